//! The body of each order that bears all hands and worlds with the least effort.
//! ```text
//! for α in 0, 0.1 … 1.5, and the lagged mass:   the least of effort(m, b), every hand and world of the box proved
//! effort² = Σ W(f)·|m·p(f) + b|²/|G·H|² grows with m   ⇒   for each b the least m that is proved, and the best b by golden sections
//! ```
//! - *Opponents* of a fractional body are a mass with a damper, and the lagged mass, which has three numbers too.
//! - *Noise* is beside effort: what is light for the hand at low frequencies is light for the sensor's noise at high ones.
//! - *Tried*: each body in virtual time, with noise and counts of the sensor; one that does not settle is not called the best.
//! - *A front* has several factors on the hands, each damping its least m: what none beats in effort, noise and factor.
//! - *Cost*: some 400 proofs an order, 1200 of a front.

use crate::analysis::admittance::moving::Around;
use crate::analysis::admittance::trial::trials;
use crate::analysis::answer::{BodyPoint, HORIZON};
use crate::analysis::keys::HAND_MARGIN;
use crate::bench::{for_each_order, minimum_of, unbeaten};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{AdmittanceNumber, AdmittanceWorld, EffortWeight, LoopOperator};
use haptic_document::{Failure, Rows, rows};
use haptic_quantity::digits;
use haptic_trial::advice::analysed;
use haptic_trial::robot::BodyValues;
use serde_json::{Value, json};
use std::cell::Cell;
use std::cmp::Ordering;
use std::sync::atomic::AtomicBool;

/// Orders that are tried: so many tenths, from 0 on.
const TENTHS: u32 = 15;
/// Lags of a lagged mass, each twice the one before, and parts of such a step.
const LAGS: u32 = 8;
const FINER: i32 = 6;
/// Dampings that are tried first, N·s/m, and sections of the best gap.
const DAMPINGS: u32 = 19;
const DAMPING_LEAST: f64 = 0.02;
const DAMPING_MOST: f64 = 300.0;
const SECTIONS: usize = 14;
/// Shares of the world with which corners are looked at.
const WORLDS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0];
/// Inertances of an interval that are tried, from just inside of it on, and halvings between two of them.
const STEPS: u32 = 12;
const INSIDE: f64 = 1.0001;
const HALVINGS: u32 = 10;
const INERTANCE_LEAST: f64 = 1e-4;
const INERTANCE_MOST: f64 = 1e4;
/// Orders of a front, so many tenths apart, and the margins of its bodies in the one that is asked for.
const FRONT_TENTHS: u32 = 2;
const MARGINS: [f64; 5] = [1.0, 1.25, 1.6, 2.0, 2.5];
/// Bodies that differ by no larger share are one choice.
const ALIKE: f64 = 0.1;

/// The best bodies, by rising order, the lagged mass last.
pub(super) struct Best {
    bodies: Vec<(BodyValues, BodyPoint)>,
    /// Place of the one of least effort without a lag.
    best: usize,
}

impl Best {
    pub(super) const STEPS: u64 = (TENTHS + 1 + LAGS) as u64 + 2 * (FINER as u64 - 1);

    pub(super) fn body(&self) -> &BodyValues {
        &self.bodies[self.best].0
    }

    pub(super) fn points(&self) -> Vec<BodyPoint> {
        self.bodies.iter().map(|(_, point)| *point).collect()
    }

    /// The candidates, and what the order is worth.
    pub(super) fn rows(&self) -> Rows {
        let best = &self.bodies[self.best].1;
        let points = self.bodies.iter().map(|(_, point)| point);
        let lagged = points.clone().find(|point| point.body_lag_s.is_some());
        let mass = points.clone().find(|point| point.is_mass_and_damper());
        let against = |name: &str, other: Option<&BodyPoint>| {
            let Some(other) = other else {
                return format!("{name} does not bear these hands");
            };
            format!(
                "{name} needs {} N·s/m with {} times the noise",
                digits(other.effort_n_s_per_m, 3),
                digits(other.command_noise / best.command_noise, 3)
            )
        };
        let worth = format!(
            "order {} needs {} N·s/m; {}; {}",
            digits(best.body_order, 3),
            digits(best.effort_n_s_per_m, 3),
            against("a mass with a damper", mass),
            against("a lagged mass", lagged)
        );
        rows([json!({
            "worth_of_the_order": worth,
            "candidates": points.map(|point| json!(point)).collect::<Vec<Value>>(),
        })])
    }
}

