//! A document: the text of a file, and values given over it by options, keywords or the fields of a form.

use crate::{
    error::{FileError, Source},
    parameters::Parameter,
    reader::{Part, Table, in_order},
};
use haptic_quantity::{parse_for_key, short};
use std::{
    collections::BTreeMap,
    fmt::Display,
    path::{Path, PathBuf},
};
use toml::{
    Value,
    de::{DeTable, DeValue},
};

/// Source text of an experiment or a question. Values given separately override the file.
///
/// ```
/// use haptic_document::{Document, parameters as p};
/// use std::path::Path;
///
/// let mut document = Document::of_text(Path::new("lab/hand.toml"), "[wall]\nmass_kg = 0.1");
/// document.set("wall", "mass_kg", 650.0, "--mass 650")?;
/// let parsed = document.parse()?;
/// let (_, wall, _) = parsed.one_of(&["wall"], &[], "experiment", "a file has [wall]")?;
/// assert_eq!(
///     wall.number(&p::MASS).expect_err("a weight in grams").to_string(),
///     "--mass 650: mass_kg = 650 is not above 0 and at most 100: change it, or omit it for 0.065"
/// );
/// # Ok::<(), haptic_document::FileError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Document {
    path: PathBuf,
    text: String,
    given: Vec<Given>,
    /// Metadata that the log of a run has about it, with the texts of the files that the document names.
    logged: BTreeMap<String, String>,
    /// Given values as TOML, and for each of its lines the words in which the value was given.
    over: (String, Vec<String>),
}

#[derive(Clone, Debug)]
struct Given {
    table: String,
    key: String,
    value: Value,
    wording: String,
}

/// Group and name of the document in the log of its run.
pub const IN_LOG: (&str, &str) = ("experiment", "document");
impl Document {
    /// A document without a file: a table of this name, to which values are given.
    #[must_use]
    pub fn new(table: &str) -> Self {
        let text = format!("[{table}]");
        Self {
            text,
            ..Self::default()
        }
    }

    /// The text of a file; `path` is for messages and for the paths in it.
    #[must_use]
    pub fn of_text(path: &Path, text: &str) -> Self {
        Self {
            path: path.to_owned(),
            text: text.to_owned(),
            ..Self::default()
        }
    }

    /// A document of the log of a run, with the metadata that the log has about it, such as the texts of files that it names.
    #[must_use]
    pub fn of_log(path: &Path, text: &str, logged: BTreeMap<String, String>) -> Self {
        Self {
            logged,
            ..Self::of_text(path, text)
        }
    }

    /// Metadata of the log that it was read from; empty for a file.
    #[must_use]
    pub const fn logged(&self) -> &BTreeMap<String, String> {
        &self.logged
    }

    /// Itself without what a log has of its files, which are then read anew.
    #[must_use]
    pub fn without_log(mut self) -> Self {
        self.logged.clear();
        self
    }

    /// Path of the file, for messages.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text of the file, without what was given over it.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Gives a value, which overrides the file; `said` is how the user wrote it, as in `--strain
    /// 3%`.
    ///
    /// # Errors
    /// A value that was given before.
    pub fn set(
        &mut self,
        table: &str,
        key: &str,
        value: impl Into<Value>,
        wording: &str,
    ) -> Result<(), FileError> {
        // A message is one line.
        let wording: String = wording
            .chars()
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        let before = self
            .given
            .iter()
            .find(|given| (given.table.as_str(), given.key.as_str()) == (table, key));
        if let Some(before) = before {
            let reason = format!(
                "{key} is given twice, also as {}: omit one of them",
                before.wording
            );
            return Err(FileError::wording(&wording, reason));
        }
        self.given.push(Given {
            table: table.to_owned(),
            key: key.to_owned(),
            value: value.into(),
            wording,
        });
        self.over = self.written();
        Ok(())
    }

