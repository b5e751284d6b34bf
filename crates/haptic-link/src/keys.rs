//! One key for each message: a hash of its definition.
//!
//! A host compares the keys of the messages that it uses and outlives everything else: a message that is new, one that
//! it does not use and that has changed.

use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Messages of one direction that a list of keys has room for.
pub const KEYS_MAX: usize = 24;

/// So many requests, the first ones, are those of a device of one axis.
pub(crate) const ONE_AXIS_REQUESTS: usize = 17;
/// Requests in all.
pub(crate) const REQUESTS: usize =
    ONE_AXIS_REQUESTS + if cfg!(feature = "several-axes") { 1 } else { 0 };
/// Reports of any device.
pub(crate) const REPORTS: usize = 13;

/// Hash of a message definition: FNV-1a of 64 bits over its name and the names and types of its fields, as
/// `postcard-schema` defines it; both halves xored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct MessageKey(#[serde(with = "postcard::fixint::le")] pub u32);

/// The keys of all messages, by their numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Keys {
    /// Of the requests.
    pub requests: Vec<MessageKey, KEYS_MAX>,
    /// Of the reports.
    pub reports: Vec<MessageKey, KEYS_MAX>,
}
