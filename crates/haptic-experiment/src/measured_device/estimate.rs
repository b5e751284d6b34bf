//! From a record to the device that made it.

use super::first_guess::{first_guess, velocity};
use super::fit::{Fit, Fitted, Number};
use super::intervals::{SIDES, Spread};
use super::measured::{Estimate, Measured, UNSURE};
use super::record::MotionRecord;
use super::replay::{DELAY_MAX, Model, Replay, State};
use super::sensor::{deviation_m, encoder_step, noise_m};

/// A record that tells too little.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// Fewer samples than numbers.
    #[error(
        "the record has {samples} samples of the multi-sine, which is below {least}: give a longer `duration_s`"
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
        "{lost} of {samples} samples were lost, more than 1 in 20: free the machine or the line, or give a longer `sample_time_s`"
    )]
    Lost {
        /// Lost samples.
        lost: usize,
        /// All samples.
        samples: usize,
    },
    /// Nothing moves.
    #[error(
        "the device moves too little to tell what it is: give a larger `force_limit_n` or a larger `box_m`"
    )]
    Still,
    /// No model fits.
    #[error(
        "no mass with damping, friction, delay and lag moves like this device: see that nothing touches it and that its position is right, and give a larger `force_limit_n`"
    )]
    NoFit,
    /// An interval as wide as the number itself.
    #[error(
        "the record tells the mass to ±{percent:.0} % only: give a larger `force_limit_n`, a larger `box_m` or a longer `duration_s`"
    )]
    Unsure {
        /// Half the interval of the mass, %.
        percent: f64,
    },
}

/// Lengths of a piece of the motion with a state of its own, s: short ones find their way from a poor guess, long ones tell more.
const PIECES_S: [f64; 3] = [0.08, 0.25, 0.5];
/// The start of a piece is looked for within this share of it, where the device is fastest.
const CHOICE: f64 = 0.4;
/// A residual that grows by this factor with longer pieces is no noise of the sensor.
const GATHERS: f64 = 1.05;
/// Fewest samples of the multi-sine.
const LEAST: usize = 500;
/// One sample in so many may be lost.
const LOST: usize = 20;
/// Finds the device that made a record.
///
/// `hand` looks for the stiffness of a hand too. Intervals are those of the linearised problem, with residuals that go together for a while.
/// *Cost*: some 300 runs of the model over the record.
///
/// # Errors
/// A record that is too short, has lost too much, or does not tell the mass.
pub fn estimate(record: &MotionRecord, hand: bool) -> Result<Measured, MeasureError> {
    check(record)?;
    let start = first_guess(record, hand).ok_or(MeasureError::Still)?;
    let search = Search {
        record,
        speed: &velocity(record),
        zero: first_known(&record.position_m).ok_or(MeasureError::Still)?,
        hand,
    };
    let mut model = start;
    let mut best: Option<(f64, Measured)> = None;
    for piece_s in PIECES_S {
        let Some((found, measured)) = search.with_pieces(piece_s, &model) else {
            continue;
        };
        let rms = measured.residual_rms_m;
        // Longer pieces tell more, unless they gather what no model knows.
        if best
            .as_ref()
            .is_none_or(|(_, before)| rms < GATHERS * before.residual_rms_m)
        {
            model = found;
            best = Some((piece_s, measured));
        }
    }
    let (piece_s, measured) = best.ok_or(MeasureError::NoFit)?;
    let measured = match exchanged(&model, record.sample_time_s) {
        Some(other) if !hand => match search.with_pieces(piece_s, &other) {
            Some((_, other)) => measured.or_exchanged(other),
            None => measured,
        },
        _ => measured,
    };
    let unsure = measured.mass_kg.relative();
    if unsure.is_nan() || unsure > UNSURE {
        let percent = 100.0 * unsure;
        return Err(MeasureError::Unsure { percent });
    }
    Ok(measured)
}

