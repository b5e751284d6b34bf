//! Charts of any quantities: named series on up to 26 panels under one legend.

use crate::axis::{Axis, Scale, extremes, four_digits};
use crate::curve::{Curve, Form};
use crate::drawing::{Marker, Shape};
use crate::page::{LegendEntry, Page, Row};
use crate::panel::{Beyond, Panel};
use crate::style::{
    DOTTED_INDEX, Dash, LARGE, LOOKS, PAGE_WIDTH, SMALL, Sizes, Stroke, even_dash, further_look,
    series_colour, series_dash,
};
use crate::thin::Points;
use crate::{FigureError, Picture};

/// The panels of a page are lettered (a) to (z).
const MOST_PANELS: usize = 26;
/// More columns would leave no room for the boxes.
const MOST_COLUMNS: usize = 5;
/// Height of the boxes of a page by its number of columns, px; their widths are about 760, 330, 200, 150 and 110.
const BOX_HEIGHTS: [f64; MOST_COLUMNS] = [400.0, 262.0, 176.0, 140.0, 118.0];
/// Space above the box of a single panel without a caption.
const TOP_WITHOUT_CAPTION: f64 = 16.0;
/// Width of a broad line over that of others.
const BROAD: f64 = 3.0;
/// Radius of a cross over that of a marker.
const CROSS: f64 = 2.0;
/// Said in a panel that has no point to show, and in one that has but elsewhere.
const EMPTY: &str = "empty";
const OUTSIDE: &str = "outside the axes";

/// An axis: its quantity, scale and ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSpec<'a> {
    /// Quantity and unit, as in `stiffness K / N·mm⁻¹` or `dissipation B / N·s^μ·m⁻¹`.
    pub label: &'a str,
    /// A logarithmic axis leaves out what is not above 0.
    pub scale: Scale,
    /// The ends; without limits, or with ones that such an axis cannot have, those of the data
    /// apply.
    pub range: Option<(f64, f64)>,
    /// True if a line that leaves the range is to say how far it goes.
    pub is_focused: bool,
}

/// The look of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line in the dash of its colour, which is solid for colour 0: series of different colours differ without colours too.
    Line,
    /// A line in any colour, with dashes and gaps of equal length: on another curve, both are seen.
    Dashed,
    /// A dotted line in any colour.
    Dotted,
    /// A broad solid line in any colour, for others to lie on: where they agree, it is seen beneath them.
    Broad,
    /// A marker at each point, in the shape of its colour.
    Markers,
    /// An outlined marker, through which whatever lies beneath it is seen.
    OpenMarkers,
    /// A cross at each point in any colour, larger than a marker: it looks out from behind one of a later series.
    Crosses,
    /// A polygon, closed and lightly filled, outlined as [`Look::Line`]. A point that is not
    /// finite ends one polygon and begins the next one; a polygon within another is a hole.
    Area,
}

/// A named row of points. A line has a gap where a point is not finite, or not positive on a logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<'a> {
    /// Name in the legend; an empty one is not there. Series of one name, on one panel or on several, share one entry. Two names
    /// never share a look: the later one has the next dash or shape that is free.
    pub name: &'a str,
    /// The points in the order in which they are joined.
    pub points: &'a [(f64, f64)],
    /// A wish: where a series with another name looks the same already, the next free look is taken.
    pub look: Look,
    /// Index of its colour in the Okabe–Ito palette: 0 blue, 1 vermilion, 2 green, 3 orange, 4
    /// purple, 5 black, 6 light blue; further ones repeat these in other dashes and shapes.
    pub colour: usize,
}

/// One panel of a page; of its series the first lies beneath, and markers lie on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart<'a> {
    /// Title above the box; may be empty.
    pub caption: &'a str,
    /// Horizontal axis; without a range it spans the points that the vertical axis shows.
    pub x: AxisSpec<'a>,
    /// Vertical axis; without a range it spans the points that the horizontal axis shows.
    pub y: AxisSpec<'a>,
    /// The series in the box.
    pub series: Vec<Series<'a>>,
}

/// A page of charts, row by row. An axis label that a row or column of panels shares stands at its outer edge only.
/// ```
/// use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Scale, Series};
///
/// let region: Vec<(f64, f64)> = (0..=100)
///     .map(|i| f64::from(i) / 50.0)
///     .map(|beta| (beta, 2.0 * beta * (2.0 - beta) / (2.0 + beta)))
///     .collect();
/// let page = ChartPage {
///     title: "Stability region",
///     subtitle: "exact operator, no device damping",
///     columns: 1,
///     charts: vec![Chart {
///         caption: "",
///         x: AxisSpec::new("dissipation β", Scale::Linear),
///         y: AxisSpec::new("stiffness α", Scale::Linear),
///         series: vec![Series::new("μ = 1", &region, Look::Area, 0)],
///     }],
/// };
/// assert!(page.draw()?.svg().contains("μ = 1"));
/// # Ok::<(), haptic_figure::FigureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ChartPage<'a> {
    /// One line above the picture.
    pub title: &'a str,
    /// The conditions, shown below it; a line break begins a new line.
    pub subtitle: &'a str,
    /// Panels in a row, 1 to 5; what is beyond is taken as the nearest.
    pub columns: usize,
    /// The panels, at most 26.
    pub charts: Vec<Chart<'a>>,
}

