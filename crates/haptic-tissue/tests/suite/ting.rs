//! Indentation that shrinks, against an independent quadrature.

use haptic_loop::{DepthMap, Loading, LoadingKind, Specimen};
use haptic_tissue::indentation::ting;
use haptic_tissue::{Model, ModelKind};
use testkit::assert_close;

/// Results of `golden/ting/make_golden.py`: its triangle of depth, its models and its maps.
const GOLDEN: &str = include_str!("../golden/ting/ting.csv");

fn model(name: &str) -> Model {
    let (kind, values): (_, &[f64]) = match name {
        "spring-pot" => (ModelKind::SpringPot, &[1000.0, 0.25]),
        "zener" => (ModelKind::Zener, &[500.0, 2000.0, 400.0]),
        _ => (
            ModelKind::FractionalZener,
            &[1500.0, 0.7, 3000.0, 0.15, 400.0],
        ),
    };
    Model::from_parameters(kind, values).expect("valid")
}

fn map(name: &str) -> Option<DepthMap<f64>> {
    let mut loading = match name {
        "punch" => return None,
        "cone" => Loading::new(LoadingKind::Cone),
        _ => Loading::new(LoadingKind::Sphere),
    };
    match name {
        "cone" => loading.half_angle_rad = Some(1.0),
        _ => loading.radius_m = Some(4e-3),
    }
    if name == "layer" {
        (loading.bonded, loading.thickness_m) = (true, Some(3e-3));
    }
    Specimen::new(loading, 0.5, 0.0).expect("valid").depth_map()
}

/// Motion in within 1 s, 1 mm deep, and out at twice the speed; 1 ms apart on the way in and 5 ms on the way out.
fn triangle() -> (Vec<f64>, Vec<f64>) {
    let way_in = (0..=1000).map(|n| (1e-3 * f64::from(n), 1e-6 * f64::from(n)));
    let way_out = (1..=100).map(|n| (1.0 + 5e-3 * f64::from(n), 1e-3 - 1e-5 * f64::from(n)));
    way_in.chain(way_out).unzip()
}

#[test]
fn a_triangle_of_depth_is_that_of_an_independent_quadrature() {
    let (times, depths) = triangle();
    let mut worst: f64 = 0.0;
    for name in ["spring-pot", "zener", "fractional-zener"] {
        for shape in ["punch", "sphere", "cone", "layer"] {
            let touch = ting(&model(name), map(shape).as_ref(), &times, &depths);
            assert_eq!(touch.force_per_shape.len(), times.len(), "{name} {shape}");
            let most = touch.force_per_shape.iter().copied().fold(0.0, f64::max);
            for row in GOLDEN.lines().skip(1) {
                let cells: Vec<&str> = row.split(',').collect();
                if cells[..2] != [name, shape] {
                    continue;
                }
                let [time, want] = [2, 3].map(|n| cells[n].parse::<f64>().expect("a number"));
                let sample = times.iter().position(|t| (t - time).abs() < 1e-9);
                let have = touch.force_per_shape[sample.expect("a sample")];
                worst = worst.max((have - want).abs() / most);
                assert_close(row, have, want, 1e-6 * most);
            }
        }
    }
    println!("worst {worst:.1e}");
}

/// A spring E beside a dashpot η: the depth at t₁ is E·x₁ = E·x + η·ẋ.
#[test]
fn a_dashpot_lets_go_at_once_by_what_it_bears() {
    let kelvin_voigt = Model::from_parameters(ModelKind::KelvinVoigt, &[1000.0, 50.0]);
    let kelvin_voigt = kelvin_voigt.expect("valid");
    let (times, depths) = triangle();
    let cone = map("cone").expect("a map");
    let touch = ting(&kelvin_voigt, Some(&cone), &times, &depths);
    for (n, (&depth, &force)) in depths
        .iter()
        .zip(&touch.force_per_shape)
        .enumerate()
        .skip(1001)
    {
        // η/E = 50 ms, ẋ = −2 mm/s.
        let held = (depth - 0.05 * 2e-3).max(0.0);
        assert_close(&n.to_string(), force, 1000.0 * cone.at(held), 1e-6);
    }
}

