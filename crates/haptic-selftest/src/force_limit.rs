//! Limits of force and rate, and the way to zero after a stop: one run.

use super::bench::{Bench, Broken, LONG_WATCHDOG_MS};
use super::direction;
use super::fall::{Bounds, Fall};
use super::promise::{Check, Promise};
use super::trial::{ASKED, Followed, LATE, Trial, alternating};
use haptic_loop::Limiters;
use haptic_remote::Tick;

const STOPPING: u8 = Limiters::STOPPING.bits();
/// Ticks at the full share of the force: some changes of its sign.
const TICKS: f64 = 300.0;
/// Rounding of a difference of two forces, relative to their limit.
const ROUNDING: f32 = 1e-5;

/// Each axis in turn; of limit and stop the row has the worst, of the direction each.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Vec<Check>, Broken> {
    bench.trying(Promise::ForceLimit)?;
    let (mut limits, mut stops, mut directions) = (Vec::new(), Vec::new(), Vec::new());
    for [limit, stop, direction] in bench.each_axis(of_axis)? {
        limits.push(limit);
        stops.push(stop);
        directions.push(direction);
    }
    let rows = [(limits, false), (stops, false), (directions, true)];
    let rows = rows.map(|(rows, all)| Check::of_axes(rows, all));
    Ok(rows.into_iter().flatten().collect())
}

fn of_axis(bench: &mut Bench<'_>) -> Result<[Check; 3], Broken> {
    let bounds = bench.bounds();
    let Bounds { limits, period_s } = bounds;
    let loosened = bench.loosen()?;
    let at_rest = direction::at_rest(bench)?;
    let ticks = (f64::from(limits.rise_time_s) / period_s + TICKS) as u32;
    let trial = Trial {
        watchdog_ms: LONG_WATCHDOG_MS,
        say: |sample: &Tick, sent| Some(alternating(&bounds, sample.tick, sent, ASKED)),
        // In the middle of a half period, so that a force acts when it is stopped.
        until: |followed: &Followed| {
            let newest = followed.samples.last();
            newest.is_some_and(|sample| {
                let half = bounds.half_period_ticks();
                sample.tick > ticks && (half / 2..3 * half / 4).contains(&(sample.tick % half))
            })
        },
    };
    let promised = format!(
        "at most {} N and {} N/s, whatever is asked for; a run cannot loosen it",
        limits.force_n, limits.force_rate_n_per_s
    );
    let zero = format!(
        "zero within {} s, {}",
        limits.stop_time_s,
        bounds.fall_in_words()
    );
    let followed = match bench.conduct(&trial, LATE)? {
        Ok(followed) => followed,
        Err(refused) => {
            let seen = refused.to_string();
            return Ok([
                Check::judged(Promise::ForceLimit, promised, seen, false),
                Check::not_judged(Promise::Stop, zero, "not reached"),
                Check::not_judged(Promise::Direction, "", "not reached"),
            ]);
        }
    };
    let can = bench.link()?.capabilities();
    Ok([
        limit(&followed, &bounds, promised, loosened),
        stop(&followed, &bounds, zero),
        direction::judge(&followed, &limits, can, bench.axis, at_rest),
    ])
}

fn limit(
    followed: &Followed,
    bounds: &Bounds,
    promised: String,
    loosened: Option<String>,
) -> Check {
    let Bounds { limits, period_s } = *bounds;
    let most_n = followed.largest_n();
    let asked = followed.sent.iter().map(|(_, force)| force.abs());
    let asked_n = asked.fold(0.0, f32::max);
    let rate = largest_rate(&followed.samples, period_s);
    let slack = ROUNDING * limits.force_n;
    let kept = most_n <= limits.force_n
        && rate <= f64::from(limits.force_rate_n_per_s) + f64::from(2.0 * slack) / period_s;
    // A device that makes no force at all has been asked nothing.
    let reached = most_n >= 0.99 * limits.force_n;
    let looser = loosened.as_deref().unwrap_or("a looser limit was taken");
    let mut seen =
        format!("at most {most_n} N and {rate:.4} N/s of {asked_n:.4} N asked for; {looser}");
    if let Some(fault) = followed.fault_in_words() {
        seen = format!("{seen}; {fault}");
    } else if !reached {
        seen.push_str("; the limit was not reached, so it was not tried");
    }
    // A board that is let go at once falls faster than its rate.
    let certain = most_n > limits.force_n || most_n.is_nan() || loosened.is_none();
    let ok = kept && loosened.is_some() && followed.fault.is_none();
    let check = if ok && !reached {
        Check::not_judged(Promise::ForceLimit, promised, seen)
    } else {
        Check::judged(Promise::ForceLimit, promised, seen, ok)
    };
    check
        .certain(certain)
        .figure("force_max_n", most_n)
        .figure("force_rate_max_n_per_s", rate)
}

