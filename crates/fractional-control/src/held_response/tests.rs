use super::HeldResponse;
use crate::Plant;
use crate::enclosure::Arc;
use core::f64::consts::PI;
use std::vec::Vec;

fn held(plant: &str, sample_time_s: f64) -> HeldResponse {
    let plant: Plant = plant.parse().expect("valid");
    HeldResponse::new(&plant, sample_time_s).expect("a transfer function")
}

const PLANTS: [&str; 7] = [
    "1/s^0.5",
    "exp(-0.3s)/s^1.2",
    "(s^0.3+2)/(0.8s^2.2+0.5s^0.9+1)",
    "(2s^0.5+0.1)/(s^0.5+1)",
    "exp(-0.25s)*(3s^1.5+1)/(s^1.5+2s+5)",
    "1/(s^2+0.001s+4)/(s^0.5+1)",
    "1/(s^1.5-s+2)",
];

/// Arcs of widths over decades, by their ends.
fn arcs() -> Vec<Arc> {
    let ends = (0..60).flat_map(|k| {
        let low = 1e-4 * libm::pow(0.99 * PI / 1e-4, f64::from(k) / 60.0);
        [1e-3, 0.03, 0.3].map(|share| (low, (low * (1.0 + share)).min(PI)))
    });
    ends.map(|(low, high)| Arc::new(low, high)).collect()
}

#[test]
fn an_arc_holds_what_lies_on_it() {
    for text in PLANTS {
        for sample_time_s in [0.1, 1.0] {
            let plant = held(text, sample_time_s);
            let mut bounded = 0;
            for arc in arcs() {
                let own = plant.enclosed(&arc);
                bounded += usize::from(own.rate.is_finite());
                for k in 0..=8 {
                    let theta = arc.low + (arc.high - arc.low) * f64::from(k) / 8.0;
                    let off = (plant.at(theta) - own.value).norm();
                    // The far end of the sum is an estimate.
                    let most = own.rate * arc.half_width() + 1e-6 * own.value.norm();
                    assert!(
                        off <= most || !own.rate.is_finite(),
                        "{text} {sample_time_s} {arc:?}: {off} {most}"
                    );
                    assert!(
                        plant.at(theta).norm() <= own.size * (1.0 + 1e-6) || !own.rate.is_finite()
                    );
                }
            }
            assert!(bounded > 120, "{text} {sample_time_s}: {bounded}");
        }
    }
}
