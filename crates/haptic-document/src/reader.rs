//! A table of a document, read key by key, so that every refusal names the place of its value.

use super::error::{FileError, Source};
use crate::{
    Named,
    parameters::{Parameter, Range, Value, in_degrees},
};
use fracdiff::{Order, Scheme, SchemeError, parameter::Shown};
use haptic_quantity::{did_you_mean, short};
use std::{
    fmt::Display,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};
use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue},
};

/// One table of a document, in its layers.
#[derive(Debug)]
pub struct Table<'a> {
    /// The name in brackets, as `wall` of `[wall]`.
    pub name: &'a str,
    /// The top one first; at least one.
    pub(crate) parts: Vec<Part<'a>>,
    /// Intervals of the numbers of a file that a layer names.
    pub intervals: Vec<Interval>,
}

/// Two numbers between which a value of a device lies in 95 of 100 cases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Key of the value in its table.
    pub key: &'static str,
    /// The lower one, in the unit of the key.
    pub low: f64,
    /// The upper one, in the unit of the key.
    pub high: f64,
}

/// A table in one layer.
#[derive(Debug)]
pub(crate) struct Part<'a> {
    source: Source<'a>,
    offset: usize,
    entries: &'a DeTable<'a>,
    /// Numbers of a file that this layer names: they lie below its keys.
    named: Vec<(&'static str, f64)>,
}

impl<'a> Part<'a> {
    pub(crate) const fn new(source: Source<'a>, offset: usize, entries: &'a DeTable<'a>) -> Self {
        Self {
            source,
            offset,
            entries,
            named: Vec::new(),
        }
    }

    fn find(&self, key: &str) -> Option<Found<'a>> {
        self.entry(key).map(|value| Found {
            value: value.get_ref(),
            offset: value.span().start,
            source: self.source,
        })
    }

    fn entry(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        let mut entries = self.entries.iter();
        let found = entries.find(|(name, _)| name.get_ref() == key);
        found.map(|(_, value)| value)
    }

    fn named(&self, key: &str) -> Option<f64> {
        let number = self.named.iter().find(|(name, _)| *name == key);
        number.map(|(_, number)| *number)
    }
}

/// A value and where it stands.
#[derive(Clone, Copy, Debug)]
struct Found<'a> {
    value: &'a DeValue<'a>,
    offset: usize,
    source: Source<'a>,
}

impl<'a> Found<'a> {
    fn fail(self, reason: impl Display) -> FileError {
        self.source.fail(self.offset, reason)
    }

    /// An item of this value, at its own offset.
    fn within(self, item: &'a Spanned<DeValue<'a>>) -> Self {
        Self {
            value: item.get_ref(),
            offset: item.span().start,
            ..self
        }
    }

    fn wrong_kind(self, key: &str, wanted: &str) -> FileError {
        let kind = self.value.type_str();
        let article = if kind.starts_with(['a', 'i']) {
            "an"
        } else {
            "a"
        };
        let shown = match self.value {
            DeValue::String(text) => format!(" = \"{}\"", short(text)),
            DeValue::Integer(integer) => format!(" = {}", short(integer.as_str())),
            DeValue::Float(float) => format!(" = {}", short(float.as_str())),
            DeValue::Boolean(flag) => format!(" = {flag}"),
            DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => String::new(),
        };
        self.fail(format!("{key}{shown} is {article} {kind}, not {wanted}"))
    }

    /// A number in a range; `default` where it may be omitted.
    fn number(
        self,
        parameter: &Parameter,
        range: Range,
        default: Option<f64>,
    ) -> Result<f64, FileError> {
        let key = parameter.key;
        let text = match (self.value.as_float(), self.value.as_integer()) {
            (Some(float), _) => float.as_str(),
            (None, Some(integer)) if integer.radix() == 10 => integer.as_str(),
            (None, Some(_)) => {
                return Err(self.fail(format!("{key} is not written as a decimal number")));
            }
            (None, None) => return Err(self.wrong_kind(key, "a number")),
        };
        // TOML's numbers are all numbers of Rust, inf and nan included.
        let number: f64 = text.parse().unwrap_or(f64::NAN);
        let shown = Shown(number);
        if range.contains(number) {
            return Ok(number);
        }
        let range = format!("{range}{}", in_degrees(key, range));
        Err(self.fail(match (parameter.value, default) {
            (Value::List(_), _) => format!("{key} has {shown}, which is not {range}: change it"),
            (_, Some(default)) => {
                let default = Shown(default);
                format!("{key} = {shown} is not {range}: change it, or omit it for {default}")
            }
            (_, None) => format!("{key} = {shown} is not {range}: change it"),
        }))
    }

