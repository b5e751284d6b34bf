//! A report as rows: what a report says once, for a terminal, a page or anything else that people read.
//!
//! A report is a structure whose fields are its keys. JSON has all of them, to the last digit; a row has a key in words,
//! its value in four digits with a unit, and what stands beside it: `X_reason` why there is no X, `X_from_s`, `X_to_s` and
//! `X_samples` what it is of, `X_unit` its unit.

use haptic_quantity::{WrittenUnit, in_five_digits, label, without_unit, written, written_between};
use serde::Serialize;
use serde_json::{Map, Value};

/// Keys of a report with their values, in order.
pub type Rows = Map<String, Value>;

/// The rows of these objects, one after the other.
pub fn rows(parts: impl IntoIterator<Item = Value>) -> Rows {
    let mut rows = Rows::new();
    for part in parts {
        if let Value::Object(object) = part {
            rows.extend(object);
        }
    }
    rows
}

/// A line of a report.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ReportLine {
    /// A value, or the heading of deeper lines.
    Row(Row),
    /// A list of things with the same keys.
    Table(ReportTable),
}

/// A value with its name, or the heading of the rows below it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Nesting level of the row; 0 in the report itself.
    pub level: usize,
    /// The row's key in JSON, by which a program finds it.
    pub key: String,
    /// The key in words, without the unit that the value has.
    pub label: String,
    /// The value in words; empty for a heading.
    pub value: String,
    /// The subject of the value, or the reason why it is missing; empty if that is clear.
    pub reason: String,
}

/// A list of things with the same keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportTable {
    /// Nesting level, as for a row.
    pub level: usize,
    /// The key of the list in JSON, by which a program finds it.
    pub key: String,
    /// The key in words, without the unit that the value has.
    pub label: String,
    /// Headings: the key in words, with its unit.
    pub columns: Vec<String>,
    /// A cell for each column, in words; a missing value is a dash.
    pub rows: Vec<Vec<String>>,
    /// Length of the list, which may be longer than its rows.
    pub length: usize,
}

/// A table of more rows is shown by fewer, evenly over its length.
const ROWS_MOST: usize = 24;
const ROWS_OF_MANY: usize = 12;
/// Numbers that stand in a line at most.
const NUMBERS_MOST: usize = 8;

/// Meaning of a key for another key, which has the same name without this ending.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Says {
    /// Why the value is missing, or what to think of it.
    Reason,
    /// The time of the first and of the last sample that it is of, and their number.
    From,
    To,
    Samples,
    /// Its unit, where the key cannot have it because it changes.
    Unit,
    /// The frequency at which it stands: `gain_up_rad_s` beside `gain_up`.
    Frequency,
}

/// The ends of such keys. Nothing else here reads a meaning from a name, but for its unit.
const ENDS: [(&str, Says); 6] = [
    ("_reason", Says::Reason),
    ("_from_s", Says::From),
    ("_to_s", Says::To),
    ("_samples", Says::Samples),
    ("_unit", Says::Unit),
    ("_rad_s", Says::Frequency),
];

const FILES: [&str; 11] = [
    "log",
    "logs",
    "fault_log",
    "csv",
    "figure",
    "model",
    "controller_file",
    "plant_file",
    "experiment",
    "picture",
    "files",
];

/// Texts that are a law, whose numbers JSON has to the last digit, or the file of one.
const LAWS: [&str; 3] = ["law", "largest", "controller"];

/// The lines of a report.
#[must_use]
pub fn lines(report: &impl Serialize) -> Vec<ReportLine> {
    let mut lines = Lines::default();
    // A structure of numbers and words always becomes JSON.
    if let Value::Object(report) = serde_json::to_value(report).unwrap_or_default() {
        lines.object(&report, &Map::new(), 0);
    }
    lines.0
}

#[derive(Default)]
struct Lines(Vec<ReportLine>);

