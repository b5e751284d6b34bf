//! The response of a plant behind a hold at the samples, without a rule.

use crate::{
    FractionalPolynomial, FractionalTransferFunction, ImplicitFactor, ImplicitFactors, Plant, Term,
    enclosure::Factor, plant::Model, poles::OnAxis,
};
use certified_count::{Arc, Enclosed, Jet};
use core::f64::consts::PI;
use num_complex::Complex;
use std::{
    sync::{Arc as Shared, OnceLock},
    vec::Vec,
};

/// Terms on either side that are added one by one.
const TERMS: usize = 64;
/// Terms on either side at most whose rates are bounded one by one: from there on the highest powers of the denominator are the largest by far.
const ONE_BY_ONE: usize = 1024;
/// Share of the sum below which a term is not followed by others that count: diffusion leaves none.
const NOTHING_LEFT: f64 = 1e-24;
/// ```text
/// G_d(θ) = Σ_k G(jω_k)·e^(−jω_k τ)·(1 − e^(−jθ))/(jω_k T),   ω_k = (θ + 2πk)/T     (S. D. Poisson)
/// ```
/// What G passes on at once, D, is seen by the next measurement: G − D in the sum, and D·w^⌈τ/T⌉, at least D·w. G may have powers of brackets and
/// diffusion as factors H beside it, with which D = 0.
#[derive(Clone, Debug)]
pub(crate) struct HeldResponse {
    /// G, without its dead time.
    function: FractionalTransferFunction,
    factors: ImplicitFactors,
    /// The numerator of G − D, whose denominator is that of G.
    above: FractionalPolynomial,
    /// Terms whose rates are bounded one by one; `None` where that would be too many.
    one_by_one: Option<usize>,
    direct: f64,
    delay: f64,
    sample_time_s: f64,
    /// The aliases, found when first asked for.
    aliases: Shared<OnceLock<Vec<Piece>>>,
}

impl HeldResponse {
    /// Response of a transfer function; `None` for any other plant.
    pub(crate) fn new(plant: &Plant, sample_time_s: f64) -> Option<Self> {
        let Model::Transfer(function) = &plant.model else {
            return None;
        };
        let above = function.numerator().terms().first()?;
        let below = function.denominator().terms().first()?;
        let factors = *plant.factors();
        let direct = if above.order < below.order || !factors.is_empty() {
            0.0
        } else {
            above.coefficient / below.coefficient
        };
        let led = |k: &usize| {
            let omega = 2.0 * PI * *k as f64 / sample_time_s;
            let denominator = Bounds::new(function.denominator(), libm::log(omega));
            denominator.led > 0.25 && factors.falls_from(omega)
        };
        let counts = core::iter::successors(Some(1), |k| Some(2 * k));
        Some(Self {
            direct,
            delay: plant.delay_s() / sample_time_s,
            function: **function,
            above: if factors.is_empty() {
                function.numerator_without(direct)?
            } else {
                *function.numerator()
            },
            factors,
            one_by_one: counts.take_while(|k| *k <= ONE_BY_ONE).find(led),
            sample_time_s,
            aliases: Shared::default(),
        })
    }

    /// `G_d` on an arc that begins above 0; not finite where the sum does not end, and its rate is not finite where the arc is too wide for a bound.
    pub(crate) fn enclosed(&self, arc: &Arc) -> Enclosed {
        let (theta, turn) = (arc.middle(), 2.0 * PI);
        let sum = self.term(theta) + self.aliases(theta);
        let rate = match arc.half_width() {
            0.0 => 0.0,
            _ => self.rate(arc.low, arc.high) + self.rate(turn - arc.high, turn - arc.low),
        };
        let sum = Enclosed::new(sum, rate, arc);
        let late = |samples: f64| {
            let value = Complex::from_polar(1.0, -samples * theta);
            let slope = value * Complex::new(0.0, -samples);
            Enclosed::bent(Jet::new(value, slope), samples, samples * samples, arc)
        };
        let later = libm::ceil(self.delay - 1e-9).max(1.0);
        let changes = Factor::Difference(1).at(arc);
        let held = sum.times(late(self.delay)).times(changes);
        held.scaled(1.0 / self.sample_time_s)
            .plus(late(later).scaled(self.direct))
    }

