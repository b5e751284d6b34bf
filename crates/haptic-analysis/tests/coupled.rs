//! The loop of device, coupler and object: three ways to judge it, its edge, and what passivity of the sampled port asks.

use fracdiff::{ExactDifference, FrequencyResponse, Scheme, Seconds};
use haptic_analysis::{
    CoupledLoop, CoupledObject, Coupler, CouplerOperator, Dynamics, ForcePath, Jury, LeastDamping,
    LoopOperator,
};
use num_complex::Complex;
use std::f64::consts::PI;
use testkit::operator::order;
use testkit::{Random, assert_relative};

const T: f64 = 1e-3;

fn operator(scheme: &str, mu: f64) -> LoopOperator {
    let scheme: Scheme = scheme.parse().expect("a scheme");
    LoopOperator::new(scheme, order(1.0 - mu), Seconds(T), 1e5).expect("valid")
}

fn exact(mu: f64, k_c: f64, b_c: f64) -> Coupler<'static> {
    Coupler::exact(order(mu), T, k_c, b_c).expect("valid")
}

fn enough(least: LeastDamping) -> f64 {
    match least {
        LeastDamping::Enough {
            damping_n_s_per_m, ..
        } => damping_n_s_per_m,
        none => panic!("{none:?}"),
    }
}

/// A device, a coupler and an object, none too far from the others.
struct Case {
    device: Dynamics,
    object: CoupledObject,
    mu: f64,
    gains: [f64; 2],
}

impl Case {
    fn random(random: &mut Random, mu: f64) -> Self {
        let mass_kg = random.log_between(0.02, 1.0);
        let damping = random.log_between(2e-3, 0.5) * mass_kg / T;
        let device = Dynamics {
            hand_stiffness_n_per_m: random.or_nothing(2000.0),
            delay_s: random.or_nothing(2.5) * T,
            current_lag_s: random.or_nothing(2.0) * T,
            ..Dynamics::ideal(mass_kg, damping)
        };
        let object = CoupledObject {
            mass_kg: random.or_nothing(1.0),
            damping_n_s_per_m: random.or_nothing(2.0),
            stiffness_n_per_m: random.log_between(1.0, 1e5),
        };
        let size = random.log_between(1e-2, 10.0) * mass_kg / T;
        let share = random.share();
        let gains = [size * share, size * (1.0 - share) * T.powf(-mu)];
        Self {
            device,
            object,
            mu,
            gains,
        }
    }

    fn closed<'a>(&self, operator: &'a LoopOperator) -> CoupledLoop<'a> {
        let coupler = exact(self.mu, self.gains[0], self.gains[1]);
        CoupledLoop::new(&self.device, &coupler, &self.object, operator).expect("valid")
    }
}

#[test]
fn encirclement_jury_and_eigenvalues_agree() {
    let mut random = Random(31);
    let (mut stable, mut unstable) = (0, 0);
    for n in 0..300 {
        let mu = [0.0, 0.25, 0.5, 0.75, 1.0][n % 5];
        let operator = operator(["grunwald:12", "tustin-muir:3", "grunwald:40"][n % 3], mu);
        let coupled = Case::random(&mut random, mu).closed(&operator);
        let jury = coupled.jury().expect("polynomial");
        let poles = coupled.poles().expect("eigenvalues");
        let largest = poles.iter().fold(0.0, |most: f64, z| most.max(z.norm()));
        // Nearer to the circle eigenvalues of a polynomial of this degree say nothing.
        if (largest - 1.0).abs() < 1e-6 || jury == Jury::Undecided {
            continue;
        }
        assert_eq!(
            coupled.is_stable(),
            largest < 1.0,
            "case {n}: largest pole {largest}"
        );
        assert_eq!(
            coupled.is_stable(),
            jury == Jury::Stable,
            "case {n}: {jury:?}"
        );
        let outside = poles.iter().filter(|z| z.norm() > 1.0).count();
        assert_eq!(coupled.unstable_poles(), Some(outside), "case {n}");
        *(if coupled.is_stable() {
            &mut stable
        } else {
            &mut unstable
        }) += 1;
    }
    assert!(stable > 60 && unstable > 60, "{stable} {unstable}");
}

