//! How a specimen is pressed: factors, maps and rendered forces against values with 30 digits
//! (`tests/golden/make_loading_golden.py` of the repository).

use super::T;
use fracdiff::{Operator, Order, Real, Scheme};
use haptic_loop::units::Metres;
use haptic_loop::{
    Contact, DepthMap, Environment, Loading, LoadingKind, LoopParameterError, Modulus, Specimen,
    SpringDamper,
};
use testkit::assert_refused;

fn relative_error(have: f64, want: f64) -> f64 {
    (have / want - 1.0).abs()
}

/// A specimen of a file, and the numbers behind it.
struct Row {
    kind: String,
    specimen: Specimen,
    numbers: Vec<f64>,
}

fn rows(text: &str) -> Vec<Row> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse().ok();
        let kind = LoadingKind::ALL
            .into_iter()
            .find(|kind| kind.name() == cells[0]);
        let loading = Loading {
            area_m2: number(1),
            thickness_m: number(2),
            radius_m: number(3),
            half_angle_rad: number(4),
            bonded: cells[5] == "1",
            ..Loading::new(kind.expect("a kind"))
        };
        let numbers: Vec<f64> = (6..cells.len()).filter_map(number).collect();
        Row {
            kind: line.to_owned(),
            specimen: Specimen::new(loading, numbers[0], numbers[1]).expect("valid"),
            numbers: numbers[2..].to_vec(),
        }
    };
    let rows: Vec<Row> = text.lines().skip(1).map(row).collect();
    assert!(rows.len() > 40);
    rows
}

fn specimens() -> Vec<Row> {
    rows(include_str!("../../../../tests/golden/loading.csv"))
}

/// e of a specimen in a precision.
fn map<F: Real>(specimen: &Specimen, depth: f64) -> f64 {
    let map = specimen.depth_map();
    let map = map.map(|map| map.rounded::<F>().expect("in range"));
    map.map_or(depth, |map| map.at(F::from_f64(depth)).to_f64())
}

#[test]
fn factors_and_maps_agree_with_30_digits() {
    for Row {
        kind,
        specimen,
        numbers,
    } in specimens()
    {
        let [shear, young, depth, want] = numbers[..] else {
            panic!("{kind}");
        };
        for (modulus, want) in [(Modulus::Shear, shear), (Modulus::Young, young)] {
            let error = relative_error(specimen.shape(modulus), want);
            assert!(error < 1e-15, "{kind}: {error:e}");
        }
        let error = relative_error(map::<f64>(&specimen, depth), want);
        assert!(error < 4e-15, "{kind}: {error:e}");
        let error = relative_error(map::<f32>(&specimen, depth), want);
        assert!(error < 2e-6, "{kind}: {error:e} in single precision");
    }
}

#[test]
fn slope_and_depth_are_those_of_the_map() {
    for row in specimens() {
        let Some(map) = row.specimen.depth_map() else {
            continue;
        };
        let depth = row.numbers[2];
        // A central difference of h = 1e-5 δ: its own error is h²/6 of the third derivative, and 2e-11 of rounding.
        let step = 1e-5 * depth;
        let difference = (map.at(depth + step) - map.at(depth - step)) / (2.0 * step);
        let error = relative_error(map.slope(depth), difference);
        assert!(error < 1e-8, "{}: {error:e}", row.kind);
        let back = map.depth(map.at(depth));
        let error = relative_error(back, depth);
        assert!(error < 1e-14, "{}: {error:e}", row.kind);
    }
}

