//! A page of charts that own their curves.

use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

pub(crate) type Points = Vec<(f64, f64)>;

/// An axis in equal steps.
pub(crate) fn linear(label: &str) -> AxisSpec<'_> {
    AxisSpec::new(label, Scale::Linear)
}

/// An axis in powers of ten.
pub(crate) fn logarithmic(label: &str) -> AxisSpec<'_> {
    AxisSpec::new(label, Scale::Log)
}

/// A chart and its curves: name, points, look, and number of a colour.
pub(crate) struct Panel<'a> {
    caption: String,
    x: AxisSpec<'a>,
    y: AxisSpec<'a>,
    curves: Vec<(String, Points, Look, usize)>,
}

impl<'a> Panel<'a> {
    pub(crate) fn new(caption: impl Into<String>, x: AxisSpec<'a>, y: AxisSpec<'a>) -> Self {
        Self {
            caption: caption.into(),
            x,
            y,
            curves: Vec::new(),
        }
    }

    /// The same with one more curve, unless it has no points.
    pub(crate) fn with(
        mut self,
        name: impl Into<String>,
        look: Look,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points: Points = points.into_iter().collect();
        if !points.is_empty() {
            self.curves.push((name.into(), points, look, colour));
        }
        self
    }

    fn chart(&self) -> Chart<'_> {
        let curves = self.curves.iter();
        let series =
            curves.map(|(name, points, look, colour)| Series::new(name, points, *look, *colour));
        Chart {
            caption: &self.caption,
            x: self.x,
            y: self.y,
            series: series.collect(),
        }
    }
}

/// Draws panels in so many columns.
pub(crate) fn page(
    title: &str,
    subtitle: &str,
    columns: usize,
    panels: &[Panel<'_>],
) -> Result<Picture, FigureError> {
    ChartPage {
        title,
        subtitle,
        columns,
        charts: panels.iter().map(Panel::chart).collect(),
    }
    .draw()
}
