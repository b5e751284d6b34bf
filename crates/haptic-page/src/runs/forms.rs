//! Forms of the experiments, from the tables of their parameters.

use haptic_experiment::parameters;
use haptic_experiment::parameters::choices;
use haptic_experiment::parameters::{
    COUPLER_REQUIRED, KINDS, Parameter, QUESTIONS, Value as Default, WALL_REQUIRED,
};
use serde_json::{Value, json};

/// Experiments and questions.
pub(super) fn kinds() -> impl Iterator<Item = &'static str> {
    KINDS.into_iter().chain(QUESTIONS)
}

/// What has to be given begins in a form with numbers that run: those of `experiments/` in the repository.
const SUGGESTED: &[(&str, &str, f64)] = &[
    ("wall", "order", 0.5),
    ("wall", "stiffness_n_per_m", 3000.0),
    ("wall", "dissipation_n_s_mu_per_m", 100.0),
    ("coupler", "order", 1.0),
    ("coupler", "coupler_stiffness_n_s_per_m", 2.0),
    (
        "coupler",
        "coupler_dissipation_n_s_1_minus_mu_per_m",
        1000.0,
    ),
];

fn parameter(form: &str, parameter: &Parameter, required: &[Parameter]) -> Value {
    let Parameter {
        key,
        value,
        shown,
        help,
    } = parameter;
    let suggested = SUGGESTED
        .iter()
        .find(|known| (known.0, known.1) == (form, *key))
        .map(|known| known.2);
    let required = required.iter().any(|known| known.key == *key);
    let (kind, default) = match value {
        Default::Number(default, _) => ("number", json!(suggested.or(*default))),
        Default::Count(default) => ("count", json!(default)),
        Default::Flag(default) => ("flag", json!(default)),
        Default::Text(default) => ("text", json!(default)),
        Default::List(_) => ("list", json!(shown)),
        _ => ("text", Value::Null),
    };
    let (least, most) = match value {
        Default::Number(_, range) => range.ends().map(Some).into(),
        _ => (None, None),
    };
    let range = match value {
        Default::Number(_, range) => Some(range.to_string()),
        _ => None,
    };
    let choices: Vec<&str> = choices(key).iter().map(|choice| choice.0).collect();
    json!({
        "key": key,
        "kind": kind,
        "default": default,
        "shown": shown,
        "least": least,
        "most": most,
        "range": range,
        "required": required,
        "choices": choices,
        "help": help,
    })
}

/// All of them.
pub(super) fn forms() -> Value {
    let form = |kind: &str| {
        // The others have defaults for all.
        let required = match kind {
            "wall" => WALL_REQUIRED,
            "coupler" => COUPLER_REQUIRED,
            _ => &[],
        };
        let tables = parameters::of_kind(kind).into_iter().map(|(title, table)| {
            let parameters: Vec<Value> =
                table.iter().map(|p| parameter(kind, p, required)).collect();
            json!({"title": title, "parameters": parameters})
        });
        json!({"kind": kind, "tables": tables.collect::<Vec<_>>()})
    };
    json!({"forms": kinds().map(form).collect::<Vec<_>>()})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_a_file_stands_in_a_form_with_its_default() {
        let forms = forms();
        for (kind, form) in kinds().zip(forms["forms"].as_array().expect("a list")) {
            let shown = form["tables"]
                .as_array()
                .expect("a list")
                .iter()
                .flat_map(|table| table["parameters"].as_array().expect("a list"));
            let keys: Vec<&str> = shown.filter_map(|shown| shown["key"].as_str()).collect();
            let tables = parameters::of_kind(kind);
            let wanted = tables.iter().flat_map(|(_, table)| *table);
            assert_eq!(
                keys,
                wanted.map(|parameter| parameter.key).collect::<Vec<_>>()
            );
        }
        let text = forms.to_string();
        assert!(
            text.contains("\"choices\":[\"off\",\"observer\",\"energy-bounding\"]"),
            "{text}"
        );
    }
}
