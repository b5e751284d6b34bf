//! Time of a whole controller tick, of a simulated plant's step, and of a relaxation.
//!
//! ```text
//! cargo benches --bench loop                    all, one minute
//! cargo benches --bench loop -- relaxation      the groups of this name
//! ```
//! - *Unit*: ns a tick, the least of some hundred runs of 1000 ticks, or of 20 000 samples of a relaxation; and that over the first of its group.
//! - *State when quoting*: processor, rustc, flags (`target-cpu`, profile), date. On a busy machine run it
//!   under `chrt -f 10 taskset -c 1` (as root).
//! - *A tick* is read, force, safety chain, write, advance. The scripted device presses 1 mm deep again
//!   and again and only keeps the force; the rig is the compliant one of the relaxation experiment.
//!   Tissue: cancerous prostate, 4 cm² by 20 mm, full memory at 1e-6 for 200 s, 1 kHz.
//! - *Nothing is left out*: controller, device and sample pass through `black_box` in each tick.
//! - *Compare with*, in the same run: the tick without an operator ("nothing") and with the naive sum of
//!   1024 taps (`benches/baseline`); for relaxation all 20 000 taps.
//! - *Two and three axes* touch a disc and a sphere: one operator on the depth, whatever the number of axes; whole chain and guard.
//! - *Relaxation* is the command line's loop without clock, log, CSV and picture; it keeps the forces.

mod baseline;
mod input;
mod press;
mod timing;

use baseline::{ModuloRing, Nothing};
use fractional_haptics::fracdiff::{Differintegrator, Real, Seconds};
use fractional_haptics::haptic_loop::plant::{
    IndentationRig, MassDamper, MassDamperConfig, RampHold, RigConfig, RigContact, RigDrive,
};
use fractional_haptics::haptic_loop::units::{
    Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond,
};
use fractional_haptics::haptic_loop::{
    Ball, Contact, Controller, Device, Environment, SafetyChain, SafetyState, SpringDamper,
};
use input::{BATCH, SAMPLE_TIME, ramp_and_hold};
use nalgebra::SVector;
use press::{Scripted, contact, guards, operator, tissue, whole};
use std::convert::Infallible;
use std::error::Error;
use std::hint::black_box;
use timing::{Timed, compare, timed};

/// Samples of a relaxation: 20 s.
const SAMPLES: usize = 20_000;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

fn main() -> Outcome {
    ticks::<f64>("f64")?;
    ticks::<f32>("f32")?;
    plants()?;
    relaxations::<f64>("f64")?;
    relaxations::<f32>("f32")?;
    axes::<f64>("f64")?;
    axes::<f32>("f32")
}

fn ticks<F: Real>(precision: &str) -> Outcome {
    let full = operator::<F>("full:1e-6", 200e3)?;
    let (script, script_3) = (Scripted::<F, 1>::new(), Scripted::<F, 3>::new());
    let (plane, ring) = ([1.0, 2.0, 2.0], ModuloRing::<F, 1024>::new());
    // Without the plane each of the axes has its own history.
    let axes = tissue(full.clone())?;
    let rig = rig(RigContact::COMPLIANT)?;
    let runs = vec![
        tick("nothing", contact([1.0], Nothing)?, chain()?, script),
        tick("D=1", contact([1.0], full.clone())?, chain()?, script),
        tick("D=3", contact(plane, full.clone())?, chain()?, script_3),
        tick("D=3, three histories", axes, chain()?, script_3),
        tick("D=1, rig", contact([1.0], full)?, chain()?, rig),
        tick("naive % ring 1024", contact([1.0], ring)?, chain()?, script),
    ];
    compare(&format!("tick {precision}"), 200, runs);
    Ok(())
}

/// A batch of ticks.
fn tick<F: Real, const D: usize>(
    name: &str,
    environment: impl Environment<F, D> + 'static,
    chain: SafetyChain<F>,
    device: impl Device<F, D, Error = Infallible> + 'static,
) -> Timed<'static> {
    let mut engaged = Controller::new(environment, chain).into_engaged(device);
    timed(name, move || {
        for _ in 0..BATCH {
            let Ok(sample) = black_box(&mut engaged).tick();
            black_box(&sample);
        }
        BATCH
    })
}

