//! Sets of laws and their mixes, proved, against single loops and against F itself on a fine grid.

use fracdiff::{FrequencyResponse as _, Order, Scheme, Seconds};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    Dynamics, LawElements, LawSet, LoopOperator, PotRange, SampledWall, SetVerdict, prove_laws,
};
use std::f64::consts::PI;
use testkit::{Random, assert_refused};

const T: f64 = 1e-3;

fn pot(size_n_s_alpha_per_m: [f64; 2], order: [f64; 2]) -> LawElements {
    LawElements::Pot(PotRange {
        size_n_s_alpha_per_m,
        order,
    })
}

fn walls(k: [f64; 2], b: [f64; 2], order: [f64; 2]) -> LawElements {
    LawElements::Parallel(Box::new([pot(k, [0.0; 2]), pot(b, order)]))
}

fn proved(device: &Dynamics, sets: &[LawSet<'_>]) -> bool {
    prove_laws(device, T, sets).expect("judges") == SetVerdict::Proved
}

fn device(random: &mut Random) -> Dynamics {
    Dynamics {
        mass_kg: random.log_between(0.03, 0.5),
        damping_n_s_per_m: random.log_between(0.05, 5.0),
        hand_stiffness_n_per_m: random.or_nothing(500.0),
        delay_s: random.or_nothing(3e-3),
        current_lag_s: random.or_nothing(1e-3),
    }
}

fn exact(order: f64) -> LoopOperator {
    let order = Order::new(order).expect("in range");
    LoopOperator::new(Scheme::Exact, order, Seconds(T), 1e6).expect("made")
}

fn wall(k: f64, b: f64, operator: &LoopOperator) -> SampledWall {
    SampledWall {
        stiffness_n_per_m: k,
        dissipation_n_s_mu_per_m: b,
        order: operator.order(),
        sample_time_s: T,
    }
}

fn is_stable(device: &Dynamics, k: f64, b: f64, order: f64) -> bool {
    let operator = exact(order);
    let closed = device.closed(&wall(k, b, &operator), &operator);
    closed.expect("closes").beside_rest().is_stable()
}

/// The largest factor for which this holds, to 1 %; 0 if a millionth does not.
fn largest(holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (1e-6, 1e4);
    if !holds(low) {
        return 0.0;
    }
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        *(if holds(middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

/// Regions of walls, each grown from its soft corner until its proof ends, and until a member is unstable.
fn regions(seed: u64, count: usize, points: usize) {
    let mut random = Random(seed);
    let mut alive = 0;
    for _ in 0..count {
        let device = device(&mut random);
        let low = random.between(0.0, 0.9);
        let order = [low, random.between(low, 1.0)];
        let [k, b] = [
            random.log_between(10.0, 300.0),
            random.log_between(0.1, 5.0),
        ];
        let set = |f: f64| LawSet::Elements(walls([k, k + f * k], [b, b + f * b], order));
        let proof = largest(|f| proved(&device, &[set(f)]));
        let stable = largest(|f| {
            let mut random = Random(seed);
            (0..points).all(|point| {
                let mut share = || {
                    let share = random.share();
                    // Corners first.
                    if point < 64 { share.round() } else { share }
                };
                let [u, v, w] = [share(), share(), share()];
                let mu = order[0] + w * (order[1] - order[0]);
                is_stable(&device, k + u * f * k, b + v * f * b, mu)
            })
        });
        assert!(
            proof <= 1.02 * stable,
            "{device:?} {order:?} {k} {b}: {proof} {stable}"
        );
        assert!(
            1.0 + proof > 0.95 * (1.0 + stable),
            "{device:?} {order:?} {k} {b}: {proof} {stable}"
        );
        alive += usize::from(proof > 0.0);
    }
    assert!(2 * alive > count, "{alive} of {count}");
}

#[test]
fn a_region_reaches_to_where_a_member_is_unstable() {
    regions(7, 12, 80);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_regions_reach_to_where_one_of_2000_is_unstable() {
    regions(11, testkit::cases(30), 2000);
}

/// True of a law, N/m by the angle, whose F turns on a fine grid: the loop is unstable.
fn turns(device: &Dynamics, law: impl Fn(f64) -> Complex<f64>) -> bool {
    let plant = device.plant(T).expect("a plant");
    let delay = plant.path().whole_samples() as f64 + 1.0;
    let f = |theta: f64| -> Complex<f64> {
        let w = Complex::from_polar(1.0, -theta);
        let polynomial = |c: &[f64]| -> Complex<f64> {
            (c.iter().rev()).fold(Complex::new(0.0, 0.0), |sum, c| sum * w + *c)
        };
        let gain = polynomial(plant.numerator()) * Complex::from_polar(1.0, -delay * theta);
        polynomial(plant.denominator()) + gain * law(theta) * (T * T / device.mass_kg)
    };
    let angle = |i: i32| 1e-5 * (PI / 1e-5).powf(f64::from(i) / 4e3);
    let angles: Vec<f64> = (0..=4000).map(angle).collect();
    let ways = angles
        .windows(2)
        .map(|pair| (f(pair[1]) / f(pair[0])).arg());
    let turned = f(1e-5).arg() + ways.sum::<f64>();
    turned.abs() > 0.5 * PI
}

/// Pairs of stable walls, of which a few have mixes that are not.
fn pairs(seed: u64, count: usize) -> [usize; 3] {
    let mut random = Random(seed);
    let [mut stable, mut unstable, mut missed] = [0; 3];
    while stable < count {
        let device = Dynamics {
            delay_s: (3.0 * random.share()).round() * T,
            current_lag_s: 0.0,
            hand_stiffness_n_per_m: 0.0,
            ..device(&mut random)
        };
        let operators = [random.between(0.05, 1.9), random.between(0.05, 1.9)].map(exact);
        // Near the border of each.
        let pair = operators.each_ref().map(|operator| {
            let (k, beta) = (random.or_nothing(500.0), random.log_between(1e-3, 1.0));
            let b = beta * device.mass_kg * T.powf(operator.order().get() - 2.0);
            let light = wall(1e-3 * k, 1e-3 * b, operator);
            let closed = device.closed(&light, operator).expect("closes");
            let closed = closed.beside_rest();
            let margins = closed.is_stable().then(|| closed.margins());
            let up = margins.and_then(|margins| margins.expect("judges").gain_up)?;
            let factor = 1e-3 * up.value * random.between(0.5, 0.98);
            let wall = wall(factor * k, factor * b, operator);
            let closed = device.closed(&wall, operator).expect("closes");
            closed.beside_rest().is_stable().then_some((wall, operator))
        });
        let [Some(first), Some(second)] = pair else {
            continue;
        };
        let pair = [first, second];
        stable += 1;
        let sets = pair
            .each_ref()
            .map(|(wall, operator)| LawSet::Wall(*wall, operator));
        let holds = proved(&device, &sets);
        let shares = if holds {
            &[0.5][..]
        } else {
            &[0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.03]
        };
        let swings = shares.iter().any(|share| {
            let shares = [1.0 - share, *share];
            turns(&device, |theta| {
                let parts = pair.iter().zip(shares).map(|((wall, operator), share)| {
                    let rate = T.powf(-wall.order.get());
                    let memory = operator.response(theta) * (wall.dissipation_n_s_mu_per_m * rate);
                    (memory + wall.stiffness_n_per_m) * share
                });
                parts.sum()
            })
        });
        assert!(!(holds && swings), "{device:?} {pair:?}");
        unstable += usize::from(swings);
        missed += usize::from(!holds && !swings);
    }
    [stable, unstable, missed]
}

#[test]
fn a_mix_of_two_stable_walls_is_proved_or_swings() {
    let [_, _, missed] = pairs(3, 40);
    assert!(missed <= 1, "{missed}");
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_some_pairs_have_unstable_mixes_and_all_are_found() {
    let [stable, unstable, missed] = pairs(5, testkit::cases(1000));
    println!(
        "{unstable} of {stable} stable pairs have an unstable mix; {missed} are neither proved nor seen to swing"
    );
    assert!(unstable > 0 && 50 * missed <= stable, "{unstable} {missed}");
}

#[test]
fn a_region_of_elements_in_series_reaches_to_where_a_member_is_unstable() {
    let mut random = Random(9);
    for _ in 0..4 {
        let device = device(&mut random);
        let [e, g, v] = [50.0, 20.0, 0.5].map(|size| size * random.log_between(0.3, 3.0));
        let order = [random.between(0.1, 0.5), random.between(0.6, 1.0)];
        let sizes = |f: f64| [e, g, v].map(|size| [size, size + f * size]);
        let proof = largest(|f| {
            let [e, g, v] = sizes(f);
            let series = LawElements::Series(Box::new([pot(g, [0.0; 2]), pot(v, order)]));
            let zener = LawElements::Parallel(Box::new([pot(e, [0.0; 2]), series]));
            proved(&device, &[LawSet::Elements(zener)])
        });
        let stable = largest(|f| {
            let mut random = Random(1);
            (0..40).all(|point| {
                let mut between = |[low, high]: [f64; 2]| {
                    let share = random.share();
                    low + (high - low) * if point < 24 { share.round() } else { share }
                };
                let ([e, g, v], order) = (sizes(f).map(&mut between), between(order));
                !turns(&device, |theta| {
                    let s = Complex::new(0.0, 0.5 * (PI - theta)).exp()
                        * (2.0 * (0.5 * theta).sin() / T);
                    let series = (s.powf(order) * v).inv() + 1.0 / g;
                    series.inv() + e
                })
            })
        });
        assert!(
            proof <= 1.02 * stable,
            "{device:?} {order:?}: {proof} {stable}"
        );
        assert!(
            1.0 + proof > 0.95 * (1.0 + stable),
            "{device:?} {order:?}: {proof} {stable}"
        );
    }
}

#[test]
fn a_set_that_is_unstable_altogether_is_not_proved() {
    let device = Dynamics {
        delay_s: 2e-3,
        ..Dynamics::ideal(0.1, 0.5)
    };
    let stiff = LawSet::Elements(walls([2000.0, 2100.0], [0.0, 0.1], [0.4, 0.6]));
    let verdict = prove_laws(&device, T, &[stiff]).expect("judges");
    assert_eq!(verdict, SetVerdict::Unstable);
    assert_refused(prove_laws(&device, T, &[]), "number of laws");
    let falling = LawSet::Elements(pot([2.0, 1.0], [0.5; 2]));
    assert_refused(prove_laws(&device, T, &[falling]), "not below the least");
    let steep = LawSet::Elements(pot([1.0, 1.0], [0.5, 2.5]));
    assert_refused(prove_laws(&device, T, &[steep]), "order");
}
