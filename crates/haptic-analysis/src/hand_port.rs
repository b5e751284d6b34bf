//! A linear plant as a hand meets it: what it feels of a sampled law, and which damping the plant has at every frequency.
//! ```text
//! ẋ = Ax + B·u + Bₕ·f,   y = Cx measured,   xₕ = Cₕ·x of the hand,   G_yu = C(jω − A)⁻¹B, and so on
//! xₕ/f = G_hh − G_hu·L·G_yh/(1 + Ĝ·H),   L = H·(1 − w)/(jωT)·e^(−jωTd)/(1 + jωτ),   Z = f/(jω·xₕ)
//! ```
//! - *Exact for one frequency of the hand's force*: Ĝ is the sampled plant, and images of the force move the hand at other frequencies, where it does
//!   not push. So Re Z < 0 shows a loop that is not passive; Re Z ≥ 0 everywhere proves nothing, as a hand may push at several frequencies.
//! - *Collocated*, Bₕ = B and Cₕ = C, Z₀ = 1/(jω·G) and b₀ = inf Re Z₀: Z₀ − b₀ is passive if G has no pole right of the axis, and the wall
//!   takes its part of b₀. So a wall that asks for less than b₀ by Theorem 1 is passive on this plant. Mass and damper have b₀ = b.
//! - *b₀ by stationary points*: they are roots of a polynomial in ω², and Z₀ is solved for there; both ends are looked at 1e4 beyond the slowest
//!   and the fastest motion.
//!
//! Source: J. E. Colgate, G. Schenkel, *Passivity of a class of sampled-data systems*, J. Robotic Systems 14(1), 1997.

use crate::linear::{Matrices, poles, scaled};
use crate::transparency::Effective;
use crate::{AnalysisError, ForcePath};
use fracdiff::parameter::range;
use fracdiff::product;
use nalgebra::{Complex, DMatrix, DVector, RowDVector};

/// A plant with a hand, from forces in N to places in m.
#[derive(Clone, Debug, PartialEq)]
pub struct HandPort {
    matrices: Matrices,
    b_hand: DVector<f64>,
    c_hand: RowDVector<f64>,
    is_collocated: bool,
}

/// Factor beyond the slowest and the fastest motion at which both ends are looked at.
const BEYOND: f64 = 1e4;

impl HandPort {
    /// Plant from `a`, n×n in 1/s, `b` and `c`, n from 1 to 8; `hand` has Bₕ and Cₕ, without which the hand acts where the law does.
    ///
    /// # Errors
    /// Sizes that do not fit, numbers that are not finite, a motion faster than 1e6 1/s.
    pub fn new([a, b, c]: [&[f64]; 3], hand: [Option<&[f64]>; 2]) -> Result<Self, AnalysisError> {
        // Units of the states stay as they are: the hand's lists have them too.
        scaled([a, b, c], 1.0, 1.0, ForcePath::NONE)?;
        let [b_hand, c_hand] = [hand[0].unwrap_or(b), hand[1].unwrap_or(c)];
        for (what, list) in [
            ("entries of the hand's B", b_hand),
            ("entries of the hand's C", c_hand),
        ] {
            let kept = list.len() == b.len() && list.iter().all(|x| x.is_finite());
            range(
                what,
                list.len() as f64,
                kept,
                "finite and as many as those of B",
                "",
            )?;
        }
        Ok(Self {
            is_collocated: b_hand == b && c_hand == c,
            matrices: (
                DMatrix::from_row_slice(b.len(), b.len(), a),
                DVector::from_column_slice(b),
                RowDVector::from_row_slice(c),
            ),
            b_hand: DVector::from_column_slice(b_hand),
            c_hand: RowDVector::from_row_slice(c_hand),
        })
    }

    /// (jω − A)⁻¹ on one input.
    fn moved(&self, input: &DVector<f64>, omega: f64) -> DVector<Complex<f64>> {
        let (a, ..) = &self.matrices;
        let system = DMatrix::from_fn(a.nrows(), a.nrows(), |row, column| {
            Complex::new(-a[(row, column)], if row == column { omega } else { 0.0 })
        });
        let nan = Complex::new(f64::NAN, f64::NAN);
        let moved = system.lu().solve(&input.map(|b| Complex::new(b, 0.0)));
        moved.unwrap_or_else(|| DVector::from_element(a.nrows(), nan))
    }

    /// Effective stiffness and damping at the hand, of a law with the response `h`, N/m, in a loop of the gain `loop_gain`, Ĝ·H
    /// ([`SampledLoop::loop_gain`](crate::SampledLoop::loop_gain)), at 0 < ω ≤ π/T, rad/s.
    ///
    /// # Errors
    /// A result that is not finite.
    pub fn felt(
        &self,
        h: Complex<f64>,
        loop_gain: Complex<f64>,
        path: ForcePath,
        sample_time_s: f64,
        omega: f64,
    ) -> Result<Effective, AnalysisError> {
        let (_, b, c) = &self.matrices;
        let theta = omega * sample_time_s;
        // (1 − e^(−jθ))/(jθ) = e^(−jθ/2)·sin(θ/2)/(θ/2)
        let half = 0.5 * theta;
        let (sin, cos) = libm::sincos(half);
        let held = Complex::new(cos, -sin) * (sin / half) * path.continuous(theta);
        let [by_hand, by_law] = [&self.b_hand, b].map(|input| self.moved(input, omega));
        let pushed = held * h * seen(c, &by_hand) / (loop_gain + 1.0);
        let stiffness = (seen(&self.c_hand, &by_hand) - seen(&self.c_hand, &by_law) * pushed).inv();
        Effective::new(omega, stiffness.re, stiffness.im / omega)
    }

