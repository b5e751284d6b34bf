//! Touches that are refused, with what is said.

use super::{request, supervised, touch};
use haptic_experiment::ExperimentFile;
use std::path::Path;
use testkit::{Folder, assert_refused};

/// Keys of `[touch]`, and a part of what is said of them.
const WRONG: &str = r#"
    axes = 4 | 2: axes = 4 is not 2 or 3
    axes = 1 | one axis is a [wall]
    radius_m = 0 | 2: radius_m = 0 is not from 0.000001 to 1000
    centre_m = [0] | 2: centre_m has 1 numbers, not one for each of 2 axes
    mass_kg = [0.1, 0] | 2: mass_kg has 0, which is not above 0
    mass_kg = [1, 2, 3] | 3 numbers, not one for all or each of 2 axes
    centre_m = [1e300, 0] | 2: centre_m has 1e300, which is not from -1000 to 1000: change it
    way_points = [[0, 1e308, 0]] | 2: way_points has 1e308, which is not from -10000 to 1e7
    normal = [1, 0] | 2: normal has no effect with a ball: change that, or omit normal
    surface_m = 0 | 2: surface_m has no effect with a ball
    shape = "plane"\nradius_m = 0.02 | 3: radius_m has no effect with shape = "plane": change that
    shape = "plane"\ncentre_m = [0, 0] | 3: centre_m has no effect with shape = "plane"
    tissue = "prostate-cancerous"\nstiffness_n_per_m = 300 | 3: stiffness_n_per_m has no effect with `tissue`
    area_m2 = 1e-4 | 2: area_m2 has no effect without `tissue`
    way_points = [[0, 1, 1]]\ncircle_radius_m = 0.01 | 3: circle_radius_m has no effect with `way_points`
    hand = "force"\nhand_stiffness_n_per_m = 300\nway_points = [[0, 1, 1]] | 3: hand_stiffness_n_per_m has no effect with hand = "force"
    shape = "cube" | is not one of plane, ball, hollow-ball
    shape = "plane"\nnormal = [0, 0] | change `normal`
    way_points = [] | `way_points` is empty
    way_points = [[0, 1]] | row 1 of `way_points`
    way_points = [[1, 1, 1], [1, 0, 0]] | row 2 of `way_points`
    hand = "force" | follows `way_points` in N
    box_low_m = [0, 0] | give box_high_m too
    box_low_m = [0, 0]\nbox_high_m = [1, 0] | `box_high_m` has 0, which is not above 0
    box_low_m = [-1, -1]\nbox_high_m = [1, 1]\nworkspace_low_m = -1\nworkspace_high_m = 1 | omit one of them
    duration_s = 2000 | 2000001 samples of
    device = "usb:1" | is not one of sim, serial:PATH
    device = "haply:x"\nloop = "host"\nbox_low_m = [-0.05, -0.05]\nbox_high_m = [0.05, 0.1] | the box is not within reach of the 2DIY
    tissue = "granite" | granite
"#;

#[test]
fn what_is_wrong_is_refused_with_its_line() {
    for [keys, reason] in testkit::table(WRONG) {
        let error = ExperimentFile::parse(Path::new("lab.toml"), &format!("[touch]\n{keys}"));
        let message = error.expect_err(&keys).to_string();
        let is_named = message.contains(&reason) && !message.contains('\n');
        assert!(is_named, "{keys}: {message}");
    }
}

#[test]
fn a_simulated_hand_that_begins_inside_is_refused_before_a_file_is_made() {
    let folder = Folder::empty();
    let inside = touch("circle_start_radius_m = 0.01");
    let refused = supervised(|supervisor| inside.run(&request(&folder, "touch"), supervisor));
    assert_refused(refused, "would be a blow");
    let left = folder.read_dir().expect("a folder").count();
    assert_eq!(left, 0);
}
