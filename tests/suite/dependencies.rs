//! The table of dependencies in `ARCHITECTURE.md` against the manifests: each is justified, and none that is gone.
//! All they depend on: its licence, where it comes from, and that `deny.toml` does not ban it.

use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

/// What `cargo` prints with these arguments, in the repository's folder.
fn cargo(arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}

fn metadata(manifest: &str, arguments: &[&str]) -> Value {
    let start = [
        "metadata",
        "--format-version=1",
        "--manifest-path",
        manifest,
    ];
    serde_json::from_slice(&cargo(&[&start, arguments].concat())).expect("is JSON")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

/// Dependencies from elsewhere, of all packages of a workspace.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let metadata = metadata(manifest, &["--no-deps"]);
    let dependencies = list(&metadata["packages"])
        .iter()
        .flat_map(|package| list(&package["dependencies"]))
        .filter(|dependency| dependency["path"].is_null());
    dependencies
        .map(|dependency| text(&dependency["name"]).to_owned())
        .collect()
}

/// The licences of what is built, as its manifests write them: `deny.toml` allows each, and `cargo deny` checks that it does, by night.
const LICENCES: [&str; 22] = [
    "(MIT OR Apache-2.0) AND Unicode-3.0",
    "0BSD OR MIT OR Apache-2.0",
    "Apache-2.0",
    "Apache-2.0 / MIT",
    "Apache-2.0 OR BSL-1.0",
    "Apache-2.0 OR MIT",
    "Apache-2.0 WITH LLVM-exception OR Apache-2.0 OR MIT",
    "(Apache-2.0 OR MIT) AND BSD-3-Clause",
    "Apache-2.0/MIT",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSD-3-Clause OR MIT OR Apache-2.0",
    "CC0-1.0 OR MIT-0 OR Apache-2.0",
    "MIT",
    "MIT OR Apache-2.0",
    "MIT OR GPL-3.0-only",
    "MIT OR Zlib OR Apache-2.0",
    "MIT/Apache-2.0",
    "Unlicense OR MIT",
    "Unlicense/MIT",
    "Zlib",
    "Zlib OR Apache-2.0 OR MIT",
];
/// Those of single packages, see `exceptions` in `deny.toml`.
const EXCEPTIONS: [(&str, &str); 1] = [("serialport", "MPL-2.0")];

#[test]
fn all_that_is_built_comes_from_the_registry_under_an_allowed_licence_and_is_not_banned() {
    let deny: toml::Table = toml::from_str(include_str!("../../deny.toml")).expect("is TOML");
    // What is built here; a package of another system need not be on the disk.
    let host = Command::new("rustc")
        .args(["--print", "host-tuple"])
        .output();
    let host = String::from_utf8(host.expect("rustc runs").stdout).expect("is text");
    let platform = format!("--filter-platform={}", host.trim());
    let metadata = metadata("Cargo.toml", &["--locked", "--all-features", &platform]);
    let banned = deny["bans"]["deny"].as_array().expect("a list");
    let mut wrong = Vec::new();
    for package in list(&metadata["packages"]) {
        let name = text(&package["name"]);
        if let Some(ban) = banned
            .iter()
            .find(|ban| ban["crate"].as_str() == Some(name))
        {
            wrong.push(format!("{name} {}", ban["reason"]));
        }
        if let Some(source) = package["source"].as_str()
            && source != "registry+https://github.com/rust-lang/crates.io-index"
        {
            wrong.push(format!("{name} comes from {source}"));
        }
        let licence = package["license"].as_str().unwrap_or("UNKNOWN");
        if !LICENCES.contains(&licence) && !EXCEPTIONS.contains(&(name, licence)) {
            wrong.push(format!("{name} is under {licence}"));
        }
    }
    assert!(wrong.is_empty(), "not allowed by deny.toml: {wrong:#?}");
}

#[test]
fn every_dependency_is_justified_and_every_justified_one_is_there() {
    let architecture = include_str!("../../ARCHITECTURE.md");
    let (_, section) = architecture
        .split_once("\n## Dependencies\n")
        .expect("a section of dependencies");
    let mut justified = BTreeSet::new();
    for row in section.lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [names, why] = cells[..] else {
            panic!("not two cells: {row}");
        };
        assert!(!why.is_empty(), "{row}");
        // Without what stands in brackets behind a name.
        let names = names.split(',').map(|name| name.split(" (").next());
        for name in names.flatten().map(str::trim) {
            let is_new = justified.insert(name.to_owned());
            assert!(is_new, "{name} has two rows in ARCHITECTURE.md");
        }
    }
    justified.remove("crate");
    let manifests = [
        "Cargo.toml",
        "benches/Cargo.toml",
        "firmware/Cargo.toml",
        "firmware/examples/rp2040/Cargo.toml",
        "fuzz/Cargo.toml",
        "python/Cargo.toml",
    ];
    let used: BTreeSet<String> = manifests.into_iter().flat_map(dependencies).collect();
    let missing: Vec<_> = used.difference(&justified).collect();
    let gone: Vec<_> = justified.difference(&used).collect();
    assert!(missing.is_empty(), "not in ARCHITECTURE.md: {missing:?}");
    assert!(
        gone.is_empty(),
        "in ARCHITECTURE.md, but not used: {gone:?}"
    );
}

/// Packages with their features, as these options of `cargo tree` choose them.
fn chosen(options: &[&str]) -> BTreeSet<String> {
    let start = ["tree", "--locked", "--prefix=none", "--format={p} {f}"];
    let packages = String::from_utf8(cargo(&[&start, options].concat())).expect("is text");
    let packages = packages.lines();
    packages
        .map(|line| line.trim_end_matches(" (*)").to_owned())
        .collect()
}

/// Otherwise `cargo test` after `cargo run -p host-cli` builds half of all crates once more.
#[test]
fn the_command_is_built_with_the_features_that_tests_need() {
    let command = chosen(&["--package=host-cli", "--edges=normal,build"]);
    let tests = chosen(&["--workspace", "--edges=normal,build,dev"]);
    let twice: Vec<_> = command.difference(&tests).collect();
    assert!(
        twice.is_empty(),
        "give the command these features too, or tests none of theirs: {twice:#?}"
    );
}