impl Lines {
    fn object(&mut self, object: &Rows, around: &Rows, level: usize) {
        let all = object.iter();
        let (files, results) = all.partition::<Vec<_>, _>(|(key, value)| is_file(key, value));
        for (key, value) in results.into_iter().chain(files) {
            if !stands_beside(object, key) && !is_repeated(object, key, value) {
                self.entry(key, value, [object, around], level);
            }
        }
    }

    fn entry(&mut self, key: &str, value: &Value, places: [&Rows; 2], level: usize) {
        let reason = reason(places[0], key);
        match value {
            Value::Null if reason.is_empty() => (),
            Value::Object(inner) if is_of_alike(inner) => {
                let named = inner.iter().map(|(name, inner)| {
                    let mut row = Map::from_iter([("name".to_owned(), name.as_str().into())]);
                    row.extend(inner.as_object().cloned().into_iter().flatten());
                    Value::Object(row)
                });
                self.table(level, key, &named.collect::<Vec<_>>(), places[0]);
            }
            Value::Object(inner) if !is_short(inner) => {
                self.row(level, key, label(key), String::new(), reason);
                self.object(inner, places[0], level + 1);
            }
            Value::Array(items) if items.is_empty() && reason.is_empty() => (),
            Value::Array(items) if items.is_empty() => {
                self.row(level, key, label(key), "none".to_owned(), reason);
            }
            Value::Array(items) if items.iter().all(Value::is_object) => {
                self.table(level, key, items, places[0]);
            }
            Value::Array(items) if items.iter().any(|item| item.is_string() || item.is_array()) => {
                // The label stands before the first.
                let mut label = label(key);
                for item in items {
                    let (label, shown) = (std::mem::take(&mut label), text(key, item, None));
                    self.row(level, key, label, shown, String::new());
                }
            }
            Value::Null
            | Value::Bool(_)
            | Value::Number(_)
            | Value::String(_)
            | Value::Array(_)
            | Value::Object(_) => {
                let shown = text(key, value, unit(places, key));
                // A text has no unit of ours.
                let label = if value.is_string() && says_unit(key) {
                    key.to_owned()
                } else {
                    label(key)
                };
                self.row(level, key, label, shown, reason);
            }
        }
    }

    fn row(&mut self, level: usize, key: &str, label: String, value: String, reason: String) {
        self.0.push(ReportLine::Row(Row {
            level,
            key: key.to_owned(),
            label,
            value,
            reason,
        }));
    }

    fn table(&mut self, level: usize, key: &str, items: &[Value], object: &Rows) {
        let inner: Vec<&Rows> = items.iter().filter_map(Value::as_object).collect();
        if inner.iter().any(|object| object.values().any(is_deep)) {
            // Things with lists of their own: one after another.
            for (index, inner) in inner.into_iter().enumerate() {
                let number = (index + 1).to_string();
                self.row(level, key, label(key), number, String::new());
                self.object(inner, object, level + 1);
            }
            return;
        }
        let flat: Vec<Rows> = inner.into_iter().map(flat).collect();
        let objects: Vec<&Rows> = flat.iter().collect();
        let mut keys: Vec<&String> = Vec::new();
        for object in &objects {
            for key in object.keys() {
                if !keys.contains(&key) && !is_unit(object, key) {
                    keys.push(key);
                }
            }
        }
        // An object that would be a table in a cell is in JSON alone.
        let is_shown =
            |value: &Value| !value.is_null() && !value.as_object().is_some_and(is_of_objects);
        keys.retain(|key| (objects.iter().filter_map(|object| object.get(*key))).any(is_shown));
        let shown = if is_curve(&objects) {
            evenly(objects.len())
        } else {
            (0..objects.len()).collect()
        };
        // Beside a unit that the report says itself there are no others with a prefix.
        let places = [objects.first().copied().unwrap_or(object), object];
        let has_own = keys.iter().any(|key| unit(places, key).is_some());
        let columns: Vec<Column> = (keys.iter())
            .map(|key| Column::new(key, &objects, object, has_own))
            .collect();
        self.0.push(ReportLine::Table(ReportTable {
            level,
            key: key.to_owned(),
            label: label(key),
            columns: columns.iter().map(Column::heading).collect(),
            rows: (shown.into_iter().map(|index| objects[index]))
                .map(|object| columns.iter().map(|column| column.cell(object)).collect())
                .collect(),
            length: objects.len(),
        }));
    }
}

