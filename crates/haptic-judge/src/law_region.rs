//! A region of laws: all walls, or all tissues of one model, whose numbers lie in ranges; and what lies between two laws.
//!
//! ```text
//! proved ⇐ every law of the region, and every mix of two, is stable on each of these devices       haptic_analysis::prove_laws
//! ```
//! - *Of what*: the laws as backward differences make them, s = (1 − w)/T, which the scheme `full` runs within its tolerance. Who feels one
//!   judges it once more with the operator that runs.
//! - *Between two laws* their own operators count. Two stable walls may have an unstable mix.
//! - *Cost*: milliseconds, up to seconds beside a border. The search for a part takes seven proofs.

use crate::{modelled_tissue::TissuePiece, preflight::Preflight, wall::WallTrial};
use fracdiff::{Scheme, full_memory::Kernel, parameter::Shown};
use haptic_analysis::{
    Dynamics, LawElements, LawSet, LoopOperator, PotRange, SampledWall, SetVerdict, prove_laws,
};
use haptic_document::{
    Failure, bad_input,
    parameters::{Parameter, SCHEME},
};
use haptic_quantity::digits;
use haptic_tissue::ModelKind;
use haptic_trial::{
    advice::analysed,
    keys::wall::{DISSIPATION, ORDER, STIFFNESS},
};

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

/// γ of the piece of a law, m; `None` of a wall.
fn shape_m(law: &WallTrial) -> Option<f64> {
    law.tissue.as_ref().map(TissuePiece::shape_m)
}

/// The elements of a law, N·s^α/m.
fn elements(law: &WallTrial) -> LawElements {
    let pot = |size: f64, order: f64| {
        LawElements::Pot(PotRange {
            size_n_s_alpha_per_m: [size; 2],
            order: [order; 2],
        })
    };
    let parallel = |a, b| LawElements::Parallel(Box::new([a, b]));
    let Some(piece) = &law.tissue else {
        let spring = pot(law.stiffness_n_per_m, 0.0);
        return parallel(spring, pot(law.dissipation_n_s_mu_per_m, law.order.get()));
    };
    let shape = piece.shape_m();
    let model = &piece.material.model;
    let series = |a, b| LawElements::Series(Box::new([a, b]));
    model.joined(|size, order| pot(shape * size, order), parallel, series)
}

/// All that lies between two of one structure.
fn between(low: &LawElements, high: &LawElements) -> Option<LawElements> {
    let range = |[a, _]: [f64; 2], [b, _]: [f64; 2]| [a.min(b), a.max(b)];
    let both = |a: &[LawElements; 2], b: &[LawElements; 2]| {
        Some(Box::new([between(&a[0], &b[0])?, between(&a[1], &b[1])?]))
    };
    Some(match (low, high) {
        (LawElements::Pot(a), LawElements::Pot(b)) => LawElements::Pot(PotRange {
            size_n_s_alpha_per_m: range(a.size_n_s_alpha_per_m, b.size_n_s_alpha_per_m),
            order: range(a.order, b.order),
        }),
        (LawElements::Parallel(a), LawElements::Parallel(b)) => LawElements::Parallel(both(a, b)?),
        (LawElements::Series(a), LawElements::Series(b)) => LawElements::Series(both(a, b)?),
        _ => return None,
    })
}

