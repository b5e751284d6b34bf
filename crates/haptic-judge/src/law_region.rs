//! A region of laws: all walls, or all tissues of one model, whose numbers lie in ranges; and what lies between two laws.
//!
//! ```text
//! proved ⇐ every law of the region, and every mix of two, is stable on each of these devices       haptic_analysis::prove_laws
//! ```
//! - *Of what*: the laws as backward differences make them, s = (1 − w)/T, which the scheme `full` runs within its tolerance. Who feels one
//!   judges it once more with the operator that runs.
//! - *Between two laws* their own operators count. Two stable walls may have an unstable mix.
//! - *Cost*: milliseconds, up to seconds beside a border. The search for a part takes seven proofs.

use crate::wall::WallTrial;
use fracdiff::Scheme;
use fracdiff::full_memory::Kernel;
use fracdiff::parameter::Shown;
use haptic_analysis::{
    Dynamics, Elements, LawSet, LoopOperator, PotRange, SampledWall, SetVerdict, prove_laws,
};
use haptic_document::Failure;
use haptic_document::parameters::{Parameter, SCHEME};
use haptic_quantity::digits;
use haptic_tissue::ModelKind;
use haptic_trial::advice::analysed;
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};

/// Samples of the memory that a law between two is judged with.
const HORIZON: u64 = 10_000_000;
/// Halvings in the search for the largest part.
const HALVINGS: u32 = 7;

