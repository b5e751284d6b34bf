//! Laws made from settings, and what the analysis says of them before they are felt.

use super::fading::{Fading, Law};
use super::hand::{HAND_DAMPING, HAND_STIFFNESS};
use super::settings::{FeelSettings, Ghost, SAMPLE_TIME};
use fracdiff::{Operator, Order, Scheme};
use haptic_experiment::judge::{Preflight, WallContact, operator};
use haptic_experiment::{Dynamics, Failure, PreflightVerdict, parameters};
use haptic_loop::units::Metres;
use haptic_loop::{Contact, Specimen, SpringDamper};

/// Samples for which the memory is made: 2.8 hours.
const HORIZON: u64 = 10_000_000;
/// Ticks in which one law goes over into the next: 0.2 s.
const FADE_TICKS: u32 = 200;
/// Ticks that the short memory keeps: 1 s.
const SHORT_TICKS: usize = 1000;
const A3_DEGREE: usize = 3;

/// A tissue or wall behind a surface at 0.
pub(crate) type Felt = Contact<f64, SpringDamper<f64, Operator<f64>>, 1>;
/// It, while it may change.
pub(crate) type FadingFelt = Fading<Felt>;

/// What is felt, with the verdict that let it run.
#[derive(Clone, Debug)]
pub(crate) struct JudgedFeel {
    pub(crate) settings: FeelSettings,
    pub(crate) verdict: PreflightVerdict,
    /// The device that the verdict is of: with the hand or without.
    pub(crate) dynamics: Dynamics,
}

impl FeelSettings {
    pub(super) fn gains(&self) -> (f64, f64) {
        (
            self.scale * self.law.stiffness_n_per_m,
            self.scale * self.law.dissipation_n_s_mu_per_m,
        )
    }

    fn fractional_order(&self) -> Result<Order, Failure> {
        Order::new(self.law.order).map_err(Failure::input)
    }

    fn felt_by(&self, scheme: Scheme) -> Result<Law<Felt>, Failure> {
        let (model, order) = (self.model.as_ref(), self.fractional_order()?);
        let operator = operator(model, scheme, order, SAMPLE_TIME, HORIZON as f64)?;
        let (stiffness, dissipation) = self.gains();
        let inner = SpringDamper::new(stiffness, dissipation, operator).map_err(Failure::input)?;
        let felt = Contact::at(Metres(0.0), inner).map_err(Failure::input)?;
        Ok(Law::at_rest(felt.with_depth_map(self.map)))
    }

    /// The law at rest, with all of its memory.
    pub(crate) fn law(&self) -> Result<Law<Felt>, Failure> {
        self.felt_by(full_memory()?)
    }

    pub(crate) fn ghost_laws(&self) -> Result<[Option<Law<Felt>>; 2], Failure> {
        let law = |ghost: Ghost| {
            let scheme = match ghost {
                Ghost::Short => Scheme::Grunwald {
                    length: SHORT_TICKS,
                },
                Ghost::A3 => Scheme::Muir { degree: A3_DEGREE },
            };
            let there = self.ghosts.contains(&ghost);
            there.then(|| self.felt_by(scheme)).transpose()
        };
        let [short, a3] = Ghost::ALL;
        Ok([law(short)?, law(a3)?])
    }

    /// Itself with the pre-flight of the loop with the hand and without, whichever is nearer to the edge.
    pub(crate) fn judged(self) -> Result<JudgedFeel, Failure> {
        let (stiffness, dissipation) = self.gains();
        // As steep as a tissue that stiffens is where small strain ends.
        let deep_m = Specimen::SMALL_STRAIN * parameters::THICKNESS.default_number();
        let preflight = Preflight {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.fractional_order()?,
            model: self.model.as_ref(),
            scheme: full_memory()?,
            sample_time_s: SAMPLE_TIME.0,
            samples: HORIZON,
            map: None,
            contact: WallContact::OneSided,
            guarded: false,
        };
        let preflight = preflight.at_depth(self.map, deep_m);
        let free = Dynamics {
            mass_kg: self.device.mass_kg,
            damping_n_s_per_m: self.device.damping_n_s_per_m,
            hand_stiffness_n_per_m: 0.0,
            delay_s: self.imperfections.delay_s,
            current_lag_s: self.imperfections.current_lag_s,
        };
        let held = Dynamics {
            damping_n_s_per_m: free.damping_n_s_per_m + HAND_DAMPING.0,
            hand_stiffness_n_per_m: HAND_STIFFNESS.0,
            ..free
        };
        let judge = |dynamics| {
            let verdict = preflight.verdict(dynamics, 0)?;
            refuse_unstable(&verdict)?;
            Ok::<_, Failure>((verdict, dynamics))
        };
        let (free, held) = (judge(free)?, judge(held)?);
        let edge = |(verdict, _): &(PreflightVerdict, _)| verdict.margin.unwrap_or(f64::INFINITY);
        let is_held = edge(&held) < edge(&free);
        let (verdict, dynamics) = if is_held { held } else { free };
        Ok(JudgedFeel {
            settings: self,
            verdict,
            dynamics,
        })
    }
}

fn refuse_unstable(verdict: &PreflightVerdict) -> Result<(), Failure> {
    if verdict.stable {
        return Ok(());
    }
    let advice = match verdict.margin {
        // Rounded down, so that what is proposed is accepted.
        Some(factor) => format!("take at most {} of K and B", (factor * 1e2).floor() / 1e2),
        None => "take another order, or a heavier or more damped device".to_owned(),
    };
    Err(Failure::bad_input(format_args!(
        "this would be unstable (alpha {:.3}, beta {:.3}, delta {:.3}): {advice}",
        verdict.alpha, verdict.beta, verdict.delta
    )))
}

fn full_memory() -> Result<Scheme, Failure> {
    parameters::SCHEME.shown.parse().map_err(Failure::input)
}

/// Two laws that become one another: the first is felt alone.
pub(crate) fn fading(law: &Felt) -> FadingFelt {
    Fading::new(law.clone(), FADE_TICKS)
}
