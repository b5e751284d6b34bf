//! `design`: the stiffest wall, the most damping, the closest tissue or the stiffest coupler, and which order does it.

use crate::command::conduct::progress_bar;
use crate::files::{Place, save_picture};
use crate::options::{WithFiles, keys};
use crate::output::{Output, warn};
use crate::page::{Panel, linear, page};
use haptic_experiment::document::Document;
use haptic_experiment::question::Question;
use haptic_experiment::question::design::coupler::{CouplerAnswer, CouplerDesign};
use haptic_experiment::question::design::{Candidate, Design, DesignReport, Wish};
use haptic_experiment::{Failure, TrialVerdict};
use haptic_figure::{FigureError, Look, Picture};
use serde::Serialize;
use std::sync::atomic::AtomicBool;

pub(crate) const LONG_ABOUT: &str = "\
Finds the wall that meets a wish on a device: stiffness K and dissipation B for each order, and the best order. \
The analysis finds them, with the device's delay and current lag; the best is then tried on the simulated device, with friction and encoder too.

Wishes:
  stiffest-wall   the largest K
  most-damping    the largest effective damping at --frequency
  tissue          does a specimen of --tissue fit, and how much larger may it be? If it does not, which order comes closest at --frequency?
  coupler         the virtual coupler damper + spring (T/(1-w))^mu that feels stiffest at --frequency, meets Llewellyn's criterion and \
has a gain margin of 2 in the sampled loop. --require passive asks for passivity with every hand and object instead

Unless a device file or friction, delay, current_lag, encoder_resolution or sensor_noise is given, the device is ideal; the report then also shows the best \
wall on the laboratory device. --force-noise-limit bounds the force noise that encoder and sensor cause.

--out writes design.toml for `host-cli run`, design.csv and a picture. The exit code is 1 if no \
candidate is found or the best does not come to rest.";

pub(crate) const EXAMPLES: &str = "Examples:\n  host-cli design --delay 1ms --out design\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue --tissue prostate-cancerous encoder_resolution=30um";

pub(crate) fn run(asked: WithFiles<keys::Design>, output: Output) -> Result<(), Failure> {
    let mut place = asked.files.look("design", &["toml"])?;
    let document = asked.options.over(Document::new("design"))?;
    let design = match Question::open(&document).map_err(Failure::input)? {
        Question::Design(design) => design,
        Question::Coupler(design) => return coupler(&design, place, output),
        Question::ZWidth(_) => return Err(Failure::bad_input("not a design")),
    };
    let bar = progress_bar(design.orders_to_try().len() as u64, output);
    let answer = design.answer(&AtomicBool::new(false), &|orders| bar.inc(orders));
    bar.finish_and_clear();
    let mut report = answer?;
    report.experiment = experiment(&mut place, report.experiment_text.as_deref());
    let table = place.write(|folder| folder.write_table("csv", report.candidates.iter()));
    report.files.extend(table);
    if report.best.is_some() {
        let picture = place.write(|folder| save_picture(folder, draw(&design, &report)));
        report.files.extend(picture);
    } else {
        place.without(&["svg", "png"]);
    }
    if let Some(real) = report.realistic.filter(|real| !real.simulated.stable) {
        warn(&format!(
            "this is for an ideal device; on one with {} the best wall is {}: give --device-model",
            real.imperfections.words(),
            real.simulated.verdict.words()
        ));
    }
    output.summary(&report)?;
    place.close(judge(&design, &report))
}

/// Writes the experiment of a design, if there is one, and returns its path.
fn experiment(place: &mut Place, text: Option<&str>) -> Option<String> {
    if text.is_none() {
        place.without(&["toml"]);
    }
    place.text("toml", text?)
}

/// A design without a candidate, or one that is not stable when it is tried.
fn judge(design: &Design, report: &DesignReport) -> Result<(), Failure> {
    match (&report.best, &report.simulated) {
        (Some(best), Some(simulated))
            if simulated.verdict == TrialVerdict::Unstable
                && design.gain_margin.is_none()
                && report.imperfections.sensors.are_ideal() =>
        {
            let order = best.order;
            warn(&format!(
                "the best, order {order}, is passive but rings for longer than its trial"
            ));
            Ok(())
        }
        (Some(best), Some(simulated)) if !simulated.stable => Err(not_at_rest(
            best.order,
            simulated.verdict,
            &simulated.reason().unwrap_or_default(),
            "raise --gain-margin, lower --force-noise-limit, or take a finer encoder",
        )),
        (None, _) => Err(nothing_found(report.notes.last().map(String::as_str))),
        _ => Ok(()),
    }
}

/// The best candidate, which is not stable when it is tried.
fn not_at_rest(order: f64, verdict: TrialVerdict, why: &str, remedy: &str) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "the best candidate, order {order}, is {} in its trial: {why}; {remedy}",
        verdict.words()
    ))
}

/// A design without a candidate, after its report.
fn nothing_found(why: Option<&str>) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "no candidate fulfils the wish: {}; ask for less, or take other --orders",
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
fn coupler(design: &CouplerDesign, mut place: Place, output: Output) -> Result<(), Failure> {
    let answer = design.answer(&AtomicBool::new(false), &|_| {})?;
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
fn draw(design: &Design, report: &DesignReport) -> Result<Picture, FigureError> {
    let (label, value): (&str, fn(&Candidate) -> Option<f64>) = match design.wish {
        Wish::StiffestWall => ("largest stiffness K / N·m⁻¹", |c| c.stiffness),
        Wish::MostDamping { .. } => ("effective damping / N·s·m⁻¹", |c| {
            c.effective_damping_n_s_per_m
        }),
        Wish::Tissue { .. } => ("largest scale of the specimen", |c| c.largest_scale),
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
        design.device.plant.mass.0,
        design.device.plant.damping.0,
        design.device.plant.sample_time.0,
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
