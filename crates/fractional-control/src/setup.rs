//! A controller with all that its loop needs to know of it.

use crate::{
    Actuator, ControlError, Controller, ControllerParameters, FractionalPid,
    FractionalTransferFunction, FunctionController, HeldPlant, LeadController, PidParameters,
    Plant, PowerMemory, Response, Rule, SampledControlLoop, SetPoint, Term, enclosure::Fraction,
    records::MODES, simulate::simulate_loaded,
};

use certified_count::{Enclosing, count};
use core::fmt::Debug;
use fracdiff::{
    Scheme, Seconds,
    full_memory::Kernel,
    parameter::{RangeError, range},
};
use std::{sync::Arc, vec::Vec};

type Pid = FractionalPid<f64, MODES>;
type Lead = LeadController<f64, MODES>;

/// Samples that a controller remembers where no time is given: 200 s at 1 kHz.
const MEMORY_SAMPLES: f64 = 2e5;
/// Rule and tolerance where none is given.
const SCHEME: Scheme = Scheme::FullBdf2 {
    tolerance: fracdiff::scheme::DEFAULT_TOLERANCE,
};

/// A controller, its limits and its memory: all that a loop needs except the plant.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{ControllerSetup, PidParameters, Plant, HeldPlant};
///
/// let gains = PidParameters { proportional: 2.0, integral: 1.0, ..PidParameters::NONE };
/// let setup = ControllerSetup { output_high: Some(1.5), ..ControllerSetup::new(gains, Seconds(0.01)) };
/// let plant: Plant = "1/(s+1)".parse()?;
/// let plant = HeldPlant::with_usual_memory(&plant, setup.sample_time())?;
/// assert!(setup.closed_with(&plant)?.verdict().stable);
/// let response = setup.simulate(&plant, &[1.0; 1000])?;
/// assert!(response.command.iter().all(|u| *u <= 1.5));
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerSetup {
    /// The law and its gains, as they are in continuous time.
    pub law: ControllerParameters,
    /// Set-point weights of a PID; c of a TID. Others act on the error.
    pub set_point: SetPoint,
    /// Lowest command, in the unit of the plant's input.
    pub output_low: Option<f64>,
    /// Highest command, in the unit of the plant's input; `None` without a limit.
    pub output_high: Option<f64>,
    /// Time constant in which the bump of a change fades, s.
    pub fade_time_s: f64,
    /// T, s, with which the powers are sampled.
    pub sample_time_s: f64,
    /// Rule and tolerance of the powers: `full` or `full-bdf2`.
    pub scheme: Scheme,
    /// Time for which the memory keeps its tolerance, s; `None` for 200 000 samples.
    pub memory_s: Option<f64>,
}

impl ControllerSetup {
    /// Setup with everything else at its default: full-bdf2, no limits, the derivative of the measurement.
    #[must_use]
    pub fn new(law: impl Into<ControllerParameters>, sample_time: Seconds) -> Self {
        Self {
            law: law.into(),
            set_point: SetPoint::DEFAULT,
            output_low: None,
            output_high: None,
            fade_time_s: 1.0,
            sample_time_s: sample_time.0,
            scheme: SCHEME,
            memory_s: None,
        }
    }

    /// The parameters of a PI^λD^μ, if it is one.
    #[must_use]
    pub fn pid(&self) -> Option<PidParameters> {
        let ControllerParameters::Pid(pid) = self.law else {
            return None;
        };
        Some(pid)
    }

    /// The transfer function, if it is given as one.
    #[must_use]
    pub fn function(&self) -> Option<FractionalTransferFunction> {
        let ControllerParameters::Function(function) = self.law else {
            return None;
        };
        Some(function)
    }

    /// T, as the operators take it.
    #[must_use]
    pub const fn sample_time(&self) -> Seconds {
        Seconds(self.sample_time_s)
    }

    /// Limits of the command.
    ///
    /// # Errors
    /// A lower limit that is not below the upper one, a fade time that is not above 0.
    pub fn actuator(&self) -> Result<Actuator, ControlError> {
        let low = self.output_low.unwrap_or(f64::NEG_INFINITY);
        let high = self.output_high.unwrap_or(f64::INFINITY);
        Actuator::new(low, high)?.fading(self.fade_time_s)
    }

    /// Rule, tolerance and horizon.
    ///
    /// # Errors
    /// A scheme that controllers do not support.
    pub fn memory(&self) -> Result<PowerMemory, ControlError> {
        let (rule, tolerance) = rule_of_scheme(self.scheme).ok_or(SCHEME_REFUSED)?;
        PowerMemory::new(rule, tolerance, self.horizon_s())
    }

    /// Time for which the powers are remembered with that tolerance, s.
    #[must_use]
    pub fn horizon_s(&self) -> f64 {
        let default = MEMORY_SAMPLES * self.sample_time_s;
        self.memory_s.unwrap_or(default)
    }

