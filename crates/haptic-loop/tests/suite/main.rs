//! Tests of the public face of `haptic-loop`, in one binary.

mod controller;
mod coupler;
mod environments;
mod extraction;
#[cfg(feature = "plants")]
mod facing;
mod guard;
mod held_rig;
mod lets_go;
mod loading;
mod motion;
mod plant_parameters;
mod plants;
mod release;
mod rig;
mod safety;
mod sensors;
mod straight;
mod surfaces;

use fracdiff::{Real, Seconds, ShortMemory};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Environment, SafetyChain, SafetyLimits, SafetyState, SpringDamper};
use nalgebra::{SVector, vector};

const T: Seconds = Seconds(1e-3);

/// 10 N on each axis, 1 N a tick, everything else off.
const BARE: SafetyLimits = SafetyLimits::bare(Newtons(10.0), NewtonsPerSecond(1000.0));

type Memory = ShortMemory<f64, 64>;

fn memory(mu: f64) -> Memory {
    ShortMemory::new(testkit::operator::order(mu), T).expect("valid")
}

fn spring(stiffness: f64, dissipation: f64, mu: f64) -> SpringDamper<f64, Memory> {
    SpringDamper::new(stiffness, dissipation, memory(mu)).expect("valid")
}

fn chain(limits: SafetyLimits) -> SafetyChain<f64> {
    SafetyChain::from_limits(&limits, T).expect("valid")
}

/// A tick of one axis at this position, m, with this wanted force, N; the force that leaves the chain, N.
fn apply<F: Real>(chain: &SafetyChain<F>, state: &mut SafetyState<F, 1>, x: F, wanted: F) -> F {
    let (force, _) = chain.apply(state, &vector![x], &vector![wanted]);
    force.newtons()[0]
}

/// Positions through an environment, forces out.
fn forces<E: Environment<f64, D>, const D: usize>(
    environment: &E,
    path: impl IntoIterator<Item = SVector<f64, D>>,
) -> Vec<SVector<f64, D>> {
    let mut history = environment.at_rest();
    let forces = path.into_iter().map(|x| {
        let force = environment.force(&history, &x);
        environment.advance(&mut history, &x);
        force
    });
    forces.collect()
}
