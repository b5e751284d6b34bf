//! The excitation on a serial device: the loop is closed here, the force is the one that the device tells it applied.

use super::conduct::{DriveError, Driven, Outcome, drive};
use super::plan::MeasurePlan;
use super::record::MotionRecord;
use crate::document::failure::Failure;
use crate::document::parameters::{MAX_AGE_TICKS, WATCHDOG};
use crate::run::device::{Warn, at_link, at_port, firmware_version, refused_at_port};
use crate::run::lateness::Lateness;
use crate::run::realtime::RealtimeOptions;
use crate::run::remote::{
    RemoteDevice, RemoteLaw, UnchangedLimits, configuration, keep_within, no_operator, push,
};
use crate::run::safety::{GuardChoice, GuardedDevice};
use crate::run::schedule::{Pace, Schedule};
use fracdiff::parameter::Shown;
use haptic_link::{LoopMode, Scope, Simulation, SimulationKind, Start};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::LinkError;
use haptic_remote::serial::{SerialError, SerialLink};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A motion of a serial device, and what the device calls itself.
#[derive(Clone, Debug)]
pub struct SerialMotion {
    /// The motion.
    pub record: MotionRecord,
    /// Name of the board, and its firmware.
    pub board: String,
    /// True if the device simulates its plant.
    pub simulated: bool,
}

/// Measures a serial device. Its own limits hold too, where they are tighter.
///
/// The delay that is found is the device's own: the line is not in it, as the force of each tick is the one that the device says it applied.
///
/// # Errors
/// A device that cannot be used; a parameter outside its range; a measurement that did not come to its end.
pub fn on_serial(
    plan: &MeasurePlan,
    remote: &RemoteDevice,
    warn: Warn<'_>,
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<SerialMotion, Failure> {
    plan.check()?;
    let remote = RemoteDevice {
        loop_mode: LoopMode::Host,
        ..remote.clone()
    };
    let mut link = remote
        .name
        .connect_with(1, remote.patience, warn, Some(stop))?;
    let driven = driven(plan, &remote, &mut link, warn, progress, stop);
    let driven = driven.map_err(|failure| at_link(&link, failure))?;
    let can = link.capabilities();
    Ok(SerialMotion {
        record: driven.record,
        board: format!("{} {}", can.board(), firmware_version(link.hello())),
        simulated: can.simulated,
    })
}

/// The excitation, from limits to rest.
fn driven(
    plan: &MeasurePlan,
    remote: &RemoteDevice,
    link: &mut SerialLink,
    warn: Warn<'_>,
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<Driven, Failure> {
    let path = link.path().to_owned();
    let problem = |error| refused_at_port(&path, error);
    configure(plan, remote, link, warn)?.map_err(problem)?;
    let watchdog = Duration::from_millis(u64::from(remote.watchdog_ms()));
    link.arm(watchdog).map_err(problem)?;
    link.start(Start::ENDLESS).map_err(problem)?;
    let mut applied = |stoppable: &Stoppable<'_>, _sent: f64| {
        let axis = stoppable.link.newest().axes.first();
        axis.map_or(0.0, |axis| f64::from(axis.force_n))
    };
    let mut stoppable = Stoppable { link, stop };
    let driven = drive(plan, &mut stoppable, &mut applied, progress, stop);
    // After an error too: dropped, the link does it once more.
    let disarmed = link.disarm();
    if let (None, Some(trouble)) = (link.lost_board(), link.trouble()) {
        warn(&trouble.words);
    }
    let stopped = DriveError::Device(LinkError::Stopped.into());
    if driven.as_ref().err() == Some(&stopped) && disarmed.is_ok() && link.wait_for_rest() {
        Outcome::Interrupted.require_complete(plan)?;
    }
    let driven = driven.map_err(|error| match error {
        DriveError::Plan(error) => Failure::input(error),
        DriveError::Device(error) => {
            too_busy(&error, remote.lateness()).unwrap_or_else(|| at_port(&path, &error))
        }
    })?;
    driven.outcome.require_complete(plan)?;
    disarmed.map_err(problem)?;
    Ok(driven)
}

/// A link whose loop hears who stops it, even where no sample comes.
struct Stoppable<'a> {
    link: &'a mut SerialLink,
    stop: &'a AtomicBool,
}