    /// Response with less dead time by whole samples, which only turn it.
    pub(crate) fn prompt(mut self) -> Self {
        self.delay -= (libm::ceil(self.delay) - 1.0).max(0.0);
        self
    }

    /// The number of poles of the plant that grow, where it is known.
    pub(crate) fn growing_poles(&self) -> Option<usize> {
        self.function.growing_poles()
    }

    /// (G − D)/(jω) at the angle x = ωT.
    fn term(&self, x: f64) -> Complex<f64> {
        let omega = x / self.sample_time_s;
        let s = Complex::new(0.0, omega);
        (self.function.response(omega) - self.direct) * self.factors.at(s) / s
    }

    /// Σ of the aliases of θ, all terms but the first.
    fn aliases(&self, theta: f64) -> Complex<f64> {
        let folded =
            |theta: f64| self.sum(theta + 2.0 * PI, 1.0) + self.sum(2.0 * PI - theta, 1.0).conj();
        let pieces = self
            .aliases
            .get_or_init(|| pieces(&folded, [0.0, PI], HALVINGS));
        let piece = pieces.iter().find(|piece| theta <= piece.high);
        piece
            .and_then(|piece| piece.at(theta))
            .unwrap_or_else(|| folded(theta))
    }

    /// Σ of (G − D)/(jω)·e^(−j(x − θ)τ/T) over x = from + 2πk, k from 0 on; `aliases` of the first are the turns of x − θ.
    fn sum(&self, from: f64, aliases: f64) -> Complex<f64> {
        let at = |k: usize| from + 2.0 * PI * k as f64;
        let late = |k: usize| {
            let turns = (aliases + k as f64) * self.delay;
            Complex::from_polar(1.0, -2.0 * PI * (turns - libm::round(turns)))
        };
        let sum: Complex<f64> = (0..TERMS).map(|k| self.term(at(k)) * late(k)).sum();
        let far = |place: f64| self.term(2.0 * PI * place);
        let part = self.delay - libm::round(self.delay);
        let a = at(TERMS) / (2.0 * PI);
        if far(a).norm() <= NOTHING_LEFT * sum.norm() {
            return sum;
        }
        sum + far_sum(far, a, part) * late(TERMS)
    }

    /// sup |d/dθ| of the same sum without its dead time, over from ∈ \[low, high\].
    fn rate(&self, low: f64, high: f64) -> f64 {
        let Some(count) = self.one_by_one else {
            return f64::INFINITY;
        };
        let turned = |k: usize| 2.0 * PI * k as f64;
        let first = (0..count).map(|k| self.term_rate(low + turned(k), high + turned(k)));
        first.sum::<f64>() + self.rest_rate(low + turned(count))
    }

    /// ```text
    /// g = NH/(jωA):   |dg/dx| ≤ |H|·((|N|(1 + |H′/H|) + |N′|)/(ω|A|) + |N|·|A′|/(ω|A|²)),   x = ln ω, ′ = d/dx
    /// ```
    fn term_rate(&self, low: f64, high: f64) -> f64 {
        let ln = |angle: f64| libm::log(angle / self.sample_time_s);
        let x = ln(0.5 * (low + high));
        let half = x - ln(low);
        let (above, below) = (
            Bounds::new(&self.above, ln(high)),
            Bounds::new(self.function.denominator(), ln(high)),
        );
        let size = |polynomial: &FractionalPolynomial, bounds: &Bounds| {
            OnAxis(polynomial).at(x, bounds.scale).norm()
        };
        let least = size(self.function.denominator(), &below) - half * below.rate;
        let most = size(&self.above, &above) + half * above.rate;
        let [size, rate] = self
            .factors
            .bounds([low, high].map(|x| x / self.sample_time_s));
        size * above.over(&below, most, least, rate) * self.sample_time_s / (low * low)
    }