    /// Z₀(jω) of a hand that acts where the law does, N·s/m.
    fn impedance(&self, omega: f64) -> Complex<f64> {
        let (_, b, c) = &self.matrices;
        Complex::new(0.0, -1.0 / omega) / seen(c, &self.moved(b, omega))
    }

    /// b₀, N·s/m, and the frequency where it is, rad/s; `None` if the hand acts elsewhere, or the plant is not passive by itself: a pole right of the
    /// axis, or a frequency at which it gives energy to the hand.
    #[must_use]
    pub fn least_damping(&self) -> Option<(f64, f64)> {
        let (a, ..) = &self.matrices;
        if !self.is_collocated {
            return None;
        }
        let poles = poles(a);
        let sizes = || poles.iter().map(|pole| pole.norm());
        let fastest = sizes().fold(0.0, f64::max);
        // Rounding leaves so much of a pole on the axis.
        let rounding = 1e-9 * fastest;
        if poles
            .iter()
            .any(|pole| pole.re > rounding || pole.re.is_nan())
        {
            return None;
        }
        // A mass alone has no motion of its own.
        let slowest = sizes().filter(|size| *size > rounding);
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        let [slowest, fastest] = if slowest.is_finite() {
            [slowest, fastest]
        } else {
            [1.0; 2]
        };
        let ends = [slowest / BEYOND, fastest * BEYOND];
        let least = self.stationary(fastest).into_iter().chain(ends);
        let least = least.map(|omega| (self.impedance(omega).re, omega));
        let least = least.filter(|(damping, _)| damping.is_finite());
        let least = least.min_by(|one, other| one.0.total_cmp(&other.0))?;
        (least.0 >= 0.0).then_some(least)
    }

    /// Frequencies at which Re Z is stationary, rad/s: with x = ω², Re Z = p/(x·q), p = −ω·Im(D·N*), q = |N|², and p'·xq = p·(xq)'.
    fn stationary(&self, unit: f64) -> Vec<f64> {
        let [above, below] = self.polynomials(unit);
        let [n, d] = [&above, &below].map(|list| split(list));
        // D·N* = (D_e + jωD_o)(N_e − jωN_o), and Re(D·N*/(jω)) = Im(D·N*)/ω; over |N|² it is Re Z.
        let p = difference(&product(&d[1], &n[0]), &product(&d[0], &n[1]));
        let squared = shifted(&product(&n[1], &n[1]));
        let q = difference(
            &product(&n[0], &n[0]),
            &squared.iter().map(|x| -x).collect::<Vec<_>>(),
        );
        let slope = difference(&product(&derived(&p), &q), &product(&p, &derived(&q)));
        let roots = fracdiff::roots(&slope);
        let real = roots
            .iter()
            .filter(|x| x.re > 0.0 && x.im.abs() < 1e-3 * x.re);
        real.map(|x| unit * libm::sqrt(x.re)).collect()
    }

    /// N and D in powers of s in units of `unit`, s⁰ first (D. K. Faddeev's recursion).
    fn polynomials(&self, unit: f64) -> [Vec<f64>; 2] {
        let (a, b, c) = &self.matrices;
        let (n, a) = (a.nrows(), a / unit);
        let mut below = vec![1.0];
        let mut above = Vec::new();
        let mut adjoint = DMatrix::identity(n, n);
        for k in 1..=n {
            above.push((c * &adjoint * b)[0]);
            let turned = &a * &adjoint;
            let coefficient = -turned.trace() / k as f64;
            below.push(coefficient);
            adjoint = turned + DMatrix::identity(n, n) * coefficient;
        }
        above.reverse();
        below.reverse();
        [above, below]
    }
}

/// C·x.
fn seen(c: &RowDVector<f64>, x: &DVector<Complex<f64>>) -> Complex<f64> {
    c.iter().zip(x.iter()).map(|(c, x)| x * c).sum()
}

/// Even and odd part of a polynomial at jω, in powers of ω²: p(jω) = e(ω²) + jω·o(ω²).
fn split(list: &[f64]) -> [Vec<f64>; 2] {
    [0, 1].map(|first| {
        let signed = list
            .iter()
            .skip(first)
            .step_by(2)
            .zip([1.0, -1.0].into_iter().cycle());
        let part: Vec<f64> = signed
            .map(|(coefficient, sign)| coefficient * sign)
            .collect();
        if part.is_empty() { vec![0.0] } else { part }
    })
}

fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    let at = |list: &[f64], n: usize| list.get(n).copied().unwrap_or(0.0);
    let most = one.len().max(other.len());
    (0..most).map(|n| at(one, n) - at(other, n)).collect()
}

/// A polynomial times x.
fn shifted(list: &[f64]) -> Vec<f64> {
    [&[0.0], list].concat()
}

fn derived(list: &[f64]) -> Vec<f64> {
    let terms = list.iter().enumerate().skip(1);
    let slope: Vec<f64> = terms
        .map(|(power, coefficient)| power as f64 * coefficient)
        .collect();
    if slope.is_empty() { vec![0.0] } else { slope }
}