#[test]
fn the_characteristic_function_is_that_of_the_ports() {
    // F/(A·e) = 1 + H_c·(G + 1/H_o), from impedances.
    let mut random = Random(32);
    for n in 0..50 {
        let mu = [0.0, 0.3, 0.7, 1.0][n % 4];
        let operator = operator("exact", mu);
        let mut case = Case::random(&mut random, mu);
        case.device.hand_stiffness_n_per_m = 300.0;
        (case.device.delay_s, case.device.current_lag_s) = (0.0, 0.0);
        let coupled = case.closed(&operator);
        assert!(!coupled.is_held());
        let (m, o) = (case.device.mass_kg, case.object);
        let plant = case.device.plant(T).expect("valid");
        for theta in [0.01, 0.3, 1.0, 2.5] {
            let w = Complex::from_polar(1.0, -theta);
            let v = Complex::new(1.0, 0.0) - w;
            let u = v - 2.0;
            let z_o = v / -u * (2.0 * o.mass_kg / T)
                + o.damping_n_s_per_m
                + -u / v * (0.5 * T * o.stiffness_n_per_m);
            let z_c = (Complex::new(T, 0.0) / v).powf(mu) * case.gains[1] + case.gains[0];
            let polynomial = |c: &[f64]| {
                c.iter()
                    .rev()
                    .fold(Complex::new(0.0, 0.0), |s, c| s * w + c)
            };
            let a = polynomial(plant.denominator());
            let g = w * polynomial(plant.numerator()) / a * (T * T / m);
            let want = v / T * z_c * (g + T / (v * z_o)) + 1.0;
            // F/(A·e): e from F without a coupler.
            let alone = coupled.scaled(0.0).characteristic(theta);
            let have = coupled.characteristic(theta) / alone;
            assert!(
                (have - want).norm() < 1e-9 * want.norm(),
                "{n}, θ {theta}: {have} {want}"
            );
        }
    }
}

#[test]
fn the_gain_margin_is_where_the_verdict_changes() {
    let mut random = Random(33);
    let mut edges = 0;
    for n in 0..60 {
        let mu = [0.0, 0.25, 0.5, 0.75, 1.0][n % 5];
        let operator = operator("full", mu);
        let coupled = Case::random(&mut random, mu).closed(&operator).scaled(0.05);
        if !coupled.is_stable() {
            continue;
        }
        let Some(edge) = coupled.gain_margin().expect("stable") else {
            continue;
        };
        edges += 1;
        let at = |factor: f64| coupled.scaled(factor * edge.value).is_stable();
        assert!(at(1.0 - 1e-6) && !at(1.0 + 1e-6), "case {n}: {edge:?}");
    }
    assert!(edges > 30, "{edges}");
}

#[test]
fn a_coupler_before_a_rigid_object_is_a_wall() {
    // An object of 1e12 N/m: K = b_c and B = k_c at μ = 1.
    let operator = operator("exact", 1.0);
    let rigid = CoupledObject {
        mass_kg: 0.0,
        damping_n_s_per_m: 0.0,
        stiffness_n_per_m: 1e12,
    };
    let device = Dynamics::ideal(0.065, 3.5);
    let difference = LoopOperator::new(Scheme::Exact, order(1.0), Seconds(T), 1e3).expect("valid");
    for [damper, spring] in [
        [5.0, 3e3],
        [30.0, 2e4],
        [30.0, 2e5],
        [200.0, 10.0],
        [60.0, 3e4],
    ] {
        let coupled = CoupledLoop::new(&device, &exact(1.0, damper, spring), &rigid, &operator)
            .expect("valid");
        let wall = haptic_analysis::Environment {
            stiffness_n_per_m: spring,
            dissipation_n_s_mu_per_m: damper,
            order: order(1.0),
            sample_time_s: T,
        };
        let wall = device.closed(&wall, &difference).expect("valid");
        assert_eq!(coupled.is_stable(), wall.is_stable(), "{damper} {spring}");
        if wall.is_stable() {
            let have = coupled.gain_margin().expect("stable").expect("an edge");
            let want = wall.margins().expect("stable").gain_up.expect("an edge");
            assert_relative("gain margin", have.value, want.value, 1e-6);
        }
    }
}

