//! The stiffest virtual coupler of each order, for a device with its hand.
//!
//! ```text
//! Z_c = k_c + b_c·(T/(1 − w))^μ,    least damping by a criterion b(k_c, b_c), in proportion to both
//! b_c = b / b(r, 1),  k_c = r·b_c   for the ratio r = k_c/b_c that makes b_c largest
//! ```
//! The damper part `k_c` can lower what the spring part `b_c` needs, so the ratio is searched: 0, and
//! 200 ratios over six decades around the T^μ at which the two are alike, then golden sections around
//! the best. Compared by the stiffness that is felt at a frequency, `|jω·Z_c(jω)|`. For μ > 1 no damping
//! makes the port passive. Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 5.14–5.20.
//!
//! - *Two criteria*: Llewellyn's, of the dissertation, and that of the sampled port, which asks for four times the damping and more but
//!   holds for every hand and object, see [`Coupler::sampled_damping`].
//! - *Llewellyn is not enough* for a sampled device. So the loop that really runs, of this device, its hand and an object, must be stable
//!   too, also with a coupler twice as large: where it is not, both parts are made smaller by the share that is left.
//! - *The operator* is the one that runs: of order 1 − μ, on the deflection of the coupler.

use crate::bench::{AskedDevice, for_each_order, minimum_of};
use crate::design::answer::keys;
use crate::design::nothing_found;
use crate::design::search::{Tried, best, plan};
use fracdiff::{Order, Scheme};
use haptic_analysis::{
    AnalysisError, CoupledLoop, CoupledObject, Coupler, CouplerOperator, ForcePath, LeastDamping,
    LoopOperator,
};
use haptic_document::Failure;
use haptic_document::parameters::{COUPLER_DAMPING, COUPLER_SPRING};
use haptic_judge::coupler::CouplerTrial;
use haptic_judge::coupler::{COUPLER_ORDER, OBJECT_DAMPING, OBJECT_MASS, OBJECT_STIFFNESS};
use haptic_judge::preflight::softer;
use haptic_judge::settling::Settling;
use haptic_judge::setup::TrialSetup;
use haptic_judge::trial::TrialPlan;
use haptic_loop::plant::MassDamperConfig;
use haptic_trial::Sensors;
use haptic_trial::device_table::dynamics;
use serde::Serialize;
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

/// Share of the largest coupler that is taken: the criterion is met with equality otherwise, and the operator of a longer run is
/// another one within its tolerance.
const INSIDE: f64 = 1.0 - 1e-4;
const RATIOS: u32 = 200;
/// Gain margin of the sampled loop.
const LOOP_MARGIN: f64 = 2.0;

/// The stiffest coupler of an order.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CouplerCandidate {
    /// μ, 0 to 1.
    pub order: f64,
    /// `k_c`, N·s/m; null if no coupler of this order is passive.
    pub coupler_damping_n_s_per_m: Option<f64>,
    /// `b_c`, N·s^(1−μ)/m.
    pub coupler_spring_n_s_1_minus_mu_per_m: Option<f64>,
    /// The device's damping divided by what the criterion requires for the coupler: a little above
    /// 1, or more if the coupler was made smaller.
    pub margin: Option<f64>,
    /// `|jω·Z_c(jω)|` at the frequency, N/m.
    pub felt_stiffness_n_per_m: Option<f64>,
    /// Share of the largest coupler by the criterion that leaves the sampled loop stable with a
    /// gain margin of 2; 1 if the whole coupler does.
    pub share: Option<f64>,
    /// Factor on both parts of the coupler at which the sampled loop becomes unstable; null if none
    /// does.
    pub loop_margin: Option<f64>,
    /// Damping with which the sampled device is passive with every hand and object, N·s/m; null if none is enough.
    pub sampled_damping_n_s_per_m: Option<f64>,
    /// Reason if no coupler was found, or if it did not pass its trial.
    pub reason: Option<String>,
}

/// The criterion that a coupler fulfils for every passive hand and object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CouplerCriterion {
    /// Llewellyn's, for the dissertation's device under Tustin's rule.
    Llewellyn,
    /// Passivity of the port that is really sampled.
    Passive,
}

impl CouplerCriterion {
    /// Name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Llewellyn => "llewellyn",
            Self::Passive => "passive",
        }
    }
}

