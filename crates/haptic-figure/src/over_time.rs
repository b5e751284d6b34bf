//! A run against its closed form over time, the page that relaxation and creep share.
//!
//! It has three panels: the quantity against time, linear (a) and log-log (b), and below them the relative error (c), log-log. The error
//! is drawn as the largest one of each of some 600 equal steps of log t, because a curve through its sign changes would be a hedge of
//! spikes. An error of exactly 0 has no place on a logarithmic axis and is left out; one more than ten decades below the largest lies below
//! the panel. So does, in panel (b), the curve of a run where it falls more than a decade below the closed form everywhere, as short memory
//! does.

use crate::axis::{Axis, Scale, extremes};
use crate::curve::{Curve, Form};
use crate::page::{LegendEntry, Page, Row};
use crate::panel::Panel;
use crate::style::{DIFFERENCE, GREEN, INK, LARGE, PURPLE, RUN, Stroke, THEORY};
use crate::thin::{Points, envelope, showable};
use crate::{FigureError, Picture};

/// Steps of an envelope across the page.
const BINS: usize = 600;
/// The error panel reaches this far below the largest error.
const ERROR_SPAN: f64 = 1e10;
/// Said in a panel of errors without one.
const NO_ERROR: &str = "no sample has a relative error";

/// A quantity against time over its closed form, and the error below. The slices belong together sample by
/// sample; what is not finite is left out, and so is what is not positive from the logarithmic panels.
/// ```
/// use haptic_figure::TheoryFigure;
///
/// let time_s: Vec<f64> = (1..=1000).map(|i| 1e-3 * f64::from(i)).collect();
/// let closed_form: Vec<f64> = time_s.iter().map(|t| 3.0 * t.powf(-0.2247)).collect();
/// let relative_error: Vec<f64> = time_s.iter().map(|t| 1e-3 * (60.0 * t).sin()).collect();
/// let both = closed_form.iter().zip(&relative_error);
/// let values: Vec<f64> = both.map(|(force, error)| force * (1.0 + error)).collect();
/// let figure = TheoryFigure {
///     title: "Relaxation",
///     subtitle: "prostate, cancerous",
///     quantity: "force",
///     label: "force / N",
///     origin: "simulated",
///     time_s: &time_s,
///     values: &values,
///     closed_form: &closed_form,
///     relative_error: &relative_error,
///     record: None,
///     held: None,
/// };
/// assert!(figure.draw()?.svg().contains("simulated force"));
/// # Ok::<(), haptic_figure::FigureError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TheoryFigure<'a> {
    /// One line above the picture.
    pub title: &'a str,
    /// What the curve was taken of, in one line below the title.
    pub subtitle: &'a str,
    /// The quantity that is compared, as in `force`.
    pub quantity: &'static str,
    /// Its axis label, with the unit, as in `force / N`.
    pub label: &'static str,
    /// Its source, as in `simulated` or `rendered`.
    pub origin: &'a str,
    /// Time since contact or since the force was applied, s: a logarithmic axis begins at the first positive one.
    pub time_s: &'a [f64],
    /// The quantity of the run; a value that is not finite leaves a gap.
    pub values: &'a [f64],
    /// The quantity in closed form at the same times.
    pub closed_form: &'a [f64],
    /// Relative error of the quantity; the sign does not matter, and NaN is left out.
    pub relative_error: &'a [f64],
    /// A measured record of the quantity, over the run in its panels and with one more for the error; `None` omits it.
    pub record: Option<MeasuredCurve<'a>>,
    /// Data for two more panels about the controller that held the device; `None` omits them.
    pub held: Option<HeldPanels<'a>>,
}

/// A measured record and how far the run is from it, at the record's own times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredCurve<'a> {
    /// Time on the clock of the run, s.
    pub time_s: &'a [f64],
    /// What was measured, in the unit of the run.
    pub values: &'a [f64],
    /// The run less the record, over the record; what has no relative error is left out.
    pub relative_error: &'a [f64],
    /// The rms of the difference over that of the record.
    pub rms: f64,
}

/// An error of more per cent than this is not drawn: where a record begins, it may be any.
const PER_CENT_MOST: f64 = 100.0;

