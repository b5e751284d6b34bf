//! A TOML file as a whole: which tables it has, in their order.

use super::error::{FileError, Source};
use super::reader::{Table, in_order};
use crate::input::short;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// A whole file.
#[derive(Debug)]
pub(crate) struct Document<'a> {
    source: Source<'a>,
    root: DeTable<'a>,
}

impl<'a> Document<'a> {
    pub(crate) fn parse(path: &'a Path, text: &'a str) -> Result<Self, FileError> {
        let source = Source { path, text };
        let root = DeTable::parse(text).map_err(|error| {
            let span = error.span().unwrap_or_default();
            // One line; TOML's own message may have several.
            let lines: Vec<&str> = error.message().lines().collect();
            let reason = match (lines.as_slice(), text.get(span.clone())) {
                (["duplicate key"], Some(key)) => {
                    format!(
                        "duplicate key `{}`: leave all but one of them out",
                        short(key)
                    )
                }
                _ => lines.join("; "),
            };
            source.fail(span.start, reason)
        })?;
        Ok(Self {
            source,
            root: root.into_inner(),
        })
    }

    /// The one table of the file that is of one of these kinds, and the table `beside` it, if there is one.
    pub(crate) fn experiment<'k>(
        &'a self,
        kinds: &[&'k str],
        beside: &str,
    ) -> Result<(&'k str, Table<'a>, Option<Table<'a>>), FileError> {
        let names: Vec<String> = kinds.iter().map(|kind| format!("[{kind}]")).collect();
        let choice = format!("an experiment file has one of {}", names.join(", "));
        let known: Vec<&str> = kinds.iter().copied().chain([beside]).collect();
        let (mut first, mut other) = (None, None);
        for (name, table) in self.tables(&known, &choice)? {
            let kind = kinds.iter().find(|kind| **kind == name);
            match (kind, &first) {
                (None, _) => other = Some(table),
                (Some(kind), None) => first = Some((*kind, table)),
                (Some(_), Some(_)) => {
                    return Err(table.fail(format!("a second table [{name}]: {choice}")));
                }
            }
        }
        let (kind, table) = first.ok_or_else(|| self.fail(format!("no experiment: {choice}")))?;
        Ok((kind, table, other))
    }

    /// All tables of the file in its order, each of one of these names; `choice` says in words what such a file has.
    pub(crate) fn tables<'k>(
        &'a self,
        names: &[&'k str],
        choice: &str,
    ) -> Result<Vec<(&'k str, Table<'a>)>, FileError> {
        let source = self.source;
        let tables = in_order(&self.root).into_iter().map(|(key, value)| {
            let (name, offset) = (key.get_ref().as_ref(), key.span().start);
            let Some(known) = names.iter().find(|known| **known == name) else {
                let reason = match value.get_ref() {
                    DeValue::Table(_) => format!("unknown table [{}]: {choice}", short(name)),
                    _ => format!(
                        "unknown key `{}` outside of any table: {choice}",
                        short(name)
                    ),
                };
                return Err(source.fail(offset, reason));
            };
            let DeValue::Table(entries) = value.get_ref() else {
                let reason = format!("`{name}` is not a table: write [{name}]");
                return Err(source.fail(offset, reason));
            };
            let table = Table {
                source,
                name,
                offset,
                entries,
            };
            Ok((*known, table))
        });
        tables.collect()
    }

    /// An error that concerns the file as a whole.
    pub(crate) fn fail(&self, reason: String) -> FileError {
        self.source.fail(0, reason)
    }
}
