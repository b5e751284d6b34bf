//! Verdicts of `control` that are easily wrong: unstable plants, gains that vary, tiny orders.

use crate::process::{Place, number};

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn an_unstable_plant_is_designed_for_and_proved_from_half_to_double_the_gain() {
    let place = Place::new();
    let line = "control design --plant 1/(s-1) --crossover 10rad/s --phase-margin 60deg --json";
    let report = place.run(line).succeeded().json();
    assert_eq!(
        (&report["stable"], &report["robust"]),
        (&true.into(), &true.into())
    );
    assert!(
        number(&report, "stable_gain_low") <= 0.5 && number(&report, "stable_gain_high") >= 2.0
    );
    // A crossover next to the dead time holds, but not at twice the gain: said, and kept in the file.
    let line = "control design --plant exp(-0.1s)/(s+1) --crossover 13rad/s --phase-margin 25deg --not-flat --out late";
    let shown = place.run(line).succeeded().stdout;
    assert!(
        shown.contains("Warning: the sampled loop is proved stable only from"),
        "{shown}"
    );
    let file = std::fs::read_to_string(place.path("late/controller.toml")).expect("written");
    assert!(file.contains("proved stable only"), "{file}");
}

#[test]
fn a_factor_after_a_division_is_said_and_a_tiny_order_is_stable() {
    let place = Place::new();
    let ran = place.run("control analyze --plant 1/(s+1)(s+2)");
    assert!(
        ran.stderr.contains("multiplies the whole"),
        "{}",
        ran.stderr
    );
    let ran = place.run("control analyze --plant 1/((s+1)(s+2))");
    assert!(!ran.stderr.contains("multiplies"), "{}", ran.stderr);
    let shown = place
        .run("control analyze --plant 1/(s^0.01+1)")
        .succeeded()
        .stdout;
    assert!(
        shown.contains("Stable: all that is in it decays."),
        "{shown}"
    );
}

/// 4(s + 1/1000)/s on 1/(1000s + 1) is 1/(250s): it takes π/2·250 s of dead time, more than the 200 s that a memory would hold.
#[test]
fn a_loop_that_is_slow_against_its_samples_has_its_margins() {
    let place = Place::new();
    let line =
        "control analyze --plant 1/(1000s+1) --controller 4+0.004/s --sample-time 1ms --json";
    let report = place.run(line).succeeded().json();
    let delay = number(&report["margins"], "delay_margin_s");
    assert!(
        (delay / (125.0 * std::f64::consts::PI) - 1.0).abs() < 1e-5,
        "{delay}"
    );
    assert!(report["coarse"].is_null(), "{report}");
    let line = "control analyze --plant 1/(1000s-1) --controller 4 --sample-time 1ms --json";
    let report = place.run(line).succeeded().json();
    let down = number(&report["margins"], "gain_down");
    assert!((down - 0.25).abs() < 1e-6, "{down}");
}

/// A crossover of 10 rad/s at 50 ms is 0.5/T: no proof for a plant of order 1/2.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_fractional_plant_that_is_sampled_too_coarsely_is_not_proved() {
    let place = Place::new();
    let line =
        "control design --plant 1/(s^0.5+1) --crossover 10rad/s --sample-time 50ms --not-flat";
    let shown = place.run(line).failed(1).stdout;
    assert!(shown.contains("that is no proof for the plant"), "{shown}");
    assert!(!shown.contains("and proved"), "{shown}");
    let fine =
        "control design --plant 1/(s^0.5+1) --crossover 10rad/s --sample-time 2ms --not-flat";
    let shown = place.run(fine).succeeded().stdout;
    assert!(shown.contains("and proved so for every gain"), "{shown}");
}

/// Half an integrator at T = 1 s is lost at a gain of about 1.1, half the sample rate, which the rule of its samples does not see.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_the_rule_of_a_fractional_plant_does_not_see_is_not_proved() {
    let place = Place::new();
    let line = |gain: &str| {
        format!("control analyze --plant 1/s^0.5 --controller {gain} --sample-time 1s --json")
    };
    let report = place.run(&line("0.4")).succeeded().json();
    assert_eq!(report["stable"], true, "{report}");
    let up = number(&report["margins"], "gain_up");
    assert!((2.5..3.0).contains(&up), "{up}");
    let report = place.run(&line("1.3")).succeeded().json();
    assert!(
        report["stable"].is_null()
            && report["margins"].is_null()
            && number(&report, "coarse") >= 2.0,
        "{report}"
    );
    let design = "control design --plant 1/s^0.5 --crossover 0.2 --sample-time 1s --json";
    let report = place.run(design).json();
    assert!(
        report["stable_gain_high"].is_null() || number(&report, "stable_gain_high") < 10.0,
        "{report}"
    );
}

/// A current that follows in a twentieth of a sample: the loop has a pole at 1.0048.
#[test]
fn a_lag_far_faster_than_the_sample_is_part_of_the_proof() {
    let place = Place::new();
    let line = "control analyze --mass 65g --damping 3.5 --delay 0.5ms --current-lag 0.05ms --sample-time 1ms --controller 4000";
    let shown = place.run(line).succeeded().stdout;
    assert!(shown.contains("Unstable, and proved: 2 poles"), "{shown}");
    let design = "control design --mass 65g --damping 3.5 --delay 1ms --current-lag 0.04ms --crossover 60rad/s --phase-margin 55deg \
                  --sample-time 1ms --json";
    let high = number(&place.run(design).succeeded().json(), "stable_gain_high");
    assert!((20.0..22.5).contains(&high), "{high}");
}

