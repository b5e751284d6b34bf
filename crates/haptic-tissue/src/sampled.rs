//! A model sampled: a spring, and one memory of increments of strain, whatever its elements.

use crate::model::{Form, MaxwellBranch, Model, ModelError, SpringPot};
use core::f64::consts::PI;
use fracdiff::full_memory::{DecayingMode, Design, DesignError, Kernel, Memory};
use fracdiff::{FrequencyResponse, Order, Seconds, grunwald_weights, product};
use num_complex::Complex64;

/// A model as backward differences see it: a spring beside one full memory of increments of strain.
/// ```text
/// s → (1 − w)/T:   σ[n] = E·ε[n] + B·T^(−μ)·Σ_j c_j·(ε[n−j] − ε[n−j−1])
/// E + B·s^μ = M(s) for slow motion,   Σ_j c_j w^j = (M((1−w)/T) − E)/(B·T^(−μ)·(1 − w))
/// ```
/// The relaxation modulus of springs, dashpots and spring-pots only fades, so that `c_j` = ∫ e^(−js) ρ(s) ds with
/// ```text
/// ρ(s) = Im M(−(e^s − 1)/T + i0)/(π·(e^s − 1)·B·T^(−μ)) ≥ 0
/// e^(−s) = 1/(1 + T/τ)      a mode that is exact, where spring and dashpot are in series
/// ```
/// and elements in series cost no more than one spring-pot: one operator for the whole model, which is a
/// [`Memory`] and gives its [`Design`]. Its [`FrequencyResponse`] is P(w) = (M((1−w)/T) − E)/(B·T^(−μ)).
///
/// - *Units*: E Pa, B Pa·s^μ, T s, `c_j` dimensionless. `B·P` in Pa, times T^(−μ).
/// - A *spring alone* has B = 0, μ = 1 and no memory.
/// ```
/// use fracdiff::{Differintegrator, FullMemory, Seconds};
/// use haptic_tissue::{Model, ModelKind, SampledModel};
///
/// // Fish muscle.
/// let muscle = Model::from_parameters(ModelKind::FractionalMaxwell, &[876e3, 0.675, 22.1e3, 0.110])?;
/// let sampled = SampledModel::new(&muscle, Seconds(1e-3))?;
/// assert_eq!((sampled.elastic_modulus_pa(), sampled.viscosity_pa_s_mu()), (0.0, 876e3));
/// // 200 s at 1 kHz, within 1e-6.
/// let design = sampled.design::<16, 48>(1e-6, 2.1e5)?;
/// let memory = FullMemory::<f32, 16, 48>::new(&design, Seconds(1e-3))?;
/// // A step of 1 % strain, and the stress 10 ms later.
/// let mut history = memory.at_rest();
/// let stress = (0..=10).map(|_| 876e3 * memory.step(&mut history, 0.01)).last();
/// assert!((stress.unwrap_or_default() - 339.6).abs() < 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SampledModel {
    sample_time_s: f64,
    viscosity_pa_s_mu: f64,
    order: Order,
    pub(crate) whole: Part,
    /// B·T^(−μ); 1 where B is 0.
    scale_pa: f64,
}

impl SampledModel {
    /// The model at sample time T.
    ///
    /// # Errors
    /// Unless 1e-9 s ≤ T ≤ 1e6 s, or if the smallest order above 0 is below [`ORDER_MIN`](Self::ORDER_MIN).
    pub fn new(model: &Model, sample_time: Seconds) -> Result<Self, ModelError> {
        let whole = Part::of(model.form());
        let slowest = whole.branches.iter().map(Branch::slow);
        let order = slowest.clone().fold(1.0, |least, pot| pot.order.min(least));
        if order < Self::ORDER_MIN {
            return Err(ModelError::Range {
                name: "order",
                value: order,
                allowed: "0, a spring, or at least 1e-6",
                unit: "",
            });
        }
        let viscosity_pa_s_mu = slowest
            .filter(|pot| pot.order <= order)
            .map(|pot| pot.size)
            .sum();
        let outside = |_| ModelError::Range {
            name: "sample_time_s",
            value: sample_time.0,
            allowed: "in [1e-9, 1e6]",
            unit: "s",
        };
        let order = memory_order(order)?;
        let rate = sample_time.rate_to_the(order).map_err(outside)?;
        let mut model = Self {
            sample_time_s: sample_time.0,
            viscosity_pa_s_mu,
            order,
            whole,
            scale_pa: 1.0,
        };
        if !model.whole.branches.is_empty() {
            model.scale_pa = viscosity_pa_s_mu * rate;
            // Elements made from others may leave the range of numbers.
            if !(model.first() > 0.0 && model.first().is_finite()) {
                return Err(ModelError::Range {
                    name: "viscosity_pa_s_alpha",
                    value: viscosity_pa_s_mu,
                    allowed: "above 0 and finite",
                    unit: "Pa·s^α",
                });
            }
        }
        Ok(model)
    }

