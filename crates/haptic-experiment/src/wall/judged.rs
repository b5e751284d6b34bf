//! Judges a wall that was run: does it settle, and was each force right?

use super::report::WallReport;
use super::specification::WallExperiment;
use crate::curves::{Origin, WallCurves};
use crate::failure::Failure;
use crate::judge::{Compared, Reference, full_history};
use crate::kept::{Record, Samples, WHOLE_MOST};
use crate::modelled::memory;
use crate::outcome::origin;
use crate::pushed::{Setup, six_digits, warnings};
use crate::remote::device_name;
use crate::report::{Errors, Files, RunReport};
use crate::run::Ran;
use crate::settling::{Judge, Settling};
use crate::thinned::Thinned;
use crate::track::{TOLERANCE, Track, operator};
use fracdiff::full_memory::Kernel;
use fracdiff::{FrequencyResponse as _, Operator};
use serde::Serialize;

/// A row of the CSV.
#[derive(Serialize)]
struct Row {
    time_s: f64,
    position_m: f64,
    reaction_force_n: f64,
}

/// Results of a run that reached its end.
struct Judged {
    csv: String,
    curves: Thinned<2>,
    /// See [`Errors::max_relative_error`].
    operator_error: Compared,
}

impl WallExperiment {
    /// Judges a run again.
    #[cfg(test)]
    pub(crate) fn report(&self, ran: &Ran) -> Result<(WallReport, Option<WallCurves>), Failure> {
        let parts = self.parts()?;
        self.publish(ran, parts.judge, parts.rest_m)
    }

    /// push/(K + k + B·T^(−μ)·P(1)), m: P(1), the gain of the operator at rest, is 1 for the identity, 0
    /// for a good derivative, and something else for one that forgets.
    ///
    /// # Errors
    /// A sample time outside its range.
    pub(super) fn expected_deflection(
        &self,
        operator: &Operator<f64>,
    ) -> Result<Option<f64>, Failure> {
        let rate = self.device.sample_time.rate_to_the(self.order);
        let at_rest = operator.response(0.0).re * rate.map_err(Failure::input)?;
        let spring = self.stiffness_n_per_m
            + self.device.stiffness.0
            + self.dissipation_n_s_mu_per_m * at_rest;
        Ok(Some(self.plan.push_n / spring).filter(|x| x.is_finite() && spring > 0.0))
    }

    /// D^μ x by the full history of x, or why the force is not −(K·x + B·D^μ x) of it.
    fn derivative(&self, ran: &Ran) -> Result<Result<Track<'_>, &'static str>, Failure> {
        let record = &ran.record;
        let kernel = Reference::of(self.scheme);
        let reason = if self.one_sided {
            Some("a one-sided wall is not compared")
        } else if record.limited > 0 {
            Some("the safety chain limited the force")
        } else if kernel == Reference::Kernel(Kernel::PiecewiseLinear) && self.order.get() >= 1.0 {
            Some("the weights of this kernel are known in closed form below order 1 only")
        } else if record.largest_force_n() == 0.0 {
            Some("no force was commanded")
        } else {
            None
        };
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        let t = self.device.sample_time;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        if let Some(model) = &self.model {
            let memory = Track::new(
                samples,
                |x| {
                    Ok(x.iter()
                        .copied()
                        .map(memory(model, t, x.len() as u64)?)
                        .collect())
                },
                || {
                    let mut step = memory(model, t, self.plan().samples(t)?)?;
                    Ok(Box::new(move |_, x| step(x)))
                },
            )?;
            return Ok(Ok(memory));
        }
        let derivative = Track::new(
            samples,
            |x| full_history(kernel, self.order, t, x).map_err(Failure::Run),
            || {
                let planned = self.plan().samples(t)?;
                let mut channel = operator(kernel, self.order, t, planned)?;
                Ok(Box::new(move |_, x| channel.step(x)))
            },
        )?;
        Ok(Ok(derivative))
    }

