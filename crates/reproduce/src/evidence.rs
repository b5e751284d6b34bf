//! Evidence on each claim: the numbers that decide it, with either operator.

use super::relaxation::relaxation_error;
use super::{DELTA, Kind, MASS_KG, ORDERS, SAMPLE_TIME_S};
use fracdiff::{FrequencyResponse, Order, grunwald_weight};
use haptic_analysis::{
    AnalysisError, Coupler, Largest, LeastDamping, Nondimensional, OnePort, SampledLoop,
    SampledPlant, StabilityRegion, StableArea, corollary_delta,
};
use serde::Serialize;
use std::f64::consts::PI;

/// The formulas of the dissertation under test. A test replaces one and sees a verdict change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formulas {
    /// Corollary 1 (5.1): least δ from μ, α, β.
    pub(crate) passivity: fn(Order, f64, f64) -> Result<f64, AnalysisError>,
    /// Corollary 2 (5.20): least b from μ, T, `k_c`, `b_c`.
    pub(crate) coupling: fn(f64, f64, f64, f64) -> f64,
    /// Closed form of the tissue's stress (theory of figure 7.2), as a factor on it.
    pub(crate) stress_factor: f64,
}

impl Formulas {
    pub(crate) const DISSERTATION: Self = Self {
        passivity: corollary_delta,
        // 8b ≥ k_c + b_c(T/2)^μ
        coupling: |mu, t, k, b| (k + b * (0.5 * t).powf(mu)) / 8.0,
        stress_factor: 1.0,
    };
}

/// Evidence, or a number that the analysis refuses, which constants should not meet.
type Found = Result<Evidence, AnalysisError>;

/// Evidence on a claim with one operator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Evidence {
    /// True if the claim holds with it.
    pub holds: bool,
    /// The numbers that decide.
    pub numbers: String,
}

/// 0, 0.1, …, 2.
fn fine_orders() -> impl Iterator<Item = f64> {
    (0..=20).map(|i| f64::from(i) / 10.0)
}

fn list<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    let texts: Vec<String> = values.into_iter().map(|v| format!("{v:.4}")).collect();
    texts.join(", ")
}

fn falls(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] < pair[0])
}

/// The stability region of the device of section 4.4 with another δ and γ; `None` if empty.
pub(crate) fn region(
    kind: Kind,
    mu: f64,
    delta: f64,
    gamma: f64,
    points: usize,
) -> Result<Option<StableArea>, AnalysisError> {
    let operator = kind.operator(mu)?;
    let plant = SampledPlant::new(delta, gamma)?;
    let region = StabilityRegion::new(plant, &operator, 0, points)?;
    Ok(region.bounded().cloned())
}

/// Largest α, largest β and area of a region; zeros if empty.
fn size(kind: Kind, mu: f64, delta: f64, gamma: f64) -> Result<(f64, f64, f64), AnalysisError> {
    Ok(region(kind, mu, delta, gamma, 200)?
        .map_or((0.0, 0.0, 0.0), |r| (r.alpha_max, r.beta_max, r.area)))
}

pub(crate) fn area_grows(kind: Kind, _: &Formulas) -> Found {
    let areas = fine_orders()
        .map(|mu| Ok((mu, size(kind, mu, DELTA, 0.0)?.2)))
        .collect::<Result<Vec<_>, AnalysisError>>()?;
    let drawn = list(areas.iter().step_by(5).map(|(_, area)| area));
    let mut numbers = format!("area at μ = 0, 0.5, 1, 1.5, 2: {drawn}");
    let fall = areas.windows(2).find(|pair| pair[1].1 <= pair[0].1);
    if let Some([(from, before), (to, after)]) = fall {
        numbers += &format!("; it first falls from μ = {from} ({before:.4}) to {to} ({after:.4})");
    }
    Ok(Evidence {
        holds: fall.is_none(),
        numbers,
    })
}