/// Bodies that none beats in effort, noise of the command and factor on the hands; of bodies that are alike to a tenth, one.
pub(super) struct Front {
    pub(super) points: Vec<BodyPoint>,
    compared: usize,
}

impl Front {
    pub(super) const STEPS: u64 = (TENTHS / FRONT_TENTHS + 1 + LAGS) as u64;

    /// Those of each order and lag, over dampings and factors, and the best ones. Each has settled in its trials, if its world is tried.
    ///
    /// # Errors
    /// A search that was stopped.
    pub(super) fn of(
        best: &Best,
        around: &Around,
        margin: f64,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
    ) -> Result<Self, Failure> {
        let orders = (0..=TENTHS).step_by(FRONT_TENTHS as usize);
        let kinds: Vec<_> = orders.map(of_order).chain(lags(around)).collect();
        let t = around.place.robot.sample_time_s();
        let found = for_each_order(&kinds, stop, progress, |kind| {
            let body = body_of(kind, t)?;
            let mut bodies = Vec::new();
            for factor in MARGINS.map(|factor| margin * factor) {
                let wide = around.with_margin(factor);
                for damping in dampings() {
                    let body = BodyValues {
                        damping,
                        ..body.clone()
                    };
                    let Some(inertance) = least_inertance(&wide, &body)? else {
                        continue;
                    };
                    let body = BodyValues { inertance, ..body };
                    let point = point(around, &body, factor)?;
                    bodies.push((body, point));
                }
            }
            Ok(bodies)
        })?;
        let mut bodies = found.concat();
        bodies.extend(best.bodies.iter().cloned());
        let compared = bodies.len();
        loop {
            let merits = |(_, point): &(BodyValues, BodyPoint)| {
                let price = [point.effort_n_s_per_m, point.command_noise];
                [-price[0], -price[1], point.hand_margin]
            };
            let kept = unbeaten(&bodies, merits).into_iter();
            let untried = kept.filter(|&n| bodies[n].1.settled.is_none());
            let untried: Vec<usize> = untried.collect();
            let tried = for_each_order(&untried, stop, &|_| {}, |n| settles(around, &bodies[n].0))?;
            for (&n, settled) in untried.iter().zip(&tried) {
                bodies[n].1.settled = *settled;
            }
            let all = bodies.len();
            bodies.retain(|(_, point)| point.settled != Some(false));
            if bodies.len() == all {
                let kept = unbeaten(&bodies, merits).into_iter();
                let points = apart(kept.map(|n| bodies[n].1).collect());
                return Ok(Self { points, compared });
            }
        }
    }

    pub(super) fn rows(&self) -> Rows {
        rows([json!({
            "compared": self.compared,
            "front": self.points,
        })])
    }
}

/// Bodies of a front, by lag, order, factor and noise. Nobody chooses between bodies that are alike in all three merits:
/// the one of less effort stands for the others.
fn apart(mut points: Vec<BodyPoint>) -> Vec<BodyPoint> {
    points.sort_by(|a, b| a.effort_n_s_per_m.total_cmp(&b.effort_n_s_per_m));
    let mut apart: Vec<BodyPoint> = Vec::new();
    for point in points {
        if !apart.iter().any(|other| is_nearly_as_good(other, &point)) {
            apart.push(point);
        }
    }
    let key = |point: &BodyPoint| {
        let lag_s = point.body_lag_s.unwrap_or(-1.0);
        let place = [lag_s, point.body_order, point.hand_margin];
        (place, point.command_noise)
    };
    apart.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
    apart
}

fn is_nearly_as_good(one: &BodyPoint, other: &BodyPoint) -> bool {
    one.effort_n_s_per_m <= (1.0 + ALIKE) * other.effort_n_s_per_m
        && one.command_noise <= (1.0 + ALIKE) * other.command_noise
        && one.hand_margin >= other.hand_margin
}

