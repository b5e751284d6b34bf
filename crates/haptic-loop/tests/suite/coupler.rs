//! The virtual coupler: its defining sums, closed forms, energy, both precisions.

use crate::T;
use fracdiff::{Operator, Real, Scheme, Seconds, ShortMemory, grunwald_weights};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{Environment, VirtualCoupler, VirtualObject, deflection_order};
use nalgebra::{SVector, vector};
use testkit::operator::order;
use testkit::{Random, assert_refused};

fn object([mass, damping, stiffness]: [f64; 3]) -> VirtualObject {
    VirtualObject::new(
        Kilograms(mass),
        NewtonSecondsPerMetre(damping),
        NewtonsPerMetre(stiffness),
    )
    .expect("valid")
}

/// Coupler with a memory that reaches over any run of up to 1024 samples.
fn coupler(mu: f64, [k_c, b_c]: [f64; 2], behind: VirtualObject) -> Long {
    let operator = ShortMemory::new(deflection_order(order(mu)).expect("valid"), T);
    VirtualCoupler::new(k_c, b_c, operator.expect("valid"), behind, T).expect("valid")
}

type Long = VirtualCoupler<f64, ShortMemory<f64, 1024>>;

/// The same coupler in full memory, as experiments run it.
fn full<F: Real>(
    mu: f64,
    [k_c, b_c]: [f64; 2],
    behind: VirtualObject,
) -> VirtualCoupler<F, Operator<F>> {
    let scheme: Scheme = "full".parse().expect("valid");
    let operator = scheme.build(deflection_order(order(mu)).expect("valid"), T, 1e5);
    VirtualCoupler::new(k_c, b_c, operator.expect("valid"), behind, T).expect("valid")
}

/// Force on the object F and its place, sample by sample.
fn run<F: Real, E: Environment<F, 1>>(
    coupler: &E,
    positions: &[f64],
    place: impl Fn(&E::History) -> f64,
) -> Vec<[f64; 2]> {
    let mut history = coupler.at_rest();
    let samples = positions.iter().map(|&x| {
        let x = SVector::from([F::from_f64(x)]);
        let force = -coupler.force(&history, &x)[0].to_f64();
        coupler.advance(&mut history, &x);
        [force, place(&history)]
    });
    samples.collect()
}

/// A random walk with velocities, m.
fn motion(random: &mut Random, samples: usize) -> Vec<f64> {
    let (mut x, mut v) = (0.0, 0.0);
    let steps = (0..samples).map(|_| {
        v = 0.9 * v + random.between(-0.02, 0.02);
        x += v * T.0;
        x
    });
    steps.collect()
}

/// Coupler and object by their sums, velocity by velocity, and the object by the trapezoidal rule.
///
/// ```text
/// F = k_c·u + b_c·T^μ·Σ c_j(−μ)·u[n−j]
/// ```
fn by_sums(mu: f64, [k_c, b_c]: [f64; 2], behind: [f64; 3], positions: &[f64]) -> Vec<[f64; 2]> {
    let [m, b, k] = behind;
    let t = T.0;
    let weights: Vec<f64> = grunwald_weights(order(-mu)).take(positions.len()).collect();
    let rate = b_c * t.powf(mu);
    let mut u: Vec<f64> = Vec::new();
    let (mut last_x, mut v, mut p, mut net) = (0.0, 0.0, 0.0, 0.0);
    let mut forces = Vec::new();
    for &x in positions {
        let v_h = (x - last_x) / t;
        let past: f64 = (u.iter().rev().zip(&weights[1..]))
            .map(|(u, c)| c * u)
            .sum();
        // F = (k_c + rate)(v_h − v_e) + rate·past; with m > 0: v_e = v + (T/2m)(net' + net), net' = F − b·v_e − k·p',
        // p' = p + (T/2)(v_e + v). With m = 0: F = b·v_e + k·p'. Linear in v_e: by two trials.
        let residual = |v_e: f64| {
            let force = (k_c + rate) * (v_h - v_e) + rate * past;
            let place = p + 0.5 * t * (v_e + v);
            let now = force - b * v_e - k * place;
            if m > 0.0 {
                (v_e - v) - 0.5 * t / m * (now + net)
            } else {
                -now
            }
        };
        let (at_0, at_1) = (residual(0.0), residual(1.0));
        let v_e = -at_0 / (at_1 - at_0);
        let force = (k_c + rate) * (v_h - v_e) + rate * past;
        p += 0.5 * t * (v_e + v);
        net = force - b * v_e - k * p;
        v = v_e;
        u.push(v_h - v_e);
        last_x = x;
        forces.push([force, p]);
    }
    forces
}

/// The largest size among numbers, never quite 0.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(1e-12, |most, number| most.max(number.abs()))
}

