//! A finished picture.

#[cfg(feature = "png")]
use crate::drawing::Drawing;
use crate::page::Page;
use crate::{FigureError, Sheet, svg};

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
    /// Drawing of the SVG, for pixels.
    #[cfg(feature = "png")]
    pub(crate) drawing: Drawing,
    page: Page,
}

impl Picture {
    pub(crate) fn of(mut page: Page) -> Result<Self, FigureError> {
        let drawing = page.draw();
        Ok(Self {
            svg: svg::write(&drawing)?,
            #[cfg(feature = "png")]
            drawing,
            page,
        })
    }

    /// Lays the picture out again for a printed sheet.
    ///
    /// # Errors
    /// If it cannot have this width, or has no such panel.
    pub fn on(self, sheet: &Sheet) -> Result<Self, FigureError> {
        if *sheet == Sheet::default() {
            return Ok(self);
        }
        Self::of(self.page.on(sheet)?)
    }

    /// The drawing as SVG text; lengths in it are CSS pixels, 96 to the inch.
    pub fn svg(&self) -> &str {
        &self.svg
    }
}
