//! Zeros of a modulus or a compliance beside the cut.

use super::spring_pot::turned;
use core::f64::consts::{FRAC_PI_2, PI};

/// A term c·s^p.
#[derive(Clone, Copy)]
pub(super) struct Term {
    pub(super) factor: f64,
    pub(super) power: f64,
}

/// A zero of D: s = e^(`ln_r`)·e^(i(π + `beyond`)), and its conjugate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pole {
    pub(super) ln_r: f64,
    /// Angle from the negative axis, 0 ≤ `beyond` < π/2.
    pub(super) beyond: f64,
}

impl Pole {
    pub(super) fn half_turns(self) -> f64 {
        1.0 + self.beyond / PI
    }
}

/// The zero within a quarter turn of the negative axis of
/// ```text
/// D(s) = c₀ + c₁·s^p + c₂·s^q,      c₀, c₁ > 0,  c₂ ≥ 0,  0 ≤ q < p ≤ 1
/// ```
/// D has no zero with |arg s| < π, and at most one pair with π ≤ |arg s| < 3π/2: it lies on the negative axis for p = 1 and
/// goes away from it, on the next sheet, as p falls. For c₂ = 0 its angle is π/p. The zero with the angle θ has
/// Im D = 0, which gives |s| for each θ, and Re D changes its sign once between π/p and 3π/2.
pub(super) fn beside_the_cut(constant: f64, first: Term, second: Option<Term>) -> Option<Pole> {
    let Some(second) = second else {
        return two_terms(constant, first);
    };
    if second.power == 0.0 {
        return two_terms(constant + second.factor, first);
    }
    if first.power <= 2.0 / 3.0 {
        return None;
    }
    // Two terms are a good guess if one of them is negligible, or both have nearly the same power.
    let sum = first.factor + second.factor;
    let middle = Term {
        factor: sum,
        power: (first.factor * first.power + second.factor * second.power) / sum,
    };
    let guesses = [
        two_terms(constant, first),
        two_terms(constant, second),
        two_terms(constant, middle),
        by_halving(constant, first, second),
    ];
    let polished = (guesses.into_iter().flatten())
        .map(|guess| polished(constant, first, second, guess))
        .find(|(_, rest)| *rest < CLOSE);
    let (pole, _) = polished?;
    (pole.beyond < FRAC_PI_2).then_some(pole)
}

/// |D| over the sum of its terms' sizes, at a zero.
const CLOSE: f64 = 1e-13;

/// The zero as the change of sign of Re D along Im D = 0; rough where the powers are close.
fn by_halving(constant: f64, first: Term, second: Term) -> Option<Pole> {
    // At π/p Re D < 0. Without a change of sign before 3π/2 there is no zero.
    let most = f64::min(1.5 * PI, PI / second.power) - PI / first.power;
    if most <= 0.0 {
        return None;
    }
    let (mut low, mut high) = (-80.0, libm::log(most) - 1e-9);
    for _ in 0..44 {
        let middle = 0.5 * (low + high);
        if real_part(constant, first, second, libm::exp(middle)).1 < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let over = libm::exp(high);
    let ln_r = real_part(constant, first, second, over).0;
    let beyond = PI * (1.0 / first.power - 1.0) + over;
    Some(Pole { ln_r, beyond })
}

fn two_terms(constant: f64, first: Term) -> Option<Pole> {
    let beyond = PI * (1.0 / first.power - 1.0);
    let ln_r = (libm::log(constant) - libm::log(first.factor)) / first.power;
    (beyond < FRAC_PI_2).then_some(Pole { ln_r, beyond })
}

/// `ln |s|` at which Im D = 0 for the angle π/p + `over`, and a number with the sign of Re D there.
fn real_part(constant: f64, first: Term, second: Term, over: f64) -> (f64, f64) {
    // sin(p·θ) = −sin(p·over), cos(p·θ) = −cos(p·over)
    let (sin_p, cos_p) = libm::sincos(first.power * over);
    let (sin_q, cos_q) = libm::sincos(second.power * (PI / first.power + over));
    let ln_r =
        (libm::log(second.factor) + libm::log(sin_q) - libm::log(first.factor) - libm::log(sin_p))
            / (first.power - second.power);
    let rest = constant * libm::exp(-first.power * ln_r)
        + second.factor * cos_q * libm::exp((second.power - first.power) * ln_r);
    let sum = rest - first.factor * cos_p;
    // No number where the smallest |s| overflows: the constant counts alone there.
    (ln_r, if sum.is_nan() { 1.0 } else { sum })
}

/// Newton's steps on ln s, each at most 1/2 long; and the residual of D.
fn polished(constant: f64, first: Term, second: Term, start: Pole) -> (Pole, f64) {
    let mut pole = start;
    let mut rest = f64::INFINITY;
    for _ in 0..40 {
        let power = |term: Term| {
            let size = term.factor / constant * libm::exp(term.power * pole.ln_r);
            turned(term.power * pole.half_turns()) * size
        };
        let (a, b) = (power(first), power(second));
        rest = (a + b + 1.0).norm() / (a.norm() + b.norm() + 1.0);
        let mut step = (a + b + 1.0) / (a * first.power + b * second.power);
        if !(step.re.is_finite() && step.im.is_finite()) || step.norm() < 1e-16 {
            break;
        }
        if step.norm() > 0.5 {
            step *= 0.5 / step.norm();
        }
        pole.ln_r -= step.re;
        pole.beyond = f64::max(0.0, pole.beyond - step.im);
    }
    (pole, if rest.is_nan() { f64::INFINITY } else { rest })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_of_three_terms_are_zeros() {
        let mut found = 0;
        for p in [1.0, 0.9999, 0.99, 0.9, 0.8, 0.7, 0.6] {
            for q in [0.0, 1e-6, 0.01, 0.3, 0.65, 0.9, p - 1e-9] {
                for ratio in [1e-12, 1e-3, 1.0, 1e3, 1e9] {
                    if q >= p {
                        continue;
                    }
                    let first = Term {
                        factor: 7.0,
                        power: p,
                    };
                    let second = Term {
                        factor: 7.0 * ratio,
                        power: q,
                    };
                    let Some(pole) = beside_the_cut(3.0, first, Some(second)) else {
                        continue;
                    };
                    found += 1;
                    let term = |t: Term| {
                        turned(t.power * pole.half_turns())
                            * (t.factor * libm::exp(t.power * pole.ln_r))
                    };
                    let (a, b) = (term(first), term(second));
                    let rest = (a + b + 3.0).norm() / (a.norm() + b.norm() + 3.0);
                    assert!(rest < 1e-14, "p {p} q {q} ratio {ratio}: {rest:e} {pole:?}");
                }
            }
        }
        assert!(found > 60, "{found}");
    }
}
