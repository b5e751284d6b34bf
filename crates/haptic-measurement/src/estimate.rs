//! Estimate of a device from the record that it made.
//!
//! First a guess by linear least squares on smoothed signals:
//!
//! ```text
//! û(t − D′) = m·x̂″ + b·x̂′ + F_c·sgn x̂′ + k·x̂ − w        hats: smoothed by one Gaussian, whose derivatives make x̂′ and x̂″
//! ```
//! Smoothing both sides alike leaves the equation as it is, but for the sign. D′, half a sample of the hold, the delay and the lag together, is
//! the one of a grid of half samples that leaves least. Velocities near zero are omitted. Then least squares over pieces from several lags.

use crate::{
    MEASURE_BOX, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME, MotionRecord,
    fit::{
        DELAY_MAX, Fit, Fitted, GOES_ON, Model, NO_LAG, Number, Replay, SIDES, Spread, State,
        goes_on, lag_of_square, square,
    },
};
use haptic_document::{Interval, parameters as p};
use haptic_trial::plant_file::{DeviceModel, DeviceValues};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// A record that determines too little.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// A multi-sine of too few samples.
    #[error(
        "the record has {samples} samples of the multi-sine, fewer than the {least} needed: give a longer {}",
        MEASURE_DURATION
    )]
    Short {
        /// Samples of the multi-sine in the record.
        samples: usize,
        /// Fewest samples from which a device is estimated.
        least: usize,
    },
    /// The force of a tick is NaN or infinite, so the record is not one of a loop.
    #[error("the force of tick {tick} is {force_n} N, which is not finite: record it again")]
    NotFinite {
        /// Index of the tick in the record, from 0.
        tick: usize,
        /// Force recorded there, N: NaN or infinite.
        force_n: f64,
    },
    /// Too many samples that never came.
    #[error(
        "{lost} of {samples} samples were lost, more than 1 in 20: free the machine or the line, or give a longer {}",
        MEASURE_SAMPLE_TIME
    )]
    Lost {
        /// Samples that did not come.
        lost: usize,
        /// Samples of the whole record, the lost ones included.
        samples: usize,
    },
    /// Motion too small for a model to be fitted to.
    #[error(
        "the device moves too little to be measured: give a larger {} or a larger {}",
        MEASURE_FORCE_LIMIT,
        MEASURE_BOX
    )]
    Still,
    /// A motion that is not that of such a device.
    #[error(
        "no mass with damping, friction, delay and lag moves like this device: check that nothing touches it and that its position is right, and give a larger {}",
        MEASURE_FORCE_LIMIT
    )]
    NoFit,
    /// An interval as wide as the number itself.
    #[error(
        "the record determines the mass only to ±{percent:.0} %: give a larger {}, a larger {} or a longer {}",
        MEASURE_FORCE_LIMIT,
        MEASURE_BOX,
        MEASURE_DURATION
    )]
    Unsure {
        /// Half the interval of the mass, %.
        percent: f64,
    },
}

/// Length of a piece of the motion with a state of its own, s, and its least number of samples. In longer ones unmodelled motion adds up, and so
/// does the effect of friction with a wrong delay: then every place has a minimum. Shorter ones determine less.
const PIECE: (f64, usize) = (0.08, 40);
/// The start of a piece is looked for within this share of it, where the device is fastest.
const CHOICE: f64 = 0.4;
/// Fewest samples of the multi-sine.
const LEAST: usize = 500;
/// One sample in this number may be lost.
const LOST: usize = 20;
/// Steps of a sample in a finer model.
const PARTS: u32 = 4;
/// Shares of all that is late which are taken for lag at the starts of the search.
const LAG_SHARES: [f64; 4] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
/// Distances from a delay of whole samples to the starts on its sides, samples.
const BESIDE: [f64; 2] = [-0.05, 0.05];
/// Factor by which the residual of a worse fit is larger.
const TELLS_APART: f64 = 1.02;
/// Residuals below it, m, are rounding errors.
const NOTHING_M: f64 = 1e-15;
/// Improvement of the fit, m, that justifies a motor slower than the mass: far below any sensor, far above rounding.
const UNEXPECTED_M: f64 = 1e-9;

