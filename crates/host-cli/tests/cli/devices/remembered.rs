//! Limits that outlive the device on which they were set.

use super::{Emulated, at};
use crate::process::{Ended, column};
use testkit::assert_says;

const ON: &str = "--device serial:device";
const SET: &str = "device set --device serial:device force_limit=0.5N workspace=-20mm:20mm";
const FORGET: &str = "device forget --device serial:device";
/// A tissue that asks for far more.
const RUN: &str = "relax --device serial:device --contact rigid --area 100cm2 --strain 50% --force-unstable \
                   --ramp-time 0.2s --duration 1s watchdog=1s --overwrite --out run --quiet";
const LOST: &str = "force limit from 500 mN to 10 N, workspace from -20:20 mm to none";

/// A command that ended on a device that was switched off and on: at its port again, with the limits of its firmware.
fn after_restart(device: &mut Emulated, line: &str) -> Ended {
    device.kill();
    device.plug_in("--speed 4");
    device.place.run(line)
}

/// The largest force that the device made in a run.
fn most_n(device: &Emulated) -> f64 {
    let export = device.place.run("log export run/relax.mcap -").stdout;
    let forces = column(&export, "applied_force_n").into_iter();
    forces.fold(0.0, |most: f64, force| most.max(force.abs()))
}

#[test]
fn limits_outlive_the_device_until_they_are_forgotten_or_set_anew() {
    let mut device = Emulated::new("--speed 4");
    device.json(SET);
    let ran = after_restart(&mut device, RUN);
    let most = most_n(&device);
    assert!((0.4..=0.5).contains(&most), "{most} N: {ran}");
    assert_says(
        &ran.stderr,
        "emulated at  & host-cli device set gave it & device forget",
    );
    assert_says(&ran.stderr, LOST);
    // It has them now.
    let again = device.place.run(RUN);
    assert!(!again.stderr.contains("forgotten"), "{again}");
    // Whoever else connects. What is found does not count here.
    for line in [
        "device get",
        "device monitor --duration 0.1s",
        "zwidth --orders 1 --points 2 --sample-time 2ms duration=0.5s window=0.2s push=0.1N",
    ] {
        let ended = after_restart(&mut device, &format!("{line} {ON}"));
        assert_says(&ended.stderr, LOST);
    }
    // Of what is set anew the last counts, the rest stays.
    let set = after_restart(
        &mut device,
        &format!("device set {ON} force_limit=1N --json"),
    )
    .json();
    assert_eq!(at(&set, "/safety/workspace_m/0"), -0.02);
    assert_says(
        &after_restart(&mut device, RUN).stderr,
        "force limit from 1 N to 10 N",
    );
    let gone = device.json(FORGET);
    assert_eq!(gone["forgotten"], true);
    assert_says(
        gone["limits"].as_str().expect("a text"),
        "device = \"emulated at & force_limit_n = 1.0 & workspace_low_m = -0.02",
    );
    assert_eq!(device.json(FORGET)["forgotten"], false);
    let ran = after_restart(&mut device, RUN);
    assert!(
        !ran.stderr.contains("forgotten") && most_n(&device) > 1.0,
        "{ran}"
    );
}
