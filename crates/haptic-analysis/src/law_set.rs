//! A set of laws at once, with every mix of two: proved stable on one device.
//! ```text
//! F_p(θ) = A + S·H_p·T²/m        H_p of the law p, N/m;  A, S of the device, see `characteristic`
//! Re(n̄F_p) > 0 for one n(θ), every p and 0 < θ ≤ π, and one p stable  ⇒  every p, and Σ s_i·H_{p_i} with s_i ≥ 0, Σ s_i = 1, is stable
//! ```
//! One half plane for all holds their convex hull, in which every mix lies; none of them meets 0, so no pole leaves the circle. One p is
//! stable if its F does not turn: between two angles that share a half plane its turn is the angle between its values there.
//!
//! - *A law* runs by an operator, or is made of spring-pots side by side and in series, s = (1 − w)/T, whose sizes and orders lie in ranges.
//! - *Enclosed* in discs: V·s^α of an interval of angles and orders is a sector of a ring. A size is at one of its two ends where all above it
//!   is side by side, since the law is straight in it, and anywhere between in a series, whose disc is 1/(1/a + 1/b).
//! - *Halved* is what costs most, the angles, an order or a size, until the disc is on the side of n, or its middle is not: then n turns,
//!   until the directions of all that were met fill a half turn. A grid alone proves nothing; a halving that goes on too long neither.
//! - Below 1e-9 rad/sample F is taken to be as it is there. Rounding is taken off first.
//!
//! Sources: the project's `theory.md`, 42; E. D. Popova, circular arithmetic after I. Gargantini, P. Henrici, *Circular arithmetic and the
//! determination of polynomial zeros*, Numerische Mathematik 18, 1972.

use crate::curve::{NEAR_REST, angles_to_pi};
use crate::{AnalysisError, Dynamics, LoopOperator, SampledPlant, SampledWall};
use core::f64::consts::PI;
use fracdiff::FrequencyResponse as _;
use fracdiff::parameter::{not_negative, positive, range};
use num_complex::Complex;

/// A spring-pot V·s^α whose size and order lie in ranges: a spring at α = 0, a damper at 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PotRange {
    /// Least and largest V, N·s^α/m.
    pub size_n_s_alpha_per_m: [f64; 2],
    /// Least and largest α, each from 0 to 2.
    pub order: [f64; 2],
}

/// Spring-pots, side by side or in series.
#[derive(Clone, Debug, PartialEq)]
pub enum LawElements {
    /// A spring-pot, the end of every branch.
    Pot(PotRange),
    /// Two parts whose forces add.
    Parallel(Box<[Self; 2]>),
    /// Two parts whose motions add.
    Series(Box<[Self; 2]>),
}

/// Laws of a loop: one that runs, or all that elements may make.
#[derive(Clone, Debug)]
pub enum LawSet<'a> {
    /// All laws of these elements, as backward differences make them.
    Elements(LawElements),
    /// A wall with the operator that runs.
    Wall(SampledWall, &'a LoopOperator),
}

/// The proof of a set with its mixes, or where it ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetVerdict {
    /// Every member is stable, and so is every mix.
    Proved,
    /// No member is stable, nor any mix.
    Unstable,
    /// At this angle, rad/sample, no half plane was found.
    Unproved {
        /// The angle θ = ωT.
        theta: f64,
    },
}

/// Halvings of a way between two angles; discs looked at, at most.
const HALVINGS: u32 = 40;
const LOOKS: u64 = 4_000_000;
/// Cells of one set at one interval of angles before that is halved instead.
const CELLS: usize = 20_000;
/// Half planes tried at an angle.
const TURNS: usize = 24;
/// Rounding errors of a value, as a share of its terms.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// All points as near to a centre as this.
#[derive(Clone, Copy, Debug)]
struct Disc {
    centre: Complex<f64>,
    radius: f64,
}

