//! Pictures of loops: runs, records, frequency responses, designs.

use crate::picture::{Panel, Points, linear, logarithmic, page, short_name};
use control_identification::model_search::InputOutput;
use control_tuning::design::{ControlAnswer, Trial, TunedController};
use fractional_control::analysis::{LoopAnalysis, LoopPoint};
use fractional_control::num_complex::Complex;
use fractional_control::{ControllerSetup, Crossing};
use haptic_figure::{AxisSpec, FigureError, Look, Picture};
use haptic_quantity::{in_five_digits, written};
use haptic_question::analysis::decibel;
use haptic_question::control_loop::run::Simulated;
use haptic_question::control_loop::{ControlLoop, NamedPlant};
use haptic_question::plant::response::ResponseAnswer;
use haptic_question::plant::{PlantAnswer, PlantFound};
use haptic_question::words::in_short;

fn subtitle(plant: &NamedPlant, controller: Option<&ControllerSetup>) -> String {
    let mut words = format!("plant {}", in_five_digits(&plant.words));
    if let Some(setup) = controller {
        let law = in_five_digits(&setup.law.to_string());
        let t = written("sample_time_s", setup.sample_time_s);
        words += &format!("\ncontroller {law} · T = {t} · {}", setup.scheme);
    }
    words
}

pub(super) fn over_time(values: &[f64], sample_time_s: f64) -> Points {
    let points = values.iter().enumerate();
    points
        .map(|(n, y)| (n as f64 * sample_time_s, *y))
        .collect()
}

/// Time over which a step is drawn: twice as long as it takes to settle, where nobody has asked for a length.
fn time_axis(found: &Simulated, asked: &ControlLoop) -> AxisSpec<'static> {
    let axis = linear("time / s");
    let shapes = [&found.report["shape"], &found.report["integer"]["shape"]];
    let mut shapes = shapes.iter().filter(|shape| !shape.is_null());
    let longest = shapes.try_fold(0.0_f64, |longest, shape| {
        Some(longest.max(shape["settling_time_s"].as_f64()?))
    });
    let whole = found.response.measured.len() as f64 * found.sample_time_s;
    let is_free = asked.form.duration_s.is_none() && asked.form.reference.is_empty();
    match longest.filter(|settled| is_free && (0.0..0.5 * whole).contains(settled)) {
        Some(settled) if settled > 0.0 => axis.between(0.0, 2.0 * settled),
        _ => axis,
    }
}

/// A run of a loop, or of a plant without a controller: output over reference, command below; beside a integer-order PID where there is one.
pub(super) fn draw_run(found: &Simulated, asked: &ControlLoop) -> Result<Picture, FigureError> {
    let (title, name) = match asked.controller {
        Some(_) => ("A loop, simulated", "this controller"),
        None => ("A plant alone, simulated", "plant"),
    };
    let subtitle = subtitle(&asked.plant, asked.controller.as_ref());
    let points = |values: &[f64]| over_time(values, found.sample_time_s);
    let run = &found.response;
    let (reference, output, command) = (
        points(&run.reference),
        points(&run.measured),
        points(&run.command),
    );
    let integer = found.integer.as_ref();
    let integer = integer.map(|other| (points(&other.measured), points(&other.command)));
    let axis = command_axis(&command, integer.as_ref().map(|(_, command)| command));
    let time = time_axis(found, asked);
    let mut outputs = Panel::new("output", time, linear("output"))
        .with("reference", Look::Dotted, 5, reference)
        .with(name, Look::Line, 0, output);
    let commands = Panel::new("command", time, axis);
    let mut commands = commands.with(name, Look::Line, 0, command);
    if let Some((output, command)) = integer {
        let name = "integer-order PID, same crossover and margin";
        outputs = outputs.with(name, Look::Dashed, 1, output);
        commands = commands.with(name, Look::Dashed, 1, command);
    }
    page(title, &subtitle, 1, &[outputs, commands])
}

