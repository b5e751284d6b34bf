//! Plain sentences about a fit.

use super::fit::{AS_GOOD, Estimate, Fit};
use super::keys::FROM;
use super::record::Record;
use super::record::digits;
use super::reference::Misfit;
use super::target::Target;
use fracdiff::parameter::Shown;
use haptic_tissue::ModelKind;

/// Two estimates that hang together so closely are one, if neither is settled.
const ONE: f64 = 0.99;
/// A standard error over the value, or of an order, below which a parameter is settled, whatever it hangs together with: a viscosity at
/// 1 s and its order always do where the record is far from 1 s.
const SETTLED: f64 = 0.1;
const SETTLED_ORDER: f64 = 0.03;
/// A standard error over the value, or of an order, from which a parameter is not settled.
const LOOSE: f64 = 0.5;
const LOOSE_ORDER: f64 = 0.2;

/// Share of a record that a model leaves, from which it does not describe it.
const MISSED: f64 = 0.1;

/// Times what a spectrum leaves, from which another kind of model is worth looking for.
const ANOTHER: f64 = 1.2;

/// Sentences about the first of these fits, which are of such a record.
pub(super) fn about(
    fits: &[Fit],
    is_absolute: bool,
    misfit: Option<Misfit>,
    chosen: Option<ModelKind>,
) -> Vec<String> {
    let Some(fit) = fits.first() else {
        return Vec::new();
    };
    let misfit = misfit.filter(|misfit| misfit.ratio > ANOTHER);
    let misfit = misfit.map(|misfit| {
        let best = if chosen.is_none() { ", the best of these models," } else { "" };
        format!(
            "{}{best} leaves {} times as much of the record as a spectrum of {} relaxations does: another kind of model is needed",
            fit.kind,
            Shown(digits(misfit.ratio)),
            misfit.modes
        )
    });
    let mut advice = Vec::from_iter(misfit.or_else(|| missed(fit, is_absolute)));
    advice.extend(burgers(fit));
    advice.extend([at_ends(fit), together(fit), loose(fit), open(fit)].concat());
    advice.extend(simpler(fit, fits));
    advice.extend(slow(fit));
    advice
}

/// A record too long to be compared sample by sample.
pub(super) fn about_length(compared: usize, record: &Record) -> Option<String> {
    // The first sample of each motion is at rest.
    (compared + record.motions.len().max(1) < record.samples()).then(|| {
        format!(
            "of {} samples {compared} are compared, spread over time; the strain of all is taken",
            record.samples()
        )
    })
}

/// Size of what a fit leaves over the errors of the record, if it has any.
pub(super) fn about_errors(fit: &Fit, target: &Target<'_>) -> Option<String> {
    let left = fit.weighted / (target.error? * target.scale);
    Some(format!(
        "residuals are weighed by the errors of the record, of which they are {} times the size; intervals are by the residuals",
        Shown(digits(left))
    ))
}

/// Much is left, and alike from sample to sample, as no noise is.
fn missed(fit: &Fit, is_absolute: bool) -> Option<String> {
    let number = fit.predicted.len() as f64;
    let squares: f64 = fit.predicted.iter().map(|value| value * value).sum();
    let missed = if is_absolute {
        fit.rms / (squares / number).sqrt()
    } else {
        fit.rms
    };
    (missed > MISSED && fit.independent < 0.5 * number).then(|| {
        format!(
            "{}, the best of these models, does not describe the record: it leaves {:.0} % of it; look at the figure, and leave out \
             what is not the tissue's, as the first instants of an instrument, with {FROM}",
            fit.kind,
            100.0 * missed
        )
    })
}

/// Two branches without a spring, by the numbers by which they are known.
/// ```text
/// E₁ = E + G,  η₁ = Eτ + Gθ,  r = η₁/(E₁τθ),  1/E₂ = 1/(E·rτ/(1 − rτ)² + G·rθ/(1 − rθ)²),  η₂ = E₂/r
/// ```
fn burgers(fit: &Fit) -> Option<String> {
    let values = fit.parameters.iter().map(|one| one.value);
    let values: Vec<f64> = values.collect();
    let &[e, tau, g, theta] = &values[..] else {
        return None;
    };
    let (spring, dashpot) = (e + g, e * tau + g * theta);
    let r = dashpot / (spring * tau * theta);
    let part = |modulus: f64, x: f64| modulus * x / ((1.0 - x) * (1.0 - x));
    let second = part(e, r * tau) + part(g, r * theta);
    let [spring, dashpot, second, slow] = [spring, dashpot, second, second / r].map(digits);
    (fit.kind == ModelKind::Prony).then(|| {
        format!(
            "this is a Burgers model: a spring of {} Pa, a dashpot of {} Pa·s, and a spring of {} Pa beside a dashpot of {} Pa·s, in series",
            Shown(spring),
            Shown(dashpot),
            Shown(second),
            Shown(slow)
        )
    })
}

