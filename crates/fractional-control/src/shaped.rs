//! CRONE of the second generation, and fractional lead–lag.

use crate::controller::{Stage, controller_from_its_core};
use crate::lead::{LeadPower, LeadPowerHistory};
use crate::{Actuator, ControlError, Memory};
use fracdiff::parameter::{positive, range};
use fracdiff::{Real, Seconds};
use num_complex::Complex;

/// k·(lead)^ν of the error: the core of both controllers.
#[derive(Clone, Debug, PartialEq)]
struct Shaped<F, const MODES: usize> {
    operator: LeadPower<F, MODES>,
    gain: F,
    inverse: F,
    stage: Stage<F>,
}

/// History of [`Crone`] and [`LeadLag`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShapedHistory<F, const MODES: usize> {
    operator: LeadPowerHistory<F, MODES>,
    bias: F,
}

impl<F: Real, const MODES: usize> Shaped<F, MODES> {
    fn new(
        gain: f64,
        (order, zero_rad_s, pole_rad_s): (f64, f64, f64),
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        range("gain", gain, gain != 0.0, "finite and not 0", "")?;
        let (operator, own) = LeadPower::new(order, zero_rad_s, pole_rad_s, &memory, sample_time)?;
        Ok(Self {
            operator,
            gain: F::from_f64(gain * own),
            inverse: F::from_f64(1.0 / (gain * own)),
            stage: actuator.stage(sample_time),
        })
    }

    fn at_rest(&self) -> ShapedHistory<F, MODES> {
        ShapedHistory {
            operator: self.operator.at_rest(),
            bias: F::ZERO,
        }
    }

    #[inline]
    fn feedback_gain(&self) -> F {
        self.gain
    }

    #[inline]
    fn wanted(&self, history: &ShapedHistory<F, MODES>, r: F, y: F) -> F {
        self.gain * self.operator.output(&history.operator, r - y) + history.bias
    }

    #[inline]
    fn advance(&self, history: &mut ShapedHistory<F, MODES>, r: F, y: F, applied: F) {
        let excess = applied - self.wanted(history, r, y);
        // The error that would have given what was applied.
        let error = (r - y) + excess * self.inverse;
        self.operator.advance(&mut history.operator, error);
        history.bias = self.stage.faded(history.bias);
    }

    fn follow(&self, history: &mut ShapedHistory<F, MODES>, r: F, y: F, applied: F) {
        history.bias += applied - self.wanted(history, r, y);
        self.operator.advance(&mut history.operator, r - y);
    }

    fn keep(
        &self,
        other: &Self,
        history: &ShapedHistory<F, MODES>,
        r: F,
        y: F,
    ) -> ShapedHistory<F, MODES> {
        let same = self.operator == other.operator;
        let operator = if same {
            history.operator.clone()
        } else {
            self.operator.settled(r - y)
        };
        let bias = F::ZERO;
        ShapedHistory { operator, bias }
    }

    fn response(&self, theta: f64) -> Complex<f64> {
        self.operator.response(theta) * self.gain.to_f64()
    }
}

/// `((1 + jω/ω_b)/(1 + jω/ω_h))^ν`: the power of a first-order lead, continuous along ω.
fn lead_power(omega: f64, zero_rad_s: f64, pole_rad_s: f64, order: f64) -> Complex<f64> {
    let (a, b) = (omega / zero_rad_s, omega / pole_rad_s);
    let size = libm::pow(libm::hypot(1.0, a) / libm::hypot(1.0, b), order);
    let (sin, cos) = libm::sincos(order * (libm::atan(a) - libm::atan(b)));
    Complex::new(size * cos, size * sin)
}

/// `C₀((1 + s/ω_b)/(1 + s/ω_h))^ν`, as numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CroneParameters {
    /// C₀, \[u\]/\[y\], not 0.
    pub gain: f64,
    /// ν, −2 to 2.
    pub order: f64,
    /// `ω_b`, rad/s.
    pub low_rad_s: f64,
    /// `ω_h`, rad/s, above `ω_b`.
    pub high_rad_s: f64,
}

impl CroneParameters {
    /// C(jω), ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        lead_power(omega, self.low_rad_s, self.high_rad_s, self.order) * self.gain
    }
}

