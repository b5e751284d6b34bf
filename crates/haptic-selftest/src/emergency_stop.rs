//! The emergency stop, pressed by a person.

use super::attendant::Notice;
use super::bench::{Bench, Broken, LONG_WATCHDOG_MS};
use super::promise::{Check, Promise};
use super::settings::SelfTest;
use haptic_link::{Refusal, State};
use haptic_loop::Fault;
use haptic_remote::LinkError;
use std::time::{Duration, Instant};

const PROMISED: &str = "pressed, it is a fault; open, no arm; closed, all is well";

pub(super) fn check(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    bench.trying(Promise::EmergencyStop)?;
    if !bench.has_emergency_stop()? {
        return Ok(Check::absent(Promise::EmergencyStop, PROMISED, "not there"));
    }
    let judged = |seen: &str, ok| Check::judged(Promise::EmergencyStop, PROMISED, seen, ok);
    bench.limit(LONG_WATCHDOG_MS)?;
    bench.arm_for_trial()?;
    bench.notice(Notice::PressEmergencyStop);
    let pressed = wait(bench, |bench| Ok(bench.state()? == State::Fault))?;
    if !pressed {
        bench.calm()?;
        return Ok(judged(
            "it was not pressed, or the device did not notice",
            false,
        ));
    }
    let code = bench.link()?.status().fault;
    if code != Fault::EmergencyStop.code() {
        bench.calm()?;
        let seen = format!("fault {code}, not {}", Fault::EmergencyStop.code());
        return Ok(judged(&seen, false));
    }
    let open = Refusal::FaultPersists(Fault::EmergencyStop.code());
    match bench.try_arm()? {
        Some(LinkError::Refused { refusal, .. }) if refusal == open => {}
        Some(refused) => return Ok(judged(&format!("fault {code}; {refused}"), false)),
        None => {
            bench.calm()?;
            return Ok(judged(
                "it was armed while the stop was open, or the stop was closed at once",
                false,
            ));
        }
    }
    bench.notice(Notice::ReleaseEmergencyStop);
    let closed = wait(bench, |bench| Ok(bench.try_arm()?.is_none()))?;
    bench.calm()?;
    Ok(if closed {
        judged(
            "fault 4; no arm while it was open; armed when it was closed",
            true,
        )
    } else {
        judged("fault 4; no arm while it was open, nor afterwards", false)
    })
}

/// Waits for a person; false if nobody did it.
fn wait(
    bench: &mut Bench<'_>,
    done: impl Fn(&mut Bench<'_>) -> Result<bool, Broken>,
) -> Result<bool, Broken> {
    let began = Instant::now();
    while began.elapsed() < SelfTest::PATIENCE {
        bench.goes_on()?;
        if done(bench)? {
            return Ok(true);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(false)
}

impl Bench<'_> {
    /// The state by now: a keep-alive after each quarter of the watchdog time tells it.
    fn state(&self) -> Result<State, Broken> {
        Ok(self.link()?.status().state)
    }
}
