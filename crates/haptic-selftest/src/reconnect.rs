//! A new connection after the link was closed, with the fault of the watchdog still latched.

use super::bench::{Bench, Broken, LONG_WATCHDOG_MS};
use super::promise::{Check, Promise};
use haptic_link::State;

const PROMISED: &str = "no force, settings as before the test, a fault as it was, no start before it is armed; armed, all is well";

pub(super) fn check(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    bench.trying(Promise::Reconnect)?;
    let (before, status) = (*bench.link()?.hello(), bench.link()?.status());
    let took = match bench.reconnect()? {
        Ok(took) => took,
        Err(error) => {
            let seen = format!("no new connection: {error}");
            return Ok(Check::judged(Promise::Reconnect, PROMISED, seen, false));
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
    let most_n = bench
        .listen(std::time::Duration::from_millis(100))?
        .largest_n();
    let mut certain = most_n > 0.0 || most_n.is_nan();
    if certain {
        wrong.push(format!("a force of {most_n} N"));
    }
    let configuration = bench.link()?.configuration()?;
    if configuration != *bench.set() {
        wrong.push("its settings are not those from before the test".to_owned());
    }
    match bench.start()? {
        Some(_) => {}
        None => {
            bench.calm()?;
            certain = true;
            wrong.push("it started without being armed".to_owned());
        }
    }
    wrong.extend(armed(bench)?);
    let took = format!("there again after {:.2} s", took.as_secs_f64());
    let ok = wrong.is_empty();
    let seen = if ok {
        format!("{took}, as promised")
    } else {
        format!("{took}, but {}", wrong.join(", "))
    };
    Ok(Check::judged(Promise::Reconnect, PROMISED, seen, ok).certain(certain))
}

/// Arms and disarms; complaints.
fn armed(bench: &mut Bench<'_>) -> Result<Option<String>, Broken> {
    let watchdog_ms = LONG_WATCHDOG_MS;
    bench.limit(watchdog_ms)?;
    bench.is_well()?;
    if let Some(refused) = bench.try_arm()? {
        return Ok(Some(refused.to_string()));
    }
    let status = bench.link()?.status();
    bench.calm()?;
    Ok(
        (status.state != State::Armed || status.fault != 0).then(|| {
            format!(
                "after being armed it is {} with fault {}",
                status.state, status.fault
            )
        }),
    )
}
