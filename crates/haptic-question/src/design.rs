//! The designer's question: what is the most that a device can render, and with which order μ?
//!
//! For each order of a grid the best wall under a requirement is computed, not searched by trying:
//!
//! ```text
//! stable    (gα, gβ) on the boundary of the stability region, so that the wall as a whole may grow by
//!           the gain margin g before it is unstable, or shrink by it; the region by D-decomposition
//! passive   δ > sup_θ (α·u + β·v), Theorem 1 for the operator really used. The right side grows in
//!           proportion to the wall, so α = δ/sup(u + t·v) for a given t = β/α, and that sup is convex
//!           in t: its minimum by golden sections gives the largest α, and the same with roles
//!           exchanged the largest β
//! ```
//! - *Every motion*: the first such wall that is proved; a specimen may grow as far as that.
//! - *Stiffest wall*: the largest α, with the β that allows it.
//! - *Most damping* at ω: the largest β, since the effective damping Im H/ω grows with B alone. The
//!   very largest β leaves no choice of α, and at α = 0 the device creeps away. So β is 99 % of it, and
//!   α is in the middle of what that leaves.
//! - *Tissue*: K, B and μ are given by tissue and specimen; the question is by which factor the
//!   specimen may grow. For other orders K is the same, and B makes |B·s^μ| the same at a frequency.
//!
//! - *Controller*: likewise, from position to force; no other orders stand beside it. It has to bear the margin in both directions.
//! - *Noise*: steps q of the encoder make a noise of the force, rms B·(q/√12)·T^(−μ)·√Σc², c the weights
//!   of the operator. A limit on it is a limit on B for the strongest wall of an order; its trials have the last word.
//! - *The device* is the one on the desk: delay and current lag are in the analysis, friction and encoder in
//!   the trial. If none is given an ideal device is assumed, and the trial on a realistic one stands beside.
//!
//! A wall "on the boundary" is made a ten-thousandth weaker, because Theorem 1 is strict.

mod answer;
mod bench;
#[cfg(test)]
mod campaign_tests;
pub mod coupler;
pub mod front;
pub mod reading;
mod search;

use crate::analysis::ANALYSED_CONTROLLER;
use crate::bench::{AskedDevice, BenchDevice, check_orders};
use fracdiff::parameter::Shown;
use fracdiff::{Order, Scheme};
use haptic_document::Warn;
use haptic_document::parameters::range::Range;
use haptic_document::parameters::{DEVICE_MODEL, ENCODER_RESOLUTION, SCHEME, UNNAMED_PIECE, range};
use haptic_document::parameters::{Parameter, Paths, joined};
use haptic_document::{Failure, named, parameters};
use haptic_judge::modelled_tissue::ModelledTissue;
use haptic_judge::position_controller::PositionController;
use haptic_judge::preflight::WallContact;
use haptic_judge::settling::Settling;
use haptic_loop::plant::MassDamper;
use haptic_quantity::{digits, in_five_digits};
use haptic_tissue::Model;
use haptic_trial::Imperfections;
use haptic_trial::advice::parameter;
use haptic_trial::device_table::dynamics;
use haptic_trial::keys::wall::{ONE_SIDED, WALL_CONTACT};
use serde::Serialize;

