//! Numbers as a device has them: single precision, whole microseconds, whole milliseconds.

use haptic_experiment::Failure;
use haptic_experiment::document::advice::single;
use haptic_link::Limits;
use haptic_quantity::Time;

/// Sets what was given.
///
/// # Errors
/// A number that single precision cannot hold.
pub(super) fn set_all<const N: usize>(
    numbers: [(&mut f32, &str, Option<f64>); N],
) -> Result<(), Failure> {
    for (target, option, value) in numbers {
        if let Some(value) = value {
            *target = single(option, value)?;
        }
    }
    Ok(())
}

/// A time in whole microseconds.
///
/// # Errors
/// Outside its range, or not a whole number of them.
pub(super) fn microseconds(
    what: &str,
    time: Time,
    least_s: f64,
    most_s: f64,
) -> Result<u32, Failure> {
    let us = (time.0 * 1e6).round();
    if time.0 >= least_s && time.0 <= most_s && (us - time.0 * 1e6).abs() < 1e-6 {
        Ok(us as u32)
    } else {
        Err(Failure::bad_input(format_args!(
            "{what} {time} is not a whole number of microseconds in [{least_s}, {most_s}] s, which a device \
             needs"
        )))
    }
}

/// A watchdog time in whole milliseconds.
///
/// # Errors
/// Outside 5 ms to 1 s, or not a whole number of them.
pub fn watchdog_ms(time: Time) -> Result<u16, Failure> {
    let ms = (1e3 * time.0).round();
    let whole = (1e3 * time.0 - ms).abs() < 1e-6;
    let (least, most) = (Limits::WATCHDOG_MIN_MS, Limits::WATCHDOG_MAX_MS);
    if whole && ms >= f64::from(least) && ms <= f64::from(most) {
        Ok(ms as u16)
    } else {
        Err(Failure::bad_input(format_args!(
            "watchdog time {time} is not a whole number of milliseconds in [{least} ms, {most} ms]: give --watchdog, as in 100ms"
        )))
    }
}
