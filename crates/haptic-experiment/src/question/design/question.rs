//! The question of a designer: on which device, under which requirement, what for.

use crate::document::advice::parameter;
use crate::document::failure::Failure;
use crate::document::parameters::FORCE_LIMIT;
use crate::dynamics;
use crate::judge::modelled_tissue::ModelledTissue;
use crate::question::design::keys::{DESIGN_ORDERS, GAIN_MARGIN, WISH_FREQUENCY};
use crate::{Imperfections, Sensors};
use fracdiff::parameter::Shown;
use fracdiff::{Order, Scheme};
use haptic_analysis::Dynamics;
use haptic_loop::Specimen;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_tissue::Model;

/// A device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Device {
    /// Mass, damping, hand and sample time; delay, current lag and friction.
    pub plant: MassDamperConfig,
    /// Its encoder.
    pub sensors: Sensors,
    /// Largest force, N.
    pub force_limit_n: f64,
}

/// Requirement on a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Requirement {
    /// Passive by Theorem 1, for the operator really used.
    Passive,
    /// Stable, also when it is stiffer and more dissipative by a factor.
    Stable {
        /// The factor, above 1.
        gain_margin: f64,
    },
}

/// Aim of a design.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one of them in a run")]
pub enum Wish {
    /// The largest K.
    StiffestWall,
    /// The largest effective damping of the wall at a frequency.
    MostDamping {
        /// Hz.
        frequency_hz: f64,
    },
    /// A specimen of a tissue.
    Tissue {
        /// The tissue.
        material: ModelledTissue,
        /// The piece of it.
        specimen: Specimen,
        /// Frequency at which other orders are made equal to it, Hz.
        frequency_hz: f64,
    },
}

/// A question of a designer.
///
/// ```
/// use fracdiff::{Order, Seconds};
/// use haptic_experiment::question::design::{Design, Device, Requirement, Wish};
/// use haptic_experiment::{Imperfections, dissertation_device};
///
/// let design = Design {
///     device: Device {
///         plant: dissertation_device(Seconds(2e-3)),
///         sensors: Imperfections::NONE.sensors,
///         force_limit_n: 100.0,
///     },
///     scheme: "muir:3".parse()?,
///     orders: vec![Order::new(1.0)?],
///     requirement: Requirement::Passive,
///     wish: Wish::StiffestWall,
///     force_noise_limit_n: None,
/// };
/// let report = design.answer(&|_| {})?;
/// // Theorem 1 without delay: K up to 2b/T.
/// let stiffness = report.best.and_then(|best| best.stiffness).expect("a wall");
/// assert!((stiffness / 3500.0 - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Design {
    /// On which device.
    pub device: Device,
    /// With which operator.
    pub scheme: Scheme,
    /// Orders to try.
    pub orders: Vec<Order>,
    /// Under which requirement.
    pub requirement: Requirement,
    /// The aim.
    pub wish: Wish,
    /// Largest noise of the force that encoder and sensor noise may make, rms N; `None` for any.
    pub force_noise_limit_n: Option<f64>,
}

impl Device {
    /// m/T², N/m of α = 1.
    pub(super) fn stiffness_unit(&self) -> f64 {
        let t = self.plant.sample_time.0;
        self.plant.mass.0 / (t * t)
    }

    /// m/T^(2−μ), N·s^μ/m of β = 1.
    pub(super) fn dissipation_unit(&self, order: Order) -> f64 {
        self.plant.mass.0 / self.plant.sample_time.0.powf(2.0 - order.get())
    }

    /// Dynamics that the analysis knows of it.
    pub(super) fn dynamics(&self) -> Dynamics {
        dynamics(&self.plant)
    }

    /// Its imperfections.
    #[must_use]
    pub fn imperfections(&self) -> Imperfections {
        Imperfections {
            friction_n: self.plant.friction.0,
            delay_s: self.plant.delay.0,
            current_lag_s: self.plant.lag.0,
            sensors: self.sensors,
        }
    }
}

