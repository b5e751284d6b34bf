//! What the boards of all other makers have in common: this host does for them what a firmware does.

use haptic_link::{Capabilities, Field, Refusal, Simulation, SimulationKind};
use haptic_remote::{COEFFICIENTS_MAX, DEGREE_MAX, FLIGHT_SAMPLES, MODES_MAX};

/// What this host serves of a board of another maker, at periods that a full-speed USB port can follow.
pub(crate) fn served_host(board: &str, axes: u8) -> Capabilities {
    Capabilities {
        board: Capabilities::board_name(board),
        axes,
        simulated: false,
        tick_period_min_us: 500,
        tick_period_max_us: 500,
        force_max_n: 0.0,
        force_rate_max_n_per_s: 0.0,
        position_resolution_m: 0.0,
        coefficients_max: COEFFICIENTS_MAX as u16,
        modes_max: MODES_MAX as u16,
        degree_max: DEGREE_MAX as u16,
        flight_samples: FLIGHT_SAMPLES as u16,
    }
}

/// Refuses to be a simulated device.
pub(crate) fn is_real(simulation: &Simulation) -> Result<(), Refusal> {
    match simulation.kind {
        SimulationKind::Real => Ok(()),
        _ => Err(Refusal::Unsupported(Field::SimulationKind)),
    }
}
