//! Memories that only fade: weights that are moments of a density, whatever the density.

use super::design::{DesignError, check_horizon};
use super::kernel::DecayingMode;
use crate::ParameterError;
use core::f64::consts::PI;
use std::vec;
use std::vec::Vec;

/// A memory that only fades: a completely monotone sequence of weights.
/// ```text
/// c_j = Σ_q w_q·e^(−j·s_q) + ∫₀^∞ e^(−js) ρ(s) ds      j ≥ 1,    w_q > 0,  ρ ≥ 0
/// c_0 ≥ the same at j = 0
/// ```
/// - *Rates* s per sample, weights dimensionless: without the factor T^(−μ).
/// - *Which are*: a power series Σ `c_j` w^j that continues to all of the plane but a cut w ≥ 1 has such weights if its
///   imaginary part above the cut is not negative: ρ(s) = Im P(e^s + i0)/π, and a pole at w = e^s is a mode of its own.
///   Responses of springs, dashpots and spring-pots to an increment of strain are of this kind.
/// - [`Design::of_memory`](super::Design::of_memory) finds the modes that approximate it,
///   [`MemoryWeights`] its weights.
pub trait Memory {
    /// `c_0`, which may hold more than modes and density give at j = 0: a share that is gone after one sample.
    fn first(&self) -> f64;

    /// s·ρ(s) ≥ 0, the density over ln s, at a rate s > 0.
    fn density(&self, rate: f64) -> f64;

    /// ∫₀^s ρ ds, all that is slower than a rate s, for rates that are next to nothing; `None` to have it found by quadrature,
    /// which sees no rate below e^(−690) and extrapolates from there by a power law.
    fn slower(&self, rate: f64) -> Option<f64> {
        let _ = rate;
        None
    }

    /// Mode `index` of those that are exact; `None` behind the last.
    fn mode(&self, index: usize) -> Option<DecayingMode> {
        let _ = index;
        None
    }
}

/// The true weights of a [`Memory`], by quadrature.
/// ```text
/// ∫ e^(−js) s·ρ(s) d ln s      Gauss–Legendre of 16 nodes on panels of ln s, halved until each is right to 1e-12
/// ```
/// - *Accuracy*: about 1e-12 relative for lags up to the horizon, if the density itself is that
///   accurate.
/// - *Cost*: some thousand densities once, as many exponentials for each weight.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryWeights {
    first: f64,
    /// Modes that are exact, and nodes of the quadrature, fastest first.
    exact: Vec<DecayingMode>,
    nodes: Vec<DecayingMode>,
    /// Rates in panels that were halved, where the density is narrow.
    narrow: Vec<Narrow>,
}

/// A place where the density changes fast: a rate, and the width of its panel in ln s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Narrow {
    rate: f64,
    width: f64,
}

impl MemoryWeights {
    /// Weights up to lag `horizon`, samples.
    ///
    /// # Errors
    /// A number of the memory that is not finite or negative; [`DesignError::Unreachable`] for a density that is rough everywhere
    /// or has no finite mass at slow rates. Single steps and narrow peaks do no harm.
    pub fn new(memory: &dyn Memory, horizon: f64) -> Result<Self, DesignError> {
        check_horizon(1, horizon)?;
        let first = memory.first();
        if !(first >= 0.0 && first.is_finite()) {
            let (lag, weight) = (0, first);
            return Err(ParameterError::Weight { lag, weight }.into());
        }
        let mut exact: Vec<DecayingMode> = (0..).map_while(|index| memory.mode(index)).collect();
        for &DecayingMode { rate, weight } in &exact {
            if !(rate > 0.0 && rate.is_finite() && weight >= 0.0 && weight.is_finite()) {
                return Err(ParameterError::Mode { rate, weight }.into());
            }
        }
        DecayingMode::sort(&mut exact);
        let mut panels = Panels::new(memory);
        panels.cover(libm::log(STILL / horizon))?;
        let Panels { nodes, narrow, .. } = panels;
        Ok(Self {
            first,
            exact,
            nodes,
            narrow,
        })
    }

    /// `c_j`.
    #[must_use]
    pub fn weight(&self, lag: u64) -> f64 {
        self.at(lag as f64)
    }

    /// `c_j` for any j ≥ 1, and at 0.
    pub(super) fn at(&self, lag: f64) -> f64 {
        if lag == 0.0 {
            return self.first;
        }
        // Small terms first; those of fast modes are nothing.
        let gone = self.nodes.partition_point(|mode| mode.rate * lag > GONE);
        let nodes = self.nodes[gone..].iter();
        let modes = self.exact.iter().chain(nodes);
        modes.fold(0.0, |sum, mode| {
            sum + mode.weight * libm::exp(-lag * mode.rate)
        })
    }

