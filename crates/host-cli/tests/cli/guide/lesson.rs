//! The answers of the lesson, by its formulas: what stands on the page is what a blackboard gives.

use crate::process::{Place, number};
use serde_json::Value;
use std::f64::consts::PI;
use testkit::{assert_relative, book};

fn answer(place: &Place, line: &str) -> Value {
    place
        .run(&format!("{line} --json"))
        .succeeded_with_warnings()
        .json()
}

/// The program's number is the formula's, within this share of it.
fn agree(message: &Value, key: &str, formula: f64, within: f64) {
    let program = number(message, key);
    assert!(
        (program / formula - 1.0).abs() <= within,
        "{key}: {program}, by hand {formula}"
    );
}

#[test]
fn the_answers_of_the_lesson_follow_from_its_formulas() {
    let place = Place::new();
    let page = book::chapter("lesson.md");
    let (_, wall) = page.split_once("```toml wall.toml\n").expect("a wall");
    let (wall, _) = wall.split_once("```").expect("its end");
    place.write("wall.toml", wall);

    // x = F/K, within what a trial calls at rest.
    for (stiffness, name) in [(1e3, "one"), (2e3, "two")] {
        let line = format!("run wall.toml stiffness={stiffness} --out {name}");
        agree(
            &answer(&place, &line),
            "deflection_m",
            1.0 / stiffness,
            0.01,
        );
    }

    // wₖ = wₖ₋₁ · (k − 1 − μ)/k
    for order in [2.0, 0.5] {
        let mut weight = 1.0;
        let mut table = "lag,weight\n0,1\n".to_owned();
        for k in 1..4 {
            weight *= (f64::from(k) - 1.0 - order) / f64::from(k);
            table += &format!("{k},{weight}\n");
        }
        let message = place.run(&format!("weights --order {order} --count 4"));
        assert_eq!(message.succeeded().stdout, table, "order {order}");
    }

    // The force falls by 10^(−μ) from decade to decade. The ramp of 10 ms is not a step: (1 − 5 ms/1 s)^(−μ) is 0.1 % more.
    let forces = ["1s", "10s", "100s"].map(|duration| {
        let line = "relax --contact rigid --ramp-time 10ms --out";
        let message = answer(&place, &format!("{line} {duration} --duration {duration}"));
        number(&message, "final_force_n")
    });
    for pair in forces.windows(2) {
        let ratio = pair[1] / pair[0];
        assert_relative("ratio", ratio, 10_f64.powf(-0.2247), 2e-3);
    }
    for (force, shown) in forces.iter().zip(["145 mN", "86 mN", "52 mN"]) {
        assert_eq!(format!("{:.0} mN", force * 1e3), shown);
        assert!(page.contains(shown), "{shown}");
    }

    // K ≤ b/(T/2 + delay)
    for (sample_time, delay) in [(1e-3, 0.0), (2e-3, 0.0), (1e-3, 1e-3)] {
        let wall = "--order 0 --mass 65g --damping 3.5 --stiffness 6.9kN/m --dissipation 0";
        let line = format!("analyze passivity {wall} --sample-time {sample_time} --delay {delay}");
        let by_hand = 3.5 / (sample_time / 2.0 + delay);
        agree(
            &answer(&place, &line),
            "largest_stiffness_n_per_m",
            by_hand,
            1e-6,
        );
        let shown = format!("{:.2}", by_hand / 1e3);
        assert!(
            page.contains(shown.trim_end_matches('0').trim_end_matches('.')),
            "{shown}"
        );
    }

    // Phase margin 90° − ω·delay, and the gain at which ω·delay is 90°; the hold is half a sample more.
    for gain in [1.0, 2.0] {
        let line = "control analyze --plant 1/s --delay 500ms --sample-time 1ms --controller";
        let message = answer(&place, &format!("{line} {gain}"));
        let late_s = 0.5 + 0.5e-3;
        agree(
            &message["margins"],
            "phase_margin_deg",
            (PI / 2.0 - gain * late_s).to_degrees(),
            1e-4,
        );
        agree(
            &message["margins"],
            "gain_up",
            PI / 2.0 / late_s / gain,
            1e-4,
        );
    }
}
