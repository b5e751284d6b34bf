//! A search that can be stopped: what it has found stands in a file, a line as soon as it is found, and the next one goes on from there.
//!
//! The first line is the question in full. A last line without an end, of a computer that was switched off, is found anew. Before something
//! was found there is no file.

use super::upward::Settled;
use haptic_document::Failure;
use haptic_document::parameters::CAMPAIGN;
use haptic_log::record::{LineFile, NewFileError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Result for one dissipation, as α.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    pub(super) stable: f64,
    /// `None` if friction held nothing beyond it.
    pub(super) held: Option<f64>,
    /// Simulated without friction, where friction holds a real device.
    #[serde(default)]
    pub(super) without_friction: Option<f64>,
}

/// Range that the search of one order covers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Extent {
    pub(super) dissipation: f64,
    /// Walls of a real device that came to rest.
    pub(super) settled: Option<Settled>,
}

/// A line of the file; orders and points by their number in the question.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Line {
    /// The question.
    Campaign(String),
    Extent(usize, Option<Extent>),
    Point(usize, usize, Option<Cell>),
}

/// Ranges and points that a search has found so far.
#[derive(Debug)]
pub(super) struct Campaign {
    pub(super) extents: BTreeMap<usize, Option<Extent>>,
    pub(super) cells: BTreeMap<(usize, usize), Option<Cell>>,
    file: Mutex<LineFile>,
    failure: Mutex<Option<Failure>>,
}

impl Campaign {
    /// Opens the campaign of this question, from a file that may be there already.
    pub(super) fn open(path: &Path, question: &str) -> Result<Self, Failure> {
        let opened = LineFile::open(path, &text(&Line::Campaign(question.to_owned()))?);
        if let Err(NewFileError::Foreign(_)) = &opened {
            return Err(Failure::bad_input(format_args!(
                "`{}` is not of this search (line 1): give the keys, device and limits with which it began, or another {CAMPAIGN}",
                path.display()
            )));
        }
        let (file, found) = opened?;
        let mut campaign = Self {
            extents: BTreeMap::new(),
            cells: BTreeMap::new(),
            file: Mutex::new(file),
            failure: Mutex::new(None),
        };
        for (index, line) in found.lines().enumerate() {
            match serde_json::from_str(line) {
                Ok(Line::Extent(order, found)) => drop(campaign.extents.insert(order, found)),
                Ok(Line::Point(order, point, found)) => {
                    campaign.cells.insert((order, point), found);
                }
                Ok(Line::Campaign(_)) | Err(_) => {
                    return Err(Failure::bad_input(format_args!(
                        "`{}`, line {}, is not of a search: remove the line, or give another {CAMPAIGN}",
                        path.display(),
                        index + 2
                    )));
                }
            }
        }
        Ok(campaign)
    }

    pub(super) fn keep(&self, line: &Line) {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = text(line).and_then(|text| Ok(file.add(&text)?));
        if let Err(failure) = kept {
            self.failure().get_or_insert(failure);
        }
    }

    /// Reason for which nothing more can be kept, so that the search cannot go on.
    pub(super) fn failure(&self) -> MutexGuard<'_, Option<Failure>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn text(line: &Line) -> Result<String, Failure> {
    serde_json::to_string(line).map_err(Failure::input)
}
