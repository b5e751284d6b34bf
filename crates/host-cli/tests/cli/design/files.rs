//! Experiment files of walls, good and bad.

use super::near;
use crate::experiments::NUMBERS;
use crate::process::{Place, number};
use serde_json::Value;
use std::path::Path;

/// A wall that is stable on the dissertation's device.
const WALL: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\n\
                    order = 0.5\nstiffness_n_per_m = 3000.0\ndissipation_n_s_mu_per_m = 100.0\n";

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_examples_run() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    for (kind, samples) in [
        ("relax", 20_001.0),
        ("creep", 20_001.0),
        ("wall", 2501.0),
        ("coupler", 5001.0),
    ] {
        let place = Place::new();
        let file = folder.join(format!("{kind}.toml"));
        let ended = place.run(&format!("run {} --json --out run", file.display()));
        let report = ended.succeeded().json();
        assert_eq!(number(&report, "samples"), samples, "{kind}");
        for key in NUMBERS {
            assert!(number(&report, key) > 0.0, "{kind}: {key}: {report}");
        }
        for key in ["closed_form_error", "missed_deadlines"] {
            assert!(number(&report, key) >= 0.0, "{kind}: {key}: {report}");
        }
        assert_eq!(report["device"], "sim");
        assert_eq!(report["log"], format!("run/{kind}.mcap"));
        assert_eq!(report["figure"], format!("run/{kind}.png"));
        let files = ["csv", "mcap", "png", "svg"].map(|e| format!("run/{kind}.{e}"));
        assert_eq!(place.files()[1..], files, "{kind}");
        assert!(!place.text(&format!("run/{kind}.csv")).contains("NaN"));
    }
}

#[test]
fn a_wall_rests_where_the_push_is_in_balance() {
    let place = Place::new();
    // Order 1 leaves nothing to creep: 1 N on 3000 + 200 N/m.
    let text = WALL
        .replace("order = 0.5", "order = 1\nhand_stiffness_n_per_m = 200")
        .replace("= 100.0", "= 10");
    place.write("wall.toml", text);
    let report = place.run("run wall.toml --json").succeeded().json();
    assert_eq!(report["stable"], true);
    near(number(&report, "deflection_m"), 1.0 / 3200.0, 1e-9);
    near(
        number(&report, "expected_deflection_m"),
        1.0 / 3200.0,
        1e-15,
    );
    assert!(number(&report, "position_std_m") < 1e-12);
    assert!(number(&report, "max_relative_error") < 1e-9);
    assert_eq!(report["log"], "results/wall-0001/wall.mcap");
    // A log like any other.
    let check = place.run("log check results/wall-0001/wall.mcap --json");
    assert_eq!(number(&check.succeeded().json(), "samples"), 2501.0);
}

#[test]
fn an_unstable_wall_is_a_result_with_a_warning() {
    let place = Place::new();
    place.write("wall.toml", WALL.replace("= 3000.0", "= 30000.0"));
    let ended = place.run("run wall.toml --json --out run");
    let warning = "warning: the wall is saturated: the force was at its limit in ";
    assert!(ended.stderr.starts_with(warning), "{ended}");
    let report = ended.succeeded_with_warnings().json();
    assert!(number(&report, "saturated_share") > 0.9, "{report}");
    assert_eq!(report["stable"], false);
    assert_eq!(report["closed_form_error"], Value::Null);
}

