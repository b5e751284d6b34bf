//! Charts of any quantities: named series on up to 26 panels under one legend.

use crate::axis::{Axis, Scale, extremes};
use crate::curve::{Curve, Form};
use crate::drawing::Shape;
use crate::page::{LegendEntry, Page, Row};
use crate::panel::Panel;
use crate::style::{
    DASHED, DOTTED, Dash, LARGE, PAGE_EDGE, PAGE_WIDTH, SMALL, Sizes, Stroke, series_colour,
    series_dash, text_width,
};
use crate::thin::Points;
use crate::{FigureError, Picture};

/// The panels of a page are lettered (a) to (z).
const MOST_PANELS: usize = 26;
/// More columns would leave no room for the boxes.
const MOST_COLUMNS: usize = 5;
/// Height of the boxes of a page with so many columns, px; their widths are about 760, 330, 200, 150 and 110.
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
    /// Linear or logarithmic.
    pub scale: Scale,
    /// The ends; without them, or with ends that such an axis cannot have, those of the data.
    pub range: Option<(f64, f64)>,
}

/// The look of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line in the dash of its colour, which is solid for colour 0: series of different colours are told apart without colours too.
    Line,
    /// A dashed line in any colour.
    Dashed,
    /// A dotted line in any colour.
    Dotted,
    /// A broad solid line in any colour, for others to lie on: where they agree, it is seen beneath them.
    Broad,
    /// A marker at each point, in the shape of its colour.
    Markers,
    /// The same, but a marker that would cover part of an earlier one of the panel is left out.
    MarkersApart,
    /// A cross at each point in any colour, larger than a marker: it looks out from behind one of a later series.
    Crosses,
    /// A polygon, closed and lightly filled, outlined as [`Look::Line`]. A point that is not
    /// finite ends one polygon and begins the next one; a polygon within another is a hole.
    Area,
}

/// A named row of points. A line has a gap where a point is not finite, or not positive on a logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<'a> {
    /// Name in the legend; an empty one is not there. Series of one name, on one panel or on several, share one entry.
    pub name: &'a str,
    /// The points in the order in which they are joined.
    pub points: &'a [(f64, f64)],
    /// Their look.
    pub look: Look,
    /// Number of its colour, of those of Okabe and Ito: 0 blue, 1 vermilion, 2 green, 3 orange, 4 purple,
    /// 5 black, 6 light blue; further ones repeat these in other dashes and shapes.
    pub colour: usize,
}

/// One panel of a page; of its series the first lies beneath, and markers lie on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart<'a> {
    /// Said above the box; may be empty.
    pub caption: &'a str,
    /// Horizontal axis.
    pub x: AxisSpec<'a>,
    /// Vertical axis.
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
    /// The conditions, below it; a line break begins a further line.
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
        let mut panels: Vec<Panel> = (('a'..='z').zip(&self.charts))
            .map(|(name, chart)| chart.panel(name, sizes, &self.charts))
            .collect();
        let mut curves = panels.iter().flat_map(|panel| &panel.curves);
        if curves.all(|curve| curve.points().next().is_none()) {
            let series = self.charts.iter().flat_map(|chart| &chart.series);
            return Err(FigureError::Empty {
                what: "series",
                samples: series.map(|series| series.points.len()).sum(),
            });
        }
        let (x_label, y_label) = share_labels(&mut panels, columns, sizes);
        let mut rows = Vec::new();
        while !panels.is_empty() {
            let rest = panels.split_off(columns.min(panels.len()));
            let margins = panels.iter().map(|panel| panel.margin_bottom(sizes));
            let margin = margins.fold(0.0, f64::max);
            rows.push(Row {
                height: sizes.top + BOX_HEIGHTS[columns - 1] + margin,
                columns,
                panels,
            });
            panels = rest;
        }
        let page = Page {
            title: self.title.to_owned(),
            subtitle: self.subtitle.to_owned(),
            legend: self.legend(sizes),
            sizes,
            rows,
            x_label,
            y_label,
        };
        page.draw()
    }

    /// Each name once, in the order of the series, with all that it stands for.
    fn legend(&self, sizes: Sizes) -> Vec<LegendEntry> {
        let mut legend: Vec<LegendEntry> = Vec::new();
        for series in self.charts.iter().flat_map(|chart| &chart.series) {
            let form = series.form(sizes);
            match legend.iter_mut().find(|entry| entry.name == series.name) {
                _ if series.name.is_empty() => {}
                Some(entry) if entry.forms.contains(&form) => {}
                Some(entry) => entry.forms.push(form),
                None => legend.push(LegendEntry::new(series.name, form)),
            }
        }
        legend
    }
}

