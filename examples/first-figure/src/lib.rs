//! The stress relaxation of `host-cli relax` with its defaults, and its figure, from the same trial: without the log, devices
//! and questions that are most of what the command compiles.

#![forbid(unsafe_code)]

use haptic_document::{Document, Failure};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use haptic_judge::indentation::{IndentationTrial, relax};
use haptic_judge::rendering::RELAX_TABLES;
use haptic_loop::plant::RigDrive;
use haptic_trial::tick::KeptSample;
use std::ops::ControlFlow;
use std::path::Path;

/// Times in s, and values there.
pub type Points = Vec<(f64, f64)>;

/// A relaxation that was simulated.
#[derive(Clone, Debug)]
pub struct Relaxation {
    trial: IndentationTrial,
    /// Force on the hand at each tick, N.
    pub force_n: Points,
}

impl Relaxation {
    /// Simulates `[relax]` with its defaults.
    ///
    /// # Errors
    /// None with the defaults as they are: the kinds are those of a file that somebody wrote.
    pub fn simulate() -> Result<Self, Failure> {
        let document = Document::of_text(Path::new("relax.toml"), "[relax]");
        let parsed = document.parse()?;
        let (_, table, _) = parsed.one_of(&["relax"], &[], "experiment", "[relax]")?;
        let trial = relax(&table.with_keys(RELAX_TABLES)?, None, false)?;
        let mut force_n = Vec::new();
        let _ended = trial.run(&mut |tick| {
            let sample = KeptSample::of(tick);
            force_n.push((sample.time_s, sample.reaction_n()));
            ControlFlow::Continue(())
        })?;
        Ok(Self { trial, force_n })
    }

    /// The closed form at these times, N.
    #[must_use]
    pub fn closed_form_n(&self, time_s: &[f64]) -> Vec<f64> {
        match self.trial.load {
            RigDrive::Position(way) => {
                let (depth_m, ramp_s) = (way.depth().0, way.ramp_time().0);
                self.trial.piece.relaxed(depth_m, ramp_s, time_s)
            }
            RigDrive::Force(push) => vec![push.0; time_s.len()],
        }
    }

    /// Force over time and over its logarithm, on the closed form.
    ///
    /// # Errors
    /// If there is nothing to draw.
    pub fn picture(&self) -> Result<Picture, FigureError> {
        let times: Vec<f64> = self.force_n.iter().map(|point| point.0).collect();
        let exact: Points =
            std::iter::zip(times.iter().copied(), self.closed_form_n(&times)).collect();
        let chart = |caption, scale| Chart {
            caption,
            x: AxisSpec::new("time / s", scale),
            y: AxisSpec::new("force on the hand / N", scale),
            series: vec![
                Series::new("closed form", &exact, Look::Broad, 3),
                Series::new("simulated force", &self.force_n, Look::Line, 0),
            ],
        };
        ChartPage {
            title: &format!(
                "Stress relaxation of {}",
                self.trial.piece.material.description
            ),
            subtitle: "",
            columns: 2,
            charts: vec![
                chart("force", Scale::Linear),
                chart("force, log–log", Scale::Log),
            ],
        }
        .draw()
    }
}
