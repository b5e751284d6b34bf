//! The record over the candidates, and the residuals below.

use crate::picture::{Panel, Points, linear, page, short_name};
use haptic_figure::{AxisSpec, FigureError, Look, Picture, Scale};
use haptic_loop::Modulus;
use haptic_quantity::{digits, written};
use haptic_question::analysis::logarithmic;
use haptic_tissue::MeasuredLoading;
use tissue_identification::{Fit, Identification, RecordKind, relative};

/// Approximate number of samples of a record that are drawn over the models.
const SPARSE: usize = 60;
/// Largest rms, over that of the chosen model, of models beside it.
const GOOD: f64 = 5.0;
/// Colour of the record: black.
const RECORD: usize = 5;

/// Labels of time or frequency, of the record, and of residuals. Of an indenter the force is drawn as it is fitted, over γ and the length ℓ
/// of its nominal strain.
const fn words(found: &Identification, indented: bool) -> [&'static str; 3] {
    match found.kind {
        RecordKind::History if indented => ["time / s", "equivalent stress / Pa", "residual / Pa"],
        RecordKind::Creep if found.is_absolute => {
            ["time / s", "creep compliance / Pa⁻¹", "residual / Pa⁻¹"]
        }
        RecordKind::Creep => ["time / s", "creep compliance / Pa⁻¹", "residual / %"],
        RecordKind::Oscillation => [
            "angular frequency / rad·s⁻¹",
            "storage and loss modulus / Pa",
            "residual / %",
        ],
        RecordKind::History => ["time / s", "stress / Pa", "residual / Pa"],
        RecordKind::Relaxation => ["time / s", "relaxation modulus / Pa", "residual / %"],
    }
}

/// Draws an identification: the record, the chosen model, which is alone if it was asked for, and its residuals. `source` is the
/// file of the record, which was measured under this loading.
pub(super) fn draw(
    found: &Identification,
    is_asked: bool,
    loading: MeasuredLoading,
    source: &str,
) -> Result<Picture, FigureError> {
    let indented = loading.kind.is_some_and(|kind| !kind.is_slab());
    let [x, y, residual] = words(found, indented);
    let oscillates = found.kind == RecordKind::Oscillation;
    let scale = if found.is_absolute || found.is_staircase {
        Scale::Linear
    } else {
        Scale::Log
    };
    let across = across(AxisSpec::new(x, scale), &found.x);
    let colour = |n: usize| if n >= RECORD { n + 1 } else { n };
    let upper = Panel::new("record and fit", across, AxisSpec::new(y, scale));
    let [record, loss] = parts(found, &found.measured);
    let mut upper = if oscillates {
        upper
            .with("storage modulus", Look::Markers, RECORD, record)
            .with("loss modulus", Look::OpenMarkers, RECORD, loss)
    } else {
        let step = record.len().div_ceil(SPARSE).max(1);
        let name = match step {
            1 => "record".to_owned(),
            _ => format!("record, 1 of {step} samples"),
        };
        upper.with(
            name,
            Look::OpenMarkers,
            RECORD,
            record.into_iter().step_by(step),
        )
    };
    // The chosen one broad, and those that fit about as well dashed on top: all are seen where they agree.
    let chosen = &found.fits[0];
    for (n, fit) in found.fits.iter().enumerate() {
        let look = match n {
            0 => Look::Broad,
            _ if is_asked || fit.rms > GOOD * chosen.rms => continue,
            _ => Look::Dashed,
        };
        upper = upper.with(name(found, fit), look, colour(n), curve(found, fit));
    }
    let caption = if oscillates {
        "model less record (open: loss modulus)"
    } else {
        "model less record"
    };
    let [of_all, of_loss] = parts(found, &residuals(found, chosen));
    let lower = Panel::new(caption, across, linear(residual))
        .with(name(found, chosen), Look::Markers, 0, of_all)
        .with("", Look::OpenMarkers, 0, of_loss);
    let title = format!("Identified from a record: {}", chosen.kind.name());
    let (source, kind, samples) = (short_name(source), found.kind.name(), found.samples);
    let modulus = match loading.modulus() {
        _ if !loading.is_known() => "",
        Modulus::Shear => " · shear modulus",
        Modulus::Young => " · Young's modulus",
    };
    let subtitle = format!("{source} · {kind} · {samples} samples{modulus}");
    page(&title, &subtitle, 1, &[upper, lower])
}

