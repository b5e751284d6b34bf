//! Forms of the experiments, from the tables of their parameters; the document that one stands for, and what may be run from a page.

use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{
    self, KINDS, Parameter, QUESTIONS, Value as Default, choices, of_kind,
};
use haptic_loop::LoadingKind;
use haptic_quantity::{label, short};
use haptic_question::tissue::CONTACT_POINT;
use serde_json::{Map, Value, json};
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
    let (mut document, tables) = (Document::new(kind), of_kind(kind));
    // Null and an empty field of a form are the default.
    let given = parameters
        .iter()
        .filter(|(_, value)| !value.is_null() && **value != "");
    for (key, value) in given {
        let mut known = tables.iter().flat_map(|(_, table)| *table);
        let known = known.find(|known| known.key == key);
        let names = |path: &&str| known.is_some_and(|known| known.is_path(path));
        if let Some(path) = value.as_str().filter(names) {
            check_regular(key, Path::new(path))?;
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

/// Initial values of required fields, with which the form runs: those of `experiments/` in the repository.
const SUGGESTED: &[(&str, &str, f64)] = &[
    ("wall", "order", 0.5),
    ("wall", "stiffness_n_per_m", 3000.0),
    ("wall", "dissipation_n_s_mu_per_m", 100.0),
    ("coupler", "order", 1.0),
    ("coupler", "coupler_damping_n_s_per_m", 2.0),
    ("coupler", "coupler_spring_n_s_1_minus_mu_per_m", 1000.0),
];

fn parameter(form: &str, given: &Parameter, required: bool) -> Value {
    let Parameter {
        key,
        value,
        shown,
        help,
        ..
    } = given;
    let suggested = SUGGESTED
        .iter()
        .find(|known| (known.0, known.1) == (form, *key))
        .map(|known| known.2);
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
    let choices: Vec<&str> = choices(given).iter().map(|choice| choice.0).collect();
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

/// Parameter of a record that is to be identified, with the loadings that it is for.
fn record_parameter(given: &Parameter, is_option: bool) -> Value {
    let size = label(given.key);
    let is_size = |kind: LoadingKind| kind.sizes().contains(&size.as_str());
    let is_held = [parameters::STRAIN.key, parameters::STRESS.key].contains(&given.key);
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
    let mut field = parameter("identify", given, false);
    field["loadings"] = json!(loadings);
    field["option"] = json!(is_option);
    field
}

/// Keys for which the page has controls, or takes a file.
const OF_THE_PAGE: [Parameter; 6] = [
    parameters::VALIDATE,
    parameters::PLANT,
    parameters::REFERENCE,
    parameters::CROSSOVER,
    parameters::PHASE_MARGIN,
    parameters::NOT_FLAT,
];

/// The forms of the experiments.
pub(crate) fn forms() -> Value {
    let form = |kind: &str| {
        let tables = parameters::of_kind(kind).into_iter().map(|(title, table)| {
            // The others have defaults.
            let required = title == "required";
            let parameters: Vec<Value> =
                table.iter().map(|p| parameter(kind, p, required)).collect();
            json!({"title": title, "parameters": parameters})
        });
        json!({"kind": kind, "tables": tables.collect::<Vec<_>>()})
    };
    let tables = parameters::RECORD.iter().enumerate();
    let record = tables.flat_map(|(place, (_, table))| {
        let fields = table.iter();
        fields.map(move |one| record_parameter(one, place > 1))
    });
    let fields = |tables: &[(&str, &[Parameter])]| -> Vec<Value> {
        let all = tables.iter().flat_map(|(_, table)| *table);
        let all = all.filter(|one| !OF_THE_PAGE.contains(one));
        all.map(|one| parameter("control", one, false)).collect()
    };
    json!({
        "control_design": fields(&[&parameters::CONTROL_LOOP[..1], parameters::CONTROL_DESIGN].concat()),
        "control_loop": fields(parameters::CONTROL_LOOP),
        "forms": kinds().map(form).collect::<Vec<_>>(),
        "record": record.collect::<Vec<_>>(),
        "plant_record": fields(parameters::PLANT_RECORD),
    })
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
            let tables = parameters::of_kind(kind);
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
