//! The open loop on a grid of frequencies, and what can be read from it.

use super::specification::{Sampling, Specification};
use core::{cell::RefCell, f64::consts::PI};
use fracdiff::roots;
use fractional_control::{
    ControlError, PidParameters, Plant, Rule,
    whole_orders::{coefficients, of_coefficients, without_root},
};
use num_complex::Complex;
use std::{collections::BTreeMap, rc::Rc};

/// Frequencies of the grid, below and above the crossover: 60 a decade near it would be 4 %.
const POINTS: usize = 180;
/// Decades below and above the crossover.
const BELOW: f64 = 4.0;
const ABOVE: f64 = 3.0;
/// Points a decade beyond, up to half the sample rate.
const FAR_POINTS: f64 = 20.0;
/// Aliases of a sampled plant on each side. Those left out are 0.6 % of the sum at half the sample rate where a plant falls as 1/ω.
const ALIASES: i32 = 32;
/// Times the grid is halved on both sides of a peak of the plant.
const PEAK_HALVINGS: usize = 8;
/// A little beyond half and double the gain, up to which a loop should hold.
const BEYOND: [f64; 2] = [0.49, 2.04];
/// Number of times at which a step is evaluated, from 0.4/`ω_c` over two decades.
const TIMES: usize = 64;

/// Everything about the plant and the rule that no parameter of the controller changes.
#[derive(Clone, Debug)]
pub(crate) struct OpenLoop {
    points: Vec<Point>,
    /// Values at the crossover: ln s, its slope over ln ω, G with the hold, and the slope of its logarithm.
    pub crossover: (Complex<f64>, Complex<f64>, Complex<f64>, Complex<f64>),
    pub omega: f64,
    nyquist: Nyquist,
    twin: Option<Twin>,
    /// Phase of the plant at rest, as it would be followed from 0 on, with the sign that its controller has.
    phase_at_rest: f64,
    sign: f64,
    /// Weights of Re T on the grid that make y at each of the times.
    steps: Vec<[f64; TIMES]>,
    /// s to each order that was tried, on the grid.
    powers: RefCell<BTreeMap<u64, Rc<[Complex<f64>]>>>,
}

/// A lag that turns the plant by less than this at the crossover, rad, cannot be separated there from a dead time.
const FAST: f64 = 0.5;

/// The plant whose fast lags are a dead time, on the grid.
#[derive(Clone, Debug)]
struct Twin {
    /// The twin over the plant itself, frequency by frequency.
    shares: Vec<Complex<f64>>,
    nyquist: Nyquist,
}

impl Twin {
    fn new(
        plant: &Plant,
        points: &[Point],
        omega: f64,
        sampling: Option<Sampling>,
    ) -> Option<Self> {
        let twin = with_dead_time(plant, omega)?;
        let share = |point: &Point| Some(held(&twin, point.omega, sampling)?.0 / point.plant);
        let frequencies: Vec<f64> = points.iter().map(|point| point.omega).collect();
        Some(Self {
            shares: points.iter().map(share).collect::<Option<_>>()?,
            nyquist: Nyquist::new(&twin, &frequencies),
        })
    }

    fn is_stable(&self, open: &[Complex<f64>]) -> bool {
        let open: Vec<Complex<f64>> = open
            .iter()
            .zip(&self.shares)
            .map(|(l, share)| l * share)
            .collect();
        let sizes: Vec<f64> = open.iter().map(|l| l.norm()).collect();
        self.nyquist.is_stable(&open, self.nyquist.end(&sizes), 1.0)
    }
}

/// The plant with e^(−τs) for each lag 1/(τs + 1) that is fast beside the crossover; it still falls as 1/s at least. `None` without such a lag.
fn with_dead_time(plant: &Plant, omega: f64) -> Option<Plant> {
    let function = plant.function().filter(|function| function.is_whole())?;
    let above = coefficients(function.numerator());
    let mut below = coefficients(function.denominator());
    let mut late_s = 0.0;
    // The slowest root first.
    for pole in roots(&below).into_iter().rev() {
        let is_fast = pole.im == 0.0 && pole.re < 0.0 && omega < -FAST * pole.re;
        if !is_fast || below.len() <= above.len() + 1 {
            break;
        }
        below = without_root(&below, pole);
        below.iter_mut().for_each(|c| *c *= -pole.re);
        late_s -= 1.0 / pole.re;
    }
    let twin = Plant::transfer(of_coefficients(&above, &below)?, late_s + plant.delay_s());
    twin.ok().filter(|_| late_s > 0.0)
}

