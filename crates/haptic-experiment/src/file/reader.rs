//! A table of a TOML file, read key by key, so that every refusal names its line.

use super::error::{FileError, Source};
use crate::input::short;
use crate::named::Named;
use crate::parameters::{Parameter, Value};
use fracdiff::parameter::Shown;
use std::path::PathBuf;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// One table of a file, with the keys it may have.
#[derive(Debug)]
pub(crate) struct Table<'a> {
    pub(super) source: Source<'a>,
    pub(super) name: &'a str,
    pub(super) offset: usize,
    pub(super) entries: &'a DeTable<'a>,
}

/// A value and where it stands.
type Found<'a> = (&'a DeValue<'a>, usize);

impl<'a> Table<'a> {
    /// Itself, if it has no other keys than these.
    pub(crate) fn with_keys(self, known: &[(&str, &[Parameter])]) -> Result<Self, FileError> {
        for (key, _) in in_order(self.entries) {
            let name = key.get_ref().as_ref();
            let keys = || {
                let tables = known.iter().flat_map(|(_, parameters)| *parameters);
                tables.map(|parameter| parameter.key)
            };
            if !keys().any(|known| known == name) {
                let name = &short(name);
                let nearest = keys().min_by_key(|known| distance(known, name));
                let advice = match nearest.filter(|known| distance(known, name) <= 3) {
                    Some(nearest) => format!("did you mean `{nearest}`?"),
                    None => format!("known are {}", keys().collect::<Vec<_>>().join(", ")),
                };
                let reason = format!("unknown key `{name}` in [{}]: {advice}", self.name);
                return Err(self.source.fail(key.span().start, reason));
            }
        }
        Ok(self)
    }

    /// An error that concerns the table as a whole.
    pub(crate) fn fail(&self, reason: String) -> FileError {
        self.source.fail(self.offset, reason)
    }

    /// An error about a key; about the table if the key is not in the file.
    pub(crate) fn fail_at(&self, key: &str, reason: String) -> FileError {
        let offset = self.find(key).map_or(self.offset, |(_, offset)| offset);
        self.source.fail(offset, reason)
    }

    /// A path that starts from the folder of the file.
    pub(crate) fn beside(&self, path: &str) -> PathBuf {
        let folder = self.source.path.parent();
        folder.map_or_else(|| PathBuf::from(path), |folder| folder.join(path))
    }

    /// True if the key is there.
    pub(crate) fn has(&self, parameter: &Parameter) -> bool {
        self.find(parameter.key).is_some()
    }

    /// A number, or its default.
    pub(crate) fn number(&self, parameter: &Parameter) -> Result<f64, FileError> {
        match self.find(parameter.key) {
            None => Ok(parameter.default_number()),
            Some(found) => self.number_at(parameter, found, true),
        }
    }

    /// A number that must be there.
    pub(crate) fn required(&self, parameter: &Parameter) -> Result<f64, FileError> {
        let found = self.find(parameter.key);
        self.number_at(
            parameter,
            found.ok_or_else(|| self.missing(parameter))?,
            false,
        )
    }

    /// A number, if the key is there.
    pub(crate) fn number_if(&self, parameter: &Parameter) -> Result<Option<f64>, FileError> {
        let found = self.find(parameter.key);
        found
            .map(|found| self.number_at(parameter, found, false))
            .transpose()
    }

    fn number_at(
        &self,
        parameter: &Parameter,
        (value, offset): Found<'a>,
        may_be_left_out: bool,
    ) -> Result<f64, FileError> {
        let key = parameter.key;
        let text = match value {
            DeValue::Float(float) => float.as_str(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
            DeValue::Integer(_) => {
                let reason = format!("{key} is not written as a decimal number");
                return Err(self.source.fail(offset, reason));
            }
            other => return Err(self.wrong_kind(key, other, offset, "a number")),
        };
        // TOML's numbers are all numbers of Rust, inf and nan included.
        let number: f64 = text.parse().unwrap_or(f64::NAN);
        let range = parameter.range();
        if range.contains(number) {
            Ok(number)
        } else {
            let default = parameter.default_number();
            let advice = match may_be_left_out {
                true => format!("change it, or leave it out for {}", Shown(default)),
                false => "change it".to_owned(),
            };
            let reason = format!("{key} = {} is not {range}: {advice}", Shown(number));
            Err(self.source.fail(offset, reason))
        }
    }

    /// A whole number of at least 0.
    pub(crate) fn count(&self, parameter: &Parameter) -> Result<u64, FileError> {
        let key = parameter.key;
        let default = match parameter.value {
            Value::Count(default) => default,
            _ => 0,
        };
        match self.find(key) {
            None => Ok(default),
            Some((DeValue::Integer(integer), offset)) => {
                let parsed = u64::from_str_radix(integer.as_str(), integer.radix());
                parsed.map_err(|_| {
                    let reason = format!(
                        "{key} = {} is not a whole number from 0 to {}",
                        integer.as_str(),
                        u64::MAX
                    );
                    self.source.fail(offset, reason)
                })
            }
            Some((other, offset)) => Err(self.wrong_kind(key, other, offset, "a whole number")),
        }
    }

    pub(crate) fn flag(&self, parameter: &Parameter) -> Result<bool, FileError> {
        let key = parameter.key;
        match self.find(key) {
            None => Ok(parameter.value == Value::Flag(true)),
            Some((DeValue::Boolean(flag), _)) => Ok(*flag),
            Some((other, offset)) => Err(self.wrong_kind(key, other, offset, "true or false")),
        }
    }

    pub(crate) fn text(&self, parameter: &Parameter) -> Result<&'a str, FileError> {
        let key = parameter.key;
        match self.find(key) {
            None => Ok(parameter.shown),
            Some((DeValue::String(text), _)) => Ok(text),
            Some((other, offset)) => Err(self.wrong_kind(key, other, offset, "a string")),
        }
    }

