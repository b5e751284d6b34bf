//! The logs and answers of a folder: names, and what they say of themselves.

use haptic_experiment::{Failure, lines};
use haptic_log::record::{CLOCK, NEXT, NewFileError, VERDICT, first_file, leftover_at, skim};
use haptic_message::{END, RunEnd};
use haptic_quantity::short;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Logs up to this size are read to their end for the list; of larger ones only as much of the beginning. No sample is unpacked.
const WHOLE_BYTES: u64 = 32 << 20;
const BEGINNING_BYTES: u64 = 1 << 20;
/// Folders below the folder of runs that are looked into.
const DEPTH: u32 = 2;
/// Entries of a folder that are looked at.
const ENTRIES_MOST: usize = 10_000;

/// Size and time of a file, by which a change of it is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seen {
    bytes: u64,
    changed: Option<SystemTime>,
}

impl Seen {
    fn of(about: &fs::Metadata) -> Self {
        Self {
            bytes: about.len(),
            changed: about.modified().ok(),
        }
    }
}

/// A line of the list.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Listed {
    name: String,
    kind: Option<String>,
    started_utc: Option<String>,
    duration_s: Option<f64>,
    samples: Option<u64>,
    size_bytes: u64,
    verdict: Option<String>,
    running: bool,
}

/// Known logs, so that each is read only once.
#[derive(Debug, Default)]
pub(super) struct Listing {
    known: HashMap<PathBuf, (Seen, Listed)>,
}

impl Listing {
    pub(super) fn list(
        &mut self,
        folder: &Path,
        going: Option<&str>,
    ) -> Result<Vec<Listed>, Failure> {
        let logs = logs(folder)?;
        self.known
            .retain(|path, _| logs.values().any(|(known, _)| known == path));
        let mut list = Vec::new();
        for (name, (path, seen)) in logs {
            let known = self.known.get(&path).filter(|(then, _)| *then == seen);
            let mut listed = match known {
                // Nothing says when a writer has died.
                Some((_, listed)) if !listed.running => listed.clone(),
                _ => {
                    let listed = listed(&name, &path, seen);
                    self.known.insert(path, (seen, listed.clone()));
                    listed
                }
            };
            listed.running |= going == Some(name.as_str());
            list.push((seen.changed, listed));
        }
        list.sort_by(|(a, one), (b, other)| b.cmp(a).then_with(|| one.name.cmp(&other.name)));
        Ok(list.into_iter().map(|(_, listed)| listed).collect())
    }

    /// The log of a name.
    pub(super) fn find(&self, folder: &Path, name: &str) -> Result<(PathBuf, Seen), Failure> {
        logs(folder)?.remove(name).ok_or_else(|| {
            Failure::bad_input(format_args!(
                "there is no log {:?} in {}, deleted or moved: list the runs again",
                short(name),
                folder.display()
            ))
        })
    }
}

/// All logs of a folder by name.
fn logs(folder: &Path) -> Result<BTreeMap<String, (PathBuf, Seen)>, Failure> {
    let mut found = BTreeMap::new();
    if folder.exists() {
        look(folder, "", DEPTH, &mut found).map_err(|error| {
            Failure::bad_input(format_args!(
                "cannot read the folder {}: {error}",
                folder.display()
            ))
        })?;
    }
    Ok(found)
}

fn look(
    folder: &Path,
    prefix: &str,
    depth: u32,
    found: &mut BTreeMap<String, (PathBuf, Seen)>,
) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)?.take(ENTRIES_MOST) {
        let entry = entry?;
        let (path, file) = (entry.path(), entry.file_name());
        // A name that is no text cannot be asked for.
        let Some(file) = file.to_str() else { continue };
        // Followed links would lead out of the folder.
        let Ok(about) = entry.metadata() else {
            continue;
        };
        if about.is_dir() {
            if depth > 0 {
                // A folder that may not be read holds nothing for us.
                let _ = look(&path, &format!("{prefix}{file}/"), depth - 1, found);
            }
        } else if about.is_file() {
            let log = file.strip_suffix(".mcap").or_else(|| {
                let stem = file.strip_suffix(UNFINISHED)?;
                (!folder.join(format!("{stem}.mcap")).exists()).then_some(stem)
            });
            let goes_on = |stem: &&str| {
                let first = first_file(&folder.join(format!("{stem}.mcap")));
                first.is_some_and(|first| first.exists())
            };
            let log = log.filter(|stem| !goes_on(stem));
            if let Some(stem) = log.or_else(|| file.strip_suffix(SUFFIX)) {
                found.insert(format!("{prefix}{stem}"), (path, Seen::of(&about)));
            }
        }
    }
    Ok(())
}

/// Behind the name of a log that is not finished.
const UNFINISHED: &str = ".mcap.part";

/// True of a log that some program writes just now, this one or a command beside it.
pub(super) fn is_being_written(path: &Path) -> bool {
    let unfinished = path.to_str().is_some_and(|path| path.ends_with(UNFINISHED));
    unfinished && matches!(leftover_at(path), NewFileError::BeingWritten(_))
}

/// Entry of a log by its contents; a log that cannot be read has the error in it.
fn listed(name: &str, path: &Path, seen: Seen) -> Listed {
    let mut listed = Listed {
        name: name.to_owned(),
        size_bytes: seen.bytes,
        running: is_being_written(path),
        ..Listed::default()
    };
    let summary = if is_answer(path) {
        listed.answer(path)
    } else {
        listed.log(path)
    };
    if let Err(error) = summary {
        listed.verdict = Some(format!("cannot be read: {error}"));
    }
    listed
}

