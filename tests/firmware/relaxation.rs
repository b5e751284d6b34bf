//! The main job through the UART of the emulated device, opened by the real serial port code.

use super::board::Emulator;
use super::image::{Image, built};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_link::{
    Configuration, EventKind, Limits, LoopMode, Sample, Simulation, SimulationKind, Start,
};
use haptic_loop::remote::operator_shape;
use haptic_loop::remote::serial::{ConnectOptions, Heard, SerialLink};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond, Pascals, SquareMetres};
use haptic_loop::{Contact, Controller, KelvinVoigt, SafetyChain, Specimen, Tissue};
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
    let (tissue, specimen) = tissue();
    let errors = forces.iter().filter_map(|&(tick, force_n)| {
        let time_s = f64::from(tick) * f64::from(period_us) * 1e-6;
        let stress = tissue.relaxation_stress(STRAIN, RAMP_TIME_S, time_s);
        let theory = specimen.force(stress).0;
        (time_s >= RAMP_TIME_S + 0.1).then(|| (-force_n / theory - 1.0).abs())
    });
    errors.fold(0.0, f64::max)
}

fn start(link: &mut SerialLink, ticks: u32) {
    link.arm(WATCHDOG).expect("arms");
    let start = Start {
        run: 1,
        ticks,
        every: 1,
        batch: 1,
    };
    link.start(start).expect("starts");
}

#[test]
fn twenty_seconds_in_the_devices_loop_lose_nothing_and_follow_theory() {
    const PERIOD_US: u32 = 1000;
    const TICKS: u32 = 20_001;
    let Some(images) = built() else { return };
    let emulator = Emulator::start(&images.path(Image::Device));
    let options = ConnectOptions {
        patience: Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let mut link = SerialLink::connect(emulator.path(), options).expect("answers");
    let (shape, values) = operator_shape(&operator::<f32>(PERIOD_US, TICKS)).expect("short");
    let mut configuration = configuration(LoopMode::Device, PERIOD_US);
    configuration.operator = shape;
    link.set(configuration, &values).expect("good parameters");
    start(&mut link, TICKS);
    let mut samples: Vec<Sample> = Vec::new();
    loop {
        match link.hear(Duration::from_secs(5)) {
            Some(Heard::Sample(sample)) => samples.push(sample),
            Some(Heard::Event(event)) if event.kind == EventKind::Finished => break,
            Some(Heard::Event(_)) => {}
            other => panic!("after {} samples: {other:?}", samples.len()),
        }
    }
    assert!(samples.len() >= TICKS as usize, "{}", samples.len());
    assert!(
        (0..).zip(&samples).all(|(n, sample)| sample.tick == n),
        "samples are missing"
    );
    let run = samples.iter().take(TICKS as usize);
    let forces: Vec<(u32, f64)> = run.map(|s| (s.tick, f64::from(s.force_n))).collect();
    let error = error(&forces, PERIOD_US);
    let counters = link.report();
    println!("device loop, 20 s at 1 kHz: force within {error:.2e} of theory; {counters:?}");
    assert!(error < 1e-4, "{error:e}");
    assert_eq!((counters.host.lost, counters.host.corrupt), (0, 0));
    // It ends by itself with zero force.
    assert_eq!(samples.last().map(|sample| sample.force_n), Some(0.0));
}

#[test]
fn a_host_loop_at_500_hz_loses_nothing_and_follows_theory() {
    const PERIOD_US: u32 = 2000;
    const TICKS: u32 = 2501;
    let Some(images) = built() else { return };
    let emulator = Emulator::start(&images.path(Image::Device));
    let options = ConnectOptions {
        patience: Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let mut link = SerialLink::connect(emulator.path(), options).expect("answers");
    let configuration = configuration(LoopMode::Host, PERIOD_US);
    link.set(configuration, &[0.0]).expect("good parameters");
    let (tissue, specimen) = tissue();
    let law = KelvinVoigt::new(&tissue, &specimen, operator::<f64>(PERIOD_US, TICKS));
    let contact = Contact::at(Metres(0.0), law.expect("valid")).expect("valid");
    let sample_time = Seconds(f64::from(PERIOD_US) * 1e-6);
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1000.0), sample_time);
    let mut controller = Controller::<f64, 1, _>::new(contact, chain.expect("valid"));
    start(&mut link, 0);
    let mut forces = Vec::new();
    for n in 0..TICKS {
        let sample = controller
            .tick(&mut link)
            .unwrap_or_else(|error| panic!("tick {n}: {error}"));
        assert_eq!(sample.reading.tick, u64::from(n), "samples are missing");
        forces.push((n, sample.force.newtons()[0]));
    }
    link.disarm().expect("disarms");
    let error = error(&forces, PERIOD_US);
    println!("host loop, 5 s at 500 Hz: force within {error:.2e} of theory");
    // Twice the sample time, twice the error of sampling.
    assert!(error < 2e-4, "{error:e}");
    assert_eq!(link.report().forces_dropped, 0);
}