#[test]
fn what_drifts_is_held_and_not_called_unstable() {
    let device = Dynamics::ideal(0.065, 0.5);
    let free = CoupledObject {
        mass_kg: 0.2,
        damping_n_s_per_m: 0.0,
        stiffness_n_per_m: 0.0,
    };
    let spring = CoupledObject {
        stiffness_n_per_m: 300.0,
        ..free
    };
    for mu in [0.0, 0.5, 1.0] {
        let operator = operator("full", mu);
        let b_c = 0.05 * T.powf(-mu);
        for (object, held) in [(free, true), (spring, mu < 1.0)] {
            let coupled = CoupledLoop::new(&device, &exact(mu, 0.05, b_c), &object, &operator);
            let coupled = coupled.expect("valid");
            assert_eq!(coupled.is_held(), held, "μ {mu}");
            assert!(coupled.is_stable(), "μ {mu}, {object:?}");
        }
    }
}

#[test]
fn the_sampled_port_of_springs_and_dampers_is_known_in_closed_form() {
    let late = |d: usize| ForcePath::whole(d).expect("valid");
    for d in [0, 1, 2, 7] {
        // (d + 1)²·b_c·T/2, at rest.
        let spring = exact(1.0, 0.0, 1000.0)
            .sampled_damping(late(d))
            .expect("valid");
        let want = 0.5 * T * 1000.0 * ((d + 1) * (d + 1)) as f64;
        assert_relative(&format!("spring, d {d}"), enough(spring), want, 1e-7);
        let damper = exact(1.0, 3.0, 0.0)
            .sampled_damping(late(d))
            .expect("valid");
        assert_relative(&format!("damper, d {d}"), enough(damper), 3.0, 1e-12);
    }
    // The same from another side: the operator that runs, P = (1 − w)/Q.
    let identity = operator("full", 1.0);
    let runs = CouplerOperator(&identity);
    let spring = exact(1.0, 0.0, 1000.0)
        .with_operator(&runs, 1)
        .sampled_damping(late(0));
    assert_relative("as it runs", enough(spring.expect("valid")), 0.5, 1e-7);
}

#[test]
fn llewellyn_asks_for_less_than_a_quarter_of_what_the_sampled_port_needs() {
    let mut random = Random(34);
    for n in 0..60 {
        let mu = [0.0, 0.2, 0.5, 0.8, 1.0][n % 5];
        let coupler = exact(
            mu,
            random.or_nothing(5.0),
            random.log_between(0.1, 5.0) * T.powf(-mu),
        );
        let tustin = enough(coupler.least_damping().expect("valid"));
        let sampled = enough(coupler.sampled_damping(ForcePath::NONE).expect("valid"));
        assert!(
            sampled >= 4.0 * tustin * (1.0 - 1e-9),
            "{coupler:?}: {sampled} {tustin}"
        );
    }
}

/// b that passivity at one angle asks of this device with c = −wM, V and the impedance Z.
fn asked(late: Complex<f64>, variance: f64, z: Complex<f64>) -> f64 {
    let r = (-late * z).re;
    0.5 * (r + (r * r + variance * z.norm_sqr()).sqrt())
}

/// wM and V of a delay of d + h samples without lag.
fn path(delay: f64, theta: f64) -> (Complex<f64>, f64) {
    let w = Complex::from_polar(1.0, -theta);
    let (d, h) = (delay.floor(), delay.fract());
    let v = Complex::new(1.0, 0.0) - w;
    let late = w * Complex::from_polar(1.0, -theta * d) * (-v * h + 1.0);
    (late, h * (1.0 - h) * v.norm_sqr())
}

