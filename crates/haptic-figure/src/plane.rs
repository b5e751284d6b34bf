//! Motion of two or three axes: the path in the plane of the first two beside depth and force over time.

use crate::axis::Scale;
use crate::chart::{AxisSpec, Chart, ChartPage, Look, Series};
use crate::thin::once;
use crate::{FigureError, Picture};

/// Lengths are drawn in mm.
const MM_PER_M: f64 = 1e3;
/// Width over height of a box of a page with two columns, so that a mm is as long either way.
const BOX: f64 = 330.0 / HEIGHT_PX;
/// Height of such a box.
const HEIGHT_PX: f64 = 262.0;
/// Points of a path that are drawn: more are left out evenly, for its panel is small.
const PATH_POINTS: usize = 5000;
/// Width of a line as a share of the height of its panel.
const LINE: f64 = 2.0 / HEIGHT_PX;
const MARGIN: f64 = 1.08;

/// Motion of two or three axes for a first look. The slices belong together sample by sample; what is not finite is left out.
/// ```
/// use haptic_figure::PlaneFigure;
///
/// let time_s: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
/// let along = |turn: fn(f64) -> f64| -> Vec<f64> { time_s.iter().map(|t| 0.02 * turn(*t)).collect() };
/// let (x, y) = (along(f64::cos), along(f64::sin));
/// let figure = PlaneFigure {
///     title: "A circle",
///     subtitle: "",
///     outline_m: &[],
///     time_s: &time_s,
///     reference_m: [&x, &y],
///     position_m: [&x, &y],
///     depth_m: None,
///     force_n: &[vec![0.0; 200], vec![1.0; 200]],
/// };
/// assert!(figure.draw()?.svg().contains("y / mm"));
/// # Ok::<(), haptic_figure::FigureError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFigure<'a> {
    /// One line above the picture.
    pub title: &'a str,
    /// One line below it; may be empty.
    pub subtitle: &'a str,
    /// Outline of the thing that is touched, m; may be empty.
    pub outline_m: &'a [(f64, f64)],
    /// Time of each sample, s; all slices are as long as this one.
    pub time_s: &'a [f64],
    /// Requested position in the plane, m.
    pub reference_m: [&'a [f64]; 2],
    /// Place of the device, in the plane, m.
    pub position_m: [&'a [f64]; 2],
    /// Depth into the thing, m, if it is known; otherwise the positions over time are drawn
    /// instead.
    pub depth_m: Option<&'a [f64]>,
    /// Force on each axis, N.
    pub force_n: &'a [Vec<f64>],
}

impl PlaneFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If no sample can be drawn, or the slices differ in length.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        self.check()?;
        let outline = scaled(self.outline_m.iter().copied());
        let hand = self.path(self.reference_m);
        let device = self.path(self.position_m);
        let (x, y) = ranges([&outline, &hand, &device]);
        // The dashes of a second lap would fill the gaps of the first.
        let width = y.map_or(f64::INFINITY, |(low, high)| LINE * (high - low));
        let hand = once(&hand, width);
        let depth = self.depth_m.map(|depth| self.over_time(depth, MM_PER_M));
        let places = self.position_m.map(|axis| self.over_time(axis, MM_PER_M));
        let forces = self.force_n.iter();
        let forces: Vec<_> = forces.map(|axis| self.over_time(axis, 1.0)).collect();
        let over_time = |caption, label, series| Chart {
            caption,
            x: AxisSpec::new("time / s", Scale::Linear),
            y: AxisSpec::new(label, Scale::Linear),
            series,
        };
        let lengths = match &depth {
            Some(depth) => {
                let depth = vec![Series::new("device", depth, Look::Line, 0)];
                over_time("depth", "depth / mm", depth)
            }
            None => over_time("place", "place / mm", axes(&places)),
        };
        ChartPage {
            title: self.title,
            subtitle: self.subtitle,
            columns: 2,
            charts: vec![
                plane(&outline, &hand, &device, x, y),
                over_time(
                    "force on the hand, along the axes",
                    "force / N",
                    axes(&forces),
                ),
                lengths,
            ],
        }
        .draw()
    }

    fn check(&self) -> Result<(), FigureError> {
        let mut lengths = vec![
            ("reference", self.reference_m[0]),
            ("reference", self.reference_m[1]),
            ("position", self.position_m[0]),
            ("position", self.position_m[1]),
        ];
        lengths.extend(self.depth_m.map(|depth| ("depth", depth)));
        lengths.extend(self.force_n.iter().map(|force| ("force", force.as_slice())));
        check_lengths(self.time_s, &lengths)
    }

    fn path(&self, [x, y]: [&[f64]; 2]) -> Vec<(f64, f64)> {
        let stride = x.len().div_ceil(PATH_POINTS).max(1);
        let points = x.iter().copied().zip(y.iter().copied());
        let mut path = scaled(points.step_by(stride));
        // The stride may miss the last point.
        path.extend(scaled(x.last().copied().zip(y.last().copied())));
        path
    }

    fn over_time(&self, values: &[f64], factor: f64) -> Vec<(f64, f64)> {
        let values = values.iter().map(|value| factor * value);
        self.time_s.iter().copied().zip(values).collect()
    }
}

