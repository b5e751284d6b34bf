//! The table of dependencies in `ARCHITECTURE.md` against the manifests: each is justified, and none that is gone.
//! All they depend on against `deny.toml`: licences, where they come from, and what is banned.

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

/// Parts of a licence expression between these words, outside of brackets.
fn parts<'a>(expression: &'a str, word: &str) -> Vec<&'a str> {
    let mut parts = vec![expression];
    for (at, _) in expression.rmatch_indices(word) {
        let before = &expression[..at];
        if before.matches('(').count() == before.matches(')').count() {
            let behind = parts.pop().map(|part| &part[at + word.len()..]);
            parts.extend(behind);
            parts.push(before);
        }
    }
    parts
}

/// Whether a licence expression can be met with these licences: `OR` (formerly `/`), `AND`, `WITH`, brackets.
fn is_met(expression: &str, allowed: &[&str]) -> bool {
    let one = |part: &str| {
        let inner = part.trim().strip_prefix('(');
        match inner.and_then(|inner| inner.strip_suffix(')')) {
            Some(inner) => is_met(inner, allowed),
            None => allowed.contains(&part.trim()),
        }
    };
    let expression = expression.replace('/', " OR ");
    let mut ways = parts(&expression, " OR ").into_iter();
    ways.any(|way| parts(way, " AND ").into_iter().all(one))
}

#[test]
fn all_that_is_built_comes_from_the_registry_under_an_allowed_licence_and_is_not_banned() {
    let deny: toml::Table = toml::from_str(include_str!("../../deny.toml")).expect("is TOML");
    let licenses = &deny["licenses"];
    let names = |value: &toml::Value| -> Vec<String> {
        let list = value.as_array().expect("a list").iter();
        list.map(|name| name.as_str().expect("a text").to_owned())
            .collect()
    };
    let allowed = names(&licenses["allow"]);
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
        let mut allowed = allowed.clone();
        for exception in licenses["exceptions"].as_array().expect("a list") {
            if exception["crate"].as_str() == Some(name) {
                allowed.extend(names(&exception["allow"]));
            }
        }
        let allowed: Vec<&str> = allowed.iter().map(String::as_str).collect();
        let licence = package["license"].as_str().unwrap_or("UNKNOWN");
        if !is_met(licence, &allowed) {
            wrong.push(format!("{name} is under {licence}"));
        }
    }
    assert!(wrong.is_empty(), "not allowed by deny.toml: {wrong:#?}");
}

#[test]
fn expressions_of_licences_are_understood() {
    let allowed = ["MIT", "Apache-2.0 WITH LLVM-exception", "Unicode-3.0"];
    for (expression, met) in [
        ("MIT", true),
        ("MIT/Apache-2.0", true),
        ("GPL-3.0-only", false),
        ("GPL-3.0-only OR MIT", true),
        ("GPL-3.0-only AND MIT", false),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", true),
        ("(MIT OR Apache-2.0) AND NCSA", false),
        ("Apache-2.0 WITH LLVM-exception", true),
        ("Apache-2.0", false),
    ] {
        assert_eq!(is_met(expression, &allowed), met, "{expression}");
    }
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
