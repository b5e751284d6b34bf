//! An experiment on a pushed device: the interface of a wall and a coupler, and the report of both.

use super::second::{OfDrive, driven, push_into};
use crate::{
    experiment::{
        drive::{SecondReport, tell},
        kind::{Conduct, Experiment, conducts},
        reading::metadata,
    },
    judge::{
        Published, origin,
        report::{Files, Report, RunReport, closed_form_error, full_history_error, unmet},
        warnings::Warnings,
    },
};
use fracdiff::{Order, Scheme, full_memory::Kernel};
use haptic_document::{Failure, Named as _, parameters::TISSUE_IN_LOG, rows};
use haptic_judge::{
    compared::Compared,
    curves::{Curves, Drawing},
    decimated::Decimated,
    felt::{FeltSummary, Tally},
    pushed::PushedLoop,
    pushed_trial::{Hit, PushedTrial},
    reference::{ReferenceWeights, TOLERANCE},
    sensed::SensedForce,
    settling::{Criterion, Settling, TrialVerdict},
    setup::{TrialParts, TrialSetup},
};
use haptic_run::{
    Ran, Watched,
    record::RunRecord,
    remote::{RemoteDevice, RemoteLaw, RemoteRun, blank, device_name},
    run_logged,
};
use haptic_trial::{
    GuardChoice,
    ending::Ending,
    keys::trial::PushBy,
    preflight::{Findings, PreflightVerdict, note_findings},
    tick::KeptSample,
};
use serde_json::json;
use std::{collections::BTreeMap, fmt::Debug};

/// Said of a trial whose push came from the motor that rendered the law.
const SHARED: &str = "one actuator rendered the law and pushed: its limits held for both together";

/// Why nobody knows of a device into whose law a motor only pushed whether it is stable.
const UNTAPPED: &str = "nothing tapped it, so friction could be all that holds it: tap the handle and look, or try a wall in the device's \
                        own loop, which push_by = device without [drive] taps";

/// A number for each sample, asked for in their order.
pub(crate) type OfSample<'a> = Box<dyn FnMut(&KeptSample) -> f64 + 'a>;

/// The force of each sample less that of the full history, N, or the reason why it has no meaning.
pub(crate) type OffN<'a> = Result<OfSample<'a>, &'static str>;

/// A law on a pushed device that can be run: what needs its log or its device.
pub(crate) trait Trial: PushedTrial + Debug + Send + Sync + 'static {
    /// The law and the push for a serial device.
    fn law_there(&self, samples: u64) -> Result<RemoteLaw, Failure>;

    /// The force of a run that reached its end against the full history.
    fn off_n(&self, ran: &Ran) -> Result<OffN<'_>, Failure>;

    /// Place of an object behind the law, m.
    fn object_m(&self, _: &Ran) -> Result<Option<OfSample<'_>>, Failure> {
        Ok(None)
    }

    /// The text of the file of the tissue that the law is of.
    fn tissue_file(&self) -> Option<String> {
        None
    }

    /// A further warning about a run.
    fn warning(&self, _: &Ran) -> Option<String> {
        None
    }
}

/// A law on a pushed device, and how it is run.
#[derive(Clone, Debug)]
pub(crate) struct Conducted<T> {
    pub trial: T,
    pub conduct: Conduct,
    /// A second device at a port, which pushes.
    pub second: Option<RemoteDevice>,
}

impl<T: Trial> Conducted<T> {
    /// Runs the loop and writes the log.
    pub(crate) fn recorded(&self, watched: Watched<'_>) -> Result<Ran, Failure> {
        let mut parts = self.trial.parts()?;
        let (setup, samples) = (self.trial.setup(), parts.samples);
        let judge = |dynamics, line| self.trial.judge(samples, dynamics, line);
        let mut metadata = self.metadata();
        let dynamics = setup.dynamics();
        let schedule = self.schedule(samples);
        let (request, supervisor) = (watched.request, watched.supervisor);
        let Some(remote) = &self.conduct.remote else {
            // Nothing can break, so it is only noted.
            let verdict = judge(dynamics, 0)?;
            note_findings(&mut metadata, "preflight", &verdict);
            let mut world = PushedLoop::new(&mut parts.controller, &mut parts.device);
            let ran = run_logged(&mut world, schedule, (request, metadata), supervisor)?;
            return Ok(Ran {
                preflight: Some(verdict),
                ..ran
            });
        };
        let look = |dynamics, line| judge(dynamics, line).map(Findings::Loop);
        let law = self.trial.law_there(samples)?;
        let run = RemoteRun {
            preflight: Some(&look),
            force_unstable: self.conduct.force_unstable,
            robot: setup.robot.as_deref(),
            dynamics: Some(dynamics),
            metadata,
            ..RemoteRun::new(remote, law, schedule, &|_| blank(0.0), request)
        };
        match (&setup.second, &self.second) {
            (Some(second), Some(there)) => {
                let (plan, safety) = (&setup.plan, setup.safety());
                push_into(
                    (second, there),
                    plan,
                    &safety,
                    run,
                    &mut parts.controller,
                    supervisor,
                )
            }
            // Both are at ports, or neither.
            _ => run.run(&mut parts.controller, supervisor),
        }
    }