impl ChartPage<'_> {
    /// Draws the picture. A panel without a point to show says so.
    ///
    /// # Errors
    /// If no panel has a point to show, or there are too many panels.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        let columns = self.columns.clamp(1, MOST_COLUMNS).min(self.charts.len());
        let mut sizes = if columns < 3 { LARGE } else { SMALL };
        if self.charts.len() > MOST_PANELS {
            return Err(FigureError::Panels {
                found: self.charts.len(),
                most: MOST_PANELS,
            });
        }
        if let [Chart { caption: "", .. }] = self.charts.as_slice() {
            sizes.top = TOP_WITHOUT_CAPTION;
        }
        let curves = self.curves(sizes);
        let legend = self.legend(&curves);
        let panels: Vec<Panel> = (('a'..='z').zip(0..self.charts.len()))
            .map(|(name, at)| self.panel(name, at, &curves))
            .collect();
        let mut curves = panels.iter().flat_map(|panel| &panel.curves);
        if curves.all(|curve| curve.points().next().is_none()) {
            let series = self.charts.iter().flat_map(|chart| &chart.series);
            return Err(FigureError::Empty {
                what: "series",
                samples: series.map(|series| series.points.len()).sum(),
            });
        }
        let height = sizes.top + BOX_HEIGHTS[columns - 1] + sizes.bottom;
        let rows = Row::of(height, columns, panels);
        let page = Page {
            title: self.title.to_owned(),
            subtitle: self.subtitle.to_owned(),
            legend,
            sizes,
            rows,
            x_label: String::new(),
            y_label: String::new(),
            width: PAGE_WIDTH,
            printed_m: None,
        };
        Picture::of(page)
    }

    /// The curves of each chart. The form of a name is no other name's, as long as there are forms.
    fn curves(&self, sizes: Sizes) -> Vec<Vec<Curve>> {
        let mut taken: Vec<(&str, Form)> = Vec::new();
        let mut all = Vec::new();
        for chart in &self.charts {
            let mut curves = Vec::new();
            for series in &chart.series {
                let is_free = |form: &Form| {
                    let mut others = taken.iter().filter(|(name, _)| *name != series.name);
                    series.name.is_empty() || !others.any(|(_, other)| form == other)
                };
                let mut forms = (0..LOOKS).map(|further| series.form(further, sizes));
                let form = forms.find(is_free);
                let form = form.unwrap_or_else(|| series.form(0, sizes));
                if !series.name.is_empty() {
                    taken.push((series.name, form));
                }
                curves.push(Curve {
                    pieces: pieces(series.points, chart.x.scale, chart.y.scale),
                    form,
                });
            }
            all.push(curves);
        }
        all
    }

    /// Each name once, in the order of the series, with all that it stands for; not that of which nothing can be drawn.
    fn legend(&self, curves: &[Vec<Curve>]) -> Vec<LegendEntry> {
        let mut legend: Vec<LegendEntry> = Vec::new();
        let all = self.charts.iter().flat_map(|chart| &chart.series);
        for (series, curve) in all.zip(curves.iter().flatten()) {
            let form = curve.form;
            match legend.iter_mut().find(|entry| entry.name == series.name) {
                _ if series.name.is_empty() || curve.pieces.is_empty() => {}
                Some(entry) if entry.forms.contains(&form) => {}
                Some(entry) => entry.forms.push(form),
                None => legend.push(LegendEntry::new(series.name, form)),
            }
        }
        legend
    }

    /// The panel of one of the charts, of the curves of all.
    fn panel(&self, name: char, at: usize, all: &[Vec<Curve>]) -> Panel {
        let (chart, curves) = (&self.charts[at], all[at].clone());
        let points: Points = curves.iter().flat_map(Curve::points).collect();
        let (x, y) = if points.is_empty() {
            // The axes of panels of the same quantities, so that it is clear what is empty.
            let like = self.charts.iter().zip(all);
            let like = like.filter(|(other, _)| (other.x, other.y) == (chart.x, chart.y));
            let curves = like.flat_map(|(_, curves)| curves.clone());
            chart.axes(&curves.collect::<Vec<Curve>>())
        } else {
            chart.axes(&curves)
        };
        let is_seen = curves.iter().any(|curve| curve.is_within(&x, &y));
        let why = if points.is_empty() { EMPTY } else { OUTSIDE };
        let note = (!is_seen).then(|| why.to_owned());
        let series = chart.series.iter().zip(&curves);
        let beyond = series.filter_map(|(series, curve)| chart.beyond(series, curve, &x, &y));
        Panel {
            name,
            caption: chart.caption.to_owned(),
            beyond: beyond.collect(),
            x,
            y,
            curves,
            note,
        }
    }
}