/// True of a sampled curve, numbers alone and not all whole: only such a list is thinned, of things every one is shown.
fn is_curve(objects: &[&Rows]) -> bool {
    let is_number = |value: &Value| value.is_number() || value.is_null();
    let all = || objects.iter().flat_map(|object| object.values());
    all().all(is_number) && all().any(Value::is_f64)
}

/// True of what has no place in a cell: a list of objects, or an object that has objects.
fn is_deep(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().any(Value::is_object),
        // An object that would be a table in a cell is in JSON alone.
        Value::Object(inner) if is_of_objects(inner) => false,
        Value::Object(inner) => inner
            .values()
            .any(|value| value.is_object() || value.is_string()),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    }
}

/// An object with the numbers of its inner ones beside its own: `p50` of `lateness_us` is `lateness_p50_us`.
fn flat(object: &Rows) -> Rows {
    let mut flat = Map::new();
    for (key, value) in object {
        let inner = value.as_object().filter(|inner| !is_of_objects(inner));
        let Some(inner) = inner else {
            flat.insert(key.clone(), value.clone());
            continue;
        };
        let stem = without_unit(key);
        for (name, value) in inner {
            let unit = if says_unit(name) {
                ""
            } else {
                &key[stem.len()..]
            };
            flat.insert(format!("{stem}_{name}{unit}"), value.clone());
        }
    }
    flat
}

/// A column of a table.
struct Column<'a> {
    key: &'a str,
    own_unit: Option<&'a str>,
    unit: WrittenUnit,
}

impl<'a> Column<'a> {
    fn new(key: &'a str, objects: &[&'a Rows], around: &'a Rows, is_plain: bool) -> Self {
        let first = objects.first().copied().unwrap_or(around);
        let sizes = objects
            .iter()
            .filter_map(|object| object.get(key)?.as_f64());
        let largest = sizes
            .map(f64::abs)
            .filter(|size| size.is_finite())
            .fold(0.0, f64::max);
        Self {
            key,
            own_unit: unit([first, around], key),
            unit: WrittenUnit::of_key(key, if is_plain { 0.0 } else { largest }),
        }
    }

    fn heading(&self) -> String {
        match self.own_unit.unwrap_or(&self.unit.symbol) {
            "" => label(self.key),
            unit => format!("{} / {unit}", label(self.key)),
        }
    }

    fn cell(&self, object: &Rows) -> String {
        match object.get(self.key) {
            None | Some(Value::Null) => "–".to_owned(),
            Some(Value::Number(number)) if !is_count(self.key, number) => {
                self.unit.number(number.as_f64().unwrap_or(f64::NAN))
            }
            Some(value) => text(self.key, value, Some("")),
        }
    }
}

/// A value in words; `own` is a unit that the key does not say.
fn text(key: &str, value: &Value, unit_beside: Option<&str>) -> String {
    match (value, unit_beside) {
        (Value::Null, _) => "–".to_owned(),
        (Value::Bool(true), _) => "yes".to_owned(),
        (Value::Bool(false), _) => "no".to_owned(),
        (Value::String(text), _) if LAWS.contains(&key) && !text.ends_with(".toml") => {
            in_five_digits(text)
        }
        (Value::String(text), _) => text.clone(),
        (Value::Number(number), _) if is_count(key, number) => number.to_string(),
        (Value::Number(number), None) => written(key, number.as_f64().unwrap_or(f64::NAN)),
        (Value::Number(number), Some(unit)) => {
            let plain = WrittenUnit::of_key(key, 0.0);
            let number = plain.number(number.as_f64().unwrap_or(f64::NAN));
            format!("{number} {unit}").trim_end().to_owned()
        }
        (Value::Array(items), _) if items.len() > NUMBERS_MOST => format!("{} values", items.len()),
        (Value::Array(items), _) => {
            let items = items.iter().map(|item| text(key, item, unit_beside));
            items.collect::<Vec<_>>().join(", ")
        }
        (Value::Object(inner), None) if interval(inner).is_some() => {
            let [value, low, high] = written_between(key, interval(inner).unwrap_or_default());
            format!("{value}, low {low}, high {high}")
        }
        (Value::Object(inner), _) => {
            // "p50" of `tick_ns` is in ns.
            let key_of = |name| if says_unit(name) { name } else { key };
            let items = inner.iter().filter(|(_, value)| !value.is_null());
            // A column's unit is that of its own numbers.
            let unit_beside = |name: &str| unit_beside.filter(|_| !says_unit(name));
            let items = items.map(|(name, value)| {
                format!(
                    "{} {}",
                    label(name),
                    text(key_of(name), value, unit_beside(name))
                )
            });
            items.collect::<Vec<_>>().join(", ")
        }
    }
}

