//! `design`: the stiffest wall, the most damping, the closest tissue or the stiffest coupler, and which order does it.

use crate::command::conduct::answered;
use crate::options::{WithFiles, keys};
use crate::output::Output;
use crate::picture::{Panel, Points, linear, logarithmic, page};
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::Imperfections;
use haptic_experiment::question::{Answer, Candidate, DesignReport, FrontReport};
use haptic_figure::{AxisSpec, FigureError, Look, Picture, Scale};
use haptic_quantity::written;
use serde_json::{Value, json};
use std::sync::Arc;

pub(crate) const EXAMPLES: &str = "Examples:\n  host-cli design --delay 1ms --out design\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue --tissue prostate-cancerous encoder_resolution=30um\n  \
                  host-cli design --wish controller --controller pid.toml --delay 1ms\n  \
                  host-cli design --front --delay 1ms --frequency 5Hz --out front";

/// The question, and the length of the printed answer.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    asked: WithFiles<keys::Design>,
    /// Print the whole report, as --json has it
    #[arg(long)]
    all: bool,
}

/// Keys that the list of candidates omits on a screen; the best candidate has them all.
const BEHIND: [&str; 7] = [
    "alpha",
    "beta",
    "passive",
    "pulling_contact_margin",
    "required_damping_n_s_per_m",
    "sampled_damping_n_s_per_m",
    "share",
];

pub(crate) fn run(arguments: Arguments, output: Output) -> Result<(), Failure> {
    let Arguments { asked, all } = arguments;
    let mut outputs = asked.files.look("design", &["toml"])?;
    let answer = answered("design", asked.options, &Arc::default(), output)?;
    let experiment = answer.experiment_text();
    if experiment.is_none() {
        outputs.without(&["toml"]);
    }
    let experiment = experiment.and_then(|text| outputs.text("toml", text));
    let table = outputs.write(|folder| answer.write_table(folder)).flatten();
    let mut files = Vec::from_iter(table);
    match &answer {
        // A controller is a single point.
        Answer::Design(report) if report.best.is_some() && report.wish != "controller" => {
            files.extend(outputs.picture(|| draw(report)));
        }
        Answer::Front(report) if !report.walls.is_empty() => {
            files.extend(outputs.picture(|| draw_front(report)));
        }
        Answer::Design(_) | Answer::Front(_) => outputs.without(&["svg", "png", "pdf"]),
        Answer::ZWidth(_) | Answer::Coupler(_) | Answer::Analysis(_) => {}
    }
    let mut report = json!(answer);
    report["experiment"] = json!(experiment);
    report["files"] = json!(files);
    let mut shown = report.clone();
    if !all {
        // Nothing is shown of what is null.
        shown["simulated"] = report["simulated"]["verdict"].clone();
        shown["realistic"] = report["realistic"]["simulated"]["verdict"].clone();
        let candidates = shown["candidates"].as_array_mut();
        for candidate in candidates.into_iter().flatten() {
            for key in BEHIND {
                candidate[key] = Value::Null;
            }
        }
    }
    output.report_as(&report, &shown)?;
    outputs.close(answer.require(&|text| output.warn(text)))
}

/// Draws the wished quantity over the order, and the dissipation that allows it, which is not seen where it is 0 and elsewhere is not.
fn draw(report: &DesignReport) -> Result<Picture, FigureError> {
    let (label, value): (&str, fn(&Candidate) -> Option<f64>) = match report.wish {
        "most-damping" => ("effective damping / N·s·m⁻¹", |c| {
            c.effective_damping_n_s_per_m
        }),
        "tissue" => ("largest scale of the specimen", |c| c.largest_scale),
        _ => ("largest stiffness K / N·m⁻¹", |c| c.stiffness_n_per_m),
    };
    let noise = report
        .force_noise_limit_n
        .filter(|_| report.trials.is_some());
    let passed = noise.map_or_else(
        || "best, six pushes passed".to_owned(),
        |noise| {
            let noise = written("noise_n", noise);
            format!("best, six pushes passed with at most {noise} of noise")
        },
    );
    let panel = |caption, y, value: fn(&Candidate) -> Option<f64>| {
        let all = points(value, &report.candidates);
        let best = points(value, report.best.as_slice());
        Panel::new(caption, linear("order μ"), y)
            .with("each order", Look::Line, 0, all)
            .with(&passed, Look::Markers, 1, best)
    };
    let asked = &report.asked;
    let device = [asked.mass_kg, asked.damping_n_s_per_m, asked.sample_time_s];
    let subtitle = about(device, &report.imperfections, &report.scheme);
    // B falls by decades with the order, as its unit does not stay; where no wall has any it is 0.
    let mut dissipations = report
        .candidates
        .iter()
        .filter_map(|c| c.dissipation_n_s_mu_per_m);
    let scale = if dissipations.any(|dissipation| dissipation > 0.0) {
        Scale::Log
    } else {
        Scale::Linear
    };
    let dissipation = AxisSpec::new("dissipation B / N·s^μ·m⁻¹", scale);
    let panels = [
        panel("what is wished, at its most", linear(label), value),
        panel("dissipation that allows it", dissipation, |c| {
            c.dissipation_n_s_mu_per_m
        }),
    ];
    let title = format!("Design: {}, {}", report.wish, report.requirement);
    page(&title, &subtitle, 2, &panels)
}

