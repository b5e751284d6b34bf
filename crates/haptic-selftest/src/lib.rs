#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod bench;
mod checks;
mod direction;
mod fall;
mod force_limit;
mod in_time;
mod promise;
mod recorder;
mod silence;
mod trial;

pub use promise::{Attendant, Check, EmergencyStop, Notice, Promise, SelfTest};

use bench::{Bench, Broken};
use chrono::{DateTime, SecondsFormat, Utc};
use haptic_document::Failure;
use haptic_link::Limits;
use haptic_run::{firmware_digest, firmware_version};
use in_time::in_time;
use serde::Serialize;
use std::time::SystemTime;

/// Table of what was promised and what was observed: as JSON, a certificate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SelfTestReport {
    /// When the test began, RFC 3339, UTC.
    pub date: String,
    /// The port as given, including forms such as `moteus:…`.
    pub device: String,
    /// The name that the board gives of itself.
    pub board: String,
    /// Version of the firmware, as three numbers.
    pub firmware: String,
    /// CRC-32 of the image that the device runs, if it reports one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub firmware_digest: Option<String>,
    /// True if the device simulates its plant.
    pub simulated: bool,
    /// Limit of the force that held during the test, N.
    pub force_limit_n: f32,
    /// The limits that the device had before the test, and has again: what the next run may make.
    #[serde(skip)]
    pub limits: Limits,
    /// One row per promise, tested or not, in the order of [`Promise::ALL`].
    pub checks: Vec<Check>,
    /// True if every promise that this device makes was judged and kept.
    pub holds: bool,
    /// Why the test ended early, if the link was lost.
    pub link_lost: Option<String>,
    /// The fault that ended the test before its end: the emergency stop, or one of the device's electronics.
    pub ended_by_fault: Option<String>,
    /// True if the test was stopped before its end.
    pub interrupted: bool,
    /// The form that this report was written into.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<String>,
}

impl SelfTest {
    /// Goes through all promises. One that is broken is a row of the table and no error, and so is a link that is lost,
    /// a fault that ends the test, or a stop: the device is disarmed then.
    ///
    /// Takes about 4 s, plus the time someone needs to press the emergency stop.
    ///
    /// # Errors
    /// Exit code 2: a number outside its range. Exit code 3: no device.
    pub fn run(&self, attendant: Attendant<'_>) -> Result<SelfTestReport, Failure> {
        self.check()?;
        let date = DateTime::<Utc>::from(SystemTime::now());
        let link = (attendant.connect)()?;
        let device = link.name();
        let board = link.capabilities().board().to_owned();
        let firmware = firmware_version(link.hello());
        let firmware_digest = firmware_digest(link.capabilities());
        let simulated = link.capabilities().simulated;
        let mut checks = Vec::new();
        let mut bench = Bench::new(link, *self, attendant)?;
        if !simulated {
            (attendant.notice)(Notice::MayMove(bench.limited.limits.force_n));
        }
        let tried = try_all(&mut bench, &mut checks);
        let interrupted = matches!(tried, Err(Broken::Interrupted));
        let (mut link_lost, mut ended_by_fault) = (None, None);
        if let Err(broken) = tried {
            let why = match broken {
                Broken::Interrupted => "interrupted",
                Broken::Fault(words) => ended_by_fault.insert(words),
                Broken::Link(error) => {
                    link_lost.insert(bench.lost_board().unwrap_or(error.to_string()))
                }
            };
            not_reached(&mut checks, why);
        }
        Ok(SelfTestReport {
            date: date.to_rfc3339_opts(SecondsFormat::Secs, true),
            device,
            board,
            firmware,
            firmware_digest,
            simulated,
            force_limit_n: bench.limited.limits.force_n,
            limits: bench.set.0.limits,
            holds: (checks.iter()).all(|check| check.ok != Some(false) && !check.not_judged),
            checks,
            link_lost,
            ended_by_fault,
            interrupted,
            form: None,
        })
    }
}

/// Tries one promise after another, up to the end, to that of the link, or to a fault that ends the test.
fn try_all(bench: &mut Bench<'_>, checks: &mut Vec<Check>) -> Result<(), Broken> {
    let one = |check: fn(&mut Bench<'_>) -> Result<Check, Broken>| {
        move |bench: &mut Bench<'_>| Ok((vec![check(bench)?], ()))
    };
    in_time(bench, checks, one(checks::arm))?;
    in_time(bench, checks, |bench| Ok((force_limit::check(bench)?, ())))?;
    in_time(bench, checks, |bench| {
        Ok((silence::finite_check(bench)?, ()))
    })?;
    let followed = in_time(bench, checks, |bench| {
        let (check, followed) = silence::watchdog(bench)?;
        Ok((vec![check], followed))
    })?;
    // Without a fault of the watchdog that could be judged there is nothing to hold the recorder against.
    let mut recorded = recorder::check(bench, followed.as_ref())?;
    if checks.last().is_some_and(|watchdog| watchdog.host_late) {
        recorded = recorded.too_late("the watchdog was not");
    }
    checks.push(recorded);
    in_time(bench, checks, one(checks::reconnect))?;
    in_time(bench, checks, one(checks::emergency_stop))?;
    Ok(())
}

/// Rows for the promises that could not be tried to their end: nobody knows if the device keeps them.
fn not_reached(checks: &mut Vec<Check>, error: &str) {
    for promise in Promise::ALL.into_iter().skip(checks.len()) {
        let first = !checks.iter().any(|check| check.promised.is_empty());
        let seen = if first { error } else { "not reached" };
        checks.push(Check::not_judged(promise, "", seen));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_tried_is_neither_kept_nor_broken() {
        let mut checks = vec![Check::judged(Promise::Arm, "no force", "none", true)];
        not_reached(&mut checks, "the line is gone");
        assert_eq!(checks.len(), Promise::ALL.len());
        assert_eq!(checks[1].seen, "the line is gone");
        for check in &checks[1..] {
            assert!(check.ok.is_none() && check.not_judged, "{check:?}");
            assert!(!check.host_late, "{check:?}");
        }
    }
}
