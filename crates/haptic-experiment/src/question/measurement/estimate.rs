//! From a record to the device that made it.

use super::first_guess::{first_guess, velocity};
use super::fit::{Fit, Fitted, Number, square};
use super::intervals::{GOES_ON, SIDES, Spread, goes_on};
use super::measured::{Estimate, Measured, UNSURE};
use super::record::MotionRecord;
use super::replay::{DELAY_MAX, Model, Replay, State};
use super::sensor::{deviation_m, encoder_step, noise_m};
use crate::question::measurement::keys::{
    MEASURE_BOX, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME,
};
use nalgebra::DVector;

/// A record that tells too little.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// Fewer samples than numbers.
    #[error(
        "the record has {samples} samples of the multi-sine, which is below {least}: give a longer {}",
        MEASURE_DURATION
    )]
    Short {
        /// Samples.
        samples: usize,
        /// Fewest.
        least: usize,
    },
    /// A force that is no number.
    #[error("the force of tick {tick} is {force_n} N, which is not finite: record it again")]
    NotFinite {
        /// Tick.
        tick: usize,
        /// Force.
        force_n: f64,
    },
    /// Too many samples that never came.
    #[error(
        "{lost} of {samples} samples were lost, more than 1 in 20: free the machine or the line, or give a longer {}",
        MEASURE_SAMPLE_TIME
    )]
    Lost {
        /// Lost samples.
        lost: usize,
        /// All samples.
        samples: usize,
    },
    /// Nothing moves.
    #[error(
        "the device moves too little to tell what it is: give a larger {} or a larger {}",
        MEASURE_FORCE_LIMIT,
        MEASURE_BOX
    )]
    Still,
    /// No model fits.
    #[error(
        "no mass with damping, friction, delay and lag moves like this device: see that nothing touches it and that its position is right, and give a larger {}",
        MEASURE_FORCE_LIMIT
    )]
    NoFit,
    /// An interval as wide as the number itself.
    #[error(
        "the record tells the mass to ±{percent:.0} % only: give a larger {}, a larger {} or a longer {}",
        MEASURE_FORCE_LIMIT,
        MEASURE_BOX,
        MEASURE_DURATION
    )]
    Unsure {
        /// Half the interval of the mass, %.
        percent: f64,
    },
}

/// Length of a piece of the motion with a state of its own, s, and at least so many samples. In longer ones what no model knows adds up, and so
/// does what friction makes of a wrong delay: then there is a minimum in every place. Shorter ones tell less.
const PIECE: (f64, usize) = (0.08, 40);
/// The start of a piece is looked for within this share of it, where the device is fastest.
const CHOICE: f64 = 0.4;
/// Fewest samples of the multi-sine.
const LEAST: usize = 500;
/// One sample in so many may be lost.
const LOST: usize = 20;
/// Steps of a sample in a finer model.
const PARTS: u32 = 4;
/// Shares of all that is late which are taken for lag at the starts of the search.
const LAG_SHARES: [f64; 4] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
/// From a delay of whole samples to the starts on its sides, samples.
const BESIDE: [f64; 2] = [-0.05, 0.05];
/// Residuals larger by this factor tell a worse fit from a better one.
const TELLS_APART: f64 = 1.02;
/// Residuals below it, m, are rounding and tell nothing.
const NOTHING_M: f64 = 1e-15;

/// Finds the device that made a record.
///
/// `hand` looks for the stiffness of a hand too. Intervals are those of the linearised problem, with residuals that go together for a while, and
/// hold every minimum that fits as well as the best.
/// *Cost*: some 2500 runs of the model over the record.
///
/// # Errors
/// A record that is too short, has lost too much, or does not tell the mass.
pub fn estimate(record: &MotionRecord, hand: bool) -> Result<Measured, MeasureError> {
    check(record)?;
    let start = first_guess(record, hand).ok_or(MeasureError::Still)?;
    let mut search = Search::new(record, hand).ok_or(MeasureError::Still)?;
    let starts = LAG_SHARES.map(|share| start.with_lag(share * start.delay));
    let mut minima = search.minima(&starts, !hand);
    // Friction of a device that is there turns within a sample.
    if let Some(best) = minima.first().filter(|best| goes_on(&best.left) > GOES_ON) {
        search.replay.parts = PARTS;
        let starts: Vec<Model> = minima.iter().map(|minimum| minimum.model).collect();
        let finer = search.minima(&starts, false);
        let is_better = |finer: &Fitted| square(&finer.left) < square(&best.left);
        if finer.first().is_some_and(is_better) {
            minima = finer;
        }
    }
    let told = minima.iter().filter_map(|minimum| search.told(minimum));
    let mut told: Vec<Measured> = told.collect();
    // All fit as well: the first that is sure of its mass is told, the others widen its intervals.
    told.sort_by_key(|told| told.mass_kg.relative() > UNSURE);
    let mut told = told.into_iter();
    let best = told.next().ok_or(MeasureError::NoFit)?;
    let unsure = best.mass_kg.relative();
    if unsure.is_nan() || unsure > UNSURE {
        let percent = 100.0 * unsure;
        return Err(MeasureError::Unsure { percent });
    }
    let mut measured = told.fold(best, Measured::or_as_well);
    measured.warn(record.len());
    Ok(measured)
}