pub(crate) fn stiffest_at_two(kind: Kind, _: &Formulas) -> Found {
    // The stiffest of the others: at 2 it would be the same number twice.
    let (mut order, mut below) = (0.0, 0.0);
    for mu in fine_orders().filter(|mu| *mu < 2.0) {
        let alpha = size(kind, mu, DELTA, 0.0)?.0;
        if alpha > below {
            (order, below) = (mu, alpha);
        }
    }
    let at_two = size(kind, 2.0, DELTA, 0.0)?.0;
    Ok(Evidence {
        holds: at_two > below,
        numbers: format!(
            "largest α = {at_two:.4} at μ = 2; of the orders below, {below:.4} at μ = {order}"
        ),
    })
}

pub(crate) fn largest_beta_falls(kind: Kind, _: &Formulas) -> Found {
    let before = size(kind, 1.5, DELTA, 0.0)?.1;
    let after = size(kind, 2.0, DELTA, 0.0)?.1;
    Ok(Evidence {
        holds: after < before,
        numbers: format!("largest β = {before:.4} at μ = 1.5, {after:.4} at μ = 2"),
    })
}

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
        list(&with),
        falling(&with),
        list(&without),
        falling(&without)
    );
    Ok((falls(&with) && falls(&without), words))
}

pub(crate) fn robust_to_time(kind: Kind, _: &Formulas) -> Found {
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
            list(&in_k_and_b),
            falling(&in_k_and_b)
        ),
    })
}

pub(crate) fn robust_to_damping(kind: Kind, _: &Formulas) -> Found {
    let (holds, numbers) = robust(kind, |factor, hand| varied(1.0, factor, hand))?;
    Ok(Evidence { holds, numbers })
}

pub(crate) fn robust_to_hand(kind: Kind, _: &Formulas) -> Found {
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
            list(&changes),
            100.0 * changes.iter().copied().fold(0.0, f64::max)
        ),
    })
}

/// α and β of the sensitivity, stable for all five orders.
pub(crate) const SENSITIVITY_WALL: Nondimensional = Nondimensional {
    alpha: 0.05,
    beta: 0.05,
    delta: DELTA,
    gamma: 0.0,
};

pub(crate) fn sensitivity_rises(kind: Kind, _: &Formulas) -> Found {
    let peaks = ORDERS
        .iter()
        .map(|&mu| {
            let operator = kind.operator(mu)?;
            let sampled = SampledLoop::new(SENSITIVITY_WALL, &operator, 0)?;
            Ok(20.0 * sampled.sensitivity_peak()?.value.log10())
        })
        .collect::<Result<Vec<f64>, AnalysisError>>()?;
    Ok(Evidence {
        holds: peaks.windows(2).all(|pair| pair[1] > pair[0]),
        numbers: format!("peak in dB: {}", list(&peaks)),
    })
}

/// α, β of walls on which the corollary is tried.
const WALLS: [(f64, f64); 3] = [(0.0, 1.0), (1.0, 0.0), (0.3, 0.7)];

pub(crate) fn corollary_one(kind: Kind, formulas: &Formulas) -> Found {
    // The largest needed over promised.
    let mut worst = (0.0_f64, 0.0, (0.0, 0.0), 0.0, 0.0);
    for mu in fine_orders() {
        let operator = kind.operator(mu)?;
        let order = Order::new(mu)?;
        let port = OnePort::new(&operator, order)?;
        for (alpha, beta) in WALLS {
            let required = port.required_delta(alpha, beta)?.delta;
            let promised = (formulas.passivity)(order, alpha, beta)?;
            let factor = required / promised;
            if factor > worst.0 {
                worst = (factor, mu, (alpha, beta), required, promised);
            }
        }
    }
    let (factor, mu, (alpha, beta), required, promised) = worst;
    let (alpha_c, beta_c) = WALLS[2];
    // Colgate: b > KT/2 + B, so δ > α/2 + β.
    let colgate =
        (formulas.passivity)(Order::new(1.0)?, alpha_c, beta_c)? - (0.5 * alpha_c + beta_c);
    let enough = factor <= 1.0 + 1e-9;
    let most = if enough {
        let share = 1.0 / factor;
        format!("the damping of (5.1) is enough, at least {share:.9} times what is needed")
    } else {
        format!(
            "not enough by a factor {factor:.3} at μ = {mu}, α = {alpha}, β = {beta}: δ = {required:.4} needed, \
             {promised:.4} promised"
        )
    };
    let one = if colgate == 0.0 {
        "is Colgate's".to_owned()
    } else {
        format!("differs from Colgate's by {colgate:.1e}")
    };
    Ok(Evidence {
        holds: enough && colgate.abs() <= 1e-9,
        numbers: format!("{most}; at μ = 1 it {one}"),
    })
}

