//! A tick: what a loop did in it, what the log tells of it, and what a run keeps of it.

use fracdiff::Real;
use haptic_log::record::flaw::{IMPOSSIBLE, LATE_FORCE};
use haptic_log::record::{AnyTick, TickMessage};
use haptic_loop::Sample;
use nalgebra::SVector;

/// A sample that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptSample {
    /// Its number.
    pub tick: u64,
    /// Its time, s.
    pub time_s: f64,
    /// Position of the renderer as the loop read it, m.
    pub position_m: f64,
    /// Force on the device by which the run is judged, N: the one commanded in answer to this position where the device made that, else the
    /// one that it made.
    pub force_n: f64,
    /// Force that the device made in this tick, N.
    pub applied_force_n: f64,
    /// Place of the indenter, m.
    pub indenter_position_m: f64,
    /// Force between indenter and renderer, N.
    pub contact_force_n: f64,
    /// Limiters that acted, bits.
    pub limiters: u8,
}

impl KeptSample {
    /// True of a sample that says something of the law: no limiter acted in it, the ramp of the start neither. Others are counted, and
    /// compared with nothing.
    #[must_use]
    pub(crate) const fn is_comparable(&self) -> bool {
        self.limiters == 0
    }

    /// Force that is opposed to an indentation, N: the negative of what is commanded.
    #[must_use]
    pub(crate) fn reaction_n(&self) -> f64 {
        // Not a negation, which would make −0 of 0.
        0.0 - self.force_n
    }

    pub(crate) const fn of(message: &TickMessage) -> Self {
        Self {
            tick: message.tick,
            time_s: message.time_s,
            position_m: message.position_m,
            force_n: judged_force(
                (message.limiters, message.flaws),
                message.commanded_force_n,
                message.applied_force_n,
            ),
            applied_force_n: message.applied_force_n,
            indenter_position_m: message.indenter_position_m,
            contact_force_n: message.contact_force_n,
            limiters: message.limiters,
        }
    }
}

/// The force by which a tick is judged: the one commanded in answer to its position, unless the device made another because its own chain
/// limited, or because it had none of the newest answers. A log of forces that no device made would be judged as if it had.
pub(crate) const fn judged_force<T: Copy>(
    (limiters, flaws): (u8, u8),
    commanded: T,
    applied: T,
) -> T {
    match (limiters, flaws & (LATE_FORCE | IMPOSSIBLE)) {
        (0, 0) => commanded,
        _ => applied,
    }
}

/// What a loop did in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tick<const D: usize> {
    /// Its number.
    pub tick: u64,
    /// Its time, s.
    pub time_s: f64,
    /// Position as the loop read it, m.
    pub position_m: SVector<f64, D>,
    /// Force that the environment wanted, N.
    pub environment_force_n: SVector<f64, D>,
    /// Force commanded in answer to it, N.
    pub commanded_force_n: SVector<f64, D>,
    /// Force that the device made, N: in a loop on the host it answers an earlier position.
    pub applied_force_n: SVector<f64, D>,
    /// Limiters that acted, bits.
    pub limiters: u8,
    /// What is wrong with the tick, bits of [`flaw`](haptic_log::record::flaw).
    pub flaws: u8,
    /// Energy that the guard observed, J; not a number without one.
    pub observed_energy_j: f64,
}

impl<const D: usize> Tick<D> {
    /// Of a loop of this program.
    fn by_loop<F: Real>(sample: &Sample<F, D>, guarded_energy_j: Option<F>) -> Self {
        let force_n = sample.force.newtons().map(F::to_f64);
        Self {
            tick: sample.reading.tick,
            time_s: sample.reading.time_s,
            position_m: sample.reading.position_m.map(F::to_f64),
            environment_force_n: sample.environment_force_n.map(F::to_f64),
            commanded_force_n: force_n,
            applied_force_n: force_n,
            limiters: sample.limiters.bits(),
            flaws: 0,
            observed_energy_j: guarded_energy_j.map_or(f64::NAN, Real::to_f64),
        }
    }
}

/// What is told of a tick: as the log has it, and as a run is judged by.
pub(crate) trait TickRecord<const D: usize = 1>: Copy {
    /// With what a loop did.
    #[must_use]
    fn of(self, made: &Tick<D>) -> Self;

    /// With what a loop of this program did.
    #[must_use]
    fn of_loop<F: Real>(self, sample: &Sample<F, D>, guarded_energy_j: Option<F>) -> Self {
        self.of(&Tick::by_loop(sample, guarded_energy_j))
    }

    /// For the log.
    fn logged(&self) -> AnyTick;

    /// For the report.
    fn kept(&self) -> KeptSample;

    /// The limiters that acted.
    fn limiters(&self) -> u8;
}

impl TickRecord for TickMessage {
    fn of(self, made: &Tick<1>) -> Self {
        Self {
            tick: made.tick,
            time_s: made.time_s,
            position_m: made.position_m[0],
            environment_force_n: made.environment_force_n[0],
            commanded_force_n: made.commanded_force_n[0],
            applied_force_n: made.applied_force_n[0],
            limiters: made.limiters,
            flaws: made.flaws,
            observed_energy_j: made.observed_energy_j,
            ..self
        }
    }

    fn logged(&self) -> AnyTick {
        (*self).into()
    }

    fn kept(&self) -> KeptSample {
        KeptSample::of(self)
    }

    fn limiters(&self) -> u8 {
        self.limiters
    }
}
