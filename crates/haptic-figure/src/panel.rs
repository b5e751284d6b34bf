//! One panel: two axes in a box, curves over a faint grid, a caption above.

use crate::axis::{Axis, Tick};
use crate::curve::{BoxEdges, Curve, Form, SAMPLE_LENGTH};
use crate::drawing::{Anchor, Item, Ruled, Text};
use crate::style::{GRID, INK, MUTED_INK, Sizes, fit, text_width};

/// Part of the space on the left that lies beside the tick labels: axis label, ticks, gaps.
const BESIDE_TICK_LABELS: f64 = 40.0;
/// Part as in [`BESIDE_TICK_LABELS`], without an axis label.
const BESIDE_BARE_TICK_LABELS: f64 = 14.0;
/// Between a vertical axis and its tick labels, and between these and the axis label.
const TICK_LABEL_GAP: f64 = 8.0;
const LABEL_GAP: f64 = 5.0;
/// Between tick labels side by side, and from one to the next on top of each other, as a share of their size.
const SIDE_GAP: f64 = 0.8;
const LINE_HEIGHT: f64 = 1.45;
/// Distance from one line of what lies beyond the axes to the next, over the size of its text.
const BEYOND_LINE: f64 = 1.5;

/// Between the end of a tick on the left and its label.
const TICK_GAP: f64 = 3.0;
/// Widths of the box with its ticks, of small ticks and of the grid.
const LINE_WIDTH: f64 = 1.2;
const SMALL_TICK_WIDTH: f64 = 0.8;
const GRID_WIDTH: f64 = 1.0;
/// Height of the font above the baseline and half the height of a digit, over its size.
const ASCENT: f64 = 0.928;
const HALF_DIGIT: f64 = 0.3645;

/// Size of a panel and place of its box, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) edges: BoxEdges,
    pub(crate) sizes: Sizes,
    /// Approximate number of points of each curve.
    pub(crate) most_points: usize,
}

/// Words about what of a curve lies beyond the axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Beyond {
    pub(crate) form: Form,
    /// Share of the horizontal axis at which it leaves the box.
    pub(crate) share: f64,
    pub(crate) words: String,
}

/// A panel of a page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Panel {
    /// Its letter, unique on the page.
    pub(crate) name: char,
    pub(crate) caption: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) curves: Vec<Curve>,
    /// Said in the middle of the box when there is no curve.
    pub(crate) note: Option<String>,
    /// Parts of the curves beyond the axes.
    pub(crate) beyond: Vec<Beyond>,
}

impl Panel {
    /// True of its letter, its number, and more than a letter with which its caption begins, all in small letters.
    pub(crate) fn is_called(&self, wanted: &str) -> bool {
        let number = u32::from(self.name) - u32::from('a') + 1;
        match wanted.chars().count() {
            0 => false,
            1 if wanted.contains(self.name) => true,
            1 => wanted == number.to_string(),
            _ => self.caption.to_lowercase().starts_with(wanted) || wanted == number.to_string(),
        }
    }

    /// Space this panel needs between its left edge and its box.
    pub(crate) fn margin_left(&self, sizes: Sizes) -> f64 {
        let widest = self.widest_y_label(sizes);
        if self.y.own_label().is_empty() {
            BESIDE_BARE_TICK_LABELS + widest
        } else {
            (BESIDE_TICK_LABELS + widest).max(sizes.left)
        }
    }

    /// Space this panel needs below its box.
    pub(crate) fn margin_bottom(&self, sizes: Sizes) -> f64 {
        if self.x.own_label().is_empty() {
            sizes.bottom_bare
        } else {
            sizes.bottom
        }
    }

    /// Gives the vertical axis its length, and ticks that have room.
    pub(crate) fn fit_y(&mut self, length: f64, sizes: Sizes) {
        self.y.fit(length, |_| LINE_HEIGHT * f64::from(sizes.tick));
    }

    /// Gives the horizontal axis its length, and ticks that have room.
    pub(crate) fn fit_x(&mut self, length: f64, sizes: Sizes) {
        let gap = SIDE_GAP * f64::from(sizes.tick);
        (self.x).fit(length, |label| text_width(label, sizes.tick) + gap);
    }

    /// The panel, with its upper left corner at the origin.
    pub(crate) fn draw(&self, frame: Frame, heading: &str, heading_size: u32) -> Vec<Item> {
        let (x_ticks, y_ticks) = (self.x.ticks(), self.y.ticks());
        let edges = frame.edges;
        let mut items = vec![grid(edges, &x_ticks, &y_ticks)];
        items.extend([false, true].map(|is_small| ticks(frame, &x_ticks, &y_ticks, is_small)));
        items.extend(tick_labels(frame, &x_ticks, &y_ticks).map(Item::Text));
        items.append(&mut self.draw_curves(frame));
        items.append(&mut self.draw_beyond(frame));
        items.extend(self.axis_labels(frame).map(Item::Text));
        if !heading.is_empty() {
            let y = edges.top - 11.0;
            items.push(Item::Text(Text::new(heading, edges.left, y, heading_size)));
        }
        if let Some(note) = &self.note {
            let (note, size) = fit(note, frame.sizes.label, edges.right - edges.left);
            let (x, y) = edges.middle();
            items.push(Item::Text(Text {
                colour: MUTED_INK,
                ..Text::new(&note, x, y, size).anchored(Anchor::Middle)
            }));
        }
        items
    }

