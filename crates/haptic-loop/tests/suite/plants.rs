//! The simulated mass-damper against closed forms.

use fracdiff::{Real, Scheme, Seconds};
use haptic_loop::plant::{MassDamper, MassDamperConfig, Sensed, run_wall};
use haptic_loop::units::{Metres, MetresPerSecond, Newtons, NewtonsPerSecond};
use haptic_loop::{
    Controller, Device, OwnPush, Pushing, Reading, SafetyChain, SafetyLimits, SpeedLimit, Wall,
};
use nalgebra::{Matrix4, Vector1, Vector2, Vector4};
use proptest::prelude::*;
use testkit::assert_close;
use testkit::device::{DAMPING as B, MASS as M, ideal, plant, safe, with_hand, write};
use testkit::operator::order;

/// Sample time at 1 kHz, s.
const T: f64 = 1e-3;

fn state(plant: &MassDamper<1>) -> (f64, f64) {
    (plant.position()[0], plant.velocity()[0])
}

/// Position and velocity t seconds after a constant force starts on a resting mass, k = 0.
fn step_response(force: f64, m: f64, b: f64, t: f64) -> (f64, f64) {
    let t = t.max(0.0);
    let lost = -libm::expm1(-b * t / m);
    (force / b * (t - m / b * lost), force / b * lost)
}

#[test]
fn a_step_arrives_after_a_delay_that_is_not_whole() {
    for samples in [0.0, 0.25, 1.0, 2.5, 17.125, 63.75, 64.0] {
        let mut plant = plant(MassDamperConfig {
            delay: Seconds(samples * T),
            ..ideal(M, B, T)
        });
        for n in 1..=200_u32 {
            write(&mut plant, 1.0);
            let (x, v) = step_response(1.0, M, B, (f64::from(n) - samples) * T);
            assert_close("x", plant.position()[0], x, 1e-15);
            assert_close("v", plant.velocity()[0], v, 2e-14);
        }
    }
}

#[test]
fn a_delay_that_is_a_whole_number_but_for_rounding_is_whole() {
    let (delay, sample_time) = (0.3, 0.1);
    assert!(delay / sample_time < 3.0, "not 3 in binary");
    let mut plant = plant(MassDamperConfig {
        delay: Seconds(delay),
        ..ideal(M, B, sample_time)
    });
    for n in 0..3 {
        write(&mut plant, 1.0);
        assert_eq!(plant.position()[0].to_bits(), 0, "moved in sample {n}");
    }
    write(&mut plant, 1.0);
    assert!(plant.position()[0] > 0.0);
}

#[test]
fn a_saturated_actuator_gives_its_limit() {
    let mut plant = plant(MassDamperConfig {
        saturation: Some(Newtons(2.0)),
        ..ideal(1.0, 0.0, 1.0)
    });
    for (wanted, velocity) in [(3.0, 2.0), (-5.0, 0.0), (1.5, 1.5)] {
        write(&mut plant, wanted);
        assert_close("v", plant.velocity()[0], velocity, 1e-15);
    }
}

#[test]
fn a_mass_that_friction_holds_never_moves() {
    let stuck = MassDamperConfig {
        friction: Newtons(1.0),
        delay: Seconds(1.4 * T),
        ..with_hand(M, B, 300.0, T)
    };
    let lagging = MassDamperConfig {
        current_lag: Seconds(5e-3),
        ..stuck
    };
    for config in [stuck, lagging] {
        let mut plant = plant(config);
        // The hand's spring pulls with 0.3 N, an external force holds against it.
        plant.set_state(Vector1::new(1e-3), Vector1::new(0.0));
        plant.set_external_force(Vector1::new(0.3));
        for n in 0..1_000_000 {
            let sign = if n % 3 == 0 { 1.0 } else { -1.0 };
            write(&mut plant, sign * 0.99);
            assert_eq!(
                plant.position()[0].to_bits(),
                1e-3_f64.to_bits(),
                "tick {n}"
            );
            assert_eq!(plant.velocity()[0].to_bits(), 0, "tick {n}");
        }
        (0..21).for_each(|_| write(&mut plant, 1.5));
        assert!(plant.velocity()[0] > 0.0, "1.5 N breaks it loose");
    }
}

