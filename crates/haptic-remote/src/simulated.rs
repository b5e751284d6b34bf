//! A device without hardware: a plant that is stepped by its own ticks.

use crate::flight::FLIGHT_SAMPLES;
use crate::hardware::Hardware;
use crate::limits::Fields;
use crate::prepared::{COEFFICIENTS_MAX, DEGREE_MAX, MODES_MAX};
use haptic_link::{Capabilities, Field, Refusal, Simulation, SimulationKind};
use haptic_loop::plant::{ImposedMotion, MassDamper, MassDamperConfig, RampHold};
#[cfg(feature = "std")]
use haptic_loop::plant::{IndentationRig, RigConfig, RigContact, RigDrive};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, NewtonsPerMetre, Seconds};
use haptic_loop::{Device, Fault, ParameterError, Reading, SafeForce};
use nalgebra::SVector;

/// A simulated board: a mass-damper with a hand, or an indentation; by a compliant indenter with the feature
/// `std` only.
///
/// The plants are those of [`plant`](haptic_loop::plant), in `f64`, so that the firmware simulates what the host
/// does, bit for bit. *Start-up*: the testbed's mass-damper without a hand, at rest. *Cost* of a tick: that
/// of the plant, in soft floating point on a Cortex-M4F.
#[derive(Clone, Debug)]
pub struct SimulatedPlant {
    board: [u8; 16],
    cycles: fn() -> u32,
    plant: Plant,
    tick_period_us: u32,
}

/// Kind of the simulated plant.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap, and one of them is in use"
)]
pub enum Plant {
    /// Nothing moves.
    Still,
    /// A mass-damper.
    MassDamper(MassDamper<1>),
    /// An indentation that is imposed exactly.
    Imposed(ImposedMotion),
    /// The rig; its matrices are too large for a microcontroller.
    #[cfg(feature = "std")]
    Rig(IndentationRig),
}

impl SimulatedPlant {
    /// Under this name, with a counter of processor cycles.
    #[must_use]
    pub fn new(board: &str, cycles: fn() -> u32) -> Self {
        Self {
            board: Capabilities::board_name(board),
            cycles,
            plant: Plant::Still,
            tick_period_us: 1000,
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
pub(crate) const fn too_fast(_: ParameterError) -> Refusal {
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

/// The plant of a configuration. On its own, for size, as [`prepare`](crate::prepare) is compiled with the tick.
#[inline(never)]
fn plant(simulation: &Simulation, sample_time: Seconds) -> Result<Plant, Refusal> {
    let fields = Fields::default();
    let profile = |mut fields: Fields| {
        let depth = fields.finite(Field::Depth, simulation.depth_m);
        let ramp = fields.positive(Field::RampTime, simulation.ramp_time_s);
        fields.done()?;
        RampHold::new(Metres(depth), Seconds(ramp)).map_err(too_fast)
    };
    match simulation.kind {
        SimulationKind::Real => Ok(Plant::Still),
        SimulationKind::MassDamper => mass_damper(simulation, sample_time).map(Plant::MassDamper),
        SimulationKind::RigidIndentation => ImposedMotion::new(profile(fields)?, sample_time)
            .map(Plant::Imposed)
            .map_err(too_fast),
        #[cfg(feature = "std")]
        SimulationKind::CompliantIndentation => {
            let drive = RigDrive::Position(profile(fields)?);
            IndentationRig::new(RigConfig::new(drive, RigContact::COMPLIANT, sample_time))
                .map(Plant::Rig)
                .map_err(too_fast)
        }
        #[cfg(not(feature = "std"))]
        SimulationKind::CompliantIndentation => Err(Refusal::Unsupported(Field::SimulationKind)),
    }
}

/// Abilities of a simulated board of so many axes.
pub(crate) const fn capabilities(board: [u8; 16], axes: u8) -> Capabilities {
    Capabilities {
        board,
        axes,
        simulated: true,
        tick_period_min_us: 100,
        tick_period_max_us: 10_000,
        // More than desktop devices can do; nothing here would break.
        force_max_n: 100.0,
        force_rate_max_n_per_s: 1e6,
        position_resolution_m: 0.0,
        coefficients_max: COEFFICIENTS_MAX as u16,
        modes_max: MODES_MAX as u16,
        degree_max: DEGREE_MAX as u16,
        flight_samples: FLIGHT_SAMPLES as u16,
    }
}

impl Device<f32, 1> for SimulatedPlant {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let reading = match &mut self.plant {
            Plant::Still => return Ok(self.resting()),
            Plant::MassDamper(plant) => plant.read(),
            Plant::Imposed(motion) => motion.read(),
            #[cfg(feature = "std")]
            Plant::Rig(rig) => rig.read(),
        };
        reading.map_err(|never| match never {})
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let written = match &mut self.plant {
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
    type Setup = Plant;

    fn capabilities(&self) -> Capabilities {
        capabilities(self.board, 1)
    }

    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Plant, Refusal> {
        plant(simulation, Seconds(f64::from(tick_period_us) * 1e-6))
    }

    fn install(&mut self, setup: Plant, tick_period_us: u32) {
        self.plant = setup;
        self.tick_period_us = tick_period_us;
    }

    fn restart(&mut self) {
        match &mut self.plant {
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
