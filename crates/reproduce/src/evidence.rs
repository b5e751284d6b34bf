//! Evidence on each claim: the numbers that decide it, with an operator.

use super::relaxation::{constants, relaxation_error};
use super::trial::{realistic, simulated};
use super::{DELTA, Kind, MASS_KG, ORDERS, SAMPLE_TIME_S};
use fracdiff::{FrequencyResponse, Order, grunwald_weight, muir_coefficients};
use haptic_analysis::{
    AnalysisError, Coupler, Effective, ForcePath, Largest, LoopOperator, Nondimensional, OnePort,
    SampledLoop, SampledPlant, SampledWall, StabilityRegion, StableArea, corollary_delta,
};
use serde::Serialize;
use std::f64::consts::PI;
use std::sync::Arc;

/// Corollary 1 (5.1): least δ from μ, α, β. A test tries another one and sees a verdict change.
pub(crate) type Passivity = fn(Order, f64, f64) -> Result<f64, AnalysisError>;
/// Corollary 2 (5.20): least b from μ, T, `k_c`, `b_c`.
pub(crate) type Coupling = fn(f64, f64, f64, f64) -> f64;

/// Verdict of one operator on a claim, and the numbers that decide. An error would be of the constants here.
pub(crate) type Found = Result<(Verdict, String), AnalysisError>;

/// Verdict of one operator: `None` where the claim holds for some values of numbers that the dissertation
/// does not print, and not for others.
pub(crate) type Verdict = Option<bool>;

/// The verdict over all values tried of numbers that the dissertation does not print.
fn over_all(held: &[bool]) -> Verdict {
    let agree = held.iter().all(|one| *one == held[0]);
    agree.then(|| held[0])
}

/// Evidence on a claim with one operator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Evidence {
    /// The operator that the claim was computed with, in its notation.
    pub operator: &'static str,
    /// True if the claim holds with it; `None`, in JSON null, if that depends on numbers that the
    /// dissertation does not print.
    pub holds: Option<bool>,
    /// The numbers that decide, in words, so that a reader can judge again.
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

fn rises(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] > pair[0])
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

pub(crate) fn area_grows(kind: Kind) -> Found {
    let area = |mu| Ok(size(kind, mu, DELTA, 0.0)?.2);
    let drawn = ORDERS.into_iter().map(area);
    let drawn = drawn.collect::<Result<Vec<f64>, AnalysisError>>()?;
    let mut numbers = format!("area at μ = 0, 0.5, 1, 1.5, 2: {}", list(&drawn));
    let fine = fine_orders().map(|mu| Ok((mu, area(mu)?)));
    let fine = fine.collect::<Result<Vec<_>, AnalysisError>>()?;
    let fall = fine.windows(2).find(|pair| pair[1].1 <= pair[0].1);
    if let Some([(from, before), (to, after)]) = fall {
        let percent = 100.0 * (1.0 - after / before);
        numbers += &format!(
            "; in steps of 0.1 it falls by {percent:.1} % from μ = {from} ({before:.4}) to {to} ({after:.4})"
        );
    }
    if kind == Kind::Muir {
        let [middle, two] = [1.5, 2.0].map(split_area);
        numbers += &format!(
            "; if μ > 1 is read as (1 − w)·A₃(μ − 1): {:.4} at 1.5, {:.4} at 2",
            middle?, two?
        );
    }
    Ok((Some(rises(&drawn)), numbers))
}

/// The stability area with (1 − w)·A₃(μ − 1), another reading of (4.2) for μ > 1, without a static force.
fn split_area(mu: f64) -> Result<f64, AnalysisError> {
    let mut below = [0.0; 4];
    muir_coefficients(Order::new(mu - 1.0)?, &mut below);
    let shifted = [0.0].iter().chain(&below);
    let split = below.iter().chain(&[0.0]).zip(shifted).map(|(p, q)| p - q);
    let operator = LoopOperator::from_polynomial(Order::new(mu)?, split.collect())?;
    let region = StabilityRegion::new(SampledPlant::new(DELTA, 0.0)?, &operator, 0, 200)?;
    Ok(region.bounded().map_or(0.0, |area| area.area))
}

