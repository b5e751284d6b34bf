//! Swings after the taps of a motor: do they die away by themselves, or because friction stops them?
//!
//! ```text
//! s' = ρ·s − c        s: swing of the speed over a window of two half periods, c ≥ 0: what friction takes from each window to the next
//! stable:    at most ρ₀ over all of the interval of ρ;    unstable: at least ρ₀;    else nobody can tell: held by friction
//! ρ₀ = 0.014^(hop/(0.96·N)): so much is left of a swing after N ticks, the time in which a wall has to settle
//! ```
//! - *Windows*: weighted by 1 − cos, one half period apart, so that neither the phase nor a slow drift counts; each of at least six ticks.
//!   The half period is the mean time between turning points of the speed. Windows end where the device stops, or where friction could stop
//!   it within some ticks, since there c is no constant. The first eighth is left out: faster motion dies away in it.
//! - *Interval*: (ρ, c) with a sum of squares within four variances of the least one, over the taps of both signs together. The energy of a
//!   window has the slope of its swing in it, which is taken off.
//! - *Overdamped* motion has no three swings. There c is bounded: a reversal of friction F is a step of 2·F at the place of the tap a, so
//!   that c ≤ 3·(F/a)·s. F is what the device file says, or the force left at rest, if that is larger. Motion has died if less than
//!   half of its first swing would be left in the last without friction.
//! - *A tap below twenty times the friction* has to leave a margin of 2·F/a, since c is then no constant.
//!
//! Cost: some 10⁵ operations a trial.

use serde::Serialize;

/// Share of F/a beyond which ρ needs a margin.
const SMALL_TAP: f64 = 0.045;
/// Width of an interval in which the best ρ decides.
const NARROW: f64 = 0.03;

/// Share of a first swing below which it has died, whatever friction took.
const GONE: f64 = 0.5;

/// Changes of the speed by friction in a tick, below which a swing tells nothing.
const STOPPED: f64 = 8.0;

/// A trial in which the motor taps the wall by steps of its force.
#[derive(Clone, Debug)]
pub struct Taps {
    /// Ticks from one step of the tap to the next.
    pub ticks: usize,
    /// Ticks in which a wall has to settle.
    pub settles_in: f64,
    /// Spring of a hand, N/m.
    pub hand_n_per_m: f64,
    /// Friction by the device file, N.
    pub friction_n: f64,
    /// Encoder step, m; 0 for an ideal sensor.
    pub encoder_step_m: f64,
    /// Force of a step of the encoder through the law, N.
    pub step_n: f64,
    /// Change of the speed by a newton in a tick, m per tick.
    pub tick_m_per_n: f64,
    /// Place, m, and force, N, of each tick.
    pub seen: Vec<(f64, f64)>,
}

/// Decay of the swings after the taps. Its fields are keys of reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Swings {
    /// Mean step of the force, N.
    pub tap_n: f64,
    /// Friction, N: that of the device file, or the force left at rest, if larger.
    pub friction_n: f64,
    /// Share of a swing that is left in the next.
    pub swing_ratio: f64,
    /// Lower end of its interval.
    pub swing_ratio_from: f64,
    /// Upper end of the interval of that share.
    pub swing_ratio_to: f64,
    /// The share up to which a wall settles in time.
    pub swing_ratio_limit: f64,
    /// The answer; `None` if friction hides it.
    #[serde(skip)]
    pub dies: Option<bool>,
}

/// Speeds after a tap, m per tick, with their turning points.
struct After {
    speeds: Vec<f64>,
    turns: Vec<usize>,
    /// The last one of more than friction could stop at once, else 0.
    last: f64,
}

impl Taps {
    fn after(&self, from: usize, friction_n: f64) -> After {
        let places = self.seen[from..from + self.ticks].windows(2);
        let speeds: Vec<f64> = places.map(|pair| pair[1].0 - pair[0].0).collect();
        let largest = speeds.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let stopped = STOPPED * friction_n * self.tick_m_per_n;
        let least = f64::max(0.05 * largest, 2.5 * self.encoder_step_m);
        let turns = |least: f64| {
            let (mut turns, mut end, mut way) = (Vec::new(), (0, speeds[0]), 0.0);
            for (tick, &v) in speeds.iter().enumerate() {
                let change = v - end.1;
                if change * way > 0.0 {
                    end = (tick, v);
                } else if change.abs() > least {
                    turns.extend((way != 0.0).then_some(end.0));
                    (way, end) = (change.signum(), (tick, v));
                }
            }
            turns
        };
        After {
            turns: turns(least),
            last: turns(least.max(stopped))
                .last()
                .map_or(0.0, |turn| *turn as f64),
            speeds,
        }
    }

    /// Mean force of the motor over the end of the time before a tick, less the spring of a hand, N: at rest friction holds it.
    fn left_n(&self, before: usize) -> f64 {
        let last = &self.seen[before - self.ticks / 8..before];
        let left_n = |seen: &(f64, f64)| seen.1 - self.hand_n_per_m * seen.0;
        last.iter().map(left_n).sum::<f64>() / last.len() as f64
    }