/// CRONE of the second generation: a phase νπ/2 that is flat in the band from `ω_b` to `ω_h`, on the error, limited.
///
/// - *Units*: ω in rad/s, at most 2/T. *Start-up*: zero for ever before.
/// - *Accuracy*: the Tustin rule, an error of O(T²), no warping at rest; each weight to the tolerance of [`Memory`].
/// - *Cost*: `output` a few multiply-adds, `advance` as two full memories.
///
/// ```
/// use fracdiff::{FrequencyResponse, Seconds};
/// use fractional_control::{Actuator, Crone, CroneParameters, Memory, Rule};
///
/// let shape = CroneParameters { gain: 2.0, order: 0.6, low_rad_s: 1.0, high_rad_s: 100.0 };
/// let memory = Memory::new(Rule::Grunwald, 1e-6, 100.0)?;
/// let crone = Crone::<f64>::new(shape, Actuator::UNLIMITED, memory, Seconds(1e-3))?;
/// let phase = crone.response(10.0 * 1e-3).arg().to_degrees();
/// assert!((phase - shape.response(10.0).arg().to_degrees()).abs() < 0.01);
/// assert!((phase - 0.6 * 78.6).abs() < 0.1);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// Source: A. Oustaloup, *La commande CRONE*, Hermès, 1991.
#[derive(Clone, Debug, PartialEq)]
pub struct Crone<F, const MODES: usize = 48> {
    core: Shaped<F, MODES>,
}

impl<F: Real, const MODES: usize> Crone<F, MODES> {
    /// Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// A gain of 0, an order outside −2 to 2, corners that are not `0 < ω_b < ω_h ≤ 2/T`.
    pub fn new(
        parameters: CroneParameters,
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let CroneParameters {
            gain,
            order,
            low_rad_s: low,
            high_rad_s: high,
        } = parameters;
        let allowed = "below the upper corner";
        range("lower corner", low, low < high, allowed, "rad/s")?;
        Ok(Self {
            core: Shaped::new(gain, (order, low, high), actuator, memory, sample_time)?,
        })
    }
}

controller_from_its_core!(Crone, ShapedHistory);

/// k((s + 1/λ)/(s + 1/(xλ)))^α, as numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadLagParameters {
    /// k, \[u\]/\[y\], not 0.
    pub gain: f64,
    /// λ, s, above 0: the zero is at 1/λ.
    pub lambda_s: f64,
    /// x, above 0: below 1 a lead, above 1 a lag.
    pub x: f64,
    /// α, −2 to 2.
    pub order: f64,
}

impl LeadLagParameters {
    /// C(jω), ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let pole = 1.0 / (self.x * self.lambda_s);
        let at_rest = self.gain * libm::pow(self.x, self.order);
        lead_power(omega, 1.0 / self.lambda_s, pole, self.order) * at_rest
    }
}

/// Fractional lead–lag, on the error, limited. Start-up, accuracy and cost as [`Crone`].
///
/// ```
/// use fracdiff::{FrequencyResponse, Seconds};
/// use fractional_control::{Actuator, LeadLag, LeadLagParameters, Memory, Rule};
///
/// let shape = LeadLagParameters { gain: 5.0, lambda_s: 0.5, x: 0.1, order: 0.7 };
/// let memory = Memory::new(Rule::Grunwald, 1e-6, 100.0)?;
/// let lead = LeadLag::<f64>::new(shape, Actuator::UNLIMITED, memory, Seconds(1e-3))?;
/// assert!((lead.response(6e-3) - shape.response(6.0)).norm() < 1e-4);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// Source: C. A. Monje, B. M. Vinagre, V. Feliu, Y. Chen, *Tuning and auto-tuning of fractional order controllers for
/// industry applications*, Control Engineering Practice 16, 2008.
#[derive(Clone, Debug, PartialEq)]
pub struct LeadLag<F, const MODES: usize = 48> {
    core: Shaped<F, MODES>,
}

impl<F: Real, const MODES: usize> LeadLag<F, MODES> {
    /// Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// A gain of 0, λ or x not above 0, an order outside −2 to 2, a corner above 2/T.
    pub fn new(
        parameters: LeadLagParameters,
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let lambda = positive("lambda", parameters.lambda_s, "s")?;
        let x = positive("x", parameters.x, "")?;
        let gain = parameters.gain * libm::pow(x, parameters.order);
        let shape = (parameters.order, 1.0 / lambda, 1.0 / (x * lambda));
        Ok(Self {
            core: Shaped::new(gain, shape, actuator, memory, sample_time)?,
        })
    }
}

controller_from_its_core!(LeadLag, ShapedHistory);