    /// Smallest order, above that of a spring, of an element that carries the slow motion.
    pub const ORDER_MIN: f64 = 1e-6;

    /// E, Pa: the equilibrium modulus.
    #[must_use]
    pub const fn elastic_modulus_pa(&self) -> f64 {
        self.whole.spring_pa
    }

    /// B, Pa·s^μ; 0 for a spring alone.
    #[must_use]
    pub const fn viscosity_pa_s_mu(&self) -> f64 {
        self.viscosity_pa_s_mu
    }

    /// μ, above 0 and at most 1: the order of the memory.
    #[must_use]
    pub const fn order(&self) -> Order {
        self.order
    }

    /// The sample time T that the weights belong to.
    #[must_use]
    pub const fn sample_time(&self) -> Seconds {
        Seconds(self.sample_time_s)
    }

    /// The modes that approximate the memory, for a tolerance and a horizon in samples as
    /// [`Design::of_memory`] takes them. For one spring-pot beside a spring they equal those of
    /// [`Design::pruned`] to the bit.
    ///
    /// # Errors
    /// As there.
    pub fn design<const TAPS: usize, const MODES: usize>(
        &self,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Design<TAPS, MODES>, DesignError> {
        match self.whole.branches.as_slice() {
            [Branch::Pot(_)] => Design::pruned(Kernel::Grunwald, self.order, tolerance, horizon),
            _ => Design::of_memory(self.order, self, tolerance, horizon),
        }
    }

    /// Numerator and denominator of P(w) with a short memory of each element, in powers of w.
    /// ```text
    /// V·s^α → V·T^(−α)·Σ_j c_j w^j, 0 ≤ j < N, (1 − w)^α = Σ_j c_j w^j
    /// ```
    /// Elements in series make it a recursion: the stress depends on the last N − 1 stresses too. With orders of at most 1
    /// the newest coefficient of the denominator exceeds the sum of the others, so that the recursion is stable.
    /// - *Cost*: N² of two spring-pots in series, N of others.
    ///
    /// # Errors
    /// Unless 2 ≤ N ≤ [`SHORT_MOST`](Self::SHORT_MOST).
    pub fn short_memory(&self, length: usize) -> Result<[Vec<f64>; 2], ModelError> {
        if !(2..=Self::SHORT_MOST).contains(&length) {
            return Err(ModelError::Range {
                name: "memory_length",
                value: length as f64,
                allowed: "from 2 to 10000",
                unit: "samples",
            });
        }
        let [mut numerator, denominator] = self.whole.quotient(0.0, self.sample_time_s, length)?;
        numerator.iter_mut().for_each(|b| *b /= self.scale_pa);
        Ok([numerator, denominator])
    }

    /// Longest short memory of a model, samples.
    pub const SHORT_MOST: usize = 10_000;

    /// M(s) − E, Pa.
    fn dissipative(&self, s: Complex64) -> Complex64 {
        self.whole.sum(0.0, |branch| branch.modulus(s))
    }
}

impl Memory for SampledModel {
    fn first(&self) -> f64 {
        let s = Complex64::new(1.0 / self.sample_time_s, 0.0);
        self.dissipative(s).re / self.scale_pa
    }

