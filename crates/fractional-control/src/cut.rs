//! Powers of brackets and diffusion in time: the sum of decays along their cuts.
//!
//! ```text
//! S(t) = H(0) − ∫ A(r)·e^(−rt) dr,   A(r) = −Im H(r·e^(jπ))/(πr),   S the response of H to a step, r along the cuts of H
//! ```
//! Cauchy's integral over the path around the cuts. It is taken between their beginnings and from the last one on, by equal steps h of y, which know
//! nothing of the powers at which H begins or ends there (H. Takahasi, M. Mori, *Publ. RIMS* 9, 1974):
//! ```text
//! r = a + (b − a)/(1 + e^(−y)) from a to b;    r = a + e^y from a on;    r = a + z(z + 2x)/τ, z = 2 ln(1 + e^(y/2)) with diffusion,
//! ```
//! τ the square of the sum of the factors before s in its roots and x its angle at a: e^(−√(τs)) swings along the cut.
//!
//! - *Units*: r in rad/s, t in s, S that of H. *Errors*: 1e-12 of H(0) (`tests/suite/implicit.rs`). *Cost*: some hundred decays.

use crate::{
    ImplicitFactor, ImplicitFactors,
    enclosure::{Factor, Product},
};
use core::f64::consts::PI;
use num_complex::Complex;
use std::vec::Vec;

/// Step of y: an error of e^(−π²/step).
const STEP: f64 = 0.3;
/// An exponent beyond this leaves nothing.
const NOTHING: f64 = 40.0;
/// Diffusion has not arrived before τ/120: erfc(√30) = 1e-14.
const ARRIVES: f64 = 120.0;
/// Decays that differ by less than this share are one: an error of its square.
const ONE: f64 = 1e-6;
/// Share of the largest from which on a term tells only how they fall.
const LEAST: f64 = 1e-15;
/// Decays by less than this share a sample are one: a hundred times as slow as what a usual memory resolves.
const SLOWEST: f64 = 1e-8;
/// Steps to one side at most.
const STEPS_MAX: usize = 4000;

/// A decay: r in rad/s, and its share A of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decay {
    pub rate: f64,
    pub size: f64,
}

/// Place on the cut with its distances from the beginnings of its interval, which are exact where they are small.
struct Place {
    above: f64,
    below: f64,
    /// dr/dy.
    slope: f64,
}

/// Interval of the cuts between two beginnings, or from the last on.
struct Interval {
    low: f64,
    high: Option<f64>,
    /// √τ, and the angle of the swing of diffusion at the lower end.
    root: f64,
    first: f64,
    step: f64,
}

impl Interval {
    fn place(&self, y: f64) -> Place {
        let below = f64::INFINITY;
        match self.high {
            Some(high) => {
                let (up, down) = (1.0 / (1.0 + libm::exp(-y)), 1.0 / (1.0 + libm::exp(y)));
                let width = high - self.low;
                Place {
                    above: width * up,
                    below: width * down,
                    slope: width * up * down,
                }
            }
            None if self.root > 0.0 => {
                let z = 2.0 * libm::log1p(libm::exp(0.5 * y));
                let rises = 1.0 / (1.0 + libm::exp(-0.5 * y));
                let square = self.root * self.root;
                Place {
                    above: z * (z + 2.0 * self.first) / square,
                    below,
                    slope: 2.0 * (z + self.first) * rises / square,
                }
            }
            None => Place {
                above: libm::exp(y),
                below,
                slope: libm::exp(y),
            },
        }
    }

    /// A decay of these factors, and its distance from the nearer end.
    fn term(&self, factors: &ImplicitFactors, y: f64) -> (Decay, f64) {
        let Place {
            above,
            below,
            slope,
        } = self.place(y);
        let base = |branch: f64| match self.high {
            Some(high) if branch >= high => branch - high + below,
            _ => branch - self.low - above,
        };
        let rate = self.low + above;
        let values = factors.all().iter().map(|factor| {
            let base = factor.slope * base(factor.branch());
            factor.of_base(Complex::new(base, 0.0))
        });
        let value: Complex<f64> = values.product();
        let size = -value.im * slope * self.step / (PI * rate);
        (Decay { rate, size }, above.min(below))
    }

