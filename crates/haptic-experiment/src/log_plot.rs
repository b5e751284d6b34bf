//! Position and force of any log against time.

use super::axis::Scale;
use super::curve::Form;
use super::page::{LegendEntry, Page, Row};
use super::style::{BLUE, GREEN, INK, LARGE, Stroke, VERMILION};
use super::theory::{curve, panel};
use super::thin::{Keep, showable, thin};
use super::{FigureError, Picture};
use haptic_log::record::TickMessage;

const BINS: usize = 450;
const ROW_HEIGHT: f64 = 300.0;
/// Positions are drawn in mm.
const MM_PER_M: f64 = 1e3;

const REFERENCE: Stroke = Stroke::solid("#999999", 4.5);
const INDENTER: Stroke = Stroke::solid(GREEN, 1.8);
const RENDERING: Stroke = Stroke::solid(BLUE, 1.8);
const FORCE: Stroke = Stroke::solid(VERMILION, 1.8);
const CONTACT: Stroke = Stroke::solid(INK, 1.0);

/// What a log holds, for a first look: positions above, forces below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogFigure<'a> {
    /// One line above the picture, as the name of the log.
    pub title: &'a str,
    /// One line below it; may be empty.
    pub subtitle: &'a str,
    /// The ticks in order.
    pub ticks: &'a [TickMessage],
}

impl LogFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If there is no tick to draw.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        let time_s = self.column(|tick| tick.time_s);
        let line = |value: fn(&TickMessage) -> f64, stroke: Stroke| {
            let points = showable(&time_s, &self.column(value), Scale::Linear, Scale::Linear);
            curve(thin(&points, Scale::Linear, BINS, Keep::Shape), stroke)
        };
        let positions = vec![
            line(|tick| MM_PER_M * tick.reference_m, REFERENCE),
            line(|tick| MM_PER_M * tick.indenter_position_m, INDENTER),
            line(|tick| MM_PER_M * tick.position_m, RENDERING),
        ];
        let forces = vec![
            line(|tick| tick.force_n, FORCE),
            line(|tick| tick.contact_force_n, CONTACT),
        ];
        let curves = positions.iter().chain(&forces);
        if curves.map(|curve| curve.points().count()).sum::<usize>() == 0 {
            return Err(FigureError::Empty {
                what: "position or force",
                samples: self.ticks.len(),
            });
        }
        let row = |name, caption: &str, label, curves| Row {
            height: ROW_HEIGHT,
            columns: 1,
            panels: vec![panel(
                name,
                caption.to_owned(),
                Scale::Linear,
                label,
                curves,
                None,
                "no finite values",
            )],
        };
        let page = Page {
            title: self.title.to_owned(),
            subtitle: self.subtitle.to_owned(),
            legend: vec![
                LegendEntry::new("reference", Form::Line(REFERENCE)),
                LegendEntry::new("indenter", Form::Line(INDENTER)),
                LegendEntry::new("position", Form::Line(RENDERING)),
                LegendEntry::new("force", Form::Line(FORCE)),
                LegendEntry::new("contact force", Form::Line(CONTACT)),
            ],
            sizes: LARGE,
            x_label: String::new(),
            y_label: String::new(),
            rows: vec![
                row('a', "position", "position / mm", positions),
                row('b', "force", "force / N", forces),
            ],
        };
        Ok(page.draw())
    }

    fn column(&self, value: impl Fn(&TickMessage) -> f64) -> Vec<f64> {
        self.ticks.iter().map(value).collect()
    }
}
