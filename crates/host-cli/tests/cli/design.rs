//! `design`: walls that are what they promise.

use crate::devices::Emulated;
use crate::process::{Place, number, row, table};
use serde_json::Value;
use testkit::{assert_relative, assert_says};

/// Runs a design that must succeed without a word on standard error.
fn design(place: &Place, options: &str) -> Value {
    let ended = place.run(&format!("design --json --out design {options}"));
    ended.succeeded_with_warnings().json()
}

/// Runs the designed experiment, with its stiffness `factor` times as large.
fn settles(place: &Place, factor: f64) -> bool {
    let text = place.text("design/design.toml");
    let line = |line: &str| match line.strip_prefix("stiffness_n_per_m = ") {
        Some(stiffness) => {
            let stiffness: f64 = stiffness.parse().expect("a number");
            format!("stiffness_n_per_m = {:?}", factor * stiffness)
        }
        None => line.to_owned(),
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    place.write("trial.toml", lines.join("\n"));
    let ended = place.run("run trial.toml --json --out trial --overwrite");
    // The file says that the wall must be stable.
    let code = ended.code.expect("ended by itself");
    let report = ended.json();
    let stable = report["stable"].as_bool().expect("a verdict");
    let agrees = report["analysis_agrees"].as_bool().expect("a comparison");
    assert_eq!(code == 0, stable && agrees, "{ended}");
    stable
}

#[test]
fn what_cannot_be_is_said_in_words() {
    let place = Place::new();
    let line = "design --require passive --damping 0 --out design";
    // Nothing was found: the report, and exit code 1.
    let ended = place.run(line).failed(1);
    assert_says(ended.error(), "no candidate meets the wish");
    let words = "none is passive: the device has no damping";
    assert_eq!(ended.stdout.matches(words).count(), 10, "{ended}");
    assert!(!ended.stdout.contains("best"), "{ended}");
    assert_eq!(place.files(), ["design/", "design/design.csv"]);
    assert!(!place.text("design/design.csv").contains("NaN"));
}

const DESK: &str = "--device-model laboratory --mass 45g --damping 0.2 --sample-time 1ms --force-limit 3.3N --orders 0,0.5,1,1.5,2";

/// Between orders 1 and 2 the stiffest walls of a device with delay are stable alone, and not as contact that is lost and found.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_design_for_every_motion_has_walls_that_are_proved_and_no_others() {
    let place = Place::new();
    let walls = |require: &str| {
        let line = format!("{DESK} gain_margin=1.2 --require {require} --overwrite");
        let report = design(&place, &line);
        assert_eq!(report["require"], require);
        let candidates = report["candidates"].as_array().expect("a list").iter();
        let keys = [
            "order",
            "stiffness_n_per_m",
            "margin",
            "pulling_contact_margin",
        ];
        let walls = candidates.map(|wall| keys.map(|key| wall[key].as_f64()));
        walls.collect::<Vec<_>>()
    };
    let (stable, proved) = (walls("stable"), walls("every-motion"));
    assert!(stable.iter().any(|wall| wall[3] < Some(1.0)), "{stable:?}");
    for (wall, of_all) in proved.iter().zip(&stable) {
        let [_, stiffness, margin, every_motion] = wall;
        let is_none = stiffness.is_none();
        assert!(
            is_none || (*margin >= Some(1.2) && *every_motion >= Some(1.0)),
            "{wall:?}"
        );
        assert!(*stiffness <= of_all[1], "{wall:?} {of_all:?}");
        assert!(
            of_all[3] < Some(1.0) || stiffness == &of_all[1],
            "{wall:?} {of_all:?}"
        );
    }
}

