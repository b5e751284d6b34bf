//! The frequency response of a measured device, at the lines of its multi-sine: what it is, whatever any model says.
//!
//! ```text
//! over a block:   f = Σ Re F_l·e^(jθ_l·n) + line,   x = Σ Re X_l·e^(jθ_l·n) + line          least squares, weighted sin²(πn/N)
//! G(θ) = Σ X·F̄/Σ |F|²        γ² = 1 − K/(K − 1)·(1 − |Σ X·F̄|²/(Σ |F|²·Σ |X|²))           sums over K blocks
//! G(jω) = G(θ)·(1/(jω)²)/(½T²·(z + 1)/(z − 1)²)                                          z = e^(jθ), θ = ωT
//! ```
//! The last line takes the hold of the sampled device away, exactly for a mass; a delay turns the images that it leaves, at 0.22 cycles a
//! sample 4 % of the whole. *Accuracy* of coherent lines for 65 g with a delay behind an encoder of 10 µm: 4 %, and 6 % from 0.15 cycles a
//! sample on. Friction is part of the response, as it is at this size of motion.
//!
//! - *Symbols*: f the force applied, N; x the position, m; T the sample time, s; γ² the coherence, 1 where the motion follows the force
//!   alone, lower under friction, play, noise or a hand.
//! - *Blocks*: as long as resolving the closest lines requires, overlapping by half, once the multi-sine has its full size. Fewer than
//!   four blocks are not enough: below 7 s of multi-sine at 1 ms a sample, and at 8 s from 7 ms on.
//!
//! *Cost*: a least-squares problem a block, 42 numbers from some 1500 samples.

use crate::{
    MeasurePlan, MotionRecord,
    drive::{grown_s, steps},
};
use fractional_control::Plant;
use haptic_trial::plant_file::COHERENT;
use nalgebra::DMatrix;
use num_complex::Complex;
use serde::Serialize;
use std::fmt::Write as _;

const BLOCKS: usize = 4;

/// A line of the response.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ResponseLine {
    /// ω of the line, rad/s.
    pub omega_rad_s: f64,
    /// |G|, m/N.
    pub gain: f64,
    /// arg G, °, unwrapped from the slowest line on.
    pub phase_deg: f64,
    /// γ², 1 where the motion follows the force alone.
    pub coherence: f64,
}

/// The response at the lines of a plan's multi-sine, slowest first; empty if the record is too short.
pub fn response(record: &MotionRecord, plan: &MeasurePlan) -> Vec<ResponseLine> {
    let (t, steps) = (record.sample_time_s, steps(plan));
    let steady = record.driven_from + plan.ticks(grown_s()) as usize;
    let apart = steps.windows(2).map(|pair| pair[1] - pair[0]);
    let block = (std::f64::consts::TAU / apart.fold(f64::INFINITY, f64::min)) as usize;
    let starts = (steady..record.len()).step_by(block / 2);
    let blocks: Vec<_> = starts
        .filter(|start| start + block <= record.len())
        .filter_map(|start| amplitudes(record, start..start + block, &steps))
        .collect();
    if blocks.len() < BLOCKS {
        return Vec::new();
    }
    let (mut before, count) = (0.0, blocks.len() as f64);
    let mut line = |l: usize, step: f64| {
        let pairs = || blocks.iter().map(move |lines| lines[l]);
        let cross: Complex<f64> = pairs().map(|(f, x)| x * f.conj()).sum();
        let forces: f64 = pairs().map(|(f, _)| f.norm_sqr()).sum();
        let motions: f64 = pairs().map(|(_, x)| x.norm_sqr()).sum();
        let z = Complex::cis(step);
        let hold = 0.5 * (z + 1.0) / ((z - 1.0) * (z - 1.0));
        let held = cross / forces / hold * -(step * step).recip();
        let turns = ((before - held.arg()) / std::f64::consts::TAU).round();
        before = held.arg() + turns * std::f64::consts::TAU;
        ResponseLine {
            omega_rad_s: step / t,
            gain: held.norm(),
            phase_deg: before.to_degrees(),
            coherence: 1.0 - count / (count - 1.0) * (1.0 - cross.norm_sqr() / (forces * motions)),
        }
    };
    let lines: Vec<ResponseLine> = (steps.iter().enumerate())
        .map(|(l, step)| line(l, *step))
        .collect();
    let is_number = |line: &ResponseLine| line.phase_deg.is_finite() && line.coherence.is_finite();
    if lines.iter().all(is_number) {
        lines
    } else {
        Vec::new()
    }
}

/// F and X of each line in a stretch of the record, without its missing samples.
fn amplitudes(
    record: &MotionRecord,
    stretch: std::ops::Range<usize>,
    steps: &[f64],
) -> Option<Vec<(Complex<f64>, Complex<f64>)>> {
    let (from, length) = (stretch.start, stretch.len() as f64);
    let rows: Vec<usize> = stretch
        .filter(|&n| record.position_m[n].is_finite())
        .collect();
    let waves = 2 * steps.len();
    // The root of the weight of a row.
    let weight = |row: usize| {
        let along = (rows[row] - from) as f64 + 0.5;
        libm::sin(std::f64::consts::PI * along / length)
    };
    let basis = DMatrix::from_fn(rows.len(), waves + 2, |row, column| {
        let tick = rows[row] as f64;
        weight(row)
            * match (column / 2, column % 2) {
                (l, part) if l < steps.len() => {
                    let (sin, cos) = libm::sincos(steps[l] * tick);
                    if part == 0 { cos } else { -sin }
                }
                (_, 0) => 1.0,
                _ => (tick - from as f64) / length,
            }
    });
    let signals = DMatrix::from_fn(rows.len(), 2, |row, column| match column {
        0 => weight(row) * record.force_n[rows[row]],
        _ => weight(row) * record.position_m[rows[row]],
    });
    let square = basis.tr_mul(&basis).cholesky()?;
    let found = square.solve(&basis.tr_mul(&signals));
    let wave = |l: usize, signal| Complex::new(found[(2 * l, signal)], found[(2 * l + 1, signal)]);
    Some((0..steps.len()).map(|l| (wave(l, 0), wave(l, 1))).collect())
}

/// The lines whose motion follows the force.
pub fn coherent(lines: &[ResponseLine]) -> impl Iterator<Item = &ResponseLine> {
    lines.iter().filter(|line| line.coherence >= COHERENT)
}

/// The coherent lines as a table that `[measured_response]` of a plant takes; `None` if they are too few for it.
pub fn table(lines: &[ResponseLine]) -> Option<String> {
    let point = |line: &ResponseLine| {
        let response = Complex::from_polar(line.gain, line.phase_deg.to_radians());
        (line.omega_rad_s, response)
    };
    let points: Vec<_> = coherent(lines).map(point).collect();
    Plant::measured(&points).ok()?;
    let mut text = "omega_rad_s,gain,phase_deg,coherence\n".to_owned();
    for line in coherent(lines) {
        let ResponseLine {
            omega_rad_s,
            gain,
            phase_deg,
            coherence,
        } = line;
        let _ = writeln!(text, "{omega_rad_s:e},{gain:e},{phase_deg},{coherence}");
    }
    Some(text)
}