    /// Itself with the values of another document over it.
    ///
    /// # Errors
    /// A value that both have.
    pub fn with(&self, other: &Self) -> Result<Self, FileError> {
        let mut both = self.clone();
        for given in &other.given {
            let Given {
                table, key, value, ..
            } = given;
            both.set(table, key, value.clone(), &given.wording)?;
        }
        Ok(both)
    }

    /// Given values as TOML, and for each of its lines the words in which the value was given.
    fn written(&self) -> (String, Vec<String>) {
        let (mut text, mut wording) = (String::new(), Vec::new());
        let mut given: Vec<&Given> = self.given.iter().collect();
        given.sort_by_key(|given| &given.table);
        for given in given.chunk_by(|a, b| a.table == b.table) {
            text += &format!("[{}]\n", given[0].table);
            wording.push(String::new());
            for Given {
                key,
                value,
                wording: text_of_user,
                ..
            } in given
            {
                // Quotes what is no bare key.
                let line = toml::Table::from_iter([(key.clone(), value.clone())]).to_string();
                wording.extend(line.lines().map(|_| text_of_user.clone()));
                text += &line;
            }
        }
        (text, wording)
    }

    /// Keys of the values that were given.
    pub fn given(&self) -> impl Iterator<Item = &str> {
        self.given.iter().map(|given| given.key.as_str())
    }

    /// The layers of the document as TOML, what was given above the file.
    ///
    /// # Errors
    /// A text that is not TOML, with the place.
    pub fn parse(&self) -> Result<Parsed<'_>, FileError> {
        let given = Source {
            path: Path::new(""),
            text: &self.over.0,
            wording: &self.over.1,
            logged: None,
        };
        let mut parsed = Parsed::of(&self.path, &self.text)?;
        let sources = parsed.layers.iter_mut().map(|layer| &mut layer.source);
        sources.for_each(|source| source.logged = Some(&self.logged));
        parsed.layers.insert(0, Layer::of(given)?);
        Ok(parsed)
    }
}

/// Lines of a file for numbers: `{:?}` is the shortest text that reads back to the same bits.
pub fn lines_of(numbers: impl IntoIterator<Item = (Parameter, f64)>) -> String {
    let lines = numbers.into_iter();
    lines
        .map(|(parameter, value)| format!("{} = {value:?}\n", parameter.key))
        .collect()
}

/// The names of tables of which a file has one, in words.
pub fn choice(kinds: &[&str]) -> String {
    let names: Vec<String> = kinds.iter().map(|kind| format!("[{kind}]")).collect();
    format!("an experiment file has one of {}", names.join(", "))
}

/// Advice for `mass_kg = 65g`, in whose line this character is: the unit is in the key.
fn with_unit(text: &str, at: usize) -> Option<String> {
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    let (key, value) = text[start..].lines().next()?.split_once('=')?;
    let number = parse_for_key(key.trim(), value).ok()?;
    Some(format!("the unit is in the key: write {key}= {number}"))
}

#[derive(Debug)]
struct Layer<'a> {
    source: Source<'a>,
    root: DeTable<'a>,
}

impl<'a> Layer<'a> {
    fn of(source: Source<'a>) -> Result<Self, FileError> {
        let text = source.text;
        let root = DeTable::parse(text).map_err(|error| {
            let span = error.span().unwrap_or_default();
            // One line; TOML's own message may have several.
            let lines: Vec<&str> = error.message().lines().collect();
            let reason = match (lines.as_slice(), text.get(span.clone())) {
                (["duplicate key"], Some(key)) => {
                    format!("duplicate key `{}`: omit all but one of them", short(key))
                }
                _ if text[span.start..].starts_with(',')
                    && text[..span.start].ends_with(|before: char| before.is_ascii_digit()) =>
                {
                    "decimals have a point, not a comma".to_owned()
                }
                _ if text[span.start..].starts_with(['“', '”', '„', '‘', '’', '«', '»']) => {
                    "a text stands between straight quotes, as in \"liver\"".to_owned()
                }
                _ => with_unit(text, span.start).unwrap_or_else(|| lines.join("; ")),
            };
            source.fail(span.start, reason).of_file(String::new())
        })?;
        Ok(Self {
            source,
            root: root.into_inner(),
        })
    }
}

