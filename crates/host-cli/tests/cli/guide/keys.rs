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
/// Variable with which the page is written, not compared.
const UPDATE: &str = "UPDATE_GUIDE";

/// A line for people, and the default that some of them tell in words: `…, 1ms to 1s [default: 0.1s]`.
fn help_and_default(parameter: &Parameter) -> (&'static str, Option<&'static str>) {
    let split = parameter.help.split_once(" [default: ");
    let pair = split.and_then(|(help, rest)| Some((help, rest.strip_suffix(']')?)));
    pair.map_or((parameter.help, None), |(help, default)| {
        (help, Some(default))
    })
}

/// The number, or words where it is not one or has no end, as 60 degrees in radians.
fn default(parameter: &Parameter) -> String {
    if let Some(default) = help_and_default(parameter).1 {
        return default.to_owned();
    }
    let shown = Some(parameter.shown).filter(|shown| !shown.is_empty());
    let is_word = |number: &str| {
        shown.filter(|shown| number.len() > 9 || !shown.starts_with(|c: char| c.is_ascii_digit()))
    };
    match parameter.value {
        Value::Number(Some(default), _) => {
            let number = format!("{default}");
            is_word(&number).map_or(number.clone(), str::to_owned)
        }
        Value::Count(default) => format!("{default}"),
        Value::Flag(default) => format!("{default}"),
        Value::Text("") | Value::Number(None, _) | Value::List(_) => {
            shown.unwrap_or("none").to_owned()
        }
        Value::Text(default) => format!("`\"{default}\"`"),
    }
}

/// An interval, as in `0…1e6` or `>0…1e6`.
fn interval(range: Range) -> String {
    let (Range::Within(low, high) | Range::AboveUpTo(low, high) | Range::ZeroOr(low, high)) = range;
    let [low, high] = [low, high].map(Shown);
    match range {
        Range::Within(..) => format!("{low}…{high}"),
        Range::AboveUpTo(..) => format!(">{low}…{high}"),
        Range::ZeroOr(..) => format!("0, {low}…{high}"),
    }
}

/// The range, if the default does not show it.
fn range(parameter: &Parameter) -> String {
    match parameter.value {
        Value::Number(_, Range::Within(f64::MIN, f64::MAX)) => "; any".to_owned(),
        Value::Number(_, range) => format!("; {}", interval(range)),
        Value::List(range) => format!("; list in {}", interval(range)),
        Value::Count(_) | Value::Flag(_) => String::new(),
        Value::Text("") if choices(parameter).is_empty() => "; text".to_owned(),
        Value::Text(_) => String::new(),
    }
}

fn meaning(parameter: &Parameter) -> String {
    let mut text = help_and_default(parameter).0.to_owned();
    for (name, help) in choices(parameter) {
        let _ = write!(text, "<br>*{name}*: {help}");
    }
    text
}

/// A key as it stands in one table; its row may stand elsewhere.
#[derive(Clone, PartialEq)]
struct Row {
    key: &'static str,
    default: String,
    range: String,
    meaning: String,
}

impl Row {
    fn new(parameter: &Parameter, required: bool) -> Self {
        let default = if required {
            "required".to_owned()
        } else {
            default(parameter)
        };
        Self {
            key: parameter.key,
            default,
            range: range(parameter),
            meaning: meaning(parameter).replace('|', "\\|"),
        }
    }

    /// True if one row does for both, but for its default.
    fn is(&self, other: &Self) -> bool {
        (self.key, &self.range, &self.meaning) == (other.key, &other.range, &other.meaning)
    }

    /// The key and its meaning, with default and range behind it, as `--help` has them.
    fn line(&self) -> String {
        let (key, default, range, meaning) = (self.key, &self.default, &self.range, &self.meaning);
        let shown = format!("{default}{range}");
        let shown = shown.strip_prefix("none; ").unwrap_or(&shown);
        let (meaning, list) = meaning.split_at(meaning.find("<br>").unwrap_or(meaning.len()));
        format!("`{key}` | {meaning} [{shown}]{list}")
    }

    /// The key alone, with its default if the row that is shown has another one.
    fn named(&self, shown: &Self) -> String {
        if self.default == shown.default || self.default == "required" {
            format!("`{}`", self.key)
        } else {
            format!("`{}` ({})", self.key, self.default)
        }
    }
}

