//! A figure of the dissertation as data: panels of curves, each quantity with its unit, and what becomes of
//! them on paper and in a table.

use haptic_analysis::AnalysisError;
use haptic_experiment::Failure;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) name: String,
    /// Name for the legend; empty for none.
    pub(crate) legend: String,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) look: Look,
    pub(crate) colour: usize,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) spec: AxisSpec<'static>,
    /// Its column in the data, with the unit.
    pub(crate) column: &'static str,
}

impl Axis {
    pub(super) const fn new(label: &'static str, scale: Scale, column: &'static str) -> Self {
        let spec = AxisSpec::new(label, scale);
        Self { spec, column }
    }

    pub(super) const fn linear(label: &'static str, column: &'static str) -> Self {
        Self::new(label, Scale::Linear, column)
    }

    pub(super) const fn log(label: &'static str, column: &'static str) -> Self {
        Self::new(label, Scale::Log, column)
    }

    pub(super) const fn between(self, low: f64, high: f64) -> Self {
        let spec = self.spec.between(low, high);
        Self { spec, ..self }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub(crate) caption: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) curves: Vec<Curve>,
    /// Shows curves of an earlier panel on other axes, so the data leave them out.
    pub(crate) repeats: bool,
}

/// A figure of the dissertation, made again.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The number that the dissertation gives it.
    pub id: &'static str,
    /// Content of the figure, as its title.
    pub title: &'static str,
    /// Parameters, and which of them are our choice; a line break where the picture has one.
    pub conditions: String,
    pub(crate) columns: usize,
    pub(crate) panels: Vec<Panel>,
}

impl Curve {
    pub(super) fn new(
        name: impl Into<String>,
        points: Vec<(f64, f64)>,
        look: Look,
        colour: usize,
    ) -> Self {
        let name = name.into();
        Self {
            legend: name.clone(),
            name,
            points,
            look,
            colour,
        }
    }
}

impl Panel {
    pub(super) fn new(caption: impl Into<String>, x: Axis, y: Axis, curves: Vec<Curve>) -> Self {
        Self {
            caption: caption.into(),
            x,
            y,
            curves,
            repeats: false,
        }
    }
}

impl Figure {
    /// The picture.
    ///
    /// # Errors
    /// If no curve has a point.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        fn series(curve: &Curve) -> Series<'_> {
            Series::new(&curve.legend, &curve.points, curve.look, curve.colour)
        }
        let charts = self.panels.iter().map(|panel| Chart {
            caption: &panel.caption,
            x: panel.x.spec,
            y: panel.y.spec,
            series: panel.curves.iter().map(series).collect(),
        });
        ChartPage {
            title: &format!("Figure {}: {}", self.id, self.title),
            subtitle: &self.conditions,
            columns: self.columns,
            charts: charts.collect(),
        }
        .draw()
    }

    /// The names of the data's columns: panel, curve, and each quantity of the axes with its unit.
    #[must_use]
    pub fn columns(&self) -> Vec<&'static str> {
        let mut columns = vec!["panel", "curve"];
        for axis in [|panel: &Panel| panel.x, |panel: &Panel| panel.y] {
            for column in self.panels.iter().map(|panel| axis(panel).column) {
                if !columns.contains(&column) {
                    columns.push(column);
                }
            }
        }
        columns
    }

    /// The data: panel, curve, and the quantities in the order of [`columns`](Self::columns), empty where a panel
    /// does not have them.
    pub fn rows(&self) -> impl Iterator<Item = (&str, &str, Vec<Option<f64>>)> {
        let columns = self.columns();
        let panels = self.panels.iter().filter(|panel| !panel.repeats);
        panels.flat_map(move |panel| {
            let columns = columns.clone();
            panel.curves.iter().flat_map(move |curve| {
                let columns = columns.clone();
                curve.points.iter().map(move |&(x, y)| {
                    let cell = |column: &&str| match *column {
                        column if column == panel.x.column => Some(x),
                        // Not −0.
                        column if column == panel.y.column => Some(y + 0.0),
                        _ => None,
                    };
                    let cells = columns[2..].iter().map(cell).collect();
                    (panel.caption.as_str(), curve.name.as_str(), cells)
                })
            })
        })
    }
}

/// A refusal of the analysis, which constants should not meet.
pub(super) fn refused(error: AnalysisError) -> Failure {
    Failure::run(error)
}

/// `count` values from `low` to `high` in equal steps of their logarithm.
pub(super) fn logarithmic(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    let ratio = libm::log(high / low) / f64::from(count - 1);
    (0..count).map(move |i| low * libm::exp(ratio * f64::from(i)))
}

/// One curve an order, in looks of their own from the `first` on.
pub(super) fn per_order(
    orders: &[f64],
    first: usize,
    look: Look,
    points: impl Fn(f64) -> Result<Vec<(f64, f64)>, AnalysisError>,
) -> Result<Vec<Curve>, Failure> {
    let curve = |(colour, &mu): (usize, &f64)| {
        let points = points(mu).map_err(refused)?;
        Ok(Curve::new(format!("μ = {mu}"), points, look, colour))
    };
    (first..).zip(orders).map(curve).collect()
}

/// Gives the panels the same axes, from 0 to a little beyond the largest value on any of them.
pub(super) fn share_axes(panels: &mut [Panel]) {
    const ROOM: f64 = 1.05;
    let curves = panels.iter().flat_map(|panel| &panel.curves);
    let points: Vec<(f64, f64)> = curves.flat_map(|curve| curve.points.clone()).collect();
    let x = points.iter().map(|point| point.0).fold(0.0, f64::max);
    let y = points.iter().map(|point| point.1).fold(0.0, f64::max);
    for panel in panels {
        panel.x = panel.x.between(0.0, ROOM * x);
        panel.y = panel.y.between(0.0, ROOM * y);
    }
}