parameters! {
    pub mod keys;
    WISH = text("wish", "stiffest-wall", "What to optimise");
    WISH_TISSUE = file("tissue", "", Paths::Toml, None, "Tissue for that wish: a name from `host-cli materials list`, or a TOML file");
    /// Frequency of a design, Hz.
    WISH_FREQUENCY = optional("frequency_hz", range::FREQUENCIES_HZ,
        "Frequency for most-damping, and to compare walls of a front or the orders of a tissue or coupler [default there: 1 Hz]");
    /// Condition that a wall must meet.
    REQUIRE = text("require", "stable", "Condition that the wall must meet");
    /// Gain margin of a design.
    GAIN_MARGIN = number("gain_margin", 2.0, "2", Range::AboveUpTo(1.0, 1e3),
        "Factor by which a stable wall could grow before it is unstable");
    DESIGN_ORDERS = list_of("orders", "0,0.25,0.5,0.75,1,1.25,1.5,1.75,2", range::WALL_ORDERS, "Orders to try, 0 to 2; if not given, finer ones around the best wall too");
    FRONT = flag("front", "All walls that none beats in stiffness, damping, gain margin and force noise at once, in place of the best of a wish; nothing is tried");
    /// Limit on the noise of the force, N.
    FORCE_NOISE_LIMIT = optional("force_noise_limit_n", range::FORCES_ABOVE_0,
        "Largest rms force noise from encoder steps and sensor noise, in all trials [default: 5 % of the push, any for a tissue]");
}

/// Halvings of the steps beside the best order: of a quarter to a hundredth.
const HALVINGS: usize = 5;

/// Frequency at which the orders of a tissue or coupler are compared where none is given, Hz.
pub const COMPARED_AT_HZ: f64 = 1.0;

/// Keys of `[design]`, beside those of the device of a question.
pub const DESIGN: &[Parameter] = &joined::<19>(&[
    &[WISH, WISH_TISSUE, ANALYSED_CONTROLLER],
    UNNAMED_PIECE,
    &[FRONT, WISH_FREQUENCY, REQUIRE, GAIN_MARGIN, DESIGN_ORDERS],
    &[SCHEME, FORCE_NOISE_LIMIT, ONE_SIDED, WALL_CONTACT],
]);

/// The wish of a designer by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DesignWish {
    /// The largest stiffness.
    StiffestWall,
    /// The largest effective damping at a frequency.
    MostDamping,
    /// A specimen of a tissue.
    Tissue,
    /// A controller from position to force.
    Controller,
    /// The coupler that feels stiffest.
    Coupler,
}

named! { DesignWish:
    StiffestWall = "stiffest-wall", "The largest stiffness";
    MostDamping = "most-damping", "The largest effective damping at a frequency";
    Tissue = "tissue", "A specimen of a tissue: does it fit, and how large may it be";
    Controller = "controller", "A controller: how far may its gain grow";
    Coupler = "coupler", "The virtual coupler that feels stiffest at a frequency";
}

/// Condition that a wall or coupler must meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequireName {
    /// Stable with a gain margin.
    Stable,
    /// Proved for every motion, too.
    EveryMotion,
    /// Passive by Theorem 1.
    Passive,
}

named! { RequireName:
    Stable = "stable", "Stable with a gain margin; a coupler passes Llewellyn's criterion too";
    EveryMotion = "every-motion", "The same, and proved for every motion: of contact that may pull, or of what runs with contact = \"signed\"; not for couplers";
    Passive = "passive", "Passive, for the operator that really runs";
}

/// The wish of a designer, with its numbers.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one of them in a run")]
pub enum WallWish {
    /// The largest stiffness.
    StiffestWall,
    /// The largest effective damping of the wall at a frequency.
    MostDamping {
        /// Frequency at which the damping Im H/ω is compared, Hz.
        frequency_hz: f64,
    },
    /// A specimen of a tissue.
    Tissue {
        /// The tissue as a law.
        material: ModelledTissue,
        /// γ of the piece of it.
        shape_m: f64,
        /// Frequency at which other orders are made equal to it, Hz.
        frequency_hz: f64,
    },
    /// A controller from the position to the force.
    Controller(Box<PositionController>),
}