    /// Judges a run, and writes the table of one that reached its end.
    pub(crate) fn report(&self, ran: &Ran) -> Result<(Report, Option<Curves>), Failure> {
        let (setup, record) = (self.trial.setup(), &ran.record);
        let mut seen = self.trial.clone();
        if let Some(link) = &record.link {
            let step = &mut seen.setup_mut().sensors.encoder_resolution_m;
            *step = step.max(link.position_resolution_m);
        }
        let TrialParts {
            mut judge, rest_m, ..
        } = seen.parts()?;
        let start_m = start_m(setup, ran)?;
        let (order, scheme) = self.trial.operator_choice();
        let whole = ran.is_whole();
        let mut felt = felt(setup, record);
        ran.samples().for_each(|sample| {
            let place_m = sample.position_m - start_m;
            judge.see(sample.time_s, place_m, sample.force_n);
            if let Some(felt) = &mut felt {
                felt.see(0, (sample.tick, sample.time_s), place_m, sample.force_n);
            }
            Ok(())
        })?;
        if record.ended == Some(Ending::Swing) {
            judge.swung();
        }
        let felt = felt.map(|felt| felt.summary());
        let mut recorded = self.trial.named(judge.settling(whole, rest_m))?;
        let pushed = setup.plan.push_of_motor().is_some() && record.link.is_some();
        let judged_so = setup.plan.criterion == Criterion::Settling;
        let tap = record.link.as_ref().and_then(|link| link.tap);
        if recorded.stable && pushed && judged_so && tap.is_none() {
            recorded = recorded.by_friction(UNTAPPED);
        }
        let (settling, hits) = if whole {
            self.trial.worst(recorded)?
        } else {
            (recorded, Vec::new())
        };
        let is_judged = whole && felt.is_none();
        let judged = ran.preflight.filter(|_| is_judged);
        // Friction leaves open if a wall is stable that it holds.
        let held = settling.verdict == TrialVerdict::HeldByFriction;
        // The box of a robot has more hands and walls than are tried.
        let wider = |analysis: &PreflightVerdict| analysis.robot.is_some() && !analysis.stable;
        let agrees = judged
            .filter(|analysis| !(held && analysis.stable || settling.stable && wider(analysis)));
        let agrees = agrees.map(|analysis| analysis.stable == settling.stable);
        let (verdict, mut warnings) = match &felt {
            Some(felt) => of_hand(felt, record),
            None => (
                settling.verdict.words(),
                warnings(T::KIND, &settling, &hits, agrees, record),
            ),
        };
        let unproved = judged.filter(|analysis| wider(analysis) && agrees.is_none());
        (warnings.0).extend(unproved.and_then(|analysis| analysis.warning(false)));
        warnings.0.extend(setup.not_thrown());
        warnings.0.extend(self.trial.warning(ran));
        let (mut curves, mut object_m) = (None, None);
        let mut sensed_rows = json!({});
        let (files, operator_error);
        if whole {
            let (off_n, object) = if start_m == 0.0 {
                (self.trial.off_n(ran)?, self.trial.object_m(ran)?)
            } else {
                (Err("the law began where the handle stood"), None)
            };
            let push_n = setup.plan.own_push_n().unwrap_or(0.0);
            let push_n = |tick| push_n + tap.map_or(0.0, |tap| tap.at(tick));
            let second = (setup.second.as_ref())
                .map(|second| driven(second, ran, setup.plan.push_n, &setup.safety()));
            let compared = Comparison::of(ran, push_n, off_n, object, second.transpose()?)?;
            (files, operator_error) = (compared.files, compared.error);
            let sensed = compared.sensed;
            (warnings.0).extend(sensed.warnings(record.sensor, record.link.is_some()));
            sensed_rows = sensed.rows(record.sensor, None);
            object_m = compared.object_m;
            let object = object_m.map_or("", |_| "object_position_m");
            let origin = origin(record);
            let title = format!("A trial of a {}, {origin}", T::KIND);
            let law = self.trial.law_in_words();
            let push_n = felt.is_none().then_some(setup.plan.push_n);
            let subtitle = format!(
                "{law} · {}",
                words(
                    setup,
                    device_name(self.conduct.remote.as_ref()),
                    scheme,
                    push_n,
                    verdict
                )
            );
            let drive = setup.second.as_ref().map_or("", |_| "drive_force_n");
            let names = ["position_m", object, "force_n", drive];
            let rest_m = settling.expected_deflection_m;
            let drawing = Drawing::Trial {
                expected_deflection_m: rest_m.filter(|_| felt.is_none()),
            };
            curves = Some((compared.curves).named(names, origin, title, subtitle, drawing));
        } else {
            files = Files::of_run(ran, None);
            operator_error = Compared::without_meaning("the run was cut short");
        }
        let device = device_name(self.conduct.remote.as_ref());
        let t = setup.device.sample_time.0;
        let shared = setup.plan.own_push_n().map(|push_n| {
            json!({ "push_by": setup.plan.push_by.name(), "shared_actuator": SHARED, "push_n": push_n })
        });
        let second = setup.second.as_ref().map(|second| {
            json!({
                "push_by": setup.plan.push_by.name(),
                "push_n": setup.plan.push_n,
                "drive_force_limit_n": second.force_limit_n,
                "preflight_reason": "of both devices as one body, however stiff their contact is",
            })
        });
        let operator = json!({
            // No tissue.
            "tissue": null,
            "order": order.get(),
            "scheme": scheme.to_string(),
        });
        // A wall that never pulls is hit at several speeds, of which the worst is the verdict; the log is of the first.
        let hits = (!hits.is_empty()).then(|| json!({ "hits": hits }));
        let deflection = closed_form_error(&self.deflection_error(record, settling));
        let mut results = match felt {
            Some(felt) => vec![json!({ "verdict": verdict, "felt": felt })],
            None => [json!(settling)].into_iter().chain(hits).collect(),
        };
        results.extend((felt.is_none()).then(|| json!({ "analysis_agrees": agrees })));
        results.push(full_history_error(&operator_error));
        results.extend(felt.is_none().then_some(deflection));
        let tolerance = record.whole.is_none().then_some(TOLERANCE);
        results.extend([json!({ "reference_tolerance": tolerance }), sensed_rows]);
        let verdict = verdict.to_owned();
        let is_accepted = settling.stable
            && agrees == Some(true)
            && (ran.preflight.as_ref()).is_some_and(|analysis| self.trial.is_accepted(analysis));
        let unmet = (setup.must_be_stable && !is_accepted).then(|| {
            let why = format!("trial ({verdict}){}", T::REFUSED);
            unmet(&T::MUST_BE_STABLE, &why, "design a weaker one")
        });
        let mut run = RunReport::new(ran, device, t, files, warnings);
        if let Some(second) = &ran.second {
            tell(&mut run, record, second);
            results.push(json!({ "drive": SecondReport::of(second) }));
        }
        let unmet = run.hold_to_law(operator_error.largest, scheme).or(unmet);
        let report = Report {
            law: rows(
                [self.trial.law_in_rows(&settling, object_m), operator]
                    .into_iter()
                    .chain(shared)
                    .chain(second),
            ),
            run,
            results: rows(results),
            verdict: Some(verdict),
            unmet,
        };
        Ok((report, curves))
    }

