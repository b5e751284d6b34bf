//! Delay margin of a sampled loop: the smallest additional delay behind its hold at which a stable loop becomes unstable.
//!
//! Whole samples only turn the phase. A fraction of a sample also changes the gain, because the hold then switches inside a sample. A few
//! fractions therefore bound every delay:
//!
//! ```text
//! L(h) is stable for fewer than (turn + 2πk)/θ whole samples more,   θ its crossovers, turn the angle from L to −1 there
//! ```
//! Near that bound the delay is narrowed until the verdicts on its two sides differ. Cost: some ten evaluations of the loop for each candidate.

use core::f64::consts::PI;

/// A loop with additional delay, and its verdict.
pub trait Late {
    /// The angles at which |L| = 1, and the turn, −π to π, that takes L to −1 there.
    fn crossovers(&self) -> Vec<(f64, f64)>;

    /// |L| ≥ 1 at half the sample rate, where each whole sample of delay changes the sign of L.
    fn is_turned(&self) -> bool;

    /// Angle at which an unstable loop is nearest to the boundary; `None` for a stable loop.
    ///
    /// # Errors
    /// [`Unknown`] where the delay is beyond what can be judged.
    fn lost(&self) -> Result<Option<f64>, Unknown>;
}

/// No verdict exists at this delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown;

/// A delay, samples, and the angle of a zero there.
pub type Zero = (f64, f64);

/// Times the loop may come near a zero, and miss it, before its margin.
const NEAR_MISSES: usize = 64;
/// Steps towards a zero, or halvings, at most.
const STEPS: usize = 60;
/// A delay is known to this share of it.
const KNOWN: f64 = 1e-12;
/// Remainder of a delay, as a share of it, up to which a zero is met.
const MET: f64 = 1e-9;
/// Distance from a zero, as a share of it, at which the verdicts on both sides must differ.
const BESIDE: f64 = 1e-7;

/// Verdict on the delays with one fractional part of a sample.
struct Part {
    more: f64,
    stable: bool,
    crossovers: Vec<(f64, f64)>,
    turned: bool,
}

impl Part {
    /// The first delay more than this that is beyond a zero, and the zero.
    fn beyond(&self, after: f64) -> Option<(f64, Zero)> {
        if !self.stable {
            return (self.more > after).then_some((self.more, (self.more, PI)));
        }
        // The last delay of this part that was looked at.
        let last = libm::floor(after - self.more).max(0.0);
        let zeros = self.crossovers.iter().map(|&(theta, turn)| {
            let turns = libm::floor((last * theta - turn) / (2.0 * PI)) + 1.0;
            ((turn + 2.0 * PI * turns) / theta, theta)
        });
        let turned = self.turned.then_some((last + 1.0, PI));
        let (first, theta) = zeros.chain(turned).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let delay = libm::ceil(first).max(last + 1.0) + self.more;
        Some((delay, (first + self.more, theta)))
    }
}

/// Smallest additional delay, samples, at which a stable loop becomes unstable, and the angle of its zero there; `None` if no delay does.
///
/// `later` gives the loop with so many samples of additional delay. `mores` are the fractions of a sample that are tried, from 0 on and in order; each gap is
/// divided into `finer` pieces where the verdicts at its ends agree.
///
/// # Errors
/// As `later` gives them.
pub fn delay_margin<L: Late, E>(
    later: &dyn Fn(f64) -> Result<L, E>,
    mores: &[f64],
    finer: u32,
) -> Result<Option<Zero>, E> {
    let mut parts: Vec<Part> = Vec::new();
    for &more in mores {
        let late = later(more)?;
        let Ok(lost) = late.lost() else { break };
        let stable = lost.is_none();
        let (crossovers, turned) = (late.crossovers(), late.is_turned());
        parts.push(Part {
            more,
            stable,
            crossovers,
            turned,
        });
        if !stable {
            break;
        }
    }
    let search = Search {
        later,
        finer,
        step: widest(mores),
    };
    let mut after = 0.0;
    for _ in 0..NEAR_MISSES {
        let next = parts.iter().filter_map(|part| part.beyond(after));
        let Some((delay, zero)) = next.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            break;
        };
        let found = search.narrowed(delay, zero)?;
        if found.is_some() {
            return Ok(found);
        }
        // A swing that came near −1 between two whole delays.
        after = delay;
    }
    Ok(None)
}

