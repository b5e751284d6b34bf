//! An environment that changes while it runs, without a bump, and gives no energy by that.
//! ```text
//! f = (1 − s)·f_old + s·f_new        s from 0 to 1 in so many ticks
//! f ← c·f                            after a change, until the touch is over: see below
//! ```
//! Both laws hear the same motion meanwhile. Two walls that only push make one that only pushes.
//!
//! - *Energy*: a tissue that grows stiffer under a finger would push it back with more than the finger ever put in. So a touch
//!   in which the law changed never gives more than it took:
//! ```text
//! A ← A − f_sent·Δx from the first contact on;    outwards, f·Δx > 0:  c ← c·A/(N·f·Δx) where that is below c
//! ```
//!   Inwards c comes back, by as much a tick as s. Out of contact A and c begin anew, and a change is done. Without a change c is 1, to the bit.

use crate::in_hand::hand::START_M;
use haptic_loop::Environment;
use nalgebra::Vector1;
use std::mem;

/// A law that is felt, and the one that went before it as long as that goes.
#[derive(Clone, Debug)]
pub struct Fading<E> {
    old: E,
    new: E,
    /// Share of the new one that is added in a tick.
    step: f64,
}

/// Their histories, the share of the new law, and the energy of this touch.
#[derive(Clone, Debug)]
pub struct FadingHistory<H> {
    old: H,
    new: H,
    share: f64,
    touch: Touch,
}

