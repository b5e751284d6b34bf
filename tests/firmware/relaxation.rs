//! The main job through the UART of the emulated device, opened by the real serial port code.

use super::board::Emulator;
use super::image::{Image, built};
use super::muscle;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_link::{
    Configuration, EventKind, Limits, LoopMode, Sample, Simulation, SimulationKind, Start,
};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond, Pascals, SquareMetres};
use haptic_loop::{Contact, Controller, SafetyChain, Specimen, SpringDamper, Tissue};
use haptic_remote::operator_shape;
use haptic_remote::serial::{ConnectOptions, Heard, SerialLink};
use haptic_tissue::SampledModel;
use std::time::Duration;

/// The device may be an emulator on a machine that has other work.
const WATCHDOG: Duration = Duration::from_secs(1);
const RAMP_TIME_S: f64 = 1.0;
const STRAIN: f64 = 0.05;

/// Cancerous prostate: 8.65 kPa·s^α, α = 0.2247, 4 cm² and 2 cm thick.
fn tissue() -> (Tissue, Specimen) {
    let order = Order::new(0.2247).expect("valid");
    let tissue = Tissue::new(Pascals(0.0), 8650.0, order).expect("valid");
    let specimen = Specimen::new(SquareMetres(4e-4), Metres(0.02)).expect("valid");
    (tissue, specimen)
}

fn operator<F: fracdiff::Real>(period_us: u32, ticks: u32) -> Operator<F> {
    let scheme: Scheme = "full".parse().expect("valid");
    let sample_time = Seconds(f64::from(period_us) * 1e-6);
    let (tissue, _) = tissue();
    let built = scheme.build(tissue.order(), sample_time, 1.05 * f64::from(ticks));
    built.expect("fits")
}

