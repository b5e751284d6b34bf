//! Sums of exponentials: what a modulus or a compliance is over a span of times.

use super::form::{Form, MaxwellBranch};
use super::spring_pot::{Response, SpringPot};
use num_complex::Complex64;

// Nodes of the rule from a rate to its double.
pub(super) use spring_pots::LANES;

#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) weight: Complex64,
    pub(super) rate: Complex64,
}

/// A modulus or a compliance over a span of times.
pub(super) struct Spectrum {
    pub(super) response: Response,
    pub(super) constant: f64,
    pub(super) slope: f64,
    /// Σ w·e^(−rt) or Σ w·(1 − e^(−rt)).
    pub(super) modes: Modes,
    pub(super) pair: Option<Pair>,
}

/// Below this r·t a mode is taken by the first terms of its Taylor series: (2^−12)^5/120 is below rounding.
const SLOW: f64 = 1.0 / 4096.0;

/// Rates and weights of the modes.
pub(super) enum Modes {
    Any {
        /// 1/s.
        rates: Vec<f64>,
        /// Weights as [`Spectrum`] says.
        weights: Vec<f64>,
    },
    /// Each rate is twice the one [`LANES`] before it.
    Ladder(Ladder),
}

pub(super) struct Ladder {
    /// Rising, 1/s.
    pub(super) rates: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// Σ w·r^n/n! of all modes before each.
    before: Vec<[f64; 5]>,
    /// Σ w of all modes from each on.
    after: Vec<f64>,
}

impl Ladder {
    pub(super) fn new(rates: Vec<f64>, weights: Vec<f64>) -> Self {
        let mut sums = [0.0; 5];
        let mut before = vec![sums];
        for (rate, weight) in rates.iter().zip(&weights) {
            let mut term = *weight;
            for (n, sum) in sums.iter_mut().enumerate() {
                *sum += term;
                term *= rate / (n + 1) as f64;
            }
            before.push(sums);
        }
        let mut after = vec![0.0; weights.len() + 1];
        for (at, weight) in weights.iter().enumerate().rev() {
            after[at] = after[at + 1] + weight;
        }
        Self {
            rates,
            weights,
            before,
            after,
        }
    }

    /// Σ w·r^n/n! of all modes before one, n = 0…4.
    pub(super) fn before(&self, mode: usize) -> [f64; 5] {
        self.before[mode]
    }

    /// Σ w·e^(−rt) or Σ w·(1 − e^(−rt)).
    fn sum(&self, response: Response, t: f64) -> f64 {
        let first = self.rates.partition_point(|r| r * t < SLOW);
        let [p0, p1, p2, p3, p4] = self.before[first];
        let slow = t * (p1 - t * (p2 - t * (p3 - t * p4)));
        let mut lanes = [-1.0; LANES];
        for (lane, rate) in lanes.iter_mut().zip(&self.rates[first..]) {
            *lane = libm::expm1(-rate * t);
        }
        // 18 doublings from the slowest of these reach r·t = 60, where e^(−rt) counts for nothing.
        const MOVING: usize = 18 * LANES;
        let end = usize::min(first + MOVING, self.weights.len());
        let relaxation = response == Response::Relaxation;
        let mut sums = [0.0; LANES];
        // The span ends long before the modes do, so no chunk is cut short.
        for chunk in self.weights[first..end].chunks_exact(LANES) {
            for lane in 0..LANES {
                let m = lanes[lane];
                sums[lane] += chunk[lane] * if relaxation { 1.0 + m } else { -m };
                lanes[lane] = m * (2.0 + m);
            }
        }
        let moving = sums.iter().sum::<f64>();
        match response {
            Response::Relaxation => (p0 - slow) + moving,
            Response::Creep => slow + moving + self.after[end],
        }
    }
}

impl Spectrum {
    /// G or J for times from `shortest` to `longest`, 0 < `shortest` ≤ `longest`.
    pub(super) fn new(form: &Form, response: Response, shortest: f64, longest: f64) -> Self {
        match (form, response) {
            (Form::Branches(beside, branches), Response::Relaxation) => {
                Self::of_branches(*beside, branches)
            }
            (Form::Branches(beside, branches), Response::Creep) => {
                Self::creep_of_branches(*beside, branches)
            }
            (Form::One(_) | Form::Two(_), _) => {
                Self::over_the_cut(form, response, shortest, longest)
            }
        }
    }

    /// ```text
    /// G(t) = E + Σ E_i·e^(−t/τ_i)          a dashpot gives its η times the slope of the strain
    /// ```
    fn of_branches(beside: SpringPot, branches: &[MaxwellBranch]) -> Self {
        let [constant, slope] = spring_and_dashpot(beside);
        // Rates rise as times fall.
        let modes = || branches.iter().rev();
        Self {
            response: Response::Relaxation,
            constant,
            slope,
            modes: Modes::Any {
                rates: modes().map(|one| 1.0 / one.relaxation_time_s).collect(),
                weights: modes().map(|one| one.elastic_modulus_pa).collect(),
            },
            pair: None,
        }
    }