/// An axis for commands: an initial kick many times larger than the rest is written as a number, not drawn.
fn command_axis(command: &Points, integer: Option<&Points>) -> AxisSpec<'static> {
    const KICK: usize = 5;
    let axis = linear("command");
    let all = || std::iter::once(command).chain(integer);
    let ends = |skipped: usize| {
        let values = all().flat_map(move |points| points.iter().skip(skipped).map(|p| p.1));
        let values = values.filter(|value| value.is_finite());
        values.fold((0.0, 0.0), |(low, high): (f64, f64), u| {
            (low.min(u), high.max(u))
        })
    };
    let (whole, rest) = (ends(0), ends(KICK));
    let height = 1.1 * (rest.1 - rest.0);
    if height > 0.0 && whole.1 - whole.0 > 3.0 * height {
        axis.focused(rest.0 - 0.05 * height, rest.1 + 0.05 * height)
    } else {
        axis
    }
}

fn panels_of(record: &InputOutput, model: &[f64], title: &'static str) -> [Panel<'static>; 2] {
    let points = |values: &[f64]| -> Points {
        let time = record.time_s.iter().copied();
        time.zip(values.iter().copied()).collect()
    };
    let left = model.iter().zip(&record.output);
    let left: Vec<f64> = left.map(|(model, output)| model - output).collect();
    let time = || linear("time / s");
    let upper = Panel::new(title, time(), linear("input, output"))
        .with("input", Look::Dotted, 2, points(&record.input))
        .with("output, record", Look::Broad, 3, points(&record.output))
        .with("output, function", Look::Line, 0, points(model));
    let lower = Panel::new("function less record", time(), linear("difference"));
    [
        upper,
        lower.with("difference", Look::Line, 1, points(&left)),
    ]
}

/// A function beside what it was found in.
pub(super) fn draw_identified(found: &PlantFound, name: &str) -> Result<Picture, FigureError> {
    match found {
        PlantFound::Record(answer) => draw_of_record(answer, name),
        PlantFound::Response(answer) => draw_of_response(answer, name),
    }
}

/// Gain and phase of a response and of its function.
fn draw_of_response(answer: &ResponseAnswer, name: &str) -> Result<Picture, FigureError> {
    type Value = fn(Complex<f64>) -> f64;
    let values: [(&'static str, Value, AxisSpec<'static>); 2] = [
        ("gain", |h| h.norm(), logarithmic("gain")),
        ("phase", |h| h.arg().to_degrees(), linear("phase / °")),
    ];
    let panels = values.map(|(title, value, axis)| {
        let pairs = answer.points.iter().zip(answer.model());
        let (points, model): (Points, Points) = pairs
            .map(|((omega, h), g)| ((*omega, value(*h)), (*omega, value(*g))))
            .unzip();
        Panel::new(title, logarithmic(OMEGA), axis)
            .with("response", Look::Markers, 3, points)
            .with("function", Look::Line, 0, model)
    });
    let count = answer.report.frequencies;
    let subtitle = format!(
        "{} · {count} frequencies\n{}",
        short_name(name),
        answer.function()
    );
    let title = "A transfer function from a frequency response";
    page(title, &subtitle, 1, &panels)
}

/// A function beside its record, and beside another one that it is tried on.
fn draw_of_record(answer: &PlantAnswer, name: &str) -> Result<Picture, FigureError> {
    let panels = panels_of(&answer.record, answer.model(), "record and function");
    let mut panels = Vec::from(panels);
    if let Some(tried) = &answer.tried {
        let other = "a second record and the function";
        panels.extend(panels_of(&tried.record, &tried.validation.model, other));
    }
    let report = &answer.report;
    let delay = written("delay_s", report.delay_s);
    let ends = report.delay_low_s.zip(report.delay_high_s);
    let between = ends.map_or_else(String::new, |ends| {
        let [low, high] = [ends.0, ends.1].map(|delay_s| written("delay_s", delay_s));
        format!(" ({low} to {high})")
    });
    let subtitle = format!(
        "{} · {} samples · dead time {delay}{between}\n{}",
        short_name(name),
        report.samples,
        answer.function()
    );
    let title = "A transfer function from a record";
    page(title, &subtitle, 1, &panels)
}

