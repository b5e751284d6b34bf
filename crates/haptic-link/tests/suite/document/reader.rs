//! The document as it is read: tables of fields, and what they say of bytes and values.

use serde_json::Value;
use std::{collections::BTreeMap, path::Path};

/// Offset of a field that begins where the one before ends.
const FOLLOWS: usize = usize::MAX;

/// A row of a table of fields.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) offset: usize,
    pub(super) kind: String,
    pub(super) name: String,
}

/// A section `### Structure …, LENGTH` with its table, or a message of a table.
#[derive(Debug)]
pub(super) struct Section {
    pub(super) length: String,
    pub(super) rows: Vec<Row>,
}

fn row(offset: usize, kind: &str, name: &str) -> Row {
    let (kind, name) = (kind.to_owned(), name.to_owned());
    Row { offset, kind, name }
}

/// Sections of messages that share a table, which ends with bytes, fields and a meaning.
fn listed(text: &str, kind: &str, first: &Row) -> BTreeMap<String, Section> {
    let (_, table) = text
        .split_once(&format!("\n## {kind}s\n"))
        .expect("a table");
    let table = table.split("\n## ").next().unwrap_or(table);
    let lines = table.lines().filter(|line| line.starts_with("| ")).skip(1);
    let sections = lines.map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [number, name, .., bytes, fields, _] = cells[..] else {
            panic!("not a row of messages: {line}");
        };
        let mut rows = vec![first.clone()];
        for field in fields.split(", ").filter(|field| !field.is_empty()) {
            let (name, kind) = field.split_once(": ").expect("a name and a type");
            rows.push(row(FOLLOWS, kind, name));
        }
        let length = format!("{bytes} bytes");
        (format!("{kind} {number}, {name}"), Section { length, rows })
    });
    sections.collect()
}

/// The document, taken apart.
pub(super) struct Document {
    pub(super) text: String,
    /// Sections by heading up to the last comma, as "Request 9, start".
    pub(super) sections: BTreeMap<String, Section>,
    /// Enumerations by name, each number with its name.
    pub(super) enumerations: BTreeMap<String, BTreeMap<u8, String>>,
}

