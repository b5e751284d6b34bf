//! From a drawing to files: SVG as drawn, PNG through resvg.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};

use super::FigureError;
use super::style::PNG_SCALE;
use crate::record::{Leftover, NewFile, NewFileError};

/// The font of all pictures; licence in `assets/LICENSE-DejaVuSans.txt`.
const FONT: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");
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

/// The files of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavedPicture {
    /// The drawing, to edit or to include in a paper.
    pub svg: PathBuf,
    /// The pixels, to look at.
    pub png: PathBuf,
}

impl Picture {
    pub(super) fn new(svg: String) -> Self {
        Self { svg }
    }

    /// The drawing as SVG text.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The picture as PNG bytes, two pixels for each unit of the SVG.
    ///
    /// # Errors
    /// If the drawing is not valid SVG, which would be a defect of this module.
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

    /// Writes `STEM.svg` and `STEM.png`, both or neither. Existing files are refused unless
    /// `overwrite` is set, and then replaced whole.
    ///
    /// # Errors
    /// If a file exists or cannot be written, or the picture cannot be rendered.
    pub fn save(&self, stem: &Path, overwrite: bool) -> Result<SavedPicture, FigureError> {
        let [svg, png] = ["svg", "png"].map(|extension| with_suffix(stem, extension));
        // Both are staged before either gets its name.
        let staged_svg = stage(&svg, self.svg.as_bytes(), overwrite)?;
        let staged_png = stage(&png, &self.png()?, overwrite)?;
        staged_svg.publish()?;
        staged_png.publish()?;
        Ok(SavedPicture { svg, png })
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

/// `a-0.5` and `png` to `a-0.5.png`; `Path::with_extension` would make `a-0.png` of it.
fn with_suffix(stem: &Path, extension: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

fn stage(path: &Path, bytes: &[u8], overwrite: bool) -> Result<NewFile, FigureError> {
    let (new_file, mut file) = NewFile::create(path, Leftover::Discard, overwrite)?;
    (file.write_all(bytes)).map_err(|source| NewFileError::io(path, source))?;
    Ok(new_file)
}
