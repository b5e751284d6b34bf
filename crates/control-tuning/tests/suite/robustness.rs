//! Baselines and designs, by the loop that runs.

use crate::fixture::{not_flat, p, pi, plant};
use control_tuning::{Specification, design::ControlDesign, integer_baseline};
use fracdiff::Seconds;
use fractional_control::{ControllerSetup, analysis::analyse};
use testkit::{assert_close, assert_refused, assert_relative};

/// 400 samples of 10 ms of a step, without limits.
fn designed(function: &str, wishes: Specification) -> ControlDesign {
    ControlDesign {
        plant: plant(function),
        wishes,
        sample_time: Seconds(0.01),
        scheme: ControllerSetup::new(p(1.0), Seconds(0.01)).scheme,
        output_low: None,
        output_high: None,
        step: 1.0,
        samples: 400,
    }
}

#[test]
fn the_baseline_has_the_crossover_and_the_margin_of_the_loop() {
    let oven = plant("0.55exp(-s)/(62s+1)");
    let setup = ControllerSetup::new(pi(9.7, 0.6, 0.9), Seconds(0.1));
    let baseline = integer_baseline(&setup, &oven)
        .expect("one")
        .expect("fractional");
    let pid = baseline.pid().expect("a PID");
    assert_eq!((pid.integral_order, pid.derivative_order), (1.0, 1.0));
    let [a, b] = [&setup, &baseline].map(|setup| {
        let phase = analyse(setup, &oven).expect("a loop").margins.phase;
        phase.expect("a crossover")
    });
    assert_relative("crossover", a.omega_rad_s, b.omega_rad_s, 2e-3);
    assert_close("margin", a.value, b.value, 2e-3);
    assert_eq!(integer_baseline(&baseline, &oven), Ok(None));
}

/// Order 1.9 on 1/(s + 1) with a sample time near the crossover: stable, and lost below twice the gain.
#[test]
fn a_design_that_is_lost_at_twice_the_gain_is_not_robust() {
    for (crossover, robust) in [(2.0, true), (12.0, false)] {
        let design = designed("exp(-0.1s)/(s+1)", not_flat(crossover, 35_f64.to_radians()));
        let trial = design
            .answer()
            .expect("found")
            .fractional
            .trial
            .expect("runs");
        assert!(trial.analysis.verdict.stable);
        let [low, high] = trial.stable_gains.expect("stable");
        assert_eq!(trial.is_robust(), robust, "{crossover}: {low} to {high}");
        // The end is the gain margin of the sampled loop.
        let up = trial.analysis.margins.gain_up.expect("a dead time").value;
        assert!(high <= up && high > 0.99 * up.min(100.0), "{high} {up}");
    }
}

/// As `an_integral_that_meets_a_factor_s_is_not_proved` of `fractional-control`.
#[test]
fn an_integral_that_meets_a_factor_s_is_no_design() {
    let design = designed("s/(s+1)^2", Specification::new(3.0, 60_f64.to_radians()));
    assert_refused(
        design.answer(),
        "a controller without an integral was not found",
    );
}
