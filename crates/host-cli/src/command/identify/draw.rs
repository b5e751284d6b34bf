//! The record over the candidates, and the residuals below.

use crate::picture::{Panel, Points, linear, page};
use haptic_figure::{AxisSpec, FigureError, Look, Picture, Scale};
use haptic_quantity::{digits, written};
use haptic_tissue::identify::{Fit, Identification, RecordKind, relative};

/// Residuals are drawn of models up to so many times the rms of the chosen one.
const GOOD: f64 = 5.0;
/// Colour of the record: black.
const RECORD: usize = 5;

/// Labels of time or frequency, of the record, and of residuals, and the scale of the first two.
const fn words(kind: RecordKind) -> [&'static str; 3] {
    match kind {
        RecordKind::Creep => ["time / s", "creep compliance / Pa⁻¹", "residual / %"],
        RecordKind::Oscillation => [
            "angular frequency / rad·s⁻¹",
            "storage and loss modulus / Pa",
            "residual / %",
        ],
        RecordKind::History => ["time / s", "stress / Pa", "residual / Pa"],
        _ => ["time / s", "relaxation modulus / Pa", "residual / %"],
    }
}

/// Draws an identification; `source` is the file of the record.
pub(super) fn draw(found: &Identification, source: &str) -> Result<Picture, FigureError> {
    let [x, y, residual] = words(found.kind);
    let scale = match found.kind {
        RecordKind::History => Scale::Linear,
        _ => Scale::Log,
    };
    let across = across(AxisSpec::new(x, scale), &found.x);
    let colour = |n: usize| if n >= RECORD { n + 1 } else { n };
    let record = pairs(&found.x, &found.measured);
    let upper = Panel::new("record and models", across, AxisSpec::new(y, scale));
    let mut upper = upper.with("record", Look::MarkersApart, RECORD, record);
    // The chosen one on top, and broad, or the record would cover it where it is right.
    for (n, fit) in found.fits.iter().enumerate().rev() {
        let look = if n == 0 { Look::Broad } else { Look::Line };
        let curve = pairs(&found.x, &fit.predicted);
        upper = upper.with(name(found.kind, fit), look, colour(n), curve);
    }
    // Poor models would flatten the residuals of the good ones; of markers that meet, the first stays.
    let caption = "model less record, of models within 5 times the rms of the first";
    let mut lower = Panel::new(caption, across, linear(residual));
    let least = found.fits[0].rms;
    let fits = found.fits.iter().enumerate();
    for (n, fit) in fits.filter(|(_, fit)| fit.rms <= GOOD * least) {
        let name = name(found.kind, fit);
        lower = lower.with(name, Look::MarkersApart, colour(n), residuals(found, fit));
    }
    let title = format!("Identified from a record: {}", found.fits[0].kind.name());
    let (kind, samples) = (found.kind.name(), found.samples);
    let subtitle = format!("{source} · {kind} · {samples} samples");
    page(&title, &subtitle, 1, &[upper, lower])
}

/// The axis of the record; a logarithmic one ends a little beyond it, not at the next power of ten.
fn across<'a>(axis: AxisSpec<'a>, x: &[f64]) -> AxisSpec<'a> {
    const BEYOND: f64 = 1.3;
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = x.iter().copied().fold(0.0, f64::max);
    match axis.scale {
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

/// A curve, with a gap before each time or frequency that begins anew: of the loss moduli, or of another motion.
fn pairs(x: &[f64], y: &[f64]) -> Points {
    let mut points = Points::new();
    for (&x, &y) in x.iter().zip(y) {
        if points.last().is_some_and(|last| x <= last.0) {
            points.push((f64::NAN, f64::NAN));
        }
        points.push((x, y));
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
