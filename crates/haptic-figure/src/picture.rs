//! A finished drawing.

/// A finished drawing: an SVG.
///
/// ```
/// use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Scale, Series};
///
/// let spring = [(0.0, 0.0), (2.0, 1.0)];
/// let page = ChartPage {
///     title: "A spring of 500 N/m",
///     subtitle: "",
///     columns: 1,
///     charts: vec![Chart {
///         caption: "",
///         x: AxisSpec::new("depth / mm", Scale::Linear),
///         y: AxisSpec::new("force / N", Scale::Linear),
///         series: vec![Series::new("spring", &spring, Look::Line, 0)],
///     }],
/// };
/// let picture = page.draw()?;
/// assert!(picture.svg().starts_with("<svg "));
/// // With the feature `png`, `picture.png()?` has the bytes of a PNG.
/// # Ok::<(), haptic_figure::FigureError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    svg: String,
}

impl Picture {
    pub(crate) fn new(svg: String) -> Self {
        Self { svg }
    }

    /// The drawing as SVG text; lengths in it are CSS pixels, 96 to the inch.
    pub fn svg(&self) -> &str {
        &self.svg
    }
}