    /// True if the motion dies away at the end of the newest samples: it varies by less than in as many before them.
    pub fn falls(&self, samples: usize) -> bool {
        let end = self.seen.len();
        let spread = |from: usize| {
            let places = self.seen[from..from + samples].iter().map(|seen| seen.0);
            let mean = places.clone().sum::<f64>() / samples as f64;
            places.map(|m| (m - mean) * (m - mean)).sum::<f64>()
        };
        end >= 2 * samples && spread(end - samples) < 0.8 * spread(end - 2 * samples)
    }

    /// The swings of a trial that reached its end.
    pub fn swings(&self) -> Option<Swings> {
        let (all, ticks) = (self.seen.len(), self.ticks);
        // Force may rise for a third of the time.
        let steps = (ticks..all).step_by(ticks.max(1));
        let steps = steps.filter(|step| step + ticks / 8 > all / 3 && step + ticks <= all);
        let steps: Vec<usize> = steps.collect();
        if steps.is_empty() || ticks < 16 {
            return None;
        }
        // Over some ticks, since the rate of the force is limited.
        let jump = |&step: &usize| {
            let jumps = self.seen[step..step + ticks / 16].iter();
            jumps.fold(0.0, |most: f64, (_, force_n)| {
                most.max((force_n - self.seen[step - 1].1).abs())
            })
        };
        let tap_n = steps.iter().map(jump).sum::<f64>() / steps.len() as f64;
        let ends = steps.iter().copied().chain([all]);
        let friction_n = ends.fold(self.friction_n, |most, end| {
            most.max(self.left_n(end).abs())
        });
        let after = steps.iter().map(|&step| self.after(step, friction_n));
        let after: Vec<After> = after.collect();
        let halves = after.iter().flat_map(|after| after.turns.windows(2));
        let halves: Vec<usize> = halves.map(|turns| turns[1] - turns[0]).collect();
        let half = match halves.len() {
            0 => ticks as f64 / 16.0,
            count => (halves.iter().sum::<usize>() as f64 / count as f64).min(ticks as f64 / 8.0),
        };
        let last = after
            .iter()
            .fold(0.0, |most: f64, after| most.max(after.last));
        let least = f64::max(last / 24.0, 3.0);
        let hop = (half * (least / half).ceil().max(1.0)).min(ticks as f64 / 5.0);
        let windows: Vec<Vec<f64>> = after.iter().map(|after| after.windows(half, hop)).collect();
        let first = windows.iter().map(|swings| swings[0]).fold(0.0, f64::max);
        let share = (friction_n / tap_n).min(1.0);
        let mut fit = Fit {
            most: 3.0 * share * first * hop / half,
            noise: f64::max(0.35 * self.encoder_step_m / hop.sqrt(), 3e-3 * first),
            windows,
        };
        let gone = fit.left() < GONE;
        for swings in &mut fit.windows {
            swings.drain(..swings.len() / 8);
        }
        let [ratio, from, to] = fit.ratio();
        let limit = libm::pow(0.0141, hop / (0.96 * self.settles_in));
        let small = share > SMALL_TAP;
        let margin = if small { 2.0 * share } else { 0.0 };
        // Friction holds nothing still if one step of the encoder makes far more force.
        let shaken = friction_n < 0.02 * self.step_n;
        let dies = if gone || to < limit - margin {
            Some(true)
        } else if from > limit {
            Some(false)
        } else if shaken || !small && to - from < NARROW {
            Some(shaken || ratio < limit)
        } else {
            None
        };
        Some(Swings {
            tap_n,
            friction_n,
            swing_ratio: ratio,
            swing_ratio_from: from,
            swing_ratio_to: to,
            swing_ratio_limit: limit,
            dies,
        })
    }
}

impl After {
    /// Swings, one hop apart, up to the first in whose window the device may have stopped.
    fn windows(&self, half: f64, hop: f64) -> Vec<f64> {
        let length = (2.0 * hop).round() as usize;
        let end = self.last + 0.5 * half;
        let turn = std::f64::consts::TAU / length as f64;
        let weights: Vec<f64> = (0..length)
            .map(|n| 1.0 - libm::cos(turn * (n as f64 + 0.5)))
            .collect();
        let mut swings = Vec::new();
        for n in 0..26 {
            let from = n as f64 * hop;
            let Some(window) = self.speeds.get(from as usize..from as usize + length) else {
                break;
            };
            let mean = |value: &dyn Fn(f64) -> f64| {
                let values = weights.iter().zip(window);
                let values = values.map(|(weight, v)| weight * value(*v));
                values.sum::<f64>() / length as f64
            };
            let drift = mean(&|v| v);
            swings.push(mean(&|v| (v - drift) * (v - drift)).sqrt());
            if n > 0 && from + length as f64 > end {
                break;
            }
        }
        let sloped = |n: usize| {
            let (before, next) = (n.saturating_sub(1), (n + 1).min(swings.len() - 1));
            let slope = (swings[before] - swings[next]) / (next - before).max(1) as f64;
            f64::max(swings[n] * swings[n] - 0.13 * slope * slope, 0.0).sqrt()
        };
        (0..swings.len()).map(sloped).collect()
    }
}

