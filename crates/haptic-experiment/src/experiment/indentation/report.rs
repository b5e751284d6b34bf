//! From the run of an indentation and its theory to files, a report and curves.

use super::{Indentation, Load};
use crate::Supervisor;
use crate::document::failure::Failure;
use crate::document::parameters::{CONTACT, FORCE_LIMIT};
use crate::experiment::drive::{DriveJudge, DriveReport, Massless, drive_columns};
use crate::experiment::rendering::{Contact, DEPTH, FORCE, Precision, Rendering, STRESS};
use crate::judge::decimated::Decimated;
use crate::judge::modelled_tissue::Sampled;
use crate::judge::reference::{ReferenceSeries, TOLERANCE};
use crate::judge::report::{Errors, Files, RunReport};
use crate::judge::warnings::Warnings;
use crate::judge::{Curves, LargestError, Origin, Published, percent, relative_error};
use crate::run::Ran;
use crate::run::folder::{FolderRequest, Table};
use crate::run::samples::Samples;
use crate::run::tick::KeptSample;
use fracdiff::Seconds;
use haptic_loop::plant::RigDrive;
use haptic_quantity::{digits, written};
use serde::Serialize;

/// The comparison with the full history begins here, s after contact.
const FROM_S: f64 = 0.01;
/// That of a relaxation with the closed form begins this long after the end of the ramp, s.
const AFTER_RAMP_S: f64 = 0.1;
/// That of creep begins here, s: before, the rig itself is moving.
const CREEP_FROM_S: f64 = 1.0;

/// The tissue is seen on a rig where the depth stays within this share of the closed form.
const SEEN_WITHIN: f64 = 0.05;

/// The result of a relaxation or creep test.
#[derive(Clone, Debug, Serialize)]
pub struct IndentationReport {
    /// Name of the tissue.
    pub tissue: String,
    /// α of the tissue.
    pub order: f64,
    /// How the piece is pressed.
    pub loading: &'static str,
    /// The modulus that the tissue's numbers are of.
    pub modulus: &'static str,
    /// True if the tissue's file does not say which.
    pub modulus_assumed: bool,
    /// Operator.
    pub scheme: String,
    /// Number type of the loop.
    pub precision: Precision,
    /// Contact between indenter and renderer.
    pub(crate) contact: Contact,
    /// Memory of the operator, s; null for everything.
    pub memory_s: Option<f64>,
    /// Of the run.
    #[serde(flatten)]
    pub run: RunReport,
    /// The two errors, each with the samples that it is of.
    #[serde(flatten)]
    pub(crate) errors: Errors,
    /// Relative tolerance of the weights that stand for the full history in a run of more than 10⁶ samples; null
    /// for exact sums.
    pub reference_tolerance: Option<f64>,
    /// Part of `closed_form_error` that is left with an ideal indenter and the full history, over the same samples:
    /// the sampling.
    pub discretisation_error: Option<f64>,
    /// From when on the depth of a creep test on a rig with masses stays within 5 % of the closed form, s; null if it never
    /// does, and without such a rig.
    pub tissue_seen_from_s: Option<f64>,
    /// Part of `closed_form_error` that comes from contact, servo, masses and sensors of the rig.
    pub rig_error: Option<f64>,
    /// Final value over its closed form: force in a relaxation, strain in a creep test.
    pub final_over_theory: Option<f64>,
    /// Final strain, in a creep test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_strain: Option<f64>,
    /// Final depth, in a creep test of another piece than a slab, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_depth_m: Option<f64>,
    /// Work of the controller that held the indenter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) drive: Option<DriveReport>,
}

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
    /// The same with the rig.
    with_rig: f64,
}

/// From when on the tissue is seen on a rig, s; `None` if never.
#[derive(Clone, Copy, Debug)]
struct Seen(Option<f64>);

impl Seen {
    fn of(unseen_until_s: Option<f64>, duration_s: f64, sample_time_s: f64) -> Self {
        let from_s = unseen_until_s.map_or(0.0, |until_s| until_s + sample_time_s);
        Self(Some(from_s).filter(|from_s| *from_s <= duration_s))
    }