    fn density(&self, rate: f64) -> f64 {
        let growth = libm::expm1(rate);
        let r = growth / self.sample_time_s;
        let loss: f64 = (self.whole.branches.iter())
            .map(|branch| branch.on_cut(r).im)
            .sum();
        // s·Im M(−r + i0)/(π(e^s − 1))
        rate / growth * loss / (PI * self.scale_pa)
    }

    fn slower(&self, rate: f64) -> Option<f64> {
        // Cauchy's theorem around the cut: ∫₀^r Im M(−r')/(πr') dr' is the mean of M on the circle |s| = r, without poles inside.
        let r = rate / self.sample_time_s;
        let real = |angle: f64| self.dissipative(Complex64::from_polar(r, angle)).re;
        let mean = |from: f64| {
            let quarter = 0.25 * PI;
            let pair = |&(node, share): &(f64, f64)| {
                let aside = quarter * node;
                0.25 * share * (real(from + quarter - aside) + real(from + quarter + aside))
            };
            LEGENDRE_8.iter().map(pair).sum::<f64>()
        };
        let sum = mean(0.0) + mean(0.5 * PI);
        // Springs and dashpots alone have no cut: what rounding leaves of nothing may be below 0.
        let rounding = 16.0 * f64::EPSILON * real(0.0).abs();
        Some(if sum.abs() > rounding { sum } else { 0.0 } / self.scale_pa)
    }

    fn mode(&self, index: usize) -> Option<DecayingMode> {
        let mut poles = self.whole.branches.iter().filter_map(Branch::maxwell);
        let (modulus_pa, viscosity_pa_s) = poles.nth(index)?;
        // E·λ^(j+1), λ = 1/(1 + rT)
        let growth = modulus_pa / viscosity_pa_s * self.sample_time_s;
        Some(DecayingMode {
            rate: libm::log1p(growth),
            weight: modulus_pa / (1.0 + growth) / self.scale_pa,
        })
    }
}

impl FrequencyResponse for SampledModel {
    fn response(&self, theta: f64) -> Complex64 {
        // 1 − w = 2 sin²(θ/2) + j sin θ
        let half = libm::sin(0.5 * theta);
        let difference = Complex64::new(2.0 * half * half, libm::sin(theta));
        self.dissipative(difference / self.sample_time_s) / self.scale_pa
    }
}

/// Places and weights of the Gauss–Legendre rule of 8 nodes, the upper half.
const LEGENDRE_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Elements side by side: a spring, Pa, 0 for none, and what gives way to a slow motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Part {
    pub(crate) spring_pa: f64,
    pub(crate) branches: Vec<Branch>,
}

/// Elements that give way to a slow motion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Branch {
    /// A spring-pot or dashpot, α > 0.
    Pot(SpringPot),
    /// Two parts in series, of which one has no spring beside its branches.
    Series([Part; 2]),
}

impl Part {
    pub(crate) fn of(form: &Form) -> Self {
        let maxwell = |branch: &MaxwellBranch| {
            let e = branch.elastic_modulus_pa;
            let dashpot = SpringPot::new(e * branch.relaxation_time_s, 1.0);
            Self::element(&dashpot).series(Self::new(e, Vec::new()))
        };
        form.of(Self::element, maxwell, Self::parallel, Self::series)
    }

    const fn new(spring_pa: f64, branches: Vec<Branch>) -> Self {
        Self {
            spring_pa,
            branches,
        }
    }

    fn element(pot: &SpringPot) -> Self {
        if pot.is_spring() {
            Self::new(pot.size, Vec::new())
        } else {
            Self::new(0.0, vec![Branch::Pot(*pot)])
        }
    }

    fn parallel(mut self, other: Self) -> Self {
        self.spring_pa += other.spring_pa;
        self.branches.extend(other.branches);
        self
    }

    fn series(self, other: Self) -> Self {
        let swapped = self.branches.is_empty();
        let (part, spring) = if swapped {
            (other, self)
        } else {
            (self, other)
        };
        if part.spring_pa == 0.0 || !spring.branches.is_empty() {
            return Self::new(0.0, vec![Branch::Series([part, spring])]);
        }
        // A spring E in series with a spring G beside the rest is E·G/(E + G) beside k² times the rest in series with
        // E²/(E + G), k = E/(E + G).
        let k = spring.spring_pa / (spring.spring_pa + part.spring_pa);
        let rest = Self::new(0.0, part.branches).times(k).times(k);
        let rest = rest.series(Self::new(spring.spring_pa * k, Vec::new()));
        Self::new(part.spring_pa * k, Vec::new()).parallel(rest)
    }

