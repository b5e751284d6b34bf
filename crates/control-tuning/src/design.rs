//! Design of a controller from wishes, with the best PID of order 1 beside it.

use crate::{GAINS, Sampling, Specification, Tuned, Wish, WishName, steps, tune, tune_integer};
use fracdiff::{Scheme, Seconds};
use fractional_control::{
    ControlError, ControllerSetup, Margins, PidParameters, Plant, Response, SetPoint, StepShape,
    analysis::{LoopAnalysis, analysed},
    run::limited_share,
};

/// The gains of the plant, over the nominal one, for which a design should hold.
pub const ROBUST_GAINS: [f64; 2] = [0.5, 2.0];

/// Number of samples in the time 1/`ω_c` if a design is given no sample time.
pub const SAMPLES_A_RADIAN: f64 = 50.0;

/// The longest sample time that is 1, 2 or 5 times a power of ten and at most 1/(50·`ω_c`).
#[must_use]
pub fn usual_sample_time(crossover_rad_s: f64) -> Seconds {
    let time_s = 1.0 / (SAMPLES_A_RADIAN * crossover_rad_s);
    let decade = libm::floor(libm::log10(time_s));
    let mantissas = [5.0, 2.0, 1.0].map(|step| (step, step * libm::pow(10.0, decade)));
    let fits = |(_, step): &(f64, f64)| *step <= time_s * (1.0 + 1e-9);
    let (mantissa, step) = mantissas.into_iter().find(fits).unwrap_or((1.0, time_s));
    // 2e-3 and not 0.0020000000000000005.
    Seconds(format!("{mantissa}e{decade}").parse().unwrap_or(step))
}

/// A plant, and the wishes for the loop around it.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlDesign {
    /// The plant at its nominal gain.
    pub plant: Plant,
    /// The wishes for the loop; those that contradict each other are refused.
    pub wishes: Specification,
    /// T, the sample time for which the controller is tuned and with which it runs.
    pub sample_time: Seconds,
    /// Rule and tolerance of the powers.
    pub scheme: Scheme,
    /// The lowest command that the actuator takes; `None` without a limit.
    pub output_low: Option<f64>,
    /// The highest command that the actuator takes; `None` without a limit.
    pub output_high: Option<f64>,
    /// Height of the step with limits.
    pub step: f64,
    /// Number of samples for which each step is simulated.
    pub samples: usize,
}

/// The two controllers that come closest to the wishes, one fractional and one of order 1, to show
/// what fractional orders gain.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ControlAnswer {
    /// The PI^λD^μ, whose orders were free.
    pub fractional: TunedController,
    /// The PID of order 1 that comes closest, or why none was found.
    pub integer: Result<TunedController, ControlError>,
}

/// A controller that was tuned and tried.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TunedController {
    /// The controller with limits and memory, as a loop runs it.
    pub setup: ControllerSetup,
    /// Result of the search on its grid of frequencies.
    pub tuned: Tuned,
    /// Behaviour of the loop, for a plant that can be simulated.
    pub trial: Option<Trial>,
    /// Each wish, and the value reached.
    pub wishes: Vec<Wish>,
}

/// A controller in its loop.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Trial {
    /// Verdict, margins and curve, at the nominal gain.
    pub analysis: LoopAnalysis,
    /// The gains of the plant, over the nominal one, between which the loop is proved stable;
    /// `None` if it is not stable. If [`LoopAnalysis::coarse`] is not `None`, they are the rule's.
    pub stable_gains: Option<[f64; 2]>,
    /// Steps while the gain of the plant goes from half to double, without limits: gain, shape, verdict.
    pub robustness: Vec<GainStep>,
    /// The step with the limits of the setup.
    pub step: Response,
    /// Overshoot, rise and settling of that step.
    pub shape: StepShape,
    /// Share of its samples with the command at a limit.
    pub limited_share: f64,
    /// A load as high as that step, added to the command before the plant, with the reference at rest.
    pub loaded: Response,
}

/// A step at another gain of the plant.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct GainStep {
    /// Gain over the nominal one.
    pub gain: f64,
    /// Overshoot, rise and settling of the step.
    pub shape: StepShape,
    /// Reference, output and command of the step.
    pub response: Response,
    /// True if the loop is proved stable.
    pub stable: bool,
}

impl Trial {
    /// The margins; `None` of a loop that is not proved stable, where they mean nothing.
    #[must_use]
    pub fn margins(&self) -> Option<&Margins> {
        let is_proved = self.analysis.verdict.stable && self.analysis.coarse.is_none();
        is_proved.then_some(&self.analysis.margins)
    }

    /// Largest less least overshoot over the gains; `None` if the loop is not stable at one of them, where a step only grows with time.
    #[must_use]
    pub fn overshoot_spread(&self) -> Option<f64> {
        let rows = self.robustness.iter();
        let (low, high) = rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
            (low.min(row.shape.overshoot), high.max(row.shape.overshoot))
        });
        let all_stable = self.robustness.iter().all(|row| row.stable);
        all_stable.then_some(high - low)
    }

    /// True if the loop is proved stable for every gain of the plant in [`ROBUST_GAINS`].
    #[must_use]
    pub fn is_robust(&self) -> bool {
        let [least, most] = ROBUST_GAINS;
        (self.stable_gains).is_some_and(|[low, high]| low <= least && high >= most)
    }
}

