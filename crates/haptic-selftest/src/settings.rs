//! Settings of a self-test.

use fracdiff::parameter::Shown;
use haptic_experiment::Failure;
use haptic_experiment::Named;
use haptic_experiment::parameters::{FORCE_LIMIT, WATCHDOG};
use std::time::Duration;

/// A flight test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfTest {
    /// Limit of the force during the test, N; less where less is set on the device.
    pub force_limit_n: f64,
    /// Silence after which the device has to let go, ms.
    pub watchdog_ms: u16,
    /// Period of the loop in the trials, µs; the nearest that the device has.
    pub period_us: u32,
    /// The emergency stop.
    pub emergency_stop: EmergencyStop,
}

/// The emergency stop of a device, which only a person can press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmergencyStop {
    /// A simulated device has none; on a real one somebody presses it.
    AsTheDevice,
    /// There is none.
    Absent,
    /// Somebody presses it.
    Pressed,
}

impl SelfTest {
    /// 0.1 N, 200 ms, 1 kHz.
    pub const DEFAULT: Self = Self {
        force_limit_n: 0.1,
        watchdog_ms: 200,
        period_us: 1000,
        emergency_stop: EmergencyStop::AsTheDevice,
    };
    /// Range of [`force_limit_n`](Self::force_limit_n): what a hand feels, and what it holds without effort.
    pub const FORCE_LIMIT_N: [f64; 2] = [1e-3, 2.0];
    /// Time in which somebody presses the emergency stop, and in which they release it.
    pub const PATIENCE: Duration = Duration::from_secs(30);

    /// # Errors
    /// A force limit or watchdog time outside its range.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let [least, most] = Self::FORCE_LIMIT_N;
        if !(least..=most).contains(&self.force_limit_n) {
            return Err(Failure::bad_input(format_args!(
                "force limit {} N of a self-test is not in [{least}, {most}] N: change {FORCE_LIMIT}",
                Shown(self.force_limit_n)
            )));
        }
        let (least, most) = (
            haptic_link::Limits::WATCHDOG_MIN_MS,
            haptic_link::Limits::WATCHDOG_MAX_MS,
        );
        if !(least..=most).contains(&self.watchdog_ms) {
            return Err(Failure::bad_input(format_args!(
                "watchdog time {} ms is not in [{least}, {most}] ms: change {WATCHDOG}",
                self.watchdog_ms
            )));
        }
        Ok(())
    }
}

impl Named for EmergencyStop {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Pressed, "pressed", "Somebody presses it when told to"),
        (Self::Absent, "none", "The device has none"),
    ];
}
