//! Figure 7.2 made again: the loop renders the cancerous prostate on the simulated rig for 200 s.

use super::Kind;
use haptic_analysis::AnalysisError;
use haptic_experiment::{Failure, ModelledTissue, Relaxation, Rendering};
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
    let material = ModelledTissue::new(material).map_err(Failure::input)?;
    let mut rendering = Rendering::new(material)?;
    if kind == Kind::Muir {
        rendering.scheme = kind.scheme();
    }
    let experiment = Relaxation::of(rendering);
    let samples = experiment.check()? as usize;
    let mut relaxed = Relaxed {
        time_s: Vec::with_capacity(samples),
        force_n: Vec::with_capacity(samples),
        theory_n: Vec::with_capacity(samples),
    };
    experiment.simulate(&mut |tick| {
        relaxed.time_s.push(tick.time_s);
        relaxed.force_n.push(0.0 - tick.force_n);
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
    AnalysisError::Range {
        what: "parameter of the relaxation",
        value: f64::NAN,
        allowed: "valid",
        unit: "",
    }
}
