//! Position and force of any log: against time, or of several axes as a path beside them.

use haptic_figure::{FigureError, MotionFigure, Picture, PlaneFigure};
use haptic_log::record::{PerAxis, TickMessage, VectorTick};

/// A log for a first look: positions above, forces below; of several axes the path, places and forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogFigure<'a> {
    /// One line above the picture, as the name of the log.
    pub title: &'a str,
    /// One line below it; may be empty.
    pub subtitle: &'a str,
    /// The ticks in order.
    pub ticks: &'a [TickMessage],
    /// The ticks of a log with several axes, in order.
    pub vectors: &'a [VectorTick],
}

impl LogFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If there is no tick to draw.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        if self.ticks.is_empty() && !self.vectors.is_empty() {
            return self.draw_plane();
        }
        MotionFigure {
            title: self.title,
            subtitle: self.subtitle,
            time_s: &self.column(|tick| tick.time_s),
            reference_m: &self.column(|tick| tick.reference_m),
            indenter_position_m: &self.column(|tick| tick.indenter_position_m),
            position_m: &self.column(|tick| tick.position_m),
            force_n: &self.column(|tick| tick.commanded_force_n),
            contact_force_n: &self.column(|tick| tick.contact_force_n),
        }
        .draw()
    }

    fn draw_plane(&self) -> Result<Picture, FigureError> {
        let time_s: Vec<f64> = self.vectors.iter().map(|tick| tick.time_s).collect();
        let [x, y] = [0, 1].map(|axis| self.axis(axis, |tick| tick.position_m));
        let [hand_x, hand_y] = [0, 1].map(|axis| self.axis(axis, |tick| tick.reference_m));
        let axes = self.vectors.first().map_or(0, VectorTick::axes);
        let force_n: Vec<Vec<f64>> = (0..axes)
            .map(|axis| self.axis(axis, |tick| tick.commanded_force_n))
            .collect();
        PlaneFigure {
            title: self.title,
            subtitle: self.subtitle,
            outline_m: &[],
            time_s: &time_s,
            reference_m: [&hand_x, &hand_y],
            position_m: [&x, &y],
            depth_m: None,
            force_n: &force_n,
        }
        .draw()
    }

    fn column(&self, value: impl Fn(&TickMessage) -> f64) -> Vec<f64> {
        self.ticks.iter().map(value).collect()
    }

    /// An axis of a vector.
    fn axis(&self, axis: usize, field: fn(&VectorTick) -> PerAxis) -> Vec<f64> {
        let ticks = self.vectors.iter();
        ticks
            .map(|tick| {
                field(tick)
                    .as_slice()
                    .get(axis)
                    .copied()
                    .unwrap_or(f64::NAN)
            })
            .collect()
    }
}