    /// Mean deflection over the window at the end against the rest position.
    fn deflection_error(&self, record: &RunRecord, settling: Settling) -> Compared {
        let (t, plan) = (
            self.trial.setup().device.sample_time.0,
            &self.trial.setup().plan,
        );
        let judged = ((plan.window_s / t).round() as u64).min(record.samples);
        let to_s = record.duration_s();
        let window_s = [to_s - judged.saturating_sub(1) as f64 * t, to_s];
        match (settling.deflection_m, settling.expected_deflection_m) {
            (Some(have), Some(want)) if settling.stable => {
                Compared::of_window((have / want - 1.0).abs(), window_s, judged)
            }
            (Some(_), None) => Compared::without_meaning(T::NO_REST),
            _ => {
                let seen = if settling.verdict == TrialVerdict::Unstable {
                    "did not come to rest".to_owned()
                } else {
                    format!("was {}", settling.verdict.words())
                };
                Compared::without_meaning(format!("the {} {seen}", T::KIND))
            }
        }
    }
}

impl<T: Trial> Experiment for Conducted<T> {
    fn check(&self) -> Result<u64, Failure> {
        self.trial.parts().map(|parts| parts.samples)
    }

    fn sample_time_s(&self) -> f64 {
        self.trial.setup().device.sample_time.0
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        let (setup, scheme) = (self.trial.setup(), self.trial.operator_choice().1);
        let mut metadata = metadata(T::KIND, &self.conduct, scheme, &setup.safety());
        // A serial device is not thrown.
        let impact = setup.plan().impact_m_per_s.to_string();
        metadata.insert("impact_m_per_s".to_owned(), impact);
        let file = self.trial.tissue_file();
        metadata.extend(file.map(|file| (TISSUE_IN_LOG.to_owned(), file)));
        metadata
    }