impl ControlDesign {
    /// Tunes both controllers, runs them and judges them.
    ///
    /// # Errors
    /// Wishes that contradict each other, named; no fractional controller with this crossover and margin.
    pub fn answer(&self) -> Result<ControlAnswer, ControlError> {
        let tried = |tuned: Result<Tuned, ControlError>| self.candidate(tuned?);
        // Side by side: a slider waits for it.
        let integer = || tune_integer(&self.plant, self.sampling()?, &self.wishes);
        let (fractional, integer) = rayon::join(|| tried(self.tuned()), || tried(integer()));
        Ok(ControlAnswer {
            fractional: fractional?,
            integer,
        })
    }

    fn tuned(&self) -> Result<Tuned, ControlError> {
        let tuned = tune(&self.plant, self.sampling()?, &self.wishes)?;
        if self.plant.order_at_rest() > 0.0 && tuned.parameters.integral != 0.0 {
            return Err(ControlError::NotFound {
                what: "a controller without an integral",
                why: "the plant has a factor s, at which an integral drives the command up for ever; choose a controller of another kind yourself, \
                      and judge its loop",
            });
        }
        Ok(tuned)
    }

    fn sampling(&self) -> Result<Option<Sampling>, ControlError> {
        Ok(Some(Sampling {
            sample_time: self.sample_time,
            rule: self.untuned().memory()?.rule(),
        }))
    }

    fn with(&self, tuned: &Tuned) -> ControllerSetup {
        ControllerSetup {
            law: tuned.parameters.into(),
            ..self.untuned()
        }
    }

    /// The setup without its controller. Everything acts on the error, as the wishes ask.
    fn untuned(&self) -> ControllerSetup {
        ControllerSetup {
            set_point: SetPoint::ERROR,
            output_low: self.output_low,
            output_high: self.output_high,
            scheme: self.scheme,
            ..ControllerSetup::new(PidParameters::NONE, self.sample_time)
        }
    }

    fn candidate(&self, tuned: Tuned) -> Result<TunedController, ControlError> {
        let setup = self.with(&tuned);
        // A measured response can be tuned for, not run.
        let runs = self.plant.band().1 == f64::INFINITY;
        let trial = runs.then(|| self.trial(&setup)).transpose()?;
        let wishes = self.wishes(&tuned, trial.as_ref().map(|trial| &trial.analysis.margins));
        Ok(TunedController {
            setup,
            tuned,
            trial,
            wishes,
        })
    }

    /// Runs and judges a controller of any kind; only a PID is tried at other gains of the plant.
    ///
    /// # Errors
    /// A plant that does not run, parameters outside their range.
    pub fn trial(&self, setup: &ControllerSetup) -> Result<Trial, ControlError> {
        let plant = setup.sampled(&self.plant)?;
        let judged = setup.closed_with(&plant)?.judged();
        let (memory, t) = (setup.memory()?, setup.sample_time());
        let runs = setup
            .pid()
            .map(|pid| steps(&pid, &self.plant, memory, t, self.samples))
            .transpose()?;
        let robustness = GAINS
            .into_iter()
            .zip(runs.unwrap_or_default())
            .map(|(gain, response)| GainStep {
                gain,
                shape: response.shape(),
                response,
                stable: judged.sampled_loop().with_gain(gain).verdict().stable,
            });
        let step = vec![self.step; self.samples];
        let step = setup.simulate(&plant, &step)?;
        let analysis = analysed(setup, &self.plant, &judged)?;
        Ok(Trial {
            stable_gains: judged.sampled_loop().gain_interval(&analysis.margins),
            analysis,
            robustness: robustness.collect(),
            shape: step.shape_of_step(self.step),
            limited_share: limited_share(setup, &step),
            loaded: setup.simulate_loaded(&plant, &vec![0.0; self.samples], self.step)?,
            step,
        })
    }

    /// Each wish and what is reached: in the loop that runs, where it runs.
    fn wishes(&self, tuned: &Tuned, margins: Option<&Margins>) -> Vec<Wish> {
        let (asked, measures) = (&self.wishes, &tuned.measures);
        let phase = margins.and_then(|margins| margins.phase);
        let designed = (asked.crossover_rad_s, tuned.phase_margin_rad);
        let (crossover, margin) = phase.map_or(designed, |phase| (phase.omega_rad_s, phase.value));
        let mut rows = vec![
            Wish::new(WishName::Crossover, asked.crossover_rad_s, crossover),
            Wish::new(WishName::PhaseMargin, asked.phase_margin_rad, margin),
        ];
        if asked.iso_damping {
            rows.push(Wish::new(WishName::IsoDamping, 0.0, tuned.phase_slope_rad));
        }
        let peaks = margins.map_or(
            [measures.sensitivity_peak, measures.complementary_peak],
            |margins| [margins.sensitivity.value, margins.complementary.value],
        );
        rows.extend(asked.bounds(peaks, [measures.noise, measures.disturbance]));
        rows
    }
}
