//! Swings after the taps of a motor: do they die away by themselves, or because friction stops them?
//!
//! ```text
//! s' = ρ·s − c        s: swing of the speed over a window of two half periods, c ≥ 0: what friction takes from each window to the next
//! stable:    at most ρ₀ over all of the interval of ρ;    unstable: at least ρ₀;    else nobody can tell: held by friction
//! ρ₀ = 0.014^(hop/(0.96·N)): so much is left of a swing after N ticks, the time in which a wall has to settle
//! ```
//! - *Windows*: weighted by 1 − cos, one half period apart, so that neither the phase nor a slow drift counts; each of at least six ticks.
//!   The half period is the mean time between turning points of the speed. Windows end where the device stops.
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

/// A trial with taps.
#[derive(Clone, Debug)]
pub(crate) struct Taps {
    /// Ticks from one step of the tap to the next.
    pub(crate) ticks: usize,
    /// Ticks in which a wall has to settle.
    pub(crate) settles_in: f64,
    /// Spring of a hand, N/m.
    pub(crate) hand_n_per_m: f64,
    /// Friction by the device file, N.
    pub(crate) friction_n: f64,
    pub(crate) encoder_step_m: f64,
    /// Force of a step of the encoder through the law, N.
    pub(crate) step_n: f64,
    /// Place, m, and force, N, of each tick.
    pub(crate) seen: Vec<(f64, f64)>,
}

/// Decay of the swings after the taps. Its fields are keys of reports.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Swings {
    /// Mean step of the force, N.
    pub tap_n: f64,
    /// Friction, at least, N.
    pub friction_n: f64,
    /// Share of a swing that is left in the next.
    pub swing_ratio: f64,
    /// Its interval.
    pub swing_ratio_from: f64,
    pub swing_ratio_to: f64,
    /// The share up to which a wall settles in time.
    pub swing_ratio_limit: f64,
    /// The answer; `None` if friction hides it.
    #[serde(skip)]
    pub(crate) dies: Option<bool>,
}

/// Speeds after a tap, m per tick, with their turning points.
struct After {
    speeds: Vec<f64>,
    turns: Vec<usize>,
}

impl Taps {
    fn after(&self, from: usize) -> After {
        let places = self.seen[from..from + self.ticks].windows(2);
        let speeds: Vec<f64> = places.map(|pair| pair[1].0 - pair[0].0).collect();
        let largest = speeds.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let least = f64::max(0.05 * largest, 2.5 * self.encoder_step_m);
        let (mut turns, mut end, mut way) = (Vec::new(), (0, speeds[0]), 0.0);
        for (tick, &v) in speeds.iter().enumerate() {
            let further = (v - end.1) * way;
            if way == 0.0 && (v - end.1).abs() > least {
                (way, end) = ((v - end.1).signum(), (tick, v));
            } else if further > 0.0 {
                end = (tick, v);
            } else if further < -least {
                turns.push(end.0);
                (way, end) = (-way, (tick, v));
            }
        }
        After { speeds, turns }
    }

    /// Mean force of the motor over the end of the time before a tick, less the spring of a hand, N: at rest friction holds it.
    fn left_n(&self, before: usize) -> f64 {
        let last = &self.seen[before - self.ticks / 8..before];
        let left = last
            .iter()
            .map(|(place_m, force_n)| force_n - self.hand_n_per_m * place_m);
        left.sum::<f64>() / last.len() as f64
    }

    /// True if the motion dies away at the end of the newest samples: it varies by less than in as many before them.
    pub(crate) fn falls(&self, samples: usize) -> bool {
        let end = self.seen.len();
        let spread = |range: std::ops::Range<usize>| {
            let places = self.seen[range].iter().map(|(place_m, _)| *place_m);
            let mean = places.clone().sum::<f64>() / samples as f64;
            places
                .map(|place| (place - mean) * (place - mean))
                .sum::<f64>()
        };
        end >= 2 * samples
            && spread(end - samples..end) < 0.8 * spread(end - 2 * samples..end - samples)
    }

