//! Pre-flight: what the analysis says of an experiment before a device is armed.
//!
//! ```text
//! K, B, μ, T, the operator really used ─┐
//! m, b, k of device and hand            ├─▶ stable? how far from the edge? passive?
//! delay really measured ────────────────┘
//! ```
//! - *The loop* is the one of the stability analysis: a mass on a damper under a wall that is felt all the time.
//!   Safety chain and friction are not in it; they may turn an unstable loop into a limit cycle. Nor is the end of the contact: with
//!   delay, hard hits can grow on a wall that never pulls where the linear loop is stable. So for such a wall the proved
//!   result is reported separately.
//! - *Without any spring* (a tissue that only dissipates) the loop has a pole at rest, z = 1, and the device drifts, as it
//!   should. Such a loop is judged beside that pole, see `SampledLoop::beside_rest`.
//! - *Delay*: that of the device, whole samples or not, as simulated or as known of a real one; in a loop on the host
//!   the round trip beside it that nine of ten keep-alives do not exceed, plus the tick that the force waits for,
//!   rounded up to whole samples, since the device writes once a sample. The current lag of the motor likewise.
//! - *Margin*: the factor on K and B together that takes the loop to the edge of stability.

use crate::{
    modelled_tissue::{TissuePiece, loop_operator, memory, operator},
    reference,
    reference::{ReferenceSeries, ReferenceWeights},
};
use fracdiff::{
    FrequencyResponse as _, Operator, Order, Real, Scheme, Seconds, num_complex::Complex,
};
use haptic_analysis::{AnalysisError, Dynamics, LoopOperator, SampledLoop, SampledWall};
use haptic_document::{Failure, Named, bad_input};
use haptic_loop::DepthMap;
use haptic_tissue::Model;
use haptic_trial::{
    advice::analysed,
    preflight::{EVERY_MOTION, NO_ENERGY, NOT_PROVED, PreflightVerdict},
    samples::{Before, Samples, horizon},
};
use serde::Serialize;

/// Touched matter: a piece of tissue, or K + B·D^μ.
#[derive(Clone, Debug)]
pub enum Matter {
    /// A piece of tissue, whose loading may make the force nonlinear in the depth.
    Tissue(TissuePiece),
    /// A wall K + B·D^μ, linear in the depth.
    Wall {
        /// K, N/m, at least 0.
        stiffness_n_per_m: f64,
        /// B, N·s^μ/m, at least 0.
        dissipation_n_s_mu_per_m: f64,
        /// μ, 0 to 2.
        order: Order,
    },
}

impl Matter {
    /// The loop with an operator of this scheme, for `samples` samples.
    pub fn run_by(&self, scheme: Scheme, t: Seconds, samples: u64) -> Preflight<'_> {
        let (model, order, (stiffness_n_per_m, dissipation_n_s_mu_per_m)) = match self {
            Self::Tissue(piece) => {
                let material = &piece.material;
                (
                    material.composed(),
                    material.order(),
                    piece.spring_and_damper(),
                )
            }
            Self::Wall {
                stiffness_n_per_m: k,
                dissipation_n_s_mu_per_m: b,
                order,
            } => (None, *order, (*k, *b)),
        };
        Preflight {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order,
            model,
            scheme,
            sample_time_s: t.0,
            samples,
            map: None,
            contact: WallContact::Linear,
            guarded: false,
        }
    }

    /// The map of depth of a piece that is not linear.
    pub fn depth_map(&self) -> Option<DepthMap<f64>> {
        match self {
            Self::Tissue(piece) => piece.specimen.depth_map(),
            Self::Wall { .. } => None,
        }
    }

    /// The depth that a step of force reaches in a time, m; 0 of a wall.
    pub fn crept(&self, force_n: f64, time_s: f64) -> f64 {
        match self {
            Self::Tissue(piece) => piece.crept(force_n, &[time_s])[0],
            Self::Wall { .. } => 0.0,
        }
    }

    /// Force per displacement at a frequency, N/m.
    #[must_use]
    pub fn stiffness(&self, omega_rad_s: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega_rad_s);
        match self {
            Self::Tissue(piece) => piece.material.model.modulus(s) * piece.shape_m(),
            Self::Wall {
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
                order,
            } => s.powf(order.get()) * *dissipation_n_s_mu_per_m + *stiffness_n_per_m,
        }
    }

    /// Its name or its numbers, in a few words for a title.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Tissue(piece) => piece.material.name.clone(),
            Self::Wall {
                stiffness_n_per_m: k,
                dissipation_n_s_mu_per_m: b,
                order,
            } => format!("{k} N/m and {b} N·s^{order}/m"),
        }
    }

    /// The text of the file of a tissue.
    pub fn file(&self) -> Option<String> {
        match self {
            Self::Tissue(piece) => Some(piece.material.to_toml()),
            Self::Wall { .. } => None,
        }
    }
}

