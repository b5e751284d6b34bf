//! Parts that pictures over time share: slices that belong together and panels over time.

use crate::FigureError;
use crate::axis::{Axis, Scale, extremes};
use crate::curve::{Curve, Form};
use crate::panel::Panel;
use crate::style::Stroke;
use crate::thin::Points;

/// Refuses slices that have not one value for each time.
pub(crate) fn check_lengths(
    time_s: &[f64],
    slices: &[(&'static str, &[f64])],
) -> Result<(), FigureError> {
    let wrong = slices.iter().find(|(_, slice)| slice.len() != time_s.len());
    match wrong {
        None => Ok(()),
        Some((what, slice)) => Err(FigureError::Lengths {
            what,
            expected: time_s.len(),
            found: slice.len(),
        }),
    }
}

/// A line through these points.
pub(crate) fn line(points: Points, stroke: Stroke) -> Curve {
    Curve {
        pieces: vec![points],
        form: Form::Line(stroke),
    }
}

/// A panel over time around its curves, with both axes of one scale.
#[derive(Clone, Debug)]
pub(crate) struct TimePanel {
    pub(crate) name: char,
    pub(crate) caption: String,
    pub(crate) scale: Scale,
    /// Of the vertical axis, with the unit.
    pub(crate) label: &'static str,
    pub(crate) curves: Vec<Curve>,
    /// The vertical axis begins no lower.
    pub(crate) floor: Option<f64>,
    /// Said when there is no curve.
    pub(crate) note: &'static str,
}

impl TimePanel {
    pub(crate) fn panel(self) -> Panel {
        let points: Points = self.curves.iter().flat_map(Curve::points).collect();
        let empty = points.is_empty();
        let (x, y) = if empty {
            ((1.0, 10.0), (1.0, 10.0))
        } else {
            (
                extremes(points.iter().map(|point| point.0)),
                extremes(points.iter().map(|point| point.1)),
            )
        };
        let y_low = self.floor.map_or(y.0, |floor| y.0.max(floor));
        Panel {
            name: self.name,
            caption: self.caption,
            x: Axis::time(self.scale, x.0, x.1),
            y: Axis::around(self.label, self.scale, y_low, y.1),
            curves: self.curves,
            note: empty.then(|| self.note.to_owned()),
        }
    }
}
