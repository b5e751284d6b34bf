//! Two hands over a line: a hand moves a master, a slave moves in a remote tissue or wall, and a bad line is between them.
//!
//! ```text
//! hand ─ k_h, b_h ─▶ master ─▶ port ─▶ line: delay, jitter, loss, duplication ─▶ port ─▶ slave ─▶ tissue or wall
//!                                  ◀─                                        ◀─
//! ```
//! - *The hand* moves its own end, `x_h` = press + Σ sines, and holds the master by a spring and a damper.
//! - *Devices, hand and environment* are stepped eight times a sample, the ports once.
//! - *Impedances*: over the window at the end, forces and places of both sides at each frequency of the motion; beside them
//!   the tissue's own and what the formula says is felt of it, see [`Teleoperation`].
//! - *Energy*: what the line has given to both devices, Σ f·Δx; never above 0 with a passive architecture.
//!
//! The log has the hand as the reference, the master as the position, the slave as the indenter, the force on the slave's
//! environment as the contact force, and the energy taken by the line as the observed energy.

mod line;
mod pair;
mod report;
mod side;
#[cfg(test)]
mod tests;

use super::kind::{Conduct, Experiment as _};
use fracdiff::{Operator, Order, Scheme, Seconds, num_complex::Complex, parameter::Shown};
use haptic_analysis::{Dynamics, HandCoupler, HandLine, HandMass, Teleoperation};
use haptic_document::{
    Failure, FileError, Table, bad_input, named,
    parameters::{
        DAMPING, FORCE_LIMIT, HAND_COUPLER_DISSIPATION, HAND_COUPLER_STIFFNESS, MASS, SAMPLE_TIME,
        SCHEME,
    },
};
use haptic_judge::{
    preflight::{Matter, Preflight, WallContact},
    tissue_table::linear_piece,
    trial::{VirtualWall, force_and_rate, wall_at_start},
};
use haptic_link::{Architecture, HandSide};
use haptic_loop::{
    SafetyChain,
    plant::{ForceSensorConfig, MassDamperConfig, SUB_STEPS},
    units::{Kilograms, NewtonSecondsPerMetre},
};
use haptic_teleoperation::{ChannelModel, CouplerGains, Port, PortLaw, Settings};
use haptic_trial::{
    Sensors,
    advice::parameter,
    device_table::force_sensor,
    keys::{
        teleoperation::{
            AMPLITUDE, ARCHITECTURE, ENVIRONMENT, FREQUENCIES, HAND_COUPLER_ORDER, HAND_DAMPER,
            HAND_SPRING, HIGH, LINE_DELAY, LINE_DUPLICATION, LINE_JITTER, LINE_LOSS, LINE_SEED,
            LOW, MUST_BE_PASSIVE, PLACE_DISSIPATION, PLACE_ONE_SIDED, PLACE_ORDER, PLACE_STIFFNESS,
            PLAYOUT, PRESS, SILENCE, SLAVE_DAMPING, SLAVE_MASS, TELEOPERATION_DURATION,
            TELEOPERATION_WINDOW, WAVE_IMPEDANCE,
        },
        trial::TRIAL_FORCE_RATE_LIMIT,
    },
    preflight::PreflightVerdict,
    safe_chain::safe_chain,
    safety::{Safety, safety},
};
pub use line::End;
pub use side::{FarReport, Terms};
use std::f64::consts::{PI, TAU};

/// The hand that holds the master; by default nothing holds it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HandModel {
    /// `k_h`, N/m, above 0.
    pub stiffness_n_per_m: f64,
    /// `b_h`, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct HandMotion {
    /// Displacement that the hand reaches in 1 s and then holds, m.
    pub press_m: f64,
    /// Sum of the amplitudes of all sines, m, at least 0; they rise in that time too.
    pub amplitude_m: f64,
    /// Frequencies of the sines, Hz, ascending.
    pub frequencies_hz: Vec<f64>,
}

impl HandMotion {
    /// Time in which the motion begins, s.
    const RISE_S: f64 = 1.0;

    /// Up to `count` frequencies from low to high, evenly spaced in the logarithm, each with whole periods in the window.
    pub(crate) fn frequencies(low_hz: f64, high_hz: f64, count: u64, window_s: f64) -> Vec<f64> {
        let last = count.saturating_sub(1).max(1) as f64;
        let mut periods: Vec<u64> = (0..count)
            .map(|n| low_hz * libm::pow(high_hz / low_hz, n as f64 / last))
            .map(|frequency| ((frequency * window_s).round() as u64).max(1))
            .collect();
        periods.dedup();
        periods.iter().map(|&n| n as f64 / window_s).collect()
    }

