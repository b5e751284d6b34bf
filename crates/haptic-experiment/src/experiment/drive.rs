//! A controller that holds the indenter of the rig: the indenter is a mass, the tissue pushes it back, the controller keeps it on its way.
//!
//! ```text
//! relaxation   r the ramp, y the place of the indenter, m        u the force on the indenter, N
//! creep        r the push, y the force between the actuators, N  |u| ≤ the limit of the drive
//! ```
//! The tissue is judged as ever: by the sum over the motion that was really made.

mod judge;
mod path;
mod preflight;
mod second;
#[cfg(test)]
mod tests;

use fracdiff::parameter::Shown;
use fractional_control::{ControlError, ControllerSetup};
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, FileError, Table, bad_input,
    parameters::{
        CONTROLLER, DEVICE, DRIVE_DEVICE, DRIVE_DEVICE_MODEL, DRIVE_LOOP, SAMPLE_TIME,
        range::FORCE_LIMITS,
    },
};
use haptic_judge::controller_holder::ControllerHolder;
use haptic_link::{ControllerLaw, OperatorShape};
use haptic_loop::{
    Environment,
    nalgebra::SVector,
    plant::{FacingContact, RampHold, RigDrive},
    units::{NewtonSecondsPerMetre, NewtonsPerMetre},
};
use haptic_quantity::written;
use haptic_run::{device::DeviceName, remote::RemoteDevice};
use haptic_trial::{
    ControllerFile, DeviceModel,
    advice::single,
    device_table::{device_model_by, without},
    keys::drive::{CONTACT_DAMPING, CONTACT_STIFFNESS, DRIVE, DRIVE_FORCE_LIMIT},
};
pub(crate) use judge::{DriveJudge, DriveReport, drive_columns};
pub(crate) use path::{PressPath, Section};
pub(crate) use preflight::{TissueLaw, device};
pub(crate) use second::{DriveSamples, SecondReport, tell};
use std::{
    fmt::Debug,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

/// `[drive]`, beside an experiment on this device, of which a file may say more; its tissue resists with this peak, N.
pub(crate) fn drive(
    table: &Table<'_>,
    tissue: Option<&RemoteDevice>,
    model: Option<DeviceModel>,
    peak_n: f64,
) -> Result<Drive, FileError> {
    table.required_text(&CONTROLLER)?;
    let path = table.file(&CONTROLLER)?.unwrap_or_default();
    let moved = if table.has(&DRIVE_DEVICE) {
        device_model_by(table, &DRIVE_DEVICE_MODEL)?
    } else {
        model
    };
    let friction_n = moved.map_or(0.0, |model| model.values.friction_n);
    let given = table.number_if(&DRIVE_FORCE_LIMIT)?;
    let [.., most] = FORCE_LIMITS.ends();
    Ok(Drive {
        name: path.display().to_string(),
        force_limit_n: given.unwrap_or((4.0 * peak_n + 2.0 * friction_n).min(most)),
        force_limit_reason: given.is_none().then(|| {
            let [peak, friction] = [peak_n, friction_n].map(|force| written("force_n", force));
            format!("four times the predicted peak of {peak}, twice the friction of {friction}")
        }),
        controller: match table.logged(&CONTROLLER) {
            Some(text) => ControllerFile::parse(&path, text)?,
            None => ControllerFile::read(&path)?,
        },
        device: second_device(table, tissue)?,
    })
}

/// The device of a drive, if it is another one than that of the tissue, or of the law that it pushes into.
pub(crate) fn second_device(
    table: &Table<'_>,
    tissue: Option<&RemoteDevice>,
) -> Result<Option<DriveDevice>, FileError> {
    if !table.has(&DRIVE_DEVICE) {
        let idle = format!("without a second device: give {DRIVE_DEVICE} too, as serial:PATH");
        let [_, _, _, rest @ ..] = DRIVE else {
            return Ok(None);
        };
        return without(table, rest, &idle).map(|()| None);
    }
    let fail = |reason: String| table.fail_at(DRIVE_DEVICE.key, reason);
    let named = table.text(&DRIVE_DEVICE)?;
    let name = named.parse::<DeviceName>().map_err(fail)?.0;
    let (Some(name), Some(tissue)) = (name, tissue) else {
        return Err(fail(format!(
            "drive_device = \"{named}\", but both devices of a drive are at ports or neither is: give {} and {}, or omit {DRIVE_DEVICE}",
            DEVICE.set_to("serial:PATH"),
            DRIVE_DEVICE.set_to("serial:PATH")
        )));
    };
    if tissue.name.may_be(&name) {
        return Err(fail(format!(
            "drive_device = \"{named}\" may be the same device as {}: name two, each by its own path",
            DEVICE.set_to(&tissue.name)
        )));
    }
    let model = device_model_by(table, &DRIVE_DEVICE_MODEL)?;
    Ok(Some(DriveDevice {
        remote: RemoteDevice {
            name,
            loop_mode: table.choice(&DRIVE_LOOP)?,
            calibration: model.as_ref().and_then(|model| model.calibration.clone()),
            ..tissue.clone()
        },
        dynamics: model.map(|model| model.values.dynamics()),
        contact: FacingContact {
            stiffness: NewtonsPerMetre(table.number(&CONTACT_STIFFNESS)?),
            damping: NewtonSecondsPerMetre(table.number(&CONTACT_DAMPING)?),
            ..FacingContact::COMPLIANT
        },
    }))
}

/// A second device, which a controller moves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DriveDevice {
    pub remote: RemoteDevice,
    /// Dynamics by its model file; `None` without one.
    pub dynamics: Option<Dynamics>,
    /// Its contact with the tissue's device.
    pub contact: FacingContact,
}

