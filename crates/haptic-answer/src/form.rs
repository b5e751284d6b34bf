//! Forms: the fields that the page shows, and the document that a filled one stands for.

use haptic_document::parameters::{KeyTable, Parameter, Value as Default};
use haptic_document::{Document, Failure, ReadDocument};
use haptic_loop::LoadingKind;
use haptic_quantity::{label, short};
use haptic_question::choices::{NamedChoice, choices};
use haptic_question::control_loop::{CONTROL_LOOP, PLANT, REFERENCE};
use haptic_question::controller::{CONTROL_DESIGN, CROSSOVER, NOT_FLAT, PHASE_MARGIN};
use haptic_question::plant::keys::{PLANT_RECORD, VALIDATE};
use haptic_question::tissue::{CONTACT_POINT, RECORD, RECORD_STRAIN, RECORD_STRESS};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The files that a form names.
#[derive(Clone, Copy, Debug)]
pub struct Files {
    /// Refuses a file that is not to be opened, before it is.
    pub check: fn(&str, &Path) -> Result<(), Failure>,
    /// Reads one.
    pub read: ReadDocument,
}

/// Whoever asks a question.
#[derive(Debug)]
pub struct Asker<'a> {
    /// The program that files say has made them.
    pub program: &'a str,
    /// The day of it, as 2026-12-01.
    pub day: String,
    /// The files that a question names.
    pub files: &'a Files,
    /// Set when nobody waits for the answer any more.
    pub given_up: &'a AtomicBool,
}

/// The document that a form of these tables stands for.
///
/// # Errors
/// A value that no document has; a file that is not to be opened.
pub fn document(
    kind: &str,
    tables: &[KeyTable],
    parameters: &Map<String, Value>,
    files: &Files,
) -> Result<Document, Failure> {
    let mut document = Document::new(kind);
    // Null and an empty field of a form are the default.
    let is_given = |value: &Value| !value.is_null() && *value != "";
    let of_tissue = parameters.get("tissue").is_some_and(is_given);
    // A suggestion that nobody changed was not asked for where a tissue takes its place.
    let is_suggestion = |key: &str, value: &Value| {
        SUGGESTED.iter().any(|&(form, known, number)| {
            (form, known) == (kind, key) && value.as_f64() == Some(number)
        })
    };
    let given = parameters
        .iter()
        .filter(|(key, value)| is_given(value) && !(of_tissue && is_suggestion(key, value)));
    for (key, value) in given {
        let mut known = tables.iter().flat_map(|(_, table)| *table);
        let known = known.find(|known| known.key == key);
        let names = |path: &&str| known.is_some_and(|known| known.is_path(path));
        if let Some(path) = value.as_str().filter(names) {
            (files.check)(key, Path::new(path))?;
        }
        let value = toml::Value::try_from(value).map_err(|_| {
            Failure::bad_input(format_args!(
                "`{}` is not a number, a text, a list of numbers, or true or false",
                short(key)
            ))
        })?;
        // The field is in the message.
        document.set(kind, key, value, "")?;
    }
    Ok(document)
}

/// A field of a form: a parameter, with another default where one is suggested.
fn parameter(
    given: &Parameter,
    required: bool,
    suggested: Option<f64>,
    choices: &[NamedChoice],
) -> Value {
    let Parameter {
        key,
        value,
        shown,
        help,
        ..
    } = given;
    let (kind, default) = match value {
        Default::Number(default, _) => ("number", json!(suggested.or(*default))),
        Default::Count(default) => ("count", json!(default)),
        Default::Flag(default) => ("flag", json!(default)),
        Default::Text(default) => ("text", json!(default)),
        Default::List(_) => ("list", json!(shown)),
    };
    let range = if let Default::Number(_, range) = value {
        Some(range)
    } else {
        None
    };
    let [least, most] = range.map_or([None; 2], |range| range.ends().map(Some));
    let choices: Vec<&str> = choices.iter().map(|choice| choice.0).collect();
    json!({
        "key": key,
        "kind": kind,
        "default": default,
        "shown": shown,
        "least": least,
        "most": most,
        "range": range.map(ToString::to_string),
        "required": required,
        "choices": choices,
        "help": help,
    })
}