const OMEGA: &str = "ω / rad·s⁻¹";

fn over_omega(points: &[LoopPoint], value: impl Fn(&LoopPoint) -> f64) -> Points {
    points
        .iter()
        .map(|point| (point.omega_rad_s, value(point)))
        .collect()
}

/// The ends of a row of points at this height.
fn level(points: &[LoopPoint], height: f64) -> Points {
    let ends = [points.first(), points.last()].into_iter().flatten();
    ends.map(|point| (point.omega_rad_s, height)).collect()
}

/// Axis from a floor to above the highest: at half the sample rate the hold has a zero, which would be all of the picture.
fn decibels(label: &'static str, points: &[&Points], floor: f64) -> AxisSpec<'static> {
    let all = points.iter().flat_map(|points| points.iter());
    let highest = all.map(|point| point.1).fold(0.0, f64::max);
    linear(label).between(floor, 10.0 * (0.1 * highest).ceil() + 10.0)
}

/// The half turn that is nearest below the phase at the crossover, °.
fn half_turn(curve: &[LoopPoint], crossing: &Crossing) -> Option<f64> {
    let mut after = curve.iter();
    let after = after.find(|point| point.omega_rad_s >= crossing.omega_rad_s)?;
    let turns = ((after.phase_rad - crossing.value).to_degrees() / 360.0 - 0.5).round();
    Some(360.0 * turns + 180.0)
}

/// Bode with margins, sensitivities, and Nyquist's curve near −1.
pub(super) fn draw_loop(
    analysis: &LoopAnalysis,
    asked: &ControlLoop,
) -> Result<Picture, FigureError> {
    let [gain, phase] = open_loop(analysis);
    let [closed, nyquist] = closed_loop(analysis);
    let title = format!("A sampled loop: {}", in_short(analysis));
    let panels = [gain, phase, closed, nyquist];
    let subtitle = subtitle(&asked.plant, asked.controller.as_ref());
    page(&title, &subtitle, 2, &panels)
}

/// Gain and phase of the open loop, with margins of a stable one.
fn open_loop(analysis: &LoopAnalysis) -> [Panel<'static>; 2] {
    let (curve, margins) = (&analysis.curve, &analysis.margins);
    let (crossover, stable) = (margins.phase, analysis.verdict.stable);
    let margin = crossover.filter(|_| stable);
    // The half turn of which the phase keeps its margin, °.
    let turn = crossover.and_then(|crossing| half_turn(curve, &crossing));
    let turn = turn.unwrap_or(-180.0);
    let up_to_curve = |gain: Crossing| {
        let omega = gain.omega_rad_s;
        let end = (omega, -decibel(gain.value));
        [(omega, 0.0), end, (f64::NAN, f64::NAN)]
    };
    let gains = [margins.gain_up, margins.gain_down].into_iter().flatten();
    let gains = gains.filter(|_| stable).flat_map(up_to_curve);
    let crossed = crossover.map(|at| (at.omega_rad_s, 0.0));
    let gain = over_omega(curve, |point| decibel(point.open.norm()));
    let axis = decibels("|L| / dB", &[&gain], -60.0);
    let gain = Panel::new("gain of the open loop", logarithmic(OMEGA), axis)
        .with("open loop L", Look::Line, 0, gain)
        .with("", Look::Dotted, 5, level(curve, 0.0))
        .with("gain margin", Look::Broad, 2, gains)
        .with("crossover", Look::Markers, 1, crossed);
    let axis = linear("phase / °").between(turn - 180.0, turn + 180.0);
    let degrees = |at: &Crossing| at.value.to_degrees();
    let words = margin.as_ref().map(degrees);
    let words = words.map_or(String::new(), |degrees| {
        format!("phase margin {degrees:.1}°")
    });
    let at_margin = margin.into_iter().flat_map(|at| {
        let ends = [turn, turn + degrees(&at)];
        ends.map(|phase| (at.omega_rad_s, phase))
    });
    let phase = over_omega(curve, |point| point.phase_rad.to_degrees());
    let phase = Panel::new("its phase", logarithmic(OMEGA), axis)
        .with("open loop L", Look::Line, 0, phase)
        .with("", Look::Dotted, 5, level(curve, turn))
        .with(words, Look::Broad, 1, at_margin);
    [gain, phase]
}

/// The closed loop, and the open one around −1.
fn closed_loop(analysis: &LoopAnalysis) -> [Panel<'static>; 2] {
    let curve = &analysis.curve;
    let errors = over_omega(curve, |point| decibel(point.sensitivity()));
    let noise = over_omega(curve, |point| decibel(point.complementary()));
    let axis = decibels("gain / dB", &[&errors, &noise], -40.0);
    let closed = Panel::new("closed loop", logarithmic(OMEGA), axis)
        .with("|S|, errors and disturbances", Look::Line, 1, errors)
        .with("|T|, reference and noise", Look::Line, 2, noise)
        .with("", Look::Dotted, 5, level(curve, 0.0));
    let degrees = (0..=180).map(|k| libm::sincos((2.0 * f64::from(k)).to_radians()));
    let circle = degrees.map(|(sin, cos)| (cos, sin));
    let open = curve.iter().map(|point| (point.open.re, point.open.im));
    let [real, imaginary] = [
        linear("Re L").between(-3.0, 2.0),
        linear("Im L").between(-2.0, 2.0),
    ];
    let nyquist = Panel::new("L near −1 (the cross)", real, imaginary)
        .with("open loop L", Look::Line, 0, open)
        .with("|L| = 1", Look::Dashed, 4, circle)
        .with("", Look::Crosses, 5, [(-1.0, 0.0)]);
    [closed, nyquist]
}

pub(super) fn draw_plant(points: &[LoopPoint], plant: &NamedPlant) -> Result<Picture, FigureError> {
    let panel = |caption, label, value: fn(&LoopPoint) -> f64| {
        let points = over_omega(points, value);
        Panel::new(caption, logarithmic(OMEGA), linear(label)).with("", Look::Line, 0, points)
    };
    let panels = [
        panel("gain", "|G| / dB", |point| decibel(point.open.norm())),
        panel("phase", "phase / °", |point| point.phase_rad.to_degrees()),
    ];
    page("A plant alone", &subtitle(plant, None), 2, &panels)
}

/// No panel is higher than this. A step of a loop that is not stable is drawn until it is.
const HIGHEST: f64 = 4.0;
/// A curve that turns more often in its panel is a block of ink.
const TURNS: usize = 60;
/// A turn is a change of direction by more than this share of the height.
const TURN: f64 = 0.03;

struct Curves {
    /// A name and a step for each gain.
    gains: Vec<(String, Points)>,
    output: Points,
    command: Points,
    is_stable: bool,
}

/// The places at which a curve changes its direction, by more than a little of this height.
fn turns(points: &[(f64, f64)], height: f64) -> Vec<usize> {
    let least = TURN * height;
    let mut found = Vec::new();
    let (mut extreme, mut rises) = (points.first().map_or(0.0, |point| point.1), true);
    for (n, &(_, y)) in points.iter().enumerate() {
        let beyond = if rises { y - extreme } else { extreme - y };
        if beyond > 0.0 {
            extreme = y;
        } else if beyond < -least {
            found.push(n);
            (extreme, rises) = (y, !rises);
        }
    }
    found
}

/// The height of what is seen of a curve: its ends, without the kick of the first samples.
fn height(points: &[(f64, f64)]) -> f64 {
    let (low, high) = points
        .iter()
        .skip(5)
        .fold((0.0, 0.0), |(low, high), point| {
            (f64::min(low, point.1), f64::max(high, point.1))
        });
    high - low
}

impl Curves {
    fn new(trial: &Trial, samples: usize, t: f64) -> Self {
        let seen = |values: &[f64]| over_time(&values[..samples.min(values.len())], t);
        let gains = trial.robustness.iter().map(|row| {
            let name = format!("gain {:+.0} dB", decibel(row.gain));
            let name = name.replace('-', "−");
            let y = &row.response.measured;
            let grown = y.iter().position(|y| !row.stable && y.abs() > HIGHEST);
            (name, seen(&y[..grown.map_or(y.len(), |end| end + 1)]))
        });
        Self {
            gains: gains.collect(),
            output: seen(&trial.step.measured),
            command: seen(&trial.step.command),
            is_stable: trial.analysis.verdict.stable,
        }
    }

    /// The output and the command as it is run, unless they grow or turn too often.
    fn as_it_is_run(&self) -> [Option<&Points>; 2] {
        [&self.output, &self.command].map(|points| {
            let is_drawn = self.is_stable && turns(points, height(points)).len() <= TURNS;
            is_drawn.then_some(points)
        })
    }

    /// A step that turns too often to be drawn.
    fn is_ink(points: &Points) -> bool {
        turns(points, height(points).min(HIGHEST)).len() > TURNS
    }

    /// The steps of each gain that can be drawn.
    fn on<'a>(&self, mut panel: Panel<'a>) -> Panel<'a> {
        let rows = self.gains.iter().zip([3, 2, 0, 4, 1]);
        for ((name, points), colour) in rows.filter(|((_, points), _)| !Self::is_ink(points)) {
            panel = panel.with(name, Look::Line, colour, points.iter().copied());
        }
        panel
    }

    fn left_out(&self, subject: &str) -> Option<String> {
        let ink = self.gains.iter().filter(|(_, points)| Self::is_ink(points));
        let mut names: Vec<&str> = ink.map(|(name, _)| name.as_str()).collect();
        if self.as_it_is_run().contains(&None) {
            names.push("its own gain in (c) or (d)");
        }
        (!names.is_empty()).then(|| {
            let names = names.join(", ");
            format!("left out: {subject} at {names}, which grows or swings too often to be drawn")
        })
    }

    /// The least and the largest value that is drawn; at least those of the step itself.
    fn ends(&self) -> (f64, f64) {
        let drawn = self
            .gains
            .iter()
            .filter(|(_, points)| !Self::is_ink(points));
        let points = drawn.flat_map(|(_, points)| points);
        points.fold((0.0, 1.0), |(low, high): (f64, f64), point| {
            (low.min(point.1), high.max(point.1))
        })
    }
}

