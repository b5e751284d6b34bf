//! A device at a port, as a search sees it: it tries one wall after another.

use fracdiff::{Operator, Order, Seconds};
use haptic_document::Failure;
use haptic_judge::preflight::WallContact;
use haptic_judge::settling::{Judge, Settling};
use haptic_judge::trial::TrialPlan;
use haptic_loop::plant::MassDamperConfig;
use haptic_trial::tap::TappedLaw;
use std::sync::atomic::AtomicBool;

/// Consecutive trials that end at a limit of the device, after which the search ends.
pub const TRIPS_IN_A_ROW: usize = 20;

/// A wall for a device at a port.
#[derive(Clone, Debug)]
pub struct WallThere {
    /// Mass, damping and hand, for an emulated device.
    pub device: MassDamperConfig,
    /// Push, force limit and length of a trial.
    pub plan: TrialPlan,
    /// Behaviour in front of the surface and on the way out.
    pub contact: WallContact,
    /// μ, the order of the operator.
    pub order: Order,
    /// The operator, as the device runs it.
    pub operator: Operator<f32>,
    /// Time in which a force rises; `None` for as it is set on the device.
    pub rise_time: Option<Seconds>,
    /// K of the wall, N/m.
    pub stiffness_n_per_m: f64,
    /// B of the wall, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// The wall as the motor taps it.
    pub tap: Option<TappedLaw>,
}

/// A device that is tried again and again. Whoever looks for walls needs no more of it.
pub trait Rig: Sync {
    /// Its identity and its lasting limits, on which all that is found depends.
    fn whose(&self) -> &str;

    /// Step of its encoder, m, and the largest force that it makes, N.
    fn encoder_and_force(&self) -> (f64, f64);

    /// Refuses a wall that the device would refuse.
    ///
    /// # Errors
    /// Such a wall.
    fn accepts(&self, wall: &WallThere, samples: u64) -> Result<(), Failure>;

    /// Judgement of one run; `None` if the wall tripped the device, or if no more trials can be made: the search then says why.
    fn judged(&self, wall: &WallThere, samples: u64, judge: Judge) -> Option<Settling>;

    /// Time in which the force of a device that pushes by itself rises, s: the one that was asked for, or a longer one that is set on it.
    fn rise_time_s(&self, asked_s: f64) -> Option<f64>;

    /// True if no more trials are made.
    fn has_failed(&self) -> bool;

    /// Why the search ended before its end, if so; `found` something or not, `stop`ped or not.
    ///
    /// # Errors
    /// The failure of the device, if nothing was found.
    fn ended(&self, found: bool, stop: &AtomicBool) -> Result<Option<Failure>, Failure>;
}
