//! Time of a whole controller tick, of a simulated plant's step, and of a relaxation.
//!
//! ```text
//! cargo benches --bench loop                    all, one minute
//! cargo benches --bench loop -- relaxation      one group
//! ```
//! - *Unit*: an iteration of `tick` and `plant` is 1000 ticks (criterion's timer then counts for
//!   nothing), so its µs are ns per tick. A `relaxation` is 20 000 samples; criterion's elem/s are
//!   samples per second. Quote the median, `target/criterion/GROUP/NAME/new/estimates.json`.
//! - *State when quoting*: processor, rustc, flags (`target-cpu`, profile), date. On a busy machine run it
//!   under `chrt -f 10 taskset -c 1` (as root).
//! - *A tick* is read, force, safety chain, write, advance. The scripted device presses 1 mm deep again
//!   and again and only keeps the force; the rig is the compliant one of the relaxation experiment.
//!   Tissue: cancerous prostate, 4 cm² by 20 mm, full memory at 1e-6 for 200 s, 1 kHz.
//! - *Nothing is left out*: controller, device and sample pass through `black_box` in each tick.
//! - *Compare with*, in the same run: the tick without an operator ("nothing") and with the naive sum of
//!   1024 taps (`benches/baseline`); for relaxation all 20 000 taps.
//! - *Two and three axes* touch a disc and a sphere: one operator on the depth, whatever the number of axes. `axes` in the output is
//!   their tick over that of one axis, whole chain and guard: least of 200 rounds of 1000 ticks, taken in turn.
//! - *Relaxation* is the command line's loop without clock, log, CSV and picture; it keeps the forces.

mod baseline;
mod input;
mod press;

use baseline::{ModuloRing, Nothing};
use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, Throughput};
use fractional_haptics::fracdiff::{Differintegrator, Real, Seconds};
use fractional_haptics::haptic_loop::plant::{
    IndentationRig, MassDamper, MassDamperConfig, RampHold, RigConfig, RigContact, RigDrive,
};
use fractional_haptics::haptic_loop::units::{
    Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond,
};
use fractional_haptics::haptic_loop::{
    Ball, Contact, Controller, Device, Environment, SafetyChain, SafetyLimits, SafetyState,
    SpringDamper,
};
use input::{BATCH, SAMPLE_TIME, ramp_and_hold};
use nalgebra::SVector;
use press::{Scripted, contact, guards, operator, short_runs, tissue, whole};
use std::convert::Infallible;
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Samples of a relaxation: 20 s.
const SAMPLES: u16 = 20_000;

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    let mut criterion = short_runs();
    ticks::<f64>(&mut criterion, "f64")?;
    ticks::<f32>(&mut criterion, "f32")?;
    plants(&mut criterion)?;
    relaxations::<f64>(&mut criterion, "f64")?;
    relaxations::<f32>(&mut criterion, "f32")?;
    axes::<f64>("f64")?;
    axes::<f32>("f32")?;
    criterion.final_summary();
    Ok(())
}

fn ticks<F: Real>(criterion: &mut Criterion, precision: &str) -> Outcome {
    let mut group = criterion.benchmark_group(format!("tick {precision}"));
    group.throughput(Throughput::Elements(BATCH as u64));
    let full = operator::<F>("full:1e-6", 200e3)?;
    let script = Scripted::<F, 1>::new();
    tick(&mut group, "nothing", contact([1.0], Nothing)?, script)?;
    tick(&mut group, "D=1", contact([1.0], full.clone())?, script)?;
    let (plane, script_3) = ([1.0, 2.0, 2.0], Scripted::<F, 3>::new());
    tick(&mut group, "D=3", contact(plane, full.clone())?, script_3)?;
    // Without the plane each of the axes has its own history.
    let axes = tissue(full.clone())?;
    tick(&mut group, "D=3, three histories", axes, script_3)?;
    let rig = rig(RigContact::COMPLIANT)?;
    tick(&mut group, "D=1, rig", contact([1.0], full)?, rig)?;
    let ring = contact([1.0], ModuloRing::<F, 1024>::new())?;
    tick(&mut group, "naive % ring 1024", ring, script)?;
    group.finish();
    Ok(())
}

fn tick<F: Real, const D: usize>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    environment: impl Environment<F, D>,
    device: impl Device<F, D, Error = Infallible>,
) -> Outcome {
    let mut engaged = Controller::new(environment, chain()?).into_engaged(device);
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for _ in 0..BATCH {
                let Ok(sample) = black_box(&mut engaged).tick();
                black_box(&sample);
            }
        });
    });
    Ok(())
}

