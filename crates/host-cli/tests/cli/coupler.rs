//! `run` of a `[coupler]` and `design --wish coupler`: couplers that are what they promise, and refusals.

use crate::process::{Place, cases, number, table};
use serde_json::Value;

/// A coupler of order 1 before a mass on a spring, stable on the dissertation's device.
const COUPLER: &str = "[coupler]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1\n\
                       coupler_stiffness_n_s_per_m = 2.0\ncoupler_dissipation_n_s_1_minus_mu_per_m = 3000.0\n\
                       object_stiffness_n_per_m = 1000.0\n";

#[track_caller]
fn near(have: f64, want: f64, tolerance: f64) {
    assert!(
        (have / want - 1.0).abs() <= tolerance,
        "have {have}, want {want}"
    );
}

#[test]
fn device_and_object_rest_where_the_springs_balance_the_push() {
    let place = Place::new();
    for (hand, device, object) in [
        (0.0, 1.0 / 750.0, 1e-3),
        // 250 N/m beside 750 N/m: three quarters of the push go through the coupler.
        (250.0, 1e-3, 0.75e-3),
    ] {
        place.write(
            "coupler.toml",
            format!("{COUPLER}hand_stiffness_n_per_m = {hand}\n"),
        );
        let ended = place.run("run coupler.toml --json --out run --overwrite");
        let report = ended.succeeded().json();
        assert_eq!(report["stable"], true, "{report}");
        assert_eq!(report["analysis_agrees"], true, "{report}");
        near(number(&report, "deflection_m"), device, 1e-6);
        near(number(&report, "expected_deflection_m"), device, 1e-12);
        near(number(&report, "object_position_m"), object, 1e-6);
        let error = number(&report, "max_relative_error");
        assert!(error > 0.0 && error < 1e-9, "{error:e}");
        let header = "time_s,position_m,object_position_m,reaction_force_n";
        let rows = table(&place.text("run/coupler.csv"), header);
        assert_eq!(rows.len(), 5001);
        // What is left at the end is rest: the force through the coupler moves the object's spring.
        let last = &rows[5000];
        near(last[3], 1000.0 * last[2], 1e-6);
        let svg = place.text("run/coupler.svg");
        assert!(svg.contains("object") && svg.contains("A trial of a coupler, simulated"));
        let check = place.run("log check run/coupler.mcap --json");
        assert_eq!(number(&check.succeeded().json(), "samples"), 5001.0);
    }
}

