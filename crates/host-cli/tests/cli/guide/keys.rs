//! The page of all keys of experiment, controller and plant files, made from the tables that read them.

use crate::process::Place;
use fracdiff::parameter::Shown;
use haptic_experiment::parameters::{
    self, CONTROL_DESIGN, CONTROL_LOOP, PLANT_RECORD, Parameter, QUESTIONS, RECORD, REFERENCE,
    Range, VALIDATE, Value, choices,
};
use haptic_quantity::without_unit;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use testkit::book;

const FILE: &str = "experiment-keys.md";
/// What stands above is written by hand, what stands below is made here.
const MARK: &str =
    "<!-- Made from the tables: UPDATE_GUIDE=1 cargo test -p host-cli --test cli guide::keys -->\n";
/// With this in the environment the page is written, not compared.
const UPDATE: &str = "UPDATE_GUIDE";

/// A line for people, and the default that some of them tell in words: `…, 1ms to 1s [default: 0.1s]`.
fn told(parameter: &Parameter) -> (&'static str, Option<&'static str>) {
    let split = parameter.help.split_once(" [default: ");
    let told = split.and_then(|(help, rest)| Some((help, rest.strip_suffix(']')?)));
    told.map_or((parameter.help, None), |(help, default)| {
        (help, Some(default))
    })
}

fn default(parameter: &Parameter) -> String {
    if let Some(default) = told(parameter).1 {
        return default.to_owned();
    }
    match parameter.value {
        Value::Number(Some(default), _) => format!("{default}"),
        Value::Count(default) => format!("{default}"),
        Value::Flag(default) => format!("{default}"),
        Value::List(_) if !parameter.shown.is_empty() => parameter.shown.to_owned(),
        Value::Text("") | Value::Number(None, _) | Value::List(_) => "none".to_owned(),
        Value::Text(default) => format!("`\"{default}\"`"),
    }
}

/// An interval, as in `[0, 1e6]` or `(0, 1e6]`.
fn interval(range: Range) -> String {
    let (Range::Within(low, high) | Range::AboveUpTo(low, high) | Range::ZeroOr(low, high)) = range;
    let [low, high] = [low, high].map(Shown);
    match range {
        Range::Within(..) => format!("[{low}, {high}]"),
        Range::AboveUpTo(..) => format!("({low}, {high}]"),
        Range::ZeroOr(..) => format!("0, [{low}, {high}]"),
    }
}

fn range(parameter: &Parameter) -> String {
    match parameter.value {
        Value::Number(_, Range::Within(f64::MIN, f64::MAX)) => "any".to_owned(),
        Value::Number(_, range) => interval(range),
        Value::Count(_) => "whole".to_owned(),
        Value::Flag(_) => "true, false".to_owned(),
        Value::List(range) => format!("list in {}", interval(range)),
        Value::Text(_) if choices(parameter).is_empty() => "text".to_owned(),
        Value::Text(_) => "choice".to_owned(),
    }
}

fn meaning(parameter: &Parameter) -> String {
    let mut text = told(parameter).0.to_owned();
    for (name, help) in choices(parameter) {
        let _ = write!(text, "<br>*{name}*: {help}");
    }
    text
}

/// Rows of a table, each with its key.
fn rows(heading: &str, parameters: &[Parameter]) -> Vec<(&'static str, String)> {
    let required = heading.ends_with("required");
    let said = required.then_some("required");
    let rows = parameters.iter();
    let rows = rows.map(|one| (one.key, format!("| `{}` | {} |", one.key, cells(one, said))));
    rows.collect()
}

/// Default, which may be said otherwise, range and meaning.
fn cells(parameter: &Parameter, said: Option<&str>) -> String {
    let default = said.map_or_else(|| default(parameter), str::to_owned);
    let meaning = meaning(parameter).replace('|', "\\|");
    [default, range(parameter), meaning].join(" | ")
}

fn table(text: &mut String, heading: &str, rows: &[&str]) {
    let _ = write!(text, "\n### {heading}\n");
    if !rows.is_empty() {
        let head = "| key | default | range | meaning |\n|---|---|---|---|";
        let _ = writeln!(text, "\n{head}\n{}", rows.join("\n"));
    }
}

/// Rows that several tables have stand once, under Shared keys; the tables name them.
fn tables(text: &mut String, tables: &[(&str, &[Parameter])], shared: &[String]) {
    for (heading, parameters) in tables {
        let rows = rows(heading, parameters);
        let (own, common) = apart(&rows, shared);
        table(text, heading, &own);
        if !common.is_empty() {
            let _ = writeln!(text, "\nAnd [shared](#shared-keys): {common}");
        }
    }
}

/// Arguments that Python calls otherwise than the key.
const IN_PYTHON: [(&str, &str); 5] = [
    ("contact_point_m", "contact_point"),
    ("from_s", "from_"),
    ("master_curve", "master_curve_c"),
    ("temperature", "temperatures_c"),
    ("to_s", "to"),
];

/// Keys of a device at a port.
const ON_DEVICE: [&str; 5] = [
    "device",
    "late_ticks",
    "loop",
    "max_age_ticks",
    "watchdog_s",
];

