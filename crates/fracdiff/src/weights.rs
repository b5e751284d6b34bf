//! Impulse responses in closed form: Grünwald weights and the Caputo L1 (piecewise-linear) kernel.

use crate::Order;

/// The Grünwald weights c₀, c₁, c₂, … of (1 − w)^μ, for ever.
/// ```text
/// c₀ = 1,   c_j = c_{j−1}·(j − 1 − μ)/j = Γ(j − μ) / (Γ(−μ)·Γ(j + 1))
/// ```
/// Relative rounding error about √j·1e-16, also next to whole orders. For whole orders the weights are exact: for 0, 1 and 2 those after
/// the last difference are zero. Source: I. Podlubny, *Fractional Differential Equations*, Academic Press, 1999, eq. 7.23.
pub fn grunwald_weights(order: Order) -> impl Iterator<Item = f64> + Clone {
    grunwald_recurrence(order.get())
}

pub(crate) fn grunwald_recurrence(order: f64) -> impl Iterator<Item = f64> + Clone {
    /// Up to here j − 1 − μ can cancel, and is then exact.
    const CANCELS: f64 = 3.0;
    let mut weight = 1.0;
    let mut lag = 0.0;
    core::iter::repeat_with(move || {
        let this = weight;
        lag += 1.0;
        if lag <= CANCELS {
            weight *= (lag - 1.0 - order) / lag;
        } else {
            // c_j = c_{j−1} − c_{j−1}(μ + 1)/j. Written as a product the rounding error of j − 1 − μ
            // would be the same for thousands of lags in a row and add up to j·1e-16.
            weight -= weight * (order + 1.0) / lag;
        }
        this
    })
}

/// The Grünwald weight `c_j` of (1 − w)^μ for a single lag j, without computing the earlier ones.
///
/// Relative error below 1e-13 for any j up to 1e12. Costs a few dozen operations.
#[must_use]
pub fn grunwald_weight(order: Order, lag: u64) -> f64 {
    grunwald_closed_form(order.get(), lag as f64)
}

/// Below this lag weights are multiplied out; from it on Stirling's series is exact to 1e-16.
const SMALL_LAG: f64 = 32.0;

/// `c_j` of (1 − w)^μ for −3 ≤ μ ≤ 2 and j ≥ 0.
pub(crate) fn grunwald_closed_form(order: f64, lag: f64) -> f64 {
    if lag < SMALL_LAG && lag > libm::floor(lag) {
        // c_j = c_(j+1)·(j + 1)/(j − μ)
        return grunwald_closed_form(order, lag + 1.0) * (lag + 1.0) / (lag - order);
    }
    if lag < SMALL_LAG {
        let mut weight = 1.0;
        let mut j = 1.0;
        while j <= lag {
            weight *= (j - 1.0 - order) / j;
            j += 1.0;
        }
        return weight;
    }
    // Γ(−μ) has a pole: all weights after the last difference are zero.
    if [0.0, 1.0, 2.0].contains(&order) {
        return 0.0;
    }
    // c_j = Γ(j − μ)/Γ(j + 1) / Γ(−μ)
    libm::exp(ln_gamma_ratio(lag + 1.0, -1.0 - order)) / libm::tgamma(-order)
}

/// ln(Γ(b + d)/Γ(b)) for b ≥ 33 and |d| ≤ 4, to about 1e-14 absolute.
///
/// The difference of two Stirling series (NIST *Digital Library of Mathematical Functions*, eq. 5.11.1), arranged so that the large terms
/// never meet: `lgamma(b + d) - lgamma(b)` would lose everything at b = 1e8, and so would rounding b + d before the difference is taken.
fn ln_gamma_ratio(b: f64, d: f64) -> f64 {
    // (b + d − ½)·ln(b + d) − (b − ½)·ln b − d = (b + d − ½)·ln(1 + d/b) + d·(ln b − 1)
    let main = (b + d - 0.5) * libm::log1p(d / b) + d * (libm::log(b) - 1.0);
    main + stirling_correction(b + d) - stirling_correction(b)
}

fn stirling_correction(x: f64) -> f64 {
    let r = 1.0 / (x * x);
    // 1/12x − 1/360x³ + 1/1260x⁵ − 1/1680x⁷ + 1/1188x⁹: the next term is below 1e-17 at x = 28.
    let series = r * (1.0 / 1260.0 + r * (-1.0 / 1680.0 + r / 1188.0));
    (1.0 / 12.0 + r * (-1.0 / 360.0 + series)) / x
}

