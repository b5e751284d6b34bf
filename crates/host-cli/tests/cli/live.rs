//! Live streams as a viewer meets them.

#[cfg(feature = "foxglove")]
mod foxglove;

use std::path::Path;
use std::process::Output;
use std::time::Duration;

/// No step of these tests takes a tenth of this, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// Runs `host-cli LINE` in a folder.
fn run(place: &Path, line: &str) -> Output {
    let mut command = assert_cmd::Command::new(assert_cmd::cargo::cargo_bin!("host-cli"));
    let command = command.args(line.split_whitespace()).current_dir(place);
    command.timeout(PATIENCE).output().expect("runs and ends")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

// `.ci/run` tests with the feature, and asks a command without it the same.
#[cfg(not(feature = "foxglove"))]
#[test]
fn a_build_without_foxglove_says_so() {
    let place = testkit::Folder::empty();
    let ended = run(&place, "relax --duration 2s --foxglove --out run");
    let message = stderr(&ended);
    assert_eq!(ended.status.code(), Some(2), "{message}");
    testkit::assert_says(&message, "--features foxglove");
}