/// One frequency: ω, ln s, G with the hold.
#[derive(Clone, Copy, Debug)]
struct Point {
    omega: f64,
    ln_s: Complex<f64>,
    plant: Complex<f64>,
}

/// Peaks, spreads and stability of the loop with one controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Measures {
    /// Largest |S| and |T|.
    pub sensitivity_peak: f64,
    /// Largest |T|.
    pub complementary_peak: f64,
    /// Largest |T| from the frequency of the noise on, if one was given: |L|/(1 − |L|), its bound for any phase, where |L| is below 1/2.
    pub noise: Option<f64>,
    /// Largest |S| up to the frequency of the disturbance, if one was given.
    pub disturbance: Option<f64>,
    /// Largest less least overshoot of the step response while the gain goes from half to double, by the inverse transform of
    /// T on the grid, to some 1e-3; [`steps`](super::steps) simulates it. Infinite where the loop is not stable.
    pub overshoot_spread: f64,
    /// Largest change of the phase margin while the gain goes from half to double, rad.
    pub margin_spread_rad: f64,
    /// Least phase margin in size at the crossovers beside the wished one, rad; π without any.
    pub other_margin_rad: f64,
    /// The closed loop is stable by Nyquist's count on the grid; the verdict that counts is [`SampledControlLoop`](fractional_control::SampledControlLoop)'s.
    pub stable: bool,
    /// Largest |L| at the highest frequencies, which alone decides about a loop there.
    pub(crate) end: f64,
    /// True if the loop is stable at half to double the gain and a little beyond, each of [`GAINS`](super::GAINS).
    pub stable_over_gains: bool,
    /// True if the loop is stable with a dead time in place of each lag of the plant below half of 1/`ω_c`: records and models seldom separate them.
    pub stable_with_dead_time: bool,
}

/// ln of the function of w that stands for s.
fn ln_s(omega: f64, sampling: Option<Sampling>) -> Complex<f64> {
    let Some(Sampling { sample_time, rule }) = sampling else {
        return Complex::new(libm::log(omega), 0.5 * PI);
    };
    let (s, c) = libm::sincos(0.5 * omega * sample_time.0);
    let v = Complex::new(2.0 * s * s, 2.0 * s * c);
    let s = match rule {
        Rule::Grunwald => v,
        Rule::Bdf2 => v * (v * 0.5 + 1.0),
    };
    (s / sample_time.0).ln()
}

/// The plant behind a hold of T as its samples see it, and the share of all aliases in it: the first ones on each side.
/// ```text
/// Σ_k G(jω_k)·(1 − e^(−jωT))/(jω_k T),   ω_k = ω + 2πk/T
/// ```
fn held(
    plant: &Plant,
    omega: f64,
    sampling: Option<Sampling>,
) -> Option<(Complex<f64>, Complex<f64>)> {
    let response = plant.response(omega)?;
    let Some(sampling) = sampling else {
        return Some((response, Complex::new(1.0, 0.0)));
    };
    let t = sampling.sample_time.0;
    let (sin, cos) = libm::sincos(0.5 * omega * t);
    let at = |k: i32| {
        let omega = omega + 2.0 * PI * f64::from(k) / t;
        // Of a measured response nothing is known there.
        let response = plant.response(omega.abs())?;
        let turned = Complex::new(response.re, response.im * omega.signum());
        Some(turned / omega)
    };
    // Far ones first, both of a pair together.
    let pairs = (1..=ALIASES).rev().map(|k| at(k).zip(at(-k)));
    let aliases: Complex<f64> = pairs.flatten().map(|(above, below)| above + below).sum();
    let first = response / omega;
    let sum = first + aliases;
    let behind_hold = sum * Complex::new(cos, -sin) * (2.0 * sin / t);
    Some((behind_hold, sum / first))
}

