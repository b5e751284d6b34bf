//! A host that is late while a hand moves the handle: no fast hand, and no jump of the position.

use super::wire::{FORCE_N, Law, Running, TICK_US, stroked};
use haptic_devices::haply::Version;
use haptic_link::{Limits, State};
use haptic_loop::{Device as _, Fault};

/// A stroked handle under the limits of any device, free of force.
fn free(version: Version, limits: Limits) -> Running {
    let now_us = 1_200_000;
    let law = Law {
        limits: Limits {
            force_n: FORCE_N,
            watchdog_ms: 1000,
            late_ticks: 0,
            ..limits
        },
        ..Law::default()
    };
    Running::with(stroked(version, now_us), version, now_us, &law)
}

/// Largest step between two ticks, m, and the fault; each n-th tick comes after so many that did not.
fn stepped(limits: Limits, every: usize, skipped: u32) -> (f32, Option<Fault>) {
    let mut running = free(Version::V3, limits);
    let (mut largest_m, mut last_m) = (0.0_f32, None);
    for n in 1..=1000 {
        running.tick_after(if n % every == 0 { skipped } else { 0 });
        if running.device.status().state != State::Running {
            break;
        }
        let [position_m] = running.device.newest().position_m;
        let before_m = last_m.replace(position_m).unwrap_or(position_m);
        largest_m = largest_m.max((position_m - before_m).abs());
    }
    let fault = Fault::from_code(running.device.status().fault);
    (largest_m, fault)
}

/// The limits of any device, with a speed that the strokes stay below and a step that they reach in some ticks.
const SLOW: Limits = Limits {
    speed_soft_m_per_s: 0.15,
    speed_hard_m_per_s: 0.18,
    jump_m: 5e-5,
    ..Limits::DEFAULT
};

#[test]
fn ticks_that_are_skipped_are_no_jump_of_the_position_and_no_speed() {
    let (usual_m, fault) = stepped(SLOW, 10, 0);
    assert_eq!(fault, None);
    // What is allowed from one tick to the next.
    let allowed_m = SLOW.jump_m + SLOW.speed_hard_m_per_s * 1e-6 * TICK_US as f32;
    assert!(usual_m < allowed_m, "{usual_m} m");
    for (every, skipped) in [(10, 6), (3, 2), (50, 20)] {
        let (largest_m, fault) = stepped(SLOW, every, skipped);
        assert_eq!(fault, None, "{skipped} of {every}: {largest_m} m");
        assert!(largest_m > allowed_m, "{skipped} of {every}: {largest_m} m");
    }
}

#[test]
fn a_handle_that_is_too_fast_is_too_fast_with_a_late_host_too() {
    let slower = Limits {
        speed_soft_m_per_s: 0.05,
        speed_hard_m_per_s: 0.06,
        ..SLOW
    };
    for (every, skipped) in [(10, 0), (10, 6), (2, 3)] {
        let (_, fault) = stepped(slower, every, skipped);
        let known = [Fault::Velocity, Fault::PositionJump];
        assert!(
            fault.is_some_and(|fault| known.contains(&fault)),
            "{skipped} of {every}: {fault:?}"
        );
    }
}

#[test]
fn after_a_standstill_the_first_frame_has_no_torque_and_the_board_stays_in_order() {
    // Told at the next tick; and at once, while the board still owes an answer.
    for at_once in [false, true] {
        let now_us = 1_200_000;
        let mut running = Running::on(stroked(Version::V3, now_us), Version::V3, now_us);
        while running.device.newest().force_n[0].abs() < 0.1 {
            running.tick();
        }
        assert!(running.torque() > 1e-4);
        running.device.stood_still();
        if at_once {
            running.device.hardware_mut().let_go();
        } else {
            running.tick_after(2600);
        }
        for _ in 0..20 {
            assert!(running.torque() <= 0.0);
            running.tick();
        }
        let fault = Fault::from_code(running.device.status().fault);
        assert_eq!(fault, Some(Fault::HostSilent));
        assert_eq!(running.device.hardware().ended_by(), None);
    }
}
