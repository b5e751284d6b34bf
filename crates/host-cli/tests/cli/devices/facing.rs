//! Two emulated boards whose masses meet, in one process.

use super::Emulated;
use crate::process::Place;
use testkit::assert_says;

#[test]
fn both_boards_of_a_pair_answer_each_over_its_own_line_and_both_go_together() {
    let mut pair =
        Emulated::at_terminal("device", "--facing white facing_model=laboratory gap=1mm");
    pair.wait_for("white");
    for name in ["device", "white"] {
        let info = pair.json(&format!("device info --device serial:{name}"));
        assert_eq!(info["simulated"], false, "{info}");
        assert_eq!(info["state"], "idle", "{info}");
    }
    let message = pair.ends();
    assert_says(&message, "ticks & ; facing: ");
    let left = pair.place.files();
    assert!(
        !left.iter().any(|file| file == "device" || file == "white"),
        "{left:?}"
    );
}

#[test]
fn a_pair_that_was_killed_leaves_names_that_the_next_one_takes() {
    let options = "--facing white";
    let mut pair = Emulated::new(options);
    pair.wait_for("white");
    pair.kill();
    // Nobody listens.
    pair.place
        .run("device info --device serial:white")
        .failed(3);
    pair.plug_in(options);
    let info = pair.json("device info --device serial:white");
    assert_eq!(info["state"], "idle", "{info}");
}

#[test]
fn a_line_may_be_bad_on_one_side_alone() {
    let mut pair = Emulated::new("--facing white facing_drop=100% facing_line_seed=5");
    pair.wait_for("white");
    let info = pair.json("device info --device serial:device");
    assert_eq!(info["state"], "idle", "{info}");
    pair.place
        .run("device info --device serial:white")
        .failed(3);
}

#[test]
fn what_no_pair_can_be_is_refused_in_a_line() {
    let place = Place::new();
    place.write("white", "somebody's file");
    place.refuses(
        "
        device emulate --link blue --facing blue => --facing | the first board | give another
        device emulate --facing white => --facing | --link or --listen
        device emulate --link blue --facing white => `white` | it is there already | --facing
        device emulate --link blue --facing pale --axes 2 => one axis | omit --axes
        device emulate --link blue --facing pale --kind moteus => --facing | --kind own
        device emulate --link blue --facing pale gap=-1mm => gap=-1mm | from 0 to 1 m
        device emulate --link blue --facing pale gap=NaN => gap=NaN | finite number
        device emulate --link blue --facing pale gap=2m => gap=2m | from 0 to 1 m
        device emulate --link blue --facing pale contact_stiffness=0 => contact_stiffness=0 | above 0
        device emulate --link blue --facing pale contact_damping=-1 => contact_damping=-1 | from 0
        device emulate --link blue --facing pale contact_friction=1km => contact_friction=1km | is not a force
        device emulate --link blue --facing pale facing_drop=2 => facing_drop=2 | from 0 to 1
        device emulate --link blue --facing pale gap=1mm gap=2mm => gap=2mm | twice
        device emulate --link blue --facing pale facing_gap=1mm => facing_gap=1mm | does not name
        device emulate --link blue --facing pale facing_model=none.toml => none.toml
        device emulate --link blue gap=1mm => --facing white | two boards
        device emulate --link blue facing_drop=1% => --facing white | two boards
        ",
    );
    // Nothing of a pair that could not be stays.
    assert_eq!(place.files(), ["white"]);
}