#[test]
fn a_sliding_mass_stops_where_friction_has_used_up_its_energy() {
    let friction = 0.4;
    let mut worst: f64 = 0.0;
    for (sample_time, throw) in [4e-3, 1e-3, 3e-4]
        .into_iter()
        .flat_map(|t| (0..20).map(move |n| (t, n)))
    {
        let v0 = 0.0503 + 0.0131 * f64::from(throw);
        let mut plant = plant(MassDamperConfig {
            friction: Newtons(friction),
            ..ideal(M, 0.0, sample_time)
        });
        plant.set_state(Vector1::new(0.0), Vector1::new(v0));
        let samples = (M * v0 / friction / sample_time).ceil();
        let mut n = 0.0;
        while plant.velocity()[0] > 0.0 {
            write(&mut plant, 0.0);
            n += 1.0;
        }
        assert_close("samples until it stopped", n, samples, 0.0);
        assert_eq!(plant.velocity()[0].to_bits(), 0, "not quite at rest");
        let stopped = plant.position()[0];
        (0..1000).for_each(|_| write(&mut plant, 0.0));
        assert_eq!(stopped.to_bits(), plant.position()[0].to_bits(), "it crept");
        // The last sample ends at rest instead of stopping early in it: at most Fc·T²/(8·m) off.
        let distance = M * v0 * v0 / (2.0 * friction);
        let bound = friction * sample_time * sample_time / (8.0 * M);
        assert_close("distance", stopped, distance, bound + 1e-15);
        worst = worst.max((stopped - distance).abs() / bound);
    }
    assert!(worst > 0.5, "the bound says nothing: {worst}");
}

#[test]
fn axes_are_independent_bit_for_bit() {
    let config = MassDamperConfig {
        friction: Newtons(0.05),
        delay: Seconds(1.3 * T),
        saturation: Some(Newtons(0.8)),
        current_lag: Seconds(1e-3),
        ..with_hand(M, B, 50.0, T)
    };
    let (mut both, mut alone) = (MassDamper::<2>::new(config).expect("valid"), plant(config));
    for n in 0..500_u32 {
        let force = libm::sin(f64::from(n) * 0.05);
        both.write(safe(Vector2::new(force, -0.5 * force)))
            .expect("infallible");
        write(&mut alone, force);
        assert_eq!(both.position()[0].to_bits(), alone.position()[0].to_bits());
    }
}

#[test]
fn a_replay_writes_each_force_for_each_part() {
    let config = MassDamperConfig {
        friction: Newtons(0.05),
        delay: Seconds(1.3 * T),
        ..ideal(M, B, T)
    };
    let (mut replayed, mut written) = (plant(config), plant(config));
    let forces = [1.0, -0.5, 0.0, 2.0].map(|force| safe(Vector1::new(force)));
    let (mut have, mut want) = (Vec::new(), Vec::new());
    replayed.replay(&mut forces.into_iter(), 3, &mut |x| have.push(x));
    for force in forces {
        want.push(written.position()[0]);
        for _ in 0..3 {
            written.write(force).expect("written");
        }
    }
    assert_eq!(have, want);
    assert_eq!(state(&replayed), state(&written));
}

#[test]
fn a_wall_that_is_run_ticks_until_it_is_seen_enough_or_a_fault_is_latched() {
    let wall = |largest_force: f64| {
        let operator = "grunwald:20".parse::<Scheme>().expect("a scheme");
        let operator = operator.build(order(0.5), Seconds(T), 1e6).expect("valid");
        let wall = Wall::new(500.0, 2.0, operator, None).expect("valid");
        let limits = SafetyLimits {
            speed: Some(SpeedLimit {
                soft: MetresPerSecond(0.2),
                hard: MetresPerSecond(0.45),
            }),
            ..SafetyLimits::bare(Newtons(largest_force), NewtonsPerSecond(1e5))
        };
        let chain = SafetyChain::from_limits(&limits, Seconds(T)).expect("valid");
        let mut device = plant(ideal(M, B, T));
        device.set_external_force(Vector1::new(2.0));
        let device = Sensed::new(device, Metres(0.0), Metres(0.0), 1).expect("valid");
        let wall = OwnPush::new(Pushing::new(wall, true), None);
        (Controller::<f64, 1, _>::new(wall, chain), device)
    };
    let (mut controller, mut device) = wall(10.0);
    let mut seen = Vec::new();
    let whole = run_wall(&mut controller, &mut device, 50, &mut |time_s, x, force| {
        seen.push((time_s, x, force));
        true
    });
    let (mut controller, mut device) = wall(10.0);
    let mut engaged = controller.engage(&mut device);
    let want: Vec<_> = (0..50)
        .map(|_| {
            let Ok(sample) = engaged.tick();
            let reading = sample.reading;
            (
                reading.time_s,
                reading.position_m[0],
                sample.force.newtons()[0],
            )
        })
        .collect();
    assert!(whole && seen == want);
    drop(engaged);

    let count = |most: usize, largest_force: f64| {
        let (mut controller, mut device) = wall(largest_force);
        let mut count = 0;
        let whole = run_wall(&mut controller, &mut device, 200, &mut |_, _, _| {
            count += 1;
            count < most
        });
        (whole, count, controller.safety().fault())
    };
    assert_eq!(count(7, 10.0), (false, 7, None));
    // 2 N push it away from a wall that holds against almost nothing.
    let (whole, ticks, fault) = count(1000, 1e-3);
    assert!(
        !whole && ticks < 200 && fault.is_some(),
        "{ticks} {fault:?}"
    );
}