    /// The swings of a trial that reached its end.
    pub(crate) fn swings(&self) -> Option<Swings> {
        // Force may rise for a third of the time.
        let rising = self.seen.len() / 3;
        let steps = (1..self.seen.len() / self.ticks.max(1)).map(|n| n * self.ticks);
        let steps: Vec<usize> = steps
            .filter(|&step| step + self.ticks / 8 > rising)
            .collect();
        if steps.is_empty() || self.ticks < 16 {
            return None;
        }
        // Over some ticks, since the rate of the force is limited.
        let jump = |&step: &usize| {
            let first = self.seen[step..step + self.ticks / 16].iter();
            let jumps = first.map(|(_, force_n)| (force_n - self.seen[step - 1].1).abs());
            jumps.fold(0.0, f64::max)
        };
        let tap_n = steps.iter().map(jump).sum::<f64>() / steps.len() as f64;
        let ends = steps.iter().copied().chain([self.seen.len()]);
        let friction_n = ends.fold(self.friction_n, |most, end| {
            most.max(self.left_n(end).abs())
        });
        let after: Vec<After> = steps.iter().map(|&step| self.after(step)).collect();
        let turned = after.iter().filter(|after| after.turns.len() > 1);
        let (span, count) = turned.fold((0, 0), |(span, count), After { turns, .. }| {
            (
                span + turns[turns.len() - 1] - turns[0],
                count + turns.len() - 1,
            )
        });
        let half = match count {
            0 => self.ticks as f64 / 16.0,
            _ => (span as f64 / count as f64).min(self.ticks as f64 / 8.0),
        };
        let last = after.iter().filter_map(|after| after.turns.last()).max();
        let least = f64::max(*last.unwrap_or(&0) as f64 / 24.0, 3.0);
        let hop = (half * (least / half).ceil().max(1.0)).min(self.ticks as f64 / 5.0);
        let windows: Vec<Vec<f64>> = after.iter().map(|after| after.windows(half, hop)).collect();
        let first = windows.iter().map(|swings| swings[0]).fold(0.0, f64::max);
        let share = (friction_n / tap_n).min(1.0);
        let fit = Fit {
            most: 3.0 * share * first * hop / half,
            noise: f64::max(0.35 * self.encoder_step_m / hop.sqrt(), 3e-3 * first),
            windows,
        };
        let [ratio, from, to] = fit.ratio();
        let gone = fit.left() < GONE;
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
        let end = self.turns.last().map_or(0.0, |turn| *turn as f64) + 0.5 * half;
        let turn = std::f64::consts::TAU / length as f64;
        let weights: Vec<f64> = (0..length)
            .map(|n| 1.0 - libm::cos(turn * (n as f64 + 0.5)))
            .collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            weights
                .iter()
                .zip(values)
                .map(|(weight, value)| weight * value)
                .sum::<f64>()
                / length as f64
        };
        let mut swings = Vec::new();
        for n in 0..26 {
            let from = n as f64 * hop;
            let Some(window) = self.speeds.get(from as usize..from as usize + length) else {
                break;
            };
            let drift = mean(&mut window.iter().copied());
            let energy = mean(&mut window.iter().map(|v| (v - drift) * (v - drift)));
            swings.push(energy.sqrt());
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
    /// Largest c.
    most: f64,
    /// Least standard deviation of a swing.
    noise: f64,
}

impl Fit {
    fn squares(&self, ratio: f64, taken: f64) -> f64 {
        let of_tap = |swings: &Vec<f64>| {
            let mut terms = (1.0, 0.0);
            let terms = swings.iter().map(|&swing| {
                let now = terms;
                terms = (ratio * now.0, 1.0 + ratio * now.1);
                (swing, now.0, taken * now.1)
            });
            let terms: Vec<(f64, f64, f64)> = terms.collect();
            let free = terms.len().max(2) - 1;
            let whole = terms.iter().take(free);
            let (over, under) = whole.fold((0.0, 0.0), |(over, under), (swing, share, less)| {
                (over + share * (swing + less), under + share * share)
            });
            let error = |(n, (swing, share, less)): (usize, &(f64, f64, f64))| {
                let error = swing - f64::max(over / under * share - less, 0.0);
                if n < free { error } else { error.min(0.0) }
            };
            terms
                .iter()
                .enumerate()
                .map(error)
                .map(|error| error * error)
                .sum::<f64>()
        };
        self.windows.iter().map(of_tap).sum()
    }