impl Disc {
    const fn point(centre: Complex<f64>) -> Self {
        Self {
            centre,
            radius: 0.0,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            centre: self.centre + other.centre,
            radius: self.radius + other.radius,
        }
    }

    fn times(self, other: Self) -> Self {
        let (a, b) = (self.centre.norm(), other.centre.norm());
        Self {
            centre: self.centre * other.centre,
            radius: a * other.radius + self.radius * (b + other.radius),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            centre: self.centre * factor,
            radius: self.radius * factor,
        }
    }

    /// 1/z; without bound if 0 is in it. What rounding did before, and does here where two squares nearly cancel, widens it.
    fn inverse(self) -> Self {
        let size = self.centre.norm();
        let radius = self.radius + ROUNDING * size;
        let square = (size - radius) * (size + radius);
        if square <= 0.0 || !square.is_finite() {
            return Self {
                centre: Complex::new(0.0, 0.0),
                radius: f64::INFINITY,
            };
        }
        let blur = ROUNDING * size * size / square;
        Self {
            centre: self.centre.conj() / square,
            radius: (radius + blur * (radius + size)) / square,
        }
    }

    /// The least disc that holds two.
    fn around(self, other: Self) -> Self {
        let way = other.centre - self.centre;
        let apart = way.norm();
        if apart + other.radius <= self.radius {
            return self;
        }
        if apart + self.radius <= other.radius {
            return other;
        }
        let radius = 0.5 * (apart + self.radius + other.radius);
        Self {
            centre: self.centre + way * ((radius - self.radius) / apart),
            radius,
        }
    }

    /// The least of Re(n̄z) in it, for |n| = 1.
    fn along(self, n: Complex<f64>) -> f64 {
        let size = self.centre.norm() + self.radius;
        (n.conj() * self.centre).re - self.radius - ROUNDING * size
    }
}

type Range = [f64; 2];

fn middle([low, high]: Range) -> f64 {
    0.5 * (low + high)
}

/// Angles from one to another, and what they make of s = (1 − w)/T.
#[derive(Clone, Copy, Debug)]
struct Angles {
    theta: Range,
    /// ln|s|, s in 1/s.
    ln_size: Range,
    /// Argument of s, which falls from π/2 to 0 as θ rises.
    turn: Range,
}

impl Angles {
    fn new([low, high]: Range, t: f64) -> Self {
        let ln_size = |theta: f64| libm::log(2.0 * libm::sin(0.5 * theta) / t);
        let turn = |theta: f64| 0.5 * (PI - theta);
        Self {
            theta: [low, high],
            ln_size: [ln_size(low), ln_size(high)],
            turn: [turn(high), turn(low)],
        }
    }

    /// s^α for all orders of a range: a sector of a ring.
    fn power(&self, [low, high]: Range) -> Disc {
        let corners = [low, high].map(|order| self.ln_size.map(|ln_size| order * ln_size));
        let corners = corners.as_flattened();
        let least = libm::exp(corners.iter().copied().fold(f64::INFINITY, f64::min));
        let most = libm::exp(corners.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        let (first, last) = (low * self.turn[0], high * self.turn[1]);
        let (size, turn) = (0.5 * (least + most), 0.5 * (first + last));
        let cos = libm::cos(f64::min(0.5 * (last - first), PI));
        let from = |corner: f64| {
            let square = corner * corner + size * size - 2.0 * corner * size * cos;
            libm::sqrt(f64::max(square, 0.0))
        };
        Disc {
            centre: Complex::from_polar(size, turn),
            radius: f64::max(from(least), from(most)),
        }
    }
}

impl LawElements {
    /// Refuses a size or an order that no element has.
    fn check(&self) -> Result<(), AnalysisError> {
        match self {
            Self::Parallel(parts) | Self::Series(parts) => parts.iter().try_for_each(Self::check),
            Self::Pot(PotRange {
                size_n_s_alpha_per_m: [least, most],
                order: [low, high],
            }) => {
                not_negative("least size of an element", *least, "N·s^α/m")?;
                not_negative("largest size of an element", *most, "N·s^α/m")?;
                let rises = "not below the least";
                range(
                    "largest size of an element",
                    *most,
                    most >= least,
                    rises,
                    "N·s^α/m",
                )?;
                let fits = (0.0..=2.0).contains(low);
                range("least order of an element", *low, fits, "in [0, 2]", "")?;
                let fits = (*low..=2.0).contains(high);
                range(
                    "largest order of an element",
                    *high,
                    fits,
                    "from the least to 2",
                    "",
                )?;
                Ok(())
            }
        }
    }

