//! A first guess by linear least squares on smoothed signals.
//!
//! ```text
//! û(t − D′) = m·x̂″ + b·x̂′ + F_c·sgn x̂′ + k·x̂ − w        hats: smoothed by one Gaussian, whose derivatives make x̂′ and x̂″
//! ```
//! Smoothing both sides alike leaves the equation as it is, but for the sign. D′, half a sample of the hold, the delay and the lag together, is
//! the one of a grid of half samples that leaves least. Velocities near zero are left out.

use super::record::MotionRecord;
use super::replay::{DELAY_MAX, Model};
use nalgebra::{DMatrix, DVector};

/// Width of the Gaussian, s, and at least so many samples.
const SMOOTH: (f64, f64) = (2.5e-3, 2.0);
/// Slower than this share of the rms velocity counts as near zero.
const SLOW: f64 = 0.15;

/// Smoothed position, velocity and acceleration, and the smoothed force; not a number where a sample is missing.
struct Smoothed {
    x: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
}

/// Velocity of a record, m/s: smoothed; not a number beside missing samples.
pub(super) fn velocity(record: &MotionRecord) -> Vec<f64> {
    smoothed(record).v
}

fn smoothed(record: &MotionRecord) -> Smoothed {
    let t = record.sample_time_s;
    let width = f64::max(SMOOTH.0 / t, SMOOTH.1);
    let reach = (4.0 * width).ceil() as isize;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|i| libm::exp(-0.5 * (i as f64 / width) * (i as f64 / width)))
        .collect();
    let sum: f64 = weights.iter().sum();
    let at = |signal: &[f64], n: usize, weight: &dyn Fn(f64) -> f64| -> f64 {
        let mut total = 0.0;
        for (g, i) in weights.iter().zip(-reach..=reach) {
            let Some(value) = n.checked_add_signed(i).and_then(|n| signal.get(n)) else {
                return f64::NAN;
            };
            // Σ y[n + i]·w(i): the derivative of a Gaussian about n.
            total += g / sum * weight(i as f64) * value;
        }
        total
    };
    let square = width * width;
    let all = |signal: &[f64], weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..record.len()).map(|n| at(signal, n, weight)).collect()
    };
    Smoothed {
        x: all(&record.position_m, &|_| 1.0),
        v: all(&record.position_m, &|i| i / square / t),
        a: all(&record.position_m, &|i| {
            (i * i / square - 1.0) / square / (t * t)
        }),
        u: all(&record.force_n, &|_| 1.0),
    }
}

/// The model with which the search begins, all that is late in it taken for delay; `None` if nothing moves.
pub(super) fn first_guess(record: &MotionRecord, hand: bool) -> Option<Model> {
    let signals = smoothed(record);
    let from = record.driven_from + DELAY_MAX as usize;
    let moving = || (from..record.len()).filter(|&n| signals.a[n].is_finite());
    let count = moving().count();
    let rms = (moving().map(|n| signals.v[n] * signals.v[n]).sum::<f64>() / count as f64).sqrt();
    let rows: Vec<usize> = moving()
        .filter(|&n| signals.v[n].abs() > SLOW * rms)
        .collect();
    if rows.len() < 50 || rms <= 0.0 {
        return None;
    }
    let columns = if hand { 5 } else { 4 };
    let matrix = DMatrix::from_fn(rows.len(), columns, |row, column| {
        let n = rows[row];
        match column {
            0 => signals.a[n],
            1 => signals.v[n],
            2 => signals.v[n].signum(),
            3 => -1.0,
            _ => signals.x[n],
        }
    });
    let normal = (matrix.transpose() * &matrix).try_inverse()?;
    let project = normal * matrix.transpose();
    let mut best: Option<(f64, f64, DVector<f64>)> = None;
    // Half samples, from that of the hold on.
    for half in 1..=(2.0 * DELAY_MAX) as usize {
        let earlier = |n: usize| {
            let (whole, odd) = (half / 2, half % 2);
            let u = |back: usize| signals.u[n - back];
            if odd == 0 {
                u(whole)
            } else {
                0.5 * (u(whole) + u(whole + 1))
            }
        };
        let forces = DVector::from_iterator(rows.len(), rows.iter().map(|&n| earlier(n)));
        let found = &project * &forces;
        let left = (forces - &matrix * &found).norm_squared();
        if left.is_finite() && best.as_ref().is_none_or(|(least, ..)| left < *least) {
            best = Some((left, 0.5 * half as f64, found));
        }
    }
    let (_, delay, found) = best?;
    Some(Model {
        mass: found[0].max(1e-6),
        damping: found[1].max(1e-3),
        friction: found[2].max(0.0),
        bias: found[3],
        delay: f64::max(delay - 0.5, 0.1),
        lag: 0.0,
        stiffness: found.get(4).map_or(0.0, |k| k.max(0.0)),
    })
}
