//! End of a run, as its log says it.

use super::MetadataRecord;
use serde::Serialize;
use std::collections::BTreeMap;

/// Name of the metadata record that says how a run ended; the last of its log.
pub const END: &str = "end";
/// Name like [`END`], for a drive, which is a second device.
pub const DRIVE_END: &str = "drive.end";

/// Kind of the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EndKind {
    /// Run that ended with its last planned sample.
    Finished,
    /// Somebody stopped it, by Ctrl-C or on the page.
    Interrupted,
    /// A fault of the loop or of the device ended it.
    Fault,
    /// The link to the device was lost: the number of samples that it still made is unknown.
    Link,
}

const ENDS: [(&str, EndKind); 4] = [
    ("finished", EndKind::Finished),
    ("interrupted", EndKind::Interrupted),
    ("fault", EndKind::Fault),
    ("link", EndKind::Link),
];

/// End of a run, and number of samples that its log should have: the ticks from 0 on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RunEnd {
    /// Why the run ended; `reason` says it in words.
    pub ended: EndKind,
    /// End of the run, in words; empty if it finished.
    pub reason: String,
    /// Samples that were to be made.
    pub planned_samples: u64,
    /// Number of samples made, as far as is known; those after a fault or a stop that belong to the
    /// log count too.
    pub made_samples: u64,
    /// Samples that the run itself counted as missing: `dropped_samples` of its report.
    pub dropped_samples: u64,
}

impl RunEnd {
    /// The record that the log gets, which [`of`](Self::of) reads back.
    #[must_use]
    pub fn metadata(&self) -> BTreeMap<String, String> {
        let mut ends = ENDS.iter().filter(|(_, kind)| *kind == self.ended);
        let ended = ends.next().map(|(name, _)| *name);
        let entries = [
            ("ended", ended.unwrap_or_default().to_owned()),
            ("reason", self.reason.clone()),
            ("planned_samples", self.planned_samples.to_string()),
            ("made_samples", self.made_samples.to_string()),
            ("dropped_samples", self.dropped_samples.to_string()),
        ];
        entries.map(|(key, value)| (key.to_owned(), value)).into()
    }

    /// End of a run from metadata; `None` if they are others, or say something else than this version writes.
    #[must_use]
    pub fn of(record: &MetadataRecord) -> Option<Self> {
        if record.name != END && record.name != DRIVE_END {
            return None;
        }
        let number = |key: &str| record.values.get(key)?.parse().ok();
        let ended = record.values.get("ended")?;
        Some(Self {
            ended: ENDS.iter().find(|(name, _)| name == ended)?.1,
            reason: record.values.get("reason")?.clone(),
            planned_samples: number("planned_samples")?,
            made_samples: number("made_samples")?,
            dropped_samples: number("dropped_samples")?,
        })
    }
}