    /// Place and speed of the hand at a time, m and m/s.
    pub(crate) fn at(&self, time_s: f64) -> (f64, f64) {
        // (1 − cos)/2 up to the rise time.
        let share = (time_s / Self::RISE_S).clamp(0.0, 1.0);
        let risen = 0.5 * (1.0 - libm::cos(PI * share));
        let rising = if share < 1.0 {
            0.5 * PI / Self::RISE_S * libm::sin(PI * share)
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
            sines += amplitude * libm::sin(phase);
            speeds += TAU * frequency * amplitude * libm::cos(phase);
        }
        let position = self.press_m + sines;
        (risen * position, rising * position + risen * speeds)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct TeleoperationExperiment {
    /// The device in the hand; its sample time is that of both ports.
    pub(super) master: MassDamperConfig,
    /// The remote device, of the same sample time.
    pub(super) slave: MassDamperConfig,
    pub(super) hand: HandModel,
    pub(super) motion: HandMotion,
    pub(super) place: RemotePlace,
    /// Between the slave and that place.
    pub(super) force_sensor: Option<ForceSensorConfig>,
    /// The law that joins master and slave.
    pub(super) architecture: Architecture,
    /// The coupler; not of waves.
    pub(super) coupler: CouplerGains,
    /// μ of the coupler, 0 to 1.
    pub(super) order: Order,
    /// b of the waves, N·s/m.
    pub(super) wave_impedance_n_s_per_m: f64,
    /// Samples over which waves and energy are played out; `None` for two plus the spread of the jitter.
    pub(super) playout_samples: Option<u32>,
    /// Each way of the line.
    pub(super) channel: ChannelModel,
    pub(super) seed: u64,
    /// Silence after which the force falls to zero, s.
    pub(super) silence_s: f64,
    /// The operators of coupler and tissue.
    pub(super) scheme: Scheme,
    pub(super) duration_s: f64,
    /// Window at the end over which impedances are taken, s.
    pub(super) window_s: f64,
    /// Largest force on either device, N.
    pub(super) force_limit_n: f64,
    /// Largest rate of it, N/s; `None` for none.
    pub(super) force_rate_limit_n_per_s: Option<f64>,
    /// True if the run fails when the line gives energy or a force reaches its limit.
    pub must_be_passive: bool,
    /// Further settings of both safety chains.
    pub(super) safety: Safety,
    /// Both devices are simulated; the remote place may be one that the analysis calls unstable for the slave.
    pub(super) conduct: Conduct,
}

impl TeleoperationExperiment {
    pub(crate) const fn sample_time(&self) -> Seconds {
        self.master.sample_time
    }

    /// Checks that both devices tolerate the waves: b acts on each as a damper a sample late, which the device's own damping must cover.
    fn check_waves(&self) -> Result<(), Failure> {
        let impedance = self.wave_impedance_n_s_per_m;
        for (device, side) in [
            (&self.master, HandSide::Master),
            (&self.slave, HandSide::Slave),
        ] {
            let damping = device.damping.0;
            if self.architecture == Architecture::Wave && impedance > damping {
                return Err(bad_input!(
                    "wave impedance {impedance} N·s/m is above the damping of the {side}, {damping} N·s/m: lower {WAVE_IMPEDANCE}",
                    impedance = Shown(impedance),
                    damping = Shown(damping)
                ));
            }
        }
        Ok(())
    }

    /// Times and frequencies that fit each other.
    fn check_times(&self) -> Result<(), Failure> {
        let t = self.sample_time().0;
        haptic_trial::samples::count(self.duration_s, t, &haptic_trial::samples::SAMPLES)?;
        let most = self.duration_s - HandMotion::RISE_S;
        let whole = (self.window_s / t - (self.window_s / t).round()).abs() < 1e-6;
        if !(self.window_s >= t && self.window_s <= most && whole) {
            return Err(bad_input!(
                "window {} s is not whole samples of {t} s, {} s below the run: change {TELEOPERATION_WINDOW} or {TELEOPERATION_DURATION}",
                Shown(self.window_s),
                HandMotion::RISE_S,
                t = Shown(t)
            ));
        }
        let highest = self.motion.frequencies_hz.last().copied().unwrap_or(0.0);
        if !(highest > 0.0 && highest < 0.45 / t) {
            return Err(bad_input!(
                "highest frequency {highest} Hz is not above 0 and below {} Hz: change {HIGH}, {FREQUENCIES} or {SAMPLE_TIME}",
                Shown(0.45 / t),
                highest = Shown(highest)
            ));
        }
        Ok(())
    }

    /// That at time 0 included.
    fn samples(&self) -> u64 {
        (self.duration_s / self.sample_time().0).round() as u64 + 1
    }

    fn horizon(&self) -> f64 {
        haptic_trial::samples::horizon(self.samples())
    }

    /// Samples of playout of waves and energy: two, which bear the hold of the forces, and what jitter spreads.
    fn playout(&self) -> u32 {
        let spread = 2.0 * self.channel.jitter * self.channel.delay.0 / self.sample_time().0;
        let most = f64::from(Settings::PLAYOUT_MOST);
        self.playout_samples
            .unwrap_or((2.0 + spread.ceil()).clamp(1.0, most) as u32)
    }

    /// The law of a port.
    fn law(&self) -> Result<PortLaw<Operator<f64>>, Failure> {
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
    pub(crate) fn port(&self, side: HandSide) -> Result<Port<Operator<f64>>, Failure> {
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
        let (force, rate) = (self.force_limit_n, self.force_rate_limit_n_per_s);
        let limits = force_and_rate(force, rate, self.sample_time());
        safe_chain(
            limits,
            device,
            Sensors::NONE,
            &self.safety,
            self.conduct.at_port(),
        )
    }

    /// The pair for the analysis; `None` for time-domain passivity, which is not a linear law.
    pub(crate) fn hands(&self) -> Option<Teleoperation> {
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

    /// The verdict on the loop of the slave and its remote place as they are simulated, several steps a sample, without coupler, hand and
    /// line; what is unstable is refused unless it is forced. `None` for a place without spring and damper, which is no loop.
    fn require_stable(&self) -> Result<Option<PreflightVerdict>, Failure> {
        let step = Seconds(self.sample_time().0 / SUB_STEPS as f64);
        let steps = self.samples() * SUB_STEPS as u64;
        // No guard stands between the slave and its place.
        let loops = Preflight {
            contact: WallContact::of(self.place.one_sided),
            ..(self.place.matter).run_by(self.scheme, step, steps)
        };
        if loops.stiffness_n_per_m <= 0.0 && loops.dissipation_n_s_mu_per_m <= 0.0 {
            return Ok(None);
        }
        let slave = Dynamics::ideal(self.slave.mass.0, self.slave.damping.0);
        let verdict = loops.proved(slave, 0)?;
        let required = verdict.require_stable(self.conduct.force_unstable);
        required.map_err(|refusal| bad_input!("the slave in its remote environment: {refusal}"))?;
        Ok(Some(verdict))
    }
}

/// `[teleoperation]`: devices, hand, motion, remote place, laws, line.
pub(crate) fn teleoperation(table: &Table<'_>) -> Result<TeleoperationExperiment, FileError> {
    let t = Seconds(table.number(&SAMPLE_TIME)?);
    let (mass, damping) = (table.number(&MASS)?, table.number(&DAMPING)?);
    let device =
        |mass, damping| MassDamperConfig::ideal(Kilograms(mass), NewtonSecondsPerMetre(damping), t);
    let slave_mass = table.number_if(&SLAVE_MASS)?.unwrap_or(mass);
    let slave_damping = table.number_if(&SLAVE_DAMPING)?.unwrap_or(damping);
    let window_s = table.number(&TELEOPERATION_WINDOW)?;
    let experiment = TeleoperationExperiment {
        master: device(mass, damping),
        slave: device(slave_mass, slave_damping),
        hand: HandModel {
            stiffness_n_per_m: table.number(&HAND_SPRING)?,
            damping_n_s_per_m: table.number(&HAND_DAMPER)?,
        },
        motion: motion(table, window_s)?,
        place: place(table)?,
        force_sensor: force_sensor(table)?,
        architecture: table.choice(&ARCHITECTURE)?,
        coupler: CouplerGains {
            stiffness_n_per_m: table.number(&HAND_COUPLER_STIFFNESS)?,
            dissipation_n_s_mu_per_m: table.number(&HAND_COUPLER_DISSIPATION)?,
        },
        order: table.order(&HAND_COUPLER_ORDER)?,
        wave_impedance_n_s_per_m: table.number(&WAVE_IMPEDANCE)?,
        playout_samples: playout(table, t)?,
        channel: ChannelModel {
            delay: Seconds(table.number(&LINE_DELAY)?),
            jitter: table.number(&LINE_JITTER)?,
            loss: table.number(&LINE_LOSS)?,
            duplication: table.number(&LINE_DUPLICATION)?,
        },
        seed: table.count(&LINE_SEED)?,
        silence_s: table.number(&SILENCE)?,
        scheme: table.scheme(&SCHEME)?,
        duration_s: table.number(&TELEOPERATION_DURATION)?,
        window_s,
        force_limit_n: table.number(&FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        must_be_passive: table.flag(&MUST_BE_PASSIVE)?,
        safety: safety(table)?,
        conduct: Conduct::on(None),
    };
    (experiment.check()).map_err(|error| table.fail(error))?;
    Ok(experiment)
}

fn motion(table: &Table<'_>, window_s: f64) -> Result<HandMotion, FileError> {
    let (low, high) = (table.number(&LOW)?, table.number(&HIGH)?);
    if low > high {
        return Err(table.fail_at(
            "low_hz",
            format_args!("low_hz = {low} is above high_hz = {high}"),
        ));
    }
    let count = table.count_in(&FREQUENCIES, 1..=100)? as u64;
    Ok(HandMotion {
        press_m: table.number(&PRESS)?,
        amplitude_m: table.number(&AMPLITUDE)?,
        frequencies_hz: HandMotion::frequencies(low, high, count, window_s),
    })
}

fn place(table: &Table<'_>) -> Result<RemotePlace, FileError> {
    if table.choice::<PlaceName>(&ENVIRONMENT)? == PlaceName::Tissue {
        return Ok(RemotePlace {
            matter: Matter::Tissue(linear_piece(table)?),
            one_sided: false,
        });
    }
    Ok(RemotePlace {
        matter: Matter::Wall {
            stiffness_n_per_m: table.number(&PLACE_STIFFNESS)?,
            dissipation_n_s_mu_per_m: table.number(&PLACE_DISSIPATION)?,
            order: table.order(&PLACE_ORDER)?,
        },
        one_sided: table.flag(&PLACE_ONE_SIDED)?,
    })
}

fn playout(table: &Table<'_>, t: Seconds) -> Result<Option<u32>, FileError> {
    let Some(time) = table.number_if(&PLAYOUT)? else {
        return Ok(None);
    };
    let samples = 1.0 + (time / t.0).round();
    if samples > f64::from(Settings::PLAYOUT_MOST) {
        let most = f64::from(Settings::PLAYOUT_MOST - 1) * t.0;
        return Err(table.fail_at(
            "playout_s",
            format_args!("playout_s = {time} is more than {most} s: use a shorter one"),
        ));
    }
    Ok(Some(samples as u32))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaceName {
    /// A tissue of the library.
    Tissue,
    Wall,
}

named! { PlaceName:
    Tissue = "tissue", "A tissue of the library, to which the slave is joined";
    Wall = "wall", "A spring and a fractional damper";
}

/// The environment that the slave touches, and is joined to, from its start on.
#[derive(Clone, Debug)]
pub(crate) struct RemotePlace {
    /// A piece of tissue, or a wall.
    pub matter: Matter,
    /// True if it pushes but never pulls.
    pub one_sided: bool,
}

impl RemotePlace {
    /// Its law, stepped `steps` times with `step`.
    fn law(&self, scheme: Scheme, step: Seconds, steps: u64) -> Result<VirtualWall, Failure> {
        let look = self.matter.run_by(scheme, step, steps);
        let (k, b) = (look.stiffness_n_per_m, look.dissipation_n_s_mu_per_m);
        let contact = WallContact::of(self.one_sided);
        wall_at_start(k, b, look.operator()?, contact).map_err(Failure::input)
    }

    /// Force for a place at a frequency, N/m; `None` where it is not linear.
    pub(crate) fn stiffness(&self, omega_rad_s: f64) -> Option<Complex<f64>> {
        (!self.one_sided).then(|| self.matter.stiffness(omega_rad_s))
    }

    pub(crate) fn words(&self) -> String {
        let words = self.matter.words();
        match (&self.matter, self.one_sided) {
            (Matter::Tissue(_), _) => words,
            (Matter::Wall { .. }, false) => format!("wall of {words}"),
            (Matter::Wall { .. }, true) => format!("one-sided wall of {words}"),
        }
    }
}
