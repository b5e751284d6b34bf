//! The motion chain: each limit for one, two and three axes, each fault, and arming.

use super::*;
use crate::plant_parameters::{Change, refuses};

/// A tick almost without a force at this wanted velocity, m/s, on a robot that follows at once.
fn tick<F: Real, const D: usize>(
    chain: &MotionChain<F, D>,
    state: &mut MotionState<F, D>,
    tick: u64,
    wanted: SVector<F, D>,
) -> (SVector<F, D>, Limiters) {
    let here = *state.position_m();
    let noise = F::from_f64(1e-3 * (tick % 2) as f64);
    chain.sense(state, &reading(tick, here, SVector::from([noise; D])));
    let (motion, limiters) = chain.apply(state, &wanted);
    (*motion.metres_per_second(), limiters)
}

/// Wild wishes: every limit holds in every tick, and from every tick the way to rest ends inside.
fn keeps_each_limit<F: Real, const D: usize>(limits: &MotionLimits<D>) {
    let digits = F::EPSILON.to_f64();
    let (chain, mut state) = armed::<F, D>(limits, SVector::from([F::ZERO; D]));
    let mut random = Random(7 + D as u64);
    let (speed, norm) = (limits.speed.0, limits.speed_norm.map_or(1e9, |norm| norm.0));
    let step = limits.acceleration.0 * T.0;
    let whole_step = limits.acceleration_norm.map_or(1e9, |norm| norm.0 * T.0);
    let mut wanted = SVector::from([F::ZERO; D]);
    let mut last = SVector::<f64, D>::zeros();
    let mut farthest: f64 = 0.0;
    for n in 0..20_000 {
        if random.chance(0.02) {
            wanted = SVector::from_fn(|_, _| {
                let size = random.log_between(1e-3, 1e30);
                F::from_f64(if random.chance(0.5) { size } else { -size })
            });
        }
        let (v, _) = tick(&chain, &mut state, n, wanted);
        let v = v.map(F::to_f64);
        let change = v - last;
        assert!(v.amax() <= speed && v.norm() <= norm, "{n}: {v}");
        assert!(change.amax() <= step + digits * speed, "{n}: {change}");
        assert!(
            change.norm() <= whole_step + 2.0 * digits * speed,
            "{n}: {change}"
        );
        last = v;
        // A stop now.
        let mut stopping = state;
        stopping.stop();
        for later in 0..60 {
            for (axis, x) in stopping.position_m().iter().enumerate() {
                let x = x.to_f64();
                farthest = farthest.max(x.abs());
                assert!(
                    x >= limits.low[axis].0 && x <= limits.high[axis].0,
                    "{n}, {later}: {x}"
                );
            }
            let before = stopping.velocity_m_per_s().map(F::to_f64);
            let (v, _) = tick(&chain, &mut stopping, n + 1 + later, wanted);
            let v = v.map(F::to_f64);
            for axis in 0..D {
                assert!(v[axis].abs() <= before[axis].abs() && v[axis] * before[axis] >= 0.0);
            }
            if n % 100 != 0 && stopping.is_at_rest() {
                break;
            }
        }
        assert!(stopping.is_at_rest(), "{n}");
    }
    // The workspace is used, too.
    assert!(farthest > 0.999 * limits.high[0].0, "{farthest}");
}

#[test]
fn speed_acceleration_and_workspace_hold_on_each_axis_and_by_norm() {
    fn all<F: Real, const D: usize>() {
        let plain = limits::<D>();
        let whole = MotionLimits {
            speed_norm: Some(MetresPerSecond(0.6)),
            acceleration_norm: Some(MetresPerSecondSquared(10.0)),
            ..plain
        };
        let soft = MotionLimits {
            jerk: Some(MetresPerSecondCubed(400.0)),
            ..plain
        };
        for limits in [plain, whole, soft] {
            keeps_each_limit::<F, D>(&limits);
        }
    }
    all::<f64, 1>();
    all::<f64, 2>();
    all::<f64, 3>();
    all::<f32, 1>();
    all::<f32, 3>();
}

#[test]
fn what_is_within_the_limits_is_commanded_to_the_bit() {
    let (chain, mut state) = armed(&limits(), vector![0.01, 0.0]);
    let mut x = vector![0.01, 0.0];
    for n in 0..200 {
        let wanted = vector![0.01 * libm::sin(0.05 * n as f64), 1e-3];
        let (v, limiters) = tick(&chain, &mut state, n, wanted);
        assert_eq!((v, limiters), (wanted, Limiters::NONE));
        x += v * T.0;
    }
    assert!((state.position_m() - x).amax() < 1e-15);
}

