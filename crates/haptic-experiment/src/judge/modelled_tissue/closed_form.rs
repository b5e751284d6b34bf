//! Closed forms of a tissue: a ramp that is held, and a step of stress.

use super::{Law, ModelledTissue};
use fracdiff::Seconds;
use haptic_tissue::Model;

impl ModelledTissue {
    /// Stress under a strain that rises to ε₀ in T₀ and is then held, Pa; zero for t ≤ 0.
    #[must_use]
    pub(crate) fn relaxation_stress(&self, strain: f64, ramp_time_s: f64, time_s: f64) -> f64 {
        match &self.law {
            Law::KelvinVoigt(tissue) => tissue.relaxation_stress(strain, ramp_time_s, time_s).0,
            Law::Composed { model, .. } => ramp(model, strain, ramp_time_s, &[time_s])[0],
        }
    }

    /// Strain under a step of stress σ₀ at t = 0; zero for t ≤ 0.
    #[must_use]
    pub fn creep_strain(&self, stress_pa: f64, time_s: f64) -> f64 {
        creep(&self.material.model, stress_pa, &[time_s])[0]
    }

    /// [`relaxation_stress`](Self::relaxation_stress) of ticks that come one after the other, at times n·T.
    pub(crate) fn relaxation(
        &self,
        strain: f64,
        ramp_time_s: f64,
        sample_time: Seconds,
    ) -> Box<dyn FnMut(u64, f64) -> f64 + '_> {
        match &self.law {
            Law::KelvinVoigt(tissue) => {
                Box::new(move |_, t| tissue.relaxation_stress(strain, ramp_time_s, t).0)
            }
            Law::Composed { model, .. } => Box::new(by_ticks(sample_time, move |times| {
                ramp(model, strain, ramp_time_s, times)
            })),
        }
    }

    /// [`creep_strain`](Self::creep_strain) likewise.
    pub(crate) fn creep(
        &self,
        stress_pa: f64,
        sample_time: Seconds,
    ) -> impl FnMut(u64, f64) -> f64 + '_ {
        by_ticks(sample_time, move |times| {
            creep(&self.material.model, stress_pa, times)
        })
    }
}

/// Many times at once cost a model little more than one.
fn by_ticks(
    sample_time: Seconds,
    many: impl Fn(&[f64]) -> Vec<f64>,
) -> impl FnMut(u64, f64) -> f64 {
    let (mut first, mut values) = (0, Vec::new());
    move |tick, _| {
        let known = tick
            .checked_sub(first)
            .and_then(|at| values.get(at as usize));
        if let Some(value) = known {
            return *value;
        }
        let times: Vec<f64> = (tick..tick + AT_ONCE)
            .map(|tick| tick as f64 * sample_time.0)
            .collect();
        (first, values) = (tick, many(&times));
        values[0]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::relative_error;
    use haptic_tissue::Material;
    use std::path::Path;

    fn tissue(modulus_pa: f64, viscosity_pa_s_alpha: f64, order: f64) -> ModelledTissue {
        let text = format!(
            "name = \"piece\"\ndescription = \"\"\n[parameters]\nelastic_modulus_pa = {modulus_pa:?}\n\
             viscosity_pa_s_alpha = {viscosity_pa_s_alpha:?}\norder = {order:?}\n\
             [source]\ncitation = \"\"\nconditions = \"\"\nchecked = false\n"
        );
        let material = Material::parse(Path::new("piece.toml"), &text).expect("valid");
        ModelledTissue::new(material).expect("valid")
    }

    #[test]
    fn creep_agrees_with_50_digits() {
        // tests/golden/make_golden.py: E_α(−z). With E₀ = 1, η = 1/z, t = 1 the argument is −z.
        let golden = include_str!("../../../tests/golden/mittag_leffler.csv");
        for line in golden.lines().skip(1) {
            let cells: Vec<f64> = line
                .split(',')
                .map(|c| c.parse().expect("number"))
                .collect();
            let (alpha, z, value) = (cells[0], cells[1], cells[2]);
            let have = tissue(1.0, 1.0 / z, alpha).creep_strain(1.0, 1.0);
            assert!(
                (have - (1.0 - value)).abs() < 1e-12,
                "α {alpha} z {z}: {have}"
            );
        }
    }

    #[test]
    fn creep_of_a_soft_spring_tends_to_creep_without_one() {
        let with = tissue(1e-4, 8650.0, 0.2247);
        let without = tissue(0.0, 8650.0, 0.2247);
        for t in [0.01, 1.0, 200.0] {
            let (a, b) = (with.creep_strain(100.0, t), without.creep_strain(100.0, t));
            assert!(relative_error(a, b) < 1e-6, "t {t}: {a} {b}");
        }
    }
}