/// Draws the front: stiffness and damping over the gain margin, and damping over stiffness, a curve an order.
fn draw_front(report: &FrontReport) -> Result<Picture, FigureError> {
    let frequency = written("frequency_hz", report.frequency_hz);
    let [stiffness, damping] = ["stiffness / N·m⁻¹", "damping / N·s·m⁻¹"];
    let mut panels = [
        Panel::new(
            "stiffness and robustness",
            logarithmic("gain margin"),
            logarithmic(stiffness),
        ),
        Panel::new(
            "damping and robustness",
            logarithmic("gain margin"),
            linear(damping),
        ),
        Panel::new(
            "damping and stiffness",
            logarithmic(stiffness),
            linear(damping),
        ),
    ];
    for (colour, walls) in report
        .walls
        .chunk_by(|a, b| a.order.to_bits() == b.order.to_bits())
        .enumerate()
    {
        let name = format!("μ = {}", walls[0].order);
        let points = [
            edge(
                walls
                    .iter()
                    .map(|wall| (wall.margin, wall.effective_stiffness_n_per_m)),
            ),
            edge(
                walls
                    .iter()
                    .map(|wall| (wall.margin, wall.effective_damping_n_s_per_m)),
            ),
            edge(walls.iter().map(|wall| {
                (
                    wall.effective_stiffness_n_per_m,
                    wall.effective_damping_n_s_per_m,
                )
            })),
        ];
        let mut points = points.into_iter();
        panels = panels
            .map(|panel| panel.with(&name, Look::Line, colour, points.next().unwrap_or_default()));
    }
    let title = format!(
        "Walls that none beats: {} of {} at {frequency}",
        report.walls.len(),
        report.compared
    );
    let asked = &report.asked;
    let device = [asked.mass_kg, asked.damping_n_s_per_m, asked.sample_time_s];
    let subtitle = about(device, &report.imperfections, &report.scheme);
    page(&title, &subtitle, 3, &panels)
}

/// The upper right edge of places: those that no other exceeds in both, by falling x.
fn edge(places: impl Iterator<Item = (f64, f64)>) -> Points {
    // Margins that differ by rounding alone are one.
    let rounded = |x: f64| (x * 1e4).round() / 1e4;
    let mut places: Points = places.map(|(x, y)| (rounded(x), y)).collect();
    places.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
    let mut most = f64::NEG_INFINITY;
    places.retain(|place| {
        let is_more = place.1 > most;
        most = most.max(place.1);
        is_more
    });
    places
}

/// Device and operator in one line.
fn about(
    [mass_kg, damping, sample_time_s]: [f64; 3],
    imperfections: &Imperfections,
    scheme: &str,
) -> String {
    format!(
        "m = {} · b = {} · T = {} · {} · scheme {scheme}",
        written("mass_kg", mass_kg),
        written("damping_n_s_per_m", damping),
        written("sample_time_s", sample_time_s),
        imperfections.words(),
    )
}

/// The places of a quantity, by rising order.
fn points(value: fn(&Candidate) -> Option<f64>, candidates: &[Candidate]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = candidates
        .iter()
        .filter_map(|c| Some((c.order?, value(c)?)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}
