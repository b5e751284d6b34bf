//! The guide: every command on its pages runs, what the pages say that commands print is what they print, and the page of
//! keys is made from the tables.

mod keys;
mod models;
mod reader;

use reader::{follows, runs_something};
use testkit::book::{self, Markdown};

/// Chapters, each with a test and with files that its commands leave behind among others.
macro_rules! chapters {
    ($($(#[$attribute:meta])* $test:ident: $file:literal [$($wanted:literal),* $(,)?];)*) => {
        const FOLLOWED: &[&str] = &[$($file),*];
        $(#[test]
        $(#[$attribute])*
        fn $test() {
            follows($file, &[$($wanted),*]);
        })*
    };
}

chapters! {
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    a_fractional_pid: "a-fractional-pid.md" [
        "oven.toml", "oven.png", "design/controller.toml", "design/controller.png", "run/response.png", "loop/loop.png",
    ];
    a_hand_that_moves_over_a_shape: "touch.md" ["disc/touch.png", "disc/touch.mcap"];
    a_lesson_of_45_minutes: "lesson.md" ["one/wall.png", "hundred/relax.png", "remembered/wall.csv"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    an_emulated_device: "emulated-device.md" ["form.md", "emulated-wall/wall.csv"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    an_indenter_held_by_a_controller: "driven-indenter.md" [
        "driven/relax.png", "bench/relax.png", "bench/relax.mcap", "muscle/relax.against.csv", "muscle/relax.png",
    ];
    commands_and_exit_codes: "commands.md" ["paper/wall.pdf", "log-log/relax.svg"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    choose_mu_for_your_device: "choose-mu.md" ["omni/design.png", "omni-tissue/design.toml"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    devices: "devices.md" [];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    feeling_something_far_away: "feeling-something-far-away.md" [
        "best/teleoperation.png", "far/teleoperation.png", "passive/teleoperation.csv",
    ];
    first_relaxation: "first-relaxation.md" [
        "first/relax.png", "first/relax.svg", "first/relax.csv", "first/relax.mcap",
    ];
    install: "install.md" ["host-cli.bash", "man/host-cli.1"];
    log_files: "log-files.md" ["ticks.csv"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    measure_your_device: "measure-your-device.md" ["device.toml", "device.png", "device.csv"];
    reading_a_stability_map: "stability-map.md" ["map/region.png", "map/region.csv"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    the_dissertation_one_by_one: "reproduction.md" [
        "3.5/environment.png", "4.3/region.csv", "4.4/zwidth.csv", "4.6/region.csv", "4.7/sensitivity.png", "6/transparency.png",
        "7/relax.png",
    ];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    the_first_time_on_real_hardware: "first-time.md" ["first.md", "first-wall/wall.csv"];
    the_device_as_a_testing_machine: "testing-machine.md" ["pressed/press.csv", "gel.png", "felt/relax.png"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    a_robot_that_you_push: "a-robot-that-you-push.md" ["light/admittance.png", "best/admittance.png"];
    the_page_in_the_browser: "page.md" [];
    passive_models_and_actuators: "models.md" ["sea/region.png"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    tissues_and_signals: "tissues.md" ["half.csv", "mine/relax.png"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    walls_and_couplers_tried: "walls.md" [
        "zwidth/zwidth.csv", "coupler/design.toml", "tried/coupler.png",
    ];
    your_own_board: "your-own-board.md" ["half.h"];
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    your_own_tissue: "your-own-tissue.md" [
        "fish.toml", "fish.png", "beside/relax.against.csv", "muscle/relax.png", "muscle/relax.csv",
    ];
}

#[test]
fn every_chapter_with_commands_is_followed() {
    for file in book::chapters().iter().filter(|file| !file.is_empty()) {
        let page = Markdown::new(&book::chapter(file));
        if page.blocks.iter().any(runs_something) {
            assert!(FOLLOWED.contains(&file.as_str()), "{file} has no test");
        }
    }
}

/// Pages of devices, each of which answers the same questions.
const DEVICES: [&str; 5] = [
    "emulated-device.md",
    "build-a-device.md",
    "your-own-board.md",
    "haply-2diy.md",
    "moteus.md",
];

#[test]
fn every_page_of_a_device_has_the_same_headings_in_the_same_order() {
    let wanted = "what-it-is connect device-info self-test measure first-wall what-it-cannot-do";
    for file in DEVICES {
        let page = Markdown::new(&book::chapter(file));
        let anchors = page.anchors.iter().map(String::as_str);
        let found: Vec<&str> = anchors
            .filter(|anchor| wanted.split(' ').any(|wanted| wanted == *anchor))
            .collect();
        assert_eq!(found.join(" "), wanted, "{file}");
    }
}