/// A question of a designer.
#[derive(Clone, Debug)]
pub struct WallDesign {
    /// Device and hand, with the imperfections that its trials have.
    pub device: BenchDevice,
    /// Numerical scheme of the operator.
    pub scheme: Scheme,
    /// Grid of orders, 0 to 2.
    pub orders: Vec<Order>,
    /// True if finer orders around the best are tried next.
    pub finer: bool,
    /// Factor by which stiffness and dissipation may grow with the wall still stable; `None`
    /// requires passivity by Theorem 1 for the operator really used.
    pub gain_margin: Option<f64>,
    /// True if a proof for every motion of contact that may pull is required too.
    pub every_motion: bool,
    /// Contact of the wall with the hand.
    pub contact: WallContact,
    /// The quantity that is to be as large as it may.
    pub wish: WallWish,
    /// Largest force noise that encoder and sensor may cause, rms N; `None` allows 5 % of the push, of a tissue any.
    pub force_noise_limit_n: Option<f64>,
}

impl WallDesign {
    /// The tissue's own order, then those of the grid.
    pub fn orders_to_try(&self) -> Vec<Order> {
        let mut orders = self.orders.clone();
        if let WallWish::Tissue { material, .. } = &self.wish {
            orders.retain(|order| *order != material.order());
            orders.insert(0, material.order());
        }
        orders
    }

    /// Number of times that the steps beside the best order are halved.
    const fn halvings(&self) -> usize {
        if self.finer { HALVINGS } else { 0 }
    }

    /// Largest number of orders tried.
    pub fn steps(&self) -> usize {
        self.orders_to_try().len() + 2 * self.halvings()
    }

    /// The model whose memory is the operator of this order; `None` for D^μ.
    fn model(&self, order: Order) -> Option<&Model> {
        let WallWish::Tissue { material, .. } = &self.wish else {
            return None;
        };
        material.composed().filter(|_| material.order() == order)
    }

    fn check(&self) -> Result<(), Failure> {
        let BenchDevice { plant, sensors, .. } = &self.device;
        (dynamics(plant).plant(plant.sample_time.0)).map_err(Failure::input)?;
        // The device on which the best is tried.
        MassDamper::<1>::new(*plant).map_err(parameter)?;
        check_orders(&self.orders, &DESIGN_ORDERS)?;
        if let Some(limit) = self.force_noise_limit_n
            && sensors.are_ideal()
        {
            return Err(Failure::bad_input(format_args!(
                "limit {} N on force noise has no effect without encoder steps or sensor noise: give {ENCODER_RESOLUTION}",
                Shown(limit)
            )));
        }
        let highest = 0.5 / plant.sample_time.0;
        match self.wish.frequency_hz() {
            Some(f) if !(f > 0.0 && f <= highest) => Err(Failure::bad_input(format_args!(
                "frequency {} Hz is not in (0, {}] Hz, up to half the sample rate: give {WISH_FREQUENCY}",
                Shown(f),
                Shown(highest)
            ))),
            Some(_) | None => Ok(()),
        }
    }
}

impl WallWish {
    fn name(&self) -> &'static str {
        match self {
            Self::StiffestWall => "stiffest-wall",
            Self::MostDamping { .. } => "most-damping",
            Self::Tissue { .. } => "tissue",
            Self::Controller(_) => "controller",
        }
    }

    fn controller(&self) -> Option<&PositionController> {
        match self {
            Self::Controller(controller) => Some(controller),
            Self::StiffestWall | Self::MostDamping { .. } | Self::Tissue { .. } => None,
        }
    }

    /// True if the law is given, which fits or does not.
    const fn is_given(&self) -> bool {
        matches!(self, Self::Tissue { .. } | Self::Controller(_))
    }

    fn frequency_hz(&self) -> Option<f64> {
        match self {
            Self::StiffestWall | Self::Controller(_) => None,
            Self::MostDamping { frequency_hz } | Self::Tissue { frequency_hz, .. } => {
                Some(*frequency_hz)
            }
        }
    }
}

/// A design without a candidate.
fn nothing_found(why: Option<&str>) -> Failure {
    Failure::run(format_args!(
        "no candidate meets the wish: {}; ask for less, or choose other {DESIGN_ORDERS} or another device",
        why.unwrap_or("nothing does it")
    ))
}

