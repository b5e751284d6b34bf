//! A hand over a shape: run, log, table and picture of several axes.

use crate::devices::Emulated;
use crate::process::number;
use testkit::assert_says;

/// An edge, into which the hand of the emulated board pushes, slowly enough for a busy machine.
const EDGE: &str = "[touch]\nshape = \"plane\"\nsurface_m = 0.001\nstiffness_n_per_m = 200\ndissipation_n_s_mu_per_m = 5\norder = 0.3\n\
                    hand = \"force\"\nway_points = [[0, 0.5, 0]]\nsample_time_s = 0.005\nduration_s = 3\nforce_limit_n = 3\nmass_kg = 0.2\n\
                    damping_n_s_per_m = 8\n";
const ON_PLANE: &str =
    "--device serial:device --loop host watchdog=1s max_age_ticks=200 late_ticks=0";

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_touch_on_an_emulated_board_of_two_axes_is_felt_along_the_normal() {
    let device = Emulated::new("--axes 2");
    let place = device.place();
    place.write("edge.toml", EDGE);
    let info = device.json("device info --device serial:device");
    assert_eq!(number(&info, "axes"), 2.0, "{info}");
    let ended = place.run(&format!("run edge.toml {ON_PLANE} --out edge --json"));
    if ended.code == Some(2) {
        // The delay is measured, and that of a busy machine counts.
        ended.refused(2, &["pre-flight", "--force-unstable"]);
        testkit::skip_for_load("the shape is not stable at the delay measured");
        return;
    }
    let report = ended.succeeded_with_warnings().json();
    println!("{report}");
    assert_eq!(report["verdict"], "rendered");
    assert_eq!(report["given_j"], serde_json::Value::Null);
    assert_eq!(report["link"]["board"], "emulated");
    assert_eq!(report["link"]["loop"], "host");
    // The way of the force to zero is in the log too.
    assert!(number(&report, "samples") >= 601.0);
    assert_eq!(number(&report, "duration_s"), 3.0);
    // At rest the springs hold the push: 0.5 N on 200 N/m, and what the damper still holds of it.
    let table = place.text("edge/touch.csv");
    let last = table.lines().last().expect("rows").split(',');
    let last: Vec<f64> = last.map(|x| x.parse().unwrap_or(f64::NAN)).collect();
    let [_, hand_x, hand_y, x, y, force_x, force_y, depth] = last[..] else {
        panic!("{last:?}");
    };
    assert!((2.2e-3..=2.6e-3).contains(&depth), "{depth} m");
    assert!(number(&report, "max_relative_error") < 1e-5, "{report}");
    // Nobody knows where the hand wants to be; nothing moves or pushes across.
    assert!(hand_x.is_nan() && hand_y.is_nan());
    assert!(x > 0.001 && force_x < -0.1, "{last:?}");
    assert_eq!((y, force_y), (0.0, 0.0));
    place.run("log check edge/touch.mcap").succeeded();
    assert!(place.text("edge/touch.svg").contains("x / mm"));
}

/// The device renders each shape by itself: what it made is held against the full history of the depth, and lies on the normal.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_board_of_several_axes_renders_shapes_in_its_own_loop() {
    for axes in [2, 3] {
        let device = Emulated::new(&format!("--axes {axes}"));
        let place = device.place();
        let third = |number: &str| {
            if axes == 3 {
                number.to_owned()
            } else {
                String::new()
            }
        };
        let (normal, place_m) = (third(", 0"), third(", -0.002"));
        let law = format!(
            "axes = {axes}\nstiffness_n_per_m = 200\ndissipation_n_s_mu_per_m = 5\norder = 0.3\nhand = \"force\"\n\
             way_points = [[0, 0.5, 0{normal}]]\nsample_time_s = 0.002\nduration_s = 1\nforce_limit_n = 3\nmass_kg = 0.2\n\
             damping_n_s_per_m = 8\n"
        );
        let on = "--device serial:device watchdog=1s late_ticks=0 --overwrite --json";
        for (kind, shape, centre) in [
            (
                "plane",
                format!("normal = [3, 4{normal}]\nsurface_m = 0.001"),
                None,
            ),
            (
                "ball",
                format!("centre_m = [0.022, 0.003{place_m}]"),
                Some([0.022, 0.003]),
            ),
            (
                "hollow-ball",
                format!("centre_m = [0, 0.001{place_m}]\nradius_m = 0.004"),
                Some([0.0, 0.001]),
            ),
        ] {
            place.write(
                "shape.toml",
                format!("[touch]\nshape = \"{kind}\"\n{shape}\n{law}"),
            );
            let ended = place.run(&format!("run shape.toml {on} --out {kind}"));
            let report = ended.succeeded_with_warnings().json();
            assert_eq!(report["verdict"], "rendered");
            assert_eq!(report["link"]["loop"], "device");
            // The device computes in single precision.
            assert!(number(&report, "max_relative_error") < 2e-5, "{report}");
            let table = place.text(&format!("{kind}/touch.csv"));
            let mut pushed = 0;
            for row in table.lines().skip(1) {
                let row: Vec<f64> = (row.split(','))
                    .map(|x| x.parse().unwrap_or(f64::NAN))
                    .collect();
                let (x, y) = (row[1 + axes], row[2 + axes]);
                let [force_x, force_y] = [row[1 + 2 * axes], row[2 + 2 * axes]];
                let [n_x, n_y] = match centre {
                    Some([c_x, c_y]) => [x - c_x, y - c_y],
                    None => [0.6, 0.8],
                };
                let across = (n_x * force_y - n_y * force_x).abs();
                assert!(across <= 1e-5 * n_x.hypot(n_y), "{row:?}");
                pushed += u32::from(force_x < -0.05);
            }
            assert!(pushed > 50, "{pushed}");
        }
        // 10 mm inside, where the device is: a blow.
        let deep = format!("[touch]\nradius_m = 0.03\ncentre_m = [0.02, 0{normal}]\n{law}");
        place.write("deep.toml", deep);
        let ended = place.run(&format!("run deep.toml {on} --out deep"));
        assert_says(ended.failed(3).error(), "would start at & above 1 N");
    }
}
