//! Two images of one picture: which pixels differ, and how far texts are apart.

use crate::Image;

/// A difference of a pixel that is seen.
pub(crate) const SEEN: u8 = 32;
/// Around the box of a text, pixels: its letters may reach out of it.
const AROUND: f32 = 2.0;

pub(crate) struct Difference {
    pub(crate) pixels: usize,
    /// Share of the pixels that differ by more than [`SEEN`]: of all, and of those that are not paper in both.
    pub(crate) share: f64,
    pub(crate) share_of_ink: f64,
    pub(crate) worst: u8,
    /// Largest distance between the middles of the ink of a text, of its left half or of its right, CSS px.
    pub(crate) shift: f64,
}

impl Difference {
    /// `texts` are boxes on the page: left, top, right, bottom, CSS px.
    pub(crate) fn between(ours: &Image, theirs: &Image, texts: &[[f32; 4]]) -> Self {
        assert_eq!((ours.width, ours.height), (theirs.width, theirs.height));
        let pairs = || ours.colours.iter().zip(&theirs.colours);
        let apart = |(a, b): (&[u8; 3], &[u8; 3])| {
            let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
            differences.max().unwrap_or(0)
        };
        let seen = pairs().map(apart).filter(|apart| *apart > SEEN).count();
        let ink = pairs().filter(|(a, b)| a != b || **a != [0; 3]).count();
        let shift = texts.iter().flat_map(|edges| parts(*edges));
        let shift = shift.map(|part| match (middle(ours, part), middle(theirs, part)) {
            (Some(a), Some(b)) => f64::hypot(a.0 - b.0, a.1 - b.1) / 2.0,
            (None, None) => 0.0,
            // One of them is not there.
            _ => f64::INFINITY,
        });
        Self {
            pixels: ours.colours.len(),
            share: seen as f64 / ours.colours.len() as f64,
            share_of_ink: seen as f64 / ink.max(1) as f64,
            worst: pairs().map(apart).max().unwrap_or(0),
            shift: shift.fold(0.0, f64::max),
        }
    }
}

/// A box and its halves along the longer side, pixels.
fn parts([left, top, right, bottom]: [f32; 4]) -> [[f32; 4]; 3] {
    let whole = [
        2.0 * left - AROUND,
        2.0 * top - AROUND,
        2.0 * right + AROUND,
        2.0 * bottom + AROUND,
    ];
    let (x, y) = ((whole[0] + whole[2]) / 2.0, (whole[1] + whole[3]) / 2.0);
    let (mut first, mut second) = (whole, whole);
    if right - left > bottom - top {
        (first[2], second[0]) = (x, x);
    } else {
        (first[3], second[1]) = (y, y);
    }
    [whole, first, second]
}

/// The middle of the ink in a box, pixels.
fn middle(image: &Image, [left, top, right, bottom]: [f32; 4]) -> Option<(f64, f64)> {
    let columns = left.max(0.0) as usize..(right as usize).min(image.width);
    let rows = top.max(0.0) as usize..(bottom as usize).min(image.height);
    let (mut ink, mut x, mut y) = (0.0, 0.0, 0.0);
    for row in rows {
        for column in columns.clone() {
            let colours = image.colours[row * image.width + column];
            let dark: f64 = colours.into_iter().map(f64::from).sum();
            ink += dark;
            x += dark * column as f64;
            y += dark * row as f64;
        }
    }
    (ink > 0.0).then(|| (x / ink, y / ink))
}
