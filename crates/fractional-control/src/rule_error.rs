//! How far the rule of a plant's samples is from the plant behind its hold.
//! ```text
//! F = A_C·A_G + k·B_C·B_G of the rule,   F + k·E of the plant,   E = B_C·(A_G·G_d − B_G)
//! k·|E| < |F| on the circle:   both turn about 0 as often     (E. Rouché)
//! ```
//! On each arc both sides are bounded, so nothing between two angles is missed, however narrow a resonance is.

use crate::SampledLoop;
use crate::held_response::HeldResponse;
use certified_count::{Arc, Enclosed};
use core::f64::consts::PI;
use std::vec::Vec;

/// Share of |F| by which the rule may be off for the loop to turn as its plant does. Below 1 it does; the rest is for what the far end of
/// the sum over the aliases of a plant is estimated to be.
const HOLDS: f64 = 0.7;
/// The first angle at most, and times 1/(the samples that are remembered): below it a rule is right as long as its memory lasts.
const FIRST: f64 = 1e-4;
const OF_MEMORY: f64 = 100.0;
/// An arc of this width that is not decided counts as one where the rule does not hold.
const NARROWEST: f64 = 1e-13;
/// Arcs at most: some hundred times what any loop of the tests takes.
const ARCS_MAX: usize = 10_000;
/// Times the end of an interval of gains, known within a factor of two, is narrowed.
const HALVINGS: usize = 5;

/// The verdict on a loop whose plant is discretised by a rule, and on the loop without that rule:
/// both on arcs from near rest to half the sample rate.
///
/// - *Cost*: some ten to some hundred arcs, each the response of the plant at 130 frequencies: a millisecond to ten.
#[derive(Clone, Debug)]
pub struct RuleError<'a> {
    rule: &'a SampledLoop,
    held: &'a HeldResponse,
    /// `None` where the rule does not hold.
    places: Option<Vec<Place>>,
}

/// F and E on an arc.
#[derive(Clone, Debug)]
struct Place {
    arc: Arc,
    below: Enclosed,
    above: Enclosed,
    error: Enclosed,
}

/// What is known of an arc.
enum Judged {
    Holds,
    Fails,
    Unclear,
}

impl Place {
    /// k|E| < [`HOLDS`]·|F| for all gains k of the interval?
    /// ```text
    /// H|d + kn| − k|e|,   the least at k = −b + |e|·c/√(H²|n|² − |e|²), or at an end;   b = Re(d·n̄)/|n|², c = |Im(d·n̄)|/|n|²
    /// ```
    fn judged(&self, [low, high]: [f64; 2]) -> Judged {
        let [d, n, e] = [self.below, self.above, self.error].map(|part| part.middle.value);
        let e = e.norm();
        let beside = d * n.conj() / n.norm_sqr();
        let steep = HOLDS * HOLDS * n.norm_sqr() - e * e;
        let lowest = -beside.re + e * beside.im.abs() / libm::sqrt(steep);
        // Without a lowest place it falls to the end.
        let k = if steep > 0.0 && lowest < high {
            lowest.max(low)
        } else {
            high
        };
        let room = HOLDS * (d + n * k).norm() - k * e;
        let rates = high * self.error.rate + HOLDS * (self.below.rate + high * self.above.rate);
        if room > 1.01 * self.arc.half_width() * rates {
            Judged::Holds
        } else if room > 0.0 && self.arc.high - self.arc.low > NARROWEST {
            Judged::Unclear
        } else {
            Judged::Fails
        }
    }
}

impl RuleError<'_> {
    /// True if the loop with the rule turns about −1 as often as the loop of the plant: its verdict
    /// then holds for the plant.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.places.is_some()
    }

    /// The gains from 1 down and up to these at which it [`holds`](Self::holds); 1 alone where it does not there.
    #[must_use]
    pub fn within(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let Some(mut places) = self.places.clone() else {
            return [1.0; 2];
        };
        let mut left = ARCS_MAX;
        let mut between = |a: f64, b: f64| {
            let gains = [a.min(b), a.max(b)];
            self.holds_at(&mut places, gains, &mut left)
        };
        let mut reached = |end: f64| {
            // What bounds one end of a step of two at most serves all of it.
            let steps = libm::ceil(libm::log2(end).abs()).max(1.0);
            let gain = |step: f64| libm::pow(end, step / steps);
            let mut inside = 0.0;
            while inside < steps && between(gain(inside), gain(inside + 1.0)) {
                inside += 1.0;
            }
            let mut part = 0.5;
            for _ in 0..HALVINGS {
                if inside < steps && between(gain(inside), gain(inside + part)) {
                    inside += part;
                }
                part *= 0.5;
            }
            gain(inside)
        };
        [reached(low), reached(high)]
    }

    fn place(&self, low: f64, high: f64) -> Place {
        let arc = Arc::new(low, high);
        let (below, above) = self.rule.parts(&arc);
        let gain = self.rule.gain();
        let error = self.rule.missed(&arc, self.held.enclosed(&arc));
        Place {
            below,
            above: above.scaled(gain),
            error: error.scaled(gain),
            arc,
        }
    }

    /// True if it holds on all these arcs at these gains. Those that do not tell are halved, and stay so for the next gains.
    fn holds_at(&self, places: &mut Vec<Place>, gains: [f64; 2], left: &mut usize) -> bool {
        // The last is the next.
        let mut ahead: Vec<Place> = places.drain(..).rev().collect();
        while let Some(place) = ahead.pop() {
            match place.judged(gains) {
                Judged::Holds => places.push(place),
                Judged::Unclear if *left > 0 => {
                    *left -= 1;
                    let [low, middle, high] = [place.arc.low, place.arc.middle(), place.arc.high];
                    ahead.extend(
                        [(middle, high), (low, middle)].map(|(low, high)| self.place(low, high)),
                    );
                }
                Judged::Fails | Judged::Unclear => {
                    places.push(place);
                    places.extend(ahead.into_iter().rev());
                    return false;
                }
            }
        }
        true
    }

    /// Arcs from the first to π, on each of which the rule holds.
    fn places(&self, first: f64) -> Option<Vec<Place>> {
        let mut places = Vec::new();
        let (mut theta, mut width) = (first, 0.1 * first);
        for _ in 0..ARCS_MAX {
            // No sliver is left at the end.
            let next = if theta + 1.5 * width > PI {
                PI
            } else {
                theta + width
            };
            let place = self.place(theta, next);
            match place.judged([1.0; 2]) {
                Judged::Holds => {
                    places.push(place);
                    if next >= PI {
                        return Some(places);
                    }
                    theta = next;
                    width *= 2.0;
                }
                Judged::Fails => return None,
                Judged::Unclear => width = 0.5 * (next - theta),
            }
        }
        None
    }
}

impl SampledLoop {
    /// How far the plant's rule deviates from the plant behind its hold; `None` for a plant that is
    /// sampled exactly.
    #[must_use]
    pub fn rule_error(&self) -> Option<RuleError<'_>> {
        let held = self.held()?;
        let nothing_yet = RuleError {
            rule: self,
            held,
            places: None,
        };
        let of_memory = |s: f64| OF_MEMORY / (s * self.rate());
        let first = self.memory_s().map_or(FIRST, |s| of_memory(s).min(FIRST));
        let places = || nothing_yet.places(first);
        let places = self.grows_as(held).then(places).flatten();
        Some(RuleError {
            places,
            ..nothing_yet
        })
    }
}
