//! A teleoperation: devices, hand, motion, remote place, laws, line.

use super::advice::parameter;
use super::place::RemotePlace;
use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::document::parameters::SAMPLE_TIME;
use crate::experiment::teleoperation::keys::{
    FREQUENCIES, HIGH, TELEOPERATION_DURATION, TELEOPERATION_WINDOW, WAVE_IMPEDANCE,
};
use crate::experiment::trial::{force_alone, safe_force_limit};
use crate::run::SAMPLES;
use crate::run::safety::Safety;
use crate::run::schedule::Pace;
use crate::run::sensors::Sensors;
use fracdiff::parameter::Shown;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_analysis::{HandCoupler, HandLine, HandMass, Teleoperation};
use haptic_link::{Architecture, HandSide};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::NewtonsPerSecond;
use haptic_loop::{Limits, SafetyChain};
use haptic_teleoperation::{ChannelModel, CouplerGains, Port, PortLaw, Settings};
use std::f64::consts::{PI, TAU};

/// An architecture, by its name in files and options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArchitectureName(pub Architecture);

impl Named for ArchitectureName {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self(Architecture::PositionPosition),
            Architecture::PositionPosition.name(),
            "A fractional coupler pulls each side to the other",
        ),
        (
            Self(Architecture::PositionForce),
            Architecture::PositionForce.name(),
            "The slave is pulled to the master, which feels that force",
        ),
        (
            Self(Architecture::Wave),
            Architecture::Wave.name(),
            "Waves: passive at any delay",
        ),
        (
            Self(Architecture::TimeDomain),
            Architecture::TimeDomain.name(),
            "Position-position with an energy account: passive at any delay",
        ),
    ];
}

/// The hand that holds the master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandModel {
    /// `k_h`, N/m, above 0.
    pub stiffness_n_per_m: f64,
    /// `b_h`, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
}

impl HandModel {
    /// No hand at all.
    pub(super) const NONE: Self = Self {
        stiffness_n_per_m: 0.0,
        damping_n_s_per_m: 0.0,
    };
}

/// Motion of the hand.
#[derive(Clone, Debug, PartialEq)]
pub struct HandMotion {
    /// Displacement that is reached in 1 s and held, m.
    pub press_m: f64,
    /// Sum of the amplitudes of all sines, m, at least 0; they rise in that time too.
    pub amplitude_m: f64,
    /// Frequencies of the sines, Hz, ascending.
    pub frequencies_hz: Vec<f64>,
}

impl HandMotion {
    /// Time in which the motion begins, s.
    pub(crate) const RISE_S: f64 = 1.0;

    /// So many frequencies from low to high, evenly in the logarithm, each with whole periods in the window.
    #[must_use]
    pub fn frequencies(low_hz: f64, high_hz: f64, count: u64, window_s: f64) -> Vec<f64> {
        let last = count.saturating_sub(1).max(1) as f64;
        let mut periods: Vec<u64> = (0..count)
            .map(|n| low_hz * (high_hz / low_hz).powf(n as f64 / last))
            .map(|frequency| ((frequency * window_s).round() as u64).max(1))
            .collect();
        periods.dedup();
        periods.iter().map(|&n| n as f64 / window_s).collect()
    }

    /// Place and speed of the hand at a time, m and m/s.
    #[must_use]
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        // (1 − cos)/2 up to the rise time.
        let share = (time_s / Self::RISE_S).clamp(0.0, 1.0);
        let risen = 0.5 * (1.0 - (PI * share).cos());
        let rising = if share < 1.0 {
            0.5 * PI / Self::RISE_S * (PI * share).sin()
        } else {
            0.0
        };
        let count = self.frequencies_hz.len() as f64;
        let first = self.frequencies_hz.first().copied().unwrap_or(1.0);
        let (mut sines, mut speeds) = (0.0, 0.0);
        for (n, &frequency) in self.frequencies_hz.iter().enumerate() {
            // Slower ones larger; phases that keep the crest low (M. R. Schroeder, 1970).
            let amplitude = self.amplitude_m / count * (first / frequency).sqrt();
            let phase = TAU * frequency * time_s + PI * (n * n) as f64 / count;
            sines += amplitude * phase.sin();
            speeds += TAU * frequency * amplitude * phase.cos();
        }
        let place = self.press_m + sines;
        (risen * place, rising * place + risen * speeds)
    }
}

