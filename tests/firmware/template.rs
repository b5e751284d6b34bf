//! The template as a newcomer takes it: copied beside a clone, built, started, and asked by the client of the page.

use super::board::Emulator;
use super::firmware;
use super::image::needs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use testkit::book::{self, Markdown};
use testkit::{Folder, skip};

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
    let mut build = Command::new(env!("CARGO"));
    let status = at_home(build.args(["build", "--release", "--locked"]), folder).status();
    let status = status.expect("cargo runs");
    assert!(status.success(), "the template does not build");
    image()
}

/// Both tests build a package of the same name into the same folder: one after the other.
static ALONE: Mutex<()> = Mutex::new(());

/// Where cargo leaves the image of a copy.
fn image() -> PathBuf {
    firmware().with_file_name("target/firmware/thumbv7em-none-eabihf/release/my-board")
}

/// Command in this folder, with nothing that a test's own cargo has set.
fn at_home<'c>(command: &'c mut Command, folder: &Path) -> &'c mut Command {
    command
        .current_dir(folder)
        .env(
            "CARGO_TARGET_DIR",
            firmware().with_file_name("target/firmware"),
        )
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_BUILD_TARGET")
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
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Folder::empty();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let clone = folder.join("fractional-haptics");
    std::os::unix::fs::symlink(root, &clone).expect("a link");
    let mine = folder.join("my-board");
    copy(&clone.join("firmware/template"), &mine);
    let emulator = Emulator::start(&built(&mine));
    let output = Command::new(python)
        .arg(clone.join("tests/protocol/client.py"))
        .args([emulator.path(), "--hello"])
        .output()
        .expect("Python runs");
    let message = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{message}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let page = include_str!("../../docs/guide/src/your-own-board.md");
    let (_, promised) = page.split_once("```json\n").expect("an answer");
    let promised = promised.lines().next().expect("a line");
    let parsed = |text: &str| -> serde_json::Value { serde_json::from_str(text).expect("is JSON") };
    assert_eq!(parsed(&message), parsed(promised));
}

/// The page is followed to the letter, but for the clone, which is this one. Each of its builds makes an image for the STM32's flash.
#[cfg(unix)]
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_stm32_of_the_guide_is_built_as_its_page_says() {
    if let Err(missing) = needs() {
        return skip(&missing);
    }
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Folder::empty();
    let clone = folder.join("fractional-haptics");
    std::os::unix::fs::symlink(env!("CARGO_MANIFEST_DIR"), &clone).expect("a link");
    let mine = folder.join("my-board");
    let page = Markdown::new(&book::chapter("your-stm32-board.md"));
    let mut builds = 0;
    for block in &page.blocks {
        let in_shell = block.language == "sh" && block.note.starts_with("not run: tests build");
        if in_shell {
            let from: &Path = if mine.exists() { &mine } else { &folder };
            let lines = block.text.lines();
            let lines: Vec<&str> = lines
                .filter(|line| !line.starts_with("git clone"))
                .collect();
            let mut shell = Command::new("sh");
            let shell = at_home(shell.args(["-ec", &lines.join("\n")]), from);
            assert!(shell.status().expect("sh runs").success(), "{block:?}");
            if block.text.contains("cargo build") {
                let image = std::fs::read(image()).expect("an image");
                // The word at 24 of an ELF file is where the program begins.
                assert_eq!(image[27], 0x08, "{block:?}");
                std::fs::remove_file(self::image()).expect("was there");
                builds += 1;
            }
        } else if block.language != "sh" && !block.note.is_empty() {
            std::fs::write(mine.join(&block.note), &block.text).expect("a file");
        }
    }
    assert_eq!(builds, 2);
}