/// Weight j of D^μ applied exactly to the piecewise-linear interpolation of the samples, T = 1, for −2 ≤ μ < 1: the Caputo L1 kernel and,
/// for negative orders, the product trapezoidal rule. `None` for μ ≥ 1, where a straight line has no such derivative at its corners.
/// ```text
/// c₀ = 1/Γ(2 − μ),   c_j = [(j + 1)^p − 2 j^p + (j − 1)^p] / Γ(2 − μ),   p = 1 − μ
/// ```
/// Source: K. Diethelm, *The Analysis of Fractional Differential Equations*, Springer, 2010, appendix C; K. B. Oldham and J. Spanier, *The
/// Fractional Calculus*, 1974, eq. 8.2.4. Relative error below 1e-12 for lags up to 32, below 1e-13 beyond.
#[must_use]
pub fn piecewise_linear_weight(order: Order, lag: u64) -> Option<f64> {
    (order.get() < 1.0).then(|| piecewise_linear_closed_form(order.get(), lag as f64))
}

pub(crate) fn piecewise_linear_closed_form(order: f64, lag: f64) -> f64 {
    central_difference(2, 1.0 - order, lag) / libm::tgamma(2.0 - order)
}

/// Weight j of the increments of x in the L1 kernel of order 1 − ν, 0 ≤ ν < 1, T = 1: the kernel above
/// summed up. All positive, to about 1e-15 relative.
/// ```text
/// a_j = [(j + 1)^ν − j^ν]/Γ(1 + ν)
/// ```
pub(crate) fn piecewise_linear_slope(integral: f64, lag: f64) -> f64 {
    let scale = libm::tgamma(1.0 + integral);
    if lag == 0.0 {
        return 1.0 / scale;
    }
    // j^ν·[(1 + 1/j)^ν − 1]: no cancellation, however small ν.
    let growth = libm::expm1(integral * libm::log1p(1.0 / lag));
    libm::pow(lag, integral) * growth / scale
}

/// Weight j − weight (j − 1) of the kernel above: what accumulation turns back into it. For
/// −2 ≤ μ < −1, where the kernel itself grows with j.
pub(crate) fn piecewise_linear_increment(order: f64, lag: f64) -> f64 {
    if lag == 0.0 {
        return 1.0 / libm::tgamma(2.0 - order);
    }
    central_difference(3, 1.0 - order, lag - 0.5) / libm::tgamma(2.0 - order)
}

/// The central difference of degree 2 or 3 of max(x, 0)^p at x, step 1; x − degree/2 is whole.
fn central_difference(degree: u32, p: f64, x: f64) -> f64 {
    let power = |x: f64| if x > 0.0 { libm::pow(x, p) } else { 0.0 };
    if x < SMALL_LAG {
        return small_difference(degree, p, x);
    }
    // Taylor: δ²x^p = 2 Σ_{k=2,4,…} C(p,k) x^(p−k); δ³x^p = 2 Σ_{k=3,5,…} C(p,k) x^(p−k) [(3/2)^k − 3 (1/2)^k].
    let mut sum = 0.0;
    let mut binomial = 1.0; // C(p, k)
    let mut scale = 1.0; // x^(−k)
    for k in 1..=16_u32 {
        binomial *= (p - f64::from(k) + 1.0) / f64::from(k);
        scale /= x;
        if k >= degree && k % 2 == degree % 2 {
            let spread = if degree == 2 {
                1.0
            } else {
                libm::pow(1.5, f64::from(k)) - 3.0 * libm::pow(0.5, f64::from(k))
            };
            sum += binomial * scale * spread;
        }
    }
    2.0 * sum * power(x)
}

/// [`central_difference`] for a small x. From degree/2 on the difference of x^n, n < degree a whole number near p,
/// is zero; so only what x^(p−n) has beyond a constant is summed, and a p next to n loses no digits.
fn small_difference(degree: u32, p: f64, x: f64) -> f64 {
    let half = 0.5 * f64::from(degree);
    let near = if x < half {
        None
    } else {
        Some(libm::fmin(libm::round(p), f64::from(degree) - 1.0))
    };
    let term = |x_k: f64| match near {
        Some(n) if x_k > 0.0 => libm::pow(x_k, n) * libm::expm1((p - n) * libm::log(x_k / x)),
        Some(0.0) => -1.0,
        None if x_k > 0.0 => libm::pow(x_k, p),
        _ => 0.0,
    };
    let outer = [term(x + half), term(libm::fmax(x - half, 0.0))];
    let inner = [term(x + half - 1.0), term(libm::fmax(x - half + 1.0, 0.0))];
    let difference = if degree == 2 {
        (outer[0] - inner[0]) + (outer[1] - inner[1])
    } else {
        (outer[0] - outer[1]) - 3.0 * (inner[0] - inner[1])
    };
    match near {
        Some(n) => difference * libm::pow(x, p - n),
        None => difference,
    }
}