    /// Mean deflection over the window at the end against push/(K + k).
    fn deflection_error(&self, record: &Record, settling: Settling) -> Compared {
        let (window_s, judged) = self.setup().window(record);
        match (settling.deflection_m, settling.expected_deflection_m) {
            (Some(have), Some(want)) if settling.stable => {
                Compared::of_window((have / want - 1.0).abs(), window_s, judged)
            }
            (Some(_), None) => Compared::without_meaning(
                "no spring holds the push, so there is no place of rest".to_owned(),
            ),
            _ => Compared::without_meaning("the wall did not come to rest".to_owned()),
        }
    }

    pub(super) fn publish(
        &self,
        ran: &Ran,
        judge: Judge,
        rest_m: Option<f64>,
    ) -> Result<(WallReport, Option<WallCurves>), Failure> {
        let Ran { record, folder, .. } = ran;
        let whole = record.ended.is_none();
        let settling = self.named(Setup::settling(judge, ran, rest_m)?)?;
        let agrees =
            (ran.preflight.filter(|_| whole)).map(|analysis| analysis.stable == settling.stable);
        let warnings = warnings("wall", &settling, agrees, record);
        let mut files = Files::default();
        let mut curves = None;
        let mut operator_error = Compared::without_meaning("the run was cut short".to_owned());
        if whole {
            let judged = self.judge(ran)?;
            operator_error = judged.operator_error;
            files.csv = Some(judged.csv);
            curves = Some(self.drawn(origin(record), judged.curves, settling));
        } else {
            folder.remove_stale_results();
        }
        let report = WallReport {
            tissue: None,
            order: self.order.get(),
            scheme: self.scheme.to_string(),
            run: RunReport::new(
                ran,
                device_name(self.remote.as_ref()),
                self.device.sample_time.0,
                files,
                warnings,
            ),
            errors: Errors::new(operator_error, self.deflection_error(record, settling)),
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            settling,
            analysis_agrees: agrees,
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
        };
        Ok((report, curves))
    }

    /// Writes the table of a run that reached its end, and holds each force against theory.
    fn judge(&self, ran: &Ran) -> Result<Judged, Failure> {
        let record = &ran.record;
        let mut derivative = self.derivative(ran)?;
        let mut table = ran.folder.table_beside_log("csv")?;
        let dense = if record.whole.is_some() {
            WHOLE_MOST
        } else {
            0
        };
        let mut curves = Thinned::new(dense);
        let mut off: f64 = 0.0;
        Samples::of(record, &ran.log.paths).for_each(|sample| {
            let (x, reaction_force_n) = (sample.position_m, sample.reaction_n());
            if let Ok(derivative) = &mut derivative {
                let d = derivative.at(sample);
                let wanted = -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d);
                off = off.max((sample.force_n - wanted).abs());
            }
            curves.add(sample.time_s, [x, reaction_force_n]);
            table.row(&Row {
                time_s: sample.time_s,
                position_m: x,
                reaction_force_n,
            })
        })?;
        curves.finish();
        let operator_error = match derivative {
            Ok(_) => Compared::of_window(
                off / record.largest_force_n(),
                [0.0, record.duration_s()],
                record.samples,
            ),
            Err(reason) => Compared::without_meaning(reason.to_owned()),
        };
        Ok(Judged {
            csv: table.finish()?,
            curves,
            operator_error,
        })
    }

    /// The curves, and what to say of them.
    fn drawn(&self, origin: Origin, curves: Thinned<2>, settling: Settling) -> WallCurves {
        let subtitle = format!(
            "order μ = {} · K = {} N/m · B = {} N·s^μ/m · {}",
            self.order,
            six_digits(self.stiffness_n_per_m),
            six_digits(self.dissipation_n_s_mu_per_m),
            self.setup().words(self.scheme, &settling)
        );
        let [position_m, force_n] = curves.curves;
        WallCurves {
            subtitle,
            origin,
            expected_deflection_m: settling.expected_deflection_m,
            time_s: curves.time_s,
            position_m,
            force_n,
        }
    }
}
