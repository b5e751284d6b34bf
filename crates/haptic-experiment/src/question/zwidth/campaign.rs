//! A search that can be stopped: what it has found stands in a file, a line as soon as it is found, and the next one goes on from there.
//!
//! The first line is the question in full. A last line without an end, of a computer that was switched off, is found anew.

use super::upward::Settled;
use crate::document::failure::Failure;
use crate::document::parameters::CAMPAIGN;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Result for one dissipation, as α.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    pub(super) stable: f64,
    pub(super) held: Option<f64>,
}

/// Range that the search of one order covers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Extent {
    pub(super) dissipation: f64,
    /// Of a real device: walls that came to rest.
    pub(super) settled: Option<Settled>,
}

/// A line of the file; orders and points by their number in the question.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Line {
    /// The question.
    Campaign(String),
    Extent(usize, Option<Extent>),
    Point(usize, usize, Option<Cell>),
}

/// Ranges and points that a search has found so far.
#[derive(Debug)]
pub(super) struct Campaign {
    path: PathBuf,
    extents: BTreeMap<usize, Option<Extent>>,
    cells: BTreeMap<(usize, usize), Option<Cell>>,
    file: Mutex<File>,
    failure: Mutex<Option<Failure>>,
}

impl Campaign {
    /// Of this question; from a file that may be there already.
    pub(super) fn open(path: &Path, question: &str) -> Result<Self, Failure> {
        let failed = |error| Failure::writing(error, format_args!("`{}`", path.display()));
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(path).map_err(failed)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        // Only lines that were written to their end count.
        text.truncate(text.rfind('\n').map_or(0, |end| end + 1));
        file.set_len(text.len() as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let mut campaign = Self {
            path: path.to_owned(),
            extents: BTreeMap::new(),
            cells: BTreeMap::new(),
            file: Mutex::new(file),
            failure: Mutex::new(None),
        };
        let mut lines = text.lines().enumerate();
        match lines.next().map(|(_, line)| serde_json::from_str(line)) {
            None => campaign.write(&Line::Campaign(question.to_owned()))?,
            Some(Ok(Line::Campaign(asked))) if asked == question => {}
            Some(_) => {
                return Err(Failure::bad_input(format_args!(
                    "`{}` is not of this search (line 1): give the keys with which it began, or another {CAMPAIGN}",
                    path.display()
                )));
            }
        }
        for (index, line) in lines {
            match serde_json::from_str(line) {
                Ok(Line::Extent(order, found)) => drop(campaign.extents.insert(order, found)),
                Ok(Line::Point(order, point, found)) => {
                    campaign.cells.insert((order, point), found);
                }
                Ok(Line::Campaign(_)) | Err(_) => {
                    return Err(Failure::bad_input(format_args!(
                        "`{}`, line {}, is not of a search: remove the line, or give another {CAMPAIGN}",
                        path.display(),
                        index + 1
                    )));
                }
            }
        }
        Ok(campaign)
    }

    /// The range of an order, if that was found before.
    pub(super) fn extent(&self, order: usize) -> Option<&Option<Extent>> {
        self.extents.get(&order)
    }

    /// A point, if that was found before.
    pub(super) fn cell(&self, order: usize, point: usize) -> Option<Option<Cell>> {
        self.cells.get(&(order, point)).copied()
    }

    pub(super) fn keep_extent(&self, order: usize, found: &Option<Extent>) {
        self.keep(&Line::Extent(order, found.clone()));
    }

    pub(super) fn keep_cell(&self, order: usize, point: usize, found: Option<Cell>) {
        self.keep(&Line::Point(order, point, found));
    }

    fn keep(&self, line: &Line) {
        if let Err(failure) = self.write(line) {
            self.failure().get_or_insert(failure);
        }
    }

    /// Reason for which nothing more can be kept, so that the search cannot go on.
    pub(super) fn failure(&self) -> MutexGuard<'_, Option<Failure>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self, line: &Line) -> Result<(), Failure> {
        let text = serde_json::to_string(line).map_err(Failure::input)? + "\n";
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.write_all(text.as_bytes());
        (written.and_then(|()| file.sync_data()))
            .map_err(|error| Failure::writing(error, format_args!("`{}`", self.path.display())))
    }
}