#[test]
fn it_is_its_defining_sums() {
    let mut random = Random(11);
    for mu in [0.0, 0.25, 0.5, 0.75, 1.0] {
        for gains in [[3.0, 0.0], [0.0, 400.0], [3.0, 400.0]] {
            for behind in [
                [0.2, 0.0, 0.0],
                [0.2, 0.5, 900.0],
                [0.0, 0.5, 900.0],
                [0.0, 0.0, 900.0],
                [0.0, 2.0, 0.0],
            ] {
                let positions = motion(&mut random, 800);
                let coupler = coupler(mu, gains, object(behind));
                let have = run(&coupler, &positions, |h| coupler.object_position_m(h)[0]);
                let want = by_sums(mu, gains, behind, &positions);
                for k in 0..2 {
                    let scale = largest(want.iter().map(|row| row[k]));
                    for (n, (have, want)) in have.iter().zip(&want).enumerate() {
                        // 800 rounding errors of the velocities, which the sums divide by T.
                        assert!(
                            (have[k] - want[k]).abs() < 1e-9 * scale,
                            "μ {mu}, {gains:?}, {behind:?}, sample {n}, {k}: {} {}",
                            have[k],
                            want[k]
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn in_single_precision_it_stays_close_for_minutes() {
    let mut random = Random(13);
    for mu in [0.5, 1.0] {
        let positions: Vec<f64> = motion(&mut random, 60_000);
        let (gains, behind) = ([2.0, 300.0], object([0.3, 0.4, 700.0]));
        let (double, single) = (
            full::<f64>(mu, gains, behind),
            full::<f32>(mu, gains, behind),
        );
        let want = run(&double, &positions, |h| double.object_position_m(h)[0]);
        let have = run(&single, &positions, |h| {
            f64::from(single.object_position_m(h)[0])
        });
        let reached = largest(positions.iter().copied());
        let largest = largest(want.iter().map(|row| row[0]));
        // k_c·ε·|x|/T is what one rounding of the position costs a damper; ten such are allowed for.
        let rounding = 10.0 * (gains[0] / T.0 + gains[1]) * f64::from(f32::EPSILON) * reached;
        for (n, (have, want)) in have.iter().zip(&want).enumerate() {
            let off = (have[0] - want[0]).abs();
            assert!(
                off < rounding + 1e-3 * largest,
                "μ {mu}, sample {n}: {off} N of {largest} N"
            );
        }
    }
}

/// Energy that came in through the device, J, its least so far, and the sum of all that moved.
fn energy<F: Real>(coupler: &impl Environment<F, 1>, positions: &[f64]) -> (f64, f64) {
    let forces = run(coupler, positions, |_| 0.0);
    let (mut last, mut sum, mut least, mut moved) = (0.0, 0.0, 0.0_f64, 0.0);
    for (&x, [force, _]) in positions.iter().zip(forces) {
        let x = F::from_f64(x).to_f64();
        sum += force * (x - last);
        moved += (force * (x - last)).abs();
        least = least.min(sum);
        last = x;
    }
    (least, moved)
}

#[test]
fn coupler_and_object_never_give_more_than_was_put_in() {
    let mut random = Random(14);
    for case in 0..testkit::cases(150_usize) {
        let mu = random.one_of(&[0.0, 0.1, 0.5, 0.9, 1.0]);
        let gains = [random.or_nothing(20.0), random.log_between(1.0, 1e4)];
        let behind = object([
            random.or_nothing(1.0),
            random.or_nothing(2.0),
            random.log_between(1.0, 1e4),
        ]);
        let positions = motion(&mut random, 2000);
        let (least, moved) = energy(&full::<f64>(mu, gains, behind), &positions);
        assert!(
            least >= -1e-12 * moved,
            "case {case}, μ {mu}: {least} J of {moved} J"
        );
        let (least, moved) = energy(&full::<f32>(mu, gains, behind), &positions);
        assert!(
            least >= -1e-4 * moved,
            "f32, case {case}, μ {mu}: {least} J of {moved} J"
        );
    }
}

#[test]
fn it_hides_no_number_that_is_not_finite() {
    let coupler = full::<f64>(0.5, [1.0, 200.0], object([0.4, 0.0, 500.0]));
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut history = Environment::<f64, 1>::at_rest(&coupler);
        assert!(!coupler.force(&history, &vector![odd])[0].is_finite());
        coupler.advance(&mut history, &vector![odd]);
        assert!(!coupler.force(&history, &vector![0.0])[0].is_finite());
    }
}

#[test]
fn axes_are_coupled_each_by_itself() {
    let coupler = full::<f64>(0.5, [1.0, 200.0], object([0.4, 0.1, 500.0]));
    let mut random = Random(16);
    let (a, b) = (motion(&mut random, 200), motion(&mut random, 200));
    let alone = [run(&coupler, &a, |_| 0.0), run(&coupler, &b, |_| 0.0)];
    let mut history = Environment::<f64, 2>::at_rest(&coupler);
    for n in 0..200 {
        let x = vector![a[n], b[n]];
        let force = coupler.force(&history, &x);
        coupler.advance(&mut history, &x);
        for axis in 0..2 {
            assert_eq!((-force[axis]).to_bits(), alone[axis][n][0].to_bits());
        }
    }
}

#[test]
fn parameters_outside_their_range_are_refused() {
    for (k_c, b_c, t, words) in [
        (-1.0, 1.0, 1e-3, "coupler damping -1 N·s/m"),
        (f64::NAN, 1.0, 1e-3, "coupler damping"),
        (1.0, -2.0, 1e-3, "coupler spring -2"),
        (
            0.0,
            0.0,
            1e-3,
            "coupler spring of a coupler without damping 0",
        ),
        (1.0, 1.0, 0.0, "sample time 0 s"),
    ] {
        let operator = ShortMemory::<f64, 8>::new(order(0.5), T).expect("valid");
        let behind = object([0.1, 0.0, 10.0]);
        let made = VirtualCoupler::new(k_c, b_c, operator, behind, Seconds(t));
        assert_refused(made, words);
    }
    for (m, b, k, words) in [
        (0.0, 0.0, 0.0, "object stiffness of an object without mass"),
        (-1.0, 0.0, 1.0, "object mass -1 kg"),
        (1.0, f64::INFINITY, 1.0, "object damping inf"),
    ] {
        let (m, b, k) = (Kilograms(m), NewtonSecondsPerMetre(b), NewtonsPerMetre(k));
        assert_refused(VirtualObject::new(m, b, k), words);
    }
    assert_refused(
        deflection_order(order(1.25)),
        "order of a coupler 1.25 is not in [0, 1]",
    );
}
