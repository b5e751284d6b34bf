#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod advice;
mod assemble;
mod bootstrap;
mod candidates;
mod commanded;
mod contact;
#[cfg(test)]
mod contour;
mod elements;
mod error;
mod fit;
mod instants;
mod keys;
mod lag;
mod master;
mod noise;
mod options;
mod profile;
mod record;
mod reference;
mod rendered;
mod replicates;
mod search;
mod stiffening;
mod strain_noise;
mod sums;
mod target;
mod tissue;
mod whitened;

pub use assemble::{TableDetails, Understood};
use candidates::read;
pub use candidates::{Identification, relative};
pub use elements::CANDIDATES;
pub use error::IdentifyError;
pub use fit::{Estimate, Fit, student};
pub use lag::{sensor_noise, white_noise};
pub use master::{MasterCurve, Overlap, Shift, ShiftBy, ShiftLaw, master_curve};
pub use options::{HeldParameter, Options};
pub use record::{Baseline, ContactPoint, Record, RecordKind, SAMPLES_MOST};
pub use replicates::{Replicates, Spread, replicates};
use std::sync::atomic::{AtomicBool, Ordering};
pub use target::Weighting;
pub use tissue::Provenance;

/// The crate of tissues and models, whose types this crate's interface has.
pub use haptic_tissue;

/// Fits the candidates to a record. The chosen one has the least BIC; one with fewer parameters and
/// a BIC within 2 of it goes first. `progress` is called from any thread with the number of
/// bootstrap records done.
///
/// # Errors
/// If no candidate can be fitted.
pub fn identify(
    record: &Record,
    options: &Options,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    identify_unless(record, options, &AtomicBool::new(false), progress)
}

/// Fits as [`identify()`] does, until `stop` is set: that ends it within an evaluation of a model, about 0.4 µs a sample.
///
/// # Errors
/// If no candidate can be fitted; a stop.
pub fn identify_unless(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    let late = (record.lag_s).map(|lag_s| lag::taken_off(record, lag_s, options, stop));
    let record = late.as_ref().unwrap_or(record);
    let found = if contact::is_sought(record, options) {
        contact::touched(record, options, stop, progress)
    } else if options.stiffening {
        stiffening::stiffened(record, options, stop)
    } else {
        read(record, options, stop, progress).map(|mut found| {
            let missed = contact::missed(record, options, &found, stop);
            found.warnings.extend(missed);
            found
                .warnings
                .extend(strain_noise::moves(record, options, &found, stop));
            found
        })
    };
    if stop.load(Ordering::Relaxed) {
        Err(IdentifyError::Stopped)
    } else {
        found
    }
}