/// A question for couplers: on which device, before which object, by which criterion.
#[derive(Clone, Debug)]
pub struct CouplerDesign {
    /// The device and its hand, assumed ideal.
    pub device: MassDamperConfig,
    /// The object behind the coupler.
    pub object: CoupledObject,
    /// Numerical scheme of the operator.
    pub scheme: Scheme,
    /// Grid of orders, 0 to 1.
    pub orders: Vec<Order>,
    /// Criterion that the coupler meets.
    pub criterion: CouplerCriterion,
    /// Frequency at which couplers are compared, Hz.
    pub frequency_hz: f64,
}

impl CouplerDesign {
    /// The object of an experiment file that names none.
    pub const OBJECT: CoupledObject = CoupledObject {
        mass_kg: OBJECT_MASS.default_number(),
        damping_n_s_per_m: OBJECT_DAMPING.default_number(),
        stiffness_n_per_m: OBJECT_STIFFNESS.default_number(),
    };

    fn candidates(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<CouplerCandidate>, Failure> {
        for_each_order(&self.orders, stop, progress, |order| {
            self.stiffest(order).map_err(Failure::input)
        })
    }

    /// The stiffest coupler of an order.
    fn stiffest(&self, order: Order) -> Result<CouplerCandidate, AnalysisError> {
        let (mu, t) = (order.get(), self.device.sample_time);
        let none = |reason: &str| {
            Ok(CouplerCandidate {
                order: mu,
                reason: Some(reason.to_owned()),
                ..CouplerCandidate::default()
            })
        };
        let damping = self.device.damping.0;
        if damping <= 0.0 {
            return none("the device has no damping, so no coupler is passive on it");
        }
        const ACTIVE: &str = "active by itself, whatever the damping";
        if !(0.0..=1.0).contains(&mu) {
            return none(ACTIVE);
        }
        let operator = LoopOperator::new(self.scheme, Order::new(1.0 - mu)?, t, self.horizon())?;
        let runs = CouplerOperator(&operator);
        let coupler = |k_c: f64, b_c: f64| -> Result<Coupler<'_>, AnalysisError> {
            let exact = Coupler::exact(order, t.0, k_c, b_c)?;
            // A finite memory ripples as fast as it is long.
            Ok(exact.with_operator(&runs, operator.memory()))
        };
        let least = |ratio: f64| Ok(self.needed(&coupler(ratio, 1.0)?)?.damping_n_s_per_m());
        let Some(bare) = least(0.0)? else {
            return none(ACTIVE);
        };
        let (ratio, required) = cheapest(bare, libm::pow(t.0, mu), least)?;
        let largest = INSIDE * damping / required;
        let whole = Coupler::exact(order, t.0, ratio * largest, largest)?;
        let closed = CoupledLoop::new(&dynamics(&self.device), &whole, &self.object, &operator)?;
        let Some((share, loop_margin)) = with_margin(&closed)? else {
            return none("no coupler of this order is stable in the sampled loop of this device");
        };
        let (spring, damper) = (share * largest, share * ratio * largest);
        let sampled = coupler(damper, spring)?.sampled_damping(ForcePath::NONE)?;
        // jω·Z_c with (T/(1 − w))^μ ≈ (jω)^(−μ)
        let omega = 2.0 * PI * self.frequency_hz;
        let (angle, size) = (-0.5 * PI * mu, spring * libm::pow(omega, -mu));
        let felt = omega * libm::hypot(damper + size * libm::cos(angle), size * libm::sin(angle));
        Ok(CouplerCandidate {
            order: mu,
            coupler_damping_n_s_per_m: Some(damper),
            coupler_spring_n_s_1_minus_mu_per_m: Some(spring),
            margin: Some(1.0 / (INSIDE * share)),
            felt_stiffness_n_per_m: Some(felt),
            share: Some(share),
            loop_margin,
            sampled_damping_n_s_per_m: sampled.damping_n_s_per_m(),
            reason: None,
        })
    }

    fn needed(&self, coupler: &Coupler<'_>) -> Result<LeastDamping, AnalysisError> {
        match self.criterion {
            CouplerCriterion::Llewellyn => coupler.least_damping(),
            CouplerCriterion::Passive => coupler.sampled_damping(ForcePath::NONE),
        }
    }
}

