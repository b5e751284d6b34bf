//! Gives the linker the memory of the chip.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let has = |feature: &str| env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    let chip = match (has("RP2040"), has("RP2350")) {
        (true, false) => "rp2040",
        (false, true) => "rp2350",
        _ => panic!("one chip: --no-default-features --features rp2350 for the other"),
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let memory = format!("memory/{chip}.x");
    fs::copy(&memory, out.join("memory.x")).expect("it stands beside build.rs");
    println!("cargo::rerun-if-changed={memory}");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    if has("RP2040") {
        // The boot loader's second stage, from embassy-rp.
        println!("cargo::rustc-link-arg-bins=-Tlink-rp.x");
    }
    if has("DEFMT") {
        println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    }
}