impl DesignReport {
    /// The verdict on a controller, in words.
    pub fn of_controller(&self) -> String {
        self.controller.as_ref().map_or_else(String::new, |found| {
            let fits = match (found.fits, &self.best) {
                (true, _) => "fits",
                (false, Some(_)) => "fits an ideal device only",
                (false, None) => "does not fit",
            };
            let scale = found.largest_scale.map_or_else(
                || "no scale of it does".to_owned(),
                |scale| format!("up to {} times the gain", digits(scale, 4)),
            );
            format!("{}: {fits}, {scale}", in_five_digits(&found.law))
        })
    }

    /// Refuses a design without a candidate that passes its trial. One that only an ideal device bears is warned of, and one of which
    /// little is proved.
    ///
    /// # Errors
    /// No wall, or a best one that is not stable in its trial.
    pub fn require(&self, warn: Warn<'_>) -> Result<(), Failure> {
        if let Some(real) = self.realistic.filter(|real| !real.simulated.stable) {
            warn(&format!(
                "this is for an ideal device; on one with {} it is {}: give {DEVICE_MODEL}, or the device's own values",
                real.imperfections.words(),
                real.simulated.verdict.words()
            ));
        }
        if self.best.is_none()
            && let Some(controller) = &self.controller
        {
            let why = self.notes.last().map_or("", String::as_str);
            return Err(Failure::run(format_args!(
                "{} does not fit: {why}; change {ANALYSED_CONTROLLER}, what is asked of it, or the device",
                in_five_digits(&controller.law)
            )));
        }
        let Some(best) = &self.best else {
            return Err(nothing_found(self.notes.last().map(String::as_str)));
        };
        let pulling = best.pulling_contact_margin.unwrap_or(0.0);
        if self.contact == WallContact::OneSided && pulling < 1.0 {
            warn(&format!(
                "contact that is lost and found again is proved up to {pulling:.2} of this wall alone, even if it may pull: \
                 hits other than those tried may grow; {} is proved",
                WALL_CONTACT.set_to("signed")
            ));
        }
        Ok(())
    }
}

/// The best wall of one order.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Candidate {
    /// The order μ that was tried; null of a controller, which has its own.
    pub order: Option<f64>,
    /// K; null if no wall was found.
    pub stiffness_n_per_m: Option<f64>,
    /// B; null if no wall was found.
    pub dissipation_n_s_mu_per_m: Option<f64>,
    /// Factor by which the wall as a whole may grow until it is unstable (below 1: must shrink).
    pub margin: Option<f64>,
    /// Factor up to which it is proved stable for every motion of contact that may pull, acts on one side or stiffens, while that is
    /// nowhere steeper; null if nothing is proved.
    pub pulling_contact_margin: Option<f64>,
    /// K·T²/m, by which walls of any device compare.
    pub alpha: Option<f64>,
    /// B·T^(2−μ)/m.
    pub beta: Option<f64>,
    /// True if it is passive by Theorem 1.
    pub passive: Option<bool>,
    /// The device damping that passivity requires, N·s/m.
    pub required_damping_n_s_per_m: Option<f64>,
    /// Im H/ω at the wish's frequency, N·s/m.
    pub effective_damping_n_s_per_m: Option<f64>,
    /// Force noise that encoder steps and sensor noise cause through B, rms N; null for ideal
    /// sensors.
    pub force_noise_rms_n: Option<f64>,
    /// Largest standard deviation of the force in the last 10 s of all its trials, N; null if it was not tried, or with ideal sensors.
    /// Steps of an encoder that the loop keeps alive make more of it than even noise does.
    pub tried_force_noise_rms_n: Option<f64>,
    /// Factor by which the specimen of a tissue or the gain of a controller may grow under the requirement; below 1 it is too
    /// large.
    pub largest_scale: Option<f64>,
    /// Why it will not do.
    pub reason: Option<String>,
}

