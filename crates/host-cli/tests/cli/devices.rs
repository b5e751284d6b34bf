//! Commands on serial devices: an emulated one behind a pseudo-terminal.

mod doors;
mod facing;
mod gone;
mod held;
mod inverse3;
mod lines;
mod makers;
mod middle;
mod promises;
mod remembered;
mod tcp;
mod unheard;

pub(crate) use crate::emulated::{Emulated, Emulator};
use crate::process::column;
pub(crate) use makers::numbers_after;
use serde_json::Value;
use std::time::Duration;
use testkit::assert_says;

const RELAX: &str = "relax --device serial:device watchdog=1s --contact rigid --duration 4s --ramp-time \
                     0.5s --out run --quiet";

pub(crate) fn at(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number {path} in {value}"))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_relaxation_in_the_devices_loop_loses_nothing_and_follows_theory() {
    let device = Emulated::new("--speed 4");
    device.loosen();
    let report = device.json(RELAX);
    assert_eq!(at(&report, "/link/samples_lost"), 0.0);
    assert_eq!(at(&report, "/dropped_samples"), 0.0);
    assert!(at(&report, "/samples") >= 4001.0);
    assert!(at(&report, "/max_relative_error") < 1e-4, "{report}");
    assert!(at(&report, "/closed_form_error") < 2e-4, "{report}");
    assert_eq!(report["precision"], "f32");
    assert_eq!(report["tick_ns"], Value::Null);
    assert_eq!(report["link"]["board"], "emulated");
    // An emulated device simulates its rig, so nothing is called rendered.
    assert_eq!(report["link"]["simulated"], true);
    assert_says(&device.place.text("run/relax.csv"), ",simulated_force_n,");
    // The log says the same.
    let info = device.json("log info run/relax.mcap");
    assert_eq!(info["complete"], true);
    assert_eq!(at(&info, "/samples"), at(&report, "/samples"));
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_relaxation_in_the_hosts_loop_loses_nothing_and_follows_theory() {
    let device = Emulated::new("");
    device.loosen();
    let line = RELAX.replace("--duration 4s", "--duration 2s");
    // A machine that is busy answers late.
    let report = device.json(&format!("{line} --loop host max_age_ticks=1000"));
    assert_eq!(at(&report, "/link/samples_lost"), 0.0);
    // Where it answers ten ticks late and more, the log has the forces that the device went on with.
    let late = at(&report, "/link/stale_forces") >= 10.0;
    let follows = at(&report, "/max_relative_error") < 1e-6;
    assert!(late || follows, "{report}");
    let in_closed_form = at(&report, "/closed_form_error") < 2e-4;
    assert!(late || in_closed_form, "{report}");
    assert_eq!(report["precision"], "f64");
    assert_eq!(report["link"]["loop"], "host");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_log_of_a_host_loop_shows_no_force_beyond_what_the_device_makes() {
    let device = Emulated::new("");
    let place = &device.place;
    device.json("device set --device serial:device force_limit=2N rise_time=0s");
    // The tissue asks for 50 times as much. A machine that is too busy for the loop ends it: what was logged until then counts.
    // In a hand it would be unstable.
    let line = "relax --device serial:device --loop host --contact rigid --area 100cm2 --thickness 5cm --strain 50% \
                --force-unstable --duration 1s --ramp-time 0.5s watchdog=1s max_age_ticks=1000 --out run --json";
    let ended = place.run(line);
    // A run that ended early keeps its log too.
    let export = place.run("log export run/relax.mcap -").succeeded();
    let forces = column(&export.stdout, "applied_force_n");
    let most = forces
        .into_iter()
        .fold(0.0, |most: f64, force| most.max(force.abs()));
    assert!((1.0..=2.0 + 1e-6).contains(&most), "{most} N: {ended}");
}

#[test]
fn parameters_are_set_as_a_whole_and_read_back() {
    let device = Emulated::new("");
    let on = "--device serial:device";
    let set = format!("device set {on} stiffness=2N/mm order=0.5 dissipation=20 watchdog=50ms");
    let after = device.json(&set);
    assert_eq!(at(&after, "/stiffness_n_per_m"), 2000.0);
    assert_eq!(at(&after, "/watchdog_s"), 0.05);
    assert_eq!(after["operator"]["form"], "modes");
    assert_eq!(device.json(&format!("device get {on}")), after);
    let refused = |line: &str, words: &str| {
        device
            .place
            .run(&format!("device set {on} {line}"))
            .refused(2, &[words]);
    };
    refused("watchdog=1ms", "watchdog=1ms is not from 5 ms to 1 s");
    refused("--watchdog 50ms", "did you mean `watchdog=VALUE`?");
    assert_eq!(device.json(&format!("device get {on}")), after);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_run_leaves_the_device_as_it_was_and_loosens_nothing() {
    let device = Emulated::new("");
    let get = "device get --device serial:device";
    device.place.write(
        "wall.toml",
        "[wall]\ndevice = \"serial:device\"\nwatchdog_s = 1\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
         sample_time_s = 1e-3\norder = 1\nstiffness_n_per_m = 500\ndissipation_n_s_mu_per_m = 1\n\
         duration_s = 1\n",
    );
    let set =
        "device set --device serial:device stiffness=123N/m order=0.5 dissipation=2 rise_time=0.2s";
    let set = device.place.run(set);
    // What was loosened, and by how much.
    assert_says(
        &set.stderr,
        "warning: loosened: rise time from 500 ms to 200 ms",
    );
    assert_eq!(set.stderr.matches("loosened").count(), 1, "{set}");
    let before = device.json(get);
    let run = device.place.run("run wall.toml --out wall --quiet --json");
    // And no limit that the run asked for itself.

    assert_says(
        &run.stderr,
        "the limits set on the device & tighter: at most 10 N; a run & device set",
    );
    assert_eq!(device.json(get), before);
    let info = device.place.run("log info wall/wall.mcap --json");
    assert_says(&info.stdout, "\"device_force_limit_n\":\"10\"");
    // A host that is killed in the middle of a run leaves no more.
    let line = RELAX.replace("watchdog=1s", "watchdog=300ms");
    let mut run = device.place.start(&line);
    device.place.wait_for("run/relax.mcap.part", &mut run);
    std::thread::sleep(Duration::from_millis(300));
    run.kill().expect("can be killed");
    run.wait().expect("ends");
    assert_eq!(device.json(get), before);
}
