//! End to end, as firmware would run it: a tissue with const-generic full memory, on the rig, in both
//! precisions, against the defining sum of the recorded indentation and against the closed form.

use fracdiff::full_memory::{Design, FullMemory, Kernel};
use fracdiff::{Differintegrator, Order, Real, Seconds, grunwald_weights};
use haptic_loop::plant::{IndentationRig, RampHold, RigConfig, RigContact, RigDrive};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond, Pascals, SquareMetres};
use haptic_loop::{
    Contact, Controller, Device, Modulus, SafetyChain, Specimen, SpringDamper, Tissue,
};

const T: Seconds = Seconds(1e-3);
const ORDER: f64 = 0.2247;
const VISCOSITY: f64 = 8650.0;
/// 5 % strain of 20 mm in 0.5 s.
const DEPTH: f64 = 1e-3;
const RAMP: f64 = 0.5;
/// 6 s: enough for a direct sum, O(N²).
const SAMPLES: usize = 6000;

fn order() -> Order {
    Order::new(ORDER).expect("valid")
}

fn tissue() -> Tissue {
    Tissue::new(Pascals(0.0), VISCOSITY, order()).expect("valid")
}

fn specimen() -> Specimen {
    Specimen::slab(SquareMetres(4e-4), Metres(0.02)).expect("valid")
}

fn rig(contact: RigContact) -> IndentationRig {
    let profile = RampHold::new(Metres(DEPTH), Seconds(RAMP)).expect("valid");
    IndentationRig::new(RigConfig::new(RigDrive::Position(profile), contact, T)).expect("valid")
}

/// Positions and reaction forces of a run.
fn run<F: Real, O: Differintegrator<F>>(
    operator: O,
    device: impl Device<F, 1, Error = core::convert::Infallible>,
) -> (Vec<f64>, Vec<f64>) {
    let dissipation = specimen().shape(Modulus::Young) * tissue().viscosity_pa_s_alpha();
    let rendered = SpringDamper::new(0.0, dissipation, operator).expect("valid");
    let environment = Contact::at(Metres(0.0), rendered).expect("valid");
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1000.0), T).expect("valid");
    let mut controller = Controller::new(environment, chain);
    let mut engaged = controller.engage(device);
    (0..SAMPLES)
        .map(|_| {
            let Ok(sample) = engaged.tick();
            assert_eq!(sample.limiters.bits(), 0, "no limiter has a reason to act");
            let position = sample.reading.position_m[0].to_f64();
            (position, -sample.force.newtons()[0].to_f64())
        })
        .unzip()
}

fn full<F: Real>() -> FullMemory<F, 16, 32> {
    let design = Design::pruned(Kernel::Grunwald, order(), 1e-6, 2e5).expect("fits");
    FullMemory::new(&design, T).expect("valid")
}

/// Force by the definition: `(A/ℓ)·η·T^(−μ)·Σ c_j·x[n−j]` at sample n.
fn defining_sum(positions: &[f64], n: usize, weights: &[f64]) -> f64 {
    let sum: f64 = (0..=n)
        .rev()
        .map(|j| weights[j] * positions[n - j].max(0.0))
        .sum();
    4e-4 / 0.02 * VISCOSITY * T.0.powf(-ORDER) * sum
}

/// Largest relative deviation from the defining sum, from 10 ms on.
fn deviation(positions: &[f64], forces: &[f64]) -> f64 {
    let weights: Vec<f64> = grunwald_weights(order()).take(SAMPLES).collect();
    (10..SAMPLES)
        .map(|n| (forces[n] / defining_sum(positions, n, &weights) - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn the_commanded_force_is_that_of_the_full_history() {
    let (positions, forces) = run(full::<f64>(), rig(RigContact::COMPLIANT));
    let double = deviation(&positions, &forces);
    assert!(double < 1e-5, "f64: {double:e}");
    let (positions, forces) = run(full::<f32>(), rig(RigContact::COMPLIANT));
    let single = deviation(&positions, &forces);
    assert!(single < 1e-4, "f32: {single:e}");
}

#[test]
fn the_commanded_force_is_that_of_the_tissue() {
    for (contact, tolerance) in [(RigContact::Rigid, 2e-4), (RigContact::COMPLIANT, 5e-3)] {
        let (_, forces) = run(full::<f64>(), rig(contact));
        for n in (600..SAMPLES).step_by(50) {
            let stress = tissue().relaxation_stress(0.05, RAMP, n as f64 * T.0);
            let want = 4e-4 * stress.0;
            // Sampling alone: (μT/2)·|F'/F|, at 0.1 s after a ramp of 0.5 s 1.2e-4.
            let error = (forces[n] / want - 1.0).abs();
            assert!(error < tolerance, "{contact:?} sample {n}: {error:e}");
        }
    }
}
