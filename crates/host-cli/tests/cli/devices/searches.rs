//! `zwidth` on a device: from soft walls up, and no further than the device goes.

use super::{Emulated, number};

/// Two dissipations, in trials of half a second.
const SEARCH: &str = "zwidth --orders 1 --points 2 --sample-time 2ms duration=0.5s window=0.2s --device serial:device watchdog=1s --quiet";

/// Faults that have latched since it was switched on.
fn faults(device: &Emulated) -> f64 {
    number(
        &device.json("device info --device serial:device"),
        "/faults",
    )
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_z_width_can_be_found_on_a_device() {
    let device = Emulated::new("--speed 400");
    device.loosen();
    let report = device.json(SEARCH);
    // Thousands before it began from soft walls.
    assert!(number(&report, "/runs") < 100.0, "{report}");
    let points = report["orders"][0]["boundary"].as_array().expect("points");
    assert_eq!(points.len(), 2, "{report}");
    for point in points {
        // The same wall on the simulated device: a little softer it comes to rest, a little stiffer it does not.
        for (times, stable) in [(0.97, true), (1.03, false)] {
            let wall = format!(
                "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\norder = 1\nimpact_m_per_s = 0\n\
                 duration_s = 0.5\nwindow_s = 0.2\nstiffness_n_per_m = {:?}\n\
                 dissipation_n_s_mu_per_m = {:?}\n",
                times * number(point, "/stiffness_max"),
                number(point, "/dissipation")
            );
            device.place.write("wall.toml", wall);
            let tried = device.json("run wall.toml --out wall --overwrite --quiet");
            assert_eq!(tried["stable"], stable, "{times} of {point}");
        }
    }
    // A person is told what is missing beside them, and where it is to be had.
    let shown = device.place.run(&SEARCH.replace(" --quiet", ""));
    let ended = shown.succeeded_with_warnings();
    for words in ["no analysis, as nobody knows", "--device-model device.toml"] {
        assert!(ended.stderr.contains(words), "{ended}");
    }
}

#[test]
fn a_fault_of_the_sensor_ends_a_search_at_once() {
    let device = Emulated::new("--speed 8");
    device.json("device set --device serial:device speed_limit=2mm/s jump=1um");
    let words = [
        "the position jumped by more than the speed limit allows",
        "no more trials are made",
    ];
    let ended = device.place.run(&format!("{SEARCH} --json")).failed(3);
    for word in words {
        assert!(ended.error().contains(word), "{ended}");
    }
    // Each trial that ends so would have armed the device again.
    assert_eq!(faults(&device), 1.0, "{ended}");
}