/// The largest share of a coupler, up to 1, whose loop has the gain margin, and the margin that it has.
fn with_margin(closed: &CoupledLoop<'_>) -> Result<Option<(f64, Option<f64>)>, AnalysisError> {
    let margin = |share: f64| -> Result<Option<Option<f64>>, AnalysisError> {
        let closed = closed.scaled(share);
        if !closed.is_stable() {
            return Ok(None);
        }
        Ok(Some(closed.gain_margin()?.map(|edge| edge.value)))
    };
    let edge = match margin(1.0)? {
        Some(None) => return Ok(Some((1.0, None))),
        Some(Some(edge)) if edge >= LOOP_MARGIN => return Ok(Some((1.0, Some(edge)))),
        Some(Some(edge)) => Some(edge),
        None => softer(|factor| Ok(closed.scaled(factor).is_stable()))?,
    };
    let Some(edge) = edge else {
        return Ok(None);
    };
    let share = INSIDE * edge / LOOP_MARGIN;
    Ok(margin(share)?.map(|margin| (share, margin)))
}

/// The ratio `k_c/b_c` that needs the least damping, and that damping, which is `bare` without `k_c`: on a grid, then by golden
/// sections.
fn cheapest(
    bare: f64,
    scale: f64,
    least: impl Fn(f64) -> Result<Option<f64>, AnalysisError>,
) -> Result<(f64, f64), AnalysisError> {
    let ratio_at = |step: f64| scale * libm::exp10(6.0 * step / f64::from(RATIOS) - 3.0);
    let needed =
        |step: f64| Ok::<f64, AnalysisError>(least(ratio_at(step))?.unwrap_or(f64::INFINITY));
    let mut best = (0.0, bare);
    let mut best_step = None;
    for step in 0..=RATIOS {
        let value = needed(f64::from(step))?;
        if value < best.1 {
            best = (ratio_at(f64::from(step)), value);
            best_step = Some(f64::from(step));
        }
    }
    if let Some(step) = best_step {
        let middle = minimum_of(step - 1.0, step + 1.0, 40, needed)?;
        best = (ratio_at(middle), needed(middle)?);
    }
    Ok(best)
}

/// The stiffest coupler of each order, and a trial of the best. The keys are a contract of the
/// command line.
#[derive(Clone, Debug, Serialize)]
pub struct CouplerAnswer {
    /// Mass, damping, hand and sample time of the device.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// `coupler`.
    pub wish: &'static str,
    /// The criterion by its name, `llewellyn` or `passive`.
    pub require: &'static str,
    /// Frequency at which stiffness is compared, Hz.
    pub frequency_hz: f64,
    /// The operator that was analysed, as documents write it.
    pub scheme: String,
    /// The stiffest coupler of each order.
    pub candidates: Vec<CouplerCandidate>,
    /// The stiffest coupler of all orders, as felt at the frequency; null if no order has one.
    pub best: Option<CouplerCandidate>,
    /// The trial of the best, on the ideal device.
    pub simulated: Option<Settling>,
    /// The experiment that runs it.
    #[serde(skip)]
    pub experiment_text: Option<String>,
}

impl CouplerAnswer {
    /// Refuses a design without a coupler that is stable when it is tried.
    ///
    /// # Errors
    /// No coupler, or one whose trial is not stable.
    pub fn require(&self) -> Result<(), Failure> {
        if self.best.is_none() {
            let mut reasons = self.candidates.iter().filter_map(|c| c.reason.as_deref());
            return Err(nothing_found(reasons.next()));
        }
        Ok(())
    }
}

