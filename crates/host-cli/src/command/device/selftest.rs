//! `device selftest`: what a device promises, tried, as a table.

mod form;

use crate::command::conduct::stop_on_interrupt;
use crate::command::device::port::PortArguments;
use crate::files::PlaceOfFile;
use crate::output::{Output, note, warn};
use crate::parse::{choice, of, quantity, whole};
use clap::Args;
use haptic_experiment::{Failure, parameters};
use haptic_quantity::written;
use haptic_selftest::{Attendant, Check, EmergencyStop, Notice, SelfTest, SelfTestReport};
use std::io::{self, IsTerminal as _};
use std::path::PathBuf;

/// Test arming, limits, direction, watchdog, recorder, reconnection and emergency stop
///
/// Prints what the device promises and what the test saw. The settings of the device stay as they
/// are. --json is a certificate: date, board, firmware with its digest, and each promise with its
/// figures. --out writes a form for a first time on real hardware, to be filled in by hand.
///
/// It takes about 4 s. The force, at most 0.1 N (--force-limit), changes sign 25 times a second; up
/// to three times that is requested, to see the limit act. A real device moves by a few
/// millimetres: let it move freely, and press its emergency stop when told (--emergency-stop none
/// if it has none). Of several axes each is driven in turn, about 1 s more for each, and one that is
/// mirrored or swapped with another is named.
///
/// Exit code 0 if every promise was kept, 1 if one was broken, 3 if the link was lost, an emergency
/// stop or fault ended the test, or this machine or a limit of the device kept one from being
/// judged.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli device selftest --device serial:/dev/ttyACM0")]
pub(crate) struct Arguments {
    #[command(flatten)]
    port: PortArguments,
    /// Force limit during the test
    #[arg(long, value_parser = quantity("_n", parameters::FORCE_LIMIT.range()), value_name = "FORCE")]
    force_limit: Option<f64>,
    /// Sample time; longer for a slow line
    #[arg(long, value_name = "TIME", value_parser = of(parameters::MEASURE_SAMPLE_TIME), default_value = parameters::MEASURE_SAMPLE_TIME.shown)]
    sample_time: f64,
    /// Axes to open on a Haply 2DIY (1, 2) or Inverse3 (1, 3); a board says itself [default: 1]
    #[arg(long, value_name = "AXES", value_parser = whole::<u8>(1..=3))]
    axes: Option<u8>,
    /// Emergency stop [default: none if simulated, else pressed]
    #[arg(long, value_parser = choice::<EmergencyStop>())]
    emergency_stop: Option<EmergencyStop>,
    /// Form for a first time on hardware: what the test found, and blanks for what a person sees
    #[arg(long, value_name = "FORM.md")]
    out: Option<PathBuf>,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut test = SelfTest::DEFAULT;
        test.force_limit_n = self.force_limit.unwrap_or(test.force_limit_n);
        test.period_us = (self.sample_time * 1e6).round() as u32;
        test.emergency_stop = self.emergency_stop.unwrap_or(test.emergency_stop);
        let mut place = PlaceOfFile::of_form(self.out.as_ref())?;
        let mut report = test.run(Attendant {
            connect: &|| self.port.connect_all(self.axes),
            notice: &|notice| say(notice, output),
            stop: stop_on_interrupt()?,
        })?;
        let mut shown = report.clone();
        for check in &mut shown.checks {
            // They stand in its words.
            check.figures.clear();
        }
        let form = self.out.is_some().then(|| form::of(&shown));
        report.form = place.write_beside("md", form);
        shown.form.clone_from(&report.form);
        output.report_as(&report, &shown)?;
        place.close(judge(&report))
    }
}

/// True if somebody watches and wants to see the progress.
fn is_watched(output: Output) -> bool {
    !output.quiet && !output.json && io::stderr().is_terminal()
}

/// Tells a person beside the device what to know or do, even with `--quiet`.
fn say(notice: Notice, output: Output) {
    let now = |what| {
        let patience_s = SelfTest::PATIENCE.as_secs();
        note("now", format_args!("{what}, within {patience_s} s"));
    };
    match notice {
        Notice::MayMove(force_n) => warn(&format!(
            "the device moves on its own, with at most {}: let it move freely",
            written("force_n", force_n.into())
        )),
        Notice::Trying(promise) if is_watched(output) => note("trying", promise),
        Notice::Trying(_) => {}
        Notice::Silent => warn("the device does not answer; it is asked on for some seconds"),
        Notice::PressEmergencyStop => now("press the emergency stop"),
        Notice::ReleaseEmergencyStop => now("release it again"),
    }
}

/// A link that was lost, a fault or Ctrl-C that ended the test, else a promise that was not kept, else one that could not be judged.
fn judge(report: &SelfTestReport) -> Result<(), Failure> {
    let device = &report.device;
    if let Some(error) = &report.link_lost {
        let words = format!("{device}: {error}; the self-test ended");
        return Err(Failure::device(words));
    }
    if let Some(fault) = &report.ended_by_fault {
        return Err(Failure::device(format_args!(
            "{device}: {fault}; the self-test ended: fix the cause, then test again"
        )));
    }
    if report.interrupted {
        return Err(Failure::run("interrupted: the device was disarmed"));
    }
    let named = |which: fn(&Check) -> bool, why: &str, remedy: &str| {
        let checks = report.checks.iter().filter(|check| which(check));
        let names: Vec<String> = checks.map(|check| check.check.to_string()).collect();
        let (count, of) = (names.len(), report.checks.len());
        let names = names.join(", ");
        (count > 0).then(|| format!("{count} of {of} promises {why}: {names}; {remedy}"))
    };
    let (broken, fix) = ("were broken", "do not use this device until that is fixed");
    let broken = named(|check| check.ok == Some(false), broken, fix);
    let (unknown, read) = ("could not be judged", "the table says why");
    let unknown = named(|check| check.not_judged && !check.host_late, unknown, read);
    let (late, close) = (
        "could not be judged, as this machine was too busy",
        "close other programs",
    );
    let late = named(|check| check.host_late, late, close);
    match (broken, unknown.or(late)) {
        (Some(broken), _) => Err(Failure::run(broken)),
        (None, Some(unknown)) => Err(Failure::device(unknown)),
        (None, None) => Ok(()),
    }
}
