//! What is drawn: faults of a line, configurations, requests.

use crate::line::spring;
use haptic_emulator::LineFaults;
use haptic_link::{Configuration, LoopMode, Request, Scope, Start};
use rand_distr::{Distribution as _, StandardUniform};
use rand_pcg::Pcg32;

pub(super) struct Random(Pcg32);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0x5851_f42d_4c95_7f2d))
    }

    fn chance(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Below `end`.
    pub(super) fn below(&mut self, end: u32) -> u32 {
        let drawn: u32 = StandardUniform.sample(&mut self.0);
        drawn % end
    }

    pub(super) fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    pub(super) fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }

    pub(super) fn faults(&mut self) -> LineFaults {
        let mut some = |most: f64| {
            if self.one_in(2) {
                most * self.chance()
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

    pub(super) fn configuration(&mut self) -> (Configuration, [f32; 2]) {
        let (mut configuration, values) = spring();
        configuration.loop_mode = self.of(&[LoopMode::Device, LoopMode::Host]);
        configuration.tick_period_us = self.of(&[500, 1000, 1000, 2000]);
        configuration.stiffness_n_per_m = self.of(&[0.0, 300.0, 3000.0]);
        configuration.simulation.push_n = self.of(&[0.0, 1.0, -3.0]);
        configuration.limits.force_n = self.of(&[0.5, 2.0, 10.0]);
        configuration.limits.force_rate_n_per_s = self.of(&[0.1, 300.0, 1000.0, 10_000.0]);
        configuration.limits.stop_time_s = self.of(&[0.001, 0.03, 0.1, 0.25]);
        configuration.limits.brake_force_n = self.of(&[0.0, 2.0, 10.0]);
        configuration.limits.braking_n_s_per_m = self.of(&[0.0, 0.5, 5.0]);
        if self.one_in(2) {
            // The most that 65 g bear with a tick of delay, for the longest tick here.
            configuration.limits.device_mass_kg = 0.065;
            configuration.limits.braking_n_s_per_m = 10.8;
        }
        configuration.limits.stuck_force_n = self.of(&[0.0, 0.2, 3.0]);
        configuration.limits.jump_m = self.of(&[0.0, 1e-3]);
        configuration.limits.watchdog_ms = self.of(&[5, 20, 50]);
        configuration.limits.late_ticks = self.of(&[0, 1, 20]);
        configuration.limits.max_age_ticks = self.of(&[1, 10, 1000]);
        if self.one_in(8) {
            configuration.surface_m = f32::NAN;
        }
        (configuration, values)
    }

    pub(super) fn request(&mut self, faults: u16) -> Request {
        match self.below(16) {
            0 => Request::Hello {
                nonce: self.below(3),
            },
            1 => Request::GetCapabilities,
            2 => Request::Commit {
                digest: 1,
                scope: self.of(&[Scope::Run, Scope::Lasting]),
            },
            3 => Request::GetConfiguration,
            4 => Request::GetCoefficients {
                offset: self.of(&[0, 1, 16]),
            },
            5..=7 => Request::Arm {
                faults: faults.wrapping_sub(u16::from(self.one_in(8))),
            },
            8 => Request::Disarm,
            9..=11 => Request::Start(Start {
                run: self.below(3),
                ticks: self.of(&[0, 0, 1, 30]),
                every: self.of(&[1, 1, 3, 0]),
                batch: self.of(&[1, 1, 5, 17]),
            }),
            12 => Request::Stop,
            13 => Request::GetStatistics,
            14 => Request::ReadFlight {
                index: self.of(&[0, 95, 96]),
            },
            _ => Request::Stream {
                every: self.of(&[0, 1, 2]),
                batch: self.of(&[0, 1, 16]),
            },
        }
    }
}
