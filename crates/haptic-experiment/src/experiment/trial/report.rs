//! An experiment on a pushed device: the interface of a wall and a coupler, and the report of both.

use super::PushedLoop;
use super::second::OfDrive;
use super::setup::{Parts, TrialSetup};
use crate::experiment::drive::{SecondReport, tell};
use crate::experiment::kind::{Conduct, Experiment};
use crate::experiment::reading::metadata;
use crate::judge::report::{
    Files, Report, RunReport, closed_form_error, full_history_error, unmet,
};
use crate::judge::warnings::Warnings;
use crate::judge::{Published, origin};
use fracdiff::full_memory::Kernel;
use fracdiff::{Order, Scheme};
use haptic_analysis::Dynamics;
use haptic_document::parameters::Parameter;
use haptic_document::{Failure, Named as _, rows};
use haptic_judge::compared::Compared;
use haptic_judge::curves::{Curves, Drawing};
use haptic_judge::decimated::Decimated;
use haptic_judge::felt::FeltSummary;
use haptic_judge::reference::ReferenceWeights;
use haptic_judge::reference::TOLERANCE;
use haptic_judge::sensed::SensedForce;
use haptic_judge::settling::{Criterion, Settling, TrialVerdict};
use haptic_loop::Environment;
use haptic_run::Watched;
use haptic_run::record::RunRecord;
use haptic_run::remote::{RemoteDevice, RemoteLaw, RemoteRun, blank, device_name};
use haptic_run::{Ran, run_logged};
use haptic_trial::GuardChoice;
use haptic_trial::ending::Ending;
use haptic_trial::preflight::{Findings, PreflightVerdict, note_findings};
use haptic_trial::tick::KeptSample;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A trial of a wall at one speed.
#[derive(Debug, Serialize)]
pub(crate) struct Hit {
    impact_m_per_s: f64,
    verdict: TrialVerdict,
    peak_force_n: f64,
}

/// The loudest of these noises.
pub(crate) fn louder(noises: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    noises.into_iter().flatten().reduce(f64::max)
}

/// Said of a trial whose push came from the motor that rendered the law.
const SHARED: &str = "one actuator rendered the law and pushed: its limits held for both together";

/// Why nobody knows of a device into whose law a motor only pushed whether it is stable.
const UNTAPPED: &str = "nothing tapped it, so friction could be all that holds it: tap the handle and look, or try a wall in the device's \
                        own loop, which push_by = device without [drive] taps";

/// A number for each sample, asked for in their order.
pub(crate) type OfSample<'a> = Box<dyn FnMut(&KeptSample) -> f64 + 'a>;

/// The force of each sample less that of the full history, N, or the reason why it has no meaning.
pub(crate) type OffN<'a> = Result<OfSample<'a>, &'static str>;

/// An experiment on a pushed device.
pub(crate) trait Trial: Experiment + Clone {
    /// The law that the device feels.
    type Law: Environment<f64, 1, History: Send> + Send;
    const KIND: &'static str;
    /// Reason for a push that no rest position belongs to.
    const NO_REST: &'static str;
    const MUST_BE_STABLE: Parameter;
    /// Said behind the verdict of a trial that this key refuses.
    const REFUSED: &'static str;

    fn setup(&self) -> &TrialSetup;

    fn setup_mut(&mut self) -> &mut TrialSetup;

    fn operator_choice(&self) -> (Order, Scheme);

    /// The law in words, for the line below a picture.
    fn law_in_words(&self) -> String;

    /// The loop, made of good parameters.
    fn parts(&self) -> Result<Parts<Self::Law>, Failure>;

    /// Analysis of the loop with this device and `line` samples of delay on a line besides its own.
    fn judge(
        &self,
        samples: u64,
        dynamics: Dynamics,
        line: usize,
    ) -> Result<PreflightVerdict, Failure>;

    /// The law and the push for a serial device.
    fn law_there(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure>;

    /// The force of a run that reached its end against the full history.
    fn off_n(&self, ran: &Ran) -> Result<OffN<'_>, Failure>;

    /// Place of an object behind the law, m.
    fn object_m(&self, _: &Ran) -> Result<Option<OfSample<'_>>, Failure> {
        Ok(None)
    }

    /// The law as its report has it, with the place at the end of an object behind it, m.
    fn law_in_rows(&self, settling: &Settling, object_m: Option<f64>) -> Value;

    /// True unless the pre-flight says something of the law that `must_be_stable` refuses beside an unstable loop.
    fn is_accepted(&self, _: &PreflightVerdict) -> bool {
        true
    }

    /// Speeds at which it is hit beside that of its plan, m/s: a device that stands here, of a law that never pulls.
    fn hits(&self) -> Vec<f64> {
        Vec::new()
    }

    /// A further warning about a run.
    fn warning(&self, _: &Ran) -> Option<String> {
        None
    }

