//! `log plot`: a run, or several over each other: positions and forces over time, force over depth, and a difference.
//!
//! ```text
//! t = tₖ − (t₀ₖ − t₀₁)         run k on the clock of the first run: both begin with their first samples
//! d(t) = b(t) − a(t)           at the samples of a; between two neighbouring samples b is a straight line
//! rms = √(Σ d²/n)              over the n samples of a at which b is known
//! ```
//! - *Symbols*: t s is the time of the picture, tₖ s that of run k on its own clock and t₀ₖ s of its first sample; a and b are a
//!   position, m, or a force on the hand, N: on one axis positive where it pushes back, which the log has as negative; on several, along
//!   the axes.
//! - *Errors*: a part that no run has, runs of different axes, a run twice, a difference without a common sample.
//! - *Cost*: each log is read once, and once more for a difference. Memory is that of [`Decimated`], whatever the length;
//!   force over depth keeps every sample, of which there may be [`DEPTH_MOST`].

use super::source::{Others, Part, log_at, require_complete, target_of};
use crate::mcap::warn_of_order;
use crate::output::{Output, joined, warn};
use crate::picture::{Panel, linear, page};
use crate::picture_file::Pictures;
use clap::Args;
use haptic_experiment::Failure;
use haptic_figure::{FigureError, Look, Picture, PlaneFigure};
use haptic_judge::decimated::Decimated;
use haptic_log::record::{Entry, LogFiles, RecordError, SAME_TIME, Span, Topic};
use haptic_message::{TickMessage, column_name};
use haptic_quantity::{label, without_unit};
use serde_json::{Map, Value, json};
use std::iter::zip;
use std::path::{Path, PathBuf};

/// Samples of which each is drawn; of more the extremes.
const DENSE: u64 = 20_000;
/// Samples of which force over depth is drawn: of the extremes of more, a loop would be a polygon.
const DEPTH_MOST: u64 = 1_000_000;
/// Numbers of a tick, as in [`drawn`], and columns of a topic that one picture holds.
const CURVES: usize = 11;
const COLUMNS: usize = 6;
/// Key, label and factor of what [`drawn`] has by turns.
const QUANTITIES: [(&str, &str, f64); 2] = [
    ("position_m", "position / mm", 1e3),
    ("force_n", "force on the hand / N", 1.0),
];

#[derive(Debug, Args)]
pub(crate) struct Plot {
    /// Logs, or the folders of runs; each begins where the first does
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Names in the picture, as in before,after [default: those of the files or folders]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    label: Vec<String>,
    #[command(flatten)]
    part: Part,
    /// Draw force over depth instead of both over time
    #[arg(long)]
    over_depth: bool,
    /// Of two logs, draw the second less the first too, and print its rms and its largest value
    #[arg(long, conflicts_with = "over_depth")]
    difference: bool,
    /// Folder for NAME.log.svg and NAME.log.png, of several logs NAME.runs.svg [default: beside the first log]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace earlier pictures
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pictures: Pictures,
    #[command(flatten)]
    others: Others,
}

/// Printed report, a log that is not whole, and the picture.
type Drawn = (Value, Option<PathBuf>, Result<Picture, FigureError>);

