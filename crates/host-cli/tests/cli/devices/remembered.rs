//! Limits that outlive the device on which they were set.

use super::{Emulated, at};
use crate::process::{Ended, column, says};

const SET: &str = "device set --device serial:device force_limit=0.5N workspace=-20mm:20mm";
/// A tissue that asks for far more.
const RUN: &str = "relax --device serial:device --contact rigid --area 100cm2 --strain 50% --force-unstable \
                   --ramp-time 0.2s --duration 1s watchdog=1s --overwrite --out run --quiet";
const LOST: &str = "force limit from 500 mN to 10 N, workspace from -20:20 mm to none";

/// Switched off and on: at its port again, with the limits of its firmware.
fn restarted(device: &mut Emulated) {
    device.kill();
    device.plug_in("--speed 4");
}

/// The largest force that the device made in a run.
fn most_n(device: &Emulated, ran: &Ended) -> f64 {
    let export = device.place.run("log export run/relax.mcap -").stdout;
    let forces = column(&export, "applied_force_n").into_iter();
    let most = forces.fold(0.0, |most: f64, force| most.max(force.abs()));
    assert!(most > 0.4, "{ran}");
    most
}

#[test]
fn limits_outlive_the_device_until_they_are_forgotten_or_set_anew() {
    let mut device = Emulated::new("--speed 4");
    device.json(SET);
    restarted(&mut device);
    let get = device.place.run("device get --device serial:device --json");
    says(&get.stderr, &["it has forgotten limits", LOST]);
    let ran = device.place.run(RUN);
    assert!(most_n(&device, &ran) <= 0.5, "{ran}");
    let words = [
        "emulated at ",
        "host-cli device set gave it",
        LOST,
        "device forget",
    ];
    says(&ran.stderr, &words);
    // It has them now.
    let again = device.place.run(RUN);
    assert!(!again.stderr.contains("forgotten"), "{again}");
    // Every other that arms it. What it finds does not count here.
    for line in [
        "zwidth --orders 1 --points 2 --sample-time 2ms duration=0.5s window=0.2s push=0.1N --device serial:device",
        "device monitor --device serial:device --duration 0.1s",
    ] {
        restarted(&mut device);
        let ended = device.place.run(line);
        says(&ended.stderr, &[LOST]);
    }
    // Of what is set anew the last counts, the rest stays.
    restarted(&mut device);
    let set = device.json("device set --device serial:device force_limit=1N");
    assert_eq!(at(&set, "/force_limit_n"), 1.0);
    assert_eq!(at(&set, "/safety/workspace_m/0"), -0.02);
    restarted(&mut device);
    let ran = device.place.run(RUN);
    says(&ran.stderr, &["force limit from 1 N to 10 N"]);
    assert!(most_n(&device, &ran) > 0.9, "{ran}");
    restarted(&mut device);
    let forget = "device forget --device serial:device";
    for forgotten in [true, false] {
        assert_eq!(device.json(forget)["forgotten"], forgotten);
    }
    let ran = device.place.run(RUN);
    assert!(!ran.stderr.contains("forgotten"), "{ran}");
    assert!(most_n(&device, &ran) > 1.0, "{ran}");
}

#[test]
fn limits_that_cannot_be_read_arm_nothing_and_say_what_to_do() {
    let device = Emulated::new("");
    let place = &device.place;
    device.json(SET);
    let folder = place.path("state/limits");
    let mut files = std::fs::read_dir(&folder).expect("a folder");
    let file = files.next().expect("a file").expect("readable").path();
    assert!(files.next().is_none(), "one file for a device");
    let good = std::fs::read_to_string(&file).expect("text");
    let broken = |text: &str| std::fs::write(&file, text).expect("writes");
    let cases: [(&str, &dyn Fn()); 6] = [
        ("empty", &|| broken("")),
        ("cut", &|| broken(&good[..good.len() / 2])),
        ("another key", &|| broken(&good.replace("force_n", "force"))),
        ("no number", &|| broken(&good.replace("0.5", "null"))),
        ("beyond what a device takes", &|| {
            broken(&good.replace("\"force_n\": 0.5", "\"force_n\": -0.5"))
        }),
        ("a folder", &|| {
            std::fs::remove_file(&file).expect("goes");
            std::fs::create_dir(&file).expect("a folder");
        }),
    ];
    for (case, make) in cases {
        make();
        let refused = place.run(RUN);
        assert_eq!(refused.code, Some(3), "{case}: {refused}");
        says(refused.error(), &["device forget"]);
        assert!(!place.path("run").exists(), "{case}: {refused}");
    }
    // The folder is nothing that this program made: a person has to look.
    let forget = "device forget --device serial:device";
    assert_eq!(place.run(forget).code, Some(3));
    std::fs::remove_dir(&file).expect("goes");
    broken("");
    place
        .run(SET)
        .refused(3, &["cannot be read", "device forget"]);
    assert_eq!(device.json(forget)["forgotten"], true);
    device.json(SET);
    place.run(RUN).succeeded_with_warnings();
}

#[test]
fn a_device_that_forgets_with_every_command_is_limited_in_the_next() {
    let device = Emulated::at_terminal("device", "--kind moteus");
    let name = "--device moteus:device,watchdog=1s,lost=1000";
    device.json(&format!("device set {name} force_limit=0.5N"));
    for (name, lost) in [
        (name, true),
        ("--device moteus:device,id=2,watchdog=1s", false),
    ] {
        let get = device.place.run(&format!("device get {name}"));
        let told = get.stderr.contains("force limit from 500 mN to 5 N");
        assert_eq!(told, lost, "{get}");
    }
}
