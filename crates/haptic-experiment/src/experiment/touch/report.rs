//! Report of a touch.

use super::posture::PostureVerdict;
use crate::judge::curves::Origin;
use crate::judge::report::{Errors, RunReport, Summary};
use serde::Serialize;

/// How a touch went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TouchVerdict {
    /// The hand was given no energy, and the force stayed within its limits.
    Passive,
    /// The hand was given energy.
    GaveEnergy,
    /// On a device, whose hand nobody measures: the shape was rendered within its limits.
    Rendered,
    /// A limiter of the safety chain other than the guard acted in more than 1 % of the samples.
    Saturated,
    /// It did not reach its end.
    Unfinished,
}

impl TouchVerdict {
    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Passive => "the hand was given no energy",
            Self::GaveEnergy => "the hand was given energy",
            Self::Rendered => "rendered within limits; the energy given is not measured",
            Self::Saturated => "the force was limited",
            Self::Unfinished => "the run did not finish",
        }
    }
}

/// The result. The keys are those of a wall where they have a meaning.
#[derive(Clone, Debug, Serialize)]
pub struct TouchReport {
    /// Number of axes.
    pub axes: usize,
    /// The shape, in words.
    pub shape: String,
    /// The matter, in words.
    pub matter: String,
    /// μ.
    pub order: f64,
    /// Operator.
    pub scheme: String,
    /// Of the run; forces are the norms of the vectors.
    #[serde(flatten)]
    pub run: RunReport,
    /// The force against the full history of the depth, as a share of the largest force; null for a limited one. There is no
    /// closed form of a scripted hand.
    #[serde(flatten)]
    pub errors: Errors,
    /// Verdict.
    pub verdict: TouchVerdict,
    /// The verdict in words.
    pub verdict_reason: &'static str,
    /// Deepest place as the loop read it, m.
    pub largest_depth_m: f64,
    /// Energy that the hand was given in all, J; negative if it gave more; null on a device, whose hand nobody measures.
    pub given_j: Option<f64>,
    /// The most of it at any time, J; at most rounding if all is passive; null on a device.
    pub given_most_j: Option<f64>,
    /// Masses along the normal, and the one that the pre-flight is of.
    #[serde(flatten)]
    pub posture: PostureVerdict,
}

impl Summary for TouchReport {
    fn run(&self) -> &RunReport {
        &self.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.run
    }
}

/// A touch for whoever draws it: paths in the plane of the first two axes, depth and forces over time.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchCurves {
    /// One line about the run.
    pub subtitle: String,
    /// Where the force comes from.
    pub origin: Origin,
    /// Outline of the shape in that plane, m; empty if it is not there.
    pub outline_m: Vec<(f64, f64)>,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// The point that the hand goes to, m; not a number where nobody knows.
    pub hand_m: [Vec<f64>; 2],
    /// The device, m.
    pub position_m: [Vec<f64>; 2],
    /// Depth into the shape, m.
    pub depth_m: Vec<f64>,
    /// Force of each axis, N.
    pub force_n: Vec<Vec<f64>>,
}
