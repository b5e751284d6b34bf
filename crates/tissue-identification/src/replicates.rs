//! Records of several specimens of one tissue, each fitted separately: the tissue is their mean, with its spread.
//! ```text
//! θᵢ, eᵢ  a parameter of specimen i of n and its standard error        m = Σ θᵢ/n,   s² = Σ (θᵢ − m)²/(n − 1)
//! between specimens  τ² = s² − Σ eᵢ²/n, at least 0                       95 % interval of the mean  m ± t·s/√n,  of a modulus m·exp(±t·s/(m√n)),  t of Student, n − 1
//! ```
//! s is what another specimen would show, τ how much of that is the specimens' own and not the fits'. The model is that of the least sum
//! of BIC over all specimens; one with fewer parameters and a sum within 2 of it goes first. Parameters at an end of their range have no
//! error, and count with none.
//!
//! - *Errors*: fewer than two records, records of different kinds, a model that fits none together.
//! - *Cost*: that of [`identify`](crate::identify()) for each record, and of one model again.
//! - *Source*: W. G. Cochran, *The combination of estimates from different experiments*, Biometrics 10, 1954 (τ², unweighted).

use super::candidates::Identification;
use super::error::IdentifyError;
use super::fit::{AS_GOOD, Estimate, Fit, student};
use super::identify_unless;
use super::options::Options;
use super::record::{Record, RecordKind};
use crate::keys::REPLICATES;
use haptic_tissue::ModelKind;
use std::sync::atomic::AtomicBool;

/// A parameter over all specimens.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// The mean, its standard error s/√n and its interval.
    pub mean: Estimate,
    /// s of the estimates, of which the errors of the fits are a part.
    pub standard_deviation: f64,
    /// τ: that of the specimens alone.
    pub between: f64,
}

/// Specimens of one tissue, each fitted separately, and their common parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Replicates {
    /// Each fitted by the model of all, which comes first in its fits.
    pub specimens: Vec<Identification>,
    /// Each parameter of the model.
    pub spreads: Vec<Spread>,
    /// All as one: its only fit has the means, the correlations between specimens, and predicts each specimen by its own parameters.
    pub all: Identification,
}