pub(crate) fn stiffest_at_two(kind: Kind) -> Found {
    // The stiffest of the others: at 2 it would be the same number twice.
    let (mut order, mut below) = (0.0, 0.0);
    for mu in fine_orders().filter(|mu| *mu < 2.0) {
        let alpha = size(kind, mu, DELTA, 0.0)?.0;
        if alpha > below {
            (order, below) = (mu, alpha);
        }
    }
    let at_two = size(kind, 2.0, DELTA, 0.0)?.0;
    Ok((
        Some(at_two > below),
        format!("largest α = {at_two:.4} at μ = 2; of the orders below, {below:.4} at μ = {order}"),
    ))
}

pub(crate) fn largest_beta_falls(kind: Kind) -> Found {
    let before = size(kind, 1.5, DELTA, 0.0)?.1;
    let after = size(kind, 2.0, DELTA, 0.0)?.1;
    Ok((
        Some(after < before),
        format!("largest β = {before:.4} at μ = 1.5, {after:.4} at μ = 2"),
    ))
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

/// Does the area move with a parameter in one direction at each order, and change less and less with μ, with the hand
/// and without one? `at` gives δ and γ for factors on the parameter and the hand, `scale` what the area is multiplied by.
fn robust(
    kind: Kind,
    direction: &str,
    at: impl Fn(f64, f64) -> (f64, f64),
    scale: impl Fn(f64, f64) -> f64,
) -> Result<Robust, AnalysisError> {
    let (mut moves, mut falls_with_order, mut words) = (true, true, Vec::new());
    for (hand, name) in [(1.0, "with the hand"), (0.0, "without one")] {
        let mut areas = Vec::new();
        for mu in ORDERS {
            let mut area = [0.5, 1.0, 2.0];
            for factor in &mut area {
                let (delta, gamma) = at(*factor, hand);
                *factor = scale(mu, *factor) * size(kind, mu, delta, gamma)?.2;
            }
            areas.push(area);
        }
        let [shrinks, grows] = [falls, rises].map(|moves| areas.iter().all(|area| moves(area)));
        let found = ["neither grows nor shrinks throughout", "shrinks", "grows"]
            [usize::from(shrinks) + 2 * usize::from(grows)];
        let changes: Vec<f64> =
            (areas.iter().map(|area| (area[2] - area[0]).abs() / area[1])).collect();
        let (at_one, change, how) = (list(&areas[2]), list(&changes), falling(&changes));
        moves &= found == direction;
        falls_with_order &= falls(&changes);
        words.push(format!(
            "{name} it {found} ({at_one} at μ = 1), by {change} ({how})"
        ));
    }
    Ok(Robust {
        moves,
        falls_with_order,
        words: words.join(", "),
    })
}

/// A region against a parameter: its area moves in the direction at each order, and its change falls with μ.
struct Robust {
    moves: bool,
    falls_with_order: bool,
    words: String,
}

/// The region over T in the plane of α and β and in that of K and B, and the numbers in words.
fn over_time(kind: Kind) -> Result<([Robust; 2], String), AnalysisError> {
    let at = |factor: f64, hand: f64| varied(factor, 1.0, hand);
    let nondimensional = robust(kind, "shrinks", at, |_, _| 1.0)?;
    // α = KT²/m and β = BT^(2−μ)/m, so areas in K and B go with T^(−2)·T^(μ−2).
    let with_units = robust(kind, "shrinks", at, |mu, factor| {
        libm::pow(factor, mu - 4.0)
    })?;
    let numbers = format!(
        "area in α and β: {}; in K and B, over α and β of once T: {}",
        nondimensional.words, with_units.words
    );
    Ok(([nondimensional, with_units], numbers))
}

pub(crate) fn shrinks_over_time(kind: Kind) -> Found {
    let (planes, numbers) = over_time(kind)?;
    Ok((Some(planes.iter().any(|plane| plane.moves)), numbers))
}

pub(crate) fn robust_to_time(kind: Kind) -> Found {
    let (planes, numbers) = over_time(kind)?;
    let holds = |plane: &Robust| plane.moves && plane.falls_with_order;
    Ok((Some(planes.iter().any(holds)), numbers))
}

pub(crate) fn robust_to_damping(kind: Kind) -> Found {
    let at = |factor: f64, hand: f64| varied(1.0, factor, hand);
    let over = robust(kind, "grows", at, |_, _| 1.0)?;
    Ok((Some(over.moves && over.falls_with_order), over.words))
}

pub(crate) fn robust_to_hand(kind: Kind) -> Found {
    let gamma = 1000.0 * SAMPLE_TIME_S * SAMPLE_TIME_S / MASS_KG;
    let changes = ORDERS
        .iter()
        .map(|&mu| {
            let free = size(kind, mu, DELTA, 0.0)?.2;
            let held = size(kind, mu, DELTA, gamma)?.2;
            Ok((held / free - 1.0).abs())
        })
        .collect::<Result<Vec<f64>, AnalysisError>>()?;
    Ok((
        Some(changes.iter().all(|change| *change < 0.05)),
        format!(
            "relative change of the area: {}; it would hold at a limit of {:.1} %",
            list(&changes),
            100.0 * changes.iter().copied().fold(0.0, f64::max)
        ),
    ))
}

/// α and β of figure 4.5, stable for all five orders.
pub(crate) const SENSITIVITY_WALL: Nondimensional = Nondimensional {
    alpha: 0.05,
    beta: 0.05,
    delta: DELTA,
    gamma: 0.0,
};

/// Peaks of the sensitivity over the orders, in dB; `None` if an order makes the loop unstable.
fn peaks(kind: Kind, wall: Nondimensional) -> Result<Option<Vec<f64>>, AnalysisError> {
    let peak = |mu: f64| {
        let operator = kind.operator(mu)?;
        let sampled = SampledLoop::new(wall, &operator, 0)?;
        Ok(if sampled.is_stable() {
            Some(20.0 * libm::log10(sampled.sensitivity_peak()?.value))
        } else {
            None
        })
    };
    ORDERS.into_iter().map(peak).collect()
}

/// A wall on which the peak does rise with μ over the five orders: whether the claim holds depends on the wall.
const RISING_WALL: Nondimensional = Nondimensional {
    alpha: 0.6146,
    beta: 1.6764,
    delta: 7.2854,
    gamma: 0.0,
};

pub(crate) fn sensitivity_rises(kind: Kind) -> Found {
    let three = [0.5, 1.0, 2.0].into_iter();
    let devices = three.flat_map(|b| [varied(1.0, b, 0.0), varied(1.0, b, 1.0)]);
    let mut walls = vec![RISING_WALL];
    for (delta, gamma) in devices {
        for alpha in [0.01, 0.02, 0.05, 0.1, 0.2] {
            for beta in [1e-4, 1e-3, 0.01, 0.05, 0.1] {
                walls.push(Nondimensional {
                    alpha,
                    beta,
                    delta,
                    gamma,
                });
            }
        }
    }
    let mut held = Vec::new();
    for wall in walls {
        held.extend(peaks(kind, wall)?.map(|peaks| rises(&peaks)));
    }
    let drawn = |wall| Ok::<_, AnalysisError>(list(&peaks(kind, wall)?.unwrap_or_default()));
    let numbers = format!(
        "it holds for {} of {} walls; peaks in dB: {} for α = 0.6146, β = 1.6764, δ = 7.2854; {} for figure 4.5's",
        held.iter().filter(|held| **held).count(),
        held.len(),
        drawn(RISING_WALL)?,
        drawn(SENSITIVITY_WALL)?
    );
    Ok((over_all(&held), numbers))
}

/// α, β of walls on which the corollary is tried.
const WALLS: [(f64, f64); 3] = [(0.0, 1.0), (1.0, 0.0), (0.3, 0.7)];

/// The largest factor by which (5.1) promises too little damping, at which μ, α and β.
fn shortfall(kind: Kind, passivity: Passivity) -> Result<(f64, f64, f64, f64), AnalysisError> {
    let mut worst = (0.0_f64, 0.0, 0.0, 0.0);
    for mu in fine_orders() {
        let operator = kind.operator(mu)?;
        let order = Order::new(mu)?;
        let port = OnePort::new(&operator, order)?;
        for (alpha, beta) in WALLS {
            let required = port.required_delta(alpha, beta)?.delta;
            let factor = required / passivity(order, alpha, beta)?;
            if factor > worst.0 {
                worst = (factor, mu, alpha, beta);
            }
        }
    }
    Ok(worst)
}

pub(crate) fn corollary_one(kind: Kind) -> Found {
    is_enough(kind, corollary_delta)
}

/// True if a condition gives damping enough for Theorem 1, and Colgate's at μ = 1.
pub(crate) fn is_enough(kind: Kind, passivity: Passivity) -> Found {
    let (factor, mu, alpha, beta) = shortfall(kind, passivity)?;
    let (alpha_c, beta_c) = WALLS[2];
    // Colgate: b > KT/2 + B, so δ > α/2 + β.
    let colgate = passivity(Order::new(1.0)?, alpha_c, beta_c)? - (0.5 * alpha_c + beta_c);
    let enough = factor <= 1.0 + 1e-9;
    let most = if enough {
        let share = 1.0 / factor;
        format!("the damping of (5.1) is enough, at least {share:.9} times what is needed")
    } else {
        format!("too little by a factor {factor:.3} at μ = {mu}, α = {alpha}, β = {beta}")
    };
    let one = if colgate == 0.0 {
        "is Colgate's".to_owned()
    } else {
        format!("differs from Colgate's by {colgate:.1e}")
    };
    let (muir, at, ..) = shortfall(Kind::Muir, passivity)?;
    Ok((
        Some(enough && colgate.abs() <= 1e-9),
        format!(
            "{most}; at μ = 1 it {one}; a warning: a loop that runs A₃ of chapter 4 needs up to {muir:.3} times as much \
             (at μ = {at})"
        ),
    ))
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
            Largest::Any | Largest::Empty => (0.0, alpha),
        })
    });
    points.collect()
}

