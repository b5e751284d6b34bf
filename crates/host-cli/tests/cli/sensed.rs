//! Runs on devices with a force sensor, from the device to the log and the report.

use crate::devices::{Emulated, at};
use crate::process::{Place, column};
use serde_json::Value;
use testkit::{assert_close, assert_says};

/// What the sensor shows beside the rendered force and the closed form, N.
fn differences(report: &Value, key: &str) -> [f64; 2] {
    ["rms_n", "largest_n"].map(|name| at(report, &format!("/sensed/{key}/{name}")))
}

/// A lag of 1 ms lags a ramp of 1 s by a thousandth of its force; the noise is 1 mN, and of some 2000 samples none is 5 σ off.
fn agrees(report: &Value) {
    let peak_n = at(report, "/peak_force_n");
    let [rms_n, largest_n] = differences(report, "from_rendered");
    assert!(
        (0.9e-3..=1.2e-3 + 0.002 * peak_n).contains(&rms_n),
        "{report}"
    );
    assert!(largest_n < 5e-3 + 0.01 * peak_n, "{report}");
}

#[test]
fn a_simulated_rig_with_a_force_sensor_has_a_column_a_picture_and_a_report() {
    let place = Place::new();
    let line = "relax contact=rigid duration=2s ramp_time=1s";
    let without = place.json(&format!("{line} --out without"));
    assert_eq!(without.get("sensed"), None);
    let report = place.json(&format!("{line} sensed_range=20N --out with"));
    agrees(&report);
    // It touches from the first tick on.
    assert!(report["sensed"]["offset_n"].is_null());
    // The force of the log's sensor is the record: two runs with other noise differ by √2·1 mN.
    let again = place.json(&format!(
        "{line} sensed_range=20N sensed_seed=2 --against with/relax.mcap --out again"
    ));
    assert_says(
        &again["against"]["notes"].to_string(),
        "that of the log's sensor",
    );
    let from_record = differences(&again, "from_record")[0];
    assert!((1.3e-3..1.55e-3).contains(&from_record), "{again}");
    let export = |name: &str| {
        let export = place
            .run(&format!("log export {name}/relax.mcap -"))
            .succeeded();
        (
            column(&export.stdout, "sensed_force_n"),
            column(&export.stdout, "commanded_force_n"),
        )
    };
    let (sensed, commanded) = export("with");
    let off = sensed
        .iter()
        .zip(&commanded)
        .map(|(sensed, commanded)| (sensed + commanded).abs());
    let seen = off.clone().filter(|off| off.is_finite()).count();
    assert!(seen > 1990, "{seen}");
    assert!(off.filter(|off| off.is_finite()).fold(0.0, f64::max) < 0.1);
    assert!(export("without").0.iter().all(|force| force.is_nan()));
    for (name, is_there) in [("with", true), ("without", false)] {
        place
            .run(&format!(
                "log plot {name}/relax.mcap --figure-format svg --out {name}/plot"
            ))
            .succeeded();
        let picture = place.text(&format!("{name}/plot/relax.log.svg"));
        assert_eq!(picture.contains("sensed force"), is_there, "{name}");
    }
}

/// Pressed at an angle to its axes and held: but for 1 mN of noise, 1 ms of lag and the mass, which meets the edge at 20 mm/s, a hand feels
/// the rendered force.
#[test]
fn a_touch_of_two_or_three_axes_has_its_sensed_force_along_the_rendered_one() {
    let place = Place::new();
    for (axes, normal, [out, within]) in [
        (2, "[3, 4]", ["-6e-3, -8e-3", "6e-3, 8e-3"]),
        (3, "[1, 2, 2]", ["-3e-3, -6e-3, -6e-3", "3e-3, 6e-3, 6e-3"]),
    ] {
        let touch = format!(
            "[touch]\naxes = {axes}\nshape = \"plane\"\nnormal = {normal}\nduration_s = 3\nsensed_range_n = 20\nsensed_offset_n = 0.3\n\
             way_points = [[0, {out}], [0.3, {out}], [1.3, {within}]]\n"
        );
        place.write("touch.toml", &touch);
        let report = place.json("run touch.toml --out run --overwrite --quiet");
        assert_close("value", at(&report, "/sensed/offset_n"), 0.3, 5e-4);
        let [rms_n, largest_n] = differences(&report, "from_rendered");
        let peak_n = at(&report, "/peak_force_n");
        assert!((0.9e-3..0.01 * peak_n).contains(&rms_n), "{report}");
        assert!(largest_n < 0.1 * peak_n, "{report}");
        assert!(report["sensed"]["from_closed_form"].is_null());
    }
}

