//! A device that is pushed into a wall: what a single try and the search for a Z-width share.

use crate::failure::Failure;
use fracdiff::scheme::OperatorHistory;
use fracdiff::{Operator, Seconds};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{Contact, Environment, ParameterError, SafetyChain, SpringDamper};
use nalgebra::SVector;

/// A device this far away has left, m: it will not come to rest.
pub(super) const GONE_M: f64 = 1.0;

/// A spring and a fractional damper at the device's start position.
pub(super) enum VirtualWall {
    /// Pushes and pulls, as theory assumes.
    Linear(SpringDamper<f64, Operator<f64>>),
    /// Pushes but never pulls.
    OneSided(Contact<f64, SpringDamper<f64, Operator<f64>>, 1>),
}

impl VirtualWall {
    /// K in N/m and B in N·s^μ/m.
    ///
    /// # Errors
    /// As [`SpringDamper::new`].
    pub(super) fn new(
        stiffness: f64,
        dissipation: f64,
        operator: Operator<f64>,
        one_sided: bool,
    ) -> Result<Self, ParameterError> {
        let wall = SpringDamper::new(stiffness, dissipation, operator)?;
        Ok(if one_sided {
            Self::OneSided(Contact::at(Metres(0.0), wall)?)
        } else {
            Self::Linear(wall)
        })
    }
}

impl Environment<f64, 1> for VirtualWall {
    type History = [OperatorHistory<f64>; 1];

    fn at_rest(&self) -> Self::History {
        match self {
            Self::Linear(wall) => Environment::<f64, 1>::at_rest(wall),
            Self::OneSided(wall) => wall.at_rest(),
        }
    }

    fn force(&self, history: &Self::History, position_m: &SVector<f64, 1>) -> SVector<f64, 1> {
        match self {
            Self::Linear(wall) => wall.force(history, position_m),
            Self::OneSided(wall) => wall.force(history, position_m),
        }
    }

    fn advance(&self, history: &mut Self::History, position_m: &SVector<f64, 1>) {
        match self {
            Self::Linear(wall) => wall.advance(history, position_m),
            Self::OneSided(wall) => wall.advance(history, position_m),
        }
    }
}

/// The device with a constant push on it, N.
///
/// # Errors
/// A parameter of the device outside its range.
pub(super) fn pushed(config: MassDamperConfig, push_n: f64) -> Result<MassDamper<1>, Failure> {
    let mut device = MassDamper::new(config).map_err(Failure::input)?;
    device.set_external_force(SVector::from([push_n]));
    Ok(device)
}

/// A safety chain that limits the force alone. The rate is not what is tried here: the limit may be
/// crossed within one sample.
///
/// # Errors
/// A limit or sample time outside its range.
pub(super) fn force_limit(limit_n: f64, t: Seconds) -> Result<SafetyChain<f64>, Failure> {
    let rate = NewtonsPerSecond(2.0 * limit_n / t.0);
    SafetyChain::new(Newtons(limit_n), rate, t).map_err(Failure::input)
}