/// A controller for the indenter, and the largest force of its motor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    /// Its name in logs and reports: the path of its file.
    pub name: String,
    /// The controller: from m, or N in a creep test, to N.
    pub controller: ControllerFile,
    /// Largest force on the indenter, N, above 0. The limits of the controller hold beside it.
    pub force_limit_n: f64,
    /// Words for a limit that nobody gave.
    pub force_limit_reason: Option<String>,
    /// The device that it moves, if that is another one than the tissue's.
    pub device: Option<DriveDevice>,
}

impl Drive {
    /// The controller within the limits of its motor, if it is made for this sample time.
    fn limited(&self, sample_time_s: f64) -> Result<ControllerSetup, Failure> {
        let limit = self.force_limit_n;
        if !DRIVE_FORCE_LIMIT.range().contains(limit) {
            return Err(bad_input!(
                "drive force limit {} N is not {} N: change {DRIVE_FORCE_LIMIT}",
                Shown(limit),
                DRIVE_FORCE_LIMIT.range()
            ));
        }
        let made_for_s = self.controller.setup.sample_time_s;
        if (made_for_s / sample_time_s - 1.0).abs() > 1e-9 {
            return Err(bad_input!(
                "drive {}: made for a sample time of {made_for_s} s, not {sample_time_s} s: change {SAMPLE_TIME} or {CONTROLLER}",
                self.name
            ));
        }
        let mut limited = self.controller.setup.clone();
        let within = |end: Option<f64>, most: f64| end.map_or(most, |end| end.clamp(-limit, limit));
        limited.output_low = Some(within(limited.output_low, -limit));
        limited.output_high = Some(within(limited.output_high, limit));
        Ok(limited)
    }

    /// The controller at rest, at this sample time.
    pub(crate) fn holder(&self, sample_time_s: f64) -> Result<ControllerHolder, Failure> {
        let limited = self.limited(sample_time_s)?;
        ControllerHolder::new(&limited).map_err(|error| self.refused(&error))
    }

    /// The controller as a device runs it on this way, at this sample time.
    pub(crate) fn portable(
        &self,
        way: RampHold,
        sample_time_s: f64,
    ) -> Result<(OperatorShape, Vec<f32>, ControllerLaw), Failure> {
        let limited = self.limited(sample_time_s)?;
        let depth_m = single("depth", way.depth().0)?;
        let ramp_ticks = (way.ramp_time().0 / sample_time_s).round() as u32;
        haptic_remote::controller_law(&limited, depth_m, ramp_ticks, self.force_limit_n as f32)
            .map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &ControlError) -> Failure {
        bad_input!("drive {}: {error}", self.name)
    }
}

