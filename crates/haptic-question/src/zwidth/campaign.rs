//! A search that can be stopped: what it has found stands in a file, a line as soon as it is found, and the next one goes on from there.
//!
//! The first line is the question in full. A last line without an end, of a computer that was switched off, is found anew. Before something
//! was found there is no file.

use crate::zwidth::upward::Settled;
use haptic_document::Failure;
use haptic_document::parameters::CAMPAIGN;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Result for one dissipation, as α.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    pub stable: f64,
    /// `None` if friction held nothing beyond it.
    pub held: Option<f64>,
    /// Simulated without friction, where friction holds a real device.
    #[serde(default)]
    pub without_friction: Option<f64>,
}

/// Range that the search of one order covers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Extent {
    pub dissipation: f64,
    /// Walls of a real device that came to rest.
    pub settled: Option<Settled>,
}

/// A line of the file; orders and points by their number in the question.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Line {
    /// The question in full, on the first line: another question is refused.
    Campaign(String),
    Extent(usize, Option<Extent>),
    Point(usize, usize, Option<Cell>),
}

/// Keeps a line on a disk.
pub type Keep = dyn Fn(&str) -> Result<(), Failure> + Send + Sync;

/// Opens the campaign of a question: its path, and the question in full.
pub type Open<'a> = &'a dyn Fn(&Path, &str) -> Result<Campaign, Failure>;

/// Ranges and points that a search has found so far.
pub struct Campaign {
    pub(super) extents: BTreeMap<usize, Option<Extent>>,
    pub(super) cells: BTreeMap<(usize, usize), Option<Cell>>,
    keep: Box<Keep>,
    failure: Mutex<Option<Failure>>,
}

impl std::fmt::Debug for Campaign {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Campaign")
            .field("extents", &self.extents)
            .field("cells", &self.cells)
            .finish_non_exhaustive()
    }
}

impl Campaign {
    /// The first line of the file of this question.
    ///
    /// # Errors
    /// A question that JSON cannot hold.
    pub fn first_line(question: &str) -> Result<String, Failure> {
        text(&Line::Campaign(question.to_owned()))
    }

    /// The campaign that stands in these lines of a file, all but the first; what is found is handed on, a line each.
    ///
    /// # Errors
    /// A line of another kind.
    pub fn found(path: &Path, lines: &str, keep: Box<Keep>) -> Result<Self, Failure> {
        let mut campaign = Self {
            extents: BTreeMap::new(),
            cells: BTreeMap::new(),
            keep,
            failure: Mutex::new(None),
        };
        for (index, line) in lines.lines().enumerate() {
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

    /// Keeps a line; the first failure ends the search.
    pub(super) fn keep(&self, line: &Line) {
        let kept = text(line).and_then(|text| (self.keep)(&text));
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