/// The same device with its two time constants exchanged: m/b and that of the motor. Without friction both move alike,
/// as 1/((m·s + b)(τ·s + 1)) is 1/(b(m/b·s + 1)(τ·s + 1)).
fn exchanged(model: &Model, sample_time_s: f64) -> Option<Model> {
    let (mass, lag) = (
        model.damping * model.lag * sample_time_s,
        model.mass / model.damping / sample_time_s,
    );
    (lag < DELAY_MAX).then_some(Model {
        mass,
        lag,
        ..*model
    })
}

/// The search over one record.
struct Search<'a> {
    record: &'a MotionRecord,
    replay: Replay,
    /// About the first, at the modelled ticks, m.
    position: Vec<f64>,
    states: Vec<State>,
    hand: bool,
}

impl<'a> Search<'a> {
    fn new(record: &'a MotionRecord, hand: bool) -> Option<Self> {
        let speed = velocity(record);
        let zero = first_known(&record.position_m)?;
        let replay = Replay::new(record, starts(record, &speed)).ok()?;
        let at = |n: usize| record.position_m[n] - zero;
        Some(Self {
            position: (replay.from()..record.len()).map(at).collect(),
            states: replay.starts.iter().map(|&n| [at(n), speed[n]]).collect(),
            record,
            replay,
            hand,
        })
    }

    fn fit(&self, start: &Model) -> Option<Fitted> {
        let (replay, position) = (&self.replay, &self.position);
        let force = self.record.largest_force_n();
        Fit::new(
            replay,
            position,
            force,
            self.hand,
            start,
            self.states.clone(),
        )
        .search()
    }

    /// All minima that fit as well as the best, the best first.
    fn minima(&self, starts: &[Model], exchanges: bool) -> Vec<Fitted> {
        let rms = |fitted: &Fitted| (square(&fitted.left) / fitted.left.len() as f64).sqrt();
        let mut minima: Vec<Fitted> = Vec::new();
        let mut search = |starts: &[Model]| {
            minima.extend(starts.iter().filter_map(|start| self.fit(start)));
            minima.sort_by(|a, b| rms(a).total_cmp(&rms(b)));
            minima.first().cloned()
        };
        // A lag that may be none is not exchanged: there is no device so light.
        let has_lag = |best: &Fitted| {
            let told = self.told(best);
            told.is_some_and(|told| told.current_lag_s.low > 0.0)
        };
        search(starts)
            .filter(|best| exchanges && has_lag(best))
            .and_then(|best| exchanged(&best.model, self.record.sample_time_s))
            .and_then(|other| search(&[other]));
        // With friction the residual has an edge at a delay of whole samples.
        if let Some(best) = search(&[]).map(|best| best.model) {
            let at = |delay: f64, lag: f64| Model { delay, lag, ..best };
            let beside = BESIDE.map(|by| best.delay.round() + by);
            search(&beside.map(|delay| at(delay, best.lag)));
            // And without lag.
            search(&beside.map(|delay| at(delay, 0.0)));
        }
        let most = TELLS_APART * minima.first().map_or(0.0, rms) + NOTHING_M;
        minima.retain(|fitted| rms(fitted) <= most);
        minima
    }

    /// What a minimum says of the device.
    fn told(&self, fitted: &Fitted) -> Option<Measured> {
        let known = self.position.iter().filter(|x| x.is_finite()).count();
        let numbers = 2 * self.replay.starts.len() + fitted.numbers.len();
        let spread = Spread::of(fitted, self.replay.parts == 1)?;
        let mut measured = measured(self.record, fitted, &spread, known.saturating_sub(numbers));
        let first = self.replay.from();
        measured.curve = (self.position.iter().zip(&fitted.left).enumerate())
            .map(|(n, (read, left))| {
                let time_s = (first + n) as f64 * self.record.sample_time_s;
                [time_s, *read, read + left]
            })
            .collect();
        Some(measured)
    }
}

fn check(record: &MotionRecord) -> Result<(), MeasureError> {
    let samples = record.len().saturating_sub(record.driven_from);
    if samples < LEAST {
        return Err(MeasureError::Short {
            samples,
            least: LEAST,
        });
    }
    let lost = record.lost();
    if lost * LOST > record.len() {
        let samples = record.len();
        return Err(MeasureError::Lost { lost, samples });
    }
    let mut forces = record.force_n.iter().enumerate();
    match forces.find(|(_, force)| !force.is_finite()) {
        Some((tick, &force_n)) => Err(MeasureError::NotFinite { tick, force_n }),
        None => Ok(()),
    }
}