/// Pressed into a wall: at rest the hand feels what the place does, in motion the sensor shows the true force but for its noise of 1 mN and
/// its lag of 1 ms.
#[test]
fn the_slave_of_a_teleoperation_senses_the_force_on_its_place() {
    let place = Place::new();
    let text = "[teleoperation]\nenvironment = \"wall\"\npress_m = 5e-3\namplitude_m = 1e-5\nduration_s = 4\nwindow_s = 2\n";
    place.write("plain.toml", text);
    place.write("sensed.toml", format!("{text}sensed_range_n = 20\n"));
    assert_eq!(place.json("run plain.toml --out plain").get("sensed"), None);
    let report = place.json("run sensed.toml --out sensed");
    assert!(differences(&report, "from_rendered")[0] < 0.2 * at(&report, "/slave_peak_n"));
    let export = place
        .run("log export sensed/teleoperation.mcap -")
        .succeeded();
    let [sensed, true_n] =
        ["sensed_force_n", "contact_force_n"].map(|name| column(&export.stdout, name));
    let off = sensed
        .iter()
        .zip(&true_n)
        .map(|(sensed, force)| sensed - force);
    let off: Vec<f64> = off.filter(|off| off.is_finite()).collect();
    let rms = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
    assert!(off.len() > 3900 && (0.9e-3..1.2e-3).contains(&rms), "{rms}");
}

#[test]
fn what_no_force_sensor_can_be_is_refused_in_a_line() {
    Place::with_examples().refuses(
        "
        relax sensed_noise=1mN => sensed_noise | sensed_range
        relax sensed_range=0N => sensed_range=0N | above 0
        relax sensed_range=1N sensed_offset=2N => offset of the force sensor 2 N | within its range
        relax --device serial:nowhere sensed_range=1N => sensed_range | omit
        run experiments/teleoperation.toml sensed_offset=1N => sensed_offset
        device emulate sensed_lag=1ms => sensed_range=20N
        device emulate sensed_range=1N sensed_offset=1N => within its range
        device emulate --kind moteus sensed_range=1N => --kind own
        device emulate sensed_range=1N facing_sensed_range=1N => --facing
        ",
    );
}

/// The plant of an emulated board waits until the force may rise in full: in that time the offset is measured.
#[test]
fn an_emulated_board_senses_its_tissue_from_the_wire_to_the_report() {
    let device = Emulated::new("--speed 8 sensed_range=20N sensed_offset=0.3N");
    let line = "relax --device serial:device watchdog=1s contact=rigid duration=2s ramp_time=1s --out run --quiet";
    let report = device.json(line);
    agrees(&report);
    // The mean of a hundred readings with 1 mN of noise: five times its own deviation.
    let offset_n = at(&report, "/sensed/offset_n");
    assert!((offset_n - 0.3).abs() < 5e-4, "{report}");
    let export = device.place.run("log export run/relax.mcap -").succeeded();
    let sensed = column(&export.stdout, "sensed_force_n");
    assert!(sensed[..99].iter().all(|force| force.is_nan()));
    assert!(sensed[99..300].iter().all(|force| force.abs() < 6e-3));
}

/// The hand of an emulated board pushes with 1 N, which the wall holds at the end.
#[test]
fn the_report_of_a_wall_has_its_sensed_force_beside_the_rendered_one() {
    let device = Emulated::new("--speed 8 sensed_range=20N");
    let wall = "[wall]\ndevice = \"serial:device\"\nwatchdog_s = 1\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
        sample_time_s = 0.001\norder = 1\nstiffness_n_per_m = 200\ndissipation_n_s_mu_per_m = 2\nforce_limit_n = 4\nduration_s = 3\n";
    device.place.write("wall.toml", wall);
    let info = device.json("device info --device serial:device");
    assert_eq!(at(&info, "/sensed_force_max_n"), 20.0);
    let report = device.json("run wall.toml --out run --quiet");
    for key in ["from_rendered", "from_closed_form"] {
        let [rms_n, largest_n] = differences(&report, key);
        assert!((0.9e-3..0.05).contains(&rms_n), "{report}");
        assert!(largest_n < 1.0, "{report}");
    }
    let [rms_n, _] = differences(&report, "rendered_from_closed_form");
    assert!(rms_n < 1e-6, "{report}");
    let export = device.place.run("log export run/wall.mcap -").succeeded();
    let sensed = column(&export.stdout, "sensed_force_n");
    assert_close(
        "sensed[sensed.len() - 1]",
        sensed[sensed.len() - 1],
        1.0,
        6e-3,
    );
}