    fn pots(&self, into: &mut Vec<PotRange>) {
        match self {
            Self::Pot(pot) => into.push(*pot),
            Self::Parallel(parts) | Self::Series(parts) => {
                parts.iter().for_each(|part| part.pots(into));
            }
        }
    }

    /// Discs whose convex hull holds H of all laws with pots of these ranges, which are taken in order.
    fn discs(&self, pots: &mut impl Iterator<Item = PotRange>, angles: &Angles) -> Vec<Disc> {
        match self {
            Self::Pot(_) => {
                let Some(pot) = pots.next() else {
                    return Vec::new();
                };
                let power = angles.power(pot.order);
                let [least, most] = pot.size_n_s_alpha_per_m;
                let mut ends = vec![power.scaled(least)];
                if most > least {
                    ends.push(power.scaled(most));
                }
                ends
            }
            Self::Parallel(parts) => {
                let [first, second] = parts.each_ref().map(|part| part.discs(pots, angles));
                let sums = first.iter().flat_map(|a| second.iter().map(|b| a.plus(*b)));
                sums.collect()
            }
            Self::Series(parts) => {
                let one = |part: &Self, pots: &mut _| {
                    let discs = part.discs(pots, angles).into_iter();
                    discs.reduce(Disc::around)
                };
                let (first, second) = (one(&parts[0], pots), one(&parts[1], pots));
                let inverse = first
                    .zip(second)
                    .map(|(a, b)| a.inverse().plus(b.inverse()));
                inverse.map(Disc::inverse).into_iter().collect()
            }
        }
    }
}

/// Ranges of the elements of a set that are halved.
type Cell = Vec<PotRange>;

impl LawSet<'_> {
    fn cell(&self) -> Cell {
        let mut cell = Vec::new();
        if let Self::Elements(elements) = self {
            elements.pots(&mut cell);
        }
        cell
    }

    fn discs(&self, cell: &[PotRange], angles: &Angles) -> Vec<Disc> {
        match self {
            Self::Elements(elements) => elements.discs(&mut cell.iter().copied(), angles),
            Self::Wall(wall, operator) => {
                let [low, high] = angles.theta;
                let response = operator.response(middle(angles.theta));
                let radius = if high > low {
                    operator.variation(low, high)
                } else {
                    0.0
                };
                let rate = libm::pow(wall.sample_time_s, -wall.order.get());
                let memory = Disc {
                    centre: response,
                    radius,
                };
                let memory = memory.scaled(wall.dissipation_n_s_mu_per_m * rate);
                let spring = Complex::new(wall.stiffness_n_per_m, 0.0);
                vec![Disc::point(spring).plus(memory)]
            }
        }
    }
}

/// The middle of a cell.
fn middle_of(cell: &[PotRange]) -> Cell {
    let point = |range: Range| [middle(range); 2];
    let pots = cell.iter().map(|pot| PotRange {
        size_n_s_alpha_per_m: point(pot.size_n_s_alpha_per_m),
        order: point(pot.order),
    });
    pots.collect()
}

/// Members of a cell: its corners, as long as they are few, and its middle.
fn members(cell: &[PotRange]) -> Vec<Cell> {
    const MOST: usize = 6;
    let mut members = vec![cell.to_vec()];
    for side in sides(cell).into_iter().take(MOST) {
        let halves = |member: &Cell| {
            let [low, high] = *side_of(&mut member.clone(), side);
            [low, high].map(|value| {
                let mut corner = member.clone();
                *side_of(&mut corner, side) = [value; 2];
                corner
            })
        };
        members = members.iter().flat_map(halves).collect();
    }
    members.push(middle_of(cell));
    members.iter().map(|member| middle_of(member)).collect()
}

