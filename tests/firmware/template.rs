//! The template as a newcomer takes it: copied beside a clone, built, started, and asked by the client of the page.

use super::board::Emulator;
use super::firmware;
use super::image::needs;
use std::path::{Path, PathBuf};
use std::process::Command;
use testkit::skip;

/// Copies files and folders; nothing that a build has left.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            if entry.file_name() != "target" {
                copy(&entry.path(), &target);
            }
        } else {
            std::fs::copy(entry.path(), target).expect("a file");
        }
    }
}

/// The copy's image. Its profile and flags are those of the firmware, whose crates from the registry are used again: a quarter of the
/// work.
fn built(folder: &Path) -> PathBuf {
    let target = firmware().with_file_name("target/firmware");
    let status = Command::new(env!("CARGO"))
        .args(["build", "--release", "--locked"])
        .current_dir(folder)
        .env("CARGO_TARGET_DIR", &target)
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_BUILD_TARGET")
        .status()
        .expect("cargo runs");
    assert!(status.success(), "the template does not build");
    target.join("thumbv7em-none-eabihf/release/my-board")
}

#[cfg(unix)]
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_copy_of_the_template_says_the_hello_of_the_page() {
    if let Err(missing) = needs() {
        return skip(&missing);
    }
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    if Command::new(&python).arg("--version").output().is_err() {
        return skip("Python is missing; point PYTHON to one");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let clone = folder.path().join("fractional-haptics");
    std::os::unix::fs::symlink(root, &clone).expect("a link");
    let mine = folder.path().join("my-board");
    copy(&clone.join("firmware/template"), &mine);
    let emulator = Emulator::start(&built(&mine));
    let output = Command::new(python)
        .arg(clone.join("tests/protocol/client.py"))
        .args([emulator.path(), "--hello"])
        .output()
        .expect("Python runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let page = include_str!("../../docs/guide/src/your-own-board.md");
    let (_, promised) = page.split_once("```json\n").expect("an answer");
    let promised = promised.lines().next().expect("a line");
    let parsed = |text: &str| -> serde_json::Value { serde_json::from_str(text).expect("is JSON") };
    assert_eq!(parsed(&said), parsed(promised));
}