fn axes<F: Real>(precision: &str) -> Outcome {
    let full = operator::<F>("full:1e-6", 200e3)?;
    for (guard, limits) in guards().map(|(name, guard)| (name, whole(guard))) {
        let chain = || SafetyChain::from_limits(&limits, SAMPLE_TIME);
        let wall = contact([1.0], full.clone())?;
        let disc = touched::<F, _, 2>(full.clone())?;
        let sphere = touched::<F, _, 3>(full.clone())?;
        let runs = vec![
            tick("one", wall, chain()?, Scripted::<F, 1>::new()),
            tick("two", disc, chain()?, Scripted::<F, 2>::new()),
            tick("three", sphere, chain()?, Scripted::<F, 3>::new()),
        ];
        compare(&format!("axes {precision}, {guard}"), 200, runs);
    }
    Ok(())
}

fn plants() -> Outcome {
    let (mass, damping) = (Kilograms(0.065), NewtonSecondsPerMetre(3.5));
    let ideal = MassDamperConfig::ideal(mass, damping, SAMPLE_TIME);
    let real = MassDamperConfig {
        stiffness: NewtonsPerMetre(300.0),
        friction: Newtons(0.1),
        delay: Seconds(1.5e-3),
        saturation: Some(Newtons(10.0)),
        current_lag: Seconds(0.5e-3),
        ..ideal
    };
    let real = MassDamper::new(real)?;
    let (rigid, compliant) = (rig(RigContact::Rigid)?, rig(RigContact::COMPLIANT)?);
    let runs = vec![
        plant::<1>("MassDamper D=1", MassDamper::new(ideal)?)?,
        plant::<3>("MassDamper D=3", MassDamper::new(ideal)?)?,
        plant::<1>("MassDamper D=1, all effects", real)?,
        plant("IndentationRig, rigid", rigid)?,
        plant("IndentationRig, compliant", compliant)?,
    ];
    compare("plant f64", 200, runs);
    Ok(())
}

/// A write and the read after it.
fn plant<const D: usize>(
    name: &str,
    mut device: impl Device<f64, D, Error = Infallible> + 'static,
) -> Outcome<Timed<'static>> {
    let (chain, mut state) = (chain::<f64>()?, SafetyState::default());
    // There and back, so that nothing runs off to infinity.
    let forces = ramp_and_hold::<f64>().map(|x| {
        let wanted = SVector::from([200.0 * x - 0.09; D]);
        chain.apply(&mut state, &SVector::zeros(), &wanted).0
    });
    Ok(timed(name, move || {
        for &force in &forces {
            let device = black_box(&mut device);
            let Ok(()) = device.write(force);
            let Ok(reading) = device.read();
            black_box(&reading);
        }
        BATCH
    }))
}

fn relaxations<F: Real>(precision: &str) -> Outcome {
    let mut runs = Vec::new();
    // The last is a baseline: the whole history as taps.
    for scheme in ["full:1e-6", "full:1e-9", "grunwald:1024", "grunwald:20000"] {
        let environment = contact([1.0], operator::<F>(scheme, SAMPLES as f64)?)?;
        let controller = Controller::new(environment, chain()?);
        let rig = rig(RigContact::COMPLIANT)?;
        runs.push(timed(scheme, move || {
            let (mut controller, mut device) = (controller.clone(), rig.clone());
            let mut engaged = controller.engage(&mut device);
            let forces = (0..SAMPLES).map(|_| {
                let Ok(sample) = engaged.tick();
                sample.force.newtons()[0]
            });
            black_box(forces.collect::<Vec<F>>()).len()
        }));
    }
    compare(&format!("relaxation {precision}"), 20, runs);
    Ok(())
}

/// Kelvin–Voigt tissue in the form of a ball.
type SoftBall<F, O, const D: usize> = Contact<F, SpringDamper<F, O>, D, Ball<F, D>>;

/// A disc or sphere whose surface goes through the origin, met along the diagonal.
fn touched<F: Real, O: Differintegrator<F>, const D: usize>(
    operator: O,
) -> Result<SoftBall<F, O, D>, Box<dyn Error>> {
    const RADIUS_M: f64 = 0.03;
    let centre = Metres(RADIUS_M / (D as f64).sqrt());
    let ball = Ball::solid([centre; D], Metres(RADIUS_M))?;
    Ok(Contact::behind(ball, tissue(operator)?))
}

fn chain<F: Real>() -> Result<SafetyChain<F>, Box<dyn Error>> {
    let (force, rate) = (Newtons(10.0), NewtonsPerSecond(1000.0));
    Ok(SafetyChain::new(force, rate, SAMPLE_TIME)?)
}

fn rig(contact: RigContact) -> Result<IndentationRig, Box<dyn Error>> {
    let press = RigDrive::Position(RampHold::new(Metres(1e-3), Seconds(1.0))?);
    Ok(IndentationRig::new(RigConfig::new(
        press,
        contact,
        SAMPLE_TIME,
    ))?)
}