    conducts!();

    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        let ran = self.recorded(watched)?;
        let (report, curves) = self.report(&ran)?;
        Ok(Published::new(report, curves, ran))
    }
}

/// Place where the law began, m: 0, or where the handle stood if the device's own motor pushes.
fn start_m(setup: &TrialSetup, ran: &Ran) -> Result<f64, Failure> {
    let mut start_m = None;
    if setup.plan.push_by == PushBy::Device {
        ran.samples().for_each(|sample| {
            start_m.get_or_insert(sample.position_m);
            Ok(())
        })?;
    }
    Ok(start_m.unwrap_or(0.0))
}

/// Sums over a run in the hand of a person, whose push nobody knows; `None` of a trial: on a simulated device, pushed by its own
/// motor, or to be stable.
fn felt(setup: &TrialSetup, record: &RunRecord) -> Option<Tally> {
    let is_real = record.link.as_ref().is_some_and(|link| !link.simulated);
    let held = is_real && setup.plan.push_by == PushBy::Hand && !setup.must_be_stable;
    held.then(|| Tally::of(0, 0.0, None, setup.device.sample_time))
}

/// Verdict and warnings of a run that somebody held in the hand.
fn of_hand(felt: &FeltSummary, record: &RunRecord) -> (&'static str, Warnings) {
    let mut warnings = Warnings::default();
    warnings.limited(record);
    match felt.contacts {
        0 => {
            let untouched = "nobody touched it: move the handle behind 0 m while it runs";
            warnings.0.push(untouched.to_owned());
            ("untouched", warnings)
        }
        _ => ("held by a person", warnings),
    }
}

/// Device, operator, push if it is known, N, verdict and guard for the line below a picture.
fn words(
    setup: &TrialSetup,
    device: String,
    scheme: Scheme,
    push_n: Option<f64>,
    verdict: &str,
) -> String {
    let guard = setup.safety.guard;
    let guard = if guard == GuardChoice::Off {
        String::new()
    } else {
        format!(" · guard {}", guard.name())
    };
    let push = push_n.map_or(String::new(), |push_n| format!("push {push_n} N · "));
    format!("device {device} · scheme {scheme} · {push}{verdict}{guard}")
}

/// Warnings about a trial of a wall or a coupler, and about the analysis beside it.
fn warnings(
    what: &str,
    settling: &Settling,
    hits: &[Hit],
    agrees: Option<bool>,
    record: &RunRecord,
) -> Warnings {
    let mut warnings = Warnings::default();
    let mut verdict = settling.verdict.words().to_owned();
    // The first of those that are as bad is the one that is judged.
    let mut worst = hits.iter().filter(|hit| hit.verdict == settling.verdict);
    if let Some(hit) = worst.next().filter(|_| !settling.stable) {
        verdict += &format!(" {}", hit.words());
    }
    match settling.reason() {
        None => warnings.limited(record),
        Some(reason) if record.ended.is_none() => {
            warnings
                .0
                .push(format!("the {what} is {verdict}: {reason}"));
        }
        Some(_) => {}
    }
    if agrees == Some(false) {
        let (analysis, why) = if settling.stable {
            let why = format!(
                "what the analysis does not know (friction, encoder, limits of the force and of its rate) holds the device, or the \
                 {what} grows unstable more slowly than the trial lasts"
            );
            ("unstable", why)
        } else {
            let contact = match what {
                "wall" => ", a wall that only pushes and so does not brake the bounce",
                _ => "",
            };
            let why = format!(
                "what the analysis does not know (encoder, limits of the force and of its rate{contact}) shakes the \
                 device, or the {what} settles more slowly than the trial lasts"
            );
            ("stable", why)
        };
        warnings.0.push(format!(
            "trial and analysis disagree: {verdict} by the trial, {analysis} by the analysis; {why}"
        ));
    }
    warnings
}

