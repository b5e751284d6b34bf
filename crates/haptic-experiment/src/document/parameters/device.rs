//! Of every table: the device.

use super::kind::{Parameter, parameters};
use super::range::Range;
use haptic_link::Limits as Wire;

/// The device file that is shipped.
pub(crate) const LABORATORY: &str = "laboratory";

parameters! {
    /// The device.
    DEVICE = text("device", "sim", "Device: `sim`, `serial:PATH[@BAUD]`, `serial:auto`, `haply:PATH` or `moteus:PATH`");
    /// Place where the loop is closed.
    LOOP = text("loop", "device", "Where the loop of a serial device is closed");
    /// Watchdog of a serial device, s.
    WATCHDOG = optional("watchdog_s", Range::Within(1e-3 * Wire::WATCHDOG_MIN_MS as f64, 1e-3 * Wire::WATCHDOG_MAX_MS as f64),
        "Silence from this program after which a serial device lets go [default: 500ms, 20ms in a host loop]");
    /// Late ticks of a serial device.
    LATE_TICKS = count("late_ticks", Wire::DEFAULT.late_ticks as u64, "20",
        "Late ticks in a row after which a serial device lets go; 0 = off");
    /// Age of a force from the host, ticks.
    MAX_AGE_TICKS = count("max_age_ticks", Wire::DEFAULT.max_age_ticks as u64, "10",
        "Host loop: largest age of a force in ticks from its sample, 1 to 1000; an older one makes a serial device \
         let go [default: 10]");
    /// Device file.
    DEVICE_MODEL = text("device_model", "",
        "Device file, as written by device measure; keys beside it take precedence. On the rig of [relax] and [creep] for the guard only");
}

/// Of every experiment on a device.
pub const ON_DEVICE: &[Parameter] = &[DEVICE, LOOP, WATCHDOG, LATE_TICKS, MAX_AGE_TICKS];