/// A teleoperation.
#[derive(Clone, Debug)]
pub struct TeleoperationExperiment {
    /// The device in the hand; its sample time is that of both ports.
    pub master: MassDamperConfig,
    /// The remote device, of the same sample time.
    pub slave: MassDamperConfig,
    /// The hand.
    pub hand: HandModel,
    /// Its motion.
    pub motion: HandMotion,
    /// What the slave touches.
    pub place: RemotePlace,
    /// How the two are joined.
    pub architecture: Architecture,
    /// The coupler; not of waves.
    pub coupler: CouplerGains,
    /// μ of the coupler, 0 to 1.
    pub order: Order,
    /// b of the waves, N·s/m.
    pub wave_impedance_n_s_per_m: f64,
    /// Samples over which waves and energy are played out; `None` for two and as many as jitter spreads.
    pub playout_samples: Option<u32>,
    /// Each way of the line.
    pub channel: ChannelModel,
    /// Seed of its chances.
    pub seed: u64,
    /// Silence after which the force falls to zero, s.
    pub silence_s: f64,
    /// The operators of coupler and tissue.
    pub scheme: Scheme,
    /// Length, s.
    pub duration_s: f64,
    /// Window at the end over which impedances are taken, s.
    pub window_s: f64,
    /// Largest force on either device, N.
    pub force_limit_n: f64,
    /// Largest rate of it, N/s; `None` for none.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// A line that gives energy, or a force at its limit, is a failure.
    pub must_be_passive: bool,
    /// Further settings of both safety chains.
    pub safety: Safety,
    /// Pace of time.
    pub pace: Pace,
    /// Run a remote place that the analysis calls unstable for the slave.
    pub force_unstable: bool,
}

impl TeleoperationExperiment {
    /// T.
    #[must_use]
    pub const fn sample_time(&self) -> Seconds {
        self.master.sample_time
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        self.check_waves()?;
        self.pair().map(|_| self.samples())
    }

    /// Waves that both devices bear: each feels b as a damper that is told a sample late, and pays for that with its own damping.
    ///
    /// # Errors
    /// A wave impedance above the damping of a device.
    pub(super) fn check_waves(&self) -> Result<(), Failure> {
        let impedance = self.wave_impedance_n_s_per_m;
        for (device, side) in [
            (&self.master, HandSide::Master),
            (&self.slave, HandSide::Slave),
        ] {
            let damping = device.damping.0;
            if self.architecture == Architecture::Wave && impedance > damping {
                return Err(Failure::bad_input(format_args!(
                    "wave impedance {impedance} N·s/m is above the damping of the {side}, {damping} N·s/m: held forces would give \
                     it energy; take a smaller {WAVE_IMPEDANCE} or a device with more damping",
                    impedance = Shown(impedance),
                    damping = Shown(damping)
                )));
            }
        }
        Ok(())
    }

    /// A duration of a number of samples.
    ///
    /// # Errors
    /// Too few or too many.
    pub(super) fn check_duration(&self) -> Result<(), Failure> {
        crate::run::schedule::samples(self.duration_s, self.sample_time().0, &SAMPLES)?;
        Ok(())
    }

    /// Times and frequencies that fit each other.
    ///
    /// # Errors
    /// One that does not.
    pub(super) fn check_times(&self) -> Result<(), Failure> {
        self.check_duration()?;
        let t = self.sample_time().0;
        let most = self.duration_s - HandMotion::RISE_S;
        let whole = (self.window_s / t - (self.window_s / t).round()).abs() < 1e-6;
        if !(self.window_s >= t && self.window_s <= most && whole) {
            return Err(Failure::bad_input(format_args!(
                "window {} s is not whole samples of {t} s, at most the run less {} s for the motion to begin: change \
                 {TELEOPERATION_WINDOW} or {TELEOPERATION_DURATION}",
                Shown(self.window_s),
                HandMotion::RISE_S,
                t = Shown(t)
            )));
        }
        let highest = self.motion.frequencies_hz.last().copied().unwrap_or(0.0);
        if !(highest > 0.0 && highest < 0.45 / t) {
            return Err(Failure::bad_input(format_args!(
                "highest frequency {highest} Hz is not above 0 and below 0.45 of the sample rate, {} Hz: change {HIGH}, \
                 {FREQUENCIES} or {SAMPLE_TIME}",
                Shown(0.45 / t),
                highest = Shown(highest)
            )));
        }
        Ok(())
    }

