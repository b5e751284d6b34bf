//! An emulated board that is a certain device.

use super::EmulatorError;
use haptic_link::{Capabilities, Refusal, Simulation};
use haptic_loop::plant::{MassDamperConfig, Sensed};
use haptic_loop::units::Metres;
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{FitsDevice, Hardware};

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
            board: board?,
            body,
        })
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

impl<H: Hardware<D, Setup: FitsDevice>, const D: usize> Hardware<D> for Embodied<H> {
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