/// Fits each record separately and summarises the parameters.
///
/// # Errors
/// Fewer than two records, records of different kinds, no model that fits all; a stop.
pub fn replicates(
    records: &[Record],
    options: &Options,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Replicates, IdentifyError> {
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    if records.len() < 2 {
        return wrong(format!(
            "{REPLICATES} needs records of two specimens at least, and there is one: give more, or omit it"
        ));
    }
    if let Some(other) = records.iter().find(|one| one.kind != records[0].kind) {
        return wrong(format!(
            "{REPLICATES} needs records of one kind, and there are {} and {}: give those of one",
            records[0].kind.name(),
            other.kind.name()
        ));
    }
    // A sum may have another number of branches in each.
    if let Some(kind) = options.chosen.filter(|kind| kind.is_sum()) {
        return wrong(format!(
            "{kind} is not fitted to {REPLICATES}: give another model, or the records one by one"
        ));
    }
    let fitted = |options: &Options| -> Result<Vec<Identification>, IdentifyError> {
        let one = |record| identify_unless(record, options, stop, progress);
        records.iter().map(one).collect()
    };
    let kinds = options.candidates.iter().copied();
    let plain = Options {
        candidates: kinds.filter(|kind| !kind.is_sum()).collect(),
        bootstrap: 0,
        ..options.clone()
    };
    let kind = match options.chosen {
        Some(kind) => kind,
        None => chosen(&fitted(&plain)?, options)?,
    };
    let one = Options {
        candidates: vec![kind],
        chosen: Some(kind),
        ..options.clone()
    };
    let specimens = fitted(&one)?;
    let spreads = spreads(&specimens);
    Ok(Replicates {
        all: all(kind, &specimens, &spreads),
        spreads,
        specimens,
    })
}

fn spreads(specimens: &[Identification]) -> Vec<Spread> {
    let count = specimens.len() as f64;
    let first = specimens[0].fits[0].parameters.iter().enumerate();
    let spreads = first.map(|(n, first)| {
        let all = || specimens.iter().map(|one| &one.fits[0].parameters[n]);
        let mean = all().map(|one| one.value).sum::<f64>() / count;
        let squares = all().map(|one| (one.value - mean) * (one.value - mean));
        let square = squares.sum::<f64>() / (count - 1.0);
        let errors = all().filter_map(|one| one.standard_error);
        let of_fits = errors.map(|error| error * error).sum::<f64>() / count;
        let error = libm::sqrt(square / count);
        let t = student(count - 1.0);
        let mut mean = Estimate::of_line(first.name, first.unit, mean, error, t);
        // Relative to a modulus, which is above 0.
        let ends = [-t, t].map(|t| {
            if first.is_order() {
                (mean.value + t * error).clamp(0.0, 1.0)
            } else {
                mean.value * libm::exp(t * error / mean.value)
            }
        });
        [mean.low_95, mean.high_95] = ends.map(|end| Some(end).filter(|end| end.is_finite()));
        Spread {
            mean,
            standard_deviation: libm::sqrt(square),
            between: libm::sqrt((square - of_fits).max(0.0)),
        }
    });
    spreads.collect()
}

fn all(kind: ModelKind, specimens: &[Identification], spreads: &[Spread]) -> Identification {
    let record = specimens[0].kind;
    // Of sweeps all storage moduli come first.
    let parts = 1 + usize::from(record == RecordKind::Oscillation);
    let joined = |values: fn(&Identification) -> &Vec<f64>| -> Vec<f64> {
        let all = (0..parts).flat_map(|part| specimens.iter().map(move |one| (part, values(one))));
        let parts = all.flat_map(|(part, values)| values.chunks(values.len() / parts).nth(part));
        parts.flatten().copied().collect()
    };
    let fits = || specimens.iter().map(|specimen| &specimen.fits[0]);
    let correlation = |a: usize, b: usize| {
        let apart = |fit: &Fit, n: usize| fit.parameters[n].value - spreads[n].mean.value;
        let product = fits().map(|fit| apart(fit, a) * apart(fit, b)).sum::<f64>();
        let sizes = spreads[a].standard_deviation * spreads[b].standard_deviation;
        product / sizes / (specimens.len() as f64 - 1.0)
    };
    let predicted = joined(|specimen| &specimen.fits[0].predicted);
    let count = predicted.len() as f64;
    let mean = |rms: fn(&Fit) -> f64| {
        let squares = fits().map(|fit| rms(fit) * rms(fit) * fit.predicted.len() as f64);
        libm::sqrt(squares.sum::<f64>() / count)
    };
    let parameters = 0..spreads.len();
    let fit = Fit {
        kind,
        parameters: spreads.iter().map(|spread| spread.mean.clone()).collect(),
        correlation: (parameters.clone())
            .map(|a| parameters.clone().map(|b| correlation(a, b)).collect())
            .collect(),
        rms: mean(|fit| fit.rms),
        weighted: mean(|fit| fit.weighted),
        aic: fits().map(|fit| fit.aic).sum(),
        bic: fits().map(|fit| fit.bic).sum(),
        predicted,
        independent: fits().map(|fit| fit.independent).sum(),
    };
    Identification {
        kind: record,
        samples: specimens.iter().map(|specimen| specimen.samples).sum(),
        fits: vec![fit],
        x: joined(|specimen| &specimen.x),
        measured: joined(|specimen| &specimen.measured),
        placement: Vec::new(),
        is_absolute: specimens.iter().any(|specimen| specimen.is_absolute),
        is_staircase: specimens.iter().any(|specimen| specimen.is_staircase),
        is_timed: specimens.iter().all(|specimen| specimen.is_timed),
        warnings: Vec::new(),
    }
}

/// The model of all specimens.
fn chosen(all: &[Identification], options: &Options) -> Result<ModelKind, IdentifyError> {
    let sum = |kind: ModelKind| -> Option<f64> {
        let fit = |one: &Identification| {
            let fit = one.fits.iter().find(|fit| fit.kind == kind)?;
            (fit.is_settled() && fit.to_model().is_ok()).then_some(fit.bic)
        };
        all.iter().map(fit).sum()
    };
    let kinds = options.candidates.iter();
    let sums = kinds.filter_map(|&kind| Some((kind, sum(kind)?)));
    let sums: Vec<(ModelKind, f64)> = sums.collect();
    let least = sums.iter().map(|one| one.1).fold(f64::INFINITY, f64::min);
    let good = sums.iter().filter(|one| one.1 <= least + AS_GOOD);
    let simplest = good.min_by_key(|one| one.0.parameters().len());
    simplest.map(|one| one.0).ok_or_else(|| {
        IdentifyError::Record(format!(
            "no model fits all {} records: give them one by one, or the model",
            all.len()
        ))
    })
}
