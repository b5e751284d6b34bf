//! Figure 7.2 and claim 12: the loop renders the cancerous prostate on the simulated rig for 200 s.

use super::Kind;
use super::figure::{Axis, Curve, Figure, Panel, logarithmic};
use fracdiff::parameter::RangeError;
use haptic_analysis::AnalysisError;
use haptic_experiment::{ExperimentFile, Failure};
use haptic_figure::{Look, Scale};
use std::ops::ControlFlow;
use std::path::Path;

/// Errors count from here on, s: the ramp takes 1 s.
const FROM_S: f64 = 1.1;

/// Time, rendered force and closed form, sample by sample.
#[derive(Debug, Default)]
struct Relaxed {
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    theory_n: Vec<f64>,
}

/// Runs the relaxation of `host-cli relax`, with full memory 1e-6 for the exact operator.
///
/// # Errors
/// None: all parameters are constants.
fn relax(kind: Kind) -> Result<Relaxed, Failure> {
    let document = format!("[relax]\ntissue = \"prostate-cancerous\"\n{}", kind.line());
    let opened = ExperimentFile::parse(Path::new("reproduce"), &document)?;
    let Some(experiment) = opened.indentation() else {
        return Err(Failure::bad_input("not a relaxation"));
    };
    let mut relaxed = Relaxed::default();
    experiment.simulate(&mut |tick| {
        relaxed.time_s.push(tick.time_s);
        relaxed.force_n.push(0.0 - tick.commanded_force_n[0]);
        relaxed.theory_n.push(experiment.closed_form(tick.time_s));
        ControlFlow::Continue(())
    })?;
    Ok(relaxed)
}

/// The largest relative deviation from `factor` times the closed form, from 1.1 s on.
///
/// # Errors
/// As [`relax`].
pub(super) fn relaxation_error(kind: Kind, factor: f64) -> Result<f64, AnalysisError> {
    let relaxed = relax(kind).map_err(constants)?;
    let pairs = relaxed.force_n.iter().zip(&relaxed.theory_n);
    let late = (pairs.zip(&relaxed.time_s)).filter(|(_, time)| **time >= FROM_S);
    let errors = late.map(|((force, theory), _)| (force / (factor * theory) - 1.0).abs());
    Ok(errors.fold(0.0, f64::max))
}

/// Constants that were refused would be a defect.
pub(super) fn constants(_: Failure) -> AnalysisError {
    RangeError::new("parameter of the relaxation", f64::NAN, "valid", "").into()
}

pub(super) fn relaxation() -> Result<Figure, Failure> {
    let [exact, oustaloup, muir] = [
        relax(Kind::Exact)?,
        relax(Kind::Oustaloup)?,
        relax(Kind::Muir)?,
    ];
    // Points at equal steps of log t: what a picture can show of 200 001 samples.
    let last = exact.time_s.len() - 1;
    let mut picked: Vec<usize> = logarithmic(1.0, last as f64, 600)
        .map(|n| (n.round() as usize).min(last))
        .collect();
    picked.dedup();
    let curve = |name: &str, values: &[f64], look, colour| {
        let points = picked.iter().map(|&n| (exact.time_s[n], values[n]));
        Curve::new(name, points.collect(), look, colour)
    };
    let curves = vec![
        curve("tissue, closed form", &exact.theory_n, Look::Broad, 3),
        curve("simulated, full memory", &exact.force_n, Look::Line, 0),
        curve("simulated, Oustaloup", &oustaloup.force_n, Look::Line, 1),
        curve("warning: A₃ of chapter 4", &muir.force_n, Look::Line, 2),
    ];
    let panel = |caption: &str, scale| {
        let axes = [("time / s", "time_s"), ("force / N", "force_n")];
        let [x, y] = axes.map(|(label, column)| Axis {
            scale,
            ..Axis::linear(label, column)
        });
        Panel {
            repeats: scale == Scale::Log,
            ..Panel::new(caption, x, y, curves.clone())
        }
    };
    Ok(Figure {
        id: "7.2",
        title: "stress relaxation of the cancerous prostate",
        conditions:
            "5 % of 20 mm in 1 s, 4 cm², 1 kHz (our choices); simulated rig with compliant contact\n\
             Oustaloup, 9 sections from 10 µHz to 100 Hz, is of the dissertation's kind: fitted over frequencies\n\
             A₃ is not its operator here: the curve shows what the three samples of chapter 4 would do"
                .to_owned(),
        columns: 2,
        panels: vec![panel("linear", Scale::Linear), panel("log–log", Scale::Log)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tissue_has_a_curve_of_the_dissertations_kind_and_a_warning() {
        let figure = relaxation().expect("makes");
        let curves = &figure.panels[0].curves;
        let last = |name: &str| {
            let curve = curves.iter().find(|curve| curve.name.contains(name));
            curve.expect(name).points.last().expect("points").1
        };
        let closed_form = last("closed form");
        // Ratios of another program after 200 s at 1 kHz.
        for (name, want) in [("full memory", 1.0), ("Oustaloup", 1.006), ("A₃", 13.2)] {
            let ratio = last(name) / closed_form;
            assert!((ratio / want - 1.0).abs() < 2e-3, "{name}: {ratio}");
        }
        let muir = curves.iter().find(|curve| curve.name.contains("A₃"));
        assert!(muir.expect("drawn").name.starts_with("warning"));
    }
}