#[test]
fn a_design_for_the_device_on_the_desk_runs_there() {
    let place = Place::new();
    let report = design(&place, DESK);
    assert_eq!(report["ideal_device_assumed"], false);
    assert_eq!(report["realistic"], Value::Null);
    let asked = ["mass_kg", "damping_n_s_per_m", "sample_time_s"];
    assert_eq!(asked.map(|key| number(&report, key)), [0.045, 0.2, 1e-3]);
    for (key, want) in [
        ("friction_n", 0.05),
        ("delay_s", 0.5e-3),
        ("current_lag_s", 1e-3),
        ("encoder_resolution_m", 1e-6),
    ] {
        assert_eq!(number(&report["imperfections"], key), want, "{key}");
    }
    assert_eq!(report["simulated"]["verdict"], "stable");
    assert!(settles(&place, 1.0));
    assert!(!settles(&place, 3.0));
}

#[test]
fn a_design_that_assumes_an_ideal_device_says_so_and_shows_a_realistic_one() {
    let place = Place::new();
    let report = design(&place, "--orders 2");
    assert_eq!(report["ideal_device_assumed"], true);
    assert_eq!(report["best"]["force_noise_rms_n"], Value::Null);
    // Order 2 is the stiffest on paper and the first to shake where the current lags.
    let real = &report["realistic"];
    assert_eq!(real["analysis_stable"], false);
    assert!(number(real, "margin") < 0.2, "{real}");
    assert_eq!(real["simulated"]["stable"], false);
    let message = place.run("design --orders 2").succeeded_with_warnings();
    assert_says(&message.stderr, "this is for an ideal device & saturated");
    assert_eq!(row(&message.stdout, "ideal device assumed"), "yes");
}

/// A wall that is stable on the dissertation's device.
const WALL: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\n\
                    order = 0.5\nstiffness_n_per_m = 3000.0\ndissipation_n_s_mu_per_m = 100.0\n";

#[test]
fn a_wall_rests_where_the_push_is_in_balance() {
    let place = Place::new();
    // Order 1 leaves nothing to creep: 1 N on 3000 + 200 N/m.
    let held = WALL.replace("order = 0.5", "order = 1\nhand_stiffness_n_per_m = 200");
    place.write("wall.toml", held.replace("= 100.0", "= 10"));
    let report = place.json("run wall.toml");
    assert_eq!(report["stable"], true);
    for (key, tolerance) in [("deflection_m", 1e-9), ("expected_deflection_m", 1e-15)] {
        assert_relative(key, number(&report, key), 1.0 / 3200.0, tolerance);
    }
    assert!(number(&report, "position_std_m") < 1e-12);
    assert!(number(&report, "max_relative_error") < 1e-9);
    assert_eq!(report["log"], "results/wall-0001/wall.mcap");
    has_samples(&place, "results/wall-0001/wall.mcap", 2501.0);
}

/// A log like any other.
fn has_samples(place: &Place, log: &str, samples: f64) {
    let check = place.json(&format!("log check {log}"));
    assert_eq!(number(&check, "samples"), samples);
}

#[test]
fn an_unstable_wall_is_a_result_with_a_warning() {
    let place = Place::new();
    place.write("wall.toml", WALL.replace("= 3000.0", "= 30000.0"));
    let ended = place.run("run wall.toml --json --out run");
    let warning = "warning: the wall is saturated: the force was at its limit for ";
    assert!(ended.stderr.starts_with(warning), "{ended}");
    let report = ended.succeeded_with_warnings().json();
    assert!(number(&report, "saturated_s") > 4.5, "{report}");
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
            guard,
            number(&report, "deflection_m"),
            1.0 / stiffness,
            1e-3,
        );
        assert!(number(&report, "limited_samples") > 0.0);
        has_samples(&place, &format!("{guard}/wall.mcap"), 2501.0);
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

/// A coupler of order 1 before a mass on a spring, stable on the dissertation's device.
const COUPLER: &str = "[coupler]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1\n\
                       coupler_damping_n_s_per_m = 2.0\ncoupler_spring_n_s_1_minus_mu_per_m = 3000.0\n\
                       object_stiffness_n_per_m = 1000.0\n";

