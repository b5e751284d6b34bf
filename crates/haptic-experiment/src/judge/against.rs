//! A measured record beside the curve of a run.
//!
//! The record becomes what the run is judged by: the force of a relaxation, the strain of a slab that creeps, the depth of another piece
//! that does. The piece, its loading and the strain or push are those of the run.
//!
//! ```text
//! relaxation   F = f          F = σ·A          F(t) = γ·Σ M(t − s)·Δe(s)      s the middles of 64 steps of the ramp
//! creep        ε = ε          ε = δ/h          e(δ(t)) = F₀·J(t)/γ
//! error        y(tᵢ)/rᵢ − 1, and as one number √(Σ(yᵢ − rᵢ)²/Σrᵢ²)
//! ```
//! - *Symbols*: f N, σ Pa and δ m are measured, M Pa and J 1/Pa too; γ m is the shape of the piece, e(δ) m its map, A m² and h m its sizes;
//!   y is the run and r the record, both in N, m or 1.
//! - *Times*: tᵢ are those of the record, so that nothing measured is interpolated; the run is straight between its ticks. Zero is the start
//!   of the ramp or of the push. A log or table of ours and a modulus or compliance have it; in any other record it is the last sample before
//!   what was imposed, else what answered, leaves its first value by 6 σ of its noise. The noise is the median of the second differences. A
//!   record that does not begin at rest keeps the zero of its clock.
//! - *Range*: samples before the start or after the end of the run are left out, and those of a modulus on the ramp, which a step never saw.
//! - *Errors*: a file that is no record, times that fall, a quantity that cannot be converted, fewer than two samples in the range, a record
//!   that ends before the hold.
//! - *Cost*: 64 interpolations a sample of a modulus before the run, a few sums a sample after it.
//! - *Source*: linear superposition (L. Boltzmann, Sitzungsber. Akad. Wiss. Wien 70, 1874); indenters as in [`TissuePiece`].

use super::decimated::Decimated;
use super::modelled_tissue::TissuePiece;
use super::report::{Files, compared};
use super::{Compared, LargestError, Overlay};
use crate::run::Ran;
use crate::run::folder::Table;
use crate::run::tick::KeptSample;
use fracdiff::parameter::Shown;
use haptic_log::record::{Entry, LogFiles};
use haptic_loop::plant::RigDrive;
use haptic_quantity::{Key, digits, written};
use haptic_tissue::identify::RecordKind;
use haptic_tissue::identify::table::{Column, Columns, Reader, Reading, TABLE_MOST, read_table};
use haptic_tissue::read_bytes;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Keys of the experiment that a record may not fit.
const RAMP_TIME: Key = Key("ramp_time_s");
const DURATION: Key = Key("duration_s");
/// Steps of a ramp through which a modulus is driven.
const STEPS: u32 = 64;
/// The first line of a table that this program writes beside its log: its time begins with the ramp.
const OURS: &[u8] = b"time_s,ideal_position_m";
/// A column that begins above this share of its largest value does not begin at rest.
const REST: f64 = 0.05;
/// Fewer second differences than this say nothing of the noise.
const FEW: usize = 8;
/// A held depth that differs from that of the run by more than this share is another experiment.
const HELD: f64 = 0.01;

/// A record in the quantity of a run, and on its clock.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    path: PathBuf,
    time_s: Vec<f64>,
    values: Vec<f64>,
    /// Time of the record at which the ramp or the push begins, s.
    start_s: f64,
    /// What was made of it, a sentence each.
    notes: Vec<String>,
    /// What makes it another experiment than the run.
    warnings: Vec<String>,
}

/// A quantity of a record that can become that of a run.
struct Convertible {
    column: Column,
    /// `None` for a modulus or compliance, which belongs to the material and not to the piece.
    divisor: Option<f64>,
    words: String,
}

impl Convertible {
    fn new(column: Column, divisor: impl Into<Option<f64>>, words: impl Into<String>) -> Self {
        Self {
            column,
            divisor: divisor.into(),
            words: words.into(),
        }
    }

