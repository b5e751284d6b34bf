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
//! A ← A − ½(f_before + f_sent)·Δx     from the first contact on, J
//! c = min(1, P·A / (|f|·d))           d m to the surface that is left last;   P = 4
//! ```
//!   A spring gives ½|f|·d on its way out, so a wall up to P/2 times as stiff is whole at once. At rest c moves with the fade and no
//!   faster; deeper in it comes back, by no more a tick than the fade moves; on the way out f falls as d^(P−1) at the steepest, so that A is
//!   spent at the surface and not before, whatever the law. A law that comes around a hand that has touched nothing has no energy: it
//!   resists what goes deeper, and d counts from where that began. In front of the surface A begins anew, and a change is done. Without a
//!   change c is 1, to the bit.
//! - *A touch that had less* than P·A₀ = |f₀|·d₀ when its law changed comes down to that in the time of the fade: instead of P
//! ```text
//! L = P + (1 − s)·min(F·d/A, P·(ℓ − 1))     ℓ = |f₀|·d₀/(P·A₀),  F = |f₀|·(1 − 1/ℓ)
//! ```
//!   At rest |f| = P·A/d + (1 − s)·F, so it falls by F/n a tick of n, and by no more however much energy comes meanwhile. On the way out
//!   f falls as d^(L−1) at the steepest.

use crate::in_hand::{hand::START_M, place::Surfaced};
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
    asked: Option<Asked>,
}

/// P: 2 would leave each stiffer wall as soft as the one before, until the next touch.
const STEEPEST: f64 = 4.0;

/// Least d, m: without energy a force stays zero where nobody moves.
const LEAST_M: f64 = 1e-8;

/// A touch that had next to nothing keeps its force no longer than it stands still.
const LENT_MOST: f64 = 1e6;

/// Forces of a tick after a change, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Force of the law that was asked for, alone.
    pub new_n: f64,
    /// Force of both laws, before the energy of the touch reduces it.
    pub mixed_n: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Touch {
    /// Energy that it has taken, J.
    taken_j: f64,
    /// The force that was sent last, N, and where.
    sent_n: f64,
    position_m: f64,
    /// The surface that is left last, m, or where the energy began if the law came around a hand; `None` without a change.
    exit_m: Option<f64>,
    /// ℓ, and F, N.
    lent: f64,
    lent_n: f64,
    /// The newest c.
    factor: f64,
}

impl Touch {
    const NONE: Self = Self {
        taken_j: 0.0,
        sent_n: 0.0,
        position_m: 0.0,
        exit_m: None,
        lent: 1.0,
        lent_n: 0.0,
        factor: 1.0,
    };

    /// c of a force that the laws want at this place, N; of the fade this share is done, and a tick is this step of it.
    #[inline]
    fn factor(&self, wanted_n: f64, position_m: f64, (share, step): (f64, f64)) -> f64 {
        let Some(exit_m) = self.exit_m.filter(|_| wanted_n != 0.0) else {
            return 1.0;
        };
        let moved = position_m - self.position_m;
        // The force acts on half of this way, and of the next.
        let left = f64::max(self.taken_j - 0.5 * self.sent_n * moved, 0.0);
        let depth_m = f64::max(position_m - exit_m, LEAST_M);
        let most = STEEPEST * (self.lent - 1.0);
        let lent = STEEPEST + (1.0 - share) * f64::min(self.lent_n * depth_m / left, most);
        let needed = wanted_n.abs() * depth_m + lent * wanted_n * moved;
        let most = f64::min(self.factor + step, 1.0);
        if most * needed > lent * left {
            lent * left / needed
        } else {
            most
        }
    }

