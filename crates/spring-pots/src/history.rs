//! The stress of any strain, over its full history.
//! ```text
//! ε straight between samples:  σ(tᵢ) = Σ_{j < i} Δrⱼ·Q(tᵢ − tⱼ),   Q(t) = ∫₀ᵗ G,   Δrⱼ = change of the strain rate at tⱼ
//! Q by cubic interpolation in ln t between nodes 1/20 apart:  σᵢ = Σ_m Wᵢₘ·Q(tₘ)
//! ```
//! W depends on the record alone. It is summed once over the full history; after that a model costs its nodes and one product with
//! W, or, for a sum of squares alone, with the triangle R of W = QR, which has as many rows as there are nodes: ‖Wq − σ‖² =
//! ‖Rq − Qᵀσ‖² and what Q leaves of σ. The error of the interpolation is below 1e-6 of Q. A step of strain between two samples is a ramp between them.
//! Between its corners a motion is smooth, and its rate goes straight within a step: errors fall with the square of the step, of a dashpot too.
//!
//! Parts of the stress beside the model's, such as a baseline, are [taken out](crate::Doubts) of both sides: PW and Pσ replace W and σ once, so
//! that a model costs no more. Where samples have errors, all rows are over them in this.

use crate::contour::{Contour, Quantity};
use crate::cubic;
use crate::doubts::Doubts;
use crate::elements::{Elements, Slope};
use crate::joint::Joint;
use crate::mode::SpectralMode;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Distance of the nodes in ln t.
const SPACING: f64 = 0.05;
/// Factor on the spacing for the search of minima: there the interpolation leaves 1e-4 of Q.
const COARSER: usize = 4;
/// Most samples compared; `PAIRS_MOST` limits the pairs of samples summed.
const OUTPUTS_MOST: usize = 2000;
/// A motion with this few corners, such as a ramp and a hold, costs almost nothing per row of W.
const FEW_CORNERS: usize = 100;
const OUTPUTS_OF_FEW: usize = 10_000;
const OUTPUTS_LEAST: usize = 300;
const PAIRS_MOST: usize = 30_000_000;

/// A record of strain and stress, made ready.
#[derive(Clone, Debug)]
pub struct History {
    /// ln of the time of the first node, in units of `unit_s`, and the distance of the nodes.
    first_node: f64,
    spacing: f64,
    nodes: usize,
    /// W, or PW, row by row, in units of `unit_s`.
    weights: Vec<f64>,
    /// σ, or Pσ, over its scale.
    pub wanted: Vec<f64>,
    /// Numbers of the samples that are compared.
    pub chosen: Vec<usize>,
    /// t₀, s, the unit of time.
    pub unit_s: f64,
    /// Root of the mean square, Pa.
    pub stress_scale: f64,
    /// Largest distance from the first.
    pub strain_scale: f64,
}

/// A motion and its stress: times, s, stresses, Pa, and the strain at times that are as close or closer and straight between them.
#[derive(Clone, Copy, Debug)]
pub struct Moved<'a> {
    /// Times of the stresses, s.
    pub time_s: &'a [f64],
    /// Stresses, Pa, one at each of these times.
    pub stress_pa: &'a [f64],
    /// Times of the strains, s.
    pub motion_s: &'a [f64],
    /// Strains, one at each of those times.
    pub strain: &'a [f64],
}

