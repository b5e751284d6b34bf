//! Figures of a run drawn into a terminal of any size.

use super::figures::{Figures, Point, WINDOW_S};
use super::follow::Run;
use haptic_loop::Limiters;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Sparkline, Wrap};

/// Width of the names in a list.
const NAME: usize = 16;

/// Draws a run, or a sentence while there is none.
pub fn draw(frame: &mut Frame<'_>, run: Option<&Run>) {
    let [head, middle, foot] = Layout::vertical([
        Constraint::Length(2),
        Constraint::Min(0),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    match run {
        Some(run) => {
            frame.render_widget(Paragraph::new(heading(run)), head);
            body(frame, middle, &run.figures);
        }
        None => {
            let text = "No run goes on under results/. One that begins is shown here; or give its folder: host-cli top FOLDER";
            frame.render_widget(Paragraph::new(text).wrap(Wrap { trim: true }), middle);
        }
    }
    let dim = Style::new().add_modifier(Modifier::DIM);
    frame.render_widget(Line::styled("q ends this view; the run goes on", dim), foot);
}

/// Log, state and fault.
fn heading(run: &Run) -> Vec<Line<'static>> {
    let (state, worry) = run.state();
    let style = match (worry, run.goes_on()) {
        (true, _) => alarm(),
        (false, true) => Style::new().fg(Color::Green),
        (false, false) => Style::new(),
    };
    let figures = &run.figures;
    let kind = figures.experiment.get("experiment").cloned();
    let device = figures.experiment.get("device").cloned();
    let what: Vec<String> = [kind, device].into_iter().flatten().collect();
    let first = Line::from(vec![
        Span::raw(format!("{}  {}  ", run.path().display(), what.join(" on "))),
        Span::styled(state, style),
    ]);
    let second = match &figures.fault {
        Some(fault) => Line::styled(format!("FAULT: {fault}"), alarm()),
        None => Line::from("no fault"),
    };
    vec![first, second]
}

const fn alarm() -> Style {
    Style::new().fg(Color::Red).add_modifier(Modifier::BOLD)
}

/// Curves above, tables below.
fn body(frame: &mut Frame<'_>, area: Rect, figures: &Figures) {
    let [position, force, tables, events] = Layout::vertical([
        Constraint::Fill(1),
        Constraint::Fill(1),
        Constraint::Length(10),
        Constraint::Length(5),
    ])
    .areas(area);
    curve(frame, position, figures, "position", "mm", |point| {
        1e3 * point.position_m
    });
    curve(frame, force, figures, "force", "N", |point| point.force_n);
    let [samples, timing, limiters] = Layout::horizontal([Constraint::Fill(1); 3]).areas(tables);
    table(frame, samples, "samples", rows_of_samples(figures));
    table(frame, timing, "tick", rows_of_timing(figures));
    table(
        frame,
        limiters,
        "limiters: last second, all samples",
        rows_of_limiters(figures),
    );
    let lines: Vec<Line<'_>> = figures
        .events
        .iter()
        .rev()
        .map(|text| Line::from(text.as_str()))
        .collect();
    frame.render_widget(
        Paragraph::new(lines).block(Block::bordered().title("events, the newest first")),
        events,
    );
}

/// The last seconds of a quantity. Each column is the value in it that is farthest from zero, so no peak is lost.
fn curve(
    frame: &mut Frame<'_>,
    area: Rect,
    figures: &Figures,
    name: &str,
    unit: &str,
    of: impl Fn(&Point) -> f64,
) {
    /// Steps of a bar in a row.
    const STEPS: u16 = 8;
    let most_steps = f64::from(STEPS * area.height.saturating_sub(2).max(1));
    let newest = figures.kept().back().map(&of);
    let columns = figures.columns(usize::from(area.width.saturating_sub(2)), of);
    let filled = columns.iter().flatten();
    let least = filled
        .clone()
        .map(|column| column.0)
        .fold(f64::INFINITY, f64::min);
    let most = filled
        .map(|column| column.1)
        .fold(f64::NEG_INFINITY, f64::max);
    let span = if most > least { most - least } else { 1.0 };
    let heights: Vec<Option<u64>> = columns
        .iter()
        .map(|column| {
            column.map(|(low, high)| {
                let shown = if low.abs() > high.abs() { low } else { high };
                // A value at the bottom is a value too.
                (1.0 + (most_steps - 1.0) * (shown - least) / span) as u64
            })
        })
        .collect();
    let title = match newest {
        Some(value) => {
            format!("{name} {value:.4} {unit} · {least:.4} to {most:.4} in the last {WINDOW_S} s")
        }
        None => format!("{name}: no sample yet"),
    };
    let line = Sparkline::default()
        .data(heights)
        .max(most_steps as u64)
        .style(Style::new().fg(Color::Cyan))
        .block(Block::bordered().title(title));
    frame.render_widget(line, area);
}

type Row = (String, String, bool);

fn row(name: &str, value: impl Into<String>) -> Row {
    (name.to_owned(), value.into(), false)
}

fn table(frame: &mut Frame<'_>, area: Rect, title: &str, rows: Vec<Row>) {
    let lines: Vec<Line<'_>> = rows
        .into_iter()
        .map(|(name, value, worry)| {
            let style = if worry { alarm() } else { Style::new() };
            Line::styled(format!("{name:<NAME$}{value}"), style)
        })
        .collect();
    frame.render_widget(
        Paragraph::new(lines).block(Block::bordered().title(title.to_owned())),
        area,
    );
}

/// Counts, and what of them is missing.
fn rows_of_samples(figures: &Figures) -> Vec<Row> {
    let number = |value: Option<f64>, decimals: usize, unit: &str| {
        value.map_or_else(
            || "–".to_owned(),
            |value| format!("{value:.decimals$} {unit}"),
        )
    };
    let mut rows = vec![
        row("device time", number(figures.time_s, 3, "s")),
        row("samples", figures.samples.to_string()),
        (
            "lost".to_owned(),
            figures.samples_lost.to_string(),
            figures.samples_lost > 0,
        ),
        row("wanted force", number(figures.environment_force_n, 4, "N")),
        row("energy", number(figures.observed_energy_j, 6, "J")),
    ];
    if let Some(end) = &figures.end {
        let dropped = end.dropped_samples;
        rows.push(("dropped".to_owned(), dropped.to_string(), dropped > 0));
    }
    for (key, name) in [
        ("samples_lost", "lost on the line"),
        ("stale_forces", "stale forces"),
        ("unanswered", "unanswered ticks"),
        ("forces_not_taken", "forces not taken"),
        ("overruns", "late ticks"),
    ] {
        if let Some(count) = figures.link.get(key) {
            rows.push((name.to_owned(), count.clone(), count != "0"));
        }
    }
    rows
}

/// The budget of a tick by its parts.
fn rows_of_timing(figures: &Figures) -> Vec<Row> {
    let period_us = figures.sample_time_s.map(|period_s| 1e6 * period_s);
    let mut rows = vec![row(
        "period",
        period_us.map_or_else(|| "–".to_owned(), |us| format!("{us:.0} µs")),
    )];
    let number = |key: String| figures.timing.get(&key)?.parse::<f64>().ok();
    for (part, name) in [
        ("lateness", "woken late"),
        ("compute", "computing"),
        ("tick", "both"),
    ] {
        let shown = ["p50", "p99", "p999", "max"]
            .map(|percentile| number(format!("{part}_us_{percentile}")));
        if let [Some(p50), Some(p99), Some(p999), Some(most)] = shown {
            let worry = period_us.is_some_and(|period| p999 > period);
            let text = format!("{p50:.1} {p99:.1} {p999:.1} {most:.1} µs");
            rows.push((name.to_owned(), text, worry));
        }
    }
    if rows.len() > 1 {
        rows.push(row("", "median, 99 %, 99.9 %, most"));
        for (key, name) in [
            ("late_by_wake_up", "late: wake-up"),
            ("late_by_compute", "late: computing"),
            ("skipped_periods", "skipped"),
        ] {
            if let Some(count) = figures.timing.get(key) {
                rows.push((name.to_owned(), count.clone(), count != "0"));
            }
        }
    } else {
        rows.push(row("", "in the log of a run by the clock"));
    }
    rows
}

/// Each limiter: share of the last second, samples so far.
fn rows_of_limiters(figures: &Figures) -> Vec<Row> {
    let limited = figures.limited();
    Limiters::NAMES
        .into_iter()
        .zip(limited)
        .map(|(name, share)| {
            let all = figures.limited_samples.get(name).copied().unwrap_or(0);
            let worry = name == "fault" && all > 0;
            (
                name.to_owned(),
                format!("{:>5.1} %  {all}", 1e2 * share),
                worry,
            )
        })
        .collect()
}