    fn times(&self, factor: f64) -> Self {
        let times = |branch: &Branch| match branch {
            Branch::Pot(one) => Branch::Pot(SpringPot::new(one.size * factor, one.order)),
            Branch::Series(parts) => {
                Branch::Series(parts.each_ref().map(|part| part.times(factor)))
            }
        };
        let branches = self.branches.iter().map(times);
        Self::new(self.spring_pa * factor, branches.collect())
    }

    /// The one element that this is, if it is one.
    fn single(&self) -> Option<SpringPot> {
        match self.branches.as_slice() {
            [] => Some(SpringPot::new(self.spring_pa, 0.0)),
            [Branch::Pot(one)] if self.spring_pa == 0.0 => Some(*one),
            _ => None,
        }
    }

    /// Sum of `beside_pa` and a modulus of each branch, Pa.
    fn sum(&self, beside_pa: f64, modulus: impl Fn(&Branch) -> Complex64) -> Complex64 {
        let branches = self.branches.iter().map(modulus);
        branches.fold(Complex64::new(beside_pa, 0.0), |sum, one| sum + one)
    }

    /// Numerator, Pa, and denominator of `beside_pa` and a short memory of each branch.
    fn quotient(&self, beside_pa: f64, t: f64, length: usize) -> Result<[Vec<f64>; 2], ModelError> {
        let mut all = [vec![beside_pa], vec![1.0]];
        for branch in &self.branches {
            let ([n, d], [above, below]) = (&all, branch.quotient(t, length)?);
            let numerator = sum(product(n, &below), &product(&above, d));
            all = [numerator, product(d, &below)];
        }
        Ok(all)
    }

    fn slow(&self) -> SpringPot {
        if self.spring_pa > 0.0 {
            return SpringPot::new(self.spring_pa, 0.0);
        }
        let slowest = self.branches.iter().map(Branch::slow);
        let slowest = slowest.min_by(|a, b| a.order.total_cmp(&b.order));
        slowest.unwrap_or(SpringPot::new(0.0, 0.0))
    }

    /// M(−r + i0), Pa.
    fn on_cut(&self, r: f64) -> Cut {
        match self.single() {
            Some(one) => Cut::of(&one, r),
            None => Cut::from(self.sum(self.spring_pa, |branch| branch.on_cut(r))),
        }
    }
}

impl Branch {
    /// M(s), Pa, on the principal branch; 0 at s = 0.
    fn modulus(&self, s: Complex64) -> Complex64 {
        let parts = match self {
            Self::Pot(one) => return one.modulus(s),
            Self::Series(parts) => parts,
        };
        // a·b/(a + b) = a/(1 + a/b), with a and b 0 at rest
        if let [Some(first), Some(second)] = parts.each_ref().map(Part::single) {
            let ratio = power(s, first.order - second.order) * (first.size / second.size);
            return first.modulus(s) / (ratio + 1.0);
        }
        let modulus = |part: &Part| part.sum(part.spring_pa, |branch| branch.modulus(s));
        let [a, b] = parts.each_ref().map(modulus);
        let (soft, stiff) = if a.norm_sqr() < b.norm_sqr() {
            (a, b)
        } else {
            (b, a)
        };
        if soft.norm_sqr() == 0.0 {
            Complex64::ZERO
        } else {
            soft / (soft / stiff + 1.0)
        }
    }

