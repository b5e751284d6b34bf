//! The guide holds together: its summary lists each page, every link and anchor of every document leads somewhere, and every
//! document that a source file names is there. The commands on its pages are run by the tests of `host-cli`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use testkit::book::{self, Markdown};

/// Folders that hold nothing of ours.
const FOREIGN: &[&str] = &[".git", "target", "node_modules", "results", "corpus"];
/// Kinds of files that name documents.
const SPEAKING: &[&str] = &[
    "md", "rs", "py", "pyi", "toml", "ts", "mjs", "sh", "yml", "run", "nightly", "build",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files of ours below a folder, links into other folders left out.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let kind = entry.file_type().expect("a kind");
        let foreign = FOREIGN.contains(&&*entry.file_name().to_string_lossy());
        if kind.is_dir() && !foreign {
            files(&entry.path(), found);
        } else if kind.is_file() {
            found.push(entry.path());
        }
    }
}

fn all_files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    files(root(), &mut found);
    found
}

/// The name of a path from the root on.
fn name(path: &Path) -> String {
    let path = path.strip_prefix(root()).unwrap_or(path);
    path.display().to_string()
}

/// Where the project says that it is, as in links to its files from elsewhere.
fn repository() -> String {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).expect("a manifest");
    let manifest: toml::Table = toml::from_str(&manifest).expect("is TOML");
    let repository = manifest["workspace"]["package"]["repository"].as_str();
    repository.expect("a text").to_owned()
}

/// Anchors of the documents, each read once.
#[derive(Default)]
struct Anchors(BTreeMap<PathBuf, BTreeSet<String>>);

impl Anchors {
    fn of(&mut self, path: &Path) -> &BTreeSet<String> {
        self.0.entry(path.to_owned()).or_insert_with(|| {
            let text = std::fs::read_to_string(path).expect("a document");
            Markdown::new(&text).anchors.into_iter().collect()
        })
    }

    /// Why a link of a document leads nowhere, if so.
    fn complaint(&mut self, document: &Path, target: &str, repository: &str) -> Option<String> {
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        let in_repository = ["blob", "tree"]
            .iter()
            .find_map(|kind| path.strip_prefix(&format!("{repository}/{kind}/main/")));
        let path = match in_repository {
            Some(path) => root().join(path),
            None if path.contains("://") => return None,
            None if path.is_empty() => document.to_owned(),
            None => document.parent()?.join(path),
        };
        let Ok(path) = path.canonicalize() else {
            return Some("no such file".to_owned());
        };
        let in_guide = |path: &Path| {
            let [path, guide] = [path, &book::folder()].map(|path| path.canonicalize().ok());
            path.zip(guide)
                .is_some_and(|(path, guide)| path.starts_with(guide))
        };
        if in_repository.is_none() && in_guide(document) && !in_guide(&path) {
            return Some(format!(
                "leaves the book, which is built without that file: write {repository}/blob/main/…"
            ));
        }
        let is_document = path.extension().is_some_and(|kind| kind == "md");
        (is_document && !anchor.is_empty() && !self.of(&path).contains(anchor))
            .then(|| format!("no heading of that name in {}", name(&path)))
    }
}

/// Names of the guide's files.
fn in_folder() -> BTreeSet<String> {
    let entries = std::fs::read_dir(book::folder()).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    names
        .map(|name| name.to_string_lossy().into_owned())
        .collect()
}

#[test]
fn the_summary_lists_every_page_once_and_each_has_one_title() {
    let chapters = book::chapters();
    let mut files = in_folder();
    files.retain(|file| file.ends_with(".md") && file != "SUMMARY.md");
    let listed: Vec<&String> = chapters.iter().filter(|file| !file.is_empty()).collect();
    let once: BTreeSet<String> = listed.iter().map(|file| (*file).clone()).collect();
    assert_eq!(listed.len(), once.len(), "twice: {listed:?}");
    assert_eq!(once, files, "left the summary, right the folder");
    for file in listed {
        let titles = Markdown::new(&book::chapter(file)).titles;
        assert_eq!(titles.len(), 1, "{file}: {titles:?}");
    }
}