/// A value and its interval, if this is one.
fn interval(object: &Rows) -> Option<[f64; 3]> {
    let number = |key: &str| object.get(key)?.as_f64();
    Some([number("value")?, number("low")?, number("high")?])
}

/// True of a whole number whose key says no unit.
fn is_count(key: &str, number: &serde_json::Number) -> bool {
    (number.is_u64() || number.is_i64()) && !says_unit(key)
}

fn says_unit(key: &str) -> bool {
    without_unit(key) != key
}

/// True of a file. The model of a device is a file, that of a tissue is not.
fn is_file(key: &str, value: &Value) -> bool {
    let names_model = key == "model" && !value.as_str().is_some_and(|name| name.ends_with(".toml"));
    FILES.contains(&key) && !names_model
}

/// True of a few numbers that stand in one line.
fn is_short(object: &Rows) -> bool {
    object.len() <= 3
        && object
            .values()
            .all(|value| value.is_number() || value.is_null())
}

/// True of several things with the same keys, each by its name: a table.
fn is_of_alike(object: &Rows) -> bool {
    let mut keys = object.values().map(|value| {
        let keys = value
            .as_object()
            .filter(|inner| !inner.values().any(|v| v.is_object() || v.is_array()));
        keys.map(|inner| inner.keys().collect::<Vec<_>>())
    });
    let first = keys.next().flatten();
    object.len() > 1 && first.is_some_and(|first| keys.all(|keys| keys.as_ref() == Some(&first)))
}

fn is_of_objects(object: &Rows) -> bool {
    !object.is_empty() && object.values().all(Value::is_object)
}

/// True of a key that says something of another one of the object, with or without its unit, so that it has no row of its own.
fn stands_beside(object: &Rows, key: &str) -> bool {
    let has = |stem: &str| (object.keys()).any(|key| key == stem || without_unit(key) == stem);
    let is_of = |stem: &str, says| match says {
        Says::Reason | Says::From | Says::To => has(stem),
        Says::Samples => companion(object, stem, Says::From).is_some(),
        // It may be the unit of a column in a table below.
        Says::Unit => true,
        Says::Frequency => object.contains_key(stem),
    };
    let mut ends = ENDS.iter();
    ends.any(|(end, says)| (key.strip_suffix(end)).is_some_and(|stem| is_of(stem, *says)))
}

/// True of the unit of a column.
fn is_unit(object: &Rows, key: &str) -> bool {
    let stem = key.strip_suffix("_unit");
    stem.is_some_and(|stem| (object.keys()).any(|key| key == stem || without_unit(key) == stem))
}

/// The key that says this of a key, and its value; null is a value too.
fn companion<'o>(object: &'o Rows, key: &str, says: Says) -> Option<(String, &'o Value)> {
    let (end, _) = ENDS.iter().find(|end| end.1 == says)?;
    let name = format!("{key}{end}");
    object.get(&name).map(|value| (name, value))
}

