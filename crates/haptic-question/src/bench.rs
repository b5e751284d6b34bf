//! Parts that questions share: the device with its keys, orders and scheme, and a search that can be stopped.

use fracdiff::{Order, Scheme, SchemeError};
use haptic_analysis::{SampledLoop, StableArea};
use haptic_document::parameters::{Parameter, joined};
use haptic_document::parameters::{SAMPLE_TIME, SCHEME, SIMULATED};
use haptic_document::{Failure, FileError, Table};
use haptic_loop::plant::MassDamperConfig;
use haptic_trial::advice::check;
use haptic_trial::device_table::device;
use haptic_trial::keys::trial::TRIAL_FORCE_LIMIT;
use haptic_trial::{Imperfections, Sensors};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};

/// The device of Z-width and design.
pub const BENCH: &[Parameter] = &joined::<12>(&[&[SAMPLE_TIME, TRIAL_FORCE_LIMIT], SIMULATED]);

/// The device of a search, its sensors and its largest force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BenchDevice {
    /// Mass, damping, hand and sample time; delay, current lag and friction.
    pub plant: MassDamperConfig,
    /// Encoder resolution and noise of the position that the loop reads.
    pub sensors: Sensors,
    /// Largest force of the actuator, N.
    pub force_limit_n: f64,
}

impl BenchDevice {
    /// Everything about it that is less than ideal.
    #[must_use]
    pub fn imperfections(&self) -> Imperfections {
        Imperfections {
            friction_n: self.plant.friction.0,
            delay_s: self.plant.delay.0,
            current_lag_s: self.plant.current_lag.0,
            sensors: self.sensors,
        }
    }
}

/// The device of a question, repeated in its answer, where a wrong unit shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AskedDevice {
    /// m of the device, kg.
    pub mass_kg: f64,
    /// b of the device, N·s/m.
    pub damping_n_s_per_m: f64,
    /// k of the hand, N/m.
    pub hand_stiffness_n_per_m: f64,
    /// T, from one tick to the next, s.
    pub sample_time_s: f64,
}

impl AskedDevice {
    /// The numbers of a device.
    #[must_use]
    pub const fn of(device: &MassDamperConfig) -> Self {
        Self {
            mass_kg: device.mass.0,
            damping_n_s_per_m: device.damping.0,
            hand_stiffness_n_per_m: device.stiffness.0,
            sample_time_s: device.sample_time.0,
        }
    }
}

/// m/T² and m/T^(2−μ): N/m of α = 1 and N·s^μ/m of β = 1.
pub fn units(device: &MassDamperConfig, order: Order) -> (f64, f64) {
    let (m, t) = (device.mass.0, device.sample_time.0);
    (m / (t * t), m / libm::pow(t, 2.0 - order.get()))
}

/// The device of a table, with the sample time of a law that brings one.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn bench(table: &Table<'_>, sample_time_s: Option<f64>) -> Result<BenchDevice, FileError> {
    let sample_time_s = sample_time_s.map_or_else(|| table.number(&SAMPLE_TIME), Ok)?;
    let (plant, sensors) = device(table, sample_time_s)?;
    Ok(BenchDevice {
        plant,
        sensors,
        force_limit_n: table.number(&TRIAL_FORCE_LIMIT)?,
    })
}

/// The scheme of a table; the exact derivative is refused, which cannot be rendered.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn scheme(table: &Table<'_>) -> Result<Scheme, FileError> {
    let scheme = table.scheme(&SCHEME)?;
    if scheme == Scheme::Exact {
        return Err(table.fail_at(SCHEME.key, SchemeError::AnalysisOnly.to_string()));
    }
    Ok(scheme)
}

/// The orders that a key lists.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn orders(table: &Table<'_>, parameter: &Parameter) -> Result<Vec<Order>, FileError> {
    let given = table.numbers_if(parameter)?;
    let numbers = given.unwrap_or_else(|| parameter.default_numbers());
    let orders: Result<_, _> = numbers.into_iter().map(Order::new).collect();
    orders.map_err(|error| table.fail_at(parameter.key, error.to_string()))
}

