//! The order of trials on a real device: from soft walls up, one wall after another.
//!
//! A wall that is too stiff throws the device beyond a limit, so few of them are tried: stiffness and dissipation double until a wall
//! does not come to rest, and then the interval is halved. With [`CLOSER`] and [`HALVINGS`] a device that has stable walls is not taken
//! beyond its limits [`TRIPS_IN_A_ROW`](crate::zwidth::rig::TRIPS_IN_A_ROW) times in a row on the way.

use crate::bench::last;
use serde::{Deserialize, Serialize};

/// Doublings from the softest wall to the stiffest: 3e-4 of it.
const DOUBLINGS: i32 = 14;
/// Stride of the dissipations tried while no wall at all has come to rest.
const STRIDE: usize = 4;
/// Halvings of the interval of the stiffness: within 0.8 % of the value found.
const CLOSER: u32 = 7;
/// Halvings of the interval of the largest dissipation, two walls each: within 0.4 %.
const HALVINGS: u32 = 8;

/// Dissipations β with a stiffness α that came to rest with each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Settled(Vec<(f64, f64)>);

/// Values from the softest to the stiffest, each twice the one before.
fn doubling(most: f64) -> impl Iterator<Item = f64> {
    (0..=DOUBLINGS)
        .rev()
        .map(move |halved| most * libm::pow(0.5, f64::from(halved)))
}

/// The largest α from one on that comes to rest.
pub(super) fn upward(mut low: f64, most: f64, rests: impl Fn(f64) -> bool) -> f64 {
    let mut high = low;
    while high < most {
        high = (2.0 * low).min(most);
        if !rests(high) {
            break;
        }
        low = high;
    }
    // Nothing is to be found between where both ends are the most.
    if low < most {
        last(low, high, CLOSER, rests)
    } else {
        low
    }
}

impl Settled {
    /// Walls that come to rest, for dissipations up to the largest with one; none if no wall does. `soft` is the softest α with a β that
    /// is there in time: where only soft walls are stable it is among them.
    pub(super) fn look(
        most: f64,
        soft: impl Fn(f64) -> f64,
        rests: impl Fn(f64, f64) -> bool,
    ) -> Self {
        let first = |beta| {
            let alpha = doubling(most).find(|&alpha| rests(alpha, beta))?;
            Some((beta, alpha))
        };
        let none_and_more = [0.0].into_iter().chain(doubling(most).step_by(STRIDE));
        let mut settled = Self(none_and_more.filter_map(first).take(1).collect());
        let Some(&(least, _)) = settled.0.first() else {
            return settled;
        };
        let mut above = most;
        for beta in doubling(most).filter(|&beta| beta > least) {
            let last = settled.last_stiffness(most);
            if !settled.add(beta, &[last, soft(beta), 2.0 * last], most, &rests) {
                above = beta;
                break;
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (settled.largest_dissipation().unwrap_or(least) + above);
            let last = settled.last_stiffness(most);
            if !settled.add(middle, &[last, soft(middle)], most, &rests) {
                above = middle;
            }
        }
        settled
    }

    /// The softest of scales of one law that comes to rest, at a β of 0.
    pub(super) fn softest(most: f64, rests: impl Fn(f64) -> bool) -> Self {
        let first = doubling(most).find(|&scale| rests(scale));
        Self(first.map(|scale| (0.0, scale)).into_iter().collect())
    }

    /// The largest β with a wall that came to rest.
    pub(super) fn largest_dissipation(&self) -> Option<f64> {
        self.0.last().map(|(beta, _)| *beta)
    }

    /// The largest α that comes to rest with a β below which there are some; `None` if none near those does.
    pub(super) fn largest(&self, beta: f64, most: f64, rests: impl Fn(f64) -> bool) -> Option<f64> {
        let near = |(other, _): &&(f64, f64)| (other - beta).abs();
        let (settled, alpha) = (self.0.iter()).min_by(|a, b| near(a).total_cmp(&near(b)))?;
        let starts = [1.0, 2.0, 0.5].map(|times| (times * alpha).min(most));
        let found = starts.into_iter().find(|&alpha| rests(alpha));
        // This very wall came to rest before, if only just.
        let low = found.or_else(|| (*settled >= beta).then_some(*alpha))?;
        Some(upward(low, most, rests))
    }

    /// The α that came to rest with the largest β.
    fn last_stiffness(&self, most: f64) -> f64 {
        self.0.last().map_or(most, |(_, alpha)| *alpha)
    }

    /// Tries a β with these stiffnesses; true if a wall came to rest, which is kept.
    fn add(
        &mut self,
        beta: f64,
        alphas: &[f64],
        most: f64,
        rests: impl Fn(f64, f64) -> bool,
    ) -> bool {
        let mut within = alphas.iter().map(|alpha| alpha.min(most));
        let found = within.find(|&alpha| rests(alpha, beta));
        self.0.extend(found.map(|alpha| (beta, alpha)));
        found.is_some()
    }
}

#[cfg(test)]
mod tests {
    use crate::zwidth::rig::TRIPS_IN_A_ROW;
    use crate::zwidth::upward::*;
    use std::cell::Cell;

