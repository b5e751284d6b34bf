//! Files, report and curves of an indentation, from its run and its theory.

use super::Indentation;
use crate::{
    experiment::{
        drive::{DriveJudge, DriveReport, DriveSamples, SecondReport, drive_columns, tell},
        kind::Experiment as _,
    },
    judge::{
        against::Comparison,
        beginning::Beginning,
        origin,
        report::{Files, Report, RunReport, closed_form_error, full_history_error},
        warnings::Warnings,
    },
};
use fracdiff::Seconds;
use haptic_document::{
    Failure,
    parameters::{CONTACT, FORCE_LIMIT},
    rows,
};
use haptic_judge::{
    compared::{LargestError, percent, relative_error},
    curves::{self, Curves, Drawing},
    decimated::Decimated,
    reference::{ReferenceSeries, ReferenceWeights, TOLERANCE},
    rendering::{DEPTH, FORCE, STRESS},
    sensed::SensedForce,
};
use haptic_loop::{
    plant::{RampHold, RigDrive},
    units::Newtons,
};
use haptic_quantity::{digits, written};
use haptic_run::{Ran, folder::RunTable, remote::device_name};
use haptic_trial::{
    samples::{Before, Samples},
    tick::KeptSample,
};
use serde_json::{Value, json};

/// The comparison with the full history begins here, s after contact.
const FROM_S: f64 = 0.01;
/// That of a relaxation with the closed form begins this long after the end of the ramp, s.
const AFTER_RAMP_S: f64 = 0.1;
/// That of creep begins here, s: before, the rig itself is moving.
const CREEP_FROM_S: f64 = 1.0;

/// The tissue is seen on a rig where the depth stays within this share of the closed form.
const SEEN_WITHIN: f64 = 0.05;

/// A sample beside what theory says of it.
#[derive(Clone, Copy, Debug)]
struct TheorySample {
    /// Place of the renderer with an ideal rig, m.
    ideal_position_m: f64,
    /// Force by the full history of the position really recorded, N.
    full_history_force_n: f64,
    /// The quantity as it was rendered or simulated.
    value: f64,
    /// The quantity in closed form.
    closed_form: f64,
    /// The quantity sampled, by its full history, without a rig.
    ideal: f64,
    /// That quantity with the rig.
    with_rig: f64,
}

/// The warning that up to this time, s, the rig is seen and not the tissue; `None` up to the whole run.
fn rig_is_seen(until_s: Option<f64>, duration_s: f64) -> Option<String> {
    let when = match until_s {
        Some(until_s) if until_s <= 0.5 * duration_s => return None,
        Some(until_s) => format!("before {} s the run shows the rig", digits(until_s, 3)),
        None => "the whole run shows the rig".to_owned(),
    };
    let ideal = CONTACT.set_to("ideal");
    Some(format!(
        "{when}, not the tissue: use {ideal}, or a longer run"
    ))
}

/// The quantity that is compared with its closed form, and its words.
#[derive(Clone, Copy, Debug)]
struct Quantity {
    name: &'static str,
    /// Label of an axis, with the unit.
    label: &'static str,
    /// Suffix of a number, with the space before it.
    unit: &'static str,
    without_rig: &'static str,
    /// The closed form is compared from this time on, s.
    from_s: f64,
    moved: Option<Moved>,
}

/// The moving quantity of a creep test, reported besides its force.
#[derive(Clone, Copy, Debug)]
struct Moved {
    /// Divisor of a depth, m.
    length_m: f64,
    /// Part of the name of a column.
    column: &'static str,
    /// The key of its last value.
    end: &'static str,
}

/// Source of a drive's report: the samples of the run, or those of its own device.
enum Driven {
    Judge(Box<DriveJudge>),
    Report(DriveSamples, Box<DriveReport>),
}

/// Says of each sample what theory says.
type Theory<'a> = Box<dyn FnMut(&KeptSample) -> TheorySample + 'a>;

/// A run that is being judged, sample by sample.
struct Judge<'a> {
    of: &'a Indentation,
    quantity: Quantity,
    /// Errors against the full history, against the closed form, of the sampling alone, and of the rig.
    errors: [LargestError; 4],
    curves: Decimated<5>,
    drive: Option<Driven>,
    csv: Option<RunTable>,
    against: Option<Comparison<'a>>,
    sensed: SensedForce,
    /// The sensed force of a relaxation beside the record.
    sensed_against: Option<Comparison<'a>>,
    beginning: Beginning,
    last: Option<TheorySample>,
    unseen_until_s: Option<f64>,
    deepest_m: f64,
    ends_limited: bool,
}