#[test]
fn every_link_of_every_document_leads_somewhere() {
    let repository = repository();
    let mut anchors = Anchors::default();
    let mut wrong = Vec::new();
    let mut links = 0;
    for document in all_files() {
        if document.extension().is_none_or(|kind| kind != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&document).expect("a document");
        for link in Markdown::new(&text).links {
            links += 1;
            // A chapter that is announced.
            if link.target.is_empty() {
                continue;
            }
            if let Some(why) = anchors.complaint(&document, &link.target, &repository) {
                wrong.push(format!(
                    "{}:{}: {}: {why}",
                    name(&document),
                    link.line,
                    link.target
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(links > 150, "{links}");
}

#[test]
fn every_document_that_a_file_names_is_there() {
    let mut wrong = Vec::new();
    let mut named = 0;
    for file in all_files() {
        let kind = file.extension().or(file.file_name()).unwrap_or_default();
        if !SPEAKING.iter().any(|known| kind == *known) {
            continue;
        }
        let text = std::fs::read_to_string(&file).expect("a text");
        for (start, _) in text.match_indices("docs/") {
            // Part of a longer name.
            let before = text[..start].chars().next_back().unwrap_or(' ');
            if before.is_alphanumeric() || matches!(before, '-' | '_' | '.') {
                continue;
            }
            let end = |c: char| !(c.is_ascii_alphanumeric() || matches!(c, '/' | '-' | '_' | '.'));
            let path = text[start..].split(end).next().unwrap_or_default();
            let path = path.trim_end_matches('.');
            if !path.ends_with(".md") {
                continue;
            }
            named += 1;
            if !root().join(path).exists() {
                let line = 1 + text[..start].matches('\n').count();
                wrong.push(format!("{}:{line}: {path}", name(&file)));
            }
        }
    }
    assert!(wrong.is_empty(), "not there:\n{}", wrong.join("\n"));
    assert!(named > 40, "{named}");
}

#[test]
fn every_picture_of_the_guide_is_shown() {
    let chapters = book::chapters().into_iter().filter(|file| !file.is_empty());
    let shown: BTreeSet<String> = chapters
        .flat_map(|file| Markdown::new(&book::chapter(&file)).links)
        .map(|link| link.target)
        .collect();
    for file in in_folder() {
        let is_picture = file.ends_with(".png") || file.ends_with(".svg");
        assert!(!is_picture || shown.contains(&file), "{file} is on no page");
    }
}

#[test]
fn a_device_is_wired_to_the_pins_that_its_firmware_takes() {
    let numbers = |text: &str, before: &str| -> BTreeSet<u32> {
        let ends = text.split(before).skip(1);
        let digits = ends.map(|end| end.split(|c: char| !c.is_ascii_digit()).next());
        digits.filter_map(|number| number?.parse().ok()).collect()
    };
    let program = include_str!("../../firmware/examples/rp2040/src/main.rs");
    // A line behind a feature is of a device with a load cell, which the picture leaves out.
    let mut parts = program.split("#[cfg(feature = \"force-sensor\")]");
    let first = parts.next().into_iter();
    let always = first.chain(parts.filter_map(|part| Some(part.trim_start().split_once('\n')?.1)));
    let always = numbers(&always.collect::<String>(), "chip.PIN_");
    let all = numbers(program, "chip.PIN_");
    assert_eq!([always.len(), all.len()], [5, 6]);
    let readme = include_str!("../../firmware/examples/rp2040/README.md");
    let picture = include_str!("../../docs/guide/src/wiring.svg");
    let page = include_str!("../../docs/guide/src/build-a-device.md");
    for (page, taken) in [(readme, &all), (picture, &always), (page, &always)] {
        assert_eq!(numbers(page, "GP"), *taken);
    }
}