    fn quotient(&self, t: f64, length: usize) -> Result<[Vec<f64>; 2], ModelError> {
        let [first, second] = match self {
            Self::Pot(one) => {
                let newest = one.size * libm::pow(t, -one.order);
                let weights = grunwald_weights(memory_order(one.order)?).take(length);
                // A dashpot has two.
                let weights = weights.take_while(|c| *c != 0.0);
                return Ok([weights.map(|c| newest * c).collect(), vec![1.0]]);
            }
            Self::Series(parts) => parts,
        };
        let quotient = |part: &Part| part.quotient(part.spring_pa, t, length);
        let ([a, c], [b, d]) = (quotient(first)?, quotient(second)?);
        // (a/c)(b/d)/(a/c + b/d)
        Ok([product(&a, &b), sum(product(&a, &d), &product(&b, &c))])
    }

    /// M(−r + i0), Pa, without the pole. All that is added up in its imaginary part is positive, but the sum of two elements
    /// itself.
    fn on_cut(&self, r: f64) -> Complex64 {
        let [a, b] = match self {
            Self::Pot(one) => return Cut::of(one, r).value(),
            Self::Series(parts) => parts.each_ref().map(|part| part.on_cut(r)),
        };
        // ab/(a + b) = |a||b|·(|a|·e^(iφ_b) + |b|·e^(iφ_a))/|a + b|²
        let unit = a.size.max(b.size);
        let (a, b) = (a.over(unit), b.over(unit));
        let above = a.size * b.size * (a.size * b.sin + b.size * a.sin);
        if above == 0.0 {
            // A spring and a dashpot: a pole, no cut.
            return Complex64::ZERO;
        }
        let real = a.size * b.size * (a.size * b.cos + b.size * a.cos);
        let square = (a.value() + b.value()).norm_sqr();
        Complex64::new(unit * real / square, unit * above / square)
    }

    /// E in Pa and η in Pa·s of a spring and a dashpot in series: E·s/(s + E/η) is a pole.
    pub(crate) fn maxwell(&self) -> Option<(f64, f64)> {
        let Self::Series(parts) = self else {
            return None;
        };
        let [dashpot, spring] = parts.each_ref().map(Part::single);
        let dashpot = dashpot.filter(SpringPot::is_dashpot)?;
        let spring = spring.filter(SpringPot::is_spring)?;
        Some((spring.size, dashpot.size))
    }

    /// The element that carries a slow motion: M(s) → V·s^α for s → 0.
    fn slow(&self) -> SpringPot {
        match self {
            Self::Pot(one) => *one,
            Self::Series(parts) => {
                let [a, b] = parts.each_ref().map(Part::slow);
                if a.order > b.order { a } else { b }
            }
        }
    }
}

fn memory_order(order: f64) -> Result<Order, ModelError> {
    Order::new(order).map_err(|_| ModelError::Range {
        name: "order",
        value: order,
        allowed: "in [0, 1]",
        unit: "",
    })
}

/// The sum of two polynomials.
fn sum(mut a: Vec<f64>, b: &[f64]) -> Vec<f64> {
    a.resize(a.len().max(b.len()), 0.0);
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

/// s^p.
fn power(s: Complex64, p: f64) -> Complex64 {
    let (size, angle) = (libm::hypot(s.re, s.im), libm::atan2(s.im, s.re));
    Complex64::from_polar(libm::pow(size, p), p * angle)
}

/// V·(−r + i0)^α = V·r^α·e^(iπα).
#[derive(Clone, Copy, Debug)]
struct Cut {
    size: f64,
    sin: f64,
    cos: f64,
}

impl Cut {
    fn of(pot: &SpringPot, r: f64) -> Self {
        let order = pot.order;
        // sin πα = sin π(1 − α), and 1 − α is exact where α is near 1; exactly 0 at both ends.
        let near = order.min(1.0 - order);
        let (sin, cos) = (libm::sin(PI * near), libm::cos(PI * near));
        Self {
            size: pot.size * libm::pow(r, order),
            sin,
            cos: if order > 0.5 { -cos } else { cos },
        }
    }

    fn from(z: Complex64) -> Self {
        let size = z.norm();
        Self {
            size,
            sin: z.im / size,
            cos: z.re / size,
        }
    }

    fn over(self, unit: f64) -> Self {
        Self {
            size: self.size / unit,
            ..self
        }
    }

    fn value(self) -> Complex64 {
        Complex64::new(self.size * self.cos, self.size * self.sin)
    }
}