    /// A number of a list; of a list in the place of a number it is only finite.
    fn element(self, parameter: &Parameter) -> Result<f64, FileError> {
        let range = if let Value::List(range) = parameter.value {
            range
        } else {
            Range::Within(f64::MIN, f64::MAX)
        };
        self.number(parameter, range, None)
    }

    /// The numbers of a list.
    fn numbers(self, parameter: &Parameter) -> Result<Vec<f64>, FileError> {
        let items = self.items(parameter.key, "a list, as in [0, 1]")?;
        let items = items.iter();
        items
            .map(|item| self.within(item).element(parameter))
            .collect()
    }

    fn items(self, key: &str, wanted: &str) -> Result<&'a DeArray<'a>, FileError> {
        let items = self.value.as_array();
        items.ok_or_else(|| self.wrong_kind(key, wanted))
    }
}

impl<'a> Table<'a> {
    /// Itself, if it has no other keys than these.
    ///
    /// # Errors
    /// An unknown key, with the one that it may stand for.
    pub fn with_keys(self, known: &[(&str, &[Parameter])]) -> Result<Self, FileError> {
        let keys = || {
            let tables = known.iter().flat_map(|(_, parameters)| *parameters);
            tables.map(|parameter| parameter.key)
        };
        for part in &self.parts {
            for (key, _) in in_order(part.entries) {
                let name = key.get_ref().as_ref();
                if !keys().any(|known| known == name) {
                    let name = &short(name);
                    let advice = did_you_mean(name, keys());
                    let reason = format!("unknown key `{name}` in [{}]: {advice}", self.name);
                    let unknown = part.source.fail(key.span().start, reason);
                    return Err(unknown.of_file(String::new()));
                }
            }
        }
        Ok(self)
    }

    /// Itself, with the numbers of the file that this key names, below the keys of the layer that names it, and their intervals.
    ///
    /// # Errors
    /// What `read` says, at the place of the key.
    pub fn with_named(
        mut self,
        parameter: &Parameter,
        read: impl Fn(&Path) -> Result<(Vec<(&'static str, f64)>, Vec<Interval>), FileError>,
    ) -> Result<Self, FileError> {
        if let Some(path) = self.file(parameter)? {
            let named = read(&path);
            let (numbers, intervals) = named.map_err(|error| self.fail_at(parameter.key, error))?;
            let mut parts = self.parts.iter_mut();
            if let Some(part) = parts.find(|part| part.find(parameter.key).is_some()) {
                part.named = numbers;
            }
            self.intervals = intervals;
        }
        Ok(self)
    }

    /// True if a text is given by this other key, and in no higher layer the key.
    pub fn lies_below(&self, parameter: &Parameter, other: &Parameter) -> bool {
        let layer = |key: &str| self.parts.iter().position(|part| part.find(key).is_some());
        let is_given = self.text(other).is_ok_and(|text| !text.is_empty());
        let names = layer(other.key).filter(|_| is_given);
        names.is_some_and(|names| layer(parameter.key).is_none_or(|layer| layer > names))
    }

    /// An error that concerns the table as a whole.
    pub fn fail(&self, reason: impl Display) -> FileError {
        match self.parts.last() {
            Some(part) => part.source.fail_from(part.offset, reason),
            None => FileError::wording("", reason),
        }
    }

    /// An error about a key; about the table if the key is not in the file.
    pub fn fail_at(&self, key: &str, reason: impl Display) -> FileError {
        match self.find(key) {
            Some(found) => found.fail(reason),
            None => self.fail(reason),
        }
    }

    /// The path that a key gives, from the folder of its file; none where it gives a name or nothing.
    pub fn path(&self, parameter: &Parameter) -> Option<PathBuf> {
        let found = self.find(parameter.key)?;
        let text = found.value.as_str()?;
        parameter
            .is_path(text)
            .then(|| path_from(found.source, text))
    }

    /// The file that a key names: a path from the folder of its file, or a name as it is; none where the text is empty.
    ///
    /// # Errors
    /// Anything but a string.
    pub fn file(&self, parameter: &Parameter) -> Result<Option<PathBuf>, FileError> {
        debug_assert!(parameter.may_be_path(), "{parameter} is declared as a text");
        let name = self.text(parameter)?;
        let file = || self.path(parameter).unwrap_or_else(|| name.into());
        Ok((!name.is_empty()).then(file))
    }

    /// The text of the file that a key of a log's document names, as the log has it; none where the key is given over it.
    pub fn logged(&self, parameter: &Parameter) -> Option<&'a str> {
        let mut parts = self.parts.iter();
        let part = parts.find(|part| part.find(parameter.key).is_some());
        let source = part.or(self.parts.last())?.source;
        source.logged?.get(parameter.in_log?).map(String::as_str)
    }

    /// True if the key is there.
    pub fn has(&self, parameter: &Parameter) -> bool {
        self.find(parameter.key).is_some()
    }

    /// True if the key was given by an option or an assignment, not by a file or a form.
    pub fn is_given(&self, parameter: &Parameter) -> bool {
        let found = self.find(parameter.key);
        found.is_some_and(|found| !found.source.said_at(found.offset).is_empty())
    }

    /// The value as TOML, if the key is there.
    pub fn written(&self, parameter: &Parameter) -> Option<&'a str> {
        self.parts.iter().find_map(|part| {
            let value = part.entry(parameter.key)?;
            part.source.text.get(value.span())
        })
    }

