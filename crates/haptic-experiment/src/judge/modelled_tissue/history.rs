//! The force that the full history of a motion asks for.
//!
//! `shape` is A/ℓ, m: the force of a piece for a depth, N for m. With 1 it is the stress for a strain.

use super::{Law, ModelledTissue};
use crate::document::failure::Failure;
use crate::judge::Reference;
use crate::judge::reference;
use crate::judge::reference::TOLERANCE;
use fracdiff::{Channel, Differintegrator as _, FullMemory, Operator, Seconds};
use haptic_tissue::{FullHistory, Model, SampledModel};

/// A piece of tissue tick by tick with all of its past: f\[n\] = gain·x\[n\] + past.
pub(crate) enum Sampled {
    /// K, B, and D^μ.
    Derivative(f64, f64, Channel<f64, Operator<f64>>),
    /// The shape, and the sums of the elements.
    Sums(f64, Box<FullHistory>),
}

impl ModelledTissue {
    /// The force of a whole record of depths that begins at rest, by the defining sums.
    ///
    /// # Errors
    /// A record too long, a sample time outside its range.
    pub(crate) fn full_history(
        &self,
        shape: f64,
        reference: Reference,
        t: Seconds,
        depth: &[f64],
    ) -> anyhow::Result<Vec<f64>> {
        match &self.law {
            Law::KelvinVoigt(tissue) => {
                let (k, b) = self.spring_and_damper(shape);
                let rates = crate::judge::full_history(reference, tissue.order(), t, depth)?;
                Ok(depth
                    .iter()
                    .zip(rates)
                    .map(|(x, d)| k * x + b * d)
                    .collect())
            }
            Law::Composed { model, .. } => {
                let sampled = SampledModel::new(model, t)?;
                let mut sums = FullHistory::new(&sampled, depth.len().max(1))?;
                Ok(depth.iter().map(|&x| shape * sums.step(x)).collect())
            }
        }
    }

    /// The same tick by tick: the sums of the elements of a run that is kept whole, else operators of a tolerance of
    /// [`TOLERANCE`].
    ///
    /// # Errors
    /// An order and length for which there is none within the tolerance.
    pub(crate) fn sampled(
        &self,
        shape: f64,
        reference: Reference,
        t: Seconds,
        samples: u64,
    ) -> Result<Sampled, Failure> {
        let (k, b) = self.spring_and_damper(shape);
        let model = match &self.law {
            Law::KelvinVoigt(tissue) => {
                let channel = reference::operator(reference, tissue.order(), t, samples)?;
                return Ok(Sampled::Derivative(k, b, channel));
            }
            Law::Composed { model, .. } => SampledModel::new(model, t).map_err(Failure::input)?,
        };
        if samples <= SUMMED {
            let sums = FullHistory::new(&model, samples.max(1) as usize);
            return Ok(Sampled::Sums(
                shape,
                Box::new(sums.map_err(Failure::input)?),
            ));
        }
        let horizon = crate::run::schedule::horizon(samples);
        let design = model.design(TOLERANCE, horizon).map_err(Failure::input)?;
        let memory = FullMemory::new(&design, t).map_err(Failure::input)?;
        let channel = Channel::new(Operator::FullMemory(Box::new(memory)));
        Ok(Sampled::Derivative(k, b, channel))
    }
}

/// The memory of a model alone, tick by tick, in units of x·s^(−μ): what D^μ is in the force −(K·x + B·D^μ x).
///
/// # Errors
/// A record too long, a sample time outside its range.
pub(crate) fn memory(
    model: &Model,
    t: Seconds,
    samples: u64,
) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
    let sampled = SampledModel::new(model, t).map_err(Failure::input)?;
    let sums = FullHistory::new(&sampled, samples.max(1) as usize);
    let mut sums = sums.map_err(Failure::input)?;
    let (e, b) = (sampled.elastic_modulus_pa(), sampled.viscosity_pa_s_mu());
    Ok(move |x: f64| (sums.step(x) - e * x) / b)
}

/// Longest run whose elements are summed up exactly, samples: some 200 MB.
const SUMMED: u64 = 1 << 21;

impl Sampled {
    /// The factor of the newest depth.
    pub(crate) fn gain(&self) -> f64 {
        match self {
            Self::Derivative(k, b, channel) => k + b * channel.operator().direct_gain(),
            Self::Sums(shape, sums) => shape * sums.gain(),
        }
    }

    /// The force at a depth; at 0 that of the past alone.
    pub(crate) fn force(&self, depth: f64) -> f64 {
        match self {
            Self::Derivative(k, b, channel) => k * depth + b * channel.output(depth),
            Self::Sums(shape, sums) => shape * sums.stress(depth),
        }
    }

    /// Takes the newest depth into the past.
    pub(crate) fn advance(&mut self, depth: f64) {
        match self {
            Self::Derivative(_, _, channel) => channel.advance(depth),
            Self::Sums(_, sums) => sums.advance(depth),
        }
    }
}
