//! A model by the sums of its elements.

use crate::model::SpringPot;
use crate::sampled::{Branch, SampledModel};
use fracdiff::full_memory::{Design, DesignError, FullMemory, Kernel};
use fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fracdiff::{Channel, Order, Seconds};

/// The stress of a [`SampledModel`], element by element, each with all of its past, every weight within 1e-11.
/// ```text
/// spring-pot    σ[n] = V·T^(−α)·Σ_j c_j(α−1)·Δε[n−j]
/// in series     ε[n] = (T^α/V)·Σ_j c_j(−α)·σ[n−j] + (T^β/G)·Σ_j c_j(−β)·σ[n−j],   solved for σ[n]: c_0 = 1
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
    /// ε\[n−1\].
    last: f64,
}

impl FullHistory {
    /// For records of up to so many samples.
    ///
    /// # Errors
    /// Beyond 1e12 samples.
    pub fn new(model: &SampledModel, samples: usize) -> Result<Self, DesignError> {
        let t = model.sample_time();
        let branches = model.branches.iter();
        let branches: Result<_, _> = branches
            .map(|branch| Sums::of(branch, t, samples))
            .collect();
        Ok(Self {
            spring_pa: model.elastic_modulus_pa(),
            branches: branches?,
            last: 0.0,
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
        self.stress(0.0)
    }

    /// The stress for the strain ε\[n\], Pa.
    #[must_use]
    pub fn stress(&self, strain: f64) -> f64 {
        let branches = self.branches.iter().rev();
        let stress: f64 = branches
            .map(|branch| branch.stress(strain, self.last))
            .sum();
        stress + self.spring_pa * strain
    }

    /// Takes ε\[n\] into the history.
    pub fn advance(&mut self, strain: f64) {
        for branch in &mut self.branches {
            branch.advance(strain, self.last);
        }
        self.last = strain;
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
    Pot(Sum),
    Series(Sum, Sum),
    /// The spring, Pa; the two side by side, and their strain.
    Standing(f64, Sum, Sum, f64),
}

impl Sums {
    fn of(branch: &Branch, t: Seconds, samples: usize) -> Result<Self, DesignError> {
        // V·D^α ε = (V/T)·I^(1−α) Δε,    ε = (1/V)·I^α σ
        let stress = |pot: &SpringPot| Sum::new(pot.size / t.0, pot.order - 1.0, t, samples);
        let strain = |pot: &SpringPot| Sum::new(1.0 / pot.size, -pot.order, t, samples);
        Ok(match branch {
            Branch::Pot(one) => Self::Pot(stress(one)?),
            Branch::Series(first, second) => Self::Series(strain(first)?, strain(second)?),
            Branch::Standing(e, first, second) => {
                Self::Standing(*e, stress(first)?, stress(second)?, 0.0)
            }
        })
    }

    fn gain(&self) -> f64 {
        match self {
            Self::Pot(one) => one.gain,
            Self::Series(first, second) => 1.0 / (first.gain + second.gain),
            Self::Standing(e, first, second, _) => {
                let beside = first.gain + second.gain;
                e * beside / (e + beside)
            }
        }
    }

    fn stress(&self, strain: f64, last: f64) -> f64 {
        match self {
            Self::Pot(one) => one.output(strain - last),
            Self::Series(first, second) => {
                (strain - (first.past() + second.past())) / (first.gain + second.gain)
            }
            Self::Standing(e, ..) => e * (strain - self.inner(strain)),
        }
    }

    /// ε₂ of σ = E·(ε − ε₂) = g·(ε₂ − ε₂\[n−1\]) + S.
    fn inner(&self, strain: f64) -> f64 {
        match self {
            Self::Standing(e, first, second, inner) => {
                let beside = first.gain + second.gain;
                let past = first.past() + second.past();
                (e * strain + beside * inner - past) / (e + beside)
            }
            Self::Pot(_) | Self::Series(..) => strain,
        }
    }

    fn advance(&mut self, strain: f64, last: f64) {
        let (stress, next) = (self.stress(strain, last), self.inner(strain));
        match self {
            Self::Pot(one) => one.advance(strain - last),
            Self::Series(first, second) => {
                first.advance(stress);
                second.advance(stress);
            }
            Self::Standing(_, first, second, inner) => {
                first.advance(next - *inner);
                second.advance(next - *inner);
                *inner = next;
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
    /// `order` from −1 to 0.
    fn new(factor: f64, order: f64, t: Seconds, samples: usize) -> Result<Self, DesignError> {
        let order = Order::new(order)?;
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

    fn output(&self, x: f64) -> f64 {
        self.gain * x + self.past()
    }

    fn advance(&mut self, x: f64) {
        match &mut self.memory {
            Past::None => {}
            Past::Running(sum, t) => *sum += *t * x,
            Past::Memory(memory) => memory.advance(x),
        }
    }
}
