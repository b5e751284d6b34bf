//! An emulated board with a specimen at its handle, to rehearse a measurement.
//!
//! The specimen is a physical force in continuous time, see [`PressedDevice`]: it knows no law of ours and no sample time of a loop.
//!
//! - *Pressed* in every run whose hand neither pushes nor holds: nothing but the specimen touches the handle. A run that brings a hand or
//!   an indenter of its own has that instead, as on any emulated board: so what was measured can be felt on this very board.
//! - *Idle* it stands still. *Start of a run*: at rest at 0, in front of a specimen that nobody has pressed.

use haptic_link::{Capabilities, ControllerCost, Field, Refusal, Simulation, SimulationKind};
use haptic_loop::plant::{MassDamperConfig, PressedDevice, PressedSpecimen};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Seconds};
use haptic_loop::{Device, Fault, LoopParameterError, Reading, SafeForce};
use haptic_remote::{FitsDevice, Hardware, PlantSetup, SimulatedPlant};

type PlantOfRun = <SimulatedPlant as Hardware>::Setup;

/// A board of one axis, whose specimen takes the place of a hand that does nothing.
#[derive(Clone, Debug)]
pub(super) struct PressingBoard {
    specimen: PressedSpecimen,
    /// Device in runs with a hand or an indenter of their own.
    plant: SimulatedPlant,
    /// Device in all others.
    pressed: Option<PressedDevice>,
}

impl PressingBoard {
    /// A board of this name.
    ///
    /// # Errors
    /// A specimen outside its range.
    pub(super) fn new(name: &str, specimen: &PressedSpecimen) -> Result<Self, LoopParameterError> {
        let tried =
            MassDamperConfig::ideal(Kilograms(1.0), NewtonSecondsPerMetre(0.0), Seconds(1e-3));
        PressedDevice::new(tried, specimen.clone())?;
        Ok(Self {
            specimen: specimen.clone(),
            plant: SimulatedPlant::new(name, || 0),
            pressed: None,
        })
    }

    /// Force of the specimen, or of the hand that a run brings, on the handle now, N, positive along the position.
    pub(super) fn contact_force(&self) -> f64 {
        (self.pressed.as_ref())
            .map_or_else(|| self.plant.contact_force(), PressedDevice::contact_force)
    }
}

/// The plant of a run, and the device that presses if its hand does nothing.
#[derive(Clone, Debug)]
pub(super) struct Setup {
    plant: PlantOfRun,
    free: Option<MassDamperConfig>,
    pressed: Option<PressedDevice>,
}

impl PlantSetup for Setup {
    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self, Refusal> {
        let hand = [simulation.push_n, simulation.hand_stiffness_n_per_m];
        let is_still = hand.iter().all(|&value| value == 0.0);
        let is_free = simulation.kind == SimulationKind::MassDamper && is_still;
        let free = is_free.then(|| {
            MassDamperConfig::ideal(
                Kilograms(simulation.mass_kg.into()),
                NewtonSecondsPerMetre(simulation.damping_n_s_per_m.into()),
                Seconds(1e-6 * f64::from(tick_period_us)),
            )
        });
        Ok(Self {
            // It checks the numbers of the mass too.
            plant: PlantSetup::prepare(simulation, tick_period_us)?,
            free,
            pressed: None,
        })
    }
}

impl FitsDevice for Setup {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        self.plant.fit(device)?;
        if let Some(free) = &mut self.free {
            *free = MassDamperConfig {
                sample_time: free.sample_time,
                ..*device
            };
        }
        Ok(())
    }
}

impl Device<f32, 1> for PressingBoard {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        match &mut self.pressed {
            Some(pressed) => pressed.read().map_err(|never| match never {}),
            None => self.plant.read(),
        }
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        match &mut self.pressed {
            Some(pressed) => pressed.write(force).map_err(|never| match never {}),
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
        let pressed = (setup.free).map(|device| PressedDevice::new(device, self.specimen.clone()));
        // Mass and specimen are known to be good, so it is a delay of too many steps.
        let pressed = pressed.transpose();
        setup.pressed = pressed.map_err(|_| Refusal::Unsupported(Field::TickPeriod))?;
        Ok(())
    }

    fn install(&mut self, setup: Setup, tick_period_us: u32) {
        self.pressed = setup.pressed;
        self.plant.install(setup.plant, tick_period_us);
    }

    fn restart(&mut self) {
        self.plant.restart();
        if let Some(pressed) = &mut self.pressed {
            pressed.restart();
        }
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read()
    }
}

#[cfg(test)]
mod tests;
