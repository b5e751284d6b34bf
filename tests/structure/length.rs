//! Files and functions that have grown too long to be read at a glance.

use std::path::{Path, PathBuf};

/// Most lines of a file of sources.
const FILE_LINES: usize = 400;
/// Most lines of a function, its signature included. Tests are free: a table of refusals is as long as it is.
const FUNCTION_LINES: usize = 60;
/// Most of each that the house bears, each with one subject.
const LONG_FILES: usize = 8;
const LONG_FUNCTIONS: usize = 5;

/// Folders of sources, beside those of the crates.
const FOLDERS: &[&str] = &[
    "firmware/boards/src",
    "firmware/examples/rp2040/src",
    "firmware/src",
    "firmware/template/src",
    "fuzz/src",
    "page/wasm/src",
    "python/rust",
];

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

/// Name, line and length of each function of a text, those with `#[test]` left out. The text is formatted: a function ends with
/// the first brace that closes at the depth of its first word.
fn functions(text: &str) -> Vec<(String, usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let depth = |line: &str| line.len() - line.trim_start().len();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let Some(name) = name_of_function(line) else {
            continue;
        };
        let above = lines[..at].iter().rev();
        let mut attributes = above.take_while(|line| line.trim_start().starts_with(['#', '/']));
        if attributes.any(|line| line.trim() == "#[test]") {
            continue;
        }
        let rest = lines[at..].iter();
        let end = rest.skip_while(|line| !line.ends_with(['{', '}', ';']));
        if end.clone().next().is_some_and(|line| line.ends_with('{')) {
            let last = lines[at..].iter().position(|other| {
                depth(other) == depth(line) && other.trim_start().starts_with('}')
            });
            found.push((name.to_owned(), at + 1, last.expect("it ends") + 1));
        }
    }
    found
}

/// The name, if a function begins in this line.
fn name_of_function(line: &str) -> Option<&str> {
    let (before, after) = line.trim_start().split_once("fn ")?;
    let known = |word| {
        let visible = ["pub", "pub(crate)", "pub(super)"].contains(&word);
        visible || ["const", "async", "extern", "\"C\""].contains(&word)
    };
    let is_one = before.split_whitespace().all(known);
    let name = after.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
    name.into_iter()
        .next()
        .filter(|name| is_one && !name.is_empty())
}

#[test]
fn files_and_functions_are_read_at_a_glance() {
    let mut all = Vec::new();
    for (_, folder) in super::crates() {
        files(&folder.join("src"), &mut all);
    }
    for folder in FOLDERS {
        files(&super::root().join(folder), &mut all);
    }
    assert!(all.len() > 500, "{} files", all.len());
    let (mut long_files, mut long_functions) = (Vec::new(), Vec::new());
    for path in all {
        let text = std::fs::read_to_string(&path).expect("is text");
        let name = path.strip_prefix(super::root()).expect("is ours").display();
        let lines = text.lines().count();
        if lines > FILE_LINES {
            long_files.push(format!("{name}: {lines} lines"));
        }
        let long = functions(&text).into_iter();
        for (function, line, lines) in long.filter(|found| found.2 > FUNCTION_LINES) {
            long_functions.push(format!("{name}:{line}: {function}, {lines} lines"));
        }
    }
    println!("{long_files:#?} {long_functions:#?}");
    assert!(long_files.len() <= LONG_FILES, "split: {long_files:#?}");
    assert!(
        long_functions.len() <= LONG_FUNCTIONS,
        "split: {long_functions:#?}"
    );
}

#[test]
fn a_function_is_counted_from_its_first_word_to_its_brace() {
    let text = "impl A {\n    /// One.\n    pub(crate) const fn one(\n        x: f64,\n    ) -> f64 {\n        if x {\n            y\n        }\n    }\n\
                \n    fn two(&self);\n}\n\n#[test]\nfn three() {\n}\n\nfn four() {}\n\nlet defn = 1;\nasync fn five() {\n}\n";
    let found = functions(text);
    let found: Vec<_> = found
        .iter()
        .map(|(name, at, lines)| (name.as_str(), *at, *lines))
        .collect();
    assert_eq!(found, [("one", 3, 7), ("five", 21, 2)]);
}