/// Prints the tick of two and three axes over that of one.
fn axes<F: Real>(precision: &str) -> Outcome {
    let full = operator::<F>("full:1e-6", 200e3)?;
    for (name, guard) in guards() {
        let limits = whole(guard);
        let wall = contact([1.0], full.clone())?;
        let mut one = batch(wall, &limits, Scripted::<F, 1>::new())?;
        let disc = touched::<F, _, 2>(full.clone())?;
        let mut two = batch(disc, &limits, Scripted::<F, 2>::new())?;
        let sphere = touched::<F, _, 3>(full.clone())?;
        let mut three = batch(sphere, &limits, Scripted::<F, 3>::new())?;
        let mut least = [f64::INFINITY; 3];
        for _ in 0..200 {
            for (least, took) in least.iter_mut().zip([one(), two(), three()]) {
                *least = least.min(took);
            }
        }
        let [one, two, three] = least.map(|seconds| 1e9 * seconds / BATCH as f64);
        println!(
            "axes {precision}, {name}: {one:.0} ns, {two:.0} ns = {:.2} times, {three:.0} ns = {:.2} times",
            two / one,
            three / one
        );
    }
    Ok(())
}

/// A batch of ticks, s.
fn batch<F: Real, const D: usize>(
    environment: impl Environment<F, D>,
    limits: &SafetyLimits,
    device: impl Device<F, D, Error = Infallible>,
) -> Result<impl FnMut() -> f64, Box<dyn Error>> {
    let chain = SafetyChain::from_limits(limits, SAMPLE_TIME)?;
    let mut engaged = Controller::new(environment, chain).into_engaged(device);
    Ok(move || {
        let before = Instant::now();
        for _ in 0..BATCH {
            let Ok(sample) = black_box(&mut engaged).tick();
            black_box(&sample);
        }
        before.elapsed().as_secs_f64()
    })
}

fn plants(criterion: &mut Criterion) -> Outcome {
    let mut group = criterion.benchmark_group("plant f64");
    group.throughput(Throughput::Elements(BATCH as u64));
    let (mass, damping) = (Kilograms(0.065), NewtonSecondsPerMetre(3.5));
    let ideal = MassDamperConfig::ideal(mass, damping, SAMPLE_TIME);
    let real = MassDamperConfig {
        stiffness: NewtonsPerMetre(300.0),
        friction: Newtons(0.1),
        delay: Seconds(1.5e-3),
        saturation: Some(Newtons(10.0)),
        lag: Seconds(0.5e-3),
        ..ideal
    };
    plant::<1>(&mut group, "MassDamper D=1", MassDamper::new(ideal)?)?;
    plant::<3>(&mut group, "MassDamper D=3", MassDamper::new(ideal)?)?;
    let real = MassDamper::new(real)?;
    plant::<1>(&mut group, "MassDamper D=1, all effects", real)?;
    let (rigid, compliant) = (rig(RigContact::Rigid)?, rig(RigContact::COMPLIANT)?);
    plant(&mut group, "IndentationRig, rigid", rigid)?;
    plant(&mut group, "IndentationRig, compliant", compliant)?;
    group.finish();
    Ok(())
}

/// A write and the read after it.
fn plant<const D: usize>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    mut device: impl Device<f64, D, Error = Infallible>,
) -> Outcome {
    let (chain, mut state) = (chain::<f64>()?, SafetyState::default());
    // There and back, so that nothing runs off to infinity.
    let forces = ramp_and_hold::<f64>().map(|x| {
        let wanted = SVector::from([200.0 * x - 0.09; D]);
        chain.apply(&mut state, &SVector::zeros(), &wanted).0
    });
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for &force in &forces {
                let device = black_box(&mut device);
                let Ok(()) = device.write(force);
                let Ok(reading) = device.read();
                black_box(&reading);
            }
        });
    });
    Ok(())
}

fn relaxations<F: Real>(criterion: &mut Criterion, precision: &str) -> Outcome {
    let mut group = criterion.benchmark_group(format!("relaxation {precision}"));
    group.throughput(Throughput::Elements(SAMPLES.into()));
    group.sample_size(20);
    // The last is a baseline: the whole history as taps.
    for scheme in ["full:1e-6", "full:1e-9", "grunwald:1024", "grunwald:20000"] {
        let environment = contact([1.0], operator::<F>(scheme, SAMPLES.into())?)?;
        let fresh = (
            Controller::new(environment, chain()?),
            rig(RigContact::COMPLIANT)?,
        );
        group.bench_function(scheme, |bencher| {
            bencher.iter_batched_ref(
                || (fresh.clone(), Vec::with_capacity(SAMPLES.into())),
                |((controller, device), forces)| {
                    let mut engaged = controller.engage(device);
                    for _ in 0..SAMPLES {
                        let Ok(sample) = engaged.tick();
                        forces.push(sample.force.newtons()[0]);
                    }
                    black_box(forces.last().copied())
                },
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
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