impl History {
    /// The columns of B and of D, a number for each sample of all motions, and the errors by which samples count, or none.
    pub fn new(
        motions: &[Moved<'_>],
        nuisance: &[Vec<f64>],
        bounded: &[Vec<f64>],
        errors: &[f64],
    ) -> Self {
        let knots: Vec<Vec<(f64, f64)>> = (motions.iter())
            .map(|moved| knots(moved.motion_s, &changes(moved.motion_s, moved.strain)))
            .collect();
        let pairs = knots.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let outputs = if pairs <= FEW_CORNERS {
            OUTPUTS_OF_FEW
        } else {
            OUTPUTS_MOST
        };
        let most = (PAIRS_MOST / pairs).clamp(OUTPUTS_LEAST, outputs) / motions.len();
        let steps = motions.iter().flat_map(|moved| moved.motion_s.windows(2));
        let least = steps
            .map(|pair| pair[1] - pair[0])
            .fold(f64::INFINITY, f64::min);
        let is_smooth = motions.iter().zip(&knots).any(|(moved, knots)| {
            let is_sample = |knot: &(f64, f64)| {
                let found = moved.motion_s.binary_search_by(|t| t.total_cmp(&knot.0));
                found.is_ok()
            };
            !knots.iter().all(is_sample)
        });
        let least = if is_smooth { GAUSS * least } else { least };
        let whole = (motions.iter())
            .map(|moved| moved.time_s[moved.time_s.len() - 1] - moved.time_s[0])
            .fold(0.0, f64::max);
        let unit_s = libm::sqrt(least * whole);
        // Two nodes beyond each end for the cubic.
        let first_node = libm::log(least / unit_s) - 2.0 * SPACING;
        let nodes = (2.0 * libm::log(whole / unit_s) / SPACING) as usize + 6;
        let mut history = Self {
            first_node,
            spacing: SPACING,
            nodes,
            weights: Vec::new(),
            wanted: Vec::new(),
            chosen: Vec::new(),
            unit_s,
            stress_scale: 0.0,
            strain_scale: 0.0,
        };
        let (mut square, mut before) = (0.0, 0);
        for (moved, knots) in motions.iter().zip(&knots) {
            let (time_s, strain) = (moved.time_s, moved.strain);
            let begin = knots.first().map_or(time_s[0], |knot| knot.0);
            let chosen = chosen(time_s, begin, most);
            let stresses = chosen.iter().map(|&i| moved.stress_pa[i]);
            square += stresses.map(|stress| stress * stress).sum::<f64>();
            let reach = strain.iter().map(|x| (x - strain[0]).abs());
            history.strain_scale = reach.fold(history.strain_scale, f64::max);
            // Rows are independent: the order of each sum does not depend on the threads.
            let rows: Vec<Vec<f64>> = (chosen.par_iter())
                .map(|&i| history.row(time_s[i], knots))
                .collect();
            history.weights.extend(rows.into_iter().flatten());
            (history.wanted).extend(chosen.iter().map(|&i| moved.stress_pa[i]));
            history.chosen.extend(chosen.iter().map(|i| before + i));
            before += time_s.len();
        }
        history.stress_scale = libm::sqrt(square / history.chosen.len() as f64);
        let (scale, wanted) = (history.stress_scale, history.wanted.iter_mut());
        wanted.for_each(|stress| *stress /= scale);
        history.leave_out(nuisance, bounded, errors);
        history
    }

    /// Takes out of W and σ what a sum of the columns makes, of the bounded ones as far as it may be.
    fn leave_out(&mut self, nuisance: &[Vec<f64>], bounded: &[Vec<f64>], errors: &[f64]) {
        if nuisance.is_empty() && bounded.is_empty() {
            return;
        }
        let at = |values: &[f64], n: usize| values.get(n).copied().unwrap_or(1.0);
        let errors: Vec<f64> = self.chosen.iter().map(|&n| at(errors, n)).collect();
        let of = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let part = |column: &Vec<f64>| {
                let chosen = self.chosen.iter().zip(&errors);
                chosen.map(|(&n, error)| column[n] / error).collect()
            };
            columns.iter().map(part).collect()
        };
        let doubts = Doubts::new(self.chosen.len(), &of(nuisance), &of(bounded));
        doubts.take_out(&mut self.weights, &errors);
        doubts.take_out(&mut self.wanted, &errors);
    }

    /// W of the stress at a time.
    fn row(&self, time_s: f64, knots: &[(f64, f64)]) -> Vec<f64> {
        let mut row = vec![0.0; self.nodes];
        let (per_unit, per_node) = (1.0 / self.unit_s, 1.0 / SPACING);
        // Neighbouring knots mostly lie between the same two nodes, where moments of their places spare the cubic of each.
        let (mut here, mut moments) = (1, [0.0; 4]);
        for &(knot_s, change) in knots.iter().take_while(|knot| knot.0 < time_s) {
            let ln_since = libm::log((time_s - knot_s) * per_unit);
            let in_nodes = (ln_since - self.first_node) * per_node;
            let node = (in_nodes as usize).clamp(1, self.nodes - 3);
            if node != here {
                add_cubics(&mut row[here - 1..here + 3], moments);
                (here, moments) = (node, [0.0; 4]);
            }
            let x = in_nodes - node as f64;
            let mut part = change;
            for moment in &mut moments {
                *moment += part;
                part *= x;
            }
        }
        add_cubics(&mut row[here - 1..here + 3], moments);
        row
    }