/// The same device with its two time constants exchanged: m/b and that of the motor. Without friction both move alike,
/// as 1/((m·s + b)(τ·s + 1)) is 1/(b(m/b·s + 1)(τ·s + 1)).
fn exchanged(model: &Model, sample_time_s: f64) -> Option<Model> {
    let (mass, lag) = (
        model.damping * model.lag * sample_time_s,
        model.mass / model.damping / sample_time_s,
    );
    (mass > 0.0 && lag < DELAY_MAX).then_some(Model {
        mass,
        lag,
        ..*model
    })
}

/// The search over one record.
struct Search<'a> {
    record: &'a MotionRecord,
    speed: &'a [f64],
    /// Position that counts as zero, m.
    zero: f64,
    hand: bool,
}

impl Search<'_> {
    /// The model that fits best with pieces of this length, from a first one.
    fn with_pieces(&self, piece_s: f64, start: &Model) -> Option<(Model, Measured)> {
        let Self {
            record,
            speed,
            zero,
            hand,
        } = *self;
        let replay = Replay::new(record, starts(record, speed, piece_s)).ok()?;
        let first = replay.from();
        let position: Vec<f64> = record.position_m[first..record.len()]
            .iter()
            .map(|x| x - zero)
            .collect();
        let states: Vec<State> = (replay.starts.iter())
            .map(|&n| [record.position_m[n] - zero, speed[n]])
            .collect();
        let force = record.largest_force_n();
        let fitted = Fit::new(&replay, &position, force, hand, start, states).search()?;
        let known = position.iter().filter(|x| x.is_finite()).count();
        let fixed = 2 * replay.starts.len();
        let spread = Spread::of(&fitted, record.sample_time_s, known, fixed)?;
        let free = known.saturating_sub(fixed + fitted.numbers.len());
        let mut measured = measured(record, &fitted, &spread, free);
        measured.curve = (position.iter().zip(&fitted.left).enumerate())
            .map(|(n, (read, left))| {
                let time_s = (first + n) as f64 * record.sample_time_s;
                [time_s, *read, read + left]
            })
            .collect();
        Some((fitted.model, measured))
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
fn starts(record: &MotionRecord, speed: &[f64], piece_s: f64) -> Vec<usize> {
    let ticks = |time_s: f64| ((time_s / record.sample_time_s) as usize).max(1);
    let (piece, choice) = (ticks(piece_s), ticks(CHOICE * piece_s));
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
    let side = |number| SIDES * index(number).map_or(f64::INFINITY, |n| spread.error(n));
    let around = |number, value: f64, unit: f64| {
        let side = side(number) * unit;
        Estimate {
            value,
            low: (value - side).max(0.0),
            high: value + side,
        }
    };
    let factor = libm::exp(side(Number::Mass));
    let bias = side(Number::Bias);
    let sensor = Sensor::of(record, &fitted.left, free);
    let correlation = index(Number::Delay)
        .zip(index(Number::Lag))
        .map_or(0.0, |(delay, lag)| spread.correlation(delay, lag));
    let mut measured = Measured {
        mass_kg: Estimate {
            value: model.mass,
            low: model.mass / factor,
            high: model.mass * factor,
        },
        damping_n_s_per_m: around(Number::Damping, model.damping, 1.0),
        friction_n: around(Number::Friction, model.friction, 1.0),
        hand_stiffness_n_per_m: index(Number::Stiffness)
            .map(|_| around(Number::Stiffness, model.stiffness, 1.0)),
        delay_s: around(Number::Delay, model.delay * t, t),
        current_lag_s: around(Number::Lag, model.lag * t, t),
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
        delay_lag_correlation: correlation,
        sample_time_s: t,
        samples: fitted.left.len(),
        lost_samples: record.lost(),
        warnings: Vec::new(),
        curve: Vec::new(),
    };
    measured.warn(record.len());
    measured
}