/// Least squares of s' = ρ·s − c over all taps, each with its own first swing; the last one of each is a bound from above.
struct Fit {
    windows: Vec<Vec<f64>>,
    /// Largest c that the friction allows.
    most: f64,
    /// Least standard deviation of a swing.
    noise: f64,
}

impl Fit {
    fn squares(&self, ratio: f64, taken: f64) -> f64 {
        let of_tap = |swings: &Vec<f64>| {
            let (mut share, mut less) = (1.0, 0.0);
            // Each swing, its share of the first one, and all that friction has taken.
            let terms = swings.iter().map(|swing| {
                let term = (swing, share, taken * less);
                (share, less) = (ratio * share, 1.0 + ratio * less);
                term
            });
            let terms: Vec<(&f64, f64, f64)> = terms.collect();
            let free = terms.len() - 1;
            let (mut over, mut under) = (0.0, 0.0);
            for (swing, share, less) in &terms[..free] {
                over += share * (*swing + less);
                under += share * share;
            }
            let errors = terms.iter().enumerate().map(|(n, (swing, share, less))| {
                let error = *swing - f64::max(over / under * share - less, 0.0);
                if n < free { error } else { error.min(0.0) }
            });
            errors.map(|error| error * error).sum::<f64>()
        };
        self.windows.iter().map(of_tap).sum()
    }

    /// The largest share of a first swing that would be left in the last one without friction: of motion that is over before it has swung.
    fn left(&self) -> f64 {
        self.windows
            .iter()
            .fold(0.0, |most: f64, swings| match swings.len() - 1 {
                1 => f64::INFINITY,
                hops => most.max((swings[hops] + self.most * hops as f64) / swings[0]),
            })
    }

    /// The best ρ and the ends of its interval.
    fn ratio(&self) -> [f64; 3] {
        let best = |ratio: f64| {
            let (mut low, mut high) = (0.0, self.most);
            for _ in 0..10 {
                let [a, b] = [1.0, 2.0].map(|part| low + part * (high - low) / 3.0);
                if self.squares(ratio, a) <= self.squares(ratio, b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            (ratio, self.squares(ratio, 0.5 * (low + high)))
        };
        let lowest = |all: &[(f64, f64)]| {
            all.iter()
                .fold((1.0, f64::INFINITY), |a, b| if b.1 < a.1 { *b } else { a })
        };
        let mut all: Vec<(f64, f64)> = (0..=55).map(|n| best(0.1 + 0.02 * f64::from(n))).collect();
        let middle = lowest(&all).0;
        all.extend((-40..=40).map(|n| best(middle + 0.002 * f64::from(n))));
        let least = lowest(&all);
        let count: usize = self.windows.iter().map(|swings| swings.len() - 1).sum();
        let free = count as f64 - 2.0 - self.windows.len() as f64;
        let variance = f64::max(least.1 / free.max(1.0), self.noise * self.noise);
        all.retain(|(_, squares)| *squares <= least.1 + 4.0 * variance);
        let inside = all.iter().map(|(ratio, _)| *ratio);
        let from = inside.clone().fold(f64::INFINITY, f64::min);
        [least.0, from, inside.fold(0.0, f64::max)]
    }
}

#[cfg(test)]
mod tests {
    use crate::swings::*;

    /// Speed of a mass on a wall after three taps: each swing is ρ times the one before less 2·F, a tap is 1 N, a period `ticks` long.
    fn tapped(ratio: f64, friction_n: f64, period: f64) -> Swings {
        let (ticks, mut place, mut seen) = (2000, 0.0, Vec::new());
        for n in 0..3 * ticks {
            let (since, way) = (n % ticks, if n / ticks == 1 { 1.0 } else { -1.0 });
            let angle = std::f64::consts::TAU * since as f64 / period;
            let first = if n < ticks { 0.0 } else { 1.0 - friction_n };
            let left = (0..(angle / std::f64::consts::PI) as u32)
                .fold(first, |swing, _| ratio * swing - 2.0 * friction_n);
            place += way * left.max(0.0) * libm::sin(angle) * 1e-3;
            let force_n = if since == 0 && n > 0 { way } else { friction_n };
            seen.push((place, force_n));
        }
        let taps = Taps {
            ticks,
            settles_in: 1e9,
            hand_n_per_m: 0.0,
            friction_n: 0.0,
            encoder_step_m: 0.0,
            step_n: 0.0,
            tick_m_per_n: 0.0,
            seen,
        };
        taps.swings().expect("judged")
    }

    #[test]
    fn the_decay_of_swings_is_told_from_what_friction_takes() {
        for period in [17.3, 40.0, 90.0] {
            for ratio in [0.6, 0.9, 0.98, 1.02, 1.05] {
                let swings = tapped(ratio, 0.02, period);
                let dies = Some(ratio < 1.0);
                assert_eq!(swings.dies, dies, "{ratio} {period}: {swings:?}");
            }
            // A seventh of the tap: what decays could be unstable.
            let swings = tapped(1.05, 0.15, period);
            assert!(swings.dies != Some(true), "{period}: {swings:?}");
        }
    }
}