/// N: a tick spends no more than 1/N of what the touch has taken.
const SPEND: f64 = 4.0;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Touch {
    /// Energy that it has taken, J.
    taken_j: f64,
    /// The force that was sent last, N, and where.
    sent_n: f64,
    position_m: f64,
    changed: bool,
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
        // The energy from the force that is held until now is known.
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
pub struct Law<E: Environment<f64, 1>> {
    /// The law, whose memory stands beside it.
    pub environment: E,
    /// All that it has heard.
    pub history: E::History,
    /// The first tick that it has not heard.
    pub next: u64,
}

/// A history of a device that always stood here, m.
fn standing<E: Environment<f64, 1>>(law: &E, position_m: f64) -> E::History {
    let mut history = law.at_rest();
    law.settle(&mut history, &Vector1::new(position_m));
    history
}

impl<E: Environment<f64, 1>> Law<E> {
    /// Law with a device in front of the surface, where a simulated one begins.
    pub fn at_rest(environment: E) -> Self {
        Self::standing(environment, START_M)
    }

    /// Law that has heard nothing, not even where the device stands.
    pub fn untouched(environment: E) -> Self {
        Self {
            history: environment.at_rest(),
            environment,
            next: 0,
        }
    }

    /// Law with a device that always stood here, m.
    pub fn standing(environment: E, position_m: f64) -> Self {
        let history = standing(&environment, position_m);
        Self {
            environment,
            history,
            next: 0,
        }
    }

    /// Takes the position of a tick.
    pub fn hear(&mut self, position_m: f64) {
        (self.environment).advance(&mut self.history, &Vector1::new(position_m));
        self.next += 1;
    }

    /// Hears the positions from a tick on, m; what was lost stands where the one before it was.
    pub fn hear_from(&mut self, tick: u64, positions_m: impl IntoIterator<Item = f64>) {
        self.next = tick;
        let mut before = 0.0;
        for position_m in positions_m {
            if !position_m.is_nan() {
                before = position_m;
            }
            self.hear(before);
        }
    }
}

impl<E: Environment<f64, 1>> Fading<E> {
    /// One law alone; a later one takes `ticks` to come.
    pub fn new(law: E, ticks: u32) -> Self
    where
        E: Clone,
    {
        Self {
            old: law.clone(),
            new: law,
            step: 1.0 / f64::from(ticks.max(1)),
        }
    }

    /// The law that is felt begins to go, `next` begins to come; `next` becomes the one that went before it, for the caller to
    /// drop elsewhere. Nothing is allocated.
    pub fn change(&mut self, history: &mut FadingHistory<E::History>, next: &mut Law<E>) {
        mem::swap(&mut self.old, &mut self.new);
        mem::swap(&mut history.old, &mut history.new);
        mem::swap(&mut self.new, &mut next.environment);
        mem::swap(&mut history.new, &mut next.history);
        history.share = 0.0;
        history.touch.changed = true;
    }

    /// `next` is felt at once, and becomes the law that was.
    pub fn replace(&mut self, history: &mut FadingHistory<E::History>, next: &mut Law<E>) {
        mem::swap(&mut self.new, &mut next.environment);
        mem::swap(&mut history.new, &mut next.history);
        history.share = 1.0;
        history.touch = Touch::NONE;
    }

    /// The force that the laws want here, N, whatever this touch has taken.
    pub fn wanted(&self, history: &FadingHistory<E::History>, position_m: &Vector1<f64>) -> f64 {
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
    /// True if one law alone is felt.
    pub const fn is_settled(&self) -> bool {
        self.share >= 1.0
    }

    /// The force of this tick after all limits, N: what the books are kept of.
    pub const fn sent(&mut self, force_n: f64) {
        self.touch.sent_n = force_n;
    }
}

impl<E: Environment<f64, 1>> Environment<f64, 1> for Fading<E> {
    type History = FadingHistory<E::History>;

    fn at_rest(&self) -> Self::History {
        FadingHistory {
            old: standing(&self.old, START_M),
            new: standing(&self.new, START_M),
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

#[cfg(test)]
mod tests {
    use crate::in_hand::fading::*;
    use fracdiff::{Operator, Order, Scheme, Seconds};
    use haptic_loop::{Contact, SpringDamper};
    use testkit::Random;

    type Felt = Contact<f64, SpringDamper<f64, Operator<f64>>, 1>;

    fn tissue(order: f64, stiffness: f64, dissipation: f64) -> Felt {
        let scheme: Scheme = "full".parse().expect("a scheme");
        let order = Order::new(order).expect("valid");
        let operator = scheme.build(order, Seconds(1e-3), 1e4).expect("made");
        let inner = SpringDamper::new(stiffness, dissipation, operator).expect("valid");
        Felt::at(haptic_loop::units::Metres(0.0), inner).expect("valid")
    }

    /// Energy that a law, changed at these ticks, has given in each touch of a motion, J; and the force at each tick. Of the
    /// law, not of the hold of its force, which the damping of a device pays for.
    fn given(
        (laws, fade): (&[Felt], u32),
        changes: &[u32],
        motion: impl Fn(u32) -> f64,
        ticks: u32,
    ) -> (Vec<f64>, Vec<f64>) {
        let mut fading = Fading::new(laws[0].clone(), fade);
        let mut history = fading.at_rest();
        let (mut touches, mut forces) = (vec![0.0], Vec::new());
        for n in 0..ticks {
            if let Some(change) = changes.iter().position(|&at| at == n) {
                let mut next = Law::at_rest(laws[change + 1].clone());
                (0..n).for_each(|heard| next.hear(motion(heard)));
                fading.change(&mut history, &mut next);
            }
            let x = Vector1::new(motion(n));
            let force = fading.force(&history, &x)[0];
            fading.advance(&mut history, &x);
            history.sent(force);
            if x[0] <= 0.0 {
                touches.push(0.0);
            }
            if let Some(touch) = touches.last_mut() {
                *touch += force * (motion(n) - motion(n.max(1) - 1));
            }
            forces.push(force);
        }
        (touches, forces)
    }

    #[test]
    fn a_change_goes_from_the_old_force_to_the_new_without_a_bump() {
        // Until the touch is nearly over: then it gives no more than it took.
        const END: u32 = 800;
        let motion = |n: u32| 1e-3 * (f64::from(n) / 300.0).sin();
        let laws = [tissue(0.3, 100.0, 20.0), tissue(0.6, 100.0, 5.0)];
        let forces = |laws: &[Felt], at: &[u32]| given((laws, 100), at, motion, END).1;
        let (old, new) = (forces(&laws[..1], &[]), forces(&laws[1..], &[]));
        let changed = forces(&laws, &[500]);
        for (n, force) in changed.iter().enumerate() {
            let share = ((n as f64 - 500.0) / 100.0).clamp(0.0, 1.0);
            let want = (1.0 - share) * old[n] + share * new[n];
            assert!((force - want).abs() < 1e-12, "tick {n}: {force} for {want}");
        }
        // No larger than the two forces themselves change, and a hundredth of what lies between them.
        let steps = changed[489..]
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs());
        let (largest, apart) = (steps.fold(0.0, f64::max), (old[500] - new[500]).abs());
        assert!(apart > 10.0 * largest, "{largest} of {apart}");
    }

    #[test]
    fn a_touch_in_which_the_law_grows_stiffer_gives_no_more_than_it_took() {
        let laws = [tissue(0.3, 100.0, 5.0), tissue(0.3, 1000.0, 50.0)];
        // Two touches to 5 mm: in 0.3 s, held for 1 s, back in 0.3 s.
        let motion = |n: u32| {
            let t = f64::from(n % 2000);
            5e-3 * (t / 300.0).min(1.0).min((1600.0 - t) / 300.0) - 1e-4
        };
        let (touches, forces) = given((&laws, 200), &[700], motion, 4000);
        let most = touches.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!(most < 1e-9, "{most:e} J given");
        // It is felt at once where nobody moves, and in the next touch as if it had always been.
        let alone = given((&laws[1..], 200), &[], motion, 4000).1;
        assert!((forces[1100] / alone[1100] - 1.0).abs() < 1e-12);
        for n in 2000..4000 {
            assert_eq!(forces[n].to_bits(), alone[n].to_bits(), "tick {n}");
        }
    }

    #[test]
    fn no_touch_gives_energy_whatever_changes_in_it() {
        let mut random = Random(1);
        for case in 0..40 {
            let laws = [(); 4].map(|()| {
                let (order, stiffness) = (random.share(), random.between(0.0, 1000.0));
                tissue(order, stiffness, random.between(1.0, 61.0))
            });
            let changes = [1, 2, 3].map(|n| 700 * n + random.between(0.0, 400.0) as u32);
            let size = random.between(0.0, 5e-3);
            let (slow, fast) = (random.between(100.0, 500.0), random.between(20.0, 60.0));
            let motion = |n: u32| {
                let n = f64::from(n);
                size * ((n / slow).sin() + 0.2 * (n / fast).sin())
            };
            let (touches, _) = given((&laws, 200), &changes, motion, 3000);
            for (n, touch) in touches.iter().enumerate() {
                assert!(*touch < 1e-6, "case {case}, touch {n}: {touch:e} J");
            }
        }
    }

    #[test]
    fn what_is_replaced_is_gone_at_once() {
        let (old, new) = (tissue(0.3, 100.0, 20.0), tissue(0.6, 100.0, 5.0));
        let mut fading = Fading::new(old.clone(), 100);
        let mut history = fading.at_rest();
        fading.advance(&mut history, &Vector1::new(1e-3));
        let mut next = Law::at_rest(new.clone());
        fading.replace(&mut history, &mut next);
        let x = Vector1::new(2e-3);
        assert_eq!(fading.force(&history, &x), new.force(&new.at_rest(), &x));
        // The caller has the one that was, which remembers.
        let x = Vector1::new(1e-3);
        let force = next.environment.force(&next.history, &x)[0];
        assert!(force > old.force(&old.at_rest(), &x)[0]);
    }
}
