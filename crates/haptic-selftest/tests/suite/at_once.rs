//! Cases that run at the same time: each has a device of its own, and waits by the clock for most of its time.

use std::thread::{Builder, scope};

/// Runs cases by their names, and names those that failed when all have ended.
pub(crate) fn at_once<N: ToString, C: FnOnce() + Send>(cases: impl IntoIterator<Item = (N, C)>) {
    let failed: Vec<String> = scope(|scope| {
        let started: Vec<_> = (cases.into_iter())
            .map(|(name, case)| {
                // What a panic says begins with the name of its thread.
                let named = Builder::new().name(name.to_string());
                let thread = named.spawn_scoped(scope, case).expect("a thread");
                (name.to_string(), thread)
            })
            .collect();
        let ended = started.into_iter();
        let failed = ended.filter_map(|(name, thread)| thread.join().is_err().then_some(name));
        failed.collect()
    });
    assert!(failed.is_empty(), "failed: {}", failed.join(", "));
}