/// Behaviour of a law in front of its surface and on the way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WallContact {
    /// It pulls as it pushes, on both sides.
    Linear,
    /// Its memory is fed with the depth, 0 outside, and its force is clamped: it never pulls.
    OneSided,
    /// Its memory is fed with the place, outside too, and its force alone is clamped.
    Signed,
}

impl Named for WallContact {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::OneSided,
            "depth",
            "The depth, zero outside: no force before contact, but no proof",
        ),
        (
            Self::Signed,
            "signed",
            "The position, outside too: pushes before contact, but can be proved",
        ),
    ];

    fn name(self) -> &'static str {
        match self {
            // No choice of this key: without `one_sided` a wall pulls too.
            Self::Linear => "linear",
            Self::OneSided => "depth",
            Self::Signed => "signed",
        }
    }
}

impl WallContact {
    /// Contact of a law that only pushes, or pulls too.
    pub const fn of(one_sided: bool) -> Self {
        if one_sided {
            Self::OneSided
        } else {
            Self::Linear
        }
    }
}

/// Steepest slope of a map that is analysed.
const STEEPEST: f64 = 1e6;

/// The loop to be checked.
#[derive(Clone, Copy, Debug)]
pub struct Preflight<'a> {
    /// K of the wall, or of the tissue at the depth that is judged, N/m.
    pub stiffness_n_per_m: f64,
    /// B of the same, N·s^μ/m, scaled like K by the slope of a depth map.
    pub dissipation_n_s_mu_per_m: f64,
    /// The order μ of the operator, 0 to 2.
    pub order: Order,
    /// The model whose memory the operator is; `None` for D^μ.
    pub model: Option<&'a Model>,
    /// The operator that really runs: the verdict differs from that of the exact D^μ.
    pub scheme: Scheme,
    /// T of the loop, s; the whole judgement is of the sampled loop.
    pub sample_time_s: f64,
    /// Samples of the run, on which the memory of the operator depends.
    pub samples: u64,
    /// The map of depth, and its slope at the point where K and B are checked; `None` if the force
    /// is linear in the depth.
    pub map: Option<(DepthMap<f64>, f64)>,
    /// Behaviour in front of the surface and on the way out.
    pub contact: WallContact,
    /// True if a guard keeps it from giving energy:
    /// [`EnergyBounding`](haptic_trial::GuardChoice::EnergyBounding).
    pub guarded: bool,
}