#[test]
fn a_long_way_to_rest_in_single_precision_ends_inside_although_each_step_is_rounded() {
    // Thousands of steps of which each is off by up to 1e-4 of itself, always to the same side.
    for acceleration in [0.05, 0.061, 0.077, 0.093] {
        let slow = MotionLimits {
            acceleration: MetresPerSecondSquared(acceleration),
            low: [Metres(-3.0)],
            high: [Metres(3.0)],
            ..limits()
        };
        for sign in [1.0, -1.0] {
            let (chain, mut state) = armed::<f32, 1>(&slow, vector![-2.9 * sign]);
            let brakes = (0..20_000).find(|&n| {
                let (_, limiters) = tick(&chain, &mut state, n, vector![sign]);
                limiters.contains(Limiters::WORKSPACE)
            });
            let brakes = brakes.expect("comes near the end");
            state.stop();
            for n in 1..=10_000 {
                tick(&chain, &mut state, brakes + n, vector![sign]);
            }
            let end = state.position_m()[0] * sign;
            assert!(state.is_at_rest());
            assert!(end <= 3.0 && end > 2.99, "{acceleration}: {end}");
        }
    }
}

#[test]
fn a_creeping_command_is_not_lost_in_single_precision() {
    // A step of 2e-9 m is a quarter of a digit of the place: a plain sum would stand still.
    let (chain, mut state) = armed::<f32, 1>(&limits(), vector![0.09]);
    for n in 0..100_000 {
        tick(&chain, &mut state, n, vector![1e-6]);
    }
    let moved = f64::from(state.position_m()[0]) - f64::from(0.09_f32);
    assert_close("way", moved, 0.2e-3, 1e-8);
}

#[test]
fn a_direction_stays_and_a_command_slides_along_an_end() {
    let (chain, mut state) = armed(&limits(), vector![0.0, 0.0]);
    let (v, limiters) = tick(&chain, &mut state, 0, vector![3.0, 4.0]);
    assert_close("direction", v[0] / v[1], 0.75, 1e-12);
    assert_eq!(
        limiters.bits(),
        Limiters::MAGNITUDE.bits() | Limiters::RATE.bits()
    );
    for n in 1..400 {
        tick(&chain, &mut state, n, vector![0.4, 0.01]);
    }
    // It came to the end, and goes on beside it.
    let (v, limiters) = tick(&chain, &mut state, 400, vector![0.4, 0.01]);
    assert!(limiters.contains(Limiters::WORKSPACE));
    assert_close("along", v[1], 0.01, 1e-12);
    assert_close("end", state.position_m()[0], 0.1, 1e-5);
}

#[test]
fn jerk_is_limited_where_no_other_limit_needs_more_and_does_not_overshoot() {
    let wide = MotionLimits {
        jerk: Some(MetresPerSecondCubed(100.0)),
        low: [Metres(-10.0)],
        high: [Metres(10.0)],
        ..limits()
    };
    let (chain, mut state) = armed(&wide, vector![0.0]);
    let (mut last, mut change) = (0.0, 0.0);
    for n in 0..500 {
        let wanted = if n < 250 { 0.3 } else { -0.2 };
        let v = tick(&chain, &mut state, n, vector![wanted]).0[0];
        assert!(
            ((v - last) - change).abs() <= 100.0 * T.0 * T.0 + 1e-15,
            "{n}"
        );
        (last, change) = (v, v - last);
        assert!((-0.2 - 1e-12..=0.3 + 1e-12).contains(&v), "{n}: {v}");
        if n == 249 {
            assert_close("reached", v, 0.3, 1e-12);
        }
    }
    assert_close("reached", last, -0.2, 1e-12);
}

#[test]
fn missed_ticks_move_the_command_on_and_too_many_are_a_fault() {
    let (chain, mut state) = armed(&limits(), vector![0.0]);
    tick(&chain, &mut state, 0, vector![0.01]);
    tick(&chain, &mut state, 4, vector![0.01]);
    assert_close("x", state.position_m()[0], 5.0 * 0.01 * T.0, 1e-15);
    assert_eq!(state.fault(), None);
    // 11 of 2 ms are more than 20 ms.
    tick(&chain, &mut state, 16, vector![0.01]);
    assert_eq!(state.fault(), Some(MotionFault::StaleForce));
}

