//! `design`: the stiffest wall, the most damping, the closest tissue or the stiffest coupler, and which order does it.

use crate::command::conduct::progress_bar;
use crate::files::save_picture;
use crate::options::{WithFiles, keys};
use crate::output::Output;
use crate::picture::{Panel, linear, page};
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use haptic_experiment::question::{Answer, Candidate, DesignReport, Question};
use haptic_figure::{AxisSpec, FigureError, Look, Picture, Scale};
use haptic_quantity::written;
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

The wall pulls as it pushes, as the analysis assumes. --one-sided takes the best wall that never pulls and settles after each of six hits, up to \
1 m/s; --contact signed takes one whose proof covers it.

--out writes design.toml for `host-cli run`, design.csv and a picture. The exit code is 1 if no \
candidate is found, or the best does not come to rest or is noisier than it may be when it is tried.";

pub(crate) const EXAMPLES: &str = "Examples:\n  host-cli design --delay 1ms --out design\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue --tissue prostate-cancerous encoder_resolution=30um";

pub(crate) fn run(asked: WithFiles<keys::Design>, output: Output) -> Result<(), Failure> {
    let mut place = asked.files.look("design", &["toml"])?;
    let document = asked.options.over(Document::new("design"))?;
    let question = Question::open(&document)?;
    let warn = &|text: &str| output.warn(text);
    let bar = progress_bar(question.steps(), output);
    let answer = question.answer(&|orders| bar.inc(orders), &AtomicBool::new(false), warn);
    bar.finish_and_clear();
    let answer = answer?;
    let experiment = answer.experiment_text();
    if experiment.is_none() {
        place.without(&["toml"]);
    }
    let experiment = experiment.and_then(|text| place.text("toml", text));
    let mut files = Vec::from_iter(place.write(|folder| answer.write_table(folder)));
    match &answer {
        Answer::Design(report) if report.best.is_some() => {
            files.extend(place.write(|folder| save_picture(folder, draw(report))));
        }
        Answer::Design(_) => place.without(&["svg", "png"]),
        _ => {}
    }
    output.summary(&Shown {
        answer: &answer,
        experiment,
        files,
    })?;
    place.close(answer.require(warn))
}

/// The result, and where it was written.
#[derive(Serialize)]
struct Shown<'a> {
    #[serde(flatten)]
    answer: &'a Answer,
    /// The experiment that was written.
    experiment: Option<String>,
    files: Vec<String>,
}

/// Draws the wished quantity over the order, and the dissipation that allows it, which is not seen where it is 0 and elsewhere is not.
fn draw(report: &DesignReport) -> Result<Picture, FigureError> {
    let (label, value): (&str, fn(&Candidate) -> Option<f64>) = match report.wish {
        "most-damping" => ("effective damping / N·s·m⁻¹", |c| {
            c.effective_damping_n_s_per_m
        }),
        "tissue" => ("largest scale of the specimen", |c| c.largest_scale),
        _ => ("largest stiffness K / N·m⁻¹", |c| c.stiffness),
    };
    let panel = |y, value: fn(&Candidate) -> Option<f64>| {
        Panel::new("", linear("order μ"), y)
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
    // Device and operator in one line.
    let subtitle = format!(
        "m = {} · b = {} · T = {} · {} · scheme {}",
        written("mass_kg", report.asked.mass_kg),
        written("damping_n_s_per_m", report.asked.damping_n_s_per_m),
        written("sample_time_s", report.asked.sample_time_s),
        report.imperfections.words(),
        report.scheme
    );
    // B falls by decades with the order, as its unit does not stay; where no wall has any it is 0.
    let mut dissipations = report.candidates.iter().filter_map(|c| c.dissipation);
    let scale = match dissipations.any(|dissipation| dissipation > 0.0) {
        true => Scale::Log,
        false => Scale::Linear,
    };
    let dissipation = AxisSpec::new("dissipation B / N·s^μ·m⁻¹", scale);
    let panels = [
        panel(linear(label), value),
        panel(dissipation, |c| c.dissipation),
    ];
    let title = format!("Design: {}, {}", report.wish, report.requirement);
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
