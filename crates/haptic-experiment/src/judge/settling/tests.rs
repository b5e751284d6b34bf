//! Motions that rest, buzz, slide or leave.

use super::*;

/// 1 N into 100 kN/m through an encoder of 1 µm, 50 N/m of dissipation a step.
const STIFF: Scales = Scales {
    push_n: 1.0,
    spring_n_per_m: 1e5,
    dissipation_step_n_per_m: 5e4,
    encoder_step_m: 1e-6,
};

/// Judges 5 s at 1 kHz of these positions and forces, the window being the last 0.4 s.
fn judged(criterion: Criterion, scales: Scales, motion: impl Fn(u32) -> (f64, f64)) -> Settling {
    let tolerance = Tolerance::new(criterion, scales);
    let mut judge = Judge::new((criterion, 0.1), tolerance, 4.6, 3.3);
    for n in 0..5001 {
        let (position, force) = motion(n);
        judge.see(1e-3 * f64::from(n), position, force);
    }
    judge.settling(true, None)
}

fn sign(n: u32) -> f64 {
    if n.is_multiple_of(2) { 1.0 } else { -1.0 }
}

#[test]
fn a_wall_that_buzzes_below_a_tenth_of_a_millimetre_is_not_stable() {
    let buzzing = |n| (10e-6 + 9e-6 * sign(n), -1.0 + 2.3 * sign(n));
    let new = judged(Criterion::Settling, STIFF, buzzing);
    assert_eq!(new.verdict, TrialVerdict::Saturated);
    let old = judged(Criterion::Dissertation, STIFF, buzzing);
    assert_eq!(old.verdict, TrialVerdict::Stable);
    // Far from the force limit it is seen too: by the position, by the force.
    let by_position = |n| (10e-6 + 3e-6 * sign(n), -1.0);
    let by_force = |n| (10e-6, -1.0 + 0.06 * sign(n));
    let quiet = |n| (10e-6 + 1.9e-6 * sign(n), -1.0 + 0.049 * sign(n));
    for (motion, verdict) in [
        (
            &by_position as &dyn Fn(u32) -> (f64, f64),
            TrialVerdict::Unstable,
        ),
        (&by_force, TrialVerdict::Unstable),
        (&quiet, TrialVerdict::Stable),
    ] {
        let settling = judged(Criterion::Settling, STIFF, motion);
        assert_eq!(settling.verdict, verdict, "{settling:?}");
        assert_eq!(settling.reason().is_none(), settling.stable);
    }
}

#[test]
fn one_step_of_the_encoder_through_the_operator_is_no_buzz() {
    // 50 kN/m of dissipation a step and 2 µm: 0.1 N.
    let coarse = Scales {
        encoder_step_m: 2e-6,
        ..STIFF
    };
    let flips = |n| (10e-6, -1.0 + 0.09 * sign(n));
    assert!(judged(Criterion::Settling, coarse, flips).stable);
    assert!(!judged(Criterion::Settling, STIFF, flips).stable);
}

#[test]
fn a_step_of_more_than_a_quarter_of_the_push_is_no_excuse() {
    // 2 N into 650 kN/m of dissipation a step and 4 µm: 2.6 N a step, 0.5 N allowed.
    let coarse = Scales {
        push_n: 2.0,
        dissipation_step_n_per_m: 6.5e5,
        encoder_step_m: 4e-6,
        ..STIFF
    };
    for (swing_n, stable) in [(1.3, false), (0.51, false), (0.49, true)] {
        let swings = |n| (20e-6, -1.5 + swing_n * sign(n));
        let settling = judged(Criterion::Settling, coarse, swings);
        assert_eq!(settling.stable, stable, "{swing_n} N: {settling:?}");
        assert_eq!(settling.force_std_limit_n, Some(0.5));
    }
}

#[test]
fn a_force_that_swings_by_more_than_the_push_is_no_rest_however_rarely() {
    // An encoder so coarse that a standard deviation of 0.25 N is excused: one sample of fifty swings by 1.1 N, 0.15 N rms.
    let coarse = Scales {
        encoder_step_m: 5e-6,
        ..STIFF
    };
    for (swing_n, stable) in [(1.1, false), (0.9, true)] {
        let swings = |n: u32| {
            (
                10e-6,
                if n.is_multiple_of(50) {
                    swing_n - 1.0
                } else {
                    -1.0
                },
            )
        };
        let settling = judged(Criterion::Settling, coarse, swings);
        assert!(settling.force_std_n < Some(0.25), "{settling:?}");
        assert_eq!(settling.stable, stable, "{settling:?}");
        let range = settling.force_range_n.expect("seen");
        assert!((range - swing_n).abs() < 1e-12, "{range}");
    }
}

#[test]
fn an_impact_may_reach_the_limit_for_a_hundredth_of_the_samples() {
    for (samples, stable) in [(50, true), (51, false)] {
        let motion = |n| (10e-6, if n < samples { -3.3 } else { -1.0 });
        let settling = judged(Criterion::Settling, STIFF, motion);
        assert_eq!(settling.stable, stable, "{samples}");
    }
}

#[test]
fn what_leaves_or_never_ends_is_not_stable() {
    let tolerance = Tolerance::new(Criterion::Settling, STIFF);
    let mut judge = Judge::new((Criterion::Settling, 0.1), tolerance, 4.6, 3.3);
    assert!(judge.see(0.0, 0.0, 0.0));
    assert_eq!(judge.settling(true, None).verdict, TrialVerdict::Unfinished);
    assert!(!judge.see(1.0, f64::NAN, 0.0));
    assert_eq!(judge.settling(true, None).verdict, TrialVerdict::Gone);
}

#[test]
fn without_a_spring_the_force_alone_is_judged() {
    let damper = Scales {
        spring_n_per_m: 0.0,
        ..STIFF
    };
    let slides = |n: u32| (1e-5 * f64::from(n), -1.0);
    let settling = judged(Criterion::Settling, damper, slides);
    assert!(settling.stable && settling.position_std_limit_m.is_none());
    assert!(!judged(Criterion::Dissertation, damper, slides).stable);
}
