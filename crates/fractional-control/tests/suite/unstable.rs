//! Plants that do not hold themselves, proved for an interval of gains.

use crate::fixture::{bdf2, p, pi};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, PidParameters, Plant, SampledControlLoop};
use testkit::Tested;

fn closed(gains: PidParameters, plant: &Plant, t: Seconds) -> SampledControlLoop {
    let memory = bdf2(1e-6, 1e5 * t.0);
    crate::fixture::closed(gains, plant, memory, t.0)
}

/// The PI that the search must not miss: 9.2 + 41/s has its crossover at 10 rad/s and a margin of 60°.
#[test]
fn the_pi_that_holds_the_simplest_unstable_plant_is_stable_by_hand_and_by_proof() {
    let plant: Plant = "1/(s-1)".parse().expect("valid");
    let pi = pi(9.2, 41.0, 1.0);
    // s² + (9.2k − 1)s + 41k: stable above k = 1/9.2.
    let closed = closed(pi, &plant, Seconds(1e-4));
    assert!(closed.is_stable_over(1.01 / 9.2, 50.0));
    assert!(!closed.with_gain(0.99 / 9.2).verdict().stable);
}

/// k on 1/(s − 1) holds from 1 on, on 1/(s + 1)³ up to 8; sampled with T the boundaries move by O(T).
#[test]
fn an_interval_of_gains_ends_at_the_boundaries_by_hand() -> Tested {
    let t = Seconds(1e-3);
    for (text, gain, ends) in [
        ("1/(s-1)", 4.0, [0.25, 100.0]),
        ("1/(s+1)^3", 2.0, [0.01, 4.0]),
        // s² + s − 2 + k: from 2 on, and the hold ends it far above a hundred times.
        ("1/((s-1)(s+2))", 10.0, [0.2, 100.0]),
    ] {
        let plant: Plant = text.parse()?;
        let closed = closed(p(gain), &plant, t);
        let interval = closed.gain_interval(&closed.margins()).expect("stable");
        for (have, want) in interval.into_iter().zip(ends) {
            assert!((have / want - 1.0).abs() < 0.01, "{text}: {interval:?}");
        }
        assert!(closed.is_stable_over(interval[0], interval[1]));
        // The proof agrees with verdicts one by one, within and beyond.
        for k in 0..40 {
            let at = 0.005 * 10_f64.powf(0.12 * f64::from(k));
            let inside = at >= interval[0] && at <= interval[1];
            let stable = closed.with_gain(at).verdict().stable;
            assert!(stable || !inside, "{text} at {at}");
            assert_eq!(closed.is_stable_over(at, at), stable, "{text} at {at}");
            assert!(
                stable || !closed.is_stable_over(0.5 * at, 2.0 * at),
                "{text} at {at}"
            );
        }
    }
    let lost = closed(p(0.5), &"1/(s-1)".parse()?, t);
    assert_eq!(lost.gain_interval(&lost.margins()), None);
    for [low, high] in [
        [0.0, 1.0],
        [-1.0, 1.0],
        [2.0, 1.0],
        [1.0, f64::INFINITY],
        [f64::NAN, 1.0],
    ] {
        assert!(!closed(p(4.0), &"1/(s-1)".parse()?, t).is_stable_over(low, high));
    }
    Ok(())
}

/// A pole that adds up three times: too small a gain is as wrong as too large a one.
#[test]
fn an_interval_that_ends_on_both_sides_is_proved_between_them() {
    // s³ + k(s + 1)²: stable for k > 1/2. With a dead time of h only up to some π/2h too.
    let plant: Plant = "(s+1)^2/s^3".parse().expect("valid");
    let lagged: Plant = "exp(-0.01s)*(s+1)^2/s^3".parse().expect("valid");
    let t = Seconds(1e-3);
    let (free, late) = (closed(p(1.0), &plant, t), closed(p(1.0), &lagged, t));
    assert!(free.is_stable_over(0.52, 100.0) && !free.is_stable_over(0.48, 1.0));
    let interval = late.gain_interval(&late.margins()).expect("stable");
    assert!(interval[0] > 0.5 && interval[1] < 300.0, "{interval:?}");
    assert!(!late.with_gain(300.0).verdict().stable && !late.is_stable_over(1.0, 300.0));
}

#[test]
fn poles_of_very_small_orders_are_counted() {
    let unstable = |text: &str| {
        let function: FractionalTransferFunction = text.parse().expect("valid");
        function.unstable_poles()
    };
    for small in ["0.01", "0.001", "0.0001"] {
        // −1 is no power s^α of the principal branch; 1 is that of s = 1, 0.5 and 2 those of far below and above.
        assert_eq!(unstable(&format!("1/(s^{small}+1)")), Some(0), "{small}");
        assert_eq!(unstable(&format!("1/(s^{small}-1)")), Some(1), "{small}");
        assert_eq!(unstable(&format!("1/(s^{small}-2)")), Some(1), "{small}");
        assert_eq!(unstable(&format!("1/(s^{small}-0.5)")), Some(1), "{small}");
        assert_eq!(
            unstable(&format!("1/(s^2+s^{small}+1)")),
            Some(0),
            "{small}"
        );
        assert_eq!(
            unstable(&format!("1/(s^1.{small}+s)", small = &small[2..])),
            None
        );
    }
    // The ends of the range: no number of the count is too large.
    assert_eq!(unstable("1/(1e60s^2+1e-60s+1e60)"), None);
    assert_eq!(unstable("1/(1e-60s^2+s+1e60)"), Some(0));
    assert_eq!(unstable("1/(1e-60s^2-s+1e60)"), Some(2));
}