impl Plot {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let logs = self.logs.iter().map(|log| log_at(log));
        let logs: Vec<PathBuf> = logs.collect::<Result<_, _>>()?;
        let (first, names) = (&logs[0], self.names()?);
        let ending = match (self.over_depth, logs.len()) {
            (true, _) => "depth",
            (false, 1) => "log",
            (false, _) => "runs",
        };
        let stem = target_of(None, self.out.as_deref(), first, ending)?;
        let span = self.part.span();
        let (report, cut, picture) = match self.others.topic(first)? {
            None => self.draw_runs(&logs, &names, span)?,
            Some(topic) if ending == "log" => draw_topic(first, &names[0], &topic, span)?,
            Some(_) => return refused(first, "is a log of others: draw it alone, over time"),
        };
        let figure = self.pictures.save(picture, &stem, self.overwrite)?;
        output.report(&joined([report, json!({ "figure": figure })]))?;
        require_complete(cut.is_none(), cut.as_deref().unwrap_or(first), &figure)
    }

    /// A name for each log: as given, or as the file or folder is called, unless two are called so.
    fn names(&self) -> Result<Vec<String>, Failure> {
        let differ = |names: &[String]| {
            let mut numbered = names.iter().enumerate();
            numbered.all(|(n, name)| !name.is_empty() && !names[..n].contains(name))
        };
        let name = |log: &PathBuf| log.file_name().unwrap_or_default().to_string_lossy().into();
        let mut names: Vec<String> = self.logs.iter().map(name).collect();
        if !self.label.is_empty() {
            names.clone_from(&self.label);
        } else if !differ(&names) {
            names = self
                .logs
                .iter()
                .map(|log| log.display().to_string())
                .collect();
        }
        if names.len() == self.logs.len() && differ(&names) {
            Ok(names)
        } else {
            Err(Failure::bad_input(format_args!(
                "{} is not a name of its own for each of {} logs: give as many, as in --label before,after",
                names.join(","),
                self.logs.len()
            )))
        }
    }

    fn draw_runs(&self, logs: &[PathBuf], names: &[String], span: Span) -> Result<Drawn, Failure> {
        let mut runs: Vec<Run> = Vec::new();
        for (log, name) in zip(logs, names) {
            let run = Run::read(log, name, runs.first(), span, self.over_depth)?;
            runs.push(run);
        }
        let ends = runs.iter().map(|run| run.ends_s);
        let ends = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        span.check(ends).map_err(RecordError::from)?;
        if let Some(run) = runs.iter().find(|run| run.samples == 0) {
            let (first_s, last_s) = run.ends_s;
            let why = format!(
                "has samples from {first_s} s to {last_s} s, none in this part: change --from or --to, or omit it"
            );
            return refused(&run.log, &why);
        }
        let mut panels = panels(&runs, self.over_depth);
        let mut report = match &runs[..] {
            [run] => run.report(),
            _ => json!({ "runs": runs.iter().map(Run::report).collect::<Vec<_>>() }),
        };
        if self.difference {
            let [a, b] = &runs[..] else {
                return Err(Failure::bad_input("--difference is of two logs: give two"));
            };
            let (of_two, mut less) = difference(a, b, span)?;
            report = joined([report, of_two]);
            panels.append(&mut less);
        }
        let picture = match &runs[..] {
            [run] if !self.over_depth && run.axes > 1 => run.path(),
            [run] => page(&run.name, &run.subtitle, 1, &panels),
            _ => {
                let columns = 1 + usize::from(panels.len() > 2);
                // The legend has their names.
                let title = format!("{} runs", runs.len());
                let first = runs[0].subtitle.as_str();
                let is_common = runs.iter().all(|run| run.subtitle == first);
                let subtitle = if is_common { first } else { "" };
                page(&title, subtitle, columns, &panels)
            }
        };
        let cut = runs.iter().find(|run| !run.complete);
        Ok((report, cut.map(|run| run.log.clone()), picture))
    }
}

fn refused<T>(log: &Path, why: &str) -> Result<T, Failure> {
    Err(Failure::bad_input(format_args!(
        "`{}` {why}",
        log.display()
    )))
}

/// Each column of a topic in a panel of its own.
fn draw_topic(log: &Path, title: &str, topic: &Topic, span: Span) -> Result<Drawn, Failure> {
    let (time, columns) = topic.columns.split_at(1);
    if columns.len() > COLUMNS {
        let (name, count, first) = (&topic.name, columns.len(), &columns[0].0);
        return Err(Failure::bad_input(format_args!(
            "{name} has {count} columns, and a picture has room for {COLUMNS}: give --columns some of them, as in {name}.{first}"
        )));
    }
    let time_s = time[0].1.iter().copied();
    let ends = time[0].1.first().copied().zip(time_s.clone().last());
    span.check(ends).map_err(RecordError::from)?;
    let panel = |(name, column): &(String, Vec<f64>)| {
        let points = zip(time_s.clone(), column.iter().copied());
        let points = points.filter(|point| span.holds(point.0));
        Panel::new(name, linear("time / s"), linear("")).with("", Look::Line, 0, points)
    };
    let panels: Vec<_> = columns.iter().map(panel).collect();
    let complete = topic.condition.complete;
    let samples = time_s.filter(|time_s| span.holds(*time_s)).count();
    let report = json!({ "samples": samples, "complete": complete });
    let cut = (!complete).then(|| log.to_owned());
    Ok((report, cut, page(title, &topic.name, 1, &panels)))
}

