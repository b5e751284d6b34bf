//! Pages of the guide: every command on them runs.

use crate::process::{Place, binary};

/// The commands of a page: the blocks that are marked `sh`, line by line, without what stands behind a `#`.
fn commands(page: &str) -> Vec<String> {
    let mut inside = false;
    let mut commands = Vec::new();
    for line in page.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside && !line.trim().is_empty() {
            commands.push(line.split(" #").next().unwrap_or(line).trim().to_owned());
        }
    }
    commands
}

/// The files of a page: the blocks that are marked `toml`.
fn files(page: &str) -> Vec<String> {
    let blocks = page.split("```toml\n").skip(1);
    let texts = blocks.filter_map(|block| block.split_once("```"));
    texts.map(|(text, _)| text.to_owned()).collect()
}

#[test]
fn feeling_something_far_away_runs_from_the_analysis_to_two_processes() {
    let place = Place::new();
    let page = include_str!("../../../../docs/feeling-something-far-away.md");
    let files = files(page);
    let [far, passive] = files.as_slice() else {
        panic!("two files: {files:?}");
    };
    place.write("far.toml", far);
    // A busy machine may be silent for longer than a line.
    place.write("far-passive.toml", format!("{passive}silence_s = 60\n"));
    let mut behind = String::new();
    for command in commands(page) {
        let arguments = command
            .strip_prefix("host-cli ")
            .unwrap_or_else(|| panic!("{command}"));
        let script = format!("\"{}\" {arguments}", binary().display());
        if script.ends_with('&') {
            // In another terminal, until the next command.
            behind = script;
            continue;
        }
        let script = match behind.is_empty() {
            true => script,
            false => format!(
                "{} {script}; ours=$?; wait $! && exit $ours",
                std::mem::take(&mut behind)
            ),
        };
        place.shell(&script).succeeded_with_warnings();
    }
    for wanted in [
        "best/teleoperation.png",
        "far/teleoperation.png",
        "passive/teleoperation.csv",
    ] {
        let files = place.files();
        assert!(
            files.iter().any(|file| file == wanted),
            "{wanted}: {files:?}"
        );
    }
}

/// Runs every command of a page, which leave these files among others.
fn runs(place: &Place, page: &str, wanted: &[&str]) {
    let commands = commands(page);
    assert!(commands.len() >= 4, "{commands:?}");
    for command in &commands {
        let arguments = command
            .strip_prefix("host-cli ")
            .unwrap_or_else(|| panic!("{command}"));
        // As a shell reads it, for quotes and redirections; a name without its path is the binary.
        let script = format!("\"{}\" {arguments}", binary().display());
        place.shell(&script).succeeded_with_warnings();
    }
    let files = place.files();
    for wanted in wanted {
        assert!(
            files.iter().any(|file| file == wanted),
            "{wanted}: {files:?}"
        );
    }
}

#[test]
fn your_own_tissue_runs_from_the_record_to_the_figure() {
    let place = Place::new();
    place.write(
        "fish-muscle-relaxation.tsv",
        include_str!("../../../haptic-tissue/records/fish-muscle-relaxation.tsv"),
    );
    runs(
        &place,
        include_str!("../../../../docs/your-own-tissue.md"),
        &[
            "fish.toml",
            "fish.png",
            "muscle/relax.png",
            "muscle/relax.csv",
        ],
    );
}

#[test]
fn a_fractional_pid_runs_from_the_step_to_the_verdict() {
    runs(
        &Place::new(),
        include_str!("../../../../docs/a-fractional-pid.md"),
        &[
            "oven.toml",
            "oven.png",
            "design/controller.toml",
            "design/controller.png",
            "run/response.png",
            "loop/loop.png",
        ],
    );
}

#[test]
fn measure_your_device_runs_from_the_motion_to_the_walls() {
    runs(
        &Place::new(),
        include_str!("../../../../docs/measure-your-device.md"),
        &["device.toml", "device.png"],
    );
}
