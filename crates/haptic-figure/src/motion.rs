//! Positions and forces of a run against time.

use crate::axis::Scale;
use crate::curve::{Curve, Form};
use crate::over_time::{TimePanel, check_lengths, line};
use crate::page::{LegendEntry, Page, Row};
use crate::style::{BLUE, GREEN, INK, LARGE, Stroke, VERMILION};
use crate::thin::{Keep, showable, thin};
use crate::{FigureError, Picture};

const BINS: usize = 450;
const ROW_HEIGHT: f64 = 300.0;
/// Positions are drawn in mm.
const MM_PER_M: f64 = 1e3;

const REFERENCE: Stroke = Stroke::solid("#999999", 4.5);
const INDENTER: Stroke = Stroke::solid(GREEN, 1.8);
const RENDERING: Stroke = Stroke::solid(BLUE, 1.8);
const FORCE: Stroke = Stroke::solid(VERMILION, 1.8);
const CONTACT: Stroke = Stroke::solid(INK, 1.0);

/// Motion of a run for a first look: positions above, forces below. The slices belong together sample by sample;
/// what is not finite is left out.
///
/// ```
/// use haptic_figure::MotionFigure;
///
/// let time_s: Vec<f64> = (0..100).map(|i| 1e-3 * f64::from(i)).collect();
/// let (ramp, rest) = (time_s.iter().map(|t| 0.01 * t), vec![0.0; 100]);
/// let ramp: Vec<f64> = ramp.collect();
/// let force_n: Vec<f64> = ramp.iter().map(|x| -500.0 * x).collect();
/// let figure = MotionFigure {
///     title: "A push into a spring of 500 N/m",
///     subtitle: "",
///     time_s: &time_s,
///     reference_m: &ramp,
///     indenter_position_m: &rest,
///     position_m: &ramp,
///     force_n: &force_n,
///     contact_force_n: &force_n,
/// };
/// assert!(figure.draw()?.svg().contains("position / mm"));
/// # Ok::<(), haptic_figure::FigureError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionFigure<'a> {
    /// One line above the picture.
    pub title: &'a str,
    /// One line below it; may be empty.
    pub subtitle: &'a str,
    /// Time, s.
    pub time_s: &'a [f64],
    /// Position that was asked for, m.
    pub reference_m: &'a [f64],
    /// Position of the indenter, m.
    pub indenter_position_m: &'a [f64],
    /// Position of the device, m.
    pub position_m: &'a [f64],
    /// Force on the device, N.
    pub force_n: &'a [f64],
    /// Force of the contact, N.
    pub contact_force_n: &'a [f64],
}

impl MotionFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If there is no sample to draw, or the slices differ in length.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        check_lengths(
            self.time_s,
            &[
                ("reference", self.reference_m),
                ("indenter", self.indenter_position_m),
                ("position", self.position_m),
                ("force", self.force_n),
                ("contact force", self.contact_force_n),
            ],
        )?;
        let positions = vec![
            self.line(self.reference_m, MM_PER_M, REFERENCE),
            self.line(self.indenter_position_m, MM_PER_M, INDENTER),
            self.line(self.position_m, MM_PER_M, RENDERING),
        ];
        let forces = vec![
            self.line(self.force_n, 1.0, FORCE),
            self.line(self.contact_force_n, 1.0, CONTACT),
        ];
        let mut curves = positions.iter().chain(&forces);
        if curves.all(|curve| curve.points().next().is_none()) {
            return Err(FigureError::Empty {
                what: "position or force",
                samples: self.time_s.len(),
            });
        }
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
        page.draw()
    }

    fn line(&self, values: &[f64], factor: f64, stroke: Stroke) -> Curve {
        let values: Vec<f64> = values.iter().map(|value| factor * value).collect();
        let points = showable(self.time_s, &values, Scale::Linear, Scale::Linear);
        line(thin(&points, Scale::Linear, BINS, Keep::Shape), stroke)
    }
}

fn row(name: char, caption: &str, label: &'static str, curves: Vec<Curve>) -> Row {
    let panel = TimePanel {
        name,
        caption: caption.to_owned(),
        scale: Scale::Linear,
        label,
        curves,
        floor: None,
        note: "no finite values",
    };
    Row {
        height: ROW_HEIGHT,
        columns: 1,
        panels: vec![panel.panel()],
    }
}
