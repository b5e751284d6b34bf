//! `zwidth`: how stiff a wall can be rendered, by trying.

use super::conduct::progress_bar;
use super::stop::stop_on_interrupt;
use crate::files::Place;
use crate::keys;
use crate::options::Options;
use crate::output::{Output, note, warn};
use clap::Args;
use haptic_experiment::document::Document;
use haptic_experiment::question::BoundaryPoint;
use haptic_experiment::question::Question;
use haptic_experiment::{Failure, ZWidth, ZWidthReport};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use serde::Serialize;
use std::path::PathBuf;

pub(crate) const LONG_ABOUT: &str = "\
Z-width: throws a device against a wall, pushes it into the wall, and finds the stiffest wall at which it comes to rest, for each order and \
dissipation. The default device is that of the dissertation's section 4.4 (65 g, 3.5 N.s/m); --device-model laboratory adds what real devices have.

At rest means: over the last 0.4 s of 5 s the standard deviation of the position is at most 2 encoder steps or 1 % of push/K, whichever is larger, \
and that of the force at most one encoder step through the operator (no more than 25 % of the push) or 5 % of the push. A force at its limit in more \
than 1 % of the samples is not stable. With friction each wall is also tried without it: stable is what settles both ways.

The largest stiffness by the analysis stands beside each point. Ctrl-C keeps the points that are done.";

/// Arguments of `zwidth`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli zwidth --orders 0,0.5,1 --points 11 --device-model laboratory --out zwidth\n  \
                  host-cli zwidth --mass 45g --damping 0.2 --force-limit 3.3N --orders 1 window=1s"
)]
pub struct Arguments {
    #[command(flatten)]
    options: Options<keys::ZWidth>,
    /// Folder for zwidth.csv and pictures
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run in the folder
    #[arg(long)]
    overwrite: bool,
}

/// The result, and where it was written.
#[derive(Serialize)]
struct Shown<'a> {
    #[serde(flatten)]
    report: &'a ZWidthReport,
    files: Vec<String>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = Place::look(self.out.as_deref(), "zwidth", self.overwrite, &[])?;
        let experiment = experiment(self.options)?;
        let bar = progress_bar(experiment.cells(), output);
        let stop = stop_on_interrupt()?;
        let result = experiment.run(&|cells| bar.inc(cells), stop, &warn);
        bar.finish_and_clear();
        let report = result?;
        let files = match report.has_points() {
            true => place.table_and_picture(report.rows(), || draw(&report)),
            false => Vec::new(),
        };
        let points = report.orders.iter().flat_map(|order| &order.boundary);
        if points
            .clone()
            .any(|p| p.alpha >= 0.999 * report.alpha_searched)
        {
            note(
                "warning",
                format_args!(
                    "some walls were stable up to alpha = {}, where the search ends: their limit is higher",
                    report.alpha_searched
                ),
            );
        }
        let mut analysed = points.clone().map(|point| point.analysis_stiffness_n_per_m);
        if report.device != "sim" && analysed.all(|found| found.is_none()) {
            note(
                "warning",
                "no analysis, as nobody knows delay and lag of this device: host-cli device measure --out device.toml finds \
                 them, host-cli analyze stability-region --device-model device.toml tells the stiffest wall",
            );
        }
        if report.disagreements > 0 {
            note(
                "warning",
                format_args!(
                    "trial and analysis disagree by more than 5 % of the wall at {} of {} points, marked !: the analysis knows \
                     neither friction, encoder, force limit nor a wall that only pushes, and a trial does not see \
                     what settles or grows more slowly than it lasts (duration_s)",
                    report.disagreements,
                    points.count()
                ),
            );
        }
        output.summary(&Shown {
            report: &report,
            files,
        })?;
        place.close(match report.ended_early {
            Some(failure) => Err(failure.and("the points that were done are kept")),
            None => Ok(()),
        })
    }
}

fn experiment(options: Options<keys::ZWidth>) -> Result<ZWidth, Failure> {
    let document = options.over(Document::new("zwidth"))?;
    match Question::open(&document).map_err(Failure::input)? {
        Question::ZWidth(zwidth) => Ok(zwidth),
        _ => Err(Failure::bad_input("not a Z-width")),
    }
}

/// A curve with what it needs to be drawn.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    look: Look,
    colour: usize,
}

impl Curve {
    fn series(&self) -> Series<'_> {
        Series::new(&self.name, &self.points, self.look, self.colour)
    }
}

/// Number of a colour.
const BLACK: usize = 5;

/// The boundaries in the plane of β and α, or with units: the analysis beneath, what was tried on it.
fn curves(report: &ZWidthReport, with_units: bool) -> Vec<Curve> {
    let tried = if report.device == "sim" {
        "simulated"
    } else {
        "measured"
    };
    let place = |p: &BoundaryPoint| match with_units {
        true => (p.dissipation, p.stiffness_max),
        false => (p.beta, p.alpha),
    };
    let orders = || report.orders.iter().enumerate();
    let analysis = orders().map(|(colour, order)| {
        let (stiffness, dissipation) = if with_units { order.units } else { (1.0, 1.0) };
        let outline = order.outline.iter();
        Curve {
            name: format!("analysis, μ = {}", order.order),
            points: outline
                .map(|&(beta, alpha)| (beta * dissipation, alpha * stiffness))
                .collect(),
            look: Look::Line,
            colour,
        }
    });
    let trials = orders().map(|(colour, order)| {
        let boundary = order.boundary.iter();
        Curve {
            name: format!("{tried}, μ = {}", order.order),
            points: boundary.map(place).collect(),
            look: Look::Markers,
            colour,
        }
    });
    let marked = Some(disagreements(report, place)).filter(|curve| !curve.points.is_empty());
    // Crosses look out from behind the points.
    analysis.chain(marked).chain(trials).collect()
}

/// The points that the table marks with an exclamation mark.
fn disagreements(report: &ZWidthReport, place: impl Fn(&BoundaryPoint) -> (f64, f64)) -> Curve {
    let points = report.orders.iter().flat_map(|order| &order.boundary);
    let marked = points.filter(|point| point.analysis_agrees == Some(false));
    Curve {
        name: "! differs from the analysis by more than 5 %".to_owned(),
        points: marked.map(place).collect(),
        look: Look::Crosses,
        colour: BLACK,
    }
}

/// The boundaries without units, and the same in N/m.
fn draw(report: &ZWidthReport) -> Result<Picture, FigureError> {
    let (plane, physical) = (curves(report, false), curves(report, true));
    ChartPage {
        title: "Z-width: the stiffest walls that settle",
        subtitle: &format!(
            "scheme {} · T = {} s · δ = {:.5} · device {} · impact {} m/s · push {} N",
            report.scheme,
            report.asked.sample_time_s,
            report.delta,
            report.device,
            report.impact_m_per_s,
            report.push_n
        ),
        columns: 2,
        charts: vec![
            Chart {
                caption: "without units",
                x: AxisSpec::new("dissipation β = BT^{2−μ}/m", Scale::Linear),
                y: AxisSpec::new("largest stiffness α = KT²/m", Scale::Linear),
                series: plane.iter().map(Curve::series).collect(),
            },
            Chart {
                caption: "with units; B = 0 lies outside",
                x: AxisSpec::new("dissipation B / N·s^{μ}·m⁻¹", Scale::Log),
                y: AxisSpec::new("largest stiffness K / N·m⁻¹", Scale::Linear),
                series: physical.iter().map(Curve::series).collect(),
            },
        ],
    }
    .draw()
}