/// Finds the device that made a record.
///
/// `hand` estimates the stiffness of a hand too. Intervals are those of the linearised problem, with autocorrelated residuals, and
/// include every minimum that fits equally well.
/// *Cost*: some 2500 runs of the model over the record.
///
/// # Errors
/// A record that says too little, or nothing that such a device does.
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
    let candidates = minima
        .iter()
        .filter_map(|minimum| search.measured_at(minimum));
    let mut candidates: Vec<Measured> = candidates.collect();
    // All fit equally well: the first with a certain mass is reported, the others widen its intervals.
    candidates.sort_by_key(|candidate| candidate.mass_kg.relative() > UNSURE);
    let mut candidates = candidates.into_iter();
    let best = candidates.next().ok_or(MeasureError::NoFit)?;
    let unsure = best.mass_kg.relative();
    if unsure.is_nan() || unsure > UNSURE {
        let percent = 100.0 * unsure;
        return Err(MeasureError::Unsure { percent });
    }
    let mut measured = candidates.fold(best, Measured::or_as_well);
    measured.warn(record.len());
    Ok(measured)
}

/// The device with its two time constants exchanged: m/b and that of the motor. Without friction both move alike,
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
        let speed = smoothed(record).v;
        let zero = record.position_m.iter().find(|x| x.is_finite())?;
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
        let t = self.record.sample_time_s;
        // Of a lag beyond m/b: a motor slower than its mass is the last that one expects.
        let is_slow = |Model {
                           mass, damping, lag, ..
                       }: &Model| damping * lag * t > *mass;
        let rms = |fitted: &Fitted| {
            let unexpected = if is_slow(&fitted.model) {
                UNEXPECTED_M
            } else {
                0.0
            };
            (square(&fitted.left) / fitted.left.len() as f64).sqrt() + unexpected
        };
        let mut minima: Vec<Fitted> = Vec::new();
        let mut search = |starts: &[Model]| {
            minima.extend(starts.iter().filter_map(|start| self.fit(start)));
            minima.sort_by(|a, b| rms(a).total_cmp(&rms(b)));
            minima.first().cloned()
        };
        // A lag that may be zero is not exchanged: no device is so light.
        let has_lag = |best: &Fitted| {
            let measured = self.measured_at(best);
            is_slow(&best.model)
                || measured.is_some_and(|measured| measured.current_lag_s.low > 0.0)
        };
        search(starts)
            .filter(|best| exchanges && has_lag(best))
            .and_then(|best| exchanged(&best.model, t))
            .and_then(|other| search(&[other]));
        // With friction the residual has an edge at a delay of whole samples.
        if let Some(best) = search(&[]).map(|best| best.model) {
            let at = |delay: f64, lag: f64| Model { delay, lag, ..best };
            let delays = BESIDE.map(|by| best.delay.round() + by);
            search(&delays.map(|delay| at(delay, best.lag)));
            // And without lag.
            search(&delays.map(|delay| at(delay, 0.0)));
        }
        let most = TELLS_APART * minima.first().map_or(0.0, rms) + NOTHING_M;
        minima.retain(|fitted| rms(fitted) <= most);
        minima
    }

    /// Estimates of the device at a minimum.
    fn measured_at(&self, fitted: &Fitted) -> Option<Measured> {
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

/// Starts of the pieces, each where the device is fastest near its turn: a state at rest would say nothing of its velocity.
fn starts(record: &MotionRecord, speed: &[f64]) -> Vec<usize> {
    let piece = ((PIECE.0 / record.sample_time_s) as usize).max(PIECE.1);
    let choice = (CHOICE * piece as f64) as usize;
    let last = record.len().saturating_sub(piece / 2);
    let fastest = |from: usize| {
        let window = (from..(from + choice).min(record.len()))
            .filter(|&n| speed[n].is_finite() && record.position_m[n].is_finite());
        window.max_by(|&a, &b| speed[a].abs().total_cmp(&speed[b].abs()))
    };
    (record.driven_from..last)
        .step_by(piece)
        .filter_map(fastest)
        .collect()
}

fn measured(record: &MotionRecord, fitted: &Fitted, spread: &Spread, free: usize) -> Measured {
    let t = record.sample_time_s;
    let model = &fitted.model;
    let index = |number: Number| fitted.numbers.iter().position(|known| *known == number);
    let only = |number| {
        let weight = |n: usize, _| if index(number) == Some(n) { 1.0 } else { 0.0 };
        DVector::from_fn(fitted.numbers.len(), weight)
    };
    let side = |number| spread.side(&only(number));
    let wide = side(Number::SquareOfLag);
    let lags = [-wide, wide].map(|by| lag_of_square(model.square_of_lag() + by));
    // The chord over the interval, as the root has no slope at 0.
    let slope = if wide > 0.0 {
        (lags[1] - lags[0]) / (2.0 * wide)
    } else {
        0.0
    };
    let lag = only(Number::SquareOfLag) * slope;
    // Of what is late the delay is what the lag is not.
    let delay = only(Number::Lateness) - &lag;
    // A negative lag counts as 0, and the whole lateness as delay.
    let lateness = model.delay + model.lag.abs();
    let delayed = (lateness - model.lag.max(0.0)).max(0.0);
    let [delay_low, delay_high] = if model.lag < 0.0 {
        [
            (lateness - model.lag - spread.side(&delay)).min(delayed - side(Number::Lateness)),
            delayed + side(Number::Lateness),
        ]
    } else {
        [-1.0, 1.0].map(|sign| delayed + sign * spread.side(&delay))
    };
    let about = |value: f64, side: f64| MeasuredNumber {
        value,
        low: value - side,
        high: value + side,
    };
    let around = |number, value: f64, unit: f64| {
        let about = about(value, side(number) * unit);
        let low = about.low.max(0.0);
        MeasuredNumber { low, ..about }
    };
    let factor = libm::exp(side(Number::Mass));
    let residual_rms_m = (square(&fitted.left) / free.max(1) as f64).sqrt();
    // Steps far below all else do not count, as those of single precision on the wire.
    let step_m = encoder_step(&record.position_m)
        .filter(|step_m| *step_m > 1e-3 * residual_rms_m)
        .unwrap_or(0.0);
    let at_rest_m = deviation_m(&record.position_m[..record.rest.min(record.len())]);
    Measured {
        mass_kg: MeasuredNumber {
            value: model.mass,
            low: model.mass / factor,
            high: model.mass * factor,
        },
        damping_n_s_per_m: around(Number::Damping, model.damping, 1.0),
        friction_n: around(Number::Friction, model.friction, 1.0),
        hand_stiffness_n_per_m: index(Number::Stiffness)
            .map(|_| around(Number::Stiffness, model.stiffness, 1.0)),
        delay_s: MeasuredNumber {
            value: delayed * t,
            low: delay_low.max(0.0) * t,
            high: delay_high * t,
        },
        current_lag_s: MeasuredNumber {
            value: model.lag.max(0.0) * t,
            low: if lags[0] > NO_LAG { lags[0] * t } else { 0.0 },
            high: lags[1].max(0.0) * t,
        },
        encoder_resolution_m: step_m,
        sensor_noise_m: noise_m(&fitted.left, free, step_m),
        bias_n: about(model.bias, side(Number::Bias)),
        breakaway_n: record.breakaway_n.map(|(up, down)| 0.5 * (up - down)),
        residual_rms_m,
        expected_residual_rms_m: libm::hypot(step_m / 12_f64.sqrt(), at_rest_m),
        residual_correlation: goes_on(&fitted.left),
        delay_lag_correlation: spread.correlation(&delay, &lag),
        sample_time_s: t,
        samples: fitted.left.len(),
        lost_samples: record.lost(),
        warnings: Vec::new(),
        curve: Vec::new(),
    }
}

/// Width of the Gaussian, s, and its least number of samples.
const SMOOTH: (f64, f64) = (2.5e-3, 2.0);
/// Slower than this share of the rms velocity counts as near zero.
const SLOW: f64 = 0.15;

/// Smoothed position, velocity and acceleration, and the smoothed force; not a number where a sample is missing.
struct Smoothed {
    x: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
}

fn smoothed(record: &MotionRecord) -> Smoothed {
    let t = record.sample_time_s;
    let width = f64::max(SMOOTH.0 / t, SMOOTH.1);
    let reach = (4.0 * width).ceil() as isize;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|i| libm::exp(-0.5 * (i as f64 / width) * (i as f64 / width)))
        .collect();
    let sum: f64 = weights.iter().sum();
    let at = |signal: &[f64], n: usize, weight: &dyn Fn(f64) -> f64| -> f64 {
        let mut total = 0.0;
        for (g, i) in weights.iter().zip(-reach..=reach) {
            let Some(value) = n.checked_add_signed(i).and_then(|n| signal.get(n)) else {
                return f64::NAN;
            };
            // Σ y[n + i]·w(i): the derivative of a Gaussian about n.
            total += g / sum * weight(i as f64) * value;
        }
        total
    };
    let square = width * width;
    let all = |signal: &[f64], weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..record.len()).map(|n| at(signal, n, weight)).collect()
    };
    Smoothed {
        x: all(&record.position_m, &|_| 1.0),
        v: all(&record.position_m, &|i| i / square / t),
        a: all(&record.position_m, &|i| {
            (i * i / square - 1.0) / square / (t * t)
        }),
        u: all(&record.force_n, &|_| 1.0),
    }
}