/// The best body of all that settle.
///
/// # Errors
/// No body that bears these hands, or that settles in its trials; a search that was stopped.
pub(super) fn bodies(
    around: &Around,
    margin: f64,
    progress: &(dyn Fn(u64) + Sync),
    stop: &AtomicBool,
) -> Result<Best, Failure> {
    let bodies = candidates(around, margin, progress, stop)?;
    let best = bodies.iter().enumerate().filter(|(_, (body, point))| {
        // The lagged mass is an opponent.
        body.lag_s.is_none() && point.settled != Some(false)
    });
    let best = best.min_by(|a, b| effort(a.1).total_cmp(&effort(b.1)));
    let Some(best) = best.map(|(index, _)| index) else {
        let why = if bodies.is_empty() {
            "no body bears all of these hands and worlds: ask for softer hands or walls, more damping of the hand, or a faster robot".to_owned()
        } else {
            format!(
                "{} bodies bear these hands, but in trials none settles within 10 s: give more {HAND_MARGIN}",
                bodies.len()
            )
        };
        return Err(Failure::run(why));
    };
    Ok(Best { bodies, best })
}

fn effort((_, point): &(BodyValues, BodyPoint)) -> f64 {
    point.effort_n_s_per_m
}

/// The body of least effort of each order, and the best lagged mass.
///
/// # Errors
/// A search that was stopped.
pub(super) fn candidates(
    around: &Around,
    margin: f64,
    progress: &(dyn Fn(u64) + Sync),
    stop: &AtomicBool,
) -> Result<Vec<(BodyValues, BodyPoint)>, Failure> {
    let t = around.place.robot.sample_time_s();
    let each = |kinds: Vec<Kind>| {
        let found = for_each_order(&kinds, stop, progress, |kind| {
            best_of(around, margin, &body_of(kind, t)?)
        })?;
        Ok::<Vec<_>, Failure>(found.into_iter().flatten().collect())
    };
    let least = |bodies: Vec<(BodyValues, BodyPoint)>| {
        bodies
            .into_iter()
            .min_by(|a, b| effort(a).total_cmp(&effort(b)))
    };
    let mut bodies = each((0..=TENTHS).map(of_order).collect())?;
    let mut lagged = least(each(lags(around).collect())?);
    // Finer ones around the best.
    if let Some(middle) = lagged.as_ref().and_then(|(body, _)| body.lag_s) {
        let finer = (1..FINER).flat_map(|n| [n, -n]);
        let finer = finer.map(|n| {
            let factor = libm::exp2(f64::from(n) / f64::from(FINER));
            (1.0, Some(middle * factor))
        });
        lagged = least(each(finer.collect())?.into_iter().chain(lagged).collect());
    }
    bodies.extend(lagged);
    Ok(bodies)
}

/// Order and lag of a body.
type Kind = (f64, Option<f64>);

fn of_order(tenth: u32) -> Kind {
    (f64::from(tenth) / 10.0, None)
}

/// Lagged masses, from a lag of a sample on.
fn lags(around: &Around) -> impl Iterator<Item = Kind> {
    let t = around.place.robot.sample_time_s();
    (0..LAGS).map(move |n| (1.0, Some(t * libm::exp2(f64::from(n)))))
}

/// A body of this kind, with an inertance of 1.
fn body_of((order, lag_s): Kind, t: f64) -> Result<BodyValues, Failure> {
    let operator = match lag_s {
        Some(lag_s) => LoopOperator::lagged_difference(lag_s / t),
        None => {
            let order = Order::new(order).map_err(Failure::input)?;
            LoopOperator::new(Scheme::Exact, order, Seconds(t), HORIZON)
        }
    };
    Ok(BodyValues {
        inertance: 1.0,
        damping: 0.0,
        operator: operator.map_err(analysed)?,
        lag_s,
        scheme: Scheme::Exact,
    })
}

fn dampings() -> impl Iterator<Item = f64> {
    (0..=DAMPINGS).map(|n| DAMPING_LEAST * libm::pow(ratio(), f64::from(n)))
}

/// One damping over the one before.
fn ratio() -> f64 {
    libm::pow(DAMPING_MOST / DAMPING_LEAST, 1.0 / f64::from(DAMPINGS))
}