impl Device<f64, 1> for Stoppable<'_> {
    type Error = SerialError;

    fn read(&mut self) -> Result<Reading<f64, 1>, SerialError> {
        self.link.read_or_stop(self.stop)
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), SerialError> {
        self.link.write(force)
    }

    fn let_go(&mut self) {
        Device::<f64, 1>::let_go(self.link);
    }
}

/// A fault that the machine makes, and no device: with its remedy.
fn too_busy(error: &SerialError, lateness: Lateness) -> Option<Failure> {
    let SerialError::Link(LinkError::Faulted(report)) = error else {
        return None;
    };
    let fault = Fault::from_code(report.status.fault);
    let longer = lateness.longer();
    matches!(fault, Some(Fault::HostSilent | Fault::StaleForce)).then(|| {
        let remedy = match longer == lateness {
            true => String::new(),
            false => format!(
                ", or allow it more with {} and {}",
                WATCHDOG.set_to(Shown(longer.watchdog_s())),
                MAX_AGE_TICKS.set_to(longer.max_age_ticks)
            ),
        };
        Failure::Run(anyhow::anyhow!(
            "{error}: run nothing else on this machine{remedy}"
        ))
    })
}

/// Sets the limits of the measurement for this run.
fn configure(
    plan: &MeasurePlan,
    remote: &RemoteDevice,
    link: &mut SerialLink,
    warn: Warn<'_>,
) -> Result<Result<(), SerialError>, Failure> {
    let (set, _) = link
        .configuration()
        .map_err(|error| at_port(link.path(), &error))?;
    let law = RemoteLaw {
        stiffness_n_per_m: 0.0,
        dissipation_n_s_mu_per_m: 0.0,
        order: 0.0,
        one_sided: false,
        operator: no_operator(),
        // The box is about the start, which is not known yet: the chain here watches over it.
        limits: haptic_loop::Limits {
            workspace: None,
            ..plan.limits(0.0)
        },
        unchanged: UnchangedLimits::default(),
        guard: (GuardChoice::Off, GuardedDevice::default()),
        simulation: Simulation {
            kind: SimulationKind::MassDamper,
            ..push(0.0)
        },
        after_rise: false,
    };
    let schedule = Schedule {
        samples: plan.ticks_at_most(),
        sample_time_s: plan.sample_time_s,
        pace: Pace::Realtime(RealtimeOptions::NORMAL),
    };
    let can = link.capabilities();
    let mut configuration = configuration(remote, &law, schedule, can, &set.limits)?;
    if let Some(text) = keep_within(&mut configuration, &set) {
        warn(&text);
    }
    Ok(link
        .set_for(configuration, &law.operator.1, Scope::Run)
        .map(|_| ()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::ending::reported;

    #[test]
    fn a_measurement_is_allowed_more_than_it_had() {
        let said = |watchdog_ms, max_age_ticks| {
            let lateness = Lateness {
                watchdog_ms,
                max_age_ticks,
            };
            let error = LinkError::Faulted(reported(Fault::HostSilent)).into();
            let failure = too_busy(&error, lateness).expect("the machine was busy");
            assert_eq!(failure.exit_code(), 1);
            failure.to_string()
        };
        for (had, more) in [
            ((20, 10), "`watchdog_s` = 0.1 and `max_age_ticks` = 50"),
            ((500, 300), "`watchdog_s` = 1 and `max_age_ticks` = 1000"),
        ] {
            let said = said(had.0, had.1);
            assert!(said.ends_with(more), "{said}");
        }
        assert!(said(1000, 1000).ends_with("on this machine"));
    }
}
