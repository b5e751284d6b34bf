//! SVG text as resvg renders it, with the font of the pictures alone.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Group, Node, Options, Tree, fontdb::Database};
use std::sync::Arc;

/// Pixels per CSS pixel.
const SCALE: f32 = 2.0;
const FONT: &[u8] = include_bytes!("../../../crates/haptic-figure/assets/DejaVuSans.ttf");

pub(crate) fn fonts() -> Arc<Database> {
    let mut fonts = Database::new();
    fonts.load_font_data(FONT.to_vec());
    Arc::new(fonts)
}

fn tree(svg: &str, fonts: &Arc<Database>) -> Tree {
    let options = Options {
        font_family: "DejaVu Sans".to_owned(),
        fontdb: Arc::clone(fonts),
        ..Options::default()
    };
    Tree::from_str(svg, &options).expect("is SVG")
}

/// The bytes of a PNG.
pub(crate) fn png(svg: &str, fonts: &Arc<Database>) -> Vec<u8> {
    let tree = tree(svg, fonts);
    let size = (tree.size().to_int_size().scale_by(SCALE)).expect("has a size");
    let mut pixels = Pixmap::new(size.width(), size.height()).expect("has a size");
    let scale = Transform::from_scale(SCALE, SCALE);
    resvg::render(&tree, scale, &mut pixels.as_mut());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.width(), size.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("writes");
    let pixels = pixels.take_demultiplied();
    writer.write_image_data(&pixels).expect("writes");
    writer.finish().expect("writes");
    bytes
}

/// The boxes of all texts: left, top, right, bottom, CSS px.
pub(crate) fn texts(svg: &str, fonts: &Arc<Database>) -> Vec<[f32; 4]> {
    fn collect(group: &Group, found: &mut Vec<[f32; 4]>) {
        for node in group.children() {
            match node {
                Node::Group(group) => collect(group, found),
                Node::Text(text) => {
                    let bounds = text.abs_bounding_box();
                    found.push([bounds.left(), bounds.top(), bounds.right(), bounds.bottom()]);
                }
                _ => {}
            }
        }
    }
    let mut found = Vec::new();
    collect(tree(svg, fonts).root(), &mut found);
    found
}
