//! One panel: two axes in a box, curves over a faint grid, a caption above.

use kuva::plot::LinePlot;
use kuva::render::layout::{AxisLine, Layout, TickAlign, TickPos};
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};

use super::axis::Axis;
use super::curve::{BoxEdges, Curve};
use super::style::{self, INK, MUTED_INK, Sizes, fit, text_width};

/// Of the space on the left, what lies beside the tick labels: axis label, ticks, gaps.
const BESIDE_TICK_LABELS: f64 = 40.0;
/// The same without an axis label.
const BESIDE_BARE_TICK_LABELS: f64 = 14.0;
/// Between a vertical axis and its tick labels, and between these and the axis label.
const TICK_LABEL_GAP: f64 = 8.0;
const LABEL_GAP: f64 = 5.0;
/// Between tick labels side by side, and from one to the next on top of each other, as a share of
/// their size.
const SIDE_GAP: f64 = 0.8;
const LINE_HEIGHT: f64 = 1.45;

const LINE_WIDTH: f64 = 1.2;
/// Height of the font above the baseline and half the height of a digit, over its size: where
/// kuva puts tick labels.
const ASCENT: f64 = 0.93;
const HALF_DIGIT: f64 = 0.36;

/// Where a panel and its box lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) edges: BoxEdges,
    pub(super) sizes: Sizes,
    /// Each curve has about so many points.
    pub(super) most_points: usize,
}

/// A panel of a page.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Panel {
    /// Its letter, unique on the page.
    pub(super) name: char,
    pub(super) caption: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) curves: Vec<Curve>,
    /// Said in the middle of the box when there is no curve.
    pub(super) note: Option<String>,
}

impl Panel {
    /// Space this panel needs between its left edge and its box.
    pub(super) fn margin_left(&self, sizes: Sizes) -> f64 {
        let ticks = self.y.labelled_ticks();
        let widths = ticks.iter().map(|tick| text_width(&tick.label, sizes.tick));
        let widest = widths.fold(0.0, f64::max);
        if self.y.label.is_empty() {
            BESIDE_BARE_TICK_LABELS + widest
        } else {
            (BESIDE_TICK_LABELS + widest).max(sizes.left)
        }
    }

    /// Space this panel needs below its box.
    pub(super) fn margin_bottom(&self, sizes: Sizes) -> f64 {
        if self.x.label.is_empty() {
            sizes.bottom_bare
        } else {
            sizes.bottom
        }
    }

    /// Gives the vertical axis its length, and ticks that have room.
    pub(super) fn fit_y(&mut self, length: f64, sizes: Sizes) {
        self.y.fit(length, |_| LINE_HEIGHT * f64::from(sizes.tick));
    }

    /// Gives the horizontal axis its length, and ticks that have room.
    pub(super) fn fit_x(&mut self, length: f64, sizes: Sizes) {
        let gap = SIDE_GAP * f64::from(sizes.tick);
        (self.x).fit(length, |label| text_width(label, sizes.tick) + gap);
    }

    /// Adds the panel to a scene, with its upper left corner at the origin of the open group.
    pub(super) fn draw(&self, scene: &mut Scene, frame: Frame, heading: &str, heading_size: u32) {
        // kuva draws no axes around nothing at all.
        let mut drawn = render_multiple(vec![LinePlot::new().into()], self.layout(frame));
        self.name_clips(&mut drawn);
        self.add_curves(&mut drawn, frame);
        scene.defs.append(&mut drawn.defs);
        scene.elements.append(&mut drawn.elements);
        self.add_minor_ticks(scene, frame);
        self.add_y_label(scene, frame);
        let edges = frame.edges;
        let y = edges.top - 11.0;
        if !heading.is_empty() {
            scene.add(text(heading, edges.left, y, heading_size, INK));
        }
        if let Some(note) = &self.note {
            let (note, size) = fit(note, frame.sizes.label, edges.right - edges.left);
            scene.add(Primitive::Text {
                x: (edges.left + edges.right) / 2.0,
                y: (edges.top + edges.bottom) / 2.0,
                content: note,
                size,
                anchor: TextAnchor::Middle,
                rotate: None,
                bold: false,
                color: Some(MUTED_INK.into()),
            });
        }
    }

    /// kuva numbers its clip paths through the whole process; named by panel, the same data give
    /// the same file.
    fn name_clips(&self, drawn: &mut Scene) {
        let mut clips = 0;
        for element in &mut drawn.elements {
            if let Primitive::ClipStart { id, .. } = element {
                clips += 1;
                let name = format!("box-{}-{clips}", self.name);
                let (old, new) = (format!("\"{id}\""), format!("\"{name}\""));
                for definition in &mut drawn.defs {
                    *definition = definition.replace(&old, &new);
                }
                *id = name;
            }
        }
    }

