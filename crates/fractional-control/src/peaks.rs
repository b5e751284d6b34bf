//! Where a plant may have a peak narrower than a grid: at its poles that hardly decay or grow.

use crate::Plant;
use core::f64::consts::PI;
use std::sync::OnceLock;
use std::vec::Vec;

/// A pole that decays by less than this share of its turn has a peak that a grid may miss, where a zero is next to it.
const SHARP: f64 = 0.05;

/// The angles, folded into (0, π), by which such poles turn in a sample. Found when first asked for: the poles of a function of a hundred
/// powers cost as much as all else in a verdict. A dead time does not move them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Peaks {
    /// The plant and T, s; `None` of one that has none.
    of: Option<(Plant, f64)>,
    found: OnceLock<Vec<f64>>,
}

impl Peaks {
    pub(crate) fn new(plant: &Plant, sample_time: f64) -> Self {
        Self {
            of: Some((plant.clone(), sample_time)),
            found: OnceLock::new(),
        }
    }

    pub(crate) fn angles(&self) -> &[f64] {
        self.found.get_or_init(|| {
            let of = self.of.as_ref();
            of.map_or_else(Vec::new, |(plant, sample_time)| find(plant, *sample_time))
        })
    }
}

fn find(plant: &Plant, sample_time: f64) -> Vec<f64> {
    let poles = plant.poles().unwrap_or_default().into_iter();
    let sharp = poles.filter(|pole| pole.im > 0.0 && pole.re.abs() < SHARP * pole.im);
    let angles = sharp.map(|pole| {
        let turn = libm::fmod(pole.im * sample_time, 2.0 * PI);
        turn.min(2.0 * PI - turn)
    });
    angles.filter(|angle| *angle > 0.0).collect()
}
