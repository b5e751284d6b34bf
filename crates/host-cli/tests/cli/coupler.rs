//! `run` of a `[coupler]` and `design --wish coupler`: couplers that are what they promise, and refusals.

use crate::process::{Place, number, table};
use serde_json::Value;
use testkit::assert_relative;

/// A coupler of order 1 before a mass on a spring, stable on the dissertation's device.
const COUPLER: &str = "[coupler]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.001\norder = 1\n\
                       coupler_stiffness_n_s_per_m = 2.0\ncoupler_dissipation_n_s_1_minus_mu_per_m = 3000.0\n\
                       object_stiffness_n_per_m = 1000.0\n";

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
        assert_relative("coupler", number(&report, "deflection_m"), device, 1e-6);
        assert_relative(
            "coupler",
            number(&report, "expected_deflection_m"),
            device,
            1e-12,
        );
        assert_relative(
            "coupler",
            number(&report, "object_position_m"),
            object,
            1e-6,
        );
        let error = number(&report, "max_relative_error");
        assert!(error > 0.0 && error < 1e-9, "{error:e}");
        let header = "time_s,position_m,object_position_m,reaction_force_n";
        let rows = table(&place.text("run/coupler.csv"), header);
        assert_eq!(rows.len(), 5001);
        // What is left at the end is rest: the force through the coupler moves the object's spring.
        let last = &rows[5000];
        assert_relative("coupler", last[3], 1000.0 * last[2], 1e-6);
        let svg = place.text("run/coupler.svg");
        assert!(svg.contains("object") && svg.contains("A trial of a coupler, simulated"));
        let check = place.run("log check run/coupler.mcap --json");
        assert_eq!(number(&check.succeeded().json(), "samples"), 5001.0);
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
        // Too stiff for the delay.
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
    }
}
