//! What a device accepts as limits: their ranges, and what a chain on the host makes of them.

use super::{GUARD, plain, set};
use crate::line::{Bench, beyond};
use haptic_link::{Field, GuardKind, Limits, Request};
use haptic_loop::{
    EnergyBounding, PassivityObserver, SpeedLimit, Workspace,
    units::{
        Hertz, Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons,
        NewtonsPerSecond, Seconds,
    },
};

/// One number of the limits.
type Number = fn(&mut Limits) -> &mut f32;

/// Each limit with numbers beyond its range, where everything is on.
#[rustfmt::skip]
const BEYOND: [(Field, Number, &[f32]); 22] = [
    (Field::StartForce, |l| &mut l.start_force_n, &[-1.0, f32::NAN, f32::INFINITY]),
    (Field::RiseTime, |l| &mut l.rise_time_s, &[-0.1, 60.1, f32::NAN]),
    (Field::WorkspaceLow, |l| &mut l.workspace_low_m, &[-101.0, f32::NAN]),
    (Field::WorkspaceHigh, |l| &mut l.workspace_high_m, &[-0.1, -0.2, 101.0, f32::NAN]),
    (Field::WorkspaceSoft, |l| &mut l.workspace_soft_m, &[0.15, -0.01, 1e-7, f32::NAN]),
    (Field::SpeedSoft, |l| &mut l.speed_soft_m_per_s, &[1.5, -0.1, f32::NAN]),
    (Field::SpeedHard, |l| &mut l.speed_hard_m_per_s, &[-1.0, 1001.0, 1e-7, f32::NAN]),
    (Field::VelocityBandwidth, |l| &mut l.velocity_bandwidth_hz, &[0.0, 1e5, f32::NAN]),
    (Field::Braking, |l| &mut l.braking_n_s_per_m, &[-1.0, 5_f32.next_up(), f32::NAN]),
    (Field::StopTime, |l| &mut l.stop_time_s, &[0.0, 1_f32.next_up(), f32::NAN]),
    (Field::BrakeForce, |l| &mut l.brake_force_n, &[-0.1, 10_f32.next_up(), f32::NAN]),
    (Field::DeviceMass, |l| &mut l.device_mass_kg, &[-1.0, 1001.0, f32::NAN]),
    (Field::StuckForce, |l| &mut l.stuck_force_n, &[-1.0, f32::INFINITY, f32::NAN]),
    (Field::StuckTime, |l| &mut l.stuck_time_s, &[0.0, 11.0, f32::NAN]),
    (Field::Jump, |l| &mut l.jump_m, &[-1e-3, 1e-7, 1.1, f32::NAN]),
    (Field::GuardDamping, |l| &mut l.guard.damping_n_s_per_m, &[0.0, 1e7, f32::NAN]),
    (Field::GuardShare, |l| &mut l.guard.share, &[0.0, 1.1, f32::NAN]),
    (Field::GuardForget, |l| &mut l.guard.forget_s, &[0.9e-3, 3601.0, f32::NAN]),
    (Field::GuardDelayMost, |l| &mut l.guard.delay_most_samples, &[4.1, -0.1, f32::NAN]),
    (Field::GuardDelayLeast, |l| &mut l.guard.delay_least_samples, &[0.1, -0.1, f32::NAN]),
    (Field::GuardLag, |l| &mut l.guard.lag_s, &[-1e-6, 0.065, f32::NAN]),
    (Field::GuardNoise, |l| &mut l.guard.noise_m, &[-1e-9, 0.02, f32::NAN]),
];

/// Sets what makes a limit wrong.
type Change = fn(&mut Limits);

/// Numbers that are beyond the range of one limit because of others.
#[rustfmt::skip]
const BEYOND_TOGETHER: [(Field, Change); 5] = [
    (Field::WorkspaceHigh, |l| (l.workspace_low_m, l.workspace_high_m) = (0.0, f32::NAN)),
    (Field::WorkspaceSoft, |l| (l.workspace_low_m, l.workspace_high_m) = (0.0, 0.0)),
    (Field::SpeedSoft, |l| l.speed_hard_m_per_s = 0.0),
    // Half of what 65 g bear with a tick of delay.
    (Field::Braking, |l| (l.device_mass_kg, l.braking_n_s_per_m) = (0.065, 21.667)),
    (Field::GuardForget, |l| (l.guard.kind, l.guard.forget_s) = (GuardKind::Observer, 0.0)),
];

/// Everything is on.
const ALL_ON: Limits = Limits {
    workspace_low_m: -0.1,
    workspace_high_m: 0.1,
    workspace_soft_m: 0.02,
    braking_n_s_per_m: 5.0,
    guard: GUARD,
    ..Limits::DEFAULT
};