/// Curves of a tick: position and force on each axis by turns; then the reference on two axes, and indenter, contact force and sensed
/// force on the first.
fn drawn(tick: &TickMessage) -> [f64; CURVES] {
    let turns = [tick.position_m, tick.commanded_force_n];
    std::array::from_fn(|n| {
        let (numbers, axis) = match n {
            0..=5 => (turns[n % 2], n / 2),
            6..=7 => (tick.reference_m, n - 6),
            8 => (tick.indenter_position_m, 0),
            9 => (tick.contact_force_n, 0),
            _ => (tick.sensed_force_n.unwrap_or(f64::NAN.into()), 0),
        };
        let number = numbers.get(axis).copied().unwrap_or(f64::NAN);
        // A force that pushes back is negative in a log.
        if n == 1 && tick.axes() == 1 {
            0.0 - number
        } else {
            number
        }
    })
}

/// A log as a picture has it.
struct Run {
    name: String,
    log: PathBuf,
    axes: usize,
    complete: bool,
    subtitle: String,
    /// Its own clock less that of the picture, s.
    shift_s: f64,
    /// Times of its first and last sample by the clock of the picture, s.
    ends_s: (f64, f64),
    /// Those in the part that is drawn.
    samples: u64,
    time_s: Vec<f64>,
    curves: [Vec<f64>; CURVES],
}

impl Run {
    /// Behind another it begins where that does.
    fn read(
        log: &Path,
        name: &str,
        first: Option<&Self>,
        span: Span,
        over_depth: bool,
    ) -> Result<Self, Failure> {
        let mut reader = LogFiles::open(log)?;
        let mut shown = Decimated::new(if over_depth { DEPTH_MOST } else { DENSE });
        let (mut conditions, mut ends, mut axes, mut shift_s) = (Vec::new(), None, 1, 0.0);
        for entry in &mut reader {
            let entry = entry?;
            if let Entry::Tick(tick) = &entry {
                axes = tick.axes();
                let (begin_s, _) = *ends.get_or_insert_with(|| {
                    let begin_s = first.map_or(tick.time_s, |first| first.ends_s.0);
                    shift_s = tick.time_s - begin_s;
                    (begin_s, begin_s)
                });
                let time_s = tick.time_s - shift_s;
                ends = Some((begin_s, time_s));
                if span.holds(time_s) {
                    shown.add(time_s, drawn(tick));
                }
            } else if let Entry::Metadata(record) = &entry
                && record.name == "experiment"
            {
                let named = ["device", "scheme"].into_iter();
                let value = |key| Some(format!("{key} {}", record.values.get(key)?));
                conditions = named.filter_map(value).collect();
            }
        }
        let condition = reader.condition();
        warn_of_order(&condition);
        let complete = condition.complete && condition.out_of_order == 0;
        if !complete {
            conditions.push("cut off or damaged: what could be read".to_owned());
        }
        let (samples, time_s, curves) = shown.curves();
        let Some(ends_s) = ends else {
            return refused(log, "has no ticks to draw: omit it");
        };
        if over_depth && samples > DEPTH_MOST {
            let why = format!(
                "has {samples} samples, and force over depth shows each of at most {DEPTH_MOST}: give --from and --to"
            );
            return refused(log, &why);
        }
        if let Some(first) = first.filter(|first| first.axes != axes) {
            let why = format!(
                "has {axes} axes, and {} has {}: give logs of as many",
                first.name, first.axes
            );
            return refused(log, &why);
        }
        if shift_s.abs() > SAME_TIME {
            let (begin_s, own_s) = (ends_s.0, ends_s.0 + shift_s);
            warn(&format!(
                "{name} begins at {own_s} s and is drawn from {begin_s} s on, as the first"
            ));
        }
        Ok(Self {
            name: name.to_owned(),
            log: log.to_owned(),
            axes,
            complete,
            subtitle: conditions.join("  ·  "),
            shift_s,
            ends_s,
            samples,
            time_s,
            curves,
        })
    }

