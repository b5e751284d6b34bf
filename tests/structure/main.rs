//! How the house stands: which crate may use which, no circle of modules inside one, rooms in their order, and a command that alone speaks.
//!
//! Tests, benches, examples and build scripts are free.

mod borrowed;
mod changelog;
mod reader;
mod source;
mod still;
mod untested;

use source::Source;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use still::{Rule, STILL};

/// The command: words in, sentences out.
const COMMAND: &str = "host-cli";

/// Crate, and the crates of this workspace that it may use.
const ARROWS: &[(&str, &[&str])] = &[
    ("certified-count", &[]),
    ("fracdiff", &[]),
    ("fractional-control", &["certified-count", "fracdiff"]),
    ("fracdiff-c", &["fracdiff"]),
    ("haptic-link", &[]),
    ("haptic-loop", &["fracdiff"]),
    ("haptic-remote", &["fracdiff", "haptic-loop", "haptic-link"]),
    (
        "haptic-board",
        &["haptic-link", "haptic-loop", "haptic-remote"],
    ),
    (
        "haptic-teleoperation",
        &["fracdiff", "haptic-loop", "haptic-link"],
    ),
    (
        "haptic-devices",
        &["haptic-loop", "haptic-link", "haptic-remote"],
    ),
    (
        "haptic-emulator",
        &[
            "fracdiff",
            "haptic-devices",
            "haptic-link",
            "haptic-loop",
            "haptic-remote",
        ],
    ),
    ("haptic-tissue", &["fracdiff", "haptic-quantity"]),
    ("haptic-analysis", &["certified-count", "fracdiff"]),
    ("haptic-log", &[]),
    ("haptic-figure", &[]),
    ("haptic-quantity", &[]),
    (
        "haptic-experiment",
        &[
            "fracdiff",
            "fractional-control",
            "haptic-analysis",
            "haptic-devices",
            "haptic-link",
            "haptic-log",
            "haptic-loop",
            "haptic-quantity",
            "haptic-remote",
            "haptic-teleoperation",
            "haptic-tissue",
        ],
    ),
    (
        "haptic-selftest",
        &[
            "fracdiff",
            "haptic-experiment",
            "haptic-link",
            "haptic-loop",
            "haptic-remote",
        ],
    ),
    (
        "haptic-page",
        &[
            "fracdiff",
            "haptic-experiment",
            "haptic-log",
            "haptic-loop",
            "haptic-quantity",
            "haptic-tissue",
        ],
    ),
    (
        "reproduce",
        &[
            "fracdiff",
            "haptic-analysis",
            "haptic-experiment",
            "haptic-figure",
            "haptic-loop",
            "haptic-tissue",
        ],
    ),
];

/// Crate, and its rooms from the ground up: a room uses only those before it.
const ROOMS: &[(&str, &[&str])] = &[(
    "haptic-experiment",
    &[
        "document",
        "run",
        "judge",
        "experiment",
        "question",
        "control",
        "open",
    ],
)];

/// Crates that may use any: the command, and the root package, whose library only re-exports.
const ALL: &[&str] = &["host-cli", "fractional-haptics"];

/// Used by tests alone, and free to use any.
const FOR_TESTS: &str = "testkit";

/// Rule, crate, module, and what was found there.
type Offence = (Rule, String, String, String);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Name and folder of each crate, the root package first.
fn crates() -> Vec<(String, PathBuf)> {
    let folders = std::fs::read_dir(root().join("crates")).expect("a folder of crates");
    let mut folders: Vec<PathBuf> = folders
        .map(|entry| entry.expect("an entry").path())
        .collect();
    folders.sort();
    folders.insert(0, root().to_owned());
    let folders = folders
        .into_iter()
        .filter(|folder| folder.join("Cargo.toml").exists());
    folders
        .map(|folder| {
            let name = manifest(&folder)["package"]["name"]
                .as_str()
                .expect("a name")
                .to_owned();
            (name, folder)
        })
        .collect()
}

fn manifest(folder: &Path) -> toml::Table {
    let text = std::fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
    toml::from_str(&text).expect("is TOML")
}