/// Warnings of a judged run.
struct Judged {
    last: Option<TheorySample>,
    final_over_theory: Option<f64>,
    /// That ratio, where neither the beginning nor the drive explains it.
    unexplained: Option<f64>,
    /// Time from which on the tissue is seen and not the rig, s; `None` if never.
    seen_from_s: Option<f64>,
    deepest_m: f64,
    /// The loop held less than the whole push at the end.
    unrendered: bool,
    drive: Option<DriveReport>,
}

impl<'a> Judge<'a> {
    fn new(of: &'a Indentation, ran: &Ran) -> Result<Self, Failure> {
        let (record, quantity) = (&ran.record, of.quantity());
        let (unit, from_s) = (quantity.unit, quantity.from_s);
        let driven = |drive| {
            let (t, on_device) = (of.sample_time_s(), of.conduct.remote.is_some());
            let mut judge = DriveJudge::new(drive, of.load, t, ran.drive, on_device)?;
            Ok::<_, Failure>(match &ran.second {
                None => Driven::Judge(Box::new(judge)),
                Some(ran) => {
                    let samples = DriveSamples::new(ran, record, t, |sample| judge.add(sample));
                    let report = DriveReport {
                        second: Some(SecondReport::of(ran)),
                        ..judge.finish()
                    };
                    Driven::Report(samples, Box::new(report))
                }
            })
        };
        let drive = of.drive.as_ref().map(driven).transpose()?;
        let columns = drive.as_ref().map(|_| drive_columns(of.load));
        Ok(Self {
            errors: [
                LargestError::new(FROM_S, "the force by the full history", " N"),
                LargestError::new(from_s, "the closed form", unit),
                LargestError::new(from_s, "the closed form", unit),
                LargestError::new(from_s, quantity.without_rig, unit),
            ],
            curves: Decimated::kept(record.whole.is_some()),
            csv: ran.is_whole().then(|| table(ran, quantity.moved, columns)),
            against: of.against.as_ref().map(Comparison::new),
            sensed: SensedForce::default(),
            sensed_against: (of.against.as_ref())
                .filter(|_| quantity.moved.is_none())
                .map(Comparison::new),
            beginning: Beginning::of(ran, from_s),
            last: None,
            unseen_until_s: None,
            deepest_m: 0.0,
            ends_limited: false,
            of,
            quantity,
            drive,
        })
    }

    fn add(&mut self, sample: &KeptSample, judged: TheorySample) {
        let (value, closed_form) = (judged.value, judged.closed_form);
        let force_n = self.of.opposed_n(sample);
        self.beginning.add(sample.time_s, closed_form);
        let pairs = [
            (force_n, judged.full_history_force_n),
            (value, closed_form),
            (judged.ideal, closed_form),
            (judged.with_rig, judged.ideal),
        ];
        for (largest, (have, want)) in self.errors.iter_mut().zip(pairs) {
            if sample.is_comparable() {
                largest.add(sample.time_s, have, want);
            } else {
                largest.pass(sample.time_s);
            }
        }
        let closed_form_n = match self.of.load {
            RigDrive::Position(_) => closed_form,
            RigDrive::Force(push) => push.0,
        };
        self.sensed.add(sample, force_n, Some(closed_form_n));
        if let Some(against) = &mut self.sensed_against {
            let sensed_n = sample.sensed_force_n.filter(|_| sample.is_comparable());
            against.add(sample.time_s, sensed_n);
        }
        if let Some(against) = &mut self.against {
            let value = sample.is_comparable().then_some(value);
            against.add(sample.time_s, value);
        }
        self.last = Some(judged);
        self.ends_limited = !sample.is_comparable();
        self.deepest_m = f64::max(self.deepest_m, sample.position_m);
        if self.quantity.moved.is_some() && (value / closed_form - 1.0).abs() > SEEN_WITHIN {
            self.unseen_until_s = Some(sample.time_s);
        }
        let driven = self.drive.as_mut().map(|drive| match drive {
            Driven::Judge(judge) => judge.add(sample),
            Driven::Report(samples, _) => samples.at(sample.time_s),
        });
        let Some(csv) = &mut self.csv else {
            return;
        };
        let error = relative_error(value, closed_form);
        let (tracking_error, [_, drive_n]) = driven.unwrap_or_default();
        let values = [value, closed_form, error, tracking_error, drive_n];
        self.curves.add(sample.time_s, values);
        let row = [
            sample.time_s,
            judged.ideal_position_m,
            sample.position_m,
            force_n,
            judged.full_history_force_n,
        ];
        // The force of a relaxation stands there already.
        let row = row.into_iter().chain(self.quantity.moved.map(|_| value));
        let mut row: Vec<Option<f64>> = row.chain([closed_form]).map(Some).collect();
        // A sample without a relative error has an empty cell.
        row.push(Some(error).filter(|error| error.is_finite()));
        row.extend(driven.iter().flat_map(|driven| driven.1.map(Some)));
        csv.row(row);
    }

