//! A hand over a shape: run, log, table and picture of several axes.

use crate::process::{Place, number};

const DISC: &str = include_str!("../../../../experiments/touch-disc.toml");

#[test]
fn a_touch_runs_from_its_file_to_table_and_picture() {
    let place = Place::new();
    place.write("disc.toml", DISC);
    let report = place
        .run("run disc.toml --out disc --json")
        .succeeded()
        .json();
    assert_eq!(report["verdict"], "passive", "{report}");
    assert_eq!(number(&report, "samples"), 5001.0);
    assert!(number(&report, "max_relative_error") < 2e-6);
    assert!(number(&report, "given_most_j") < 1e-12);
    assert_eq!(number(&report, "effective_mass_most_kg"), 0.12);
    assert_eq!(report["preflight"]["stable"], true);
    let files = place.files();
    for wanted in [
        "disc/touch.mcap",
        "disc/touch.csv",
        "disc/touch.png",
        "disc/touch.svg",
    ] {
        assert!(files.iter().any(|file| file == wanted), "{files:?}");
    }
    let table = place.text("disc/touch.csv");
    let header =
        "time_s,reference_x_m,reference_y_m,position_x_m,position_y_m,force_x_n,force_y_n,depth_m";
    assert_eq!(table.lines().next(), Some(header));
    assert_eq!(table.lines().count(), 5002);

    place.run("log check disc/touch.mcap").succeeded();
    let exported = place
        .run("log export disc/touch.mcap --out table --json")
        .succeeded()
        .json();
    assert_eq!(number(&exported, "samples"), 5001.0);
    let columns = place.text("table/touch.ticks.csv");
    let columns: Vec<&str> = columns
        .lines()
        .next()
        .expect("a header")
        .split(',')
        .collect();
    assert_eq!(columns.len(), 16);
    assert!(columns.contains(&"position_x_m") && columns.contains(&"environment_force_y_n"));
    place.run("log plot disc/touch.mcap --out path").succeeded();
    let picture = place.text("path/touch.log.svg");
    assert!(
        picture.contains("x / mm") && picture.contains("y / mm"),
        "the plane"
    );
    let info = place.run("log info disc/touch.mcap").succeeded().stdout;
    assert!(info.contains("effective_mass_least_kg"), "{info}");
}

#[test]
fn by_the_clock_a_touch_is_the_same() {
    let place = Place::new();
    place.write(
        "short.toml",
        "[touch]\nduration_s = 0.2\nsample_time_s = 0.005\n",
    );
    let virtual_time = place
        .run("run short.toml --out a --json")
        .succeeded()
        .json();
    let clock = place
        .run("run short.toml --realtime --priority off --out b --json")
        .succeeded_with_warnings()
        .json();
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
    assert!(
        ended.error().contains("must_be_passive"),
        "{}",
        ended.error()
    );
    place.write(
        "out.toml",
        "[touch]\nshape = \"plane\"\nsurface_m = 1\nway_points = [[0, 0, 0], [0.2, 0.1, 0]]\nduration_s = 1\n\
         box_low_m = [-0.05, -0.05]\nbox_high_m = [0.05, 0.05]\n",
    );
    let ended = place.run("run out.toml --out out").failed(1);
    assert!(ended.error().contains("workspace"), "{}", ended.error());
    place.write("serial.toml", "[touch]\n");
    place
        .run("run serial.toml --device serial:/dev/ttyUSB9")
        .refused(2, &["simulated device"]);
    place.write("typo.toml", "[touch]\nradius = 0.02\n");
    place
        .run("run typo.toml")
        .refused(2, &["typo.toml:2", "radius_m"]);
}
