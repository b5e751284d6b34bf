//! Positions and forces of a run against time.

use crate::axis::Scale;
use crate::curve::Form;
use crate::page::{LegendEntry, Page, Row};
use crate::style::{BLUE, GREEN, INK, LARGE, Stroke, VERMILION};
use crate::theory::{curve, panel};
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
        let line = |what: &'static str, values: &[f64], factor: f64, stroke: Stroke| {
            if values.len() != self.time_s.len() {
                return Err(FigureError::Lengths {
                    what,
                    expected: self.time_s.len(),
                    found: values.len(),
                });
            }
            let values: Vec<f64> = values.iter().map(|value| factor * value).collect();
            let points = showable(self.time_s, &values, Scale::Linear, Scale::Linear);
            Ok(curve(
                thin(&points, Scale::Linear, BINS, Keep::Shape),
                stroke,
            ))
        };
        let positions = vec![
            line("reference", self.reference_m, MM_PER_M, REFERENCE)?,
            line("indenter", self.indenter_position_m, MM_PER_M, INDENTER)?,
            line("position", self.position_m, MM_PER_M, RENDERING)?,
        ];
        let forces = vec![
            line("force", self.force_n, 1.0, FORCE)?,
            line("contact force", self.contact_force_n, 1.0, CONTACT)?,
        ];
        let curves = positions.iter().chain(&forces);
        if curves.map(|curve| curve.points().count()).sum::<usize>() == 0 {
            return Err(FigureError::Empty {
                what: "position or force",
                samples: self.time_s.len(),
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
        page.draw()
    }
}
