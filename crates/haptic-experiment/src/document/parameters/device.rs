//! Of every table: the device.

use super::kind::{Parameter, parameters};
use super::range::Range;
use haptic_link::Limits as Wire;

/// The device file that is shipped.
pub(crate) const LABORATORY: &str = "laboratory";

parameters! {
    /// The device.
    DEVICE = text("device", "sim", "Device: `sim`, `serial:PATH[@BAUD]`, `serial:auto`, or one of another maker, as `haply:PATH` or `moteus:PATH`");
    /// Place where the loop is closed.
    LOOP = text("loop", "device", "Where the loop with a serial device is closed");
    /// Watchdog of a serial device, s.
    WATCHDOG = optional("watchdog_s", Range::Within(1e-3 * Wire::WATCHDOG_MIN_MS as f64, 1e-3 * Wire::WATCHDOG_MAX_MS as f64),
        "Silence from this program after which a serial device lets go [default: 500ms, 20ms with a loop on the \
         host]");
    /// Late ticks of a serial device.
    LATE_TICKS = count("late_ticks", Wire::DEFAULT.late_ticks as u64, "20",
        "Late ticks in a row after which a serial device lets go; 0 for never");
    /// Age of a force from the host, ticks.
    MAX_AGE_TICKS = count("max_age_ticks", Wire::DEFAULT.max_age_ticks as u64, "10",
        "In a loop on the host: ticks from a sample to the force that answers it at most, 1 to 1000; an older force \
         makes a serial device let go [default: 10]");
    /// Device file.
    DEVICE_MODEL = text("device_model", "",
        "Device file, as device measure writes it: mass, damping, hand, delay, lag, friction, encoder and noise, below the keys beside it; on the rig of [relax] and [creep] for the guard alone");
}

/// Of every experiment on a device.
pub const ON_DEVICE: &[Parameter] = &[DEVICE, LOOP, WATCHDOG, LATE_TICKS, MAX_AGE_TICKS];
