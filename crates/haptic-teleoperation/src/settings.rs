//! Settings of a port, in SI units.

use crate::coupled::{Coupled, CouplerGains, Observed};
use crate::law::Law;
use crate::wave::WavePort;
use fracdiff::parameter::{RangeError, not_negative, positive, range};
use fracdiff::{Differintegrator, Seconds};
use haptic_link::{Architecture, HandSide};
use haptic_loop::ParameterError;

/// The law of a port, with its operator where it has one.
#[derive(Clone, Debug)]
pub enum PortLaw<O> {
    /// Position–position.
    PositionPosition(CouplerGains, O),
    /// Position–force: the coupler is the slave's; the master feels its force.
    PositionForce(CouplerGains, O),
    /// Waves.
    Wave {
        /// b, N·s/m, above 0: the damping that each hand feels of the line itself. A sampled device bears it if its own damping
        /// is as large.
        impedance_n_s_per_m: f64,
        /// N, 1 to 10 000: samples over which waves that came in a bunch are played out.
        playout_samples: u32,
    },
    /// Time-domain passivity around position–position.
    TimeDomain {
        /// Of the coupler.
        gains: CouplerGains,
        /// Its operator.
        operator: O,
        /// N, 1 to 10 000: a tick spends at most 1/N of the account, so that energy that came in a bunch lasts to the next.
        playout_samples: u32,
    },
}

impl<O> PortLaw<O> {
    /// Its architecture.
    pub const fn architecture(&self) -> Architecture {
        match self {
            Self::PositionPosition(..) => Architecture::PositionPosition,
            Self::PositionForce(..) => Architecture::PositionForce,
            Self::Wave { .. } => Architecture::Wave,
            Self::TimeDomain { .. } => Architecture::TimeDomain,
        }
    }
}

/// Everything of a port but its law and its safety chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Its side.
    pub side: HandSide,
    /// T, s, above 0.
    pub sample_time: Seconds,
    /// Silence of the other side after which the force falls to zero, s: at least one sample. Counted from the first message on.
    pub silence: Seconds,
}

impl Settings {
    /// Silence after which the force falls to zero unless something else is asked for, s: longer than what jitter and loss of a
    /// line over the world make, shorter than a hand takes to be afraid.
    pub const SILENCE_S: f64 = 0.2;
    /// Most samples of playout.
    pub const PLAYOUT_MOST: u32 = 10_000;

    /// Samples of silence.
    pub(crate) fn silence_ticks(&self) -> Result<u64, ParameterError> {
        let t = positive("sample time", self.sample_time.0, "s")?;
        let ticks = libm::ceil(self.silence.0 / t - 1e-9);
        range(
            "silence",
            self.silence.0,
            (1.0..=1e9).contains(&ticks),
            "at least one sample time and at most 1e9 of them",
            "s",
        )?;
        Ok(ticks as u64)
    }
}

fn checked(gains: CouplerGains) -> Result<CouplerGains, RangeError> {
    not_negative("coupler stiffness", gains.stiffness_n_per_m, "N/m")?;
    not_negative(
        "coupler dissipation",
        gains.dissipation_n_s_mu_per_m,
        "N·s^μ/m",
    )?;
    positive(
        "coupler stiffness and dissipation together",
        gains.stiffness_n_per_m + gains.dissipation_n_s_mu_per_m,
        "",
    )?;
    Ok(gains)
}

fn playout(samples: u32) -> Result<u32, ParameterError> {
    range(
        "playout",
        f64::from(samples),
        (1..=Settings::PLAYOUT_MOST).contains(&samples),
        "in [1, 10000]",
        "samples",
    )?;
    Ok(samples)
}

/// The law at rest.
///
/// # Errors
/// A gain or impedance outside its range.
pub(crate) fn law<O: Differintegrator<f64>>(
    law: PortLaw<O>,
    settings: &Settings,
) -> Result<Law<O>, ParameterError> {
    let coupled = |gains, operator| Ok::<_, RangeError>(Coupled::new(checked(gains)?, operator));
    Ok(match law {
        PortLaw::PositionPosition(gains, operator) => Law::Position(coupled(gains, operator)?),
        PortLaw::PositionForce(gains, operator) => {
            let coupled = coupled(gains, operator)?;
            match settings.side {
                HandSide::Master => Law::Reflected { force_n: 0.0 },
                HandSide::Slave => Law::Reflecting(coupled),
            }
        }
        PortLaw::Wave {
            impedance_n_s_per_m,
            playout_samples,
        } => {
            let impedance = positive("wave impedance", impedance_n_s_per_m, "N·s/m")?;
            let playout_samples = playout(playout_samples)?;
            Law::Wave(WavePort::new(
                impedance,
                playout_samples,
                settings.sample_time.0,
            ))
        }
        PortLaw::TimeDomain {
            gains,
            operator,
            playout_samples,
        } => Law::Observed(Observed::new(
            coupled(gains, operator)?,
            playout(playout_samples)?,
            settings.side == HandSide::Master,
        )),
    })
}