/// Largest change of the force from a tick to the next, N/s; infinite for a force that is no number.
fn largest_rate(samples: &[Tick], period_s: f64) -> f64 {
    let stopping = samples
        .iter()
        .position(|tick| tick.limiters & STOPPING != 0);
    let running = samples[..stopping.unwrap_or(samples.len())].windows(2);
    let steps = running.filter(|pair| pair[1].tick == pair[0].tick + 1);
    steps.fold(0.0, |most, pair| {
        let step = f64::from(pair[1].force_n[0] - pair[0].force_n[0]).abs() / period_s;
        if step.is_nan() {
            f64::INFINITY
        } else {
            step.max(most)
        }
    })
}

fn stop(followed: &Followed, bounds: &Bounds, promised: String) -> Check {
    let mut samples = followed.samples.iter();
    let stopping = samples.find(|sample| sample.limiters & STOPPING != 0);
    let first = stopping.map(|sample| sample.tick).or(followed.stop_asked);
    let (Some(first), None) = (first, followed.fault_in_words()) else {
        let fault = followed.fault_in_words();
        let seen = fault.unwrap_or_else(|| "it went on".to_owned());
        return Check::judged(Promise::Stop, promised, seen, false);
    };
    let fall = Fall::of(&followed.samples, first, bounds);
    let (seen, ok) = (fall.words(bounds), fall.is_within(bounds));
    fall.shown_by(Check::judged(Promise::Stop, promised, seen, ok), bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_link::Limits;

    fn run(forces: &[f32]) -> Followed {
        let numbered = forces.iter().zip(0..);
        let samples = numbered.map(|(&force_n, tick)| Tick {
            tick,
            force_n: [force_n],
            ..Tick::NONE
        });
        Followed {
            samples: samples.collect(),
            ..Followed::default()
        }
    }

    #[test]
    fn a_limit_is_kept_if_force_and_rate_are_and_it_was_reached() {
        let bounds = Bounds {
            limits: Limits {
                force_n: 0.1,
                force_rate_n_per_s: 50.0,
                ..Limits::DEFAULT
            },
            period_s: 1e-3,
        };
        let refused = || Some("20 N refused".to_owned());
        let limited =
            |forces: &[f32], loosened| limit(&run(forces), &bounds, String::new(), loosened);
        let judge = |forces: &[f32], loosened| limited(forces, loosened).ok;
        assert_eq!(judge(&[0.0, 0.05, 0.1, 0.1, 0.05], refused()), Some(true));
        // Never there is not tried.
        assert!(limited(&[0.0, 0.05], refused()).not_judged);
        assert!(!limited(&[0.0, 0.05], None).not_judged);
        // Too much, too fast, no number, a looser limit was taken.
        assert_eq!(judge(&[0.0, 0.05, 0.1, 0.100_01], refused()), Some(false));
        assert_eq!(judge(&[0.0, 0.1], refused()), Some(false));
        assert_eq!(judge(&[0.0, f32::NAN, 0.1], refused()), Some(false));
        assert_eq!(judge(&[0.0, 0.05, 0.1], None), Some(false));
        // What went beyond is broken for certain; what was not tried is not.
        assert!(limited(&[0.0, 0.05, 0.1, 0.100_01], refused()).certain);
        assert!(!limited(&[0.0, 0.1], refused()).certain);
        assert!(!limited(&[0.0, 0.05], refused()).certain);
    }
}
