//! Tuning of PI^λD^μ, with the best PID of order 1 beside it: orders and slope by search, gains by three linear equations.
//! ```text
//! C(s_c)·G(jω_c) = e^(j(φ_m − π))                             crossover and phase margin: two real equations
//! Im(C′/C + G′/G) = ψ at ω_c, over ln ω                       slope of the phase: ψ = 0 is iso-damping
//! ```
//! For given orders λ and μ all three are linear in `K_p`, `K_i` and `K_d`: they are met exactly, by a 3 × 3 system. The rest is a search over λ
//! and μ (and ψ, if the phase need not be flat) for the inequalities, and among what meets them for the overshoot that changes least
//! while the gain goes from half to double. The PID of order 1 is the same search with λ = μ = 1 over ψ.
//!
//! Source: C. A. Monje, B. M. Vinagre, V. Feliu, Y. Chen, *Tuning and auto-tuning of fractional order controllers for
//! industry applications*, Control Engineering Practice 16, 2008, whose five equations these are.

use super::{
    open_loop::{Measures, OpenLoop, at},
    specification::{Sampling, Specification, Wish, WishName},
};
use core::f64::consts::PI;
use fractional_control::{ControlError, PidParameters, Plant};
use nalgebra::{Matrix3, Vector3};
use num_complex::Complex;
use std::collections::{BTreeMap, BTreeSet};

/// A tuned controller, and what it achieves.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tuned {
    /// Gains and orders of the controller, for a plant of nominal gain.
    pub parameters: PidParameters,
    /// `|L(jω_c)|`, 1 by construction.
    pub gain_at_crossover: f64,
    /// Phase margin at `ω_c`, rad.
    pub phase_margin_rad: f64,
    /// dφ/d ln ω at `ω_c`, rad.
    pub phase_slope_rad: f64,
    /// Peaks, spreads and stability, as accurately as the search's grid shows them.
    pub measures: Measures,
    /// Wishes that are missed by more than 1 %; empty if all are met.
    pub unmet: Vec<Wish>,
}

/// Tunes a PI^λD^μ: crossover, margin and flat phase exactly, the rest as well as can be.
///
/// - *Gains*: `K_p` and `K_i` have the sign of the plant, `K_d` any; so has `K_p` of an unstable plant that needs it.
/// - *Cost*: some thousand trials, a few milliseconds to a tenth of a second.
/// ```
/// use fractional_control::Plant;
/// use control_tuning::{Specification, tune};
///
/// // Monje's tank: 0.55·e^(−s)/(62 s + 1)… and a margin of 70° at 0.05 rad/s, flat.
/// let plant: Plant = "0.55exp(-s)/(62s+1)".parse()?;
/// let tuned = tune(&plant, None, &Specification::new(0.05, 70_f64.to_radians()))?;
/// assert!(tuned.unmet.is_empty() && tuned.measures.stable);
/// let open = tuned.parameters.response(0.05) * plant.response(0.05).unwrap();
/// assert!((open.norm() - 1.0).abs() < 1e-9);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
///
/// # Errors
/// Wishes that contradict each other, named; no controller of this kind with this crossover and margin.
pub fn tune(
    plant: &Plant,
    sampling: Option<Sampling>,
    wishes: &Specification,
) -> Result<Tuned, ControlError> {
    let found = search(plant, sampling, wishes);
    let Err(ControlError::NotFound { what, .. }) = found else {
        return found;
    };
    let is_there = |wishes| search(plant, sampling, &wishes).is_ok();
    let at = |crossover_rad_s| Specification {
        crossover_rad_s,
        ..*wishes
    };
    let (omega, margin) = (wishes.crossover_rad_s, wishes.phase_margin_rad);
    let free = Specification {
        iso_damping: false,
        ..*wishes
    };
    let less = Specification {
        phase_margin_rad: 0.5 * margin,
        ..*wishes
    };
    let why = if wishes.iso_damping && is_there(free) {
        "a controller exists whose phase is not flat there: give up the flat phase, or change the crossover"
    } else if is_there(at(0.5 * omega)) {
        "a controller exists at half the crossover: lower the crossover"
    } else if is_there(at(2.0 * omega)) {
        "a controller exists at twice the crossover: raise the crossover"
    } else if is_there(less) {
        "a controller exists at half that margin: ask for less"
    } else {
        return found;
    };
    Err(ControlError::NotFound { what, why })
}

