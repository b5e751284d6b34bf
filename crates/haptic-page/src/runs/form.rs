//! Forms of the experiments, from the tables of their parameters; the document that one stands for, and what may be run from a page.

use haptic_answer::form::{Files, form_of};
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{KINDS, QUESTIONS, choices, of_kind};
use haptic_quantity::short;
use haptic_run::read_document;
use serde_json::{Map, Value};
use std::fs;
use std::path::Path;

/// The document that a form stands for.
pub(crate) fn document(kind: &str, parameters: &Map<String, Value>) -> Result<Document, Failure> {
    if !kinds().any(|known| known == kind) {
        let kinds: Vec<&str> = kinds().collect();
        return Err(Failure::bad_input(format_args!(
            "experiment {:?} is not one of {}",
            short(kind),
            kinds.join(", ")
        )));
    }
    haptic_answer::form::document(kind, &of_kind(kind), parameters, &FILES)
}

pub(crate) const FILES: Files = Files {
    check: check_regular,
    read: read_document,
};

/// The one place that looks at a file before what a form names is opened: a pipe would be waited for without an end. What is not there
/// its reader says, or it is the name of a tissue.
fn check_regular(key: &str, path: &Path) -> Result<(), Failure> {
    let Ok(about) = fs::metadata(path) else {
        return Ok(());
    };
    let inside = about.is_dir().then(|| fs::read_dir(path));
    let inside = inside.and_then(Result::ok).into_iter().flatten();
    let other = inside
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(|inside| {
            fs::metadata(inside).is_ok_and(|about| !(about.is_file() || about.is_dir()))
        });
    let itself = (!(about.is_file() || about.is_dir())).then(|| path.to_owned());
    itself.or(other).map_or(Ok(()), |path| {
        Err(Failure::bad_input(format_args!(
            "`{key}`: {} is not a regular file: only those are opened for a page",
            path.display()
        )))
    })
}

pub(super) fn simulated(is_simulated: bool) -> Result<(), Failure> {
    if is_simulated {
        Ok(())
    } else {
        Err(Failure::bad_input(
            "the page runs experiments on the simulated device: for a serial one use the command line, as in \
         `run FILE.toml`; its log is shown here",
        ))
    }
}

pub(super) fn kinds() -> impl Iterator<Item = &'static str> {
    KINDS.into_iter().chain(QUESTIONS)
}

/// The forms of the experiments.
pub(crate) fn forms() -> Value {
    let mut forms = haptic_answer::form::forms();
    forms["forms"] = kinds()
        .map(|kind| form_of(kind, &of_kind(kind), choices))
        .collect();
    forms
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_a_file_stands_in_a_form_with_its_default() {
        let forms = forms();
        for (kind, form) in kinds().zip(forms["forms"].as_array().expect("a list")) {
            let tables = form["tables"].as_array().expect("a list").iter();
            let shown = tables.flat_map(|table| table["parameters"].as_array().expect("a list"));
            let keys: Vec<&str> = shown.filter_map(|shown| shown["key"].as_str()).collect();
            let tables = of_kind(kind);
            let wanted = tables.iter().flat_map(|(_, table)| *table);
            let wanted: Vec<&str> = wanted.map(|parameter| parameter.key).collect();
            assert_eq!(keys, wanted);
        }
        let record = forms["record"].as_array().expect("a list").iter();
        let loadings = |key: &str| {
            record
                .clone()
                .find(|kind| kind["key"] == key)
                .map(|kind| kind["loadings"].to_string())
        };
        assert_eq!(loadings("half_angle_rad").as_deref(), Some("[\"cone\"]"));
        assert_eq!(
            loadings("strain").as_deref(),
            Some("[\"shear\",\"tension\",\"compression\"]")
        );
        assert_eq!(
            loadings("contact_point_m").as_deref(),
            Some("[\"punch\",\"sphere\",\"cone\"]")
        );
        let all = loadings("poisson_ratio").expect("a field");
        assert!(all.contains("sphere") && all.contains("shear"), "{all}");
        let text = forms.to_string();
        let choices = "\"choices\":[\"off\",\"observer\",\"energy-bounding\"]";
        assert!(text.contains(choices), "{text}");
    }
}
