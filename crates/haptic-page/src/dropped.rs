//! TOML files that fall on the page: an experiment or question, a plant, a controller, or a tissue, which is kept in the folder of the
//! runs as `tissues/NAME.toml`, never over another, and in the library that is felt.

use crate::folder::folder_of;
use haptic_answer::TextFile;
use haptic_answer::dropped::{self, named, of_file};
use haptic_document::Document;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::Failure;
use haptic_run::write_text;
use haptic_tissue::Library;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Folder of tissues in that of the runs.
pub(crate) const TISSUES: &str = "tissues";

/// Kind of a TOML file, and for an experiment the form that it fills.
pub(crate) fn looked_at(file: &TextFile) -> Result<Value, Failure> {
    if let Some(known) = dropped::looked_at(file)? {
        return Ok(known);
    }
    let path = Path::new(&file.name);
    let document = Document::of_text(path, &file.text);
    document.kind().map_err(|error| {
        Failure::from(error).and("nor a tissue, plant or controller file: drop one of these")
    })?;
    Ok(json!({"is": "experiment", "experiment": of_file(&file.text)}))
}

/// Keeps a tissue under a name of its own, in the folder and in the library; where it is.
pub(crate) fn keep_tissue(
    library: &mut Library,
    runs: &Path,
    name: &str,
    text: &str,
) -> Result<PathBuf, Failure> {
    let path = runs.join(TISSUES).join(format!("{name}.toml"));
    let tissue = named(&path, name, text)?;
    let text = tissue.to_toml();
    let mut with = library.clone();
    with.add(&path, tissue).map_err(Failure::input)?;
    folder_of(runs, TISSUES)?;
    write_text(&path, &text, false)?;
    *library = with;
    Ok(path)
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
        // Through a link it would be written somewhere else, and so through a file in its place.
        let (elsewhere, linked) = (tempfile::tempdir(), tempfile::tempdir());
        let (elsewhere, linked) = (elsewhere.expect("a folder"), linked.expect("a folder"));
        let tissues = linked.path().join(TISSUES);
        #[cfg(unix)]
        for target in [elsewhere.path(), &elsewhere.path().join("missing")] {
            std::os::unix::fs::symlink(target, &tissues).expect("linked");
            let mut library = Library::load(None).expect("built in");
            let error = keep_tissue(&mut library, linked.path(), "soft-gel", GEL);
            let error = error.expect_err("refused").to_string();
            assert!(error.contains("is a link or a file"), "{error}");
            assert!(library.find("soft-gel").is_err(), "nor is it felt");
            std::fs::remove_file(&tissues).expect("removed");
        }
        assert_eq!(
            std::fs::read_dir(elsewhere.path()).expect("read").count(),
            0
        );
        let files = std::fs::read_dir(place.path().join(TISSUES)).expect("read");
        assert_eq!(files.count(), 1);
        assert!(library.find("soft-gel").is_ok());
        let later = Library::load(Some(&place.path().join(TISSUES))).expect("read");
        assert_eq!(later.find("soft-gel").expect("found").name, "soft-gel");
    }
}