fn search(
    plant: &Plant,
    sampling: Option<Sampling>,
    wishes: &Specification,
) -> Result<Tuned, ControlError> {
    let mut search = Search::new(plant, sampling, wishes)?;
    let found = search.over_orders();
    let nothing = matches!(found, Err(ControlError::NotFound { .. }));
    if nothing && plant.unstable_poles() > 0 {
        // Against a pole that grows a proportional part of the other sign can flatten a phase that no other can.
        search.equations.any_sign = true;
        return search.over_orders();
    }
    found
}

/// The PID of order 1 with this crossover and margin that comes closest to the rest.
///
/// # Errors
/// As [`tune`].
pub fn tune_integer(
    plant: &Plant,
    sampling: Option<Sampling>,
    wishes: &Specification,
) -> Result<Tuned, ControlError> {
    let search = Search::new(plant, sampling, wishes)?;
    let slopes = (-150..=50).map(|k| 0.02 * f64::from(k));
    let sketches = slopes.filter_map(|slope| search.sketch([1.0, 1.0, slope]));
    search.finish(sketches.map(|(sketch, _)| sketch), [false, false, true])
}

/// Slopes of the phase, rad per unit of ln ω, where it need not be flat.
const SLOPES: [f64; 11] = [
    -2.0, -1.4, -1.0, -0.7, -0.5, -0.3, -0.15, 0.0, 0.2, 0.45, 0.9,
];
const ORDERS: [f64; 2] = [0.02, 1.98];
const STARTS: usize = 4;

#[derive(Clone, Debug)]
struct Search<'a> {
    open: OpenLoop,
    wishes: &'a Specification,
    equations: Equations,
}

/// λ, μ, ψ; the controller; how bad it is.
#[derive(Clone, Copy, Debug)]
struct Trial {
    place: [f64; 3],
    gains: PidParameters,
    measures: Measures,
    cost: f64,
}

/// A trial whose step is not evaluated yet.
#[derive(Clone, Copy, Debug)]
struct Sketch {
    /// Its cost is without the step and `lost`.
    trial: Trial,
    /// Cost of a loop that is lost at some gain, or where a lag is a dead time: its overshoot has no end.
    lost: f64,
}

impl Sketch {
    /// The cost, if the overshoot does not change; of a loop that is not stable, its cost.
    fn least(&self) -> f64 {
        self.trial.cost + self.lost
    }
}

/// A place as it is tried: orders to 1e-4, finer than a loop can resolve.
fn rounded([lambda, mu, slope]: [f64; 3]) -> [f64; 3] {
    let order = |order: f64| libm::round(1e4 * order) / 1e4;
    [order(lambda), order(mu), slope]
}

/// −1, 0 or 1 along each axis that is free: sides and corners.
fn directions(free: [bool; 3]) -> impl Iterator<Item = [f64; 3]> {
    let signs = |free: bool| {
        if free {
            [0.0, -1.0, 1.0].as_slice()
        } else {
            &[0.0]
        }
    };
    let [x, y, z] = free.map(signs);
    let all = x.iter().flat_map(move |x| {
        y.iter()
            .flat_map(move |y| z.iter().map(move |z| [*x, *y, *z]))
    });
    all.filter(|direction| direction.iter().any(|sign| *sign != 0.0))
}

impl<'a> Search<'a> {
    /// Search for wishes that can be had together.
    fn new(
        plant: &Plant,
        sampling: Option<Sampling>,
        wishes: &'a Specification,
    ) -> Result<Self, ControlError> {
        wishes.check(plant, sampling)?;
        let open = OpenLoop::new(plant, wishes, sampling)?;
        Ok(Self {
            equations: Equations::new(&open, wishes.phase_margin_rad, plant.sign()),
            open,
            wishes,
        })
    }