/// The set point of a tick: m, or N in a creep test.
pub(crate) fn set_point(drive: RigDrive, time_s: f64) -> f64 {
    match drive {
        RigDrive::Position(profile) => profile.position(time_s),
        RigDrive::Force(push) => push.0,
    }
}

/// Set points of a drive.
#[derive(Clone, Debug)]
enum Way {
    Rig(RigDrive),
    Press(Arc<PressPath>),
}

/// The controller of a drive that closes the loop of its device from here, tick by tick from the start of its run.
#[derive(Debug)]
pub(crate) struct HostDrive {
    at_rest: ControllerHolder,
    way: Way,
    sample_time_s: f64,
    /// The newest force that the other device opposes, N, as its bits: what is measured in a creep test.
    opposed_n: Arc<AtomicU64>,
}

impl Drive {
    /// The controller for a loop here, in which the other device opposes this force, N, as its bits.
    pub(crate) fn on_host(
        &self,
        load: RigDrive,
        sample_time_s: f64,
        opposed_n: Arc<AtomicU64>,
    ) -> Result<HostDrive, Failure> {
        Ok(HostDrive {
            at_rest: self.holder(sample_time_s)?,
            way: Way::Rig(load),
            sample_time_s,
            opposed_n,
        })
    }

    /// The controller for a loop here that leads a handle along this path.
    pub(crate) fn along(
        &self,
        path: Arc<PressPath>,
        sample_time_s: f64,
    ) -> Result<HostDrive, Failure> {
        Ok(HostDrive {
            at_rest: self.holder(sample_time_s)?,
            way: Way::Press(path),
            sample_time_s,
            opposed_n: Arc::default(),
        })
    }
}

/// A controller, and the tick that comes next.
#[derive(Clone, Debug)]
pub(crate) struct HostHistory {
    holder: ControllerHolder,
    tick: u64,
}

impl HostDrive {
    fn set_point(&self, history: &HostHistory) -> f64 {
        let time_s = history.tick as f64 * self.sample_time_s;
        match &self.way {
            Way::Rig(load) => set_point(*load, time_s),
            Way::Press(path) => path.at(time_s).position_m,
        }
    }

    /// True while nothing is held yet.
    fn rests(&self, history: &HostHistory) -> bool {
        let time_s = history.tick as f64 * self.sample_time_s;
        matches!(&self.way, Way::Press(path) if path.rests(time_s))
    }
}

impl Environment<f64, 1> for HostDrive {
    type History = HostHistory;

    fn at_rest(&self) -> HostHistory {
        let holder = self.at_rest.clone();
        HostHistory { holder, tick: 0 }
    }

    fn force(&self, history: &HostHistory, position_m: &SVector<f64, 1>) -> SVector<f64, 1> {
        self.force_and_input(history, position_m).0
    }

    fn advance(&self, history: &mut HostHistory, position_m: &SVector<f64, 1>) {
        let (force, input) = self.force_and_input(history, position_m);
        self.advance_applied(history, &input, &force);
    }

    /// The input is what the controller measures.
    fn force_and_input(
        &self,
        history: &HostHistory,
        position_m: &SVector<f64, 1>,
    ) -> (SVector<f64, 1>, SVector<f64, 1>) {
        let measured = match &self.way {
            Way::Rig(RigDrive::Position(_)) | Way::Press(_) => position_m[0],
            Way::Rig(RigDrive::Force(_)) => f64::from_bits(self.opposed_n.load(Ordering::Relaxed)),
        };
        if self.rests(history) {
            return ([0.0].into(), [measured].into());
        }
        let command = history.holder.command(self.set_point(history), measured);
        ([command].into(), [measured].into())
    }

    fn advance_applied(
        &self,
        history: &mut HostHistory,
        input: &SVector<f64, 1>,
        applied_n: &SVector<f64, 1>,
    ) {
        if !self.rests(history) {
            let set_point = self.set_point(history);
            (history.holder).advance(set_point, input[0], applied_n[0]);
        }
        history.tick += 1;
    }
}