impl MeasuredCurve<'_> {
    fn row(&self, name: char) -> Result<Row, FigureError> {
        let slices = [
            ("the record", self.values),
            ("error against the record", self.relative_error),
        ];
        check_lengths(self.time_s, &slices)?;
        let errors = self.relative_error.iter();
        let per_cent: Vec<f64> = errors.map(|error| 100.0 * error).collect();
        let mut points = showable(self.time_s, &per_cent, Scale::Log, Scale::Linear);
        points.retain(|point| point.1.abs() <= PER_CENT_MOST);
        let stroke = Stroke {
            width: 1.4,
            ..RECORD
        };
        let rms = 100.0 * self.rms;
        let panel = panel(
            name,
            &format!("run less record, over the record: rms {rms:.2} %"),
            [Scale::Log, Scale::Linear],
            "difference / %",
            vec![line(points, stroke)],
            f64::NEG_INFINITY,
            NO_ERROR,
        );
        Ok(row(ERROR_ROW_HEIGHT, vec![panel]))
    }
}

const RECORD: Stroke = Stroke::solid(PURPLE, 3.6);
/// Tracking error and force of the drive.
const HELD: [Stroke; 2] = [Stroke::solid(GREEN, 1.8), Stroke::solid(INK, 1.4)];

/// Panels about the controller that held a device on its way: the error that it left, and its force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldPanels<'a> {
    /// Time of each sample, s; all slices are as long as this one.
    pub time_s: &'a [f64],
    /// Axis label of the error, with the unit, as in `tracking error / µm`.
    pub label: &'static str,
    /// Set point less measurement, in the unit of the label.
    pub tracking_error: &'a [f64],
    /// Force of the drive, N.
    pub force_n: &'a [f64],
}

impl HeldPanels<'_> {
    fn row(&self) -> Result<Row, FigureError> {
        let slices = [
            ("tracking error", self.tracking_error),
            ("drive force", self.force_n),
        ];
        check_lengths(self.time_s, &slices)?;
        let of = |name, caption, label, values, stroke| {
            let points = showable(self.time_s, values, Scale::Linear, Scale::Linear);
            let (scales, curves) = ([Scale::Linear; 2], vec![line(points, stroke)]);
            let floor = f64::NEG_INFINITY;
            panel(name, caption, scales, label, curves, floor, "no sample")
        };
        let (errors, forces) = (self.tracking_error, self.force_n);
        let caption = "set point less measurement";
        let panels = vec![
            of('d', caption, self.label, errors, HELD[0]),
            of('e', "force of the drive", "force / N", forces, HELD[1]),
        ];
        Ok(row(ERROR_ROW_HEIGHT, panels))
    }
}

/// Panels side by side.
fn row(height: f64, panels: Vec<Panel>) -> Row {
    Row {
        height,
        columns: panels.len(),
        panels,
    }
}

const TOP_ROW_HEIGHT: f64 = 340.0;
const ERROR_ROW_HEIGHT: f64 = 270.0;