/// The place at which a range is halved: sizes are alike by their ratio.
fn halfway([low, high]: Range) -> f64 {
    if low > 0.0 {
        libm::sqrt(low * high)
    } else {
        middle([low, high])
    }
}

/// The side of a cell that changes an element by the largest ratio; `None` of a point.
fn widest(cell: &[PotRange], angles: &Angles) -> Option<Side> {
    let slowest = angles.ln_size[0].abs().max(angles.ln_size[1].abs());
    let folds = |side: &Side| {
        let [low, high] = *side_of(&mut cell.to_vec(), *side);
        let folds = if side.1 {
            slowest * (high - low)
        } else {
            libm::log(high / low)
        };
        // More than there are numbers, for a size from 0 on.
        f64::min(folds, 1e3)
    };
    let sides = sides(cell).into_iter();
    sides.max_by(|a, b| folds(a).total_cmp(&folds(b)))
}

/// An element, and whether its order is meant or its size.
type Side = (usize, bool);

/// The sides of a cell that are not a point.
fn sides(cell: &[PotRange]) -> Vec<Side> {
    let both = |(index, pot): (usize, &PotRange)| {
        let wide = |[low, high]: Range| high > low;
        let order = wide(pot.order).then_some((index, true));
        let size = wide(pot.size_n_s_alpha_per_m).then_some((index, false));
        order.into_iter().chain(size)
    };
    cell.iter().enumerate().flat_map(both).collect()
}

fn side_of(cell: &mut [PotRange], (index, is_order): Side) -> &mut Range {
    let pot = &mut cell[index];
    if is_order {
        &mut pot.order
    } else {
        &mut pot.size_n_s_alpha_per_m
    }
}

/// The end of a look at one interval of angles.
enum Look {
    Clear,
    /// The angles are to be halved.
    Wide,
    /// No half plane holds what was met.
    Blocked,
}

/// Angles with what the device is over all of them.
struct Over {
    angles: Angles,
    /// A.
    plant: Disc,
    /// S·T²/m, m/N.
    gain: Disc,
}

struct Proof<'a> {
    plant: SampledPlant,
    /// The factor T²/m that makes a force per way a pure number, m/N.
    unit: f64,
    t: f64,
    sets: &'a [LawSet<'a>],
    /// Single members of each set.
    members: &'a [Vec<Cell>],
    looks: u64,
}

