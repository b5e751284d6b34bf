//! Files that fall on the page: what a TOML file is, tissues that are kept in the folder of the runs, and logs that are laid there.
//! ```text
//! NAME.toml ─▶ an experiment or question, a plant, a controller, a tissue          NAME.mcap ─▶ dropped/NAME.mcap
//! tissue    ─▶ tissues/NAME.toml, and the library that is felt
//! ```
//! Nothing is overwritten.

use crate::TextFile;
use crate::runs::of_file;
use haptic_experiment::document::Document;
use haptic_experiment::run::write_text;
use haptic_experiment::{Failure, ModelledTissue, TissuePiece};
use haptic_log::record::{Leftover, LogFiles, NewFile};
use haptic_tissue::{Library, Material};
use serde_json::{Value, json};
use std::fs::{File, create_dir_all};
use std::path::{Path, PathBuf};

/// Folder of tissues in that of the runs.
const TISSUES: &str = "tissues";
/// Folder of logs that were dropped.
const LOGS: &str = "dropped";
/// Tables of a controller file; that of a function is a plant unless a loop is beside it.
const CONTROLLERS: [&str; 5] = ["pid", "tid", "crone", "lead_lag", "loop"];
const PLANTS: [&str; 4] = [
    "transfer_function",
    "device",
    "state_space",
    "measured_response",
];

/// What a TOML file is: its kind, and of an experiment the form that it fills.
pub(crate) fn looked_at(file: &TextFile) -> Result<Value, Failure> {
    let path = Path::new(&file.name);
    let table: toml::Table = toml::from_str(&file.text).map_err(|error| {
        let why = error.message();
        Failure::bad_input(format_args!("{}: not TOML: {why}", file.name))
    })?;
    let has = |names: &[&str]| names.iter().any(|name| table.contains_key(*name));
    if has(&CONTROLLERS) {
        return Ok(json!({"is": "controller"}));
    }
    if has(&PLANTS) {
        return Ok(json!({"is": "plant"}));
    }
    if has(&["parameters"]) {
        let tissue = Material::parse(path, &file.text).map_err(Failure::input)?;
        return Ok(json!({"is": "tissue", "name": tissue.name}));
    }
    let document = Document::of_text(path, &file.text);
    document.kind().map_err(|error| {
        Failure::from(error).and("nor a tissue, plant or controller file: drop one of these")
    })?;
    Ok(json!({"is": "experiment", "experiment": of_file(&file.text)}))
}

/// The library, with the tissues that were kept in this folder of runs.
pub(crate) fn with_kept(mut library: Library, runs: &Path) -> Library {
    // What cannot be read is no tissue of the page; the folder is there for people too.
    let _ = library.add_folder(&runs.join(TISSUES));
    library
}

/// Keeps a tissue under a name of its own, in the folder and in the library; where it is.
pub(crate) fn keep_tissue(
    library: &mut Library,
    runs: &Path,
    name: &str,
    text: &str,
) -> Result<PathBuf, Failure> {
    let mut tissue = Material::parse(Path::new("the tissue"), text).map_err(Failure::input)?;
    name.clone_into(&mut tissue.name);
    let folder = runs.join(TISSUES);
    let path = folder.join(format!("{name}.toml"));
    let text = tissue.to_toml();
    let tissue = Material::parse(&path, &text).map_err(Failure::input)?;
    // Whoever asks for the library gets it as something to be felt.
    let felt = ModelledTissue::new(tissue.clone())?;
    TissuePiece::usual(felt).map_err(Failure::input)?;
    let mut with = library.clone();
    with.add(&path, tissue).map_err(Failure::input)?;
    make(&folder)?;
    write_text(&path, &text, false)?;
    *library = with;
    Ok(path)
}

/// A log that is being laid into the folder of the runs.
#[derive(Debug)]
pub(crate) struct DroppedLog {
    new: NewFile,
    /// As the list of runs has it.
    name: String,
    pub(crate) file: File,
}

impl DroppedLog {
    /// Begins one; `None` for a name that is not of letters, digits, `-`, `_` and `.`, with `.mcap` at its end.
    pub(crate) fn begin(runs: &Path, name: &str) -> Result<Option<Self>, Failure> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        let stem = name.strip_suffix(".mcap").filter(|stem| !stem.is_empty());
        let Some(stem) = stem.filter(|stem| stem.chars().all(plain) && !stem.starts_with('.'))
        else {
            return Ok(None);
        };
        let folder = runs.join(LOGS);
        make(&folder)?;
        let (new, file) = NewFile::create(&folder.join(name), Leftover::Discard, false)?;
        Ok(Some(Self {
            new,
            name: format!("{LOGS}/{stem}"),
            file,
        }))
    }

    /// Gives it its name, if it is a log: the name by which the page opens it.
    pub(crate) fn end(self) -> Result<String, Failure> {
        LogFiles::open(self.new.part())
            .map_err(|_| Failure::bad_input(format_args!("{} is not an MCAP log", self.name)))?;
        self.new.publish()?;
        Ok(self.name)
    }
}

