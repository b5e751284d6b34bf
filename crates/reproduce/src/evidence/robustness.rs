//! Claims 4 and 5: how much the stability region changes with the device and the hand.

use super::region::size;
use super::{Evidence, Formulas, falls, list};
use crate::{DELTA, Kind, MASS_KG, ORDERS, SAMPLE_TIME_S};
use haptic_analysis::AnalysisError;

/// Range in which the values fall strictly, in words.
fn falling(values: &[f64]) -> String {
    let last = values.len() - 1;
    let from = (0..last).find(|&start| falls(&values[start..]));
    let to = (1..last).rev().find(|&end| falls(&values[..=end]));
    match (from, to) {
        (Some(0), _) => "falls throughout".to_owned(),
        (Some(from), _) => format!("falls from μ = {} on", ORDERS[from]),
        (None, Some(to)) => format!("falls up to μ = {}, then rises", ORDERS[to]),
        (None, None) => "does not fall".to_owned(),
    }
}

/// k of the hand in figure 4.4 and in C4, N/m: our choice, the dissertation gives none.
const HAND_N_PER_M: f64 = 500.0;

/// δ and γ of section 4.4's device in that hand, with T, b and k times these factors.
pub(crate) fn varied(time: f64, damping: f64, hand: f64) -> (f64, f64) {
    let gamma = HAND_N_PER_M * SAMPLE_TIME_S * SAMPLE_TIME_S / MASS_KG;
    (time * damping * DELTA, time * time * hand * gamma)
}

/// Relative change of the region's area from half to twice a parameter, order by order. `at` gives δ and γ for a
/// factor on the parameter, `scale` what the area is multiplied by for an order and a factor.
fn area_changes(
    kind: Kind,
    at: impl Fn(f64) -> (f64, f64),
    scale: impl Fn(f64, f64) -> f64,
) -> Result<Vec<f64>, AnalysisError> {
    let change = |mu: f64| {
        let area = |factor: f64| {
            let (delta, gamma) = at(factor);
            Ok::<_, AnalysisError>(scale(mu, factor) * size(kind, mu, delta, gamma)?.2)
        };
        Ok((area(2.0)? - area(0.5)?).abs() / area(1.0)?)
    };
    ORDERS.into_iter().map(change).collect()
}

/// True if the areas change less and less with μ, with the hand (1) and without one (0); and the changes in words.
fn robust(
    kind: Kind,
    at: impl Fn(f64, f64) -> (f64, f64),
) -> Result<(bool, String), AnalysisError> {
    let with = area_changes(kind, |factor| at(factor, 1.0), |_, _| 1.0)?;
    let without = area_changes(kind, |factor| at(factor, 0.0), |_, _| 1.0)?;
    let words = format!(
        "relative change of the area: {} with the hand ({}), {} without one ({})",
        list(with.iter().copied()),
        falling(&with),
        list(without.iter().copied()),
        falling(&without)
    );
    Ok((falls(&with) && falls(&without), words))
}

pub(crate) fn robust_to_time(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let (holds, words) = robust(kind, |factor, hand| varied(factor, 1.0, hand))?;
    // α = KT²/m and β = BT^(2−μ)/m, so areas in K and B go with T^(−2)·T^(μ−2).
    let in_k_and_b = area_changes(
        kind,
        |factor| varied(factor, 1.0, 1.0),
        |mu, factor| factor.powf(mu - 4.0),
    )?;
    Ok(Evidence {
        holds,
        numbers: format!(
            "{words}; in the K–B plane, which does not decide, {} with the hand ({})",
            list(in_k_and_b.iter().copied()),
            falling(&in_k_and_b)
        ),
    })
}

pub(crate) fn robust_to_damping(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let (holds, numbers) = robust(kind, |factor, hand| varied(1.0, factor, hand))?;
    Ok(Evidence { holds, numbers })
}

pub(crate) fn robust_to_hand(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let gamma = 1000.0 * SAMPLE_TIME_S * SAMPLE_TIME_S / MASS_KG;
    let changes = ORDERS
        .iter()
        .map(|&mu| {
            let free = size(kind, mu, DELTA, 0.0)?.2;
            let held = size(kind, mu, DELTA, gamma)?.2;
            Ok((held / free - 1.0).abs())
        })
        .collect::<Result<Vec<f64>, AnalysisError>>()?;
    Ok(Evidence {
        holds: changes.iter().all(|change| *change < 0.05),
        numbers: format!(
            "relative change of the area: {}; it would hold at a limit of {:.1} %",
            list(changes.iter().copied()),
            100.0 * changes.iter().copied().fold(0.0, f64::max)
        ),
    })
}