    /// ```text
    /// M(−r) = E − η₀·r − Σ E_i·rτ_i/(1 − rτ_i)   one zero r_k between any two rates 1/τ_i, one below the first if E > 0, one above the last if η₀ > 0
    /// J(t) = 1/(E + ΣE_i) + t/η + Σ w_k·(1 − e^(−r_k·t)),   w_k = 1/(η₀·r_k + Σ E_i·r_kτ_i/(1 − r_kτ_i)²),   1/η = 0 if E > 0, else η = η₀ + ΣE_iτ_i
    /// ```
    /// With a dashpot the first term is 0.
    /// Source: B. Gross, *Mathematical Structure of the Theories of Viscoelasticity*, 1953.
    fn creep_of_branches(beside: SpringPot, branches: &[MaxwellBranch]) -> Self {
        let [spring_pa, dashpot_pa_s] = spring_and_dashpot(beside);
        let stiffness =
            |from: f64| (branches.iter()).fold(from, |sum: f64, one| sum + one.elastic_modulus_pa);
        let slope = if spring_pa > 0.0 {
            0.0
        } else {
            1.0 / branches.iter().fold(dashpot_pa_s, |sum, one| {
                sum + one.elastic_modulus_pa * one.relaxation_time_s
            })
        };
        let mut rates = Vec::new();
        // From the slowest branch on: a zero below each rate, down to the rate before it.
        let mut below = if spring_pa > 0.0 { Some(0.0) } else { None };
        for branch in branches.iter().rev() {
            let pole = 1.0 / branch.relaxation_time_s;
            if let Some(below) = below {
                rates.push(zero_between(beside, branches, below, pole));
            }
            below = Some(pole);
        }
        if let Some(below) = below.filter(|_| dashpot_pa_s > 0.0) {
            let above = below + stiffness(0.0) / dashpot_pa_s;
            rates.push(zero_between(beside, branches, below, above));
        }
        let weight = |r: &f64| {
            1.0 / branches.iter().fold(dashpot_pa_s * r, |sum, one| {
                let x = r * one.relaxation_time_s;
                sum + one.elastic_modulus_pa * x / ((1.0 - x) * (1.0 - x))
            })
        };
        Self {
            response: Response::Creep,
            constant: if dashpot_pa_s > 0.0 {
                0.0
            } else {
                1.0 / stiffness(spring_pa)
            },
            slope,
            modes: Modes::Any {
                weights: rates.iter().map(weight).collect(),
                rates,
            },
            pair: None,
        }
    }

    /// G or J at a time of the span.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let modes = self.modes_at(time_s);
        match self.response {
            Response::Relaxation => self.constant + modes,
            Response::Creep => self.constant + self.slope * time_s + modes,
        }
    }

    /// Sum of the modes, without constant and slope.
    pub(super) fn modes_at(&self, time_s: f64) -> f64 {
        let relaxation = self.response == Response::Relaxation;
        let sum = match &self.modes {
            Modes::Any { rates, weights } => {
                let modes = weights.iter().zip(rates);
                modes.fold(0.0, |sum, (w, r)| {
                    let k = if relaxation {
                        libm::exp(-r * time_s)
                    } else {
                        -libm::expm1(-r * time_s)
                    };
                    sum + w * k
                })
            }
            Modes::Ladder(ladder) => ladder.sum(self.response, time_s),
        };
        let pair = self.pair.map_or(0.0, |pair| {
            if relaxation {
                real_product(pair.weight, left(pair.rate, time_s))
            } else {
                -real_product(pair.weight, decayed(pair.rate, time_s))
            }
        });
        sum + pair
    }
}

/// e^(−rt) of a complex rate with Re r ≥ 0.
fn left(rate: Complex64, time_s: f64) -> Complex64 {
    let size = libm::exp(-rate.re * time_s);
    // The angle of an overflowing rate has no meaning.
    if size > 0.0 {
        let (sin, cos) = libm::sincos(rate.im * time_s);
        Complex64::new(size * cos, -size * sin)
    } else {
        Complex64::ZERO
    }
}

/// e^(−rt) − 1 of a complex rate with Re r ≥ 0.
pub(super) fn decayed(rate: Complex64, time_s: f64) -> Complex64 {
    let (re, im) = (rate.re * time_s, rate.im * time_s);
    if re.is_nan() || re > 745.0 {
        return Complex64::new(-1.0, 0.0);
    }
    // e^(−a)·(cos b − i·sin b) − 1 without cancellation: cos b − 1 = −2·sin²(b/2).
    let half = libm::sin(0.5 * im);
    let less = libm::expm1(-re);
    let size = 1.0 + less;
    Complex64::new(less - 2.0 * size * half * half, -size * libm::sin(im))
}

/// E and η of a spring or a dashpot.
fn spring_and_dashpot(one: SpringPot) -> [f64; 2] {
    if one.is_dashpot() {
        [0.0, one.size]
    } else {
        [one.size, 0.0]
    }
}

/// M(−r) falls from +∞ (or E at 0) to −∞ between two rates.
fn zero_between(beside: SpringPot, branches: &[MaxwellBranch], low: f64, high: f64) -> f64 {
    let [spring_pa, dashpot_pa_s] = spring_and_dashpot(beside);
    let modulus = |r: f64| {
        branches
            .iter()
            .fold(spring_pa - dashpot_pa_s * r, |sum, one| {
                let x = r * one.relaxation_time_s;
                sum - one.elastic_modulus_pa * x / (1.0 - x)
            })
    };
    let (mut low, mut high) = (low, high);
    // Halving the interval; towards 0 in the logarithm, so that a small zero has its digits too.
    loop {
        let middle = if low > 0.0 {
            libm::sqrt(low) * libm::sqrt(high)
        } else {
            high * 0.001
        };
        if middle <= low || middle >= high {
            return high;
        }
        if modulus(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Re(w·k) of a pair of conjugate terms whose sum that is.
pub(super) fn real_product(a: Complex64, b: Complex64) -> f64 {
    a.re * b.re - a.im * b.im
}
