//! The edge of the passive walls.

use fracdiff::Seconds;
use haptic_analysis::{AnalysisError, Dynamics, Largest, LoopOperator, OnePort};

/// Steps of B along the edge, which is the boundary of a convex set.
const STEPS: usize = 20;

/// B, K from B = 0 to K = 0. The set of passive walls is convex, so chords between its points lie inside.
pub(crate) fn passive_walls(
    port: &OnePort<'_, LoopOperator>,
    sample_time_s: f64,
    dynamics: &Dynamics,
) -> Result<Vec<f64>, AnalysisError> {
    let t = Seconds(sample_time_s);
    let damping = dynamics.damping_n_s_per_m;
    let Largest::Below { value: most, .. } = port.largest_dissipation(t, damping, 0.0)? else {
        return Ok(Vec::new());
    };
    let mut edge = Vec::new();
    for step in 0..STEPS {
        let dissipation = most * step as f64 / STEPS as f64;
        if let Largest::Below { value, .. } = port.largest_stiffness(t, damping, dissipation)? {
            edge.extend([dissipation, value]);
        }
    }
    edge.extend([most, 0.0]);
    Ok(edge)
}
