//! The pixels of a picture, through resvg.

use std::sync::{Arc, LazyLock};

use png::{BitDepth, ColorType, Encoder, EncodingError};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};

use crate::{FigureError, Picture};

/// PNG pixels per CSS pixel: 1760 pixels, 250 per inch on a page 7 inches wide.
const PIXELS: f32 = 2.0;
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

impl Picture {
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
        let tree = Tree::from_str(self.svg(), &options)
            .map_err(|error| FigureError::Render(error.to_string()))?;
        let size = (tree.size().to_int_size())
            .scale_by(PIXELS)
            .ok_or_else(|| FigureError::Render("its size is not positive".to_owned()))?;
        let mut pixels = Pixmap::new(size.width(), size.height())
            .ok_or_else(|| FigureError::Render("its size is not positive".to_owned()))?;
        let scale = Transform::from_scale(PIXELS, PIXELS);
        resvg::render(&tree, scale, &mut pixels.as_mut());
        encode(pixels, size.width(), size.height())
            .map_err(|error| FigureError::Render(error.to_string()))
    }
}

/// The pixels as PNG. `Pixmap::encode_png` would copy them all first: 10 MB of the memory of a run.
fn encode(pixels: Pixmap, width: u32, height: u32) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.take_demultiplied())?;
    writer.finish()?;
    Ok(bytes)
}