fn finds<const D: usize>(axis: usize) {
    let along = |value: f64| SVector::from_fn(|at, _| if at == axis { value } else { 0.0 });
    let wide = MotionLimits::<D> {
        low: [Metres(-9.0); D],
        high: [Metres(9.0); D],
        ..limits()
    };
    let calm = [0.0; 3];
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    // Force, N, distance from the command, m, and age, s, of readings until tick 20, and of those after, which are the fault at once.
    let sudden = [
        (calm, [nan, 0.0, 0.0], MotionFault::NotFinite),
        (calm, [-inf, 0.0, 0.0], MotionFault::NotFinite),
        (calm, [0.0, nan, 0.0], MotionFault::NotFinite),
        (calm, [0.0, inf, 0.0], MotionFault::NotFinite),
        (calm, [0.0, 0.0, nan], MotionFault::NotFinite),
        (calm, [0.0, 0.0, -inf], MotionFault::NotFinite),
        (calm, [0.0, 0.0, 0.0201], MotionFault::StaleForce),
        (calm, [50.0, 0.0, 0.0], MotionFault::SensorSaturated),
        ([24.9, 0.0, 0.0], [25.1, 0.0, 0.0], MotionFault::Force),
        (
            [0.0, 0.0199, 0.0],
            [0.0, 0.0201, 0.0],
            MotionFault::Following,
        ),
    ];
    let sudden = sudden.map(|(before, after, fault)| (0.02, before, after, 1e-3, 20..21, fault));
    let (push, pull) = ([10.0, 0.0, 0.0], [-10.0, 0.0, 0.0]);
    // The wanted speed, m/s, comes before them; noise of the force, N, ticks in which it may be found, and the fault after them.
    let others = [
        (inf, calm, calm, 1e-3, 0..1, MotionFault::NotFinite),
        // A sensor may stand still while nothing moves; not for 0.1 s and 5 mm.
        (0.04, calm, calm, 0.0, 60..70, MotionFault::SensorStuck),
        (0.004, calm, calm, 0.0, 620..640, MotionFault::SensorStuck),
        // 10 N against 0.25 m/s give 2 J in 0.8 s, though the hand has paid before.
        (0.25, push, pull, 1e-3, 418..422, MotionFault::HandEnergy),
        (0.0, push, pull, 0.0, 999..1000, MotionFault::RobotFailed),
    ];
    for (wanted, before, after, noise, when, fault) in sudden.into_iter().chain(others) {
        for sign in [1.0, -1.0] {
            let (chain, mut state) = armed::<f64, D>(&wide, SVector::zeros());
            let found = (0..1000).find(|&n| {
                let [force, ahead, age] = if n < 20 { before } else { after };
                let force = along(sign * (force + noise * (n % 2) as f64));
                let mut reading = reading(n, state.position_m() + along(sign * ahead), force);
                reading.force_age_s = age;
                let last = *state.velocity_m_per_s();
                let sensed = chain.sense(&mut state, &reading);
                assert!(state.fault().is_none() || sensed == along(0.0));
                if n == 999 {
                    state.trip(MotionFault::RobotFailed);
                }
                chain.apply(&mut state, &along(sign * wanted));
                assert!(state.fault().is_none() || state.velocity_m_per_s().norm() <= last.norm());
                state.fault().is_some()
            });
            assert_eq!(state.fault(), Some(fault), "axis {axis} of {D}, {found:?}");
            assert!(
                found.is_some_and(|tick| when.contains(&tick)),
                "{fault:?}: {found:?}"
            );
            for n in 1001..1030 {
                tick(&chain, &mut state, n, along(wanted));
            }
            assert!(state.is_at_rest() && state.fault() == Some(fault), "held");
        }
    }
}

#[test]
fn each_fault_is_found_on_each_axis_and_held() {
    finds::<1>(0);
    (0..2).for_each(finds::<2>);
    (0..3).for_each(finds::<3>);
}

#[test]
fn a_dead_band_takes_off_noise_without_a_jump_and_keeps_the_direction() {
    let with_band = MotionLimits {
        dead_band: Newtons(0.5),
        ..limits()
    };
    let (chain, mut state) = armed(&with_band, vector![0.0, 0.0]);
    for (n, force) in [0.1, 0.49, 0.5, 0.51, 5.5].into_iter().enumerate() {
        let shown = vector![0.6, -0.8] * force;
        let sensed = chain.sense(&mut state, &reading(n as u64, vector![0.0, 0.0], shown));
        let left: f64 = if force > 0.5 { force - 0.5 } else { 0.0 };
        assert!(
            (sensed - vector![0.6, -0.8] * left).amax() < 1e-15,
            "{force}: {sensed}"
        );
    }
}