/// The model with which the search begins, all that is late in it taken for delay; `None` if nothing moves.
fn first_guess(record: &MotionRecord, hand: bool) -> Option<Model> {
    let signals = smoothed(record);
    let from = record.driven_from + DELAY_MAX as usize;
    let moving = || (from..record.len()).filter(|&n| signals.a[n].is_finite());
    let count = moving().count();
    let rms = (moving().map(|n| signals.v[n] * signals.v[n]).sum::<f64>() / count as f64).sqrt();
    let rows: Vec<usize> = moving()
        .filter(|&n| signals.v[n].abs() > SLOW * rms)
        .collect();
    if rows.len() < 50 || rms <= 0.0 {
        return None;
    }
    let columns = if hand { 5 } else { 4 };
    let matrix = DMatrix::from_fn(rows.len(), columns, |row, column| {
        let n = rows[row];
        match column {
            0 => signals.a[n],
            1 => signals.v[n],
            2 => signals.v[n].signum(),
            3 => -1.0,
            _ => signals.x[n],
        }
    });
    let normal = (matrix.transpose() * &matrix).try_inverse()?;
    let project = normal * matrix.transpose();
    let mut best: Option<(f64, f64, DVector<f64>)> = None;
    // Half samples, from that of the hold on.
    for half in 1..=(2.0 * DELAY_MAX) as usize {
        let earlier = |n: usize| {
            let (whole, odd) = (half / 2, half % 2);
            let u = |back: usize| signals.u[n - back];
            if odd == 0 {
                u(whole)
            } else {
                0.5 * (u(whole) + u(whole + 1))
            }
        };
        let forces = DVector::from_iterator(rows.len(), rows.iter().map(|&n| earlier(n)));
        let found = &project * &forces;
        let left = (forces - &matrix * &found).norm_squared();
        if left.is_finite() && best.as_ref().is_none_or(|(least, ..)| left < *least) {
            best = Some((left, 0.5 * half as f64, found));
        }
    }
    let (_, delay, found) = best?;
    Some(Model {
        mass: found[0].max(1e-6),
        damping: found[1].max(1e-3),
        friction: found[2].max(0.0),
        bias: found[3],
        delay: f64::max(delay - 0.5, 0.1),
        lag: 0.0,
        stiffness: found.get(4).map_or(0.0, |k| k.max(0.0)),
    })
}

