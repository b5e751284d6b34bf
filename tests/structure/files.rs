//! Rules that are read from the text of files: sources of another crate, tests that nobody runs, lines twice, idioms in comments.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The files of Rust below a folder, with their texts; builds are left out.
fn files(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
    files_of("rs", folder, found);
}

/// The files with this extension below a folder.
fn files_of(wanted: &str, folder: &Path, found: &mut Vec<(PathBuf, String)>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            if !path.ends_with("target") {
                files_of(wanted, &path, found);
            }
        } else if path.extension().is_some_and(|kind| kind == wanted) {
            let text = std::fs::read_to_string(&path).expect("a text");
            found.push((path, text));
        }
    }
}

/// Code that two crates need is a crate, so that an arrow leads to it.
#[test]
fn no_source_is_included_from_another_crate() {
    let mut found = Vec::new();
    for (_, folder) in crate::crates() {
        files(&folder.join("src"), &mut found);
    }
    assert!(found.len() > 100, "{}", found.len());
    for (file, text) in found {
        let mut paths = text.lines().filter(|line| line.starts_with("#[path"));
        assert!(
            !paths.any(|path| path.contains("../")),
            "{}",
            file.display()
        );
    }
}

/// `std::time::Instant` does not count the time for which a machine slept. `haptic-log` measures with it how long a disk takes.
#[test]
fn silence_and_lateness_are_judged_by_the_one_clock_that_counts_a_sleep() {
    let mut found = Vec::new();
    for (name, folder) in crate::crates() {
        if !["haptic-log", crate::FOR_TESTS].contains(&name.as_str()) {
            files(&folder.join("src"), &mut found);
        }
    }
    found.retain(|(path, text)| text.contains("Instant::now") && !path.ends_with("moment.rs"));
    let named: Vec<_> = found.iter().map(|(path, _)| path).collect();
    assert!(
        named.is_empty(),
        "take haptic_loop::realtime::Moment in {named:?}"
    );
}

/// A sweep's folder is its own door: a lock, a manifest and parts that are renamed when they are whole. The tissue is in a folder that goes; a study has its table.
#[test]
fn a_file_of_the_python_package_is_written_by_its_doors() {
    const DOORS: [&str; 5] = ["experiment", "folder", "in_parquet", "in_zarr", "records"];
    const WRITES: [&str; 6] = [
        "write_text(",
        "write_bytes(",
        "os.open(",
        "write_table(",
        "\"w\"",
        "\"a\"",
    ];
    let mut found = Vec::new();
    files_of("py", &crate::root().join("python/src"), &mut found);
    let writes =
        |line: &str| !line.contains(">>>") && WRITES.iter().any(|word| line.contains(word));
    found.retain(|(_, text)| text.lines().any(writes));
    let mut found: Vec<_> = found
        .iter()
        .filter_map(|(path, _)| path.file_stem()?.to_str())
        .collect();
    found.sort_unstable();
    assert_eq!(found, DOORS);
}

#[test]
fn no_test_stands_where_none_is_run() {
    let mut looked_at = 0;
    for (name, folder) in crate::crates() {
        let manifest = crate::manifest(&folder);
        let run = manifest.get("lib").and_then(|lib| lib.get("test"));
        if run.and_then(toml::Value::as_bool) != Some(false) {
            continue;
        }
        looked_at += 1;
        let mut sources = Vec::new();
        files(&folder.join("src"), &mut sources);
        sources.retain(|(_, text)| text.contains("#[test]"));
        assert!(
            sources.is_empty(),
            "{name}: `test = false` leaves out the tests of {:?}",
            sources.iter().map(|(path, _)| path).collect::<Vec<_>>()
        );
    }
    assert!(looked_at > 3, "{looked_at}");
}

/// Why a test is left out of `cargo test`, and the words of the script that does it.
const LEFT_OUT: [(&str, &str, &str); 2] = [
    (
        "long: `.ci/run` does it, or --include-ignored",
        "run",
        "-- --ignored --skip by_night",
    ),
    (
        "by night: `.ci/nightly` does it",
        "nightly",
        "-- --include-ignored --nocapture",
    ),
];

#[test]
fn a_test_that_is_left_out_is_done_elsewhere() {
    let root = crate::root();
    let mut sources = Vec::new();
    for folder in ["crates", "tests"] {
        files(&root.join(folder), &mut sources);
    }
    let mut counts = [0; 2];
    for (file, text) in sources {
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        for (at, line) in lines.iter().enumerate() {
            let Some(reason) = line.strip_prefix("#[ignore = \"") else {
                continue;
            };
            let reason = reason.trim_end_matches("\"]");
            let known = LEFT_OUT.iter().position(|(why, ..)| *why == reason);
            let kind = known.unwrap_or_else(|| panic!("{}: {reason}", file.display()));
            counts[kind] += 1;
            let name = lines[at..].iter().find(|line| line.contains("fn "));
            let named = name.is_some_and(|line| line.starts_with("fn by_night_"));
            assert_eq!(named, kind == 1, "{}: {name:?}", file.display());
        }
    }
    for ((_, script, words), count) in LEFT_OUT.iter().zip(counts) {
        let text = std::fs::read_to_string(root.join(".ci").join(script)).expect("a script");
        assert!(count > 0 && text.contains(words), "{script}: {count}");
    }
}

