//! Shared by the tests of pictures: the texts as the renderer sets them.

use std::sync::Arc;

use haptic_figure::Picture;
use resvg::usvg::{Group, Node, Options, Tree, fontdb::Database};

/// All texts of a picture with their boxes, as the renderer sets them.
pub(crate) fn texts(picture: &Picture) -> (Tree, Vec<(String, [f32; 4])>) {
    let mut fonts = Database::new();
    fonts.load_font_data(include_bytes!("../../assets/DejaVuSans.ttf").to_vec());
    let options = Options {
        fontdb: Arc::new(fonts),
        font_family: "DejaVu Sans".to_owned(),
        ..Options::default()
    };
    let tree = Tree::from_str(picture.svg(), &options).expect("is SVG");
    fn collect(group: &Group, found: &mut Vec<(String, [f32; 4])>) {
        for node in group.children() {
            match node {
                Node::Group(group) => collect(group, found),
                Node::Text(text) => {
                    let content = text.chunks().iter().map(|chunk| chunk.text()).collect();
                    let bounds = text.abs_bounding_box();
                    let [left, top] = [bounds.left(), bounds.top()];
                    found.push((content, [left, top, bounds.right(), bounds.bottom()]));
                }
                _ => {}
            }
        }
    }
    let mut found = Vec::new();
    collect(tree.root(), &mut found);
    (tree, found)
}

/// Checks what holds of every picture.
pub(crate) fn assert_sound(picture: &Picture, name: &str, most_bytes: usize) {
    let svg = picture.svg();
    for word in ["NaN", "inf"] {
        assert!(!svg.contains(word), "{name}: `{word}` in the SVG");
    }
    assert!(svg.len() < most_bytes, "{name}: {} bytes", svg.len());
    let (tree, texts) = texts(picture);
    assert!(texts.len() > 10, "{name}: {} texts", texts.len());
    let (width, height) = (tree.size().width(), tree.size().height());
    for (text, [left, top, right, bottom]) in texts {
        assert!(
            left >= 0.0 && top >= 0.0 && right <= width && bottom <= height,
            "{name}: `{text}` is cut off at the edge of the page"
        );
    }
}
