//! A controller as the law of a run: what a device that can run one needs beside its numbers.

use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most parts that a controller can have.
pub const CONTROLLER_PARTS: usize = 3;

/// The meaning of the numbers of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ControllerForm {
    /// The share of a bias that is left after a sample, then k, w and the power of each part: PI^λD^μ, TID.
    #[default]
    Parallel,
    /// That share too, g, p, q, then the power of each part: CRONE, lead–lag without a whole section.
    Lead,
    /// Numbers as of `Lead`, with one whole section.
    LeadOfOne,
    /// Numbers as of `Lead`, with two whole sections.
    LeadOfTwo,
}

/// One part of a controller, and how many of the coefficients belong to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct ControllerPart {
    /// Differences (> 0) or sums (< 0) applied around its power, −2 to 2.
    pub integer: i8,
    /// Number of coefficients of its power, as for
    /// [`OperatorForm::Modes`](crate::OperatorForm::Modes); 0 without one.
    #[serde(with = "postcard::fixint::le")]
    pub values: u16,
    /// Number of coefficients of the filter after it.
    pub filter: u8,
}

/// A controller that makes the device follow a reference, in place of the law of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct ControllerLaw {
    /// The meaning of the coefficients.
    pub form: ControllerForm,
    /// r, the position at which the device is held, m.
    pub reference_m: f32,
    /// Number of ticks in which the reference rises from 0 to r; 0 means at once.
    #[serde(with = "postcard::fixint::le")]
    pub ramp_ticks: u32,
    /// Lowest command that the controller may give, N.
    pub low_n: f32,
    /// Highest command, above the lowest, N.
    pub high_n: f32,
    /// One part for each power, plus one for a term without a power.
    pub parts: Vec<ControllerPart, CONTROLLER_PARTS>,
}

/// The time that a device needs for a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct ControllerCost {
    /// Shortest tick, whatever the controller, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_us: u32,
    /// Additional time per coefficient, ns.
    #[serde(with = "postcard::fixint::le")]
    pub coefficient_ns: u32,
}

impl ControllerCost {
    /// Shortest tick with a controller of this many coefficients, µs, rounded up.
    #[must_use]
    pub const fn tick_period_min_us(&self, coefficients: u16) -> u32 {
        let ns = self.coefficient_ns.saturating_mul(coefficients as u32);
        self.tick_us.saturating_add(ns.div_ceil(1000))
    }
}