    /// What may be compared with this load of a piece, the best first.
    fn all(piece: &TissuePiece, load: RigDrive) -> Vec<Self> {
        let slab = piece.specimen.slab_sizes();
        let depth = || Self::new(Column::Position, 1.0, "the depth as measured");
        match load {
            RigDrive::Position(profile) => {
                let stress = slab.map(|(area, _)| {
                    let words = format!("stress times {}", written("area_m2", area.0));
                    Self::new(Column::Stress, 1.0 / area.0, words)
                });
                let words = format!(
                    "force of the modulus on this piece, driven through the ramp of {} s",
                    profile.ramp_time().0
                );
                let modulus = Self::new(Column::Modulus, None, words);
                let force = Self::new(Column::Force, 1.0, "the force as measured");
                [force].into_iter().chain(stress).chain([modulus]).collect()
            }
            RigDrive::Force(_) => {
                let moved = match slab {
                    Some((_, thickness)) => {
                        let words = format!("depth over {}", written("thickness_m", thickness.0));
                        vec![
                            Self::new(Column::Strain, 1.0, "the strain as measured"),
                            Self::new(Column::Position, thickness.0, words),
                        ]
                    }
                    None => vec![depth()],
                };
                let words = "the compliance under the push of this run";
                let compliance = Self::new(Column::Compliance, None, words);
                moved.into_iter().chain([compliance]).collect()
            }
        }
    }
}

impl Measured {
    /// Reads a table or a log, as the load of a run on this piece would show it.
    ///
    /// # Errors
    /// In one line, what is wrong with it and what to do.
    pub(crate) fn read(
        path: &Path,
        piece: &TissuePiece,
        load: RigDrive,
        duration_s: f64,
    ) -> Result<Self, String> {
        let wrong = |what: String| format!("{}: {what}", path.display());
        let (columns, on_our_clock) = read(path).map_err(wrong)?;
        let ways = Convertible::all(piece, load);
        let found = ways.into_iter().find_map(|way| {
            let values = of(&columns, way.column)?.to_vec();
            Some((way, values))
        });
        let (way, values) = found.ok_or_else(|| wrong(lacks(&columns, piece, load)))?;
        let mut notes = columns.notes.clone();
        let mut measured = Self {
            path: path.to_owned(),
            time_s: Vec::new(),
            values,
            start_s: 0.0,
            notes: Vec::new(),
            warnings: Vec::new(),
        };
        match way.divisor {
            Some(divisor) => {
                let times = of(&columns, Column::Time).ok_or_else(|| {
                    wrong("there is no column of time: name it time_s".to_owned())
                })?;
                rising(times, &columns.lines).map_err(wrong)?;
                measured.time_s = times.to_vec();
                let start = match on_our_clock {
                    true => None,
                    false => start(&columns, load),
                };
                let rest = measured.begin(start, load, &mut notes, on_our_clock);
                let values = measured.values.iter_mut();
                values.for_each(|value| *value = (*value - rest) / divisor);
                measured.warnings.extend(held(&columns, start, piece, load));
            }
            None => measured.of_material(columns, piece, load).map_err(wrong)?,
        }
        notes.insert(0, format!("compared is {}", way.words));
        let finite = measured.values.iter().filter(|value| value.is_finite());
        if finite.sum::<f64>() < 0.0 {
            let values = measured.values.iter_mut();
            values.for_each(|value| *value = 0.0 - *value);
            notes.push("the sign of the record is turned".to_owned());
        }
        measured.notes = notes;
        let ramp_s = match load {
            RigDrive::Position(profile) => profile.ramp_time().0,
            RigDrive::Force(_) => 0.0,
        };
        measured.within(duration_s, ramp_s).map_err(wrong)?;
        Ok(measured)
    }

