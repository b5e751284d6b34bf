//! A model fitted to a record, with its errors.

use super::elements::{Candidate, number};
use super::noise::independent;
use super::search::Best;
use super::target::Target;
use core::cmp::Ordering;
use haptic_tissue::{Model, ModelError, ModelKind};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use spring_pots::{Elements, is_order};

/// A model with no more BIC than the best and this is as good: odds of less than 3 to 1 (R. Kass, A. Raftery, *Bayes factors*, 1995).
pub(super) const AS_GOOD: f64 = 2.0;
/// A model whose BIC exceeds the best by this is refused by the record: odds of more than 150 to 1 (the same source).
pub(super) const REFUSED: f64 = 10.0;

/// Orders closer to 0 or 1 are 0 or 1.
const CLASSICAL: f64 = 1e-4;
/// Ratio of standard error to value beyond which the record does not determine a modulus.
const WILD: f64 = 10.0;

/// A model fitted to a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The kind of the model.
    pub kind: ModelKind,
    /// Its parameters in SI units, in the order of a tissue file; then b, if it was looked for.
    pub parameters: Vec<Estimate>,
    /// Correlations of the estimates (for a modulus, of its logarithm); NaN where one is at an end
    /// of its range. Empty if the record does not determine them.
    pub correlation: Vec<Vec<f64>>,
    /// Root of the mean square of the residuals, without weights: of the logarithm, or Pa for a history.
    pub rms: f64,
    /// Root of the mean square of the weighted residuals.
    pub weighted: f64,
    /// n·ln(S/n) + 2k, of the weighted sum of squares S, n residuals and k parameters, the noise among them: one at an end of its range
    /// was put there by the record too, one that is held was not.
    pub aic: f64,
    /// n·ln(S/n) + k·ln n + 2k(k + 1)/(n − k − 1); the last term is that of small samples (C. Hurvich, C.-L. Tsai, *Regression
    /// and time series model selection in small samples*, Biometrika 76, 1989).
    pub bic: f64,
    /// The model's values at those of the record, in the order of
    /// [`measured`](super::Identification::measured).
    pub predicted: Vec<f64>,
    /// Effective number of independent residuals: their number for white noise, fewer for slow noise.
    pub independent: f64,
}

impl Fit {
    /// The model with the parameters of the fit. An order within 1e-4 of 0 or 1 becomes a spring or
    /// a dashpot: that changes a modulus by 1e-4 in a factor e of time, and no calculation
    /// distinguishes the two.
    ///
    /// # Errors
    /// If the fit has come down to a simpler model, such as one with both orders equal.
    pub fn to_model(&self) -> Result<Model, ModelError> {
        let value = |parameter: &Estimate| match parameter.value {
            modulus if !parameter.is_order() => modulus,
            order if order < CLASSICAL => 0.0,
            order if order > 1.0 - CLASSICAL => 1.0,
            order => order,
        };
        let mut values: Vec<f64> = self.of_memory().iter().map(value).collect();
        if self.kind == ModelKind::Prony && values.len().is_multiple_of(2) {
            // Without a spring.
            values.insert(0, 0.0);
        }
        Model::from_parameters(self.kind, &values)
    }

    /// True if the record settles the parameters so far that they describe anything: no standard error many times its value.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let wild = |parameter: &Estimate| parameter.is_looser_than(1.0, WILD);
        !self.correlation.is_empty() && !self.of_memory().iter().any(wild)
    }

    /// Order by BIC; if equal, as for all with the same number of parameters and residuals below the accuracy of the record, by
    /// the residual.
    pub(super) fn by_bic(&self, other: &Self) -> Ordering {
        let left = || self.weighted.total_cmp(&other.weighted);
        self.bic.total_cmp(&other.bic).then_with(left)
    }

    /// b of tissue that stiffens, if it was looked for.
    #[must_use]
    pub fn stiffening(&self) -> Option<&Estimate> {
        self.parameters.get(self.of_memory().len())
    }

    /// The parameters of the model.
    fn of_memory(&self) -> &[Estimate] {
        let all = self.parameters.len();
        // A series has as many as it has branches; no stiffening is looked for beside them.
        let count = if self.kind == ModelKind::Prony {
            all
        } else {
            self.kind.parameters().len().min(all)
        };
        &self.parameters[..count]
    }
}

/// Numbers from which the intervals of a fit are calculated.
#[derive(Clone, Debug)]
pub(super) struct Certainty {
    /// (JᵀJ)⁻¹ of the variables, 0 where one is fixed; `None` if the record does not settle them.
    spread: Option<DMatrix<f64>>,
    /// Independent residuals less free variables, at least 1.
    pub(super) freedom: f64,
    /// 97.5 % point of Student's t.
    pub(super) student: f64,
    pub(super) variance: f64,
}

