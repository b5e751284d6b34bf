//! Curves of a teleoperation.

use super::report::FeltAt;

/// What there is to draw of a teleoperation.
#[derive(Clone, Debug, PartialEq)]
pub struct TeleoperationCurves {
    /// One line: line, laws, place, verdict.
    pub subtitle: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Place of the hand, m.
    pub hand_m: Vec<f64>,
    /// Place of the master, m.
    pub master_m: Vec<f64>,
    /// Place of the slave, m.
    pub slave_m: Vec<f64>,
    /// Force on the master, N.
    pub master_n: Vec<f64>,
    /// Force on the slave, N.
    pub slave_n: Vec<f64>,
    /// Energy taken by the line, J.
    pub taken_j: Vec<f64>,
    /// What was felt.
    pub felt: Vec<FeltAt>,
}

/// What there is to draw of one side.
#[derive(Clone, Debug, PartialEq)]
pub struct SideCurves {
    /// Its heading.
    pub title: String,
    /// One line: laws and the other side.
    pub subtitle: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Where the hand wants to be, m; not a number on the side without one.
    pub reference_m: Vec<f64>,
    /// Place of the device, m.
    pub position_m: Vec<f64>,
    /// Force on the device, N.
    pub force_n: Vec<f64>,
    /// Force of hand or place on it, N.
    pub outside_n: Vec<f64>,
}
