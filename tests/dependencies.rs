//! The table of dependencies in `ARCHITECTURE.md` against the manifests: each is justified, and none that is gone.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Dependencies from elsewhere, of all packages of a workspace.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version=1", "--manifest-path"])
        .arg(root.join(manifest))
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
    let packages = metadata["packages"].as_array().expect("a list");
    let dependencies = packages
        .iter()
        .flat_map(|package| package["dependencies"].as_array().expect("a list"))
        .filter(|dependency| dependency["path"].is_null());
    dependencies
        .map(|dependency| dependency["name"].as_str().expect("a name").to_owned())
        .collect()
}

#[test]
fn every_dependency_is_justified_and_every_justified_one_is_there() {
    let architecture = include_str!("../ARCHITECTURE.md");
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
        justified.extend(names.flatten().map(|name| name.trim().to_owned()));
    }
    justified.remove("crate");
    let manifests = ["Cargo.toml", "firmware/Cargo.toml", "fuzz/Cargo.toml"];
    let used: BTreeSet<String> = manifests.into_iter().flat_map(dependencies).collect();
    let missing: Vec<_> = used.difference(&justified).collect();
    let gone: Vec<_> = justified.difference(&used).collect();
    assert!(missing.is_empty(), "not in ARCHITECTURE.md: {missing:?}");
    assert!(gone.is_empty(), "in ARCHITECTURE.md, but not used: {gone:?}");
}