/// A number of a law, by its name, which has its unit.
type Number = (&'static str, f64);

/// Laws of one kind between two corners.
#[derive(Clone, Debug)]
pub struct LawRegion {
    /// The soft corner, and the one of the largest numbers.
    corners: [WallTrial; 2],
    ranges: Vec<(&'static str, [f64; 2])>,
}

/// Name of the model of a law, `None` for order, K and B; and its numbers.
fn numbers(law: &WallTrial) -> (Option<ModelKind>, Vec<Number>) {
    let Some(piece) = &law.tissue else {
        let of_wall = |key: Parameter, value| (key.key, value);
        let numbers = [
            of_wall(ORDER, law.order.get()),
            of_wall(STIFFNESS, law.stiffness_n_per_m),
            of_wall(DISSIPATION, law.dissipation_n_s_mu_per_m),
        ];
        return (None, numbers.to_vec());
    };
    let model = &piece.material.model;
    let numbers = model.parameters().into_iter();
    let numbers = numbers.map(|(parameter, value)| (parameter.name, value));
    (Some(model.kind()), numbers.collect())
}

/// The elements of a law, N·s^α/m.
fn elements(law: &WallTrial) -> Elements {
    let pot = |size: f64, order: f64| {
        Elements::Pot(PotRange {
            size_n_s_alpha_per_m: [size; 2],
            order: [order; 2],
        })
    };
    let parallel = |a, b| Elements::Parallel(Box::new([a, b]));
    let Some(piece) = &law.tissue else {
        let spring = pot(law.stiffness_n_per_m, 0.0);
        return parallel(spring, pot(law.dissipation_n_s_mu_per_m, law.order.get()));
    };
    let shape = piece.shape_m();
    let model = &piece.material.model;
    let series = |a, b| Elements::Series(Box::new([a, b]));
    model.joined(|size, order| pot(shape * size, order), parallel, series)
}

/// All that lies between two of one structure.
fn between(low: &Elements, high: &Elements) -> Option<Elements> {
    let range = |[a, _]: [f64; 2], [b, _]: [f64; 2]| [a.min(b), a.max(b)];
    let both = |a: &[Elements; 2], b: &[Elements; 2]| {
        Some(Box::new([between(&a[0], &b[0])?, between(&a[1], &b[1])?]))
    };
    Some(match (low, high) {
        (Elements::Pot(a), Elements::Pot(b)) => Elements::Pot(PotRange {
            size_n_s_alpha_per_m: range(a.size_n_s_alpha_per_m, b.size_n_s_alpha_per_m),
            order: range(a.order, b.order),
        }),
        (Elements::Parallel(a), Elements::Parallel(b)) => Elements::Parallel(both(a, b)?),
        (Elements::Series(a), Elements::Series(b)) => Elements::Series(both(a, b)?),
        _ => return None,
    })
}

/// Sizes of a set so near to their least as this share of the way says; orders stay.
fn shrunk(set: &Elements, share: f64) -> Elements {
    let both = |parts: &[Elements; 2]| Box::new(parts.each_ref().map(|part| shrunk(part, share)));
    match set {
        Elements::Pot(pot) => {
            let [least, most] = pot.size_n_s_alpha_per_m;
            Elements::Pot(PotRange {
                size_n_s_alpha_per_m: [least, least + share * (most - least)],
                order: pot.order,
            })
        }
        Elements::Parallel(parts) => Elements::Parallel(both(parts)),
        Elements::Series(parts) => Elements::Series(both(parts)),
    }
}

fn words(ranges: impl Iterator<Item = (&'static str, [f64; 2])>) -> String {
    let words = ranges.map(|(name, [low, high])| {
        let digits = |value: f64| digits(value, 3);
        format!("{name} {} to {}", digits(low), digits(high))
    });
    words.collect::<Vec<_>>().join(", ")
}

impl LawRegion {
    /// The region between two laws of one kind, in any order of their numbers.
    ///
    /// # Errors
    /// A wall and a tissue, two models, two sizes of a piece, or a scheme that is not of backward differences with all of the past.
    pub fn new(corners: [WallTrial; 2]) -> Result<Self, Failure> {
        let [low, high] = &corners;
        for corner in &corners {
            let Scheme::Full {
                kernel: Kernel::Grunwald,
                ..
            } = corner.scheme
            else {
                return Err(Failure::bad_input(format_args!(
                    "a region is proved for {}, not for {}: omit it, or allow each law alone",
                    SCHEME.set_to("full"),
                    corner.scheme
                )));
            };
        }
        let [(kind, least), (other, most)] = [numbers(low), numbers(high)];
        let shapes = corners
            .each_ref()
            .map(|law| law.tissue.as_ref().map(|piece| piece.shape_m()));
        if kind != other || least.len() != most.len() || shapes[0] != shapes[1] {
            return Err(Failure::bad_input(
                "a region lies between two walls, or two pieces of one size of tissues of one model: change one of its ends",
            ));
        }
        let ranges = least.iter().zip(&most);
        let ranges = ranges.map(|(&(name, a), &(_, b))| (name, [a.min(b), a.max(b)]));
        Ok(Self {
            ranges: ranges.collect(),
            corners,
        })
    }

    /// Its ranges in words.
    #[must_use]
    pub fn words(&self) -> String {
        words(self.ranges.iter().copied())
    }

    /// Proves all of it, with every mix of two, on each of these devices.
    ///
    /// # Errors
    /// A region that is not proved, with the largest part of it that is; numbers that the analysis does not accept.
    pub fn prove(&self, devices: &[Dynamics]) -> Result<(), Failure> {
        let [low, high] = &self.corners;
        let whole = between(&elements(low), &elements(high)).ok_or_else(|| {
            Failure::bad_input(
                "the models of its ends have other elements: end an order above 0 and below 1",
            )
        })?;
        let t = low.setup.device.sample_time.0;
        let holds = |share: f64| {
            let sets = [LawSet::Elements(shrunk(&whole, share))];
            for device in devices {
                if prove_laws(device, t, &sets).map_err(analysed)? != SetVerdict::Proved {
                    return Ok(false);
                }
            }
            Ok::<_, Failure>(true)
        };
        if holds(1.0)? {
            return Ok(());
        }
        let (mut good, mut bad) = (0.0, 1.0);
        if !holds(0.0)? {
            return Err(Failure::bad_input(format_args!(
                "not all of this region is proved stable, nor its soft end with these orders ({}): give fewer orders, or softer laws",
                self.words()
            )));
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            *(if holds(middle)? { &mut good } else { &mut bad }) = middle;
        }
        let part = self.ranges.iter().map(|&(name, [least, most])| {
            let is_order = name.ends_with("order");
            let share = if is_order { 1.0 } else { good };
            (name, [least, least + share * (most - least)])
        });
        Err(Failure::bad_input(format_args!(
            "not all of this region is proved stable, free and in a hand: {} is",
            words(part)
        )))
    }

    /// True of a law within it; the nearest that is, in words, of another one of its kind, with how far it is away; `None` of another kind.
    pub fn holds(&self, law: &WallTrial) -> Option<Result<(), (String, f64)>> {
        let (kind, given) = numbers(law);
        let first = &self.corners[0];
        let shape = |law: &WallTrial| law.tissue.as_ref().map(|piece| piece.shape_m());
        let alike = kind == numbers(first).0 && shape(law) == shape(first);
        if !alike || given.len() != self.ranges.len() || law.scheme != first.scheme {
            return None;
        }
        let (mut off, mut far) = (Vec::new(), 0.0);
        for (&(name, value), &(_, [low, high])) in given.iter().zip(&self.ranges) {
            // A number that was read back differs by its rounding.
            let slack = 1e-12 * high.abs();
            if !(low - slack..=high + slack).contains(&value) {
                let nearest = value.clamp(low, high);
                off.push(format!("{name} = {} for {}", Shown(nearest), Shown(value)));
                far += (value - nearest).abs() / (high - low).max(f64::MIN_POSITIVE);
            }
        }
        Some(if off.is_empty() {
            Ok(())
        } else {
            Err((off.join(", "), far))
        })
    }
}

/// Proves that every mix of two laws is stable on each of these devices.
///
/// # Errors
/// A mix that is not proved; a law of which no operator can be made.
pub fn prove_mix(laws: [&WallTrial; 2], devices: &[Dynamics]) -> Result<(), Failure> {
    let made = |law: &WallTrial| {
        let wall = SampledWall {
            stiffness_n_per_m: law.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: law.dissipation_n_s_mu_per_m,
            order: law.order,
            sample_time_s: law.setup.device.sample_time.0,
        };
        Ok::<_, Failure>((wall, law.look(HORIZON).loop_operator()?))
    };
    let [first, second]: [(SampledWall, LoopOperator); 2] = [made(laws[0])?, made(laws[1])?];
    let sets = [
        LawSet::Wall(first.0, &first.1),
        LawSet::Wall(second.0, &second.1),
    ];
    for device in devices {
        let verdict = prove_laws(device, first.0.sample_time_s, &sets).map_err(analysed)?;
        if verdict != SetVerdict::Proved {
            return Err(Failure::bad_input(
                "what is felt while one of these laws becomes the other is not proved stable: rest before it, or feel a softer one in between",
            ));
        }
    }
    Ok(())
}
