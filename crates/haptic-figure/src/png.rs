//! The bytes of a PNG.

use png::{BitDepth, ColorType, Encoder, EncodingError};
use tiny_skia::Pixmap;

use crate::{FigureError, Picture, pixels};

/// PNG pixels per CSS pixel: 1760 pixels, 250 per inch on a page 7 inches wide.
const SCALE: u32 = 2;

impl Picture {
    /// The picture as PNG bytes, two pixels for each unit of the SVG.
    ///
    /// Text is set letter by letter in `DejaVu Sans`, with its kerning. A letter that the font does not have is an
    /// empty box, and scripts that join letters or run from right to left are for the SVG and its viewer.
    ///
    /// # Errors
    /// If the drawing cannot be turned into pixels, which would be a defect of this crate.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let pixels = pixels::paint(&self.drawing, SCALE)?;
        encode(pixels).map_err(|error| FigureError::Render(error.to_string()))
    }
}

/// The pixels as PNG. `Pixmap::encode_png` would copy them all first: 10 MB of the memory of a run.
fn encode(pixels: Pixmap) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.take_demultiplied())?;
    writer.finish()?;
    Ok(bytes)
}