    /// A number, or its default.
    ///
    /// # Errors
    /// A value of another kind, or a number outside the range of the parameter.
    pub fn number(&self, parameter: &Parameter) -> Result<f64, FileError> {
        let number = self.number_in_layers(parameter, true)?;
        Ok(number.unwrap_or(parameter.default_number()))
    }

    /// A number that must be there.
    ///
    /// # Errors
    /// A key that is not there; else as for [`number`](Self::number).
    pub fn required(&self, parameter: &Parameter) -> Result<f64, FileError> {
        let number = self.number_in_layers(parameter, false)?;
        number.ok_or_else(|| self.missing(parameter))
    }

    /// A number, if the key is there.
    ///
    /// # Errors
    /// As for [`number`](Self::number).
    pub fn number_if(&self, parameter: &Parameter) -> Result<Option<f64>, FileError> {
        self.number_in_layers(parameter, false)
    }

    fn number_in_layers(
        &self,
        parameter: &Parameter,
        may_be_left_out: bool,
    ) -> Result<Option<f64>, FileError> {
        for part in &self.parts {
            if let Some(found) = part.find(parameter.key) {
                let default = may_be_left_out.then(|| parameter.default_number());
                return found
                    .number(parameter, parameter.range(), default)
                    .map(Some);
            }
            if let Some(number) = part.named(parameter.key) {
                return Ok(Some(number));
            }
        }
        Ok(None)
    }

    /// A whole number of at least 0.
    ///
    /// # Errors
    /// A value of another kind, or a negative one.
    pub fn count(&self, parameter: &Parameter) -> Result<u64, FileError> {
        let key = parameter.key;
        let Some(found) = self.find(key) else {
            return Ok(parameter.default_count());
        };
        let Some(integer) = found.value.as_integer() else {
            return Err(found.wrong_kind(key, "a whole number"));
        };
        u64::from_str_radix(integer.as_str(), integer.radix()).map_err(|_| {
            let reason = format!(
                "{key} = {} is not a whole number from 0 to {}",
                integer.as_str(),
                u64::MAX
            );
            found.fail(reason)
        })
    }

    /// An order, or its default; one without a default must be there.
    ///
    /// # Errors
    /// As for [`number`](Self::number).
    pub fn order(&self, parameter: &Parameter) -> Result<Order, FileError> {
        let number = if parameter.default_number().is_nan() {
            self.required(parameter)
        } else {
            self.number(parameter)
        };
        Order::new(number?).map_err(|error| self.fail_at(parameter.key, error))
    }

    /// A scheme of D^μ, or its default.
    ///
    /// # Errors
    /// No scheme of that name, or one without what it needs.
    pub fn scheme(&self, parameter: &Parameter) -> Result<Scheme, FileError> {
        let scheme = short(self.text(parameter)?).parse();
        scheme.map_err(|error: SchemeError| self.fail_at(parameter.key, error))
    }

    /// A whole number in a range.
    ///
    /// # Errors
    /// A value of another kind, or a number outside this range.
    pub fn count_in(
        &self,
        parameter: &Parameter,
        range: RangeInclusive<u64>,
    ) -> Result<usize, FileError> {
        let (key, count) = (parameter.key, self.count(parameter)?);
        if range.contains(&count) {
            return Ok(count as usize);
        }
        let (least, most) = range.into_inner();
        Err(self.fail_at(
            key,
            format_args!("{key} = {count} is not a whole number from {least} to {most}: change it"),
        ))
    }

