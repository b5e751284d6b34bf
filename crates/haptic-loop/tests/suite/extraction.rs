//! Energy that motions can draw from a loop with energy bounding, by adversaries that are optimised for it.
//!
//! The oracle does not know the guard's books. It follows the commands to the device: each acts after its own delay, the
//! actuator follows with its lag, and between two events force and velocity are
//!
//! ```text
//! g(t) = u + p·e^(−t/τ),  v(t) = c + e·g(t)        ∫g·v dt and ∫v² dt in closed form, event by event
//! E = ∫ (ρb·v² − g·v) dt                          of device and loop together; passive if E never falls below 0
//! ```
//! *The worst motion inside a sample* for a displacement Δ is v = Δ/T + (g − ḡ)/(2ρb), for any displacement v = g/(2ρb).
//!
//! The environment variable `CAMPAIGN_CASES` sets how many random devices are tried; 400 if it is not set.

mod adversary;
mod oracle;

use self::adversary::{Case, Motion, Wanted};
use fracdiff::Seconds;
use haptic_loop::EnergyBounding;
use testkit::Random;

/// Rounding, J.
const ROUNDING: f64 = -1e-9;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_motion_draws_energy_from_a_bounded_loop() {
    let mut random = Random(13);
    let (mut unguarded, mut felt) = (0, 0);
    let count = testkit::cases(400);
    for index in 0..count {
        let case = Case::random(&mut random);
        let motions = Case::motions(&mut random);
        let guard = Some(case.guard());
        let (least, most) = if index % 3 == 0 {
            case.worst::<f64, 2>(&motions, guard)
        } else {
            case.worst::<f64, 1>(&motions, guard)
        };
        assert!(least >= ROUNDING, "{index}: {least} J, {case:?}");
        felt += usize::from(most > 0.1);
        let (free, _) = case.worst::<f64, 1>(&motions, None);
        unguarded += usize::from(free < -1e-6);
        let (least, _) = case.worst::<f32, 1>(&motions, guard);
        assert!(least >= ROUNDING, "single {index}: {least} J, {case:?}");
    }
    // The adversaries are strong, and the guard does not just let nothing through.
    assert!(unguarded * 10 > count * 8, "{unguarded} of {count}");
    assert!(felt * 10 > count * 8, "{felt} of {count}");
}

/// Up to 4·10⁵ samples: what a plain sum of single precision would lose comes to millijoules.
#[test]
fn no_long_motion_draws_energy_in_single_precision() {
    let mut random = Random(21);
    let mut felt = 0;
    let count = testkit::cases(40);
    for index in 0..count {
        let (motion, samples) = Case::long(&mut random);
        let case = Case {
            motion,
            ..Case::random(&mut random)
        };
        let guard = Some(case.guard());
        let (least, most) = if index % 4 == 0 {
            case.least::<f32, 2>(guard, samples)
        } else {
            case.least::<f32, 1>(guard, samples)
        };
        assert!(
            least >= ROUNDING,
            "{index}: {least} J, {samples} samples, {case:?}"
        );
        felt += usize::from(most > 0.1);
    }
    assert!(felt * 10 > count * 8, "{felt} of {count}");
}

/// A wall that is stiff beyond any limit, felt by an adversary.
fn stiff(delays: (f64, f64), lag: f64, motion: Motion) -> Case {
    Case {
        sample_time: 1e-3,
        damping: 1.0,
        share: 1.0,
        forget: 1000.0,
        delays,
        jitters: false,
        lag,
        wanted: Wanted::Wall {
            stiffness: 20_000.0,
            dissipation: 0.0,
        },
        motion,
        limits: (35.0, None),
        braking: None,
        seed: 1,
    }
}

#[test]
fn a_delay_rounded_up_or_down_is_not_safe() {
    let motion = Motion::StoreThenExtract {
        store: 12,
        extract: 4,
    };
    let case = stiff((0.5e-3, 0.5e-3), 0.0, motion);
    let with_delay = |delay: f64| {
        let delay = Seconds(delay);
        let guard = EnergyBounding {
            delay_least: delay,
            delay_most: delay,
            ..case.guard()
        };
        case.least::<f64, 1>(Some(guard), 5000).0
    };
    assert!(with_delay(0.5e-3) >= ROUNDING);
    for rounded in [0.0, 1e-3] {
        let least = with_delay(rounded);
        assert!(least < -1e-3, "{rounded} {least}");
    }
    // Nor one whose lag is not said.
    let case = stiff((0.0, 0.0), 1e-3, motion);
    let guard = EnergyBounding {
        current_lag: Seconds(0.0),
        ..case.guard()
    };
    assert!(case.least::<f64, 1>(Some(guard), 5000).0 < -1e-3);
}
