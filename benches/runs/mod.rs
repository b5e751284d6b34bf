//! How long criterion measures.

use criterion::Criterion;
use std::time::Duration;

/// Long enough for a figure on a quiet machine; the command line has the last word.
pub(crate) fn short_runs() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args()
}
