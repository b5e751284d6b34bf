//! Faults that a host makes: a force that is no number, and silence.

use super::bench::{Bench, Broken, LONG_WATCHDOG_MS};
use super::checks::refused;
use super::fall::{Bounds, Fall};
use super::promise::{Check, Promise, SelfTest};
use super::trial::{Followed, LATE, Trial, alternating};
use haptic_loop::Fault;
use haptic_remote::{LinkError, Tick};

/// Share of the limit that acts when the fault comes.
const SHARE: f32 = 0.9;
/// Ticks at the full share before.
const TICKS: f64 = 100.0;
/// Ticks to wait for a fault beyond the time in which it has to come: a busy host may be seconds behind the device, and its last
/// forces come as late. A device that keeps its promise spares the wait.
const MORE_TICKS: u32 = 5000;

/// Tick at which the fault is made: at the end of a half period, when the force has its full share.
fn made_at(bounds: &Bounds) -> u32 {
    let ticks = (f64::from(bounds.limits.rise_time_s) / bounds.period_s + TICKS) as u32;
    ticks.next_multiple_of(bounds.half_period_ticks()) - 2
}

fn is_behind(followed: &Followed, tick: u32, more: u32) -> bool {
    let newest = followed.samples.last();
    newest.is_some_and(|sample| sample.tick > tick + more)
}

pub(super) fn finite_check(bench: &mut Bench<'_>) -> Result<Vec<Check>, Broken> {
    bench.trying(Promise::FiniteCheck)?;
    let rows = bench.each_axis(finite_on_axis)?;
    Ok(Check::of_axes(rows, false).into_iter().collect())
}

fn finite_on_axis(bench: &mut Bench<'_>) -> Result<Check, Broken> {
    let bounds = bench.bounds();
    let (limits, made_at) = (bounds.limits, made_at(&bounds));
    let trial = Trial {
        watchdog_ms: LONG_WATCHDOG_MS,
        say: |sample: &Tick, sent| {
            let is_good = sample.tick < made_at;
            let good = is_good.then(|| alternating(&bounds, sample.tick, sent, SHARE));
            Some(good.unwrap_or(f32::NAN))
        },
        until: |followed: &Followed| is_behind(followed, made_at, MORE_TICKS),
    };
    let promised = format!(
        "a force that is not a number is a fault, zero within {} s",
        limits.stop_time_s
    );
    let followed = bench.conduct(&trial, LATE)?;
    let (check, fault) = (Promise::FiniteCheck, Fault::NonFiniteForce);
    Ok(faulted(check, promised, &followed, fault, &bounds))
}

pub(super) fn watchdog(bench: &mut Bench<'_>) -> Result<(Check, Option<Followed>), Broken> {
    bench.trying(Promise::Watchdog)?;
    let bounds = bench.bounds();
    let Bounds { limits, period_s } = bounds;
    let watchdog_ms = SelfTest::WATCHDOG_MS;
    let made_at = made_at(&bounds);
    let silent_ticks = (1e-3 * f64::from(watchdog_ms) / period_s) as u32;
    let trial = Trial {
        watchdog_ms,
        say: |sample: &Tick, sent| {
            (sample.tick < made_at).then(|| alternating(&bounds, sample.tick, sent, SHARE))
        },
        until: |followed: &Followed| is_behind(followed, made_at, silent_ticks + MORE_TICKS),
    };
    let promised = format!(
        "no force for {watchdog_ms} ms is a fault, zero within {} s; no start until armed again",
        limits.stop_time_s
    );
    // Silent too soon is silent: whichever force was the last, the time counts from it.
    let followed = bench.conduct(&trial, &[Fault::StaleForce])?;
    let (check, fault) = (Promise::Watchdog, Fault::HostSilent);
    let mut check = faulted(check, promised, &followed, fault, &bounds);
    let Ok(followed) = followed else {
        return Ok((check, None));
    };
    if followed.ended_by(&[Fault::HostSilent]) {
        let (silence_s, silence, in_time) = silence(&followed, watchdog_ms, period_s);
        if silence_s.is_nan() {
            // None of this host's forces came in time for the device to show what it does without them.
            bench.late = followed.fault_in_words();
        }
        let started = bench.start()?;
        if started.is_none() {
            bench.calm()?;
        }
        check.seen = format!("{silence}; {}; {}", check.seen, refused(&started));
        check.ok = Some(check.ok == Some(true) && in_time && started.is_some());
        check = check.figure("silence_s", silence_s);
    }
    Ok((check, Some(followed)))
}

