//! Verdicts of `control` that are easily wrong: unstable plants, gains that vary, tiny orders.

use crate::process::{Place, number};

#[test]
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
    let line = "control design --plant exp(-0.1s)/(s+1) --crossover 12rad/s --phase-margin 35deg --not-flat --out late";
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

/// The PID of order 1 grows, and its steps swing: the picture says what it leaves out.
#[test]
fn a_picture_of_loops_that_grow_says_what_it_leaves_out() {
    let place = Place::new();
    let line = "control design --plant exp(-0.1s)/(s+1) --crossover 12rad/s --phase-margin 35deg --not-flat --out late";
    place.run(line).succeeded();
    let picture = place.text("late/controller.svg");
    assert!(
        picture.contains("left out: PID of order 1 at ")
            && picture.contains("its own gain in (c) or (d)"),
        "{picture}"
    );
}