    const MOST: f64 = 5.0;

    /// Walls below an edge that falls to zero at a largest dissipation, and how many in a row were not: most of all, and now.
    struct Device {
        damped_up_to: f64,
        edge: fn(f64) -> f64,
        row: Cell<usize>,
        longest: Cell<usize>,
        trials: Cell<usize>,
    }

    impl Device {
        fn rests(&self, alpha: f64, beta: f64) -> bool {
            let rests = beta <= self.damped_up_to && alpha <= (self.edge)(beta / self.damped_up_to);
            self.row.set(if rests { 0 } else { self.row.get() + 1 });
            self.longest.set(self.longest.get().max(self.row.get()));
            self.trials.set(self.trials.get() + 1);
            rests
        }
    }

    #[test]
    fn a_search_from_below_finds_the_edge_and_is_seldom_beyond_it() {
        let edges: [fn(f64) -> f64; 4] = [
            |beta| 0.1 + 0.5 * beta * (1.0 - beta),
            |beta| 1.1 - beta,
            |beta| 0.002 * (1.2 - beta),
            |beta| 1e-4 + 0.6 * (1.0 - beta),
        ];
        for damped_up_to in [0.003, 0.07, 0.6, 2.0, 4.9] {
            for edge in edges {
                let device = Device {
                    damped_up_to,
                    edge,
                    row: Cell::new(0),
                    longest: Cell::new(0),
                    trials: Cell::new(0),
                };
                let settled =
                    Settled::look(MOST, |_| 1e-4, |alpha, beta| device.rests(alpha, beta));
                let largest = settled.largest_dissipation().expect("some");
                assert!(
                    (0.99..=1.0).contains(&(largest / damped_up_to)),
                    "{damped_up_to}: {largest}"
                );
                for part in [0.0, 0.2, 0.5, 0.9, 1.0] {
                    let beta = part * largest;
                    let found = settled.largest(beta, MOST, |alpha| device.rests(alpha, beta));
                    let found = found.expect("a wall") / edge(beta / damped_up_to);
                    assert!((0.992..=1.0).contains(&found), "{part}: {found}");
                }
                assert!(device.longest.get() < TRIPS_IN_A_ROW, "{settled:?}");
                assert!(device.trials.get() < 150, "{}", device.trials.get());
            }
        }
    }

    #[test]
    fn a_device_without_a_wall_that_comes_to_rest_has_none() {
        let trials = Cell::new(0);
        let rests = |_, _| {
            trials.set(trials.get() + 1);
            false
        };
        let none = Settled::look(MOST, |_| 1e-4, rests);
        assert_eq!(none, Settled::default());
        assert_eq!(none.largest_dissipation(), None);
        assert!(trials.get() < 100, "{}", trials.get());
    }
}
