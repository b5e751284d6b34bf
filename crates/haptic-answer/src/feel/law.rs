//! Laws made from settings, and what the analysis says of them before they are felt.

use super::ghost::GhostLaws;
use super::settings::{FeelSettings, Ghost};
use fracdiff::num_complex::Complex;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::Dynamics;
use haptic_document::{Failure, parameters};
use haptic_judge::law_region::prove_mix;
use haptic_judge::modelled_tissue::operator;
use haptic_judge::preflight::{Matter, Preflight, WallContact};
use haptic_loop::units::Metres;
use haptic_loop::{Controller, Pushing, SafetyChain, Specimen, Wall, WallShape};
use haptic_quantity::digits;
use haptic_tissue::SampledModel;
use haptic_trial::in_hand::fading::Law;
use haptic_trial::in_hand::hand::{HAND_DAMPING, HAND_STIFFNESS, HeldDevice};
use haptic_trial::in_hand::law::{Felt, HORIZON, fading, refuse_unstable, rounded_down, ticks};
use haptic_trial::in_hand::place::Placed;
use haptic_trial::in_hand::ticking::FeltController;
use haptic_trial::preflight::PreflightVerdict;
use std::f64::consts::TAU;

/// Time that the short memory keeps, s.
const SHORT_S: f64 = 1.0;
/// Time of the past that a ghost hears, s: more than it remembers.
const GHOST_PAST_S: f64 = 1.1 * SHORT_S;
const A3_DEGREE: usize = 3;

/// Frequencies of a hand that presses, Hz; the middle one is that of a difference in stiffness.
const HAND_HZ: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];

/// Laws of which no frequency tells more are the same.
const ALIKE: f64 = 1e-9;

/// Margin at which a tissue is felt that would be unstable in its full size: hits on contact that only pushes grow at less.
const FITTED_MARGIN: f64 = 2.0;

/// Settings of a felt law, with the verdict that let it run.
#[derive(Clone, Debug)]
pub struct JudgedFeel {
    /// The law and the device.
    pub settings: FeelSettings,
    /// The verdict, of the device below.
    pub verdict: PreflightVerdict,
    /// The device that the verdict is of: with the hand or without.
    pub dynamics: Dynamics,
}

impl FeelSettings {
    /// K and B with the factor.
    pub fn gains(&self) -> (f64, f64) {
        (
            self.scale * self.law.stiffness_n_per_m,
            self.scale * self.law.dissipation_n_s_mu_per_m,
        )
    }

    /// Force per displacement at small depths, N/m.
    ///
    /// ```text
    /// |K + B·(jω)^μ|, of a model with more elements |K + B·(M(jω) − E)/η|
    /// ```
    fn dynamic_stiffness(&self, frequency_hz: f64) -> Result<f64, Failure> {
        let omega_rad_s = TAU * frequency_hz;
        let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = self.gains();
        let Some(model) = &self.model else {
            let wall = Matter::Wall {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                order: self.fractional_order()?,
            };
            return Ok(wall.stiffness(omega_rad_s).norm());
        };
        // E and η are the same at any sample time.
        let sampled = SampledModel::new(model, Seconds(1.0)).map_err(Failure::input)?;
        let beside_rest =
            model.modulus(Complex::new(0.0, omega_rad_s)) - sampled.elastic_modulus_pa();
        let memory = beside_rest / sampled.viscosity_pa_s_mu();
        Ok((memory * dissipation_n_s_mu_per_m + stiffness_n_per_m).norm())
    }

    /// The share by which it is stiffer than another one at 1 Hz; `None` if it is the softer one at some speeds of a hand and the
    /// stiffer one at others, from 0.1 to 10 Hz.
    ///
    /// # Errors
    /// Two that are the same; one that is nothing.
    pub fn stiffer_by(&self, other: &Self) -> Result<Option<f64>, Failure> {
        let mut changes = [0.0; HAND_HZ.len()];
        for (change, hz) in changes.iter_mut().zip(HAND_HZ) {
            *change = self.dynamic_stiffness(hz)? / other.dynamic_stiffness(hz)? - 1.0;
        }
        if !changes.iter().all(|change| change.is_finite()) {
            return Err(Failure::bad_input(
                "what is felt has neither stiffness nor dissipation, so nothing can be compared with it: give it some",
            ));
        }
        if changes.iter().all(|change| change.abs() < ALIKE) {
            return Err(Failure::bad_input(
                "both are the same, so no answer would be right: give `b` another tissue, stiffness or scale",
            ));
        }
        let one_way = |sign: f64| changes.iter().all(|change| sign * change > ALIKE);
        Ok((one_way(1.0) || one_way(-1.0)).then_some(changes[HAND_HZ.len() / 2]))
    }

    fn fractional_order(&self) -> Result<Order, Failure> {
        Order::new(self.law.order).map_err(Failure::input)
    }

    fn felt_by(&self, scheme: Scheme) -> Result<Law<Felt>, Failure> {
        let (model, order) = (self.model.as_ref(), self.fractional_order()?);
        let t = self.device.sample_time();
        let operator = operator(model, scheme, order, t, HORIZON as f64)?;
        let (stiffness, dissipation) = self.gains();
        let surface = (!self.law.signed).then_some(Metres(0.0));
        let shape = WallShape::new(stiffness, dissipation, surface).map_err(Failure::input)?;
        let wall = Wall::of(shape.with_depth_map(self.map), operator);
        Ok(Law::at_rest(Placed::new(Pushing::new(wall, false), 0.0)))
    }

    /// The law at rest, with all of its memory.
    ///
    /// # Errors
    /// A law that cannot be made.
    pub fn law(&self) -> Result<Law<Felt>, Failure> {
        self.felt_by(self.scheme()?)
    }