/// What a crate depends on when it is used, not tested.
fn dependencies(folder: &Path) -> BTreeSet<String> {
    let manifest = manifest(folder);
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let targets = targets.into_iter().flat_map(|targets| targets.values());
    let tables = targets.map(|target| target.get("dependencies"));
    let tables = tables.chain([manifest.get("dependencies")]).flatten();
    let names = tables
        .filter_map(toml::Value::as_table)
        .flat_map(|table| table.keys());
    names.cloned().collect()
}

/// Offences that [`STILL`] does not allow, and entries of it without an offence.
fn judge(rules: &[Rule], found: &[Offence]) -> (Vec<String>, Vec<String>) {
    let is = |entry: &(Rule, &str, &str), offence: &Offence| {
        (entry.0, entry.1, entry.2) == (offence.0, offence.1.as_str(), offence.2.as_str())
    };
    let wrong = found
        .iter()
        .filter(|offence| !STILL.iter().any(|entry| is(entry, offence)));
    let wrong =
        wrong.map(|(rule, name, module, what)| format!("{rule:?}: {name} {module}: {what}"));
    let over = STILL.iter().filter(|entry| rules.contains(&entry.0));
    let over = over.filter(|entry| !found.iter().any(|offence| is(entry, offence)));
    (
        wrong.collect(),
        over.map(|entry| format!("{entry:?}")).collect(),
    )
}

fn assert_none(rules: &[Rule], found: &[Offence]) {
    let (wrong, over) = judge(rules, found);
    assert!(wrong.is_empty(), "not allowed:\n{}", wrong.join("\n"));
    assert!(
        over.is_empty(),
        "gone, so take it out of STILL:\n{}",
        over.join("\n")
    );
}

/// The circles of a graph: sets of files each of which imports from each other in the set, perhaps by way of others.
fn circles(imports: &BTreeMap<usize, BTreeSet<usize>>) -> Vec<BTreeSet<usize>> {
    let reached = |from: usize| {
        let mut seen = BTreeSet::new();
        let mut todo = vec![from];
        while let Some(at) = todo.pop() {
            let next = imports.get(&at).into_iter().flatten();
            todo.extend(next.filter(|&&to| seen.insert(to)));
        }
        seen
    };
    let reach: BTreeMap<usize, BTreeSet<usize>> =
        imports.keys().map(|&file| (file, reached(file))).collect();
    let mut circles = BTreeSet::new();
    for (file, reached) in &reach {
        let back = |other: &&usize| reach.get(other).is_some_and(|seen| seen.contains(file));
        let circle: BTreeSet<usize> = reached.iter().filter(back).copied().collect();
        if circle.len() > 1 {
            circles.insert(circle);
        }
    }
    circles.into_iter().collect()
}

fn circles_of(name: &str, source: &Source) -> Vec<Offence> {
    let imports = source.imports();
    let mut found = Vec::new();
    for circle in circles(&imports) {
        for &file in &circle {
            let others = imports[&file].intersection(&circle);
            let others: Vec<&str> = others
                .map(|&other| source.files[other].name.as_str())
                .collect();
            let module = source.files[file].name.clone();
            found.push((Rule::Circle, name.to_owned(), module, others.join(", ")));
        }
    }
    found
}

/// The floor of a module: that of its room, and none for the root of the crate.
fn floor(rooms: &[&str], module: &str) -> Option<usize> {
    let room = module.split("::").next().expect("a name");
    let floor = rooms.iter().position(|known| *known == room);
    assert!(
        floor.is_some() || room == "crate",
        "{room} is not one of the rooms {rooms:?}"
    );
    floor
}

/// Imports of a room from one above it.
fn upwards(name: &str, rooms: &[&str], source: &Source) -> Vec<Offence> {
    let floors: Vec<Option<usize>> = (source.files.iter())
        .map(|file| floor(rooms, &file.name))
        .collect();
    let mut found = Vec::new();
    for (from, files) in source.imports() {
        // The root may name them all.
        let up = files
            .into_iter()
            .filter(|&to| floors[from].is_some() && floors[from] < floors[to]);
        for to in up {
            let [module, other] = [from, to].map(|file| source.files[file].name.clone());
            found.push((Rule::Room, name.to_owned(), module, other));
        }
    }
    found
}

