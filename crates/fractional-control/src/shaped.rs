//! Controllers that act on the error: CRONE of the second generation, fractional lead–lag, any proper function of s.

use crate::{
    Actuator, ControlError, Controller, FractionalTransferFunction, PowerMemory,
    SampledTransferFunction,
    controller::Stage,
    lead::{LeadPower, LeadShape},
    transfer::in_samples,
};
use fracdiff::{
    Differintegrator, FrequencyResponse, Real, Seconds,
    parameter::{positive, range},
};
use num_complex::Complex;

/// k·P of the error r − y, limited, P an operator.
///
/// - *Limits*: it takes in the error that would have given its limited command, which runs the operator backwards: with limits its
///   zeros must be stable.
/// - *Start-up*: zero for ever before. *Cost*: `output` a few multiply-adds, `advance` as the operator.
#[derive(Clone, Debug, PartialEq)]
pub struct OnError<F, O> {
    pub(crate) operator: O,
    pub(crate) gain: F,
    pub(crate) stage: Stage<F>,
}

/// History of [`OnError`].
#[derive(Clone, Debug, PartialEq)]
pub struct OnErrorHistory<F, H> {
    operator: H,
    /// Held over a change or a start; fades where nothing integrates.
    bias: F,
}

/// CRONE of the second generation, and fractional lead–lag.
///
/// - *Units*: ω in rad/s, corners at most 2/T. *Cost*: `advance` as two full memories.
/// - *Accuracy*: the Tustin rule, an error of O(T²), no warping at rest; each weight to the tolerance of [`PowerMemory`].
pub type LeadController<F, const MODES: usize = 48> = OnError<F, LeadPower<F, MODES>>;

/// C(s) of the error: a [`FractionalTransferFunction`] as a controller. *Cost*: `advance` as [`SampledTransferFunction`].
pub type FunctionController<F, const MODES: usize = 64> =
    OnError<F, SampledTransferFunction<F, MODES>>;

impl<F: Real, O> Controller<F> for OnError<F, O>
where
    O: Differintegrator<F> + PartialEq,
{
    type History = OnErrorHistory<F, O::History>;

    fn at_rest(&self) -> Self::History {
        OnErrorHistory {
            operator: self.operator.at_rest(),
            bias: F::ZERO,
        }
    }

    #[inline]
    fn wanted(&self, history: &Self::History, r: F, y: F) -> F {
        self.gain * self.operator.output(&history.operator, r - y) + history.bias
    }

    #[inline]
    fn output(&self, history: &Self::History, r: F, y: F) -> F {
        self.stage.limit(self.wanted(history, r, y))
    }

    #[inline]
    fn limited(&self, command: F) -> F {
        self.stage.limit(command)
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, r: F, y: F, applied: F) {
        let wanted = self.wanted(history, r, y);
        // The error that would have given what was left of the command.
        let error = (r - y) + (self.stage.given(wanted, applied) - wanted) / self.feedback_gain();
        self.operator.advance(&mut history.operator, error);
        history.bias = self.stage.faded(history.bias);
    }

    fn follow(&self, history: &mut Self::History, r: F, y: F, applied: F) {
        let wanted = self.wanted(history, r, y);
        history.bias += self.stage.applied(wanted, applied) - wanted;
        self.operator.advance(&mut history.operator, r - y);
    }

    #[inline]
    fn feedback_gain(&self) -> F {
        self.gain * self.operator.direct_gain()
    }

    fn settled(&self, r: F, y: F, command: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        history.operator = self.operator.settled(r - y)?;
        let wanted = self.wanted(&history, r, y);
        history.bias = self.stage.limit(self.stage.applied(wanted, command)) - wanted;
        Some(history)
    }

    fn take_over(&self, other: &Self, history: &Self::History, r: F, y: F) -> Self::History {
        let wanted = other.wanted(history, r, y);
        let mut next = self.at_rest();
        if self.operator == other.operator {
            next.operator.clone_from(&history.operator);
        } else if let Some(settled) = self.operator.settled(r - y) {
            next.operator = settled;
        }
        next.bias += wanted - self.wanted(&next, r, y);
        next
    }
}

impl<F: Real, O: FrequencyResponse> FrequencyResponse for OnError<F, O> {
    /// −u/y at the angle θ, of the weights held.
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CroneParameters {
    /// C₀, \[u\]/\[y\], not 0: the gain below both corners.
    pub gain: f64,
    /// ν, −2 to 2.
    pub order: f64,
    /// `ω_b`, rad/s.
    pub low_rad_s: f64,
    /// `ω_h`, rad/s, above `ω_b`.
    pub high_rad_s: f64,
}

impl CroneParameters {
    /// # Errors
    /// A lower corner that is not below the upper one.
    pub(crate) fn shape(&self) -> Result<LeadShape, ControlError> {
        let (low, high) = (self.low_rad_s, self.high_rad_s);
        let allowed = "below the upper corner";
        range("lower corner", low, low < high, allowed, "rad/s")?;
        Ok(LeadShape {
            gain: self.gain,
            factor: 1.0,
            order: self.order,
            zero_rad_s: low,
            pole_rad_s: high,
        })
    }

