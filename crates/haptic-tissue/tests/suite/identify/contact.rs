//! Where an indenter touches, and what its force is without: the truth comes out, as often as the intervals promise.

use super::candidate;
use haptic_loop::{Loading, LoadingKind, Specimen};
use haptic_tissue::identify::{
    Baseline, ContactPoint, Identification, IdentifyError, Options, Record, identify,
};
use haptic_tissue::{Model, ModelKind};
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;

/// V, Pa·s^0.2, and the order of the tissue.
const TISSUE: [f64; 2] = [3000.0, 0.2];
/// Depth of the press, m.
const DEPTH: f64 = 1e-3;

fn sphere() -> Specimen {
    let loading = Loading {
        radius_m: Some(5e-3),
        ..Loading::new(LoadingKind::Sphere)
    };
    Specimen::new(loading, 0.5, 0.0).expect("a sphere")
}

/// Times, depths from the contact on and forces of a press: at rest, a ramp of 1 s, a hold.
struct Press {
    times: Vec<f64>,
    depths: Vec<f64>,
    forces: Vec<f64>,
}

impl Press {
    /// From a height above the tissue.
    fn new(height: f64) -> Self {
        let rest = if height > 0.0 { 0.0 } else { 2.0 };
        let times: Vec<f64> = (0..200)
            .map(|n| 0.02 * f64::from(n))
            .chain((0..200).map(|n| 4.0 * 15.75_f64.powf(f64::from(n) / 199.0)))
            .collect();
        let depth = |t: f64| -height + (DEPTH + height) * (t - rest).clamp(0.0, 1.0);
        let fine: Vec<f64> = (0..63_000).map(|n| 1e-3 * f64::from(n)).collect();
        let map = sphere().depth_map().expect("of a sphere");
        let strains: Vec<f64> = fine.iter().map(|t| map.at(depth(*t).max(0.0))).collect();
        // The motion is over after 4 s: the samples of the hold are enough.
        let fine: Vec<f64> = fine[..4000]
            .iter()
            .copied()
            .chain(times[200..].iter().copied())
            .collect();
        let strains: Vec<f64> = fine
            .iter()
            .map(|t| {
                if *t < 4.0 {
                    strains[(t * 1e3).round() as usize]
                } else {
                    map.at(DEPTH)
                }
            })
            .collect();
        let model = Model::from_parameters(ModelKind::SpringPot, &TISSUE).expect("valid");
        let stress = model.stress(&fine, &strains);
        let shape = sphere().shape(sphere().loading().kind.modulus());
        let at = |t: f64| fine.partition_point(|fine| *fine < t - 1e-6);
        Self {
            forces: times.iter().map(|t| shape * stress[at(*t)]).collect(),
            depths: times.iter().map(|t| depth(*t)).collect(),
            times,
        }
    }

    /// With the axis shifted, m, an offset and noise, shares of the largest force.
    fn record(
        &self,
        contact: ContactPoint,
        shift: f64,
        offset: f64,
        noise: f64,
        seed: u64,
    ) -> Result<Record, IdentifyError> {
        let mut generator = Pcg64::seed_from_u64(seed);
        let most = self.forces.iter().copied().fold(0.0, f64::max);
        let forces = self.forces.iter().map(|force| {
            let drawn: f64 = StandardNormal.sample(&mut generator);
            force + most * (offset + noise * drawn)
        });
        let depths = self.depths.iter().map(|depth| depth + shift).collect();
        Record::pressed_from(
            contact,
            self.times.clone(),
            depths,
            forces.collect(),
            &sphere(),
        )
    }
}

fn fitted(record: &Record, baseline: Option<Baseline>) -> Result<Identification, IdentifyError> {
    let options = Options {
        candidates: vec![candidate("spring-pot")],
        baseline,
        ..Options::default()
    };
    identify(record, &options, &|_| ())
}

#[test]
#[ignore = "long: try"]
fn trial() {
    let count: u64 = std::env::var("COUNT")
        .ok()
        .and_then(|c| c.parse().ok())
        .unwrap_or(20);
    for (name, height) in [("rest at contact", 0.0), ("approach", 0.3e-3)] {
        let press = Press::new(height);
        let mut within = [0usize; 4];
        let mut warned = [[0usize; 2]; 3];
        let begin = std::time::Instant::now();
        for seed in 0..count {
            let part = seed as f64 / (count - 1) as f64;
            let shift = 2e-4 * (2.0 * part - 1.0);
            let offset = 0.2 * (2.0 * ((part * 7.3) % 1.0) - 1.0);
            let record = press
                .record(ContactPoint::Fitted, shift, offset, 0.01, seed)
                .expect("valid");
            let found = fitted(&record, Some(Baseline::Constant)).expect("fits");
            let most = press.forces.iter().copied().fold(0.0, f64::max);
            let all = found.fits[0].parameters.iter().chain(&found.beside);
            for (n, (one, truth)) in all.zip([3000.0, 0.2, offset * most, shift]).enumerate() {
                let (low, high) = (one.low_95.unwrap(), one.high_95.unwrap());
                within[n] += usize::from(low <= truth && truth <= high);
                if seed < 4 {
                    println!("{} {} {low} {high} truth {truth}", one.name, one.value);
                }
            }
        }
        println!("{name}: {within:?} of {count}, {:?}", begin.elapsed());
        let begin = std::time::Instant::now();
        for seed in 0..count {
            let part = seed as f64 / (count - 1) as f64;
            for scale in [1.0, 0.1, 0.02] {
                let shift = scale * 2e-4 * (2.0 * part - 1.0);
                let offset = scale * 0.2 * (2.0 * ((part * 7.3) % 1.0) - 1.0);
                let Ok(record) = press.record(ContactPoint::Zero, shift, offset, 0.01, seed) else {
                    continue;
                };
                let found = fitted(&record, None).expect("fits");
                let off = (found.fits[0].parameters[0].value / 3000.0 - 1.0).abs();
                let group = if off > 0.05 {
                    0
                } else if off < 0.01 {
                    2
                } else {
                    1
                };
                let said = found
                    .warnings
                    .iter()
                    .any(|one| one.contains("fits better with"));
                warned[group][0] += 1;
                warned[group][1] += usize::from(said);
                if (group == 0) != said && group != 1 || seed < 2 {
                    println!("{shift} {offset} off {off} {:?}", found.warnings);
                }
            }
        }
        println!("{name}: warned {warned:?}, {:?}", begin.elapsed());
    }
}
