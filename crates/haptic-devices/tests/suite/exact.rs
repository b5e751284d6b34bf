//! The sum over the whole motion, that forces of devices are held to.

use fracdiff::batch::Batch;
use fracdiff::full_memory::Kernel;
use fracdiff::{Order, Seconds};

/// The largest distance of recorded forces from −B·D^μ x of the recorded positions, N, and the largest force of that sum, N.
pub(crate) fn off_from_the_sum(
    dissipation: f64,
    order: Order,
    t: Seconds,
    positions: &[f64],
    forces: &[f64],
) -> (f64, f64) {
    let exact = Batch::full_history(Kernel::Grunwald, order, t)
        .expect("a sum")
        .run(positions);
    let wanted: Vec<f64> = exact.iter().map(|sum| -dissipation * sum).collect();
    let largest = wanted
        .iter()
        .fold(0.0_f64, |most, force| most.max(force.abs()));
    let pairs = wanted.iter().zip(forces);
    let error = pairs.fold(0.0_f64, |most, (want, have)| most.max((want - have).abs()));
    (error, largest)
}