impl Proof<'_> {
    /// Angles between two, with A and S·T²/m there.
    fn over(&self, ends: Range) -> Over {
        let angles = Angles::new(ends, self.t);
        let (theta, half) = (middle(ends), 0.5 * (ends[1] - ends[0]));
        let sin = libm::sin(0.5 * theta);
        // |dv/dθ| = 1
        let v = Disc {
            centre: Complex::new(2.0 * sin * sin, libm::sin(theta)),
            radius: half,
        };
        let polynomial = |coefficients: &[f64]| {
            let zero = Disc::point(Complex::new(0.0, 0.0));
            coefficients.iter().rev().fold(zero, |sum, c| {
                sum.times(v).plus(Disc::point(Complex::new(*c, 0.0)))
            })
        };
        let first = (self.plant.path().whole_samples() + 1) as f64;
        let delays = Disc {
            centre: Complex::from_polar(1.0, -first * theta),
            radius: first * half,
        };
        let gain = polynomial(self.plant.numerator_in_v()).times(delays);
        Over {
            angles,
            plant: polynomial(self.plant.denominator_in_v()),
            gain: gain.scaled(self.unit),
        }
    }

    /// Discs whose hull holds F of a cell.
    fn values(&mut self, set: &LawSet<'_>, cell: &[PotRange], over: &Over) -> Vec<Disc> {
        let laws = set.discs(cell, &over.angles);
        self.looks += laws.len() as u64;
        let values = laws
            .iter()
            .map(|law| over.plant.plus(over.gain.times(*law)));
        values.collect()
    }

    /// The least of Re(n̄F) over a cell.
    fn least(&mut self, set: &LawSet<'_>, cell: &[PotRange], over: &Over, n: Complex<f64>) -> f64 {
        let values = self.values(set, cell, over).into_iter();
        // A disc without bound times a point is no number, and has no least either.
        let least = values.map(|disc| disc.along(n)).map(|least| {
            if least.is_nan() {
                f64::NEG_INFINITY
            } else {
                least
            }
        });
        least.fold(f64::INFINITY, f64::min)
    }

    /// F of a single member at one angle.
    fn member(&mut self, set: &LawSet<'_>, cell: &[PotRange], at: &Over) -> Complex<f64> {
        let values = self.values(set, &middle_of(cell), at);
        values
            .first()
            .map_or(Complex::new(0.0, 0.0), |disc| disc.centre)
    }

    /// F of the first set's middle at one angle.
    fn first(&mut self, theta: f64) -> Complex<f64> {
        let (set, at) = (&self.sets[0], self.over([theta; 2]));
        self.member(set, &set.cell(), &at)
    }

    fn look(&mut self, ends: Range) -> Look {
        let (over, at_middle) = (self.over(ends), self.over([middle(ends); 2]));
        let mut directions = Directions::default();
        for (set, members) in self.sets.iter().zip(self.members) {
            for member in members {
                directions.meet(self.member(set, member, &at_middle));
            }
        }
        for _ in 0..TURNS {
            let Some(n) = directions.between() else {
                return Look::Blocked;
            };
            match self.tried([&over, &at_middle], n) {
                Ok(look) => return look,
                Err(met) => directions.meet(met),
            }
        }
        Look::Wide
    }

    /// Looks whether all lies on the side of n; a member that does not is the error.
    fn tried(
        &mut self,
        [over, at_middle]: [&Over; 2],
        n: Complex<f64>,
    ) -> Result<Look, Complex<f64>> {
        for set in self.sets {
            let mut cells = vec![set.cell()];
            let mut seen = 0;
            while let Some(cell) = cells.pop() {
                if self.least(set, &cell, over, n) > 0.0 {
                    continue;
                }
                let met = self.member(set, &cell, at_middle);
                if (n.conj() * met).re <= 0.0 {
                    return Err(met);
                }
                seen += 1;
                if seen > CELLS || self.looks > LOOKS {
                    return Ok(Look::Wide);
                }
                // One of them as a point shows by how much it matters.
                let mut best = (self.least(set, &cell, at_middle, n), None);
                for side in sides(&cell) {
                    let mut narrow = cell.clone();
                    let range = side_of(&mut narrow, side);
                    *range = [middle(*range); 2];
                    let least = self.least(set, &narrow, over, n);
                    if least > best.0 {
                        best = (least, Some(side));
                    }
                }
                let side = match best {
                    (_, Some(side)) => side,
                    // A series with 0 in its disc has no bound: first its widest side in e-folds.
                    (f64::NEG_INFINITY, None) => match widest(&cell, &over.angles) {
                        Some(side) => side,
                        None => return Ok(Look::Wide),
                    },
                    (_, None) => return Ok(Look::Wide),
                };
                let (mut low, mut high) = (cell.clone(), cell);
                let halfway = halfway(*side_of(&mut low, side));
                side_of(&mut low, side)[1] = halfway;
                side_of(&mut high, side)[0] = halfway;
                cells.extend([low, high]);
            }
        }
        Ok(Look::Clear)
    }
}

/// Directions that were met, as turns from the first.
#[derive(Clone, Copy, Debug, Default)]
struct Directions(Option<(Complex<f64>, Range)>);