    /// True if it is on; a default is off unless its parameter says otherwise.
    ///
    /// # Errors
    /// Anything but `true` and `false`.
    pub fn flag(&self, parameter: &Parameter) -> Result<bool, FileError> {
        let key = parameter.key;
        let Some(found) = self.find(key) else {
            return Ok(parameter.value == Value::Flag(true));
        };
        let flag = found.value.as_bool();
        flag.ok_or_else(|| found.wrong_kind(key, "true or false"))
    }

    /// A text, or its default.
    ///
    /// # Errors
    /// Anything but a string.
    pub fn text(&self, parameter: &Parameter) -> Result<&'a str, FileError> {
        let key = parameter.key;
        let Some(found) = self.find(key) else {
            return Ok(parameter.shown);
        };
        let text = found.value.as_str();
        text.ok_or_else(|| found.wrong_kind(key, "a string"))
    }

    /// A text that must be there.
    ///
    /// # Errors
    /// A key that is not there, or anything but a string.
    pub fn required_text(&self, parameter: &Parameter) -> Result<&'a str, FileError> {
        match self.find(parameter.key) {
            Some(_) => self.text(parameter),
            None => Err(self.missing(parameter)),
        }
    }

    /// A list of numbers that must be there.
    ///
    /// # Errors
    /// A key that is not there; else as for [`numbers_if`](Self::numbers_if).
    pub fn numbers(&self, parameter: &Parameter) -> Result<Vec<f64>, FileError> {
        self.must(parameter)?.numbers(parameter)
    }

    /// A list of lists of numbers that must be there.
    ///
    /// # Errors
    /// A key that is not there, a row that is no list, or as for [`number`](Self::number).
    pub fn matrix(&self, parameter: &Parameter) -> Result<Vec<Vec<f64>>, FileError> {
        const ROWS: &str = "a list of rows, as in [[0, 1], [0, -5]]";
        let found = self.must(parameter)?;
        let rows = found.items(parameter.key, "a list, as in [0, 1]")?.iter();
        let rows = rows.map(|row| {
            let row = found.within(row);
            row.items(parameter.key, ROWS)?;
            row.numbers(parameter)
        });
        rows.collect()
    }

    /// A list of numbers, or one of them alone, if the key is there.
    ///
    /// # Errors
    /// A value of another kind, or a number outside the range of the parameter.
    pub fn numbers_if(&self, parameter: &Parameter) -> Result<Option<Vec<f64>>, FileError> {
        let numbers = self
            .find(parameter.key)
            .map(|found| match found.value.as_array() {
                Some(_) => found.numbers(parameter),
                None => Ok(vec![found.element(parameter)?]),
            });
        numbers.transpose()
    }

    /// A list of lists of numbers, if the key is there.
    ///
    /// # Errors
    /// As for [`matrix`](Self::matrix).
    pub fn matrix_if(&self, parameter: &Parameter) -> Result<Option<Vec<Vec<f64>>>, FileError> {
        let found = self.find(parameter.key);
        found.map(|_| self.matrix(parameter)).transpose()
    }

    fn must(&self, parameter: &Parameter) -> Result<Found<'a>, FileError> {
        let found = self.find(parameter.key);
        found.ok_or_else(|| self.missing(parameter))
    }

    fn missing(&self, parameter: &Parameter) -> FileError {
        let missing = format!("missing key `{}` in [{}]", parameter.key, self.name);
        let range = match parameter.value {
            Value::Number(_, range) | Value::List(range) => {
                format!(", {range} {}", parameter.unit())
                    .trim_end()
                    .to_owned()
            }
            Value::Count(_) | Value::Flag(_) | Value::Text(_) => String::new(),
        };
        self.fail(missing)
            .of_file(format!(": give {parameter}{range}"))
    }

    /// One of the values that the command line knows for it.
    ///
    /// # Errors
    /// Another text than one of the names, which the message lists.
    pub fn choice<T: Named>(&self, parameter: &Parameter) -> Result<T, FileError> {
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
        self.parts.iter().find_map(|part| part.find(key))
    }
}

/// Path as seen from the folder of a file.
fn path_from(source: Source<'_>, path: &str) -> PathBuf {
    let folder = source.path.parent();
    folder.map_or_else(|| PathBuf::from(path), |folder| folder.join(path))
}

/// The entries of a table in the order of the file.
pub(crate) fn in_order<'t, 'i>(
    table: &'t DeTable<'i>,
) -> Vec<(
    &'t Spanned<toml::de::DeString<'i>>,
    &'t Spanned<DeValue<'i>>,
)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries
}
