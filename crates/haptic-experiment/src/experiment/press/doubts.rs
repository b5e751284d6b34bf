//! What a device leaves open of the force that it makes: by its file, and by friction while its handle sticks.

use crate::document::parameters::{DAMPING, FRICTION, MASS, Parameter};
use crate::document::reader::Interval;
use haptic_loop::plant::MassDamperConfig;
use std::ops::Range;

/// Deviations from end to end of a 95 % interval.
const WIDTH: f64 = 3.92;

/// What the file of a device leaves open of it, as deviations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub mass_kg: f64,
    pub damping_n_s_per_m: f64,
    pub friction_n: f64,
}

impl Open {
    /// By those intervals in which the device lies: whoever gives another value does not mean the device of the file.
    pub(super) fn of(device: &MassDamperConfig, intervals: &[Interval]) -> Self {
        let open = |parameter: Parameter, value: f64| {
            let mut found = intervals.iter().filter(|ends| ends.key == parameter.key);
            let found = found.find(|ends| (ends.low..=ends.high).contains(&value));
            found.map_or(0.0, |ends| (ends.high - ends.low) / WIDTH)
        };
        Self {
            mass_kg: open(MASS, device.mass.0),
            damping_n_s_per_m: open(DAMPING, device.damping.0),
            friction_n: open(FRICTION, device.friction.0),
        }
    }
}

/// Distance by which a handle has to go back to slide the other way, m, and in deviations of what is read of it.
const STEADY_M: f64 = 1e-7;
const STEADY: f64 = 8.0;
/// Fewest samples of a handle that sticks, and most such times, of which the longest count.
const STICKS: usize = 30;
const TIMES_MOST: usize = 8;
/// Time after which a handle sticks for long, s.
pub(super) const STICKS_S: f64 = 0.01;

/// Distance by which a handle has to go back whose position is read with this deviation, m.
pub(super) fn back_m(deviation_m: f64) -> f64 {
    STEADY_M + STEADY * deviation_m
}

/// Share of its friction with which a handle slid at each place, 1 or −1; from one to the other evenly while it sticks, and the samples in which
/// it does. A handle sticks from where it was farthest, within
/// half of that, until it is back by so much.
pub(super) fn slides(places_m: &[f64], back_m: f64) -> (Vec<f64>, Vec<Range<usize>>) {
    let (mut shares, mut stuck) = (vec![1.0; places_m.len()], Vec::new());
    let (mut way, mut farthest) = (1.0, 0);
    for n in 0..places_m.len() {
        let beyond_m = way * (places_m[n] - places_m[farthest]);
        if beyond_m > 0.5 * back_m {
            farthest = n;
        } else if beyond_m < 0.0 - back_m {
            let count = (n - farthest) as f64;
            for (k, share) in shares[farthest..n].iter_mut().enumerate() {
                *share = way * (1.0 - 2.0 * k as f64 / count);
            }
            stuck.push(farthest..n);
            (way, farthest) = (0.0 - way, n);
        }
        shares[n] = way;
    }
    stuck.push(farthest..places_m.len());
    stuck.retain(|some| some.len() >= STICKS);
    stuck.sort_by_key(|some| places_m.len() - some.len());
    stuck.truncate(TIMES_MOST);
    (shares, stuck)
}
