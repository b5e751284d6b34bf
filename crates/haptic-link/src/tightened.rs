//! Limits of a run beside those that were set to last: a run may only tighten them.

use crate::configuration::Configuration;
use crate::field::Field;
use crate::limits::{Guard, GuardKind, Limits};

/// The first limit that was looser.
#[derive(Default)]
struct Looser(Option<Field>);

impl Looser {
    /// The limit itself if it is on the tight side, else the other one. A number that is none is loose.
    #[inline(never)]
    fn keep(&mut self, field: Field, tight: bool, value: f32, set: f32) -> f32 {
        if tight {
            return value;
        }
        self.0.get_or_insert(field);
        set
    }

    #[inline(never)]
    fn at_most(&mut self, field: Field, value: f32, set: f32) -> f32 {
        self.keep(field, value <= set, value, set)
    }

    #[inline(never)]
    fn at_least(&mut self, field: Field, value: f32, set: f32) -> f32 {
        self.keep(field, value >= set, value, set)
    }

    /// 0 is no limit.
    #[inline(never)]
    fn at_most_if_on(&mut self, field: Field, value: f32, set: f32) -> f32 {
        let tight = set <= 0.0 || (value > 0.0 && value <= set);
        self.keep(field, tight, value, set)
    }
}

impl Configuration {
    /// [`Limits::tightened`] of a run whose ticks may be of another length than those of what was set to last: delays
    /// are times, so many ticks there are other ones here.
    #[must_use]
    pub fn tightened(&self, set: &Self) -> (Limits, Option<Field>) {
        let mut limits = set.limits;
        if self.tick_period_us != set.tick_period_us {
            // Ticks of this run in a tick of what was set.
            let ticks = set.tick_period_us as f32 / self.tick_period_us.max(1) as f32;
            limits.guard.delay_least_samples *= ticks;
            limits.guard.delay_most_samples *= ticks;
            let delay = f32::from(limits.device_delay_ticks) * ticks;
            // Rounded up; a cast stays within a byte.
            let whole = delay as u8;
            let more = u8::from(f32::from(whole) < delay);
            limits.device_delay_ticks = whole.saturating_add(more);
        }
        self.limits.tightened(&limits)
    }
}

impl Limits {
    /// These limits, each replaced by the one of `set` where that is tighter; and the first that was looser.
    ///
    /// - *Tighter* are less force, rate, force at a start, speed, a narrower workspace, a longer rise, a faster estimate
    ///   of the velocity, a shorter stop, less force of braking in it, a stricter look at the position.
    /// - *Mass and delay* of the device say how much braking it bears: less mass and more delay are tighter.
    /// - *Braking and guard* have no order: where they are on they stay as they were set, where they are off a run may
    ///   switch them on.
    /// - *Of the run* are watchdog, late ticks and age of a force, within their ranges: they suit its line and its host.
    #[must_use]
    pub fn tightened(&self, set: &Self) -> (Self, Option<Field>) {
        let mut looser = Looser::default();
        let mut tight = Self {
            force_n: looser.at_most(Field::ForceLimit, self.force_n, set.force_n),
            force_rate_n_per_s: looser.at_most(
                Field::ForceRateLimit,
                self.force_rate_n_per_s,
                set.force_rate_n_per_s,
            ),
            start_force_n: looser.at_most_if_on(
                Field::StartForce,
                self.start_force_n,
                set.start_force_n,
            ),
            rise_time_s: looser.at_least(Field::RiseTime, self.rise_time_s, set.rise_time_s),
            speed_hard_m_per_s: looser.at_most_if_on(
                Field::SpeedHard,
                self.speed_hard_m_per_s,
                set.speed_hard_m_per_s,
            ),
            velocity_bandwidth_hz: looser.at_least(
                Field::VelocityBandwidth,
                self.velocity_bandwidth_hz,
                set.velocity_bandwidth_hz,
            ),
            stop_time_s: looser.at_most(Field::StopTime, self.stop_time_s, set.stop_time_s),
            brake_force_n: looser.at_most(Field::BrakeForce, self.brake_force_n, set.brake_force_n),
            jump_m: looser.at_most_if_on(Field::Jump, self.jump_m, set.jump_m),
            ..*self
        };
        self.tighten_stuck(set, &mut tight, &mut looser);
        self.tighten_device(set, &mut tight, &mut looser);
        self.tighten_workspace(set, &mut tight, &mut looser);
        self.tighten_braking(set, &mut tight, &mut looser);
        if set.guard.kind != GuardKind::Off && self.guard != set.guard {
            looser.0.get_or_insert(Field::GuardDamping);
            tight.guard = Guard { ..set.guard };
        }
        (tight, looser.0)
    }

