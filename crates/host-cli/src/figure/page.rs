//! A page: title, subtitle, legend, and panels in rows.
//!
//! The legend stands above the panels, where it cannot cover a curve.

use kuva::backend::svg::SvgBackend;
use kuva::render::render::{Primitive, Scene};

use super::panel::{Frame, Panel, text};
use super::render::Picture;
use super::style::{
    INK, LABEL_SIZE, MUTED_INK, PAGE_EDGE, PAGE_WIDTH, SUBTITLE_SIZE, Stroke, TITLE_SIZE, fit,
    text_width,
};

const TITLE_BASELINE: f64 = 34.0;
const SUBTITLE_BASELINE: f64 = 60.0;
const LEGEND_BASELINE: f64 = 88.0;
const PANELS_TOP: f64 = 100.0;
/// Length of a line in the legend.
const SAMPLE_LENGTH: f64 = 40.0;

/// A row of panels of equal width.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) height: f64,
    pub(super) panels: Vec<Panel>,
}

/// A page; see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Page {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) legend: Vec<(&'static str, Stroke)>,
    pub(super) rows: Vec<Row>,
}

impl Page {
    /// Draws the page as SVG.
    pub(super) fn draw(&self) -> Picture {
        let height = PANELS_TOP + self.rows.iter().map(|row| row.height).sum::<f64>() + PAGE_EDGE;
        let mut scene = Scene::new(PAGE_WIDTH, height);
        scene.font_family = Some("DejaVu Sans, Verdana, Arial, sans-serif".to_owned());
        scene.text_color = Some(INK.to_owned());
        self.add_header(&mut scene);
        // One margin for all, so that the boxes stand in line.
        let panels = self.rows.iter().flat_map(|row| &row.panels);
        let left = panels.map(Panel::margin_left).fold(0.0, f64::max);
        let mut y = PANELS_TOP;
        for row in &self.rows {
            let width = (PAGE_WIDTH - 2.0 * PAGE_EDGE) / row.panels.len() as f64;
            for (column, panel) in row.panels.iter().enumerate() {
                let x = PAGE_EDGE + column as f64 * width;
                scene.add(Primitive::GroupStart {
                    transform: Some(format!("translate({x},{y})")),
                    title: None,
                    extra_attrs: None,
                });
                let height = row.height;
                panel.draw(
                    &mut scene,
                    Frame {
                        width,
                        height,
                        left,
                    },
                );
                scene.add(Primitive::GroupEnd);
            }
            y += row.height;
        }
        Picture::new(SvgBackend::new().render_scene(&scene))
    }

    fn add_header(&self, scene: &mut Scene) {
        let left = 2.0 * PAGE_EDGE;
        let room = PAGE_WIDTH - 2.0 * left;
        let (title, size) = fit(&self.title, TITLE_SIZE, room);
        scene.add(text(&title, left, TITLE_BASELINE, size, INK));
        let (subtitle, size) = fit(&self.subtitle, SUBTITLE_SIZE, room);
        scene.add(text(&subtitle, left, SUBTITLE_BASELINE, size, MUTED_INK));
        let mut x = left;
        for (label, stroke) in &self.legend {
            let y = LEGEND_BASELINE - 0.35 * f64::from(LABEL_SIZE);
            scene.add(Primitive::Line {
                x1: x,
                y1: y,
                x2: x + SAMPLE_LENGTH,
                y2: y,
                stroke: stroke.colour.into(),
                stroke_width: stroke.width,
                stroke_dasharray: None,
            });
            x += SAMPLE_LENGTH + 10.0;
            scene.add(text(label, x, LEGEND_BASELINE, LABEL_SIZE, INK));
            x += text_width(label, LABEL_SIZE) + 28.0;
        }
    }
}
