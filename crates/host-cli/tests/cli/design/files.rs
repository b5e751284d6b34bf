//! Experiment files of walls, good and bad.

use crate::process::{Place, number};
use serde_json::Value;
use testkit::assert_relative;

/// A wall that is stable on the dissertation's device.
const WALL: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\n\
                    order = 0.5\nstiffness_n_per_m = 3000.0\ndissipation_n_s_mu_per_m = 100.0\n";

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
    assert_relative(
        "design",
        number(&report, "deflection_m"),
        1.0 / 3200.0,
        1e-9,
    );
    assert_relative(
        "design",
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
        assert_relative(
            "design",
            number(&report, "deflection_m"),
            1.0 / stiffness,
            1e-3,
        );
        assert!(number(&report, "limited_samples") > 0.0);
        let check = place.run(&format!("log check {guard}/wall.mcap --json"));
        assert_eq!(number(&check.succeeded().json(), "samples"), 2501.0);
    }
}

/// What is wrong with files is tested where they are read, in `haptic-experiment`.
#[test]
fn a_file_that_is_wrong_is_refused_in_one_line_with_its_place() {
    let place = Place::new();
    place.write("wall.toml", WALL.replace("= 3000.0", "= \"stiff\""));
    place.refuses(
        "
        run wall.toml --out run => wall.toml:6: stiffness_n_per_m = \"stiff\" is a string, not a number
        run none.toml => cannot read the experiment file `none.toml`
        ",
    );
    assert_eq!(place.files(), ["wall.toml"]);
}
