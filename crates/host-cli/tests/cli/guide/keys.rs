//! The page of all keys of experiment, controller and plant files, made from the tables that read them.

use haptic_experiment::parameters;
use haptic_experiment::parameters::choices;
use haptic_experiment::parameters::{
    CONTROLLER_LOOP, CONTROLLER_SOURCE, CRONE, DEVICE_PLANT, LEAD_LAG, MEASURED_PLANT, PID,
    PLANT_SOURCE, Parameter, STATE_PLANT, TID, TRANSFER_CONTROLLER, TRANSFER_PLANT, Value,
};
use host_cli::command::run::TABLES;
use std::fmt::Write as _;
use testkit::book;

const FILE: &str = "experiment-keys.md";
/// What stands above is written by hand, what stands below is made here.
const MARK: &str = "<!-- From here on made from the tables of the program: UPDATE_GUIDE=1 cargo test -p host-cli --test cli guide::keys -->\n";
/// With this in the environment the page is written, not compared.
const UPDATE: &str = "UPDATE_GUIDE";

const CONTROLLER_FILES: &[(&str, &[Parameter])] = &[
    ("[pid]", PID),
    ("[tid]", TID),
    ("[crone]", CRONE),
    ("[lead_lag]", LEAD_LAG),
    ("[transfer_function]", TRANSFER_CONTROLLER),
    ("[loop], always", CONTROLLER_LOOP),
    ("[source], if you like", CONTROLLER_SOURCE),
];
const PLANT_FILES: &[(&str, &[Parameter])] = &[
    ("[transfer_function]", TRANSFER_PLANT),
    ("[device]", DEVICE_PLANT),
    ("[state_space]", STATE_PLANT),
    ("[measured_response]", MEASURED_PLANT),
    ("[source], if you like", PLANT_SOURCE),
];

/// A line for people, and the default that some of them tell in words: `…, 1ms to 1s [default: 0.1s]`.
fn told(parameter: &Parameter) -> (&'static str, Option<&'static str>) {
    let split = parameter.help.split_once(" [default: ");
    let told = split.and_then(|(help, rest)| Some((help, rest.strip_suffix(']')?)));
    told.map_or((parameter.help, None), |(help, default)| {
        (help, Some(default))
    })
}

fn default(parameter: &Parameter, required: bool) -> String {
    match parameter.value {
        _ if required => "to be given".to_owned(),
        _ if told(parameter).1.is_some() => told(parameter).1.unwrap_or_default().to_owned(),
        Value::Number(Some(default), _) => format!("{default}"),
        Value::Count(default) => format!("{default}"),
        Value::Flag(default) => format!("{default}"),
        Value::Text("") | Value::Number(None, _) | Value::List(_) => "none".to_owned(),
        Value::Text(default) => format!("`\"{default}\"`"),
        other => panic!("{other:?}"),
    }
}

fn range(parameter: &Parameter) -> String {
    let choices = choices(parameter.key);
    match parameter.value {
        Value::Number(_, range) => range.to_string(),
        Value::Count(_) => "whole number".to_owned(),
        Value::Flag(_) => "true, false".to_owned(),
        Value::List(range) => format!("list of numbers {range}"),
        _ if choices.is_empty() => "text".to_owned(),
        _ => {
            let names = choices.iter().map(|choice| format!("`\"{}\"`", choice.0));
            names.collect::<Vec<_>>().join(", ")
        }
    }
}

fn meaning(parameter: &Parameter) -> String {
    let mut text = told(parameter).0.to_owned();
    for (name, help) in choices(parameter.key) {
        let _ = write!(text, "<br>*{name}*: {help}");
    }
    text
}

fn tables(text: &mut String, tables: &[(&str, &[Parameter])]) {
    for (heading, parameters) in tables {
        let required = heading.ends_with("to be given");
        let _ = write!(
            text,
            "\n### {heading}\n\n| key | default | range | meaning |\n|---|---|---|---|\n"
        );
        for parameter in *parameters {
            let row = [
                format!("`{}`", parameter.key),
                default(parameter, required),
                range(parameter),
                meaning(parameter),
            ];
            assert!(
                row.iter().all(|cell| !cell.contains(['|', '\n'])),
                "{row:?}"
            );
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
    }
}

/// The page below its mark.
fn made() -> String {
    let mut text = String::from("\n## Experiment files\n");
    tables(&mut text, TABLES);
    text.push_str("\n## Controller files\n\nOne of the first five, and `[loop]`.\n");
    tables(&mut text, CONTROLLER_FILES);
    text.push_str("\n## Plant files\n\nOne of the first four. In `[device]` mass and damping are to be given; `[intervals]` beside `[device]` has its keys too, each `[low, high]`.\n");
    tables(&mut text, PLANT_FILES);
    text
}

#[test]
fn the_page_of_keys_is_made_from_the_tables() {
    let page = book::chapter(FILE);
    let (head, shown) = page.split_once(MARK).expect("a mark");
    let made = made();
    if std::env::var_os(UPDATE).is_some() {
        std::fs::write(book::folder().join(FILE), format!("{head}{MARK}{made}")).expect("writes");
    } else if shown != made {
        let differs = shown.lines().zip(made.lines()).find(|(a, b)| a != b);
        panic!(
            "{FILE} is stale: make it anew with {UPDATE}=1 in the environment; first line that differs: {differs:?}"
        );
    }
}

#[test]
fn no_table_of_an_experiment_is_missing_on_the_page() {
    for kind in parameters::KINDS {
        for (_, table) in parameters::of_kind(kind) {
            for parameter in table {
                let shown = TABLES.iter().any(|(_, shown)| shown.contains(parameter));
                assert!(shown, "{kind}: {}", parameter.key);
            }
        }
    }
}
