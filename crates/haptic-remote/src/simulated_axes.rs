//! A device of several axes without hardware: a mass that is stepped by its own ticks.

use crate::{
    hardware::{Hardware, PlantSetup},
    simulated::{capabilities, mass_damper},
};
use haptic_link::{Capabilities, Field, Refusal, Simulation, SimulationKind};
use haptic_loop::{Device, Fault, Reading, SafeForce, plant::MassDamper, units::Seconds};
use nalgebra::SVector;

/// A simulated board of several axes: the same mass-damper on each, with a hand that holds it at 0
/// by a spring and pushes along the first axis. *Start-up*: at rest at 0. *Cost* of a tick: as for
/// [`MassDamper`].
#[derive(Clone, Debug)]
pub struct SimulatedAxes<const D: usize> {
    board: [u8; 16],
    /// `None` stands still.
    plant: Option<MassDamper<D>>,
}

impl<const D: usize> SimulatedAxes<D> {
    /// Axes of a board that gives itself this name.
    #[must_use]
    pub fn new(board: &str) -> Self {
        Self {
            board: Capabilities::board_name(board),
            plant: None,
        }
    }

    /// Force of the hand on each axis now, N, positive along the position.
    #[must_use]
    pub fn contact_force(&self) -> [f64; D] {
        let force = self.plant.as_ref().map(MassDamper::contact_force);
        force.map_or([0.0; D], Into::into)
    }
}

impl<const D: usize> Device<f32, D> for SimulatedAxes<D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        match &mut self.plant {
            Some(plant) => plant.read().map_err(|never| match never {}),
            None => Ok(Reading {
                tick: 0,
                time_s: 0.0,
                position_m: SVector::from([0.0; D]),
            }),
        }
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        match &mut self.plant {
            Some(plant) => plant.write(force).map_err(|never| match never {}),
            None => Ok(()),
        }
    }

    fn let_go(&mut self) {
        // Nothing here fails, and nothing holds a force.
    }
}

impl<const D: usize> PlantSetup for Option<MassDamper<D>> {
    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self, Refusal> {
        let t = Seconds(f64::from(tick_period_us) * 1e-6);
        match simulation.kind {
            SimulationKind::Real => Ok(None),
            SimulationKind::MassDamper => mass_damper(simulation, t).map(Some),
            SimulationKind::RigidIndentation | SimulationKind::CompliantIndentation => {
                Err(Refusal::Unsupported(Field::SimulationKind))
            }
        }
    }
}

impl<const D: usize> Hardware<D> for SimulatedAxes<D> {
    type Setup = Option<MassDamper<D>>;

    fn capabilities(&self) -> Capabilities {
        capabilities(self.board, D as u8)
    }

    fn install(&mut self, setup: Self::Setup, _: u32) {
        self.plant = setup;
    }

    fn restart(&mut self) {
        if let Some(plant) = &mut self.plant {
            plant.restart();
        }
    }

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.read()
    }
}
