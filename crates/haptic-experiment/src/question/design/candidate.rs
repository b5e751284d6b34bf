//! Answer of a design: a candidate for each order, and the whole report.

use crate::question::asked_device::AskedDevice;
use crate::{Imperfections, Settling};
use fracdiff::Order;
use serde::Serialize;

/// The best wall of one order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// μ.
    pub order: f64,
    /// K, N/m; null if there is no wall.
    pub stiffness: Option<f64>,
    /// B, N·s^μ/m.
    pub dissipation: Option<f64>,
    /// Factor by which the wall as a whole may grow until it is unstable (below 1: must shrink).
    pub margin: Option<f64>,
    /// K·T²/m.
    pub alpha: Option<f64>,
    /// B·T^(2−μ)/m.
    pub beta: Option<f64>,
    /// True if it is passive by Theorem 1.
    pub passive: Option<bool>,
    /// The damping of the device that this takes, N·s/m.
    pub required_damping_n_s_per_m: Option<f64>,
    /// Im H/ω at the wish's frequency, N·s/m.
    pub effective_damping_n_s_per_m: Option<f64>,
    /// Noise of the force that encoder steps and sensor noise make through B, rms N; null for ideal sensors.
    pub force_noise_rms_n: Option<f64>,
    /// For a tissue: factor by which the specimen may grow under the requirement; below 1 it is too
    /// large.
    pub largest_scale: Option<f64>,
    /// Why it will not do.
    pub reason: Option<String>,
}

/// The best candidate on a realistic device. Keys of the report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RealisticTrial {
    /// Imperfections of the device.
    #[serde(flatten)]
    pub imperfections: Imperfections,
    /// True if the analysis, which knows delay and current lag, calls it stable.
    pub analysis_stable: bool,
    /// Factor by which the wall may grow until it is unstable (below 1: must shrink); null if no factor does.
    pub margin: Option<f64>,
    /// Noise of the force that the encoder makes, rms N.
    pub force_noise_rms_n: f64,
    /// Result of the trial.
    pub simulated: Settling,
}

/// Verdict on a tissue that is to be rendered as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TissueVerdict {
    /// Its name.
    pub name: String,
    /// Its order.
    pub order: f64,
    /// True if the specimen meets the requirement.
    pub fits: bool,
    /// Factor by which it may grow.
    pub largest_scale: Option<f64>,
}

/// The answer. The keys are a contract of the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignReport {
    /// Mass, damping, hand and sample time of the device.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// Imperfections of the device, as far as they were given.
    pub imperfections: Imperfections,
    /// Nothing of a real device was given: friction, delay, current lag and encoder steps are none.
    pub ideal_device_assumed: bool,
    /// The wish.
    pub wish: String,
    /// Under which requirement.
    pub require: String,
    /// Of the requirement.
    pub gain_margin: Option<f64>,
    /// Of the wish.
    pub frequency_hz: Option<f64>,
    /// Operator.
    pub scheme: String,
    /// Limit on the noise of the force, rms N; null for none.
    pub force_noise_limit_n: Option<f64>,
    /// Of the `stiffness` of candidates.
    pub stiffness_unit: &'static str,
    /// Of their `dissipation`.
    pub dissipation_unit: &'static str,
    /// One for each order.
    pub candidates: Vec<Candidate>,
    /// The one that meets the wish best; null if none does.
    pub best: Option<Candidate>,
    /// For a tissue.
    pub tissue: Option<TissueVerdict>,
    /// The best one tried on the simulated device.
    pub simulated: Option<Settling>,
    /// If an ideal device was assumed: the best one tried on a realistic one.
    pub realistic: Option<RealisticTrial>,
    /// Notes for the designer, a sentence each.
    pub notes: Vec<String>,
    /// The text of the experiment file that does this.
    #[serde(skip)]
    pub experiment_text: Option<String>,
    /// The experiment file, if one was written.
    pub experiment: Option<String>,
    /// Table and picture, if they were written.
    pub files: Vec<String>,
}

/// A wall without units, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Point {
    Wall {
        alpha: f64,
        beta: f64,
        /// Of a tissue.
        scale: Option<f64>,
    },
    None(String),
}

impl Candidate {
    /// An order without a wall.
    pub(super) fn none(order: Order, reason: String) -> Self {
        Self {
            order: order.get(),
            stiffness: None,
            dissipation: None,
            margin: None,
            alpha: None,
            beta: None,
            passive: None,
            required_damping_n_s_per_m: None,
            effective_damping_n_s_per_m: None,
            force_noise_rms_n: None,
            largest_scale: None,
            reason: Some(reason),
        }
    }
}
