//! Figure 7.2 made again: the loop renders the cancerous prostate on the simulated rig for 200 s.

use super::Kind;
use super::figure::{Axis, Curve, Figure, Panel, logarithmic};
use fracdiff::parameter::RangeError;
use haptic_analysis::AnalysisError;
use haptic_experiment::{Failure, Indentation, ModelledTissue, Rendering};
use haptic_figure::{Look, Scale};
use haptic_tissue::Library;
use std::ops::ControlFlow;

/// Errors count from here on, s: the ramp takes 1 s.
const FROM_S: f64 = 1.1;

/// Time, rendered force and closed form, sample by sample.
#[derive(Clone, Debug)]
pub struct Relaxed {
    /// s.
    pub time_s: Vec<f64>,
    /// N.
    pub force_n: Vec<f64>,
    /// N.
    pub theory_n: Vec<f64>,
}

/// Runs the relaxation of `host-cli relax` with A₃, or with full memory 1e-6 for the exact operator.
///
/// # Errors
/// None: all parameters are constants.
pub fn relax(kind: Kind) -> Result<Relaxed, Failure> {
    let library = Library::load(None).map_err(Failure::input)?;
    let material = library.find("prostate-cancerous").map_err(Failure::input)?;
    let material = ModelledTissue::new(material)?;
    let mut rendering = Rendering::new(material)?;
    if kind == Kind::Muir {
        rendering.scheme = kind.scheme();
    }
    let experiment = Indentation::relaxation(rendering);
    let samples = experiment.check()? as usize;
    let mut relaxed = Relaxed {
        time_s: Vec::with_capacity(samples),
        force_n: Vec::with_capacity(samples),
        theory_n: Vec::with_capacity(samples),
    };
    experiment.simulate(&mut |tick| {
        relaxed.time_s.push(tick.time_s);
        relaxed.force_n.push(0.0 - tick.commanded_force_n);
        relaxed.theory_n.push(experiment.closed_form(tick.time_s));
        ControlFlow::Continue(())
    })?;
    Ok(relaxed)
}

/// The largest relative deviation from `factor` times the closed form, from 1.1 s on.
///
/// # Errors
/// As [`relax`].
pub fn relaxation_error(kind: Kind, factor: f64) -> Result<f64, AnalysisError> {
    let relaxed = relax(kind).map_err(constants)?;
    let pairs = relaxed.force_n.iter().zip(&relaxed.theory_n);
    let errors = pairs
        .zip(&relaxed.time_s)
        .filter(|(_, time)| **time >= FROM_S);
    Ok(errors
        .map(|((force, theory), _)| (force / (factor * theory) - 1.0).abs())
        .fold(0.0, f64::max))
}

/// Constants that were refused would be a defect.
fn constants(_: Failure) -> AnalysisError {
    RangeError::new("parameter of the relaxation", f64::NAN, "valid", "").into()
}

pub(super) fn relaxation() -> Result<Figure, Failure> {
    let exact = relax(Kind::Exact)?;
    let muir = relax(Kind::Muir)?;
    // Points at equal steps of log t: what a picture can show of 200 001 samples.
    let last = exact.time_s.len() - 1;
    let mut picked: Vec<usize> = logarithmic(1.0, last as f64, 600)
        .map(|n| (n.round() as usize).min(last))
        .collect();
    picked.dedup();
    let curve = |name: &str, values: &[f64], look, colour| Curve {
        name: name.to_owned(),
        legend: name.to_owned(),
        points: picked
            .iter()
            .map(|&n| (exact.time_s[n], values[n]))
            .collect(),
        look,
        colour,
    };
    let curves = vec![
        curve("tissue, closed form", &exact.theory_n, Look::Broad, 3),
        curve("simulated, full memory", &exact.force_n, Look::Line, 0),
        curve("simulated, A₃", &muir.force_n, Look::Line, 2),
    ];
    let panel = |caption: &str, scale| Panel {
        caption: caption.to_owned(),
        x: Axis {
            scale,
            ..Axis::linear("time / s", "time_s")
        },
        y: Axis {
            scale,
            ..Axis::linear("force / N", "force_n")
        },
        curves: curves.clone(),
        repeats: scale == Scale::Log,
    };
    Ok(Figure {
        id: "7.2",
        title: "stress relaxation of the cancerous prostate",
        conditions:
            "5 % of 20 mm in 1 s, 4 cm², 1 kHz (our choices); simulated rig with compliant contact"
                .to_owned(),
        columns: 2,
        panels: vec![panel("linear", Scale::Linear), panel("log–log", Scale::Log)],
    })
}
