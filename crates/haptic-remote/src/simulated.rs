//! A device without hardware: a plant that is stepped by its own ticks.

use crate::{
    hardware::{Hardware, PlantSetup},
    limits::Fields,
    prepared::abilities,
};
use haptic_link::{Capabilities, Field, Refusal, Simulation, SimulationKind};
#[cfg(feature = "std")]
use haptic_loop::plant::{IndentationRig, RigConfig, RigContact, RigDrive};
use haptic_loop::{
    Device, Fault, LoopParameterError, Reading, SafeForce,
    plant::{ImposedMotion, MassDamper, MassDamperConfig, RampHold},
    units::{Kilograms, Metres, NewtonSecondsPerMetre, NewtonsPerMetre, Seconds},
};
use nalgebra::SVector;

/// A simulated board: a mass-damper with a hand, or an indentation; by a compliant indenter with the feature `std`
/// only.
///
/// The [plants](haptic_loop::plant) run in `f64`, on the firmware as on the host, bit for bit. *Start-up*: the
/// testbed's mass-damper without a hand, at rest. *Cost* of a tick: that of the plant, in soft floating point on a
/// Cortex-M4F.
#[derive(Clone, Debug)]
pub struct SimulatedPlant {
    board: [u8; 16],
    cycles: fn() -> u32,
    setup: Setup,
    /// Ticks until the plant moves.
    still: f32,
    /// Force written last, N.
    force_n: f32,
}

/// A plant, and when it begins to move.
#[derive(Clone, Debug)]
pub struct Setup {
    pub(crate) plant: Plant,
    start_ticks: f32,
}

/// Kind of the simulated plant.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap, and one of them is in use"
)]
pub(crate) enum Plant {
    Still,
    MassDamper(MassDamper<1>),
    /// An indentation that is imposed exactly.
    Imposed(ImposedMotion),
    /// The rig; its matrices are too large for a microcontroller.
    #[cfg(feature = "std")]
    Rig(IndentationRig),
}

impl SimulatedPlant {
    /// Simulated hardware with this name and a counter of processor cycles.
    #[must_use]
    pub fn new(board: &str, cycles: fn() -> u32) -> Self {
        Self {
            board: Capabilities::board_name(board),
            cycles,
            setup: Setup {
                plant: Plant::Still,
                start_ticks: 0.0,
            },
            still: 0.0,
            force_n: 0.0,
        }
    }

    /// Force of the hand or indenter on the device now, N, positive along the position; 0 until the plant moves.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn contact_force(&self) -> f64 {
        match &self.setup.plant {
            Plant::Still => 0.0,
            _ if self.still > 0.0 => 0.0,
            Plant::MassDamper(plant) => plant.contact_force()[0],
            // It moves however the device resists.
            Plant::Imposed(_) => 0.0 - f64::from(self.force_n),
            Plant::Rig(rig) => rig.contact_force(),
        }
    }

    fn resting(&self) -> Reading<f32, 1> {
        Reading {
            tick: 0,
            time_s: 0.0,
            position_m: SVector::from([0.0]),
        }
    }
}

impl Fields {
    fn positive(&mut self, field: Field, value: f32) -> f64 {
        f64::from(self.within(field, value, f32::MIN_POSITIVE, f32::MAX))
    }

    fn not_negative(&mut self, field: Field, value: f32) -> f64 {
        f64::from(self.within(field, value, 0.0, f32::MAX))
    }

    fn finite(&mut self, field: Field, value: f32) -> f64 {
        f64::from(self.within(field, value, -f32::MAX, f32::MAX))
    }
}

/// The one thing a plant finds that its fields do not show: a motion too fast for the tick.
pub(crate) const fn too_fast(_: LoopParameterError) -> Refusal {
    Refusal::Unsupported(Field::TickPeriod)
}

/// The mass-damper of a configuration, whose hand pushes along the first axis.
pub(crate) fn mass_damper<const D: usize>(
    simulation: &Simulation,
    sample_time: Seconds,
) -> Result<MassDamper<D>, Refusal> {
    let mut fields = Fields::default();
    let mass = fields.positive(Field::Mass, simulation.mass_kg);
    let damping = fields.not_negative(Field::Damping, simulation.damping_n_s_per_m);
    let hand = fields.not_negative(Field::HandStiffness, simulation.hand_stiffness_n_per_m);
    let push = fields.finite(Field::Push, simulation.push_n);
    fields.done()?;
    let mut config =
        MassDamperConfig::ideal(Kilograms(mass), NewtonSecondsPerMetre(damping), sample_time);
    config.stiffness = NewtonsPerMetre(hand);
    let mut plant = MassDamper::new(config).map_err(too_fast)?;
    let mut force = SVector::from([0.0; D]);
    force[0] = push;
    plant.set_external_force(force);
    Ok(plant)
}

