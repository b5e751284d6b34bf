//! The record over the candidates, and the residuals below.

use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use haptic_quantity::{digits, written};
use haptic_tissue::identify::{Fit, Identification, RecordKind, relative};

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
        format!("{}, rms {}", fit.kind.name(), written("rms_pa", fit.rms))
    } else {
        let rms = digits(100.0 * relative(fit.rms), 3);
        format!("{}, rms {rms} %", fit.kind.name())
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

/// Model less record: in % of it, of a stress in Pa.
fn residuals(found: &Identification, fit: &Fit) -> Points {
    let unit = match found.kind {
        RecordKind::History => 1.0,
        _ => 100.0,
    };
    let values = found.residuals(fit).into_iter().map(|value| unit * value);
    found.x.iter().copied().zip(values).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_tissue::ModelKind;

    #[test]
    fn a_model_at_a_third_of_the_record_is_67_percent_below_it() {
        let fit = Fit {
            kind: ModelKind::SpringPot,
            parameters: Vec::new(),
            correlation: Vec::new(),
            rms: 1.12,
            aic: 0.0,
            bic: 0.0,
            predicted: vec![100.0 * (-1.12_f64).exp(), 110.0],
            neighbours: 0.0,
        };
        let mut found = Identification {
            kind: RecordKind::Relaxation,
            samples: 2,
            fits: vec![fit.clone()],
            x: vec![1.0, 2.0],
            measured: vec![100.0, 100.0],
            warnings: Vec::new(),
        };
        let drawn = residuals(&found, &fit);
        assert!((drawn[0].1 + 67.37).abs() < 0.01, "{drawn:?}");
        assert!((drawn[1].1 - 10.0).abs() < 1e-9, "{drawn:?}");
        assert_eq!(name(found.kind, &fit), "spring-pot, rms 206 %");
        found.kind = RecordKind::History;
        let drawn = residuals(&found, &fit);
        assert!((drawn[1].1 - 10.0).abs() < 1e-9, "{drawn:?}");
    }
}