fn make(folder: &Path) -> Result<(), Failure> {
    create_dir_all(folder).map_err(|error| {
        let folder = folder.display();
        Failure::bad_input(format_args!("cannot make the folder {folder}: {error}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is(text: &str) -> Result<String, String> {
        let (name, text) = ("x.toml".to_owned(), text.to_owned());
        let looked = looked_at(&TextFile { name, text });
        looked
            .map(|value| value["is"].as_str().unwrap_or_default().to_owned())
            .map_err(|error| error.to_string())
    }

    const GEL: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\n\
        elastic_modulus_pa = 100\nviscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\n\
        citation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";

    #[test]
    fn a_file_is_what_its_tables_say() {
        for (text, want) in [
            ("[wall]\norder = 0.5\n", "experiment"),
            ("[zwidth]\n", "experiment"),
            ("[pid]\n[loop]\nsample_time_s = 0.01\n", "controller"),
            (
                "[transfer_function]\nfunction = \"1/s\"\n[loop]\n",
                "controller",
            ),
            ("[transfer_function]\nfunction = \"1/s\"\n", "plant"),
            ("[device]\nmass_kg = 0.1\n", "plant"),
            (GEL, "tissue"),
        ] {
            assert_eq!(is(text).as_deref(), Ok(want), "{text}");
        }
        for text in ["", "[dance]\n", "a = ", "\u{0}", "[parameters]\n"] {
            let error = is(text).expect_err(text);
            assert!(
                error.contains("x.toml") && !error.contains('\n'),
                "{error:?}"
            );
        }
    }

    #[test]
    fn a_tissue_is_kept_once_and_found_again() {
        let place = tempfile::tempdir().expect("a folder");
        let mut library = Library::load(None).expect("built in");
        let mut keep = |name: &str| keep_tissue(&mut library, place.path(), name, GEL);
        let path = keep("soft-gel").expect("kept");
        assert!(path.ends_with("tissues/soft-gel.toml"));
        for (name, why) in [
            ("soft-gel", "already"),
            ("liver", "already"),
            ("../evil", "lower-case"),
            ("", "lower-case"),
        ] {
            let error = keep(name).expect_err(name).to_string();
            assert!(error.contains(why), "{error}");
        }
        let files = std::fs::read_dir(place.path().join(TISSUES)).expect("read");
        assert_eq!(files.count(), 1);
        assert!(library.find("soft-gel").is_ok());
        let later = with_kept(Library::load(None).expect("built in"), place.path());
        assert_eq!(later.find("soft-gel").expect("found").name, "soft-gel");
    }

    #[test]
    fn only_a_log_gets_a_name_and_none_leaves_the_folder() {
        use haptic_log::record::{LogWriter, TickMessage};
        use std::io::Write as _;
        let place = tempfile::tempdir().expect("a folder");
        let source = place.path().join("source.mcap");
        let mut log = LogWriter::create(&source).expect("made");
        log.tick(&TickMessage::default()).expect("written");
        log.finish().expect("finished");
        let bytes = std::fs::read(&source).expect("read");
        let runs = place.path().join("runs");
        let drop_it = |name: &str, bytes: &[u8]| {
            let begun = DroppedLog::begin(&runs, name).map_err(|error| error.to_string())?;
            let mut begun = begun.ok_or("no name")?;
            begun.file.write_all(bytes).expect("written");
            begun.end().map_err(|error| error.to_string())
        };
        assert_eq!(drop_it("a.mcap", &bytes).as_deref(), Ok("dropped/a"));
        assert!(drop_it("a.mcap", &bytes).is_err_and(|why| why.contains("already exists")));
        assert!(drop_it("b.mcap", b"no log").is_err_and(|why| why.contains("not an MCAP")));
        for name in ["../c.mcap", "c.txt", ".mcap", "c/d.mcap", "", "é.mcap"] {
            assert_eq!(drop_it(name, &bytes), Err("no name".to_owned()), "{name}");
        }
        let left = std::fs::read_dir(runs.join(LOGS)).expect("read");
        assert_eq!(left.count(), 1);
    }
}
