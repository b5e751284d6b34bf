//! A measurement on a device at a port: the loop is here, and the device keeps its own limits.

use haptic_document::{Failure, Named as _, Warn, bad_input};
use haptic_link::{Configuration, LoopMode, Scope, Simulation, SimulationKind, Start};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_measurement::{
    HELD, MEASURE_AXIS, MeasurePlan, MeasuredAxis, MotionRecord, OwnLimits,
    drive::{DriveError, INTERRUPTED, drive},
    robot::drive_robot,
};
use haptic_remote::{
    LinkError,
    serial::{SerialError, SerialLink},
};
use haptic_run::{
    device::{at_link, at_port, firmware_version, refused_at_port},
    realtime::RealtimeOptions,
    remote::{RemoteDevice, RemoteLaw, agreed, push},
    schedule::{Pace, Schedule},
};
use haptic_trial::ending::Lateness;
use nalgebra::SVector;
use std::sync::{Arc, atomic::AtomicBool};

/// Motion of a device that takes a force, or of a robot.
pub(crate) struct Moved {
    pub record: MotionRecord,
    pub is_robot: bool,
    /// Its board and firmware, in words.
    pub board: String,
    pub plan: MeasurePlan,
}

/// Measures a serial device. Its own limits hold too, where they are tighter.
///
/// The delay that is found is the device's own: the line is not in it, as the force of each tick is the one that the device says it applied.
pub(crate) fn on_serial(
    plan: &MeasurePlan,
    remote: &RemoteDevice,
    warn: Warn<'_>,
    progress: &dyn Fn(u64),
    stop: &Arc<AtomicBool>,
) -> Result<Moved, Failure> {
    let (mut link, set, mut plan) = opened(plan, remote, warn, stop)?;
    let is_robot = link.capabilities().lets_go_alone.moves;
    if is_robot {
        fits_robot(&plan, &link)?;
        link.knows_robot();
        plan = plan.of_robot();
    }
    let mut applied = |axis: &Stoppable<'_>, _sent: f64| axis.forces_n()[0];
    let driven = armed(&plan, remote, &mut link, &set, warn, stop, |axis| {
        if is_robot {
            return drive_robot(&plan, axis, &mut applied, progress, stop);
        }
        let driven = drive(&plan, axis, &mut applied, progress, stop)?;
        driven.outcome.require_complete(&plan)?;
        Ok(driven.record)
    });
    let record = driven.map_err(|failure| at_link(&link, failure))?;
    let can = link.capabilities();
    let simulated = if can.simulated { " (simulated)" } else { "" };
    let firmware = firmware_version(link.hello());
    let board = format!("{} {firmware}{simulated}", can.board());
    Ok(Moved {
        record,
        is_robot,
        board,
        plan,
    })
}

/// Refuses a robot whose program knows its loop, and a hand at one.
fn fits_robot(plan: &MeasurePlan, link: &SerialLink) -> Result<(), Failure> {
    let refused = if !link.capabilities().lets_go_alone.to_measure {
        "this robot's program has its bandwidth_hz and dead_time_s already: to measure them, start it with a file that has neither".to_owned()
    } else if plan.hand {
        format!("a robot is measured without a hand: omit {HELD}")
    } else {
        return Ok(());
    };
    Err(Failure::bad_input(refused))
}

/// Connects to the device of a plan; its loop is closed here. It gets the limits back that it has forgotten, and its link speaks of true
/// newtons if they are known. With it go what is set on it, and the plan within its limits.
pub(in crate::question) fn opened(
    plan: &MeasurePlan,
    remote: &RemoteDevice,
    warn: Warn<'_>,
    stop: &Arc<AtomicBool>,
) -> Result<(SerialLink, Configuration, MeasurePlan), Failure> {
    let mut link = (remote.name).connect_all(None, remote.patience, warn, Some(stop))?;
    remote.calibrate(&mut link)?;
    let axes = link.capabilities().axes;
    let MeasuredAxis(axis) = plan.axis;
    if axis >= usize::from(axes) {
        return Err(bad_input!(
            "`{}` = {} is not on {}, which has {axes} {}: omit it",
            MEASURE_AXIS.key,
            plan.axis.name(),
            remote.name,
            if axes == 1 { "axis" } else { "axes" },
        ));
    }
    let set = link.configuration();
    let (set, _) = set.map_err(|error| at_port(link.path(), &error))?;
    let plan = plan.within(OwnLimits::of(&set.limits, plan.axis));
    Ok((link, set, plan))
}

