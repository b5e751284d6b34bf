//! Fish muscle, a fractional Maxwell model: elements in series, rendered by one operator.

use fracdiff::{FullMemory, Operator, Real, Seconds};
use haptic_tissue::{Model, ModelKind, SampledModel};

/// V = 876 kPa·s^0.675 and G = 22.1 kPa·s^0.110 in series.
pub(crate) fn model() -> Model {
    let values = [876e3, 0.675, 22.1e3, 0.110];
    Model::from_parameters(ModelKind::FractionalMaxwell, &values).expect("valid")
}

/// Its memory for a horizon in samples, within 1e-6.
pub(crate) fn operator<F: Real>(sample_time: Seconds, horizon: f64) -> Operator<F> {
    let sampled = SampledModel::new(&model(), sample_time).expect("valid");
    let design = sampled.design(1e-6, horizon).expect("modes");
    let memory = FullMemory::new(&design, sample_time).expect("valid");
    Operator::FullMemory(Box::new(memory))
}
