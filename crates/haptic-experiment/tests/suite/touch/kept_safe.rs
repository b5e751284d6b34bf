//! Limits, guards and faults of a touch; the energy of its hand, and its log.

use super::{json, run, touch, verdict};
use crate::design::number;
use haptic_message::TickMessage;
use haptic_quantity::written;
use testkit::assert_says;

#[test]
fn the_force_stays_within_the_limit_of_its_norm() {
    let (report, ticks) = run(&touch(
        "axes = 3\nstiffness_n_per_m = 2000\nforce_limit_n = 0.5\nhand_stiffness_n_per_m = 600\nradius_m = 0.02\n\
         circle_radius_m = 0.015\nduration_s = 2",
    ));
    let most = ticks
        .iter()
        .map(|tick| tick.commanded_force_n.norm())
        .fold(0.0, f64::max);
    let wanted = ticks.iter().map(|tick| tick.environment_force_n.norm());
    assert!(wanted.fold(0.0, f64::max) > 1.0);
    assert!(most <= 0.5 && most > 0.499, "{most}");
    assert_eq!(verdict(&report), "saturated");
    // What was not limited is compared.
    let (run, shown) = (&report.run, json(&report));
    assert!(run.limited_samples > 100, "{}", run.limited_samples);
    assert_eq!(
        shown["max_relative_error_samples"],
        run.samples - run.limited_samples
    );
    assert!(
        (shown["max_relative_error"].as_f64()).is_some_and(|error| error < 1e-5),
        "{shown}"
    );
}

#[test]
fn a_wall_that_shakes_gives_the_hand_energy_and_a_guard_takes_it_back() {
    // 2b/T = 7000 N/m: beyond what any hand may hold.
    let shaking = |guard: &str| {
        touch(&format!(
            "shape = \"plane\"\nstiffness_n_per_m = 60000\ndissipation_n_s_mu_per_m = 0\nduration_s = 2\n\
             force_limit_n = 50\nway_points = [[0, -0.005, 0], [0.5, 0.005, 0], [2, 0.005, 0.02]]\n{guard}"
        ))
    };
    let (report, _) = run(&shaking(""));
    assert_eq!(verdict(&report), "gave-energy");
    let most_j = number(&json(&report), "given_most_j");
    assert!(most_j > 1e-6, "{most_j}");
    assert!(!report.run.preflight.expect("one").stable);
    let message = report.run.warnings.join("; ");
    assert_says(&message, "pre-flight & the hand was given");
    let (report, ticks) = run(&shaking("guard = \"energy-bounding\""));
    assert_eq!(verdict(&report), "passive", "{report:?}");
    // No friction from the guard: the hand slides along the second axis.
    assert!(ticks.iter().all(|tick| tick.commanded_force_n[1] == 0.0));
}

#[test]
fn a_shape_that_grows_stiff_while_it_is_pressed_is_told_as_that() {
    // Pressed within the first tenth of a second, while the force rises for two seconds; or touched afterwards.
    let risen = |touched_s: f64| {
        let (in_s, out_s) = (touched_s + 0.1, touched_s + 2.9);
        touch(&format!(
            "shape = \"plane\"\nstiffness_n_per_m = 1000\ndissipation_n_s_mu_per_m = 0\nduration_s = 6\nrise_time_s = 2\n\
             way_points = [[0, -0.001, 0], [{touched_s}, -0.001, 0], [{in_s}, 0.008, 0], [{out_s}, 0.008, 0]]"
        ))
    };
    let (report, _) = run(&risen(0.01));
    assert_eq!(verdict(&report), "gave-energy");
    let message = report.run.warnings.join("; ");
    assert!(
        message.contains("use a shorter `rise_time_s`") && !message.contains("softer K"),
        "{message}"
    );
    let (report, _) = run(&risen(2.5));
    assert_ne!(verdict(&report), "gave-energy");
}

#[test]
fn leaving_the_box_is_a_fault_that_ends_the_run() {
    let (report, ticks) = run(&touch(
        "axes = 3\nshape = \"plane\"\nsurface_m = 1\nway_points = [[0, 0, 0, 0], [1, 0, 0.04, 0]]\n\
         box_low_m = [-0.01, -0.01, -0.01]\nbox_high_m = [0.1, 0.02, 0.1]\nduration_s = 2",
    ));
    assert_eq!(verdict(&report), "unfinished");
    let reason = report.run.ended_early.clone().expect("a fault");
    assert_says(&reason, "workspace");
    assert!(report.run.fault_log.is_some());
    let last = ticks.last().expect("ticks").position_m;
    assert!((0.02..0.03).contains(&last[1]), "{last:?}");
}

#[test]
fn what_is_told_of_a_run_that_a_fault_ended_is_what_its_log_shows() {
    // Pressed 20 mm deep when it leaves its box.
    let pressed = |safety: &str| {
        touch(&format!(
            "shape = \"plane\"\nstiffness_n_per_m = 200\ndissipation_n_s_mu_per_m = 0\nforce_limit_n = 50\nduration_s = 2\n\
             way_points = [[0, -0.005, 0], [0.5, 0.06, 0]]\nbox_low_m = [-0.1, -0.1]\nbox_high_m = [0.02, 0.1]\n{safety}"
        ))
    };
    for (safety, ramps) in [
        ("", false),
        ("force_rate_limit_n_per_s = 200", true),
        ("braking_n_s_per_m = 8\nbrake_force_n = 8", true),
    ] {
        let (report, ticks) = run(&pressed(safety));
        let run = &report.run;
        let acting = ticks
            .iter()
            .rfind(|tick| tick.commanded_force_n.norm() > 0.0);
        let until_s = acting.expect("a force").time_s;
        let message = run.let_go.as_deref().unwrap_or_default();
        let ramped = format!("ramped to zero until {}", written("time_s", until_s));
        assert_eq!(message.contains(&ramped), ramps, "{safety}: {message}");
        let norms: Vec<f64> = ticks
            .iter()
            .map(|tick| tick.commanded_force_n.norm())
            .collect();
        let most = norms.iter().copied().fold(0.0, f64::max);
        assert!(most > 3.0, "{most} N");
        assert_eq!(run.peak_force_n, most, "{safety}");
        assert_eq!(norms.last(), Some(&0.0));
        // The last sample that counts is that before the fault; the force at the end is its, before it falls.
        let counts = |tick: &&TickMessage| tick.time_s <= run.duration_s;
        let last = ticks.iter().rfind(counts).expect("ticks");
        assert_eq!(run.final_force_n, last.commanded_force_n.norm(), "{safety}");
        assert!(run.final_force_n > 3.0, "{safety}: {}", run.final_force_n);
        // The tick of the fault is the first outside, so it is deeper than all that count.
        let depths = ticks.iter().map(|tick| tick.position_m[0]);
        assert_eq!(
            number(&json(&report), "largest_depth_m"),
            depths.fold(0.0, f64::max)
        );
        assert!(
            number(&json(&report), "largest_depth_m") > 0.02,
            "{}",
            number(&json(&report), "largest_depth_m")
        );
    }
}