    /// Modes that are exact, fastest first.
    pub(super) fn exact(&self) -> &[DecayingMode] {
        &self.exact
    }

    /// The moments ∫ s^m ρ ds, m = 0…3, of all rates below one, in units of that rate.
    pub(super) fn moments_below(&self, rate: f64) -> [f64; 4] {
        let below = self.nodes.partition_point(|mode| mode.rate >= rate);
        let mut moments = [0.0; 4];
        for mode in self.nodes[below..].iter().rev() {
            let mut term = mode.weight;
            for moment in &mut moments {
                *moment += term;
                term *= mode.rate / rate;
            }
        }
        moments
    }

    /// Rates at which the density needs nodes closer than `step` in ln s.
    pub(super) fn narrow(&self, step: f64) -> impl Iterator<Item = f64> + '_ {
        let close = move |narrow: &&Narrow| narrow.width < NARROW * step;
        self.narrow.iter().filter(close).map(|narrow| narrow.rate)
    }
}

/// The fastest rate, per sample: e^(−80) of a mode is left after one.
const FASTEST: f64 = 80.0;
/// Modes of less than this share of a horizon stand still.
const STILL: f64 = 1e-17;
/// e^(−745) is nothing.
const GONE: f64 = 745.0;
/// Largest relative error of a panel.
const PANEL: f64 = 1e-12;
/// A panel is halved this often at most.
const HALVINGS: u32 = 40;
const MOST: usize = 4000;
/// The slowest rate, so that its digits are all there.
const SLOWEST_LN: f64 = -690.0;
/// Largest share of the sum that may be slower than the last panel.
const REST: f64 = 1e-14;
const NODES: usize = 16;
/// A panel this much narrower than a grid of modes wants nodes of its own.
const NARROW: f64 = 1.5;

/// Panels of ln s, from the fastest down.
struct Panels<'a> {
    memory: &'a dyn Memory,
    rule: [(f64, f64); NODES],
    nodes: Vec<DecayingMode>,
    narrow: Vec<Narrow>,
    count: usize,
}

impl<'a> Panels<'a> {
    fn new(memory: &'a dyn Memory) -> Self {
        Self {
            memory,
            rule: legendre(),
            nodes: vec![],
            narrow: vec![],
            count: 0,
        }
    }

    /// Panels of width 1 down to the logarithm of the rate from which on a mode stands still; one node for all that is slower.
    fn cover(&mut self, still: f64) -> Result<(), DesignError> {
        let mut top = libm::log(FASTEST);
        while top > still {
            self.panel(top - 1.0, top)?;
            top -= 1.0;
        }
        let rate = libm::exp(top);
        let weight = match self.memory.slower(rate) {
            Some(weight) if weight >= 0.0 && weight.is_finite() => weight,
            Some(density) => return Err(ParameterError::Density { rate, density }.into()),
            None => self.slower(top)?,
        };
        if weight > 0.0 {
            self.nodes.push(DecayingMode { rate, weight });
        }
        Ok(())
    }

    /// The mass of all that is slower than a rate, given by its logarithm.
    fn slower(&mut self, mut top: f64) -> Result<f64, DesignError> {
        let (moving, narrow) = (self.nodes.len(), self.narrow.len());
        let (mut width, mut sum) = (1.0, 0.0);
        while top > SLOWEST_LN {
            let bottom = f64::max(top - width, SLOWEST_LN);
            let from = self.nodes.len();
            self.panel(bottom, top)?;
            sum += self.nodes[from..]
                .iter()
                .map(|mode| mode.weight)
                .sum::<f64>();
            (top, width) = (bottom, 2.0 * width);
            if self.rest(top)? <= REST * sum {
                break;
            }
        }
        let rest = self.rest(top)?;
        let slow = self.nodes.split_off(moving);
        self.narrow.truncate(narrow);
        Ok(slow.iter().rev().fold(rest, |sum, mode| sum + mode.weight))
    }

    /// The mass of all that is slower, from the slope of the density: ∫ D e^(p(u − top)) du = D/p.
    fn rest(&self, top: f64) -> Result<f64, DesignError> {
        let (here, below) = (self.density(top)?, self.density(top - 1.0)?);
        if here == 0.0 {
            return Ok(0.0);
        }
        let slope = libm::log(here / below);
        if slope > 0.0 {
            Ok(here / slope)
        } else {
            // No finite mass: not a memory.
            Err(unreachable())
        }
    }

