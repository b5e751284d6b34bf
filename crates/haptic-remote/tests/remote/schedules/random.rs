//! What is drawn: faults of a line, configurations, requests.

use crate::line::spring;
use haptic_emulator::LineFaults;
use haptic_link::{Configuration, LoopMode, Request, Scope, Start};
use testkit::Random;

/// Below `end`.
pub(super) fn below(random: &mut Random, end: u32) -> u32 {
    (random.bits() % u64::from(end)) as u32
}

pub(super) fn faults(random: &mut Random) -> LineFaults {
    let mut some = |most: f64| {
        if random.chance(0.5) {
            random.between(0.0, most)
        } else {
            0.0
        }
    };
    LineFaults {
        drop: some(0.5),
        corrupt: some(0.5),
        duplicate: some(0.3),
        reorder: some(0.3),
        delay_s: some(0.03),
        stall: some(0.02),
        stall_s: some(0.1),
    }
}

pub(super) fn configuration(random: &mut Random) -> (Configuration, [f32; 2]) {
    let (mut configuration, values) = spring();
    configuration.loop_mode = random.one_of(&[LoopMode::Device, LoopMode::Host]);
    configuration.tick_period_us = random.one_of(&[500, 1000, 1000, 2000]);
    configuration.stiffness_n_per_m = random.one_of(&[0.0, 300.0, 3000.0]);
    configuration.simulation.push_n = random.one_of(&[0.0, 1.0, -3.0]);
    configuration.limits.force_n = random.one_of(&[0.5, 2.0, 10.0]);
    configuration.limits.force_rate_n_per_s = random.one_of(&[0.1, 300.0, 1000.0, 10_000.0]);
    configuration.limits.stop_time_s = random.one_of(&[0.001, 0.03, 0.1, 0.25]);
    configuration.limits.brake_force_n = random.one_of(&[0.0, 2.0, 10.0]);
    configuration.limits.braking_n_s_per_m = random.one_of(&[0.0, 0.5, 5.0]);
    if random.chance(0.5) {
        // The most that 65 g bear with a tick of delay, for the longest tick here.
        configuration.limits.device_mass_kg = 0.065;
        configuration.limits.braking_n_s_per_m = 10.8;
    }
    configuration.limits.stuck_force_n = random.one_of(&[0.0, 0.2, 3.0]);
    configuration.limits.jump_m = random.one_of(&[0.0, 1e-3]);
    configuration.limits.watchdog_ms = random.one_of(&[5, 20, 50]);
    configuration.limits.late_ticks = random.one_of(&[0, 1, 20]);
    configuration.limits.max_age_ticks = random.one_of(&[1, 10, 1000]);
    if random.chance(0.25) {
        // A sphere of 5 mm in tissue that stiffens.
        configuration.one_sided = true;
        configuration.depth_map = Some([200.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2000.0]);
    }
    if random.chance(0.125) {
        configuration.surface_m = f32::NAN;
    }
    (configuration, values)
}

pub(super) fn request(random: &mut Random, faults: u16) -> Request {
    match below(random, 16) {
        0 => Request::Hello {
            nonce: below(random, 3),
        },
        1 => Request::GetCapabilities,
        2 => Request::Commit {
            digest: 1,
            scope: random.one_of(&[Scope::Run, Scope::Lasting]),
        },
        3 => Request::GetConfiguration,
        4 => Request::GetCoefficients {
            offset: random.one_of(&[0, 1, 16]),
        },
        5..=7 => Request::Arm {
            faults: faults.wrapping_sub(u16::from(random.chance(0.125))),
        },
        8 => Request::Disarm,
        9..=11 => Request::Start(Start {
            run: below(random, 3),
            ticks: random.one_of(&[0, 0, 1, 30]),
            every: random.one_of(&[1, 1, 3, 0]),
            batch: random.one_of(&[1, 1, 5, 17]),
        }),
        12 => Request::Stop,
        13 => Request::GetStatistics,
        14 => Request::ReadFlight {
            index: random.one_of(&[0, 95, 96]),
        },
        _ => Request::Stream {
            every: random.one_of(&[0, 1, 2]),
            batch: random.one_of(&[0, 1, 16]),
        },
    }
}
