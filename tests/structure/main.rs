//! How the house stands: which crate may use which, no circle of modules inside one, rooms in their order, and a command that alone speaks.
//!
//! Tests, benches, examples and build scripts are free.

mod files;
mod reader;
mod storeys;

use reader::Source;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The command: words in, sentences out.
const COMMAND: &str = "host-cli";

/// Crate, and its rooms from the ground up: a room uses only those before it.
const ROOMS: &[(&str, &[&str])] = &[(
    "haptic-experiment",
    &["judge", "experiment", "question", "open", "live"],
)];

/// Crates that may use any: the command, and the root package, whose library only re-exports.
const ALL: &[&str] = &["host-cli", "fractional-haptics"];

/// Used by tests alone, and free to use any.
const FOR_TESTS: &str = "testkit";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Name and folder of each crate, the root package first.
fn crates() -> Vec<(String, PathBuf)> {
    let folders = std::fs::read_dir(root().join("crates")).expect("a folder of crates");
    let mut folders: Vec<PathBuf> = folders
        .map(|entry| entry.expect("an entry").path())
        .filter(|folder| folder.join("Cargo.toml").exists())
        .collect();
    folders.sort();
    folders.insert(0, root().to_owned());
    let named = |folder: PathBuf| {
        let name = manifest(&folder)["package"]["name"].clone();
        (name.as_str().expect("a name").to_owned(), folder)
    };
    folders.into_iter().map(named).collect()
}

/// Each crate with those that it may use, by the table in `ARCHITECTURE.md`.
fn arrows() -> BTreeMap<String, BTreeSet<String>> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("a text");
    let (_, table) = text.split_once("\n| crate | uses |\n").expect("a table");
    let rows = table.lines().take_while(|line| line.starts_with('|'));
    let names = |cell: &str| -> BTreeSet<String> {
        let names = cell.split('`').skip(1).step_by(2);
        names.map(str::to_owned).collect()
    };
    rows.flat_map(|row| {
        let (users, used) = row[1..].split_once('|').expect("two cells");
        let used = names(used);
        names(users)
            .into_iter()
            .map(move |user| (user, used.clone()))
    })
    .collect()
}

/// The sources of each crate, read once for all tests.
static SOURCES: LazyLock<Vec<(String, Vec<Source>)>> = LazyLock::new(|| {
    let read = |(name, folder): (String, PathBuf)| (name, reader::read(&folder.join("src")));
    crates().into_iter().map(read).collect()
});