    fn judged(&mut self, duration_s: f64) -> Judged {
        let of = self.of;
        // On the ideal rig the depth is the tissue's own, whatever is left of the force.
        let unrendered = of.is_ideal() && self.ends_limited;
        let ratio = (self.last.map(|last| last.value / last.closed_form))
            .filter(|ratio: &f64| ratio.is_finite() && !unrendered);
        let beginning = &mut self.beginning;
        let final_over_theory = beginning.ratio("final_over_theory", ratio);
        let seen_from_s = self
            .unseen_until_s
            .map_or(0.0, |until_s| until_s + of.sample_time_s());
        Judged {
            last: self.last,
            final_over_theory,
            // No operator of this program makes the force of a drive.
            unexplained: final_over_theory
                .filter(|ratio| !of.holds_device() && !beginning.explains(*ratio)),
            seen_from_s: Some(seen_from_s).filter(|from_s| *from_s <= duration_s),
            deepest_m: self.deepest_m,
            unrendered,
            drive: self.drive.take().map(|drive| match drive {
                Driven::Judge(judge) => judge.finish(),
                Driven::Report(_, report) => *report,
            }),
        }
    }
}

impl Indentation {
    /// Judges a run; the table of one that reached its end goes beside its log. A run that was cut short leaves its log alone.
    pub(crate) fn report(&self, ran: &Ran) -> Result<(Report, Option<Curves>), Failure> {
        let record = &ran.record;
        let mut theory = match self.load {
            RigDrive::Position(profile) => self.relaxed(profile, ran)?,
            RigDrive::Force(push) => self.crept(push, ran)?,
        };
        let mut judge = Judge::new(self, ran)?;
        ran.samples().for_each(|sample| {
            judge.add(sample, theory(sample));
            Ok(())
        })?;
        let quantity = judge.quantity;
        let mut files = Files::of_run(ran, judge.csv.take());
        let (mut comparison, mut overlay) = (Vec::new(), None);
        match judge.against.take() {
            None => ran.folder.remove_stale("against.csv"),
            Some(against) => {
                let column = quantity.moved.map_or("force_n", |moved| moved.column);
                let found = against.finish(ran, column, quantity.from_s, &mut judge.beginning);
                (comparison, overlay) = (found.0, Some(found.1));
                files.unwritten = files.unwritten.or(found.2);
            }
        }
        let judged = judge.judged(record.duration_s());
        let Judge {
            mut beginning,
            curves,
            errors,
            sensed,
            sensed_against,
            ..
        } = judge;
        let law_off = errors[0].off().filter(|_| !self.holds_device());
        let [full_history, closed_form, discretisation, rig] = errors.map(LargestError::get);
        let closed_form = beginning.error("closed_form_error", closed_form);
        let rig = beginning.error("rig_error", rig);
        let mut run = RunReport::new(
            ran,
            device_name(self.conduct.remote.as_ref()),
            self.sample_time_s(),
            files,
            self.warnings(ran, &judged, beginning.warning()),
        );
        run.warnings
            .extend(sensed.warnings(record.sensor, record.link.is_some()));
        run.final_force_n = (record.last.as_ref()).map_or(0.0, |last| self.opposed_n(last));
        if let Some(second) = &ran.second {
            tell(&mut run, record, second);
        }
        // A creep test says where it ended.
        let end = judged.last.zip(quantity.moved);
        let end = end.map(|(last, moved)| json!({ moved.end: last.value }));
        let held = judged.drive.as_ref().map(|drive| json!({ "drive": drive }));
        let results = json!({
            // Of the weights that stand for the full history in a run of more than 10⁶ samples; null for exact sums.
            "reference_tolerance": record.whole.is_none().then_some(TOLERANCE),
            // Part of `closed_form_error` that an ideal indenter and the full history leave over the same samples: the sampling.
            "discretisation_error": discretisation.largest,
            // From when on a rig with masses stays within 5 % of the closed form of a creep test; null if never, and without such a rig.
            "tissue_seen_from_s": judged.seen_from_s.filter(|_| self.has_masses()),
            // Part of `closed_form_error` that contact, servo, masses and sensors of the rig add.
            "rig_error": rig.largest,
            "final_over_theory": judged.final_over_theory,
        });
        let results = [
            full_history_error(&full_history),
            closed_form_error(&closed_form),
            results,
        ];
        let measured = [sensed.rows(
            record.sensor,
            sensed_against.and_then(|against| against.differences()),
        )];
        let off = closed_form.largest;
        let unmet = run.hold_to_law(law_off, self.scheme);
        let report = Report {
            law: rows([self.law_rows()]),
            run,
            results: rows(
                results
                    .into_iter()
                    .chain(end)
                    .chain(held)
                    .chain(comparison)
                    .chain(measured),
            ),
            verdict: off.map(|error| format!("{:.2} % from the closed form", 1e2 * error)),
            unmet,
        };
        let held = judged.drive.map(|_| ["tracking_error", "drive_force_n"]);
        let [tracking_error, force_n] = held.unwrap_or_default();
        let names = [
            "values",
            "closed_form",
            "relative_error",
            tracking_error,
            force_n,
        ];
        let origin = origin(record);
        let (title, subtitle) = self.titles(origin, &report.run.device);
        let drawing = Drawing::Theory(curves::Theory {
            quantity: quantity.name,
            label: quantity.label,
            record: overlay,
        });
        let curves = ran
            .is_whole()
            .then(|| curves.named(names, origin, title, subtitle, drawing));
        Ok((report, curves))
    }