/// Frequencies around the crossover within the band of the plant, those of the bounds, and of samples all up to half their rate.
fn grid(plant: &Plant, wishes: &Specification, half_rate: Option<f64>) -> Vec<f64> {
    let omega = wishes.crossover_rad_s;
    let (low, high) = plant.band();
    let low = (omega * libm::pow(10.0, -BELOW)).max(low * (1.0 + 1e-9));
    let high = (high * (1.0 - 1e-9)).min(half_rate.unwrap_or(f64::INFINITY));
    let near = (omega * libm::pow(10.0, ABOVE)).min(high);
    let ratio = libm::log(near / low) / (POINTS - 1) as f64;
    let around = (0..POINTS).map(|k| low * libm::exp(ratio * k as f64));
    let far = half_rate.map_or(near, |_| high);
    let count = libm::ceil(FAR_POINTS * libm::log10(far / near)) as usize;
    let step = libm::log(far / near) / count.max(1) as f64;
    let beyond = (1..=count).map(|k| near * libm::exp(step * k as f64));
    let bounds = [wishes.noise, wishes.disturbance].into_iter().flatten();
    let bounds = bounds.map(|bound| bound.omega_rad_s);
    let bounds = bounds.filter(|omega| *omega > low && *omega < far);
    let mut grid: Vec<f64> = around.chain(beyond).chain(bounds).collect();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    grid
}

/// Puts points to both sides of each peak of the plant, again and again: a swing that hardly decays is narrower than the grid.
fn with_peaks(mut points: Vec<Point>, at: impl Fn(f64) -> Option<Point>) -> Vec<Point> {
    for _ in 0..PEAK_HALVINGS {
        let size = |k: usize| points[k].plant.norm();
        let peaks = (1..points.len().saturating_sub(1))
            .filter(|k| size(*k) > size(k - 1) && size(*k) > size(k + 1));
        let sides = peaks.flat_map(|k| [[k - 1, k], [k, k + 1]]);
        let frequencies = sides.map(|[a, b]| libm::sqrt(points[a].omega * points[b].omega));
        let inner: Vec<Point> = frequencies.filter_map(&at).collect();
        points.extend(inner);
        points.sort_by(|a, b| a.omega.total_cmp(&b.omega));
    }
    points
}

impl OpenLoop {
    pub(crate) fn new(
        plant: &Plant,
        wishes: &Specification,
        sampling: Option<Sampling>,
    ) -> Result<Self, ControlError> {
        let omega = wishes.crossover_rad_s;
        let unknown = ControlError::NotFound {
            what: "the response of the plant at the crossover",
            why: "measure on both sides of it",
        };
        let half_rate = sampling.map(|sampling| 0.999 * PI / sampling.sample_time.0);
        let grid = grid(plant, wishes, half_rate);
        let low = grid.first().copied().unwrap_or(omega);
        let at = |omega: f64| {
            let (plant, _) = held(plant, omega, sampling)?;
            let ln_s = ln_s(omega, sampling);
            Some(Point { omega, ln_s, plant })
        };
        let points = with_peaks(grid.into_iter().filter_map(at).collect(), at);
        let (here, _) = held(plant, omega, sampling).ok_or(unknown)?;
        // Slopes by central differences.
        let h = 1e-5;
        let (above, below) = (omega * libm::exp(h), omega * libm::exp(-h));
        let slope_s = (ln_s(above, sampling) - ln_s(below, sampling)) / (2.0 * h);
        let hold =
            |omega: f64| sampling.map_or(0.0, |sampling| -0.5 * omega * sampling.sample_time.0);
        let aliased = |omega: f64| held(plant, omega, sampling).map(|(_, share)| share.ln());
        let aliased = aliased(above).zip(aliased(below)).ok_or(unknown)?;
        let aliases = (aliased.0 - aliased.1) / (2.0 * h);
        // The phase of the hold; its gain is flat to (ωT)²/12.
        let slope_plant =
            plant.slope(omega).ok_or(unknown)? + aliases + Complex::new(0.0, hold(omega));
        let frequencies: Vec<f64> = points.iter().map(|point| point.omega).collect();
        let times =
            (0..TIMES).map(|k| libm::pow(10.0, -0.4 + 2.0 * k as f64 / TIMES as f64) / omega);
        Ok(Self {
            steps: {
                let rows: Vec<Vec<f64>> = times.map(|t| step_row(&frequencies, t)).collect();
                let weights = |k: usize| core::array::from_fn(|time| rows[time][k]);
                (0..points.len()).map(weights).collect()
            },
            powers: RefCell::default(),
            crossover: (ln_s(omega, sampling), slope_s, here, slope_plant),
            omega,
            nyquist: Nyquist::new(plant, &frequencies),
            twin: Twin::new(plant, &points, omega, sampling),
            phase_at_rest: plant.phase_at_rest(low),
            sign: plant.sign(),
            points,
        })
    }

