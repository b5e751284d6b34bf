//! The pantograph against roots that were found without its closed form, against difference quotients, and there and back.

use haptic_devices::haply::{Pantograph, Posture, Singular, Version};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use testkit::assert_close;

/// A row of `pantograph.csv`.
struct Golden {
    pantograph: Pantograph,
    angles: [f64; 2],
    hand_m: Vector2<f64>,
    jacobian: Matrix2<f64>,
}

fn golden() -> Vec<Golden> {
    let table = include_str!("../pantograph.csv");
    let rows = table.lines().skip(1).map(|line| {
        let numbers = line
            .split(',')
            .map(|number| number.parse().expect("a number"));
        let row: Vec<f64> = numbers.collect();
        let [version, first, second, x, y, j11, j12, j21, j22] = row[..] else {
            panic!("{line}");
        };
        let version = Version::ALL
            .into_iter()
            .find(|v| v.number() == version as u8);
        Golden {
            pantograph: version.expect("2 or 3").model().pantograph,
            angles: [first, second],
            hand_m: Vector2::new(x, y),
            jacobian: Matrix2::new(j11, j12, j21, j22),
        }
    });
    rows.collect()
}

#[test]
fn hand_and_jacobian_are_those_of_roots_found_by_newton() {
    let (mut worst_m, mut worst) = (0.0_f64, 0.0_f64);
    let rows = golden();
    assert_eq!(rows.len(), 300);
    for row in rows {
        let Posture { hand_m, jacobian } = row.pantograph.posture(row.angles).expect("in order");
        worst_m = worst_m.max((hand_m - row.hand_m).amax());
        worst = worst.max((jacobian - row.jacobian).amax());
    }
    println!("hand {worst_m:e} m, Jacobian {worst:e} m/rad");
    // Metres; the arms are 0.09 m long.
    assert!(worst_m < 1e-12 * 0.09, "{worst_m:e} m");
    assert!(worst < 1e-12, "{worst:e} m/rad");
}

#[test]
fn the_homes_of_both_versions_are_in_order() {
    for version in Version::ALL {
        let model = version.model();
        let posture = model.pantograph.posture(model.home()).expect("in order");
        let middle = 0.5 * model.pantograph.base_m;
        assert_close("posture.hand_m.x", posture.hand_m.x, middle, 1e-4);
        // Near the base: 22 and 36 mm from it.
        assert!((0.02..0.04).contains(&posture.hand_m.y), "{posture:?}");
    }
}

#[test]
fn postures_without_a_jacobian_are_named() {
    let two = Version::V2.model().pantograph;
    // Elbows 179.9 mm apart, of 180 mm that the far arms reach.
    let nearly = arms(0.0399);
    let apart = nearly.posture([core::f64::consts::PI, 0.0]);
    let stretched = matches!(apart, Err(Singular::Stretched { sine }) if sine < 0.1);
    assert!(stretched, "{apart:?}");
    let wide = arms(0.05).posture([core::f64::consts::PI, 0.0]);
    let Err(Singular::OutOfReach { apart_m, reach_m }) = wide else {
        panic!("{wide:?}");
    };
    assert!((apart_m - 0.19).abs() < 1e-12 && (reach_m - 0.18).abs() < 1e-12);
    let folded = two.posture([1.5, 1.5]);
    assert!(
        matches!(folded, Err(Singular::Stretched { .. })),
        "{folded:?}"
    );
    // The right arm of the hand at the end of its reach.
    let hand = Vector2::new(0.159_99 * libm::cos(1.9), 0.159_99 * libm::sin(1.9));
    let straight = two.posture(two.angles(hand).expect("just so"));
    assert!(straight.is_err(), "{straight:?}");
    assert_eq!(two.posture([f64::NAN, 1.0]), Err(Singular::NotFinite));
    assert!(two.angles(Vector2::new(0.0, 0.17)).is_err());
}

/// Places of the workspace of both versions.
fn places() -> impl Strategy<Value = (Pantograph, Vector2<f64>)> {
    let versions = prop_oneof![Just(Version::V2), Just(Version::V3)];
    (versions, -0.07..0.07_f64, 0.03..0.14_f64).prop_map(|(version, x, y)| {
        let pantograph = version.model().pantograph;
        (pantograph, Vector2::new(0.5 * pantograph.base_m + x, y))
    })
}

/// The angles and the posture of a hand, if it has any.
fn posed(pantograph: &Pantograph, hand: Vector2<f64>) -> Option<([f64; 2], Posture)> {
    let angles = pantograph.angles(hand).ok()?;
    Some((angles, pantograph.posture(angles).ok()?))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_hand_is_where_its_angles_put_it((pantograph, hand) in places()) {
        let Some((_, posture)) = posed(&pantograph, hand) else { return Ok(()) };
        // The angles are rounded, and the Jacobian is below 1 m/rad.
        prop_assert!((posture.hand_m - hand).amax() < 1e-13, "{posture:?}");
    }

    #[test]
    fn the_jacobian_is_the_difference_quotient((pantograph, hand) in places()) {
        let Some((angles, posture)) = posed(&pantograph, hand) else { return Ok(()) };
        // A fourth-order quotient: truncation h⁴·f⁗/30, rounding 1e-16/h.
        let h = 2e-4;
        for joint in 0..2 {
            let at = |steps: f64| {
                let mut moved = angles;
                moved[joint] += steps * h;
                pantograph.posture(moved).map(|posture| posture.hand_m)
            };
            let (Ok(a), Ok(b), Ok(c), Ok(d)) = (at(-2.0), at(-1.0), at(1.0), at(2.0)) else { continue };
            let quotient = (a - d + (c - b) * 8.0) / (12.0 * h);
            let column = posture.jacobian.column(joint);
            prop_assert!((quotient - column).amax() < 1e-7, "{quotient} {column}");
        }
    }

    #[test]
    fn torques_and_force_are_each_others_inverse(
        (pantograph, hand) in places(), x in -2.0..2.0_f64, y in -2.0..2.0_f64,
    ) {
        let Some((_, posture)) = posed(&pantograph, hand) else { return Ok(()) };
        let force = Vector2::new(x, y);
        let torques = posture.torques(force);
        prop_assert!((posture.force(torques) - force).amax() < 1e-11);
        // Virtual work: f·J·dθ = τ·dθ.
        let turn = Vector2::new(0.3, -0.7);
        let (work, moved) = (force.dot(&(posture.jacobian * turn)), torques.dot(&turn));
        prop_assert!((work - moved).abs() < 1e-15);
    }
}

fn arms(base_m: f64) -> Pantograph {
    Pantograph {
        near_m: 0.07,
        far_m: 0.09,
        base_m,
    }
}