/// Steps are whole multiples of the smallest one within this share of it.
const WHOLE: f64 = 0.05;
/// Differences below this are rounding, m.
const ROUNDING_M: f64 = 1e-12;
/// Number of levels below which steps are not reported.
const LEVELS: usize = 5;

/// q: the step of which all differences of positions are multiples, m; `None` if they have none.
///
/// The smallest difference of two positions is the first guess. Counting the levels up from the lowest, all differences must be whole multiples of
/// it; the way from the lowest to the highest level, divided by the count, is q. *Cost*: a sort.
fn encoder_step(positions_m: &[f64]) -> Option<f64> {
    let mut levels: Vec<f64> = positions_m
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() < ROUNDING_M);
    let (lowest, highest) = (levels.first()?, levels.last()?);
    if levels.len() < LEVELS {
        return None;
    }
    let gaps = || levels.windows(2).map(|pair| pair[1] - pair[0]);
    let smallest = gaps().fold(f64::INFINITY, f64::min);
    let mut count = 0.0;
    for gap in gaps() {
        let steps = gap / smallest;
        if (steps - steps.round()).abs() > WHOLE * steps.round().clamp(1.0, 3.0) {
            return None;
        }
        count += steps.round();
    }
    Some((highest - lowest) / count)
}

/// Noise besides the rounding to steps of q, from the residual of a fit: value, low and high, m.
///
/// ```text
/// σ² = mean r² − q²/12        its error by blocks of the record
/// ```
fn noise_m(left: &[f64], free: usize, step_m: f64) -> MeasuredNumber {
    let variance = square(left) / free.max(1) as f64;
    let block = (left.len() / 40).max(10);
    let blocks = left.chunks(block);
    let means: Vec<f64> = blocks
        .map(|block| square(block) / block.len() as f64)
        .collect();
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let spread = means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>();
    let error = (spread / (count * (count - 1.0).max(1.0))).sqrt();
    let rounding = step_m * step_m / 12.0;
    let variance_left = (variance - rounding).max(0.0);
    let [value, low, high] = [
        variance_left,
        variance_left - SIDES * error,
        variance_left + SIDES * error,
    ]
    .map(|variance| variance.max(0.0).sqrt());
    MeasuredNumber { value, low, high }
}