#[test]
fn every_limit_beyond_its_range_is_refused_by_name() {
    let mut bench = Bench::ideal();
    set(&mut bench, plain(100.0, ALL_ON)).expect("good parameters");
    let before = bench.done(Request::GetConfiguration);
    let mut refuse = |limits, field, case: f32| {
        let answer = set(&mut bench, plain(100.0, limits));
        assert_eq!(beyond(&answer), Some(field), "{case}");
    };
    for (field, number, values) in BEYOND {
        for &value in values {
            let mut limits = ALL_ON;
            *number(&mut limits) = value;
            refuse(limits, field, value);
        }
    }
    for (n, (field, change)) in BEYOND_TOGETHER.iter().enumerate() {
        let mut limits = ALL_ON;
        change(&mut limits);
        refuse(limits, *field, n as f32);
    }
    assert_eq!(bench.done(Request::GetConfiguration), before);
}

#[test]
fn every_limit_at_the_end_of_its_range_is_good() {
    type Change = fn(&mut Limits);
    // Each number for itself is asked beside the document's range, in `haptic-trial`.
    let ends: [Change; 10] = [
        |l| {
            (l.workspace_low_m, l.workspace_high_m, l.workspace_soft_m) = (-0.1, 0.2, 0.15);
        },
        |l| (l.speed_soft_m_per_s, l.speed_hard_m_per_s) = (100_f32.next_down(), 100.0),
        |l| (l.device_mass_kg, l.braking_n_s_per_m, l.device_delay_ticks) = (0.065, 65.0, 0),
        |l| (l.device_mass_kg, l.braking_n_s_per_m) = (1e-6, 3e-4),
        |l| (l.guard, l.guard.forget_s, l.guard.share) = (GUARD, 0.0, 1e-3),
        |l| (l.guard, l.guard.damping_n_s_per_m) = (GUARD, 1e-6),
        |l| {
            (
                l.guard,
                l.guard.delay_least_samples,
                l.guard.delay_most_samples,
            ) = (GUARD, 4.0, 4.0);
        },
        |l| {
            l.guard = GUARD;
            (l.guard.delay_most_samples, l.guard.lag_s, l.guard.noise_m) = (4.0, 0.064, 0.01);
        },
        |l| (l.guard, l.guard.damping_n_s_per_m, l.guard.forget_s) = (GUARD, 1e6, 1.0001e-3),
        |l| (l.guard, l.guard.kind, l.guard.forget_s) = (GUARD, GuardKind::Observer, 3600.0),
    ];
    let mut bench = Bench::ideal();
    for (n, change) in ends.iter().enumerate() {
        let mut limits = Limits::DEFAULT;
        change(&mut limits);
        let answer = set(&mut bench, plain(100.0, limits));
        assert!(answer.is_ok(), "{n}: {answer:?}");
    }
}

#[test]
fn what_a_chain_on_the_host_has_goes_over_the_wire_and_is_good() {
    let bounding = EnergyBounding {
        delay_least: Seconds(2e-3),
        delay_most: Seconds(2.5e-3),
        current_lag: Seconds(0.5e-3),
        noise: Metres(1e-6),
        ..EnergyBounding::of(NewtonSecondsPerMetre(3.5))
    };
    let observer = PassivityObserver::bearable(Kilograms(0.065), Seconds(1e-3));
    for guard in [
        None,
        Some(haptic_loop::PassivityGuard::EnergyBounding(bounding)),
        Some(haptic_loop::PassivityGuard::Observer(observer)),
    ] {
        let limits = haptic_loop::SafetyLimits {
            norm: Some(Newtons(5.0)),
            workspace: Some(Workspace {
                low: Metres(-0.1),
                high: Metres(0.1),
                soft: Metres(0.1),
            }),
            speed: Some(SpeedLimit {
                soft: MetresPerSecond(0.5),
                hard: MetresPerSecond(2.0),
            }),
            velocity_bandwidth: Hertz(30.0),
            guard,
            ..haptic_loop::SafetyLimits::default()
        };
        let wire = haptic_remote::wire_limits(&limits, Seconds(1e-3));
        let want = Limits {
            // The smaller of force and norm.
            force_n: 5.0,
            workspace_low_m: -0.1,
            workspace_high_m: 0.1,
            workspace_soft_m: 0.1,
            speed_soft_m_per_s: 0.5,
            speed_hard_m_per_s: 2.0,
            velocity_bandwidth_hz: 30.0,
            // A device does not know how much it bears.
            braking_n_s_per_m: 5.0,
            guard: wire.guard,
            ..Limits::DEFAULT
        };
        assert_eq!(wire, want);
        let mut bench = Bench::ideal();
        set(&mut bench, plain(100.0, wire)).expect("good parameters");
    }
    let bare = haptic_loop::SafetyLimits::bare(Newtons(10.0), NewtonsPerSecond(1000.0));
    let wire = haptic_remote::wire_limits(&bare, Seconds(1e-3));
    assert_eq!(wire, Limits::bare(10.0, 1000.0));
}
