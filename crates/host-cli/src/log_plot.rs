//! Position and force of any log: against time, or of several axes as a path beside them.

use haptic_figure::{FigureError, MotionFigure, Picture, PlaneFigure};
use haptic_log::record::{PerAxis, TickMessage};

/// A log for a first look: positions above, forces below; of several axes the path, places and forces.
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
        let axes = self.ticks.first().map_or(1, TickMessage::axes);
        let time_s: Vec<f64> = self.ticks.iter().map(|tick| tick.time_s).collect();
        let of = |axis: usize, field: fn(&TickMessage) -> PerAxis| -> Vec<f64> {
            let numbers = self.ticks.iter().map(field);
            numbers
                .map(|numbers| numbers.get(axis).copied().unwrap_or(f64::NAN))
                .collect()
        };
        if axes == 1 {
            return MotionFigure {
                title: self.title,
                subtitle: self.subtitle,
                time_s: &time_s,
                reference_m: &of(0, |tick| tick.reference_m),
                indenter_position_m: &of(0, |tick| tick.indenter_position_m),
                position_m: &of(0, |tick| tick.position_m),
                force_n: &of(0, |tick| tick.commanded_force_n),
                contact_force_n: &of(0, |tick| tick.contact_force_n),
            }
            .draw();
        }
        let [x, y] = [0, 1].map(|axis| of(axis, |tick| tick.position_m));
        let [hand_x, hand_y] = [0, 1].map(|axis| of(axis, |tick| tick.reference_m));
        let force_n: Vec<_> = (0..axes)
            .map(|axis| of(axis, |tick| tick.commanded_force_n))
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
}
