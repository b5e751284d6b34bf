//! Any proper function of s as a controller.

use crate::controller::{Stage, controller_from_its_core};
use crate::{
    Actuator, ControlError, FractionalTransferFunction, Memory, SampledHistory,
    SampledTransferFunction,
};
use fracdiff::parameter::range;
use fracdiff::{Differintegrator, FrequencyResponse, Real, Seconds};
use num_complex::Complex;

#[derive(Clone, Debug, PartialEq)]
struct OfError<F, const MODES: usize> {
    function: SampledTransferFunction<F, MODES>,
    /// 1 over the direct gain.
    inverse: F,
    stage: Stage<F>,
}

/// History of [`FunctionController`].
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionHistory<F, const MODES: usize> {
    function: SampledHistory<F, MODES>,
    bias: F,
}

impl<F: Real, const MODES: usize> OfError<F, MODES> {
    fn at_rest(&self) -> FunctionHistory<F, MODES> {
        FunctionHistory {
            function: self.function.at_rest(),
            bias: F::ZERO,
        }
    }

    #[inline]
    fn feedback_gain(&self) -> F {
        self.function.direct_gain()
    }

    #[inline]
    fn wanted(&self, history: &FunctionHistory<F, MODES>, r: F, y: F) -> F {
        self.function.output(&history.function, r - y) + history.bias
    }

    #[inline]
    fn advance(&self, history: &mut FunctionHistory<F, MODES>, r: F, y: F, applied: F) {
        let excess = applied - self.wanted(history, r, y);
        // The error that would have given what was applied.
        let error = (r - y) + excess * self.inverse;
        self.function.advance(&mut history.function, error);
        history.bias = self.stage.faded(history.bias);
    }

    fn follow(&self, history: &mut FunctionHistory<F, MODES>, r: F, y: F, applied: F) {
        history.bias += applied - self.wanted(history, r, y);
        self.function.advance(&mut history.function, r - y);
    }

    fn keep(
        &self,
        other: &Self,
        history: &FunctionHistory<F, MODES>,
        _: F,
        _: F,
    ) -> FunctionHistory<F, MODES> {
        let mut kept = self.at_rest();
        if self.function == other.function {
            kept.function.clone_from(&history.function);
        }
        kept
    }

    fn response(&self, theta: f64) -> Complex<f64> {
        self.function.response(theta)
    }
}

/// C(s) of the error, limited: a [`FractionalTransferFunction`] as a controller.
///
/// - *Limits*: back-calculation runs the function backwards, so with limits its zeros must be stable.
/// - *Cost*: `output` two multiply-adds, `advance` as [`SampledTransferFunction`].
///
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{Actuator, Controller, FunctionController, Memory, Rule};
///
/// let memory = Memory::new(Rule::Bdf2, 1e-6, 100.0)?;
/// let lead = FunctionController::<f64>::new(
///     &"3(s^0.5+1)/(0.01s+1)".parse()?,
///     Actuator::new(-2.0, 2.0)?,
///     memory,
///     Seconds(1e-3),
/// )?;
/// assert_eq!(lead.output(&lead.at_rest(), 1.0, 0.0), 2.0);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionController<F, const MODES: usize = 64> {
    core: OfError<F, MODES>,
}

impl<F: Real, const MODES: usize> FunctionController<F, MODES> {
    /// Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// As [`SampledTransferFunction::new`]; a newest command that does not follow from the newest error.
    pub fn new(
        function: &FractionalTransferFunction,
        actuator: Actuator,
        memory: Memory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let function = SampledTransferFunction::new(function, memory, sample_time)?;
        let direct: F = function.direct_gain();
        let gain = direct.to_f64();
        let well = gain != 0.0 && (1.0 / gain).is_finite();
        let allowed = "finite and not 0";
        range("gain of the newest error", gain, well, allowed, "")?;
        Ok(Self {
            core: OfError {
                function,
                inverse: F::from_f64(1.0 / gain),
                stage: actuator.stage(sample_time),
            },
        })
    }
}

controller_from_its_core!(FunctionController, FunctionHistory);
