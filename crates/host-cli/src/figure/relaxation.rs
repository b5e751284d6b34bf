//! Stress relaxation: the picture of the main job.

use super::theory::Comparison;
use super::{Conditions, FigureError, Picture};

/// Force against time under a held indentation, linear and log-log, over theory, and the error
/// below. The slices belong together sample by sample; what is not finite is left out, and so is
/// what is not positive from the logarithmic panels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxationFigure<'a> {
    /// One line above the picture.
    pub title: &'a str,
    /// Tissue, order, scheme.
    pub conditions: Conditions<'a>,
    /// Time since contact, s: a logarithmic axis begins at the first positive one.
    pub time_s: &'a [f64],
    /// Commanded force, N.
    pub force_n: &'a [f64],
    /// Force by theory at the same times, N.
    pub theory_n: &'a [f64],
    /// Relative error of the force; the sign does not matter.
    pub relative_error: &'a [f64],
}

impl RelaxationFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If there is no sample to draw, or the slices differ in length.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        Comparison {
            title: self.title,
            conditions: self.conditions,
            quantity: "force",
            label: "force / N",
            time_s: self.time_s,
            measured: self.force_n,
            theory: self.theory_n,
            relative_error: self.relative_error,
        }
        .draw()
    }
}