/// A merge leaves lines twice, and nobody reads them twice.
/// A reader of two crates should not have to ask which one is meant.
#[test]
fn no_two_public_types_of_sister_crates_share_a_name() {
    // The trait of a control law, and the environment behind a safety chain: both are what their field calls so.
    const SHARED: [&str; 1] = ["Controller"];
    let mut owners = BTreeMap::<String, BTreeSet<String>>::new();
    for (name, folder) in super::crates() {
        let mut sources = Vec::new();
        files(&folder.join("src"), &mut sources);
        for (path, text) in sources {
            for line in product(&path, &text) {
                let ends = |letter: char| !letter.is_alphanumeric();
                let kinds = ["pub struct ", "pub enum ", "pub trait ", "pub type "];
                let kind = kinds.iter().find_map(|kind| line.strip_prefix(kind));
                let typed = kind.and_then(|rest| rest.split(ends).next());
                // The name of a macro's type is its argument.
                if let Some(typed) = typed.filter(|typed| !typed.is_empty()) {
                    let crates = owners.entry(typed.to_owned()).or_default();
                    crates.insert(name.clone());
                }
            }
        }
    }
    owners.retain(|typed, crates| crates.len() > 1 && !SHARED.contains(&typed.as_str()));
    assert!(owners.is_empty(), "{owners:?}");
}

#[test]
fn no_line_of_the_changelog_stands_twice() {
    let text = std::fs::read_to_string(crate::root().join("CHANGELOG.md")).expect("a changelog");
    let mut seen = BTreeSet::new();
    let mut changes = text
        .lines()
        .filter(|line| line.starts_with("- "))
        .peekable();
    assert!(changes.peek().is_some());
    let twice: Vec<&str> = changes.filter(|line| !seen.insert(*line)).collect();
    assert!(twice.is_empty(), "{twice:#?}");
}

/// A decision sends its reader to code that is there; one whose folders are gone gets a line "Now in …".
#[test]
fn the_folders_that_decisions_name_are_there() {
    let root = crate::root();
    let entries = std::fs::read_dir(root.join("docs/decisions")).expect("a folder");
    let mut named = 0;
    for entry in entries {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a text");
        for word in text.split('`').filter(|word| !word.contains(['\n', ' '])) {
            if word.starts_with("crates/") {
                named += 1;
                assert!(root.join(word).exists(), "{}: {word}", path.display());
            }
        }
    }
    assert!(named > 1, "{named}");
}

/// Pages besides the guide whose commands are copied into a shell.
const COPIED: [&str; 5] = [
    "README.md",
    "crates/host-cli/README.md",
    "firmware/README.md",
    "firmware/examples/rp2040/README.md",
    "python/README.md",
];

/// Reasons why a line of a block of shell is read otherwise somewhere, by the rules of the guide's page of commands.
fn differs(line: &str, ruled: &[char]) -> Vec<&'static str> {
    let mut found = Vec::new();
    if line.split_whitespace().any(|word| word.starts_with('#')) {
        found.push("zsh and cmd.exe know no comment at the prompt");
    }
    let ours = ["host-cli ", "cargo ", "pip ", "python "];
    if ours.iter().any(|program| line.starts_with(program)) {
        // Behind each second mark a text is quoted.
        for (at, part) in line.split('"').enumerate() {
            let plain = |c: char| c.is_alphanumeric() || " -_./:=%+@…".contains(c);
            let quoted = |c: char| plain(c) || "[](),^*<>".contains(c);
            let known = |c: char| plain(c) || ruled.contains(&c);
            if !part
                .chars()
                .all(|c| if at % 2 == 1 { quoted(c) } else { known(c) })
            {
                found.push(
                    "a mark is special in some shell: leave it out, or write \"…\" around its word",
                );
            }
        }
    }
    found
}

