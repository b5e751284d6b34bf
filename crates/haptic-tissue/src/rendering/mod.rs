//! Models as sampled laws: one memory that renders a model, and the sums of its elements to compare with.

mod branch;
mod full_history;
mod sampled;

pub use full_history::FullHistory;
pub use sampled::SampledModel;
