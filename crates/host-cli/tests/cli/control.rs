//! `control`: from wishes to a controller, its loop, and back from a record to a plant.

mod identified;
mod refusals;
mod verdicts;

use crate::process::{Place, keys, number};
use serde_json::Value;

const OVEN: &str = "0.55exp(-s)/(62s+1)";
const PODLUBNY: &str = "1/(0.8s^2.2+0.5s^0.9+1)";

fn sorted<const N: usize>(mut keys: [&str; N]) -> Vec<&str> {
    keys.sort_unstable();
    keys.to_vec()
}

/// Keys of the report of a design.
const OF_A_DESIGN: [&str; 20] = [
    "plant",
    "sample_time_s",
    "scheme",
    "controller",
    "specification",
    "margins",
    "stable",
    "coarse",
    "stable_gain_low",
    "stable_gain_high",
    "robust",
    "overshoot_spread",
    "robustness",
    "shape",
    "limited_share",
    "integer",
    "integer_reason",
    "step",
    "controller_file",
    "files",
];

#[test]
fn a_design_meets_its_wishes_and_the_files_are_what_other_commands_take() {
    let place = Place::new();
    let line = format!(
        "control design --plant {OVEN} --crossover 0.1rad/s --phase-margin 65deg --output-limits 0:10 --out d --json"
    );
    let report = place.run(&line).succeeded().json();
    assert_eq!(keys(&report), sorted(OF_A_DESIGN));
    assert_eq!(report["stable"], true);
    let wishes = report["specification"].as_array().expect("a list");
    let names: Vec<&str> = wishes.iter().filter_map(|w| w["name"].as_str()).collect();
    assert_eq!(
        names,
        [
            "crossover_rad_s",
            "phase_margin_deg",
            "phase_slope_deg_per_decade"
        ]
    );
    assert!(wishes.iter().all(|wish| wish["met"] == true), "{wishes:?}");
    assert!((number(&wishes[1], "wanted") - 65.0).abs() < 1e-9);
    assert!((number(&wishes[1], "reached") / 65.0 - 1.0).abs() < 0.01);
    // Iso-damped: the PID of order 1 is at least three times worse.
    let (own, other) = (
        number(&report, "overshoot_spread"),
        number(&report["integer"], "overshoot_spread"),
    );
    assert!(other > 3.0 * own, "{own} {other}");
    assert_eq!(
        place.files(),
        [
            "d/",
            "d/controller.csv",
            "d/controller.png",
            "d/controller.svg",
            "d/controller.toml"
        ]
    );
    let line = format!("control analyze --plant {OVEN} --controller d/controller.toml --json");
    let analysis = place.run(&line).succeeded().json();
    assert!((number(&analysis["margins"], "phase_margin_deg") / 65.0 - 1.0).abs() < 0.01);
    // The step is that of the design.
    let line = format!("control simulate --plant {OVEN} --controller d/controller.toml --json");
    let run = place.run(&line).succeeded().json();
    let overshoot = |report: &Value| number(&report["shape"], "overshoot");
    assert!((overshoot(&run) - overshoot(&report)).abs() < 1e-9);
    // Nothing is overwritten unasked.
    let line = format!("control design --plant {OVEN} --crossover 0.1rad/s --out d");
    place
        .run(&line)
        .refused(2, &["controller", "already exists", "--overwrite"]);
}

#[test]
fn a_wish_that_is_not_met_ends_with_1_and_says_by_how_much() {
    let place = Place::new();
    let line = format!(
        "control design --plant {OVEN} --crossover 0.1rad/s --phase-margin 65deg --sensitivity-peak 1.01 --out d --json"
    );
    let ended = place.run(&line).failed(1);
    let said = ended.error();
    assert!(
        said.contains("not met: largest |S|") && said.contains("in place of 1.01 (+"),
        "{said}"
    );
    // The report is there all the same, and the file says so.
    let wishes = ended.json()["specification"].clone();
    let missed = wishes.as_array().expect("a list");
    let missed: Vec<&Value> = missed.iter().filter(|wish| wish["met"] == false).collect();
    assert_eq!(missed.len(), 1);
    assert_eq!(missed[0]["name"], "sensitivity_peak");
    assert!(
        place
            .text("d/controller.toml")
            .contains("note = \"not met: largest |S|")
    );
}