/// Columns of a second device.
const SECOND_COLUMNS: [&str; 2] = ["indenter_position_m", "drive_force_n"];

/// A run that reached its end, beside theory.
struct Comparison {
    files: Files,
    curves: Decimated<4>,
    /// Error of the force against the full history.
    error: Compared,
    object_m: Option<f64>,
    sensed: SensedForce,
}

impl Comparison {
    /// Writes the table, keeps the curves, and the largest error of a force: of all but the push of the device's own motor in a tick, N.
    fn of(
        ran: &Ran,
        push_n: impl Fn(u64) -> f64,
        mut off_n: OffN<'_>,
        mut object: Option<OfSample<'_>>,
        mut drive: Option<OfDrive<'_>>,
    ) -> Result<Self, Failure> {
        let record = &ran.record;
        let mut names = vec!["time_s", "position_m"];
        names.extend(object.as_ref().map(|_| "object_position_m"));
        names.push("reaction_force_n");
        names.extend(drive.iter().flat_map(|_| SECOND_COLUMNS));
        let mut table = ran.folder.named_table_beside_log("csv", &names);
        let mut curves = Decimated::kept(record.whole.is_some());
        let (mut seen, mut last) = (Seen::default(), None);
        let mut sensed = SensedForce::default();
        ran.samples().for_each(|sample| {
            // A sensor feels the whole force of the motor.
            let rendered_n = sample.reaction_n();
            let sample = &KeptSample {
                force_n: sample.force_n - push_n(sample.tick),
                ..*sample
            };
            let off_n = off_n.as_mut().ok().map(|off_n| off_n(sample));
            seen.add(sample, off_n.unwrap_or(0.0));
            sensed.add(sample, rendered_n, off_n.map(|off_n| rendered_n + off_n));
            last = object.as_mut().map(|object| object(sample));
            let (x, force_n) = (sample.position_m, sample.reaction_n());
            let driven = drive.as_mut().map(|drive| drive(sample));
            let [_, drive_n] = driven.unwrap_or_default();
            curves.add(sample.time_s, [x, last.unwrap_or(0.0), force_n, drive_n]);
            let row = [Some(sample.time_s), Some(x), last, Some(force_n)];
            let row = row
                .into_iter()
                .flatten()
                .chain(driven.into_iter().flatten());
            table.row(row.collect::<Vec<f64>>());
            Ok(())
        })?;
        Ok(Self {
            files: Files::of_run(ran, Some(table)),
            curves,
            error: match off_n {
                Ok(_) => seen.over(record),
                Err(reason) => Compared::without_meaning(reason),
            },
            object_m: last,
            sensed,
        })
    }
}

/// The largest error of the forces that can be compared, over the largest force of the run.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    off_n: f64,
    from_s: Option<f64>,
    to_s: f64,
    samples: u64,
}

impl Seen {
    /// A sample whose force is off by so much, N.
    pub(crate) fn add(&mut self, sample: &KeptSample, off_n: f64) {
        if sample.is_comparable() {
            self.off_n = self.off_n.max(off_n.abs());
            self.from_s = self.from_s.or(Some(sample.time_s));
            self.to_s = sample.time_s;
            self.samples += 1;
        }
    }

    pub(crate) fn over(self, record: &RunRecord) -> Compared {
        let Some(from_s) = self.from_s else {
            let reason = "the safety chain limited the force in each sample";
            return Compared::without_meaning(reason);
        };
        let error = self.off_n / record.largest_force_n();
        Compared::of_window(error, [from_s, self.to_s], self.samples)
    }
}

/// A law that a limited force moves on is not compared any more.
pub(crate) fn limited(record: &RunRecord) -> Option<&'static str> {
    (record.limited > 0).then_some("the safety chain limited the force")
}

/// A force without a full history of this order, or without any force, has nothing to be compared with.
pub(crate) fn incomparable(
    reference: ReferenceWeights,
    order: Order,
    record: &RunRecord,
) -> Option<&'static str> {
    if reference == ReferenceWeights::Kernel(Kernel::PiecewiseLinear) && order.get() >= 1.0 {
        Some("the weights of this kernel are known in closed form below order 1 only")
    } else if record.largest_force_n() == 0.0 {
        Some("no force was commanded")
    } else {
        None
    }
}
