//! An emulated board that is a certain device.

use super::EmulatorError;
use crate::hardware::Hardware;
use crate::simulated::{Plant, Setup, too_fast};
use haptic_link::{Capabilities, Field, Refusal, Simulation};
use haptic_loop::plant::{
    IndentationRig, MAX_DELAY_SAMPLES, MassDamper, MassDamperConfig, RigConfig, Sensed,
};
use haptic_loop::units::Metres;
use haptic_loop::{Device, Fault, Reading, SafeForce};

/// A device that an emulated board is, whatever a host takes it for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, damping, friction, delay and lag. The sample time is that of a run, and so is the stiffness, which is a hand's.
    pub plant: MassDamperConfig,
    /// Resolution of its encoder, m per count; 0 for none.
    pub encoder_resolution: Metres,
    /// Standard deviation of its noise, m, 0 for none; and the seed.
    pub noise: (Metres, u64),
}

/// A simulated board with a body.
pub(super) struct Embodied<H> {
    board: Sensed<H>,
    body: Body,
}

impl<H> Embodied<H> {
    pub(super) fn new(board: H, body: Body) -> Result<Self, EmulatorError> {
        let board = Sensed::new(board, body.encoder_resolution, body.noise);
        Ok(Self {
            board: board.map_err(EmulatorError::Body)?,
            body,
        })
    }
}

/// A simulated plant that becomes a certain device.
pub(super) trait Fits {
    /// Becomes it.
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal>;
}

impl<const D: usize> Fits for MassDamper<D> {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        let &MassDamperConfig {
            sample_time,
            stiffness,
            ..
        } = self.config();
        let shortest_s = device.delay.0 / MAX_DELAY_SAMPLES as f64;
        if sample_time.0 < shortest_s * (1.0 - 1e-9) {
            return Err(Refusal::Range {
                field: Field::TickPeriod,
                value: (1e6 * sample_time.0) as f32,
                least: (1e6 * shortest_s).ceil() as f32,
                most: f32::MAX,
            });
        }
        let config = MassDamperConfig {
            sample_time,
            stiffness,
            ..*device
        };
        *self = self.with(config).map_err(too_fast)?;
        Ok(())
    }
}

impl<const D: usize> Fits for Option<MassDamper<D>> {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        self.as_mut().map_or(Ok(()), |plant| plant.fit(device))
    }
}

impl Fits for Setup {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        match &mut self.plant {
            // What is imposed is the same for any device.
            Plant::Still | Plant::Imposed(_) => Ok(()),
            Plant::MassDamper(plant) => plant.fit(device),
            // The rig knows no more of its renderer than mass and damping.
            Plant::Rig(_) if device.friction.0 + device.delay.0 + device.lag.0 > 0.0 => {
                Err(Refusal::Unsupported(Field::SimulationKind))
            }
            Plant::Rig(rig) => {
                let config = RigConfig {
                    renderer_mass: device.mass,
                    renderer_damping: device.damping,
                    ..*rig.config()
                };
                *rig = IndentationRig::new(config).map_err(too_fast)?;
                Ok(())
            }
        }
    }
}

impl<H: Hardware<D>, const D: usize> Device<f32, D> for Embodied<H> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.board.read()
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        self.board.write(force)
    }

    fn let_go(&mut self) {
        self.board.let_go();
    }
}

impl<H: Hardware<D, Setup: Fits>, const D: usize> Hardware<D> for Embodied<H> {
    type Setup = H::Setup;

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            position_resolution_m: self.body.encoder_resolution.0 as f32,
            ..self.board.device().capabilities()
        }
    }

    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self::Setup, Refusal> {
        H::prepare(simulation, tick_period_us)
    }

    fn fit(&self, setup: &mut Self::Setup) -> Result<(), Refusal> {
        setup.fit(&self.body.plant)
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.board.device_mut().install(setup, tick_period_us);
    }

    fn restart(&mut self) {
        self.board.device_mut().restart();
    }

    /// A simulated board stands still while it is read.
    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.board.read()
    }
}