    /// Decays at equal steps of y from this one on, up or down, until none is left at that time, or those that follow are known by their ratio:
    /// that of the distances to the power 1 + α where a power α begins.
    fn side(&self, factors: &ImplicitFactors, mut y: f64, step: f64, from_s: f64) -> Vec<Decay> {
        let end = if step > 0.0 {
            self.high
        } else {
            Some(self.low)
        };
        let is_there = |factor: &&ImplicitFactor| factor.is_power && Some(factor.branch()) == end;
        let power = factors.all().iter().find(is_there);
        let mut found: Vec<Decay> = Vec::new();
        let (mut most, mut last_near) = (0.0_f64, f64::NAN);
        for _ in 0..STEPS_MAX {
            let (mut next, near) = self.term(factors, y);
            if next.rate * from_s > NOTHING && step > 0.0 {
                break;
            }
            most = most.max(next.size.abs());
            let falls = found.last().map(|last| next.size / last.size);
            let is_last = next.size.abs() <= LEAST * most || near <= LEAST * next.rate;
            let falls = falls.filter(|falls| is_last && (0.0..1.0).contains(falls));
            if let Some(falls) = falls {
                let nearer = libm::log(near / last_near);
                next.size /= power.map_or(1.0 - falls, |factor| {
                    -libm::expm1((1.0 + factor.order) * nearer)
                });
            }
            last_near = near;
            found.push(next);
            if falls.is_some() {
                break;
            }
            y += step;
        }
        found
    }
}

impl ImplicitFactors {
    /// √τ of all diffusion.
    fn root_of_diffusion(&self) -> f64 {
        let all = self.all().iter().filter(|factor| !factor.is_power);
        all.map(|factor| -factor.order * libm::sqrt(factor.slope))
            .sum()
    }

    /// True if its decays include slower ones than are resolved at this sample time.
    pub(crate) fn remembers(&self, sample_time_s: f64) -> bool {
        let mut all = self.all().iter();
        all.any(|factor| factor.branch() * sample_time_s < SLOWEST)
    }

    /// Time before which a step has not arrived, s.
    fn silence_s(&self) -> f64 {
        let root = self.root_of_diffusion();
        root * root / ARRIVES
    }

    /// H(0).
    pub(crate) fn at_rest(&self) -> f64 {
        self.at(Complex::new(0.0, 0.0)).re
    }

    /// |H(jω)|/H(0).
    pub(crate) fn share_at(&self, omega: f64) -> f64 {
        self.at(Complex::new(0.0, omega)).norm() / self.at_rest()
    }

    /// The decays that are left from this time on, s, above [`silence_s`](Self::silence_s).
    pub(crate) fn decays(&self, from_s: f64) -> Vec<Decay> {
        let mut branches: Vec<f64> = self.all().iter().map(|factor| factor.branch()).collect();
        branches.sort_by(f64::total_cmp);
        branches.dedup();
        let ends = branches.iter().copied();
        // Of an interval that ends where nothing is left the end does not count.
        let ends = ends
            .skip(1)
            .map(|end| (end * from_s <= NOTHING).then_some(end));
        let ends = ends.chain([None]);
        let mut all = Vec::new();
        for (low, high) in branches.iter().copied().zip(ends) {
            all.extend(self.between(low, high, from_s));
            if high.is_none() {
                break;
            }
        }
        merged(all)
    }

    /// Angle of the swing of diffusion at this place of the cut.
    fn angle(&self, rate: f64) -> f64 {
        let all = self.all().iter().filter(|factor| !factor.is_power);
        let angle = |base: f64| libm::sqrt(base.max(0.0));
        all.map(|factor| -factor.order * angle(rate * factor.slope - factor.constant))
            .sum()
    }

    fn between(&self, low: f64, high: Option<f64>, from_s: f64) -> Vec<Decay> {
        let (root, first) = (self.root_of_diffusion(), self.angle(low));
        let swing = high.map_or(0.0, |high| self.angle(high) - first);
        let step = STEP / (1.0 + swing / 21.0);
        let interval = Interval {
            low,
            high,
            root,
            first,
            step,
        };
        // The middle of what is left at that time.
        let middle = if high.is_some() || root > 0.0 {
            0.0
        } else {
            -libm::log(from_s)
        };
        let mut all = interval.side(self, middle - step, -step, from_s);
        all.reverse();
        all.extend(interval.side(self, middle, step, from_s));
        all
    }
}