/// What is found in the sources of each crate, which is to be nothing.
fn assert_none(find: impl Fn(&str, &Source) -> Vec<String>) {
    let mut found = Vec::new();
    for (name, sources) in &*SOURCES {
        for source in sources {
            let found_here = find(name, source).into_iter();
            found.extend(found_here.map(|what| format!("{name} {what}")));
        }
    }
    assert!(found.is_empty(), "not allowed:\n{}", found.join("\n"));
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

/// Each file of a circle, with the others of it that it imports.
fn circles_of(source: &Source) -> Vec<(String, String)> {
    let imports = source.imports();
    let name = |file: &usize| source.files[*file].name.clone();
    let in_circle = |circle: &BTreeSet<usize>| -> Vec<(String, String)> {
        let others = |file| imports[file].intersection(circle).map(name);
        let others = |file| others(file).collect::<Vec<_>>().join(", ");
        circle
            .iter()
            .map(|file| (name(file), others(file)))
            .collect()
    };
    circles(&imports).iter().flat_map(in_circle).collect()
}

/// The room of a file: its module at the top.
fn room_of(source: &Source, file: usize) -> &str {
    let name = source.files[file].name.split([':', ' ']).next();
    name.expect("a name")
}

/// The rooms that each file of a crate uses besides its own: those that define what it names, and those through which it names it.
fn rooms_used(source: &Source) -> BTreeMap<usize, BTreeSet<String>> {
    let mut used = source.rooms_named();
    for (file, files) in source.imports() {
        let rooms = files
            .into_iter()
            .map(|other| room_of(source, other).to_owned());
        used.entry(file).or_default().extend(rooms);
    }
    for (file, rooms) in &mut used {
        rooms.remove(room_of(source, *file));
    }
    used
}

/// Imports of a room from one above it; the root, which is in no room, may name them all.
fn upwards(rooms: &[&str], source: &Source) -> Vec<(String, String)> {
    let floor = |room: &str| {
        let floor = rooms.iter().position(|known| *known == room);
        assert!(
            floor.is_some() || room == "crate",
            "{room} is not one of the rooms {rooms:?}"
        );
        floor
    };
    let used = rooms_used(source).into_iter();
    let pairs = used.flat_map(|(from, rooms)| rooms.into_iter().map(move |to| (from, to)));
    let is_up = |(from, to): &(usize, String)| {
        let from = floor(room_of(source, *from));
        from.is_some() && from < floor(to)
    };
    let up = pairs.filter(is_up);
    up.map(|(from, to)| (source.files[from].name.clone(), to))
        .collect()
}

/// Printing, arguments, their parser and flags.
fn words_of(name: &str, source: &Source) -> Vec<String> {
    /// Standard output and standard error, the arguments of the process, and the parser of command lines.
    const PATHS: [&str; 5] = [
        "std::io::stdout",
        "std::io::stderr",
        "std::env::args",
        "std::env::args_os",
        "clap",
    ];
    // The kit speaks for tests, with which nothing that is given away is built.
    if [COMMAND, FOR_TESTS].contains(&name) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for file in &source.files {
        let macros = ["print", "println", "eprint", "eprintln", "dbg"].into_iter();
        let macros = macros.filter(|name| file.macros.contains(*name));
        let is = |path: &&String| {
            let starts = |prefix: &&str| {
                *path == prefix
                    || path.starts_with(&format!("{prefix}::"))
                    || path.starts_with("clap_")
            };
            PATHS.iter().any(starts)
        };
        let paths = file.paths.iter().filter(is).map(String::as_str);
        let is_flag = |word: &str| {
            let flag = word.trim_start_matches(['`', '"', '(']).strip_prefix("--");
            flag.is_some_and(|flag| flag.starts_with(|letter: char| letter.is_ascii_lowercase()))
        };
        let texts = file.texts.iter();
        let flags = texts.filter(|text| text.split([' ', '\n']).any(is_flag));
        let words = macros.chain(paths).chain(flags.map(String::as_str));
        found.extend(words.map(|what| format!("{}: {what}", file.name)));
    }
    found
}

/// The files that open one for writing, by crate and module, with the reason. The first is the door for all others; none of the rest writes
/// a file that a person keeps.
const WRITERS: [(&str, &str, &str); 4] = [
    ("haptic-log", "record::new_file", "the door"),
    (
        "haptic-page",
        "server",
        "the address, for its owner's eyes alone: goes with the server",
    ),
    ("haptic-remote", "serial::port", "a setting of the kernel"),
    (
        "host-cli",
        "command::device::flash::drive",
        "the drive of a boot loader, which renames nothing",
    ),
];

/// Functions and types that make, open or rename a file.
const OPENS: [&str; 9] = [
    "std::fs::File::create",
    "std::fs::File::create_new",
    "std::fs::File::options",
    "std::fs::OpenOptions",
    "std::fs::copy",
    "std::fs::hard_link",
    "std::fs::rename",
    "std::fs::write",
    "csv::Writer::from_path",
];

#[test]
fn one_door_leads_to_every_file_that_is_written() {
    let python = (
        "python".to_owned(),
        reader::read(&root().join("python/rust")),
    );
    let mut found = Vec::new();
    for (name, sources) in SOURCES.iter().chain([&python]) {
        let opens = |path: &String| OPENS.iter().any(|known| path.starts_with(known));
        let files = sources.iter().flat_map(|source| &source.files);
        let files = files.filter(|file| name != FOR_TESTS && file.paths.iter().any(opens));
        found.extend(files.map(|file| (name.as_str(), file.name.as_str())));
    }
    let known = WRITERS.map(|(name, file, _)| (name, file));
    assert_eq!(
        found, known,
        "write by haptic_log::record::{{NewFile, LineFile}}"
    );
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
    assert_none(|name, source| {
        let of_keys = [
            "haptic-document",
            "haptic-trial",
            "haptic-measurement",
            "haptic-question",
            "haptic-run",
            "haptic-experiment",
            COMMAND,
        ]
        .contains(&name);
        let file = |file: &reader::File| {
            let keys = file
                .texts
                .iter()
                .filter(|text| of_keys && spells_a_key(text));
            let found = file.edits.iter().chain(keys);
            found
                .map(|what| format!("{}: {what}", file.name))
                .collect::<Vec<_>>()
        };
        source.files.iter().flat_map(file).collect()
    });
}

#[test]
fn crates_use_only_what_the_house_allows() {
    let all = crates();
    let arrows = arrows();
    for (name, folder) in &all {
        let used = dependencies(folder);
        assert!(
            !used.contains(FOR_TESTS),
            "{name} is built with {FOR_TESTS}"
        );
        assert!(
            name == COMMAND || !used.iter().any(|used| used.starts_with("clap")),
            "{name} depends on the parser of command lines"
        );
        if ALL.contains(&name.as_str()) || name == FOR_TESTS {
            continue;
        }
        let allowed = arrows.get(name);
        let allowed = allowed.unwrap_or_else(|| panic!("{name} is not in the table of arrows"));
        for (ours, _) in &all {
            assert!(
                !used.contains(ours) || allowed.contains(ours),
                "{name} uses {ours}"
            );
        }
    }
}

#[test]
fn no_two_modules_of_a_crate_import_each_other_in_a_circle() {
    assert_none(|_, source| {
        let found = circles_of(source).into_iter();
        found
            .map(|(module, others)| format!("{module}: {others}"))
            .collect()
    });
    for folder in ["firmware", "firmware/examples/rp2040"] {
        let sources = reader::read(&root().join(folder).join("src"));
        let found: Vec<_> = sources.iter().flat_map(circles_of).collect();
        assert_eq!(found, [], "{folder}");
    }
}

#[test]
fn no_two_scripts_of_the_page_import_each_other_in_a_circle() {
    let folder = std::fs::read_dir(root().join("page/src")).expect("a folder of scripts");
    let scripts = folder.filter_map(|entry| {
        let path = entry.expect("an entry").path();
        let name = path.file_name()?.to_str()?.strip_suffix(".ts")?.to_owned();
        Some((name, std::fs::read_to_string(&path).expect("a text")))
    });
    let scripts: Vec<(String, String)> = scripts.collect();
    let of = |text: &str| {
        let imported = text.split("from \"./").skip(1);
        let imported = imported.filter_map(|rest| rest.split('"').next());
        let place = |name: &str| scripts.iter().position(|script| script.0 == name);
        imported.filter_map(place).collect::<BTreeSet<usize>>()
    };
    let imports = scripts.iter().map(|script| of(&script.1)).enumerate();
    let imports: BTreeMap<usize, BTreeSet<usize>> = imports.collect();
    assert!(imports.values().any(|imported| imported.len() > 5));
    let name = |file: &usize| scripts[*file].0.as_str();
    let found = circles(&imports).into_iter();
    let found = found.map(|circle| circle.iter().map(name).collect::<Vec<_>>().join(", "));
    assert_eq!(found.collect::<Vec<_>>(), [""; 0]);
}

/// Rooms of a crate, its modules at the top with all in them, that use each other in a circle.
#[test]
fn no_two_rooms_of_a_crate_use_each_other_in_a_circle() {
    assert_none(|_, source| {
        let all = (0..source.files.len()).map(|file| room_of(source, file));
        let rooms: Vec<&str> = all.collect::<BTreeSet<_>>().into_iter().collect();
        let place = |room: &str| rooms.iter().position(|known| *known == room);
        let mut uses: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for (file, used) in rooms_used(source) {
            let from = place(room_of(source, file)).expect("a room");
            let to = used.iter().filter_map(|room| place(room));
            uses.entry(from).or_default().extend(to);
        }
        let name = |room: &usize| rooms[*room];
        let named = |circle: BTreeSet<usize>| circle.iter().map(name).collect::<Vec<_>>();
        let found = circles(&uses).into_iter().map(named);
        found.map(|names| names.join(", ")).collect()
    });
}

#[test]
fn a_room_uses_only_those_below_it() {
    assert_none(|name, source| {
        let rooms = ROOMS.iter().find(|(known, _)| *known == name);
        for room in rooms.into_iter().flat_map(|(_, rooms)| *rooms) {
            let is_there = (0..source.files.len()).any(|file| room_of(source, file) == *room);
            assert!(is_there, "{name} has no room {room}");
        }
        let found = rooms.map(|(_, rooms)| upwards(rooms, source));
        let found = found.into_iter().flatten();
        found
            .map(|(module, other)| format!("{module}: {other}"))
            .collect()
    });
}

#[test]
fn only_the_command_prints_reads_arguments_and_names_its_flags() {
    assert_none(words_of);
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
        crate::upwards(&["low", "high"], &source)
    };
    let high = "use crate::Low; pub struct High(Low);";
    assert_eq!(upwards(high, "pub struct Low;"), []);
    let up = [("low::y".to_owned(), "high".to_owned())];
    let low = "use crate::High; pub struct Low(High);";
    assert_eq!(upwards("pub struct High;", low), up);
    // What is defined below is used from above all the same.
    let low = "use crate::high; pub struct Low; fn low() { high::handed_on(); }";
    assert_eq!(upwards("pub use crate::low::handed_on;", low), up);
    let low = "pub struct Low; fn low() { crate::High::make(); }";
    assert_eq!(upwards("pub use crate::low::Low as High;", low), up);
    let low = "pub struct Low; fn low(_: super::super::high::Low) {}";
    assert_eq!(upwards("pub use crate::low::Low;", low), up);
}

#[test]
fn a_circle_is_found_through_re_exports_and_macros_and_only_where_there_is_one() {
    let circle = |files: &[(&str, &str)]| {
        let found = circles_of(&of_files(files)).into_iter();
        found.map(|(module, _)| module).collect::<Vec<_>>()
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
