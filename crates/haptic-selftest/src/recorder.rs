//! The device's flight recorder after a fault, beside the samples that came while it happened.

use super::bench::{Bench, Broken};
use super::promise::{Check, Promise};
use super::trial::{Followed, seen};
use haptic_remote::Tick;
use std::collections::BTreeMap;

/// The row; `followed` is the run that ended in the fault.
pub(super) fn check(bench: &mut Bench<'_>, followed: Option<&Followed>) -> Result<Check, Broken> {
    bench.trying(Promise::FlightRecorder)?;
    let room = bench.link()?.capabilities().flight_samples;
    if room == 0 {
        let seen = "not there: this device keeps none";
        let promised = "the samples around a fault";
        return Ok(Check::judged(Promise::FlightRecorder, promised, seen, None));
    }
    let promised = format!("{room} samples around a fault, as they were");
    let fault = followed.and_then(|followed| Some((followed, followed.fault_tick()?)));
    let Some((followed, fault)) = fault else {
        let seen = "not tried: no fault before it";
        return Ok(Check::not_judged(Promise::FlightRecorder, promised, seen));
    };
    let kept = bench.link()?.flight().collect::<Result<Vec<_>, _>>()?;
    let kept: Vec<Tick> = (kept.iter())
        .filter_map(|sample| seen(sample, bench.axis))
        .collect();
    let (seen, ok) = judge(&kept, followed, fault, usize::from(room));
    let row = Check::judged(Promise::FlightRecorder, promised, seen, ok);
    Ok(row.figure("samples", kept.len() as f64))
}

/// Record in words, and true if all of it is there: full, without gap, with the fault in it, and as it was sent.
fn judge(kept: &[Tick], followed: &Followed, fault: u32, room: usize) -> (String, bool) {
    let after = kept.iter().filter(|sample| sample.tick > fault).count();
    let has_fault = kept.iter().any(|sample| sample.tick == fault);
    let sent: BTreeMap<u32, &Tick> = (followed.samples.iter())
        .map(|sample| (sample.tick, sample))
        .collect();
    // A period that the device has skipped has no sample anywhere.
    let gaps = kept
        .windows(2)
        .filter(|pair| {
            let [before, tick] = [pair[0].tick, pair[1].tick];
            before >= tick || sent.range(before + 1..tick).next().is_some()
        })
        .count();
    let compared =
        (kept.iter()).filter_map(|sample| Some(is_same(sample, sent.get(&sample.tick)?)));
    let (count, compared) = (kept.len(), compared.collect::<Vec<bool>>());
    let (all, same) = (
        compared.len(),
        compared.iter().filter(|same| **same).count(),
    );
    let seen = format!(
        "{count} samples, {after} of them after the fault, {gaps} gaps; {same} of {all} as they were sent"
    );
    let full = count == room.min(fault as usize + 1 + after);
    let ok = full && gaps == 0 && has_fault && all > 0 && same == all;
    (seen, ok)
}

/// True if two ticks agree to the last bit, but for the time, which a batch of samples does not carry.
fn is_same(a: &Tick, b: &Tick) -> bool {
    let bits = |tick: &Tick| {
        [tick.position_m, tick.environment_force_n, tick.force_n].map(|[axis]| axis.to_bits())
    };
    bits(a) == bits(b) && a.limiters == b.limiters
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(ticks: std::ops::Range<u32>) -> Vec<Tick> {
        let sample = |tick| Tick {
            tick,
            force_n: [tick as f32],
            ..Tick::NONE
        };
        ticks.map(sample).collect()
    }

    #[test]
    fn a_recorder_is_whole_without_gap_with_the_fault_and_as_it_was() {
        let followed = Followed {
            samples: samples(0..300),
            ..Followed::default()
        };
        let ok = |kept: &[Tick]| judge(kept, &followed, 200, 96).1;
        assert!(ok(&samples(129..225)));
        assert!(!ok(&[]));
        assert!(!ok(&samples(129..224)), "one is missing");
        assert!(!ok(&samples(100..196)), "the fault is not in it");
        let mut gap = samples(128..225);
        gap.remove(50);
        assert!(!ok(&gap), "a gap");
        let mut twice = samples(129..225);
        twice[50] = twice[49];
        assert!(!ok(&twice), "one is there twice");
        let mut other = samples(129..225);
        other[40].force_n = [0.0];
        assert!(!ok(&other), "another force");
    }

    #[test]
    fn periods_that_the_device_skipped_are_no_gap() {
        let mut skipped = samples(0..300);
        skipped.retain(|sample| !(150..190).contains(&sample.tick));
        let followed = Followed {
            samples: skipped.clone(),
            ..Followed::default()
        };
        let kept: Vec<Tick> = (skipped.into_iter())
            .filter(|sample| (89..225).contains(&sample.tick))
            .collect();
        assert_eq!(kept.len(), 96);
        assert!(judge(&kept, &followed, 200, 96).1);
    }
}