#[test]
fn below_order_one_it_creeps_and_the_force_is_judged() {
    let place = Place::new();
    let text = COUPLER
        .replace("order = 1", "order = 0.5")
        .replace("= 3000.0", "= 200.0");
    place.write("coupler.toml", text);
    let report = place.run("run coupler.toml --json --out run");
    let report = report.succeeded_with_warnings().json();
    assert_eq!(report["stable"], true, "{report}");
    for key in [
        "expected_deflection_m",
        "position_std_limit_m",
        "closed_form_error",
    ] {
        assert_eq!(report[key], Value::Null, "{key}");
    }
    assert!(number(&report, "max_relative_error") < 1e-5);
    // F = push − b·x' by now; without k_c the coupler alone would be at F·t^0.5/(b_c·Γ(1.5)) beyond the object.
    let rows = table(
        &place.text("run/coupler.csv"),
        "time_s,position_m,object_position_m,reaction_force_n",
    );
    let gap = |row: &[f64]| row[1] - row[2];
    let (early, late) = (&rows[1250], &rows[5000]);
    near(gap(late) / gap(early), 2.0, 0.05);
    near(
        gap(late),
        5.0_f64.sqrt() / (200.0 * libm::tgamma(1.5)),
        0.05,
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn llewellyn_and_the_sampled_loop_are_told_apart() {
    let place = Place::new();
    // 24 N·s/m on 5 g with 3 N·s/m: Llewellyn is content (8b ≥ k_c), the sampled loop is unstable.
    let text = COUPLER
        .replace("= 0.065", "= 0.005")
        .replace("= 3.5", "= 3.0")
        .replace("= 2.0", "= 23.9")
        .replace("= 3000.0", "= 0.0");
    place.write(
        "coupler.toml",
        format!("{text}object_mass_kg = 1\nmust_be_stable = true\n"),
    );
    let ended = place.run("run coupler.toml --json --out run").failed(1);
    assert!(ended.error().contains("must_be_stable"), "{ended}");
    assert!(ended.stderr.contains("unstable by the analysis"), "{ended}");
    let report = ended.json();
    let analysis = &report["preflight"];
    assert_eq!(analysis["stable"], false, "{report}");
    assert_eq!(analysis["coupler"]["llewellyn"], true, "{report}");
    near(
        number(&analysis["coupler"], "llewellyn_damping_n_s_per_m"),
        23.9 / 8.0,
        1e-9,
    );
    near(
        number(&analysis["coupler"], "sampled_damping_n_s_per_m"),
        23.9,
        1e-9,
    );
    // The other way round: stable here, but not with every hand.
    let text = COUPLER.replace("= 2.0", "= 40.0");
    place.write("coupler.toml", format!("{text}must_be_stable = true\n"));
    let ended = place.run("run coupler.toml --json --out other").failed(1);
    assert!(
        ended.stderr.contains("Llewellyn's criterion refuses it"),
        "{ended}"
    );
    let report = ended.json();
    assert_eq!(report["preflight"]["stable"], true, "{report}");
    assert_eq!(
        report["preflight"]["coupler"]["llewellyn"], false,
        "{report}"
    );
}

#[test]
fn a_wrong_file_is_refused_in_one_line() {
    let place = Place::new();
    for (from, to, want) in [
        (
            "order = 1",
            "order = 1.5",
            "coupler.toml:5: order = 1.5 is not from 0 to 1: change it",
        ),
        (
            "= 2.0",
            "= -1",
            "coupler.toml:6: coupler_stiffness_n_s_per_m = -1 is not from 0 to 1e6",
        ),
        (
            "= 1000.0",
            "= nan",
            "coupler.toml:8: object_stiffness_n_per_m = NaN is not from 0 to 1e8",
        ),
        (
            "object_stiffness_n_per_m = 1000.0",
            "object_stiffness_n_per_m = 0\nobject_mass_kg = 0\nobject_damping_n_s_per_m = 0",
            "object stiffness of an object without mass and damping 0 N/m is not above 0 N/m",
        ),
        ("mass_kg", "mas_kg", "did you mean `mass_kg`?"),
        ("order = 1\n", "", "missing key `order` in [coupler]"),
        (
            "= 2.0\ncoupler_dissipation_n_s_1_minus_mu_per_m = 3000.0",
            "= 0\ncoupler_dissipation_n_s_1_minus_mu_per_m = 0",
            "coupler dissipation of a coupler without stiffness 0",
        ),
        (
            "order",
            "one_sided = true\norder",
            "unknown key `one_sided` in [coupler]",
        ),
    ] {
        place.write("coupler.toml", COUPLER.replace(from, to));
        place.run("run coupler.toml --out run").refused(2, &[want]);
    }
    place.write("coupler.toml", COUPLER);
    place.refuses(
        "
        run coupler.toml --device serial:nowhere => a loop on the device cannot carry a coupler | --loop host
        run coupler.toml --force-unstable => --force-unstable | --device
        ",
    );
    assert_eq!(place.files(), ["coupler.toml"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_designed_coupler_runs_and_is_stable() {
    let place = Place::new();
    for (options, code) in [
        ("", 0),
        ("--require passive", 0),
        ("--hand-stiffness 500N/m --frequency 20Hz", 0),
        ("--mass 2g --damping 3", 0),
    ] {
        let line = format!(
            "design --wish coupler --sample-time 1ms --out design --overwrite --json {options}"
        );
        let report = place.run(&line).succeeded().json();
        assert_eq!(report["experiment"], "design/design.toml", "{report}");
        assert_eq!(report["simulated"]["stable"], true, "{report}");
        let text = place.text("design/design.toml");
        let ended = place.run("run design/design.toml --json --out run --overwrite");
        assert_eq!(ended.code, Some(code), "{options}: {ended} {text}");
        let run = ended.succeeded_with_warnings().json();
        assert_eq!(run["stable"], true, "{run}");
        assert_eq!(run["preflight"]["coupler"]["llewellyn"], true, "{run}");
        near(
            number(&run, "coupler_dissipation_n_s_1_minus_mu_per_m"),
            number(&report["best"], "dissipation"),
            1e-15,
        );
        let passive = options.contains("passive");
        assert_eq!(
            report["require"],
            if passive { "passive" } else { "llewellyn" }
        );
        assert!(!passive || run["preflight"]["passive"] == true, "{run}");
        assert!(number(&run["preflight"], "margin") >= 1.99, "{run}");
    }
}

#[test]
fn mass_and_hand_have_effect_on_a_designed_coupler() {
    let place = Place::new();
    let shares = |options: &str| -> Vec<f64> {
        let line = format!(
            "design --wish coupler --sample-time 1ms --damping 3 --orders 0,0.5,1 --json {options}"
        );
        let report = place.run(&line).succeeded().json();
        let candidates = report["candidates"].as_array().expect("candidates");
        candidates.iter().map(|c| number(c, "share")).collect()
    };
    assert_eq!(shares("--mass 65g"), [1.0; 3]);
    let light = shares("--mass 2g");
    assert!(light.iter().any(|share| *share < 0.9), "{light:?}");
    let held = shares("--mass 2g --hand-stiffness 2000N/m");
    assert_ne!(light, held);
}

#[test]
fn a_coupler_is_designed_up_to_order_one_and_none_above() {
    let place = Place::new();
    let line = "design --wish coupler --damping 2 --sample-time 1ms --orders 0.5,1,1.5 --json";
    let report = place.run(line).succeeded().json();
    let candidates = report["candidates"].as_array().expect("candidates").clone();
    assert_eq!(candidates.len(), 3);
    for candidate in &candidates[..2] {
        let order = number(candidate, "order");
        let (k, b) = (
            number(candidate, "stiffness"),
            number(candidate, "dissipation"),
        );
        // What the analysis says of it: passive, with nearly all the damping used.
        let verdict = place
            .run(&format!(
                "analyze coupling --order {order} --coupler-stiffness {k} --coupler-dissipation {b} \
                 --sample-time 1ms --damping 2 --json"
            ))
            .succeeded()
            .json();
        assert_eq!(verdict["passive"], true, "{verdict}");
        assert!(number(&verdict, "required_damping") > 1.99, "{verdict}");
    }
    assert!(candidates[2]["dissipation"].is_null() && candidates[2]["reason"].is_string());
    assert!(report["best"].is_object());
}

#[test]
fn what_has_no_effect_on_a_designed_coupler_is_refused() {
    let place = Place::new();
    for (options, words) in cases(
        "
        --frequency 0Hz => frequency_hz = 0 | --frequency
        --gain-margin 3 => gain_margin belongs to a wall
        --delay 1ms => ideal device | --delay
        ",
    ) {
        let line = format!("design --wish coupler {options}");
        place.run(&line).refused(2, &words);
    }
    // None: the report, exit code 1, no experiment, none of an earlier design left.
    // Its delay would be lost, and the coupler told as stable.
    place.write(
        "late.toml",
        "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\ndelay_s = 0.0005\n",
    );
    place
        .run("design --wish coupler --device-model late.toml")
        .refused(2, &["ideal device", "--device-model"]);
    // No delay is none.
    let ended = place.run("design --wish coupler --delay 0ms --out design");
    ended.succeeded();
    let ended = place.run("design --wish coupler --damping 0 --out design --overwrite --json");
    let ended = ended.failed(1);
    assert!(ended.error().contains("no damping"), "{ended}");
    let report = ended.json();
    assert_eq!(report["best"], Value::Null);
    assert_eq!(report["experiment"], Value::Null);
    assert_eq!(place.files(), ["design/", "design/design.csv", "late.toml"]);
}

#[test]
fn the_long_help_of_a_command_is_all_of_it() {
    let place = Place::new();
    for (line, words) in cases(
        "
        run --help => [coupler], to be given: | object_stiffness_n_per_m = 500, from 0 to 1e8
        design --help => Exit code 0 means | sampled_damping_n_s_per_m
        device emulate --help => the same state machine as in the firmware | --line-seed
        device flash --help => greets the device | Usage: host-cli device flash
        device monitor --help => without touching what it does | monitor-2.mcap
        analyze teleoperation --help => Llewellyn's criterion | time-domain is no linear law
        identify --help => relaxation | Usage: host-cli identify
        zwidth --help => JSON | analysis_stiffness_n_per_m
        relax --help => an indenter compresses a virtual tissue | Usage: host-cli relax
        ",
    ) {
        // Lines are broken to fit a terminal.
        let help = place.run(line).succeeded().stdout;
        let text: String = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in &words {
            assert!(text.contains(word), "{line}: no \"{word}\" in {help}");
        }
    }
}

/// On an emulated device, with the loop on the host.
#[cfg(unix)]
mod on_a_device {
    use super::COUPLER;
    use crate::devices::Emulated;
    use crate::process::number;

    #[test]
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    fn a_loop_on_the_host_carries_it_and_refuses_an_unstable_one() {
        // Its clock is slow, so that a busy machine is heard within the watchdog time.
        let device = Emulated::new("--speed 0.2");
        let place = device.place();
        // Soft enough for two samples of delay and more.
        let soft = COUPLER
            .replace("= 2.0", "= 0.5")
            .replace("= 3000.0", "= 60.0")
            .replace("= 1000.0", "= 100.0");
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
        // Too stiff for the delay, then too much for Llewellyn.
        place.write("coupler.toml", COUPLER.replace("= 3000.0", "= 90000.0"));
        let refused = place.run(&format!("{on} --out stiff"));
        refused.refused(
            2,
            &[
                "pre-flight",
                "coupled loop would be unstable",
                "--force-unstable",
            ],
        );
        let weak = soft.replace("= 3.5", "= 0.01");
        place.write("coupler.toml", weak);
        let refused = place.run(&format!("{on} --out weak"));
        refused.refused(2, &["pre-flight", "--force-unstable"]);
    }
}