/// The best candidate on a realistic device. Keys of the report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RealisticTrial {
    /// Imperfections that were assumed: friction, delay, current lag and sensors.
    #[serde(flatten)]
    pub imperfections: Imperfections,
    /// True if the analysis, which knows delay and current lag, calls it stable.
    pub analysis_stable: bool,
    /// Factor by which the wall may grow until it is unstable (below 1: must shrink); null if no factor does.
    pub margin: Option<f64>,
    /// Force noise that the encoder causes, rms N.
    pub force_noise_rms_n: Option<f64>,
    /// Trial of the best candidate with all of these imperfections.
    pub simulated: Settling,
}

/// The best wall without a limit on its noise that nobody asked for. Keys of the report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noisier {
    /// Order μ of its dissipation.
    pub order: f64,
    /// K of the wall, N/m.
    pub stiffness_n_per_m: f64,
    /// B of the wall, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// Largest of its trials, rms N.
    pub tried_force_noise_rms_n: Option<f64>,
}

/// Verdict on a tissue that is to be rendered as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TissueVerdict {
    /// Name of the tissue, as its file gives it.
    pub name: String,
    /// Order of its memory, which is tried before those of the grid.
    pub order: f64,
    /// True if the specimen meets the requirement and passes its trials, that on a realistic device too.
    pub fits: bool,
    /// Factor by which the specimen may grow.
    pub largest_scale: Option<f64>,
}

/// Verdict on a controller that is to be rendered as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControllerVerdict {
    /// The controller in words, with its gains as given.
    pub law: String,
    /// True as for a tissue.
    pub fits: bool,
    /// Factor by which its gain may grow.
    pub largest_scale: Option<f64>,
    /// The factor below which it is unstable by the analysis, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysis_scale_from: Option<f64>,
    /// The controller with that gain.
    pub largest: Option<String>,
}

/// The answer. The keys are a contract of the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignReport {
    /// Mass, damping, hand and sample time of the device.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// Imperfections of the device, as far as they were given.
    pub imperfections: Imperfections,
    /// True if the device is ideal, that is without friction, delay, current lag or encoder steps.
    pub ideal_device_assumed: bool,
    /// The wish, named as in the document, for example `stiffest-wall`.
    pub wish: &'static str,
    /// The requirement, named as in the document, for example `every-motion`.
    pub require: &'static str,
    /// The requirement in words, with its numbers.
    #[serde(skip)]
    pub requirement: String,
    /// The factor by which the wall may grow; null if only passivity was required.
    pub gain_margin: Option<f64>,
    /// The frequency at which orders were compared, Hz; null if the wish has none.
    pub frequency_hz: Option<f64>,
    /// The operator that was analysed, as documents write it.
    pub scheme: String,
    /// Contact of the wall with the hand: a one-sided wall is accepted only if it settles after each of six hits, a signed one only if it is
    /// proved.
    pub contact: WallContact,
    /// Limit on the noise of the force, rms N, by default 5 % of the push; null for ideal sensors and tissues.
    pub force_noise_limit_n: Option<f64>,
    /// The trials that the best wall passed, in words, with the worst noise.
    pub trials: Option<String>,
    /// Time until a passive wall that rings is at rest, s; null if it is as soon as any other.
    pub rings_s: Option<f64>,
    /// The best wall without the limit on noise, if nobody asked for that; null if it is no better.
    pub noisier: Option<Noisier>,
    /// One candidate for each order tried, with the reason where no wall was found.
    pub candidates: Vec<Candidate>,
    /// The candidate that meets the wish best; null if none does.
    pub best: Option<Candidate>,
    /// Verdict on the tissue that was asked for.
    pub tissue: Option<TissueVerdict>,
    /// Verdict on the controller that was asked for.
    pub controller: Option<ControllerVerdict>,
    /// The best one tried on the simulated device.
    pub simulated: Option<Settling>,
    /// If an ideal device was assumed: the best one tried on a realistic one.
    pub realistic: Option<RealisticTrial>,
    /// Notes for the designer, a sentence each.
    pub notes: Vec<String>,
    /// The text of the experiment file that does this.
    #[serde(skip)]
    pub experiment_text: Option<String>,
}