    /// The law changes; of these surfaces, m, one is left last.
    fn change(&mut self, surfaces_m: [f64; 2]) {
        let [one, other] = surfaces_m;
        let begins_m = if self.taken_j > 0.0 {
            f64::NEG_INFINITY
        } else {
            self.position_m
        };
        let surface_m = self.exit_m.unwrap_or(f64::INFINITY).min(one).min(other);
        let exit_m = surface_m.max(begins_m);
        self.exit_m = Some(exit_m);
        // The force goes on from where it is.
        let held_j = self.sent_n.abs() * f64::max(self.position_m - exit_m, 0.0);
        let lent = held_j / (STEEPEST * f64::max(self.taken_j, f64::MIN_POSITIVE));
        self.lent = lent.clamp(1.0, LENT_MOST);
        self.lent_n = self.sent_n.abs() * (1.0 - 1.0 / self.lent);
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

impl<E: Environment<f64, 1> + Surfaced> Fading<E> {
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
        (history.touch).change([&self.old, &self.new].map(Surfaced::surface_m));
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
        self.asked(history, position_m).mixed_n
    }

    fn asked(&self, history: &FadingHistory<E::History>, position_m: &Vector1<f64>) -> Asked {
        let new_n = self.new.force(&history.new, position_m)[0];
        let mixed_n = if history.is_settled() {
            new_n
        } else {
            let old_n = self.old.force(&history.old, position_m)[0];
            old_n * (1.0 - history.share) + new_n * history.share
        };
        Asked { new_n, mixed_n }
    }

    /// Books the motion to this place and the force that was sent there, N, before the laws hear of it.
    #[inline]
    fn book(
        &self,
        history: &mut FadingHistory<E::History>,
        position_m: &Vector1<f64>,
        sent_n: f64,
    ) {
        let touch = history.touch;
        let at_m = position_m[0];
        let looks = touch.exit_m.is_some() || touch.sent_n == 0.0;
        let asked = looks.then(|| self.asked(history, position_m));
        let wanted_n = asked.map_or(sent_n, |asked| asked.mixed_n);
        history.touch.factor = touch.factor(wanted_n, at_m, (history.share, self.step));
        history.touch.taken_j -= 0.5 * (touch.sent_n + sent_n) * (at_m - touch.position_m);
        history.touch.sent_n = sent_n;
        if asked.is_some_and(|asked| asked.mixed_n == 0.0 && asked.new_n == 0.0) {
            // No law acts, since all push or are zero: so the old one may go at once. Where the fade begins, only the old one is mixed.
            history.share = 1.0;
            if at_m <= self.new.surface_m() {
                history.touch = Touch::NONE;
            }
        }
        let is_spent = history.touch.taken_j <= 0.0;
        let exit_m = |exit_m: f64| if is_spent { at_m } else { exit_m.min(at_m) };
        history.touch.exit_m = history.touch.exit_m.map(exit_m);
        history.touch.position_m = at_m;
        history.asked = asked.filter(|_| history.touch.exit_m.is_some());
    }
}

impl<H> FadingHistory<H> {
    /// True if one law alone is felt.
    pub const fn is_settled(&self) -> bool {
        self.share >= 1.0
    }

    /// Forces of the tick that was heard last; `None` where the law alone is felt, and is whole.
    pub const fn asked(&self) -> Option<Asked> {
        self.asked
    }
}

impl<E: Environment<f64, 1> + Surfaced> Environment<f64, 1> for Fading<E> {
    type History = FadingHistory<E::History>;

    fn at_rest(&self) -> Self::History {
        FadingHistory {
            old: standing(&self.old, START_M),
            new: standing(&self.new, START_M),
            share: 1.0,
            touch: Touch::NONE,
            asked: None,
        }
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &Vector1<f64>) -> Vector1<f64> {
        let wanted = self.wanted(history, position_m);
        let factor = (history.touch).factor(wanted, position_m[0], (history.share, self.step));
        Vector1::new(wanted * factor)
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &Vector1<f64>) {
        let force_n = self.force(history, position_m);
        self.advance_applied(history, position_m, &force_n);
    }

