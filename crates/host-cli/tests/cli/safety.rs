//! The safety chain as options, keys of files and parameters of devices.

#[cfg(unix)]
mod device;

use crate::process::{Place, cases, number, says, table};
use serde_json::Value;

/// Header of `log export`.
const COLUMNS: &str = "tick,time_s,reference_m,indenter_position_m,position_m,environment_force_n,\
                       commanded_force_n,applied_force_n,contact_force_n,limiters,flaws,observed_energy_j";
const FORCE: usize = 6;
const LIMITERS: usize = 9;
const ENERGY: usize = 11;

/// 8000 N/m on the dissertation's device: it shakes.
const SHAKING: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 2e-3\norder = 0\n\
                       stiffness_n_per_m = 8000\ndissipation_n_s_mu_per_m = 0\n";
/// 50 µm·1000 s⁻¹ = 50 mm/s in the ramp, 1 mm held.
const RELAX: &str = "relax --contact rigid --duration 3s --ramp-time 0.5s --out run";

fn ticks(place: &Place, log: &str) -> Vec<Vec<f64>> {
    let export = place.run(&format!("log export {log} ticks.csv --overwrite"));
    export.succeeded();
    table(&place.text("ticks.csv"), COLUMNS)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_guard_given_as_an_option_overrides_the_file_and_its_energy_is_logged() {
    let place = Place::new();
    place.write("wall.toml", SHAKING);
    let run = |options: &str| {
        let ended = place.run(&format!("run wall.toml --json {options}"));
        ended.succeeded_with_warnings().json()
    };
    assert_eq!(run("--out off")["stable"], false);
    let off = ticks(&place, "off/wall.mcap");
    assert!(off.iter().all(|row| row[ENERGY].is_nan()));
    for guard in ["observer", "energy-bounding"] {
        let report = run(&format!("--guard {guard} --out {guard}"));
        assert_eq!(report["stable"], true, "{guard}");
        let rows = ticks(&place, &format!("{guard}/wall.mcap"));
        assert!(rows.iter().all(|row| row[ENERGY].is_finite()), "{guard}");
        assert!(rows.iter().any(|row| row[ENERGY] != 0.0), "{guard}");
        assert!(
            rows.iter().any(|row| row[LIMITERS] as u8 & 128 != 0),
            "{guard}"
        );
    }
    place.write("wall.toml", format!("{SHAKING}guard = \"observer\"\n"));
    assert_eq!(run("--guard off --out again")["stable"], false);
    let again = ticks(&place, "again/wall.mcap");
    assert!(
        off.iter()
            .zip(&again)
            .all(|(a, b)| a[..ENERGY] == b[..ENERGY])
    );
}

#[test]
fn energy_bounding_knows_delay_lag_and_encoder_of_a_simulated_device() {
    let place = Place::new();
    let late = format!(
        "{SHAKING}delay_s = 1.3e-3\ncurrent_lag_s = 1e-3\nencoder_resolution_m = 1e-6\nguard = \"energy-bounding\"\n"
    );
    place.write("wall.toml", &late);
    let ended = place.run("run wall.toml --json --out late");
    assert_eq!(ended.succeeded_with_warnings().json()["stable"], true);
    place.write("wall.toml", late.replace("1.3e-3", "8.1e-3"));
    place.run("run wall.toml --out later").refused(
        2,
        &[
            "delay of the guard 0.0081 s",
            "from the least delay to 4 sample times",
            "another guard",
        ],
    );
    // What is told goes before what is simulated, and is in the log.
    place.write("wall.toml", late);
    place
        .run("run wall.toml device_delay_least=1ms device_delay_most=1.5ms device_lag=1ms --out told")
        .succeeded_with_warnings();
    let info = place
        .run("log info told/wall.mcap --json")
        .succeeded()
        .json();
    says(
        &info.to_string(),
        &[
            "device_delay_least_s",
            "device_delay_most_s",
            "device_lag_s",
        ],
    );
    for (options, words) in cases(
        "
        device_delay_least=2ms device_delay_most=1ms => device_delay_most_s = 0.001 is below
        device_delay_least=-1ms device_delay_most=-1ms => device_delay_least_s = -0.001 is not from 0 to 1
        device_delay_least=1kg device_delay_most=1kg => 1kg | a time
        ",
    ) {
        place
            .run(&format!("run wall.toml {options}"))
            .refused(2, &words);
    }
}

#[test]
fn limits_end_or_shape_a_run_on_the_simulated_rig() {
    let place = Place::new();
    // 1 mm is asked for.
    for (limit, word) in [
        ("workspace_low=-1mm workspace_high=0.5mm", "workspace"),
        ("speed_limit=1mm/s", "faster"),
    ] {
        let ended = place.run(&format!("{RELAX} {limit} --overwrite"));
        ended.failed(1);
        let check = place
            .run("log check run/relax.mcap --json")
            .succeeded()
            .json();
        assert!(check["events"].to_string().contains(word), "{check}");
    }
    let within = "workspace_low=-1mm workspace_high=1.5mm speed_limit=10mm/s braking=2 --overwrite";
    place
        .run(&format!("{RELAX} {within}"))
        .succeeded_with_warnings();
    // From the start on the force rises for a second.
    let rising = place.run(&format!("{RELAX} rise_time=1s --overwrite --json"));
    assert!(number(&rising.succeeded_with_warnings().json(), "limited_samples") >= 1000.0);
    let rows = ticks(&place, "run/relax.mcap");
    for row in rows.iter().filter(|row| row[0] != 1000.0) {
        assert_eq!(
            row[LIMITERS] as u8,
            if row[0] < 1000.0 { 16 } else { 0 },
            "{row:?}"
        );
    }
    // The same from a file.
    place.write(
        "relax.toml",
        "[relax]\ncontact = \"rigid\"\nduration_s = 3\nramp_time_s = 0.5\nrise_time_s = 1\nguard = \"off\"\n",
    );
    place
        .run("run relax.toml --out file")
        .succeeded_with_warnings();
    let same = ticks(&place, "file/relax.mcap");
    assert!(
        rows.iter()
            .zip(&same)
            .all(|(a, b)| a[..ENERGY] == b[..ENERGY])
    );
}

#[test]
fn a_run_that_ends_has_no_force_after_its_stop_time() {
    let place = Place::new();
    // Pushed beyond its workspace against a slow wall: the fault comes at some newton.
    let slow = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 1e-3\norder = 0\n\
                stiffness_n_per_m = 2000\ndissipation_n_s_mu_per_m = 0\nforce_rate_limit_n_per_s = 2\n\
                push_n = 3\nduration_s = 3\nworkspace_low_m = -1\nworkspace_high_m = 0.2\n";
    place.write("wall.toml", slow);
    for (options, ticks) in [("", 100), ("stop_time=30ms", 30)] {
        place
            .run(&format!("run wall.toml --out run --overwrite {options}"))
            .failed(1);
        let rows = ticks_after_fault(&place);
        assert!(rows[0].abs() > 0.1, "{rows:?}");
        // The fault is latched in a tick that falls already.
        assert!(rows[ticks - 2].abs() > 0.0, "{options}: {rows:?}");
        assert!(rows[ticks - 1..].iter().all(|f| *f == 0.0), "{options}");
        let falls = rows.windows(2).all(|pair| pair[1].abs() <= pair[0].abs());
        assert!(falls, "{options}: {rows:?}");
    }
}

/// Forces from the tick of the fault on.
fn ticks_after_fault(place: &Place) -> Vec<f64> {
    let rows = ticks(place, "run/wall-fault.mcap");
    let after = rows.iter().filter(|row| row[LIMITERS] as u8 & 4 != 0);
    after.map(|row| row[FORCE]).collect()
}

/// Lines of `[relax]`, and what is said of them.
const WRONG: &[(&str, [&str; 2])] = &[
    (
        "workspace_low_m = 0",
        ["workspace.toml:2", "workspace_high_m"],
    ),
    (
        "workspace_high_m = 0",
        ["workspace.toml:2", "workspace_low_m"],
    ),
    (
        "workspace_low_m = 0\nworkspace_high_m = -1",
        ["workspace.toml:3", "not above"],
    ),
    ("rise_time_s = 0", ["workspace.toml:2", "not above 0"]),
    ("stop_time_s = 2", ["workspace.toml:2", "from 0.001 to 1"]),
    ("brake_force_n = 20", ["workspace.toml:2", "from 0 to 10"]),
    ("jump_m = -1", ["workspace.toml:2", "from 0 to 1"]),
    (
        "jump_m = 1e-9",
        ["jump 1e-9 m has no effect", "speed_limit_m_per_s"],
    ),
    (
        "jump_m = nan",
        ["workspace.toml:2", "from 0 to 1: change it"],
    ),
    (
        "watchdog_s = 0.0054",
        ["workspace.toml:2", "whole number of milliseconds"],
    ),
    (
        "strain = 0.1\nstrain = 0.2",
        ["workspace.toml:3", "duplicate key `strain`"],
    ),
    (
        "speed_limit_m_per_s = -1",
        ["workspace.toml:2", "not above 0"],
    ),
];

#[test]
fn limits_that_are_none_are_refused() {
    let place = Place::new();
    for (options, words) in cases(
        "
        workspace_low=1mm => workspace_low=1mm: a workspace has two ends
        workspace_low=1mm workspace_high=2kg => 2kg | length
        braking=0 => braking_n_s_per_m = 0 is not above 0
        # On the rig's renderer of 65 g, and on one of 1 g.
        braking=1000 => braking 1000 N·s/m is not at most | take less braking
        braking=5 device_mass=1g => at most 1 N·s/m | take less braking
        stop_time=2s => stop_time=2s: stop_time_s = 2 is not from 0.001 to 1
        jump=1nm => jump 1e-9 m has no effect | give `speed_limit_m_per_s`
        --guard on => --guard | observer
        ",
    ) {
        place.run(&format!("{RELAX} {options}")).refused(2, &words);
    }
    for &(lines, words) in WRONG {
        place.write("workspace.toml", format!("[relax]\n{lines}\n"));
        place.run("run workspace.toml").refused(2, &words);
    }
}