/// The values over time or frequency; of an oscillation those of the storage modulus, and then those of the loss modulus.
fn parts(found: &Identification, values: &[f64]) -> [Points; 2] {
    let pairs = found.x.iter().copied().zip(values.iter().copied());
    let mut first: Points = pairs.collect();
    let curves = 1 + usize::from(found.kind == RecordKind::Oscillation);
    let second = first.split_off(first.len() / curves);
    [first, second]
}

/// Places of a curve on a logarithmic axis.
const STEPS: usize = 400;

/// The curve of a model over the range of the record, finely where it has a closed form: not of a history, which has the motion of its
/// record, nor of a fit that came down to another model. Those have it where the record has a value.
fn curve(found: &Identification, fit: &Fit) -> Points {
    let (low, high) = ends(&found.x);
    let at: Vec<f64> = logarithmic(low, high, STEPS).collect();
    let over = |values: Vec<f64>| at.iter().copied().zip(values).collect::<Points>();
    let [first, second] = match (found.kind, fit.to_model()) {
        (RecordKind::Relaxation, Ok(model)) => [over(model.relaxation_moduli(&at)), Points::new()],
        (RecordKind::Creep, Ok(model)) if !found.is_staircase => {
            [over(model.creep_compliances(&at)), Points::new()]
        }
        (RecordKind::Oscillation, Ok(model)) => {
            let moduli = || at.iter().map(|omega| model.complex_modulus(*omega));
            [
                over(moduli().map(|modulus| modulus.re).collect()),
                over(moduli().map(|modulus| modulus.im).collect()),
            ]
        }
        (RecordKind::History | RecordKind::Creep, _) | (_, Err(_)) => {
            parts(found, &fit.predicted).map(apart)
        }
    };
    // A gap keeps the two curves of an oscillation apart.
    [first, vec![(f64::NAN, f64::NAN)], second].concat()
}

/// Points with a gap before each time that begins anew: several motions are several curves.
fn apart(points: Points) -> Points {
    let mut curves = Points::new();
    for point in points {
        if curves.last().is_some_and(|last| point.0 <= last.0) {
            curves.push((f64::NAN, f64::NAN));
        }
        curves.push(point);
    }
    curves
}

fn ends(x: &[f64]) -> (f64, f64) {
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    (low, x.iter().copied().fold(0.0, f64::max))
}

/// The axis of the record; a logarithmic one ends a little beyond it, not at the next power of ten.
fn across<'a>(axis: AxisSpec<'a>, x: &[f64]) -> AxisSpec<'a> {
    const BEYOND: f64 = 1.3;
    let (low, high) = ends(x);
    match axis.scale {
        Scale::Log => axis.between(low / BEYOND, BEYOND * high),
        Scale::Linear => axis,
    }
}

fn name(found: &Identification, fit: &Fit) -> String {
    if found.is_absolute {
        let key = match found.kind {
            RecordKind::Creep => "rms_per_pa",
            RecordKind::History | RecordKind::Relaxation | RecordKind::Oscillation => "rms_pa",
        };
        format!("{}, rms {}", fit.kind.name(), written(key, fit.rms))
    } else {
        let rms = digits(100.0 * relative(fit.rms), 3);
        format!("{}, rms {rms} %", fit.kind.name())
    }
}

