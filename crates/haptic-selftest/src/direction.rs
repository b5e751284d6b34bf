//! The direction in which a device moves under its force: with the encoder or the motor the wrong way round every spring pushes away.
//!
//! ```text
//! W[n] = Σ_{k<n} ½·(f[k] + f[k+1])·(x[k+1] − x[k])
//! ```
//! Whatever hangs on the motor, if it starts at rest and nobody moves it, takes energy before it gives any back: W ≥ 0. A device that
//! counts the wrong way shows −W. So the first motion decides; later ones add what the sensor's delay removes.
//!
//! - *Symbols*: f the force of a tick, N; x its position, m; W the work, J, shown as W over the largest force, m.
//! - *Not judged*: W over the largest force stays below 16 counts of the sensor, as where friction or a hand holds it, or a wire is off.

use super::bench::{Bench, Broken};
use super::promise::{AXES, Check, Promise};
use super::trial::Followed;
use haptic_document::parameters::FORCE_LIMIT;
use haptic_link::{AXES_MAX, Capabilities, Limits};
use haptic_loop::Limiters;
use haptic_remote::Tick;
use std::time::Duration;

const OVER: u8 = Limiters::STOPPING.bits() | Limiters::FAULT.bits();
/// Force above the friction of most slides, which two fingers hold, N: by little, as a host that is late lets it act for longer.
const FIRST_TIME_N: f64 = 0.4;
/// Counts, and their size where the sensor has none, m.
const LEAST_COUNTS: f64 = 16.0;
const COUNT_M: f64 = 1e-6;

/// Waits until it is at rest, 2 s at most: what coasts gives energy. Whether it is.
pub(super) fn at_rest(bench: &mut Bench<'_>) -> Result<bool, Broken> {
    let most_m = 2.0 * count_m(bench.link()?.capabilities().position_resolution_m);
    for _ in 0..40 {
        let samples = bench.listen(Duration::from_millis(50))?.samples;
        if samples.len() < 2 {
            continue;
        }
        let places = samples.iter().map(|tick| f64::from(tick.position_m[0]));
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = places.fold(ends, |(low, high), x| (x.min(low), x.max(high)));
        if high - low <= most_m {
            return Ok(true);
        }
    }
    Ok(false)
}

fn count_m(resolution_m: f32) -> f64 {
    f64::from(resolution_m).max(COUNT_M)
}

/// The row of a run whose force changed its sign along this axis, if it began at rest.
pub(super) fn judge(
    followed: &Followed,
    limits: &Limits,
    can: &Capabilities,
    axis: usize,
    at_rest: bool,
) -> Check {
    let enough_m = LEAST_COUNTS * count_m(can.position_resolution_m);
    let works_m = works_m(followed, limits, enough_m);
    let with_m = works_m[axis];
    // A motor that pushes x and moves y is wired or named the wrong way round.
    let farthest = (0..AXES_MAX)
        .rev()
        .max_by(|a, b| works_m[*a].abs().total_cmp(&works_m[*b].abs()));
    let moved = farthest.unwrap_or(axis);
    let promised = "it moves with its force, not against it";
    let check = |seen: &str, ok| Check::judged(Promise::Direction, promised, seen, ok);
    // A wire may be off.
    let unknown = |seen: &str| Check::not_judged(Promise::Direction, promised, seen);
    let verdict = if !at_rest {
        unknown("it moved already: hold it still, then let go")
    } else if works_m[moved].abs() < enough_m {
        unknown(&format!(
            "it hardly moved under {} N, which tells nothing: look at the encoder's wires, let it move freely, or give more than its \
             friction, as {FIRST_TIME_N} N of {FORCE_LIMIT}",
            limits.force_n
        ))
    } else if moved != axis {
        let sense = if works_m[moved] > 0.0 {
            "with"
        } else {
            "against"
        };
        let seen = format!(
            "a force along it moves {} {:.2} mm, {sense} the force: these axes are swapped, exchange them where positions or forces are converted",
            AXES[moved],
            1e3 * works_m[moved].abs()
        );
        check(&seen, Some(false))
    } else if with_m > 0.0 {
        let seen = format!("{:.2} mm with its force", 1e3 * with_m);
        check(&seen, Some(true))
    } else {
        let remedy = match can.axes {
            1 => "swap the encoder's channels or the motor's leads",
            _ => "turn the sign of this axis where positions or forces are converted",
        };
        let seen = format!(
            "{:.2} mm against its force: try again with your hand away, then {remedy}",
            -1e3 * with_m
        );
        check(&seen, Some(false))
    };
    verdict.figure("moved_with_force_m", with_m)
}