/// Keys of a question, each with its row: option, or `KEY=VALUE`, and argument; the help of the command has them.
fn asked(command: &str, tables: &[(&str, &[Parameter])]) -> Vec<(&'static str, String)> {
    let help = Place::new().run(&format!("{command} --help")).stdout;
    let row = |parameter: &Parameter| {
        let key = parameter.key;
        let option = format!("--{}", without_unit(key).replace('_', "-"));
        let is_option = [" ", "\n"]
            .iter()
            .any(|end| help.contains(&format!("{option}{end}")));
        let typed = match is_option {
            true => option,
            false => format!("{}=VALUE", without_unit(key)),
        };
        assert!(is_option || help.contains("[KEY=VALUE]"), "{typed}");
        let page = match key {
            key if key == VALIDATE.key => ", second file",
            key if key == REFERENCE.key => ", file",
            key if ON_DEVICE.contains(&key) => ", not there",
            _ => "",
        };
        let python = IN_PYTHON.iter().find(|one| one.0 == key);
        let python = python.map_or(key, |one| one.1);
        let cells = cells(
            parameter,
            Some(parameter.shown).filter(|shown| !shown.is_empty()),
        );
        let row = format!("| `{key}`{page} | `{typed}` | `{python}` | {cells} |");
        (key, row)
    };
    let all = tables.iter().flat_map(|(_, table)| *table);
    all.map(row).collect()
}

/// The questions, with their own rows; those of several stand once, behind them.
fn questions(text: &mut String) {
    let design = [&CONTROL_LOOP[..1], CONTROL_DESIGN].concat();
    let forms = [
        ("identify", RECORD),
        ("control identify", PLANT_RECORD),
        ("control design", &design),
        ("control analyze", &CONTROL_LOOP[..2]),
        ("control simulate", CONTROL_LOOP),
    ];
    let forms = forms.map(|(command, tables)| (command.to_owned(), tables.to_vec()));
    let documents = QUESTIONS.map(|kind| {
        (
            kind.replace("analyze-", "analyze "),
            parameters::of_kind(kind),
        )
    });
    let all = forms.into_iter().chain(documents);
    let all: Vec<_> = all
        .map(|(command, tables)| {
            let rows = asked(&command, &tables);
            (command, rows)
        })
        .collect();
    let shared = shared(all.iter().flat_map(|(_, rows)| rows.clone()));
    let head = "| key, field of the page | command | Python | default | range | meaning |\n|---|---|---|---|---|---|";
    for (command, rows) in &all {
        let (own, common) = apart(rows, &shared);
        let _ = writeln!(text, "\n### {command}");
        if !own.is_empty() {
            let _ = writeln!(text, "\n{head}\n{}", own.join("\n"));
        }
        if !common.is_empty() {
            let _ = writeln!(
                text,
                "\nAnd [of several](#keys-of-several-questions): {common}"
            );
        }
    }
    let _ = writeln!(
        text,
        "\n### Keys of several questions\n\n{head}\n{}",
        shared.join("\n")
    );
}

/// Rows that stand here alone, and the keys of those that stand once for several tables.
fn apart<'a>(rows: &'a [(&str, String)], shared: &[String]) -> (Vec<&'a str>, String) {
    let (common, own): (Vec<_>, Vec<_>) = rows.iter().partition(|row| shared.contains(&row.1));
    let common: Vec<String> = common.iter().map(|row| format!("`{}`", row.0)).collect();
    (
        own.iter().map(|row| row.1.as_str()).collect(),
        common.join(" "),
    )
}

/// Rows of several tables: one for each key, that of most.
fn shared(all: impl Iterator<Item = (&'static str, String)>) -> Vec<String> {
    let mut counts: BTreeMap<String, (&str, usize)> = BTreeMap::new();
    for (key, row) in all {
        counts.entry(row).or_insert((key, 0)).1 += 1;
    }
    let mut shared: BTreeMap<&str, (usize, String)> = BTreeMap::new();
    for (row, (key, count)) in counts {
        let least = shared.get(key).map_or(1, |known| known.0);
        if count > least {
            shared.insert(key, (count, row));
        }
    }
    shared.into_values().map(|(_, row)| row).collect()
}

/// The text with each list of choices once; later rows name the key that has it.
fn lists_once(text: &str) -> String {
    let mut seen = BTreeMap::new();
    let lines = text.lines().map(|line| {
        let Some((row, list)) = line.split_once("<br>") else {
            return line.to_owned();
        };
        if let Some(first) = seen.get(list) {
            return format!("{row}; choices as of {first} above |");
        }
        seen.insert(list, row.split(' ').nth(1).unwrap_or_default());
        line.to_owned()
    });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// The page below its mark.
fn made() -> String {
    let all = ["experiment", "controller", "plant"]
        .map(parameters::tables)
        .concat();
    let all = all
        .iter()
        .flat_map(|(heading, parameters)| rows(heading, parameters));
    let shared = shared(all);
    let mut text = String::from("\n## Experiment files\n");
    let listed: Vec<&str> = shared.iter().map(String::as_str).collect();
    tables(&mut text, &parameters::tables("experiment"), &shared);
    table(&mut text, "Shared keys", &listed);
    text.push_str("\n## Controller files\n\nOne of the first five, and `[loop]`.\n");
    tables(&mut text, &parameters::tables("controller"), &shared);
    text.push_str("\n## Plant files\n\nOne of the first four. In `[device]` mass and damping are required; `[intervals]` beside it has the same\nkeys, each `[low, high]`.\n");
    tables(&mut text, &parameters::tables("plant"), &shared);
    text.push_str("\n## Questions\n\nThe command, the page and Python ask them alike; in Python they are `tissue.identify_tables`, `control.identify`, `control.design`, `control.analyze`, `control.simulate`, and in\n`experiment` `zwidth`, `design`, `analyze_stability` and so on. The page runs no device at a port; a plant is typed there, or a file.\n");
    questions(&mut text);
    lists_once(&text)
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
                let shown = parameters::tables("experiment")
                    .iter()
                    .any(|(_, shown)| shown.contains(parameter));
                assert!(shown, "{kind}: {}", parameter.key);
            }
        }
    }
}