    /// C(jω) of the continuous law, ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        lead_power(omega, self.low_rad_s, self.high_rad_s, self.order) * self.gain
    }
}

/// k((s + 1/λ)/(s + 1/(xλ)))^α, as numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeadLagParameters {
    /// k, \[u\]/\[y\], not 0: the gain above both corners; below them it is k·x^α.
    pub gain: f64,
    /// λ, s, above 0: the zero is at 1/λ.
    pub lambda_s: f64,
    /// x, above 0: below 1 a lead, above 1 a lag.
    pub x: f64,
    /// α, −2 to 2.
    pub order: f64,
}

impl LeadLagParameters {
    /// # Errors
    /// λ or x not above 0.
    pub(crate) fn shape(&self) -> Result<LeadShape, ControlError> {
        let lambda = positive("lambda", self.lambda_s, "s")?;
        let x = positive("x", self.x, "")?;
        Ok(LeadShape {
            gain: self.gain,
            factor: libm::pow(x, self.order),
            order: self.order,
            zero_rad_s: 1.0 / lambda,
            pole_rad_s: 1.0 / (x * lambda),
        })
    }

    /// C(jω) of the continuous law, ω in rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let pole = 1.0 / (self.x * self.lambda_s);
        let at_rest = self.gain * libm::pow(self.x, self.order);
        lead_power(omega, 1.0 / self.lambda_s, pole, self.order) * at_rest
    }
}

impl<F: Real, const MODES: usize> LeadController<F, MODES> {
    /// CRONE: a phase νπ/2 that is flat in the band from `ω_b` to `ω_h`. Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// A gain of 0, an order outside −2 to 2, corners that are not `0 < ω_b < ω_h ≤ 2/T`.
    /// ```
    /// use fracdiff::{FrequencyResponse, Seconds};
    /// use fractional_control::{Actuator, CroneParameters, LeadController, PowerMemory, Rule};
    ///
    /// let shape = CroneParameters { gain: 2.0, order: 0.6, low_rad_s: 1.0, high_rad_s: 100.0 };
    /// let memory = PowerMemory::new(Rule::Grunwald, 1e-6, 100.0)?;
    /// let crone = LeadController::<f64>::crone(shape, Actuator::UNLIMITED, memory, Seconds(1e-3))?;
    /// let phase = crone.response(10.0 * 1e-3).arg().to_degrees();
    /// assert!((phase - 0.6 * 78.6).abs() < 0.1);
    /// # Ok::<(), fractional_control::ControlError>(())
    /// ```
    /// Source: A. Oustaloup, *La commande CRONE*, Hermès, 1991.
    pub fn crone(
        parameters: CroneParameters,
        actuator: Actuator,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        Self::shaped(parameters.shape()?, actuator, memory, sample_time)
    }

    /// Fractional lead–lag. Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// A gain of 0, λ or x not above 0, an order outside −2 to 2, a corner above 2/T.
    ///
    /// Source: C. A. Monje, B. M. Vinagre, V. Feliu, Y. Chen, *Tuning and auto-tuning of fractional order controllers for
    /// industry applications*, Control Engineering Practice 16, 2008.
    pub fn lead_lag(
        parameters: LeadLagParameters,
        actuator: Actuator,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        Self::shaped(parameters.shape()?, actuator, memory, sample_time)
    }

    fn shaped(
        shape: LeadShape,
        actuator: Actuator,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let gain = shape.gain * shape.factor;
        range("gain", gain, gain != 0.0, "finite and not 0", "")?;
        let (operator, normaliser) = LeadPower::new(&shape, &memory, sample_time)?;
        in_samples::<F>("inverse of the gain", 1.0 / (gain * normaliser))?;
        Ok(Self {
            operator,
            gain: in_samples("gain", gain * normaliser)?,
            stage: actuator.stage(sample_time, false),
        })
    }
}

impl<F: Real, const MODES: usize> FunctionController<F, MODES> {
    /// Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// As [`SampledTransferFunction::new`]; a newest command that does not follow from the newest error.
    /// ```
    /// use fracdiff::Seconds;
    /// use fractional_control::{Actuator, Controller, FunctionController, PowerMemory, Rule};
    ///
    /// let memory = PowerMemory::new(Rule::Bdf2, 1e-6, 100.0)?;
    /// let function = "3(s^0.5+1)/(0.01s+1)".parse()?;
    /// let lead = FunctionController::<f64>::new(&function, Actuator::new(-2.0, 2.0)?, memory, Seconds(1e-3))?;
    /// assert_eq!(lead.output(&lead.at_rest(), 1.0, 0.0), 2.0);
    /// # Ok::<(), fractional_control::ControlError>(())
    /// ```
    pub fn new(
        function: &FractionalTransferFunction,
        actuator: Actuator,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let operator = SampledTransferFunction::new(function, memory, sample_time)?;
        let direct: F = operator.direct_gain();
        let gain = direct.to_f64();
        let well = gain != 0.0 && (1.0 / gain).is_finite();
        let allowed = "finite and not 0";
        range("gain of the newest error", gain, well, allowed, "")?;
        let integrates = function.numerator().lowest() < function.denominator().lowest();
        Ok(Self {
            operator,
            gain: F::ONE,
            stage: actuator.stage(sample_time, integrates),
        })
    }
}
