//! Limits and length of a measurement.

use crate::document::failure::Failure;
use crate::question::measurement::keys::{
    MEASURE_BOX, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME,
};
use fracdiff::parameter::Shown;
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{Limits, Stuck, Workspace};

/// Settings of a measurement.
///
/// ```
/// use haptic_experiment::question::measurement::MeasurePlan;
///
/// let plan = MeasurePlan { force_limit_n: 3.3, ..MeasurePlan::default() };
/// plan.check()?;
/// assert!((plan.force_n() - 0.66).abs() < 1e-12); // no more than that, ever
/// # Ok::<(), haptic_experiment::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasurePlan {
    /// T.
    pub sample_time_s: f64,
    /// Largest force that the device may make, N. The measurement stays within [`SHARE`](Self::SHARE) of it.
    pub force_limit_n: f64,
    /// The device stays within this distance of where it is at the start, m.
    pub box_m: f64,
    /// Length of the multi-sine, s.
    pub duration_s: f64,
    /// True if a hand holds the device: its stiffness is looked for too.
    pub hand: bool,
}

impl Default for MeasurePlan {
    fn default() -> Self {
        Self {
            sample_time_s: MEASURE_SAMPLE_TIME.default_number(),
            force_limit_n: MEASURE_FORCE_LIMIT.default_number(),
            box_m: MEASURE_BOX.default_number(),
            duration_s: MEASURE_DURATION.default_number(),
            hand: false,
        }
    }
}

impl MeasurePlan {
    /// Share of the force limit that is used at most.
    pub const SHARE: f64 = 0.2;
    /// Time without force at the beginning, s.
    pub(super) const REST_S: f64 = 0.5;
    /// Time in which a ramp reaches the largest force, s.
    pub(super) const RAMP_S: f64 = 1.5;
    /// Share of [`near_m`](Self::near_m) by which a device moves when it is said to move, and of the box in which it may rest.
    pub(super) const MOVES: f64 = 0.02;

    /// Largest force of the measurement, N.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        Self::SHARE * self.force_limit_n
    }

    /// The length to which motions are compared, m: the box, but not more than the usual one. A wider box gives room, it asks for no more motion.
    pub(super) fn near_m(&self) -> f64 {
        f64::min(self.box_m, MEASURE_BOX.default_number())
    }

    /// Refuses what is outside its range.
    ///
    /// # Errors
    /// The parameter, its value and its range.
    pub fn check(&self) -> Result<(), Failure> {
        let values = [
            (&MEASURE_SAMPLE_TIME, self.sample_time_s, "s", "as in 1ms"),
            (&MEASURE_FORCE_LIMIT, self.force_limit_n, "N", "as in 10N"),
            (&MEASURE_BOX, self.box_m, "m", "as in 5mm"),
            (&MEASURE_DURATION, self.duration_s, "s", "as in 8s"),
        ];
        for (parameter, value, unit, example) in values {
            let range = parameter.range();
            if !range.contains(value) {
                return Err(Failure::bad_input(format_args!(
                    "{} {value} {unit} is not {range}: change `{}`, {example}",
                    parameter.key,
                    parameter.key,
                    value = Shown(value)
                )));
            }
        }
        Ok(())
    }

    /// Limits of the safety chain of a device that is at `start_m`.
    #[must_use]
    pub fn limits(&self, start_m: f64) -> Limits {
        let force = self.force_n();
        let default = Limits::default();
        // As steep as the fastest line of the multi-sine, so that its highest frequencies get through.
        let rate = f64::max(default.rate.0, 1000.0 * force);
        Limits {
            force: Newtons(force),
            norm: None,
            rate: NewtonsPerSecond(rate),
            brake_force: Newtons(f64::min(default.brake_force.0, force)),
            stuck: default.stuck.map(|stuck| Stuck {
                force: Newtons(force),
                ..stuck
            }),
            workspace: Some(Workspace {
                low: Metres(start_m - self.box_m),
                high: Metres(start_m + self.box_m),
                soft: Metres(0.1 * self.box_m),
            }),
            rise_time: None,
            ..default
        }
    }

    /// Ticks of a time.
    pub(super) fn ticks(&self, time_s: f64) -> u64 {
        (time_s / self.sample_time_s).round() as u64
    }

    /// Most ticks that a measurement takes, its ramps and the way to zero included.
    #[must_use]
    pub fn ticks_at_most(&self) -> u64 {
        self.ticks(Self::REST_S + 2.0 * Self::RAMP_S + 2.0 + self.duration_s)
    }
}