/// Area between a boundary, as β and α from one axis to the other, and the axes.
fn area_under(boundary: &[(f64, f64)]) -> f64 {
    area_above(boundary, 0.0)
}

/// Area between a boundary, as β and α, and the line α = `slope`·β, where the boundary is above it.
fn area_above(boundary: &[(f64, f64)], slope: f64) -> f64 {
    let trapezoids = boundary.windows(2).map(|pair| {
        let [from, to] = [pair[0], pair[1]].map(|(beta, alpha)| alpha - slope * beta);
        let width = pair[1].0 - pair[0].0;
        match (from >= 0.0, to >= 0.0) {
            (true, true) => 0.5 * width * (from + to),
            (false, false) => 0.0,
            // A triangle up to where the two lines cross.
            (true, false) | (false, true) => {
                let above = from.max(to);
                0.5 * width * above * above / (from - to).abs()
            }
        }
    });
    trapezoids.sum()
}

pub(crate) fn passivity_region(kind: Kind) -> Found {
    let area = |mu| Ok(area_under(&passive_boundary(kind, mu, DELTA, 200)?));
    let quarters = (0..=8).map(|quarter| area(f64::from(quarter) / 4.0));
    let areas = quarters.collect::<Result<Vec<f64>, AnalysisError>>()?;
    let drawn = list(areas.iter().step_by(2));
    let numbers = format!("area at μ = 0, 0.5, 1, 1.5, 2: {drawn}");
    Ok((Some(falls(&areas)), numbers))
}

