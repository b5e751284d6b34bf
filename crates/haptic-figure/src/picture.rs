//! A finished drawing: SVG as drawn, PNG through resvg.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};

use crate::FigureError;
use crate::style::PNG_SCALE;

/// The font of all pictures; licence in `assets/LICENSE-DejaVuSans.txt`.
const FONT: &[u8] = include_bytes!("../assets/DejaVuSans.ttf");
const FONT_FAMILY: &str = "DejaVu Sans";

/// Only the bundled font: a picture must not depend on what a machine has installed, and a
/// family that is not found would lose its text without a word.
static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family(FONT_FAMILY);
    Arc::new(fonts)
});

/// A finished drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    svg: String,
}

impl Picture {
    pub(crate) fn new(svg: String) -> Self {
        Self { svg }
    }

    /// The drawing as SVG text.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The picture as PNG bytes, two pixels for each unit of the SVG.
    ///
    /// # Errors
    /// If the drawing is not valid SVG, which would be a defect of this crate.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let options = Options {
            font_family: FONT_FAMILY.to_owned(),
            fontdb: Arc::clone(&FONTS),
            ..Options::default()
        };
        let tree = Tree::from_str(&self.svg, &options)
            .map_err(|error| FigureError::Render(error.to_string()))?;
        let size = (tree.size().to_int_size())
            .scale_by(PNG_SCALE)
            .ok_or_else(|| FigureError::Render("its size is not positive".to_owned()))?;
        let mut pixels = Pixmap::new(size.width(), size.height())
            .ok_or_else(|| FigureError::Render("its size is not positive".to_owned()))?;
        let scale = Transform::from_scale(PNG_SCALE, PNG_SCALE);
        resvg::render(&tree, scale, &mut pixels.as_mut());
        encode(pixels, size.width(), size.height())
            .map_err(|error| FigureError::Render(error.to_string()))
    }
}

/// The pixels as PNG. `Pixmap::encode_png` would copy them all first: 10 MB of the memory of a run.
fn encode(pixels: Pixmap, width: u32, height: u32) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.take_demultiplied())?;
    writer.finish()?;
    Ok(bytes)
}