    /// Makes 1 s the unit of time.
    pub fn in_seconds(&mut self) {
        self.first_node += libm::log(self.unit_s);
        self.unit_s = 1.0;
    }

    /// Equal sum of squares by fewer rows, with their target values, if there are more than twice as many samples as nodes.
    pub fn compressed(&self, wanted: &[f64], roots: &[f64]) -> Option<(Self, Vec<f64>)> {
        let (rows, columns) = (roots.len(), self.nodes + 1);
        if rows <= 2 * columns {
            return None;
        }
        Some(self.triangle(wanted, roots))
    }

    /// Fewer nodes and rows, accurate enough to locate the minima.
    pub fn coarse(&self, wanted: &[f64], roots: &[f64]) -> (Self, Vec<f64>) {
        let spacing = COARSER as f64 * SPACING;
        let nodes = (self.nodes - 1) / COARSER + 4;
        let mut weights = vec![0.0; roots.len() * nodes];
        let rows = weights.chunks_exact_mut(nodes);
        for (coarse, row) in rows.zip(self.weights.chunks_exact(self.nodes)) {
            for (m, weight) in row.iter().enumerate() {
                let around = cubic((m % COARSER) as f64 / COARSER as f64);
                for (coarse, part) in coarse[m / COARSER..].iter_mut().zip(around) {
                    *coarse += weight * part;
                }
            }
        }
        let coarse = Self {
            first_node: self.first_node - spacing,
            spacing,
            nodes,
            weights,
            wanted: Vec::new(),
            chosen: Vec::new(),
            ..*self
        };
        coarse.triangle(wanted, roots)
    }

    /// The triangle of the weighted rows, with its target values.
    fn triangle(&self, wanted: &[f64], roots: &[f64]) -> (Self, Vec<f64>) {
        let columns = self.nodes + 1;
        let at = |row: usize, column: usize| {
            if column == self.nodes {
                wanted[row]
            } else {
                self.weights[row * self.nodes + column]
            }
        };
        let whole = DMatrix::from_fn(roots.len(), columns, |row, column| {
            roots[row] * at(row, column)
        });
        let triangle = whole.qr().r();
        let weights = (0..triangle.nrows()).flat_map(|row| (0..self.nodes).map(move |m| (row, m)));
        let compressed = Self {
            weights: weights.map(|place| triangle[place]).collect(),
            wanted: Vec::new(),
            chosen: Vec::new(),
            ..*self
        };
        (compressed, triangle.column(self.nodes).as_slice().to_vec())
    }

    /// Least and largest ln of a time since a change of the strain, in units of t₀.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        [2.0, (self.nodes - 4) as f64].map(|node| self.first_node + node * self.spacing)
    }

    /// The stress of each output over its scale, of a mode of unit size.
    #[must_use]
    pub fn mode(&self, mode: SpectralMode) -> Vec<f64> {
        let scale = self.unit_s / self.stress_scale;
        let node = |m: usize| self.first_node + m as f64 * self.spacing;
        let nodes = (0..self.nodes).map(|m| scale * mode.at(Some(Quantity::Integral), node(m))[0]);
        let nodes: Vec<f64> = nodes.collect();
        let rows = self.weights.chunks_exact(self.nodes);
        let product = |row: &[f64]| row.iter().zip(&nodes).fold(0.0, |sum, (w, q)| sum + w * q);
        rows.map(product).collect()
    }

    /// Calls `each` with the stress of each output over its scale.
    pub fn model(
        &self,
        joint: Option<Joint>,
        elements: &Elements,
        each: &mut dyn FnMut(usize, Slope),
    ) {
        let contour = Contour::new(joint, Quantity::Integral, *elements);
        // From units of t₀ to s: rates are in 1/s.
        let scale = self.unit_s / self.stress_scale;
        let nodes: Vec<Slope> = (0..self.nodes)
            .map(|m| contour.at(self.first_node + m as f64 * self.spacing))
            .collect();
        for (n, row) in self.weights.chunks_exact(self.nodes).enumerate() {
            // Of a triangle half the weights are 0.
            let first = row.iter().position(|weight| *weight != 0.0).unwrap_or(0);
            let mut sum = Slope::sum(&row[first..], &nodes[first..]);
            sum.value *= scale;
            sum.by.iter_mut().for_each(|by| *by *= scale);
            each(n, sum);
        }
    }
}