fn first_known(positions: &[f64]) -> Option<f64> {
    positions.iter().copied().find(|x| x.is_finite())
}

/// Starts of the pieces, each where the device is fastest near its turn: a state at rest would say nothing of its velocity.
fn starts(record: &MotionRecord, speed: &[f64]) -> Vec<usize> {
    let piece = ((PIECE.0 / record.sample_time_s) as usize).max(PIECE.1);
    let choice = (CHOICE * piece as f64) as usize;
    let last = record.len().saturating_sub(piece / 2);
    let fastest = |from: usize| {
        let there = (from..(from + choice).min(record.len()))
            .filter(|&n| speed[n].is_finite() && record.position_m[n].is_finite());
        there.max_by(|&a, &b| speed[a].abs().total_cmp(&speed[b].abs()))
    };
    (record.driven_from..last)
        .step_by(piece)
        .filter_map(fastest)
        .collect()
}

/// What is known of the sensor.
struct Sensor {
    step_m: f64,
    noise_m: Estimate,
    residual_rms_m: f64,
    /// Of rounding and of the noise at rest.
    expected_rms_m: f64,
}

impl Sensor {
    /// From the positions, and what is left of `free` of them.
    fn of(record: &MotionRecord, left: &[f64], free: usize) -> Self {
        let step = encoder_step(&record.position_m).unwrap_or_default();
        let squares: f64 = left.iter().map(|r| r * r).sum();
        let residual_rms_m = (squares / free.max(1) as f64).sqrt();
        // Steps far below all else do not count, as those of single precision on the wire.
        let counts = step > 1e-3 * residual_rms_m;
        let step_m = if counts { step } else { 0.0 };
        let [value, low, high] = noise_m(left, free, step_m, SIDES);
        let at_rest = deviation_m(&record.position_m[..record.rest.min(record.len())]);
        Self {
            step_m,
            noise_m: Estimate { value, low, high },
            residual_rms_m,
            expected_rms_m: (step_m / 12_f64.sqrt()).hypot(at_rest),
        }
    }
}

fn measured(record: &MotionRecord, fitted: &Fitted, spread: &Spread, free: usize) -> Measured {
    let t = record.sample_time_s;
    let model = &fitted.model;
    let index = |number: Number| fitted.numbers.iter().position(|known| *known == number);
    let only = |number| {
        let weight = |n: usize, _| if index(number) == Some(n) { 1.0 } else { 0.0 };
        DVector::from_fn(fitted.numbers.len(), weight)
    };
    let lag = only(Number::Lag);
    // Of what is late the delay is what the lag is not.
    let delay = only(Number::Lateness) - &lag;
    let side = |number| spread.side(&only(number));
    // A negative lag is none, and all that is late is delay.
    let lateness = model.delay + model.lag.abs();
    let delayed = (lateness - model.lag.max(0.0)).max(0.0);
    let [delay_low, delay_high] = match model.lag < 0.0 {
        true => [
            (lateness - model.lag - spread.side(&delay)).min(delayed - side(Number::Lateness)),
            delayed + side(Number::Lateness),
        ],
        false => [-1.0, 1.0].map(|sign| delayed + sign * spread.side(&delay)),
    };
    let about = |value: f64, side: f64| Estimate {
        value,
        low: (value - side).max(0.0),
        high: value + side,
    };
    let around = |number, value: f64, unit: f64| about(value, side(number) * unit);
    let factor = libm::exp(side(Number::Mass));
    let bias = side(Number::Bias);
    let sensor = Sensor::of(record, &fitted.left, free);
    Measured {
        mass_kg: Estimate {
            value: model.mass,
            low: model.mass / factor,
            high: model.mass * factor,
        },
        damping_n_s_per_m: around(Number::Damping, model.damping, 1.0),
        friction_n: around(Number::Friction, model.friction, 1.0),
        hand_stiffness_n_per_m: index(Number::Stiffness)
            .map(|_| around(Number::Stiffness, model.stiffness, 1.0)),
        delay_s: Estimate {
            value: delayed * t,
            low: delay_low.max(0.0) * t,
            high: delay_high * t,
        },
        current_lag_s: around(Number::Lag, model.lag.max(0.0) * t, t),
        encoder_resolution_m: sensor.step_m,
        sensor_noise_m: sensor.noise_m,
        bias_n: Estimate {
            value: model.bias,
            low: model.bias - bias,
            high: model.bias + bias,
        },
        breakaway_n: record.breakaway_n.map(|(up, down)| 0.5 * (up - down)),
        residual_rms_m: sensor.residual_rms_m,
        expected_residual_rms_m: sensor.expected_rms_m,
        residual_correlation: goes_on(&fitted.left),
        delay_lag_correlation: spread.correlation(&delay, &lag),
        sample_time_s: t,
        samples: fitted.left.len(),
        lost_samples: record.lost(),
        warnings: Vec::new(),
        curve: Vec::new(),
    }
}