    /// Puts areas and lines into the clipped part of the scene and markers on top.
    fn add_curves(&self, scene: &mut Scene, frame: Frame) {
        let is_end = |element: &Primitive| matches!(element, Primitive::ClipEnd);
        let mut at = (scene.elements.iter().position(is_end)).unwrap_or(scene.elements.len());
        let mut insert = |scene: &mut Scene, element| {
            scene.elements.insert(at, element);
            at += 1;
        };
        let group = Primitive::GroupStart {
            transform: None,
            title: None,
            extra_attrs: Some(r#"stroke-linejoin="round" fill-rule="evenodd""#.to_owned()),
        };
        insert(scene, group);
        let (mut lines, mut markers, mut placed) = (Vec::new(), Vec::new(), Vec::new());
        for curve in &self.curves {
            let (edges, most) = (frame.edges, frame.most_points);
            let mut drawn = curve.draw(&self.x, &self.y, edges, most, &mut placed);
            for element in drawn.fills {
                insert(scene, element);
            }
            lines.append(&mut drawn.lines);
            markers.append(&mut drawn.markers);
        }
        for element in lines {
            insert(scene, element);
        }
        insert(scene, Primitive::GroupEnd);
        scene.elements.append(&mut markers);
    }

    fn layout(&self, frame: Frame) -> Layout {
        let (x, y) = (self.x.range(), self.y.range());
        let (edges, sizes) = (frame.edges, frame.sizes);
        let mut layout = Layout::new(x, y)
            .with_width(frame.width)
            .with_height(frame.height)
            .with_theme(style::theme())
            .with_tick_size(sizes.tick)
            .with_x_tick_format(self.x.tick_format())
            .with_y_tick_format(self.y.tick_format())
            .with_force_margins(edges.left, frame.width - edges.right)
            .with_force_margins_y(edges.top, frame.height - edges.bottom)
            .with_x_axis_min(x.0)
            .with_x_axis_max(x.1)
            .with_y_axis_min(y.0)
            .with_y_axis_max(y.1)
            .with_axis_line(AxisLine::Box)
            .with_tick_align(TickAlign::Inside)
            .with_tick_pos(TickPos::Both)
            .with_tick_length(sizes.tick_length)
            .with_axis_line_width(LINE_WIDTH)
            .with_tick_width(LINE_WIDTH);
        if !self.x.label.is_empty() {
            let (label, size) = fit(&self.x.label, sizes.label, frame.width);
            layout = layout.with_x_label(label).with_label_size(size);
        }
        layout.x_tick_step = Some(self.x.tick_step());
        layout.y_tick_step = Some(self.y.tick_step());
        layout
    }

    /// kuva would place the label beside its own tick labels, without room for those of small
    /// ticks.
    fn add_y_label(&self, scene: &mut Scene, frame: Frame) {
        if self.y.label.is_empty() {
            return;
        }
        let (edges, sizes) = (frame.edges, frame.sizes);
        let (content, size) = fit(&self.y.label, sizes.label, frame.height);
        let ticks = self.y.labelled_ticks();
        let widths = ticks.iter().map(|tick| text_width(&tick.label, sizes.tick));
        let widest = widths.fold(2.0 * f64::from(sizes.tick), f64::max);
        let half = 0.5 * f64::from(size);
        let x = (edges.left - TICK_LABEL_GAP - widest - LABEL_GAP - half).max(half + 8.0);
        let y = (edges.top + edges.bottom) / 2.0;
        scene.add(middle_text(&content, x, y, size, true));
    }

    /// The small ticks of logarithmic axes, on all four sides, and their labels.
    fn add_minor_ticks(&self, scene: &mut Scene, frame: Frame) {
        let BoxEdges {
            left,
            right,
            top,
            bottom,
        } = frame.edges;
        let Sizes {
            tick: size,
            tick_length,
            minor_tick_length: length,
            ..
        } = frame.sizes;
        for tick in self.x.minor_ticks() {
            let x = left + tick.fraction * (right - left);
            scene.add(tick_line(x, bottom, x, bottom - length));
            scene.add(tick_line(x, top, x, top + length));
            if let Some(label) = tick.label {
                let y = bottom + tick_length + ASCENT * f64::from(size);
                scene.add(tick_label(label, x, y, size, TextAnchor::Middle));
            }
        }
        for tick in self.y.minor_ticks() {
            let y = bottom - tick.fraction * (bottom - top);
            scene.add(tick_line(left, y, left + length, y));
            scene.add(tick_line(right, y, right - length, y));
            if let Some(label) = tick.label {
                let x = left - tick_length - 3.0;
                let y = y + HALF_DIGIT * f64::from(size);
                scene.add(tick_label(label, x, y, size, TextAnchor::End));
            }
        }
    }
}

fn tick_label(content: String, x: f64, y: f64, size: u32, anchor: TextAnchor) -> Primitive {
    Primitive::Text {
        x,
        y,
        content,
        size,
        anchor,
        rotate: None,
        bold: false,
        color: None,
    }
}

fn tick_line(x1: f64, y1: f64, x2: f64, y2: f64) -> Primitive {
    Primitive::Line {
        x1,
        y1,
        x2,
        y2,
        stroke: INK.into(),
        stroke_width: 0.8,
        stroke_dasharray: None,
    }
}

/// Text that starts at a place.
pub(super) fn text(content: &str, x: f64, y: f64, size: u32, colour: &str) -> Primitive {
    Primitive::Text {
        x,
        y,
        content: content.to_owned(),
        size,
        anchor: TextAnchor::Start,
        rotate: None,
        bold: false,
        color: Some(colour.into()),
    }
}

/// Text around the middle of a line, level or from below upwards.
pub(super) fn middle_text(content: &str, x: f64, y: f64, size: u32, upright: bool) -> Primitive {
    Primitive::Text {
        x,
        y,
        content: content.to_owned(),
        size,
        anchor: TextAnchor::Middle,
        rotate: upright.then_some(-90.0),
        bold: false,
        color: None,
    }
}