/// W of the force on one axis with the motion of each, over the largest force, m, up to where one is large enough.
fn works_m(followed: &Followed, limits: &Limits, enough_m: f64) -> [f64; AXES_MAX] {
    let fault = followed.fault_tick().unwrap_or(u32::MAX);
    let running = (followed.samples.iter().zip(&followed.places_m))
        .take_while(|(tick, _)| tick.tick < fault && tick.limiters & OVER == 0);
    let running: Vec<(&Tick, &[f32; AXES_MAX])> = running.collect();
    let mut works_m = [0.0_f64; AXES_MAX];
    for pair in running.windows(2) {
        let [(before, from), (after, to)] = [pair[0], pair[1]];
        let mean = f64::from(before.force_n[0]).midpoint(after.force_n[0].into());
        for (axis, work_m) in works_m.iter_mut().enumerate() {
            let moved_m = f64::from(to[axis]) - f64::from(from[axis]);
            *work_m += mean * moved_m / f64::from(limits.force_n);
        }
        if works_m.iter().any(|work_m| work_m.abs() >= enough_m) {
            break;
        }
    }
    works_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_remote::{Hardware as _, SimulatedPlant};

    fn device() -> Capabilities {
        Capabilities {
            position_resolution_m: 1e-5,
            ..SimulatedPlant::new("test", || 0).capabilities()
        }
    }

    /// A mass, kg, in damping, N·s/m, on a spring, N/m, under ±0.1 N, the sign changed every 40 ticks of 1 ms; its counts of 10 µm.
    fn run(mass: f64, damping: f64, spring: f64, count: f64) -> Followed {
        let (mut x, mut v) = (0.0_f64, 0.0);
        let tick = |tick: u32| {
            let force: f64 = if (tick / 40).is_multiple_of(2) {
                0.1
            } else {
                -0.1
            };
            let sample = Tick {
                tick,
                position_m: [((x / 1e-5_f64).round() * count) as f32],
                force_n: [force as f32],
                ..Tick::NONE
            };
            for _ in 0..100 {
                v += 1e-5 * (force - damping * v - spring * x) / mass;
                x += 1e-5 * v;
            }
            sample
        };
        of_x((0..330).map(tick).collect())
    }

    fn of_x(samples: Vec<Tick>) -> Followed {
        let places = samples.iter().map(|tick| [tick.position_m[0], 0.0, 0.0]);
        Followed {
            places_m: places.collect(),
            samples,
            ..Followed::default()
        }
    }

    const LIMITS: Limits = Limits {
        force_n: 0.1,
        ..Limits::DEFAULT
    };

    #[test]
    fn a_device_that_counts_the_wrong_way_is_seen_whatever_hangs_on_it() {
        // Almost free, damped, held by a soft finger.
        for (mass, damping, spring) in [(0.065, 0.05, 0.0), (0.065, 3.5, 0.0), (0.1, 2.0, 100.0)] {
            for (count, ok) in [(1e-5, true), (-1e-5, false)] {
                let whole = run(mass, damping, spring, count);
                let mut kept = whole.samples.clone();
                kept.retain(|tick| tick.tick % 7 != 3);
                for followed in [whole, of_x(kept)] {
                    let row = judge(&followed, &LIMITS, &device(), 0, true);
                    assert_eq!(row.ok, Some(ok), "{mass} kg, {spring} N/m: {row:?}");
                }
            }
        }
    }

    #[test]
    fn of_several_axes_one_that_is_mirrored_or_swapped_is_named() {
        let can = Capabilities {
            axes: 3,
            ..device()
        };
        let moved = run(0.065, 0.05, 0.0, 1e-5);
        let verdict = |moves: usize, sign: f32| {
            let mut followed = moved.clone();
            for place in &mut followed.places_m {
                let moved = core::mem::take(&mut place[0]);
                place[moves] = sign * moved;
                // The others tremble.
                place[(moves + 1) % 3] = 0.1 * moved;
            }
            judge(&followed, &LIMITS, &can, 1, true)
        };
        assert_eq!(verdict(1, 1.0).ok, Some(true));
        let with = "moves x 0.17 mm, with the force: these axes are swapped";
        let against = "moves z 0.17 mm, against the force: these axes are swapped";
        for (moves, sign, words) in [
            (1, -1.0, "turn the sign of this axis"),
            (0, 1.0, with),
            (2, -1.0, against),
        ] {
            let row = verdict(moves, sign);
            assert!(row.ok == Some(false) && row.seen.contains(words), "{row:?}");
        }
    }

    #[test]
    fn of_one_that_does_not_move_nothing_is_claimed() {
        let held = run(0.065, 3.5, 1e5, 1e-5);
        for (at_rest, words) in [(true, "hardly moved under 0.1 N"), (false, "moved already")] {
            let row = judge(&held, &LIMITS, &device(), 0, at_rest);
            assert_eq!((row.ok, row.not_judged), (None, true), "{row:?}");
            assert!(row.seen.contains(words), "{row:?}");
        }
    }
}