    /// Puts the start at 0, and says how; gives what the quantity was at rest, which a creep test counts from.
    fn begin(
        &mut self,
        start: Option<usize>,
        load: RigDrive,
        notes: &mut Vec<String>,
        on_our_clock: bool,
    ) -> f64 {
        let Some(start) = start else {
            notes.push(match on_our_clock {
                true => "the record has the clock of a run".to_owned(),
                false => "no start is seen in the record: the zero of its time is taken".to_owned(),
            });
            return 0.0;
        };
        self.start_s = self.time_s[start];
        let start_s = self.start_s;
        self.time_s.iter_mut().for_each(|time| *time -= start_s);
        notes.push(format!(
            "the record is at rest up to {}, which is laid on the start of the run",
            written("start_s", start_s)
        ));
        match load {
            RigDrive::Position(_) => 0.0,
            RigDrive::Force(_) => self.values[start],
        }
    }

    /// Of a modulus or a compliance over the time after a step.
    fn of_material(
        &mut self,
        columns: Columns,
        piece: &TissuePiece,
        load: RigDrive,
    ) -> Result<(), String> {
        let kind = match load {
            RigDrive::Position(_) => RecordKind::Relaxation,
            RigDrive::Force(_) => RecordKind::Creep,
        };
        let reading = Reading {
            kind: Some(kind),
            ..Reading::default()
        };
        let understood = columns
            .record(&reading)
            .map_err(|error| error.to_string())?;
        let of_loading = piece.specimen.loading().kind.modulus();
        let modulus = understood.loading.modulus.unwrap_or(of_loading);
        let shape = piece.specimen.shape(modulus);
        let (time_s, first) = (understood.record.x(), understood.record.first());
        match load {
            RigDrive::Position(profile) => {
                let (depth_m, ramp_s) = (profile.depth().0, profile.ramp_time().0);
                let moduli = PowerLaws::new(time_s, first);
                let (effective, step) = (piece.effective(), 1.0 / f64::from(STEPS));
                let steps = (0..STEPS).map(|n| {
                    let [from, middle, to] =
                        [0.0, 0.5, 1.0].map(|part| (f64::from(n) + part) * step);
                    (
                        middle * ramp_s,
                        effective(to * depth_m) - effective(from * depth_m),
                    )
                });
                let steps: Vec<(f64, f64)> = steps.collect();
                let begin_s = time_s.first().map_or(0.0, |first| first + ramp_s);
                let force = |time: &f64| {
                    let parts = steps.iter().map(|(at, rise)| moduli.at(time - at) * rise);
                    match *time >= begin_s {
                        true => shape * parts.sum::<f64>(),
                        // The step of the record saw nothing of this.
                        false => f64::NAN,
                    }
                };
                self.values = time_s.iter().map(force).collect();
            }
            RigDrive::Force(push) => {
                let map = piece.specimen.depth_map();
                let length_m =
                    (piece.specimen.slab_sizes()).map_or(1.0, |(_, thickness)| thickness.0);
                let depth = |compliance: &f64| {
                    let effective = push.0 * compliance / shape;
                    map.map_or(effective, |map| map.depth(effective)) / length_m
                };
                self.values = first.iter().map(depth).collect();
            }
        }
        self.time_s = time_s.to_vec();
        Ok(())
    }

    /// Keeps what lies within the run.
    fn within(&mut self, duration_s: f64, ramp_s: f64) -> Result<(), String> {
        let [first_s, last_s] =
            [self.time_s.first(), self.time_s.last()].map(|end| end.copied().unwrap_or(f64::NAN));
        if last_s <= ramp_s {
            return Err(format!(
                "the record ends {} s after the start of the ramp, and the hold begins at {ramp_s} s: \
                 give a shorter {RAMP_TIME}, or a longer record",
                digits(last_s, 6)
            ));
        }
        let pairs = self.time_s.iter().zip(&self.values);
        let inside =
            pairs.filter(|(time, value)| (0.0..=duration_s).contains(*time) && value.is_finite());
        let (time_s, values): (Vec<f64>, Vec<f64>) = inside.unzip();
        let count = self.time_s.len();
        if time_s.len() < 2 {
            return Err(format!(
                "the record goes from {} s to {} s after the start of the ramp or push, and the run ends at {duration_s} s: \
                 they need two samples in common, of a modulus from its first time after the ramp on: change {DURATION} or the record",
                digits(first_s, 6),
                digits(last_s, 6)
            ));
        }
        if time_s.len() < count {
            let outside = count - time_s.len();
            self.notes.push(format!(
                "{outside} of {count} samples lie outside the run and are not compared"
            ));
        }
        (self.time_s, self.values) = (time_s, values);
        Ok(())
    }