/// Samples until every stable signal has settled, and half of that again; and no more than the first loop needs for the
/// turns that can be drawn.
fn length(trials: &[&Trial]) -> usize {
    let settled = trials.iter().flat_map(|trial| {
        let stable = trial.robustness.iter().filter(|row| row.stable);
        let run = trial.analysis.verdict.stable.then_some(trial.shape);
        let shapes = stable.map(|row| row.shape).chain(run);
        shapes.map(|shape| shape.settled)
    });
    let Some(first) = trials.first() else {
        return 2;
    };
    let samples = first.step.measured.len();
    let longest = settled.map(|settled| settled.unwrap_or(samples)).max();
    let mut length = longest.map_or(samples, |longest| samples.min(3 * longest / 2));
    for signal in [&first.step.measured, &first.step.command] {
        let points = over_time(&signal[..length.min(signal.len())], 1.0);
        // The height of a growing signal is that of its visible part.
        let ends = turns(&points, height(&points));
        length = ends.get(TURNS).map_or(length, |end| length.min(*end));
    }
    length.max(2)
}

/// Steps of both controllers over ± 6 dB of gain, and the nominal ones with their commands; `None` for a plant that does not run.
pub(super) fn draw_design(
    answer: &ControlAnswer,
    plant: &NamedPlant,
) -> Result<Option<Picture>, FigureError> {
    let file = &answer.fractional.setup;
    let t = file.sample_time_s;
    let integer = answer.integer.as_ref().ok();
    let candidates = [Some(&answer.fractional), integer];
    let trials = candidates.map(|candidate| candidate?.trial.as_ref());
    let [Some(trial), other] = trials else {
        return Ok(None);
    };
    let trials: Vec<&Trial> = trials.into_iter().flatten().collect();
    let samples = length(&trials);
    let (flat, other) = (
        Curves::new(trial, samples, t),
        other.map(|other| Curves::new(other, samples, t)),
    );
    let time = linear("time / s").between(0.0, samples as f64 * t);
    let ends = [Some(&flat), other.as_ref()].into_iter().flatten();
    let (lowest, highest) = ends
        .map(Curves::ends)
        .fold((0.0, 1.0), |a, b| (f64::min(a.0, b.0), f64::max(a.1, b.1)));
    let steps = linear("output").focused(1.1 * lowest.max(-HIGHEST), 1.1 * highest.min(HIGHEST));
    let (law, pid) = ("PI^λD^μ", "integer-order PID");
    let of_gains = |name| Panel::new(format!("{name} at several gains"), time, steps);
    let (fractional, mut integer) = (flat.on(of_gains(law)), of_gains(pid));
    let run_other = other.as_ref().and_then(|other| other.as_it_is_run()[1]);
    let axis = command_axis(&flat.command, run_other);
    // Other looks than those of the gains.
    let outputs = Panel::new("as it is run, with its limits", time, linear("output"));
    let mut outputs = outputs.with(law, Look::Broad, 6, flat.output.iter().copied());
    let commands = Panel::new("command", time, axis);
    let mut commands = commands.with(law, Look::Broad, 6, flat.command.iter().copied());
    let mut about = vec![subtitle(plant, Some(file))];
    about.extend(flat.left_out(law).filter(|_| flat.is_stable));
    if let Some(other) = &other {
        let [output, command] = other
            .as_it_is_run()
            .map(|points| points.into_iter().flatten().copied());
        integer = other.on(integer);
        outputs = outputs.with(pid, Look::Dashed, 5, output);
        commands = commands.with(pid, Look::Dashed, 5, command);
        about.extend(other.left_out(pid));
    }
    let title = "A fractional PID, and the best integer-order PID";
    let panels = [fractional, integer, outputs, commands];
    page(title, &about.join("\n"), 2, &panels).map(Some)
}

