//! Figure 7.2 made again: the loop renders the cancerous prostate on the simulated rig for 200 s.

use super::Kind;
use fracdiff::full_memory::Kernel;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::AnalysisError;
use haptic_loop::plant::{IndentationRig, RampHold, RigConfig, RigContact, RigDrive};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond, Pascals, SquareMetres};
use haptic_loop::{
    Contact, Controller, KelvinVoigt, ParameterError, SafetyChain, Specimen, Tissue,
};

/// η in Pa·s^α and α of (7.2).
const VISCOSITY: f64 = 8650.0;
const ORDER: f64 = 0.2247;
/// Strain, ramp time s, duration s, sample time s: the choices of `host-cli relax`.
const STRAIN: f64 = 0.05;
const RAMP_S: f64 = 1.0;
const DURATION_S: f64 = 200.0;
const T: Seconds = Seconds(1e-3);

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

/// Runs the relaxation with A₃, or with full memory 1e-6 for the exact operator.
///
/// # Errors
/// None: all parameters are constants.
pub fn relax(kind: Kind) -> Result<Relaxed, AnalysisError> {
    let scheme = match kind {
        Kind::Muir => kind.scheme(),
        Kind::Exact => Scheme::Full {
            kernel: Kernel::Grunwald,
            tolerance: 1e-6,
        },
    };
    let samples = (DURATION_S / T.0) as usize + 1;
    let operator: Operator<f64> = scheme.build(Order::new(ORDER)?, T, 1.05 * samples as f64)?;
    let (mut controller, mut rig, tissue, specimen) = setup(operator).map_err(constants)?;
    let mut relaxed = Relaxed {
        time_s: Vec::with_capacity(samples),
        force_n: Vec::with_capacity(samples),
        theory_n: Vec::with_capacity(samples),
    };
    for _ in 0..samples {
        let sample = match controller.tick(&mut rig) {
            Ok(sample) => sample,
            Err(never) => match never {},
        };
        let time = sample.reading.time_s;
        relaxed.time_s.push(time);
        relaxed.force_n.push(0.0 - sample.force.newtons()[0]);
        let stress = tissue.relaxation_stress(STRAIN, RAMP_S, time);
        relaxed.theory_n.push(specimen.force(stress).0);
    }
    Ok(relaxed)
}

type Loop = Controller<f64, 1, Contact<f64, KelvinVoigt<f64, Operator<f64>>, 1>>;

fn setup(
    operator: Operator<f64>,
) -> Result<(Loop, IndentationRig, Tissue, Specimen), ParameterError> {
    let tissue = Tissue::new(Pascals(0.0), VISCOSITY, Order::new(ORDER)?)?;
    let specimen = Specimen::new(SquareMetres(4e-4), Metres(0.02))?;
    let environment = Contact::at(Metres(0.0), KelvinVoigt::new(&tissue, &specimen, operator)?)?;
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1000.0), T)?;
    let profile = RampHold::new(specimen.displacement(STRAIN), Seconds(RAMP_S))?;
    let config = RigConfig::new(RigDrive::Position(profile), RigContact::COMPLIANT, T);
    let rig = IndentationRig::new(config)?;
    Ok((Controller::new(environment, chain), rig, tissue, specimen))
}

/// Constants that were refused would be a defect; say which.
fn constants(error: ParameterError) -> AnalysisError {
    match error {
        ParameterError::Range {
            what,
            value,
            allowed,
            unit,
        } => AnalysisError::Range {
            what,
            value,
            allowed,
            unit,
        },
        ParameterError::Operator(error) => error.into(),
        _ => AnalysisError::Range {
            what: "parameter of the relaxation",
            value: f64::NAN,
            allowed: "valid",
            unit: "",
        },
    }
}

/// The largest relative deviation from `factor` times the closed form, from 1.1 s on.
///
/// # Errors
/// As [`relax`].
pub fn relaxation_error(kind: Kind, factor: f64) -> Result<f64, AnalysisError> {
    let relaxed = relax(kind)?;
    let pairs = relaxed.force_n.iter().zip(&relaxed.theory_n);
    let errors = pairs
        .zip(&relaxed.time_s)
        .filter(|(_, time)| **time >= RAMP_S + 0.1);
    Ok(errors
        .map(|((force, theory), _)| (force / (factor * theory) - 1.0).abs())
        .fold(0.0, f64::max))
}