impl Certainty {
    /// Change of the variables along the valley for a unit change of a weighted sum of them, by the curvature; and the standard error of the sum.
    pub(super) fn along(&self, shares: &[f64]) -> Option<(Vec<f64>, f64)> {
        let shares = DVector::from_column_slice(shares);
        let moved = self.spread.as_ref()? * &shares;
        let square = moved.dot(&shares);
        let error = libm::sqrt(self.variance * square);
        (error > 0.0).then(|| ((moved / square).as_slice().to_vec(), error))
    }
}

/// A fit with its errors, from the best minimum.
pub(super) fn fit(candidate: Candidate, target: &Target, best: &Best) -> (Fit, Certainty) {
    let Best {
        elements,
        sum,
        free,
        ..
    } = best;
    let n = target.len();
    let [mut predicted, mut residuals, mut weighted] = [(); 3].map(|()| vec![0.0; n]);
    let mut normal = DMatrix::zeros(free.len(), free.len());
    target.residuals(candidate, elements, |i, root, slope| {
        predicted[i] = target.modelled(i, slope.value);
        residuals[i] = slope.value * target.scale;
        weighted[i] = slope.value * root;
        for (k, &v) in free.iter().enumerate() {
            for (l, &w) in free.iter().enumerate() {
                normal[(k, l)] += root * root * slope.by[v] * slope.by[w];
            }
        }
    });
    target.apart(candidate, elements, |i, residual| {
        predicted[i] = target.modelled(i, residual);
        residuals[i] = residual * target.scale;
    });
    let fitted = free.len() + target.nuisance;
    let independent = independent(&weighted, n / target.samples(), fitted);
    let freedom = (independent - fitted as f64).max(1.0);
    let certainty = Certainty {
        spread: spread(candidate, n, &normal, free),
        freedom,
        student: student(freedom),
        variance: sum / freedom,
    };
    let covariance = (certainty.spread.as_ref())
        .map(|spread| covariance(candidate, spread, certainty.variance, free, target.unit_s));
    let values = parameters(candidate, elements, target.unit_s);
    let [aic, bic] = criteria(target, *sum, candidate.parameters() + target.nuisance);
    let fit = Fit {
        kind: candidate.kind(),
        parameters: estimates(
            candidate,
            &values,
            free,
            covariance.as_ref(),
            certainty.student,
        ),
        correlation: covariance.as_ref().map(correlation).unwrap_or_default(),
        rms: libm::sqrt(residuals.iter().map(|r| r * r).sum::<f64>() / n as f64),
        weighted: target.scale * libm::sqrt(weighted.iter().map(|r| r * r).sum::<f64>() / n as f64),
        aic,
        bic,
        predicted,
        independent,
    };
    (fit, certainty)
}

/// AIC and BIC of residuals that leave this sum of squares, and `parameters` parameters, plus one for the noise.
pub(super) fn criteria(target: &Target<'_>, sum: f64, parameters: usize) -> [f64; 2] {
    let n = target.len();
    criteria_of(n, likelihood(n, sum, target.floor), parameters)
}

/// n·ln(S/n); an S/n below the square of this floor counts as that.
pub(super) fn likelihood(n: usize, sum: f64, floor: f64) -> f64 {
    n as f64 * libm::log((sum / n as f64).max(floor * floor))
}

/// AIC and BIC from n·ln(S/n), or from the deviance of correlated noise.
pub(super) fn criteria_of(n: usize, likelihood: f64, parameters: usize) -> [f64; 2] {
    let (count, k) = (n as f64, (parameters + 1) as f64);
    let small = 2.0 * k * (k + 1.0) / (count - k - 1.0);
    [
        likelihood + 2.0 * k,
        likelihood + k * libm::log(count) + small,
    ]
}

/// A parameter with its errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name, as in a tissue file.
    pub name: &'static str,
    /// Its unit; empty for an order.
    pub unit: &'static str,
    /// The value of the best fit.
    pub value: f64,
    /// Standard error by the curvature of the sum of squares; `None` at an end of the range, or if the record does not settle the parameter.
    pub standard_error: Option<f64>,
    /// Low end of the 95 % interval: from the profile of the sum of squares, or from the standard
    /// error if the record rejects the fit (BIC more than 10 above the least). None for a modulus
    /// that the record does not bound.
    pub low_95: Option<f64>,
    /// High end of that interval; `None` like the low one.
    pub high_95: Option<f64>,
    /// True if it was held: it is at the end of a range that was given, or has one value.
    pub held: bool,
}

impl Estimate {
    /// Estimate of a linear problem, with its standard error and Student's t.
    pub(super) const fn of_line(
        name: &'static str,
        unit: &'static str,
        value: f64,
        error: f64,
        t: f64,
    ) -> Self {
        Self {
            name,
            unit,
            value,
            standard_error: Some(error),
            low_95: Some(value - t * error),
            high_95: Some(value + t * error),
            held: false,
        }
    }