fn words_of(name: &str, source: &Source) -> Vec<Offence> {
    let mut found = Vec::new();
    // The kit speaks for tests, with which nothing that is given away is built.
    if [COMMAND, FOR_TESTS].contains(&name) {
        return found;
    }
    for file in &source.files {
        let mut offend = |rule, what: &str| {
            found.push((rule, name.to_owned(), file.name.clone(), what.to_owned()));
        };
        for macro_name in ["print", "println", "eprint", "eprintln", "dbg"] {
            if file.macros.contains(macro_name) {
                offend(Rule::Print, macro_name);
            }
        }
        for path in &file.paths {
            let starts = |prefix: &str| path == prefix || path.starts_with(&format!("{prefix}::"));
            if ["std::io::stdout", "std::io::stderr"]
                .iter()
                .any(|p| starts(p))
            {
                offend(Rule::Print, path);
            }
            if ["std::env::args", "std::env::args_os"]
                .iter()
                .any(|p| starts(p))
            {
                offend(Rule::Arguments, path);
            }
            if path
                .split("::")
                .next()
                .is_some_and(|first| first.starts_with("clap"))
            {
                offend(Rule::Clap, path);
            }
        }
        for text in file.texts.iter().filter(|text| names_a_flag(text)) {
            offend(Rule::Flag, text);
        }
    }
    found
}

/// Whether a text has a `--word` in it.
fn names_a_flag(text: &str) -> bool {
    text.match_indices("--").any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + 2..].chars().next();
        before != Some('-') && after.is_some_and(|letter| letter.is_ascii_lowercase())
    })
}

/// Whether a text has a key with its unit in it, `` `sample_time_s` ``.
fn spells_a_key(text: &str) -> bool {
    let quoted = text.split('`').skip(1).step_by(2);
    let mut quoted =
        quoted.filter(|word| word.bytes().all(|b| b == b'_' || b.is_ascii_lowercase()));
    quoted.any(|word| {
        ["_s", "_m", "_n", "_kg", "_per_m", "_per_s"]
            .iter()
            .any(|unit| word.ends_with(unit))
    })
}

#[test]
fn a_sentence_is_written_once_and_its_keys_are_values() {
    let mut found = Vec::new();
    for (name, folder) in crates() {
        for source in reader::read(&folder.join("src")) {
            for file in &source.files {
                let keys = file.texts.iter().filter(|text| spells_a_key(text));
                let keys = keys.filter(|_| ["haptic-experiment", COMMAND].contains(&name.as_str()));
                for what in file.edits.iter().chain(keys) {
                    let offence = (name.clone(), file.name.clone(), what.clone());
                    found.push((Rule::Sentence, offence.0, offence.1, offence.2));
                }
            }
        }
    }
    assert_none(&[Rule::Sentence], &found);
}

#[test]
fn crates_use_only_what_the_house_allows() {
    let all = crates();
    let ours: BTreeSet<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    let allowed: BTreeMap<&str, &[&str]> = ARROWS.iter().copied().collect();
    let mut found = Vec::new();
    for (name, folder) in &all {
        if ALL.contains(&name.as_str()) || name == FOR_TESTS {
            continue;
        }
        let allowed = allowed.get(name.as_str());
        let allowed = allowed.unwrap_or_else(|| panic!("{name} is not in the table of arrows"));
        let used = dependencies(folder);
        let used = used.iter().filter(|used| ours.contains(used.as_str()));
        for used in used.filter(|used| !allowed.contains(&used.as_str())) {
            found.push((Rule::Arrow, name.clone(), used.clone(), "used".to_owned()));
        }
    }
    assert_none(&[Rule::Arrow], &found);
    for (name, folder) in &all {
        assert!(
            !dependencies(folder).contains(FOR_TESTS),
            "{name} is built with {FOR_TESTS}"
        );
    }
}

#[test]
fn no_two_modules_of_a_crate_import_each_other_in_a_circle() {
    let mut found = Vec::new();
    for (name, folder) in crates() {
        for source in reader::read(&folder.join("src")) {
            found.extend(circles_of(&name, &source));
        }
    }
    assert_none(&[Rule::Circle], &found);
}

#[test]
fn a_room_uses_only_those_below_it() {
    let mut found = Vec::new();
    for (name, folder) in crates() {
        let Some((_, rooms)) = ROOMS.iter().find(|(known, _)| *known == name) else {
            continue;
        };
        for source in reader::read(&folder.join("src")) {
            found.extend(upwards(&name, rooms, &source));
        }
    }
    assert_none(&[Rule::Room], &found);
}