/// Podlubny's plant with and without his PD^μ: IEEE Trans. Automatic Control 44(1), 1999, figures 2 and 4.
#[test]
fn podlubnys_loop_is_as_published() {
    let place = Place::new();
    let line = format!(
        "control simulate --plant {PODLUBNY} --controller 20.5+3.7343s^1.15 --sample-time 1ms --duration 5s --out r --json"
    );
    let run = place.run(&line).succeeded_with_warnings().json();
    assert_eq!(run["stable"], true);
    // Without an integral it ends at 20.5/21.5.
    let last = run["step"]
        .as_array()
        .expect("samples")
        .last()
        .expect("one");
    assert!(
        (number(last, "output") - 20.5 / 21.5).abs() < 2e-3,
        "{last}"
    );
    assert!(run["integer"]["controller"].is_string());
    assert_eq!(place.text("r/response.csv").lines().count(), 5002);
    let alone = format!("control analyze --plant {PODLUBNY} --json");
    let alone = place.run(&alone).succeeded().json();
    assert_eq!(
        keys(&alone),
        sorted([
            "plant",
            "stable",
            "unstable_poles",
            "commensurate_order",
            "poles",
            "files"
        ])
    );
    assert!((number(&alone, "commensurate_order") - 0.1).abs() < 1e-9);
    let poles = alone["poles"].as_array().expect("poles");
    // mpmath: the root of 0.8s^2.2 + 0.5s^0.9 + 1 in the upper half-plane.
    let pole = poles.iter().find(|pole| number(pole, "im") > 0.0);
    let pole = pole.expect("a pair");
    assert!((number(pole, "re") + 0.108_42).abs() < 1e-4, "{pole}");
    assert!((number(pole, "im") - 1.197_02).abs() < 1e-4, "{pole}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_reason_of_a_verdict_is_said() {
    let place = Place::new();
    for (plant, controller, wanted) in [
        ("1/(s+1)", "2", &["Stable, and proved"][..]),
        (
            "1/(s+1)^3",
            "20",
            &["2 poles grow", "gain is too high", "below 0.394"],
        ),
        (
            "1/(s-1)",
            "0.5",
            // Above by hand, below 2/T of the samples.
            &[
                "one pole grows",
                "gain is too low",
                "Between 2 and 400 times",
            ],
        ),
        (
            "exp(-2s)/(s-1)",
            "2",
            &["because of the dead time", "up to 0.59"],
        ),
        ("1/s^2", "2", &["Neither a hundred times more"]),
        ("1/(s^4+1)", "2.0", &["more phase near 1 rad/s"]),
    ] {
        let line = format!(
            "control analyze --plant {plant} --controller {controller} --sample-time 10ms --out {}",
            controller.len() + plant.len()
        );
        let ended = place.run(&line).succeeded();
        for word in wanted {
            assert!(ended.stdout.contains(word), "{word}: {ended}");
        }
        // An answer is an answer; the margins of an unstable loop mean nothing.
        let stable = wanted[0].starts_with("Stable");
        assert_eq!(ended.stdout.contains("phase margin"), stable, "{ended}");
        let line = format!(
            "control analyze --plant {plant} --controller {controller} --sample-time 10ms --json"
        );
        let json = place.run(&line).succeeded().json();
        assert_eq!(json["stable"], stable);
        assert_eq!(json["margins"].is_null(), !stable, "{json}");
    }
}

#[test]
fn numbers_that_overflow_or_are_nothing_have_words() {
    let place = Place::new();
    let large = "control analyze --plant 1e60/(s+1) --controller 1e10 --sample-time 10ms";
    let large = place.run(large).succeeded().stdout;
    assert!(
        large.contains("Unstable, and proved: one pole grows") && !large.contains("boundary"),
        "{large}"
    );
    assert!(large.contains("1e60/(s+1)"), "{large}");
    let near = "control analyze --plant 1/(s^0.999994+1) --controller 2 --sample-time 10ms";
    let near = place.run(near).succeeded().stdout;
    assert!(near.contains("the order 0.999994 is next to 1"), "{near}");
    let slow = "control analyze --plant 1/(s+1) --controller 1.0000000001 --sample-time 10ms";
    let slow = place.run(slow).succeeded().stdout;
    assert!(
        // |L| = 1 at √(2e-10) rad/s, where π is left.
        slow.contains("Stable") && slow.contains("at 222140 s more dead time"),
        "{slow}"
    );
    let late =
        "control analyze --plant one.toml --controller 2+1/s --sample-time 100ms --delay 10s";
    place.write(
        "one.toml",
        "[state_space]\na = [[-1.0]]\nb = [1.0]\nc = [1.0]\n",
    );
    let late = place.run(late).succeeded().stdout;
    assert!(late.contains("because of the dead time"), "{late}");
    let rest = place
        .run("control analyze --plant 1/s^2")
        .succeeded()
        .stdout;
    assert!(rest.contains("at rest") && !rest.contains("NaN"), "{rest}");
    // λ⁴ + 1 and its like, whose companion matrix is cyclic.
    for plant in ["1/(s^4+1)", "1/(s^2+1)^2", "1/(s^3.7+1)", "cyclic.toml"] {
        place.write(
            "cyclic.toml",
            "[state_space]\na = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]\nb = [1.0, 0.0, 0.0]\nc = [0.0, 0.0, 1.0]\n",
        );
        let alone = format!("control analyze --plant {plant} --json");
        let report = place.run(&alone).succeeded().json();
        assert!(
            report["poles"]
                .as_array()
                .is_some_and(|poles| poles.len() > 1),
            "{plant}: {report}"
        );
    }
    let one = place
        .run("control analyze --plant one.toml")
        .succeeded()
        .stdout;
    assert!(one.contains("1 state, delay 0 s"), "{one}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn every_kind_of_controller_and_plant_runs() {
    let place = Place::new();
    let running = "\n[loop]\nsample_time_s = 0.01\noutput_low = -5\noutput_high = 5\n";
    for (name, text) in [
        (
            "tid.toml",
            "[tid]\ntilt_gain_per_s_1_over_n = 2\nintegral_gain_per_s = 0.5",
        ),
        (
            "crone.toml",
            "[crone]\ngain = 2\norder = 0.6\nlow_rad_s = 1\nhigh_rad_s = 100",
        ),
        (
            "lead.toml",
            "[lead_lag]\ngain = 5\nlambda_s = 0.5\nx = 0.1\norder = 0.7",
        ),
        (
            "function.toml",
            "[transfer_function]\nfunction = \"3(s^0.5+1)/s^0.5\"",
        ),
        (
            "pid.toml",
            "[pid]\nproportional_gain = 3\nintegral_gain_per_s_lambda = 2\nset_point_weight = 0.8",
        ),
    ] {
        place.write(name, format!("{text}{running}"));
    }
    place.write("device.toml", "[device]\nmass_kg = 0.5\ndamping_n_s_per_m = 3\nhand_stiffness_n_per_m = 1\ncurrent_lag_s = 0.01\n");
    place.write(
        "states.toml",
        "[state_space]\na = [[-1.0]]\nb = [1.0]\nc = [1.0]\ndelay_s = 0.05\n",
    );
    place.write("ramp.csv", "time_s,reference\n0,0\n1,0.5\n2,1\n4,1\n");
    for controller in ["tid", "crone", "lead", "function", "pid"] {
        for plant in [
            "--plant device.toml",
            "--plant states.toml",
            "--mass 500g --damping 3 --hand-stiffness 1",
        ] {
            let line = format!(
                "control simulate {plant} --controller {controller}.toml --reference ramp.csv --json"
            );
            let run = place.run(&line).succeeded_with_warnings().json();
            assert_eq!(run["stable"], true, "{line}");
            assert!(run["shape"].is_null());
            let samples = run["step"].as_array().expect("samples");
            assert_eq!(samples.len(), 401, "{line}");
            assert_eq!(
                (&samples[150]["reference"], &samples[200]["reference"]),
                (&0.5.into(), &1.0.into())
            );
            let line = format!("control analyze {plant} --controller {controller}.toml");
            place.run(&line).succeeded();
        }
    }
}

#[test]
fn a_measured_response_can_be_designed_for() {
    let place = Place::new();
    let rows: String = (0..400)
        .map(|k| {
            let omega = 1e-4 * 1.04_f64.powi(k);
            // 0.55·e^(−s)/(62 s + 1)
            let gain = 0.55 / (62.0 * omega).hypot(1.0);
            let phase = -omega - (62.0 * omega).atan();
            format!("{omega},{gain},{}\n", phase.to_degrees())
        })
        .collect();
    place.write("oven.csv", format!("omega_rad_s,gain,phase_deg\n{rows}"));
    let wishes = "--crossover 0.1rad/s --phase-margin 65deg --sample-time 0.2s --json";
    let of = |plant: &str| {
        let line = format!("control design --plant {plant} {wishes}");
        place.run(&line).succeeded().json()
    };
    let (measured, known) = (of("oven.csv"), of(OVEN));
    let gain = |report: &Value| number(&report["controller"], "proportional_gain");
    assert!((gain(&measured) / gain(&known) - 1.0).abs() < 0.3);
    assert!(measured["stable"].is_null() && measured["shape"].is_null());
    place
        .run("control analyze --plant oven.csv --controller 2 --sample-time 1s")
        .refused(2, &["a measured response can be tuned for, not run"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_plant_comes_back_from_its_own_step() {
    let place = Place::new();
    let line = format!("control simulate --plant {PODLUBNY} --duration 20s --out r");
    place.run(&line).succeeded();
    let line = "control identify r/response.csv --input command --out p.toml --json";
    let found = place.run(line).succeeded().json();
    assert_eq!(
        keys(&found),
        sorted([
            "function",
            "delay_s",
            "samples",
            "sample_time_s",
            "rms_residual",
            "fit",
            "bic",
            "unstable_poles",
            "numbers",
            "candidates",
            "plant_file",
            "files",
            "warnings"
        ])
    );
    let value = |name: &str| {
        let numbers = found["numbers"].as_array().expect("numbers");
        let own = numbers.iter().find(|own| own["name"] == name);
        number(own.expect("named"), "value")
    };
    for (name, wanted) in [
        ("denominator_coefficient_1", 0.8),
        ("denominator_order_1", 2.2),
        ("denominator_coefficient_2", 0.5),
        ("denominator_order_2", 0.9),
    ] {
        assert!(
            (value(name) - wanted).abs() < 1e-4,
            "{name}: {}",
            value(name)
        );
    }
    assert_eq!(
        place.files(),
        [
            "p.png",
            "p.svg",
            "p.toml",
            "r/",
            "r/response.csv",
            "r/response.png",
            "r/response.svg"
        ]
    );
    place.run("control analyze --plant p.toml").succeeded();
    place.run(line).refused(2, &["p.toml"]);
}
