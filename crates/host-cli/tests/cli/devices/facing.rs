//! Two emulated boards whose masses meet, in one process.

use super::Emulated;
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
