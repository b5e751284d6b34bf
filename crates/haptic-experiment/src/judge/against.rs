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
//! - *Errors*: a file that is no record, times that fall, a quantity that cannot be converted, fewer than two samples on the hold.
//! - *Cost*: 64 interpolations a sample of a modulus before the run, a few sums a sample after it.
//! - *Source*: linear superposition (L. Boltzmann, Sitzungsber. Akad. Wiss. Wien 70, 1874); indenters as in [`TissuePiece`].

use super::{
    beginning::Beginning,
    origin,
    report::{Files, compared},
};
use fracdiff::parameter::Shown;
use haptic_judge::{
    compared::{Compared, LargestError},
    curves::Overlay,
    decimated::Decimated,
    modelled_tissue::TissuePiece,
};
use haptic_log::record::{Entry, LogFiles};
use haptic_loop::plant::RigDrive;
use haptic_quantity::{Key, digits, written};
use haptic_run::Ran;
use haptic_trial::tick::KeptSample;
use measured_table::{Column, Columns, Reader, TABLE_MOST, read_bytes, read_table};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tissue_identification::{RecordKind, TableDetails, white_noise};

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

/// Advice for a table whose columns or units `identify` could be given.
const HEADER_ALONE: &str = "beside a run only the header tells what a column is, as time_s and force_n: rename or remove others";

/// Time on the clock of a run, s, and a value.
type Samples = Vec<(f64, f64)>;

/// A record in the quantity of a run, and on its clock.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    path: PathBuf,
    samples: Samples,
    /// Time of the record at which the ramp or the push begins, s.
    start_s: f64,
    /// Conversions applied to the record, a sentence each.
    notes: Vec<String>,
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
        let wrong = |reason: String| format!("{}: {reason}", path.display());
        let (columns, on_our_clock) = read(path).map_err(wrong)?;
        let mut notes = columns.notes.clone();
        let converted = converted(columns, on_our_clock, piece, load, &mut notes);
        let (samples, start_s) = converted.map_err(wrong)?;
        let mut samples = within(&samples, duration_s, load).map_err(wrong)?;
        if samples.iter().map(|sample| sample.1).sum::<f64>() < 0.0 {
            samples.iter_mut().for_each(|sample| sample.1 *= -1.0);
            notes.push("the sign of the record is turned".to_owned());
        }
        let path = path.to_owned();
        Ok(Self {
            path,
            samples,
            start_s,
            notes,
        })
    }
}

/// Samples in the quantity of the run from its start on, and the time of the record at which that is, s.
fn converted(
    columns: Columns,
    on_our_clock: bool,
    piece: &TissuePiece,
    load: RigDrive,
    notes: &mut Vec<String>,
) -> Result<(Samples, f64), String> {
    let slab = piece.specimen.slab_sizes();
    let area_m2 = slab.map(|sizes| sizes.0.0);
    let length_m = slab.map(|sizes| sizes.1.0);
    // Comparable columns, each with its divisor, if this piece has one, and words; the column of the material comes last.
    let as_is = (Some(1.0), "as measured");
    let over_length = (length_m, "over the thickness");
    let (ways, of_whole) = match load {
        RigDrive::Position(_) => {
            let per_area = (area_m2.map(|area| 1.0 / area), "times the area");
            let ways = [(Column::Force, as_is), (Column::Stress, per_area)];
            (ways, Column::Modulus)
        }
        RigDrive::Force(_) => {
            let strain = (length_m.map(|_| 1.0), as_is.1);
            let depth = length_m.map_or(as_is, |_| over_length);
            let ways = [(Column::Strain, strain), (Column::Position, depth)];
            (ways, Column::Compliance)
        }
    };
    let direct = ways
        .into_iter()
        .filter_map(|(column, (divisor, words))| Some((column, divisor?, words)));
    let found = direct
        .clone()
        .find_map(|way| Some((way, of(&columns, way.0)?)));
    let Some(((column, divisor, words), values)) = found else {
        if of(&columns, of_whole).is_some() {
            is_clear(&columns, of_whole)?;
            notes.push(format!(
                "{} on the piece, under the load of the run",
                of_whole.name()
            ));
            return of_material(columns, piece, load).map(|samples| (samples, 0.0));
        }
        let has: Vec<&str> = columns.values.iter().map(|value| &*value.1).collect();
        let wanted = direct.map(|way| way.0).chain([of_whole]);
        let wanted: Vec<&str> = wanted.map(Column::header).collect();
        return Err(format!(
            "this run ({}) is compared with {}, and the record has only {}: give a record with one of them",
            piece.specimen.loading().kind.name(),
            wanted.join(" or "),
            has.join(", ")
        ));
    };
    is_clear(&columns, column)?;
    notes.push(format!("{} {words}", column.name()));
    let time_s = of(&columns, Column::Time).ok_or("there is no column of time: name it time_s")?;
    if let Some(before) = time_s.windows(2).position(|pair| pair[1] < pair[0]) {
        let line = columns.lines.get(before + 1).copied().unwrap_or_default();
        let [then, now] = [before, before + 1].map(|row| Shown(time_s[row]));
        return Err(format!(
            "line {line}: time {now} s comes after {then} s: sort the rows"
        ));
    }
    let start = start(&columns, load).filter(|_| !on_our_clock);
    let clock = match start {
        None => "time is that of the record",
        Some(_) => "time is 0 where the record ends its rest",
    };
    notes.push(clock.to_owned());
    let at_start = |column: &[f64]| start.map_or(0.0, |start| column[start]);
    let (start_s, mut rest) = (at_start(time_s), at_start(values));
    if let RigDrive::Position(profile) = load {
        // A force has a zero of its own.
        rest = 0.0;
        let moved = |column| {
            let way = of(&columns, column)?;
            Some((way.last()? - at_start(way)).abs())
        };
        let strained = || Some(moved(Column::Strain)? * length_m?);
        let held_m = moved(Column::Position).or_else(strained);
        let another = |held_m: &f64| (held_m / profile.depth().0 - 1.0).abs() > HELD;
        notes.extend(held_m.filter(another).map(|held_m| {
            let [held, wanted] = [held_m, profile.depth().0].map(|depth| written("depth_m", depth));
            format!("the record is held at {held}, the run at {wanted}: it is another experiment")
        }));
    }
    let pairs = time_s.iter().zip(values);
    let samples = pairs.map(|(time, value)| (time - start_s, (value - rest) / divisor));
    Ok((samples.collect(), start_s))
}