    /// s·ρ(s) at the logarithm of a rate.
    fn density(&self, ln_rate: f64) -> Result<f64, DesignError> {
        let rate = libm::exp(ln_rate);
        let density = self.memory.density(rate);
        if density >= 0.0 && density.is_finite() {
            Ok(density)
        } else {
            Err(ParameterError::Density { rate, density }.into())
        }
    }

    /// Nodes of one panel, fastest first.
    fn nodes(&self, low: f64, high: f64) -> Result<[DecayingMode; NODES], DesignError> {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut nodes = [DecayingMode::default(); NODES];
        for (node, (place, share)) in nodes.iter_mut().zip(self.rule) {
            let ln_rate = middle - half * place;
            node.rate = libm::exp(ln_rate);
            node.weight = half * share * self.density(ln_rate)?;
        }
        Ok(nodes)
    }

    /// Adds a panel, halved as often as it must be.
    fn panel(&mut self, low: f64, high: f64) -> Result<(), DesignError> {
        let mut open = vec![(low, high, 0, self.nodes(low, high)?)];
        while let Some((low, high, halvings, whole)) = open.pop() {
            let middle = 0.5 * (low + high);
            let (upper, lower) = (self.nodes(middle, high)?, self.nodes(low, middle)?);
            let sum = |nodes: &[DecayingMode]| nodes.iter().map(|mode| mode.weight).sum::<f64>();
            let (halves, mass) = (sum(&upper) + sum(&lower), sum(&whole));
            // A sum of 16 numbers has rounding errors, and so have the densities.
            if (halves - mass).abs() <= PANEL * halves || halvings == HALVINGS {
                self.nodes.extend(whole);
                if halvings > 0 {
                    let width = high - low;
                    let places = whole.iter().step_by(2).map(|mode| mode.rate);
                    self.narrow
                        .extend(places.map(|rate| Narrow { rate, width }));
                }
                continue;
            }
            self.count += 1;
            if self.count > MOST {
                return Err(unreachable());
            }
            open.push((low, middle, halvings + 1, lower));
            open.push((middle, high, halvings + 1, upper));
        }
        Ok(())
    }
}

/// A density that no quadrature takes.
fn unreachable() -> DesignError {
    DesignError::Unreachable {
        tolerance: PANEL,
        reached: f64::INFINITY,
    }
}

/// Places and weights of the Gauss–Legendre rule on (−1, 1), the highest last: roots of the Legendre polynomial by
/// Newton's method from cos(π(i + ¾)/(n + ½)).
fn legendre() -> [(f64, f64); NODES] {
    core::array::from_fn(|index| {
        let mut x = -libm::cos(PI * (index as f64 + 0.75) / (NODES as f64 + 0.5));
        let mut slope = 0.0;
        for _ in 0..8 {
            // (k+1)·P_(k+1) = (2k+1)·x·P_k − k·P_(k−1)
            let (mut before, mut value) = (0.0, 1.0);
            for k in 0..NODES {
                let k = k as f64;
                let next = ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0);
                (before, value) = (value, next);
            }
            slope = NODES as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Order;
    use crate::full_memory::kernel::{Core, Kernel};

    /// A named kernel as a memory.
    struct Named(Core);

    impl Memory for Named {
        fn first(&self) -> f64 {
            self.0.weight(0.0)
        }

        fn density(&self, rate: f64) -> f64 {
            self.0.density(rate)
        }
    }

    #[test]
    fn the_quadrature_gives_the_weights_of_the_named_kernels() {
        for mu in [0.003, 0.1, 0.2247, 0.5, 0.9, 0.999] {
            for kernel in [Kernel::Grunwald, Kernel::PiecewiseLinear] {
                let core = Core::new(kernel, Order::new(mu).expect("valid"));
                let weights = MemoryWeights::new(&Named(core), 1e7).expect("smooth");
                for lag in [0.0, 1.0, 2.0, 3.0, 17.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7] {
                    let (have, want) = (weights.at(lag), core.weight(lag));
                    assert!(
                        (have / want - 1.0).abs() < 3e-12,
                        "{kernel:?} {mu} lag {lag}: {have:e} {want:e}, {:e}",
                        have / want - 1.0
                    );
                }
            }
        }
    }

    #[test]
    fn the_rule_integrates_polynomials_up_to_degree_31() {
        let rule = legendre();
        for degree in 0..32 {
            let have: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
            let want = if degree % 2 == 0 {
                2.0 / f64::from(degree + 1)
            } else {
                0.0
            };
            assert!((have - want).abs() < 1e-14, "{degree}: {have} {want}");
        }
    }
}