impl TheoryFigure<'_> {
    /// Draws the picture.
    ///
    /// # Errors
    /// If no sample can be drawn, or the slices differ in length.
    pub fn draw(&self) -> Result<Picture, FigureError> {
        let slices = [
            (self.quantity, self.values),
            ("closed form", self.closed_form),
            ("relative error", self.relative_error),
        ];
        check_lengths(self.time_s, &slices)?;
        let run = format!("{} {}", self.origin, self.quantity);
        let both = vec![
            self.curves('a', self.quantity, Scale::Linear)?,
            self.curves('b', &format!("{}, log–log", self.quantity), Scale::Log)?,
        ];
        let error = vec![self.error()];
        let mut rows = vec![row(TOP_ROW_HEIGHT, both), row(ERROR_ROW_HEIGHT, error)];
        if let Some(held) = &self.held {
            rows.push(held.row()?);
        }
        let mut legend = vec![
            (run.as_str(), RUN),
            ("closed form", THEORY),
            ("relative error", DIFFERENCE),
        ];
        if let Some(record) = &self.record {
            legend.push(("measured", RECORD));
            let panels: usize = rows.iter().map(|row| row.panels.len()).sum();
            rows.push(record.row(('a'..).nth(panels).unwrap_or('f'))?);
        }
        draw(self.title, self.subtitle, &legend, rows)
    }

    /// The run over its closed form; a panel that has nothing to show on logarithmic axes says so.
    fn curves(&self, name: char, caption: &str, scale: Scale) -> Result<Panel, FigureError> {
        let [theory, run] = [self.closed_form, self.values]
            .map(|values| showable(self.time_s, values, scale, scale));
        if run.is_empty() && scale == Scale::Linear {
            return Err(FigureError::Empty {
                what: self.quantity,
                samples: self.time_s.len(),
            });
        }
        // A curve that passes through zero would stretch a logarithmic axis without end.
        let lowest = extremes(theory.iter().map(|point| point.1)).0;
        let floor = match scale {
            Scale::Log if lowest.is_finite() => lowest / 10.0,
            Scale::Log | Scale::Linear => f64::NEG_INFINITY,
        };
        let record = self.record.map(|record| {
            let points = showable(record.time_s, record.values, scale, scale);
            line(points, RECORD)
        });
        let curves = [line(theory, THEORY)].into_iter().chain(record);
        let curves = curves.chain([line(run, RUN)]).collect();
        let scales = [scale, scale];
        let note = "no positive values";
        Ok(panel(
            name, caption, scales, self.label, curves, floor, note,
        ))
    }

    fn error(&self) -> Panel {
        let magnitude: Vec<f64> = self
            .relative_error
            .iter()
            .map(|error| error.abs())
            .collect();
        let points = showable(self.time_s, &magnitude, Scale::Log, Scale::Log);
        let envelope = envelope(&points, Scale::Log, BINS);
        let largest = extremes(envelope.iter().map(|point| point.1)).1;
        let note = if magnitude.iter().any(|error| error.is_finite()) {
            "the error is 0 throughout"
        } else {
            NO_ERROR
        };
        panel(
            'c',
            "relative error, largest in each step of log t",
            [Scale::Log; 2],
            "relative error",
            vec![line(envelope, DIFFERENCE)],
            largest / ERROR_SPAN,
            note,
        )
    }
}

/// Refuses slices that have not one value for each time.
pub(crate) fn check_lengths(
    time_s: &[f64],
    slices: &[(&'static str, &[f64])],
) -> Result<(), FigureError> {
    let wrong = slices.iter().find(|(_, slice)| slice.len() != time_s.len());
    match wrong {
        None => Ok(()),
        Some((what, slice)) => Err(FigureError::Lengths {
            what,
            expected: time_s.len(),
            found: slice.len(),
        }),
    }
}

/// A page of lines, each with its own labels.
fn draw(
    title: &str,
    subtitle: &str,
    legend: &[(&str, Stroke)],
    rows: Vec<Row>,
) -> Result<Picture, FigureError> {
    let entry = |(name, stroke): &(&str, Stroke)| LegendEntry::new(name, Form::Line(*stroke));
    Page::new(
        title,
        subtitle,
        legend.iter().map(entry).collect(),
        LARGE,
        rows,
    )
    .draw()
}

/// A line through these points.
fn line(points: Points, stroke: Stroke) -> Curve {
    Curve {
        pieces: vec![points],
        form: Form::Line(stroke),
    }
}

/// A panel over time around its curves: scales of time and of the values, whose label has the unit and whose axis begins no
/// lower than the floor. The note is said when there is no curve.
fn panel(
    name: char,
    caption: &str,
    [scale, value_scale]: [Scale; 2],
    label: &str,
    curves: Vec<Curve>,
    floor: f64,
    note: &str,
) -> Panel {
    let points: Points = curves.iter().flat_map(Curve::points).collect();
    let (mut x, mut y) = ((1.0, 10.0), (1.0, 10.0));
    if !points.is_empty() {
        x = extremes(points.iter().map(|point| point.0));
        y = extremes(points.iter().map(|point| point.1));
    }
    Panel {
        name,
        caption: caption.to_owned(),
        x: Axis::time(scale, x.0, x.1),
        y: Axis::around(label, value_scale, y.0.max(floor), y.1),
        curves,
        note: points.is_empty().then(|| note.to_owned()),
        beyond: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_stroke_means_two_things_in_a_picture() {
        let strokes = [&[RUN, THEORY, DIFFERENCE, RECORD], HELD.as_slice()].concat();
        for (n, stroke) in strokes.iter().enumerate() {
            assert!(!strokes[..n].contains(stroke), "{stroke:?}");
        }
    }
}