    /// Areas and lines, cut off at the box, and markers on top.
    fn draw_curves(&self, frame: Frame) -> Vec<Item> {
        let (edges, most) = (frame.edges, frame.most_points);
        let (mut fills, mut lines, mut markers) = (Vec::new(), Vec::new(), Vec::new());
        for curve in &self.curves {
            let mut drawn = curve.draw(&self.x, &self.y, edges, most);
            fills.append(&mut drawn.fills);
            lines.append(&mut drawn.lines);
            markers.append(&mut drawn.markers);
        }
        fills.append(&mut lines);
        let boxed = Item::Boxed {
            name: self.name,
            edges: edges.rectangle(),
            items: fills,
        };
        [vec![boxed], markers].concat()
    }

    /// A line of words for each curve that leaves the box, from where it does so.
    fn draw_beyond(&self, frame: Frame) -> Vec<Item> {
        let (edges, size) = (frame.edges, frame.sizes.tick);
        let mut items = Vec::new();
        for (line, beyond) in (1..).zip(&self.beyond) {
            let y = edges.top + BEYOND_LINE * f64::from(line) * f64::from(size);
            let width = SAMPLE_LENGTH + 2.0 * TICK_LABEL_GAP + text_width(&beyond.words, size);
            let x = edges.x(beyond.share).min(edges.right - width) + TICK_LABEL_GAP;
            let x = x.max(edges.left + TICK_LABEL_GAP);
            items.append(&mut beyond.form.sample(x, y - HALF_DIGIT * f64::from(size)));
            let x = x + SAMPLE_LENGTH + LABEL_GAP;
            items.push(Item::Text(Text::new(&beyond.words, x, y, size)));
        }
        items
    }

    /// The labels of both axes that have one.
    fn axis_labels(&self, frame: Frame) -> impl Iterator<Item = Text> {
        let (edges, sizes) = (frame.edges, frame.sizes);
        let (x, y) = edges.middle();
        let below = (!self.x.own_label().is_empty()).then(|| {
            let (label, size) = fit(self.x.own_label(), sizes.label, frame.width);
            let y = frame.height - 0.5 * f64::from(size);
            Text::new(&label, x, y, size).anchored(Anchor::Middle)
        });
        let name = (!self.y.own_label().is_empty()).then(|| {
            let (label, size) = fit(self.y.own_label(), sizes.label, frame.height);
            let widest = (self.widest_y_label(sizes)).max(2.0 * f64::from(sizes.tick));
            let half = 0.5 * f64::from(size);
            let x = (edges.left - TICK_LABEL_GAP - widest - LABEL_GAP - half).max(half + 8.0);
            Text {
                upright: true,
                ..Text::new(&label, x, y, size).anchored(Anchor::Middle)
            }
        });
        below.into_iter().chain(name)
    }

    fn widest_y_label(&self, sizes: Sizes) -> f64 {
        let labels = self.y.labels().into_iter();
        let widths = labels.map(|(_, label)| text_width(&label, sizes.tick));
        widths.fold(0.0, f64::max)
    }
}

/// A faint line at each large tick that is not on the border.
fn grid(edges: BoxEdges, x_ticks: &[Tick], y_ticks: &[Tick]) -> Item {
    let mut grid = Ruled::new(GRID, GRID_WIDTH);
    for x in shares(x_ticks, false).map(|share| edges.x(share)) {
        if x - edges.left >= 1.0 && edges.right - x >= 1.0 {
            grid.line((x, edges.top), (x, edges.bottom));
        }
    }
    for y in shares(y_ticks, false).map(|share| edges.y(share)) {
        if y - edges.top >= 1.0 && edges.bottom - y >= 1.0 {
            grid.line((edges.left, y), (edges.right, y));
        }
    }
    Item::Ruled(grid)
}

/// The box with its large ticks, or the small ticks, inwards from all four sides.
fn ticks(frame: Frame, x_ticks: &[Tick], y_ticks: &[Tick], is_small: bool) -> Item {
    let edges = frame.edges;
    let (length, width) = if is_small {
        (frame.sizes.minor_tick_length, SMALL_TICK_WIDTH)
    } else {
        (frame.sizes.tick_length, LINE_WIDTH)
    };
    let mut ruled = Ruled::new(INK, width);
    ruled.border = (!is_small).then(|| edges.rectangle());
    for x in shares(x_ticks, is_small).map(|share| edges.x(share)) {
        ruled.line((x, edges.bottom), (x, edges.bottom - length));
        ruled.line((x, edges.top), (x, edges.top + length));
    }
    for y in shares(y_ticks, is_small).map(|share| edges.y(share)) {
        ruled.line((edges.left, y), (edges.left + length, y));
        ruled.line((edges.right, y), (edges.right - length, y));
    }
    Item::Ruled(ruled)
}

/// The small or the large ticks as shares of the axis.
fn shares(ticks: &[Tick], is_small: bool) -> impl Iterator<Item = f64> {
    let ticks = ticks.iter().filter(move |tick| tick.is_small == is_small);
    ticks.map(|tick| tick.fraction)
}

/// Labels below the box and on its left.
fn tick_labels(frame: Frame, x_ticks: &[Tick], y_ticks: &[Tick]) -> impl Iterator<Item = Text> {
    let (edges, size) = (frame.edges, frame.sizes.tick);
    let bottom = edges.bottom + frame.sizes.tick_length + ASCENT * f64::from(size);
    let left = edges.left - frame.sizes.tick_length - TICK_GAP;
    let below = x_ticks.iter().filter_map(move |tick| {
        let text = Text::new(tick.label.as_ref()?, edges.x(tick.fraction), bottom, size);
        Some(text.anchored(Anchor::Middle))
    });
    let labels = y_ticks.iter().filter_map(move |tick| {
        let y = edges.y(tick.fraction) + HALF_DIGIT * f64::from(size);
        Some(Text::new(tick.label.as_ref()?, left, y, size).anchored(Anchor::End))
    });
    below.chain(labels)
}
