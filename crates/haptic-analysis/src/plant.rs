//! The device with its hand behind a zero-order hold, as the loop sees it once a sample.

use crate::linear::{Continuous, Lists, Matrices, numerator};
use crate::{AnalysisError, ForcePath, linear};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::product;
use nalgebra::{DMatrix, DVector, RowDVector};

/// A plant behind a zero-order hold, sampled exactly: G(w) = w^(d+1)·N(w)/A(w), w = z^(−1).
///
/// It is a mass with damper and hand ([`new`](Self::new)), the same behind a delay that is not a
/// whole number of samples and a current lag ([`behind`](Self::behind)), or any linear plant
/// ([`linear`](Self::linear)). A fraction h of delay splits each sample where the force changes:
/// ```text
/// x[n+1] = Φx[n] + Γ₀u[n−d] + Γ₁u[n−d−1],   Φ = e^(AT),  Γ₀ = ∫₀^((1−h)T) e^(As)B ds,  Γ₁ = e^(A(1−h)T)∫₀^(hT) e^(As)B ds
/// A(w) = det(1 − wΦ),   N(w) = C·adj(1 − wΦ)(Γ₀ + Γ₁w),   d whole samples beside
/// ```
/// (the modified z-transform). Without fraction and lag, nondimensional (4.1):
/// ```text
/// x'' + δ·x' + γ·x = u,   time in samples:   G(w) = (n₁w + n₀w²) / A(w),   w = z^(−1)
/// A(w) = 1 − (c₂ + c₃)w + e^(−δ)w²,   c₂,₃ = e^(−s₂,₃),   s₂,₃ = (δ ± √(δ² − 4γ))/2
/// n₁ = exp[−s₂, −s₃, 0],   n₀ = exp[−s₂, −s₃, −δ]   (divided differences)
/// ```
/// The closed forms of the dissertation divide by c₁γ and lose everything near γ = 0 and δ² = 4γ. Here nothing cancels:
/// ```text
/// n₁ + n₀ = φ₁(s₂)·φ₁(s₃),   φ₁(s) = (1 − e^(−s))/s        A(1) = γ·(n₁ + n₀)
/// A = A(1) + a₁v + e^(−δ)v²,   a₁ = (1 − e^(−δ)) − A(1)     n₁ + n₀w = (n₁ + n₀) − n₀v,   v = 1 − w
/// ```
/// and n₁ comes from its power series over a step so short that the series is exact, and then from doublings of that step.
///
/// - *Ranges*: δ = bT/m from 0 to 1e6, γ = kT²/m from 0 to 1e12; all dimensionless.
/// - *Accuracy*: 1e-12 relative for δ and γ from 1e-9 to 10, over-, critically and under-damped, and at every removable singularity,
///   against 50 digits (`tests/golden/plant.csv`). Beyond, a phase of ω radians in a sample is known to ω rounding errors.
/// - *Cost*: a few exponentials and about 30 multiply-adds, once.
///
/// With fraction or lag the denominator is the same times 1 − e^(−T/τ)w, and the numerator comes from the
/// matrix exponential less 1: within 1e-12 of its largest coefficient for T/τ from 1e-6 to 1e9 and any h.
///
/// Sources: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 4.1 (which prints c₂ twice); E. I. Jury,
/// *Theory and Application of the z-Transform Method*, Wiley, 1964 (the modified transform).
/// ```
/// use haptic_analysis::SampledPlant;
///
/// let free = SampledPlant::new(0.0, 0.0)?; // a mass without damper or hand: (w + w²)/2/(1 − w)²
/// assert_eq!(free.numerator(), [0.5, 0.5]);
/// # Ok::<(), haptic_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledPlant {
    path: ForcePath,
    continuous: Continuous,
    denominator: Coefficients,
    denominator_in_v: Coefficients,
    numerator: Coefficients,
    numerator_in_v: Coefficients,
    /// The size of the numerator.
    sum: f64,
}

/// A polynomial of a plant, the coefficient of the power 0 first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coefficients {
    values: [f64; SampledPlant::STATES_MAX + 1],
    count: usize,
}

impl Coefficients {
    /// Coefficients of a list, at most `STATES_MAX + 1` of them.
    fn new(list: &[f64]) -> Self {
        let mut values = [0.0; SampledPlant::STATES_MAX + 1];
        let count = list.len().min(values.len());
        values[..count].copy_from_slice(&list[..count]);
        Self { values, count }
    }