/// The paths over the outline, with one scale for both axes.
fn plane<'a>(
    outline: &'a [(f64, f64)],
    hand: &'a [(f64, f64)],
    device: &'a [(f64, f64)],
    x: Ends,
    y: Ends,
) -> Chart<'a> {
    let axis = |label, range| AxisSpec {
        range,
        ..AxisSpec::new(label, Scale::Linear)
    };
    let mut series = vec![
        Series::new("hand", hand, Look::Dashed, 2),
        Series::new("device", device, Look::Line, 0),
    ];
    if !outline.is_empty() {
        series.insert(0, Series::new("surface", outline, Look::Area, 6));
    }
    Chart {
        caption: "path",
        x: axis("x / mm", x),
        y: axis("y / mm", y),
        series,
    }
}

/// Refuses slices that have not one value for each time.
fn check_lengths(time_s: &[f64], slices: &[(&'static str, &[f64])]) -> Result<(), FigureError> {
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

fn scaled(points: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let points = points.into_iter();
    points.map(|(x, y)| (MM_PER_M * x, MM_PER_M * y)).collect()
}

/// A series for each axis.
fn axes(curves: &[Vec<(f64, f64)>]) -> Vec<Series<'_>> {
    let curves = curves.iter().zip(["x", "y", "z"]).enumerate();
    curves
        .map(|(n, (points, name))| Series::new(name, points, Look::Line, [1, 3, 4][n]))
        .collect()
}

/// Ends of an axis; `None` uses those of the data.
type Ends = Option<(f64, f64)>;

/// The ends of both axes for these points, with one scale for both.
fn ranges(curves: [&[(f64, f64)]; 3]) -> (Ends, Ends) {
    let points = || curves.into_iter().flatten();
    let ends = |coordinate: fn(&(f64, f64)) -> f64| {
        let values = || points().map(coordinate).filter(|value| value.is_finite());
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        (0.5 * (low + high), high - low)
    };
    let ((x, width), (y, height)) = (ends(|point| point.0), ends(|point| point.1));
    // Half the height of the box, mm.
    let half = 0.5 * MARGIN * height.max(width / BOX);
    if !(half.is_finite() && half > 0.0) {
        return (None, None);
    }
    (
        Some((x - BOX * half, x + BOX * half)),
        Some((y - half, y + half)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_millimetre_is_as_long_either_way() {
        let flat = [(0.0, 1.0), (10.0, 2.0)];
        let (x, y) = ranges([&flat, &[], &[(f64::NAN, 5.0)]]);
        let ((x_low, x_high), (y_low, y_high)) = (x.expect("ends"), y.expect("ends"));
        let ratio = (x_high - x_low) / (y_high - y_low);
        assert!((ratio - BOX).abs() < 1e-12, "{ratio}");
        assert!(x_low < 0.0 && x_high > 10.0 && y_low < 1.0 && y_high > 5.0);
        assert_eq!(ranges([&[], &[], &[]]), (None, None));
        let point: &[(f64, f64)] = &[(1.0, 1.0)];
        assert_eq!(ranges([point, point, point]), (None, None));
    }
}