impl PlantSetup for Setup {
    // On its own, for size, as [`prepare`](crate::prepare) is compiled with the tick.
    #[inline(never)]
    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self, Refusal> {
        let sample_time = Seconds(f64::from(tick_period_us) * 1e-6);
        let fields = Fields::default();
        let profile = |mut fields: Fields| {
            let depth = fields.finite(Field::Depth, simulation.depth_m);
            let ramp = fields.positive(Field::RampTime, simulation.ramp_time_s);
            fields.done()?;
            RampHold::new(Metres(depth), Seconds(ramp)).map_err(too_fast)
        };
        let plant = match simulation.kind {
            SimulationKind::Real => Plant::Still,
            SimulationKind::MassDamper => Plant::MassDamper(mass_damper(simulation, sample_time)?),
            SimulationKind::RigidIndentation => {
                Plant::Imposed(ImposedMotion::new(profile(fields)?, sample_time).map_err(too_fast)?)
            }
            #[cfg(feature = "std")]
            SimulationKind::CompliantIndentation => {
                let drive = RigDrive::Position(profile(fields)?);
                let config = RigConfig::new(drive, RigContact::COMPLIANT, sample_time);
                Plant::Rig(IndentationRig::new(config).map_err(too_fast)?)
            }
            #[cfg(not(feature = "std"))]
            SimulationKind::CompliantIndentation => {
                return Err(Refusal::Unsupported(Field::SimulationKind));
            }
        };
        Ok(Self {
            plant,
            start_ticks: simulation.start_ticks,
        })
    }
}

/// Abilities of a simulated board with `axes` axes.
pub(crate) const fn capabilities(board: [u8; 16], axes: u8) -> Capabilities {
    Capabilities {
        board,
        simulated: true,
        // More than desktop devices can do; nothing here would break.
        force_max_n: 100.0,
        force_rate_max_n_per_s: 1e6,
        ..abilities("", axes)
    }
}

impl Device<f32, 1> for SimulatedPlant {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let reading = match &mut self.setup.plant {
            Plant::Still => return Ok(self.resting()),
            Plant::MassDamper(plant) => plant.read(),
            Plant::Imposed(motion) => motion.read(),
            #[cfg(feature = "std")]
            Plant::Rig(rig) => rig.read(),
        };
        reading.map_err(|never| match never {})
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.force_n = force.newtons()[0];
        if self.still > 0.0 {
            self.still -= 1.0;
            return Ok(());
        }
        let written = match &mut self.setup.plant {
            Plant::Still => return Ok(()),
            Plant::MassDamper(plant) => plant.write(force),
            Plant::Imposed(motion) => motion.write(force),
            #[cfg(feature = "std")]
            Plant::Rig(rig) => rig.write(force),
        };
        written.map_err(|never| match never {})
    }

    fn let_go(&mut self) {
        // Nothing here fails, and nothing holds a force.
    }
}

impl Hardware for SimulatedPlant {
    type Setup = Setup;

    fn capabilities(&self) -> Capabilities {
        capabilities(self.board, 1)
    }

    #[cfg(feature = "std")]
    fn controller_cost(&self) -> Option<haptic_link::ControllerCost> {
        Some(crate::CONTROLLER_COST)
    }

    fn install(&mut self, setup: Setup, _: u32) {
        self.setup = setup;
    }

    fn restart(&mut self) {
        (self.still, self.force_n) = (self.setup.start_ticks, 0.0);
        match &mut self.setup.plant {
            Plant::Still => {}
            Plant::MassDamper(plant) => plant.restart(),
            Plant::Imposed(motion) => motion.restart(),
            #[cfg(feature = "std")]
            Plant::Rig(rig) => rig.restart(),
        }
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read()
    }

    fn cycles(&self) -> u32 {
        (self.cycles)()
    }
}