/// The samples that lie within a run, of which two must lie on its hold.
fn within(samples: &[(f64, f64)], duration_s: f64, load: RigDrive) -> Result<Samples, String> {
    let hold_s = match load {
        RigDrive::Position(profile) => profile.ramp_time().0,
        RigDrive::Force(_) => 0.0,
    };
    let inside = |sample: &&(f64, f64)| (0.0..=duration_s).contains(&sample.0);
    let kept: Samples = samples.iter().filter(inside).copied().collect();
    if kept.iter().filter(|sample| sample.0 >= hold_s).count() >= 2 {
        return Ok(kept);
    }
    let ends = [samples.first(), samples.last()];
    let [first_s, last_s] = ends.map(|end| digits(end.map_or(f64::NAN, |sample| sample.0), 6));
    Err(format!(
        "the record goes from {first_s} s to {last_s} s after the start of the run, which holds from {hold_s} s to {duration_s} s: \
         two samples on the hold are needed, change {RAMP_TIME}, {DURATION} or the record"
    ))
}

/// The columns of a file, and true if their time begins where a run does.
fn read(path: &Path) -> Result<(Columns, bool), String> {
    let name = path.to_string_lossy().to_lowercase();
    if name.ends_with(".mcap") || name.ends_with(".mcap.part") {
        return log(path).map(|columns| (columns, true));
    }
    let bytes = read_bytes(path, TABLE_MOST);
    let bytes = bytes.map_err(|error| format!("cannot be read: {error}; give a table or a log"))?;
    let table = read_table(&bytes).map_err(|error| error.to_string())?;
    let columns = Reader::default()
        .read(table)
        .map_err(|error| format!("{error}; {HEADER_ALONE}"))?;
    Ok((columns, bytes.starts_with(OURS)))
}

/// Time, position and opposing force of a log: that of its force sensor, else the one by which its run was judged.
fn log(path: &Path) -> Result<Columns, String> {
    let mut read = [Column::Time, Column::Position, Column::Force]
        .map(|column| (column, column.header().to_owned(), Vec::new()));
    let mut sensed: Option<[Vec<f64>; 3]> = None;
    let mut files = LogFiles::open(path).map_err(|error| error.to_string())?;
    for entry in &mut files {
        if let Entry::Tick(tick) = entry.map_err(|error| error.to_string())? {
            let sample = KeptSample::of(&tick);
            let row = [sample.time_s, sample.position_m, sample.reaction_n()];
            (read.iter_mut().zip(row)).for_each(|(column, value)| column.2.push(value));
            if let Some(force_n) = sample.sensed_force_n {
                let row = [sample.time_s, sample.position_m, force_n];
                let columns = sensed.get_or_insert_default();
                (columns.iter_mut().zip(row)).for_each(|(column, value)| column.push(value));
            }
        }
    }
    if read[0].2.is_empty() {
        return Err("the log has no sample: give another".to_owned());
    }
    let of_sensor = sensed
        .is_some()
        .then(|| "the force is that of the log's sensor".to_owned());
    for (column, values) in read.iter_mut().zip(sensed.into_iter().flatten()) {
        column.2 = values;
    }
    let cut = (!files.condition().complete).then(|| "the log is not whole".to_owned());
    Ok(Columns {
        values: read.into(),
        notes: cut.into_iter().chain(of_sensor).collect(),
        ..Columns::default()
    })
}