#[test]
fn a_robot_is_armed_only_at_rest_within_its_workspace_and_with_a_sensor_near_zero() {
    let chain = MotionChain::<f64, 1>::new(&limits(), T).expect("in range");
    let mut never = MotionState::default();
    let (motion, _) = tick(&chain, &mut never, 0, vector![0.3]);
    assert_eq!(motion, vector![0.0]);
    let try_with = |shown: &dyn Fn(u32) -> f64, count: u32, x: f64| {
        let mut state = MotionState::default();
        for n in 0..count {
            chain.rest(&mut state, &reading(0, vector![x], vector![shown(n)]));
        }
        chain
            .arm(&mut state, &reading(0, vector![x], vector![shown(count)]))
            .map(|at_rest| (at_rest, state))
    };
    let noisy = |n: u32| 1.5 + if n.is_multiple_of(2) { 0.25 } else { -0.25 };
    let (at_rest, mut state) = try_with(&noisy, 100, 0.05).expect("may be armed");
    assert_close("offset", at_rest.offset_n[0], 1.5, 1e-12);
    assert_close("spread", at_rest.spread_n[0], 0.5, 1e-12);
    // The offset is taken off, and the command begins where the robot stands.
    let sensed = chain.sense(&mut state, &reading(1, vector![0.05], vector![4.0]));
    assert_close("sensed", sensed[0], 2.5, 1e-12);
    assert_eq!(*state.position_m(), vector![0.05]);
    assert_refused(try_with(&noisy, 99, 0.0), "99 ticks of 100");
    // One tick shows something else, of 100 at rest and the one that arms.
    for (usual, at, once, x, words) in [
        (2.6, 0, 2.6, 0.0, "shows 2.6 N at rest, at most 2.5 N"),
        (0.0, 7, 3.0, 0.0, "differ by 3 N"),
        (0.0, 50, f64::NAN, 0.0, "49 ticks of 100"),
        (0.0, 0, 0.0, 0.11, "stands at 0.11 m on axis 0"),
        (0.0, 100, 60.0, 0.0, "the force sensor is saturated"),
    ] {
        let shown = |n| if n == at { once } else { usual };
        assert_refused(try_with(&shown, 100, x), words);
    }
    // Not while it moves; after a stop again, which forgets nothing else by itself.
    tick(&chain, &mut state, 2, vector![0.1]);
    assert_refused(
        chain.arm(&mut state, &reading(3, vector![0.05], vector![1.5])),
        "still moves",
    );
    state.stop();
    for n in 3..200 {
        tick(&chain, &mut state, n, vector![0.1]);
        let here = reading(n, *state.position_m(), vector![1.5]);
        chain.rest(&mut state, &here);
    }
    let here = reading(200, *state.position_m(), vector![1.5]);
    chain.arm(&mut state, &here).expect("armed again");
    assert!(state.is_driven());
}

#[test]
fn limits_without_sense_are_refused_by_name_value_and_remedy() {
    let changes: [(Change<MotionLimits<2>>, &str); 8] = [
        (
            |it| it.speed = MetresPerSecond(0.0),
            "speed limit 0 m/s is not above 0 m/s",
        ),
        (
            |it| it.acceleration = MetresPerSecondSquared(0.0),
            "acceleration limit 0",
        ),
        (
            |it| it.acceleration = MetresPerSecondSquared(1e-14),
            "raise it, or lower the speed limit",
        ),
        (
            |it| it.acceleration_norm = Some(MetresPerSecondSquared(f64::NAN)),
            "acceleration norm limit NaN",
        ),
        (
            |it| it.high[1] = Metres(-0.1),
            "high end of the workspace -0.1 m is not above the low one",
        ),
        (|it| it.force = Newtons(51.0), "at most the sensor's range"),
        (
            |it| {
                it.stuck = Some(StuckSensor {
                    travel: Metres(1e-3),
                    time: Seconds(20.0),
                });
            },
            "stuck sensor 20",
        ),
        (|it| it.offset_share = 1.5, "offset at rest 1.5"),
    ];
    refuses(limits(), &changes, |it| MotionChain::<f64, 2>::new(&it, T));
    assert_refused(
        MotionChain::<f64, 2>::new(&limits(), Seconds(0.0)),
        "sample time 0",
    );
    let slow = MotionLimits {
        acceleration: MetresPerSecondSquared(1e-5),
        ..limits::<1>()
    };
    assert!(MotionChain::<f64, 1>::new(&slow, T).is_ok());
    assert_refused(MotionChain::<f32, 1>::new(&slow, T), "in this number type");
    assert_eq!(limits::<1>().stop_time(T), Seconds(25.0 * T.0));
}
