//! Judging a drive: how close it kept to its way, and with which force.
//!
//! The log has the way and what was measured at each tick; from the two the controller gives the same commands again, bit for bit.

use super::{ControllerHolder, Drive, DriveVerdict, set_point};
use crate::document::failure::Failure;
use crate::document::parameters::CONTROLLER;
use crate::experiment::drive::keys::DRIVE_FORCE_LIMIT;
use crate::judge::decimated::Decimated;
use crate::run::record::Record;
use crate::run::tick::KeptSample;
use haptic_loop::plant::{Holder, RigDrive};
use serde::Serialize;

/// The work of a drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveReport {
    /// The controller.
    pub controller: String,
    /// `position` in a relaxation, `force` in a creep test: what the controller holds, and the unit of the errors, m or N.
    pub quantity: &'static str,
    /// Largest |set point − measurement|, m or N.
    pub tracking_error_max: f64,
    /// Root of the mean square of it, m or N.
    pub tracking_error_rms: f64,
    /// |set point − measurement| of the last sample, m or N.
    pub tracking_error_final: f64,
    /// Largest force on the indenter, N.
    pub drive_force_peak_n: f64,
    /// Its limit, N.
    pub drive_force_limit_n: f64,
    /// Samples in which the limit acted.
    pub saturated_samples: u64,
    /// The verdict before the run.
    pub preflight: DriveVerdict,
}

impl DriveReport {
    /// The drive was at its limit, or runs though the analysis calls it unstable.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.saturated_samples > 0 {
            warnings.push(format!(
                "the drive was at its limit of {} N in {} samples: raise {DRIVE_FORCE_LIMIT}, or take a slower ramp or \
                 another {CONTROLLER}",
                self.drive_force_limit_n, self.saturated_samples
            ));
        }
        if !self.preflight.stable() {
            warnings.push(
                "pre-flight: the loop of the drive is unstable by the analysis; run all the same"
                    .to_owned(),
            );
        }
        warnings
    }
}

/// Tracking error and force of a drive. The slices belong together point by point.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveCurves {
    /// Unit of the error: m, or N in a creep test.
    pub unit: &'static str,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Set point − measurement.
    pub tracking_error: Vec<f64>,
    /// Force on the indenter, N.
    pub force_n: Vec<f64>,
}

/// Columns that a drive adds to the table of a run.
pub(crate) fn drive_columns(drive: RigDrive) -> [&'static str; 2] {
    match drive {
        RigDrive::Position(_) => ["indenter_position_m", "drive_force_n"],
        RigDrive::Force(_) => ["contact_force_n", "drive_force_n"],
    }
}

/// Judges sample by sample.
pub(crate) struct DriveJudge {
    drive: RigDrive,
    holder: ControllerHolder,
    report: DriveReport,
    samples: u64,
    squares: f64,
    curves: Decimated<2>,
}

impl DriveJudge {
    /// Of no sample yet.
    ///
    /// # Errors
    /// A controller that cannot be made.
    pub(crate) fn new(
        own: &Drive,
        drive: RigDrive,
        sample_time_s: f64,
        preflight: DriveVerdict,
        record: &Record,
    ) -> Result<Self, Failure> {
        Ok(Self {
            drive,
            holder: own.holder(sample_time_s)?,
            report: DriveReport {
                controller: own.name.clone(),
                quantity: match drive {
                    RigDrive::Position(_) => "position",
                    RigDrive::Force(_) => "force",
                },
                tracking_error_max: 0.0,
                tracking_error_rms: 0.0,
                tracking_error_final: 0.0,
                drive_force_peak_n: 0.0,
                drive_force_limit_n: own.force_limit_n,
                saturated_samples: 0,
                preflight,
            },
            samples: 0,
            squares: 0.0,
            curves: Decimated::of(record),
        })
    }

