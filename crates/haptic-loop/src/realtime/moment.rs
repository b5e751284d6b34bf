//! The clock by which silence and lateness are judged.

use core::ops::Add;
use std::time::Duration;

/// A moment by a clock that counts the time for which the machine slept: wherever silence or lateness is judged, as the standard
/// library's does not count it on Linux and macOS, and a force of before the sleep would be taken for one of now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(Duration);

impl Moment {
    /// The moment of the call.
    #[must_use]
    pub fn now() -> Self {
        Self(since_start())
    }

    /// The time that has passed since then.
    #[must_use]
    pub fn elapsed(self) -> Duration {
        Self::now().saturating_duration_since(self)
    }

    /// The time since an earlier moment; zero since a later one.
    #[must_use]
    pub const fn saturating_duration_since(self, earlier: Self) -> Duration {
        self.0.saturating_sub(earlier.0)
    }
}

impl Add<Duration> for Moment {
    type Output = Self;

    fn add(self, time: Duration) -> Self {
        Self(self.0.saturating_add(time))
    }
}

/// Time since the machine was started; the time for which it slept counts. The clock that counts it has a name of its own on each
/// system; Apple's has a resolution of 1 µs.
#[cfg(any(target_os = "linux", target_os = "macos"))]
pub(super) fn since_start() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    #[cfg(target_os = "linux")]
    let now = clock_gettime(ClockId::Boottime);
    #[cfg(target_os = "macos")]
    let now = clock_gettime(ClockId::Monotonic);
    // The clock starts at 0 when the machine does.
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec as u32)
}

/// Time since the first call. On Windows it counts the time for which the machine slept.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn since_start() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::super::{SystemWaiter, Waiter as _};
    use super::*;
    use std::process::Command;
    use std::string::String;

    /// Time since the machine was started, its sleep included, as the system shows it to people, s.
    fn uptime_s() -> f64 {
        let text = std::fs::read_to_string("/proc/uptime").expect("Linux tells it");
        let first = text.split_whitespace().next().expect("two numbers");
        first.parse().expect("a number")
    }

    /// Runs in a namespace of time whose machine has slept for an hour.
    #[test]
    fn the_time_for_which_a_machine_slept_counts() {
        let test_name = "realtime::moment::tests::the_time_for_which_a_machine_slept_counts";
        if std::env::var_os("SLEPT").is_some() {
            let near = |time: Duration| (time.as_secs_f64() - uptime_s()).abs() < 0.5;
            assert!(near(Moment::now().0), "{:?}", Moment::now());
            let mut waiter = SystemWaiter::default();
            assert!(near(waiter.now()), "{:?}", waiter.now());
            let due = waiter.now() + Duration::from_millis(20);
            waiter.sleep_until(due);
            let late = waiter.now().checked_sub(due).expect("not too early");
            assert!(late < Duration::from_millis(500), "{late:?}");
            return;
        }
        let in_namespace = |program: &std::path::Path, arguments: &[&str]| {
            let mut command = Command::new("unshare");
            command.args(["--user", "--map-root-user", "--time", "--boottime", "3600"]);
            command.arg("--fork").arg(program).args(arguments);
            command.env("SLEPT", "1").output()
        };
        let allowed = in_namespace("true".as_ref(), &[]).is_ok_and(|done| done.status.success());
        if !allowed {
            return testkit::skip("no namespace of time is to be had");
        }
        let test = std::env::current_exe().expect("its path");
        let ran = in_namespace(&test, &["--exact", test_name]).expect("runs");
        let printed = String::from_utf8_lossy(&ran.stdout);
        assert!(
            ran.status.success() && printed.contains("1 passed"),
            "{printed}"
        );
    }
}