/// Area of the passive walls in the α–β plane at the δ of section 4.4, by `steps` steps in α, from the largest down.
pub(crate) fn passive_boundary(
    kind: Kind,
    mu: f64,
    delta: f64,
    steps: usize,
) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let operator = kind.operator(mu)?;
    let port = OnePort::new(&operator, Order::new(mu)?)?;
    let Largest::Below { value: most, .. } = port.largest_alpha(delta, 0.0)? else {
        return Ok(Vec::new());
    };
    let points = (0..=steps).map(|step| {
        // A hair below the largest α, where the largest β is 0.
        let alpha = most * (1.0 - step as f64 / steps as f64).min(1.0 - 1e-9);
        Ok(match port.largest_beta(delta, alpha)? {
            Largest::Below { value, .. } => (value.max(0.0), alpha),
            _ => (0.0, alpha),
        })
    });
    points.collect()
}

pub(crate) fn passivity_region(kind: Kind, _: &Formulas) -> Found {
    let areas = (0..=8)
        .map(|quarter| {
            let boundary = passive_boundary(kind, f64::from(quarter) / 4.0, DELTA, 200)?;
            let trapezoids = boundary
                .windows(2)
                .map(|p| 0.5 * (p[0].1 - p[1].1) * (p[0].0 + p[1].0));
            Ok(trapezoids.sum())
        })
        .collect::<Result<Vec<f64>, AnalysisError>>()?;
    Ok(Evidence {
        holds: falls(&areas),
        numbers: format!(
            "area at μ = 0, 0.5, 1, 1.5, 2: {}",
            list(areas.iter().step_by(2))
        ),
    })
}

pub(crate) fn corollary_two(kind: Kind, formulas: &Formulas) -> Found {
    /// T, s, and couplers (`k_c`, `b_c`·(T/2)^μ), both in N·s/m.
    const T: f64 = 1e-3;
    const COUPLERS: [(f64, f64); 5] = [(1.0, 0.0), (1.0, 0.3), (1.0, 1.0), (0.3, 1.0), (0.0, 1.0)];
    let mut worst = (1.0_f64, 0.0, (0.0, 0.0));
    let mut active_above_one = true;
    for mu in [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0] {
        let operator = kind.operator(mu)?;
        for (k, scaled) in COUPLERS {
            let b = scaled / (0.5 * T).powf(mu);
            let exact = Coupler::exact(Order::new(mu)?, T, k, b)?;
            let coupler = match kind {
                Kind::Exact => exact,
                Kind::Muir => exact.with_operator(&operator, 4),
            };
            match coupler.least_damping()? {
                LeastDamping::Enough {
                    damping_n_s_per_m, ..
                } => {
                    if mu > 1.0 {
                        active_above_one &= b == 0.0;
                    } else {
                        let factor = damping_n_s_per_m / (formulas.coupling)(mu, T, k, b);
                        if factor > worst.0 {
                            worst = (factor, mu, (k, scaled));
                        }
                    }
                }
                LeastDamping::NoneIsEnough { .. } => {
                    if mu <= 1.0 {
                        worst = (f64::INFINITY, mu, (k, scaled));
                    }
                }
            }
        }
    }
    let (factor, mu, (k, b)) = worst;
    let sufficient = factor <= 1.0 + 1e-9;
    let above = ["some is enough", "none is enough"][usize::from(active_above_one)];
    let needs = match factor {
        _ if sufficient => "(5.20) is enough for all couplers".to_owned(),
        f64::INFINITY => format!("at μ = {mu}, k_c : b_c(T/2)^μ = {k} : {b} no damping is enough"),
        _ => format!(
            "at μ = {mu}, k_c : b_c(T/2)^μ = {k} : {b} the port needs {factor:.3} times (5.20)"
        ),
    };
    Ok(Evidence {
        holds: sufficient && active_above_one,
        numbers: format!("{needs}; for μ > 1 {above}"),
    })
}

