//! The virtual coupler as a two port: hybrid matrix, Llewellyn's conditions, least device damping.

use crate::least_damping::{LeastDamping, SampledHold, Shares, TustinHold, exact, hold};
use crate::transparency::finite;
use crate::{AnalysisError, ForcePath};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{FrequencyResponse, Order};
use num_complex::Complex;
use std::f64::consts::PI;
use std::fmt;

/// A virtual coupler between the device and any passive environment; velocity in, force out.
///
/// ```text
/// Z_c(w) = k_c + b_c·(T/(1 − w))^μ        exact
/// Z_c(w) = k_c + b_c·T^μ/P(w)             with an operator P of order μ
/// ```
/// - *Units*: `k_c` N·s/m; `b_c` N·s^(1−μ)/m. At μ = 1 `k_c` is the damper and `b_c` the spring.
/// - *Orders*: 0 ≤ μ ≤ 2. For the exact operator with μ > 1 and `b_c` > 0 no device damping makes the
///   port passive: [`LeastDamping::NoneIsEnough`].
/// - *Accuracy* of the least damping: 1e-12 in closed form. With an operator, where Re P near θ = 0
///   cancels to rounding (μ = 1 in a polynomial), the limit is extrapolated: 1e-9.
/// - *Cost*: 4·memory + 400 responses for the least damping, on the heap.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 5.2, after R. J. Adams,
/// B. Hannaford, *Stable haptic interaction with virtual environments*, IEEE Trans. Robotics and
/// Automation 15(3), 1999.
///
/// ```
/// use fracdiff::Order;
/// use haptic_analysis::{Coupler, LeastDamping};
///
/// // k_c = 10 N·s/m, b_c = 2 N·s^0.5/m at 1 ms.
/// let coupler = Coupler::exact(Order::new(0.5)?, 1e-3, 10.0, 2.0)?;
/// let LeastDamping::Enough { damping_n_s_per_m, .. } = coupler.least_damping()? else {
///     panic!("some damping is enough below order 1");
/// };
/// assert!(damping_n_s_per_m > coupler.corollary_damping()); // Corollary 2 promises too much
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Coupler<'a> {
    stiffness: f64,
    /// `b_c·T^μ`, N·s/m.
    dissipation: f64,
    order: Order,
    sample_time_s: f64,
    inverse: Inverse<'a>,
}

/// The source of (T/(1 − w))^μ.
#[derive(Clone, Copy)]
enum Inverse<'a> {
    Exact,
    Operator {
        operator: &'a dyn FrequencyResponse,
        memory: usize,
    },
}

/// Hybrid matrix from (velocity of the hand, force of the environment) to (force at the hand, velocity
/// of the environment, reversed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HybridMatrix {
    /// `Z_d`, N·s/m.
    pub p11: Complex<f64>,
    /// The hold, 1.
    pub p12: Complex<f64>,
    /// −1.
    pub p21: Complex<f64>,
    /// `1/Z_c`, m/(N·s).
    pub p22: Complex<f64>,
}

/// The three numbers of Llewellyn's absolute stability at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Llewellyn {
    /// Re p₁₁, N·s/m; at least 0.
    pub re_p11: f64,
    /// Re p₂₂, m/(N·s); at least 0.
    pub re_p22: f64,
    /// 2 Re p₁₁ Re p₂₂ − |p₁₂p₂₁| − Re(p₁₂p₂₁), 1; at least 0.
    pub margin: f64,
}

impl Llewellyn {
    /// All three conditions.
    #[must_use]
    pub fn fulfilled(&self) -> bool {
        self.re_p11 >= 0.0 && self.re_p22 >= 0.0 && self.margin >= 0.0
    }
}

impl HybridMatrix {
    /// Llewellyn's conditions for this matrix. The margin comes from a difference of products: near
    /// θ = 0 prefer [`Coupler::llewellyn`], which has it in closed form.
    #[must_use]
    pub fn llewellyn(&self) -> Llewellyn {
        let product = self.p12 * self.p21;
        Llewellyn {
            re_p11: self.p11.re,
            re_p22: self.p22.re,
            margin: 2.0 * self.p11.re * self.p22.re - (product.norm() + product.re),
        }
    }
}