/// Refuses a time or a value whose header could mean another, or names a unit of something else.
fn is_clear(columns: &Columns, used: Column) -> Result<(), String> {
    let mut unclear = columns.unclear.iter();
    let doubt = unclear.find(|column| [Column::Time, used].contains(&column.0));
    doubt.map_or(Ok(()), |(_, asked)| Err(format!("{asked}; {HEADER_ALONE}")))
}

fn of(columns: &Columns, wanted: Column) -> Option<&[f64]> {
    let mut all = columns.values.iter();
    let found = all.find(|(column, ..)| *column == wanted)?;
    Some(&found.2)
}

/// The last sample at rest: by what was imposed, else by what answered if that begins near 0; `None` if no rest is seen.
fn start(columns: &Columns, load: RigDrive) -> Option<usize> {
    let moves = [Column::Position, Column::Strain];
    let pushes = [Column::Force, Column::Stress];
    let [imposed, answers] = match load {
        RigDrive::Position(_) => [moves, pushes],
        RigDrive::Force(_) => [pushes, moves],
    };
    let find = |names: [Column; 2]| names.into_iter().find_map(|name| of(columns, name));
    let near_0 = |values: &&[f64]| {
        let most = values
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        values
            .first()
            .is_some_and(|first| first.abs() < REST * most)
    };
    let answer = || find(answers).filter(near_0).and_then(leaves);
    find(imposed).and_then(leaves).or_else(answer)
}

/// The last sample before these values leave the first of them, by more than their noise.
fn leaves(values: &[f64]) -> Option<usize> {
    // The second differences of a few samples are the curve itself.
    let sigma = if values.len() < FEW + 2 {
        0.0
    } else {
        white_noise(values)
    };
    let off = |value: &f64| (value - values[0]).abs();
    // A signal that moves no further than its noise is held.
    let moves = values.iter().any(|value| off(value) > 20.0 * sigma);
    let left = values.iter().position(|value| off(value) > 6.0 * sigma)?;
    moves.then(|| left.saturating_sub(1))
}

/// A modulus from its first time after the ramp on, or a compliance, on the piece.
fn of_material(columns: Columns, piece: &TissuePiece, load: RigDrive) -> Result<Samples, String> {
    let kind = match load {
        RigDrive::Position(_) => RecordKind::Relaxation,
        RigDrive::Force(_) => RecordKind::Creep,
    };
    let reading = TableDetails {
        kind: Some(kind),
        ..TableDetails::default()
    };
    let understood = reading.record(columns).map_err(|error| error.to_string())?;
    let of_loading = piece.specimen.loading().kind.modulus();
    let shape = (piece.specimen).shape(understood.loading.modulus.unwrap_or(of_loading));
    let record = understood.record;
    let pairs = record
        .x()
        .iter()
        .copied()
        .zip(record.first().iter().copied());
    Ok(match load {
        RigDrive::Position(profile) => {
            let (depth_m, ramp_s) = (profile.depth().0, profile.ramp_time().0);
            let effective = piece.effective();
            let share = |n: f64| n / f64::from(STEPS);
            let steps = (0..STEPS).map(f64::from).map(|n| {
                let rise = effective(share(n + 1.0) * depth_m) - effective(share(n) * depth_m);
                (share(n + 0.5) * ramp_s, rise)
            });
            let steps: Samples = steps.collect();
            let curve = pairs.map(|(t, m)| (libm::log(t), libm::log(m)));
            let curve: Samples = curve.collect();
            // The step of a record precedes the end of a ramp.
            let begin_s = record.x()[0] + ramp_s;
            let after = record.x().iter().filter(|time| **time >= begin_s);
            let force = |time: &f64| {
                let parts = steps
                    .iter()
                    .map(|(at, rise)| power_law(&curve, time - at) * rise);
                (*time, shape * parts.sum::<f64>())
            };
            after.map(force).collect()
        }
        RigDrive::Force(push) => {
            let map = piece.specimen.depth_map();
            let length_m = piece.specimen.slab_sizes().map_or(1.0, |sizes| sizes.1.0);
            let depth = |(time, compliance): (f64, f64)| {
                let effective = push.0 * compliance / shape;
                (
                    time,
                    map.map_or(effective, |map| map.depth(effective)) / length_m,
                )
            };
            pairs.map(depth).collect()
        }
    })
}