impl CouplerDesign {
    /// Answers it: candidates, the best of them, its trial and its experiment file; `progress` hears of each order that is done, `stop` ends
    /// it before the next.
    ///
    /// # Errors
    /// A design that was stopped, or a loop that cannot be analysed.
    pub fn answer(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<CouplerAnswer, Failure> {
        let mut candidates = self.candidates(stop, progress)?;
        let found = loop {
            let merit =
                |c: &CouplerCandidate| c.felt_stiffness_n_per_m.filter(|_| c.reason.is_none());
            let merits = candidates.iter().enumerate();
            let Some(index) = best(merits.filter_map(|(index, c)| Some((merit(c)?, index)))) else {
                break None;
            };
            let tried = self.trial(&candidates[index])?;
            if tried.settling.stable {
                break Some((candidates[index].clone(), tried));
            }
            candidates[index].reason = Some(tried.reason());
        };
        let (best, trial) = found.unzip();
        Ok(CouplerAnswer {
            asked: AskedDevice::of(&self.device),
            wish: "coupler",
            require: self.criterion.name(),
            frequency_hz: self.frequency_hz,
            scheme: self.scheme.to_string(),
            candidates,
            best,
            simulated: trial.as_ref().map(|tried| tried.settling),
            experiment_text: trial.map(|tried| self.experiment_file(&tried.experiment)),
        })
    }

    /// Memory of the operator that runs, samples.
    fn horizon(&self) -> f64 {
        let t = self.device.sample_time;
        haptic_trial::samples::horizon((self.plan(1.0).duration_s / t.0) as u64)
    }

    fn plan(&self, stretch: f64) -> TrialPlan {
        let limit = TrialPlan::DEFAULT.force_limit_n;
        plan(self.device.sample_time, limit, stretch)
    }

    fn trial(&self, best: &CouplerCandidate) -> Result<Tried<CouplerTrial>, Failure> {
        let order = Order::new(best.order).map_err(Failure::input)?;
        let make = |stretch| CouplerTrial {
            setup: TrialSetup {
                must_be_stable: true,
                ..TrialSetup::new(self.device, Sensors::NONE, self.plan(stretch))
            },
            order,
            scheme: self.scheme,
            coupler_damping_n_s_per_m: best.coupler_damping_n_s_per_m.unwrap_or(0.0),
            coupler_spring_n_s_1_minus_mu_per_m: best
                .coupler_spring_n_s_1_minus_mu_per_m
                .unwrap_or(0.0),
            object: self.object,
        };
        Tried::of(make, |settling| settling.stable)
    }

    /// The experiment file of a coupler that was tried.
    fn experiment_file(&self, coupler: &CouplerTrial) -> String {
        let head = format!(
            "# Written by host-cli design: coupler, {}, gain margin 2 in the sampled loop.\n\
             # host-cli run FILE tries it; it ends with 0 only if trial and analysis call it stable and Llewellyn's criterion is met.\n\
             [coupler]\n",
            self.criterion.name()
        );
        let law = [
            (COUPLER_ORDER, coupler.order.get()),
            (COUPLER_DAMPING, coupler.coupler_damping_n_s_per_m),
            (COUPLER_SPRING, coupler.coupler_spring_n_s_1_minus_mu_per_m),
            (OBJECT_MASS, coupler.object.mass_kg),
            (OBJECT_DAMPING, coupler.object.damping_n_s_per_m),
            (OBJECT_STIFFNESS, coupler.object.stiffness_n_per_m),
        ];
        head + &keys(&coupler.setup, coupler.scheme, &law)
    }
}

#[cfg(test)]
mod tests {
    use crate::design::coupler::*;
    use crate::one_table::read;
    use fracdiff::Seconds;
    use haptic_judge::coupler::{COUPLER, COUPLER_REQUIRED, coupler};
    use haptic_judge::pushed_trial::PushedTrial as _;
    use haptic_judge::setup::Beside;
    use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
    use testkit::device::dissertation;

    fn design(scheme: &str, criterion: CouplerCriterion, mass: f64, damping: f64) -> CouplerDesign {
        let order = |mu| Order::new(mu).expect("valid");
        CouplerDesign {
            device: MassDamperConfig {
                mass: Kilograms(mass),
                damping: NewtonSecondsPerMetre(damping),
                ..dissertation(Seconds(1e-3))
            },
            object: CouplerDesign::OBJECT,
            scheme: scheme.parse().expect("a scheme"),
            orders: [0.0, 0.5, 0.75, 1.0].map(order).to_vec(),
            criterion,
            frequency_hz: 1.0,
        }
    }