pub(super) fn design_columns(candidate: &TunedController, prefix: &str) -> Vec<(String, Vec<f64>)> {
    let Some(trial) = &candidate.trial else {
        return Vec::new();
    };
    let mut columns = vec![
        (format!("{prefix}output"), trial.step.measured.clone()),
        (format!("{prefix}command"), trial.step.command.clone()),
    ];
    columns.extend(trial.robustness.iter().map(|row| {
        let name = format!("{prefix}output_gain_{:+.0}db", decibel(row.gain));
        (name, row.response.measured.clone())
    }));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// cos ωt turns ωt/π times; a ripple below a thirtieth of the height is none.
    #[test]
    fn turns_are_counted_as_they_are_seen() {
        let curve = |ripple: f64| -> Points {
            let t = (0..=10_000).map(|n| f64::from(n) * 1e-3);
            t.map(|t| {
                (
                    t,
                    (20.5 * std::f64::consts::PI * t).cos() + ripple * (900.0 * t).cos(),
                )
            })
            .collect()
        };
        // The first turn, from the beginning downwards, is at the second sample.
        assert_eq!(turns(&curve(0.0), 2.0).len(), 205);
        assert_eq!(turns(&curve(0.01), 2.0).len(), 205);
        assert!(turns(&curve(0.2), 2.0).len() > 1000);
        assert!(Curves::is_ink(&curve(0.0)));
        let calm: Points = (0..1000)
            .map(|n| (f64::from(n), -(-0.01 * f64::from(n)).exp_m1()))
            .collect();
        assert!(turns(&calm, 1.0).is_empty() && !Curves::is_ink(&calm));
    }

    #[test]
    fn a_loop_that_grows_as_it_is_run_is_left_out_by_name() {
        let step: Points = vec![(0.0, 0.0), (1.0, 1.0)];
        let curves = |is_stable| Curves {
            gains: vec![("gain +0 dB".to_owned(), step.clone())],
            output: step.clone(),
            command: step.clone(),
            is_stable,
        };
        assert_eq!(curves(true).left_out("it"), None);
        let words = curves(false).left_out("it").expect("it grows");
        assert!(
            words.contains("it at its own gain in (c) or (d)"),
            "{words}"
        );
    }
}