/// The row of a fault that has to latch and to take the force to zero.
fn faulted(
    promise: Promise,
    promised: String,
    followed: &Result<Followed, LinkError>,
    fault: Fault,
    bounds: &Bounds,
) -> Check {
    let judged = |seen: String, ok| Check::judged(promise, promised.clone(), seen, ok);
    let followed = match followed {
        Ok(followed) => followed,
        Err(refused) => return judged(refused.to_string(), false),
    };
    let Some(tick) = followed.fault_tick() else {
        return judged("no fault".to_owned(), false);
    };
    let latched = followed.fault.map_or(0, |report| report.status.fault);
    let fall = Fall::of(&followed.samples, tick, bounds);
    let words = followed.fault_in_words().unwrap_or_default();
    let ok = latched == fault.code() && fall.is_within(bounds);
    let seen = format!("{words}; {}", fall.words(bounds));
    fall.shown_by(judged(seen, ok), bounds)
}

/// Silence before the fault by the clock of the device, s, in words, and whether it is the one that was set.
///
/// ```text
/// sample that the last force answered  ≤  its arrival  ≤  first sample that shows it
/// ```
/// The fault has to latch in the first tick that comes after the time: from the answered sample to the fault it has
/// passed, from the sample that shows the force to the tick before the fault it has not. A device whose ticks stand still
/// for a while, as in an emulator, keeps that too.
fn silence(followed: &Followed, watchdog_ms: u16, period_s: f64) -> (f64, String, bool) {
    /// Ticks of rounding and jitter.
    const SLACK: f64 = 3.0;
    let unknown = || (f64::NAN, "no force arrived before it".to_owned(), false);
    let Some(fault) = followed.fault_tick() else {
        return unknown();
    };
    let Some((answered, shown)) = followed.last_taken(fault) else {
        return unknown();
    };
    let samples = &followed.samples;
    let at = |tick: u32| samples.iter().find(|sample| sample.tick >= tick);
    let before = samples.iter().rfind(|sample| sample.tick < fault);
    let (Some(answered), Some(before), Some(latched)) = (at(answered), before, at(fault)) else {
        return unknown();
    };
    // The clock goes round at 2³² µs.
    let passed_s = |from: &Tick, to: &Tick| {
        1e-6 * f64::from(to.time_us.wrapping_sub(from.time_us).cast_signed())
    };
    let set_s = 1e-3 * f64::from(watchdog_ms);
    let in_time = passed_s(answered, latched) >= set_s - period_s
        && passed_s(&shown, before) <= set_s + SLACK * period_s;
    let silence_s = passed_s(&shown, latched);
    let words = format!("let go {silence_s:.3} s after the last force");
    (silence_s, words, in_time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_link::{FaultReport, State, Status};

    /// Forces 1, 2, 3, … N answer the ticks up to `sent`, arrive a tick later, and a fault latches at a tick.
    fn followed(sent: u32, fault: u32) -> Followed {
        let force = |tick: u32| tick.min(sent) as f32;
        let samples = (0..fault + 20).map(|tick| Tick {
            tick,
            // Round the end of the clock.
            time_us: (u32::MAX - 99_500).wrapping_add(1000 * tick),
            environment_force_n: [force(tick.saturating_sub(1))],
            ..Tick::NONE
        });
        Followed {
            samples: samples.collect(),
            sent: (1..=sent).map(|tick| (tick, force(tick))).collect(),
            fault: Some(FaultReport {
                status: Status {
                    state: State::Fault,
                    fault: Fault::HostSilent.code(),
                    faults: 1,
                    ..Status::default()
                },
                tick: fault,
                time_us: 1,
            }),
            ..Followed::default()
        }
    }

    #[test]
    fn silence_counts_from_the_last_force_that_arrived() {
        for (sent, fault, in_time) in [
            (50, 250, true),
            (50, 251, true),
            (50, 253, true),
            // Too late, and too soon.
            (50, 260, false),
            (50, 240, false),
            // Nobody knows since when.
            (0, 200, false),
        ] {
            let (_, words, judged) = silence(&followed(sent, fault), 200, 1e-3);
            assert_eq!(judged, in_time, "{sent} {fault}: {words}");
        }
    }

    #[test]
    fn a_device_that_stands_still_for_a_while_lets_go_in_its_next_tick() {
        let mut followed = followed(50, 100);
        for sample in followed
            .samples
            .iter_mut()
            .filter(|sample| sample.tick >= 100)
        {
            sample.time_us = sample.time_us.wrapping_add(500_000);
        }
        let (_, words, in_time) = silence(&followed, 200, 1e-3);
        assert!(in_time, "{words}");
    }

    #[test]
    fn samples_that_the_line_lost_make_no_fault_late() {
        let mut followed = followed(50, 251);
        followed
            .samples
            .retain(|sample| !(51..80).contains(&sample.tick));
        let (_, words, in_time) = silence(&followed, 200, 1e-3);
        assert!(in_time, "{words}");
    }
}