    /// True of a creep test on a rig with masses, which is not seen at once.
    fn has_masses(&self) -> bool {
        self.quantity().moved.is_some() && !self.is_ideal()
    }

    /// Rows about the law that was rendered.
    fn law_rows(&self) -> Value {
        let (piece, material) = (&self.piece, &self.piece.material);
        json!({
            "tissue": material.name,
            // α of the tissue.
            "order": material.order().get(),
            "loading": piece.specimen.loading().kind.name(),
            // The modulus that the tissue's numbers are of, and whether its file leaves that open.
            "modulus": material.loading.modulus().name(),
            "modulus_assumed": !material.loading.is_known(),
            "scheme": self.scheme.to_string(),
            "precision": self.precision_run(),
            "contact": self.contact,
            // Null for everything.
            "memory_s": self.scheme.memory_s(self.actuator.sample_time),
        })
    }

    fn warnings(&self, ran: &Ran, judged: &Judged, beginning: Option<String>) -> Warnings {
        let (record, mut warnings) = (&ran.record, Warnings::default());
        let duration_s = record.duration_s();
        if self.has_masses() {
            warnings
                .0
                .extend(rig_is_seen(judged.seen_from_s, duration_s));
        }
        // The load asks for times from the ramp on, or from a sample after a step.
        let shortest_s = match self.load {
            RigDrive::Position(profile) => profile.ramp_time().0,
            RigDrive::Force(_) => self.sample_time_s(),
        };
        let leaves = self
            .piece
            .leaves((shortest_s, duration_s), judged.deepest_m);
        warnings.0.extend(leaves);
        let memory_s = self.scheme.memory_s(self.actuator.sample_time);
        let name = self.quantity().name;
        warnings.operator(memory_s, duration_s, judged.unexplained, name);
        warnings.limited(record);
        if judged.unrendered {
            warnings.0.push(format!(
                "the closed form assumes the whole push, which the loop did not render up to the end: change {STRESS}, {FORCE} or {FORCE_LIMIT}"
            ));
        }
        (warnings.0).extend(judged.drive.iter().flat_map(DriveReport::warnings));
        warnings.0.extend(beginning);
        if self.holds_device() && record.link.as_ref().is_some_and(|link| link.simulated) {
            warnings.0.push(
                "the simulated device has no tissue before it: the force is that of its own mass and damping"
                    .to_owned(),
            );
        }
        warnings
    }

