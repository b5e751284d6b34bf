//! Random simulated devices are measured, and what is found is held against what they are.
//!
//! `CAMPAIGN_CASES` sets how many; 20 unless it is given.

use fracdiff::Seconds;
use haptic_experiment::measured_device::{MeasurePlan, Measured, estimate, on_simulated};
use haptic_experiment::{Imperfections, Sensors};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;
use testkit::Random;

/// A device, and what was found.
struct Case {
    device: MassDamperConfig,
    imperfections: Imperfections,
    found: Measured,
}

/// Devices of 30 to 200 g, 1 to 8 N·s/m, with 0.02 to 0.2 N of friction, an encoder of 10 µm and up to 3 µm of noise; delay and lag
/// about 1.3 samples and 0.5 ms.
fn random_device(case: u64) -> (MassDamperConfig, Imperfections) {
    let mut random = Random(0x6d65_6173 + 7919 * case);
    let t = 1e-3;
    let device = MassDamperConfig::ideal(
        Kilograms(random.log_between(0.03, 0.2)),
        NewtonSecondsPerMetre(random.log_between(1.0, 8.0)),
        Seconds(t),
    );
    let imperfections = Imperfections {
        friction_n: random.log_between(0.02, 0.2),
        delay_s: t * random.between(1.0, 1.6),
        current_lag_s: 1e-3 * random.between(0.4, 0.6),
        sensors: Sensors {
            encoder_resolution_m: 10e-6,
            noise_m: random.between(0.0, 3e-6),
            seed: case,
        },
    };
    (device, imperfections)
}

fn measure(case: u64) -> Case {
    let (device, imperfections) = random_device(case);
    let plan = MeasurePlan::default();
    let never = AtomicBool::new(false);
    let record = on_simulated(&plan, device, &imperfections, &|_| {}, &never).expect("measures");
    assert!(record.largest_force_n() <= plan.force_n());
    let (low, high) = record.reach_m();
    assert!(-low <= plan.box_m && high <= plan.box_m);
    let found = estimate(&record, false).expect("finds it");
    Case {
        device,
        imperfections,
        found,
    }
}

#[test]
fn random_devices_are_found_as_they_are_and_intervals_hold() {
    let cases: u64 = std::env::var("CAMPAIGN_CASES").map_or(20, |n| n.parse().expect("a number"));
    let all: Vec<Case> = (0..cases).into_par_iter().map(measure).collect();
    let share = |holds: &dyn Fn(&Case) -> bool| all.iter().filter(|case| holds(case)).count();
    let within = |have: f64, want: f64, share: f64| (have / want - 1.0).abs() <= share;
    let right = [
        (
            "mass",
            share(&|c| within(c.found.mass_kg.value, c.device.mass.0, 0.05)),
        ),
        (
            "damping",
            share(&|c| within(c.found.damping_n_s_per_m.value, c.device.damping.0, 0.05)),
        ),
        (
            "delay",
            share(&|c| (c.found.delay_s.value - c.imperfections.delay_s).abs() <= 1e-4),
        ),
        (
            "lag",
            share(&|c| {
                within(
                    c.found.current_lag_s.value,
                    c.imperfections.current_lag_s,
                    0.2,
                )
            }),
        ),
        (
            "all",
            share(&|c| {
                within(c.found.mass_kg.value, c.device.mass.0, 0.05)
                    && within(c.found.damping_n_s_per_m.value, c.device.damping.0, 0.05)
                    && (c.found.delay_s.value - c.imperfections.delay_s).abs() <= 1e-4
                    && within(
                        c.found.current_lag_s.value,
                        c.imperfections.current_lag_s,
                        0.2,
                    )
            }),
        ),
        (
            "encoder",
            share(&|c| within(c.found.encoder_resolution_m, 1e-5, 1e-6)),
        ),
    ];
    let covered = [
        ("mass", share(&|c| c.found.mass_kg.covers(c.device.mass.0))),
        (
            "damping",
            share(&|c| c.found.damping_n_s_per_m.covers(c.device.damping.0)),
        ),
        (
            "friction",
            share(&|c| c.found.friction_n.covers(c.imperfections.friction_n)),
        ),
        (
            "delay",
            share(&|c| c.found.delay_s.covers(c.imperfections.delay_s)),
        ),
        (
            "lag",
            share(&|c| c.found.current_lag_s.covers(c.imperfections.current_lag_s)),
        ),
        (
            "noise",
            share(&|c| {
                c.found
                    .sensor_noise_m
                    .covers(c.imperfections.sensors.noise_m)
            }),
        ),
    ];
    println!("of {cases}: right {right:?}, covered {covered:?}");
    if std::env::var("MEASURE_SHOW").is_ok() {
        for (n, case) in all.iter().enumerate() {
            let (d, i, f) = (&case.device, &case.imperfections, &case.found);
            println!(
                "{n}: m {:.4} {:.4} ±{:.2}% · b {:.3} {:.3} ±{:.2}% · Fc {:.4} {:.4} ±{:.4} · D {:.4} {:.4} ±{:.4} ms · τ {:.4} {:.4} ±{:.4} ms · σ {:.2} {:.2} [{:.2},{:.2}] µm · rms {:.2} · ρ {:.3} · ab {:?}",
                d.mass.0,
                f.mass_kg.value,
                100.0 * f.mass_kg.relative(),
                d.damping.0,
                f.damping_n_s_per_m.value,
                100.0 * f.damping_n_s_per_m.relative(),
                i.friction_n,
                f.friction_n.value,
                f.friction_n.high - f.friction_n.value,
                1e3 * i.delay_s,
                1e3 * f.delay_s.value,
                1e3 * (f.delay_s.high - f.delay_s.value),
                1e3 * i.current_lag_s,
                1e3 * f.current_lag_s.value,
                1e3 * (f.current_lag_s.high - f.current_lag_s.value),
                1e6 * i.sensors.noise_m,
                1e6 * f.sensor_noise_m.value,
                1e6 * f.sensor_noise_m.low,
                1e6 * f.sensor_noise_m.high,
                1e6 * f.residual_rms_m,
                f.delay_lag_correlation,
                f.breakaway_n
            );
        }
    }
    for (what, count) in right {
        assert!(
            count as f64 >= 0.95 * cases as f64,
            "{what}: {count} of {cases}"
        );
    }
}