    fn tighten_stuck(&self, set: &Self, tight: &mut Self, looser: &mut Looser) {
        tight.stuck_force_n =
            looser.at_most_if_on(Field::StuckForce, self.stuck_force_n, set.stuck_force_n);
        if set.stuck_force_n > 0.0 {
            tight.stuck_time_s =
                looser.at_most(Field::StuckTime, self.stuck_time_s, set.stuck_time_s);
        }
    }

    fn tighten_device(&self, set: &Self, tight: &mut Self, looser: &mut Looser) {
        if set.device_mass_kg > 0.0 {
            tight.device_mass_kg =
                looser.at_most_if_on(Field::DeviceMass, self.device_mass_kg, set.device_mass_kg);
            if self.device_delay_ticks < set.device_delay_ticks {
                looser.0.get_or_insert(Field::DeviceMass);
                tight.device_delay_ticks = set.device_delay_ticks;
            }
        }
    }

    fn tighten_workspace(&self, set: &Self, tight: &mut Self, looser: &mut Looser) {
        let ends = |limits: &Self| (limits.workspace_low_m, limits.workspace_high_m);
        let ((low, high), (set_low, set_high)) = (ends(self), ends(set));
        if set_low >= set_high {
            return;
        }
        let inside = low < high && low < set_high && high > set_low;
        (tight.workspace_low_m, tight.workspace_high_m) = if inside {
            (
                looser.at_least(Field::WorkspaceLow, low, set_low),
                looser.at_most(Field::WorkspaceHigh, high, set_high),
            )
        } else {
            looser.0.get_or_insert(Field::WorkspaceLow);
            (set_low, set_high)
        };
    }

    fn tighten_braking(&self, set: &Self, tight: &mut Self, looser: &mut Looser) {
        if set.braking_n_s_per_m > 0.0 {
            let same = (self.braking_n_s_per_m - set.braking_n_s_per_m).abs() <= 0.0;
            tight.braking_n_s_per_m = looser.keep(
                Field::Braking,
                same,
                self.braking_n_s_per_m,
                set.braking_n_s_per_m,
            );
            let half = 0.5 * (tight.workspace_high_m - tight.workspace_low_m);
            tight.workspace_soft_m = looser.at_least(
                Field::WorkspaceSoft,
                self.workspace_soft_m,
                set.workspace_soft_m.min(half),
            );
            // 0 brakes every motion.
            if set.speed_hard_m_per_s > 0.0 {
                tight.speed_soft_m_per_s = looser.at_most(
                    Field::SpeedSoft,
                    self.speed_soft_m_per_s,
                    set.speed_soft_m_per_s,
                );
            }
        }
        // If the hard limit came from the set configuration, the zone before it has to fit.
        if tight.speed_hard_m_per_s > 0.0 && tight.speed_soft_m_per_s >= tight.speed_hard_m_per_s
            || self.speed_hard_m_per_s <= 0.0
        {
            tight.speed_soft_m_per_s = set.speed_soft_m_per_s.min(tight.speed_hard_m_per_s);
        }
    }
}
