//! Models from measured records: relaxation, creep, oscillation, or any motion.
//! ```text
//! minimise  S = Σ wᵢ rᵢ²     r the residual in log modulus (relaxation, creep, oscillation) or in stress (any motion)
//! ```
//! by Levenberg–Marquardt from many starts, on logarithms of moduli and on orders in their range [0, 1], with exact derivatives. A model
//! costs about 0.4 µs a sample: functions of time come from M(s) by quadrature along one contour for all models.
//! Standard errors are those of the Jacobian at the minimum, intervals those of the profile of S, or by bootstrap; both are wider where
//! neighbouring residuals hang together.
//! ```
//! use haptic_tissue::identify::{Options, Record, identify};
//!
//! let time_s: Vec<f64> = (0..60).map(|i| 1e-2 * 1.2_f64.powi(i)).collect();
//! let modulus_pa = time_s.iter().map(|t| 5000.0 * t.powf(-0.2) / 1.164_229_713_725_303_4).collect(); // Γ(0.8)
//! let record = Record::relaxation(time_s, modulus_pa)?;
//! let found = identify(&record, &Options::default(), &|_| ())?;
//! let best = &found.fits[0];
//! assert_eq!(best.kind.name(), "spring-pot");
//! assert!((best.parameters[0].value - 5000.0).abs() < 1e-6 && (best.parameters[1].value - 0.2).abs() < 1e-9);
//! # Ok::<(), haptic_tissue::identify::IdentifyError>(())
//! ```
//! - *Errors*: a bad record, or no minimum from any start. A fit that did not converge is not in the result.
//! - *Cost*: 40 starts of four parameters on 566 samples take about 0.1 s.

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

pub use crate::model::CANDIDATES;
pub use assemble::{TableDetails, Understood};
use candidates::read;
pub use candidates::{Identification, relative};
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
