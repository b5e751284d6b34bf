//! `zwidth`: how stiff a wall can be rendered, by trying.

use super::conduct::{answered, stop_on_interrupt};
use crate::options::{WithFiles, keys};
use crate::output::Output;
use crate::picture::{Panel, linear, logarithmic, page};
use haptic_experiment::Failure;
use haptic_experiment::question::{Answer, BoundaryPoint, ZWidthReport};
use haptic_figure::{FigureError, Look, Picture};
use haptic_quantity::{digits, written};
use serde_json::json;

pub(crate) const EXAMPLES: &str = "Examples:\n  \
                  host-cli zwidth --orders 0,0.5,1 --points 11 --device-model laboratory --out zwidth\n  \
                  host-cli zwidth --mass 45g --damping 0.2 --force-limit 3.3N --orders 1 window=1s\n  \
                  host-cli zwidth --tissue liver loading=shear area=4cm2 thickness=2cm --device-model laboratory\n  \
                  host-cli zwidth --controller pid.toml --device-model laboratory\n  \
                  host-cli zwidth --device serial:auto --push-by device --campaign night.jsonl --out night";

pub(crate) fn run(asked: WithFiles<keys::ZWidth>, output: Output) -> Result<(), Failure> {
    let mut outputs = asked.files.look("zwidth", &[])?;
    let answer = answered("zwidth", asked.options, stop_on_interrupt()?, output)?;
    let mut shown = json!(answer);
    let mut files = Vec::new();
    let required = answer.require(&|text| output.warn(text));
    if matches!(&answer, Answer::ZWidth(report) if report.has_found()) {
        files.extend(outputs.write(|folder| answer.write_table(folder)).flatten());
    }
    let Answer::ZWidth(report) = answer else {
        return Err(Failure::bad_input("not a Z-width"));
    };
    // A controller is no point among walls.
    if report.rows().next().is_some() {
        files.extend(outputs.picture(|| draw(&report)));
    }
    shown["files"] = json!(files);
    output.report(&shown)?;
    outputs.close(match report.ended_early {
        Some(failure) => Err(failure.and("the points found so far are kept")),
        None => required,
    })
}

/// Stiffness at which the line of a robot's walls begins that are stable from nothing on, N/m.
const SOFTEST_DRAWN: f64 = 0.1;

/// The boundaries, the analysis beneath and what was tried on it, without units and the same in N/m.
fn draw(report: &ZWidthReport) -> Result<Picture, FigureError> {
    let subtitle = format!(
        "scheme {} · T = {} · δ = {} · device {} · impact {} · push {}{}",
        report.scheme,
        written("sample_time_s", report.asked.sample_time_s),
        digits(report.delta, 4),
        report.device,
        written("impact_m_per_s", report.impact_m_per_s),
        written("push_n", report.push_n),
        match report.push_by {
            "device" => " by its own motor",
            _ => "",
        }
    );
    let dissipation = "dissipation B / N·s^{μ}·m⁻¹";
    // Walls of a robot lie between newtons and meganewtons per metre.
    let panels = if report.hands.is_some() {
        let [across, up] = [linear(dissipation), logarithmic("stiffness K / N·m⁻¹")];
        let panel = Panel::new("walls that settle in every hand", across, up);
        vec![with_curves(panel, report, true)]
    } else {
        let without_units = Panel::new(
            "without units",
            linear("dissipation β = BT^{2−μ}/m"),
            linear("largest stiffness α = KT²/m"),
        );
        let with_units = Panel::new(
            "with units, where B is above 0",
            logarithmic(dissipation),
            linear("largest stiffness K / N·m⁻¹"),
        );
        let without_units = with_curves(without_units, report, false);
        vec![without_units, with_curves(with_units, report, true)]
    };
    let title = match &report.tissue {
        Some(tissue) => format!("Z-width: the largest specimen of {tissue} that settles"),
        None => "Z-width: the stiffest walls that settle".to_owned(),
    };
    page(&title, &subtitle, panels.len(), &panels)
}

fn with_curves<'a>(mut panel: Panel<'a>, report: &ZWidthReport, with_units: bool) -> Panel<'a> {
    let is_simulated = report.device == "sim";
    let tried = if is_simulated {
        "simulated"
    } else {
        "measured"
    };
    let point = |p: &BoundaryPoint| {
        if with_units {
            (p.dissipation, p.stiffness_max)
        } else {
            (p.beta, p.alpha)
        }
    };
    // The other panel has those without a place on a logarithmic axis.
    let all_shown = !with_units || report.hands.is_some();
    let shown = |point: &&BoundaryPoint| all_shown || point.dissipation > 0.0;
    for (colour, order) in report.orders.iter().enumerate() {
        let (stiffness, dissipation) = if with_units { order.units } else { (1.0, 1.0) };
        let outline = order.outline.iter();
        // A gap for the edge along K = 0: it is the axis.
        let gap = |alpha| if alpha == 0.0 { f64::NAN } else { alpha };
        let outline = outline.map(|&(beta, alpha)| (beta * dissipation, gap(alpha) * stiffness));
        // Each interval of a robot is a line that stands.
        let standing = (order.boundary.iter().filter(shown)).flat_map(|p| {
            let walls = p.in_hands.iter();
            let all = walls.flat_map(|walls| &walls.analysis_stable_n_per_m);
            let all = all.filter(|[_, to]| *to > SOFTEST_DRAWN);
            // An axis of logarithms has no 0.
            let line = |[from, to]: &[f64; 2]| [from.max(SOFTEST_DRAWN), *to, f64::NAN];
            all.flat_map(move |ends| line(ends).map(|k| (p.dissipation, k)))
        });
        let name = format!("analysis, μ = {}", order.order);
        panel = panel.with(name, Look::Line, colour, outline.chain(standing));
    }
    // Crosses in black look out from behind the points.
    let points = report.orders.iter().flat_map(|order| &order.boundary);
    let marked = points.filter(|point| point.analysis_agrees == Some(false));
    let marked = marked.filter(shown);
    let name = "! differs from the analysis by more than 5 %";
    panel = panel.with(name, Look::Crosses, 5, marked.map(point));
    for (colour, order) in report.orders.iter().enumerate() {
        let name = format!("{tried}, μ = {}", order.order);
        let tried = (order.boundary.iter().filter(shown)).flat_map(|p| match &p.in_hands {
            None => vec![point(p)],
            Some(walls) => {
                let ends = walls.stable_n_per_m.iter().flatten();
                let ends = ends.filter(|k| **k > SOFTEST_DRAWN);
                ends.map(|k| (p.dissipation, *k)).collect()
            }
        });
        panel = panel.with(name, Look::Markers, colour, tried);
    }
    panel
}