    fn get(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

impl SampledPlant {
    /// Largest δ: a motion that dies out faster than in a millionth of a sample is sampled wrongly.
    pub const DELTA_MAX: f64 = 1e6;
    pub(crate) const GAMMA_MAX: f64 = 1e12;
    pub(crate) const STATES_MAX: usize = linear::STATES_MAX;

    /// Mass, damper and hand, from δ and γ, with an actuator that acts at once.
    ///
    /// # Errors
    /// Unless 0 ≤ δ ≤ 1e6 and 0 ≤ γ ≤ 1e12.
    pub fn new(delta: f64, gamma: f64) -> Result<Self, AnalysisError> {
        let delta = not_above("delta", delta, Self::DELTA_MAX, "from 0 to 1e6")?;
        let gamma = not_above("gamma", gamma, Self::GAMMA_MAX, "from 0 to 1e12")?;
        let Poles { sum, pole_sum } = Poles::new(delta, gamma);
        let pole_product = libm::exp(-delta);
        let n1 = step_response(delta, gamma);
        let slope = -libm::expm1(-delta) - gamma * sum;
        Ok(Self {
            path: ForcePath::NONE,
            continuous: Continuous {
                named: [delta, gamma],
                linear: None,
            },
            denominator: Coefficients::new(&[1.0, -pole_sum, pole_product]),
            denominator_in_v: Coefficients::new(&[gamma * sum, slope, pole_product]),
            numerator: Coefficients::new(&[n1, sum - n1]),
            numerator_in_v: Coefficients::new(&[sum, -(sum - n1)]),
            sum,
        })
    }

    /// Mass, damper and hand behind a delay and a current lag: the state is position, velocity, force.
    ///
    /// # Errors
    /// δ or γ outside its range.
    pub fn behind(delta: f64, gamma: f64, path: ForcePath) -> Result<Self, AnalysisError> {
        let ideal = Self::new(delta, gamma)?;
        if path.is_whole() {
            return Ok(Self { path, ..ideal });
        }
        let (mut denominator, mut in_v) = (
            ideal.denominator.get().to_vec(),
            ideal.denominator_in_v.get().to_vec(),
        );
        let mut sum = ideal.sum;
        let lags = path.lag_samples() > 0.0;
        if lags {
            // (1 − e^(−T/τ)w) = (1 − e^(−T/τ)) + e^(−T/τ)v
            let rate = 1.0 / path.lag_samples();
            let (left, gone) = (libm::exp(-rate), -libm::expm1(-rate));
            denominator = product(&denominator, &[1.0, -left]);
            in_v = product(&in_v, &[gone, left]);
            sum *= gone;
        }
        let matrices = matrices(delta, gamma, path);
        let numerator = numerator(&matrices, path.fraction(), &denominator);
        let mut numerator_in_v = in_powers_of_v(&numerator);
        // A(1) = γ·(n₁ + n₀)·(1 − e^(−T/τ)), and the force at rest is the command.
        numerator_in_v[0] = sum;
        Ok(Self {
            path,
            denominator: Coefficients::new(&denominator),
            denominator_in_v: Coefficients::new(&in_v),
            numerator: Coefficients::new(&numerator),
            numerator_in_v: Coefficients::new(&numerator_in_v),
            sum,
            ..ideal
        })
    }

    /// Any linear plant ẋ = Ax + Bu(t − (d + h)T), y = Cx, its input held between samples.
    ///
    /// - `a`, n×n in 1/s, `b` and `c`, n long: n from 1 to 8. u in N, y in m.
    /// - `mass_kg`: the mass in α = KT²/m and β = BT^(2−μ)/m. It only scales; 1 kg does.
    /// - `path`: delay, and a current lag if A has none; it takes a state of its own.
    /// - *Accuracy*: the sampled plant is compared with C(1 − wΦ)⁻¹Γ solved directly at eight angles, and
    ///   refused if they differ by more than 1e-9 of its numerator.
    ///
    /// # Errors
    /// Sizes that do not fit, numbers that are not finite, a motion faster than 1e6 per sample, an output that the input does not move, T
    /// or m not above 0; [`AnalysisError::Unresolved`] if rounding errors spoil the polynomials.
    pub fn linear(
        a: &[f64],
        b: &[f64],
        c: &[f64],
        sample_time_s: f64,
        mass_kg: f64,
        path: ForcePath,
    ) -> Result<Self, AnalysisError> {
        let t = positive("sample time", sample_time_s, "s")?;
        let mass = positive("mass", mass_kg, "kg")?;
        let matrices = linear::scaled([a, b, c], t, mass, path)?;
        let sampled = linear::Sampled::new(&matrices, path.fraction())?;
        let sum = sampled.numerator.iter().map(|x| x.abs()).sum();
        Ok(Self {
            path,
            continuous: Continuous {
                named: [0.0; 2],
                linear: Some(Lists::new(&matrices)),
            },
            denominator: Coefficients::new(&sampled.denominator),
            denominator_in_v: Coefficients::new(&sampled.denominator_in_v),
            numerator: Coefficients::new(&sampled.numerator),
            numerator_in_v: Coefficients::new(&in_powers_of_v(&sampled.numerator)),
            sum,
        })
    }

    /// The force's whole and fractional delay, and its lag.
    #[must_use]
    pub fn path(&self) -> ForcePath {
        self.path
    }

    /// A in powers of w, from w⁰ on.
    #[must_use]
    pub fn denominator(&self) -> &[f64] {
        self.denominator.get()
    }

    /// N in powers of w, from w⁰ on: G = w^(d+1)·N/A.
    #[must_use]
    pub fn numerator(&self) -> &[f64] {
        self.numerator.get()
    }

    /// The numerator at w = 1; for an ideal actuator n₁ + n₀ = φ₁(s₂)φ₁(s₃). For a plant from matrices,
    /// whose numerator may vanish there, the sum of the sizes of its coefficients.
    pub(crate) fn numerator_sum(&self) -> f64 {
        self.sum
    }

    /// A in powers of v = 1 − w, of v⁰ first.
    pub(crate) fn denominator_in_v(&self) -> &[f64] {
        self.denominator_in_v.get()
    }

    /// N in powers of v.
    pub(crate) fn numerator_in_v(&self) -> &[f64] {
        self.numerator_in_v.get()
    }

    /// Adds whole samples of delay.
    pub(crate) fn later(self, samples: usize) -> Result<Self, AnalysisError> {
        let path = self.path.later(samples)?;
        Ok(Self { path, ..self })
    }

    /// Replaces the delay and keeps the lag. Only the numerator depends on where in a sample the force changes.
    ///
    /// # Errors
    /// More than the longest delay.
    pub(crate) fn delayed_by(&self, delay_samples: f64) -> Result<Self, AnalysisError> {
        let path = ForcePath::new(delay_samples, self.path.lag_samples())?;
        if (path.fraction() - self.path.fraction()).abs() == 0.0 {
            return Ok(Self { path, ..*self });
        }
        let Some(lists) = &self.continuous.linear else {
            let [delta, gamma] = self.continuous.named;
            return Self::behind(delta, gamma, path);
        };
        let numerator = numerator(&lists.matrices(), path.fraction(), self.denominator());
        Ok(Self {
            path,
            numerator: Coefficients::new(&numerator),
            numerator_in_v: Coefficients::new(&in_powers_of_v(&numerator)),
            sum: numerator.iter().map(|x| x.abs()).sum(),
            ..*self
        })
    }

    /// About the radians by which the fastest motion of the plant turns within a sample, or more.
    pub(crate) fn turn(&self) -> f64 {
        self.continuous.turn()
    }
}

/// `Σ c_j w^j = Σ_k v^k (−1)^k Σ_j C(j, k)·c_j`.
pub(crate) fn in_powers_of_v(coefficients: &[f64]) -> Vec<f64> {
    let mut shifted = vec![0.0; coefficients.len()];
    for (j, c) in coefficients.iter().enumerate() {
        let mut signed_binomial = 1.0;
        for (k, term) in shifted.iter_mut().enumerate().take(j + 1) {
            *term += signed_binomial * c;
            signed_binomial *= -((j - k) as f64) / (k + 1) as f64;
        }
    }
    shifted
}

fn not_above(
    what: &'static str,
    value: f64,
    most: f64,
    allowed: &'static str,
) -> Result<f64, AnalysisError> {
    let value = not_negative(what, value, "")?;
    Ok(range(what, value, value <= most, allowed, "")?)
}

/// x″ + δx′ + γx = f, and a·(u − f) = f′ where there is a lag, in samples.
pub(crate) fn matrices(delta: f64, gamma: f64, path: ForcePath) -> Matrices {
    // Natural units: the fastest of a sample, the damping and a radian of oscillation sets the time.
    let rate = libm::sqrt(gamma).max(1.0);
    let stiff = gamma / rate;
    if path.lag_samples() == 0.0 {
        return (
            DMatrix::from_row_slice(2, 2, &[0.0, rate, -stiff, -delta]),
            DVector::from_column_slice(&[0.0, 1.0 / rate]),
            RowDVector::from_row_slice(&[1.0, 0.0]),
        );
    }
    let a = 1.0 / path.lag_samples();
    #[rustfmt::skip]
    let matrix = [
        0.0,    rate,   0.0,
        -stiff, -delta, 1.0 / rate,
        0.0,    0.0,    -a,
    ];
    (
        DMatrix::from_row_slice(3, 3, &matrix),
        DVector::from_column_slice(&[0.0, 0.0, a]),
        RowDVector::from_row_slice(&[1.0, 0.0, 0.0]),
    )
}

/// n₁ + n₀ and c₂ + c₃.
pub(crate) struct Poles {
    pub(crate) sum: f64,
    pub(crate) pole_sum: f64,
}

impl Poles {
    pub(crate) fn new(delta: f64, gamma: f64) -> Self {
        // δ² − 4γ as a product: a square root of it loses half the digits at critical damping, but both results are smooth and even in it.
        let root = libm::sqrt(gamma);
        let discriminant = (delta - 2.0 * root) * (delta + 2.0 * root);
        if discriminant >= 0.0 {
            // s₃ = γ/s₂: the small root without a difference.
            let s2 = 0.5 * (delta + libm::sqrt(discriminant));
            let s3 = if s2 > 0.0 { gamma / s2 } else { 0.0 };
            return Self {
                sum: phi1(s2) * phi1(s3),
                pole_sum: libm::exp(-s2) + libm::exp(-s3),
            };
        }
        // s₂,₃ = σ ± jω: φ₁(s₂)φ₁(s₃) = [σ²φ₁(σ)² + ω²e^(−σ)(sin(ω/2)/(ω/2))²]/(σ² + ω²), a mean.
        let sigma = 0.5 * delta;
        let omega = 0.5 * libm::sqrt(-discriminant);
        let share = (sigma / root) * (sigma / root);
        let sinc = if omega > 0.0 {
            libm::sin(0.5 * omega) / (0.5 * omega)
        } else {
            1.0
        };
        let decay = libm::exp(-sigma);
        Self {
            sum: share * phi1(sigma) * phi1(sigma) + (1.0 - share) * decay * sinc * sinc,
            pole_sum: 2.0 * decay * libm::cos(omega),
        }
    }
}

/// (1 − e^(−s))/s.
fn phi1(s: f64) -> f64 {
    if s > 0.0 { -libm::expm1(-s) / s } else { 1.0 }
}

/// n₁ = x(1) for a unit force from rest.
/// ```text
/// X(t) = ∫₀ᵗ h,   h'' + δh' + γh = 0,  h(0) = 0,  h'(0) = 1
/// X = t² Σ_{k≥0} (−1)^k h_k/(k + 2)!,   h_k = δt·h_{k−1} − γt²·h_{k−2},   h₀ = 1,  h₋₁ = 0
/// X(2t) = 2X − γX² + h²,    h(2t) = h·(2 − 2γX − δh)
/// ```
pub(crate) fn step_response(delta: f64, gamma: f64) -> f64 {
    // δt and √(γ)t at most a half: 18 terms are exact.
    let fastest = delta.max(libm::sqrt(gamma));
    let halvings = if fastest < 0.5 {
        0
    } else {
        libm::ilogb(fastest) + 2
    };
    let step = libm::ldexp(1.0, -halvings);
    let (mut damping, mut stiffness) = (delta * step, gamma * step * step);
    // `impulse` is h/t and `position` is X/t².
    let (mut impulse, mut position) = (0.0, 0.0);
    let (mut before, mut term, mut factorial) = (0.0, 1.0, 1.0);
    for k in 1..=18_u32 {
        // `term` is (−1)^(k−1) h_{k−1}, `factorial` k!
        factorial *= f64::from(k);
        impulse += term / factorial;
        position += term / (factorial * f64::from(k + 1));
        let next = -damping * term - stiffness * before;
        before = term;
        term = next;
    }
    for _ in 0..halvings {
        let settled = stiffness * position;
        let doubled = 2.0 * position - settled * position + impulse * impulse;
        impulse *= 1.0 - settled - 0.5 * damping * impulse;
        position = 0.25 * doubled;
        damping *= 2.0;
        stiffness *= 4.0;
    }
    position
}