    /// The phase of the plant at the crossover, times its sign, followed from low frequencies on, rad.
    pub(crate) fn plant_phase(&self) -> f64 {
        let below = self.points.iter().filter(|point| point.omega < self.omega);
        let rest = Complex::from_polar(self.sign, self.phase_at_rest);
        let (mut phase, mut last) = (self.phase_at_rest, rest);
        for next in below.map(|point| point.plant).chain([self.crossover.2]) {
            let turn = (next / last).arg();
            // Across a pole on the axis: as with a little damping.
            phase += if turn > PI - 1e-6 {
                turn - 2.0 * PI
            } else {
                turn
            };
            last = next;
        }
        phase
    }

    pub(crate) fn open(&self, gains: &PidParameters) -> Vec<Complex<f64>> {
        let integral = self.power(-gains.integral_order);
        let derivative = self.power(gains.derivative_order);
        let powers = integral.iter().zip(derivative.iter()).zip(&self.points);
        let open = powers.map(|((integral, derivative), point)| {
            (integral * gains.integral + derivative * gains.derivative + gains.proportional)
                * point.plant
        });
        open.collect()
    }

    /// s^order on the grid: the same few orders are tried again and again.
    fn power(&self, order: f64) -> Rc<[Complex<f64>]> {
        let mut powers = self.powers.borrow_mut();
        let power = || self.points.iter().map(|point| (point.ln_s * order).exp());
        let power = powers
            .entry(order.to_bits())
            .or_insert_with(|| power().collect());
        Rc::clone(power)
    }

    /// Reads an open loop, all but [`overshoot_spread`](Self::overshoot_spread), which takes the longest.
    pub(crate) fn measure(&self, open: &[Complex<f64>], wishes: &Specification) -> Measures {
        let (mut s_most, mut t_most) = (0.0_f64, 0.0_f64);
        let (mut noise, mut disturbance) = (0.0_f64, 0.0_f64);
        let sizes: Vec<f64> = open.iter().map(|l| l.norm()).collect();
        for ((point, l), size) in self.points.iter().zip(open).zip(&sizes) {
            let s = (*l + 1.0).inv();
            let t = s * l;
            s_most = larger(s_most, s);
            t_most = larger(t_most, t);
            if wishes.noise.is_some_and(|b| point.omega >= b.omega_rad_s) {
                // Whatever a dead time makes of the phase before the next point.
                noise = noise.max(if *size < 0.5 {
                    size / (1.0 - size)
                } else {
                    t.norm()
                });
            }
            if wishes
                .disturbance
                .is_some_and(|b| point.omega <= b.omega_rad_s)
            {
                disturbance = larger(disturbance, s);
            }
        }
        let end = self.nyquist.end(&sizes);
        Measures {
            sensitivity_peak: s_most,
            complementary_peak: t_most,
            noise: wishes.noise.map(|_| noise),
            disturbance: wishes.disturbance.map(|_| disturbance),
            overshoot_spread: f64::INFINITY,
            margin_spread_rad: margin_spread(open, &sizes, wishes.phase_margin_rad),
            other_margin_rad: self.other_margin(open, &sizes),
            stable: self.nyquist.is_stable(open, end, 1.0),
            end,
            stable_over_gains: (super::GAINS.iter())
                .chain(&BEYOND)
                .all(|gain| self.nyquist.is_stable(open, end, *gain)),
            stable_with_dead_time: self.twin.as_ref().is_none_or(|twin| twin.is_stable(open)),
        }
    }

    /// Overshoot spread of a stable loop; infinite as soon as it is known to be no less than `most`.
    pub(crate) fn overshoot_spread(&self, open: &[Complex<f64>], most: f64) -> f64 {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        // The ends first: there it is lowest and highest.
        let [a, b, c, d, e] = super::GAINS;
        for gain in [e, a, c, b, d] {
            let mut step = [0.0_f64; TIMES];
            for (l, weights) in open.iter().zip(&self.steps) {
                let real = (l * gain / (l * gain + 1.0)).re;
                for (y, weight) in step.iter_mut().zip(weights) {
                    *y += weight * real;
                }
            }
            let overshoot = (step.into_iter().fold(f64::NEG_INFINITY, f64::max) - 1.0).max(0.0);
            (low, high) = (low.min(overshoot), high.max(overshoot));
            if high - low >= most {
                return f64::INFINITY;
            }
        }
        high - low
    }