    /// The sum of those rates from the angle x on.
    /// ```text
    /// |A| ≥ l·Σ|a|ω^α with the share l at x, and |dg/dx| ≤ |g|·(1 + ν + α/l + |H′/H|), which falls as ω^(−β), β = 1 + α_lead − ν − η, η that
    /// of |H|;   Σ of it/x over x + 2πk
    /// ```
    fn rest_rate(&self, x: f64) -> f64 {
        let ln = libm::log(x / self.sample_time_s);
        let (above, below) = (
            Bounds::new(&self.above, ln),
            Bounds::new(self.function.denominator(), ln),
        );
        if above.size == 0.0 {
            return 0.0;
        }
        let (degree_above, degree_below) =
            (self.above.degree(), self.function.denominator().degree());
        let omega = x / self.sample_time_s;
        let [size, rate] = self.factors.bounds([omega; 2]);
        let relative = 1.0 + degree_above + degree_below / below.led + rate;
        let least = below.led * below.lead;
        let first = size * relative * above.size / least * libm::exp(above.scale - below.scale);
        let order = 1.0 + below.lead_order - degree_above - self.factors.rise_from(omega);
        if order <= 0.0 {
            return f64::INFINITY;
        }
        first * self.sample_time_s / (x * x) * (1.0 + x / (2.0 * PI * order))
    }
}

impl ImplicitFactors {
    /// sup |H| and sup |d ln H/d ln ω| on the imaginary axis between two frequencies.
    /// ```text
    /// |d ln(jbω + c)^α| = |α|·|jbω/(jbω + c)| ≤ |α|,   |d(−k√(jbω + c))| = k·bω/(2|√(jbω + c)|), which rises with ω;   |H| of each goes one way
    /// ```
    fn bounds(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let of_factor = |factor: &ImplicitFactor| {
            let base = |omega: f64| Complex::new(factor.constant, factor.slope * omega);
            let size = |omega: f64| factor.of_base(base(omega)).norm();
            let (rise, base) = (factor.slope * high, base(high).norm());
            let rate = if factor.is_power {
                1.0
            } else {
                0.5 * rise / libm::sqrt(base)
            };
            [size(low).max(size(high)), factor.order.abs() * rate]
        };
        let all = self.all().iter().map(of_factor);
        all.fold([1.0, 0.0], |[size, rate], next| {
            [size * next[0], rate + next[1]]
        })
    }

    /// η, with which |H|·(κ + Y), κ ≥ 1, rises at most as ω^η from this frequency on; a power that falls does so at least as it does here.
    fn rise_from(&self, omega: f64) -> f64 {
        let rise = |factor: &ImplicitFactor| {
            let rise = factor.slope * omega / factor.constant;
            let share = rise * rise / (rise * rise + 1.0);
            match (factor.is_power, factor.order > 0.0) {
                (true, true) => factor.order,
                (true, false) => factor.order * share,
                (false, _) => -factor.fall_from(omega),
            }
        };
        self.all().iter().map(rise).sum()
    }

    /// True if all diffusion falls faster from this frequency on than its rate rises.
    fn falls_from(&self, omega: f64) -> bool {
        let mut all = self.all().iter().filter(|factor| !factor.is_power);
        all.all(|factor| factor.fall_from(omega) >= 0.0)
    }
}

