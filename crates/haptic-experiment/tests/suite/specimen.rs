//! The largest specimen of a tissue that a device renders, by trial: on its line it ends where the map of all walls does, and the sums of
//! its model say.

use crate::design::number;
use crate::law::{DEVICE, T, TissueFile, ask, gain_margin};
use haptic_tissue::{Model, ModelKind};
use serde_json::Value;
use testkit::{Random, assert_relative};

/// Of a trial, short.
const TRIAL: &str = "duration_s = 2\n";

/// A spring beside a spring-pot.
fn pot(k: f64, b: f64, order: f64) -> TissueFile {
    let names = ["elastic_modulus_pa", "viscosity_pa_s_alpha", "order"];
    TissueFile::with("", names.into_iter(), &[k, b, order])
}

#[test]
fn a_specimen_ends_where_its_line_leaves_the_map_of_all_walls() {
    let mut random = Random(69);
    for case in 0..testkit::cases(4) {
        // Bisected to 2e-4, both. The first is the model of Kelvin and Voigt.
        let order = if case == 0 {
            1.0
        } else {
            random.between(0.2, 1.0)
        };
        let keys = format!("{DEVICE}{TRIAL}");
        let of_map = format!("sample_time_s = {T}\norders = [{order}]\npoints = 4\n{keys}");
        let map = ask("zwidth", &of_map).expect("a map");
        let boundary = &map["orders"][0]["boundary"];
        let share = random.log_between(0.01, 3.0);
        let grown = |k: f64, point: &Value| {
            let b = number(point, "dissipation");
            let report = pot(share * k, share * b, order).ask("zwidth", &keys);
            share * number(&report, "largest_scale")
        };
        let k = number(&boundary[2], "stiffness_max");
        assert_relative("on a line", grown(k, &boundary[2]), 1.0, 2e-4);
        // Without a spring it is at the end of the axis, where the last wall of the map has a soft one that takes its share.
        assert_relative("no spring", grown(0.0, &boundary[3]), 1.0, 0.01);
    }
}

#[test]
fn a_composed_tissue_grows_up_to_what_the_sums_of_its_model_say() {
    let kinds = [
        ModelKind::FractionalMaxwell,
        ModelKind::FractionalZener,
        ModelKind::FractionalPoyntingThomson,
    ];
    let mut random = Random(30);
    for case in 0..testkit::cases(9) {
        let kind = kinds[case % kinds.len()];
        let mut drawn = || random.log_between(10.0, 300.0);
        let [first, second, spring] = [drawn(), drawn(), drawn()];
        let beta = random.between(0.0, 0.5);
        let alpha = random.between(beta + 0.05, 1.0);
        let mut numbers = vec![first, alpha, second, beta, spring];
        numbers.truncate(kind.parameters().len());
        let keys = format!("{DEVICE}duration_s = 10\nsensor_noise_m = 1e-7\nseed = {case}\n");
        let report = TissueFile::of(kind, &numbers).ask("zwidth", &keys);
        let model = Model::from_parameters(kind, &numbers).expect("a model");
        let margin = gain_margin(|w| model.modulus((1.0 - w) / T));
        let what = format!("{kind:?} {numbers:?}");
        assert_relative(&what, number(&report, "analysis_scale"), margin, 1e-5);
        assert_relative(&what, number(&report, "largest_scale"), margin, 0.05);
        assert_eq!(report["disagreements"], 0, "{what}");
    }
}