    /// Makes the controller once.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<(), ControlError> {
        self.with_controller(&mut Nothing)
    }

    /// Runs the loop with a plant from rest; the reference is given for each sample. Set-point
    /// weights come from the setup.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn simulate(&self, plant: &HeldPlant, reference: &[f64]) -> Result<Response, ControlError> {
        self.simulate_loaded(plant, reference, 0.0)
    }

    /// Runs the loop with a load that is added to the command before the plant, from the first sample on.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn simulate_loaded(
        &self,
        plant: &HeldPlant,
        reference: &[f64],
        load: f64,
    ) -> Result<Response, ControlError> {
        let mut run = Run {
            plant,
            reference,
            load,
            response: Response::default(),
        };
        self.with_controller(&mut run)?;
        Ok(run.response)
    }

    /// The plant as the loop of this controller samples it.
    ///
    /// # Errors
    /// As [`HeldPlant::with_usual_memory`].
    pub fn sampled(&self, plant: &Plant) -> Result<HeldPlant, ControlError> {
        HeldPlant::with_usual_memory(plant, self.sample_time())
    }

    /// The loop with a plant, for its verdict and margins.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn closed_with(&self, plant: &HeldPlant) -> Result<SampledControlLoop, ControlError> {
        SampledControlLoop::new(self.law, self.memory()?, plant)
    }

    /// The answer of the command to the measurement while the reference stands and no limit holds.
    ///
    /// # Errors
    /// As [`check`](Self::check); a controller that grows by itself.
    pub fn feedback(&self) -> Result<Feedback, ControlError> {
        let mut newest = Newest(0.0);
        self.with_controller(&mut newest)?;
        let Fraction { above, below } = self.law.fraction(self.memory()?, self.sample_time())?;
        let resting = below.clone().without_differences();
        let grows = count(|arc| resting.at(arc)).unstable_poles;
        let what = "number of poles of the controller that grow by themselves";
        let allowed = "0: change its denominator";
        let of = grows.unwrap_or(1) as f64;
        range(what, of, grows == Some(0), allowed, "")?;
        Ok(Feedback {
            above: Arc::new(above),
            below: Arc::new(below),
            direct_gain: newest.0,
            integrates: self.law.integrates(),
        })
    }

    /// Makes the controller and hands it on.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn with_controller(&self, user: &mut impl UseController) -> Result<(), ControlError> {
        let (actuator, memory, t) = (self.actuator()?, self.memory()?, self.sample_time());
        match &self.law {
            ControllerParameters::Pid(law) => {
                user.have(&Pid::new(*law, self.set_point, actuator, memory, t)?);
            }
            ControllerParameters::Tid(law) => {
                let weight = self.set_point.derivative;
                user.have(&Pid::tid(*law, weight, actuator, memory, t)?);
            }
            ControllerParameters::Crone(law) => {
                user.have(&Lead::crone(*law, actuator, memory, t)?);
            }
            ControllerParameters::LeadLag(law) => {
                user.have(&Lead::lead_lag(*law, actuator, memory, t)?);
            }
            ControllerParameters::Function(law) => {
                if self.output_low.is_some() || self.output_high.is_some() {
                    runs_backwards(law)?;
                }
                let controller = FunctionController::<f64, MODES>::new(law, actuator, memory, t)?;
                user.have(&controller);
            }
        }
        Ok(())
    }
}

/// −u/y of a sampled controller, above/below.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Feedback {
    /// The numerator as a function on the unit circle.
    pub above: Arc<dyn Enclosing>,
    /// The denominator, with a zero at w = 1 of an integral of an order from 1 on.
    pub below: Arc<dyn Enclosing>,
    /// The fall of the command at once when the measurement rises by one.
    pub direct_gain: f64,
    /// True if a measurement that stands drives the command on and on.
    pub integrates: bool,
}

/// Rule and tolerance of a scheme that a controller may have.
#[must_use]
pub fn rule_of_scheme(scheme: Scheme) -> Option<(Rule, f64)> {
    let grunwald = Kernel::Grunwald;
    match scheme {
        Scheme::Full { kernel, tolerance } => {
            (kernel == grunwald).then_some((Rule::Grunwald, tolerance))
        }
        Scheme::FullBdf2 { tolerance } => Some((Rule::Bdf2, tolerance)),
        Scheme::Grunwald { .. }
        | Scheme::Muir { .. }
        | Scheme::TustinMuir { .. }
        | Scheme::Oustaloup { .. }
        | Scheme::Exact
        | _ => None,
    }
}

const SCHEME_REFUSED: ControlError = ControlError::NotFound {
    what: "a controller with this scheme",
    why: "give full[:TOLERANCE] or full-bdf2[:TOLERANCE]",
};

/// Refuses a function whose inverse is unstable.
fn runs_backwards(function: &FractionalTransferFunction) -> Result<(), ControlError> {
    let above = function.numerator();
    let lowest = above.lowest();
    let terms: Vec<Term> = above
        .terms()
        .iter()
        .map(|term| Term::new(term.coefficient, term.order - lowest))
        .collect();
    let inverse = FractionalTransferFunction::new(&[Term::new(1.0, 0.0)], &terms)?;
    match inverse.unstable_poles() {
        Some(0) => Ok(()),
        zeros => Err(RangeError::new(
            "number of unstable zeros of a limited controller",
            zeros.unwrap_or(1) as f64,
            "0: omit `output_low` and `output_high`, or change the function",
            "",
        )
        .into()),
    }
}

/// A function to apply to a controller of any type.
pub trait UseController {
    /// Gets it, of whatever type.
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C);
}

/// The gain of the newest measurement.
struct Newest(f64);

impl UseController for Newest {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C) {
        self.0 = controller.feedback_gain();
    }
}

struct Nothing;

impl UseController for Nothing {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, _: &C) {}
}

struct Run<'a> {
    plant: &'a HeldPlant,
    reference: &'a [f64],
    load: f64,
    response: Response,
}

impl UseController for Run<'_> {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C) {
        let at = |n: usize| self.reference.get(n).copied().unwrap_or(0.0);
        let samples = self.reference.len();
        self.response = simulate_loaded(controller, self.plant, at, self.load, samples);
    }
}
