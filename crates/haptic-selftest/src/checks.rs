//! Checks around the runs: nothing before it is armed, a new connection, the emergency stop.

use super::bench::{Bench, Broken, LONG_WATCHDOG_MS, refusal};
use super::promise::{Check, Notice, Promise, SelfTest};
use haptic_link::{Refusal, State};
use haptic_loop::Fault;
use haptic_loop::realtime::Moment;
use haptic_remote::LinkError;
use std::time::Duration;

const AT_REST: &str = "no force and no start before it is armed";
/// Time to look at a device that nobody has armed.
const LOOK: Duration = Duration::from_millis(200);

pub(super) fn arm(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    bench.trying(Promise::Arm)?;
    let followed = bench.listen(LOOK)?;
    let (samples, most_n) = (followed.samples.len(), followed.largest_n());
    let started = bench.start()?;
    if started.is_none() {
        bench.calm()?;
    }
    let seen = format!(
        "{samples} samples, at most {most_n} N; {}",
        refused(&started)
    );
    let certain = most_n > 0.0 || most_n.is_nan() || started.is_none();
    let ok = samples > 0 && !certain;
    let row = Check::judged(Promise::Arm, AT_REST, seen, ok).certain(certain);
    Ok(row.figure("force_max_n", most_n))
}

pub(super) fn refused(started: &Option<LinkError>) -> String {
    let refused = started.as_ref().map(ToString::to_string);
    refused.unwrap_or_else(|| "it started all the same".to_owned())
}

/// After the link was closed, with the fault of the watchdog still latched.
const CONNECTED_ANEW: &str = "no force, settings as before the test, a fault as it was, no start before it is armed; armed, all is well";

pub(super) fn reconnect(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    bench.trying(Promise::Reconnect)?;
    let (before, status) = (*bench.link()?.hello(), bench.link()?.status());
    let took = match bench.reconnect()? {
        Ok(took) => took,
        Err(error) => {
            let seen = format!("no new connection: {error}");
            return Ok(Check::judged(
                Promise::Reconnect,
                CONNECTED_ANEW,
                seen,
                false,
            ));
        }
    };
    let mut wrong: Vec<String> = Vec::new();
    let hello = *bench.link()?.hello();
    if hello.connection == before.connection {
        wrong.push("the connection has the number of the last one".to_owned());
    }
    let now = bench.link()?.hello().status;
    if !matches!(now.state, State::Idle | State::Fault) {
        wrong.push(format!("it is {}", now.state));
    }
    // A device that was switched off meanwhile, or lives in this process, has forgotten.
    if hello.boot == before.boot && now.fault != status.fault {
        wrong.push(format!("fault {} was {}", now.fault, status.fault));
    }
    let most_n = bench.listen(Duration::from_millis(100))?.largest_n();
    let mut certain = most_n > 0.0 || most_n.is_nan();
    if certain {
        wrong.push(format!("a force of {most_n} N"));
    }
    let configuration = bench.link()?.configuration()?;
    if configuration != bench.set {
        wrong.push("its settings are not those from before the test".to_owned());
    }
    if bench.start()?.is_none() {
        bench.calm()?;
        certain = true;
        wrong.push("it started without being armed".to_owned());
    }
    wrong.extend(armed(bench)?);
    let took_s = took.as_secs_f64();
    let took = format!("there again after {took_s:.2} s");
    let ok = wrong.is_empty();
    let seen = if ok {
        format!("{took}, as promised")
    } else {
        format!("{took}, but {}", wrong.join(", "))
    };
    let row = Check::judged(Promise::Reconnect, CONNECTED_ANEW, seen, ok).certain(certain);
    Ok(row.figure("time_to_answer_s", took_s))
}

fn armed(bench: &mut Bench<'_>) -> Result<Option<String>, Broken> {
    bench.limit(LONG_WATCHDOG_MS)?;
    bench.is_well()?;
    if let Some(refused) = refusal(bench.arm())? {
        return Ok(Some(refused.to_string()));
    }
    let status = bench.link()?.status();
    bench.calm()?;
    let (state, fault) = (status.state, status.fault);
    let complaint = || format!("after being armed it is {state} with fault {fault}");
    Ok((state != State::Armed || fault != 0).then(complaint))
}

const PRESSED: &str = "pressed, it is a fault; open, no arm; closed, all is well";

pub(super) fn emergency_stop(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    bench.trying(Promise::EmergencyStop)?;
    let judged = |seen: &str, ok| Check::judged(Promise::EmergencyStop, PRESSED, seen, ok);
    if !bench.has_emergency_stop()? {
        return Ok(judged("not there", None));
    }
    let broken = |seen: &str| judged(seen, Some(false));
    bench.limit(LONG_WATCHDOG_MS)?;
    bench.arm_for_trial()?;
    bench.notice(Notice::PressEmergencyStop);
    let pressed = wait(bench, |bench| {
        Ok(bench.link()?.status().state == State::Fault)
    })?;
    if !pressed {
        bench.calm()?;
        return Ok(broken("it was not pressed, or the device did not notice"));
    }
    let code = bench.link()?.status().fault;
    if code != Fault::EmergencyStop.code() {
        bench.calm()?;
        let wanted = Fault::EmergencyStop.code();
        return Ok(broken(&format!("fault {code}, not {wanted}")));
    }
    let open = Refusal::FaultPersists(Fault::EmergencyStop.code());
    match refusal(bench.arm())? {
        Some(LinkError::Refused { refusal, .. }) if refusal == open => {}
        Some(refused) => return Ok(broken(&format!("fault {code}; {refused}"))),
        None => {
            bench.calm()?;
            let seen = "it was armed while the stop was open, or the stop was closed at once";
            return Ok(broken(seen));
        }
    }
    bench.notice(Notice::ReleaseEmergencyStop);
    let closed = wait(bench, |bench| Ok(refusal(bench.arm())?.is_none()))?;
    bench.calm()?;
    Ok(if closed {
        let seen = "fault 4; no arm while it was open; armed when it was closed";
        judged(seen, Some(true))
    } else {
        broken("fault 4; no arm while it was open, nor afterwards")
    })
}

/// Waits for a person; false if nobody did it.
fn wait(
    bench: &mut Bench<'_>,
    done: impl Fn(&mut Bench<'_>) -> Result<bool, Broken>,
) -> Result<bool, Broken> {
    let began = Moment::now();
    while began.elapsed() < SelfTest::PATIENCE {
        bench.goes_on()?;
        if done(bench)? {
            return Ok(true);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(false)
}
