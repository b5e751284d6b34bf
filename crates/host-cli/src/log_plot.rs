//! Position and force of any log against time.

use crate::record::TickMessage;
use haptic_figure::{FigureError, MotionFigure, Picture};

/// A log for a first look: positions above, forces below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogFigure<'a> {
    /// One line above the picture, as the name of the log.
    pub title: &'a str,
    /// One line below it; may be empty.
    pub subtitle: &'a str,
    /// The ticks in order.
    pub ticks: &'a [TickMessage],
}

impl LogFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If there is no tick to draw.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        MotionFigure {
            title: self.title,
            subtitle: self.subtitle,
            time_s: &self.column(|tick| tick.time_s),
            reference_m: &self.column(|tick| tick.reference_m),
            indenter_position_m: &self.column(|tick| tick.indenter_position_m),
            position_m: &self.column(|tick| tick.position_m),
            force_n: &self.column(|tick| tick.force_n),
            contact_force_n: &self.column(|tick| tick.contact_force_n),
        }
        .draw()
    }

    fn column(&self, value: impl Fn(&TickMessage) -> f64) -> Vec<f64> {
        self.ticks.iter().map(value).collect()
    }
}