#[test]
fn device_and_object_rest_where_the_springs_balance_the_push() {
    let place = Place::new();
    for (hand, device, object) in [
        (0.0, 1.0 / 750.0, 1e-3),
        // 250 N/m beside 750 N/m: three quarters of the push go through the coupler.
        (250.0, 1e-3, 0.75e-3),
    ] {
        let file = format!("{COUPLER}hand_stiffness_n_per_m = {hand}\n");
        place.write("coupler.toml", file);
        let ended = place.run("run coupler.toml --json --out run --overwrite");
        let report = ended.succeeded().json();
        assert_eq!(report["stable"], true, "{report}");
        assert_eq!(report["analysis_agrees"], true, "{report}");
        for (key, want, tolerance) in [
            ("deflection_m", device, 1e-6),
            ("expected_deflection_m", device, 1e-12),
            ("object_position_m", object, 1e-6),
        ] {
            assert_relative(key, number(&report, key), want, tolerance);
        }
        let error = number(&report, "max_relative_error");
        assert!(error > 0.0 && error < 1e-9, "{error:e}");
        let header = "time_s,position_m,object_position_m,reaction_force_n";
        let rows = table(&place.text("run/coupler.csv"), header);
        assert_eq!(rows.len(), 5001);
        // What is left at the end is rest: the force through the coupler moves the object's spring.
        let last = &rows[5000];
        assert_relative("rest", last[3], 1000.0 * last[2], 1e-6);
        let svg = place.text("run/coupler.svg");
        assert_says(&svg, "object & A trial of a coupler, simulated");
        has_samples(&place, "run/coupler.mcap", 5001.0);
    }
}

#[test]
fn a_coupler_that_cannot_be_is_refused_or_not_found() {
    let place = Place::new();
    // Its delay would be lost, and the coupler told as stable.
    place
        .run("design --wish coupler --delay 1ms")
        .refused(2, &["ideal device", "--delay"]);
    let ended = place.run("design --wish coupler --out design");
    ended.succeeded();
    // None: the report, exit code 1, no experiment, none of an earlier design left.
    let ended = place.run("design --wish coupler --damping 0 --out design --overwrite --json");
    let ended = ended.failed(1);
    assert!(ended.error().contains("no damping"), "{ended}");
    let report = ended.json();
    assert_eq!(report["best"], Value::Null);
    assert_eq!(report["experiment"], Value::Null);
    assert_eq!(place.files(), ["design/", "design/design.csv"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_loop_on_the_host_carries_it_and_refuses_an_unstable_one() {
    // Its clock is slow, so that a busy machine is heard within the watchdog time.
    let device = Emulated::new("--speed 0.2");
    let place = device.place();
    // Soft enough for two samples of delay and more.
    let soft = [
        ("= 2.0", "= 0.5"),
        ("= 3000.0", "= 60.0"),
        ("= 1000.0", "= 100.0"),
    ];
    let soft = soft.iter().fold(COUPLER.to_owned(), |text, (from, to)| {
        text.replace(from, to)
    });
    place.write(
        "coupler.toml",
        format!("{soft}duration_s = 0.4\nwindow_s = 0.1\n"),
    );
    let on = "run coupler.toml --device serial:device --loop host max_age_ticks=1000 watchdog=1s --quiet";
    let ended = place.run(&format!("{on} --out soft --json"));
    if ended.code == Some(2) {
        // The delay is measured, and that of a busy machine counts.
        ended.refused(2, &["pre-flight", "--force-unstable"]);
        testkit::skip_for_load("a loop on the host is not stable at the delay measured");
        return;
    }
    let report = ended.succeeded_with_warnings().json();
    let analysis = &report["preflight"];
    assert_eq!(analysis["stable"], true, "{report}");
    assert!(number(analysis, "delay_samples") >= 2.0, "{report}");
    assert_eq!(analysis["coupler"]["llewellyn"], true, "{report}");
    assert!(number(&report, "object_position_m") > 1e-3, "{report}");
    // Too stiff for the delay.
    place.write("coupler.toml", COUPLER.replace("= 3000.0", "= 90000.0"));
    let words = [
        "pre-flight",
        "coupled loop would be unstable",
        "--force-unstable",
    ];
    place.run(&format!("{on} --out stiff")).refused(2, &words);
}