impl Directions {
    fn meet(&mut self, value: Complex<f64>) {
        let unit = value / value.norm();
        match &mut self.0 {
            None => self.0 = Some((unit, [0.0; 2])),
            Some((first, [low, high])) => {
                let turn = (first.conj() * unit).arg();
                // Not a number where F is 0: nothing then lies between.
                if turn.is_nan() {
                    *low = f64::NEG_INFINITY;
                }
                *low = low.min(turn);
                *high = high.max(turn);
            }
        }
    }

    /// The direction from which all are less than a quarter turn away.
    fn between(&self) -> Option<Complex<f64>> {
        let (first, [low, high]) = self.0?;
        let fits = high - low < PI * (1.0 - 1e-9) && first.norm() > 0.0;
        fits.then(|| first * Complex::from_polar(1.0, 0.5 * (low + high)))
    }
}

/// Proves sets of laws, and all their mixes, on a device with its hand.
///
/// ```
/// use haptic_analysis::{Dynamics, LawElements, LawSet, PotRange, SetVerdict, prove_laws};
///
/// // All walls from 100 to 400 N/m with 1 to 4 N·s^μ/m of every order from 0.2 to 0.9.
/// let spring = PotRange { size_n_s_alpha_per_m: [100.0, 400.0], order: [0.0, 0.0] };
/// let pot = PotRange { size_n_s_alpha_per_m: [1.0, 4.0], order: [0.2, 0.9] };
/// let walls = LawElements::Parallel(Box::new([LawElements::Pot(spring), LawElements::Pot(pot)]));
/// let device = Dynamics::ideal(0.065, 3.5);
/// let verdict = prove_laws(&device, 1e-3, &[LawSet::Elements(walls)])?;
/// assert_eq!(verdict, SetVerdict::Proved);
/// # Ok::<(), haptic_analysis::AnalysisError>(())
/// ```
/// - *At rest*: a loop without any spring is judged beside its pole there, as by [`SampledLoop::beside_rest`](crate::SampledLoop::beside_rest).
/// - *Cost*: some ten thousand discs for two or three ranges, up to 4 million near a border, then it ends as unproved.
///
/// # Errors
/// A number of device, wall or element outside its range; no law at all.
pub fn prove_laws(
    device: &Dynamics,
    sample_time_s: f64,
    sets: &[LawSet<'_>],
) -> Result<SetVerdict, AnalysisError> {
    let t = positive("sample time", sample_time_s, "s")?;
    positive("number of laws", sets.len() as f64, "")?;
    for set in sets {
        match set {
            LawSet::Elements(elements) => elements.check()?,
            LawSet::Wall(wall, _) => {
                wall.checked()?;
            }
        }
    }
    let members: Vec<Vec<Cell>> = sets.iter().map(|set| members(&set.cell())).collect();
    let mut proof = Proof {
        plant: device.plant(t)?,
        unit: t * t / device.mass_kg,
        t,
        sets,
        members: &members,
        looks: 0,
    };
    let nodes: Vec<f64> = angles_to_pi().collect();
    let mut todo: Vec<(Range, u32)> = nodes
        .windows(2)
        .map(|pair| ([pair[0], pair[1]], 0))
        .collect();
    let mut turned = proof.first(NEAR_REST).arg();
    while let Some((way, depth)) = todo.pop() {
        let theta = middle(way);
        match proof.look(way) {
            Look::Clear => turned += (proof.first(way[1]) / proof.first(way[0])).arg(),
            Look::Wide if depth < HALVINGS && proof.looks < LOOKS => {
                todo.push(([way[0], theta], depth + 1));
                todo.push(([theta, way[1]], depth + 1));
            }
            Look::Wide | Look::Blocked => return Ok(SetVerdict::Unproved { theta }),
        }
    }
    // F is real and above 0 at w = 0, and real at w = −1: whole half turns.
    Ok(if turned.abs() < 0.5 * PI {
        SetVerdict::Proved
    } else {
        SetVerdict::Unstable
    })
}