    #[inline]
    fn advance_applied(
        &self,
        history: &mut Self::History,
        position_m: &Vector1<f64>,
        applied_n: &Vector1<f64>,
    ) {
        self.book(history, position_m, applied_n[0]);
        self.new.advance(&mut history.new, position_m);
        if !history.is_settled() {
            self.old.advance(&mut history.old, position_m);
            history.share = f64::min(history.share + self.step, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::in_hand::{fading::*, place::Placed};
    use fracdiff::{Operator, Order, Scheme, Seconds};
    use haptic_loop::{
        Controller, Pushing, SafetyChain, Wall,
        plant::{MassDamper, MassDamperConfig},
        units::{
            Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond,
        },
    };
    use testkit::Random;

    type Felt = Placed<Pushing<Wall<f64, Operator<f64>>>>;

    fn placed(order: f64, stiffness: f64, dissipation: f64, surface_m: f64) -> Felt {
        let scheme: Scheme = "full".parse().expect("a scheme");
        let order = Order::new(order).expect("valid");
        let operator = scheme.build(order, Seconds(1e-3), 1e4).expect("made");
        let wall = Wall::new(stiffness, dissipation, operator, Some(Metres(0.0)));
        Placed::new(Pushing::new(wall.expect("valid"), false), surface_m)
    }

    fn tissue(order: f64, stiffness: f64, dissipation: f64) -> Felt {
        placed(order, stiffness, dissipation, 0.0)
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
    fn a_wall_that_comes_where_the_one_before_has_let_go_comes_by_the_fade() {
        // A spring-pot alone pushes no more once it is left, still behind its surface.
        let laws = [tissue(0.5, 0.0, 20.0), tissue(1.0, 300.0, 0.0)];
        let part = |n: u32, from: f64, long: f64| ((f64::from(n) - from) / long).clamp(0.0, 1.0);
        let motion = |n| 4e-3 * part(n, 0.0, 300.0) - 1.5e-3 * part(n, 600.0, 100.0);
        let (_, forces) = given((&laws, 100), &[720], motion, 1000);
        assert_eq!(forces[710..721], [0.0; 11]);
        let steps = forces[719..].windows(2).map(|pair| pair[0] - pair[1]);
        assert!(steps.fold(0.0, f64::max) < 1.1 * 300.0 * 2.5e-3 / 100.0);
        assert!(forces[999] < -0.5, "{}", forces[999]);
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

    /// Forces of a tick in a hand, N, and its place, m.
    struct Tick {
        at_m: f64,
        sent_n: f64,
        asked: Option<Asked>,
        alone_n: [f64; 2],
    }

    /// A law that becomes another at tick 1000 in a hand of this stiffness, N/m, which presses to the first place, m, moves to the
    /// second at tick 900, holds, and leaves from tick 2500 on at a speed, m/s.
    fn in_a_hand(laws: [&Felt; 2], stiffness: f64, deep_m: [f64; 2], speed: f64) -> Vec<Tick> {
        const T: Seconds = Seconds(1e-3);
        let hand = MassDamperConfig {
            stiffness: NewtonsPerMetre(stiffness),
            ..MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(10.0), T)
        };
        let mut device = MassDamper::<1>::new(hand).expect("valid");
        device.set_state(Vector1::new(START_M), Vector1::new(0.0));
        let chain = SafetyChain::new(Newtons(50.0), NewtonsPerSecond(1e6), T).expect("valid");
        let fading = Fading::new(laws[0].clone(), 200);
        let mut controller = Controller::<_, 1, _>::new(fading, chain);
        let mut alone = laws.map(|law| Law::at_rest(law.clone()));
        (0..3500)
            .map(|n| {
                let t = f64::from(n) * 1e-3;
                let [first_m, then_m] = deep_m;
                let moved_m = (then_m - first_m) * (20.0 * (t - 0.9)).clamp(0.0, 1.0);
                let held_m = (START_M + 0.1 * t).min(first_m) + moved_m;
                let place_m = (held_m - speed * (t - 2.5).max(0.0)).max(START_M);
                device.set_external_force(Vector1::new(stiffness * place_m));
                if n == 1000 {
                    let (environment, history) = controller.law_mut();
                    environment.change(history, &mut alone[1].clone());
                }
                let mut engaged = controller.engage(&mut device);
                let Ok(sample) = engaged.tick();
                std::mem::forget(engaged);
                let x = sample.reading.position_m;
                let alone_n = alone.each_mut().map(|law| {
                    let force_n = law.environment.force(&law.history, &x)[0];
                    law.hear(x[0]);
                    force_n
                });
                Tick {
                    at_m: x[0],
                    sent_n: sample.force.newtons()[0],
                    asked: controller.law_mut().1.asked(),
                    alone_n,
                }
            })
            .collect()
    }

    /// Pairs of 40 laws. `CAMPAIGN_CASES` sets how many, 20 by default; the campaign has 200.
    #[test]
    fn a_change_in_a_hand_is_no_step_and_the_wall_is_reached_or_it_is_known_that_it_is_not() {
        let mut random = Random(86);
        let laws = [(); 40].map(|()| {
            let (order, stiffness) = (random.share(), random.between(30.0, 600.0));
            let dissipation = random.between(0.0, 15.0);
            placed(order, stiffness, dissipation, random.between(-5e-4, 5e-4))
        });
        let mut reached = 0;
        let pairs = testkit::cases(20_u32);
        for case in 0..pairs {
            let pair = [(); 2].map(|()| &laws[(random.share() * 40.0) as usize]);
            let (deep_m, speed) = (random.between(1e-3, 1e-2), random.between(5e-3, 0.3));
            let then_m = deep_m * if random.chance(0.3) { 0.3 } else { 1.0 };
            for stiffness in [100.0, 1500.0] {
                let ticks = in_a_hand(pair, stiffness, [deep_m, then_m], speed);
                let exit_m = pair[0].surface_m().min(pair[1].surface_m());
                let mut taken_j = 0.0;
                for (n, two) in ticks.windows(2).enumerate() {
                    let (before, now) = (&two[0], &two[1]);
                    let at = format!("case {case}, hand {stiffness} N/m, tick {}", n + 1);
                    let moved = now.at_m - before.at_m;
                    taken_j -= 0.5 * (before.sent_n + now.sent_n) * moved;
                    if now.sent_n == 0.0 && now.at_m <= exit_m {
                        taken_j = 0.0;
                    }
                    if n < 999 {
                        assert_eq!(now.sent_n.to_bits(), now.alone_n[0].to_bits(), "{at}");
                        continue;
                    }
                    assert!(taken_j > -1e-9, "{at}: {taken_j:e} J");
                    // The laws' own steps by that motion, and a 200th of s and c; on the way out a force that falls as d³ falls
                    // three times as fast as one that falls as d.
                    let [a, b] = [0, 1].map(|law| (now.alone_n[law] - before.alone_n[law]).abs());
                    let apart_n = (now.alone_n[0] - now.alone_n[1]).abs();
                    let own = a.max(b) + (apart_n + before.sent_n.abs()) / 200.0;
                    let steep = before.sent_n.abs() * moved.abs() / (before.at_m - exit_m);
                    let most = own + 1e-9 + if n < 2500 { 1.0 } else { 3.0 } * steep;
                    let step = (now.sent_n - before.sent_n).abs();
                    assert!(step < most || steep < 0.0, "{at}: {step} N, not {most}");
                }
                let after = &ticks[1500];
                if (after.sent_n - after.alone_n[1]).abs() < 1e-8 {
                    reached += 1;
                } else {
                    let asked = after.asked.expect("known");
                    assert_eq!(asked.new_n.to_bits(), after.alone_n[1].to_bits());
                    assert!((asked.mixed_n - after.sent_n).abs() > 1e-9);
                }
            }
        }
        println!(
            "{reached} of {} asked laws reached, all others said",
            2 * pairs
        );
        assert!(reached > pairs);
    }

    #[test]
    fn a_wall_that_comes_around_a_hand_resists_what_goes_deeper_and_pushes_nobody_out() {
        let laws = [20e-3, 0.0].map(|surface_m| placed(0.5, 300.0, 2.0, surface_m));
        // To 4 mm, to 5 mm, back to 4 mm and out.
        let motion = |n: u32| {
            let t = f64::from(n) * 1e-3;
            let part = |from: f64, long: f64| ((t - from) / long).clamp(0.0, 1.0);
            4.0e-3 * part(0.0, 0.3) + 1e-3 * (part(1.0, 0.2) - part(1.6, 0.2))
                - 4.1e-3 * part(2.0, 0.3)
        };
        let (touches, forces) = given((&laws, 200), &[700], motion, 2500);
        assert!(touches.iter().all(|touch| *touch < 1e-9), "{touches:?}");
        let alone = given((&laws[1..], 200), &[], motion, 2500).1;
        let share = |n: usize| forces[n] / alone[n];
        assert!(share(999).abs() < 1e-12 && share(1199) > 0.9 && share(1900) < 1e-2);
        let step = |n: usize| (forces[n] - forces[n - 1]).abs();
        let largest = (701..2500).map(step).fold(0.0, f64::max);
        // f falls as d³ from where 2·d² is δ²: 3·√2/δ.
        assert!(
            largest < 4.3 * 5e-6 * alone[1199].abs() / 1e-3,
            "{largest} N"
        );
    }

    #[test]
    fn a_force_that_had_no_energy_goes_with_the_fade_though_much_more_comes_meanwhile() {
        let laws = [tissue(0.5, 100.0, 0.0), placed(0.5, 500.0, 0.0, -5e-4)];
        let part = |n: u32, from: f64, long: f64| ((f64::from(n) - from) / long).clamp(0.0, 1.0);
        // Just touched when the law changes: ℓ = 5.5. Then deep, a part of the way back, and still.
        let motion = |n| {
            5e-5 * part(n, 0.0, 100.0) + 2.5e-3 * part(n, 100.0, 40.0)
                - 1e-3 * part(n, 140.0, 100.0)
        };
        let (_, forces) = given((&laws, 200), &[101], motion, 400);
        assert!(forces[399] < -0.2, "{}", forces[399]);
        let falls = forces[240..].windows(2).map(|pair| pair[1] - pair[0]);
        let (largest, lent_n) = (falls.fold(0.0, f64::max), 5e-3 * (1.0 - 1.0 / 5.5));
        assert!((largest - lent_n / 200.0).abs() < 1e-9, "{largest} N");
    }

    #[test]
    fn a_force_that_the_energy_took_comes_back_with_the_fade() {
        let spent = Touch {
            exit_m: Some(0.0),
            lent: LENT_MOST,
            lent_n: 1.0,
            position_m: 1e-3,
            factor: 0.0,
            ..Touch::NONE
        };
        // Inwards it takes energy in any case.
        assert!((spent.factor(-1.0, 1.001e-3, (0.0, 0.005)) - 0.005).abs() < 1e-15);
        assert!(spent.factor(-1.0, 0.999e-3, (0.0, 0.005)).abs() < 1e-15);
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