pub(crate) fn effective_stiffness(kind: Kind, _: &Formulas) -> Found {
    let least = |mu: f64| -> Result<f64, AnalysisError> {
        let operator = kind.operator(mu)?;
        let real = (1..=4000).map(|i| operator.response(PI * f64::from(i) / 4000.0).re);
        Ok(real.fold(f64::INFINITY, f64::min))
    };
    let mut low = (f64::INFINITY, 0.0);
    for mu in fine_orders().filter(|mu| *mu <= 1.0) {
        let value = least(mu)?;
        if value < low.0 {
            low = (value, mu);
        }
    }
    let mut always_negative = true;
    for mu in fine_orders().filter(|mu| *mu > 1.0) {
        always_negative &= least(mu)? < 0.0;
    }
    let (low, mu) = low;
    let not = if always_negative { "" } else { "not always " };
    Ok(Evidence {
        // Rounding: Re P at μ = 1 tends to 0 at low frequency.
        holds: low >= -1e-12 && always_negative,
        numbers: format!(
            "least Re P for μ ≤ 1: {low:.2e} at μ = {mu}; for each μ > 1 it is {not}negative somewhere"
        ),
    })
}

/// μ of the cancerous prostate.
const TISSUE_ORDER: f64 = 0.2247;

pub(crate) fn short_memory(kind: Kind, _: &Formulas) -> Found {
    let order = Order::new(TISSUE_ORDER)?;
    // 200 s after the start of a 1 s ramp at 1 kHz the last 1000 samples are all on the hold, so a
    // short memory gives the sum of its weights.
    let (n, ramp) = (200_000_u64, 1000_u64);
    // Full history of a ramp 0, 1, 2, …: Σ c_{n−j}·j = c^(μ−1)_n·n/(1 − μ).
    let below = Order::new(TISSUE_ORDER - 1.0)?;
    let of_ramp = |n: u64| grunwald_weight(below, n) * n as f64 / (1.0 - TISSUE_ORDER);
    let full = (of_ramp(n) - of_ramp(n - ramp)) / ramp as f64;
    let short = match kind {
        // Σ_{j<1000} c_j
        Kind::Exact => grunwald_weight(below, ramp - 1),
        Kind::Muir => kind.operator(TISSUE_ORDER)?.response(0.0).re,
    };
    let slope = |j: u64| {
        let ratio = grunwald_weight(order, 2 * j) / grunwald_weight(order, j);
        -ratio.ln() / j as f64
    };
    let ratio = short / full;
    Ok(Evidence {
        holds: (ratio - 1.0).abs() < 0.01,
        numbers: format!(
            "force after 200 s: {ratio:.3} times the truth; decay rate of the weights per sample {:.1e} at lag 100, \
             {:.1e} at lag 100 000 (an exponential would have one)",
            slope(100),
            slope(100_000)
        ),
    })
}

pub(crate) fn relaxation(kind: Kind, formulas: &Formulas) -> Found {
    let error = relaxation_error(kind, formulas.stress_factor)?;
    Ok(Evidence {
        holds: error < 0.01,
        numbers: format!(
            "largest relative deviation from the closed form, 1.1 s to 200 s: {error:.2e}"
        ),
    })
}