    /// Title and subtitle of the picture.
    fn titles(&self, origin: &str, device: &str) -> (String, String) {
        let (material, specimen) = (&self.piece.material, &self.piece.specimen);
        let (loading, slab) = (specimen.loading().kind.name(), specimen.slab_sizes());
        let (test, remark) = match self.load {
            RigDrive::Position(profile) => {
                let (depth_m, ramp_s) = (profile.depth().0, profile.ramp_time().0);
                let depth = match slab {
                    Some((_, thickness)) => format!("{} % strain", percent(depth_m / thickness.0)),
                    None => written(DEPTH.key, depth_m),
                };
                let until = self.duration_s;
                let remark = format!("{loading}, {depth} in {ramp_s} s, held until {until} s");
                ("Stress relaxation", remark)
            }
            RigDrive::Force(push) => {
                let push = match slab {
                    Some((area, _)) => format!("{} Pa", digits(push.0 / area.0, 4)),
                    None => written(FORCE.key, push.0),
                };
                ("Creep", format!("{loading}, {push} from t = 0"))
            }
        };
        // An order that was identified has all digits of its fit.
        let order = (1e4 * material.order().get()).round() / 1e4;
        let subtitle = format!(
            "{}  ·  order μ = {order}  ·  device {device}  ·  scheme {}  ·  {remark}",
            material.name, self.scheme
        );
        (
            format!("{test} of {}, {origin}", material.description),
            subtitle,
        )
    }

    /// Closed form of the force of a relaxation, N; zero for creep, whose closed form is a depth.
    #[must_use]
    pub fn closed_form(&self, time_s: f64) -> f64 {
        match self.load {
            RigDrive::Position(profile) => {
                let (depth_m, ramp_time_s) = (profile.depth().0, profile.ramp_time().0);
                self.piece.relaxed(depth_m, ramp_time_s, &[time_s])[0]
            }
            RigDrive::Force(_) => 0.0,
        }
    }

    /// The force of a relaxation; the strain of a slab that creeps, the depth of another piece.
    fn quantity(&self) -> Quantity {
        let slab = self.piece.specimen.slab_sizes();
        match (self.load, slab) {
            (RigDrive::Position(profile), _) => Quantity {
                name: "force",
                label: "force on the hand / N",
                unit: " N",
                without_rig: "the force with an ideal rig",
                from_s: profile.ramp_time().0 + AFTER_RAMP_S,
                moved: None,
            },
            (RigDrive::Force(_), Some((_, thickness))) => Quantity {
                name: "strain",
                label: "strain",
                unit: "",
                without_rig: "the strain without a rig",
                from_s: CREEP_FROM_S,
                moved: Some(Moved {
                    length_m: thickness.0,
                    column: "strain",
                    end: "final_strain",
                }),
            },
            (RigDrive::Force(_), None) => Quantity {
                name: "depth",
                label: "depth / m",
                unit: " m",
                without_rig: "the depth without a rig",
                from_s: CREEP_FROM_S,
                moved: Some(Moved {
                    length_m: 1.0,
                    column: "depth_m",
                    end: "final_depth_m",
                }),
            },
        }
    }

