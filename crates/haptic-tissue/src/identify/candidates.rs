//! The candidates of a record, fitted and in order.

use super::error::IdentifyError;
use super::fit::{AS_GOOD, Estimate, Fit, REFUSED, fit};
use super::options::{Options, candidates, target_of};
use super::record::{Record, RecordKind};
use super::search::search;
use super::{advice, bootstrap, profile};
use crate::model::ModelKind;
use std::sync::atomic::AtomicBool;
/// Models fitted to a record, best first.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// The kind of the record.
    pub kind: RecordKind,
    /// Samples of the whole record; of a long motion fewer are compared, which `warnings` says.
    pub samples: usize,
    /// Fits that converged, the chosen one first, the others by BIC.
    pub fits: Vec<Fit>,
    /// Times in s, or angular frequencies in rad/s, of the values that were fitted. For an
    /// oscillation each appears twice.
    pub x: Vec<f64>,
    /// The values: moduli, compliances, all storage and then all loss moduli, or stresses; for a
    /// long history a selection.
    pub measured: Vec<f64>,
    /// Contact point and baseline of the chosen fit, if they were looked for.
    pub beside: Vec<Estimate>,
    /// Sentences that a user should know.
    pub warnings: Vec<String>,
}

impl Identification {
    /// The residual of each value, model minus record: a share of the value, or in Pa for a
    /// history.
    #[must_use]
    pub fn residuals(&self, fit: &Fit) -> Vec<f64> {
        let both = fit.predicted.iter().zip(&self.measured);
        both.map(|(model, measured)| match self.kind {
            RecordKind::History => model - measured,
            RecordKind::Relaxation | RecordKind::Creep | RecordKind::Oscillation => {
                relative(libm::log(model / measured))
            }
        })
        .collect()
    }
}

/// A residual r of a logarithm as a share of the value: e^r − 1, never below −1.
#[must_use]
pub fn relative(residual: f64) -> f64 {
    libm::expm1(residual)
}

/// Fits the candidates; none stiffens.
pub(super) fn identified(
    record: &Record,
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Identification, IdentifyError> {
    let target = target_of(record, options, stop);
    let (mut fitted, mut failed) = (Vec::new(), Vec::new());
    for candidate in candidates(options, record.kind())? {
        match search(candidate, &target, options.starts.max(1)) {
            Ok(best) => {
                let (fit, certainty) = fit(candidate, &target, &best);
                fitted.push((fit, candidate, best, certainty));
            }
            Err(error) if options.chosen == Some(candidate.kind()) => return Err(error),
            Err(error) => failed.push(error),
        }
    }
    fitted.sort_by(|a, b| a.0.bic.total_cmp(&b.0.bic));
    let fits = || fitted.iter().map(|fitted| &fitted.0);
    let Some(index) = choose(fits(), options.chosen) else {
        // What the model with the fewest parameters needs.
        return Err(failed.into_iter().next().unwrap_or_else(|| {
            IdentifyError::Record("there is no model to fit: give at least one".to_owned())
        }));
    };
    let first = fitted.remove(index);
    fitted.insert(0, first);
    let mut warnings = record.said.clone();
    warnings.extend(failed.iter().map(ToString::to_string));
    let bics = fitted.iter().map(|fitted| fitted.0.bic);
    let refused = bics.fold(f64::INFINITY, f64::min) + REFUSED;
    for (index, (fit, candidate, best, certainty)) in fitted.iter_mut().enumerate() {
        let (candidate, independent) = (*candidate, fit.independent);
        let (records, seed) = (options.bootstrap, options.seed);
        let ends = if index == 0 && records > 0 {
            let (ends, fitted) = bootstrap::intervals(
                candidate,
                &target,
                best,
                independent,
                records,
                seed,
                progress,
            );
            let lost = records - fitted;
            if lost > 0 {
                warnings.push(format!(
                    "{lost} of {records} records of the bootstrap could not be fitted and are left out"
                ));
            }
            ends
        } else if index == 0 || fit.bic <= refused {
            profile::intervals(candidate, &target, best, certainty)
        } else {
            continue;
        };
        for (estimate, (low, high)) in fit.parameters.iter_mut().zip(ends) {
            estimate.low_95 = Some(low).filter(|x| x.is_finite());
            estimate.high_95 = Some(high).filter(|x| x.is_finite());
        }
    }
    if let Some(said) = advice::about_length(target.samples(), record) {
        warnings.push(said);
    }
    let fits: Vec<Fit> = fitted.into_iter().map(|(fit, ..)| fit).collect();
    warnings.extend(advice::about(&fits));
    let (x, measured) = target.values(record);
    Ok(Identification {
        kind: record.kind(),
        samples: record.samples(),
        fits,
        x,
        measured,
        beside: Vec::new(),
        warnings,
    })
}

/// The place of the wanted one in fits by BIC; else of that with the fewest parameters of those as good as the best.
pub(super) fn choose<'a>(
    fits: impl Iterator<Item = &'a Fit> + Clone,
    wanted: Option<ModelKind>,
) -> Option<usize> {
    let mut places = fits.enumerate();
    if let Some(wanted) = wanted {
        return places.position(|(_, fit)| fit.kind == wanted);
    }
    // What has come down to a simpler model, or is not settled, makes no tissue; it is taken only where there is nothing else.
    let sound = |fit: &Fit| fit.is_settled() && fit.to_model().is_ok();
    let any = places.clone().any(|(_, fit)| sound(fit));
    let places = places.filter(|(_, fit)| !any || sound(fit));
    let good = places.clone().next()?.1.bic + AS_GOOD;
    places
        .filter(|(_, fit)| fit.bic <= good)
        .min_by_key(|(_, fit)| fit.parameters.len())
        .map(|(index, _)| index)
}
