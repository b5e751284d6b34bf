//! End of a run, in its log: so that ticks lost before the first and after the last one kept are counted too.

use std::collections::BTreeMap;

use serde::Serialize;

use super::MetadataRecord;

/// Name of the metadata record that says how a run ended; the last of its log.
pub const END: &str = "end";

/// Kind of the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EndKind {
    /// With its last planned sample.
    Finished,
    /// Somebody asked for it.
    Interrupted,
    /// By a fault.
    Fault,
    /// The link to the device was lost: nobody knows how many samples it still made.
    Link,
}

impl EndKind {
    const ALL: [Self; 4] = [Self::Finished, Self::Interrupted, Self::Fault, Self::Link];

    const fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Interrupted => "interrupted",
            Self::Fault => "fault",
            Self::Link => "link",
        }
    }
}

/// End of a run, and number of samples that its log should have: the ticks from 0 on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RunEnd {
    /// Kind of the end.
    pub ended: EndKind,
    /// In words; empty for a run that finished.
    pub reason: String,
    /// Samples that were to be made.
    pub planned_samples: u64,
    /// Samples made, as far as is known; what follows a fault or a stop, and belongs to the log, counts.
    pub made_samples: u64,
    /// Samples that the run itself counted as missing: `dropped_samples` of its report.
    pub dropped_samples: u64,
}

impl RunEnd {
    /// As metadata.
    #[must_use]
    pub fn metadata(&self) -> BTreeMap<String, String> {
        let entries = [
            ("ended", self.ended.name().to_owned()),
            ("reason", self.reason.clone()),
            ("planned_samples", self.planned_samples.to_string()),
            ("made_samples", self.made_samples.to_string()),
            ("dropped_samples", self.dropped_samples.to_string()),
        ];
        entries.map(|(key, value)| (key.to_owned(), value)).into()
    }

    /// From metadata; `None` if they are others, or say something else than this version writes.
    #[must_use]
    pub fn of(record: &MetadataRecord) -> Option<Self> {
        if record.name != END {
            return None;
        }
        let number = |key: &str| record.values.get(key)?.parse().ok();
        let ended = record.values.get("ended")?;
        Some(Self {
            ended: (EndKind::ALL.into_iter()).find(|kind| kind.name() == ended)?,
            reason: record.values.get("reason")?.clone(),
            planned_samples: number("planned_samples")?,
            made_samples: number("made_samples")?,
            dropped_samples: number("dropped_samples")?,
        })
    }
}