/// Standard deviation, m; 0 of fewer than two.
fn deviation_m(positions_m: &[f64]) -> f64 {
    let known: Vec<f64> = positions_m
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .collect();
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    let squares = known.iter().map(|x| (x - mean) * (x - mean));
    (squares.sum::<f64>() / (known.len().max(2) - 1) as f64).sqrt()
}

/// Largest half-width of the mass's interval, relative to the mass, that counts as an answer.
const UNSURE: f64 = 0.5;
/// Ratio of residual to sensor noise above which a warning is given.
const UNEXPLAINED: f64 = 2.0;
/// Residuals below it, m, give no warning, whatever the sensor explains: finer than the sensor of a desktop device.
const UNNOTICED_M: f64 = 1e-7;
/// One lost sample in this number gives a warning.
const LOST_NOTABLE: usize = 1000;

pub(super) use haptic_trial::plant_file::calibration::MeasuredNumber;

/// A device as estimated from a record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// m.
    pub mass_kg: MeasuredNumber,
    /// b.
    pub damping_n_s_per_m: MeasuredNumber,
    /// `F_c`, while it slides.
    pub friction_n: MeasuredNumber,
    /// k of a hand; `None` if there was none.
    pub hand_stiffness_n_per_m: Option<MeasuredNumber>,
    /// D: delay from a measurement to the force that answers it, beyond the hold.
    pub delay_s: MeasuredNumber,
    /// τ, by which the current follows its command.
    pub current_lag_s: MeasuredNumber,
    /// q; 0 if no steps were detected.
    pub encoder_resolution_m: f64,
    /// σ: noise of the position, without the rounding to steps but with everything that the model
    /// does not explain.
    pub sensor_noise_m: MeasuredNumber,
    /// w: a constant force, such as from a slope or a cable.
    pub bias_n: MeasuredNumber,
    /// Half the difference between the forces at which it began to move upwards and downwards: an
    /// upper bound of the friction at rest.
    pub breakaway_n: Option<f64>,
    /// Root mean square of model minus record.
    pub residual_rms_m: f64,
    /// The part of the residual that rounding and the noise at rest explain.
    pub expected_residual_rms_m: f64,
    /// Correlation of successive residuals: near 0 unless the model is off.
    pub residual_correlation: f64,
    /// Correlation of delay and lag, −1 to 1.
    pub delay_lag_correlation: f64,
    /// Sample time of the record.
    pub sample_time_s: f64,
    /// Number of ticks.
    pub samples: usize,
    /// Those of which no position came.
    pub lost_samples: usize,
    /// Facts that a user should know.
    pub warnings: Vec<String>,
    /// Time since the start, s, position read and position of the model, m, of each fitted tick.
    #[serde(skip)]
    pub curve: Vec<[f64; 3]>,
}