pub(crate) fn corollary_two(_: Kind) -> Found {
    // 8b ≥ k_c + b_c(T/2)^μ
    meets_llewellyn(|mu, t, k, b| (k + b * libm::pow(0.5 * t, mu)) / 8.0)
}

/// True if a condition gives damping enough for Llewellyn's criterion up to order 1, and none is enough beyond.
pub(crate) fn meets_llewellyn(coupling: Coupling) -> Found {
    /// T, s, and couplers (`k_c`, `b_c`·(T/2)^μ), both in N·s/m.
    const T: f64 = 1e-3;
    const COUPLERS: [(f64, f64); 5] = [(1.0, 0.0), (1.0, 0.3), (1.0, 1.0), (0.3, 1.0), (0.0, 1.0)];
    // Damping that the port needs over that of (5.20), with μ and the coupler.
    let mut needs = Vec::new();
    let mut active_above_one = true;
    for mu in [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0] {
        for (k, scaled) in COUPLERS {
            let b = scaled / libm::pow(0.5 * T, mu);
            let needed = Coupler::exact(Order::new(mu)?, T, k, b)?
                .least_damping()?
                .damping_n_s_per_m()
                .unwrap_or(f64::INFINITY);
            if mu <= 1.0 {
                needs.push((needed / coupling(mu, T, k, b), mu, k, scaled));
            } else {
                active_above_one &= needed.is_infinite() || b == 0.0;
            }
        }
    }
    needs.sort_by(|one, other| one.0.total_cmp(&other.0));
    let sufficient = needs.iter().filter(|one| one.0 <= 1.0 + 1e-9).count();
    let (worst, mu, k, b) = needs[needs.len() - 1];
    let above = ["some is enough", "none is enough"][usize::from(active_above_one)];
    Ok((
        Some(sufficient == needs.len() && active_above_one),
        format!(
            "(5.20) is enough for {sufficient} of {} couplers; the port needs {:.3} times as much in the median, {worst:.3} \
             times at worst (μ = {mu}, k_c : b_c(T/2)^μ = {k} : {b}); for μ > 1 {above}",
            needs.len(),
            needs[needs.len() / 2].0
        ),
    ))
}