    pub(crate) fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        self.warnings.iter().cloned()
    }
}

/// The columns of a file, and true if their time begins where a run does.
fn read(path: &Path) -> Result<(Columns, bool), String> {
    let name = path.to_string_lossy().to_lowercase();
    if name.ends_with(".mcap") || name.ends_with(".mcap.part") {
        return log(path).map(|columns| (columns, true));
    }
    let bytes = read_bytes(path, TABLE_MOST);
    let bytes = bytes.map_err(|error| format!("cannot be read: {error}; give a table or a log"))?;
    let read = read_table(&bytes).and_then(|table| Reader::default().read(table));
    let columns = read.map_err(|error| {
        format!("{error}; here columns are found by their headers alone, as time_s and force_n: rename or remove others")
    })?;
    Ok((columns, bytes.starts_with(OURS)))
}

/// Time, position and opposing force of a log, by which its run was judged.
fn log(path: &Path) -> Result<Columns, String> {
    let mut read: [Vec<f64>; 3] = Default::default();
    let mut files = LogFiles::open(path).map_err(|error| error.to_string())?;
    for entry in &mut files {
        let Entry::Tick(tick) = entry.map_err(|error| error.to_string())? else {
            continue;
        };
        let sample = KeptSample::of(&tick);
        let row = [sample.time_s, sample.position_m, sample.reaction_n()];
        for (column, value) in read.iter_mut().zip(row) {
            column.push(value);
        }
    }
    if read[0].is_empty() {
        return Err("the log has no sample: give another".to_owned());
    }
    let cut = (!files.condition().complete).then(|| "the log is not whole".to_owned());
    let columns = [Column::Time, Column::Position, Column::Force];
    let values = columns.into_iter().zip(read);
    Ok(Columns {
        values: values
            .map(|(column, values)| (column, column.header().to_owned(), values))
            .collect(),
        notes: cut.into_iter().collect(),
        ..Columns::default()
    })
}

fn of(columns: &Columns, wanted: Column) -> Option<&[f64]> {
    let mut all = columns.values.iter();
    let found = all.find(|(column, ..)| *column == wanted)?;
    Some(&found.2)
}

/// What a record without a quantity that can be compared has, and what it needs.
fn lacks(columns: &Columns, piece: &TissuePiece, load: RigDrive) -> String {
    let names: Vec<&str> = columns.values.iter().map(|value| &*value.1).collect();
    let wanted: Vec<&str> = Convertible::all(piece, load)
        .iter()
        .map(|way| way.column.header())
        .collect();
    format!(
        "found are {}, and this run ({}) is compared with {}: give a record with one of them",
        names.join(", "),
        piece.specimen.loading().kind.name(),
        wanted.join(" or ")
    )
}

fn rising(times: &[f64], lines: &[u64]) -> Result<(), String> {
    let falls = |pair: &[f64]| pair[1] < pair[0] || pair[1].is_nan();
    let Some(before) = times.windows(2).position(falls) else {
        return Ok(());
    };
    let line = lines.get(before + 1);
    Err(format!(
        "{}time {} s comes after {} s: sort the rows",
        line.map_or_else(String::new, |line| format!("line {line}: ")),
        Shown(times[before + 1]),
        Shown(times[before])
    ))
}

