//! Closed forms of a tissue: a ramp that is held, and a step of stress.

use super::{Law, ModelledTissue};
use crate::judge;
use fracdiff::Seconds;
use haptic_tissue::Model;

impl ModelledTissue {
    /// Stress under a strain that rises to ε₀ in T₀ and is then held, Pa; zero for t ≤ 0.
    #[must_use]
    pub fn relaxation_stress(&self, strain: f64, ramp_time_s: f64, time_s: f64) -> f64 {
        match &self.law {
            Law::KelvinVoigt(tissue) => tissue.relaxation_stress(strain, ramp_time_s, time_s).0,
            Law::Composed { model, .. } => ramp(model, strain, ramp_time_s, &[time_s])[0],
        }
    }

    /// Strain under a step of stress σ₀ at t = 0; zero for t ≤ 0.
    #[must_use]
    pub fn creep_strain(&self, stress_pa: f64, time_s: f64) -> f64 {
        match &self.law {
            Law::KelvinVoigt(tissue) => judge::creep_strain(tissue, stress_pa, time_s),
            Law::Composed { model, .. } => creep(model, stress_pa, &[time_s])[0],
        }
    }

    /// [`relaxation_stress`](Self::relaxation_stress) of ticks that come one after the other, at times n·T.
    pub(crate) fn relaxation(
        &self,
        strain: f64,
        ramp_time_s: f64,
        sample_time: Seconds,
    ) -> impl FnMut(u64, f64) -> f64 + '_ {
        self.by_ticks(
            sample_time,
            move |model, times| ramp(model, strain, ramp_time_s, times),
            move |time_s| self.relaxation_stress(strain, ramp_time_s, time_s),
        )
    }

    /// [`creep_strain`](Self::creep_strain) likewise.
    pub(crate) fn creep(
        &self,
        stress_pa: f64,
        sample_time: Seconds,
    ) -> impl FnMut(u64, f64) -> f64 + '_ {
        self.by_ticks(
            sample_time,
            move |model, times| creep(model, stress_pa, times),
            move |time_s| self.creep_strain(stress_pa, time_s),
        )
    }

    /// Many times at once cost a model little more than one.
    fn by_ticks<'a>(
        &'a self,
        sample_time: Seconds,
        many: impl Fn(&Model, &[f64]) -> Vec<f64> + 'a,
        one: impl Fn(f64) -> f64 + 'a,
    ) -> impl FnMut(u64, f64) -> f64 + 'a {
        let (mut first, mut values) = (0, Vec::new());
        move |tick, time_s| {
            let Law::Composed { model, .. } = &self.law else {
                return one(time_s);
            };
            let known = tick
                .checked_sub(first)
                .and_then(|at| values.get(at as usize));
            if let Some(value) = known {
                return *value;
            }
            let times: Vec<f64> = (tick..tick + AT_ONCE)
                .map(|tick| tick as f64 * sample_time.0)
                .collect();
            (first, values) = (tick, many(model, &times));
            values[0]
        }
    }
}

/// Ticks whose closed forms are made at once.
const AT_ONCE: u64 = 4096;

/// The stress at rising times.
fn ramp(model: &Model, strain: f64, ramp_time_s: f64, time_s: &[f64]) -> Vec<f64> {
    let later = time_s.iter().filter(|&&time| time > 0.0);
    let mut times: Vec<f64> = [0.0].into_iter().chain(later.copied()).collect();
    // The corner is a time of its own.
    let corner = times.partition_point(|&time| time < ramp_time_s);
    let own = times.get(corner).is_none_or(|&time| time > ramp_time_s);
    if own {
        times.insert(corner, ramp_time_s);
    }
    let strains: Vec<f64> = times
        .iter()
        .map(|time| strain * (time / ramp_time_s).min(1.0))
        .collect();
    let mut stress = model.stress(&times, &strains);
    if own {
        stress.remove(corner);
    }
    // All times up to 0 have the stress of the start.
    let early = time_s.len() + 1 - stress.len();
    let mut all = vec![0.0; early];
    all.extend(stress.drain(1..));
    all
}

/// The strain at any times.
fn creep(model: &Model, stress_pa: f64, time_s: &[f64]) -> Vec<f64> {
    let compliances = model.creep_compliances(time_s).into_iter();
    let strains = compliances.zip(time_s);
    strains
        .map(|(j, &time)| if time > 0.0 { stress_pa * j } else { 0.0 })
        .collect()
}
