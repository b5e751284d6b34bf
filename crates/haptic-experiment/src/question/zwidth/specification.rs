//! A Z-width experiment: device, orders, how each wall is tried.

use crate::document::failure::Failure;
use crate::document::parameters;
use crate::experiment::trial::TrialPlan;
use crate::run::remote::RemoteDevice;
use crate::run::sensors::Sensors;
use fracdiff::{Order, Scheme, Seconds};
use haptic_loop::plant::MassDamperConfig;
use std::ops::RangeInclusive;

/// A Z-width experiment.
///
/// ```
/// use fracdiff::{Order, Seconds};
/// use haptic_experiment::{Imperfections, TrialPlan, ZWidth, dissertation_device};
/// use std::sync::atomic::AtomicBool;
///
/// let zwidth = ZWidth {
///     device: dissertation_device(Seconds(2e-3)),
///     sensors: Imperfections::NONE.sensors,
///     one_sided: false,
///     scheme: "muir:3".parse()?,
///     orders: vec![Order::new(1.0)?],
///     points: 2,
///     plan: TrialPlan::DEFAULT,
///     remote: None,
/// };
/// let report = zwidth.run(&|_| {}, &AtomicBool::new(false), &|_| {})?;
/// let softest = &report.orders[0].boundary[0];
/// println!("up to {} N/m without dissipation", softest.stiffness_max);
/// assert!(softest.stiffness_max > 1000.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ZWidth {
    /// The device, with whatever makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// A wall that pushes but never pulls, instead of the linear one that the theory assumes.
    pub one_sided: bool,
    /// Operator of the wall.
    pub scheme: Scheme,
    /// Orders to try.
    pub orders: Vec<Order>,
    /// Dissipations to try for each order, from 0 to the largest stable one.
    pub points: usize,
    /// Plan of the trial of each wall; on a serial device the force limit is at most what that can do.
    pub plan: TrialPlan,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
}

impl ZWidth {
    /// Numbers of dissipations an order.
    pub const POINTS: RangeInclusive<usize> = 2..=1000;

    /// As it is really tried: a serial device cannot be thrown.
    pub(super) fn plan(&self) -> TrialPlan {
        match self.remote {
            Some(_) => self.plan.starting_at_rest(),
            None => self.plan,
        }
    }

    /// Cells of the experiment, for a progress bar.
    #[must_use]
    pub fn cells(&self) -> u64 {
        (self.orders.len() * self.points) as u64
    }

    pub(crate) fn check(&self) -> Result<(), Failure> {
        if !Self::POINTS.contains(&self.points) {
            return Err(Failure::bad_input(format_args!(
                "number of points {} is not in [{}, {}]: give as many dissipations an order",
                self.points,
                Self::POINTS.start(),
                Self::POINTS.end()
            )));
        }
        if self.orders.is_empty() {
            return Err(Failure::bad_input(
                "no order was given: give one or more in [0, 2], as in 0,0.5,1",
            ));
        }
        if let Some(order) = self.orders.iter().find(|order| order.get() < 0.0) {
            return Err(Failure::bad_input(format_args!(
                "order {order} is not in [0, 2]: a wall has no integral; leave it out"
            )));
        }
        self.plan().samples(self.device.sample_time).map(|_| ())
    }
}

/// The device of the dissertation's section 4.4, which is sampled at 2 ms there: 65 g, 3.5 N·s/m, ideal.
#[must_use]
pub fn dissertation_device(sample_time: Seconds) -> MassDamperConfig {
    use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
    let mass = Kilograms(parameters::MASS.default_number());
    let damping = NewtonSecondsPerMetre(parameters::DAMPING.default_number());
    MassDamperConfig::ideal(mass, damping, sample_time)
}