impl Listed {
    fn answer(&mut self, path: &Path) -> Result<(), Failure> {
        let answer = read_answer(path)?;
        let text = |key: &str| answer[key].as_str().map(str::to_owned);
        self.kind = text("kind");
        self.verdict = text("verdict");
        Ok(())
    }

    fn log(&mut self, path: &Path) -> Result<(), Failure> {
        let is_whole = self.size_bytes <= WHOLE_BYTES;
        let most_bytes = if is_whole {
            WHOLE_BYTES
        } else {
            BEGINNING_BYTES
        };
        let skimmed = skim(path, most_bytes)?;
        let record = |name| skimmed.metadata.iter().find(|record| record.name == name);
        let text = |name, key| Some(record(name)?.values.get(key)?.clone());
        self.kind = text("experiment", "experiment");
        self.started_utc = text(CLOCK, "started_utc");
        let planned = || text("experiment", "duration_s")?.parse().ok();
        // Of one file, and not of a part of it or of the first of several.
        let is_all = is_whole && record(NEXT).is_none();
        self.samples = skimmed.samples.filter(|_| is_all);
        self.duration_s = skimmed.duration_s.filter(|_| is_all).or_else(planned);
        self.verdict = text(VERDICT, VERDICT);
        let end = record(END).and_then(RunEnd::of);
        if is_whole && !skimmed.complete && !self.running {
            self.verdict = Some("cut off or damaged".to_owned());
        } else if let Some(end) = end.filter(|end| !end.reason.is_empty()) {
            self.verdict = Some(end.reason);
        }
        Ok(())
    }
}

pub(super) const ANSWER: &str = "answer.json";
/// End like [`ANSWER`], behind the name of an answer.
const SUFFIX: &str = ".answer.json";
/// Longest file that is read, bytes: some thousand points are a megabyte.
const ANSWER_MOST: u64 = 64 << 20;

/// True for the file of an answer.
pub(super) fn is_answer(path: &Path) -> bool {
    path.to_str().is_some_and(|path| path.ends_with(SUFFIX))
}

/// Reads an answer: `kind`, `verdict`, `report`, its `lines`, `experiment`.
pub(super) fn read_answer(path: &Path) -> Result<Value, Failure> {
    let none = |why: &dyn std::fmt::Display| {
        Failure::bad_input(format_args!(
            "{} is not an answer: {why}; ask again",
            path.display()
        ))
    };
    let length = fs::metadata(path).map_err(|error| none(&error))?.len();
    if length > ANSWER_MOST {
        return Err(none(&format_args!("it is {length} bytes long")));
    }
    let text = fs::read(path).map_err(|error| none(&error))?;
    let mut answer: Value = serde_json::from_slice(&text).map_err(|error| none(&error))?;
    if answer["kind"].is_string() && answer["report"].is_object() {
        answer["lines"] = json!(lines(&answer["report"]));
        Ok(answer)
    } else {
        Err(none(&"it has no `kind` and `report`"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_log::record::LogWriter;
    use haptic_message::TickMessage;

    fn log(path: &Path) {
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        let mut log = LogWriter::create(path).expect("made");
        let values = [("experiment".to_owned(), "relax".to_owned())];
        log.metadata("experiment", values.into()).expect("written");
        for tick in 0..5 {
            let time_s = tick as f64 * 1e-3;
            let message = TickMessage {
                tick,
                time_s,
                ..TickMessage::at_rest(1)
            };
            log.tick(&message).expect("written");
        }
        log.finish().expect("finished");
    }

    #[test]
    fn only_logs_have_names_and_no_name_leads_out_of_the_folder() {
        let place = tempfile::tempdir().expect("a folder");
        let runs = place.path().join("runs");
        log(&runs.join("relax-0001/relax.mcap"));
        log(&runs.join("single.mcap"));
        log(&runs.join("single-0002.mcap"));
        log(&place.path().join("secret.mcap"));
        fs::write(runs.join("notes.txt"), "no log").expect("written");
        fs::write(runs.join("broken.mcap"), "no log either").expect("written");
        let mut listing = Listing::default();
        let list = listing.list(&runs, Some("single")).expect("read");
        let mut names: Vec<&str> = list.iter().map(|listed| listed.name.as_str()).collect();
        names.sort_unstable();
        assert_eq!(names, ["broken", "relax-0001/relax", "single"]);
        let mut all = list.iter();
        let mut listed_as = |name: &str| all.find(|listed| listed.name == name).expect("there");
        let relax = listed_as("relax-0001/relax");
        assert_eq!(
            (relax.kind.as_deref(), relax.samples),
            (Some("relax"), Some(5))
        );
        let running = list.iter().filter(|listed| listed.running);
        let running: Vec<&str> = running.map(|listed| listed.name.as_str()).collect();
        assert_eq!(running, ["single"]);
        let ends = (relax.duration_s, relax.verdict.as_deref());
        assert_eq!(ends, (Some(0.004), None));
        let broken = list
            .iter()
            .find(|listed| listed.name == "broken")
            .expect("there");
        let broken = broken.verdict.as_deref().unwrap_or_default();
        assert!(broken.starts_with("cannot be read"), "{broken}");
        let outside = "../secret .. /etc/passwd relax-0001/../../secret single-0002";
        for outside in outside.split(' ').chain([""]) {
            let error = listing.find(&runs, outside).expect_err(outside);
            assert!(error.to_string().contains("list the runs again"), "{error}");
        }
        assert!(listing.find(&runs, "single").is_ok());
        let none = Listing::default().list(&place.path().join("none"), None);
        assert!(none.expect("empty").is_empty());
    }
}
