//! An experiment on a pushed device: what a wall and a coupler tell of themselves, and what follows for both.

use super::described::warnings;
use super::report::TrialReport;
use super::setup::{Parts, TrialSetup};
use super::verdict::Verdict;
use crate::document::failure::Failure;
use crate::judge::Compared;
use crate::judge::curves::{Origin, Published};
use crate::judge::decimated::Decimated;
use crate::judge::reference::TOLERANCE;
use crate::judge::report::{Errors, Files, RunReport};
use crate::judge::settling::{Judge, Settling};
use crate::run::folder::FolderRequest;
use crate::run::preflight::PreflightSubject;
use crate::run::remote::{RemoteDevice, RemoteLaw, device_name};
use crate::run::{Ran, Supervisor};
use fracdiff::{Order, Scheme};
use haptic_loop::Environment;

/// An experiment on a pushed device.
pub(crate) trait Trial: Clone {
    /// The law that the device feels.
    type Law: Environment<f64, 1>;
    /// The word for it.
    const KIND: &'static str;
    /// Reason for a push that no place of rest belongs to.
    const NO_REST: &'static str;

    /// All but the law.
    fn setup(&self) -> &TrialSetup;

    /// μ, and the operator.
    fn operator_choice(&self) -> (Order, Scheme);

    /// The same, to change it.
    fn setup_mut(&mut self) -> &mut TrialSetup;

    /// The loop, made of good parameters.
    ///
    /// # Errors
    /// A parameter outside its range.
    fn parts(&self) -> Result<Parts<Self::Law>, Failure>;

    /// The loop for the analysis.
    fn subject(&self, samples: u64) -> impl PreflightSubject;

    /// The same law and push for a serial device.
    ///
    /// # Errors
    /// An operator that does not fit there.
    fn law_there(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure>;

    /// Names and values of the law, beside those of the operator.
    fn law_in_numbers(&self) -> Vec<(&'static str, String)>;

    /// A further warning about a run.
    fn warning(&self, _: &Ran) -> Option<String> {
        None
    }

    /// Runs the loop and writes the log, and makes the report with its curves, as [`reported`](Self::reported).
    ///
    /// # Errors
    /// Those of both.
    fn published<R, C>(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
        report: impl FnOnce(&Ran, Judge, Option<f64>) -> Result<(R, Option<C>), Failure>,
    ) -> Result<Published<R, C>, Failure> {
        let (ran, judge, rest_m) = self.recorded(request, supervisor)?;
        Ok(Published::new(report(&ran, judge, rest_m)?, ran.folder))
    }

    /// Runs the loop and writes the log; with the run its judge and the place of rest.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log that cannot be written.
    fn recorded(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<(Ran, Judge, Option<f64>), Failure> {
        let mut parts = self.parts()?;
        let (judge, rest_m, samples) = (parts.judge, parts.rest_m, parts.samples);
        let law = |remote: &RemoteDevice| self.law_there(remote, samples);
        let setup = self.setup();
        let metadata = setup.metadata(Self::KIND, self.operator_choice(), self.law_in_numbers());
        let (subject, files) = (self.subject(samples), (request, metadata));
        let ran = setup.record(&mut parts, subject, law, files, supervisor)?;
        Ok((ran, judge, rest_m))
    }

    /// Runs it without log or files: does it settle?
    ///
    /// # Errors
    /// Bad parameters.
    fn tried(&self) -> Result<Settling, Failure> {
        Ok(self.parts()?.try_out())
    }

    /// The same judgement, unless friction alone holds the device: then it is called that.
    ///
    /// # Errors
    /// Those of the trial.
    fn named(&self, settling: Settling) -> Result<Settling, Failure> {
        let Some(smooth) = self.setup().smooth().filter(|_| settling.stable) else {
            return Ok(settling);
        };
        let mut other = self.clone();
        *other.setup_mut() = smooth;
        match other.tried()?.stable {
            true => Ok(settling),
            false => Ok(settling.by_friction()),
        }
    }

    /// The report of a run, and its curves if it reached its end; `judged` makes its table.
    ///
    /// # Errors
    /// A log that cannot be read again, a file that cannot be written.
    fn reported<const N: usize>(
        &self,
        ran: &Ran,
        (judge, rest_m): (Judge, Option<f64>),
        judged: impl FnOnce() -> Result<Verdict<N>, Failure>,
    ) -> Result<(TrialReport, Option<(Origin, Decimated<N>)>), Failure> {
        let setup = self.setup();
        let (order, scheme) = self.operator_choice();
        let record = &ran.record;
        let whole = record.ended.is_none();
        let settling = self.named(TrialSetup::settling(judge, ran, rest_m)?)?;
        let agrees =
            (ran.preflight.filter(|_| whole)).map(|analysis| analysis.stable == settling.stable);
        let mut warnings = warnings(Self::KIND, &settling, agrees, record);
        warnings.0.extend(setup.not_thrown());
        warnings.0.extend(self.warning(ran));
        let files;
        let mut curves = None;
        let mut operator_error = Compared::without_meaning("the run was cut short".to_owned());
        if whole {
            let judged = judged()?;
            operator_error = judged.operator_error;
            files = judged.files;
            curves = Some((Origin::of(record), judged.curves));
        } else {
            files = Files::of_run(ran, None);
        }
        let deflection_error = setup.deflection_error(record, settling, Self::KIND, Self::NO_REST);
        let report = TrialReport {
            tissue: None,
            order: order.get(),
            scheme: scheme.to_string(),
            run: RunReport::new(
                ran,
                device_name(setup.remote.as_ref()),
                setup.device.sample_time.0,
                files,
                warnings,
            ),
            errors: Errors::new(operator_error, deflection_error),
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            settling,
            analysis_agrees: agrees,
        };
        Ok((report, curves))
    }
}