    fn report(&self) -> Value {
        json!({
            "run": self.name,
            "samples": self.samples,
            "first_s": self.time_s.first(),
            "last_s": self.time_s.last(),
            "shifted_s": self.shift_s,
            "complete": self.complete,
            "log": self.log,
        })
    }

    /// One of several axes, alone: the path, places and forces.
    fn path(&self) -> Result<Picture, FigureError> {
        let curves = &self.curves;
        PlaneFigure {
            title: &self.name,
            subtitle: &self.subtitle,
            outline_m: &[],
            time_s: &self.time_s,
            reference_m: [&curves[6], &curves[7]],
            position_m: [&curves[0], &curves[2]],
            depth_m: None,
            force_n: &[1, 3, 5].map(|n| curves[n].clone())[..self.axes],
        }
        .draw()
    }

    /// A curve over time or over another, multiplied by `scale`.
    fn points(
        &self,
        n: usize,
        scale: f64,
        over: Option<usize>,
    ) -> impl Iterator<Item = (f64, f64)> {
        let x = over.map_or(&self.time_s, |over| &self.curves[over]);
        let factor = if over.is_some() { QUANTITIES[0].2 } else { 1.0 };
        zip(x, &self.curves[n]).map(move |(x, y)| (factor * x, scale * y))
    }
}

/// Position and force on each axis over time, or force over position. Each run has a colour and a dash of its own, and one alone
/// all that its log has beside.
fn panels(runs: &[Run], over_depth: bool) -> Vec<Panel<'static>> {
    let is_alone = runs.len() == 1 && !over_depth;
    // A rig measures what answers the force of the device. Without one this is the force that the motors made, as negative as the command.
    let forces = zip(&runs[0].curves[1], &runs[0].curves[9]);
    let product = forces.map(|(hand, contact)| hand * contact);
    let agreement: f64 = product.filter(|product| product.is_finite()).sum();
    let (contact, sign) = if agreement < 0.0 {
        ("force of the motors", -1.0)
    } else {
        ("contact force", 1.0)
    };
    let panel = |n: usize| {
        let (key, y, scale) = QUANTITIES[n % 2];
        let (over, x) = if over_depth {
            (Some(n - 1), QUANTITIES[0].1)
        } else {
            (None, "time / s")
        };
        let name = caption(key, n / 2, runs[0].axes);
        let mut panel = Panel::new(&name, linear(x), linear(y));
        let others: &[_] = match n {
            0 => &[
                ("reference", Look::Broad, 6, 6),
                ("indenter", Look::Line, 2, 8),
            ],
            1 => &[
                (contact, Look::Dashed, 5, 9),
                ("sensed force", Look::Line, 3, 10),
            ],
            _ => &[(contact, Look::Dashed, 5, 9)],
        };
        let is_known = |n: usize| n != 10 || runs[0].curves[n].iter().any(|force| !force.is_nan());
        let others = others.iter().filter(|_| is_alone);
        for (name, look, colour, n) in others.filter(|(.., n)| is_known(*n)) {
            let scale = match n {
                9 => sign,
                10 => 1.0,
                _ => scale,
            };
            panel = panel.with(*name, *look, *colour, runs[0].points(*n, scale, None));
        }
        for (colour, run) in runs.iter().enumerate() {
            let (name, colour) = if is_alone {
                (&name, n % 2)
            } else {
                (&run.name, colour)
            };
            let points = || run.points(n, scale, over);
            panel = panel.with(name, Look::Line, colour, points());
            // End of a path, as a marker: it widens the axes, so that no line lies on the frame.
            let end = points().last().filter(|_| over_depth);
            panel = panel.with("", Look::Markers, colour, end);
        }
        panel
    };
    let all = 0..2 * runs[0].axes;
    all.filter(|n| !over_depth || n % 2 == 1)
        .map(panel)
        .collect()
}