impl ImplicitFactor {
    /// −d ln(|H|·(κ + Y))/d ln ω of diffusion at least, κ ≥ 1 and Y = |d ln H/d ln ω|; where it is not below 0 it rises from there on.
    /// ```text
    /// Y·sin(φ/2) − Y(1 − ½sin²φ)/(κ + Y),   Y = k·bω/(2√|jbω + c|),   φ = arg(jbω + c)
    /// ```
    fn fall_from(&self, omega: f64) -> f64 {
        let base = Complex::new(self.constant, self.slope * omega);
        let rate = -0.5 * self.order * base.im / libm::sqrt(base.norm());
        let (angle, across) = (base.arg(), base.im / base.norm());
        rate * (libm::sin(0.5 * angle) - (1.0 - 0.5 * across * across) / (1.0 + rate))
    }
}

/// Bounds of a polynomial at jω, ω from 0 to e^x, relative to e^scale.
struct Bounds {
    scale: f64,
    /// Σ |a|ω^α.
    size: f64,
    /// Σ α|a|ω^α.
    rate: f64,
    /// The size of the terms that lead, and the lowest order of them: those of the sign of the highest and at most one order below, so that
    /// their directions are within a right angle.
    lead: f64,
    lead_order: f64,
    /// The share of the size that |A| has at least, here and at any higher ω; below 0 where none is known.
    led: f64,
}

impl Bounds {
    fn new(polynomial: &FractionalPolynomial, x: f64) -> Self {
        let axis = OnAxis(polynomial);
        let scale = axis.scale(x);
        let sizes = axis.sizes(x, scale);
        let first = polynomial.terms().first().copied().unwrap_or_default();
        let leads = |term: &&Term| {
            term.coefficient * first.coefficient > 0.0 && term.order >= first.order - 1.0
        };
        let count = polynomial.terms().iter().take_while(leads).count();
        let lead: f64 = sizes.clone().take(count).map(|(_, size)| size).sum();
        let size: f64 = sizes.clone().map(|(_, size)| size).sum();
        Self {
            scale,
            size,
            rate: sizes.clone().map(|(order, size)| order * size).sum(),
            lead,
            lead_order: sizes.take(count).last().map_or(0.0, |(order, _)| order),
            // Half a right angle from the middle of the sector.
            led: (core::f64::consts::FRAC_1_SQRT_2 * lead - (size - lead)) / size,
        }
    }

    /// |dg/dx|·ω of g = NH/(jωA) from bounds of |N|, |A| and |H′/H|, over |H|; infinite where |A| is not above 0.
    fn over(&self, below: &Self, most: f64, least: f64, factors: f64) -> f64 {
        if self.size == 0.0 {
            return 0.0;
        }
        if least.is_nan() || least <= 0.0 {
            return f64::INFINITY;
        }
        let relative =
            (most * (1.0 + factors) + self.rate) / least + most * below.rate / (least * least);
        relative * libm::exp(self.scale - below.scale)
    }
}

impl FractionalTransferFunction {
    /// The numerator of G − D over its denominator: what G passes on at once, D, leaves no highest power. `None` with too many terms.
    #[must_use]
    pub fn numerator_without(&self, direct: f64) -> Option<FractionalPolynomial> {
        let below = self.denominator();
        let passed = below.terms().iter();
        let passed = passed.map(|term| Term::new(-direct * term.coefficient, term.order));
        let terms = self.numerator().terms().iter().copied().chain(passed);
        let mut left = FractionalPolynomial::ZERO;
        for term in terms.filter(|term| term.order < below.degree() && term.coefficient != 0.0) {
            left.add(term).ok()?;
        }
        Some(left)
    }
}

/// Places in a piece of the sum over the aliases, and times it is halved at most.
const PLACES: usize = 24;
const HALVINGS: u32 = 5;
/// Tolerance of a piece between its places, over its largest value.
const MISSES: f64 = 1e-11;

