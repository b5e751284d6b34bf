//! A run rehearsed on an emulated board that is the device of a device file.

use crate::emulated::Emulated;
use crate::process::{Place, number};
use serde_json::Value;

/// Delay, lag, friction and encoder of a desktop device.
const DEVICE: &str = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\nfriction_n = 0.05\ndelay_s = 0.0013\n\
                      current_lag_s = 0.0005\nencoder_resolution_m = 1e-6\n";
const WALL: &str = "[wall]\ndevice_model = \"device.toml\"\nsample_time_s = 0.001\norder = 1\nstiffness_n_per_m = 900\n\
                    dissipation_n_s_mu_per_m = 1\nimpact_m_per_s = 0\npush_n = 0.5\nduration_s = 1.5\n";

/// A board that is a device.
fn board(device: &str) -> Emulated {
    let files = Place::new();
    files.write("device.toml", device);
    let file = files.path("device.toml");
    let board = Emulated::new(&format!("--device-model {}", file.display()));
    board.place().write("device.toml", device);
    board
}

/// Columns of a table of a run.
fn table(place: &Place, name: &str) -> Vec<Vec<f64>> {
    let text = place.text(name);
    let rows = text.lines().skip(1);
    let number = |cell: &str| cell.parse().expect("a number");
    rows.map(|row| row.split(',').map(number).collect())
        .collect()
}

fn preflight(report: &Value) -> [f64; 3] {
    ["margin", "delay_s", "current_lag_s"].map(|key| number(&report["preflight"], key))
}

#[test]
fn a_device_file_is_the_same_device_in_sim_and_on_a_board() {
    let board = board(DEVICE);
    board.loosen();
    board.place().write("wall.toml", WALL);
    let sim = board.json("run wall.toml --out sim");
    let there = board.json("run wall.toml --device serial:device watchdog=1s --out there");
    assert_eq!(preflight(&sim), preflight(&there));
    assert_eq!(preflight(&there)[1..], [0.0013, 0.0005]);
    assert_eq!(there["verdict"], sim["verdict"], "{there}");
    // The board's law is in single precision, which the encoder hides: a position may fall on the next count now and then.
    let (sim, there) = (
        table(board.place(), "sim/wall.csv"),
        table(board.place(), "there/wall.csv"),
    );
    assert_eq!(sim.len(), 1501);
    let largest = sim.iter().fold(0.0, |most: f64, row| most.max(row[1]));
    let off = sim.iter().zip(&there).map(|(a, b)| (a[1] - b[1]).abs());
    let off = off.fold(0.0, f64::max);
    assert!(largest > 4e-4, "{largest}");
    assert!(off <= 1.5e-6, "{off}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn without_steps_and_friction_a_board_moves_as_sim_does_to_single_precision() {
    let smooth = DEVICE
        .replace("friction_n = 0.05\n", "")
        .replace("encoder_resolution_m = 1e-6\n", "");
    let board = board(&smooth);
    board.loosen();
    board.place().write("wall.toml", WALL);
    board.json("run wall.toml --out sim");
    board.json("run wall.toml --device serial:device watchdog=1s --out there");
    let (sim, there) = (
        table(board.place(), "sim/wall.csv"),
        table(board.place(), "there/wall.csv"),
    );
    let off = |column: usize| {
        let largest = sim
            .iter()
            .fold(0.0, |most: f64, row| most.max(row[column].abs()));
        let differ = sim
            .iter()
            .zip(&there)
            .map(|(a, b)| (a[column] - b[column]).abs());
        differ.fold(0.0, f64::max) / largest
    };
    assert!(off(1) < 2e-6 && off(2) < 2e-6, "{} {}", off(1), off(2));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_design_writes_runs_in_sim_and_on_a_board() {
    let board = board(DEVICE);
    let place = board.place();
    let line = "design --device-model device.toml --sample-time 1ms force_limit=3N --orders 1 --out designed";
    place.run(line).succeeded_with_warnings();
    let sim = board.json("run designed/design.toml --out sim");
    let there =
        board.json("run designed/design.toml --device serial:device watchdog=1s --out there");
    assert!(there["ended_early"].is_null(), "{there}");
    assert_eq!(preflight(&there), preflight(&sim));
    assert_eq!(there["verdict"], "stable", "{there}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_simulated_plant_moves_once_the_force_has_risen() {
    let board = Emulated::new("");
    let report = |kind, device| {
        let report = board.json(&format!(
            "{kind} --device {device} --duration 2s precision=f32"
        ));
        // The ramp of the device is in its log alone.
        assert_eq!(number(&report, "limited_samples"), 0.0, "{report}");
        report
    };
    let there = report("relax", "serial:device watchdog=1s");
    let here = report("relax", "sim");
    for same in [
        "max_relative_error_samples",
        "closed_form_error",
        "final_over_theory",
    ] {
        let [there, here] = [&there, &here].map(|report| number(report, same));
        assert!(
            (there / here - 1.0).abs() < 1e-4,
            "{same}: {there}, in simulation {here}"
        );
    }
    // A push that began with the ramp would be 18 % off.
    let creep = report("creep", "serial:device watchdog=1s");
    assert!(number(&creep, "closed_form_error") < 0.01, "{creep}");
}