#[test]
fn no_passive_object_asks_for_more_and_one_asks_for_all() {
    let mut random = Random(35);
    for n in 0..40 {
        let mu = [0.1, 0.4, 0.6, 0.9][n % 4];
        let delay = [0.0, 0.0, 0.4, 1.0, 2.3][n % 5];
        let (k_c, b_c) = (
            random.or_nothing(5.0),
            random.log_between(0.1, 5.0) * T.powf(-mu),
        );
        let coupler = exact(mu, k_c, b_c);
        let way = ForcePath::new(delay, 0.0).expect("valid");
        let LeastDamping::Enough {
            damping_n_s_per_m: least,
            worst_theta,
        } = coupler.sampled_damping(way).expect("valid")
        else {
            panic!("below order 1 some damping is enough");
        };
        let admittance = |theta: f64| {
            let v = ExactDifference(order(1.0)).response(theta);
            1.0 / ((Complex::new(T, 0.0) / v).powf(mu) * b_c + k_c)
        };
        for _ in 0..200 {
            let theta = random.log_between(1e-3, PI);
            let y = admittance(theta);
            let object = Complex::new(
                random.or_nothing(2.0 * y.re),
                random.between(-3.0, 3.0) * y.norm(),
            );
            let (late, variance) = path(delay, theta);
            let need = asked(late, variance, 1.0 / (y + object));
            assert!(
                need <= least * (1.0 + 1e-9),
                "{n}, θ {theta}: {need} {least}"
            );
        }
        // The object that asks for it: Y = Re(1/Z_c) + j·Im(c)/(2b).
        let y = admittance(worst_theta);
        let (late, variance) = path(delay, worst_theta);
        let whole = Complex::new(y.re, -late.im / (2.0 * least));
        let need = asked(late, variance, 1.0 / whole);
        assert_relative(&format!("case {n}, d + h {delay}"), need, least, 1e-6);
    }
}

#[test]
fn passive_by_the_sampled_criterion_is_stable_with_every_hand_and_object() {
    let mut random = Random(36);
    for n in 0..150 {
        let mu = [0.0, 0.25, 0.5, 0.75, 1.0][n % 5];
        let operator = operator("full", mu);
        let mut case = Case::random(&mut random, mu);
        let runs = CouplerOperator(&operator);
        let path = case.device.path(T).expect("valid");
        let unit = exact(mu, case.gains[0], case.gains[1]);
        let least = unit
            .with_operator(&runs, 1)
            .sampled_damping(path)
            .expect("valid");
        let share = 0.999 * case.device.damping_n_s_per_m / enough(least);
        case.gains = case.gains.map(|gain| share * gain);
        assert!(case.closed(&operator).is_stable(), "case {n}");
    }
}

#[test]
fn llewellyn_passive_does_not_mean_stable_in_the_sampled_loop() {
    // 8b ≥ k_c holds, and the sampled mass throws itself about: k_c·T/m = 4.8 > 2.
    let (b, m) = (3.0, 5e-3);
    let damper = exact(1.0, 24.0, 0.0);
    assert!(damper.passive(b).expect("valid"));
    let heavy = CoupledObject {
        mass_kg: 1.0,
        damping_n_s_per_m: 0.0,
        stiffness_n_per_m: 0.0,
    };
    let operator = operator("exact", 1.0);
    let coupled = CoupledLoop::new(&Dynamics::ideal(m, b), &damper, &heavy, &operator);
    assert!(
        coupled
            .expect("valid")
            .unstable_poles()
            .is_some_and(|poles| poles > 0)
    );
}

#[test]
fn what_is_out_of_range_is_refused() {
    let operator = operator("exact", 0.5);
    let device = Dynamics::ideal(0.065, 3.5);
    let object = CoupledObject {
        mass_kg: 0.1,
        damping_n_s_per_m: 0.0,
        stiffness_n_per_m: 100.0,
    };
    let refused = |coupler: &Coupler<'_>, object: CoupledObject| {
        let coupled = CoupledLoop::new(&device, coupler, &object, &operator);
        coupled.expect_err("refused").to_string()
    };
    let other = refused(&exact(0.25, 1.0, 1.0), object);
    assert!(
        other.contains("order of the coupler's operator 0.5"),
        "{other}"
    );
    let negative = CoupledObject {
        mass_kg: -1.0,
        ..object
    };
    assert!(refused(&exact(0.5, 1.0, 1.0), negative).contains("object mass -1 kg"));
    let nothing = CoupledObject {
        mass_kg: 0.0,
        stiffness_n_per_m: 0.0,
        ..object
    };
    assert!(refused(&exact(0.5, 1.0, 1.0), nothing).contains("impedance of the object"));
}