    /// That at time 0 included.
    pub(super) fn samples(&self) -> u64 {
        (self.duration_s / self.sample_time().0).round() as u64 + 1
    }

    pub(super) fn horizon(&self) -> f64 {
        crate::run::schedule::horizon(self.samples())
    }

    /// Samples of playout of waves and energy: two, which bear the hold of the forces, and what jitter spreads.
    pub(super) fn playout(&self) -> u32 {
        let spread = 2.0 * self.channel.jitter * self.channel.delay.0 / self.sample_time().0;
        let most = f64::from(Settings::PLAYOUT_MOST);
        self.playout_samples
            .unwrap_or((2.0 + spread.ceil()).clamp(1.0, most) as u32)
    }

    /// The law of a port.
    pub(super) fn law(&self) -> Result<PortLaw<Operator<f64>>, Failure> {
        let mu = self.order.get();
        if !(0.0..=1.0).contains(&mu) {
            return Err(Failure::bad_input(format_args!(
                "order {mu} is not in [0, 1]: a coupler of a higher order pushes ahead of the motion",
                mu = Shown(mu)
            )));
        }
        let operator = || {
            let built = (self.scheme).build(self.order, self.sample_time(), self.horizon());
            built.map_err(Failure::input)
        };
        Ok(match self.architecture {
            Architecture::PositionPosition => PortLaw::PositionPosition(self.coupler, operator()?),
            Architecture::PositionForce => PortLaw::PositionForce(self.coupler, operator()?),
            Architecture::TimeDomain => PortLaw::TimeDomain {
                gains: self.coupler,
                operator: operator()?,
                playout_samples: self.playout(),
            },
            Architecture::Wave => PortLaw::Wave {
                impedance_n_s_per_m: self.wave_impedance_n_s_per_m,
                playout_samples: self.playout(),
            },
        })
    }

    /// The port of a side.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn port(&self, side: HandSide) -> Result<Port<Operator<f64>>, Failure> {
        let settings = Settings {
            side,
            sample_time: self.sample_time(),
            silence: Seconds(self.silence_s),
        };
        Port::new(self.law()?, settings, self.chain(side)?).map_err(parameter)
    }

    fn chain(&self, side: HandSide) -> Result<SafetyChain<f64>, Failure> {
        let device = match side {
            HandSide::Master => &self.master,
            HandSide::Slave => &self.slave,
        };
        let limits = force_alone(self.force_limit_n, self.sample_time());
        let limits = Limits {
            rate: (self.force_rate_limit_n_per_s).map_or(limits.rate, NewtonsPerSecond),
            ..limits
        };
        let ideal = Sensors {
            encoder_resolution_m: 0.0,
            noise_m: 0.0,
            seed: 0,
        };
        let chain = safe_force_limit(limits, device, ideal, &self.safety)?;
        self.safety.acts()?;
        Ok(chain)
    }

    /// The same for the analysis; `None` for time-domain passivity, which is no linear law.
    #[must_use]
    pub fn hands(&self) -> Option<Teleoperation> {
        let mass = |device: &MassDamperConfig| HandMass {
            mass_kg: device.mass.0,
            damping_n_s_per_m: device.damping.0,
        };
        let coupler = HandCoupler {
            stiffness_n_per_m: self.coupler.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.coupler.dissipation_n_s_mu_per_m,
            order: self.order,
        };
        let line = match self.architecture {
            Architecture::TimeDomain => return None,
            Architecture::PositionPosition => HandLine::PositionPosition(coupler),
            Architecture::PositionForce => HandLine::PositionForce(coupler),
            Architecture::Wave => HandLine::Wave {
                impedance_n_s_per_m: self.wave_impedance_n_s_per_m,
                playout_samples: self.playout(),
            },
        };
        let t = self.sample_time();
        Some(Teleoperation {
            master: mass(&self.master),
            slave: mass(&self.slave),
            line,
            sample_time_s: t.0,
            // The analysis adds the sample that every message takes.
            delay_s: (self.channel.samples(t) - 1) as f64 * t.0,
        })
    }
}