    #[test]
    fn the_designed_coupler_fulfils_its_criterion_and_a_hair_more_does_not() {
        for (scheme, criterion) in [
            ("exact", CouplerCriterion::Llewellyn),
            ("full", CouplerCriterion::Llewellyn),
            ("full", CouplerCriterion::Passive),
        ] {
            let design = design(scheme, criterion, 0.065, 0.7);
            for found in design
                .candidates(&AtomicBool::new(false), &|_| {})
                .expect("valid")
            {
                let mu = found.order;
                let (k, b) = (
                    found.coupler_damping_n_s_per_m.expect("one"),
                    found.coupler_spring_n_s_1_minus_mu_per_m.expect("one"),
                );
                assert_eq!(found.share, Some(1.0), "{found:?}");
                let scheme: Scheme = scheme.parse().expect("a scheme");
                let order = Order::new(1.0 - mu).expect("valid");
                let t = design.device.sample_time;
                let operator = LoopOperator::new(scheme, order, t, design.horizon());
                let operator = operator.expect("valid");
                let runs = CouplerOperator(&operator);
                let passive = |k: f64, b: f64| {
                    let exact = Coupler::exact(Order::new(mu).expect("valid"), t.0, k, b);
                    let coupler = exact.expect("valid").with_operator(&runs, 1);
                    let needed = design.needed(&coupler).expect("valid");
                    needed.damping_n_s_per_m().is_some_and(|b| b <= 0.7)
                };
                assert!(passive(k, b), "{scheme} μ {mu}: {found:?}");
                assert!(
                    !passive(1.0002 * k, 1.0002 * b),
                    "{scheme} μ {mu}: {found:?}"
                );
                // No ratio on a coarse grid of its own does better.
                for decade in -4..=4 {
                    let ratio = 1e-3_f64.powf(mu) * 10f64.powi(decade);
                    assert!(
                        !passive(1.001 * b * ratio, 1.001 * b),
                        "{scheme} μ {mu}, {ratio}"
                    );
                }
            }
        }
    }

    #[test]
    fn where_llewellyn_is_not_enough_the_sampled_loop_has_the_last_word() {
        // 2 g with 3 N·s/m: δ = 1.5, so that a damper of 8b would be 12 units of m/T.
        let mut shrunk = 0;
        for found in design("full", CouplerCriterion::Llewellyn, 2e-3, 3.0)
            .candidates(&AtomicBool::new(false), &|_| {})
            .expect("valid")
        {
            let (share, margin) = (
                found.share.expect("one"),
                found.loop_margin.expect("an edge"),
            );
            assert!(margin >= 2.0 * (1.0 - 1e-3), "{found:?}");
            shrunk += u32::from(share < 1.0);
        }
        assert!(shrunk > 0, "none was too strong");
        // Passive as sampled needs no such help.
        for found in design("full", CouplerCriterion::Passive, 2e-3, 3.0)
            .candidates(&AtomicBool::new(false), &|_| {})
            .expect("valid")
        {
            assert!(
                found.sampled_damping_n_s_per_m.is_some_and(|b| b <= 3.0),
                "{found:?}"
            );
        }
    }

    #[test]
    fn above_order_one_and_without_damping_there_is_none() {
        for (mu, damping) in [(1.5, 1.0), (0.5, 0.0)] {
            let mut design = design("full", CouplerCriterion::Llewellyn, 0.065, damping);
            design.orders = vec![Order::new(mu).expect("valid")];
            let answer = design
                .answer(&AtomicBool::new(false), &|_| {})
                .expect("valid");
            let found = &answer.candidates[0];
            assert!(
                found.coupler_spring_n_s_1_minus_mu_per_m.is_none() && found.reason.is_some(),
                "{found:?}"
            );
            assert!(answer.best.is_none() && answer.experiment_text.is_none());
        }
    }

    #[test]
    fn the_written_experiment_is_the_one_that_was_tried() {
        for (criterion, mass) in [
            (CouplerCriterion::Llewellyn, 0.065),
            (CouplerCriterion::Llewellyn, 2e-3),
            (CouplerCriterion::Passive, 0.065),
        ] {
            let design = design("full", criterion, mass, 3.0);
            let answer = design
                .answer(&AtomicBool::new(false), &|_| {})
                .expect("valid");
            let text = answer.experiment_text.expect("a best one");
            let keys = [("required", COUPLER_REQUIRED), ("coupler", COUPLER)];
            let coupler = read(&text, ("coupler", &keys), |table| {
                coupler(table, Beside::default(), [None, None])
            });
            let settling = coupler.settled().expect("valid");
            assert_eq!(Some(settling), answer.simulated, "{text}");
            assert!(settling.stable, "{settling:?}");
            let samples = coupler.parts().expect("valid").samples;
            let verdict = coupler.judge(samples, coupler.setup.dynamics(), 0);
            let verdict = verdict.expect("valid");
            let llewellyn = verdict.coupler.is_some_and(|coupler| coupler.llewellyn);
            assert!(verdict.stable && llewellyn, "{verdict:?}");
            let passive = criterion == CouplerCriterion::Passive;
            assert!(verdict.passive || !passive, "{verdict:?}");
        }
    }
}
