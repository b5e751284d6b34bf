//! `design`: the stiffest wall, the most damping, the closest tissue or the stiffest coupler, and which order does it.

use crate::command::conduct::progress_bar;
use crate::files::{Place, save_picture};
use crate::options::{WithFiles, keys};
use crate::output::{Output, warn};
use crate::page::{Panel, linear, page};
use haptic_experiment::document::Document;
use haptic_experiment::question::{Answer, Candidate, CouplerAnswer, DesignReport, Question};
use haptic_experiment::{Failure, TrialVerdict};
use haptic_figure::{FigureError, Look, Picture};
use serde::Serialize;
use std::sync::atomic::AtomicBool;

pub(crate) const LONG_ABOUT: &str = "\
From a device and a wish to a wall: the largest stiffness K and dissipation B for each order, and the order that does best. \
The analysis finds them, with the device's delay and current lag; the best is then tried on the simulated device, with friction and encoder too.

Wishes:
  stiffest-wall   the largest K
  most-damping    the largest effective damping at --frequency
  tissue          does a specimen of --tissue fit, and how much larger may it be? If it does not, which order comes closest at --frequency?
  coupler         the virtual coupler damper + spring (T/(1-w))^mu that feels stiffest at --frequency, absolutely stable by Llewellyn's criterion and \
with a gain margin of 2 in the sampled loop. --require passive asks for passivity with every hand and object instead

Without a device file or friction, delay, current_lag, encoder_resolution or sensor_noise the device is ideal; the report then also shows the best \
wall on the laboratory device. --force-noise-limit bounds the force noise that encoder and sensor cause.

--out writes design.toml for `host-cli run`, design.csv and a picture. The exit code is 1 if no candidate is found or the best does not come to rest.";

pub(crate) const EXAMPLES: &str = "Examples:\n  host-cli design --delay 1ms --out design\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue --tissue prostate-cancerous encoder_resolution=30um";

pub(crate) fn run(asked: WithFiles<keys::Design>, output: Output) -> Result<(), Failure> {
    let mut place = asked.files.look("design", &["toml"])?;
    let document = asked.options.over(Document::new("design"))?;
    let question = Question::open(&document).map_err(Failure::input)?;
    let bar = progress_bar(question.steps(), output);
    let answer = question.answer(&|orders| bar.inc(orders), &AtomicBool::new(false), &warn);
    bar.finish_and_clear();
    let mut report = match answer? {
        Answer::Design(report) => report,
        Answer::Coupler(answer) => return coupler(answer, place, output),
        Answer::ZWidth(_) => return Err(Failure::bad_input("not a design")),
    };
    report.experiment = experiment(&mut place, report.experiment_text.as_deref());
    let table = place.write(|folder| folder.write_table("csv", report.candidates.iter()));
    report.files.extend(table);
    if report.best.is_some() {
        let picture = place.write(|folder| save_picture(folder, draw(&report)));
        report.files.extend(picture);
    } else {
        place.without(&["svg", "png"]);
    }
    if let Some(real) = report.realistic.filter(|real| !real.simulated.stable) {
        warn(&format!(
            "this is for an ideal device; on one with {} the best wall is {}: give --device-model, or the device's own values",
            real.imperfections.words(),
            real.simulated.verdict.words()
        ));
    }
    output.summary(&report)?;
    place.close(judge(&report))
}

/// Writes the experiment of a design, if there is one, and returns its path.
fn experiment(place: &mut Place, text: Option<&str>) -> Option<String> {
    if text.is_none() {
        place.without(&["toml"]);
    }
    place.text("toml", text?)
}

