//! The main job through the UART of the emulated device, opened by the real serial port code.

use super::board::{Emulator, samples};
use super::image::{Image, built};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_link::{Configuration, Limits, LoopMode, Simulation, SimulationKind, Start};
use haptic_loop::units::{Metres, Pascals, SquareMetres};
use haptic_loop::{Modulus, Specimen, Tissue};
use haptic_remote::operator_shape;
use std::time::Duration;

const RAMP_TIME_S: f64 = 1.0;
const STRAIN: f64 = 0.05;
const THICKNESS: f64 = 0.02;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn five_seconds_in_the_devices_loop_lose_nothing_uncounted_and_follow_theory() {
    const TICKS: u32 = 5001;
    let Some(images) = built() else { return };
    // Cancerous prostate: 8.65 kPa·s^α, α = 0.2247, 4 cm² and 2 cm thick.
    let order = Order::new(0.2247).expect("valid");
    let tissue = Tissue::new(Pascals(0.0), 8650.0, order).expect("valid");
    let specimen = Specimen::slab(SquareMetres(4e-4), Metres(THICKNESS)).expect("valid");
    let scheme: Scheme = "full".parse().expect("valid");
    let operator = scheme.build(order, Seconds(1e-3), 1.05 * f64::from(TICKS));
    let operator: Operator<f32> = operator.expect("fits");
    let (coefficients, values) = operator_shape(&operator).expect("short");
    let shape = specimen.shape(Modulus::Young);
    let configuration = Configuration {
        loop_mode: LoopMode::Device,
        dissipation_n_s_mu_per_m: (shape * tissue.viscosity_pa_s_alpha()) as f32,
        order: 0.2247,
        one_sided: true,
        operator: coefficients,
        limits: Limits {
            watchdog_ms: 1000,
            late_ticks: 0,
            // Theory knows no limits.
            rise_time_s: 0.0,
            ..Limits::DEFAULT
        },
        simulation: Simulation {
            kind: SimulationKind::RigidIndentation,
            depth_m: (STRAIN * THICKNESS) as f32,
            ramp_time_s: RAMP_TIME_S as f32,
            ..Simulation::TESTBED
        },
        ..Configuration::PASSIVE
    };
    let emulator = Emulator::start(&images.path(Image::Device));
    let mut link = emulator.connected().expect("answers");
    link.set(configuration, &values).expect("good");
    link.arm(Duration::from_secs(1)).expect("arms");
    let start = Start {
        ticks: TICKS,
        ..Start::ENDLESS
    };
    link.start(start).expect("starts");
    let samples = samples(&mut link);
    let statistics = link.statistics().expect("answers");
    let counters = link.report();
    assert!(
        samples.is_sorted_by(|one, next| one.tick < next.tick),
        "samples are out of order"
    );
    let last = samples.last().expect("samples");
    // A reader that gets no turn for longer than the device's queue lasts loses samples, and the device counts them.
    let missing = u64::from(last.tick) + 1 - samples.len() as u64;
    let counted = u64::from(statistics.samples_dropped)
        + u64::from(counters.host.order.lost)
        + counters.samples_dropped;
    println!("{missing} samples missing, {counted} counted as lost; {counters:?}");
    assert!(missing <= counted, "lost without being counted");
    assert_eq!(counters.host.line.corrupt, 0);
    if counted == 0 {
        assert!(last.tick + 1 >= TICKS, "{}", last.tick);
        // It ends by itself with zero force.
        assert_eq!(last.axes[0].force_n.to_bits() << 1, 0, "{last:?}");
    }
    // From 0.1 s after the ramp on, against the closed form.
    let held = samples
        .iter()
        .filter(|sample| (1100..TICKS).contains(&sample.tick));
    let errors = held.map(|sample| {
        let time_s = 1e-3 * f64::from(sample.tick);
        let stress = tissue.relaxation_stress(STRAIN, RAMP_TIME_S, time_s);
        (-f64::from(sample.axes[0].force_n) / (shape * THICKNESS * stress.0) - 1.0).abs()
    });
    let errors: Vec<f64> = errors.collect();
    assert!(!errors.is_empty());
    let error = errors.into_iter().fold(0.0, f64::max);
    println!("device loop, {TICKS} ticks at 1 kHz: force within {error:.2e} of theory");
    assert!(error < 1e-4, "{error:e}");
}