/// The widest gap between fractions of a sample that are in order; behind the last comes the next whole sample.
fn widest(mores: &[f64]) -> f64 {
    let behind = mores.iter().skip(1).chain([&1.0]);
    let gaps = mores.iter().zip(behind).map(|(before, next)| next - before);
    gaps.fold(0.0, f64::max)
}

struct Search<'a, L, E> {
    later: &'a dyn Fn(f64) -> Result<L, E>,
    finer: u32,
    step: f64,
}

impl<L: Late, E> Search<'_, L, E> {
    fn lost(&self, delay: f64) -> Result<Result<Option<f64>, Unknown>, E> {
        Ok((self.later)(delay)?.lost())
    }

    /// The zero before a delay that seems to be beyond one, by less than a step.
    fn narrowed(&self, delay: f64, zero: Zero) -> Result<Option<Zero>, E> {
        let (low, high) = ((delay - self.step).max(0.0), delay);
        if let Some(found) = self.by_phase(zero, low, high + self.step)? {
            let before = self.lost(found.0 * (1.0 - BESIDE))?;
            let after = self.lost(found.0 * (1.0 + BESIDE))?;
            let is_kept = matches!(before, Ok(Some(_))) || matches!(after, Ok(None));
            if before.is_err() || after.is_err() || !is_kept {
                return Ok(Some(found));
            }
        }
        // A loop that is lost for less than the step is back beyond it.
        let mut inside = low;
        for k in 1..=self.finer {
            let tried = low + (high - low) * f64::from(k) / f64::from(self.finer);
            match self.lost(tried)? {
                Err(Unknown) => return Ok(None),
                Ok(Some(theta)) => return self.by_verdicts(inside, (tried, theta)).map(Some),
                Ok(None) => inside = tried,
            }
        }
        Ok(None)
    }

    /// The delay between two at which the crossover next to that of a zero meets −1: φ(d)/θ(d) = 0 by secants, φ the turn that is left.
    fn by_phase(&self, near: Zero, low: f64, high: f64) -> Result<Option<Zero>, E> {
        let (mut delay, mut theta) = (near.0.clamp(low, high), near.1);
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..STEPS {
            let late = (self.later)(delay)?;
            let away = |at: &(f64, f64)| libm::log(at.0 / theta).abs();
            let crossovers = late.crossovers().into_iter();
            let Some((at, turn)) = crossovers.min_by(|a, b| away(a).total_cmp(&away(b))) else {
                break;
            };
            theta = at;
            let left = turn / theta;
            // −1 but for the hold.
            let slope = before.map_or(-1.0, |(last, more)| (more - left) / (last - delay));
            let slope = if slope < -0.5 { slope } else { -1.0 };
            before = Some((delay, left));
            let next = (delay - left / slope).clamp(low, high);
            if (next - delay).abs() <= KNOWN * next {
                return Ok((left.abs() <= MET * next.max(1.0)).then_some((next, theta)));
            }
            delay = next;
        }
        Ok(None)
    }

    /// The delay at which the verdict turns, between one at which the loop is stable and one at which it is lost.
    fn by_verdicts(&self, mut low: f64, (mut high, mut theta): Zero) -> Result<Zero, E> {
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            if high - low <= KNOWN * high {
                break;
            }
            match self.lost(middle)? {
                Err(Unknown) => break,
                Ok(None) => low = middle,
                Ok(Some(lost)) => (high, theta) = (middle, lost),
            }
        }
        Ok((high, theta))
    }
}
