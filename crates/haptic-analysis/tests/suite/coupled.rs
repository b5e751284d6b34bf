//! The loop of device, coupler and object: two ways to judge it, its edge, and what passivity of the sampled port asks.

mod passive;

use fracdiff::{Scheme, Seconds};
use haptic_analysis::{CoupledLoop, CoupledObject, Coupler, Dynamics, LeastDamping, LoopOperator};
use num_complex::Complex;
use testkit::{Random, assert_relative};
use testkit::{assert_says, operator::order};

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

fn multiply(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            product[i + j] += x * y;
        }
    }
    product
}

fn add(a: &[f64], b: &[f64]) -> Vec<f64> {
    let at = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
    (0..a.len().max(b.len()))
        .map(|k| at(a, k) + at(b, k))
        .collect()
}

fn times(list: &[f64], factor: f64) -> Vec<f64> {
    list.iter().map(|x| factor * x).collect()
}

impl Case {
    /// The poles in z, as roots of F in powers of w, from the equations of a tick; Q = N/D.
    /// ```text
    /// F·D = A·e·D + (A·u + w^(d+1)·N_p·e)·(α(1 − w)D + βN),   H_o·T²/m = e/u
    /// ```
    fn poles(&self, coupled: &CoupledLoop, operator: &LoopOperator) -> Vec<Complex<f64>> {
        let (above, below) = operator.polynomials().expect("polynomials");
        let plant = self.device.plant(T).expect("valid");
        let (alpha, beta) = coupled.nondimensional();
        let m = self.device.mass_kg;
        // ρ·2v/(2 − v)·v + δv + γ(2 − v)/2 of the object, v = 1 − w and 2 − v = 1 + w.
        let (v, u) = ([1.0, -1.0], [1.0, 1.0]);
        let rho = 2.0 * self.object.mass_kg / m;
        let delta = self.object.damping_n_s_per_m * T / m;
        let gamma = 0.5 * self.object.stiffness_n_per_m * T * T / m;
        let firm = add(&times(&v, delta), &times(&u, gamma));
        let (e, u) = if rho > 0.0 {
            let heavy = times(&multiply(&v, &v), rho);
            (add(&heavy, &multiply(&firm, &u)), u.to_vec())
        } else {
            (firm, vec![1.0])
        };
        let coupler = add(&times(&multiply(&v, below), alpha), &times(above, beta));
        let mut late = vec![0.0; plant.path().whole_samples() + 1];
        late.extend(multiply(plant.numerator(), &e));
        let seen = add(&late, &multiply(plant.denominator(), &u));
        let alone = multiply(&multiply(plant.denominator(), &e), below);
        let mut sum = add(&alone, &multiply(&seen, &coupler));
        let used = sum.iter().rposition(|c| *c != 0.0).expect("not 0") + 1;
        sum.truncate(used);
        sum.reverse();
        fracdiff::roots(&sum)
    }
}

#[test]
fn encirclement_and_eigenvalues_agree() {
    let mut random = Random(31);
    let (mut stable, mut unstable) = (0, 0);
    for n in 0..300 {
        let mu = [0.0, 0.25, 0.5, 0.75, 1.0][n % 5];
        let operator = operator(["grunwald:12", "tustin-muir:3", "grunwald:40"][n % 3], mu);
        let case = Case::random(&mut random, mu);
        let coupled = case.closed(&operator);
        let poles = case.poles(&coupled, &operator);
        let largest = poles.iter().fold(0.0, |most: f64, z| most.max(z.norm()));
        // Nearer to the circle eigenvalues of a polynomial of this degree say nothing.
        if (largest - 1.0).abs() < 1e-6 {
            continue;
        }
        let what = format!("case {n}: largest pole {largest}");
        assert_eq!(coupled.is_stable(), largest < 1.0, "{what}");
        // Of what drifts one is at rest, on the circle.
        let edge = 1.0 + if coupled.drifts() { 1e-6 } else { 0.0 };
        let outside = poles.iter().filter(|z| z.norm() > edge).count();
        assert_eq!(coupled.unstable_poles(), Some(outside), "{what}");
        stable += usize::from(coupled.is_stable());
        unstable += usize::from(!coupled.is_stable());
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
        assert!(!coupled.drifts());
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
            let polynomial = |c: &[f64]| -> Complex<f64> {
                let powers = c.iter().rev();
                powers.fold(Complex::new(0.0, 0.0), |sum, c| sum * w + c)
            };
            let a = polynomial(plant.denominator());
            let g = w * polynomial(plant.numerator()) / a * (T * T / m);
            let want = v / T * z_c * (g + T / (v * z_o)) + 1.0;
            // F/(A·e): e from F without a coupler.
            let alone = coupled.scaled(0.0).characteristic(theta);
            let have = coupled.characteristic(theta) / alone;
            let error = (have - want).norm() / want.norm();
            assert!(error < 1e-9, "{n}, θ {theta}: {have} {want}");
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
        let edge = coupled.is_stable().then(|| coupled.gain_margin());
        let Some(edge) = edge.and_then(|edge| edge.expect("stable")) else {
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
        let coupler = exact(1.0, damper, spring);
        let coupled = CoupledLoop::new(&device, &coupler, &rigid, &operator).expect("valid");
        let wall = haptic_analysis::SampledWall {
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
fn what_drifts_is_not_called_unstable() {
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
        for (object, drifts) in [(free, true), (spring, mu < 1.0)] {
            let coupled = CoupledLoop::new(&device, &exact(mu, 0.05, b_c), &object, &operator);
            let coupled = coupled.expect("valid");
            assert_eq!(coupled.drifts(), drifts, "μ {mu}");
            assert!(coupled.is_stable(), "μ {mu}, {object:?}");
        }
    }
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
    assert_says(&other, "order of the coupler's operator 0.5");
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