/// A design without a candidate, or one that is not stable when it is tried.
fn judge(report: &DesignReport) -> Result<(), Failure> {
    match (&report.best, &report.simulated) {
        (Some(best), Some(simulated))
            if simulated.verdict == TrialVerdict::Unstable
                && report.gain_margin.is_none()
                && report.imperfections.sensors.are_ideal() =>
        {
            warn(&format!(
                "the best candidate, order {}, is passive but rings for longer than it was tried: \
                     the device has little damping",
                best.order
            ));
            Ok(())
        }
        (Some(best), Some(simulated)) if !simulated.stable => Err(not_at_rest(
            best.order,
            simulated.verdict,
            &simulated.reason().unwrap_or_default(),
            "ask for more margin with --gain-margin, less noise with --force-noise-limit, or take a finer encoder",
        )),
        (None, _) => Err(nothing_found(report.notes.last().map(String::as_str))),
        _ => Ok(()),
    }
}

/// The best candidate, which is not stable when it is tried.
fn not_at_rest(order: f64, verdict: TrialVerdict, why: &str, remedy: &str) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "the best candidate, order {order}, is {} when it is tried: {why}; {remedy}",
        verdict.words()
    ))
}

/// A design without a candidate, after its report.
fn nothing_found(why: Option<&str>) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "no candidate fulfils the wish: {}; ask for less, or take other --orders or another device",
        why.unwrap_or("nothing does it")
    ))
}

/// Result of `--wish coupler`.
#[derive(Serialize)]
struct CouplerReport {
    #[serde(flatten)]
    answer: CouplerAnswer,
    /// The experiment that was written.
    experiment: Option<String>,
    files: Vec<String>,
}

/// The stiffest coupler of each order.
fn coupler(answer: CouplerAnswer, mut place: Place, output: Output) -> Result<(), Failure> {
    let experiment = experiment(&mut place, answer.experiment_text.as_deref());
    let table = place.write(|folder| folder.write_table("csv", answer.candidates.iter()));
    let report = CouplerReport {
        answer,
        experiment,
        files: table.into_iter().collect(),
    };
    output.summary(&report)?;
    let answer = &report.answer;
    place.close(match (&answer.best, &answer.simulated) {
        (None, _) => {
            let mut reasons = answer.candidates.iter().filter_map(|c| c.reason.as_deref());
            Err(nothing_found(reasons.next()))
        }
        (Some(best), Some(simulated)) if !simulated.stable => Err(not_at_rest(
            best.order,
            simulated.verdict,
            &simulated.reason().unwrap_or_default(),
            "take a device with more damping, or other --orders",
        )),
        _ => Ok(()),
    })
}

/// Draws the wished quantity over the order, and the dissipation that allows it.
fn draw(report: &DesignReport) -> Result<Picture, FigureError> {
    let (label, value): (&str, fn(&Candidate) -> Option<f64>) = match report.wish {
        "most-damping" => ("effective damping / N·s·m⁻¹", |c| {
            c.effective_damping_n_s_per_m
        }),
        "tissue" => ("largest scale of the specimen", |c| c.largest_scale),
        _ => ("largest stiffness K / N·m⁻¹", |c| c.stiffness),
    };
    let panel = |label, value: fn(&Candidate) -> Option<f64>| {
        Panel::new("", linear("order μ"), linear(label))
            .with(
                "each order",
                Look::Line,
                0,
                points(value, &report.candidates),
            )
            .with(
                "best",
                Look::Markers,
                1,
                points(value, report.best.as_slice()),
            )
    };
    let requirement = match report.gain_margin {
        Some(margin) => format!("stable, gain margin {margin}"),
        None => "passive".to_owned(),
    };
    // Device and operator in one line.
    let subtitle = format!(
        "m = {} kg · b = {} N·s/m · T = {} s · {} · scheme {}",
        report.asked.mass_kg,
        report.asked.damping_n_s_per_m,
        report.asked.sample_time_s,
        report.imperfections.words(),
        report.scheme
    );
    let panels = [panel(label, value), panel("dissipation β", |c| c.beta)];
    let title = format!("Design: {}, {requirement}", report.wish);
    page(&title, &subtitle, 2, &panels)
}

/// The places of a quantity, by rising order.
fn points(value: fn(&Candidate) -> Option<f64>, candidates: &[Candidate]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = candidates
        .iter()
        .filter_map(|c| Some((c.order, value(c)?)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}