/// Keys that stand together in many tables, and their name.
const GROUPS: [(&str, &str); 5] = [
    (
        "*specimen*",
        "`library` `area_m2` `thickness_m` `loading` `indenter_radius_m` `half_angle_rad` `bonded`",
    ),
    (
        "*law*",
        "`order` `scheme` `stiffness_n_per_m` `dissipation_n_s_mu_per_m` `sample_time_s` `tissue` *specimen* `depth_m` `controller`",
    ),
    (
        "*without units*",
        "`alpha` `beta` `delta` `gamma` `delay_samples`",
    ),
    (
        "*analysed device*",
        "`device_model` `mass_kg` `damping_n_s_per_m` `hand_stiffness_n_per_m` (none) `delay_s` (none) `current_lag_s` `plant_model`",
    ),
    (
        "*imperfections*",
        "`delay_s` `friction_n` `current_lag_s` (0) `encoder_resolution_m` `sensor_noise_m` `seed`",
    ),
];

/// The keys with the names of groups in their place.
fn grouped(keys: &str) -> String {
    let name = |keys: String, (group, list): &(&str, &str)| keys.replace(list, group);
    GROUPS.iter().fold(keys.to_owned(), name)
}

/// A table of the page, under its heading.
struct Table {
    heading: String,
    rows: Vec<Row>,
}

impl Table {
    fn new(heading: &str, parameters: &[Parameter]) -> Self {
        let required = heading.ends_with("required");
        let rows = parameters.iter().map(|one| Row::new(one, required));
        Self {
            heading: heading.to_owned(),
            rows: rows.collect(),
        }
    }

    /// The anchor of the heading behind those of `before`, some of which may have the same words.
    fn anchor(&self, before: &[Self]) -> String {
        let alike = |table: &&Self| table.heading == self.heading;
        let earlier = before
            .iter()
            .take_while(|table| !std::ptr::eq(*table, self));
        let suffix = match earlier.filter(alike).count() {
            0 => String::new(),
            count => format!("-{count}"),
        };
        let kept = |c: &char| c.is_alphanumeric() || " _-".contains(*c);
        let kept: String = self.heading.chars().filter(kept).collect();
        kept.to_lowercase().replace(' ', "-") + &suffix
    }

    /// The rows that stand nowhere else before, and the names of all others with the place of their rows.
    fn write(&self, text: &mut String, shared: &Self, before: &[Self]) {
        let _ = write!(text, "\n### {}\n", self.heading);
        let mut rows = Vec::new();
        let mut elsewhere: Vec<(&Self, Vec<String>)> = Vec::new();
        for row in &self.rows {
            let mut tables = [shared].into_iter().chain(before);
            let known = tables.find_map(|table| {
                let shown = table.rows.iter().find(|shown| shown.is(row));
                shown.map(|shown| (table, shown))
            });
            let Some((table, shown)) = known else {
                rows.push(row.line());
                continue;
            };
            let name = row.named(shown);
            match elsewhere.iter_mut().find(|one| std::ptr::eq(one.0, table)) {
                Some((_, names)) => names.push(name),
                None => elsewhere.push((table, vec![name])),
            }
        }
        if !rows.is_empty() {
            let _ = writeln!(text, "\n{HEAD}\n{}", rows.join("\n"));
        }
        let elsewhere = elsewhere.into_iter().map(|(table, names)| {
            let (anchor, names) = (table.anchor(before), names.join(" "));
            let heading = table.heading.split(',').next().unwrap_or_default();
            let heading = heading.trim_end_matches(" keys");
            format!("[{heading}](#{anchor}): {}", grouped(&names))
        });
        let elsewhere = elsewhere.collect::<Vec<_>>().join("; ");
        if !elsewhere.is_empty() {
            let _ = writeln!(text, "\nAlso {elsewhere}");
        }
    }
}

const HEAD: &str = "key | meaning [default; range]\n---|---";

/// Rows that at least three tables have: one for each key, that of most, with the default of most.
fn shared(tables: &[Table]) -> Table {
    let mut counts: BTreeMap<&str, Vec<(&Row, usize)>> = BTreeMap::new();
    let all: Vec<&Row> = tables.iter().flat_map(|table| &table.rows).collect();
    for row in &all {
        let known = counts.entry(row.key).or_default();
        match known.iter_mut().find(|one| one.0.is(row)) {
            Some((_, count)) => *count += 1,
            None => known.push((row, 1)),
        }
    }
    let most = counts.into_values().filter_map(|rows| {
        let (row, count) = rows.into_iter().max_by_key(|one| one.1)?;
        let alike = |one: &&&Row| one.is(row) && one.default != "required";
        let by_default = |one: &&Row| all.iter().filter(|other| **other == *one).count();
        let row = all.iter().filter(alike).copied().max_by_key(by_default)?;
        (count > 2).then(|| row.clone())
    });
    Table {
        heading: "Shared keys".to_owned(),
        rows: most.collect(),
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

/// The questions: command and tables.
fn questions() -> Vec<(String, Vec<Parameter>)> {
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
        let command = kind.replace("analyze-", "analyze ");
        (command, parameters::of_kind(kind))
    });
    let all = forms.into_iter().chain(documents);
    let keys = |tables: Vec<(&str, &[Parameter])>| {
        tables
            .iter()
            .flat_map(|(_, table)| table.to_vec())
            .collect()
    };
    all.map(|(command, tables)| (command, keys(tables)))
        .collect()
}