    /// A text that must be there.
    pub(crate) fn required_text(&self, parameter: &Parameter) -> Result<&'a str, FileError> {
        match self.find(parameter.key) {
            Some(_) => self.text(parameter),
            None => Err(self.missing(parameter)),
        }
    }

    /// A list of finite numbers that must be there.
    pub(crate) fn numbers(&self, parameter: &Parameter) -> Result<Vec<f64>, FileError> {
        let (value, offset) = self.list(parameter)?;
        self.row(parameter, value, offset)
    }

    /// A list of lists of finite numbers that must be there.
    pub(crate) fn matrix(&self, parameter: &Parameter) -> Result<Vec<Vec<f64>>, FileError> {
        let (key, (rows, offset)) = (parameter.key, self.list(parameter)?);
        let rows = rows.iter().map(|row| match row.get_ref() {
            DeValue::Array(items) => self.row(parameter, items, row.span().start),
            other => Err(self.wrong_kind(
                key,
                other,
                offset,
                "a list of rows, as in [[0, 1], [0, -5]]",
            )),
        });
        rows.collect()
    }

    /// A list of finite numbers, or one of them alone, if the key is there.
    pub(crate) fn numbers_if(&self, parameter: &Parameter) -> Result<Option<Vec<f64>>, FileError> {
        match self.find(parameter.key) {
            None => Ok(None),
            Some((DeValue::Array(items), offset)) => self.row(parameter, items, offset).map(Some),
            Some((value, offset)) => {
                let number = self.element(parameter, value, offset, offset)?;
                Ok(Some(vec![number]))
            }
        }
    }

    /// A list of lists of finite numbers, if the key is there.
    pub(crate) fn matrix_if(
        &self,
        parameter: &Parameter,
    ) -> Result<Option<Vec<Vec<f64>>>, FileError> {
        let found = self.find(parameter.key);
        found.map(|_| self.matrix(parameter)).transpose()
    }

    fn list(&self, parameter: &Parameter) -> Result<(&'a DeArray<'a>, usize), FileError> {
        match self.find(parameter.key) {
            Some((DeValue::Array(items), offset)) => Ok((items, offset)),
            Some((other, offset)) => {
                Err(self.wrong_kind(parameter.key, other, offset, "a list, as in [0, 1]"))
            }
            None => Err(self.missing(parameter)),
        }
    }

    fn row(
        &self,
        parameter: &Parameter,
        items: &DeArray<'_>,
        offset: usize,
    ) -> Result<Vec<f64>, FileError> {
        let numbers = items
            .iter()
            .map(|item| self.element(parameter, item.get_ref(), offset, item.span().start));
        numbers.collect()
    }

    /// A number of a list that begins at `offset`, itself at `place`; of a list in the place of a number it is only finite.
    fn element(
        &self,
        parameter: &Parameter,
        value: &DeValue<'_>,
        offset: usize,
        place: usize,
    ) -> Result<f64, FileError> {
        let key = parameter.key;
        let text = match value {
            DeValue::Float(float) => float.as_str(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
            other => return Err(self.wrong_kind(key, other, offset, "a number")),
        };
        let number: f64 = text.parse().unwrap_or(f64::NAN);
        let (good, allowed) = match parameter.value {
            Value::List(range) => (range.contains(number), range.to_string()),
            _ => (number.is_finite(), "finite".to_owned()),
        };
        if good {
            return Ok(number);
        }
        let reason = format!(
            "{key} has {}, which is not {allowed}: change it",
            Shown(number)
        );
        Err(self.source.fail(place, reason))
    }

    fn missing(&self, parameter: &Parameter) -> FileError {
        self.fail(format!(
            "missing key `{}` in [{}]",
            parameter.key, self.name
        ))
    }

    /// One of the values that the command line knows for it.
    pub(crate) fn choice<T: Named>(&self, parameter: &Parameter) -> Result<T, FileError> {
        let (key, text) = (parameter.key, self.text(parameter)?);
        T::named(text).ok_or_else(|| {
            let names: Vec<&str> = T::CHOICES.iter().map(|choice| choice.1).collect();
            let reason = format!(
                "{key} = \"{}\" is not one of {}",
                short(text),
                names.join(", ")
            );
            self.fail_at(key, reason)
        })
    }

    fn find(&self, key: &str) -> Option<Found<'a>> {
        let entry = self.entries.iter().find(|(name, _)| name.get_ref() == key);
        entry.map(|(_, value)| (value.get_ref(), value.span().start))
    }

    fn wrong_kind(&self, key: &str, value: &DeValue<'_>, offset: usize, wanted: &str) -> FileError {
        let kind = value.type_str();
        let article = if kind.starts_with(['a', 'i']) {
            "an"
        } else {
            "a"
        };
        let shown = match value {
            DeValue::String(text) => format!(" = \"{}\"", short(text)),
            DeValue::Integer(integer) => format!(" = {}", short(integer.as_str())),
            DeValue::Float(float) => format!(" = {}", short(float.as_str())),
            DeValue::Boolean(flag) => format!(" = {flag}"),
            _ => String::new(),
        };
        // A string may hold a line break.
        let reason = format!("{key}{shown} is {article} {kind}, not {wanted}");
        self.source.fail(offset, reason.replace('\n', "\\n"))
    }
}

/// The entries of a table in the order of the file.
pub(super) fn in_order<'t, 'i>(
    table: &'t DeTable<'i>,
) -> Vec<(
    &'t Spanned<toml::de::DeString<'i>>,
    &'t Spanned<DeValue<'i>>,
)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries
}

/// Letters to change, add or leave out to make one word of the other (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let changed = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