    /// The least margin in size where |L| passes 1, but for the wished crossover.
    fn other_margin(&self, open: &[Complex<f64>], sizes: &[f64]) -> f64 {
        let places = self.points.windows(2).zip(sizes.windows(2)).enumerate();
        let margins = places.filter_map(|(at, (points, sizes))| {
            let ([below, above], [a, b]) = (points, sizes) else {
                return None;
            };
            let wished = (below.omega..=above.omega).contains(&self.omega);
            let crosses = (*a < 1.0) != (*b < 1.0);
            (crosses && !wished).then(|| margin_between(open[at], open[at + 1], 1.0).abs())
        });
        margins.fold(PI, f64::min)
    }
}

/// The larger of a size and |z|, to the bit, without the root of one that is clearly smaller.
fn larger(size: f64, z: Complex<f64>) -> f64 {
    if z.norm_sqr() < 0.999 * size * size {
        size
    } else {
        size.max(z.norm())
    }
}

/// The largest change of the margin where |L| is 1/k, for k from 1/2 to 2; `sizes` is |L|.
fn margin_spread(open: &[Complex<f64>], sizes: &[f64], margin: f64) -> f64 {
    let mut spread = 0.0_f64;
    for gain in [0.5, 0.7, 1.4, 2.0] {
        // The highest frequency at which |L|·k falls through 1.
        let falls = |pair: &[f64]| pair[0] * gain >= 1.0 && pair[1] * gain < 1.0;
        let Some(at) = sizes.windows(2).rposition(falls) else {
            return PI;
        };
        let phase = margin_between(open[at], open[at + 1], gain);
        spread = spread.max((phase - margin).abs());
    }
    spread
}

/// The phase margin where k·|L| is 1 between two neighbours of the grid, by a straight line of ln L, rad.
fn margin_between(a: Complex<f64>, b: Complex<f64>, gain: f64) -> f64 {
    let (from, to) = (libm::log(a.norm() * gain), libm::log(b.norm() * gain));
    let share = from / (from - to);
    (-a).arg() + share * (b / a).arg()
}

/// y(t) = (2/π)∫ Re T(jω)·sin(ωt)/ω dω as a row of weights of Re T, which is constant below the first frequency and where Re T/ω is a straight line
/// between two (L. N. G. Filon's rule).
/// ```text
/// ∫ sin(ωt)·(ω − a)/(b − a) dω over [a, b] = (sin bt − sin at)/((b − a)t²) − cos bt/t,   and the rest by symmetry
/// ```
fn step_row(frequencies: &[f64], t: f64) -> Vec<f64> {
    let mut row: Vec<f64> = frequencies.iter().map(|_| 0.0).collect();
    for (k, pair) in frequencies.windows(2).enumerate() {
        let [a, b] = pair else { continue };
        let width = b - a;
        let angle = width * t;
        let ((sin_a, cos_a), (sin_b, cos_b)) = (libm::sincos(a * t), libm::sincos(b * t));
        let (rising, falling) = if angle < 0.05 {
            // The rule of Simpson: exact to angle⁴/2880.
            let middle = libm::sin(0.5 * (a + b) * t);
            let sixth = width / 6.0;
            (
                sixth * (2.0 * middle + sin_b),
                sixth * (2.0 * middle + sin_a),
            )
        } else {
            let slope = (sin_b - sin_a) / (width * t * t);
            (slope - cos_b / t, cos_a / t - slope)
        };
        row[k] += falling / a;
        row[k + 1] += rising / b;
    }
    if let (Some(weight), Some(first)) = (row.first_mut(), frequencies.first()) {
        // ∫ sin(ωt)/ω from 0 on.
        *weight += first * t;
    }
    row.iter_mut().for_each(|weight| *weight *= 2.0 / PI);
    row
}