#[test]
fn a_reading_counts_ticks_in_virtual_time_and_rounds_to_single_precision() {
    let mut plant = plant(ideal(M, B, 0.25));
    for n in 0..5_u32 {
        let reading: Reading<f32, 1> = plant.read().expect("infallible");
        assert_eq!(reading.tick, u64::from(n));
        assert_close("time", reading.time_s, f64::from(n) * 0.25, 0.0);
        let want = f32::from_f64(plant.position()[0]);
        assert_eq!(reading.position_m[0].to_bits(), want.to_bits());
        plant
            .write(safe(Vector1::new(0.1_f32)))
            .expect("infallible");
    }
}

/// One sample of x'' = (a - b·x' - k·x)/m, τ·a' = u - a by another route, many short Taylor steps: x, v, a and u at its end.
fn reference_step(m: f64, b: f64, k: f64, lag: f64, t: f64, start: Vector4<f64>) -> Vector4<f64> {
    let follow = if lag > 0.0 { 1.0 / lag } else { 0.0 };
    #[rustfmt::skip]
    let generator = Matrix4::new(
        0.0, 1.0, 0.0, 0.0,
        -k / m, -b / m, 1.0 / m, 0.0,
        0.0, 0.0, -follow, follow,
        0.0, 0.0, 0.0, 0.0,
    );
    // Short against the fastest motion, b/m, √(k/m) or 1/τ.
    let fastest = b / m + libm::sqrt(k / m) + follow;
    let steps = (8.0 * t * fastest).ceil().max(1.0);
    let mut state = start;
    for _ in 0..steps as u32 {
        let mut term = state;
        for order in 1..=24_u32 {
            term = generator * term * (t / steps / f64::from(order));
            state += term;
        }
    }
    state
}

proptest! {
    #[test]
    fn a_sample_matches_a_taylor_series_of_the_motion(
        m in 0.01..10.0_f64,
        b in 0.0..100.0_f64,
        k in prop_oneof![Just(0.0), 0.0..1e4_f64],
        lag in prop_oneof![Just(0.0), 1e-4..1e-1_f64],
        t in 1e-4..1e-2_f64,
        x in -1.0..1.0_f64,
        v in -1.0..1.0_f64,
        u in -10.0..10.0_f64,
    ) {
        let mut plant = plant(MassDamperConfig { current_lag: Seconds(lag), ..with_hand(m, b, k, t) });
        plant.set_state(Vector1::new(x), Vector1::new(v));
        write(&mut plant, u);
        let at_once = if lag > 0.0 { 0.0 } else { u };
        let want = reference_step(m, b, k, lag, t, Vector4::new(x, v, at_once, u));
        assert_close("a", plant.applied_force()[0], want[2], 1e-13 * u.abs());
        let (have_x, have_v) = state(&plant);
        // Errors are relative to the largest position and velocity the start could lead to.
        let omega = libm::sqrt(k / m);
        let speed = v.abs() + omega * x.abs() + u.abs() * t / m;
        assert_close("x", have_x, want[0], 1e-13 * (x.abs() + speed * t));
        assert_close("v", have_v, want[1], 1e-13 * (speed + omega * t * speed));
    }
}