/// Masses that differ by this factor are those of two devices that move alike.
const APART: f64 = 1.1;

impl Measured {
    /// This device, and another one that fits equally well: intervals wide enough for both. If their masses differ, the device with the
    /// faster motor is reported.
    fn or_as_well(self, other: Self) -> Self {
        let (mut found, mut other) = (self, other);
        let ratio = other.mass_kg.value / found.mass_kg.value;
        if !(1.0 / APART..=APART).contains(&ratio) {
            if other.current_lag_s.value < found.current_lag_s.value {
                std::mem::swap(&mut found, &mut other);
            }
            found.warnings = vec![format!(
                "mass and current lag cannot be told apart: {:.3} g and {:.3} ms fit as well as {:.3} g and {:.3} ms; add a known mass",
                1e3 * found.mass_kg.value,
                1e3 * found.current_lag_s.value,
                1e3 * other.mass_kg.value,
                1e3 * other.current_lag_s.value
            )];
        }
        let hands = (found.hand_stiffness_n_per_m.iter_mut()).zip(&other.hand_stiffness_n_per_m);
        let numbers = [
            (&mut found.mass_kg, &other.mass_kg),
            (&mut found.current_lag_s, &other.current_lag_s),
            (&mut found.delay_s, &other.delay_s),
            (&mut found.damping_n_s_per_m, &other.damping_n_s_per_m),
            (&mut found.friction_n, &other.friction_n),
            (&mut found.bias_n, &other.bias_n),
        ];
        for (ours, theirs) in hands.chain(numbers) {
            ours.low = ours.low.min(theirs.low);
            ours.high = ours.high.max(theirs.high);
        }
        found
    }