/// Refuses an empty list, and orders that a wall cannot have.
///
/// # Errors
/// No order, or one out of range, with the parameter to change.
pub fn check_orders(orders: &[Order], parameter: &Parameter) -> Result<(), Failure> {
    if orders.is_empty() {
        return Err(Failure::bad_input(format_args!(
            "no order was given: give {parameter}, as in 0, 0.5, 1"
        )));
    }
    (orders.iter()).try_for_each(|order| check(parameter, order.get()))
}

/// The answer for each order, or another candidate, on all cores; `progress` hears of each that is done, `stop` ends it before the next.
///
/// # Errors
/// The first of the orders that has one; a search that was stopped.
pub fn for_each_order<I: Copy + Sync, T: Send>(
    orders: &[I],
    stop: &AtomicBool,
    progress: &(dyn Fn(u64) + Sync),
    answer: impl Fn(I) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let goes_on = || {
        if stop.load(Ordering::Relaxed) {
            Err(Failure::interrupted())
        } else {
            Ok(())
        }
    };
    let answers = orders.par_iter().map(|&order| {
        goes_on()?;
        let answer = answer(order);
        progress(1);
        answer
    });
    let answers = answers.collect::<Result<_, _>>()?;
    goes_on()?;
    Ok(answers)
}

/// Share by which rounding parts numbers that are alike.
const ALIKE: f64 = 1e-9;

/// Places of those that no other is as good as in all merits, and better in one. Of two that are alike the first is kept.
pub fn unbeaten<T, const N: usize>(all: &[T], merits: impl Fn(&T) -> [f64; N]) -> Vec<usize> {
    let merits: Vec<[f64; N]> = all.iter().map(merits).collect();
    let is_as_good = |a: &[f64; N], b: &[f64; N]| {
        let mut pairs = a.iter().zip(b);
        pairs.all(|(value, other)| *value >= other - ALIKE * other.abs())
    };
    let is_beaten = |n: usize| {
        let mut others = merits.iter().enumerate();
        others.any(|(k, other)| {
            let is_worse = || !is_as_good(&merits[n], other);
            k != n && is_as_good(other, &merits[n]) && (k < n || is_worse())
        })
    };
    (0..all.len()).filter(|n| !is_beaten(*n)).collect()
}

/// The last place at which something holds on the way to one at which it does not, after `halvings` halvings.
pub fn last(mut from: f64, mut to: f64, halvings: u32, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (from + to);
        *(if holds(middle) { &mut from } else { &mut to }) = middle;
    }
    from
}

/// The place of the one minimum of a function between two places, by golden sections.
///
/// # Errors
/// Those of the function.
pub fn minimum_of<E>(
    mut low: f64,
    mut high: f64,
    sections: usize,
    function: impl Fn(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..sections {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if function(a)? <= function(b)? {
            high = b;
        } else {
            low = a;
        }
    }
    Ok(0.5 * (low + high))
}

/// Scale below which a law counts as none.
const LEAST_SCALE: f64 = 1e-6;

/// The largest factors up to `most` with which a loop is stable: the first, if smaller ones are unstable, and the edge.
pub fn largest_scales(closed: &SampledLoop<'_>, most: f64) -> Option<(Option<f64>, f64)> {
    let stable = closed.stable_factors([LEAST_SCALE.min(1e-6 * most), most]);
    let [from, edge] = *stable.last()?;
    Some(((from > LEAST_SCALE).then_some(from), edge))
}

/// Values of α at which the boundary has this β, the least first.
pub fn crossings(area: &StableArea, beta: f64) -> Vec<f64> {
    let mut crossings: Vec<f64> = Vec::new();
    for polygon in &area.polygons {
        for (a, b) in polygon.edges() {
            if (a.beta > beta) != (b.beta > beta) {
                let way = (beta - a.beta) / (b.beta - a.beta);
                crossings.push(a.alpha + way * (b.alpha - a.alpha));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings
}