/// C at s, which is given by its logarithm.
pub(crate) fn at(gains: &PidParameters, ln_s: Complex<f64>) -> Complex<f64> {
    let power = |gain: f64, order: f64| {
        if gain == 0.0 {
            Complex::new(0.0, 0.0)
        } else {
            (ln_s * order).exp() * gain
        }
    };
    power(gains.integral, -gains.integral_order)
        + power(gains.derivative, gains.derivative_order)
        + gains.proportional
}

/// |L| above which the loop is not judged at the highest frequency of the grid, and where dead time turns L by more than [`TURN`] from point
/// to point.
const SMALL: f64 = 0.7;
/// Turn by dead time between two points of the grid, rad.
const TURN: f64 = 1.0;

/// Contribution of the plant's poles to the count: its denominator A on the grid.
/// ```text
/// F = A·(1 + kL) has the poles of the closed loop for zeros and none of its own, so that it is finite at a pole of the plant too
/// stable ⇔ F turns by (α − n)·π/2 from the lowest frequency up,   α the degree of A,   F ~ ω^n at the lowest
/// ```
#[derive(Clone, Debug)]
pub(super) struct Nyquist {
    /// A/|A|.
    directions: Vec<Complex<f64>>,
    /// The turn of A from the highest frequency on, rad.
    rest: f64,
    degree: f64,
    /// d ln|A|/d ln ω at the lowest frequency.
    rise: f64,
    /// ln of the second frequency over the first.
    ratio: f64,
    /// The first point from which on dead time turns L fast.
    fast_from: usize,
}

impl Nyquist {
    pub(super) fn new(plant: &Plant, omegas: &[f64]) -> Self {
        let at = |omega: f64| plant.denominator(omega);
        let ends = omegas.first().zip(omegas.get(1));
        let (rise, ratio) = ends.map_or((0.0, 1.0), |(first, second)| {
            let ratio = libm::log(second / first);
            ((at(*second).0 - at(*first).0) / ratio, ratio)
        });
        Self {
            directions: omegas.iter().map(|omega| at(*omega).1).collect(),
            rest: omegas
                .last()
                .map_or(0.0, |omega| plant.denominator_turn_from(*omega)),
            degree: plant.degree(),
            rise,
            ratio,
            fast_from: omegas
                .windows(2)
                .position(|pair| (pair[1] - pair[0]) * plant.delay_s() > TURN)
                .unwrap_or(omegas.len()),
        }
    }

    /// The largest |L| at the end of the grid, and where dead time turns it fast.
    pub(super) fn end(&self, sizes: &[f64]) -> f64 {
        let from = self.fast_from.min(sizes.len().saturating_sub(1));
        let sizes = sizes.iter().skip(from);
        // A value that is not finite counts as large.
        sizes.fold(0.0, |most, size| if *size <= most { most } else { *size })
    }

    /// True if the loop is stable at a gain k, by the grid; `open` is L on it, `end` its [`end`](Self::end).
    fn is_stable(&self, open: &[Complex<f64>], end: f64, gain: f64) -> bool {
        let (Some(first), Some(second), Some(last)) = (open.first(), open.get(1), open.last())
        else {
            return false;
        };
        // Also not so of what is no number.
        let ends_small = end * gain <= SMALL;
        if !ends_small {
            return false;
        }
        // A straight line from point to point turns by less than π; each that passes 0 on the left adds a whole turn.
        let pairs = open.iter().zip(&self.directions);
        let mut values = pairs.map(|(l, direction)| (l * gain + 1.0) * direction);
        let Some(begin) = values.next() else {
            return false;
        };
        let (mut turns, mut from) = (0.0, begin);
        for to in values {
            if (from.im < 0.0) != (to.im < 0.0) {
                let meets = (from.re * to.im - to.re * from.im) / (to.im - from.im);
                if meets < 0.0 {
                    turns += if to.im < 0.0 { 1.0 } else { -1.0 };
                }
            }
            from = to;
        }
        // From the last point on L falls to 0.
        let left = self.rest - (last * gain + 1.0).arg();
        let turn = from.arg() - begin.arg() + 2.0 * PI * turns + left;
        let grows = libm::log((second * gain + 1.0).norm() / (first * gain + 1.0).norm());
        let order = self.rise + grows / self.ratio;
        (turn - 0.5 * PI * (self.degree - order)).abs() < 1.0
    }
}
