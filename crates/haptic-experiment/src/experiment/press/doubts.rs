//! Doubts about the force of a device: by its file, and by friction while its handle sticks.

use haptic_document::{
    Interval,
    parameters::{DAMPING, FRICTION, MASS, Parameter},
};
use haptic_loop::plant::MassDamperConfig;
use std::ops::Range;

/// Deviations from end to end of a 95 % interval.
const WIDTH: f64 = 3.92;

/// Deviations that the file of a device leaves open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub mass_kg: f64,
    pub damping_n_s_per_m: f64,
    pub friction_n: f64,
}

impl Open {
    /// Deviations by those intervals in which the device lies: whoever gives another value does not mean the device of the file.
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
/// Fewest samples of a handle that sticks.
const STICKS: usize = 10;
/// Time after which a handle sticks for long, s, and distance of what is compared in the logarithm of the time.
const STICKS_S: f64 = 0.01;
const PLACES: f64 = 0.6;
/// Deviations of a share of friction: of one that stays, and of one from −1 to 1, each as likely.
const STAYS: f64 = 1.0;
const HELD: f64 = 0.577_350_269_189_625_8;

/// Distance by which a handle has to go back whose position is read with this deviation, m.
pub(super) fn back_m(deviation_m: f64) -> f64 {
    STEADY_M + STEADY * deviation_m
}

/// Share of its friction with which a handle slid at each place, 1 or −1, and from one to the other evenly while it turns; and the samples in which
/// nobody sees how it slides: it turns, or stays within the distance by which it would have to go back.
pub(super) fn slides(places_m: &[f64], back_m: f64) -> (Vec<f64>, Vec<Range<usize>>) {
    let (mut shares, mut unseen) = (vec![1.0; places_m.len()], Vec::new());
    let (mut way, mut farthest) = (1.0, 0);
    let (mut since, mut ends_m) = (0, [f64::INFINITY, f64::NEG_INFINITY]);
    let mut stays = |some: Range<usize>| {
        // It begins at rest.
        if some.len() >= STICKS || some.start == 0 {
            unseen.push(some);
        }
    };
    let mut turns = Vec::new();
    for (n, &place_m) in places_m.iter().enumerate() {
        let beyond_m = way * (place_m - places_m[farthest]);
        if beyond_m > 0.5 * back_m {
            farthest = n;
        } else if beyond_m < 0.0 - back_m {
            let count = (n - farthest) as f64;
            for (k, share) in shares[farthest..n].iter_mut().enumerate() {
                *share = way * (1.0 - 2.0 * k as f64 / count);
            }
            turns.push(farthest..n);
            (way, farthest) = (0.0 - way, n);
        }
        shares[n] = way;
        ends_m = [ends_m[0].min(place_m), ends_m[1].max(place_m)];
        if ends_m[1] - ends_m[0] > back_m {
            stays(since..n);
            (since, ends_m) = (n, [place_m; 2]);
        }
    }
    stays(since..places_m.len());
    unseen.extend(turns);
    (shares, unseen)
}

/// Samples in which the force of a motor is known, and what friction may do in them, N: any share of its size where nobody sees how the handle slides,
/// of which few are compared, evenly in the logarithm of the time.
pub(super) fn known(
    time_s: &[f64],
    unseen: &[Range<usize>],
    friction_n: f64,
) -> (Vec<usize>, Vec<Vec<f64>>) {
    let (mut known, mut open) = (vec![true; time_s.len()], Vec::new());
    for some in unseen {
        known[some.clone()].fill(false);
    }
    for some in unseen {
        let mut stays = vec![0.0; time_s.len()];
        let mut next = 0.0;
        for n in some.clone() {
            let over = libm::log1p((time_s[n] - time_s[some.start]) / STICKS_S) / PLACES;
            if over >= next {
                (known[n], next) = (true, next + 1.0);
                stays[n] = STAYS * friction_n;
                let mut varies = vec![0.0; time_s.len()];
                varies[n] = HELD * friction_n;
                open.push(varies);
            }
        }
        open.push(stays);
    }
    let known = (0..known.len()).filter(|n| known[*n]).collect();
    (known, open)
}