#[test]
fn only_the_command_prints_reads_arguments_and_names_its_flags() {
    let mut found = Vec::new();
    for (name, folder) in crates() {
        for source in reader::read(&folder.join("src")) {
            found.extend(words_of(&name, &source));
        }
        if name != COMMAND
            && dependencies(&folder)
                .iter()
                .any(|used| used.starts_with("clap"))
        {
            found.push((
                Rule::Clap,
                name,
                "crate".to_owned(),
                "its manifest".to_owned(),
            ));
        }
    }
    assert_none(
        &[Rule::Clap, Rule::Print, Rule::Arguments, Rule::Flag],
        &found,
    );
}

/// A crate of these files.
fn of_files(files: &[(&str, &str)]) -> Source {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        std::fs::write(file, text).expect("a file");
    }
    let mut sources = reader::read(folder.path());
    assert_eq!(sources.len(), 1, "one root");
    sources.remove(0)
}

#[test]
fn an_arrow_between_rooms_is_found_through_a_re_export_and_only_where_it_goes_up() {
    let upwards = |high: &str, low: &str| {
        let root = "mod low; mod high; pub use high::High; pub use low::Low;";
        let files = [("lib.rs", root), ("high/x.rs", high), ("low/y.rs", low)];
        let rooms = [
            ("high.rs", "mod x; pub use x::High;"),
            ("low.rs", "mod y; pub use y::Low;"),
        ];
        let source = of_files(&[&files[..], &rooms[..]].concat());
        let found = upwards("a crate", &["low", "high"], &source);
        let found = found.into_iter().map(|(_, _, module, to)| (module, to));
        found.collect::<Vec<_>>()
    };
    let high = "use crate::Low; pub struct High(Low);";
    assert_eq!(upwards(high, "pub struct Low;"), []);
    let up = [("low::y".to_owned(), "high::x".to_owned())];
    let low = "use crate::High; pub struct Low(High);";
    assert_eq!(upwards("pub struct High;", low), up);
}

#[test]
fn a_circle_is_found_through_re_exports_and_macros_and_only_where_there_is_one() {
    let circle = |files: &[(&str, &str)]| {
        let found = circles_of("a crate", &of_files(files));
        found
            .into_iter()
            .map(|(_, _, module, _)| module)
            .collect::<Vec<_>>()
    };
    let root = ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;");
    // Each imports the other from the root, one of them inside a macro.
    let a = ("a.rs", "use crate::B; pub struct A(B);");
    let b = (
        "b.rs",
        "pub struct B; impl B { fn b(&self) { assert!(crate::A::c(), \"crate::a\"); } }",
    );
    assert_eq!(circle(&[root, a, b]), ["a", "b"]);
    // A comment, a text, a test and a link in documentation are no imports.
    let b = (
        "b.rs",
        "/// [`A`](crate::A)\npub struct B; // crate::A\nconst T: &str = \"crate::A\";\n\
         #[cfg(test)] mod tests { use crate::A; use super::*; }",
    );
    assert_eq!(circle(&[root, a, b]), [""; 0]);
    // A parent that hands on what its child defines, and a child that uses what its parent defines.
    let root = ("lib.rs", "mod p;");
    let child = ("p/c.rs", "use super::P; pub struct C(P);");
    let hands_on = ("p/mod.rs", "mod c; pub use c::C; pub struct P;");
    assert_eq!(circle(&[root, hands_on, child]), [""; 0]);
    let uses = (
        "p/mod.rs",
        "mod c; pub use c::C; pub struct P; fn p(c: C) {}",
    );
    assert_eq!(circle(&[root, uses, child]), ["p", "p::c"]);
    // By a module that is imported as a whole.
    let uses = ("p/mod.rs", "mod c; pub struct P; fn p() { c::f(); }");
    let child = ("p/c.rs", "use crate::p; pub fn f() -> p::P { p::P }");
    assert_eq!(circle(&[root, uses, child]), ["p", "p::c"]);
}

#[test]
fn a_flag_in_a_text_is_told_from_a_dash() {
    for (text, names) in [
        ("give --out", true),
        ("--sample-time", true),
        ("a -- b", false),
        ("---- test", false),
        ("1--2", false),
    ] {
        assert_eq!(names_a_flag(text), names, "{text}");
    }
}

/// The files of Rust below a folder.
pub(crate) fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            found.push(path);
        }
    }
}