/// The last sample at rest: by what was imposed, else by what answered if that begins near 0; `None` if no rest is seen.
fn start(columns: &Columns, load: RigDrive) -> Option<usize> {
    let moves = [Column::Position, Column::Strain];
    let pushes = [Column::Force, Column::Stress];
    let [imposed, answers] = match load {
        RigDrive::Position(_) => [moves, pushes],
        RigDrive::Force(_) => [pushes, moves],
    };
    let imposed = imposed.into_iter().find_map(|column| of(columns, column));
    let answer = answers.into_iter().find_map(|column| of(columns, column));
    let near_0 = answer.filter(|values| {
        let most = values
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        values[0].abs() < REST * most
    });
    imposed.and_then(leaves).or_else(|| near_0.and_then(leaves))
}

/// The last sample before these values leave the first of them, by more than their noise.
fn leaves(values: &[f64]) -> Option<usize> {
    let first = values.first()?;
    let second = values
        .windows(3)
        .map(|of| (of[0] - 2.0 * of[1] + of[2]).abs());
    let mut second: Vec<f64> = second.collect();
    second.sort_by(f64::total_cmp);
    // σ of white noise by the median of |x₋ − 2x + x₊|, whose σ is √6 times as large. Of a few samples they are the curve itself.
    let median = match second.len() {
        0..FEW => 0.0,
        count => second[count / 2],
    };
    let sigma = median / (0.6745 * 6.0_f64.sqrt());
    let off = |value: &f64| (value - first).abs();
    let most = values.iter().map(off).fold(0.0, f64::max);
    let left = values.iter().position(|value| off(value) > 6.0 * sigma)?;
    // What moves no further than its noise is held.
    (most > 20.0 * sigma).then(|| left.saturating_sub(1))
}

/// A warning if the record is held at another depth than the run.
fn held(
    columns: &Columns,
    start: Option<usize>,
    piece: &TissuePiece,
    load: RigDrive,
) -> Option<String> {
    let RigDrive::Position(profile) = load else {
        return None;
    };
    let thickness_m = piece
        .specimen
        .slab_sizes()
        .map(|(_, thickness)| thickness.0);
    let depths = of(columns, Column::Position).map(|depths| (depths, 1.0));
    let strains = || Some((of(columns, Column::Strain)?, thickness_m?));
    let (way, length_m) = depths.or_else(strains)?;
    let rest = start.map_or(0.0, |start| way[start]);
    let held_m = length_m * (way.last()? - rest).abs();
    let wanted_m = profile.depth().0;
    ((held_m / wanted_m - 1.0).abs() > HELD).then(|| {
        format!(
            "the record is held at {}, this run at {}: change its strain or depth",
            written("depth_m", held_m),
            written("depth_m", wanted_m)
        )
    })
}

/// A curve of positive values that is a power of time between its samples.
struct PowerLaws {
    /// ln t and ln M.
    points: Vec<(f64, f64)>,
}

impl PowerLaws {
    fn new(time_s: &[f64], values: &[f64]) -> Self {
        let pairs = time_s.iter().zip(values);
        Self {
            points: pairs.map(|(t, m)| (libm::log(*t), libm::log(*m))).collect(),
        }
    }

    /// The value within the samples, at their ends the first and the last of them.
    fn at(&self, time_s: f64) -> f64 {
        let (points, x) = (&self.points, libm::log(time_s));
        let next = points.partition_point(|point| point.0 <= x);
        let (a, b) = (points[next.max(1) - 1], points[next.min(points.len() - 1)]);
        let share = if b.0 > a.0 {
            (x - a.0) / (b.0 - a.0)
        } else {
            0.0
        };
        libm::exp(a.1 + share * (b.1 - a.1))
    }
}

/// Lays a record over a run, sample by sample of the run.
pub(crate) struct Comparison<'a> {
    measured: &'a Measured,
    table: Option<Table>,
    curves: Decimated<2>,
    /// The next sample of the record.
    next: usize,
    /// Time and value of the tick before, if it may be compared.
    before: Option<(f64, f64)>,
    /// Σ(y − r)² and Σr².
    squares: [f64; 2],
    largest: LargestError,
    /// Times of the first and of the last sample that were compared.
    span_s: Option<[f64; 2]>,
    samples: u64,
    final_ratio: f64,
}