impl Chart<'_> {
    /// The panel of this chart, which is one of `all`.
    fn panel(&self, name: char, sizes: Sizes, all: &[Chart<'_>]) -> Panel {
        let curves = self.curves(sizes);
        let points: Points = curves.iter().flat_map(Curve::points).collect();
        let (x, y) = if points.is_empty() {
            // The axes of panels of the same quantities, so that it is clear what is empty.
            let like = |chart: &&Chart<'_>| (chart.x, chart.y) == (self.x, self.y);
            let curves = all
                .iter()
                .filter(like)
                .flat_map(|chart| chart.curves(sizes));
            self.axes(&curves.collect::<Vec<Curve>>())
        } else {
            self.axes(&curves)
        };
        let note = match curves.iter().any(|curve| curve.is_within(&x, &y)) {
            true => None,
            false if points.is_empty() => Some(EMPTY.to_owned()),
            false => Some(OUTSIDE.to_owned()),
        };
        Panel {
            name,
            caption: self.caption.to_owned(),
            x,
            y,
            curves,
            note,
        }
    }

    fn curves(&self, sizes: Sizes) -> Vec<Curve> {
        let scales = (self.x.scale, self.y.scale);
        let curve = |series: &Series<'_>| Curve {
            pieces: pieces(series.points, scales),
            form: series.form(sizes),
        };
        self.series.iter().map(curve).collect()
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
    pub fn new(label: &'a str, scale: Scale) -> Self {
        Self {
            label,
            scale,
            range: None,
        }
    }

    /// The same axis between these ends.
    #[must_use]
    pub fn between(self, low: f64, high: f64) -> Self {
        Self {
            range: Some((low, high)),
            ..self
        }
    }

    /// True if a value is in the given range.
    fn shows(&self, value: f64) -> bool {
        self.range
            .is_none_or(|(low, high)| (low..=high).contains(&value))
    }

    /// The axis in the given range or, if that is none, made by `automatic` for the values: for
    /// those marked as in the range of the other axis, if there are any.
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

    fn form(&self, sizes: Sizes) -> Form {
        let colour = series_colour(self.colour);
        let stroke = |dash: Dash| Stroke {
            colour,
            width: sizes.series_width,
            dash,
        };
        let markers = |shape, size, apart| Form::Markers {
            colour,
            shape,
            radius: size * sizes.marker_radius,
            apart,
        };
        match self.look {
            Look::Line => Form::Line(stroke(series_dash(self.colour))),
            Look::Dashed => Form::Line(stroke(DASHED)),
            Look::Dotted => Form::Line(stroke(DOTTED)),
            Look::Broad => Form::Line(Stroke {
                width: BROAD * sizes.series_width,
                ..stroke(None)
            }),
            Look::Area => Form::Area(stroke(series_dash(self.colour))),
            Look::Markers => markers(Shape::of_series(self.colour), 1.0, false),
            Look::MarkersApart => markers(Shape::of_series(self.colour), 1.0, true),
            Look::Crosses => markers(Shape::Cross, CROSS, false),
        }
    }
}

/// The points between those that axes of these scales cannot show.
fn pieces(points: &[(f64, f64)], (x, y): (Scale, Scale)) -> Vec<Points> {
    let showable = |point: &(f64, f64)| x.can_show(point.0) && y.can_show(point.1);
    (points.split(|point| !showable(point)))
        .filter(|piece| !piece.is_empty())
        .map(<[_]>::to_vec)
        .collect()
}

/// Leaves a label that all panels of a row or column share to the outer one alone. If all panels
/// share it and it is too long for one of them it goes to the page and is returned.
fn share_labels(panels: &mut [Panel], columns: usize, sizes: Sizes) -> (String, String) {
    let (mut x_label, mut y_label) = (String::new(), String::new());
    let Some(first) = panels.first() else {
        return (x_label, y_label);
    };
    let (x, y) = (first.x.label.clone(), first.y.label.clone());
    let width = (PAGE_WIDTH - 2.0 * PAGE_EDGE) / columns as f64;
    let height = BOX_HEIGHTS[columns - 1] + sizes.top;
    let all =
        |same: fn(&Panel) -> &str, label: &str| panels.iter().all(|panel| same(panel) == label);
    let is_long =
        |label: &str, room: f64| panels.len() > 1 && text_width(label, sizes.label) > room;
    if all(|panel| &panel.x.label, &x) && is_long(&x, width) {
        x_label = x;
    }
    if all(|panel| &panel.y.label, &y) && is_long(&y, height) {
        y_label = y;
    }
    for column in 0..columns {
        let below = |panel: &Panel| panel.x.label.clone();
        let labels: Vec<String> = panels
            .iter()
            .skip(column)
            .step_by(columns)
            .map(below)
            .collect();
        let shared = labels.windows(2).all(|pair| pair[0] == pair[1]);
        let last = labels.len() - 1;
        for (row, panel) in panels.iter_mut().skip(column).step_by(columns).enumerate() {
            if !x_label.is_empty() || (shared && row < last) {
                panel.x.label.clear();
            }
        }
    }
    for row in panels.chunks_mut(columns) {
        let shared = row
            .windows(2)
            .all(|pair| pair[0].y.label == pair[1].y.label);
        for (column, panel) in row.iter_mut().enumerate() {
            if !y_label.is_empty() || (shared && column > 0) {
                panel.y.label.clear();
            }
        }
    }
    (x_label, y_label)
}