    fn warning(self, duration_s: f64) -> Option<String> {
        let ideal = CONTACT.set_to("ideal");
        match self.0 {
            Some(from_s) if from_s <= 0.5 * duration_s => None,
            Some(from_s) => Some(format!(
                "before {} s the run shows the rig, not the tissue: take {ideal}, or a longer run",
                digits(from_s, 3)
            )),
            None => Some(format!(
                "the whole run shows the rig, not the tissue: take {ideal}, or a longer run"
            )),
        }
    }
}

/// What moves in a creep test, and how it is told.
#[derive(Clone, Copy, Debug)]
struct Moved {
    /// What a depth is divided by, m.
    length_m: f64,
    what: &'static str,
    /// In the name of a column.
    column: &'static str,
    unit: &'static str,
    without_rig: &'static str,
}

/// Says of each sample what theory says.
type Theory<'a> = Box<dyn FnMut(&KeptSample) -> TheorySample + 'a>;

impl Indentation {
    /// Runs the experiment; log and CSV go into the folder.
    pub(crate) fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<IndentationReport>, Failure> {
        let ran = self.record(request, supervisor)?;
        let reported = self.report(&ran)?;
        Ok(Published::new(reported, ran.folder))
    }

    /// Judges a run; the table of one that reached its end goes beside its log. A run that was cut short leaves its log alone.
    pub(crate) fn report(&self, ran: &Ran) -> Result<(IndentationReport, Option<Curves>), Failure> {
        let (rendering, record, own) = (&self.rendering, &ran.record, self.drive()?);
        let moves = matches!(self.load, Load::Force { .. });
        let moved = self.moved();
        let (from_s, unit, without_rig) = match self.load {
            Load::Depth { ramp_time_s, .. } => {
                let from_s = ramp_time_s + AFTER_RAMP_S;
                (from_s, " N", "the force with an ideal rig")
            }
            Load::Force { .. } => (CREEP_FROM_S, moved.unit, moved.without_rig),
        };
        let mut theory = match self.load {
            Load::Depth { .. } => self.relaxed(ran)?,
            Load::Force { force_n } => self.crept(ran, force_n)?,
        };
        let mut errors = [
            LargestError::new(FROM_S, "the force by the full history", " N"),
            LargestError::new(from_s, "the closed form", unit),
            LargestError::new(from_s, "the closed form", unit),
            LargestError::new(from_s, without_rig, unit),
        ];
        let mut curves = Decimated::of(record);
        let judge = (ran.drive, self.holds_device());
        let drive = (rendering.drive.as_ref())
            .map(|drive| DriveJudge::new(drive, own, rendering.sample_time_s, judge));
        let mut drive = drive.transpose()?;
        let whole = record.ended.is_none();
        let column = moves.then_some(moved.column);
        let mut csv = whole.then(|| table(ran, column, drive.is_some().then_some(own)));
        let (mut last, mut unseen_until_s, mut deepest_m) = (None, None, 0.0);
        let mut ends_limited = false;
        Samples::of(record, &ran.log.paths).for_each(|sample| {
            let judged = theory(sample);
            let (value, closed_form) = (judged.value, judged.closed_form);
            let pairs = [
                (self.opposed_n(sample), judged.full_history_force_n),
                (value, closed_form),
                (judged.ideal, closed_form),
                (judged.with_rig, judged.ideal),
            ];
            for (largest, (have, want)) in errors.iter_mut().zip(pairs) {
                match sample.is_comparable() {
                    true => largest.add(sample.time_s, have, want),
                    false => largest.pass(sample.time_s),
                }
            }
            last = Some(judged);
            ends_limited = !sample.is_comparable();
            deepest_m = f64::max(deepest_m, sample.position_m);
            if moves && (value / closed_form - 1.0).abs() > SEEN_WITHIN {
                unseen_until_s = Some(sample.time_s);
            }
            let driven = drive.as_mut().map(|drive| drive.add(sample));
            let Some(csv) = &mut csv else {
                return Ok(());
            };
            let error = relative_error(value, closed_form);
            let (tracking_error, [_, force_n]) = driven.unwrap_or_default();
            let values = [value, closed_form, error, tracking_error, force_n];
            curves.add(sample.time_s, values);
            let mut row = row(moves, (sample, self.opposed_n(sample)), &judged, error);
            row.extend(
                driven
                    .iter()
                    .flat_map(|(_, columns)| columns)
                    .copied()
                    .map(Some),
            );
            csv.row(row);
            Ok(())
        })?;
        let files = Files::of_run(ran, csv);
        // On the ideal rig the depth is the tissue's own, whatever is left of the force.
        let unrendered = self.is_ideal() && ends_limited;
        let final_over_theory = (last.map(|last| last.value / last.closed_form))
            .filter(|ratio: &f64| ratio.is_finite() && !unrendered);
        let drive = drive.map(DriveJudge::finish);
        let mut warnings = Warnings::default();
        let memory_s = rendering.memory_s();
        let seen = Seen::of(unseen_until_s, record.duration_s(), rendering.sample_time_s);
        let seen = Some(seen).filter(|_| moves && !self.is_ideal());
        warnings
            .0
            .extend(seen.and_then(|seen| seen.warning(record.duration_s())));
        let piece = &rendering.piece;
        warnings
            .0
            .extend(piece.leaves((self.shortest_s(), record.duration_s()), deepest_m));
        warnings.operator(
            memory_s,
            record.duration_s(),
            // No operator of this program makes the force of a drive.
            final_over_theory.filter(|_| !self.holds_device()),
            if moves { moved.what } else { "force" },
        );
        warnings.limited(record);
        if unrendered {
            warnings.0.push(format!(
                "the closed form assumes the whole push, which the loop did not render up to the end: change {STRESS}, {FORCE} or {FORCE_LIMIT}"
            ));
        }
        warnings
            .0
            .extend(drive.iter().flat_map(DriveReport::warnings));
        let [full_history, closed_form, discretisation, rig] = errors.map(LargestError::get);
        if self.holds_device() && record.link.as_ref().is_some_and(|link| link.simulated) {
            warnings.0.push(
                "the simulated device has no tissue before it: the force is that of its own mass and damping"
                    .to_owned(),
            );
        }
        let run = RunReport::new(
            ran,
            rendering.device_name(),
            rendering.sample_time_s,
            files,
            warnings,
        );
        let report = IndentationReport {
            tissue: rendering.piece.material.name.clone(),
            order: rendering.piece.material.order().get(),
            loading: piece.specimen.loading().kind.name(),
            modulus: piece.material.loading.modulus().name(),
            modulus_assumed: !piece.material.loading.is_known(),
            scheme: rendering.scheme.to_string(),
            run: RunReport {
                final_force_n: record
                    .last
                    .as_ref()
                    .map_or(0.0, |last| self.opposed_n(last)),
                ..run
            },
            errors: Errors {
                full_history,
                closed_form,
            },
            discretisation_error: discretisation.largest,
            rig_error: rig.largest,
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            memory_s,
            tissue_seen_from_s: seen.and_then(|seen| seen.0),
            final_over_theory,
            final_strain: last
                .filter(|_| moves && moved.unit.is_empty())
                .map(|last| last.value),
            final_depth_m: last
                .filter(|_| moves && !moved.unit.is_empty())
                .map(|last| last.value),
            precision: rendering.precision_run(),
            contact: rendering.contact,
            drive,
        };
        let held = report
            .drive
            .as_ref()
            .map(|_| ["tracking_error", "drive_force_n"]);
        let [tracking_error, force_n] = held.unwrap_or_default();
        let names = [
            "values",
            "closed_form",
            "relative_error",
            tracking_error,
            force_n,
        ];
        let slab = rendering.piece.specimen.slab_sizes();
        let (what, remark) = match self.load {
            Load::Depth {
                depth_m,
                ramp_time_s,
            } => {
                let until = self.duration_s;
                let depth = match slab {
                    Some((_, thickness)) => format!("{} % strain", percent(depth_m / thickness.0)),
                    None => written(DEPTH.key, depth_m),
                };
                let remark = format!("{depth} in {ramp_time_s} s, held until {until} s");
                ("Stress relaxation", remark)
            }
            Load::Force { force_n } => {
                let push = match slab {
                    Some((area, _)) => format!("{} Pa", digits(force_n / area.0, 4)),
                    None => written(FORCE.key, force_n),
                };
                ("Creep", format!("{push} from t = 0"))
            }
        };
        let (tissue, origin) = (&rendering.piece.material.description, Origin::of(record));
        let title = format!("{what} of {tissue}, {}", origin.word());
        let remark = format!("{}, {remark}", report.loading);
        let curves = whole.then(|| curves.named(names, origin, title, remark));
        Ok((report, curves))
    }

