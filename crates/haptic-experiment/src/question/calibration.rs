//! A newton of a device at hand, checked against a kitchen scale, a spring balance or a hung weight.
//!
//! ```text
//! F = g·u ∓ F_c        u commanded, N; F on the instrument, N; F_c friction: − while the force rises, + while it falls
//! F = s·(r − r₀)       r shown by the device's force sensor, N
//! ```
//! - *Sign* first: the free handle must go with its force.
//! - *Scale or balance*: a person reads three forces on the way up and two on the way down. *Weight*: the force grows until the handle
//!   lifts it, and falls until it sinks, three times without and with it; nobody reads anything.
//! - *g* is the slope, the same on both ways, so that friction is between them and not in it. Its interval has the scatter about both
//!   lines by Student's t, and the step of the instrument at its worst. A reading that friction held where it was is no part.
//! - *Lag* of the sensor: a slow sine on the scale, whose spring shows the force by its way. The phase between way and sensor has neither
//!   delay and lag of the motor in it, nor friction and damping of the handle.

mod answer;
mod conduct;
mod line;

pub use answer::{CalibrationReport, Calibrator};
use haptic_document::{
    Failure, parameters,
    parameters::{DEVICE_MODEL, Parameter, range::Range},
};
use haptic_measurement::{MEASURE_AXIS, MEASURE_BOX, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME};
use std::sync::{
    Arc,
    mpsc::{TryRecvError, channel},
};

parameters! {
    pub(crate) mod keys;
    CALIBRATE_WEIGHT = optional("weight_kg", Range::AboveUpTo(0.0, 100.0),
        "Weight to hang on the handle; omit it with a scale");
    CALIBRATE_STEP = number("resolution_kg", 1e-3, "1g", Range::Within(0.0, 1.0), "Smallest step of the scale");
}

pub(crate) const CALIBRATE: &[Parameter] = &[
    CALIBRATE_WEIGHT,
    CALIBRATE_STEP,
    MEASURE_FORCE_LIMIT,
    MEASURE_BOX,
    MEASURE_AXIS,
    MEASURE_SAMPLE_TIME,
    DEVICE_MODEL,
];

/// The question that checks a newton.
pub const CALIBRATION: &str = "calibrate";

pub(crate) const TABLES: [(&str, &[Parameter]); 2] =
    [(CALIBRATION, CALIBRATE), haptic_measurement::TABLES[2]];

/// Acceleration of a mass that is weighed, m/s².
pub const GRAVITY: f64 = 9.80665;

/// Something that the handle does: it lifts this weight, N, or presses on an instrument.
type Task = Option<f64>;

/// Somebody at the bench, who hears words and the force that is held meanwhile, N: the force that the instrument shows, N, or, where none
/// is held, anything once all is in place. It is called on a thread of its own, and may wait there.
pub type Person = Arc<dyn Fn(&str, Option<f64>) -> Result<f64, Failure> + Send + Sync>;

/// Asks, and does `meanwhile` again and again until the answer comes.
fn asked<E: From<Failure>>(
    person: &Person,
    words: String,
    held_n: Option<f64>,
    mut meanwhile: impl FnMut() -> Result<(), E>,
) -> Result<f64, E> {
    let (told, answer) = channel();
    let person = Arc::clone(person);
    std::thread::spawn(move || told.send(person(&words, held_n)));
    loop {
        match answer.try_recv() {
            Ok(answered) => return answered.map_err(E::from),
            Err(TryRecvError::Empty) => meanwhile()?,
            Err(TryRecvError::Disconnected) => return Err(Failure::run("nobody answers").into()),
        }
    }
}