/// True of a list of one thing that stands alone as well: `logs` beside `log`.
fn is_repeated(object: &Rows, key: &str, value: &Value) -> bool {
    let single = key.strip_suffix('s').and_then(|key| object.get(key));
    let mut pair = single.zip(value.as_array()).into_iter();
    pair.any(|(single, list)| list.len() == 1 && list[0] == *single)
}

/// The reason for a missing value, or the subject of a value, from the keys beside it.
fn reason(object: &Rows, key: &str) -> String {
    let value_beside = |says| {
        let mut found = [key, without_unit(key)].into_iter();
        let (_, value) = found.find_map(|stem| companion(object, stem, says))?;
        Some(value).filter(|value| !value.is_null())
    };
    if let Some(Value::String(reason)) = value_beside(Says::Reason) {
        return reason.clone();
    }
    let frequency = companion(object, key, Says::Frequency).filter(|(_, at)| !at.is_null());
    let frequency = frequency.map(|(name, at)| format!("at {}", text(&name, at, None)));
    let mut parts = Vec::from_iter(frequency);
    if let (Some(from), Some(to)) = (value_beside(Says::From), value_beside(Says::To)) {
        let [from, to] = [("from_s", from), ("to_s", to)].map(|(key, at)| text(key, at, None));
        parts.push(format!("from {from} to {to}"));
        parts.extend(value_beside(Says::Samples).map(|samples| format!("{samples} samples")));
    }
    parts.join(", ")
}

/// The unit that a report says beside a key, in the object or in the one around it.
fn unit<'o>(objects: [&'o Rows; 2], key: &str) -> Option<&'o str> {
    let mut units = objects.into_iter();
    units.find_map(|object| companion(object, key, Says::Unit)?.1.as_str())
}