impl Design {
    /// The tissue's own order, then those of the grid.
    #[must_use]
    pub fn orders_to_try(&self) -> Vec<Order> {
        let mut orders = self.orders.clone();
        if let Wish::Tissue { material, .. } = &self.wish {
            let own = material.order();
            orders.retain(|order| *order != own);
            orders.insert(0, own);
        }
        orders
    }

    /// The model whose memory is the operator of this order; `None` for D^μ.
    pub(super) fn model(&self, order: Order) -> Option<&Model> {
        match &self.wish {
            Wish::Tissue { material, .. } if material.order() == order => material.composed(),
            _ => None,
        }
    }

    pub(crate) fn check(&self) -> Result<(), Failure> {
        let device = &self.device;
        let plant = device.dynamics().plant(device.plant.sample_time.0);
        plant.map_err(Failure::input)?;
        // The device on which the best is tried.
        MassDamper::<1>::new(device.plant).map_err(parameter)?;
        if self.scheme == Scheme::Exact {
            return Err(Failure::input(fracdiff::SchemeError::AnalysisOnly));
        }
        if self.orders.is_empty() {
            return Err(Failure::bad_input(format_args!(
                "no order was given: give {DESIGN_ORDERS}, as in 0, 0.5, 1"
            )));
        }
        if let Some(order) = self.orders.iter().find(|order| order.get() < 0.0) {
            return Err(Failure::bad_input(format_args!(
                "order {order} is not in [0, 2]: a wall has no integral; change {DESIGN_ORDERS}"
            )));
        }
        if !(device.force_limit_n > 0.0 && device.force_limit_n.is_finite()) {
            return Err(Failure::bad_input(format_args!(
                "force limit {} N is not above 0 N: give {FORCE_LIMIT}, as in 10",
                Shown(device.force_limit_n)
            )));
        }
        if let Requirement::Stable { gain_margin } = self.requirement
            && !(gain_margin > 1.0 && gain_margin <= 1e3)
        {
            return Err(Failure::bad_input(format_args!(
                "gain margin {gain_margin} is not in (1, 1000]: give {GAIN_MARGIN}, as in 2",
                gain_margin = Shown(gain_margin)
            )));
        }
        if let Some(limit) = self.force_noise_limit_n {
            if !(limit > 0.0 && limit.is_finite()) {
                return Err(Failure::bad_input(format_args!(
                    "limit {limit} N of the force noise is not above 0 N: 0.01 N is felt by few",
                    limit = Shown(limit)
                )));
            }
            if self.device.sensors.are_ideal() {
                return Err(Failure::bad_input(format_args!(
                    "limit {limit} N of the force noise needs an encoder or sensor noise that makes some: give \
                     its resolution, as in 1um",
                    limit = Shown(limit)
                )));
            }
        }
        let highest = 0.5 / device.plant.sample_time.0;
        match self.wish.frequency_hz() {
            Some(f) if !(f > 0.0 && f <= highest) => Err(Failure::bad_input(format_args!(
                "frequency {f} Hz is not in (0, {highest}] Hz, up to half the sample rate: give {WISH_FREQUENCY}",
                f = Shown(f),
                highest = Shown(highest)
            ))),
            _ => Ok(()),
        }
    }
}

impl Requirement {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Passive => "passive",
            Self::Stable { .. } => "stable",
        }
    }

    /// Of the stable one.
    #[must_use]
    pub(crate) fn gain_margin(self) -> Option<f64> {
        match self {
            Self::Passive => None,
            Self::Stable { gain_margin } => Some(gain_margin),
        }
    }
}

impl Wish {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::StiffestWall => "stiffest-wall",
            Self::MostDamping { .. } => "most-damping",
            Self::Tissue { .. } => "tissue",
        }
    }

    pub(super) fn frequency_hz(&self) -> Option<f64> {
        match self {
            Self::StiffestWall => None,
            Self::MostDamping { frequency_hz } | Self::Tissue { frequency_hz, .. } => {
                Some(*frequency_hz)
            }
        }
    }
}