fn configuration(loop_mode: LoopMode, period_us: u32) -> Configuration {
    let (tissue, specimen) = tissue();
    let shape = specimen.area().0 / specimen.thickness().0;
    Configuration {
        loop_mode,
        tick_period_us: period_us,
        dissipation_n_s_mu_per_m: (shape * tissue.viscosity_pa_s_alpha()) as f32,
        order: 0.2247,
        one_sided: true,
        limits: Limits {
            watchdog_ms: 1000,
            late_ticks: 0,
            // Theory knows no limits.
            rise_time_s: 0.0,
            ..Limits::DEFAULT
        },
        simulation: Simulation {
            kind: SimulationKind::RigidIndentation,
            depth_m: (STRAIN * specimen.thickness().0) as f32,
            ramp_time_s: RAMP_TIME_S as f32,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    }
}

/// Largest relative error of the tissue's force against its closed form, from 0.1 s after the ramp on.
fn error(forces: &[(u32, f64)], period_us: u32) -> f64 {
    let (tissue, _) = tissue();
    error_of(forces, period_us, |times| {
        let stress = |&time_s: &f64| tissue.relaxation_stress(STRAIN, RAMP_TIME_S, time_s).0;
        times.iter().map(stress).collect()
    })
}

/// The same against the stresses at these times, Pa.
fn error_of(
    forces: &[(u32, f64)],
    period_us: u32,
    closed_form: impl Fn(&[f64]) -> Vec<f64>,
) -> f64 {
    let (_, specimen) = tissue();
    let timed = forces
        .iter()
        .map(|&(tick, force_n)| (f64::from(tick) * f64::from(period_us) * 1e-6, force_n));
    let (times, held): (Vec<f64>, Vec<f64>) = timed
        .filter(|(time_s, _)| *time_s >= RAMP_TIME_S + 0.1)
        .unzip();
    let theory = closed_form(&times);
    assert_eq!(theory.len(), held.len());
    let errors = held.iter().zip(theory).map(|(force_n, stress)| {
        let theory = specimen.force(Pascals(stress)).0;
        (-force_n / theory - 1.0).abs()
    });
    errors.fold(0.0, f64::max)
}

/// What a host finds on a device in an emulator, which runs in real time. `None` where there is no emulator.
fn emulated<T>(host: impl Fn(&Emulator) -> Result<T, String>) -> Option<T> {
    let emulator = Emulator::start(&built()?.path(Image::Device));
    Some(host(&emulator).unwrap_or_else(|why| panic!("{why}")))
}

fn connected(
    emulator: &Emulator,
    configuration: Configuration,
    values: &[f32],
) -> Result<SerialLink, String> {
    let options = ConnectOptions {
        patience: Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let mut link = SerialLink::connect(emulator.path(), options).map_err(told("connect"))?;
    link.set(configuration, values).map_err(told("configure"))?;
    Ok(link)
}

fn start(link: &mut SerialLink, ticks: u32) -> Result<(), String> {
    link.arm(WATCHDOG).map_err(told("arm"))?;
    let start = Start {
        ticks,
        ..Start::ENDLESS
    };
    link.start(start).map_err(told("start"))
}

/// An error as a reason.
fn told<E: std::fmt::Display>(what: &str) -> impl Fn(E) -> String {
    move |error| format!("{what}: {error}")
}

/// Samples of a run until its end is told.
fn samples(link: &mut SerialLink) -> Result<Vec<Sample>, String> {
    let mut samples: Vec<Sample> = Vec::new();
    loop {
        match link.hear(Duration::from_secs(20)) {
            Some(Heard::Sample(sample)) => samples.push(sample),
            Some(Heard::Event(event)) if event.kind == EventKind::Finished => return Ok(samples),
            Some(Heard::Event(_)) => {}
            other => return Err(format!("after {} samples: {other:?}", samples.len())),
        }
    }
}

/// Samples of a run in the device's loop, each lost one counted. `None` where there is no emulator.
fn device_loop(
    mut configuration: Configuration,
    operator: &Operator<f32>,
    ticks: u32,
) -> Option<Vec<(u32, f64)>> {
    let (shape, values) = operator_shape(operator).expect("short");
    configuration.operator = shape;
    let (samples, statistics, counters) = emulated(|emulator| {
        let mut link = connected(emulator, configuration, &values)?;
        start(&mut link, ticks)?;
        let samples = samples(&mut link)?;
        let statistics = link.statistics().map_err(told("statistics"))?;
        Ok((samples, statistics, link.report()))
    })?;
    assert!(
        samples.is_sorted_by(|one, next| one.tick < next.tick),
        "samples are out of order"
    );
    let last = samples.last().expect("samples");
    // A reader that gets no turn for longer than the device's queue lasts loses samples, and the device counts them.
    let missing = u64::from(last.tick) + 1 - samples.len() as u64;
    let counted = u64::from(statistics.samples_dropped)
        + u64::from(counters.host.lost)
        + counters.samples_dropped;
    println!("{missing} samples missing, {counted} counted as lost; {counters:?}");
    assert!(missing <= counted, "lost without being counted");
    assert_eq!(counters.host.corrupt, 0);
    if counted == 0 {
        assert!(last.tick + 1 >= ticks, "{}", last.tick);
        // It ends by itself with zero force.
        assert_eq!(last.axes[0].force_n.to_bits() << 1, 0, "{last:?}");
    }
    let run = samples.iter().take_while(|sample| sample.tick < ticks);
    let forces: Vec<(u32, f64)> = run
        .map(|s| (s.tick, f64::from(s.axes[0].force_n)))
        .collect();
    assert!(!forces.is_empty());
    Some(forces)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn five_seconds_in_the_devices_loop_lose_nothing_uncounted_and_follow_theory() {
    const TICKS: u32 = 5001;
    const PERIOD_US: u32 = 1000;
    let configuration = configuration(LoopMode::Device, PERIOD_US);
    let operator = operator::<f32>(PERIOD_US, TICKS);
    let Some(forces) = device_loop(configuration, &operator, TICKS) else {
        return;
    };
    let error = error(&forces, PERIOD_US);
    println!("device loop, {TICKS} ticks at 1 kHz: force within {error:.2e} of theory");
    assert!(error < 1e-4, "{error:e}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn elements_in_series_follow_theory_in_the_devices_loop() {
    const PERIOD_US: u32 = 1000;
    const TICKS: u32 = 5001;
    let (muscle, t) = (muscle::model(), Seconds(f64::from(PERIOD_US) * 1e-6));
    let sampled = SampledModel::new(&muscle, t).expect("valid");
    let (_, specimen) = tissue();
    let shape = specimen.area().0 / specimen.thickness().0;
    let configuration = Configuration {
        dissipation_n_s_mu_per_m: (shape * sampled.viscosity_pa_s_mu()) as f32,
        order: sampled.order().get() as f32,
        ..configuration(LoopMode::Device, PERIOD_US)
    };
    let operator = muscle::operator(t, 1.05 * f64::from(TICKS));
    let Some(forces) = device_loop(configuration, &operator, TICKS) else {
        return;
    };
    let error = error_of(&forces, PERIOD_US, |times| {
        let times: Vec<f64> = [0.0, RAMP_TIME_S].iter().chain(times).copied().collect();
        let strains: Vec<f64> = times
            .iter()
            .map(|time| STRAIN * (time / RAMP_TIME_S).min(1.0))
            .collect();
        muscle.stress(&times, &strains).split_off(2)
    });
    println!(
        "fractional Maxwell in the device loop, 5 s at 1 kHz: force within {error:.2e} of theory"
    );
    assert!(error < 1e-4, "{error:e}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_host_loop_loses_nothing_and_follows_theory() {
    // The emulated UART takes a force byte by byte, with a switch between two threads for each: on a busy machine a few hundred a
    // second.
    const PERIOD_US: u32 = 10_000;
    const TICKS: u32 = 501;
    let mut configuration = configuration(LoopMode::Host, PERIOD_US);
    // A host that gets no turn for a while answers late, and goes on.
    configuration.limits.max_age_ticks = Limits::MAX_AGE_TICKS;
    let done = emulated(|emulator| {
        let mut link = connected(emulator, configuration, &[0.0])?;
        let (tissue, specimen) = tissue();
        let law = SpringDamper::of_tissue(&tissue, &specimen, operator::<f64>(PERIOD_US, TICKS));
        let contact = Contact::at(Metres(0.0), law.expect("valid")).expect("valid");
        let sample_time = Seconds(f64::from(PERIOD_US) * 1e-6);
        let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1000.0), sample_time);
        let mut controller = Controller::<f64, 1, _>::new(contact, chain.expect("valid"));
        start(&mut link, 0)?;
        let mut forces = Vec::new();
        let mut engaged = controller.engage(link);
        for n in 0..TICKS {
            let sample = engaged
                .tick()
                .map_err(|error| format!("tick {n}: {error}"))?;
            if sample.reading.tick != u64::from(n) {
                // The device counts what its queue had no room for.
                let statistics = engaged.device().statistics().map_err(told("statistics"))?;
                let counted = u64::from(statistics.samples_dropped)
                    + u64::from(engaged.device().report().host.lost)
                    + engaged.device().report().samples_dropped
                    + engaged.device().report().forces_skipped;
                assert!(counted > 0, "tick {n}: a sample is missing and not counted");
                return Err(format!("tick {n}: {counted} samples were lost"));
            }
            forces.push((n, sample.force.newtons()[0]));
        }
        if let Err(error) = engaged.device().disarm() {
            // Its force is done: that it hears this late is no other result.
            println!("disarm: {error}");
            engaged.device().disarm().map_err(told("disarm, again"))?;
        }
        Ok((forces, engaged.device().report().forces_dropped))
    });
    let Some((forces, dropped)) = done else {
        return;
    };
    let error = error(&forces, PERIOD_US);
    println!("host loop, 5 s at 100 Hz: force within {error:.2e} of theory");
    // Ten times the sample time, ten times the error of sampling.
    assert!(error < 1e-3, "{error:e}");
    assert_eq!(dropped, 0);
}
