//! Reports a press: what was measured, its curves, and the smallest modulus that this device and depth can tell.

use super::{PRESS_HOLD, PRESS_RAMP, Press, PressRecord};
use crate::{
    experiment::kind::Experiment as _,
    judge::{
        origin,
        report::{Files, Report, RunReport},
        warnings::Warnings,
    },
};
use haptic_document::{
    Failure, Named as _,
    parameters::{CONTROLLER, FORCE_LIMIT},
    rows,
};
use haptic_judge::{
    curves::{Curves, Drawing},
    sensed::SensedForce,
};
use haptic_quantity::written;
use haptic_run::{Ran, remote::device_name};
use haptic_trial::tick::KeptSample;
use serde_json::json;

/// A modulus below so many times the smallest one that can be told is hidden.
const HIDDEN: f64 = 3.0;

impl Press {
    /// The report of a run, with its record as a table and as curves where it reached its end.
    pub(super) fn report(&self, ran: &Ran) -> Result<(Report, Option<Curves>), Failure> {
        let mut samples: Vec<KeptSample> = Vec::new();
        ran.samples().for_each(|sample| {
            samples.push(*sample);
            Ok(())
        })?;
        let record = self.record(&samples);
        let force_n = &record.force_n;
        let table = ran.record.ended.is_none().then(|| {
            let mut table =
                (ran.folder).named_table_beside_log("csv", &["time_s", "position_m", "force_n"]);
            let motion = record.time_s.iter().zip(&record.depth_m);
            for ((time_s, depth_m), force_n) in motion.zip(force_n) {
                table.row([time_s, depth_m, force_n]);
            }
            table
        });
        let deepest_m = record.depth_m.iter().copied().fold(0.0, f64::max);
        let peak_n = record.peak_n();
        let noise_n = record.noise_n();
        let hiding_n = if record.is_sensed {
            2.0 * noise_n
        } else {
            2.0 * noise_n + self.device.friction.0
        };
        let per_pa = self.piece.shape_m() * self.piece.effective()(deepest_m);
        let least_pa = Some(hiding_n / per_pa).filter(|least| least.is_finite());
        let mut warnings = Warnings::default();
        if peak_n < HIDDEN * hiding_n {
            let [peak, hiding] = [peak_n, hiding_n].map(|force| written("force_n", force));
            warnings.0.push(format!(
                "the specimen is hidden: its largest force of {peak} is not {HIDDEN} times the {hiding} of friction and noise; press deeper, \
                 on a larger area, or with a force sensor"
            ));
        }
        warnings.0.extend(self.missed_depth(&samples, ran));
        let left = record.has_left();
        warnings.0.extend(left.map(|left| {
            format!("{left}, so `identify` reads what was before: give another {CONTROLLER}, or a longer {PRESS_RAMP}")
        }));
        let sensed = self.sensed(&record, &samples);
        warnings.0.extend(sensed.warnings(ran.record.sensor, true));
        warnings.0.extend(record.check_zero().err());
        let run = RunReport::new(
            ran,
            device_name(self.conduct.remote.as_ref()),
            self.sample_time_s(),
            Files::of_run(ran, table),
            warnings,
        );
        let law = json!({
            "protocol": self.protocol.name(),
            "loading": self.piece.specimen.loading().kind.name(),
            "controller": self.drive.name,
        });
        let results = json!({
            "force_source": if record.is_sensed { "sensor" } else { "motor" },
            "largest_depth_m": deepest_m,
            "largest_force_n": peak_n,
            "force_noise_n": noise_n,
            // Of the loading's kind, Pa: with it the force would be as large as friction and noise.
            "least_modulus_pa": least_pa,
            "drive_preflight": ran.drive,
        });
        let [depth, force] =
            [("depth_m", deepest_m), ("force_n", peak_n)].map(|(key, number)| written(key, number));
        let verdict = format!("pressed to {depth} with {force}");
        let is_whole = ran.record.ended.is_none();
        let curves = is_whole.then(|| self.curves(record, origin(&ran.record), &verdict));
        let report = Report {
            law: rows([law]),
            run,
            results: rows([results, sensed.rows(ran.record.sensor, None)]),
            verdict: Some(verdict),
            unmet: None,
        };
        Ok((report, curves))
    }

    /// The sensor beside the motor.
    fn sensed(&self, record: &PressRecord, samples: &[KeptSample]) -> SensedForce {
        let mut sensed = SensedForce::default();
        let begins = samples.partition_point(|sample| sample.time_s < self.path.rest_s);
        for (sample, motor_n) in samples[begins..].iter().zip(&record.motor_n) {
            sensed.add(sample, 0.0 - motor_n, None);
        }
        sensed
    }

    /// A handle that did not get where it was to press to.
    fn missed_depth(&self, samples: &[KeptSample], ran: &Ran) -> Option<String> {
        /// Share of the depth that counts as all of it.
        const REACHED: f64 = 0.95;
        let wanted_m = self.path.deepest_m();
        let reached_m = samples
            .iter()
            .map(|sample| sample.position_m)
            .fold(0.0, f64::max);
        if ran.record.ended.is_some() || reached_m >= REACHED * wanted_m {
            return None;
        }
        let [wanted, reached] = [wanted_m, reached_m].map(|depth_m| written("depth_m", depth_m));
        let largest_n = ran.record.largest_force_n();
        let remedy = if largest_n >= REACHED * self.drive.force_limit_n.min(self.limits.force.0) {
            format!("raise {FORCE_LIMIT}, or press less deep")
        } else {
            format!("give a longer {PRESS_HOLD}, or another {CONTROLLER}")
        };
        let force = written("force_n", largest_n);
        Some(format!(
            "the handle reached {reached} of {wanted}, with at most {force} of its motor: {remedy}"
        ))
    }

    fn curves(&self, record: PressRecord, origin: &'static str, verdict: &str) -> Curves {
        let wanted = record.time_s.iter().map(|t| self.path.at(*t).position_m);
        let mut columns = vec![
            ("reference_m", wanted.collect()),
            ("depth_m", record.depth_m),
            ("force_n", record.motor_n),
        ];
        if record.is_sensed {
            columns.push(("sensed_force_n", record.force_n));
        }
        let specimen = match &self.conduct.remote {
            Some(remote) => format!("device {}", device_name(Some(remote))),
            None => self.piece.material.name.clone(),
        };
        let loading = self.piece.specimen.loading().kind.name();
        Curves {
            title: format!("A press, {origin}"),
            subtitle: format!(
                "{specimen} · {loading} · {} · {verdict}",
                self.protocol.name()
            ),
            origin,
            time_s: record.time_s,
            columns,
            drawing: Drawing::Press,
        }
    }
}