fn at_ends(fit: &Fit) -> Vec<String> {
    let parameters = fit.parameters.iter().enumerate();
    let ends = parameters.filter(|(_, parameter)| !parameter.held);
    let ends = ends.filter_map(|(k, parameter)| {
        // A parameter that was fixed has no correlation, not even with itself.
        let fixed = fit.correlation.get(k).is_some_and(|row| row[k].is_nan());
        let (name, value) = (parameter.name, parameter.value);
        let element = match (parameter.is_order(), value) {
            (false, _) if fixed => {
                return Some(format!(
                    "`{name}` is at the end of its range: use a model without this element"
                ));
            }
            (true, 0.0) => "spring",
            (true, 1.0) => "dashpot",
            _ => return None,
        };
        Some(format!(
            "`{name}` is {value}, the end of its range: this element is a {element}"
        ))
    });
    ends.collect()
}

/// Pairs that the record cannot separate.
fn together(fit: &Fit) -> Vec<String> {
    if fit.correlation.is_empty() {
        return vec![format!(
            "the record does not determine the parameters of {}: use a longer record or another model",
            fit.kind
        )];
    }
    let names: Vec<&str> = fit.parameters.iter().map(|p| p.name).collect();
    let mut advice = Vec::new();
    for (i, row) in fit.correlation.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            let loose = [i, j].iter().any(|&k| {
                let parameter = &fit.parameters[k];
                parameter.standard_error.is_none()
                    || parameter.is_looser_than(SETTLED_ORDER, SETTLED)
            });
            if correlation.abs() > ONE && loose {
                advice.push(format!(
                    "the record cannot tell `{}` and `{}` apart (correlation {correlation:.4})",
                    names[j], names[i]
                ));
            }
        }
    }
    advice
}

fn loose(fit: &Fit) -> Vec<String> {
    let loose = fit.parameters.iter();
    let loose = loose.filter(|parameter| parameter.is_looser_than(LOOSE_ORDER, LOOSE));
    loose
        .map(|parameter| {
            let share = parameter.standard_error.unwrap_or(f64::INFINITY) / parameter.value;
            let size = if share > 1.0 {
                "larger than its value".to_owned()
            } else {
                format!("{:.0} % of its value", 100.0 * share)
            };
            format!(
                "the record hardly determines `{}`: its standard error is {size}",
                parameter.name
            )
        })
        .collect()
}

/// The best of those with fewer parameters, if it is as good.
pub(super) fn simpler(fit: &Fit, fits: &[Fit]) -> Option<String> {
    let fewer = fits
        .iter()
        .filter(|other| other.parameters.len() < fit.parameters.len());
    let good = fewer.filter(|other| other.bic <= fit.bic + AS_GOOD);
    let best = good.min_by(|a, b| a.bic.total_cmp(&b.bic))?;
    Some(format!(
        "the simpler {} is as good: BIC {:.1} against {:.1} with {} parameters against {}",
        best.kind,
        best.bic,
        fit.bic,
        best.parameters.len(),
        fit.parameters.len()
    ))
}

/// Bounds that the record does not give.
fn open(fit: &Fit) -> Vec<String> {
    let settled = |k: &usize| fit.correlation.get(*k).is_none_or(|row| !row[*k].is_nan());
    let settled = (0..fit.parameters.len()).filter(settled);
    settled
        .filter_map(|k| {
            let Estimate {
                name,
                low_95,
                high_95,
                ..
            } = &fit.parameters[k];
            let which = match (low_95, high_95) {
                (Some(_), Some(_)) => return None,
                (None, Some(_)) => "no lower bound",
                (Some(_), None) => "no upper bound",
                (None, None) => "no bound",
            };
            Some(format!("the record gives `{name}` {which}"))
        })
        .collect()
}

fn slow(fit: &Fit) -> Option<String> {
    let number = fit.predicted.len();
    (fit.independent < number as f64).then(|| {
        format!(
            "neighbouring residuals are alike, over {} samples on average: {number} count as {:.0}, and intervals are wider by that",
            Shown(digits(number as f64 / fit.independent)),
            fit.independent
        )
    })
}
