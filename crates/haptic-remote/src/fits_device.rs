//! Simulated plants that become a certain device, whatever a host takes them for.

use crate::simulated::{Plant, Setup, too_fast};
use haptic_link::{Field, Refusal};
use haptic_loop::plant::{
    IndentationRig, MAX_DELAY_SAMPLES, MassDamper, MassDamperConfig, RigConfig,
};

/// A simulated plant that becomes a certain device.
pub trait FitsDevice {
    /// Becomes it.
    ///
    /// # Errors
    /// A tick too short for its delay, or too long for its motion; a device that the plant cannot be.
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal>;
}

/// A board that simulates nothing is what it is.
impl FitsDevice for () {
    fn fit(&mut self, _: &MassDamperConfig) -> Result<(), Refusal> {
        Ok(())
    }
}

impl<const D: usize> FitsDevice for MassDamper<D> {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        let &MassDamperConfig {
            sample_time,
            stiffness,
            ..
        } = self.config();
        let shortest_s = device.delay.0 / MAX_DELAY_SAMPLES as f64;
        if sample_time.0 < shortest_s * (1.0 - 1e-9) {
            return Err(Refusal::range(
                Field::TickPeriod,
                (1e6 * sample_time.0) as f32,
                (1e6 * shortest_s).ceil() as f32,
                f32::MAX,
            ));
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

impl<const D: usize> FitsDevice for Option<MassDamper<D>> {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        self.as_mut().map_or(Ok(()), |plant| plant.fit(device))
    }
}

impl FitsDevice for Setup {
    fn fit(&mut self, device: &MassDamperConfig) -> Result<(), Refusal> {
        match &mut self.plant {
            // An imposed motion does not depend on the device.
            Plant::Still | Plant::Imposed(_) => Ok(()),
            Plant::MassDamper(plant) => plant.fit(device),
            // The rig knows no more of its renderer than mass and damping.
            Plant::Rig(_) if device.friction.0 + device.delay.0 + device.current_lag.0 > 0.0 => {
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
