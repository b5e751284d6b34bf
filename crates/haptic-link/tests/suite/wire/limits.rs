//! Limits that a run may tighten, and never loosen.

use haptic_link::{Configuration, Field, Limits};
use proptest::prelude::*;

/// The limits that a device was set to.
const SET: Limits = Limits {
    workspace_low_m: -0.1,
    workspace_high_m: 0.1,
    stuck_force_n: 3.0,
    jump_m: 1e-3,
    device_mass_kg: 0.065,
    ..Limits::DEFAULT
};

type Change = fn(&mut Limits);

const TIGHTER: [Change; 7] = [
    |l| l.force_n = 1.0,
    |l| l.force_rate_n_per_s = 10.0,
    |l| l.start_force_n = 0.5,
    |l| l.rise_time_s = 2.0,
    |l| l.workspace_high_m = 0.05,
    |l| l.speed_hard_m_per_s = 1.2,
    // What belongs to a host and its line.
    |l| (l.watchdog_ms, l.late_ticks, l.max_age_ticks) = (1000, 0, 1000),
];

/// What is refused, and the field that is blamed.
const LOOSER: [(Field, Change); 23] = [
    (Field::ForceLimit, |l| l.force_n = 10.1),
    (Field::ForceLimit, |l| l.force_n = f32::NAN),
    (Field::ForceRateLimit, |l| l.force_rate_n_per_s = 1e5),
    (Field::StartForce, |l| l.start_force_n = 0.0),
    (Field::StartForce, |l| l.start_force_n = 2.0),
    (Field::RiseTime, |l| l.rise_time_s = 0.0),
    (Field::SpeedHard, |l| {
        (l.speed_soft_m_per_s, l.speed_hard_m_per_s) = (0.0, 0.0);
    }),
    (Field::SpeedHard, |l| l.speed_hard_m_per_s = 2.0),
    (Field::VelocityBandwidth, |l| l.velocity_bandwidth_hz = 10.0),
    (Field::StopTime, |l| l.stop_time_s = 1.0),
    (Field::BrakeForce, |l| l.brake_force_n = 10.0),
    (Field::StuckForce, |l| l.stuck_force_n = 0.0),
    (Field::StuckForce, |l| l.stuck_force_n = 30.0),
    (Field::StuckTime, |l| l.stuck_time_s = 10.0),
    (Field::Jump, |l| l.jump_m = 0.0),
    (Field::Jump, |l| l.jump_m = 0.1),
    (Field::DeviceMass, |l| l.device_mass_kg = 0.0),
    (Field::DeviceMass, |l| l.device_mass_kg = 5.0),
    (Field::DeviceMass, |l| l.device_delay_ticks = 0),
    (Field::WorkspaceLow, |l| {
        (l.workspace_low_m, l.workspace_high_m) = (0.0, 0.0);
    }),
    (Field::WorkspaceLow, |l| l.workspace_low_m = -0.2),
    (Field::WorkspaceHigh, |l| l.workspace_high_m = 0.2),
    (Field::WorkspaceLow, |l| {
        (l.workspace_low_m, l.workspace_high_m) = (0.2, 0.3);
    }),
];

#[test]
fn a_run_may_tighten_limits_and_not_loosen_them() {
    assert_eq!(SET.tightened(&SET), (SET, None));
    for change in TIGHTER {
        let mut limits = SET;
        change(&mut limits);
        assert_eq!(limits.tightened(&SET), (limits, None));
    }
    for (field, change) in LOOSER {
        let mut limits = SET;
        change(&mut limits);
        assert_eq!(limits.tightened(&SET), (SET, Some(field)), "{limits:?}");
    }
}

#[test]
fn what_brakes_or_guards_may_be_switched_on_and_not_off() {
    let set = SET;
    // Where a motion is braked, from no later on.
    let mut braked = set;
    (braked.braking_n_s_per_m, braked.speed_soft_m_per_s) = (5.0, 0.0);
    let mut later = braked;
    later.speed_soft_m_per_s = 0.5;
    assert_eq!(later.tightened(&braked), (braked, Some(Field::SpeedSoft)));
    // Braking and guard: on stays on as it is, off may be switched on.
    let mut braking = set;
    (braking.braking_n_s_per_m, braking.workspace_soft_m) = (5.0, 0.02);
    assert_eq!(braking.tightened(&set), (braking, None));
    assert_eq!(set.tightened(&braking), (braking, Some(Field::Braking)));
    let mut harder = braking;
    harder.braking_n_s_per_m = 1000.0;
    assert_eq!(harder.tightened(&braking), (braking, Some(Field::Braking)));
    let mut guarded = set;
    guarded.guard.kind = haptic_link::GuardKind::Observer;
    assert_eq!(guarded.tightened(&set), (guarded, None));
    assert_eq!(
        set.tightened(&guarded),
        (guarded, Some(Field::GuardDamping))
    );
}

#[test]
fn delays_of_the_guard_are_times_whatever_the_tick_of_a_run() {
    let mut set = Configuration::PASSIVE;
    set.tick_period_us = 1000;
    set.limits.guard = haptic_link::Guard {
        kind: haptic_link::GuardKind::EnergyBounding,
        damping_n_s_per_m: 1.0,
        delay_least_samples: 1.0,
        delay_most_samples: 1.5,
        ..haptic_link::Guard::OFF
    };
    set.limits.device_mass_kg = 0.065;
    set.limits.device_delay_ticks = 1;
    // Half the tick: the same ticks of delay would be half the time.
    let run = Configuration {
        tick_period_us: 500,
        ..set
    };
    let (tight, looser) = run.tightened(&set);
    assert!(looser.is_some());
    assert_eq!(
        (
            tight.guard.delay_least_samples,
            tight.guard.delay_most_samples
        ),
        (2.0, 3.0)
    );
    assert_eq!(tight.device_delay_ticks, 2);
    let held = Configuration {
        limits: tight,
        ..run
    };
    assert_eq!(held.tightened(&set), (tight, None));
    assert_eq!(set.tightened(&set), (set.limits, None));
    // Three times as long a tick: a third of the ticks, whole ones rounded up.
    let slow = Configuration {
        tick_period_us: 3000,
        ..set
    };
    let (tight, _) = slow.tightened(&set);
    assert_eq!(
        (tight.guard.delay_most_samples, tight.device_delay_ticks),
        (0.5, 1)
    );
}

proptest! {
    #[test]
    fn what_was_tightened_is_never_loose(
        a in prop::array::uniform8(-1.0_f32..3.0),
        b in prop::array::uniform8(-1.0_f32..3.0),
    ) {
        let limits = |v: [f32; 8]| Limits {
            force_n: v[0],
            start_force_n: v[1].max(0.0),
            rise_time_s: v[2].max(0.0),
            workspace_low_m: v[3],
            workspace_high_m: v[3] + v[4],
            // As a device accepts them: a soft limit below the hard one, or none.
            speed_soft_m_per_s: if v[6] > 0.1 { v[5].max(0.0) } else { 0.0 },
            speed_hard_m_per_s: if v[6] > 0.1 { v[5].max(0.0) + v[6] } else { 0.0 },
            braking_n_s_per_m: v[7].max(0.0),
            ..Limits::DEFAULT
        };
        let (wanted, set) = (limits(a), limits(b));
        let (tight, _) = wanted.tightened(&set);
        prop_assert_eq!(tight.tightened(&set), (tight, None));
    }
}
