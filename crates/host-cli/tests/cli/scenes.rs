//! Scenes: commands as they are typed, and what is true behind each. A scene begins at a line that is not indented, its title, in an empty
//! folder.
//!
//! | line | done with it |
//! |---|---|
//! | `#` | a remark |
//! | `@ linux` | the scene is played on Linux alone |
//! | `@ examples` | the folder has the `experiments` and a record |
//! | `@ page FILE` | the folder has this page of the guide |
//! | `@ others` | the folder has the logs that `others/make_logs.py` made by the public packages |
//! | `@ device OPTIONS` | an emulated device is at `serial:device`, and what is in the folder, `HERE`, too; `@ loosened` takes its limits away |
//! | `+ FILE`, and `\| TEXT` below it | a file of these lines; `+ FOLDER/` is a folder |
//! | `$ LINE` | `host-cli LINE` ends with exit code 0, and says nothing on standard error |
//! | `~ LINE` | exit code 0, and perhaps warnings |
//! | `1 LINE`, and 2, 3, 4 | that exit code, and one line `error: …` at the end |
//! | `! LINE => WORDS` | exit code 2, nothing on standard output, these words in the error, between ` \| `; behind ` ! ` those that it must not have |
//! | `sh SCRIPT` | of the shell, where `$0` is `host-cli`; exit code 0 |
//! | `out WORDS`, `err WORDS` | standard output or error has them; `no-out`, `no-err`: has none of them |
//! | `/PLACE = JSON` | value in the report; `<`, `>`, `has WORDS`, `has-not`, `keys NAMES`, `length N`; `~ NUMBER SHARE`, `+- NUMBER ERROR`. A number may be `0.1*FILE/PLACE` |
//! | `in FILE WORDS`, `not-in FILE WORDS` | words of a file |
//! | `lines FILE N`, `same FILE FILE` | its lines, its bytes; `keep FILE` makes one of standard output |
//! | `files NAMES`, `not-there FILE` | all that is in the folder |
//!
//! Words that are separate stand between ` & `. `SCENE=WORDS` plays the scenes alone whose titles have these words.

use crate::emulated::Emulated;
use crate::process::{Ended, Place, keys};
use serde_json::Value;