/// The loop for whoever runs it, or compares the run with its full history.
impl Preflight<'_> {
    /// The law with the slope that its depth map has at a depth, m.
    #[must_use]
    pub fn at_depth(self, map: Option<DepthMap<f64>>, depth_m: f64) -> Self {
        // A loop a million times as steep is as unstable as any steeper one.
        let slope = map.map_or(1.0, |map| map.slope(depth_m).min(STEEPEST));
        Self {
            stiffness_n_per_m: slope * self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: slope * self.dissipation_n_s_mu_per_m,
            map: map.map(|map| (map, slope)),
            ..self
        }
    }

    /// The operator that is rendered.
    ///
    /// # Errors
    /// One that its scheme cannot make.
    pub fn operator<F: Real>(&self) -> Result<Operator<F>, Failure> {
        let (t, horizon) = (Seconds(self.sample_time_s), horizon(self.samples));
        operator(self.model, self.scheme, self.order, t, horizon)
    }

    /// The operator as the analysis has it.
    ///
    /// # Errors
    /// One that its scheme cannot make.
    pub fn loop_operator(&self) -> Result<LoopOperator, Failure> {
        let (t, horizon) = (Seconds(self.sample_time_s), horizon(self.samples));
        loop_operator(self.model, self.scheme, self.order, t, horizon)
    }

    /// Input of the damper over a whole record: the memory of the model, or D^μ x.
    ///
    /// # Errors
    /// An operator that the scheme cannot make.
    pub fn felt(&self, x: &[f64]) -> Result<Vec<f64>, Failure> {
        let t = Seconds(self.sample_time_s);
        match self.model {
            Some(model) => Ok((x.iter().copied())
                .map(memory(model, t, x.len() as u64)?)
                .collect()),
            None => ReferenceWeights::of(self.scheme).full_history(self.order, t, x),
        }
    }

    /// Input of the damper for the samples of a run.
    ///
    /// # Errors
    /// An operator that the scheme cannot make.
    pub fn felt_of(
        &self,
        samples: Samples<'_>,
        before: Before<'_>,
    ) -> Result<ReferenceSeries<'static>, Failure> {
        let (t, planned) = (Seconds(self.sample_time_s), self.samples);
        ReferenceSeries::new(
            samples,
            before,
            |x| self.felt(x),
            || {
                Ok(match self.model {
                    Some(model) => {
                        let mut step = memory(model, t, planned)?;
                        Box::new(move |_, x| step(x))
                    }
                    None => {
                        let kernel = ReferenceWeights::of(self.scheme);
                        let mut channel = reference::operator(kernel, self.order, t, planned)?;
                        Box::new(move |_, x| channel.step(x))
                    }
                })
            },
        )
    }
}

impl Preflight<'_> {
    /// Checks the loop with this device and `line` additional samples of delay, without the proof
    /// for every motion.
    ///
    /// # Errors
    /// A number that the analysis does not accept.
    pub fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        self.looked_at(dynamics, line, false)
    }

    /// Checks the loop and proves results for every motion, which takes longer than all the rest.
    ///
    /// # Errors
    /// A loop that the analysis cannot judge.
    pub fn proved(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        self.looked_at(dynamics, line, true)
    }

    fn looked_at(
        &self,
        dynamics: Dynamics,
        line: usize,
        every_motion: bool,
    ) -> Result<PreflightVerdict, Failure> {
        let operator = self.loop_operator();
        let operator = operator.map_err(|error| bad_input!("pre-flight: {error}"))?;
        self.judge(dynamics, line, &operator, every_motion)
            .map_err(analysed)
    }

    fn judge(
        &self,
        dynamics: Dynamics,
        line: usize,
        operator: &LoopOperator,
        every_motion: bool,
    ) -> Result<PreflightVerdict, AnalysisError> {
        let dynamics = Dynamics {
            delay_s: dynamics.delay_s + line as f64 * self.sample_time_s,
            ..dynamics
        };
        let plant = dynamics.plant(self.sample_time_s)?;
        let wall = dynamics.nondimensional(&SampledWall {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            sample_time_s: self.sample_time_s,
        })?;
        let scaled = |factor: f64| {
            SampledLoop::with_plant(plant, factor * wall.alpha, factor * wall.beta, operator)
                .map(SampledLoop::beside_rest)
        };
        let sampled = scaled(1.0)?;
        let stable = sampled.is_stable();
        let margin = if stable {
            sampled.margins()?.gain_up.map(|edge| edge.value)
        } else {
            softer(|factor| Ok(scaled(factor)?.is_stable()))?
        };
        let contact = every_motion.then(|| sampled.slope_limit().proved);
        let proved = contact.filter(|proved| *proved > 0.0);
        let without_energy = if self.guarded { NO_ENERGY } else { NOT_PROVED };
        let pushing_contact = match self.contact {
            WallContact::Linear => None,
            WallContact::OneSided => Some(without_energy),
            // A constant push moves the map along itself, for which H(1) > 0 is needed.
            WallContact::Signed => {
                let at_rest = wall.alpha + wall.beta * operator.response(0.0).re;
                let holds = at_rest > 0.0 && proved.is_some_and(|proved| proved >= 1.0);
                // A guard takes force away by what was before: no static map, of which alone this is proved.
                let proved = holds && !self.guarded;
                Some(if proved { EVERY_MOTION } else { without_energy })
            }
        };
        let required = dynamics
            .port(self.sample_time_s, operator)?
            .required_delta(wall.alpha, wall.beta)?;
        Ok(PreflightVerdict {
            stable,
            margin,
            pulling_contact_margin: proved,
            pulling_contact_depth_m: (proved.zip(self.map))
                .map(|(proved, (map, slope))| map.depth_of_slope(proved * slope)),
            pushing_contact,
            passive: required.passive(wall.delta),
            required_delta: (!required.negative_at_rest).then_some(required.delta),
            delta: wall.delta,
            delay_samples: plant.path().delay_samples(),
            delay_s: dynamics.delay_s,
            current_lag_s: dynamics.current_lag_s,
            alpha: wall.alpha,
            beta: wall.beta,
            coupler: None,
            robot: None,
        })
    }
}