/// The names of a key, rule and exceptions: on the command, on the page and in Python.
fn names(questions: &[(String, Vec<Parameter>)]) -> String {
    let mut text = String::from("\nkey | command | page | Python\n---|---|---|---\n");
    let like = ["`--sample-time`", "`sample_time_s`", "`sample_time_s`"];
    let mut row = |key: &str, [command, page, python]: [&str; 3]| {
        let _ = writeln!(text, "{key} | {command} | {page} | {python}");
    };
    row("each key, as `sample_time_s`", like);
    for (command, parameters) in questions {
        let help = Place::new().run(&format!("{command} --help")).stdout;
        let typed = parameters.iter().map(|one| one.key).filter(|key| {
            let option = format!("--{}", without_unit(key).replace('_', "-"));
            !([" ", "\n"].iter()).any(|end| help.contains(&format!("{option}{end}")))
        });
        let typed: Vec<String> = typed.map(|key| format!("`{key}`")).collect();
        if !typed.is_empty() {
            assert!(help.contains("[KEY=VALUE]"), "{command}: {typed:?}");
            let keys = format!("`{command}`: {}", grouped(&typed.join(" ")));
            row(&keys, ["`KEY=VALUE`, key without unit", "same", "same"]);
        }
    }
    let on_device = ON_DEVICE.map(|key| format!("`{key}`")).join(" ");
    let no_field = "no field: it runs no device at a port";
    row(&on_device, ["same", no_field, "same"]);
    row(
        &format!("`{}`", VALIDATE.key),
        ["same", "second file", "same"],
    );
    row(&format!("`{}`", REFERENCE.key), ["same", "file", "same"]);
    for (key, python) in IN_PYTHON {
        row(
            &format!("`{key}`"),
            ["same", "same", &format!("`{python}`")],
        );
    }
    text
}

/// The text with each list of choices once; later rows name the key that has it.
fn lists_once(text: &str) -> String {
    let mut seen = BTreeMap::new();
    let lines = text.lines().map(|line| {
        let Some((row, list)) = line.split_once("<br>") else {
            return line.to_owned();
        };
        if let Some(first) = seen.get(list) {
            return format!("{row}; choices of {first}");
        }
        seen.insert(list, row.split(' ').next().unwrap_or_default());
        line.to_owned()
    });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// The page below its mark.
fn made() -> String {
    let questions = questions();
    let asked = questions.iter();
    let asked = asked.map(|(command, parameters)| Table::new(command, parameters));
    let files = ["experiment", "controller", "plant"].map(|file| {
        let tables = parameters::tables(file);
        tables
            .iter()
            .map(|(heading, keys)| Table::new(heading, keys))
            .collect::<Vec<_>>()
    });
    let [experiment, controller, plant] = files.each_ref().map(Vec::len);
    let all: Vec<Table> = files.into_iter().flatten().chain(asked).collect();
    let shared = shared(&all);
    let groups = GROUPS
        .map(|(group, keys)| format!("{group}: {keys}"))
        .join("\n\n");
    let mut text = format!(
        "\n## {}\n\nNamed groups:\n\n{groups}\n\n{HEAD}\n",
        shared.heading
    );
    for row in &shared.rows {
        let _ = writeln!(text, "{}", row.line());
    }
    let chapters = [
        (0, "Experiment files", String::new()),
        (experiment, "Controller files", CONTROLLER_FILES.to_owned()),
        (
            experiment + controller,
            "Plant files",
            PLANT_FILES.to_owned(),
        ),
        (
            experiment + controller + plant,
            "Questions",
            format!("{ASKED}{}", names(&questions)),
        ),
    ];
    for (at, table) in all.iter().enumerate() {
        if let Some((_, heading, head)) = chapters.iter().find(|chapter| chapter.0 == at) {
            let _ = write!(text, "\n## {heading}\n{head}");
        }
        table.write(&mut text, &shared, &all[..at]);
    }
    lists_once(&text)
}

const CONTROLLER_FILES: &str = "\nOne of the first five, and `[loop]`.\n";
const PLANT_FILES: &str = "\nOne of the first four. In `[device]` mass and damping are required; `[intervals]` beside it has the same\nkeys, each `[low, high]`.\n";
const ASKED: &str = "\nCommand, page and Python ask them alike, in Python as `tissue.identify_tables`, `control.identify`, `control.design`, `control.analyze`, `control.simulate`, and in\n`experiment` `zwidth`, `design`, `analyze_stability` and so on. On the page a plant is typed, or a file. Names:\n";

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
