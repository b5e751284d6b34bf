//! A hand over a shape: run, log, table and picture of several axes.

use crate::devices::Emulated;
use crate::process::{Place, number};
use testkit::assert_says;

const DISC: &str = include_str!("../../../../experiments/touch-disc.toml");

#[test]
fn a_touch_runs_from_its_file_to_table_and_picture() {
    let place = Place::new();
    place.write("disc.toml", DISC);
    let report = place.json("run disc.toml --out disc");
    assert_eq!(report["verdict"], "passive", "{report}");
    assert_eq!(number(&report, "samples"), 5001.0);
    let files = place.files();
    for ending in "mcap csv png svg".split(' ') {
        let file = format!("disc/touch.{ending}");
        assert!(files.contains(&file), "{files:?}");
    }
    let table = place.text("disc/touch.csv");
    let header =
        "time_s,reference_x_m,reference_y_m,position_x_m,position_y_m,force_x_n,force_y_n,depth_m";
    assert_eq!(table.lines().next(), Some(header));
    assert_eq!(table.lines().count(), 5002);

    place.run("log check disc/touch.mcap").succeeded();
    let exported = place.json("log export disc/touch.mcap --out table");
    assert_eq!(number(&exported, "samples"), 5001.0);
    let columns = place.text("table/touch.ticks.csv");
    let columns: Vec<&str> = columns
        .lines()
        .next()
        .expect("a header")
        .split(',')
        .collect();
    assert_eq!(columns.len(), 21);
    assert!(columns.contains(&"position_x_m") && columns.contains(&"sensed_force_y_n"));
    place.run("log plot disc/touch.mcap --out path").succeeded();
    assert_says(&place.text("path/touch.log.svg"), "x / mm & y / mm");
    let info = place.run("log info disc/touch.mcap").succeeded().stdout;
    assert_says(&info, "effective_mass_least_kg");
}

#[test]
fn by_the_clock_a_touch_is_the_same() {
    let place = Place::new();
    let file = "[touch]\nduration_s = 0.2\nsample_time_s = 0.005\n";
    place.write("short.toml", file);
    let virtual_time = place.json("run short.toml --out a");
    let clock = place.run("run short.toml --realtime --priority off --out b --json");
    let clock = clock.succeeded_with_warnings().json();
    assert_eq!(virtual_time["largest_depth_m"], clock["largest_depth_m"]);
    assert_eq!(place.read("a/touch.csv"), place.read("b/touch.csv"));
}

#[test]
fn a_touch_that_must_be_passive_and_is_not_ends_with_1_and_a_fault_too() {
    let place = Place::new();
    place.write(
        "stiff.toml",
        "[touch]\nshape = \"plane\"\nstiffness_n_per_m = 60000\ndissipation_n_s_mu_per_m = 0\nduration_s = 1\nforce_limit_n = 50\n\
         way_points = [[0, -0.005, 0], [0.5, 0.005, 0]]\nmust_be_passive = true\n",
    );
    let ended = place.run("run stiff.toml --out stiff").failed(1);
    assert_says(ended.error(), "must_be_passive");
    place.write(
        "out.toml",
        "[touch]\nshape = \"plane\"\nsurface_m = 1\nway_points = [[0, 0, 0], [0.2, 0.1, 0]]\nduration_s = 1\n\
         box_low_m = [-0.05, -0.05]\nbox_high_m = [0.05, 0.05]\n",
    );
    assert_says(
        place.run("run out.toml --out out").failed(1).error(),
        "workspace",
    );
}

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

    // The other way round, and another number: one line, before anything moves.
    let line = place.run("relax --device serial:device --duration 5s");
    line.refused(2, &["has 2 axes", "`axes` = 2"]);
}

#[test]
fn a_touch_on_a_board_of_one_axis_is_refused() {
    let device = Emulated::new("");
    let place = device.place();
    place.write("edge.toml", EDGE);
    for on_plane in [ON_PLANE, &ON_PLANE.replace("host", "device")] {
        let ended = place.run(&format!("run edge.toml {on_plane}"));
        ended.refused(2, &["has one axis", "has 2", "[wall]"]);
    }
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