/// A document whose TOML is read: its layers, the top one first.
#[derive(Debug)]
pub struct Parsed<'a> {
    layers: Vec<Layer<'a>>,
}

impl<'a> Parsed<'a> {
    /// The text of a file alone.
    ///
    /// # Errors
    /// As for [`Document::parse`].
    pub fn of(path: &'a Path, text: &'a str) -> Result<Self, FileError> {
        let layer = Layer::of(Source {
            path,
            text,
            wording: &[],
            logged: None,
        })?;
        Ok(Self {
            layers: vec![layer],
        })
    }

    /// True if one of its layers has this table.
    pub fn has(&self, table: &str) -> bool {
        let mut layers = self.layers.iter();
        layers.any(|layer| layer.root.contains_key(table))
    }

    /// The one table that is of one of these kinds, and those beside it by name; `what` and `choice` say in words what such a file has.
    ///
    /// # Errors
    /// No table of these kinds or two of them, or one that is neither a kind nor a companion.
    pub fn one_of<'k>(
        &'a self,
        kinds: &[&'k str],
        companions: &[&'k str],
        what: &str,
        choice: &str,
    ) -> Result<(&'k str, Table<'a>, BTreeMap<&'k str, Table<'a>>), FileError> {
        let (mut found, mut others) = (None, BTreeMap::new());
        for (name, table) in self.tables(&[kinds, companions].concat(), choice)? {
            if companions.contains(&name) {
                others.insert(name, table);
            } else if found.is_some() {
                return Err(table.fail(format!("a second {what} [{name}]: {choice}")));
            } else {
                found = Some((name, table));
            }
        }
        let (name, table) = found.ok_or_else(|| self.fail(format!("no {what}: {choice}")))?;
        Ok((name, table, others))
    }

    /// All tables in the order of the file, each of one of these names; `choice` says in words what such a file has.
    ///
    /// # Errors
    /// A table of another name, or a key outside of tables.
    pub fn tables<'k>(
        &'a self,
        names: &[&'k str],
        choice: &str,
    ) -> Result<Vec<(&'k str, Table<'a>)>, FileError> {
        let mut tables: Vec<(&'k str, Table<'a>)> = Vec::new();
        for Layer { source, root } in self.layers.iter().rev() {
            for (key, value) in in_order(root) {
                let (name, offset) = (key.get_ref().as_ref(), key.span().start);
                let known = names.iter().find(|known| **known == name);
                let (known, entries) = match (known, value.get_ref()) {
                    (Some(known), DeValue::Table(entries)) => (*known, entries),
                    (known, value) => {
                        let shown = short(name);
                        let reason = match (known, value) {
                            (Some(_), _) => format!("`{name}` is not a table: write [{name}]"),
                            (None, DeValue::Table(_)) => {
                                format!("unknown table [{shown}]: {choice}")
                            }
                            _ => format!("unknown key `{shown}` outside of any table: {choice}"),
                        };
                        return Err(source.fail(offset, reason).of_file(String::new()));
                    }
                };
                let part = Part::new(*source, offset, entries);
                match tables.iter_mut().find(|(table, _)| *table == known) {
                    Some((_, table)) => table.parts.insert(0, part),
                    None => {
                        let parts = vec![part];
                        tables.push((
                            known,
                            Table {
                                name,
                                parts,
                                intervals: Vec::new(),
                            },
                        ));
                    }
                }
            }
        }
        Ok(tables)
    }

    /// An error that concerns the file as a whole.
    pub fn fail(&self, reason: impl Display) -> FileError {
        match self.layers.last() {
            Some(file) => file.source.fail_from(0, reason),
            None => FileError::wording("", reason),
        }
    }
}

/// Reader of the document at a path: a file, or what a log has of it.
pub type ReadDocument = fn(&Path) -> Result<Document, FileError>;
