//! One panel: two axes in a box, curves over a faint grid, a caption above.

use kuva::plot::LinePlot;
use kuva::render::layout::{AxisLine, Layout, TickAlign, TickPos};
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};

use super::axis::Axis;
use super::style::{self, INK, LABEL_SIZE, MUTED_INK, Stroke, TICK_SIZE, text_width};
use super::thin::Points;

/// Space between the edges of a panel and its box; on the left at least.
const MARGIN_LEFT: f64 = 84.0;
const MARGIN_RIGHT: f64 = 16.0;
const MARGIN_TOP: f64 = 34.0;
const MARGIN_BOTTOM: f64 = 58.0;

/// Of that, what lies beside the tick labels: axis label, ticks, gaps.
const BESIDE_TICK_LABELS: f64 = 40.0;

const TICK_LENGTH: f64 = 7.0;
const MINOR_TICK_LENGTH: f64 = 4.0;
const LINE_WIDTH: f64 = 1.2;
/// Height of the font above the baseline and half the height of a digit, over its size: where
/// kuva puts tick labels.
const ASCENT: f64 = 0.93;
const HALF_DIGIT: f64 = 0.36;

/// A curve, drawn in the order given: the first lies beneath.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    pub(super) points: Points,
    pub(super) stroke: Stroke,
}

/// Where the box of a panel lies in its rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Left edge of the box.
    pub(super) left: f64,
}

impl Frame {
    fn right(self) -> f64 {
        self.width - MARGIN_RIGHT
    }

    fn bottom(self) -> f64 {
        self.height - MARGIN_BOTTOM
    }
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
    pub(super) fn margin_left(&self) -> f64 {
        let labels = self.y.labels();
        let widths = labels.iter().map(|label| text_width(label, TICK_SIZE));
        (BESIDE_TICK_LABELS + widths.fold(0.0, f64::max)).max(MARGIN_LEFT)
    }

    /// Adds the panel to a scene, with its upper left corner at the origin of the open group.
    pub(super) fn draw(&self, scene: &mut Scene, frame: Frame) {
        let lines = self.curves.iter().map(|curve| self.line(curve).into());
        let mut drawn = render_multiple(lines.collect(), self.layout(frame));
        self.name_clips(&mut drawn);
        scene.defs.append(&mut drawn.defs);
        scene.elements.append(&mut drawn.elements);
        self.add_minor_ticks(scene, frame);
        let caption = format!("({}) {}", self.name, self.caption);
        let y = MARGIN_TOP - 11.0;
        scene.add(text(&caption, frame.left, y, LABEL_SIZE, INK));
        if let Some(note) = &self.note {
            scene.add(Primitive::Text {
                x: (frame.left + frame.right()) / 2.0,
                y: (MARGIN_TOP + frame.bottom()) / 2.0,
                content: note.clone(),
                size: LABEL_SIZE,
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

    fn line(&self, curve: &Curve) -> LinePlot {
        let placed = (curve.points.iter()).map(|(x, y)| (self.x.place(*x), self.y.place(*y)));
        LinePlot::new()
            .with_data(placed)
            .with_color(curve.stroke.colour)
            .with_stroke_width(curve.stroke.width)
    }

    fn layout(&self, frame: Frame) -> Layout {
        let (x, y) = (self.x.range(), self.y.range());
        let mut layout = Layout::new(x, y)
            .with_width(frame.width)
            .with_height(frame.height)
            .with_theme(style::theme())
            .with_x_label(self.x.label)
            .with_y_label(self.y.label)
            .with_label_size(LABEL_SIZE)
            .with_tick_size(TICK_SIZE)
            .with_x_tick_format(self.x.tick_format())
            .with_y_tick_format(self.y.tick_format())
            .with_force_margins(frame.left, MARGIN_RIGHT)
            .with_force_margins_y(MARGIN_TOP, MARGIN_BOTTOM)
            .with_x_axis_min(x.0)
            .with_x_axis_max(x.1)
            .with_y_axis_min(y.0)
            .with_y_axis_max(y.1)
            .with_axis_line(AxisLine::Box)
            .with_tick_align(TickAlign::Inside)
            .with_tick_pos(TickPos::Both)
            .with_tick_length(TICK_LENGTH)
            .with_axis_line_width(LINE_WIDTH)
            .with_tick_width(LINE_WIDTH);
        layout.x_tick_step = Some(self.x.tick_step());
        layout.y_tick_step = Some(self.y.tick_step());
        layout
    }

    /// The small ticks of logarithmic axes, on all four sides, and their labels.
    fn add_minor_ticks(&self, scene: &mut Scene, frame: Frame) {
        let (left, right, top, bottom) = (frame.left, frame.right(), MARGIN_TOP, frame.bottom());
        for tick in self.x.minor_ticks() {
            let x = left + tick.fraction * (right - left);
            scene.add(tick_line(x, bottom, x, bottom - MINOR_TICK_LENGTH));
            scene.add(tick_line(x, top, x, top + MINOR_TICK_LENGTH));
            if let Some(label) = tick.label {
                let y = bottom + TICK_LENGTH + ASCENT * f64::from(TICK_SIZE);
                scene.add(tick_label(label, x, y, TextAnchor::Middle));
            }
        }
        for tick in self.y.minor_ticks() {
            let y = bottom - tick.fraction * (bottom - top);
            scene.add(tick_line(left, y, left + MINOR_TICK_LENGTH, y));
            scene.add(tick_line(right, y, right - MINOR_TICK_LENGTH, y));
            if let Some(label) = tick.label {
                let x = left - TICK_LENGTH - 3.0;
                let y = y + HALF_DIGIT * f64::from(TICK_SIZE);
                scene.add(tick_label(label, x, y, TextAnchor::End));
            }
        }
    }
}

fn tick_label(content: String, x: f64, y: f64, anchor: TextAnchor) -> Primitive {
    Primitive::Text {
        x,
        y,
        content,
        size: TICK_SIZE,
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