    /// Controller and device of a loop whose tissue is untouched, and the laws of its ghosts.
    ///
    /// # Errors
    /// A law that cannot be made; a number that no device has.
    pub fn untouched(&self) -> Result<(FeltController, HeldDevice, GhostLaws), Failure> {
        let t = self.device.sample_time();
        let chain = SafetyChain::from_limits(&self.limits(), t).map_err(Failure::input)?;
        let controller = Controller::new(fading(&self.law()?.environment, t), chain);
        Ok((controller, self.device.simulated()?, self.ghost_laws()?))
    }

    /// The laws of the ghosts, `None` of one that is not drawn.
    ///
    /// # Errors
    /// A law that cannot be made.
    pub fn ghost_laws(&self) -> Result<GhostLaws, Failure> {
        let law = |ghost: Ghost| {
            let scheme = match ghost {
                Ghost::Short => Scheme::Grunwald {
                    length: ticks(SHORT_S, self.device.sample_time()),
                },
                Ghost::A3 => Scheme::Muir { degree: A3_DEGREE },
            };
            let is_drawn = self.ghosts.contains(&ghost);
            is_drawn.then(|| self.felt_by(scheme)).transpose()
        };
        let [short, a3] = Ghost::ALL;
        Ok([law(short)?, law(a3)?])
    }

    /// The law, and the ghosts, after these positions, m, from a tick on.
    ///
    /// # Errors
    /// A law that cannot be made.
    pub fn laws_after(&self, first: u64, past: &[f32]) -> Result<(Law<Felt>, GhostLaws), Failure> {
        let (mut law, mut ghosts) = (self.law()?, self.ghost_laws()?);
        law.hear_from(first, past.iter().copied().map(f64::from));
        let heard = ticks(GHOST_PAST_S, self.device.sample_time());
        let recent = past.len().saturating_sub(heard);
        for law in ghosts.iter_mut().flatten() {
            let recent_past = past[recent..].iter().copied();
            law.hear_from(first + recent as u64, recent_past.map(f64::from));
        }
        Ok((law, ghosts))
    }

    /// Itself with the pre-flight of the loop with the hand and without, whichever is nearer to the edge. A tissue whose size
    /// was not requested is made as small as it has to be.
    ///
    /// # Errors
    /// A law that is unstable, with the factor that helps.
    pub fn judged(mut self) -> Result<JudgedFeel, Failure> {
        let mut both = self.verdicts()?;
        if self.may_scale && both.iter().any(|(verdict, _)| !verdict.stable) {
            self.fit(&both);
            both = self.verdicts()?;
        }
        for (verdict, _) in &both {
            refuse_unstable(verdict)?;
        }
        let [free, held] = both;
        let edge = |(verdict, _): &(PreflightVerdict, _)| verdict.margin.unwrap_or(f64::INFINITY);
        let is_held = edge(&held) < edge(&free);
        let (verdict, dynamics) = if is_held { held } else { free };
        Ok(JudgedFeel {
            settings: self,
            verdict,
            dynamics,
        })
    }

    /// Takes the factor at which the nearest edge is [`FITTED_MARGIN`] away, to two digits and rounded down, with a note.
    fn fit(&mut self, both: &[(PreflightVerdict, Dynamics)]) {
        let edges = both.iter().filter_map(|(verdict, _)| verdict.margin);
        let most = edges.fold(f64::INFINITY, f64::min);
        self.scale = rounded_down(self.scale * most / FITTED_MARGIN);
        self.note = Some(format!(
            "Felt at {} % of its stiffness: on this device more than {} % is unstable.",
            digits(100.0 * self.scale, 2),
            digits(100.0 * most, 2)
        ));
    }

    /// The loop that is judged, of a tissue that stiffens where it is steepest.
    fn preflight(&self) -> Result<Preflight<'_>, Failure> {
        let (stiffness, dissipation) = self.gains();
        // As steep as a tissue that stiffens is where small strain ends.
        let deep_m = Specimen::SMALL_STRAIN * parameters::THICKNESS.default_number();
        let preflight = Preflight {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.fractional_order()?,
            model: self.model.as_ref(),
            scheme: self.scheme()?,
            sample_time_s: self.device.sample_time_s,
            samples: HORIZON,
            map: None,
            // Of a signed wall no less is said without the proof for every motion, which takes too long here.
            contact: WallContact::OneSided,
            guarded: false,
        };
        Ok(preflight.at_depth(self.map, deep_m))
    }

    /// The device without the hand and with it.
    fn devices(&self) -> [Dynamics; 2] {
        let free = Dynamics {
            hand_stiffness_n_per_m: 0.0,
            ..self.device.values.dynamics()
        };
        let held = Dynamics {
            damping_n_s_per_m: free.damping_n_s_per_m + HAND_DAMPING.0,
            hand_stiffness_n_per_m: HAND_STIFFNESS.0,
            ..free
        };
        [free, held]
    }

    /// The pre-flight without the hand and with it.
    fn verdicts(&self) -> Result<[(PreflightVerdict, Dynamics); 2], Failure> {
        let preflight = self.preflight()?;
        let judge = |dynamics| Ok::<_, Failure>((preflight.verdict(dynamics, 0)?, dynamics));
        let [free, held] = self.devices();
        Ok([judge(free)?, judge(held)?])
    }

    /// Proves what is felt while this law becomes another one on its device, free and in a hand.
    ///
    /// # Errors
    /// A mix of the two that is not proved stable.
    pub fn proves_change(&self, next: &Self) -> Result<(), Failure> {
        let law = |of: &Self| (of.law.clone(), of.scale, of.model.clone(), of.map);
        if law(self) == law(next) {
            return Ok(());
        }
        prove_mix([&self.preflight()?, &next.preflight()?], &next.devices())
    }
}
