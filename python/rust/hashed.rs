//! Hashes of values for Python.

use std::hash::{DefaultHasher, Hasher as _};

/// The hash of what `fill` writes.
pub(crate) fn hashed(fill: impl FnOnce(&mut DefaultHasher)) -> u64 {
    let mut hasher = DefaultHasher::new();
    fill(&mut hasher);
    hasher.finish()
}
