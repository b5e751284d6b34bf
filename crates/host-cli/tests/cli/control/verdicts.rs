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
