//! Judges how well a drive kept its set point.

use super::{Drive, second::SecondReport, set_point};
use haptic_document::{Failure, parameters::CONTROLLER};
use haptic_judge::controller_holder::ControllerHolder;
use haptic_loop::plant::{Holder as _, RigDrive};
use haptic_trial::{drive_verdict::DriveVerdict, keys::drive::DRIVE_FORCE_LIMIT, tick::KeptSample};
use serde::Serialize;

/// The work of a drive.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct DriveReport {
    pub controller: String,
    /// `position` in a relaxation, `force` in a creep test: what the controller holds, and the unit of the errors, m or N.
    pub quantity: &'static str,
    /// Largest |set point − measurement|, m or N.
    pub tracking_error_max: f64,
    /// Root mean square of that error, m or N.
    pub tracking_error_rms: f64,
    /// |set point − measurement| of the last sample, m or N.
    pub tracking_error_final: f64,
    /// Largest force on the indenter, N.
    pub drive_force_peak_n: f64,
    pub drive_force_limit_n: f64,
    pub drive_force_limit_reason: Option<String>,
    /// Samples in which the limit acted.
    pub saturated_samples: u64,
    /// The verdict before the run; null if it was skipped.
    pub preflight: Option<DriveVerdict>,
    /// Report of the drive's own device, if it has one.
    #[serde(flatten)]
    pub second: Option<SecondReport>,
}

impl DriveReport {
    /// The drive was at its limit, or runs though the analysis calls it unstable.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.saturated_samples > 0 {
            warnings.push(format!(
                "the drive was at its limit of {} N in {} samples: raise {DRIVE_FORCE_LIMIT}, or change {CONTROLLER}",
                self.drive_force_limit_n, self.saturated_samples
            ));
        }
        if self.preflight.is_some_and(|verdict| !verdict.stable()) {
            warnings.push(
                "pre-flight: the loop of the drive is unstable by the analysis; it runs anyway"
                    .to_owned(),
            );
        }
        warnings
    }
}

/// Columns that a drive adds to the table of a run.
pub(crate) fn drive_columns(drive: RigDrive) -> [&'static str; 2] {
    match drive {
        RigDrive::Position(_) => ["indenter_position_m", "drive_force_n"],
        RigDrive::Force(_) => ["contact_force_n", "drive_force_n"],
    }
}

enum Maker {
    /// The rig, which does not report them: they are computed again.
    Rig(ControllerHolder),
    /// The device, whose forces they are, within these limits, N.
    Device([f32; 2]),
}

pub(crate) struct DriveJudge {
    load: RigDrive,
    maker: Maker,
    report: DriveReport,
    samples: u64,
    squares: f64,
}

impl DriveJudge {
    pub(crate) fn new(
        drive: &Drive,
        load: RigDrive,
        sample_time_s: f64,
        preflight: Option<DriveVerdict>,
        on_device: bool,
    ) -> Result<Self, Failure> {
        let maker = if !on_device {
            Maker::Rig(drive.holder(sample_time_s)?)
        } else {
            let setup = drive.limited(sample_time_s)?;
            let ends = [setup.output_low, setup.output_high];
            Maker::Device(ends.map(|end| end.unwrap_or(f64::NAN) as f32))
        };
        Ok(Self {
            load,
            maker,
            report: DriveReport {
                controller: drive.name.clone(),
                quantity: match load {
                    RigDrive::Position(_) => "position",
                    RigDrive::Force(_) => "force",
                },
                drive_force_limit_n: drive.force_limit_n,
                drive_force_limit_reason: drive.force_limit_reason.clone(),
                preflight,
                ..DriveReport::default()
            },
            samples: 0,
            squares: 0.0,
        })
    }

    /// Takes a sample in: set point − measurement, and the values of its columns.
    pub(crate) fn add(&mut self, sample: &KeptSample) -> (f64, [f64; 2]) {
        let set_point = set_point(self.load, sample.time_s);
        let measured = match (self.load, &self.maker) {
            (RigDrive::Position(_), Maker::Rig(_)) => sample.indenter_position_m,
            (RigDrive::Position(_), Maker::Device(_)) => sample.position_m,
            (RigDrive::Force(_), _) => sample.contact_force_n,
        };
        let (force, limited) = match &mut self.maker {
            Maker::Rig(holder) => (holder.force(set_point, measured), holder.limited),
            Maker::Device(ends) => {
                let force_n = sample.force_n;
                (force_n, ends.contains(&(force_n as f32)))
            }
        };
        let error = set_point - measured;
        let report = &mut self.report;
        report.tracking_error_max = report.tracking_error_max.max(error.abs());
        report.tracking_error_final = error.abs();
        report.drive_force_peak_n = report.drive_force_peak_n.max(force.abs());
        report.saturated_samples += u64::from(limited);
        self.samples += 1;
        self.squares += error * error;
        (error, [measured, force])
    }

    pub(crate) fn finish(mut self) -> DriveReport {
        if self.samples > 0 {
            self.report.tracking_error_rms = (self.squares / self.samples as f64).sqrt();
        }
        self.report
    }
}