/// Caption in words, as `position x` on one of several axes.
fn caption(key: &str, axis: usize, axes: usize) -> String {
    label(&column_name(key, axis, axes))
}

/// The second run less the first, as it is printed and drawn.
fn difference(a: &Run, b: &Run, span: Span) -> Result<(Value, Vec<Panel<'static>>), Failure> {
    let ticks = |run: &Run| -> Result<_, Failure> {
        let entries = LogFiles::open(&run.log)?;
        Ok(entries.filter_map(|entry| match entry {
            Ok(Entry::Tick(tick)) => Some(Ok(tick)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        }))
    };
    let (first, mut second) = (ticks(a)?, ticks(b)?);
    let (mut before, mut next) = (None::<TickMessage>, second.next().transpose()?);
    let (mut shown, mut interpolated) = (Decimated::<CURVES>::new(DENSE), 0);
    // Of each curve the sum of the squares, and the largest without its sign with its time.
    let mut sums = [(0.0, 0.0, 0.0); CURVES];
    for tick in first {
        let tick = tick?;
        let at_s = tick.time_s + b.shift_s;
        while let Some(other) = next.filter(|other| other.time_s < at_s - SAME_TIME) {
            (before, next) = (Some(other), second.next().transpose()?);
        }
        let Some(other) = next.filter(|_| span.holds(tick.time_s)) else {
            continue;
        };
        let mut less = drawn(&other);
        if other.time_s > at_s + SAME_TIME {
            let Some(before) = before.filter(|before| before.tick + 1 == other.tick) else {
                continue;
            };
            let share = (other.time_s - at_s) / (other.time_s - before.time_s);
            zip(&mut less, drawn(&before))
                .for_each(|(less, before)| *less += share * (before - *less));
            interpolated += 1;
        }
        zip(&mut less, drawn(&tick)).for_each(|(less, value)| *less -= value);
        shown.add(tick.time_s, less);
        for (sum, less) in zip(&mut sums, less) {
            sum.0 += less * less;
            if less.abs() > sum.1 {
                (sum.1, sum.2) = (less.abs(), tick.time_s);
            }
        }
    }
    let (compared, time_s, curves) = shown.curves();
    if compared == 0 {
        let why = format!(
            "has no time in common with {}: change --from and --to",
            a.name
        );
        return refused(&b.log, &why);
    }
    if interpolated > 0 {
        warn(&format!(
            "{interpolated} of {compared} samples of {} are between two of {}, which is taken as a straight line there",
            a.name, b.name
        ));
    }
    let less = format!("{} − {}", b.name, a.name);
    let mut report = Map::new();
    report.insert("difference".to_owned(), less.as_str().into());
    report.insert("compared".to_owned(), compared.into());
    report.insert("interpolated".to_owned(), interpolated.into());
    let mut panels = Vec::new();
    for n in 0..2 * a.axes {
        let (key, y, scale) = QUANTITIES[n % 2];
        let (axis, (squares, largest, at_s)) = (n / 2, sums[n]);
        let of = |what| column_name(&key.replace('_', what), axis, a.axes);
        report.insert(of("_rms_"), (squares / compared as f64).sqrt().into());
        report.insert(of("_largest_"), largest.into());
        report.insert(
            format!("{}_at_s", without_unit(&of("_largest_"))),
            at_s.into(),
        );
        let name = format!("difference of {}", caption(key, axis, a.axes));
        let points = zip(&time_s, &curves[n]).map(|(time_s, value)| (*time_s, scale * value));
        let panel = Panel::new(name, linear("time / s"), linear(y));
        panels.push(panel.with(&less, Look::Line, 2, points));
    }
    Ok((report.into(), panels))
}