/// A smooth function from one angle to another as Chebyshev's polynomial through its values at the zeros of the next: the aliases of a plant are far
/// from 0, where its powers of s branch, so 24 places give eleven digits, unless it swings at one of them.
/// ```text
/// p(x) = c₀/2 + Σ c_j·T_j(x),   c_j = (2/n)·Σ f(x_k)·T_j(x_k),   x_k = cos((k + ½)π/n)     (C. W. Clenshaw's recurrence)
/// ```
#[derive(Clone, Debug)]
struct Piece {
    low: f64,
    high: f64,
    /// None where the function is not smooth enough.
    coefficients: Option<[Complex<f64>; PLACES]>,
}

/// Pieces of a function, halved where one is not enough.
fn pieces(f: &impl Fn(f64) -> Complex<f64>, [low, high]: [f64; 2], halvings: u32) -> Vec<Piece> {
    let piece = Piece::new(f, [low, high]);
    if halvings == 0 || piece.coefficients.is_some() {
        return std::vec![piece];
    }
    let middle = 0.5 * (low + high);
    let mut both = pieces(f, [low, middle], halvings - 1);
    both.extend(pieces(f, [middle, high], halvings - 1));
    both
}

impl Piece {
    fn new(f: &impl Fn(f64) -> Complex<f64>, [low, high]: [f64; 2]) -> Self {
        let angle = |k: usize| PI * (k as f64 + 0.5) / PLACES as f64;
        let place = |x: f64| 0.5 * (low + high + (high - low) * x);
        let values: [Complex<f64>; PLACES] =
            core::array::from_fn(|k| f(place(libm::cos(angle(k)))));
        let largest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let coefficients = core::array::from_fn(|j| {
            let terms = values.iter().enumerate();
            let sum: Complex<f64> = terms
                .map(|(k, value)| value * libm::cos(j as f64 * angle(k)))
                .sum();
            sum * (2.0 / PLACES as f64)
        });
        let piece = Self {
            low,
            high,
            coefficients: Some(coefficients),
        };
        // Between the places at both ends and in the middle.
        let neighbours = [1.0, 0.02, -1.0].map(place);
        let misses = |theta: &f64| piece.at(*theta).map(|value| (value - f(*theta)).norm());
        let is_near = |theta| misses(theta).is_some_and(|misses| misses <= MISSES * largest);
        if neighbours.iter().all(is_near) {
            piece
        } else {
            Self {
                coefficients: None,
                ..piece
            }
        }
    }

    fn at(&self, theta: f64) -> Option<Complex<f64>> {
        let [first, others @ ..] = self.coefficients.as_ref()?;
        let x = (2.0 * theta - self.low - self.high) / (self.high - self.low);
        let (mut last, mut before) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for c in others.iter().rev() {
            (last, before) = (last * (2.0 * x) - before + c, last);
        }
        Some(last * x - before + first * 0.5)
    }
}

/// Orders of the terms from which their sum is known.
const ORDER_LEAST: f64 = 1.02;
/// Parts of a sample up to which the terms turn slowly enough for an integral.
const SLOW: f64 = 0.1;
/// Parts of a sample that count as 0.
const NONE: f64 = 1e-9;
/// Octaves at most, and the angle by which f turns in one at most, rad.
const OCTAVES: i32 = 10;
const TURN: f64 = 4.0;
/// Half of the places and weights of C. F. Gauss for six points of (−1, 1).
const GAUSS: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];
/// Steps of ln u: an error of e^(−π²/step).
const STEP: f64 = 0.5;
/// Limits of the integral on either side, as ln u.
const NOTHING: f64 = 23.0;
const END: f64 = 3.75;