    /// The best over all orders.
    fn over_orders(&self) -> Result<Tuned, ControlError> {
        let orders = || (1..=19).map(|k| 0.1 * f64::from(k));
        let flat = self.wishes.iso_damping;
        let slopes: &[f64] = if flat { &[0.0] } else { &SLOPES };
        let mut sketches = Vec::new();
        for lambda in orders() {
            for mu in orders() {
                for slope in slopes {
                    let ends = [mu, (mu + 0.1).min(ORDERS[1])];
                    let between = self.equations.between(lambda, ends, *slope);
                    let places = [Some([lambda, mu, *slope]), between];
                    let places = places.into_iter().flatten();
                    let places = places.filter_map(|place| self.sketch(place));
                    sketches.extend(places.map(|(sketch, _)| sketch));
                }
            }
        }
        self.finish(sketches, [true, true, !flat])
    }

    /// A sketch, with L on the grid; `None` if the place has no gains.
    fn sketch(&self, place: [f64; 3]) -> Option<(Sketch, Vec<Complex<f64>>)> {
        let place = rounded(place);
        let within = |order: &f64| (ORDERS[0]..=ORDERS[1]).contains(order);
        if !place[..2].iter().all(within) {
            return None;
        }
        let gains = self.equations.gains(place)?;
        let open = self.open.open(&gains);
        let measures = self.open.measure(&open, self.wishes);
        let missed: f64 = self
            .bounds(&measures)
            .map(|bound| (bound.reached / bound.wanted - 1.0).max(0.0))
            .sum();
        let margin = (1.0 - measures.other_margin_rad / self.wishes.phase_margin_rad).max(0.0);
        let mut cost = 100.0 * (missed + margin) + 0.01 * measures.margin_spread_rad;
        if !measures.stable {
            // Any stable one is better; the way there is that of less gain at the end.
            cost += 1e6 * (1.0 + measures.end);
        }
        let holds = measures.stable_over_gains && measures.stable_with_dead_time;
        let lost = if holds { 0.0 } else { 10.0 };
        let trial = Trial {
            place,
            gains,
            measures,
            cost,
        };
        Some((Sketch { trial, lost }, open))
    }

    /// Looks at the step of a stable loop too, which takes the longest.
    fn whole(&self, sketch: Sketch, open: &[Complex<f64>], most: f64) -> Trial {
        let Sketch { mut trial, lost } = sketch;
        if trial.measures.stable {
            let spread = self.open.overshoot_spread(open, most - trial.cost - lost);
            trial.measures.overshoot_spread = spread;
            trial.cost += spread;
        }
        trial.cost += lost;
        trial
    }

    /// `None` if no candidate has a cost below `most`.
    fn trial(&self, place: [f64; 3], most: f64) -> Option<Trial> {
        let (sketch, open) = self.sketch(place)?;
        if sketch.least() >= most {
            return None;
        }
        let trial = self.whole(sketch, &open, most);
        (trial.cost < most).then_some(trial)
    }

    fn bounds(&self, measures: &Measures) -> impl Iterator<Item = Wish> {
        let peaks = [measures.sensitivity_peak, measures.complementary_peak];
        self.wishes
            .bounds(peaks, [measures.noise, measures.disturbance])
    }

