//! A plant as a sampled loop sees it: held, late, exact where it can be.

use crate::{
    ControlError, FractionalTransferFunction, Plant, PowerMemory, Rule, SampledHistory,
    SampledTransferFunction, StateSpace,
    curves::transfer_fraction,
    cut::HeldFactors,
    enclosure::{Factor, Fraction, Product, Sum},
    held_response::HeldResponse,
    plant::Model,
    records::MODES,
    state_space::{SampledStates, StatesInV},
};
use core::f64::consts::PI;
use fracdiff::{Differintegrator, Seconds, parameter::range};
use nalgebra::DVector;
use std::{boxed::Box, collections::VecDeque, vec, vec::Vec};

/// Above over below of it on the circle.
/// Parts of a sample in which a function behind factors runs.
const PARTS: u32 = 16;
const PLANT: &str = "gain of the plant over a sample";
pub(crate) const DELAY_MAX: f64 = 10_000.0;

impl Plant {
    /// The dead time in samples, if it is not too long.
    ///
    /// # Errors
    /// More than 10 000 samples.
    pub fn delay_samples(&self, sample_time: Seconds) -> Result<f64, ControlError> {
        let samples = self.delay_s / sample_time.0;
        let inside = samples <= DELAY_MAX;
        range("dead time", samples, inside, "at most 10000 {}", "samples")?;
        Ok(samples)
    }
}

/// Share of the response at half the sample rate, over that at rest, down to which decays have the digits of the response.
const LEFT: f64 = 1e-7;

/// Tolerance of the usual memory, and the samples for which it holds.
const USUAL_TOLERANCE: f64 = 1e-9;
const USUAL_SAMPLES: f64 = 1e6;

/// A [`Plant`] behind a hold and its dead time (d + h)T, 0 ≤ h < 1, sampled with T.
///
/// - *Matrices, and transfer functions of whole orders up to 16*: exactly, by matrix exponentials of the two parts of a sample, in numbers of
///   some hundred bits, so that a pole of any speed, from 1e-6 to 1e6 a sample, keeps its digits. The direct path of a function of equal degrees
///   passes on the command of ⌈d + h⌉ samples ago, and of one at least: a loop measures before it commands.
/// - *Other transfer functions*: by the rule of [`PowerMemory`], fed with the held command as a hat function between neighbouring samples sees it,
///   m\[n\] = p₀u\[n−d\] + p₁u\[n−d−1\] + p₂u\[n−d−2\] with p = ((1−h)²/2, 1/2 + h − h², h²/2): an error of O(T²) with
///   [`Rule::Bdf2`](crate::Rule::Bdf2). Where p₀ acts at once the loop is solved for the command.
/// - *Powers of brackets and diffusion*: exactly, by the decays along their cuts. A transfer function beside them that is no number follows the rule,
///   fed with their output.
#[derive(Clone, Debug)]
pub struct HeldPlant {
    kind: Kind,
    delay: usize,
    part: f64,
    path: [f64; 3],
    /// Direct path of a plant in states: what it passes on at once, and by how many samples more than d.
    direct: (f64, usize),
    curve: Fraction,
    /// Reach of its memory, s, if it follows a rule.
    memory_s: Option<f64>,
    /// Response of a plant that follows a rule, computed without the rule.
    held: Option<HeldResponse>,
    /// The plant in parts of a sample, which runs in its place.
    finer: Option<Box<Self>>,
    sample_time: Seconds,
}

#[derive(Clone, Debug)]
enum Kind {
    Transfer(Box<SampledTransferFunction<f64, MODES>>),
    States(SampledStates),
    /// Factors, and the function behind them.
    Factors(HeldFactors, Behind),
}

/// The function behind powers of brackets and diffusion.
#[derive(Clone, Debug)]
enum Behind {
    Gain(f64),
    Transfer(Box<SampledTransferFunction<f64, MODES>>),
}

/// The state of a [`HeldPlant`].
#[derive(Clone, Debug)]
pub struct PlantState {
    kind: KindState,
    /// u\[n−1\], u\[n−2\], …
    commands: VecDeque<f64>,
}