/// The PID of order 1 grows, and its steps swing: the picture says what it leaves out.
#[test]
fn a_picture_of_loops_that_grow_says_what_it_leaves_out() {
    let place = Place::new();
    let line = "control design --plant exp(-0.1s)/(s+1) --crossover 13rad/s --phase-margin 25deg --not-flat --out late";
    place.run(line).succeeded();
    let picture = place.text("late/controller.svg");
    let told = picture.contains("left out: PID of order 1 at gain +3 dB, which grows");
    assert!(told, "{picture}");
}

#[test]
fn a_loop_too_weak_or_too_slow_for_its_samples_is_told_so() {
    let place = Place::new();
    let line = "control analyze --plant 1/s^2 --controller 1e-40 --sample-time 1ms";
    let shown = place.run(line).succeeded().stdout;
    assert!(
        shown.contains("neither decays nor grows within 1e8 samples")
            && shown.contains("more gain"),
        "{shown}"
    );
    // A pole on the circle elsewhere takes another gain: 2/(1 − e^(−0.1)) − 1 … at half the sample rate.
    let edge = 2.0 / (1.0 - f64::exp(-0.1)) - 1.0;
    let line = format!("control analyze --plant 1/(s+1) --controller {edge:?} --sample-time 0.1s");
    let shown = place.run(&line).succeeded().stdout;
    assert!(shown.contains("Change the gain a little"), "{shown}");
}

/// A loop of 1e30 and one of 1 are as far from the boundary, and one that grows beyond all numbers says so.
#[test]
fn very_large_and_very_small_numbers_are_judged_right() {
    let place = Place::new();
    let report = |plant: &str, controller: &str| {
        let line = format!(
            "control analyze --plant {plant} --controller {controller} --sample-time 1ms --json"
        );
        place.run(&line).succeeded().json()
    };
    let usual = report("1/(s+1)", "20");
    for (plant, controller) in [
        ("1e60/(s+1)", "2e-59"),
        ("1e-59/(1e-59s+1e-59)", "20"),
        ("2e-59/(s+1)", "1e60"),
    ] {
        let own = report(plant, controller);
        assert_eq!(own["stable"], usual["stable"], "{plant}");
        for name in ["gain_up", "delay_margin_s", "sensitivity_peak"] {
            let [have, want] = [&own, &usual].map(|of| number(&of["margins"], name));
            assert!(
                (have / want - 1.0).abs() < 1e-9,
                "{plant}: {name} {have} {want}"
            );
        }
    }
    // L = 1e117 at half the sample rate.
    let fast = "control analyze --plant 1e60/(s+1) --controller 1e60 --sample-time 1ms --json";
    let own = place.run(fast).succeeded().json();
    assert_eq!(
        (&own["stable"], &own["unstable_poles"]),
        (&false.into(), &1.into())
    );
    let grows =
        "control simulate --plant 1e40/(s+1) --controller 1 --sample-time 1s --duration 200s";
    let shown = place.run(grows).succeeded_with_warnings().stdout;
    assert!(
        shown.contains("beyond 1e308 %") && !shown.contains("NaN") && !shown.contains("inf"),
        "{shown}"
    );
}

/// A mass drifts, a mass on a spring swings for ever, a damper on both ends it.
#[test]
fn a_device_alone_decays_only_where_something_holds_and_damps_it() {
    let place = Place::new();
    for (device, words) in [
        ("", "On the boundary"),
        ("--damping 3.5", "On the boundary"),
        ("--hand-stiffness 100", "On the boundary"),
        (
            "--damping 3.5 --hand-stiffness 100",
            "Stable: all that is in it decays.",
        ),
    ] {
        let shown = place
            .run(&format!("control analyze --mass 65g {device}"))
            .succeeded()
            .stdout;
        assert!(
            shown.contains(words) && shown.contains("poles (orders are multiples of 1)"),
            "{device}: {shown}"
        );
    }
    place
        .run("control simulate --mass 65g --duration 1s")
        .refused(2, &["do not decay", "close the loop"]);
}

/// C/(1 + L) of s/(s + 1)² and 1 + 1/s^0.5 is s^−0.5 at rest: the command grows as √t.
#[test]
fn an_integral_that_meets_a_factor_s_is_not_proved() {
    let place = Place::new();
    for controller in ["1+1/s^0.5", "1+1/s", "1+1/s^1.5"] {
        let line = format!(
            "control analyze --plant s/(s+1)^2 --controller {controller} --sample-time 10ms"
        );
        let shown = place.run(&line).succeeded().stdout;
        assert!(
            shown.contains("On the boundary") && shown.contains("leave one of both out"),
            "{shown}"
        );
    }
    let design = "control design --plant s/(s+1)^2 --crossover 3rad/s --phase-margin 60deg";
    place.run(design).refused(
        1,
        &["a controller without an integral was not found", "factor s"],
    );
}