/// Model less record: in % of it, or in its unit.
fn residuals(found: &Identification, fit: &Fit) -> Vec<f64> {
    let unit = if found.is_absolute { 1.0 } else { 100.0 };
    let values = found.residuals(fit).into_iter().map(|value| unit * value);
    values.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_tissue::ModelKind;
    use tissue_identification::{Options, Record, identify};

    #[test]
    fn a_model_at_a_third_of_the_record_is_67_percent_below_it() {
        let fit = Fit {
            kind: ModelKind::SpringPot,
            parameters: Vec::new(),
            correlation: Vec::new(),
            rms: 1.12,
            weighted: 1.12,
            aic: 0.0,
            bic: 0.0,
            predicted: vec![100.0 * (-1.12_f64).exp(), 110.0],
            independent: 1.0,
        };
        let mut found = Identification {
            kind: RecordKind::Relaxation,
            samples: 2,
            fits: vec![fit.clone()],
            x: vec![1.0, 2.0],
            measured: vec![100.0, 100.0],
            placement: Vec::new(),
            is_absolute: false,
            is_staircase: false,
            is_timed: true,
            warnings: Vec::new(),
        };
        let drawn = residuals(&found, &fit);
        assert!((drawn[0] + 67.37).abs() < 0.01, "{drawn:?}");
        assert!((drawn[1] - 10.0).abs() < 1e-9, "{drawn:?}");
        assert_eq!(name(&found, &fit), "spring-pot, rms 206 %");
        found.is_absolute = true;
        found.kind = RecordKind::Creep;
        assert_eq!(name(&found, &fit), "spring-pot, rms 1.12 Pa⁻¹");
        found.kind = RecordKind::Relaxation;
        let drawn = residuals(&found, &fit);
        assert!((drawn[1] - 10.0).abs() < 1e-9, "{drawn:?}");
    }
    /// Moduli of a spring-pot of 2 kPa·s^0.3: V·ω^α·cos and sin(πα/2) and V·t^(−α)/Γ(1−α), Γ(0.7) = 1.298 055 332 647 558.
    #[test]
    fn a_model_is_drawn_between_the_samples_too() {
        let alpha = 0.3;
        let x: Vec<f64> = (-2..3).map(|decade| 10_f64.powi(decade)).collect();
        let power = |sign: f64, factor: f64| -> Vec<f64> {
            x.iter()
                .map(|x| 2e3 * factor * x.powf(sign * alpha))
                .collect()
        };
        let angle = std::f64::consts::FRAC_PI_2 * alpha;
        let gamma = 1.298_055_332_647_558;
        let relaxation = Record::relaxation(x.clone(), power(-1.0, 1.0 / gamma));
        let oscillation =
            Record::oscillation(x.clone(), power(1.0, angle.cos()), power(1.0, angle.sin()));
        for (record, sign, factors) in [
            (relaxation, -1.0, vec![1.0 / gamma]),
            (oscillation, 1.0, vec![angle.cos(), angle.sin()]),
        ] {
            let options = Options {
                candidates: vec![ModelKind::SpringPot],
                ..Options::default()
            };
            let found = identify(&record.expect("a record"), &options, &|_| {}).expect("a fit");
            let drawn = curve(&found, &found.fits[0]);
            let curves: Vec<_> = drawn.split(|point| point.0.is_nan()).collect();
            for (curve, factor) in curves.iter().zip(&factors) {
                assert_eq!(curve.len(), STEPS);
                assert_eq!((curve[0].0, curve[STEPS - 1].0), (0.01, 100.0));
                // Steps of one ratio.
                let ratio = |n: usize| curve[n + 1].0 / curve[n].0;
                assert!((ratio(0) / ratio(STEPS / 2) - 1.0).abs() < 1e-12);
                for (x, y) in *curve {
                    let want = 2e3 * factor * x.powf(sign * alpha);
                    assert!((y / want - 1.0).abs() < 1e-6, "{x}: {y} {want}");
                }
            }
            assert!(curves[factors.len()..].iter().all(|curve| curve.is_empty()));
        }
    }
}
