//! A report as the metadata of a log: names and texts.

use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The values of a report by key, each key after `prefix`. A nested value has both names with `joint` between them, an absent one is `none`.
pub fn flat(report: &impl Serialize, prefix: &str, joint: &str) -> BTreeMap<String, String> {
    let mut flat = BTreeMap::new();
    // Numbers and words always become JSON.
    let value = serde_json::to_value(report).unwrap_or_default();
    add(&mut flat, prefix, joint, &value);
    flat
}

fn add(flat: &mut BTreeMap<String, String>, name: &str, joint: &str, value: &Value) {
    let text = match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let inner = if value.is_object() { joint } else { "" };
                add(flat, &format!("{name}{key}{inner}"), joint, value);
            }
            return;
        }
        Value::Null => "none".to_owned(),
        Value::String(text) => text.clone(),
        // As Rust writes it, 1 and not 1.0.
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            Some(number) => number.to_string(),
            None => number.to_string(),
        },
        Value::Bool(_) | Value::Array(_) => value.to_string(),
    };
    flat.insert(name.to_owned(), text);
}