impl Document {
    pub(super) fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("protocol.md");
        let text = std::fs::read_to_string(path).expect("the document is there");
        let (mut sections, mut enumerations) = (BTreeMap::new(), BTreeMap::new());
        for part in text.split("\n### ").skip(1) {
            let part = part.split("\n## ").next().unwrap_or(part);
            let (heading, body) = part.split_once('\n').expect("a heading ends");
            let cells = body.lines().filter(|line| line.starts_with("| "));
            let cells = cells.map(|line| line.split(" | ").map(cell).collect::<Vec<_>>());
            let cells: Vec<Vec<String>> = cells.skip(1).collect();
            if let Some(name) = heading.strip_prefix("Enumeration ") {
                let names = cells.iter().map(|row| (number(&row[0]), row[1].clone()));
                enumerations.insert(name.to_owned(), names.collect());
            } else {
                let (name, length) = heading.rsplit_once(", ").expect("a length");
                let rows = cells.iter().map(|row| Row {
                    offset: number(&row[0]),
                    kind: row[1].clone(),
                    name: row[2].clone(),
                });
                let section = Section {
                    length: length.to_owned(),
                    rows: rows.collect(),
                };
                sections.insert(name.to_owned(), section);
            }
        }
        sections.extend(listed(&text, "Request", &row(0, "u8", "number")));
        sections.extend(listed(&text, "Report", &row(0, "u8", "number")));
        sections.extend(listed(&text, "Refusal", &row(5, "Refusal", "refusal")));
        Self {
            text,
            sections,
            enumerations,
        }
    }

    pub(super) fn section(&self, name: &str) -> &Section {
        let section = self.sections.get(name);
        section.unwrap_or_else(|| panic!("no section \"{name}\""))
    }

    /// Length of one value of this type.
    pub(super) fn size(&self, kind: &str) -> usize {
        // Of what may be missing: if it is there.
        let kind = kind.strip_suffix(" × n").unwrap_or(kind);
        let basic = [
            ("u8", 1),
            ("i8", 1),
            ("bool", 1),
            ("u16", 2),
            ("u32", 4),
            ("u64", 8),
            ("f32", 4),
        ];
        if let Some((_, size)) = basic.iter().find(|(name, _)| *name == kind) {
            return *size;
        }
        if let Some((element, count)) = kind.strip_suffix(']').and_then(|k| k.split_once('[')) {
            return self.size(element) * number::<usize>(count);
        }
        if self.enumerations.contains_key(kind) || kind == "Refusal" {
            return 1;
        }
        let rows = &self.section(&format!("Structure {kind}")).rows;
        let last = rows.last().expect("a structure has fields");
        last.offset + self.size(&last.kind)
    }

    /// Rows with structures resolved, for a message of these bytes; checks that they lie end to end.
    pub(super) fn resolve(&self, rows: &[Row], bytes: &[u8]) -> Vec<Row> {
        let mut resolved: Vec<Row> = Vec::new();
        for row in rows {
            let at = resolved
                .last()
                .map_or(row.offset, |r| r.offset + self.size(&r.kind));
            let row = match row.offset {
                FOLLOWS => &Row {
                    offset: at,
                    ..row.clone()
                },
                _ => row,
            };
            assert_eq!(row.offset, at, "{row:?} begins where the one before ends");
            let (kind, count) = match row.kind.strip_suffix(" × n") {
                Some(kind) => (kind, usize::from(bytes[row.offset - 1])),
                None => (row.kind.as_str(), 1),
            };
            let name = format!("Structure {kind}");
            if kind == "f32" && kind != row.kind {
                resolved.push(Row {
                    kind: format!("f32[{count}]"),
                    ..row.clone()
                });
                continue;
            }
            if !self.sections.contains_key(&name) {
                resolved.push(row.clone());
                continue;
            }
            let (inner, size) = (&self.section(&name).rows, self.size(kind));
            for n in 0..count {
                let at = |field: &Row| row.offset + n * size + field.offset;
                let is_present =
                    |field: &&Row| !field.kind.ends_with(" × n") || bytes[at(field) - 1] > 0;
                resolved.extend(inner.iter().filter(is_present).map(|field| Row {
                    offset: at(field),
                    kind: field.kind.replace(" × n", ""),
                    name: match row.name.as_str() {
                        "–" => field.name.clone(),
                        // A structure around one value has no name for it.
                        outer if kind == "key" => format!("{outer}.{n}"),
                        outer if count == 1 && kind == row.kind => {
                            format!("{outer}.{}", field.name)
                        }
                        outer => format!("{outer}.{n}.{}", field.name),
                    },
                }));
            }
        }
        resolved
    }

    /// True if the bytes at this row are the value.
    pub(super) fn holds(&self, row: &Row, bytes: &[u8], value: &Value) -> bool {
        let bytes = &bytes[row.offset..row.offset + self.size(&row.kind)];
        let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
        match (row.kind.as_str(), value) {
            ("u8", Value::Number(n)) => n.as_u64() == Some(u64::from(bytes[0])),
            ("i8", Value::Number(n)) => n.as_i64() == Some(i64::from(bytes[0].cast_signed())),
            ("bool", Value::Bool(b)) => bytes[0] == u8::from(*b),
            ("f32", Value::Number(n)) => {
                n.as_f64().map(|n| (n as f32).to_bits()) == Some(float(bytes).to_bits())
            }
            (kind, Value::Array(list)) if kind.starts_with("f32[") => list
                .iter()
                .zip(bytes.chunks(4))
                .all(|(n, b)| n.as_f64().map(|n| (n as f32).to_bits()) == Some(float(b).to_bits())),
            // Integers of fixed length are little-endian bytes to serde.
            (_, Value::Array(list)) => {
                let list = list.iter().map(Value::as_u64);
                list.eq(bytes.iter().map(|&b| Some(u64::from(b))))
            }
            (kind, Value::String(name)) => {
                let names = self.enumerations.get(kind);
                names.is_some_and(|names| names.get(&bytes[0]) == Some(name))
            }
            _ => false,
        }
    }

    /// Compares the table with the message, and returns the stated length.
    pub(super) fn compare(
        &self,
        heading: &str,
        bytes: &[u8],
        fields: &BTreeMap<String, Value>,
    ) -> String {
        let section = self.section(heading);
        let rows = self.resolve(&section.rows, bytes);
        let last = rows.last().expect("a number at least");
        assert_eq!(
            last.offset + self.size(&last.kind),
            bytes.len(),
            "{heading}"
        );
        let rows = &rows[1..];
        assert_eq!(rows.len(), fields.len(), "{heading}: {rows:#?} {fields:#?}");
        for row in rows {
            let value = fields.get(&row.name);
            let value = value.unwrap_or_else(|| panic!("{heading} has no {}", row.name));
            let holds = self.holds(row, bytes, value);
            assert!(holds, "{heading}: {row:?} is not {value}");
        }
        section.length.clone()
    }
}

pub(super) fn cell(text: &str) -> String {
    text.trim_matches(['|', ' ']).to_owned()
}

pub(super) fn number<T: std::str::FromStr>(text: &str) -> T {
    let parsed = text.parse().ok();
    parsed.unwrap_or_else(|| panic!("\"{text}\" is no number"))
}

/// Every field of a message by its name.
pub(super) fn fields(name: &str, value: &Value, found: &mut BTreeMap<String, Value>) {
    let inner = |key: &str| match name {
        "" => key.to_owned(),
        name => format!("{name}.{key}"),
    };
    if let Value::Object(object) = value {
        for (key, value) in object {
            fields(&inner(key), value, found);
        }
    } else if let Value::Array(list) = value
        && list.iter().any(|item| item.is_object() || item.is_array())
    {
        found.insert(inner("count"), list.len().into());
        for (n, item) in list.iter().enumerate() {
            fields(&inner(&n.to_string()), item, found);
        }
    } else {
        found.insert(name.to_owned(), value.clone());
    }
}

/// Name and content of a variant.
pub(super) fn variant(value: &Value) -> (&str, &Value) {
    if let Value::String(name) = value {
        return (name, &Value::Null);
    }
    let object = value.as_object().filter(|object| object.len() == 1);
    let variant = object.and_then(|object| object.iter().next());
    let (name, content) = variant.unwrap_or_else(|| panic!("{value} is no variant"));
    (name, content)
}

/// A name as the document writes those of messages.
pub(super) fn kebab(name: &str) -> String {
    let mut kebab = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !kebab.is_empty() {
            kebab.push('-');
        }
        kebab.extend(letter.to_lowercase());
    }
    kebab
}