/// Sizes of a set so near to their least as this share of the way says; orders stay.
fn shrunk(set: &LawElements, share: f64) -> LawElements {
    let both =
        |parts: &[LawElements; 2]| Box::new(parts.each_ref().map(|part| shrunk(part, share)));
    match set {
        LawElements::Pot(pot) => {
            let [least, most] = pot.size_n_s_alpha_per_m;
            LawElements::Pot(PotRange {
                size_n_s_alpha_per_m: [least, least + share * (most - least)],
                order: pot.order,
            })
        }
        LawElements::Parallel(parts) => LawElements::Parallel(both(parts)),
        LawElements::Series(parts) => LawElements::Series(both(parts)),
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
                return Err(bad_input!(
                    "a region is proved for {}, not for {}: omit it, or allow each law alone",
                    SCHEME.set_to("full"),
                    corner.scheme
                ));
            };
        }
        let [(kind, least), (other, most)] = [numbers(low), numbers(high)];
        if kind != other || least.len() != most.len() || shape_m(low) != shape_m(high) {
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

    /// Each number with its ends, in words.
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
            return Err(bad_input!(
                "not all of this region is proved stable, nor its soft end with these orders ({}): give fewer orders, or softer laws",
                self.words()
            ));
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
        Err(bad_input!(
            "not all of this region is proved stable, free and in a hand: {} is",
            words(part)
        ))
    }

    /// True of a law within it; the nearest that is, in words, of another one of its kind, with how far it is away; `None` of another kind.
    pub fn holds(&self, law: &WallTrial) -> Option<Result<(), (String, f64)>> {
        let (kind, given) = numbers(law);
        let first = &self.corners[0];
        let alike = kind == numbers(first).0 && shape_m(law) == shape_m(first);
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
pub fn prove_mix(laws: [&Preflight<'_>; 2], devices: &[Dynamics]) -> Result<(), Failure> {
    let made = |law: &Preflight<'_>| {
        let wall = SampledWall {
            stiffness_n_per_m: law.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: law.dissipation_n_s_mu_per_m,
            order: law.order,
            sample_time_s: law.sample_time_s,
        };
        Ok::<_, Failure>((wall, law.loop_operator()?))
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
                "what is felt while one of these laws becomes the other is not proved stable: leave the first before the second comes, or feel a softer one in between",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::{law_region::*, setup::TrialSetup, trial::TrialPlan};
    use fracdiff::{Channel, Order, Seconds};
    use haptic_loop::{
        plant::MassDamperConfig,
        units::{Kilograms, NewtonSecondsPerMetre},
    };
    use haptic_trial::{Sensors, in_hand::law::HORIZON};
    use testkit::{Random, Tested, assert_refused, assert_says};

    const T: Seconds = Seconds(1e-3);

    fn device() -> MassDamperConfig {
        MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), T)
    }

    fn wall(k: f64, b: f64, order: f64) -> WallTrial {
        let setup = TrialSetup::new(device(), Sensors::NONE, TrialPlan::DEFAULT);
        let order = Order::new(order).expect("in range");
        WallTrial::linear(setup, order, "full".parse().expect("a scheme"), k, b)
    }

    fn devices() -> [Dynamics; 1] {
        [wall(1.0, 1.0, 0.5).setup.dynamics()]
    }

    /// Largest place in the last 0.2 s of 2 s over that in the first after a push, with a share of the second law: a mass on a damper, held.
    fn grows(laws: [&WallTrial; 2], share: f64) -> f64 {
        let (m, b) = (0.065, 3.5);
        let left = f64::exp(-b * T.0 / m);
        let way = (1.0 - left) * m / b;
        let mut parts = laws.map(|law| {
            let operator = law.look(HORIZON).operator::<f64>();
            Channel::new(operator.expect("made"))
        });
        let (mut x, mut v, mut peaks) = (0.0, 0.0, [0.0_f64; 2]);
        for tick in 0..2000 {
            let mut u = if tick == 0 { 1.0 } else { 0.0 };
            for ((law, memory), share) in laws.iter().zip(&mut parts).zip([1.0 - share, share]) {
                let rate = memory.step(x);
                u -= share * (law.stiffness_n_per_m * x + law.dissipation_n_s_mu_per_m * rate);
            }
            (x, v) = (
                x + way * v + (T.0 - way) / b * u,
                left * v + (1.0 - left) / b * u,
            );
            let part = [0..200, 1800..2000]
                .iter()
                .position(|part| part.contains(&tick));
            if let Some(part) = part {
                peaks[part] = peaks[part].max(f64::abs(x));
            }
        }
        peaks[1] / peaks[0]
    }

    #[test]
    fn a_mix_that_is_refused_grows_and_one_that_is_proved_does_not() {
        // Both are stable, and 4 of 2000 such pairs have a mix that is not.
        let (stiff, soft) = (
            wall(68894.82, 2.5176, 1.41897),
            wall(537.16, 7443.1, 0.069792),
        );
        let shares = (0..=20).map(|n| f64::from(n) / 20.0);
        let grown: Vec<f64> = shares.map(|share| grows([&stiff, &soft], share)).collect();
        assert!(grown[0] < 0.5 && grown[20] < 0.5, "{grown:?}");
        assert!(grown.iter().any(|grown| *grown > 2.0), "{grown:?}");
        let proved = |stiff: &WallTrial, soft: &WallTrial| {
            prove_mix([&stiff.look(HORIZON), &soft.look(HORIZON)], &devices())
        };
        assert_refused(proved(&stiff, &soft), "leave the first");
        let (stiff, soft) = (wall(2000.0, 20.0, 0.9), wall(100.0, 20.0, 0.2));
        proved(&stiff, &soft).expect("proved");
        assert!(grows([&stiff, &soft], 0.5) < 0.5);
    }

    #[test]
    fn each_law_of_a_region_is_stable_by_itself_and_the_refused_region_names_a_part() -> Tested {
        let corner = |share: f64| wall(50.0 + share * 60e3, 1.0 + share * 100.0, 0.2 + 0.7 * share);
        let whole = LawRegion::new([corner(0.0), corner(1.0)])?;
        let refused = whole.prove(&devices()).expect_err("too stiff").to_string();
        assert_says(&refused, "stiffness_n_per_m 50 to ");
        let most: f64 = refused
            .split("stiffness_n_per_m 50 to ")
            .nth(1)
            .and_then(|rest| rest.split(',').next()?.parse().ok())
            .expect("a number");
        let share = 0.99 * (most - 50.0) / 60e3;
        let top = WallTrial {
            order: Order::new(0.9)?,
            ..corner(share)
        };
        let region = LawRegion::new([top, corner(0.0)])?;
        region.prove(&devices())?;
        let mut random = Random(4);
        for _ in 0..40 {
            let law = wall(
                random.between(50.0, 50.0 + share * 60e3),
                random.between(1.0, 1.0 + share * 100.0),
                random.between(0.2, 0.9),
            );
            assert_eq!(region.holds(&law), Some(Ok(())));
            let verdict = law.look(HORIZON).verdict(devices()[0], 0);
            assert!(verdict?.stable, "{law:?}");
        }
        let outside = region.holds(&wall(10.0, 2.0, 0.95)).expect("of its kind");
        let (nearest, _) = outside.expect_err("outside");
        assert_eq!(
            nearest,
            "order = 0.9 for 0.95, stiffness_n_per_m = 50 for 10"
        );
        let short = WallTrial {
            scheme: "grunwald:100".parse()?,
            ..corner(0.0)
        };
        assert_eq!(region.holds(&short), None);
        assert_refused(
            LawRegion::new([short, corner(0.1)]),
            "a region is proved for",
        );
        Ok(())
    }
}