/// Decays that are nearly the same as one, with the same size at rest and at first.
fn merged(all: Vec<Decay>) -> Vec<Decay> {
    let mut rest: Vec<Decay> = Vec::new();
    for next in all.into_iter().filter(|decay| decay.size != 0.0) {
        match rest.last_mut() {
            Some(last)
                if next.rate - last.rate <= ONE * next.rate && next.size * last.size > 0.0 =>
            {
                let size = last.size + next.size;
                last.rate += (next.rate - last.rate) * next.size / size;
                last.size = size;
            }
            _ => rest.push(next),
        }
    }
    rest
}

/// Decays that are slower than this as one, with the same size at rest and at first. The cut of diffusion begins at rest.
fn of_a_memory(all: Vec<Decay>, slowest: f64) -> Vec<Decay> {
    let count = all.partition_point(|decay| decay.rate < slowest);
    let (slow, rest) = all.split_at(count);
    let size: f64 = slow.iter().map(|decay| decay.size).sum();
    let first: f64 = slow.iter().map(|decay| decay.size * decay.rate).sum();
    let one = (size != 0.0).then(|| Decay {
        rate: first / size,
        size,
    });
    one.into_iter().chain(rest.iter().copied()).collect()
}

/// Factors behind a hold and a part h of a sample of dead time.
/// ```text
/// H_d = S(t₁)·w + Σ A(1 − p)e^(−rt₁)·w²/(1 − pw),   p = e^(−rT),   t₁ = (n₀ + 1 − h)T, all times w^n₀: before it nothing has arrived
/// ```
#[derive(Clone, Debug)]
pub(crate) struct HeldFactors {
    first: f64,
    /// Weight, p and 1 − p of each.
    decays: Vec<[f64; 3]>,
}

impl HeldFactors {
    /// The held factors, and n₀.
    pub(crate) fn new(factors: &ImplicitFactors, sample_time_s: f64, part: f64) -> (Self, f64) {
        let silent = libm::floor(factors.silence_s() / sample_time_s + part);
        let from_s = (silent + 1.0 - part) * sample_time_s;
        let decays = of_a_memory(factors.decays(from_s), SLOWEST / sample_time_s);
        let left = |decay: &Decay| decay.size * libm::exp(-decay.rate * from_s);
        let held = decays.iter().map(|decay| {
            let turn = -decay.rate * sample_time_s;
            let lost = -libm::expm1(turn);
            [left(decay) * lost, libm::exp(turn), lost]
        });
        let first = factors.at_rest() - decays.iter().map(left).sum::<f64>();
        let decays = held.collect();
        (Self { first, decays }, silent)
    }

    /// Products of it and others, before n₀ samples of dead time.
    pub(crate) fn times(&self, others: &[Product]) -> Vec<Product> {
        let decays = self.decays.iter().map(|[weight, _, lost]| (*weight, *lost));
        let memory = Factor::Memory(Vec::new(), decays.collect());
        let products = others.iter().flat_map(|other| {
            let [mut at_once, mut later] = [other.clone(), other.clone()];
            at_once.scale *= self.first;
            at_once.factors.push(Factor::Delay(1));
            later.factors.extend([memory.clone(), Factor::Delay(2)]);
            [at_once, later]
        });
        products.collect()
    }

    pub(crate) fn at_rest(&self) -> Vec<f64> {
        std::vec![0.0; self.decays.len()]
    }

    /// The output, from its decays and the last input.
    pub(crate) fn output(&self, state: &[f64], last: f64) -> f64 {
        let decays = self.decays.iter().zip(state);
        let left: f64 = decays.map(|([weight, ..], x)| weight * x).sum();
        self.first * last + left
    }

    pub(crate) fn advance(&self, state: &mut [f64], last: f64) {
        for ([_, kept, _], x) in self.decays.iter().zip(state) {
            *x = kept * *x + last;
        }
    }
}