impl<'a> Comparison<'a> {
    /// Of a quantity with this name in tables; the largest error is looked for from `from_s` on.
    pub(crate) fn new(
        measured: &'a Measured,
        ran: &Ran,
        origin: &str,
        column: &str,
        from_s: f64,
    ) -> Self {
        let table = ran.record.ended.is_none().then(|| {
            let [record, run, difference] =
                ["record", origin, "difference"].map(|whose| format!("{whose}_{column}"));
            let names = ["time_s", &record, &run, &difference, "relative_error"];
            ran.folder.named_table_beside_log("against.csv", &names)
        });
        Self {
            measured,
            table,
            curves: Decimated::of(&ran.record),
            next: 0,
            before: None,
            squares: [0.0; 2],
            largest: LargestError::new(from_s, "the record", ""),
            span_s: None,
            samples: 0,
            final_ratio: f64::NAN,
        }
    }

    /// The next tick; without a value where the run says nothing of its law.
    pub(crate) fn add(&mut self, time_s: f64, value: Option<f64>) {
        while let Some(&at) = self.measured.time_s.get(self.next)
            && at <= time_s
        {
            let run = match (self.before, value) {
                (_, Some(value)) if at >= time_s => Some(value),
                (Some((from_s, from)), Some(value)) => {
                    Some(from + (value - from) * (at - from_s) / (time_s - from_s))
                }
                (_, None) | (None, Some(_)) => None,
            };
            if let Some(run) = run {
                self.compare(at, run, self.measured.values[self.next]);
            }
            self.next += 1;
        }
        self.before = value.map(|value| (time_s, value));
    }

    fn compare(&mut self, at_s: f64, run: f64, record: f64) {
        let difference = run - record;
        let error = difference / record;
        self.squares[0] += difference * difference;
        self.squares[1] += record * record;
        self.largest.add(at_s, run, record);
        self.span_s = Some([self.span_s.map_or(at_s, |span| span[0]), at_s]);
        self.samples += 1;
        self.final_ratio = run / record;
        self.curves.add(at_s, [record, error]);
        if let Some(table) = &mut self.table {
            let error = Some(error).filter(|error| error.is_finite());
            table.row((at_s, record, run, difference, error));
        }
    }

    /// Rows of a report, the curve of a run that reached its end, and why its table could not be written.
    pub(crate) fn finish(self) -> ([Value; 3], Overlay, Option<String>) {
        let rms = (self.squares[0] / self.squares[1]).sqrt();
        let error = match self.span_s {
            Some(_) if self.squares[1] == 0.0 => {
                Compared::without_meaning("the record is 0 wherever it is compared")
            }
            Some(span_s) => Compared::of_window(rms, span_s, self.samples),
            None => Compared::without_meaning("the run ended before the record begins"),
        };
        let Files { csv, unwritten } = Files::finished(self.table);
        let Measured {
            path,
            start_s,
            notes,
            ..
        } = self.measured;
        let beside = json!({
            "final_over_record": Some(self.final_ratio).filter(|ratio| ratio.is_finite()),
            "against": {
                "record": path.display().to_string(),
                // Where the ramp or push begins, on the clock of the record.
                "record_start_s": start_s,
                "notes": notes,
                "csv": csv,
            },
        });
        let rows = [
            // The rms of run less record over that of the record.
            compared("against_error", &error),
            // The largest difference over the record's value at that time.
            compared("against_largest_error", &self.largest.get()),
            beside,
        ];
        let (_, time_s, [values, relative_error]) = self.curves.curves();
        let overlay = Overlay {
            time_s,
            values,
            relative_error,
            rms,
        };
        (rows, overlay, unwritten)
    }
}
