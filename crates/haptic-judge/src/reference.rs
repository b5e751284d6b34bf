//! A series that belongs to the samples of a run, as the full history of their positions makes it.
//!
//! A run that is kept whole has it whole, by exact sums. A long one has it sample by sample, by an operator
//! with full memory whose weights are right to a tolerance of [`TOLERANCE`].

use fracdiff::{Channel, Operator, Order, Scheme, Seconds, batch::Batch, full_memory::Kernel};
use haptic_document::Failure;
use haptic_trial::{
    samples::{Before, Samples},
    tick::KeptSample,
};

/// Largest relative error of any weight of an operator that stands for the full history.
pub const TOLERANCE: f64 = 1e-9;

/// The weights whose full history a run is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]

pub enum ReferenceWeights {
    /// Those of a kernel.
    Kernel(Kernel),
    /// Weights of `full-bdf2`.
    Bdf2,
}

impl ReferenceWeights {
    /// Those of the scheme itself where it has the full history, else Grünwald's.
    pub fn of(scheme: Scheme) -> Self {
        if let Scheme::FullBdf2 { .. } = scheme {
            Self::Bdf2
        } else if let Scheme::Full { kernel, .. } = scheme {
            Self::Kernel(kernel)
        } else {
            Self::Kernel(Kernel::Grunwald)
        }
    }

    /// The scheme with these weights, of this tolerance.
    pub fn scheme(self, tolerance: f64) -> Scheme {
        match self {
            Self::Kernel(kernel) => Scheme::Full { kernel, tolerance },
            Self::Bdf2 => Scheme::FullBdf2 { tolerance },
        }
    }

    /// D^μ of a whole record by its full history, no memory cut: [`Batch`].
    ///
    /// # Errors
    /// An order or a history that cannot be summed.
    pub fn full_history(
        self,
        order: Order,
        sample_time: Seconds,
        x: &[f64],
    ) -> Result<Vec<f64>, Failure> {
        let sum = match self {
            Self::Kernel(kernel) => Batch::full_history(kernel, order, sample_time),
            Self::Bdf2 => Batch::full_bdf2(order, sample_time),
        };
        Ok(sum.map_err(Failure::run)?.run(x))
    }
}

/// A value for each sample, asked for in their order.
pub struct ReferenceSeries<'a>(Source<'a>);

enum Source<'a> {
    Whole(std::vec::IntoIter<f64>),
    Streamed(Stream<'a>),
}

/// Made as it is asked for.
struct Stream<'a> {
    next_tick: u64,
    last_m: f64,
    /// Ticks before the run, which shift its numbers.
    before: u64,
    step: Step<'a>,
}

/// The next value of every tick, given its number and the position.
pub type Step<'a> = Box<dyn FnMut(u64, f64) -> f64 + 'a>;

impl std::fmt::Debug for ReferenceSeries<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ReferenceSeries").finish_non_exhaustive()
    }
}

impl<'a> Stream<'a> {
    fn new(step: Step<'a>, before: Before<'_>) -> Self {
        let mut stream = Self {
            next_tick: 0,
            last_m: f64::NAN,
            before: before.ticks,
            step,
        };
        for sample in before.samples {
            stream.at(sample.tick, sample.position_m);
        }
        stream
    }

    /// The value of a tick; those that were lost before it lie on a straight line.
    fn at(&mut self, tick: u64, x: f64) -> f64 {
        let from = if self.next_tick == 0 { x } else { self.last_m };
        let missing = tick.saturating_sub(self.next_tick);
        let slope = (x - from) / (missing + 1) as f64;
        for n in 1..=missing {
            let _ = (self.step)(self.next_tick + n - 1, from + n as f64 * slope);
        }
        self.next_tick = tick + 1;
        self.last_m = x;
        (self.step)(tick, x)
    }
}

impl<'a> ReferenceSeries<'a> {
    /// Values by `whole` from the positions of all ticks of a run that is in memory, or by `step`, tick by tick; both begin with the ticks before it.
    ///
    /// # Errors
    /// Those of what makes the values.
    pub fn new(
        samples: Samples<'_>,
        before: Before<'_>,
        whole: impl FnOnce(&[f64]) -> Result<Vec<f64>, Failure>,
        step: impl FnOnce() -> Result<Step<'a>, Failure>,
    ) -> Result<Self, Failure> {
        Ok(Self(match samples {
            Samples::Whole(samples) => {
                Source::Whole(of_every_tick(samples, before, whole)?.into_iter())
            }
            Samples::Logged(..) => Source::Streamed(Stream::new(step()?, before)),
        }))
    }

    /// Values by the same step whether the run is in memory or not.
    ///
    /// # Errors
    /// Those of what makes the values.
    pub fn stepped(
        samples: Samples<'_>,
        mut step: impl FnMut(f64) -> f64 + 'a,
    ) -> Result<Self, Failure> {
        let before = Before::default();
        Ok(Self(match samples {
            Samples::Whole(samples) => {
                let all = |x: &[f64]| Ok(x.iter().map(|x| step(*x)).collect());
                Source::Whole(of_every_tick(samples, before, all)?.into_iter())
            }
            Samples::Logged(..) => {
                Source::Streamed(Stream::new(Box::new(move |_, x| step(x)), before))
            }
        }))
    }

    /// The value of this sample.
    pub fn at(&mut self, sample: &KeptSample) -> f64 {
        match &mut self.0 {
            Source::Whole(values) => values.next().unwrap_or(f64::NAN),
            Source::Streamed(stream) => stream.at(sample.tick + stream.before, sample.position_m),
        }
    }
}

/// A function of the whole motion, where it was recorded, the ticks before the run included. Positions of ticks that a link lost are
/// taken from a straight line between their neighbours.
fn of_every_tick(
    samples: &[KeptSample],
    before: Before<'_>,
    function: impl FnOnce(&[f64]) -> Result<Vec<f64>, Failure>,
) -> Result<Vec<f64>, Failure> {
    let ticks = samples.iter().map(|sample| sample.tick + before.ticks);
    let ticks = before.samples.iter().map(|sample| sample.tick).chain(ticks);
    let all = before.samples.iter().chain(samples);
    let mut position_m: Vec<f64> = Vec::with_capacity(before.samples.len() + samples.len());
    for (tick, sample) in ticks.zip(all) {
        let x = sample.position_m;
        let from = position_m.last().copied().unwrap_or(x);
        let missing = (tick as usize).saturating_sub(position_m.len());
        let step = (x - from) / (missing + 1) as f64;
        position_m.extend((1..=missing).map(|n| from + n as f64 * step));
        position_m.push(x);
    }
    let values = function(&position_m)?;
    if values.len() == samples.len() {
        return Ok(values);
    }
    let ticks = samples
        .iter()
        .map(|sample| (sample.tick + before.ticks) as usize);
    Ok(ticks.filter_map(|tick| values.get(tick).copied()).collect())
}

/// D^μ by an operator that stands for the full history of this many samples.
///
/// # Errors
/// An operator that the scheme cannot make.
pub fn operator(
    reference: ReferenceWeights,
    order: Order,
    sample_time: Seconds,
    samples: u64,
) -> Result<Channel<f64, Operator<f64>>, Failure> {
    let scheme = reference.scheme(TOLERANCE);
    let horizon = haptic_trial::samples::horizon(samples);
    let operator = scheme.build(order, sample_time, horizon);
    Ok(Channel::new(operator.map_err(Failure::input)?))
}
