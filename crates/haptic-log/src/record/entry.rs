//! Contents of a log, one entry at a time.

use std::collections::BTreeMap;

use super::{EventMessage, TickMessage, VectorTick};

/// One thing in a log.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Entry {
    /// A control tick of one axis.
    Tick(TickMessage),
    /// A control tick of two or three axes.
    Vector(VectorTick),
    /// An event.
    Event(EventMessage),
    /// A metadata record.
    Metadata(MetadataRecord),
}

/// A named set of strings: parameters, versions, statistics.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct MetadataRecord {
    /// Subject of the strings.
    pub name: String,
    /// The strings by key.
    pub values: BTreeMap<String, String>,
}