/// 1/s, c₀ to c₅, q of a root, and of an exponential.
const ROOT: [f64; 8] = [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const GROWTH: [f64; 8] = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// The largest error of e over the depths from 2^`least` to 2^`most`, in units of the last place.
fn worst<F: Real>(numbers: [f64; 8], [least, most]: [f64; 2], want: fn(f64) -> f64) -> f64 {
    let map = DepthMap::<F>::new(numbers).expect("a map");
    let steps = 20_000;
    let exponent = |n: i32| least + (most - least) * f64::from(n) / f64::from(steps);
    let error = |n: i32| {
        let depth = F::from_f64(exponent(n).exp2());
        let have = map.at(depth).to_f64();
        relative_error(have, want(depth.to_f64())) / F::EPSILON.to_f64()
    };
    (0..=steps).map(error).fold(0.0, f64::max)
}

#[test]
fn root_and_exponential_are_right_to_some_units_of_the_last_place() {
    let root = |x: f64| x * x.sqrt();
    // The product with the depth has half a unit too.
    let errors = [
        worst::<f32>(ROOT, [-80.0, 80.0], root),
        worst::<f64>(ROOT, [-600.0, 600.0], root),
    ];
    assert!(errors.iter().all(|&error| error < 2.0), "{errors:?}");
    let near = [
        worst::<f32>(GROWTH, [-30.0, -1.0], f64::exp_m1),
        worst::<f64>(GROWTH, [-60.0, -5.0], f64::exp_m1),
    ];
    assert!(near.iter().all(|&error| error < 2.5), "{near:?}");
    // Further out e^x makes the rounding of x, and of each doubling, x times as large.
    let far = [
        worst::<f32>(GROWTH, [-1.0, 3.0], f64::exp_m1) / 8.0,
        worst::<f32>(GROWTH, [-1.0, 6.4], f64::exp_m1) / 84.0,
        worst::<f64>(GROWTH, [-5.0, 9.4], f64::exp_m1) / 676.0,
    ];
    assert!(far.iter().all(|&error| error < 3.0), "{far:?}");
}

#[test]
fn depths_without_a_map_of_their_own_stay_what_they_are() {
    for numbers in [ROOT, GROWTH] {
        let map = DepthMap::<f32>::new(numbers).expect("a map");
        for depth in [0.0, -0.5] {
            assert_eq!(map.at(depth).to_bits(), f32::to_bits(depth));
        }
        assert!(map.at(f32::NAN).is_nan());
        assert!(!map.at(f32::INFINITY).is_finite());
    }
    let map = DepthMap::<f32>::new(GROWTH).expect("a map");
    for depth in [89.0, 1e4, 1e30] {
        assert!(!map.at(depth).is_finite(), "{depth}");
    }
}

#[test]
fn what_is_no_specimen_and_no_map_is_refused() {
    let bare = Loading::new(LoadingKind::Sphere);
    let sphere = Loading {
        radius_m: Some(5e-3),
        ..bare
    };
    let cone = |angle| Loading {
        half_angle_rad: Some(angle),
        ..Loading::new(LoadingKind::Cone)
    };
    let layer = |bonded| Loading {
        thickness_m: Some(1e-3),
        bonded,
        ..sphere
    };
    let (mut flat, mut wide, mut pointed, mut glued) = (sphere, sphere, sphere, sphere);
    (flat.radius_m, wide.area_m2) = (Some(0.0), Some(1.0));
    (pointed.half_angle_rad, glued.bonded) = (Some(1.0), true);
    for (loading, nu, b, words) in [
        (bare, 0.5, 0.0, "loading sphere needs indenter radius"),
        (sphere, 0.51, 0.0, "Poisson's ratio"),
        (sphere, -0.1, 0.0, "Poisson's ratio"),
        (sphere, f64::NAN, 0.0, "Poisson's ratio"),
        (sphere, 0.5, -1.0, "stiffening"),
        (sphere, 0.5, 101.0, "stiffening"),
        (flat, 0.5, 0.0, "indenter radius"),
        (wide, 0.5, 0.0, "area has no effect"),
        (pointed, 0.5, 0.0, "half angle has no effect"),
        (glued, 0.5, 0.0, "loading sphere needs thickness"),
        (cone(1.6), 0.5, 0.0, "half angle"),
        (cone(1.0), 0.5, 1.0, "stiffening under a cone"),
        (
            layer(true),
            0.4,
            0.0,
            "Poisson's ratio of a bonded specimen",
        ),
        (layer(false), 0.4, 0.0, "Poisson's ratio of a layer"),
    ] {
        assert_refused(Specimen::new(loading, nu, b), words);
    }
    for (at, bad) in [
        (0, 0.0),
        (1, -1.0),
        (2, f64::NAN),
        (7, f64::INFINITY),
        (2, 0.0),
        (7, 1e39),
    ] {
        let mut numbers = ROOT;
        numbers[at] = bad;
        let refused: Result<DepthMap<f32>, LoopParameterError> = DepthMap::new(numbers);
        assert!(refused.is_err(), "{at} {bad}");
        assert_eq!(DepthMap::of(numbers.map(|n| n as f32)), None, "{at} {bad}");
    }
}

const ORDER: f64 = 0.2247;

/// The force in each tick of the file's ramp to 1 mm in 1 s and hold, in tissue of 1 kPa·s^α, α the order; N.
fn rendered<F: Real>(specimen: &Specimen, scheme: &str) -> Vec<f64> {
    let order = Order::new(ORDER).expect("valid");
    let scheme: Scheme = scheme.parse().expect("valid");
    let operator: Operator<F> = scheme.build(order, T, 1e4).expect("fits");
    let tissue = SpringDamper::new(0.0, 1e3 * specimen.shape(Modulus::Shear), operator);
    let contact = Contact::at(Metres(0.0), tissue.expect("valid")).expect("valid");
    let map = specimen.depth_map();
    let contact = contact.with_depth_map(map.map(|map| map.rounded().expect("in range")));
    let mut history = Environment::<F, 1>::at_rest(&contact);
    let tick = |n: u32| {
        let depth = [F::from_f64(1e-3 * (f64::from(n) * T.0).min(1.0))].into();
        let (force, input) = contact.force_and_input(&history, &depth);
        assert_eq!(force, contact.force(&history, &depth));
        contact.advance_input(&mut history, &input);
        -force[0].to_f64()
    };
    (0..=5000).map(tick).collect()
}

#[test]
fn a_rendered_contact_is_that_of_lee_and_radok() {
    let rows = rows(include_str!("../../../../tests/golden/loading_force.csv"));
    for of_one in rows.chunk_by(|a, b| a.specimen == b.specimen) {
        for scheme in ["full", "piecewise-linear", "full-bdf2"] {
            let double = rendered::<f64>(&of_one[0].specimen, scheme);
            let single = rendered::<f32>(&of_one[0].specimen, scheme);
            for Row { kind, numbers, .. } in of_one {
                let (time, want) = (numbers[0], numbers[1]);
                let n = (time / T.0).round() as usize;
                let error = relative_error(double[n], want);
                // Grünwald's sum is that of μT/2 before. From 0.1 s after the corner at 1 s this is at most 1.3e-4.
                let lag_s = 0.5 * ORDER * T.0;
                let late = (double[n] - double[n - 1]).abs() / T.0 * lag_s / want;
                let bound = if scheme == "full" {
                    1.03 * late + 1e-6
                } else {
                    6e-5
                };
                assert!(error < bound, "{scheme}, {kind}: {error:e}, {bound:e}");
                assert!(bound < 1.3e-4 || time <= 1.0, "{kind}: {bound:e}");
                let error = relative_error(single[n], double[n]);
                assert!(
                    error < 2e-6,
                    "{scheme}, {kind}: {error:e} in single precision"
                );
            }
        }
    }
}