    /// Takes a sample in; the values of its columns.
    pub(crate) fn add(&mut self, sample: &KeptSample) -> [f64; 2] {
        let set_point = set_point(self.drive, sample.time_s);
        let measured = match self.drive {
            RigDrive::Position(_) => sample.indenter_position_m,
            RigDrive::Force(_) => sample.contact_force_n,
        };
        let force = self.holder.force(set_point, measured);
        let error = set_point - measured;
        let report = &mut self.report;
        report.tracking_error_max = report.tracking_error_max.max(error.abs());
        report.tracking_error_final = error.abs();
        report.drive_force_peak_n = report.drive_force_peak_n.max(force.abs());
        report.saturated_samples += u64::from(self.holder.limited);
        self.samples += 1;
        self.squares += error * error;
        self.curves.add(sample.time_s, [error, force]);
        [measured, force]
    }

    /// The report and the curves.
    pub(crate) fn finish(mut self) -> (DriveReport, DriveCurves) {
        self.curves.finish();
        if self.samples > 0 {
            self.report.tracking_error_rms = (self.squares / self.samples as f64).sqrt();
        }
        let [tracking_error, force_n] = self.curves.curves;
        let curves = DriveCurves {
            unit: match self.drive {
                RigDrive::Position(_) => "m",
                RigDrive::Force(_) => "N",
            },
            time_s: self.curves.time_s,
            tracking_error,
            force_n,
        };
        (self.report, curves)
    }
}

#[cfg(test)]
mod tests {
    use super::super::preflight::LoopVerdict;
    use super::*;
    use crate::run::simulate::Instrumented;
    use fracdiff::Seconds;
    use fractional_control::{ControllerSetup, PidParameters};
    use haptic_loop::Device;
    use haptic_loop::plant::{HeldRig, RampHold, RigConfig, RigContact};
    use haptic_loop::units::{Metres, Newtons};
    use nalgebra::Vector1;

    #[test]
    fn the_commands_that_are_judged_are_those_that_were_given_bit_for_bit() {
        let t = 1e-3;
        let gains: PidParameters = "900+9000/s^0.9+25s^0.9".parse().expect("a controller");
        let own = Drive {
            name: "own".to_owned(),
            controller: ControllerSetup::new(gains, Seconds(t)).into(),
            force_limit_n: 0.2,
        };
        let stable = LoopVerdict {
            stable_beyond_gain: None,
            stable: true,
            phase_margin_rad: None,
            crossover_rad_s: None,
            gain_margin: None,
            delay_margin_s: None,
        };
        let verdict = DriveVerdict {
            free: None,
            in_contact: stable,
            holding_stiffness_n_per_m: None,
        };
        let record = Record::with_room_for(500).expect("room");
        let ramp = RampHold::new(Metres(1e-3), Seconds(0.05)).expect("a ramp");
        for drive in [RigDrive::Position(ramp), RigDrive::Force(Newtons(0.1))] {
            let config = RigConfig::new(drive, RigContact::COMPLIANT, Seconds(t));
            let holder = own.holder(t).expect("a controller");
            let rig = Box::new(HeldRig::new(config, holder).expect("a rig"));
            let mut rig = super::super::SimulatedRig::Held(rig);
            let mut judge = DriveJudge::new(&own, drive, t, verdict, &record).expect("a judge");
            let mut peak: f64 = 0.0;
            for tick in 0..500 {
                let seen = rig.observe();
                let reading = Device::<f64, 1>::read(&mut rig).expect("never fails");
                let force_n = -300.0 * reading.position_m[0];
                rig.write(testkit::device::safe(Vector1::new(force_n)))
                    .expect("never fails");
                let [_, judged] = judge.add(&KeptSample {
                    tick,
                    time_s: reading.time_s,
                    position_m: reading.position_m[0],
                    force_n,
                    applied_force_n: force_n,
                    indenter_position_m: seen.indenter_position_m[0],
                    contact_force_n: seen.contact_force_n[0],
                    limiters: 0,
                });
                let super::super::SimulatedRig::Held(held) = &rig else {
                    unreachable!()
                };
                assert_eq!(judged.to_bits(), held.drive_force().to_bits(), "{tick}");
                peak = peak.max(judged.abs());
            }
            let (report, curves) = judge.finish();
            assert_eq!(report.drive_force_peak_n.to_bits(), peak.to_bits());
            assert_eq!(curves.time_s.len(), 500);
            // The ramp is steep, and the gain is large for a force: the limit acts at first.
            assert!(report.saturated_samples > 0 && report.saturated_samples <= 500);
        }
    }
}