/// The body of least effort of this kind that is proved for hands with the margin, and tried in the others; `None` if none of the dampings does.
fn best_of(
    around: &Around,
    margin: f64,
    kind: &BodyValues,
) -> Result<Option<(BodyValues, BodyPoint)>, Failure> {
    let wide = around.with_margin(margin);
    let body = |inertance: f64, damping: f64| BodyValues {
        inertance,
        damping,
        ..kind.clone()
    };
    let least = |damping: f64| least_inertance(&wide, &body(1.0, damping));
    let effort = |damping: f64| {
        let light = body(least(damping).ok()??, damping);
        Some(point(around, &light, margin).ok()?.effort_n_s_per_m)
    };
    let tried = dampings().filter_map(|damping| Some((damping, effort(damping)?)));
    let Some(middle) = tried.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(None);
    };
    // The best one often stands at the edge of what is proved, so the best that was seen is kept.
    let best = Cell::new(middle);
    minimum_of(
        libm::log(middle.0 / ratio()),
        libm::log(middle.0 * ratio()),
        SECTIONS,
        |logarithm| {
            let damping = libm::exp(logarithm);
            let found = effort(damping).unwrap_or(f64::INFINITY);
            if found < best.get().1 {
                best.set((damping, found));
            }
            Ok::<_, Failure>(found)
        },
    )?;
    let damping = best.get().0;
    let Some(inertance) = least(damping)? else {
        return Ok(None);
    };
    let found = body(inertance, damping);
    let point = BodyPoint {
        settled: settles(around, &found)?,
        ..point(around, &found, margin)?
    };
    Ok(Some((found, point)))
}

/// The costs of a body that is proved for hands with this margin.
fn point(around: &Around, body: &BodyValues, hand_margin: f64) -> Result<BodyPoint, Failure> {
    let free = around.in_hand(body, around.place.hand([0; 3]), None)?;
    Ok(BodyPoint {
        body_order: body.operator.order().get(),
        body_lag_s: body.lag_s,
        body_inertance_n_s_mu_per_m: body.inertance,
        body_damping_n_s_per_m: body.damping,
        effort_n_s_per_m: free.effort(EffortWeight::Hand).map_err(analysed)?,
        command_noise: free.command_noise(),
        hand_margin,
        settled: None,
    })
}

fn settles(around: &Around, body: &BodyValues) -> Result<Option<bool>, Failure> {
    Ok(trials(around, body)?.map(|trials| trials.settled == trials.runs))
}

/// The least inertance of this body that is proved. Those that are stable with a corner of the hands and a few worlds are intervals, often not up to
/// the heaviest: a spring that acts late drives a heavy body. The proof for all hands and worlds begins at their common ones.
fn least_inertance(around: &Around, body: &BodyValues) -> Result<Option<f64>, Failure> {
    let common = stable_inertances(around, body)?;
    let holds = |inertance: f64| {
        let body = BodyValues {
            inertance,
            ..body.clone()
        };
        around.all(&body).is_ok_and(|all| all.is_proved())
    };
    for [low, high] in common {
        let at =
            |step: u32| low * INSIDE * libm::pow(high / low, f64::from(step) / f64::from(STEPS));
        let Some(first) = (0..STEPS).find(|step| holds(at(*step))) else {
            continue;
        };
        if first == 0 {
            return Ok(Some(at(0)));
        }
        let (mut below, mut above) = (at(first - 1), at(first));
        for _ in 0..HALVINGS {
            let middle = libm::sqrt(below * above);
            *(if holds(middle) {
                &mut above
            } else {
                &mut below
            }) = middle;
        }
        return Ok(Some(above));
    }
    Ok(None)
}

/// Inertances of this body that are stable in each corner of the hands and at six shares of the world.
pub(super) fn stable_inertances(
    around: &Around,
    body: &BodyValues,
) -> Result<Vec<[f64; 2]>, Failure> {
    let most = [INERTANCE_LEAST, INERTANCE_MOST];
    let mut common = vec![most];
    for share in WORLDS {
        let world = around.world().map(|world| AdmittanceWorld {
            stiffness_n_per_m: share * world.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: share * world.dissipation_n_s_mu_per_m,
            ..world
        });
        if world.is_none() && share > 0.0 {
            break;
        }
        for hand in around.place.corners() {
            if common.is_empty() {
                break;
            }
            let subject = around.in_hand(body, hand, world)?;
            let stable = subject.stable_values(AdmittanceNumber::Inertance, most);
            common = both(&common, &stable);
        }
    }
    Ok(common)
}

/// Intervals that two lists of rising ones share.
fn both(one: &[[f64; 2]], other: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let pairs = one
        .iter()
        .flat_map(|a| other.iter().map(move |b| [a[0].max(b[0]), a[1].min(b[1])]));
    pairs.filter(|[low, high]| low < high).collect()
}