#[test]
fn a_command_that_is_copied_means_the_same_in_every_shell() {
    use testkit::book::{self, Markdown};
    // The marks for which the page has a rule of PowerShell.
    let rules = book::chapter("commands.md");
    let rows = rules.split("|---|---|\n").nth(1).expect("a table").lines();
    let rows = rows.take_while(|row| row.starts_with('|'));
    let ruled = |c: &char| !c.is_alphanumeric() && !" |`.".contains(*c);
    let ruled: Vec<char> = rows
        .flat_map(|row| {
            row.split('`')
                .nth(1)
                .expect("what the guide writes")
                .chars()
                .filter(ruled)
        })
        .collect();
    assert_eq!(ruled, ['>', ',']);
    let pages = COPIED.map(|page| {
        (
            page.to_owned(),
            std::fs::read_to_string(crate::root().join(page)).expect("a page"),
        )
    });
    let chapters = book::chapters().into_iter().filter(|file| !file.is_empty());
    let chapters = chapters.map(|file| (file.clone(), book::chapter(&file)));
    let mut found = Vec::new();
    for (page, text) in pages.into_iter().chain(chapters) {
        for block in Markdown::new(&text)
            .blocks
            .iter()
            .filter(|block| block.language == "sh")
        {
            for line in block.text.lines() {
                let why = differs(line, &ruled).into_iter();
                found.extend(why.map(|why| format!("{page}: {line}: {why}")));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    for line in [
        "relax # first",
        "host-cli relax \\",
        "host-cli x '1/s'",
        "host-cli x 1/(s+1)",
        "host-cli x \"$a\"",
    ] {
        assert!(!differs(line, &ruled).is_empty(), "{line}");
    }
}

/// Idioms in the comments of all product code. To be lowered, never raised.
const IDIOMS_MOST: usize = 10;

/// Lines of a file that are not tests: those before `#[cfg(test)] mod`, and none of a file of tests.
fn product<'a>(path: &Path, text: &'a str) -> Vec<&'a str> {
    let folders = ["tests", "benches"];
    let mut parts = path.iter().filter_map(|part| part.to_str());
    if path.to_string_lossy().ends_with("tests.rs") || parts.any(|part| folders.contains(&part)) {
        return Vec::new();
    }
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let begins = |pair: &[&str]| {
        pair[0].starts_with("#[cfg(test)]") && pair[1].contains("mod ") && pair[1].contains('{')
    };
    let end = lines.windows(2).position(begins).unwrap_or(lines.len());
    lines[..end].to_vec()
}

/// Numbers from 0 of the lines with a comment that says "is none" or "is told", or whose first line begins with a question word, "The same" or "So".
fn idioms(lines: &[&str]) -> Vec<usize> {
    const SAID: [&str; 8] = [
        "is none", "are none", "be none", "of none", "is told", "are told", "be told", "was told",
    ];
    const FIRST: [&str; 8] = [
        "The same", "What", "Whether", "How", "Where", "Which", "Who", "So",
    ];
    let is_letter = |letter: char| letter.is_alphanumeric() || letter == '_';
    let says = |line: &str, words: &str| {
        line.match_indices(words).any(|(at, _)| {
            let (before, behind) = (&line[..at], &line[at + words.len()..]);
            !before.ends_with(is_letter) && !behind.starts_with(is_letter)
        })
    };
    let begins = |comment: &str, words: &str| {
        let behind = comment.strip_prefix(words);
        behind.is_some_and(|behind| !behind.starts_with(is_letter))
    };
    let is_idiom = |&at: &usize| {
        let Some(comment) = lines[at].strip_prefix("//") else {
            return false;
        };
        let before = at.checked_sub(1).map_or("", |before| lines[before]);
        let is_first = !before.starts_with("//") || ["//", "///", "//!"].contains(&before);
        let comment = comment.strip_prefix(['/', '!']).unwrap_or(comment);
        let comment = comment.strip_prefix(' ').filter(|_| is_first);
        SAID.iter().any(|words| says(lines[at], words))
            || comment.is_some_and(|comment| FIRST.iter().any(|words| begins(comment, words)))
    };
    (0..lines.len()).filter(is_idiom).collect()
}

#[test]
fn an_idiom_is_found_in_the_first_line_of_a_comment_or_in_its_words() {
    let found = [
        "/// Whether it moves.",
        "//! What it is: a loop.",
        "// So the force falls.",
        "/// The length; it is none.",
        "// The user was told (twice).",
    ];
    for line in found {
        assert_eq!(idioms(&["fn f() {}", line]), [1], "{line}");
    }
    let others = [
        "/// True while it moves.",
        "/// Whoever moves it.",
        "/// `None`; this none knows.",
        "let what = \"is told\";",
    ];
    for line in others {
        assert_eq!(idioms(&["fn f() {}", line]), [0; 0], "{line}");
    }
    assert_eq!(idioms(&["/// A force.", "/// What is left."]), [0; 0]);
    assert_eq!(idioms(&["/// A force.", "///", "/// What is left."]), [2]);
}

#[test]
fn comments_name_the_thing_first() {
    let root = crate::root();
    let mut sources = Vec::new();
    for folder in ["crates", "src", "firmware", "python/rust", "examples"] {
        files(&root.join(folder), &mut sources);
    }
    let mut found = Vec::new();
    for (file, text) in &sources {
        let file = file.strip_prefix(root).expect("is below the root");
        let lines = product(file, text);
        let of_file = idioms(&lines).into_iter();
        found.extend(of_file.map(|at| format!("{}:{}: {}", file.display(), at + 1, lines[at])));
    }
    assert!(
        found.len() <= IDIOMS_MOST,
        "{} comments, of at most {IDIOMS_MOST}, begin with a question word, `The same` or `So`, or say `is none` or `is told`. CONTRIBUTING.md: \
         Name the thing first, write one idea per sentence, and put the verb early. Do not begin documentation with What, Whether, How, Where, \
         Which or Who.\n{}",
        found.len(),
        found.join("\n")
    );
}
