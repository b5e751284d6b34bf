//! A hand and a sensor that do their worst, for a long time.

use super::*;

/// Ticks of a loop with a wall on a robot whose sensor has some trouble, again and again, in hands of all kinds.
fn campaign<F: Real, const D: usize>(ticks: u64, seed: u64) -> [u64; 8] {
    let limits = MotionLimits::<D> {
        acceleration_norm: Some(MetresPerSecondSquared(12.0)),
        dead_band: Newtons(0.2),
        ..limits()
    };
    let mut random = Random(seed);
    let (speed, step) = (limits.speed.0, limits.acceleration.0 * T.0);
    let whole_step = 12.0 * T.0;
    let digits = 4.0 * F::EPSILON.to_f64() * speed;
    let stop_ticks = (limits.stop_time(T).0 / T.0).round() as u64;
    let mut found = [0; 8];
    let mut tick = 0;
    while tick < ticks {
        let hand = RobotHand {
            mass: Kilograms(random.between(0.0, 3.0)),
            damping: NewtonSecondsPerMetre(random.between(0.0, 40.0)),
            stiffness: NewtonsPerMetre(random.or_nothing(2000.0)),
        };
        let config = SimulatedRobotConfig {
            sensor_range: limits.sensor_range,
            sensor_noise: Newtons(0.02),
            sensor_resolution: Newtons(0.01),
            seed: random.bits(),
            ..robot(hand)
        };
        let alpha = random.one_of(&[0.5, 0.8, 1.0, 1.2]);
        let inertia = random.between(0.5, 4.0);
        let damping = random.between(0.0, 20.0);
        let body = body(inertia, damping, full::<F>(alpha, T, 1e-4));
        let mut device = admittance(&limits, made::<D>(config), body);
        let wall = SpringDamper::<F, _>::new(random.between(0.0, 3000.0), 5.0, full(1.0, T, 1e-4));
        let mut controller = Controller::<F, D, _>::new(wall.expect("in range"), law_chain());
        let mut engaged = controller.engage(&mut device);
        let nothing = SVector::<f64, D>::zeros();
        let mut last = nothing;
        let mut fault: Option<(u64, MotionFault)> = None;
        let begins = tick + 50 + random.bits() % 200;
        let offset = random.between(-80.0, 80.0);
        let trouble = random.one_of(&[
            None,
            Some(SensorTrouble::NotANumber),
            Some(SensorTrouble::Stuck),
            Some(SensorTrouble::Offset(offset)),
            Some(SensorTrouble::Gain(2.0)),
            Some(SensorTrouble::Gain(-1.0)),
            Some(SensorTrouble::Silent),
            Some(SensorTrouble::Replayed),
        ]);
        for _ in 0..800 {
            tick += 1;
            if random.chance(0.02) {
                let push = SVector::from_fn(|_, _| random.between(-8.0, 8.0));
                engaged.device_mut().robot_mut().set_hand_force(push);
                let place = SVector::from_fn(|_, _| random.between(-0.005, 0.005));
                engaged.device_mut().robot_mut().set_hand_target(place);
            }
            if tick >= begins {
                engaged.device_mut().robot_mut().set_trouble(trouble);
            }
            let outcome = engaged.tick();
            let state = engaged.device().state();
            let v: SVector<f64, D> = state.velocity_m_per_s().map(F::to_f64);
            let change = v - last;
            assert!(v.norm() <= speed, "{tick}: {v}");
            assert!(
                change.amax() <= step + digits && change.norm() <= whole_step + digits,
                "{tick}: {change}"
            );
            for x in state.position_m() {
                assert!(x.to_f64().abs() <= limits.high[0].0, "{tick}: {x}");
            }
            if let Some((at, first)) = fault {
                assert_eq!(state.fault(), Some(first));
                assert!(
                    (0..D).all(|axis| v[axis].abs() <= last[axis].abs()),
                    "{tick}: {v} after {last}"
                );
                assert!(
                    v == nothing || tick - at < stop_ticks,
                    "{tick}: {v}, fault {first} at {at}"
                );
                if v == nothing && last == nothing {
                    assert!(
                        matches!(outcome, Err(AdmittanceError::Stopped(_))),
                        "{outcome:?}"
                    );
                }
            } else if let Some(first) = state.fault() {
                fault = Some((tick, first));
                found[usize::from(first.code()) - 1] += 1;
            }
            last = v;
            if fault.is_some_and(|(at, _)| tick > at + 60) {
                break;
            }
        }
    }
    found
}

/// Ticks on one axis, two and three, in both precisions; each fault that a sensor can make is among what is found.
fn look(ticks: u64) {
    let runs = [
        campaign::<f64, 1>(ticks / 4, 1),
        campaign::<f32, 1>(ticks / 4, 2),
        campaign::<f64, 2>(ticks / 4, 3),
        campaign::<f32, 3>(ticks / 4, 4),
    ];
    println!("{runs:?}");
    for fault in [
        MotionFault::NotFinite,
        MotionFault::StaleForce,
        MotionFault::SensorSaturated,
        MotionFault::Force,
        MotionFault::SensorStuck,
    ] {
        let code = usize::from(fault.code());
        let found = runs.iter().any(|run| run[code - 1] > 0);
        assert!(found, "{fault:?}: {runs:?}");
    }
}

#[test]
fn whatever_a_sensor_shows_the_command_keeps_its_limits_and_stops_in_time() {
    look(testkit::cases(100_000));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_million_ticks_of_hostile_sensors_are_borne_too() {
    look(1_000_000);
}