    /// False for a modulus, whose errors are shares of it.
    pub(super) const fn is_order(&self) -> bool {
        self.unit.is_empty()
    }

    /// True if its standard error is above this order, or this share of a modulus.
    pub(super) fn is_looser_than(&self, order: f64, share: f64) -> bool {
        let least = if self.is_order() {
            order
        } else {
            share * self.value
        };
        self.standard_error.is_some_and(|error| error > least)
    }
}

/// The parameters of the elements in SI units.
pub(super) fn parameters(candidate: Candidate, elements: &Elements, unit_s: f64) -> Vec<f64> {
    let (variables, ln_unit) = (elements.variables(candidate.joint()), libm::log(unit_s));
    (0..candidate.kind().parameters().len())
        .map(|parameter| {
            let parts = variables.iter().zip(candidate.shares(parameter, ln_unit));
            let sum = parts.map(|(value, share)| share * value).sum();
            number(candidate.variable(parameter), sum)
        })
        .collect()
}

/// Covariance of the variables over the variance of a residual, (JᵀJ)⁻¹, 0 where one is fixed; `None` if the record does not settle them.
fn spread(
    candidate: Candidate,
    n: usize,
    normal: &DMatrix<f64>,
    free: &[usize],
) -> Option<DMatrix<f64>> {
    let (p, count) = (free.len(), candidate.variables());
    if p == 0 {
        return Some(DMatrix::zeros(count, count));
    }
    if n <= p {
        return None;
    }
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
    let mut all = DMatrix::zeros(count, count);
    for (i, &v) in free.iter().enumerate() {
        for (j, &w) in free.iter().enumerate() {
            all[(v, w)] = inverse[(i, j)] / (size[i] * size[j]);
        }
    }
    Some(all)
}

/// Covariance of ln Vᵢ and αᵢ from that of the variables, NaN in rows of what is fixed.
fn covariance(
    candidate: Candidate,
    spread: &DMatrix<f64>,
    variance: f64,
    free: &[usize],
    unit_s: f64,
) -> DMatrix<f64> {
    let (count, ln_unit) = (candidate.kind().parameters().len(), libm::log(unit_s));
    let shares: Vec<Vec<f64>> = (0..count)
        .map(|parameter| candidate.shares(parameter, ln_unit))
        .collect();
    let outer = DMatrix::from_fn(count, spread.nrows(), |p, v| shares[p][v]);
    let moved = &outer * (spread * variance) * outer.transpose();
    let is_free = |parameter: usize| free.contains(&candidate.variable(parameter));
    DMatrix::from_fn(count, count, |p, q| {
        if is_free(p) && is_free(q) {
            moved[(p, q)]
        } else {
            f64::NAN
        }
    })
}

/// Values with errors: ±t of Student around ln V and around α, which stays in its range.
fn estimates(
    candidate: Candidate,
    values: &[f64],
    free: &[usize],
    covariance: Option<&DMatrix<f64>>,
    t: f64,
) -> Vec<Estimate> {
    (candidate.kind().parameters().iter().enumerate())
        .map(|(p, parameter)| {
            let (value, variable) = (values[p], candidate.variable(p));
            let error = covariance
                .map(|c| libm::sqrt(c[(p, p)]))
                .filter(|e| e.is_finite());
            let (is_order, (low, high)) = (is_order(variable), candidate.range(variable));
            let end = |sign: f64| {
                let error = error?;
                Some(if is_order {
                    (value + sign * t * error).clamp(low, high)
                } else {
                    value * libm::exp(sign * t * error)
                })
                .filter(|end| end.is_finite())
            };
            let mut estimate = Estimate {
                name: parameter.name,
                unit: parameter.unit,
                value,
                standard_error: error
                    .map(|e| if is_order { e } else { value * e })
                    .filter(|e| e.is_finite()),
                low_95: end(-1.0),
                high_95: end(1.0),
                held: candidate.is_held(variable) && !free.contains(&variable),
            };
            if low >= high {
                (estimate.low_95, estimate.high_95) = (Some(value), Some(value));
            }
            estimate
        })
        .collect()
}

/// 97.5 % point of Student's t: a table, then the expansion of Cornish and Fisher (M. Abramowitz, I. Stegun, *Handbook of Mathematical
/// Functions*, 26.7.5), within 2e-4.
#[must_use]
pub fn student(freedom: f64) -> f64 {
    const FEW: [f64; 8] = [
        12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060,
    ];
    const Z: f64 = 1.959_963_984_540_054;
    if let Some(&t) = FEW.get(freedom.max(1.0) as usize - 1) {
        return t;
    }
    let n = freedom;
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