/// Adds the sum of [`cubic`]s at several x, by the sums of their sizes times 1, x, x² and x³.
fn add_cubics(weights: &mut [f64], [all, x, square, cube]: [f64; 4]) {
    let parts = [
        (3.0 * square - cube - 2.0 * x) / 6.0,
        all + 0.5 * (cube - x) - square,
        x + 0.5 * (square - cube),
        (cube - x) / 6.0,
    ];
    for (weight, part) in weights.iter_mut().zip(parts) {
        *weight += part;
    }
}

/// Samples to compare: all, or of a long record half of them evenly, and half evenly in the logarithm of the time since the motion
/// began, where most happens.
pub fn chosen(time_s: &[f64], begin_s: f64, most: usize) -> Vec<usize> {
    let n = time_s.len();
    if n - 1 <= most {
        return (1..n).collect();
    }
    let half = most / 2;
    let even = (0..half).map(|k| 1 + k * (n - 2) / (half - 1).max(1));
    let first = time_s.partition_point(|&t| t <= begin_s).min(n - 1);
    let (low, high) = (time_s[first] - begin_s, time_s[n - 1] - begin_s);
    let logarithmic = (0..half).map(|k| {
        let share = k as f64 / (half - 1).max(1) as f64;
        let wanted = begin_s + low * libm::pow(high / low, share);
        time_s.partition_point(|&t| t < wanted).clamp(first, n - 1)
    });
    let mut chosen: Vec<usize> = even.chain(logarithmic).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// A knot whose change is this many times that of a sample beside it is a corner of the motion, or one of two around it.
const CORNER: f64 = 3.0;
/// Steps before and after a knot of a smooth motion differ by this factor at most.
const ALIKE: f64 = 2.0;
/// Place of the first of the two points of Gauss in a step.
const GAUSS: f64 = 0.211_324_865_405_187_1;

/// The knots of a motion whose rate r goes straight within the steps between two corners:
/// ```text
/// r = s + κ·(t − middle of the step)     s the slope of the step, κ the mean of Δr/h at its ends that are no corners
/// ```
/// The strain stays that of the samples. Within a step the change κ·h is at the two points of Gauss, and the rest of Δr where it was: of a smooth
/// motion next to nothing. A dashpot then has the rate at the sample, not the slope of the step before.
fn knots(time_s: &[f64], changes: &[f64]) -> Vec<(f64, f64)> {
    let step = |n: usize| time_s[n + 1] - time_s[n];
    // Of a corner none.
    let bend = |n: usize| {
        if n == 0 || n + 1 >= time_s.len() {
            return None;
        }
        let (before, after) = (step(n - 1), step(n));
        let is_even = before <= ALIKE * after && after <= ALIKE * before;
        // No change is known at the last sample.
        let neighbour = if n + 2 < time_s.len() {
            changes[n - 1].abs().min(changes[n + 1].abs())
        } else {
            changes[n - 1].abs()
        };
        let is_corner = changes[n].abs() > CORNER * neighbour;
        (is_even && !is_corner).then(|| 2.0 * changes[n] / (before + after))
    };
    let within: Vec<f64> = (0..time_s.len() - 1)
        .map(|n| match (bend(n), bend(n + 1)) {
            (Some(a), Some(b)) => 0.5 * (a + b) * step(n),
            (Some(one), None) | (None, Some(one)) => one * step(n),
            (None, None) => 0.0,
        })
        .collect();
    let mut knots = Vec::new();
    let mut before = 0.0;
    for (n, &change) in within.iter().enumerate() {
        let rest = changes[n] - 0.5 * (before + change);
        before = change;
        if rest != 0.0 {
            knots.push((time_s[n], rest));
        }
        if change != 0.0 {
            let points = [GAUSS, 1.0 - GAUSS];
            knots.extend(points.map(|share| (time_s[n] + share * step(n), 0.5 * change)));
        }
    }
    knots
}

/// Change of the strain rate at each sample, 1/s. Rounding alone makes none.
fn changes(time_s: &[f64], strain: &[f64]) -> Vec<f64> {
    let mut changes = vec![0.0; time_s.len()];
    let mut rate = 0.0;
    let steps = time_s.windows(2).zip(strain.windows(2));
    for ((times, strains), change) in steps.zip(&mut changes) {
        let next = (strains[1] - strains[0]) / (times[1] - times[0]);
        let rounding =
            4.0 * f64::EPSILON * strains[0].abs().max(strains[1].abs()) / (times[1] - times[0]);
        if (next - rate).abs() > rounding {
            *change = next - rate;
            rate = next;
        }
    }
    changes
}
