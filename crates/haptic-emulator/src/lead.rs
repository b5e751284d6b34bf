//! The way that a hand leads a handle.

use core::f64::consts::PI;

/// Share of the way after `since_s`, half a cosine over `time_s`, and its rate, 1/s: 1 and 0 from then on.
pub(crate) fn lead(since_s: f64, time_s: f64) -> (f64, f64) {
    if since_s >= time_s {
        return (1.0, 0.0);
    }
    let phase = PI * since_s / time_s;
    let rate = 0.5 * libm::sin(phase) * PI / time_s;
    (0.5 * (1.0 - libm::cos(phase)), rate)
}