/// The value at a time, s, of a curve of logarithms that is straight between its samples.
fn power_law(curve: &[(f64, f64)], time_s: f64) -> f64 {
    let x = libm::log(time_s);
    let next = curve.partition_point(|point| point.0 <= x);
    let (a, b) = (curve[next.max(1) - 1], curve[next.min(curve.len() - 1)]);
    let share = if b.0 > a.0 {
        (x - a.0) / (b.0 - a.0)
    } else {
        0.0
    };
    libm::exp(a.1 + share * (b.1 - a.1))
}

/// Lays a record over a run, sample by sample of the run.
pub(crate) struct Comparison<'a> {
    measured: &'a Measured,
    /// The next sample of the record.
    next: usize,
    /// Time and value of the tick before, if it may be compared.
    before: Option<(f64, f64)>,
    /// Time of the record, record and run.
    pairs: Vec<[f64; 3]>,
}

impl<'a> Comparison<'a> {
    pub(crate) fn new(measured: &'a Measured) -> Self {
        let (next, before, pairs) = (0, None, Vec::new());
        Self {
            measured,
            next,
            before,
            pairs,
        }
    }

    /// The next tick; without a value where the run says nothing of its law.
    pub(crate) fn add(&mut self, time_s: f64, value: Option<f64>) {
        while let Some(&(at, record)) = self.measured.samples.get(self.next)
            && at <= time_s
        {
            let run = match (value, self.before) {
                // On a tick its value itself, to the bit.
                (value, _) if at >= time_s => value,
                (Some(value), Some((from_s, from))) => {
                    Some(from + (value - from) * (at - from_s) / (time_s - from_s))
                }
                (None, _) | (_, None) => None,
            };
            self.pairs.extend(run.map(|run| [at, record, run]));
            self.next += 1;
        }
        self.before = value.map(|value| (time_s, value));
    }

    /// Root mean square and largest size of run less record; `None` without a time at which both are known.
    pub(crate) fn differences(&self) -> Option<[f64; 2]> {
        let off = self.pairs.iter().map(|[_, record, run]| run - record);
        let squares: f64 = off.clone().map(|off| off * off).sum();
        let largest = off.map(f64::abs).reduce(f64::max)?;
        Some([(squares / self.pairs.len() as f64).sqrt(), largest])
    }

    /// Rows of a report, the curve, and why its table could not be written. The largest error is looked for from `from_s` on.
    pub(crate) fn finish(
        self,
        ran: &Ran,
        column: &str,
        from_s: f64,
        beginning: &mut Beginning,
    ) -> (Vec<Value>, Overlay, Option<String>) {
        let mut table = ran.record.ended.is_none().then(|| {
            let [record, run, difference] = ["record", origin(&ran.record), "difference"]
                .map(|whose| format!("{whose}_{column}"));
            let names = ["time_s", &record, &run, &difference, "relative_error"];
            ran.folder.named_table_beside_log("against.csv", &names)
        });
        let mut curves = Decimated::kept(ran.record.whole.is_some());
        let mut largest = LargestError::new(from_s, "the record", "");
        let [mut off, mut all] = [0.0; 2];
        for &[time_s, record, run] in &self.pairs {
            let difference = run - record;
            let error = difference / record;
            (off, all) = (off + difference * difference, all + record * record);
            largest.add(time_s, run, record);
            curves.add(time_s, [record, error]);
            if let Some(table) = &mut table {
                let error = Some(error).filter(|error| error.is_finite());
                table.row((time_s, record, run, difference, error));
            }
        }
        let rms = (off / all).sqrt();
        let error = match &self.pairs[..] {
            [] => Compared::without_meaning("the run ended before the record begins"),
            _ if all == 0.0 => Compared::without_meaning("the record is 0 wherever it is compared"),
            [first, ..] => {
                let span_s = [first[0], self.pairs[self.pairs.len() - 1][0]];
                Compared::of_window(rms, span_s, self.pairs.len() as u64)
            }
        };
        let error = beginning.error("against_error", error);
        let largest = beginning.error("against_largest_error", largest.get());
        let files = Files::finished(table);
        let against = json!({
            "record": self.measured.path.display().to_string(),
            // Start of the ramp or push on the clock of the record.
            "record_start_s": self.measured.start_s,
            "notes": self.measured.notes,
            "csv": files.csv,
        });
        let rows = vec![
            // The rms of run less record over that of the record.
            compared("against_error", &error),
            // The largest difference over the record's value at that time.
            compared("against_largest_error", &largest),
            json!({ "against": against }),
        ];
        let (_, time_s, [values, relative_error]) = curves.curves();
        let overlay = Overlay {
            time_s,
            values,
            relative_error,
            rms,
        };
        (rows, overlay, files.unwritten)
    }
}