    /// Runs the loop and writes the log.
    fn recorded(&self, watched: Watched<'_>) -> Result<Ran, Failure> {
        let mut parts = self.parts()?;
        let (setup, samples) = (self.setup(), parts.samples);
        let judge = |dynamics, line| self.judge(samples, dynamics, line);
        let mut metadata = self.metadata();
        let dynamics = setup.dynamics();
        let schedule = self.schedule(samples);
        let (request, supervisor) = (watched.request, watched.supervisor);
        let Some(remote) = &setup.conduct.remote else {
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
        let law = self.law_there(remote, samples)?;
        let run = RemoteRun {
            preflight: Some(&look),
            force_unstable: setup.conduct.force_unstable,
            dynamics: Some(dynamics),
            metadata,
            ..RemoteRun::new(remote, law, schedule, &|_| blank(0.0), request)
        };
        match &setup.second {
            None => run.run(&mut parts.controller, supervisor),
            Some(second) => {
                let (plan, safety) = (&setup.plan, setup.safety());
                second.push_into(plan, &safety, run, &mut parts.controller, supervisor)
            }
        }
    }

    /// Runs it without log or files: does it settle, at each hit, and without friction too?
    fn settled(&self) -> Result<Settling, Failure> {
        Ok(self.worst(self.named(self.tried()?)?)?.0)
    }

    /// The worst of this judgement and those of all further hits, and all of them if there are any.
    fn worst(&self, recorded: Settling) -> Result<(Settling, Vec<Hit>), Failure> {
        let mut all = vec![recorded];
        for impact_m_per_s in self.hits() {
            let mut other = self.clone();
            other.setup_mut().plan.impact_m_per_s = impact_m_per_s;
            all.push(other.named(other.tried()?)?);
        }
        let worse = |a: Settling, b: &Settling| if b.verdict > a.verdict { *b } else { a };
        let worst = Settling {
            noise_n: louder(all.iter().map(|settling| settling.noise_n)),
            ..all.iter().fold(recorded, worse)
        };
        let hits = all.iter().filter(|_| all.len() > 1).map(|settling| Hit {
            impact_m_per_s: settling.impact_m_per_s,
            verdict: settling.verdict,
            peak_force_n: settling.peak_force_n,
        });
        Ok((worst, hits.collect()))
    }

    /// Runs it without log or files, to see if it settles.
    fn tried(&self) -> Result<Settling, Failure> {
        self.parts().map(Parts::tried)
    }

    /// Changes the verdict if friction alone holds the device. Noise includes that of the device without friction: a moving hand feels it.
    fn named(&self, settling: Settling) -> Result<Settling, Failure> {
        let Some(smooth) = self.setup().smooth().filter(|_| settling.stable) else {
            return Ok(settling);
        };
        let mut other = self.clone();
        *other.setup_mut() = smooth;
        let smooth = other.tried()?;
        if smooth.stable {
            Ok(Settling {
                noise_n: louder([settling.noise_n, smooth.noise_n]),
                ..settling
            })
        } else {
            Ok(settling.by_friction("without friction the device does not come to rest"))
        }
    }

    /// Judges a run, and writes the table of one that reached its end.
    fn report(&self, ran: &Ran) -> Result<(Report, Option<Curves>), Failure> {
        let (setup, record) = (self.setup(), &ran.record);
        let mut seen = self.clone();
        if let Some(link) = &record.link {
            let step = &mut seen.setup_mut().sensors.encoder_resolution_m;
            *step = step.max(link.position_resolution_m);
        }
        let Parts {
            mut judge, rest_m, ..
        } = seen.parts()?;
        let start_m = setup.start_m(ran)?;
        let (order, scheme) = self.operator_choice();
        let whole = ran.is_whole();
        let mut felt = setup.felt(record);
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
        let mut recorded = self.named(judge.settling(whole, rest_m))?;
        let pushed = setup.plan.push_of_motor().is_some() && record.link.is_some();
        let judged_so = setup.plan.criterion == Criterion::Settling;
        let tap = record.link.as_ref().and_then(|link| link.tap);
        if recorded.stable && pushed && judged_so && tap.is_none() {
            recorded = recorded.by_friction(UNTAPPED);
        }
        let (settling, hits) = if whole {
            self.worst(recorded)?
        } else {
            (recorded, Vec::new())
        };
        let is_judged = whole && felt.is_none();
        let judged = ran.preflight.filter(|_| is_judged);
        // Friction leaves open if a wall is stable that it holds.
        let held = settling.verdict == TrialVerdict::HeldByFriction;
        let agrees = judged.filter(|analysis| !(held && analysis.stable));
        let agrees = agrees.map(|analysis| analysis.stable == settling.stable);
        let (verdict, mut warnings) = match &felt {
            Some(felt) => of_hand(felt, record),
            None => (
                settling.verdict.words(),
                warnings(Self::KIND, &settling, &hits, agrees, record),
            ),
        };
        warnings.0.extend(setup.not_thrown());
        warnings.0.extend(self.warning(ran));
        let (mut curves, mut object_m) = (None, None);
        let mut sensed_rows = json!({});
        let (files, operator_error);
        if whole {
            let (off_n, object) = if start_m == 0.0 {
                (self.off_n(ran)?, self.object_m(ran)?)
            } else {
                (Err("the law began where the handle stood"), None)
            };
            let push_n = setup.plan.own_push_n().unwrap_or(0.0);
            let push_n = |tick| push_n + tap.map_or(0.0, |tap| tap.at(tick));
            let second = (setup.second.as_ref())
                .map(|second| second.driven(ran, setup.plan.push_n, &setup.safety()));
            let compared = Comparison::of(ran, push_n, off_n, object, second.transpose()?)?;
            (files, operator_error) = (compared.files, compared.error);
            let sensed = compared.sensed;
            (warnings.0).extend(sensed.warnings(record.sensor, record.link.is_some()));
            sensed_rows = sensed.rows(record.sensor, None);
            object_m = compared.object_m;
            let object = object_m.map_or("", |_| "object_position_m");
            let origin = origin(record);
            let title = format!("A trial of a {}, {origin}", Self::KIND);
            let law = self.law_in_words();
            let push_n = felt.is_none().then_some(setup.plan.push_n);
            let subtitle = format!("{law} · {}", words(setup, scheme, push_n, verdict));
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
        let device = device_name(setup.conduct.remote.as_ref());
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
            && (ran.preflight.as_ref()).is_some_and(|analysis| self.is_accepted(analysis));
        let unmet = (setup.must_be_stable && !is_accepted).then(|| {
            let why = format!("trial ({verdict}){}", Self::REFUSED);
            unmet(&Self::MUST_BE_STABLE, &why, "design a weaker one")
        });
        let mut run = RunReport::new(ran, device, t, files, warnings);
        if let Some(second) = &ran.second {
            tell(&mut run, record, second);
            results.push(json!({ "drive": SecondReport::of(second) }));
        }
        let unmet = run.hold_to_law(operator_error.largest, scheme).or(unmet);
        let report = Report {
            law: rows(
                [self.law_in_rows(&settling, object_m), operator]
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
        let (t, plan) = (self.setup().device.sample_time.0, &self.setup().plan);
        let judged = ((plan.window_s / t).round() as u64).min(record.samples);
        let to_s = record.duration_s();
        let window_s = [to_s - judged.saturating_sub(1) as f64 * t, to_s];
        match (settling.deflection_m, settling.expected_deflection_m) {
            (Some(have), Some(want)) if settling.stable => {
                Compared::of_window((have / want - 1.0).abs(), window_s, judged)
            }
            (Some(_), None) => Compared::without_meaning(Self::NO_REST),
            _ => {
                let seen = if settling.verdict == TrialVerdict::Unstable {
                    "did not come to rest".to_owned()
                } else {
                    format!("was {}", settling.verdict.words())
                };
                Compared::without_meaning(format!("the {} {seen}", Self::KIND))
            }
        }
    }
}

impl<T: Trial> Experiment for T {
    fn check(&self) -> Result<u64, Failure> {
        self.parts().map(|parts| parts.samples)
    }

    fn sample_time_s(&self) -> f64 {
        self.setup().device.sample_time.0
    }

    fn axes(&self) -> usize {
        1
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        let (setup, scheme) = (self.setup(), self.operator_choice().1);
        let mut metadata = metadata(Self::KIND, &setup.conduct, scheme, &setup.safety());
        // A serial device is not thrown.
        let impact = setup.plan().impact_m_per_s.to_string();
        metadata.insert("impact_m_per_s".to_owned(), impact);
        metadata
    }

    fn conduct(&self) -> &Conduct {
        &self.setup().conduct
    }

    fn conduct_mut(&mut self) -> &mut Conduct {
        &mut self.setup_mut().conduct
    }

    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure> {
        let ran = self.recorded(watched)?;
        let (report, curves) = self.report(&ran)?;
        Ok(Published::new(report, curves, ran))
    }

    fn check_start(&self) -> Result<(), Failure> {
        Ok(())
    }

    fn may_be_refused(&self) -> bool {
        false
    }
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
fn words(setup: &TrialSetup, scheme: Scheme, push_n: Option<f64>, verdict: &str) -> String {
    let guard = setup.safety.guard;
    let guard = if guard == GuardChoice::Off {
        String::new()
    } else {
        format!(" · guard {}", guard.name())
    };
    let push = push_n.map_or(String::new(), |push_n| format!("push {push_n} N · "));
    let device = device_name(setup.conduct.remote.as_ref());
    format!("device {device} · scheme {scheme} · {push}{verdict}{guard}")
}

/// Value to six significant digits, as a subtitle shows a number.
pub(crate) fn six_digits(value: f64) -> f64 {
    // A formatted number is a number again.
    format!("{value:.5e}").parse().unwrap_or(value)
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
    if !hits.is_empty() && !settling.stable {
        verdict += &format!(" when it is hit at {} m/s", settling.impact_m_per_s);
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
