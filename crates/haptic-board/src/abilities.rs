//! What a board says of itself.

use haptic_link::{Capabilities, Field, Refusal, Simulation, SimulationKind};
use haptic_remote::{COEFFICIENTS_MAX, DEGREE_MAX, FLIGHT_SAMPLES, MODES_MAX};

/// Abilities of a real board with one axis, as far as this crate knows them. The board adds its own: forces, in N and
/// N/s, the sensor's resolution, in m, and other periods than 100 µs to 10 ms.
#[must_use]
pub const fn one_axis(board: &str) -> Capabilities {
    Capabilities {
        board: Capabilities::board_name(board),
        axes: 1,
        simulated: false,
        tick_period_min_us: 100,
        tick_period_max_us: 10_000,
        force_max_n: 0.0,
        force_rate_max_n_per_s: 0.0,
        position_resolution_m: 0.0,
        coefficients_max: COEFFICIENTS_MAX as u16,
        modes_max: MODES_MAX as u16,
        degree_max: DEGREE_MAX as u16,
        flight_samples: FLIGHT_SAMPLES as u16,
    }
}

/// [`Hardware::prepare`](haptic_remote::Hardware::prepare) of a board that simulates nothing.
///
/// # Errors
/// A configuration that asks for a simulated plant.
pub fn only_real(simulation: &Simulation) -> Result<(), Refusal> {
    if simulation.kind == SimulationKind::Real {
        Ok(())
    } else {
        Err(Refusal::Unsupported(Field::SimulationKind))
    }
}
