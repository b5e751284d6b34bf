//! Gives the linker the memory of the chosen board: its budget for the device, more for tests.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=memory");
    let chosen = |board: &str| env::var_os(format!("CARGO_FEATURE_BOARD_{board}")).is_some();
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    // None or two: the library says so, with a message of its own.
    match (chosen("MPS2"), chosen("NUCLEO_F446RE")) {
        (true, false) => {
            copy("mps2.x", &out.join("device/memory.x"));
            copy("mps2-tests.x", &out.join("tests/memory.x"));
            // The interrupts of the other board are named by its HAL.
            copy("mps2-interrupts.x", &out.join("device.x"));
        }
        (false, true) => {
            copy("nucleo-f446re.x", &out.join("device/memory.x"));
        }
        _ => return,
    }
    println!("cargo::rustc-link-search={}", out.display());
    println!(
        "cargo::rustc-link-arg-bins=-L{}",
        out.join("device").display()
    );
    println!(
        "cargo::rustc-link-arg-tests=-L{}",
        out.join("tests").display()
    );
    println!("cargo::rustc-link-arg=-Tlink.x");
    // One copy of functions that are the same instruction for instruction, and of texts that end alike.
    println!("cargo::rustc-link-arg=--icf=all");
    println!("cargo::rustc-link-arg=-O2");
}

fn copy(from: &str, to: &Path) {
    let folder = to.parent().expect("a file in a folder");
    fs::create_dir_all(folder)
        .and_then(|()| fs::copy(Path::new("memory").join(from), to))
        .unwrap_or_else(|error| panic!("memory/{from}: {error}"));
}