/// Sets the limits, arms the device and brings it to rest again; between, `conduct` has its axis within the limits of the plan.
pub(in crate::question) fn armed<T>(
    plan: &MeasurePlan,
    remote: &RemoteDevice,
    link: &mut SerialLink,
    set: &Configuration,
    warn: Warn<'_>,
    stop: &AtomicBool,
    conduct: impl FnOnce(&mut Stoppable<'_>) -> Result<T, DriveError<SerialError>>,
) -> Result<T, Failure> {
    let path = link.path().to_owned();
    let problem = |error| refused_at_port(&path, error);
    // The box is about the start, which is not known yet: the chain here watches over it.
    let limits = haptic_loop::SafetyLimits {
        workspace: None,
        ..plan.limits(0.0)
    };
    let simulation = Simulation {
        kind: SimulationKind::MassDamper,
        ..push(0.0)
    };
    let law = RemoteLaw::bare(limits, simulation);
    let remote = &RemoteDevice {
        loop_mode: LoopMode::Host,
        ..remote.clone()
    };
    let schedule = Schedule {
        samples: plan.ticks_at_most(),
        sample_time_s: plan.sample_time_s,
        pace: Pace::Realtime(RealtimeOptions::default()),
    };
    let configuration = agreed(remote, &law, schedule, link, set, &|text| warn(text))?;
    link.set_for(configuration, &law.operator.1, Scope::Run)
        .map_err(problem)?;
    link.arm(remote.watchdog()).map_err(problem)?;
    link.start(Start::ENDLESS).map_err(problem)?;
    let mut stoppable = Stoppable {
        axes: link.capabilities().axes,
        axis: plan.axis.0,
        link,
        stop,
    };
    let done = conduct(&mut stoppable);
    // After an error too: dropped, the link does it once more.
    let disarmed = link.disarm();
    let rests = disarmed.is_ok() && link.wait_for_rest();
    if let (None, Some(trouble)) = (link.lost_board(), link.trouble()) {
        warn(&trouble.words);
    }
    let done = done.map_err(|error| match error {
        DriveError::Plan(error) => Failure::input(error),
        DriveError::Said(failure) => failure,
        DriveError::Device(error) => {
            let stopped = error == LinkError::Stopped.into();
            if stopped && rests {
                return Failure::run(INTERRUPTED);
            }
            too_busy(&error, remote.lateness()).unwrap_or_else(|| at_port(&path, &error))
        }
    })?;
    disarmed.map_err(problem)?;
    Ok(done)
}

/// An axis of a link whose loop hears who stops it, even where no sample comes.
pub(in crate::question) struct Stoppable<'a> {
    link: &'a mut SerialLink,
    stop: &'a AtomicBool,
    axes: u8,
    axis: usize,
}

impl Stoppable<'_> {
    /// Force that the device says it applied in the newest tick, and the reading of its force sensor then, N; NaN without one.
    pub(in crate::question) fn forces_n(&self) -> [f64; 2] {
        let newest = self.link.newest();
        let applied = newest.axes.get(self.axis).map_or(0.0, |axis| axis.force_n);
        let sensed = newest.sensed_force_n.get(self.axis).copied();
        [applied, sensed.unwrap_or(f32::NAN)].map(f64::from)
    }

    fn read_of<const D: usize>(&mut self) -> Result<Reading<f64, 1>, SerialError> {
        let reading: Reading<f64, D> = self.link.read_or_stop(self.stop)?;
        Ok(Reading {
            tick: reading.tick,
            time_s: reading.time_s,
            position_m: SVector::from([reading.position_m[self.axis]]),
        })
    }
}

impl Device<f64, 1> for Stoppable<'_> {
    type Error = SerialError;

    fn read(&mut self) -> Result<Reading<f64, 1>, SerialError> {
        match self.axes {
            2 => self.read_of::<2>(),
            3 => self.read_of::<3>(),
            _ => self.read_of::<1>(),
        }
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), SerialError> {
        match self.axes {
            2 => self.link.write(force.on_axis::<2>(self.axis)),
            3 => self.link.write(force.on_axis::<3>(self.axis)),
            _ => self.link.write(force),
        }
    }

    fn let_go(&mut self) {
        match self.axes {
            2 => Device::<f64, 2>::let_go(self.link),
            3 => Device::<f64, 3>::let_go(self.link),
            _ => Device::<f64, 1>::let_go(self.link),
        }
    }
}

/// A fault that the machine makes, and no device: with its remedy.
fn too_busy(error: &SerialError, lateness: Lateness) -> Option<Failure> {
    let SerialError::Link(LinkError::Faulted(report)) = error else {
        return None;
    };
    let advice = lateness.advice(Fault::from_code(report.status.fault)?)?;
    Some(Failure::run(format_args!("{error}{advice}")))
}

#[cfg(all(test, feature = "bad-lines"))]
mod tests {
    use super::*;
    use haptic_loop::Fault;
    use haptic_run::remote::bad_line_tests::reported;

    #[test]
    fn a_fault_of_a_busy_machine_says_what_to_allow() {
        let lateness = Lateness {
            watchdog_ms: 20,
            max_age_ticks: 10,
        };
        let error = LinkError::Faulted(reported(Fault::HostSilent)).into();
        let failure = too_busy(&error, lateness).expect("the machine was busy");
        assert!(matches!(failure, Failure::Run(_)));
        assert!(failure.to_string().ends_with("`watchdog_s` = 0.1"));
    }
}