    /// The largest share of a first swing that would be left in the last one without friction: of motion that is over before it has swung.
    fn left(&self) -> f64 {
        let left = self.windows.iter().map(|swings| {
            let hops = swings.len() - 1;
            match hops {
                0 | 1 => f64::INFINITY,
                _ => (swings[hops] + self.most * hops as f64) / swings[0],
            }
        });
        left.fold(0.0, f64::max)
    }

    /// The best ρ and the ends of its interval.
    fn ratio(&self) -> [f64; 3] {
        let best = |ratio: f64| {
            let (mut low, mut high) = (0.0, self.most);
            for _ in 0..10 {
                let [a, b] = [1.0, 2.0].map(|part| low + part * (high - low) / 3.0);
                match self.squares(ratio, a) <= self.squares(ratio, b) {
                    true => high = b,
                    false => low = a,
                }
            }
            (ratio, self.squares(ratio, 0.5 * (low + high)))
        };
        let lowest = |all: &[(f64, f64)]| {
            let none = (1.0, f64::INFINITY);
            all.iter().fold(none, |a, b| if b.1 < a.1 { *b } else { a })
        };
        let mut all: Vec<(f64, f64)> = (0..=55).map(|n| best(0.1 + 0.02 * f64::from(n))).collect();
        let middle = lowest(&all).0;
        all.extend((-40..=40).map(|n| best(middle + 0.002 * f64::from(n))));
        let least = lowest(&all);
        let count: usize = self.windows.iter().map(|swings| swings.len() - 1).sum();
        let free = count as f64 - 2.0 - self.windows.len() as f64;
        let variance = f64::max(least.1 / free.max(1.0), self.noise * self.noise);
        let inside = all
            .iter()
            .filter(|(_, squares)| *squares <= least.1 + 4.0 * variance);
        let ends = inside.fold((f64::INFINITY, 0.0), |(from, to), (ratio, _)| {
            (ratio.min(from), ratio.max(to))
        });
        [least.0, ends.0, ends.1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed of a mass on a wall after three taps: each swing is ρ times the one before less 2·F, a tap is 1 N, a period `ticks` long.
    fn tapped(ratio: f64, friction_n: f64, period: f64) -> Swings {
        let (ticks, mut place, mut seen) = (2000, 0.0, Vec::new());
        for n in 0..3 * ticks {
            let (since, up) = (n % ticks, n / ticks == 1);
            let half = (since as f64 / (0.5 * period)).floor();
            let left = (0..half as u32).fold(1.0 - friction_n, |swing, _| {
                ratio * swing - 2.0 * friction_n
            });
            let way = if up { 1.0 } else { -1.0 };
            let moves = n >= ticks && left > 0.0;
            let angle = std::f64::consts::TAU * since as f64 / period;
            place += if moves {
                way * left * libm::sin(angle) * 1e-3
            } else {
                0.0
            };
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
            seen,
        };
        taps.swings().expect("judged")
    }

    #[test]
    fn the_decay_of_swings_is_told_from_what_friction_takes() {
        for period in [17.3, 40.0, 90.0] {
            for ratio in [0.6, 0.9, 0.98, 1.02, 1.05] {
                let swings = tapped(ratio, 0.02, period);
                assert_eq!(
                    swings.dies,
                    Some(ratio < 1.0),
                    "{ratio} {period}: {swings:?}"
                );
            }
            // A seventh of the tap: what decays could be unstable.
            let swings = tapped(1.05, 0.15, period);
            assert!(swings.dies != Some(true), "{period}: {swings:?}");
        }
    }
}