#[test]
fn a_guard_stills_an_unstable_wall() {
    let place = Place::new();
    // 8000 N/m: the observer leaves them, the bounding 2·0.8·b/T = 2800 N/m.
    for (guard, stiffness) in [("observer", 8000.0), ("energy-bounding", 2800.0)] {
        let text = WALL
            .replace("order = 0.5", &format!("guard = \"{guard}\"\norder = 0"))
            .replace("= 3000.0", "= 8000.0")
            .replace("= 100.0", "= 0.0");
        place.write("wall.toml", &text);
        let ended = place.run(&format!("run wall.toml --json --out {guard}"));
        let report = ended.succeeded_with_warnings().json();
        assert_eq!(report["stable"], true, "{guard}");
        near(number(&report, "deflection_m"), 1.0 / stiffness, 1e-3);
        assert!(number(&report, "limited_samples") > 0.0);
        let check = place.run(&format!("log check {guard}/wall.mcap --json"));
        assert_eq!(number(&check.succeeded().json(), "samples"), 2501.0);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wall_is_the_same_in_the_file_and_in_zwidths_terms() {
    // The boundary that zwidth finds by bisection: just below it is stable, just above not.
    let place = Place::new();
    let line = "zwidth --orders 1 --points 2 --sample-time 2ms --json";
    let report = place.run(line).succeeded_with_warnings().json();
    let first = &report["orders"][0]["boundary"][0];
    for (factor, stable) in [(0.99, true), (1.01, false)] {
        let stiffness = factor * number(first, "stiffness_max");
        let text = WALL
            .replace("order = 0.5", "order = 1")
            .replace("= 3000.0", &format!("= {stiffness:?}"))
            .replace("= 100.0", "= 0.0");
        place.write("wall.toml", text);
        let ended = place.run("run wall.toml --json --out run --overwrite");
        let report = ended.succeeded_with_warnings().json();
        assert_eq!(report["stable"], stable, "{factor}");
    }
}

/// What stands in [`WALL`], what is put in its place, and what is said; with a space at its end, how that begins.
const WRONG: &[(&str, &str, &str)] = &[
    (
        "= 0.065",
        "= 0",
        "wall.toml:2: mass_kg = 0 is not above 0 and at most 100: change it",
    ),
    (
        "order = 0.5",
        "order = -0.5",
        "wall.toml:5: order = -0.5 is not from 0 to 2: change it",
    ),
    (
        "sample_time_s = 0.002\n",
        "",
        "wall.toml:1: missing key `sample_time_s` in [wall]: give it",
    ),
    (
        "damping_n_s_per_m",
        "damping",
        "wall.toml:3: unknown key `damping` in [wall]: known are mass_kg, damping_n_s_per_m, sample_time_s, \
         order, stiffness_n_per_m, dissipation_n_s_mu_per_m, device_model, hand_stiffness_n_per_m, delay_s, friction_n, \
         current_lag_s, encoder_resolution_m, sensor_noise_m, seed, force_limit_n, force_rate_limit_n_per_s, \
         scheme, one_sided, impact_m_per_s, push_n, duration_s, window_s, \
         must_be_stable, device, loop, watchdog_s, late_ticks, max_age_ticks, guard, workspace_low_m, \
         workspace_high_m, speed_limit_m_per_s, rise_time_s, braking_n_s_per_m, stop_time_s, brake_force_n, \
         stuck_force_n, stuck_time_s, jump_m, device_mass_kg, device_damping_n_s_per_m, device_delay_least_s, \
         device_delay_most_s, device_lag_s, device_noise_m",
    ),
    (
        "mass_kg =",
        "mas_kg =",
        "wall.toml:2: unknown key `mas_kg` in [wall]: did you mean `mass_kg`?",
    ),
    (
        "= 3000.0",
        "= \"stiff\"",
        "wall.toml:6: stiffness_n_per_m = \"stiff\" is a string, not a number",
    ),
    (
        "= 100.0",
        "= inf",
        "wall.toml:7: dissipation_n_s_mu_per_m = inf is not from 0 to 1e8: change it",
    ),
    (
        WALL,
        "# nothing\n",
        "wall.toml:1: no experiment: an experiment file has one of [relax], [creep], [wall], [coupler], [teleoperation], [touch]",
    ),
    (
        "[wall]",
        "[wall]\nscheme = \"oustaloup:5:1:9e9\"",
        "wall.toml:2: ",
    ),
    (
        WALL,
        "[relax]\n\nstrain = 1.5\n",
        "wall.toml:3: strain = 1.5 is not above 0 and at most 1: change it, or omit it for 0.05",
    ),
];

#[test]
fn a_file_that_is_wrong_is_refused_in_one_line() {
    for &(from, to, want) in WRONG {
        let place = Place::new();
        assert!(WALL.contains(from), "{from}");
        place.write("wall.toml", WALL.replace(from, to));
        let ended = place.run("run wall.toml --out run").failed(2);
        let error = ended
            .error()
            .strip_prefix("error: ")
            .expect("an error")
            .to_owned();
        if want.ends_with(' ') {
            assert!(error.starts_with(want), "have {error}\nwant {want}");
        } else {
            assert_eq!(error, want);
        }
        assert_eq!(place.files(), ["wall.toml"], "{to}");
    }
    let place = Place::new();
    place
        .run("run none.toml")
        .refused(2, &["cannot read the experiment file `none.toml`"]);
}
