//! A newton of a device at hand, checked against a kitchen scale, a spring balance or a hung weight.
//!
//! ```text
//! F = g·u ∓ F_c        u commanded, N; F on the instrument, N; F_c friction: − while the force rises, + while it falls
//! F = s·(r − r₀)       r shown by the device's force sensor, N
//! ```
//! - *Sign* first: the free handle must go with its force.
//! - *Scale or balance*: a person reads three forces on the way up and two on the way down. *Weight*: without it and with it the force
//!   grows until the handle lifts, and falls until it sinks, three times; nobody reads anything.
//! - *g* is the slope, the same on both ways, so that friction is between them and not in it. Its interval has the scatter about both
//!   lines by Student's t, and the step of the instrument at its worst. A reading that friction held where it was is no part. Where no scatter is
//!   known, friction widens it at its worst.
//! - *Lag* of the sensor: four slow sines on the scale, whose spring shows the force by its way. The slope of the phase between way and
//!   sensor over the frequency is the lag: delay and lag of the motor are not in it, nor are friction and damping of the handle.

mod answer;
mod conduct;
mod line;

use crate::document::failure::Failure;
use crate::document::parameters::kind::{Parameter, parameters};
use crate::document::parameters::range::{FORCE_LIMITS, Range};
use crate::document::parameters::{DEVICE_MODEL, MAX_AGE_TICKS, WATCHDOG};
use crate::question::measurement::drive::INTERRUPTED;
use crate::question::measurement::{MEASURE_AXIS, MEASURE_DEVICE, MEASURE_SAMPLE_TIME};
pub use answer::{CalibrationReport, Calibrator};
use haptic_quantity::written;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::Poll;
use std::time::Duration;

parameters! {
    CALIBRATE_FORCE = number("force_limit_n", 2.0, "2N", FORCE_LIMITS, "Largest commanded force");
    CALIBRATE_BOX = number("box_m", 0.05, "50mm", Range::Within(1e-4, 1.0), "Largest distance from the start; beyond it the force falls to zero");
    CALIBRATE_WEIGHT = optional("weight_kg", Range::AboveUpTo(0.0, 100.0),
        "Weight hung on the handle; omit it with a scale");
    CALIBRATE_STEP = number("resolution_kg", 1e-3, "1g", Range::Within(0.0, 1.0), "Smallest step of the scale");
    CALIBRATE_READINGS = list("readings_n", Range::Within(-1e4, 1e4),
        "Pairs of commanded and shown force, as [[0.5, 0.51], [1, 1.01]]");
}

pub(crate) const CALIBRATE: &[Parameter] = &[
    CALIBRATE_FORCE,
    CALIBRATE_BOX,
    CALIBRATE_WEIGHT,
    CALIBRATE_STEP,
    CALIBRATE_READINGS,
    MEASURE_AXIS,
    MEASURE_SAMPLE_TIME,
    DEVICE_MODEL,
];

/// The question that checks a newton.
pub const CALIBRATION: &str = "calibrate";

pub(crate) const TABLES: [(&str, &[Parameter]); 2] = [
    (CALIBRATION, CALIBRATE),
    ("device", &[MEASURE_DEVICE, WATCHDOG, MAX_AGE_TICKS]),
];

/// Acceleration of a mass that is weighed, m/s².
pub const GRAVITY: f64 = 9.80665;

/// The part of a calibration that waits for a person.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationStep {
    /// Words for a person.
    pub words: String,
    /// The force that is held while the instrument is read, N, in newtons of the device; `None` while something is put in place.
    pub commanded_n: Option<f64>,
}

impl CalibrationStep {
    fn read(commanded_n: f64, reading: usize, readings: usize) -> Self {
        Self {
            words: format!(
                "reading {reading} of {readings}, at {} commanded: once it is steady, what does the instrument show?",
                written("force_n", commanded_n)
            ),
            commanded_n: Some(commanded_n),
        }
    }
}

/// Answers for a person: the force that was read, N, or that something is in place; `Pending` while they are at it. It must not wait: a
/// loop is run meanwhile.
pub type Answer<'a> = &'a mut dyn FnMut(&CalibrationStep) -> Poll<Result<f64, Failure>>;

/// A person who answers.
struct Answers<'a>(Answer<'a>, &'a AtomicBool);

impl Answers<'_> {
    fn poll(&mut self, step: &CalibrationStep) -> Result<Option<f64>, Failure> {
        match (self.0)(step) {
            Poll::Ready(answer) => answer.map(Some),
            Poll::Pending if self.1.load(Ordering::Relaxed) => Err(Failure::run(INTERRUPTED)),
            Poll::Pending => Ok(None),
        }
    }

    /// Waits, without a force, until something is in place.
    fn prepare(&mut self, words: &str) -> Result<(), Failure> {
        let words = words.to_owned();
        let step = CalibrationStep {
            words,
            commanded_n: None,
        };
        while self.poll(&step)?.is_none() {
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(())
    }
}