    /// Each sample of a relaxation.
    fn relaxed(&self, profile: RampHold, ran: &Ran) -> Result<Theory<'_>, Failure> {
        let samples = ran.samples();
        let mut history = self.full_history(samples, ran.record.before())?;
        let (t, lead_s) = (self.sample_time_s(), ran.record.start.lead_s);
        let mut ideal = ReferenceSeries::new(
            samples,
            Before::default(),
            |x| {
                let time = (0..x.len()).map(|n| n as f64 * t + lead_s);
                let imposed: Vec<f64> = time.map(|time| profile.position(time)).collect();
                self.full_history_force(&imposed)
            },
            || {
                let mut force = self.full_history_step(0)?;
                Ok(Box::new(move |tick, _| {
                    force(profile.position(tick as f64 * t + lead_s))
                }))
            },
        )?;
        let (depth_m, ramp_time_s) = (profile.depth().0, profile.ramp_time().0);
        let piece = &self.piece;
        let mut force = piece.relaxation(depth_m, ramp_time_s, Seconds(t), lead_s);
        Ok(Box::new(move |sample| {
            let full_history_force_n = history.at(sample);
            TheorySample {
                ideal_position_m: profile.position(sample.time_s),
                full_history_force_n,
                value: self.opposed_n(sample),
                closed_form: force(sample.tick, sample.time_s),
                ideal: ideal.at(sample),
                with_rig: full_history_force_n,
            }
        }))
    }

    fn crept(&self, push: Newtons, ran: &Ran) -> Result<Theory<'_>, Failure> {
        let length_m = self.quantity().moved.map_or(1.0, |moved| moved.length_m);
        let samples = ran.samples();
        let mut history = self.full_history(samples, ran.record.before())?;
        let mut alone = self.massless(push, self.check()?)?;
        let mut ideal = ReferenceSeries::stepped(samples, move |_| alone.step())?;
        let mut depth = (self.piece).creep(push.0, self.actuator.sample_time);
        Ok(Box::new(move |sample| {
            let closed_form = depth(sample.tick, sample.time_s);
            let value = sample.position_m / length_m;
            TheorySample {
                ideal_position_m: closed_form,
                full_history_force_n: history.at(sample),
                value,
                closed_form: closed_form / length_m,
                ideal: ideal.at(sample) / length_m,
                with_rig: value,
            }
        }))
    }

    /// The force that the specimen opposes to an indentation, by the full history of it, N.
    ///
    /// ```text
    /// F = max(0, γ·(E₀·e(x) + η·D^α e(x)))        x ≥ 0
    /// ```
    fn full_history_force(&self, position_m: &[f64]) -> Result<Vec<f64>, Failure> {
        // The virtual tissue begins at 0 and only pushes.
        let piece = &self.piece;
        let effective = piece.effective();
        let depth = position_m.iter().map(|x| effective(x.max(0.0)));
        let depth: Vec<f64> = depth.collect();
        let (shape, t) = (piece.shape_m(), self.actuator.sample_time);
        let reference = ReferenceWeights::of(self.scheme);
        let forces = (piece.material).full_history(shape, reference, t, &depth)?;
        Ok(depth
            .iter()
            .zip(forces)
            .map(|(&x, f)| pushes(x, f))
            .collect())
    }

    /// The full history tick by tick, for a run too long to keep and `before` ticks before it: from each position the force.
    fn full_history_step(&self, before: u64) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
        let mut tissue = self.sampled(self.check()? + before)?;
        let effective = self.piece.effective();
        Ok(move |x: f64| {
            let depth = effective(x.max(0.0));
            let force = tissue.force(depth);
            tissue.advance(depth);
            pushes(depth, force)
        })
    }

    /// Full history of the samples of a run and those before them.
    fn full_history(
        &self,
        samples: Samples<'_>,
        before: Before<'_>,
    ) -> Result<ReferenceSeries<'static>, Failure> {
        ReferenceSeries::new(
            samples,
            before,
            |x| self.full_history_force(x),
            || {
                let mut force = self.full_history_step(before.ticks)?;
                Ok(Box::new(move |_, x| force(x)))
            },
        )
    }
}

/// The force of a tissue that only pushes, N, and only at a depth above 0, m.
fn pushes(depth: f64, force: f64) -> f64 {
    if depth > 0.0 { force.max(0.0) } else { 0.0 }
}

/// Begins the CSV, under names that say where the force comes from.
fn table(ran: &Ran, moved: Option<Moved>, driven: Option<[&'static str; 2]>) -> RunTable {
    let origin = origin(&ran.record);
    let force = format!("{origin}_force_n");
    let moved = moved.map(|Moved { column, .. }| {
        [
            format!("{origin}_{column}"),
            format!("closed_form_{column}"),
        ]
    });
    let mut names = vec![
        "time_s",
        "ideal_position_m",
        "position_m",
        &force,
        "full_history_force_n",
    ];
    match &moved {
        Some(columns) => names.extend(columns.iter().map(String::as_str)),
        None => names.push("closed_form_force_n"),
    }
    names.push("closed_form_error");
    names.extend(driven.iter().flatten());
    ran.folder.named_table_beside_log("csv", &names)
}
