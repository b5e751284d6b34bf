//! The wall below what touches the world: pure crates use pure crates, and name no file, thread, socket, clock, process or environment.

use super::{SOURCES, crates, dependencies, manifest, reader, root};
use std::collections::BTreeSet;

/// Paths that touch the world.
const WORLD: &[&str] = &[
    "std::env",
    "std::fs",
    "std::net",
    "std::os",
    "std::path::absolute",
    "std::process",
    "std::thread",
    "std::time::Instant",
    "std::time::SystemTime",
];

/// Methods of a path that ask a disk.
const ASKS_A_DISK: &[&str] = &[
    "canonicalize",
    "exists",
    "is_dir",
    "is_file",
    "metadata",
    "read_dir",
    "try_exists",
];

/// Modules of pure crates behind a feature, which no pure crate turns on.
const BEHIND_A_FEATURE: &[(&str, &str, &str)] = &[
    ("measured-table", "text_file", "files"),
    ("haptic-loop", "realtime", "std"),
    ("haptic-remote", "serial", "std"),
    ("haptic-remote", "held_clock", "std"),
];

/// The crates of a storey, by the drawing in `ARCHITECTURE.md`.
fn storey(name: &str) -> BTreeSet<String> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("a text");
    let (_, drawing) = text.split_once("\n## Storeys\n").expect("a drawing");
    let (_, drawing) = drawing.split_once("```text\n").expect("a drawing");
    let (drawing, _) = drawing.split_once("```").expect("its end");
    let mut of = "";
    let mut found = BTreeSet::new();
    for line in drawing.lines() {
        let mut words = line.split_whitespace().peekable();
        if let Some(first) = words.next_if(|first| ["pure", "machine", "doors"].contains(first)) {
            of = first;
        }
        if of == name {
            found.extend(words.map(str::to_owned));
        }
    }
    found
}

/// What of the world a file of a crate names.
fn of_the_world(file: &reader::File) -> Vec<String> {
    let is = |path: &&String| {
        let mut world = WORLD.iter();
        world.any(|known| *path == known || path.starts_with(&format!("{known}::")))
    };
    let paths = file.paths.iter().filter(is).cloned();
    let asked = ASKS_A_DISK
        .iter()
        .filter(|asks| file.asked.contains(**asks));
    paths.chain(asked.map(ToString::to_string)).collect()
}

#[test]
fn every_crate_is_in_a_storey() {
    let all: BTreeSet<String> = ["pure", "machine", "doors"]
        .into_iter()
        .flat_map(storey)
        .collect();
    let known = crates().into_iter().map(|(name, _)| name);
    let known = known.filter(|name| !["fractional-haptics", "testkit"].contains(&name.as_str()));
    let others = ["python", "firmware"].map(str::to_owned);
    assert_eq!(known.chain(others).collect::<BTreeSet<_>>(), all);
}

#[test]
fn the_pure_storey_uses_itself_and_no_feature_that_touches_the_world() {
    let pure = storey("pure");
    let ours: BTreeSet<String> = crates().into_iter().map(|(name, _)| name).collect();
    for (name, folder) in crates().into_iter().filter(|(name, _)| pure.contains(name)) {
        for used in dependencies(&folder).intersection(&ours) {
            let is_pure = pure.contains(used) || used == "haptic-remote";
            assert!(is_pure, "{name} is pure and uses {used}");
            let table = &manifest(&folder)["dependencies"][used];
            let features = table.get("features").and_then(toml::Value::as_array);
            let asks = |feature: &str| {
                let mut features = features.into_iter().flatten();
                features.any(|known| known.as_str() == Some(feature))
            };
            for (_, module, feature) in BEHIND_A_FEATURE.iter().filter(|known| known.0 == used) {
                assert!(
                    !asks(feature),
                    "{name} is pure and turns on {used}/{feature} for {module}"
                );
            }
        }
    }
}

#[test]
fn the_pure_storey_names_nothing_of_the_world() {
    let pure = storey("pure");
    let mut found = Vec::new();
    let sources = SOURCES
        .iter()
        .filter(|(name, _)| pure.contains(name) || name == "haptic-remote");
    for (name, sources) in sources {
        for file in sources.iter().flat_map(|source| &source.files) {
            let module = file.name.split("::").next().unwrap_or_default();
            let is_behind = |known: &&(&str, &str, &str)| known.0 == name && known.1 == module;
            if BEHIND_A_FEATURE.iter().any(|known| is_behind(&known)) {
                continue;
            }
            let world = of_the_world(file).into_iter();
            found.extend(world.map(|what| format!("{name} {}: {what}", file.name)));
        }
    }
    assert!(found.is_empty(), "not pure:\n{}", found.join("\n"));
}

#[test]
fn what_touches_the_world_is_found() {
    let named = |code: &str| {
        let source = super::of_files(&[("lib.rs", code)]);
        of_the_world(&source.files[0])
    };
    assert_eq!(
        named("use std::fs::File; pub fn f(file: &File) -> &File { file }"),
        ["std::fs::File"]
    );
    assert_eq!(
        named("pub fn f() { std::thread::yield_now(); }"),
        ["std::thread::yield_now"]
    );
    assert_eq!(
        named("use std::path; pub fn f() { let _ = path::absolute(\"x\"); }").len(),
        1
    );
    assert_eq!(
        named("pub fn f(p: &std::path::Path) -> bool { p.is_dir() }"),
        ["is_dir"]
    );
    let plain = "use std::time::Duration; pub fn f(p: Duration) -> f64 { p.as_secs_f64() }";
    assert!(named(plain).is_empty());
    assert!(named("#[cfg(test)]\nmod tests { use std::fs::File; }").is_empty());
}