/// The far end of a sum over the aliases of a frequency, whose terms fall as a power and turn with a part of a sample of dead time.
/// ```text
/// Σ_{k≥0} f(k) = ∫₀^∞ f dk + f(0)/2 − f′(0)/12 + f‴(0)/720 − …,   f(k) = g(a + k)·e^(−jck)     (L. Euler, C. Maclaurin)
/// ∫₀^∞ (1 + k/A)^(−β)·e^(−jck) dk = −j·sgn(c)/|c|·∫₀^∞ e^(−u)·(1 − j·sgn(c)·u/(|c|A))^(−β) du
/// ```
/// The integral is taken octave by octave while f turns slowly, and from A on along the path on which e^(−jck) falls.
/// It is g(a)·1 + g(a + 1)·z + g(a + 2)·z² + …, z = e^(−2πj·part), −1/2 ≤ part ≤ 1/2; not finite where it does not end.
///
/// `g` is smooth, and from a on nearly a power of its place.
fn far_sum(g: impl Fn(f64) -> Complex<f64>, a: f64, part: f64) -> Complex<f64> {
    let begin = g(a);
    if begin.norm() == 0.0 {
        return begin;
    }
    let order = order(&g, a);
    if part.abs() > SLOW {
        return begin * by_parts(a, order, part);
    }
    let c = if part.abs() < NONE {
        0.0
    } else {
        2.0 * PI * part
    };
    let turn = Complex::new(0.0, c);
    let first = order / a;
    let second = first * (order + 1.0) / a;
    let third = second * (order + 2.0) / a;
    // f′ and f‴ over −f.
    let once = turn + first;
    let thrice = turn * turn * turn + turn * turn * first * 3.0 + turn * second * 3.0 + third;
    begin * (once / 12.0 - thrice / 720.0 + 0.5) + integral(&g, a, c)
}

/// β of g ~ place^(−β) at this place.
fn order(g: &impl Fn(f64) -> Complex<f64>, place: f64) -> f64 {
    -libm::log(g(1.1 * place).norm() / g(place).norm()) / libm::log(1.1)
}

/// ∫₀^∞ g(a + k)·e^(−jck) dk
fn integral(g: &impl Fn(f64) -> Complex<f64>, a: f64, c: f64) -> Complex<f64> {
    let late = |place: f64| Complex::from_polar(1.0, -c * (place - a));
    let (mut sum, mut low) = (Complex::new(0.0, 0.0), a);
    for _ in 0..OCTAVES {
        if c.abs() * low > TURN {
            break;
        }
        let half = 0.5 * low;
        for (place, weight) in GAUSS {
            for place in [low + half * (1.0 - place), low + half * (1.0 + place)] {
                sum += g(place) * late(place) * (weight * half);
            }
        }
        low *= 2.0;
    }
    let order = order(g, low);
    if order.is_nan() || order < ORDER_LEAST {
        return Complex::new(f64::NAN, f64::NAN);
    }
    sum + g(low) * late(low) * of_power(order, low, c)
}

/// ∫₀^∞ (1 + k/a)^(−β)·e^(−jck) dk, by equal steps of ln u.
fn of_power(order: f64, a: f64, c: f64) -> Complex<f64> {
    if c == 0.0 {
        return Complex::new(a / (order - 1.0), 0.0);
    }
    let wide = 1.0 / (c.abs() * a);
    let low = -NOTHING - libm::log(wide.max(1.0));
    let steps = libm::ceil((END - low) / STEP) as usize;
    let values = (0..=steps).map(|n| {
        let u = libm::exp(low + STEP * n as f64);
        let (across, angle) = (u * wide, libm::atan(u * wide));
        let size = u * libm::exp(-u) * libm::pow(across * across + 1.0, -0.5 * order);
        Complex::from_polar(size, c.signum() * order * angle)
    });
    values.sum::<Complex<f64>>() * Complex::new(0.0, -STEP / c)
}

/// Σ (1 + k/a)^(−β)·z^k by parts: z turns, the size hardly changes.
fn by_parts(a: f64, order: f64, part: f64) -> Complex<f64> {
    let size = |k: f64| libm::pow((a + k) / a, -order);
    let z = Complex::from_polar(1.0, -2.0 * PI * part);
    let (once, by) = (size(1.0) - 1.0, (-z + 1.0).inv());
    let twice = size(2.0) - 2.0 * size(1.0) + 1.0;
    by * (z * by * (z * by * twice + once) + 1.0)
}
