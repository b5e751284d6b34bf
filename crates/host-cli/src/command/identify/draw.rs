//! The record over the candidates, and the residuals below.

use super::print::digits;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use haptic_tissue::identify::{Fit, Identification, RecordKind};

/// Points of a curve or of the record.
type Points = Vec<(f64, f64)>;

/// Residuals are drawn of models up to so many times the rms of the chosen one.
const GOOD: f64 = 5.0;
/// Colour of the record: black.
const RECORD: usize = 5;

/// Labels and scales of a kind of record.
struct Words {
    x: &'static str,
    y: &'static str,
    residual: &'static str,
    scale: Scale,
}

const fn words(kind: RecordKind) -> Words {
    let (x, y, residual, scale) = match kind {
        RecordKind::Creep => (
            "time / s",
            "creep compliance / Pa⁻¹",
            "residual / %",
            Scale::Log,
        ),
        RecordKind::Oscillation => (
            "angular frequency / rad·s⁻¹",
            "storage and loss modulus / Pa",
            "residual / %",
            Scale::Log,
        ),
        RecordKind::History => ("time / s", "stress / Pa", "residual / Pa", Scale::Linear),
        _ => (
            "time / s",
            "relaxation modulus / Pa",
            "residual / %",
            Scale::Log,
        ),
    };
    Words {
        x,
        y,
        residual,
        scale,
    }
}

/// Draws an identification; `source` is the file of the record.
///
/// # Errors
/// If there is nothing to draw.
pub(super) fn draw(found: &Identification, source: &str) -> Result<Picture, FigureError> {
    let words = words(found.kind);
    let record = pairs(&found.x, &found.measured);
    // An oscillation has all frequencies twice: a gap keeps its two curves apart.
    let half = (found.kind == RecordKind::Oscillation).then_some(found.x.len() / 2);
    let curves: Vec<(String, usize, Points, Points)> = (found.fits.iter().enumerate())
        .map(|(n, fit)| {
            let colour = if n >= RECORD { n + 1 } else { n };
            let residuals = residuals(found, fit);
            (
                name(found.kind, fit),
                colour,
                gap(pairs(&found.x, &fit.predicted), half),
                residuals,
            )
        })
        .collect();
    // The chosen one on top.
    let mut upper = vec![Series::new("record", &record, Look::MarkersApart, RECORD)];
    let chosen_last = curves.iter().enumerate().rev();
    upper.extend(chosen_last.map(|(n, (name, colour, curve, _))| {
        // Broad, or the record would cover it where it is right.
        let look = if n == 0 { Look::Broad } else { Look::Line };
        Series::new(name, curve, look, *colour)
    }));
    // Poor models would flatten the residuals of the good ones; of markers that meet, the first stays.
    let least = found.fits[0].rms;
    let fits = found.fits.iter().zip(&curves);
    let good = fits.filter(|(fit, _)| fit.rms <= GOOD * least);
    let lower = good.map(|(_, (name, colour, _, residuals))| {
        Series::new(name, residuals, Look::MarkersApart, *colour)
    });
    let across = across(&words, &found.x);
    ChartPage {
        title: &format!("Identified from a record: {}", found.fits[0].kind.name()),
        subtitle: &format!(
            "{source} · {} · {} samples",
            found.kind.name(),
            found.samples
        ),
        columns: 1,
        charts: vec![
            Chart {
                caption: "record and models",
                x: across,
                y: AxisSpec::new(words.y, words.scale),
                series: upper,
            },
            Chart {
                caption: "model less record, of models within 5 times the rms of the first",
                x: across,
                y: AxisSpec::new(words.residual, Scale::Linear),
                series: lower.collect(),
            },
        ],
    }
    .draw()
}

/// The axis of the record; a logarithmic one ends a little beyond it, not at the next power of ten.
fn across(words: &Words, x: &[f64]) -> AxisSpec<'static> {
    const BEYOND: f64 = 1.3;
    let axis = AxisSpec::new(words.x, words.scale);
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = x.iter().copied().fold(0.0, f64::max);
    match words.scale {
        Scale::Log => axis.between(low / BEYOND, BEYOND * high),
        _ => axis,
    }
}

fn name(kind: RecordKind, fit: &Fit) -> String {
    if kind == RecordKind::History {
        format!("{}, rms {} Pa", fit.kind.name(), digits(fit.rms))
    } else {
        format!("{}, rms {:.2} %", fit.kind.name(), 100.0 * fit.rms)
    }
}

fn pairs(x: &[f64], y: &[f64]) -> Points {
    x.iter().copied().zip(y.iter().copied()).collect()
}

fn gap(mut points: Points, at: Option<usize>) -> Points {
    if let Some(at) = at {
        points.insert(at, (f64::NAN, f64::NAN));
    }
    points
}

/// Model less record: of the logarithm in %, of a stress in Pa.
fn residuals(found: &Identification, fit: &Fit) -> Points {
    let values = fit
        .predicted
        .iter()
        .zip(&found.measured)
        .map(|(model, measured)| match found.kind {
            RecordKind::History => model - measured,
            _ => 100.0 * (model / measured).ln(),
        });
    found.x.iter().copied().zip(values).collect()
}
