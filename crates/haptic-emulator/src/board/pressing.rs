//! An emulated board with a specimen at its handle, to rehearse a measurement, or with a hand that follows a script.
//!
//! The specimen is a physical force in continuous time, see [`PressedDevice`]: it knows no law of ours and no sample time of a loop.
//!
//! - *Pressed* in every run whose hand neither pushes nor holds: nothing but the specimen touches the handle. A run that brings a hand or
//!   an indenter of its own has that instead, as on any emulated board: so what was measured can be felt on this very board.
//! - *A script* takes the place of whatever hand a run brings, but not that of an indenter.
//! - *Idle* it stands still. *Start of a run*: at rest at 0, in front of a specimen that nobody has pressed, or at the first move.

use super::scripted::{HandScript, ScriptedDevice};
use haptic_link::{Capabilities, ControllerCost, Field, Refusal, Simulation, SimulationKind};
use haptic_loop::{
    Device, Fault, LoopParameterError, Reading, SafeForce,
    plant::{MassDamperConfig, PressedDevice, PressedSpecimen},
    units::{Kilograms, NewtonSecondsPerMetre, Seconds},
};
use haptic_remote::{FitsDevice, Hardware, PlantSetup, SimulatedPlant};

type PlantOfRun = <SimulatedPlant as Hardware>::Setup;

/// Something at the handle of an emulated board.
#[derive(Clone, Debug, PartialEq)]
pub enum AtHandle {
    /// A piece of tissue, which the handle presses.
    Specimen(PressedSpecimen),
    /// A hand that follows a script.
    Hand(HandScript),
}

impl AtHandle {
    /// The device of a run, with this at its handle.
    fn device(&self, device: MassDamperConfig) -> Result<Touching, LoopParameterError> {
        Ok(match self {
            Self::Specimen(specimen) => {
                Touching::Specimen(PressedDevice::new(device, specimen.clone())?)
            }
            Self::Hand(script) => Touching::Hand(ScriptedDevice::new(device, script.clone())?),
        })
    }
}

#[derive(Clone, Debug)]
enum Touching {
    Specimen(PressedDevice),
    Hand(ScriptedDevice),
}

/// A board of one axis with something at its handle.
#[derive(Clone, Debug)]
pub(super) struct PressingBoard {
    there: AtHandle,
    /// Device in runs whose own hand or indenter is felt.
    plant: SimulatedPlant,
    /// Device in all others.
    touching: Option<Touching>,
}

impl PressingBoard {
    /// A board of this name.
    ///
    /// # Errors
    /// A specimen outside its range.
    pub(super) fn new(name: &str, there: &AtHandle) -> Result<Self, LoopParameterError> {
        let tried =
            MassDamperConfig::ideal(Kilograms(1.0), NewtonSecondsPerMetre(0.0), Seconds(1e-3));
        there.device(tried)?;
        Ok(Self {
            there: there.clone(),
            plant: SimulatedPlant::new(name, || 0),
            touching: None,
        })
    }

    /// Force of what is at the handle, or of the hand that a run brings, on the handle now, N, positive along the position.
    pub(super) fn contact_force(&self) -> f64 {
        match &self.touching {
            Some(Touching::Specimen(device)) => device.contact_force(),
            Some(Touching::Hand(device)) => device.contact_force(),
            None => self.plant.contact_force(),
        }
    }
}

/// The plant of a run, and the device that something else touches.
#[derive(Clone, Debug)]
pub(super) struct Setup {
    plant: PlantOfRun,
    device: Option<MassDamperConfig>,
    /// The run brings a hand.
    has_hand: bool,
    touching: Option<Touching>,
}

impl PlantSetup for Setup {
    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self, Refusal> {
        let hand = [simulation.push_n, simulation.hand_stiffness_n_per_m];
        let is_mass = simulation.kind == SimulationKind::MassDamper;
        let device = is_mass.then(|| {
            MassDamperConfig::ideal(
                Kilograms(simulation.mass_kg.into()),
                NewtonSecondsPerMetre(simulation.damping_n_s_per_m.into()),
                Seconds(1e-6 * f64::from(tick_period_us)),
            )
        });
        Ok(Self {
            // It checks the numbers of the mass too.
            plant: PlantSetup::prepare(simulation, tick_period_us)?,
            device,
            has_hand: hand.iter().any(|&value| value != 0.0),
            touching: None,
        })
    }
}

impl FitsDevice for Setup {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        self.plant.fit(device)?;
        if let Some(alone) = &mut self.device {
            *alone = MassDamperConfig {
                sample_time: alone.sample_time,
                ..*device
            };
        }
        Ok(())
    }
}

impl Device<f32, 1> for PressingBoard {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        match &mut self.touching {
            Some(Touching::Specimen(device)) => device.read().map_err(|never| match never {}),
            Some(Touching::Hand(device)) => device.read().map_err(|never| match never {}),
            None => self.plant.read(),
        }
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        match &mut self.touching {
            Some(Touching::Specimen(device)) => device.write(force).map_err(|never| match never {}),
            Some(Touching::Hand(device)) => device.write(force).map_err(|never| match never {}),
            None => self.plant.write(force),
        }
    }

    fn let_go(&mut self) {
        // Nothing here fails, and nothing holds a force.
    }
}

impl Hardware for PressingBoard {
    type Setup = Setup;

    fn capabilities(&self) -> Capabilities {
        self.plant.capabilities()
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        self.plant.controller_cost()
    }

    fn fit(&self, setup: &mut Setup) -> Result<(), Refusal> {
        let gives_way = setup.has_hand && matches!(self.there, AtHandle::Specimen(_));
        let device = setup.device.filter(|_| !gives_way);
        let touching = device.map(|device| self.there.device(device));
        // Mass and specimen are known to be good, so it is a delay of too many steps.
        let touching = touching.transpose();
        setup.touching = touching.map_err(|_| Refusal::Unsupported(Field::TickPeriod))?;
        Ok(())
    }

    fn install(&mut self, setup: Setup, tick_period_us: u32) {
        self.touching = setup.touching;
        self.plant.install(setup.plant, tick_period_us);
    }

    fn restart(&mut self) {
        self.plant.restart();
        match &mut self.touching {
            Some(Touching::Specimen(device)) => device.restart(),
            Some(Touching::Hand(device)) => device.restart(),
            None => {}
        }
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read()
    }
}

#[cfg(test)]
mod tests;