/// Texts, each with a test.
macro_rules! scenes {
    ($($(#[$attribute:meta])* $name:ident)*) => {
        $(#[test]
        $(#[$attribute])*
        fn $name() {
            play(include_str!(concat!("scenes/", stringify!($name), ".txt")));
        })*
    };
}

scenes! {
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    clock
    control
    devices
    experiments
    #[ignore = "long: `.ci/run` does it, or --include-ignored"]
    long
    logs
    refusals
    tables
    tissues
    unwritten
    walls
}

enum Stage {
    Empty(Place),
    Device(Emulated),
}

impl Stage {
    const fn place(&self) -> &Place {
        match self {
            Self::Empty(place) => place,
            Self::Device(device) => &device.place,
        }
    }
}

/// A scene that is played: where, and how its last command ended.
struct Played {
    stage: Stage,
    ended: Option<Ended>,
}

/// Plays all scenes of a text, and shows all complaints at once.
fn play(text: &str) {
    let wanted = std::env::var("SCENE").unwrap_or_default();
    let mut complaints = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    for scene in lines.chunk_by(|_, next| next.starts_with("  ") || next.is_empty()) {
        let [title, scene @ ..] = scene else { continue };
        let here = cfg!(target_os = "linux") || !scene.contains(&"  @ linux");
        if here && title.contains(&wanted) {
            let scene: Vec<&str> = scene.iter().map(|line| line.trim()).collect();
            let found = Played::new().scene(&scene);
            complaints.extend(found.iter().map(|one| format!("{title}: {one}")));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// The words that a text lacks.
fn lacks(text: &str, words: &str) -> Result<(), String> {
    match words.split(" & ").find(|words| !text.contains(words)) {
        Some(words) => Err(format!("\"{words}\" is missing")),
        None => Ok(()),
    }
}

/// The words that a text has and should not.
fn has(text: &str, words: &str) -> Result<(), String> {
    match words.split(" & ").find(|words| text.contains(words)) {
        Some(words) => Err(format!("\"{words}\" is there")),
        None => Ok(()),
    }
}

fn if_not<T>(holds: bool, instead: T) -> Result<(), T> {
    if holds { Ok(()) } else { Err(instead) }
}

/// A number, or so many times that of a report which was kept: `0.1*FILE/PLACE`.
fn number(place: &Place, word: &str) -> f64 {
    let Some((factor, (file, pointer))) = word
        .split_once('*')
        .and_then(|(factor, at)| Some((factor, at.split_once('/')?)))
    else {
        return word.parse().expect(word);
    };
    let report: Value = serde_json::from_str(&place.text(file)).expect("JSON");
    let value = report.pointer(&format!("/{pointer}"));
    number(place, factor) * value.and_then(Value::as_f64).expect(word)
}

/// Holds a value of a report against what is wanted of it.
fn judged(place: &Place, have: &Value, wanted: &str) -> Result<(), String> {
    let (how, wanted) = wanted.split_once(' ').expect("how, and what");
    let value = have.as_f64().unwrap_or(f64::NAN);
    let mut words = wanted.split(' ');
    let mut next = || number(place, words.next().expect("a number"));
    let holds = match how {
        "=" => {
            let wanted: Value = serde_json::from_str(wanted).expect(wanted);
            *have == wanted || Some(value) == wanted.as_f64()
        }
        "<" => value < next(),
        ">" => value > next(),
        "~" => (value / next() - 1.0).abs() <= next(),
        "+-" => (value - next()).abs() <= next(),
        "length" => have.as_array().map(Vec::len) == wanted.parse().ok(),
        "keys" => keys(have) == wanted,
        "has" => return lacks(&have.to_string(), wanted),
        // Of what is not there, nobody knows.
        "has-not" if !have.is_null() => return has(&have.to_string(), wanted),
        _ => panic!("no {how}"),
    };
    if_not(holds, format!("it is {have:.300}"))
}

impl Played {
    fn new() -> Self {
        Self {
            stage: Stage::Empty(Place::new()),
            ended: None,
        }
    }

    /// Plays it; what is to complain of.
    fn scene(&mut self, lines: &[&str]) -> Vec<String> {
        let mut complaints = Vec::new();
        for (at, line) in lines.iter().enumerate() {
            let (verb, rest) = line.split_once(' ').unwrap_or((line, ""));
            if let Err(complaint) = self.line(verb, rest, &lines[at + 1..]) {
                let ended = self.ended.as_ref().map(Ended::to_string);
                let ended = ended.unwrap_or_default();
                complaints.push(format!("{line}: {complaint} {ended}"));
            }
        }
        complaints
    }

    /// Does what a line says; `below` are the lines after it.
    fn line(&mut self, verb: &str, rest: &str, below: &[&str]) -> Result<(), String> {
        let place = self.stage.place();
        let ended = || self.ended.as_ref().expect("a command before");
        let (file, words) = rest.split_once(' ').unwrap_or((rest, ""));
        match verb {
            "" | "|" | "#" => {}
            "@" => self.prepare(file, words),
            "+" if rest.ends_with('/') => {
                std::fs::create_dir_all(place.path(rest)).expect("a folder");
            }
            "+" => {
                let text = below.iter().map_while(|line| line.strip_prefix('|'));
                let text =
                    text.map(|line| line.strip_prefix(' ').unwrap_or(line).to_owned() + "\n");
                place.write(rest, text.collect::<String>());
            }
            "$" | "~" | "1" | "2" | "3" | "4" => {
                let mut report = below.iter().take_while(|line| {
                    !"$~1234!@".contains(&line[..line.len().min(1)]) || line.is_empty()
                });
                let json = if report.any(|line| line.starts_with('/')) {
                    " --json"
                } else {
                    ""
                };
                let ended = place.run(&format!("{rest}{json}"));
                let complaint = match verb {
                    "$" | "~" => ended.fault_in_success(verb == "$"),
                    _ => ended.fault_in_failure(verb.parse().expect("a code")),
                };
                self.ended = Some(ended);
                return complaint.map_or(Ok(()), Err);
            }
            "!" => {
                let (line, words) = rest.split_once("=> ").expect("a refusal");
                let (words, wrong) = words.split_once(" ! ").unwrap_or((words, "\n\n"));
                let words: Vec<&str> = words.split(" | ").collect();
                let ended = place.run(line);
                self.ended = None;
                let complaint = ended.complaint(2, &words).map_or(Ok(()), Err);
                return complaint.and_then(|()| has(&ended.stderr, wrong));
            }
            "sh" => {
                let ended = place.shell(rest);
                let complaint = ended.fault_in_success(true);
                self.ended = Some(ended);
                return complaint.map_or(Ok(()), Err);
            }
            "out" => return lacks(&ended().stdout, rest),
            "err" => return lacks(&ended().stderr, rest),
            "no-out" => return has(&ended().stdout, rest),
            "no-err" => return has(&ended().stderr, rest),
            "in" => return lacks(&place.text(file), words),
            "not-in" => return has(&place.text(file), words),
            "lines" => {
                let count = place.text(file).lines().count();
                return if_not(count.to_string() == words, format!("it has {count}"));
            }
            "same" => {
                return if_not(
                    place.read(file) == place.read(words),
                    "they differ".to_owned(),
                );
            }
            "not-there" => return if_not(!place.path(rest).exists(), "it is there".to_owned()),
            "keep" => place.write(file, &ended().stdout),
            "files" => return if_not(place.listing() == rest, place.listing()),
            pointer if pointer.starts_with('/') => {
                let json: Value =
                    serde_json::from_str(&ended().stdout).map_err(|error| error.to_string())?;
                let value = json
                    .pointer(pointer.trim_end_matches('/'))
                    .unwrap_or(&Value::Null);
                return judged(place, value, rest);
            }
            _ => panic!("no {verb}"),
        }
        Ok(())
    }

    fn prepare(&mut self, what: &str, options: &str) {
        match (what, &self.stage) {
            ("linux", _) => {}
            ("examples", _) => self.stage = Stage::Empty(Place::with_examples()),
            ("device", stage) => {
                let here = stage.place().path("");
                let device = Emulated::new(&options.replace("HERE", &here.to_string_lossy()));
                for file in stage.place().files() {
                    std::fs::copy(here.join(&file), device.place.path(&file)).expect("copies");
                }
                self.stage = Stage::Device(device);
            }
            ("others", _) => {
                let logs = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/others");
                self.stage.place().shell(&format!("cp {logs}/*.mcap ."));
            }
            ("page", stage) => stage
                .place()
                .write(options, testkit::book::chapter(options)),
            ("loosened", Stage::Device(device)) => device.loosen(),
            _ => panic!("no {what}"),
        }
    }
}