    /// Adds warnings for the user. `ticks` are those of the whole record.
    fn warn(&mut self, ticks: usize) {
        let lost = self.lost_samples;
        if lost * LOST_NOTABLE >= ticks && lost > 0 {
            self.warnings.push(format!(
                "{lost} of {ticks} samples were lost: free the machine or the line, or lengthen {MEASURE_SAMPLE_TIME}"
            ));
        }
        let (left, expected) = (self.residual_rms_m, self.expected_residual_rms_m);
        // Sensor noise is not autocorrelated.
        let sensed = left * (1.0 - self.residual_correlation.clamp(0.0, 1.0)).sqrt();
        let unexplained = left > UNEXPLAINED * expected || self.residual_correlation > GOES_ON;
        if unexplained && left > UNNOTICED_M {
            self.warnings.push(format!(
                "the model is off by {:.3} µm rms, of which the sensor explains {:.3} µm: play, or lost frames",
                1e6 * left,
                1e6 * expected.min(sensed)
            ));
        }
        // Intervals about as wide as their value; one of the mass is refused. A delay or lag much shorter than a sample, and a friction far
        // below that at rest, may be as unsure as they like.
        let wide =
            |number: &MeasuredNumber, scale: f64| 0.5 * (number.high - number.low) > UNSURE * scale;
        let sample_s = self.sample_time_s;
        let at_rest_n = self.breakaway_n.unwrap_or(f64::INFINITY);
        let (damping, friction) = (&self.damping_n_s_per_m, &self.friction_n);
        let (delay, lag) = (&self.delay_s, &self.current_lag_s);
        for (what, number, counts) in [
            ("damping", damping, damping.value > 0.0),
            ("friction", friction, wide(friction, at_rest_n)),
            ("delay", delay, wide(delay, sample_s)),
            ("current lag", lag, lag.low > 0.0 || wide(lag, sample_s)),
        ] {
            let relative = number.relative();
            if counts && (relative > UNSURE || relative.is_nan()) {
                let known = if relative.is_finite() && relative < 10.0 {
                    format!("to ±{:.0} % only", 100.0 * relative)
                } else {
                    "not at all".to_owned()
                };
                self.warnings.push(format!(
                    "the {what} is known {known}: a larger {MEASURE_FORCE_LIMIT}, a larger {MEASURE_BOX} or a longer {MEASURE_DURATION} tells more"
                ));
            }
        }
    }
}

impl Measured {
    /// Widens what a force is in by the interval of the motor's factor, whose likeliest value the forces have in them already.
    pub fn by_newtons_of(&mut self, motor: MeasuredNumber) {
        let factor = motor.times(MeasuredNumber::about(1.0 / motor.value, 0.0));
        let of_force = [
            &mut self.mass_kg,
            &mut self.damping_n_s_per_m,
            &mut self.friction_n,
        ];
        for known in of_force.into_iter().chain(&mut self.hand_stiffness_n_per_m) {
            *known = known.times(factor);
        }
    }
}

/// A device that was measured.
pub fn device_model(found: &Measured) -> DeviceModel {
    let six = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
    let estimates = [
        (&p::MASS, Some(found.mass_kg)),
        (&p::DAMPING, Some(found.damping_n_s_per_m)),
        (&p::HAND_STIFFNESS, found.hand_stiffness_n_per_m),
        (&p::DELAY, Some(found.delay_s)),
        (&p::CURRENT_LAG, Some(found.current_lag_s)),
        (&p::FRICTION, Some(found.friction_n)),
        (&p::SENSOR_NOISE, Some(found.sensor_noise_m)),
    ];
    let (mut values, mut intervals) = (DeviceValues::default(), Vec::new());
    values.set(&p::ENCODER_RESOLUTION, six(found.encoder_resolution_m));
    for (parameter, estimate) in estimates {
        if let Some(MeasuredNumber { value, low, high }) = estimate {
            values.set(parameter, six(value));
            intervals.push(Interval {
                key: parameter.key,
                low: six(low),
                high: six(high),
            });
        }
    }
    DeviceModel {
        values,
        intervals,
        calibration: None,
    }
}

#[cfg(test)]
mod tests {
    use crate::estimate::*;

    #[test]
    fn steps_are_found_where_there_are_steps_alone() {
        let wave = |n: usize| 1.7e-3 * (0.037 * n as f64).sin() + 3e-4 * (0.011 * n as f64).cos();
        let smooth: Vec<f64> = (0..5000).map(wave).collect();
        assert_eq!(encoder_step(&smooth), None);
        for step in [1e-6, 1e-5, 3.3e-5] {
            let rounded: Vec<f64> = smooth.iter().map(|x| (x / step).round() * step).collect();
            let found = encoder_step(&rounded).expect("has steps");
            assert!((found / step - 1.0).abs() < 1e-9, "{found} for {step}");
            // As they come over the wire.
            let single: Vec<f64> = rounded.iter().map(|x| f64::from(*x as f32)).collect();
            let found = encoder_step(&single).expect("has steps");
            assert!((found / step - 1.0).abs() < 1e-3, "{found} for {step}");
        }
        assert_eq!(encoder_step(&[0.0; 100]), None);
    }