/// The largest factor below 1 known to be stable, to three digits and rounded down; `None` if a millionth is
/// not.
///
/// # Errors
/// Those of the question.
pub fn softer(
    stable: impl Fn(f64) -> Result<bool, AnalysisError>,
) -> Result<Option<f64>, AnalysisError> {
    let (mut good, mut bad) = (0.5, 1.0);
    while !stable(good)? {
        bad = good;
        good *= 0.5;
        if good < 1e-6 {
            return Ok(None);
        }
    }
    while bad - good > 1e-3 * good {
        let middle = 0.5 * (good + bad);
        if stable(middle)? {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(Some(good))
}

#[cfg(test)]
mod tests {
    //! Margins against closed forms, and what is said of a loop.
    use testkit::Tested;

    use crate::preflight::*;
    use haptic_trial::preflight::{delay_samples, note_findings};
    use std::collections::BTreeMap;

    /// The dissertation's device.
    const TESTBED: Dynamics = Dynamics::ideal(0.065, 3.5);

    fn wall(order: f64, stiffness: f64, dissipation: f64) -> Preflight<'static> {
        Preflight {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: Order::new(order).expect("in range"),
            model: None,
            scheme: Scheme::Exact,
            sample_time_s: 1e-3,
            samples: 5000,
            map: None,
            contact: WallContact::Linear,
            guarded: false,
        }
    }

    #[test]
    fn a_damper_has_the_margin_of_its_closed_form() -> Tested {
        // Without damping of the device: α < 2β(2 − β)/(2 + β), 2/3 at β = 1.
        let device = Dynamics {
            damping_n_s_per_m: 0.0,
            mass_kg: 1.0,
            ..TESTBED
        };
        let at = |factor: f64| wall(1.0, factor * 0.6e6, factor * 1e3);
        let verdict = at(1.0).verdict(device, 0)?;
        assert!(verdict.stable && !verdict.passive, "{verdict:?}");
        // 0.6g = 2g(2 − g)/(2 + g)  ⇔  1.2 + 0.6g = 4 − 2g.
        let edge = 2.8 / 2.6;
        let margin = verdict.margin.expect("a margin");
        assert!((margin - edge).abs() < 1e-6, "{margin}");
        // Theorem 1 at μ = 1: δ > α/2 + β.
        let required = verdict.required_delta.expect("some");
        assert!((required - 1.3).abs() < 1e-9, "{required}");
        // An unstable one is told how much softer it has to be.
        let verdict = at(2.0).verdict(device, 0)?;
        let margin = verdict.margin.expect("a margin");
        assert!(!verdict.stable);
        assert!(margin <= 0.5 * edge && margin > 0.499 * edge, "{margin}");
        let refused = verdict.require_stable(false).expect_err("refused");
        assert!(matches!(refused, Failure::Input(_)));
        let text = refused.to_string();
        let words = "alpha 1.2000 | beta 2.0000 | delta 0.0000 | delay 0 samples | margin 0.538 | softer K | less B";
        for part in words.split(" | ").chain(["`force_unstable`"]) {
            assert!(text.contains(part), "\"{part}\" in {text}");
        }
        verdict.require_stable(true)?;
        for (guarded, words) in [(false, "it runs anyway"), (true, "only the guard")] {
            let warning = verdict.warning(guarded).expect("a warning");
            let is_named = ["unstable", words]
                .iter()
                .all(|word| warning.contains(word));
            assert!(is_named, "{warning}");
        }
        Ok(())
    }

    #[test]
    fn delay_makes_a_stable_wall_unstable() {
        let wall = wall(0.5, 3000.0, 30.0);
        assert!(wall.verdict(TESTBED, 0).expect("judges").stable);
        assert!(!wall.verdict(TESTBED, 20).expect("judges").stable);
    }

    #[test]
    fn delay_and_current_lag_of_the_device_count_as_they_are() {
        let wall = wall(1.0, 12e3, 15.0);
        let late = |delay_s: f64, current_lag_s: f64| {
            let device = Dynamics {
                delay_s,
                current_lag_s,
                ..TESTBED
            };
            wall.verdict(device, 0).expect("judges")
        };
        let margin = |delay, lag| late(delay, lag).margin.expect("a margin");
        // Between whole samples the margin is between theirs, and a lag costs too.
        let (none, half, one) = (margin(0.0, 0.0), margin(0.5e-3, 0.0), margin(1e-3, 0.0));
        assert!(none > half && half > one, "{none} {half} {one}");
        assert!(margin(0.0, 0.5e-3) < none);
        let verdict = late(1.3e-3, 1.5e-3);
        assert!(!verdict.stable, "{verdict:?}");
        let words = verdict.line();
        assert!(
            words.contains("delay 1.3 samples, current lag 1.5 ms"),
            "{words}"
        );
        // Samples of the line come on top.
        let verdict = wall.verdict(TESTBED, 2).expect("judges");
        assert_eq!(verdict.delay_samples.to_string(), "2");
    }

    #[test]
    fn a_soft_and_plain_wall_is_passive_and_nothing_is_said() {
        let verdict = wall(1.0, 100.0, 0.5).verdict(TESTBED, 0).expect("judges");
        assert!(verdict.stable && verdict.passive, "{verdict:?}");
        assert_eq!(verdict.warning(false), None);
        let mut metadata = BTreeMap::new();
        note_findings(&mut metadata, "preflight", &verdict);
        assert_eq!(metadata["preflight.stable"], "true");
        assert_eq!(metadata["preflight.delay_samples"], "0");
    }

    #[test]
    fn the_operator_that_runs_is_judged_and_not_the_ideal_one() {
        // Order 1.5 by A₃ is a negative spring at rest, (1−μ)(3−μ)/3 = −1/4.
        let ideal = wall(1.5, 10.0, 1.0);
        let short = Preflight {
            scheme: Scheme::Muir { degree: 3 },
            ..ideal
        };
        assert!(ideal.verdict(TESTBED, 0).expect("judges").stable);
        let verdict = short.verdict(TESTBED, 0).expect("judges");
        assert_eq!((verdict.stable, verdict.required_delta), (false, None));
    }

    #[test]
    fn a_tissue_without_a_spring_drifts_and_is_stable() -> Tested {
        let tissue = |dissipation: f64| Preflight {
            scheme: "full".parse().expect("a scheme"),
            ..wall(0.2247, 0.0, dissipation)
        };
        let verdict = tissue(174.0).verdict(TESTBED, 0)?;
        assert!(verdict.stable, "{verdict:?}");
        // These left a negative spring at rest once.
        for order in [0.35, 0.4, 0.45, 0.7, 0.8] {
            for scheme in ["full", "piecewise-linear", "exact"] {
                let tissue = Preflight {
                    scheme: scheme.parse()?,
                    ..wall(order, 0.0, 20.0)
                };
                let verdict = tissue.verdict(TESTBED, 0)?;
                assert!(verdict.stable, "{scheme} {order}: {verdict:?}");
                assert!(
                    verdict.required_delta.is_some(),
                    "{scheme} {order}: {verdict:?}"
                );
            }
        }
        assert!(
            verdict.margin.is_some_and(|factor| factor > 10.0),
            "{verdict:?}"
        );
        // One that shakes is still told.
        let verdict = tissue(1e6).verdict(TESTBED, 0)?;
        assert!(!verdict.stable && verdict.margin.is_some(), "{verdict:?}");
        Ok(())
    }

    /// The wall of a public report: stable with a margin of 1.5, and a hit at 0.5 m/s grows to 1 kN behind the clamp f ≥ 0.
    #[test]
    fn of_contact_that_never_pulls_only_what_is_proved_is_said() {
        let device = Dynamics {
            mass_kg: 0.065,
            damping_n_s_per_m: 0.2,
            hand_stiffness_n_per_m: 1000.0,
            delay_s: 1e-3,
            current_lag_s: 0.0,
        };
        let full = Preflight {
            scheme: "full".parse().expect("a scheme"),
            ..wall(1.0, 6000.0, 18.0)
        };
        let verdict_of = |contact, guarded, factor: f64, device| {
            let wall = Preflight {
                contact,
                guarded,
                stiffness_n_per_m: factor * full.stiffness_n_per_m,
                dissipation_n_s_mu_per_m: factor * full.dissipation_n_s_mu_per_m,
                ..full
            };
            wall.proved(device, 0).expect("judges")
        };
        use WallContact::{Linear, OneSided, Signed};
        for (contact, guarded, factor, proof) in [
            (Linear, false, 1.0, None),
            (OneSided, false, 1.0, Some(NOT_PROVED)),
            (OneSided, false, 0.1, Some(NOT_PROVED)),
            (OneSided, true, 1.0, Some(NO_ENERGY)),
            (Signed, false, 1.0, Some(EVERY_MOTION)),
            (Signed, false, 1.6, Some(NOT_PROVED)),
            (Signed, true, 1.6, Some(NO_ENERGY)),
        ] {
            let verdict = verdict_of(contact, guarded, factor, device);
            assert_eq!(verdict.pushing_contact, proof, "{contact:?} {factor}");
            let margin = verdict.pulling_contact_margin.expect("a margin");
            assert!((1.5..1.51).contains(&(margin * factor)), "{margin}");
            let words = verdict.line();
            assert!(words.contains("contact that may pull"), "{words}");
            assert_eq!(
                proof.is_some(),
                words.contains("only pushes is "),
                "{words}"
            );
        }
        // A free device without damping has a double pole, which the certificate does not cover.
        let free = Dynamics {
            damping_n_s_per_m: 0.0,
            hand_stiffness_n_per_m: 0.0,
            ..device
        };
        let verdict = verdict_of(Signed, false, 0.5, free);
        assert_eq!(verdict.pushing_contact, Some(NOT_PROVED));
    }

    #[test]
    fn delays_are_rounded_up() {
        assert_eq!(delay_samples(0, 1e-3), 1);
        assert_eq!(delay_samples(300, 1e-3), 2);
        assert_eq!(delay_samples(2100, 1e-3), 4);
    }
}