/// Below the Nyquist frequency, the least of a share that the B term alone has (B = 1, T = 1 s), and the first θ at which
/// it is not positive; behind the hold if `held`.
fn least(
    kind: Kind,
    mu: f64,
    held: bool,
    share: fn(&Effective) -> f64,
) -> Result<(f64, Option<f64>), AnalysisError> {
    let environment = SampledWall {
        stiffness_n_per_m: 0.0,
        dissipation_n_s_mu_per_m: 1.0,
        order: Order::new(mu)?,
        sample_time_s: 1.0,
    };
    let operator = kind.response(mu)?;
    let mut found = (f64::INFINITY, None);
    for theta in (1..4000).map(|i| PI * f64::from(i) / 4000.0) {
        let at = if held {
            environment.felt_on(0.0.into(), ForcePath::NONE, &operator, theta)
        } else {
            environment.effective(&operator, theta)
        };
        let value = share(&at?);
        found = (
            found.0.min(value),
            found.1.or((value <= 0.0).then_some(theta)),
        );
    }
    Ok(found)
}

fn damping(at: &Effective) -> f64 {
    at.damping_n_s_per_m
}

pub(crate) fn effective_stiffness(kind: Kind) -> Found {
    let (mut low, mut always_negative) = (f64::INFINITY, true);
    for mu in fine_orders() {
        let (value, _) = least(kind, mu, kind == Kind::Continuous, |at| {
            at.stiffness_n_per_m
        })?;
        if mu > 1.0 {
            always_negative &= value < 0.0;
        } else {
            low = low.min(value);
        }
    }
    let not = if always_negative { "" } else { "not always " };
    let numbers = format!(
        "least share of B for μ ≤ 1: {low:.1e}; for each μ > 1 it is {not}negative somewhere"
    );
    // Rounding: at μ = 1 the share tends to 0 at low frequency.
    Ok((Some(low >= -1e-12 && always_negative), numbers))
}

pub(crate) fn damps(kind: Kind) -> Found {
    let mut lowers = Vec::new();
    for mu in fine_orders().filter(|mu| *mu >= 1.0) {
        let (_, first) = least(kind, mu, true, damping)?;
        lowers.extend(first.map(|theta| format!("from θ = {theta:.3} at μ = {mu}")));
    }
    let numbers = if lowers.is_empty() {
        "it raises the damping at every frequency".to_owned()
    } else {
        format!("it lowers the damping {}", lowers.join(", "))
    };
    Ok((Some(lowers.is_empty()), numbers))
}

/// The least damping of the orders between 0 and 2.
fn least_damping(kind: Kind) -> Result<f64, AnalysisError> {
    let mut low = f64::INFINITY;
    for mu in fine_orders().filter(|mu| *mu > 0.0 && *mu < 2.0) {
        low = low.min(least(kind, mu, false, damping)?.0);
    }
    Ok(low)
}

pub(crate) fn positive_damping(kind: Kind) -> Found {
    let low = least_damping(kind)?;
    Ok((Some(low > 0.0), format!("damping at least {low:.1e}")))
}

pub(crate) fn stores(kind: Kind) -> Found {
    let low = least_damping(kind)?;
    let most = |mu| Ok::<_, AnalysisError>(-least(kind, mu, false, |at| -damping(at))?.0);
    let [none, two] = [most(0.0)?, most(2.0)?];
    let numbers = format!(
        "damping between at least {low:.1e}; at most {none:.1e} at μ = 0, {two:.1e} at μ = 2"
    );
    Ok((Some(low > 0.0 && none.max(two) < 1e-12), numbers))
}