impl Chart<'_> {
    /// Words about markers that have no place on a logarithmic axis, and about the end of a curve beyond a focused one.
    fn beyond(&self, series: &Series<'_>, curve: &Curve, x: &Axis, y: &Axis) -> Option<Beyond> {
        let message = |share, words| Beyond {
            form: curve.form,
            share,
            words,
        };
        if let Form::Markers(_) = curve.form {
            let finite = |point: &&(f64, f64)| point.0.is_finite() && point.1.is_finite();
            let missing = series.points.iter().filter(finite).count() - curve.points().count();
            return (missing > 0)
                .then(|| message(0.0, format!("{missing} not drawn: not above 0")));
        }
        let beyond = |point: &(f64, f64)| (point.1 - y.high).max(y.low - point.1);
        let seen = |point: &(f64, f64)| (x.low..=x.high).contains(&point.0) && beyond(point) > 0.0;
        let points = curve
            .points()
            .filter(|point| self.y.is_focused && seen(point));
        let end = points.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
        let arrow = if end.1 > y.high { '↑' } else { '↓' };
        let words = format!("{arrow} {}", four_digits(end.1 / y.unit));
        Some(message(x.fraction(end.0), words))
    }

    /// Axes in the given ranges, or around these curves.
    fn axes(&self, curves: &[Curve]) -> (Axis, Axis) {
        let points: Points = curves.iter().flat_map(Curve::points).collect();
        // A line may end at the edges of the box, what has a width of its own may not.
        let lines = |curve: &Curve| matches!(curve.form, Form::Line(_));
        let along = if curves.iter().all(lines) {
            Axis::tight
        } else {
            Axis::around
        };
        let xs = points.iter().map(|&(x, y)| (x, self.y.shows(y)));
        let ys = points.iter().map(|&(x, y)| (y, self.x.shows(x)));
        (self.x.axis(along, xs), self.y.axis(Axis::around, ys))
    }
}

impl<'a> AxisSpec<'a> {
    /// An axis that reaches as far as the data.
    pub const fn new(label: &'a str, scale: Scale) -> Self {
        Self {
            label,
            scale,
            range: None,
            is_focused: false,
        }
    }

    /// Limits the axis to this range.
    #[must_use]
    pub const fn between(self, low: f64, high: f64) -> Self {
        Self {
            range: Some((low, high)),
            ..self
        }
    }

    /// Limits the axis; a line that leaves the range has an arrow with its largest or smallest value.
    #[must_use]
    pub const fn focused(self, low: f64, high: f64) -> Self {
        Self {
            is_focused: true,
            ..self.between(low, high)
        }
    }

    /// True if a value is in the given range, or shown by an arrow beyond it.
    fn shows(&self, value: f64) -> bool {
        self.is_focused || (self.range).is_none_or(|(low, high)| (low..=high).contains(&value))
    }

    /// The axis in the given range. Without a valid one, `automatic` makes it for the values marked as in the
    /// range of the other axis, or for all if no value is marked.
    fn axis(
        &self,
        automatic: impl Fn(&str, Scale, f64, f64) -> Axis,
        values: impl Iterator<Item = (f64, bool)> + Clone,
    ) -> Axis {
        let given = self
            .range
            .and_then(|(low, high)| Axis::between(self.label, self.scale, low, high));
        let automatic = || {
            let seen = values.clone().filter(|(_, seen)| *seen);
            let (mut low, mut high) = extremes(seen.map(|(value, _)| value));
            if low > high {
                (low, high) = extremes(values.clone().map(|(value, _)| value));
            }
            if low > high {
                (low, high) = (1.0, 10.0);
            }
            automatic(self.label, self.scale, low, high)
        };
        given.unwrap_or_else(automatic)
    }
}

impl<'a> Series<'a> {
    /// A series with a name, which may be empty, in one of the colours.
    pub fn new(name: &'a str, points: &'a [(f64, f64)], look: Look, colour: usize) -> Self {
        Self {
            name,
            points,
            look,
            colour,
        }
    }