    #[test]
    fn the_noise_is_what_rounding_does_not_explain() {
        // ±1 and ±3 alternate: the variance is 5.
        let left: Vec<f64> = (0..4000).map(|n| [1.0, -1.0, 3.0, -3.0][n % 4]).collect();
        let MeasuredNumber { value, low, high } = noise_m(&left, left.len(), 0.0);
        assert!((value - 5_f64.sqrt()).abs() < 1e-12);
        assert!(low <= value && value <= high);
        let MeasuredNumber { value, .. } = noise_m(&left, left.len(), 12_f64.sqrt());
        assert!((value - 2.0).abs() < 1e-12);
        assert!(deviation_m(&[1.0, f64::NAN, 3.0]) - 2_f64.sqrt() < 1e-12);
    }

    fn about(value: f64, half: f64) -> MeasuredNumber {
        MeasuredNumber {
            value,
            low: (value - half).max(0.0),
            high: value + half,
        }
    }

    /// A device that was measured well.
    fn sound() -> Measured {
        Measured {
            mass_kg: about(0.065, 1e-4),
            damping_n_s_per_m: about(3.5, 0.01),
            friction_n: about(0.05, 1e-3),
            hand_stiffness_n_per_m: None,
            delay_s: about(1e-3, 1e-5),
            current_lag_s: about(0.0, 1e-4),
            encoder_resolution_m: 1e-5,
            sensor_noise_m: about(0.0, 1e-7),
            bias_n: about(0.0, 1e-3),
            breakaway_n: Some(0.06),
            residual_rms_m: 3e-6,
            expected_residual_rms_m: 2.9e-6,
            residual_correlation: 0.0,
            delay_lag_correlation: 0.0,
            sample_time_s: 1e-3,
            samples: 8000,
            lost_samples: 0,
            warnings: Vec::new(),
            curve: Vec::new(),
        }
    }

    type Defect = fn(&mut Measured);

    fn warnings(change: impl Fn(&mut Measured)) -> Vec<String> {
        let mut found = sound();
        change(&mut found);
        found.warn(10_000);
        found.warnings
    }

    #[test]
    fn a_sound_measurement_has_no_warnings_and_each_defect_has_one() {
        assert_eq!(warnings(|found| found.lost_samples = 9), [""; 0]);
        // Residuals of the arithmetic, where the sensor explains nothing.
        let exact = |found: &mut Measured| {
            (found.residual_rms_m, found.expected_residual_rms_m) = (1e-9, 0.0);
        };
        assert_eq!(warnings(exact), [""; 0]);
        let defects: [(&str, Defect); 8] = [
            ("10 of 10000 samples were lost", |found| {
                found.lost_samples = 10;
            }),
            (
                "off by 107.700 µm rms, of which the sensor explains 0.000",
                |found| {
                    (found.residual_rms_m, found.expected_residual_rms_m) = (107.7e-6, 0.0);
                },
            ),
            ("off by 9.000 µm", |found| found.residual_rms_m = 9e-6),
            ("off by 3.000 µm", |found| {
                found.residual_correlation = 0.06;
            }),
            ("the delay is known not at all", |found| {
                found.delay_s = about(1e-3, 1.47);
            }),
            ("the delay is known to ±60 %", |found| {
                found.delay_s = MeasuredNumber {
                    value: 1e-3,
                    low: 0.4e-3,
                    high: 1.6e-3,
                };
            }),
            ("the current lag is known not at all", |found| {
                found.current_lag_s = about(0.0, 2e-3);
            }),
            ("the friction is known not at all", |found| {
                found.friction_n = about(1e-3, 0.07);
            }),
        ];
        for (words, change) in defects {
            let warnings = warnings(change);
            assert!(
                warnings.len() == 1 && warnings[0].contains(words),
                "{words}: {warnings:?}"
            );
        }
    }
}
