//! Judges a wall that was run: does it settle, and was each force right?

use super::report::{WallCurves, WallReport};
use super::specification::WallExperiment;
use crate::document::failure::Failure;
use crate::experiment::trial::{Trial as _, Verdict, incomparable, six_digits, verdict};
use crate::judge::curves::Origin;
use crate::judge::decimated::Decimated;
use crate::judge::modelled_tissue::memory;
use crate::judge::reference::{ReferenceSeries, operator};
use crate::judge::settling::{Judge, Settling};
use crate::judge::{Reference, full_history};
use crate::run::Ran;
use crate::run::samples::Samples;
use fracdiff::{FrequencyResponse as _, Operator};

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
        let rate = self.setup.device.sample_time.rate_to_the(self.order);
        let at_rest = operator.response(0.0).re * rate.map_err(Failure::input)?;
        let spring = self.stiffness_n_per_m
            + self.setup.device.stiffness.0
            + self.dissipation_n_s_mu_per_m * at_rest;
        Ok(Some(self.setup.plan.push_n / spring).filter(|x| x.is_finite() && spring > 0.0))
    }

    /// D^μ x by the full history of x, or why the force is not −(K·x + B·D^μ x) of it.
    fn derivative(&self, ran: &Ran) -> Result<Result<ReferenceSeries<'_>, &'static str>, Failure> {
        let record = &ran.record;
        let kernel = Reference::of(self.scheme);
        let reason = (self.one_sided.then_some("a one-sided wall is not compared"))
            .or_else(|| incomparable(kernel, self.order, record));
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        let t = self.setup.device.sample_time;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        if let Some(model) = &self.model {
            let memory = ReferenceSeries::new(
                samples,
                |x| {
                    Ok(x.iter()
                        .copied()
                        .map(memory(model, t, x.len() as u64)?)
                        .collect())
                },
                || {
                    let mut step = memory(model, t, self.setup.plan().samples(t)?)?;
                    Ok(Box::new(move |_, x| step(x)))
                },
            )?;
            return Ok(Ok(memory));
        }
        let derivative = ReferenceSeries::new(
            samples,
            |x| full_history(kernel, self.order, t, x).map_err(Failure::Run),
            || {
                let planned = self.setup.plan().samples(t)?;
                let mut channel = operator(kernel, self.order, t, planned)?;
                Ok(Box::new(move |_, x| channel.step(x)))
            },
        )?;
        Ok(Ok(derivative))
    }

    pub(super) fn publish(
        &self,
        ran: &Ran,
        judge: Judge,
        rest_m: Option<f64>,
    ) -> Result<(WallReport, Option<WallCurves>), Failure> {
        let (trial, curves) = self.reported(ran, (judge, rest_m), || self.judge(ran))?;
        let settling = trial.settling;
        let report = WallReport {
            trial,
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
        };
        let curves = curves.map(|(origin, curves)| self.drawn(origin, curves, settling));
        Ok((report, curves))
    }

    /// Writes the table of a run that reached its end, and holds each force against theory.
    fn judge(&self, ran: &Ran) -> Result<Verdict<2>, Failure> {
        let mut derivative = self.derivative(ran)?;
        let reason = derivative.as_ref().err().copied();
        verdict(ran, ["position_m", "reaction_force_n"], reason, |sample| {
            let (x, reaction_force_n) = (sample.position_m, sample.reaction_n());
            let off = derivative.as_mut().map_or(0.0, |derivative| {
                let d = derivative.at(sample);
                let wanted = -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d);
                (sample.force_n - wanted).abs()
            });
            (off, [x, reaction_force_n])
        })
    }

    /// The curves, and what to say of them.
    fn drawn(&self, origin: Origin, curves: Decimated<2>, settling: Settling) -> WallCurves {
        let subtitle = format!(
            "order μ = {} · K = {} N/m · B = {} N·s^μ/m · {}",
            self.order,
            six_digits(self.stiffness_n_per_m),
            six_digits(self.dissipation_n_s_mu_per_m),
            self.setup.words(self.scheme, &settling)
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
