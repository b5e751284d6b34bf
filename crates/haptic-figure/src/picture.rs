//! A finished picture.

use crate::drawing::Drawing;
use crate::{FigureError, svg};

/// A finished picture: an SVG. Two pictures are equal if their SVGs are.
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
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    svg: String,
    /// What the SVG says, for pixels.
    #[cfg(feature = "png")]
    pub(crate) drawing: Drawing,
}

impl Picture {
    pub(crate) fn new(drawing: Drawing) -> Result<Self, FigureError> {
        Ok(Self {
            svg: svg::write(&drawing)?,
            #[cfg(feature = "png")]
            drawing,
        })
    }

    /// The drawing as SVG text; lengths in it are CSS pixels, 96 to the inch.
    pub fn svg(&self) -> &str {
        &self.svg
    }
}