    /// The form of its look, or of the look `further` places down the line.
    fn form(&self, further: usize, sizes: Sizes) -> Form {
        // Of which dash or shape the look begins.
        let first = match self.look {
            Look::Broad => 0,
            Look::Dotted => DOTTED_INDEX,
            Look::Crosses => Shape::CROSS_INDEX,
            Look::Line | Look::Dashed | Look::Markers | Look::OpenMarkers | Look::Area => {
                self.colour
            }
        };
        let (style, colour) = further_look(first, self.colour, further);
        let colour = series_colour(colour);
        let stroke = |dash: Dash| Stroke {
            colour,
            width: sizes.series_width,
            dash,
        };
        let markers = |size: f64, open| {
            let (shape, radius) = (Shape::of_series(style), size * sizes.marker_radius);
            let marker = Marker::new(colour, shape, radius, open);
            Form::Markers(marker)
        };
        match self.look {
            Look::Line | Look::Dotted => Form::Line(stroke(series_dash(style))),
            Look::Dashed => Form::Line(stroke(even_dash(style))),
            Look::Broad => Form::Line(Stroke {
                width: BROAD * sizes.series_width,
                ..stroke(series_dash(style))
            }),
            Look::Area => Form::Area(stroke(series_dash(style))),
            Look::Markers => markers(1.0, false),
            Look::OpenMarkers => markers(1.0, true),
            Look::Crosses => markers(CROSS, false),
        }
    }
}

/// The points between those that axes of these scales cannot show.
fn pieces(points: &[(f64, f64)], x: Scale, y: Scale) -> Vec<Points> {
    let showable = |point: &(f64, f64)| x.can_show(point.0) && y.can_show(point.1);
    (points.split(|point| !showable(point)))
        .filter(|piece| !piece.is_empty())
        .map(<[_]>::to_vec)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::INK;

    const LOOKS_OF_A_SERIES: [Look; 8] = [
        Look::Line,
        Look::Dashed,
        Look::Dotted,
        Look::Broad,
        Look::Markers,
        Look::OpenMarkers,
        Look::Crosses,
        Look::Area,
    ];

    fn charts<'a>(series: &[Series<'a>]) -> Vec<Chart<'a>> {
        let axis = AxisSpec::new("", Scale::Linear);
        let chart = |series: &[Series<'a>]| Chart {
            caption: "",
            x: axis,
            y: axis,
            series: series.to_vec(),
        };
        // On several panels: the legend is that of the page.
        series.chunks(20).map(chart).collect()
    }

    /// All that tells a form from others: its kind, colour, width or size, dash, and shape.
    fn seen(form: Form) -> String {
        match form {
            Form::Line(Stroke {
                colour,
                width,
                dash,
            }) => format!("line {colour} {width} {dash:?}"),
            Form::Area(Stroke {
                colour,
                width,
                dash,
            }) => format!("area {colour} {width} {dash:?}"),
            Form::Markers(marker) => format!("{marker:?}"),
        }
    }

    fn forms(series: &[Series<'_>]) -> Vec<Form> {
        let page = ChartPage {
            title: "",
            subtitle: "",
            columns: 1,
            charts: charts(series),
        };
        let curves = page.curves(LARGE).into_iter().flatten();
        curves.map(|curve| curve.form).collect()
    }

    #[test]
    fn no_two_names_have_the_same_colour_dash_and_marker() {
        let names: Vec<String> = (0..8 * 9 * 2).map(|n| format!("name {n}")).collect();
        let wish = |n: usize| (LOOKS_OF_A_SERIES[n % 8], n / 8 % 9);
        let series = names.iter().enumerate().map(|(n, name)| {
            let (look, colour) = wish(n);
            Series::new(name, &[], look, colour)
        });
        let mut seen: Vec<String> = forms(&series.collect::<Vec<_>>())
            .into_iter()
            .map(seen)
            .collect();
        let all = seen.len();
        seen.sort();
        seen.dedup();
        assert_eq!((seen.len(), all), (144, 144));
    }

    #[test]
    fn a_name_keeps_its_look_and_gives_way_to_those_before_it_alone() {
        let line = |name, look, colour| Series::new(name, &[], look, colour);
        let drawn = forms(&[
            line("gain +6 dB", Look::Line, 1),
            line("integer", Look::Markers, 5),
            line("", Look::Line, 1),
            line("PID", Look::Line, 1),
            line("other", Look::Markers, 5),
            line("PID", Look::Line, 1),
            line("gain +6 dB", Look::Line, 1),
            line("gain +6 dB", Look::Markers, 1),
        ]);
        assert_eq!(drawn[0], drawn[2]);
        assert_eq!((drawn[0], drawn[3]), (drawn[6], drawn[5]));
        assert!(drawn[0] != drawn[3]);
        // It keeps its colour.
        let Form::Markers(marker) = drawn[4] else {
            panic!("{:?}", drawn[4]);
        };
        assert_eq!((marker.inside, marker.shape), (Some(INK), Shape::Cross));
    }
}