#[derive(Clone, Debug)]
enum KindState {
    Transfer(Box<SampledHistory<f64, MODES>>),
    States(DVector<f64>),
    Factors(Vec<f64>, Option<Box<SampledHistory<f64, MODES>>>),
}

impl HeldPlant {
    /// Remembers a million samples within 1e-9, by the rule of second order, whatever the rule of the controller is.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_usual_memory(plant: &Plant, sample_time: Seconds) -> Result<Self, ControlError> {
        let memory = PowerMemory::new(Rule::Bdf2, USUAL_TOLERANCE, USUAL_SAMPLES * sample_time.0)?;
        Self::new(plant, memory, sample_time)
    }

    /// The plant at this sample time.
    ///
    /// # Errors
    /// A measured response, which does not run; a dead time of more than 10 000 samples; as [`SampledTransferFunction::new`].
    pub fn new(
        plant: &Plant,
        memory: PowerMemory,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        sample_time.rate_to_the(fracdiff::Order::new(0.0)?)?;
        let samples = plant.delay_samples(sample_time)?;
        let nearest = libm::round(samples);
        let samples = if (samples - nearest).abs() < 1e-9 {
            nearest
        } else {
            samples
        };
        let delay = libm::floor(samples);
        let h = samples - delay;
        let delay = delay as usize;
        let function = match &plant.model {
            Model::Transfer(function) => function,
            Model::StateSpace(states) => {
                return Self::in_states(states, 0.0, delay, h, 0.0, sample_time);
            }
            Model::Measured(_) => return Err(ControlError::Measured),
        };
        if !plant.factors().is_empty() {
            let held =
                Self::behind_factors(plant, function, memory, [delay as f64, h], sample_time)?;
            return Ok(held.finer(plant, function, memory, samples));
        }
        if let Some((states, direct)) = StateSpace::of_function(function) {
            let integrators = function.denominator().lowest();
            return Self::in_states(&states, direct, delay, h, integrators, sample_time);
        }
        let running = SampledTransferFunction::new(function, memory, sample_time)?;
        let path = [0.5 * (1.0 - h) * (1.0 - h), 0.5 + h - h * h, 0.5 * h * h];
        let curve = transfer_fraction(function, memory, sample_time)?;
        let factors = [Factor::InW(path.to_vec()), Factor::Delay(delay)];
        let above = factors.iter().fold(curve.above, Sum::with);
        let curve = Fraction { above, ..curve }.bearable(PLANT)?;
        Ok(Self {
            kind: Kind::Transfer(Box::new(running)),
            delay,
            part: h,
            path,
            direct: (0.0, 1),
            memory_s: curve.remembers().then_some(memory.horizon_s()),
            held: HeldResponse::new(plant, sample_time.0),
            curve,
            finer: None,
            sample_time,
        })
    }

    fn behind_factors(
        plant: &Plant,
        function: &FractionalTransferFunction,
        memory: PowerMemory,
        [delay, h]: [f64; 2],
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let (factors, silent) = HeldFactors::new(plant.factors(), sample_time.0, h);
        let inside = silent <= DELAY_MAX;
        let what = "time before diffusion arrives";
        range(
            what,
            silent,
            inside,
            "at most 10000 {}: sample more slowly",
            "samples",
        )?;
        let delay = delay as usize + silent as usize;
        let curve = transfer_fraction(function, memory, sample_time)?;
        let remembers = curve.remembers() || plant.factors().remembers(sample_time.0);
        let above = Sum(factors.times(&curve.above.0)).with(&Factor::Delay(delay));
        let is_number = function.denominator().degree() == 0.0;
        let behind = if is_number {
            Behind::Gain(function.gain_at_rest())
        } else {
            let running = SampledTransferFunction::new(function, memory, sample_time)?;
            Behind::Transfer(Box::new(running))
        };
        Ok(Self {
            kind: Kind::Factors(factors, behind),
            delay,
            part: h,
            path: [0.0; 3],
            direct: (0.0, 1),
            curve: Fraction { above, ..curve }.bearable(PLANT)?,
            memory_s: remembers.then_some(memory.horizon_s()),
            // Decays cancel each other to the last digit where they leave hardly anything.
            held: (!is_number || plant.factors().share_at(PI / sample_time.0) < LEFT)
                .then(|| HeldResponse::new(plant, sample_time.0))
                .flatten(),
            finer: None,
            sample_time,
        })
    }

    /// Runs a function behind factors in parts of a sample, over which the command is held: only what is between the two follows the rule.
    fn finer(
        mut self,
        plant: &Plant,
        function: &FractionalTransferFunction,
        memory: PowerMemory,
        samples: f64,
    ) -> Self {
        if matches!(self.kind, Kind::Factors(_, Behind::Transfer(_))) {
            let late = samples * f64::from(PARTS);
            let late = [libm::floor(late), late - libm::floor(late)];
            let part = Seconds(self.sample_time.0 / f64::from(PARTS));
            // Diffusion that arrives after too many parts is left to whole samples.
            let finer = Self::behind_factors(plant, function, memory, late, part);
            self.finer = finer.ok().map(Box::new);
        }
        self
    }

    fn in_states(
        states: &StateSpace,
        direct: f64,
        delay: usize,
        h: f64,
        integrators: f64,
        sample_time: Seconds,
    ) -> Result<Self, ControlError> {
        let (sampled, in_v) = states.held(sample_time.0, h)?;
        let later = usize::from(h > 0.0 || delay == 0);
        let curve = states_fraction(in_v, integrators, direct, later).bearable(PLANT)?;
        Ok(Self {
            kind: Kind::States(sampled),
            delay,
            part: h,
            path: [0.0; 3],
            direct: (direct, later),
            curve: Fraction {
                above: curve.above.with(&Factor::Delay(delay)),
                ..curve
            },
            memory_s: None,
            held: None,
            finer: None,
            sample_time,
        })
    }

    /// True if the samples are exact for the plant behind a hold. If not, they follow a rule, which
    /// is accurate for a loop that is slow compared with the sample time: up to a crossover of
    /// about 0.3/T.
    #[must_use]
    pub const fn is_exact(&self) -> bool {
        matches!(
            self.kind,
            Kind::States(_) | Kind::Factors(_, Behind::Gain(_))
        )
    }

    /// T, for which the plant was sampled.
    #[must_use]
    pub fn sample_time(&self) -> Seconds {
        self.sample_time
    }

    /// The part of a sample in its dead time, 0 to 1.
    pub(crate) fn part(&self) -> f64 {
        self.part
    }

    /// Reach of its memory, s; `None` without one.
    pub(crate) fn memory_s(&self) -> Option<f64> {
        self.memory_s
    }

    /// The plant without its rule; `None` if it is sampled exactly.
    pub(crate) fn held_response(&self) -> Option<&HeldResponse> {
        self.held.as_ref()
    }

    pub(crate) fn curve(&self) -> &Fraction {
        &self.curve
    }

    /// A plant that always was at rest.
    #[must_use]
    pub fn at_rest(&self) -> PlantState {
        if let Some(finer) = &self.finer {
            return finer.at_rest();
        }
        PlantState {
            kind: match &self.kind {
                Kind::Transfer(running) => KindState::Transfer(Box::new(running.at_rest())),
                Kind::States(states) => KindState::States(states.at_rest()),
                Kind::Factors(factors, behind) => KindState::Factors(
                    factors.at_rest(),
                    match behind {
                        Behind::Gain(_) => None,
                        Behind::Transfer(running) => Some(Box::new(running.at_rest())),
                    },
                ),
            },
            commands: vec![0.0; self.delay + 2].into(),
        }
    }

    /// The share of the command of now in the output of now: above 0 only for a transfer function that is sampled by a rule, without a
    /// whole sample of dead time.
    #[must_use]
    pub fn direct_gain(&self) -> f64 {
        match (&self.kind, self.delay) {
            (Kind::Transfer(running), 0) => running.direct_gain() * self.path[0],
            _ => 0.0,
        }
    }

    /// The present output for a command of 0.
    #[must_use]
    pub fn past(&self, state: &PlantState) -> f64 {
        self.output(state, 0.0)
    }

    /// The output of now, for the command of now.
    #[must_use]
    pub fn output(&self, state: &PlantState, command: f64) -> f64 {
        if let Some(finer) = &self.finer {
            return finer.output(state, command);
        }
        match (&self.kind, &state.kind) {
            (Kind::Transfer(running), KindState::Transfer(inner)) => {
                running.output(inner, self.held(state, command))
            }
            (Kind::States(states), KindState::States(inner)) => {
                let (gain, later) = self.direct;
                let past = state.commands.get(self.delay + later - 1);
                states.output(inner) + gain * past.copied().unwrap_or(0.0)
            }
            (Kind::Factors(factors, behind), KindState::Factors(decays, inner)) => {
                let last = state.commands.get(self.delay).copied().unwrap_or(0.0);
                let between = factors.output(decays, last);
                match (behind, inner) {
                    (Behind::Transfer(running), Some(inner)) => running.output(inner, between),
                    (Behind::Gain(gain), _) => gain * between,
                    _ => f64::NAN,
                }
            }
            _ => f64::NAN,
        }
    }

    /// m\[n\]
    fn held(&self, state: &PlantState, command: f64) -> f64 {
        let at = |lag: usize| match lag {
            0 => command,
            lag => state.commands.get(lag - 1).copied().unwrap_or(0.0),
        };
        let terms = self.path.iter().enumerate();
        terms.map(|(j, p)| p * at(self.delay + j)).sum()
    }

    /// Takes the command of now in.
    pub fn advance(&self, state: &mut PlantState, command: f64) {
        if let Some(finer) = &self.finer {
            for _ in 0..PARTS {
                finer.advance(state, command);
            }
            return;
        }
        let held = self.held(state, command);
        let late = |lag: usize| match lag {
            0 => command,
            lag => state.commands.get(lag - 1).copied().unwrap_or(0.0),
        };
        let (newest, last) = (late(self.delay), late(self.delay + 1));
        match (&self.kind, &mut state.kind) {
            (Kind::Transfer(running), KindState::Transfer(inner)) => running.advance(inner, held),
            (Kind::States(states), KindState::States(inner)) => states.advance(inner, newest, last),
            (Kind::Factors(factors, behind), KindState::Factors(decays, inner)) => {
                if let (Behind::Transfer(running), Some(inner)) = (behind, inner) {
                    running.advance(inner, factors.output(decays, last));
                }
                factors.advance(decays, last);
            }
            _ => {}
        }
        state.commands.rotate_right(1);
        if let Some(front) = state.commands.front_mut() {
            *front = command;
        }
    }

    /// [`output`](Self::output), then [`advance`](Self::advance).
    pub fn step(&self, state: &mut PlantState, command: f64) -> f64 {
        let y = self.output(state, command);
        self.advance(state, command);
        y
    }
}

/// w·(num₀ + w·num₁)/det in powers of v, and what is passed on at once. A factor s^n of the plant's denominator is v^n of det, which rounding
/// does not know.
fn states_fraction(in_v: StatesInV, integrators: f64, direct: f64, later: usize) -> Fraction {
    let [newest, last] = in_v.above;
    let mut denominator = in_v.below;
    let integrators = denominator.iter_mut().take(integrators as usize);
    integrators.for_each(|coefficient| *coefficient = 0.0);
    let term = |scale, numerator, delay| {
        Product::new(scale, vec![Factor::InV(numerator), Factor::Delay(delay)])
    };
    let mut above = vec![term(1.0, newest, 1), term(1.0, last, 2)];
    if direct != 0.0 {
        above.push(term(direct, denominator.clone(), later));
    }
    Fraction::new(above, vec![term(1.0, denominator, 0)])
}