/// Where the contact grows again the theory of one retraction ends, and so does the result; before, both laws are one.
#[test]
fn the_result_ends_where_the_contact_grows_again() {
    let (model, sphere) = (model("zener"), map("sphere").expect("a map"));
    let (times, mut depths) = triangle();
    for depth in &mut depths[1021..] {
        *depth = 8e-4;
    }
    let held = ting(&model, Some(&sphere), &times, &depths);
    assert_eq!(held.shrinks_from, 1001);
    // The surface follows: the contact grows from the first sample of the hold on.
    assert_eq!(held.force_per_shape.len(), 1021);
    let growing = ting(&model, Some(&sphere), &times[..1001], &depths[..1001]);
    assert_eq!(
        (growing.shrinks_from, growing.force_per_shape.len()),
        (1001, 1001)
    );
    assert_eq!(growing.force_per_shape[..], held.force_per_shape[..1001]);
    assert!(ting(&model, None, &[], &[]).force_per_shape.is_empty());
}

/// A touch that begins between two samples is one that begins there.
#[test]
fn contact_begins_at_depth_0() {
    let (model, sphere) = (model("fractional-zener"), map("sphere").expect("a map"));
    let shifted = ting(
        &model,
        Some(&sphere),
        &[0.0, 1.0, 1.5, 1.7],
        &[-1e-3, 1e-3, 2e-3, 1e-3],
    );
    let direct = ting(
        &model,
        Some(&sphere),
        &[0.5, 1.0, 1.5, 1.7],
        &[0.0, 1e-3, 2e-3, 1e-3],
    );
    assert_eq!(shifted.force_per_shape[0].to_bits(), 0.0_f64.to_bits());
    for n in 1..4 {
        let (have, want) = (shifted.force_per_shape[n], direct.force_per_shape[n]);
        assert_close(&n.to_string(), have, want, 1e-6 * want);
    }
}

/// A ramp to a depth, of two samples, and a long hold with many. On a cone e = e₁·(t/T)², and with G = V·t^(−α)/Γ(1 − α)
/// ```text
/// F/γ = 2·V·e₁/(Γ(1 − α)·T²) · [t·u^(1−α)/(1 − α) − u^(2−α)/(2 − α)]  from u = t − T to t
/// ```
#[test]
fn a_ramp_of_two_samples_is_as_good_as_one_of_many() {
    let (viscosity, order, ramp_s, depth) = (1000.0, 0.25, 0.2, 1e-3);
    let cone = map("cone").expect("a map");
    let (begin, _) = libm::lgamma_r(1.0 - order);
    let closed = |t: f64| {
        let part =
            |u: f64| t * u.powf(1.0 - order) / (1.0 - order) - u.powf(2.0 - order) / (2.0 - order);
        let scale = 2.0 * viscosity * cone.at(depth) / (begin.exp() * ramp_s * ramp_s);
        scale * (part(t) - part(t - ramp_s))
    };
    for hold in [1, 100, 10_000] {
        let after = (0..=hold).map(|n| ramp_s + 20.0 * f64::from(n) / f64::from(hold));
        let times: Vec<f64> = std::iter::once(0.0).chain(after).collect();
        let depths: Vec<f64> = times
            .iter()
            .map(|t| depth * (t / ramp_s).min(1.0))
            .collect();
        let touch = ting(&model("spring-pot"), Some(&cone), &times, &depths);
        let most = touch.force_per_shape[1];
        for (n, (&time, &have)) in times.iter().zip(&touch.force_per_shape).enumerate().skip(1) {
            assert_close(&format!("{n} of {hold}"), have, closed(time), 1e-6 * most);
        }
    }
}
