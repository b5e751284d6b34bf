//! An environment that changes while it runs, without a bump, and gives no energy by that.
//!
//! ```text
//! f = (1 − s)·f_old + s·f_new        s from 0 to 1 in so many ticks
//! f ← c·f                            after a change, until the touch is over: see below
//! ```
//! Both laws hear the same motion meanwhile. Two walls that only push make one that only pushes.
//!
//! - *Energy*: a tissue that grows stiffer under a finger would push it back with more than the finger ever put in. So a touch
//!   in which the law changed never gives more than it took:
//!
//! ```text
//! A ← A − f_sent·Δx from the first contact on;    outwards, f·Δx > 0:  c ← c·A/(N·f·Δx) where that is below c
//! ```
//!   Inwards c comes back, by as much a tick as s. Out of contact A and c begin anew, and a change is done. Without a change c is 1, to the bit.

#[cfg(test)]
mod tests;

use haptic_loop::Environment;
use nalgebra::Vector1;
use std::mem;

/// Two laws, the old and the new one.
#[derive(Clone, Debug)]
pub(crate) struct Fading<E> {
    old: E,
    new: E,
    /// Share of the new one that is added in a tick.
    step: f64,
}

/// Their histories, the share of the new law, and the energy of this touch.
#[derive(Clone, Debug)]
pub(crate) struct FadingHistory<H> {
    old: H,
    new: H,
    share: f64,
    touch: Touch,
}

/// N: a tick spends no more than 1/N of what the touch has taken.
const SPEND: f64 = 4.0;

/// Books of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Touch {
    /// Energy that it has taken, J.
    taken_j: f64,
    /// The force that was sent last, N, and where.
    sent_n: f64,
    position_m: f64,
    /// The law has changed in it.
    changed: bool,
    /// c.
    factor: f64,
}

impl Touch {
    const NONE: Self = Self {
        taken_j: 0.0,
        sent_n: 0.0,
        position_m: 0.0,
        changed: false,
        factor: 1.0,
    };

    /// c of a force that the laws want at this place, N; `step` is by how much it may come back.
    #[inline]
    fn factor(&self, wanted_n: f64, position_m: f64, step: f64) -> f64 {
        if !self.changed {
            return 1.0;
        }
        let moved = position_m - self.position_m;
        let given = wanted_n * moved;
        if given <= 0.0 {
            // Inwards, or at rest.
            let back = if given < 0.0 { step } else { 0.0 };
            return f64::min(self.factor + back, 1.0);
        }
        // What the force that is held until now has given is known.
        let left = f64::max(self.taken_j - self.sent_n * moved, 0.0) / SPEND;
        if self.factor * given > left {
            left / given
        } else {
            self.factor
        }
    }
}

/// A law with the history of what it has heard.
#[derive(Clone, Debug)]
pub(crate) struct Law<E: Environment<f64, 1>> {
    pub(crate) environment: E,
    pub(crate) history: E::History,
}

impl<E: Environment<f64, 1>> Law<E> {
    /// At rest.
    pub(crate) fn at_rest(environment: E) -> Self {
        let history = environment.at_rest();
        Self {
            environment,
            history,
        }
    }

    /// Hears a position, m.
    pub(crate) fn hear(&mut self, position_m: f64) {
        (self.environment).advance(&mut self.history, &Vector1::new(position_m));
    }
}

impl<E: Environment<f64, 1> + Clone> Fading<E> {
    /// One law alone; a later one takes `ticks` to come.
    pub(crate) fn new(law: E, ticks: u32) -> Self {
        Self {
            old: law.clone(),
            new: law,
            step: 1.0 / f64::from(ticks.max(1)),
        }
    }
}

impl<E: Environment<f64, 1>> Fading<E> {
    /// The law that is felt begins to go, `next` begins to come; `next` becomes the one that went before it, for the caller to
    /// drop elsewhere. Nothing is allocated.
    pub(crate) fn change(&mut self, history: &mut FadingHistory<E::History>, next: &mut Law<E>) {
        mem::swap(&mut self.old, &mut self.new);
        mem::swap(&mut history.old, &mut history.new);
        mem::swap(&mut self.new, &mut next.environment);
        mem::swap(&mut history.new, &mut next.history);
        history.share = 0.0;
        history.touch.changed = true;
    }

    /// `next` is felt at once, and becomes the law that was.
    pub(crate) fn replace(&mut self, history: &mut FadingHistory<E::History>, next: &mut Law<E>) {
        mem::swap(&mut self.new, &mut next.environment);
        mem::swap(&mut history.new, &mut next.history);
        history.share = 1.0;
        history.touch = Touch::NONE;
    }

    fn wanted(&self, history: &FadingHistory<E::History>, position_m: &Vector1<f64>) -> f64 {
        let new = self.new.force(&history.new, position_m)[0];
        if history.is_settled() {
            return new;
        }
        let old = self.old.force(&history.old, position_m)[0];
        old * (1.0 - history.share) + new * history.share
    }

    /// Books the motion to this place, before the laws hear of it.
    #[inline]
    fn book(&self, history: &mut FadingHistory<E::History>, position_m: &Vector1<f64>) {
        let touch = history.touch;
        let moved = position_m[0] - touch.position_m;
        let wanted = if touch.changed || touch.sent_n == 0.0 {
            self.wanted(history, position_m)
        } else {
            f64::NAN
        };
        if wanted == 0.0 {
            // Out of contact: of both laws, since both push or are zero. So the old one may go at once.
            history.touch = Touch::NONE;
            history.share = 1.0;
        } else {
            history.touch.taken_j -= touch.sent_n * moved;
            history.touch.factor = touch.factor(wanted, position_m[0], self.step);
        }
        history.touch.position_m = position_m[0];
    }
}

impl<H> FadingHistory<H> {
    /// True if one law is felt alone.
    pub(crate) const fn is_settled(&self) -> bool {
        self.share >= 1.0
    }

    /// The force of this tick after all limits, N: what the books are kept of.
    pub(crate) const fn sent(&mut self, force_n: f64) {
        self.touch.sent_n = force_n;
    }
}

impl<E: Environment<f64, 1>> Environment<f64, 1> for Fading<E> {
    type History = FadingHistory<E::History>;

    fn at_rest(&self) -> Self::History {
        FadingHistory {
            old: self.old.at_rest(),
            new: self.new.at_rest(),
            share: 1.0,
            touch: Touch::NONE,
        }
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &Vector1<f64>) -> Vector1<f64> {
        let wanted = self.wanted(history, position_m);
        Vector1::new(wanted * history.touch.factor(wanted, position_m[0], self.step))
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &Vector1<f64>) {
        self.book(history, position_m);
        self.new.advance(&mut history.new, position_m);
        if !history.is_settled() {
            self.old.advance(&mut history.old, position_m);
            history.share = f64::min(history.share + self.step, 1.0);
        }
    }
}
