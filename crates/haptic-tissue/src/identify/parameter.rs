//! Parameters of a fit, with what the record says about their errors.

use super::candidate::Candidate;
use super::elements::{Elements, Variable, variables};
use super::target::Target;
use nalgebra::DMatrix;

/// A parameter with its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Its name, as in a tissue file.
    pub name: &'static str,
    /// Its unit; empty for an order.
    pub unit: &'static str,
    /// The value of the best fit.
    pub value: f64,
    /// Standard error by the curvature of the sum of squares; none at an end of the range, or if the record does not settle the parameter.
    pub standard_error: Option<f64>,
    /// Low end of the 95 % interval.
    pub low_95: Option<f64>,
    /// High end.
    pub high_95: Option<f64>,
}

/// The parameters of the elements in SI units: ln Vᵢ = aᵢ + αᵢ ln t₀ for a modulus, αᵢ for an order.
pub(super) fn parameters(candidate: Candidate, elements: &Elements, unit_s: f64) -> Vec<f64> {
    let ln_unit = libm::log(unit_s);
    (variables(candidate).iter())
        .map(|variable| match *variable {
            Variable::Modulus(i) => libm::exp(elements.ln_modulus[i] + elements.order[i] * ln_unit),
            Variable::Order(i) => elements.order[i],
        })
        .collect()
}

/// Covariance of ln Vᵢ and αᵢ, NaN in rows of what is fixed; none if the record does not settle them.
///
/// C = s²(JᵀJ)⁻¹, s² = S/(n − p), for the free variables; then from aᵢ to ln Vᵢ.
pub(super) fn covariance(
    candidate: Candidate,
    target: &Target,
    elements: &Elements,
    free: &[usize],
    sum: f64,
) -> Option<DMatrix<f64>> {
    let (n, p) = (target.len(), free.len());
    if n <= p || p == 0 {
        return None;
    }
    let mut normal = DMatrix::<f64>::zeros(p, p);
    target.residuals(candidate, elements, |_, root, slope| {
        for (i, &v) in free.iter().enumerate() {
            for (j, &w) in free.iter().enumerate() {
                normal[(i, j)] += root * root * slope.by[v] * slope.by[w];
            }
        }
    });
    // With a unit diagonal the inverse says whether it is one.
    let size: Vec<f64> = (0..p).map(|i| libm::sqrt(normal[(i, i)])).collect();
    if size.iter().any(|&size| !(size > 0.0 && size.is_finite())) {
        return None;
    }
    let scaled = DMatrix::from_fn(p, p, |i, j| normal[(i, j)] / (size[i] * size[j]));
    let inverse = scaled.cholesky()?.inverse();
    if inverse.diagonal().iter().any(|&x| !(x > 0.0 && x < 1e12)) {
        return None;
    }
    let variance = sum / (n - p) as f64;
    let inner = DMatrix::from_fn(p, p, |i, j| {
        variance * inverse[(i, j)] / (size[i] * size[j])
    });
    // ln Vᵢ depends on aᵢ and αᵢ, an order on itself.
    let kinds = variables(candidate);
    let ln_unit = libm::log(target.unit_s);
    let outer = DMatrix::from_fn(p, p, |i, j| match (kinds[free[i]], kinds[free[j]]) {
        _ if i == j => 1.0,
        (Variable::Modulus(a), Variable::Order(b)) if a == b => ln_unit,
        _ => 0.0,
    });
    let moved = &outer * inner * outer.transpose();
    let mut all = DMatrix::from_element(kinds.len(), kinds.len(), f64::NAN);
    for (i, &v) in free.iter().enumerate() {
        for (j, &w) in free.iter().enumerate() {
            all[(v, w)] = moved[(i, j)];
        }
    }
    Some(all)
}

/// Values with errors: ±t of Student around ln V and around α, which stays in [0, 1].
pub(super) fn estimates(
    candidate: Candidate,
    values: &[f64],
    covariance: Option<&DMatrix<f64>>,
    freedom: usize,
) -> Vec<Estimate> {
    let t = student(freedom);
    let kinds = variables(candidate);
    (candidate.kind().parameters().iter().enumerate())
        .map(|(v, parameter)| {
            let value = values[v];
            let error = covariance
                .map(|c| libm::sqrt(c[(v, v)]))
                .filter(|e| e.is_finite());
            let is_order = matches!(kinds[v], Variable::Order(_));
            let end = |sign: f64| {
                let error = error?;
                Some(if is_order {
                    (value + sign * t * error).clamp(0.0, 1.0)
                } else {
                    value * libm::exp(sign * t * error)
                })
                .filter(|end| end.is_finite())
            };
            Estimate {
                name: parameter.name,
                unit: parameter.unit,
                value,
                standard_error: error
                    .map(|e| if is_order { e } else { value * e })
                    .filter(|e| e.is_finite()),
                low_95: end(-1.0),
                high_95: end(1.0),
            }
        })
        .collect()
}

/// 97.5 % point of Student's t: a table, then the expansion of Cornish and Fisher (M. Abramowitz, I. Stegun, *Handbook of Mathematical
/// Functions*, 26.7.5), within 2e-4.
pub(super) fn student(freedom: usize) -> f64 {
    const FEW: [f64; 8] = [
        12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060,
    ];
    const Z: f64 = 1.959_963_984_540_054;
    if let Some(&t) = FEW.get(freedom.max(1) - 1) {
        return t;
    }
    let n = freedom as f64;
    let (z3, z5, z7) = (Z * Z * Z, libm::pow(Z, 5.0), libm::pow(Z, 7.0));
    Z + (z3 + Z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * Z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * Z) / (384.0 * n * n * n)
}

/// Correlations of ln Vᵢ and αᵢ; NaN where a parameter is fixed.
pub(super) fn correlation(covariance: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let p = covariance.nrows();
    let size: Vec<f64> = (0..p).map(|i| libm::sqrt(covariance[(i, i)])).collect();
    (0..p)
        .map(|i| {
            (0..p)
                .map(|j| covariance[(i, j)] / (size[i] * size[j]))
                .collect()
        })
        .collect()
}