/// Initial values of fields that are sent unless they are emptied, with which the form runs: those of `experiments/` in the repository.
const SUGGESTED: &[(&str, &str, f64)] = &[
    ("wall", "order", 0.5),
    ("wall", "stiffness_n_per_m", 3000.0),
    ("wall", "dissipation_n_s_mu_per_m", 100.0),
    ("coupler", "order", 1.0),
    ("coupler", "coupler_damping_n_s_per_m", 2.0),
    ("coupler", "coupler_spring_n_s_1_minus_mu_per_m", 1000.0),
];

/// The form of a kind: the fields of its tables. All but the required ones have defaults.
#[must_use]
pub fn form_of(
    kind: &str,
    tables: &[KeyTable],
    choices: fn(&Parameter) -> Vec<NamedChoice>,
) -> Value {
    let tables = tables.iter().map(|(title, table)| {
        let field = |one: &Parameter| {
            let suggested = SUGGESTED
                .iter()
                .find(|known| (known.0, known.1) == (kind, one.key))
                .map(|known| known.2);
            let required = *title == "required" || suggested.is_some();
            parameter(one, required, suggested, &choices(one))
        };
        json!({"title": title, "parameters": table.iter().map(field).collect::<Vec<_>>()})
    });
    json!({"kind": kind, "tables": tables.collect::<Vec<_>>()})
}

/// Parameter of a record that is to be identified, with the loadings that it is for.
fn record_parameter(given: &Parameter, is_option: bool) -> Value {
    let size = label(given.key);
    let is_size = |kind: LoadingKind| kind.sizes().contains(&size.as_str());
    let is_held = [RECORD_STRAIN.key, RECORD_STRESS.key].contains(&given.key);
    let kinds = LoadingKind::ALL;
    let is_of_some = kinds.into_iter().any(is_size);
    let is_contact = given.key == CONTACT_POINT.key;
    let takes = |kind: &LoadingKind| match (is_of_some, is_contact) {
        (true, _) => is_size(*kind),
        (false, true) => !kind.is_slab(),
        (false, false) => kind.is_slab() || !is_held,
    };
    let loadings = LoadingKind::ALL.iter().filter(|kind| takes(kind));
    let loadings: Vec<&str> = loadings.map(|kind| kind.name()).collect();
    let mut field = parameter(given, false, None, &choices(given));
    field["loadings"] = json!(loadings);
    field["option"] = json!(is_option);
    field
}

/// Keys for which the page has controls, or takes a file.
const OF_THE_PAGE: [Parameter; 6] = [
    VALIDATE,
    PLANT,
    REFERENCE,
    CROSSOVER,
    PHASE_MARGIN,
    NOT_FLAT,
];

/// The forms of what is asked about a plant, a loop or a record.
#[must_use]
pub fn forms() -> Value {
    let tables = RECORD.iter().enumerate();
    let record = tables.flat_map(|(place, (_, table))| {
        let fields = table.iter();
        fields.map(move |one| record_parameter(one, place > 1))
    });
    let fields = |tables: &[KeyTable]| -> Vec<Value> {
        let all = tables.iter().flat_map(|(_, table)| *table);
        let all = all.filter(|one| !OF_THE_PAGE.contains(one));
        all.map(|one| parameter(one, false, None, &choices(one)))
            .collect()
    };
    json!({
        "control_design": fields(&[&CONTROL_LOOP[..1], CONTROL_DESIGN].concat()),
        "control_loop": fields(CONTROL_LOOP),
        "record": record.collect::<Vec<_>>(),
        "plant_record": fields(PLANT_RECORD),
    })
}
