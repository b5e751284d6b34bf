//! An environment that changes while it runs, without a bump.
//!
//! ```text
//! f = (1 − s)·f_old + s·f_new        s from 0 to 1 in so many ticks
//! ```
//! Both laws hear the same motion meanwhile. Two walls that only push make one that only pushes.

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

/// Their histories, and the share of the new law.
#[derive(Clone, Debug)]
pub(crate) struct FadingHistory<H> {
    old: H,
    new: H,
    share: f64,
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
    }

    /// `next` is felt at once, and becomes the law that was.
    pub(crate) fn replace(&mut self, history: &mut FadingHistory<E::History>, next: &mut Law<E>) {
        mem::swap(&mut self.new, &mut next.environment);
        mem::swap(&mut history.new, &mut next.history);
        history.share = 1.0;
    }
}

impl<H> FadingHistory<H> {
    /// True if one law is felt alone.
    pub(crate) const fn is_settled(&self) -> bool {
        self.share >= 1.0
    }
}

impl<E: Environment<f64, 1>> Environment<f64, 1> for Fading<E> {
    type History = FadingHistory<E::History>;

    fn at_rest(&self) -> Self::History {
        FadingHistory {
            old: self.old.at_rest(),
            new: self.new.at_rest(),
            share: 1.0,
        }
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &Vector1<f64>) -> Vector1<f64> {
        let new = self.new.force(&history.new, position_m);
        if history.is_settled() {
            return new;
        }
        let old = self.old.force(&history.old, position_m);
        old * (1.0 - history.share) + new * history.share
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &Vector1<f64>) {
        self.new.advance(&mut history.new, position_m);
        if !history.is_settled() {
            self.old.advance(&mut history.old, position_m);
            history.share = f64::min(history.share + self.step, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::{Operator, Order, Scheme, Seconds};
    use haptic_loop::SpringDamper;

    type Damper = SpringDamper<f64, Operator<f64>>;

    fn law(order: f64, dissipation: f64) -> Damper {
        let scheme: Scheme = "full".parse().expect("a scheme");
        let order = Order::new(order).expect("valid");
        let operator = scheme.build(order, Seconds(1e-3), 1e4).expect("made");
        SpringDamper::new(100.0, dissipation, operator).expect("valid")
    }

    fn position(n: u32) -> Vector1<f64> {
        Vector1::new(1e-3 * (f64::from(n) / 300.0).sin().max(0.0))
    }

    /// Force of a law alone on the same motion.
    fn alone(law: &Damper, ticks: u32) -> Vec<f64> {
        let mut history: <Damper as Environment<f64, 1>>::History = law.at_rest();
        let tick = |n| {
            let x = position(n);
            let force = law.force(&history, &x)[0];
            law.advance(&mut history, &x);
            force
        };
        (0..ticks).map(tick).collect()
    }

    #[test]
    fn a_change_goes_from_the_old_force_to_the_new_without_a_bump() {
        let (old, new) = (law(0.3, 20.0), law(0.6, 5.0));
        let (of_old, of_new) = (alone(&old, 2000), alone(&new, 2000));
        let mut fading = Fading::new(old, 100);
        let mut history = fading.at_rest();
        let mut largest_step = 0.0_f64;
        let mut before = 0.0;
        for n in 0..2000_u32 {
            if n == 500 {
                let mut next = Law::at_rest(new.clone());
                for heard in 0..n {
                    next.hear(position(heard)[0]);
                }
                fading.change(&mut history, &mut next);
            }
            let x = position(n);
            let force = fading.force(&history, &x)[0];
            let share = (f64::from(n) - 500.0) / 100.0;
            let share = share.clamp(0.0, 1.0);
            let want = (1.0 - share) * of_old[n as usize] + share * of_new[n as usize];
            assert!((force - want).abs() < 1e-12, "tick {n}: {force} for {want}");
            if n > 490 {
                largest_step = largest_step.max((force - before).abs());
            }
            before = force;
            fading.advance(&mut history, &x);
        }
        // No larger than the two forces themselves change, and a hundredth of what lies between them.
        let apart = (of_old[500] - of_new[500]).abs();
        assert!(apart > 10.0 * largest_step, "{largest_step} of {apart}");
    }

    #[test]
    fn what_is_replaced_is_gone_at_once() {
        let (old, new) = (law(0.3, 20.0), law(0.6, 5.0));
        let mut fading = Fading::new(old.clone(), 100);
        let mut history = fading.at_rest();
        fading.advance(&mut history, &Vector1::new(1e-3));
        let mut next = Law::at_rest(new.clone());
        fading.replace(&mut history, &mut next);
        let fresh: <Damper as Environment<f64, 1>>::History = new.at_rest();
        let x = Vector1::new(2e-3);
        assert_eq!(fading.force(&history, &x), new.force(&fresh, &x));
        // The caller has the one that was.
        let force: Vector1<f64> = next.environment.force(&next.history, &Vector1::new(1e-3));
        let rested: Vector1<f64> = old.force(&old.at_rest(), &Vector1::new(1e-3));
        assert!(force[0] > rested[0], "it remembers 1 mm");
    }
}
