//! The operator of a wall or tissue: D^μ by a scheme, or the one memory of a model.

use super::ModelledTissue;
use crate::document::failure::Failure;
use crate::document::parameters::SCHEME;
use fracdiff::full_memory::{Design, HORIZON_MIN, Kernel};
use fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fracdiff::{FullMemory, Operator, Order, Real, Scheme, SchemeError, Seconds};
use haptic_analysis::{AnalysisError, LoopOperator};
use haptic_tissue::{Model, SampledModel};

/// The operator for a horizon in samples: of the model, or D^μ.
///
/// # Errors
/// A scheme that cannot be made, or not for a model.
pub fn operator<F: Real>(
    model: Option<&Model>,
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
    horizon: f64,
) -> Result<Operator<F>, Failure> {
    let Some(model) = model else {
        let built = scheme.build(order, sample_time, horizon);
        return built.map_err(Failure::input);
    };
    let design = design(model, scheme, sample_time, horizon)?;
    let memory = FullMemory::new(&design, sample_time).map_err(Failure::input)?;
    Ok(Operator::FullMemory(Box::new(memory)))
}

/// The same for the analysis.
///
/// # Errors
/// As above, and those of the analysis.
pub(crate) fn loop_operator(
    model: Option<&Model>,
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
    horizon: f64,
) -> Result<LoopOperator, Failure> {
    let made = match model {
        None => LoopOperator::new(scheme, order, sample_time, horizon),
        Some(model) => LoopOperator::from_design(&design(model, scheme, sample_time, horizon)?),
    };
    made.map_err(|error: AnalysisError| Failure::input(error))
}

/// The modes of a model.
fn design(
    model: &Model,
    scheme: Scheme,
    sample_time: Seconds,
    horizon: f64,
) -> Result<Design<FULL_TAPS, FULL_MODES>, Failure> {
    let sampled = SampledModel::new(model, sample_time).map_err(Failure::input)?;
    let tolerance = match scheme {
        Scheme::Full {
            kernel: Kernel::Grunwald,
            tolerance,
        } => tolerance,
        Scheme::Exact => return Err(Failure::input(SchemeError::AnalysisOnly)),
        other => {
            return Err(Failure::bad_input(format_args!(
                "scheme {other} makes D^α of one spring-pot, not the memory of a model with more elements: take \
                 {scheme_full}",
                scheme_full = SCHEME.set_to("full")
            )));
        }
    };
    sampled
        .design(tolerance, horizon.max(HORIZON_MIN))
        .map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!(
                    "give {SCHEME} a larger tolerance, as in full:1e-4, or take a shorter run"
                ),
            )
        })
}

impl ModelledTissue {
    /// The operator that renders the tissue for so many samples.
    ///
    /// # Errors
    /// A scheme that cannot be made, or not for this model.
    pub(crate) fn operator<F: Real>(
        &self,
        scheme: Scheme,
        sample_time: Seconds,
        samples: u64,
    ) -> Result<Operator<F>, Failure> {
        // A little more than needed, so that the last weights are not at the very edge.
        let horizon = crate::run::schedule::horizon(samples);
        match self.composed() {
            None => scheme
                .build(self.order(), sample_time, horizon)
                .map_err(|error| {
                    Failure::input_with_advice(error, format_args!("change {SCHEME}"))
                }),
            model => operator(model, scheme, self.order(), sample_time, horizon),
        }
    }
}