    /// Closed form of the force of a relaxation, N; zero for creep, which has one of the depth.
    #[must_use]
    pub fn closed_form(&self, time_s: f64) -> f64 {
        match self.load {
            Load::Depth {
                depth_m,
                ramp_time_s,
            } => self
                .rendering
                .piece
                .relaxed(depth_m, ramp_time_s, &[time_s])[0],
            Load::Force { .. } => 0.0,
        }
    }

    /// The shortest time that the load asks of the tissue, s: the ramp, or a sample after a step.
    fn shortest_s(&self) -> f64 {
        match self.load {
            Load::Depth { ramp_time_s, .. } => ramp_time_s,
            Load::Force { .. } => self.rendering.sample_time_s,
        }
    }

    /// What moves in a creep test: the strain of a slab, else the depth.
    fn moved(&self) -> Moved {
        match self.rendering.piece.specimen.slab_sizes() {
            Some((_, thickness)) => Moved {
                length_m: thickness.0,
                what: "strain",
                column: "strain",
                unit: "",
                without_rig: "the strain without a rig",
            },
            None => Moved {
                length_m: 1.0,
                what: "depth",
                column: "depth_m",
                unit: " m",
                without_rig: "the depth without a rig",
            },
        }
    }

    /// Each sample of a relaxation.
    fn relaxed(&self, ran: &Ran) -> Result<Theory<'_>, Failure> {
        let (
            RigDrive::Position(profile),
            Load::Depth {
                depth_m,
                ramp_time_s,
            },
        ) = (self.drive()?, self.load)
        else {
            return Err(Failure::bad_input("a push is not a relaxation"));
        };
        let rendering = &self.rendering;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut history = self.full_history(samples)?;
        let t = rendering.sample_time_s;
        let mut ideal = ReferenceSeries::new(
            samples,
            |x| {
                let time = (0..x.len()).map(|n| n as f64 * t);
                let imposed: Vec<f64> = time.map(|time| profile.position(time)).collect();
                self.full_history_force(&imposed).map_err(Failure::Run)
            },
            || {
                let mut force = self.full_history_step()?;
                Ok(Box::new(move |tick, _| {
                    force(profile.position(tick as f64 * t))
                }))
            },
        )?;
        let mut force = (rendering.piece).relaxation(depth_m, ramp_time_s, Seconds(t));
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

