//! The plant that a device simulates.

use crate::in_order::{Blank, blank, read_in_order};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The plant of a simulated device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Schema)]
pub struct Simulation {
    /// The simulated plant.
    pub kind: SimulationKind,
    /// Mass of the device, kg.
    pub mass_kg: f32,
    /// Its viscous damping, N·s/m.
    pub damping_n_s_per_m: f32,
    /// Stiffness of the hand, N/m.
    pub hand_stiffness_n_per_m: f32,
    /// Constant push of the hand, N.
    pub push_n: f32,
    /// Indentation that is held, m.
    pub depth_m: f32,
    /// Time to reach it, s.
    pub ramp_time_s: f32,
    /// Ticks from the start of a run in which the plant stands still; with one axis only.
    pub start_ticks: f32,
}

read_in_order!(Simulation {
    kind,
    mass_kg,
    damping_n_s_per_m,
    hand_stiffness_n_per_m,
    push_n,
    depth_m,
    ramp_time_s,
    start_ticks,
});

blank!(SimulationKind: Self::Real);

impl Simulation {
    /// A real device.
    pub const REAL: Self = Self {
        kind: SimulationKind::Real,
        mass_kg: 0.0,
        damping_n_s_per_m: 0.0,
        hand_stiffness_n_per_m: 0.0,
        push_n: 0.0,
        depth_m: 0.0,
        ramp_time_s: 0.0,
        start_ticks: 0.0,
    };

    /// The dissertation's testbed without a hand: 65 g, 3.5 N·s/m.
    pub const TESTBED: Self = Self {
        kind: SimulationKind::MassDamper,
        mass_kg: 0.065,
        damping_n_s_per_m: 3.5,
        ..Self::REAL
    };
}

/// The plant of a simulated device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SimulationKind {
    /// Nothing: a real device.
    #[default]
    Real,
    /// A mass-damper with a hand that pushes.
    MassDamper,
    /// An indentation by ramp and hold, imposed exactly.
    RigidIndentation,
    /// The same by an indenter of its own mass and servo, through a stiff contact.
    CompliantIndentation,
}