    /// The best that are not neighbours, each the best of the rest; of equal ones the first. Only steps that can decide are evaluated.
    fn starts(&self, sketches: impl IntoIterator<Item = Sketch>) -> Vec<Trial> {
        // No cost is negative: their bits stand in order. A lower bound comes before the final cost.
        let key = |cost: f64, whole: bool, index: usize| (cost.to_bits(), whole, index);
        let sketches = sketches.into_iter().enumerate();
        let mut queue: BTreeMap<_, Sketch> = sketches
            .map(|(index, sketch)| (key(sketch.least(), false, index), sketch))
            .collect();
        let mut starts: Vec<Trial> = Vec::new();
        while starts.len() < STARTS
            && let Some(((_, whole, index), sketch)) = queue.pop_first()
        {
            let near = |start: &Trial| {
                let pairs = start.place.iter().zip(&sketch.trial.place);
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 0.25
            };
            if starts.iter().any(near) {
                continue;
            }
            if whole {
                starts.push(sketch.trial);
                continue;
            }
            let open = self.open.open(&sketch.trial.gains);
            let trial = self.whole(sketch, &open, f64::INFINITY);
            queue.insert(key(trial.cost, true, index), Sketch { trial, lost: 0.0 });
        }
        starts
    }

    /// Refines the best starts, then the report.
    fn finish(
        &self,
        sketches: impl IntoIterator<Item = Sketch>,
        free: [bool; 3],
    ) -> Result<Tuned, ControlError> {
        let starts = self.starts(sketches);
        let refined = starts.into_iter().map(|start| self.refine(start, free));
        let best = refined.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = best.ok_or_else(|| self.none())?;
        if best.measures.stable {
            return Ok(self.report(&best));
        }
        if self.lead() > 0.5 * PI * ORDERS[1] {
            return Err(self.none());
        }
        Err(ControlError::NotFound {
            what: "a stable controller with this crossover and margin",
            why: if self.equations.any_sign {
                "move the crossover, above the unstable poles and below 1/(dead time), or ask for less margin"
            } else {
                "every candidate has a second crossover: lower the crossover or ask for less margin"
            },
        })
    }

    /// Steps to all sides and corners, halved where none helps.
    fn refine(&self, mut best: Trial, free: [bool; 3]) -> Trial {
        let mut step = 0.05;
        // A place that was tried was no better than the best then, and so is no better than the best now.
        let mut tried = BTreeSet::from([best.place.map(f64::to_bits)]);
        while step > 1e-4 {
            let before = best.cost;
            for direction in directions(free) {
                let mut place = best.place;
                for (value, sign) in place.iter_mut().zip(direction) {
                    *value += step * sign;
                }
                let anew = tried.insert(rounded(place).map(f64::to_bits));
                if anew && let Some(trial) = self.trial(place, best.cost) {
                    best = trial;
                }
            }
            if best.cost >= before {
                step *= 0.5;
            }
        }
        best
    }

    fn report(&self, best: &Trial) -> Tuned {
        let (ln_s, slope_s, response, slope_plant) = self.open.crossover;
        let controller = at(&best.gains, ln_s);
        // d ln C/d ln ω
        let gains = &best.gains;
        let integral =
            (ln_s * -gains.integral_order).exp() * (-gains.integral_order * gains.integral);
        let derivative =
            (ln_s * gains.derivative_order).exp() * (gains.derivative_order * gains.derivative);
        let slope = (integral + derivative) * slope_s / controller + slope_plant;
        let open = controller * response;
        let margin = (-open).arg();
        let least_margin = margin.min(best.measures.other_margin_rad);
        let margin_wanted = self.wishes.phase_margin_rad;
        let exact = [
            Some(Wish::new(WishName::Crossover, 1.0, open.norm())),
            Some(Wish::new(
                WishName::PhaseMargin,
                margin_wanted,
                least_margin,
            )),
            (self.wishes.iso_damping).then(|| Wish::new(WishName::IsoDamping, 0.0, slope.im)),
        ];
        let all = self
            .bounds(&best.measures)
            .chain(exact.into_iter().flatten());
        let unmet = all.filter(|wish| !wish.is_met()).collect();
        Tuned {
            parameters: best.gains,
            gain_at_crossover: open.norm(),
            phase_margin_rad: margin,
            phase_slope_rad: slope.im,
            measures: best.measures,
            unmet,
        }
    }

    /// The phase by which the controller has to lead, rad.
    fn lead(&self) -> f64 {
        self.wishes.phase_margin_rad - PI - self.open.plant_phase()
    }

