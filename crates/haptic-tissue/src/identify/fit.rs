//! A model fitted to a record, with its errors.

use super::bootstrap::neighbours;
use super::candidate::Candidate;
use super::parameter::{Estimate, correlation, covariance, estimates, parameters};
use super::search::Best;
use super::target::Target;
use crate::model::{Model, ModelError, ModelKind};

/// A model with no more BIC than the best and this is as good: odds of less than 3 to 1 (R. Kass, A. Raftery, *Bayes factors*, 1995).
pub(super) const AS_GOOD: f64 = 2.0;

/// Orders closer to 0 or 1 are 0 or 1.
const CLASSICAL: f64 = 1e-4;
/// Standard errors of so many times the value say that the record knows nothing of a modulus.
const WILD: f64 = 10.0;

/// A model fitted to a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The kind of the model.
    pub kind: ModelKind,
    /// Its parameters in SI units, in the order of a tissue file.
    pub parameters: Vec<Estimate>,
    /// Correlations of the estimates, of the logarithm where it is a modulus; NaN where one is at an end of its range. Empty if the
    /// record does not settle them.
    pub correlation: Vec<Vec<f64>>,
    /// Root of the mean square of the residuals, without weights: of the logarithm, or Pa for a history.
    pub rms: f64,
    /// n·ln(S/n) + 2(p + 1), of the weighted sum of squares S, n residuals and all p parameters of the model: one at an end of its range
    /// was put there by the record too.
    pub aic: f64,
    /// n·ln(S/n) + (p + 1)·ln n.
    pub bic: f64,
    /// The model where the record has a value, in the order of [`measured`](super::Identification::measured).
    pub predicted: Vec<f64>,
    /// Correlation of neighbouring residuals; 0 for white noise.
    pub neighbours: f64,
}

impl Fit {
    /// The model with the parameters of the fit. An order within 1e-4 of 0 or 1 becomes a spring or a dashpot: that changes a modulus by
    /// 1e-4 in a factor e of time, and no design tells the two apart.
    ///
    /// # Errors
    /// If the fit has come down to a simpler model, as one with both orders equal.
    pub fn to_model(&self) -> Result<Model, ModelError> {
        let value = |parameter: &Estimate| match parameter.value {
            order if !parameter.unit.is_empty() => order,
            order if order < CLASSICAL => 0.0,
            order if order > 1.0 - CLASSICAL => 1.0,
            order => order,
        };
        let values: Vec<f64> = self.parameters.iter().map(value).collect();
        Model::from_parameters(self.kind, &values)
    }

    /// True if the record settles the parameters so far that they describe anything: no standard error many times its value.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let wild = |parameter: &Estimate| {
            let most = if parameter.unit.is_empty() {
                1.0
            } else {
                WILD * parameter.value
            };
            parameter.standard_error.is_some_and(|error| error > most)
        };
        !self.correlation.is_empty() && !self.parameters.iter().any(wild)
    }
}

/// A fit with its errors, from the best minimum.
pub(super) fn fit(candidate: Candidate, target: &Target, best: &Best) -> Fit {
    let Best {
        elements,
        sum,
        free,
        ..
    } = best;
    let n = target.len();
    let (mut predicted, mut residuals) = (vec![0.0; n], vec![0.0; n]);
    target.model(candidate, elements, |i, slope| {
        predicted[i] = slope.value * target.scale;
    });
    target.residuals(candidate, elements, |i, _, slope| {
        residuals[i] = slope.value * target.scale;
    });
    let covariance = covariance(candidate, target, elements, free, *sum);
    let values = parameters(candidate, elements, target.unit_s);
    // A record without any noise is as good as one with noise in the last digits.
    let likelihood = n as f64 * libm::log((sum / n as f64).max(1e-30));
    let numbers = (candidate.parameters() + 1) as f64;
    Fit {
        kind: candidate.kind(),
        parameters: estimates(
            candidate,
            &values,
            covariance.as_ref(),
            n - free.len().min(n - 1),
        ),
        correlation: covariance.as_ref().map(correlation).unwrap_or_default(),
        rms: libm::sqrt(residuals.iter().map(|r| r * r).sum::<f64>() / n as f64),
        aic: likelihood + 2.0 * numbers,
        bic: likelihood + numbers * libm::log(n as f64),
        predicted,
        neighbours: neighbours(&residuals),
    }
}
