//! Creep: strain under a held force.

use super::theory::Comparison;
use super::{Conditions, FigureError, Picture};

/// Strain against time under a held force, linear and log-log, over theory, and the error below.
/// The slices belong together sample by sample; what is not finite is left out, and so is what is
/// not positive from the logarithmic panels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreepFigure<'a> {
    /// One line above the picture.
    pub title: &'a str,
    /// Tissue, order, scheme.
    pub conditions: Conditions<'a>,
    /// Time since the force was applied, s.
    pub time_s: &'a [f64],
    /// Strain, dimensionless.
    pub strain: &'a [f64],
    /// Strain by theory at the same times.
    pub theory: &'a [f64],
    /// Relative error of the strain; the sign does not matter.
    pub relative_error: &'a [f64],
}

impl CreepFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If there is no sample to draw, or the slices differ in length.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        Comparison {
            title: self.title,
            conditions: self.conditions,
            quantity: "strain",
            label: "strain",
            time_s: self.time_s,
            measured: self.strain,
            theory: self.theory,
            relative_error: self.relative_error,
        }
        .draw()
    }
}