pub(crate) fn classical(kind: Kind) -> Found {
    let (operator, difference) = (kind.response(1.0)?, Kind::Exact.response(1.0)?);
    let gain = |theta| operator.response(theta) / difference.response(theta);
    let apart = (1..=4000).map(|i| (gain(PI * f64::from(i) / 4000.0) - 1.0).norm());
    let [rest, middle] = [1e-6, 0.5 * PI].map(|theta| gain(theta).norm());
    let numbers =
        format!("gain over that of 1 − w: {rest:.4} at low frequency, {middle:.4} at θ = π/2");
    Ok((Some(apart.fold(0.0, f64::max) < 1e-12), numbers))
}

/// Delay and current lag of simulated devices, ms: those of the dissertation's device are not printed.
const LATE_MS: [(f64, f64); 4] = [(0.0, 0.0), (0.1, 0.1), (0.25, 0.25), (1.0, 1.0)];

pub(crate) fn experiments(kind: Kind) -> Found {
    let mut theory = Vec::new();
    for mu in ORDERS {
        // Beneath α = −P(1)·β the wall is a negative spring at rest, which is not in theory's region.
        let wedge = -kind.operator(mu)?.response(0.0).re;
        theory.push((size(kind, mu, DELTA, 0.0)?.2, wedge.max(0.0)));
    }
    let (mut held, mut words) = (Vec::new(), Vec::new());
    for (delay, lag) in LATE_MS {
        let device = format!("points = 5\n{}", realistic(delay, lag));
        let boundaries = simulated(kind, &device, &Arc::default()).map_err(constants)?;
        let mut largest = boundaries
            .iter()
            .map(|points| points.iter().map(|point| point.0).fold(0.0, f64::max));
        let areas = boundaries.iter().zip(&theory);
        let lost: Vec<f64> = areas
            .map(|(points, (area, wedge))| 1.0 - area_above(points, *wedge) / area)
            .collect();
        let [before, after] = [largest.nth(3), largest.next()].map(Option::unwrap_or_default);
        let holds = after < before && rises(&lost);
        held.push(holds);
        words.push(format!(
            "{} with a delay of {delay} ms and a lag of {lag} ms (largest β {before:.4}, {after:.4} at μ = 1.5, 2; \
             share of the area lost {})",
            if holds { "yes" } else { "no" },
            list(&lost)
        ));
    }
    Ok((over_all(&held), words.join("; ")))
}

/// μ of the cancerous prostate.
const TISSUE_ORDER: f64 = 0.2247;

pub(crate) fn short_memory(_: Kind) -> Found {
    let order = Order::new(TISSUE_ORDER)?;
    // 200 s after the start of a 1 s ramp at 1 kHz the last 1000 samples are all on the hold, so a
    // short memory gives the sum of its weights.
    let (n, ramp) = (200_000_u64, 1000_u64);
    // Full history of a ramp 0, 1, 2, …: Σ c_{n−j}·j = c^(μ−1)_n·n/(1 − μ).
    let below = Order::new(TISSUE_ORDER - 1.0)?;
    let of_ramp = |n: u64| grunwald_weight(below, n) * n as f64 / (1.0 - TISSUE_ORDER);
    let full = (of_ramp(n) - of_ramp(n - ramp)) / ramp as f64;
    // Σ_{j<1000} c_j
    let short = grunwald_weight(below, ramp - 1);
    let slope = |j: u64| {
        let ratio = grunwald_weight(order, 2 * j) / grunwald_weight(order, j);
        -libm::log(ratio) / j as f64
    };
    let ratio = short / full;
    Ok((
        Some((ratio - 1.0).abs() < 0.01),
        format!(
            "force after 200 s: {ratio:.3} times the truth; decay rate of the weights per sample {:.1e} at lag 100, \
             {:.1e} at lag 100 000 (an exponential would have one)",
            slope(100),
            slope(100_000)
        ),
    ))
}

pub(crate) fn relaxation(kind: Kind) -> Found {
    follows(kind, 1.0)
}

/// True if the rendered relaxation follows so many times the closed form of the tissue's stress (theory of figure 7.2).
pub(crate) fn follows(kind: Kind, times: f64) -> Found {
    let error = relaxation_error(kind, times)?;
    Ok((
        Some(error < 0.01),
        format!("largest relative deviation from the closed form, 1.1 s to 200 s: {error:.2e}"),
    ))
}
