//! A tick: its course in a loop, its record in the log, and the part of it that a run keeps.

use fracdiff::Real;
use haptic_link::BatchItem;
use haptic_loop::LoopSample;
use haptic_message::{
    PerAxis, TickMessage,
    flaw::{IMPOSSIBLE, LATE_FORCE},
};
use nalgebra::SVector;

/// A tick as a run keeps it, in memory and for its judges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptSample {
    /// Number of the tick; ticks that were lost leave gaps.
    pub tick: u64,
    /// Time on the clock of the device, s.
    pub time_s: f64,
    /// Position of the renderer as the loop read it, m.
    pub position_m: f64,
    /// Force on the device by which the run is judged, N: the one commanded for this position if
    /// the device applied it, else the one that it applied.
    pub force_n: f64,
    /// Force that the device made in this tick, N.
    pub applied_force_n: f64,
    /// Place of the indenter, m.
    pub indenter_position_m: f64,
    /// Force between indenter and renderer, N.
    pub contact_force_n: f64,
    /// Force at the sensor of the device, N; `None` without one, and until its offset is known.
    pub sensed_force_n: Option<f64>,
    /// Limiters that acted, as bits.
    pub limiters: u8,
}

impl KeptSample {
    /// True of a sample that says something of the law: no limiter acted in it, the ramp of the start neither. Others are counted, and
    /// compared with nothing.
    pub const fn is_comparable(&self) -> bool {
        self.limiters == 0
    }

    /// Force that is opposed to an indentation, N: the negative of what is commanded.
    pub fn reaction_n(&self) -> f64 {
        // Not a negation, which would make −0 of 0.
        0.0 - self.force_n
    }

    /// The part of a message that is kept: the first axis.
    pub fn of(message: &TickMessage) -> Self {
        Self {
            tick: message.tick,
            time_s: message.time_s,
            position_m: message.position_m[0],
            force_n: judged_force_n(message)[0],
            applied_force_n: message.applied_force_n[0],
            indenter_position_m: message.indenter_position_m[0],
            contact_force_n: message.contact_force_n[0],
            sensed_force_n: (message.sensed_force_n.map(|axes| axes[0]))
                .filter(|force_n| force_n.is_finite()),
            limiters: message.limiters,
        }
    }
}

/// The force by which a tick is judged: the one commanded in answer to its position, unless the device made another because its own chain
/// limited, or because it had none of the newest answers. A log of forces that no device made would be judged as if it had.
pub const fn judged_force_n(tick: &TickMessage) -> PerAxis {
    match (tick.limiters, tick.flaws & (LATE_FORCE | IMPOSSIBLE)) {
        (0, 0) => tick.commanded_force_n,
        _ => tick.applied_force_n,
    }
}

/// The numbers of a vector.
pub fn per_axis<F: Real, const D: usize>(vector: &SVector<F, D>) -> PerAxis {
    PerAxis::new(vector.map(F::to_f64).as_slice())
}

/// The message of a tick with what the device reported about it.
#[must_use]
pub fn by_device(message: TickMessage, sample: &haptic_link::Sample, time_s: f64) -> TickMessage {
    let axes = &sample.axes;
    let of = |read: fn(&BatchItem) -> f32| axes.iter().map(|axis| read(axis).into()).collect();
    let force_n: PerAxis = of(|axis| axis.force_n);
    let first = axes.first().copied().unwrap_or_default();
    TickMessage {
        tick: sample.tick.into(),
        time_s,
        position_m: of(|axis| axis.position_m),
        environment_force_n: of(|axis| axis.environment_force_n),
        commanded_force_n: force_n,
        applied_force_n: force_n,
        limiters: first.limiters,
        flaws: first.flaws,
        observed_energy_j: f64::NAN,
        sensed_force_n: sensed_by_device(sample),
        ..message
    }
}

/// Force at the sensors of a device; `None` without one for each axis.
pub fn sensed_by_device(sample: &haptic_link::Sample) -> Option<PerAxis> {
    let forces = &sample.sensed_force_n;
    let senses = sample.is_even() && !forces.is_empty();
    senses.then(|| forces.iter().map(|&force_n| force_n.into()).collect())
}

/// The message of a tick that a loop of this program ran.
pub fn by_loop<F: Real, const D: usize>(
    message: TickMessage,
    sample: &LoopSample<F, D>,
    guarded_energy_j: Option<F>,
) -> TickMessage {
    let force_n = per_axis(sample.force.newtons());
    TickMessage {
        tick: sample.reading.tick,
        time_s: sample.reading.time_s,
        position_m: per_axis(&sample.reading.position_m),
        environment_force_n: per_axis(&sample.environment_force_n),
        commanded_force_n: force_n,
        applied_force_n: force_n,
        limiters: sample.limiters.bits(),
        flaws: 0,
        observed_energy_j: guarded_energy_j.map_or(f64::NAN, Real::to_f64),
        ..message
    }
}

/// Record of a tick, as logged and as judged.
pub trait TickRecord: Copy {
    /// The tick for the log.
    fn logged(&self) -> &TickMessage;

    /// The logged record, for the loop to fill in its part.
    fn logged_mut(&mut self) -> &mut TickMessage;

    /// The tick for the judges.
    fn kept(&self) -> KeptSample;
}

impl TickRecord for TickMessage {
    fn logged(&self) -> &TickMessage {
        self
    }

    fn logged_mut(&mut self) -> &mut TickMessage {
        self
    }

    fn kept(&self) -> KeptSample {
        KeptSample::of(self)
    }
}