    fn crept(&self, ran: &Ran, force_n: f64) -> Result<Theory<'_>, Failure> {
        let length_m = self.moved().length_m;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut history = self.full_history(samples)?;
        let mut ideal = ReferenceSeries::new(
            samples,
            |x| {
                let mut alone = self.massless()?;
                Ok(x.iter().map(|_| alone.next()).collect())
            },
            || {
                let mut alone = self.massless()?;
                Ok(Box::new(move |_, _| alone.next()))
            },
        )?;
        let mut depth =
            (self.rendering.piece).creep(force_n, Seconds(self.rendering.sample_time_s));
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

    /// The tissue alone under the push.
    pub(super) fn massless(&self) -> Result<Massless, Failure> {
        let Load::Force { force_n } = self.load else {
            return Err(Failure::bad_input("a relaxation has no push"));
        };
        Ok(Massless::new(
            self.sampled(self.check()?)?,
            self.rendering.piece.specimen.depth_map(),
            force_n,
            Seconds(self.rendering.sample_time_s),
        ))
    }

    /// The piece tick by tick with all of its past, from e(δ) to force.
    fn sampled(&self, samples: u64) -> Result<Sampled, Failure> {
        let Rendering { piece, .. } = &self.rendering;
        let t = Seconds(self.rendering.sample_time_s);
        let reference = self.rendering.reference_kernel();
        (piece.material).sampled(piece.shape_m(), reference, t, samples)
    }