/// Places of a list that are shown: all of a short one, the first and the last and evenly between of a long one.
fn evenly(length: usize) -> Vec<usize> {
    match length {
        0..=ROWS_MOST => (0..length).collect(),
        _ => (0..ROWS_OF_MANY)
            .map(|index| index * (length - 1) / (ROWS_OF_MANY - 1))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn lines_of(report: &Value) -> Vec<String> {
        let say = |line: ReportLine| match line {
            ReportLine::Row(row) => {
                format!("{}|{}|{}|{}", row.level, row.label, row.value, row.reason)
            }
            ReportLine::Table(table) => {
                let rows: Vec<String> = table.rows.iter().map(|row| row.join(",")).collect();
                format!(
                    "{}: {}: {}",
                    table.label,
                    table.columns.join(","),
                    rows.join(";")
                )
            }
        };
        lines(report).into_iter().map(say).collect()
    }

    #[test]
    fn a_report_is_rows_in_its_order_and_its_files_come_last() {
        let report = json!({
            "tissue": null,
            "model": "device.toml",
            "log": "a.mcap",
            "logs": ["a.mcap"],
            "sample_time_s": 0.001,
            "samples": 10001,
            "passive": true,
            "max_error": 3.2e-7,
            "max_error_from_s": 0.01,
            "max_error_to_s": 10.0,
            "max_error_samples": 9991,
            "max_error_reason": null,
            "closed_form": null,
            "closed_form_reason": "the run ended before",
            "tick_ns": { "p50": 711, "max": 2_000_000 },
            "foreign_topics": { "/grip_force_n": 5, "/joint_states": 7 },
            "notes": ["one", "two"],
            "preflight": { "stable": true, "delay_s": 0.002, "alpha": 0.5, "beta": null },
        });
        assert_eq!(
            lines_of(&report),
            [
                "0|sample time|1 ms|",
                "0|samples|10001|",
                "0|passive|yes|",
                "0|max error|3.2e-7|from 10 ms to 10 s, 9991 samples",
                "0|closed form|–|the run ended before",
                "0|tick|p50 711 ns, max 2 ms|",
                "0|foreign topics|/grip_force_n 5, /joint_states 7|",
                "0|notes|one|",
                "0||two|",
                "0|preflight||",
                "1|stable|yes|",
                "1|delay|2 ms|",
                "1|alpha|0.5|",
                "0|model|device.toml|",
                "0|log|a.mcap|",
            ]
        );
    }

    #[test]
    fn a_law_has_five_digits_to_its_numbers() {
        let law = "12.3456789s^0.25+7";
        for (report, shown) in [
            (json!({"controller": {"largest": law}}), "12.346s^0.25+7"),
            (json!({"controller": law}), "12.346s^0.25+7"),
            (json!({"controller": "20261128.toml"}), "20261128.toml"),
        ] {
            let found = lines(&report).pop();
            assert!(matches!(found, Some(ReportLine::Row(row)) if row.value == shown));
        }
    }

    #[test]
    fn a_value_stands_with_its_frequency_and_a_cell_keeps_its_units() {
        let report = json!({
            "peak": 1.25, "peak_rad_s": 5.0, "gain_up": null, "gain_up_rad_s": null, "crossover_rad_s": 3.0,
        });
        let lines = ["0|peak|1.25|at 5 rad/s", "0|crossover|3 rad/s|"];
        assert_eq!(lines_of(&report), lines);
        let steps = json!({ "steps": [{ "shape": { "overshoot": 0.25, "rise_time_s": 0.5 } }] });
        assert_eq!(
            lines_of(&steps),
            ["steps: shape overshoot,shape rise time / ms: 0.25,500"]
        );
    }

    #[test]
    fn things_with_names_are_a_table_and_a_matrix_is_a_row_a_line() {
        let parameters = json!({
            "order": { "value": 0.5, "unit": "1" },
            "modulus": { "value": 2000.0, "unit": "Pa" },
        });
        let report = json!({
            "parameters": parameters,
            "candidates": [{ "model": "zener", "parameters": parameters }],
            "correlation": [[1.0, 0.5], [0.5, null]],
        });
        let lines = [
            "parameters: name,value,unit: order,0.5,1;modulus,2000,Pa",
            "candidates: model: zener",
            "0|correlation|1, 0.5|",
            "0||0.5, –|",
        ];
        assert_eq!(lines_of(&report), lines);
    }

    #[test]
    fn an_interval_is_told_apart_and_of_many_things_none_is_left_out() {
        let report =
            json!({ "mass_kg": { "value": 0.065, "low": 0.064_997_21, "high": 0.065_003_75 } });
        assert_eq!(
            lines_of(&report),
            ["0|mass|65 g, low 64.99721 g, high 65.00375 g|"]
        );
        let events: Vec<Value> = (0..30)
            .map(|n| json!({ "tick": n, "kind": "phase" }))
            .collect();
        let [ReportLine::Table(table)] = &lines(&json!({ "events": events }))[..] else {
            panic!("no table")
        };
        assert_eq!(table.rows.len(), 30);
        let none = json!({ "poles": [], "poles_reason": "it creeps" });
        assert_eq!(lines_of(&none), ["0|poles|none|it creeps"]);
    }

    #[test]
    fn things_with_the_same_keys_are_a_table_with_one_unit_a_column() {
        let report = json!({
            "dissipation_unit": "N·s/m",
            "walls": [
                { "order": 0.5, "stiffness_n_per_m": null, "dissipation": 3.0, "why": null },
                { "order": 1.0, "stiffness_n_per_m": 12_000.0, "dissipation": 4.0, "why": null },
            ],
        });
        let table = "walls: order,stiffness / N/m,dissipation / N·s/m: 0.5,–,3;1,12000,4";
        assert_eq!(lines_of(&report), [table]);
        let long: Vec<Value> = (0..100)
            .map(|place| json!({ "place": f64::from(place) }))
            .collect();
        let [ReportLine::Table(table)] = &lines(&json!({ "points": long }))[..] else {
            panic!("no table")
        };
        assert_eq!((table.length, table.rows.len()), (100, ROWS_OF_MANY));
        assert_eq!(
            (&table.rows[0][0][..], &table.rows[ROWS_OF_MANY - 1][0][..]),
            ("0", "99")
        );
    }
}
