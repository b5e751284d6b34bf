//! Sums of exponentials: what a modulus or a compliance is over a span of times.

use super::pole::real_product;
use num_complex::Complex64;

/// Nodes of the rule from a rate to its double.
pub(super) const LANES: usize = 3;
/// The two functions of time.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Response {
    /// G.
    Relaxation,
    /// J.
    Creep,
}

/// Two conjugate modes: Re(weight·k(rate)).
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) weight: Complex64,
    pub(super) rate: Complex64,
}

/// A modulus or a compliance over a span of times.
pub(super) struct Spectrum {
    pub(super) response: Response,
    /// C or A.
    pub(super) constant: f64,
    /// D or B.
    pub(super) slope: f64,
    /// Σ w·e^(−rt) or Σ w·(1 − e^(−rt)).
    pub(super) modes: Modes,
    pub(super) pair: Option<Pair>,
}

/// Below this r·t a mode is taken by the first terms of its Taylor series: (2^−12)^5/120 is below rounding.
const SLOW: f64 = 1.0 / 4096.0;

/// Rates and weights of the modes.
pub(super) enum Modes {
    /// Any rates.
    Any {
        /// 1/s.
        rates: Vec<f64>,
        /// As [`Spectrum`] says.
        weights: Vec<f64>,
    },
    /// Each rate is twice the one [`LANES`] before it.
    Ladder(Ladder),
}

/// Modes whose rates double.
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
    /// G or J at a time of the span.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let modes = self.modes_at(time_s);
        match self.response {
            Response::Relaxation => self.constant + modes,
            Response::Creep => self.constant + self.slope * time_s + modes,
        }
    }

    /// The same without constant and slope.
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
    // Where the rate overflows, its angle has no meaning.
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