impl<'a> Coupler<'a> {
    /// The exact operator. `stiffness` is `k_c`, `dissipation` is `b_c`.
    ///
    /// # Errors
    /// `k_c` or `b_c` below 0, or both 0; μ < 0; T not above 0; `b_c·T^μ` too large.
    pub fn exact(
        order: Order,
        sample_time_s: f64,
        stiffness: f64,
        dissipation: f64,
    ) -> Result<Self, AnalysisError> {
        let mu = order.get();
        range(
            "order",
            mu,
            mu >= 0.0,
            "in [0, 2], the orders of the coupler",
            "",
        )?;
        let t = positive("sample time", sample_time_s, "s")?;
        let stiffness = not_negative("coupler stiffness", stiffness, "N·s/m")?;
        let dissipation = not_negative("coupler dissipation", dissipation, "N·s^(1−μ)/m")?;
        let per_sample = dissipation * libm::pow(t, mu);
        positive("impedance of the coupler", stiffness + per_sample, "N·s/m")?;
        Ok(Self {
            stiffness,
            dissipation: per_sample,
            order,
            sample_time_s: t,
            inverse: Inverse::Exact,
        })
    }

    /// The same coupler run by an operator of its order. `memory` in samples, 1 for unlimited memory:
    /// as in [`OnePort::with_memory`](crate::OnePort::with_memory).
    #[must_use]
    pub fn with_operator<'b>(
        self,
        operator: &'b dyn FrequencyResponse,
        memory: usize,
    ) -> Coupler<'b> {
        Coupler {
            stiffness: self.stiffness,
            dissipation: self.dissipation,
            order: self.order,
            sample_time_s: self.sample_time_s,
            inverse: Inverse::Operator { operator, memory },
        }
    }

    /// `1/Z_c(e^(−jθ)) = P/(k_c·P + b_c·T^μ)`, m/(N·s), for 0 < θ ≤ π: finite where P has a zero too.
    ///
    /// # Errors
    /// θ outside its range, or a zero of `Z_c`.
    pub fn admittance(&self, theta: f64) -> Result<Complex<f64>, AnalysisError> {
        check_theta(theta, theta <= PI, "above 0 and at most π")?;
        let p = self.response(theta);
        let y = p / (p * self.stiffness + self.dissipation);
        finite("admittance of the coupler", y.re + y.im, "m/(N·s)")?;
        Ok(y)
    }

    /// Hybrid matrix of device, hold and coupler, for 0 < θ < π (at π the Tustin device has its pole).
    ///
    /// ```text
    /// p₁₁ = m·(2/T)(1 − w)/(1 + w) + b,   p₁₂ = (1 + w)/2,   p₂₁ = −1,   p₂₂ = 1/Z_c
    /// ```
    /// # Errors
    /// Mass (kg) or damping (N·s/m) below 0, or θ outside its range.
    pub fn hybrid_matrix(
        &self,
        mass: f64,
        damping: f64,
        theta: f64,
    ) -> Result<HybridMatrix, AnalysisError> {
        let mass = not_negative("mass", mass, "kg")?;
        let damping = not_negative("damping", damping, "N·s/m")?;
        check_theta(theta, theta < PI, "above 0 and below π")?;
        let (sin, cos) = (libm::sin(0.5 * theta), libm::cos(0.5 * theta));
        // (1 − w)/(1 + w) = j tan(θ/2)
        let inertia = mass * 2.0 / self.sample_time_s * sin / cos;
        finite("impedance of the device", inertia, "N·s/m")?;
        Ok(HybridMatrix {
            p11: Complex::new(damping, inertia),
            // (1 + w)/2 = cos(θ/2) e^(−jθ/2)
            p12: Complex::new(cos * cos, -cos * sin),
            p21: Complex::new(-1.0, 0.0),
            p22: self.admittance(theta)?,
        })
    }

    /// Llewellyn's conditions at one frequency, 0 < θ ≤ π.
    ///
    /// ```text
    /// b ≥ 0,   Re(1/Z_c) ≥ 0,   2b·Re(1/Z_c) ≥ cos(θ/2)(1 − cos(θ/2))
    /// ```
    /// # Errors
    /// Damping (N·s/m) below 0, or θ outside its range.
    pub fn llewellyn(&self, damping: f64, theta: f64) -> Result<Llewellyn, AnalysisError> {
        let re_p11 = not_negative("damping", damping, "N·s/m")?;
        let re_p22 = self.admittance(theta)?.re;
        Ok(Llewellyn {
            re_p11,
            re_p22,
            margin: 2.0 * re_p11 * re_p22 - hold(theta),
        })
    }

    /// Corollary 2: `8b ≥ k_c + b_c·(T/2)^μ`, b in N·s/m. Not sufficient: it takes the worst of the two
    /// sides at different frequencies, and the criterion itself asks for up to twice as much (`k_c` = 0,
    /// μ = 1); equal only where `b_c` = 0 or μ = 0. An operator that is not exact may ask for more
    /// still. For μ > 1 it promises what no damping can keep.
    ///
    /// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 5.20.
    #[must_use]
    pub fn corollary_damping(&self) -> f64 {
        0.125 * (self.stiffness + self.dissipation * libm::pow(2.0, -self.order.get()))
    }

    /// The least b for which Llewellyn's conditions hold at every 0 ≤ θ ≤ π.
    ///
    /// ```text
    /// b = sup over θ of cos(θ/2)(1 − cos(θ/2))/(2 Re(1/Z_c))
    /// ```
    /// # Errors
    /// An operator without a finite response.
    ///
    /// ```
    /// use fracdiff::Order;
    /// use haptic_analysis::{Coupler, LeastDamping};
    ///
    /// // A pure spring of 1 kN/m at 1 kHz: b = b_c·T/8, twice what Corollary 2 says.
    /// let coupler = Coupler::exact(Order::new(1.0)?, 1e-3, 0.0, 1000.0)?;
    /// let LeastDamping::Enough { damping_n_s_per_m, .. } = coupler.least_damping()? else {
    ///     unreachable!("μ = 1 has a bound");
    /// };
    /// assert!((damping_n_s_per_m - 0.125).abs() < 1e-12);
    /// # Ok::<(), haptic_analysis::AnalysisError>(())
    /// ```
    pub fn least_damping(&self) -> Result<LeastDamping, AnalysisError> {
        let (scale, shares) = self.shares();
        let outcome = match self.inverse {
            Inverse::Exact => shares.least_of_exact(self.order.get()),
            Inverse::Operator { operator, memory } => {
                shares.least_of(operator, memory, &TustinHold)
            }
        };
        outcome?.times(scale)
    }

    /// The least b for which the *really sampled* device, its force held between samples, late and lagging by `path`, is passive
    /// with the coupler and every passive object behind it: stable in every passive hand, then.
    ///
    /// ```text
    /// b = sup over θ of h(θ)/(2 Re(1/Z_c)),   h = √(|M|² + V) − Re(wM),   h = 1 − cos((d + 1)θ) for d whole samples of delay
    /// ```
    /// M and V are mean and variance of the force within a sample. Llewellyn's h, cos(θ/2)(1 − cos(θ/2)), is less than a quarter
    /// of it: his device is one under Tustin's rule, whose force acts half a sample earlier. So
    /// [`least_damping`](Self::least_damping) is not enough for a sampled device: a spring (μ = 1) needs four times as much, `b_c·T/2`, and a damper
    /// eight times, `k_c`.
    ///
    /// *Derivation*: passivity of a sampled port asks b ≥ (Re(cZ) + √(Re²(cZ) + V|Z|²))/2, c = −wM, at each θ (Theorem 1 with
    /// the variance within a sample), which is |bY − c/2|² ≥ (|c|² + V)/4 for Y = 1/Z. With an object Y = 1/`Z_c` + 1/`Z_o`, and a
    /// passive `Z_o` can make it any Y with Re Y ≥ Re(1/`Z_c`): the circle has to lie outside of that half-plane.
    ///
    /// *Delays* up to some hundred samples; beyond, the limit at rest of a coupler of order 1 is not resolved.
    ///
    /// # Errors
    /// An operator without a finite response.
    ///
    /// ```
    /// use fracdiff::Order;
    /// use haptic_analysis::{Coupler, ForcePath, LeastDamping};
    ///
    /// let damper = Coupler::exact(Order::new(1.0)?, 1e-3, 2.0, 0.0)?; // 2 N·s/m
    /// let LeastDamping::Enough { damping_n_s_per_m, .. } = damper.sampled_damping(ForcePath::NONE)? else {
    ///     unreachable!("a damper has a bound");
    /// };
    /// assert!((damping_n_s_per_m - 2.0).abs() < 1e-12); // Llewellyn says 0.25
    /// # Ok::<(), haptic_analysis::AnalysisError>(())
    /// ```
    pub fn sampled_damping(&self, path: ForcePath) -> Result<LeastDamping, AnalysisError> {
        let (scale, shares) = self.shares();
        let hold = SampledHold(path);
        let outcome = match self.inverse {
            Inverse::Exact => shares.least_of(&ExactInverse(self.order.get()), 1, &hold),
            Inverse::Operator { operator, memory } => shares.least_of(operator, memory, &hold),
        };
        outcome?.times(scale)
    }

    /// μ.
    #[must_use]
    pub const fn order(&self) -> Order {
        self.order
    }

    /// T, s.
    #[must_use]
    pub const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// `k_c` and `b_c·T^μ`, N·s/m.
    pub(crate) const fn gains(&self) -> (f64, f64) {
        (self.stiffness, self.dissipation)
    }

    /// Both gains as shares of their sum, so that no product of the two can overflow, and that sum.
    fn shares(&self) -> (f64, Shares) {
        let scale = self.stiffness + self.dissipation;
        let shares = Shares {
            stiffness: self.stiffness / scale,
            dissipation: self.dissipation / scale,
        };
        (scale, shares)
    }

    /// Is the port passive with a device of this damping, N·s/m, whatever passive hand and
    /// environment it is between?
    ///
    /// # Errors
    /// Damping below 0, or an operator without a finite response.
    pub fn passive(&self, damping: f64) -> Result<bool, AnalysisError> {
        let damping = not_negative("damping", damping, "N·s/m")?;
        Ok(match self.least_damping()? {
            LeastDamping::Enough {
                damping_n_s_per_m, ..
            } => damping >= damping_n_s_per_m,
            LeastDamping::NoneIsEnough { .. } => false,
        })
    }

    /// P(e^(−jθ)).
    fn response(&self, theta: f64) -> Complex<f64> {
        match self.inverse {
            Inverse::Exact => exact(self.order.get(), theta),
            Inverse::Operator { operator, .. } => operator.response(theta),
        }
    }
}

/// (1 − w)^μ with its digits near rest.
struct ExactInverse(f64);

impl FrequencyResponse for ExactInverse {
    fn response(&self, theta: f64) -> Complex<f64> {
        exact(self.0, theta)
    }
}

impl fmt::Debug for Coupler<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Coupler")
            .field("stiffness", &self.stiffness)
            .field("dissipation_t_mu", &self.dissipation)
            .field("order", &self.order)
            .field("sample_time_s", &self.sample_time_s)
            .field("exact", &matches!(self.inverse, Inverse::Exact))
            .finish()
    }
}

fn check_theta(value: f64, below: bool, allowed: &'static str) -> Result<(), AnalysisError> {
    range(
        "digital frequency",
        value,
        value > 0.0 && below,
        allowed,
        "rad/sample",
    )?;
    Ok(())
}