    fn none(&self) -> ControlError {
        if self.lead().abs() > 0.5 * PI * ORDERS[1] {
            return ControlError::Contradiction {
                first: "phase_margin_rad",
                first_value: self.wishes.phase_margin_rad,
                second: "crossover_rad_s",
                second_value: self.open.omega,
                remedy: "the controller would have to turn the phase by more than half a turn: lower one of the two",
            };
        }
        ControlError::NotFound {
            what: "two gains with the plant's sign with this crossover, margin and slope of the phase",
            why: if self.wishes.iso_damping {
                "lower the crossover (dead time makes the phase fall), change the phase margin, or give up the flat phase"
            } else {
                "lower the crossover (dead time makes the phase fall), or change the phase margin"
            },
        }
    }
}

/// The equations of a plant at its crossover.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equations {
    /// ln s, and its slope over ln ω.
    ln_s: Complex<f64>,
    slope_s: Complex<f64>,
    /// Slope of the plant's phase over ln ω, rad.
    phase_slope: f64,
    /// `C(s_c)` that crossover and margin ask for.
    target: Complex<f64>,
    sign: f64,
    /// `K_p` may have any sign.
    any_sign: bool,
}

impl Equations {
    pub(super) fn new(open: &OpenLoop, phase_margin_rad: f64, sign: f64) -> Self {
        let (ln_s, slope_s, response, slope_plant) = open.crossover;
        Self {
            ln_s,
            slope_s,
            phase_slope: slope_plant.im,
            target: Complex::from_polar(1.0, phase_margin_rad - PI) / response,
            sign,
            any_sign: false,
        }
    }

    /// `K_p`, `K_i` and `K_d` of these orders and this slope, of any sign.
    fn solved(&self, [lambda, mu, slope]: [f64; 3]) -> Option<Vector3<f64>> {
        let powers =
            [0.0, -lambda, mu].map(|order| (order, (self.ln_s * order).exp() / self.target));
        // Σ k·s^μ/R = 1,   Im(σ·Σ k·μ·s^μ/R) = ψ − Im(G′/G)
        let row = |value: &dyn Fn(f64, Complex<f64>) -> f64| {
            powers.map(|(order, power)| value(order, power))
        };
        let rows = [
            row(&|_, power| power.re),
            row(&|_, power| power.im),
            row(&|order, power| (power * self.slope_s * order).im),
        ];
        let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
        let wanted = Vector3::new(1.0, 0.0, slope - self.phase_slope);
        let gains = matrix.lu().solve(&wanted)?;
        gains.iter().all(|gain| gain.is_finite()).then_some(gains)
    }

    /// The three gains, if `K_p` and `K_i` have the sign of the plant. `K_d` may have any: a negative one of small order is a lag.
    pub(super) fn gains(&self, place: [f64; 3]) -> Option<PidParameters> {
        let gains = self.solved(place)?;
        let with_plant =
            (self.any_sign || gains[0] * self.sign >= 0.0) && gains[1] * self.sign >= 0.0;
        with_plant.then_some(PidParameters {
            proportional: gains[0],
            integral: gains[1],
            integral_order: place[0],
            derivative: gains[2],
            derivative_order: place[1],
        })
    }

    /// Between two neighbours of μ where both `K_p` and `K_i` change sign, both may have the right one, however near these places are:
    /// the middle of the two.
    fn between(&self, lambda: f64, ends: [f64; 2], slope: f64) -> Option<[f64; 3]> {
        let zero = |gain: usize| {
            let at = |mu: f64| Some(self.solved([lambda, mu, slope])?[gain] > 0.0);
            let ([mut low, mut high], above) = (ends, at(ends[0])?);
            if at(high)? == above {
                return None;
            }
            while high - low > 1e-6 {
                let middle = 0.5 * (low + high);
                if at(middle)? == above {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            Some(low)
        };
        Some([lambda, 0.5 * (zero(0)? + zero(1)?), slope])
    }
}
