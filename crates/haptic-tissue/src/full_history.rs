//! A model by the sums of its elements.

use crate::model::SpringPot;
use crate::sampled::{Branch, Part, SampledModel};
use fracdiff::full_memory::{Design, DesignError, FullMemory, Kernel};
use fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fracdiff::{Channel, Order, Seconds};

/// The stress of a [`SampledModel`], element by element, each with all of its past, every weight within 1e-11.
/// ```text
/// spring-pot    σ[n] = V·T^(−α)·Σ_j c_j(α−1)·Δε[n−j]
/// in series     σ[n] = g₁·ε₁[n] + p₁ = g₂·ε₂[n] + p₂,   ε₁[n] + ε₂[n] = ε[n]        of two parts with gains g and pasts p
/// ```
/// The same P(w) as the one memory of the whole model, by another way: what that is compared with. Two phases, as an
/// operator: σ\[n\] = [`gain`](Self::gain)·ε\[n\] + [`past`](Self::past).
///
/// - *Cost*: some 100 multiply-adds a tick and element, however long the past; allocates in `new` only.
/// - *Start-up*: zero for ever before.
#[derive(Clone, Debug)]
pub struct FullHistory {
    spring_pa: f64,
    branches: Vec<Sums>,
}

impl FullHistory {
    /// History for records of up to `samples` samples.
    ///
    /// # Errors
    /// Beyond 1e12 samples.
    pub fn new(model: &SampledModel, samples: usize) -> Result<Self, DesignError> {
        Self::of(&model.whole, model.sample_time(), samples)
    }

    fn of(part: &Part, t: Seconds, samples: usize) -> Result<Self, DesignError> {
        let sums = |branch: &Branch| match branch {
            Branch::Pot(one) => Sum::new(one, t, samples).map(|sum| Sums::Pot(sum, 0.0)),
            Branch::Series(parts) => {
                let [first, second] = parts.each_ref().map(|part| Self::of(part, t, samples));
                Ok(Sums::Series([first?, second?]))
            }
        };
        let branches: Result<_, _> = part.branches.iter().map(sums).collect();
        Ok(Self {
            spring_pa: part.spring_pa,
            branches: branches?,
        })
    }

    /// The factor of the newest strain, Pa.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.spring_pa + self.branches.iter().map(Sums::gain).sum::<f64>()
    }

    /// The stress for a strain of 0 now, Pa.
    #[must_use]
    pub fn past(&self) -> f64 {
        self.branches.iter().rev().map(Sums::past).sum()
    }

    /// The stress for the strain ε\[n\], Pa.
    #[must_use]
    pub fn stress(&self, strain: f64) -> f64 {
        self.past() + self.gain() * strain
    }

    /// Takes ε\[n\] into the history.
    pub fn advance(&mut self, strain: f64) {
        for branch in &mut self.branches {
            branch.advance(strain);
        }
    }

    /// [`stress`](Self::stress), then [`advance`](Self::advance).
    pub fn step(&mut self, strain: f64) -> f64 {
        let stress = self.stress(strain);
        self.advance(strain);
        stress
    }
}

/// The sums of a branch.
#[derive(Clone, Debug)]
enum Sums {
    /// Sum of a spring-pot, with its strain ε\[n−1\].
    Pot(Sum, f64),
    Series([FullHistory; 2]),
}

impl Sums {
    fn gain(&self) -> f64 {
        match self {
            Self::Pot(one, _) => one.gain,
            Self::Series(parts) => {
                let [a, b] = parts.each_ref().map(FullHistory::gain);
                a * b / (a + b)
            }
        }
    }

    fn past(&self) -> f64 {
        match self {
            Self::Pot(one, last) => one.past() - one.gain * last,
            Self::Series(parts) => {
                let [a, b] = parts.each_ref().map(|part| (part.gain(), part.past()));
                (a.0 * b.1 + b.0 * a.1) / (a.0 + b.0)
            }
        }
    }

    fn advance(&mut self, strain: f64) {
        match self {
            Self::Pot(one, last) => {
                one.advance(strain - *last);
                *last = strain;
            }
            Self::Series(parts) => {
                let [a, b] = parts.each_ref().map(|part| (part.gain(), part.past()));
                let first = (b.0 * strain + b.1 - a.1) / (a.0 + b.0);
                parts[0].advance(first);
                parts[1].advance(strain - first);
            }
        }
    }
}

/// ε of every weight: the least that a design reaches in `f64`.
const TOLERANCE: f64 = 1e-11;

/// A factor times a fractional integral of order 0 to 1.
#[derive(Clone, Debug)]
struct Sum {
    factor: f64,
    /// Factor of the newest input.
    gain: f64,
    memory: Past,
}

#[derive(Clone, Debug)]
enum Past {
    /// Order 0.
    None,
    /// Order 1: T·Σ, and T.
    Running(f64, f64),
    Memory(Box<Channel<f64, FullMemory<f64, FULL_TAPS, FULL_MODES>>>),
}

impl Sum {
    /// V·D^α ε = (V/T)·I^(1−α) Δε.
    fn new(pot: &SpringPot, t: Seconds, samples: usize) -> Result<Self, DesignError> {
        let (factor, order) = (pot.size / t.0, Order::new(pot.order - 1.0)?);
        let memory = if order.get() == 0.0 {
            Past::None
        } else if order.get() <= -1.0 {
            Past::Running(0.0, t.0)
        } else {
            let horizon = samples.max(100) as f64;
            let design = Design::closed_form(Kernel::Grunwald, order, TOLERANCE, horizon)?;
            let memory = FullMemory::new(&design, t)?;
            Past::Memory(Box::new(Channel::new(memory)))
        };
        Ok(Self {
            factor,
            gain: factor * t.rate_to_the(order)?,
            memory,
        })
    }

    fn past(&self) -> f64 {
        match &self.memory {
            Past::None => 0.0,
            Past::Running(sum, _) => self.factor * sum,
            Past::Memory(memory) => self.factor * memory.output(0.0),
        }
    }

    fn advance(&mut self, x: f64) {
        match &mut self.memory {
            Past::None => {}
            Past::Running(sum, t) => *sum += *t * x,
            Past::Memory(memory) => memory.advance(x),
        }
    }
}