    /// The force that the specimen opposes to an indentation, by the full history of it, N.
    ///
    /// ```text
    /// F = max(0, γ·(E₀·e(x) + η·D^α e(x)))        x ≥ 0
    /// ```
    fn full_history_force(&self, position_m: &[f64]) -> anyhow::Result<Vec<f64>> {
        // The virtual tissue begins at 0 and only pushes.
        let Rendering { piece, .. } = &self.rendering;
        let effective = piece.effective();
        let depth = position_m.iter().map(|x| effective(x.max(0.0)));
        let depth: Vec<f64> = depth.collect();
        let (shape, t) = (piece.shape_m(), Seconds(self.rendering.sample_time_s));
        let reference = self.rendering.reference_kernel();
        let forces = (piece.material).full_history(shape, reference, t, &depth)?;
        Ok(depth
            .iter()
            .zip(forces)
            .map(|(&x, f)| pushes(x, f))
            .collect())
    }

    /// The same tick by tick, for a run too long to keep: from each position the force.
    fn full_history_step(&self) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
        let mut tissue = self.sampled(self.check()?)?;
        let effective = self.rendering.piece.effective();
        Ok(move |x: f64| {
            let depth = effective(x.max(0.0));
            let force = tissue.force(depth);
            tissue.advance(depth);
            pushes(depth, force)
        })
    }

    fn full_history(&self, samples: Samples<'_>) -> Result<ReferenceSeries<'static>, Failure> {
        ReferenceSeries::new(
            samples,
            |x| self.full_history_force(x).map_err(Failure::Run),
            || {
                let mut force = self.full_history_step()?;
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
fn table(ran: &Ran, moved: Option<&str>, drive: Option<RigDrive>) -> Table {
    let word = Origin::of(&ran.record).word();
    let own_force = format!("{word}_force_n");
    let moved = moved.map(|moved| [format!("{word}_{moved}"), format!("closed_form_{moved}")]);
    let drive = drive.map(drive_columns);
    let mut names = vec![
        "time_s",
        "ideal_position_m",
        "position_m",
        &own_force,
        "full_history_force_n",
    ];
    match &moved {
        Some(columns) => names.extend(columns.iter().map(String::as_str)),
        None => names.push("closed_form_force_n"),
    }
    names.push("closed_form_error");
    names.extend(drive.iter().flatten());
    ran.folder.named_table_beside_log("csv", &names)
}

/// A row of it. A sample without a relative error has an empty cell.
fn row(
    moves: bool,
    (sample, opposed_n): (&KeptSample, f64),
    judged: &TheorySample,
    error: f64,
) -> Vec<Option<f64>> {
    let mut row = vec![
        Some(sample.time_s),
        Some(judged.ideal_position_m),
        Some(sample.position_m),
        Some(opposed_n),
        Some(judged.full_history_force_n),
    ];
    // The force of a relaxation stands there already.
    if moves {
        row.push(Some(judged.value));
    }
    row.push(Some(judged.closed_form));
    row.push(Some(error).filter(|error| error.is_finite()));
    row
}
