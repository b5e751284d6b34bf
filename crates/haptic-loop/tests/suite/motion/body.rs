//! The virtual body against recurrences, the defining sum and closed forms.

use super::*;

/// Velocities under these forces, of a body that no limit holds.
fn velocities<F: Real, O: Differintegrator<F>>(
    body: &VirtualBody<F, O>,
    forces: impl IntoIterator<Item = f64>,
) -> Vec<F> {
    let mut history = body.at_rest();
    let velocities = forces.into_iter().map(|force| {
        let v = body.velocity(&history, &vector![F::from_f64(force)]);
        body.advance(&mut history, &v);
        v[0]
    });
    velocities.collect()
}

fn grunwald<const N: usize>(alpha: f64, t: f64) -> ShortMemory<f64, N> {
    ShortMemory::new(order(alpha), Seconds(t)).expect("in range")
}

/// Forces of a hand that changes its mind, N.
fn pushes(count: usize) -> Vec<f64> {
    let mut random = Random(85);
    let mut force = 0.0;
    let forces = (0..count).map(|n| {
        if n % 37 == 0 {
            force = random.between(-10.0, 10.0);
        }
        force
    });
    forces.collect()
}

#[test]
fn a_lagged_mass_is_its_recurrence_and_has_its_response() {
    // Without a lag it is a mass.
    for lag in [0.0, 0.03] {
        let (m, b, t) = (2.0, 1.0, T.0);
        let rate = LaggedRate::<f64>::new(Seconds(lag), T).expect("in range");
        let have = velocities(&body(m, b, rate), pushes(2000));
        // F = m·y + b·v with τ·ẏ + y = v̇, both by backward differences.
        let (mut v, mut y) = (0.0, 0.0);
        for (force, have) in pushes(2000).into_iter().zip(have) {
            // y = (v' − v + τ·y)/(T + τ)
            let next = (force * (t + lag) + m * v - m * lag * y) / (m + b * (t + lag));
            y = (next - v + lag * y) / (t + lag);
            v = next;
            assert_close("v", have, v, 1e-13);
        }
        // The response is the sum of its answer to one sample, here without the unit 1/T.
        let mut history = rate.at_rest();
        let answer: Vec<f64> = (0..2000)
            .map(|n| rate.step(&mut history, if n == 0 { t } else { 0.0 }))
            .collect();
        for theta in [0.0, 0.02, 0.5, 3.0] {
            let have = rate.response(theta);
            let parts = answer.iter().enumerate();
            let (re, im) = parts.fold((0.0, 0.0), |(re, im), (n, y)| {
                let angle = theta * n as f64;
                (re + y * libm::cos(angle), im - y * libm::sin(angle))
            });
            assert_close("re", have.re, re, 1e-12);
            assert_close("im", have.im, im, 1e-12);
        }
    }
}

#[test]
fn a_fractional_body_is_the_direct_sum() {
    const N: usize = 600;
    // Order 0 is a damper, order 1 a mass.
    for alpha in [0.0, 0.3, 0.8, 1.0, 1.2] {
        let (m, b, t) = (1.16, 1.0, T.0);
        let have = velocities(&body(m, b, grunwald::<N>(alpha, t)), pushes(N));
        let mut weights = vec![libm::pow(t, -alpha)];
        for j in 1..N {
            weights.push(weights[j - 1] * (j as f64 - 1.0 - alpha) / j as f64);
        }
        for (n, force) in pushes(N).into_iter().enumerate() {
            // m·Σ c_j·v[n−j] + b·v[n] = f[n], all in place: what is left over.
            let sum: f64 = (0..=n).map(|j| weights[j] * have[n - j]).sum();
            assert_close("force", m * sum + b * have[n], force, 1e-11);
        }
    }
}

/// E_{α,β}(z) by its series, for small z.
fn mittag_leffler(alpha: f64, beta: f64, z: f64) -> f64 {
    (0..120)
        .map(|k| libm::pow(z, f64::from(k)) / libm::tgamma(alpha * f64::from(k) + beta))
        .sum()
}

#[test]
fn under_a_step_of_force_the_velocity_converges_to_mittag_leffler() {
    // m·D^α v + b·v = 1 N: v = (t^α/m)·E_{α,α+1}(−(b/m)·t^α)
    let (m, b, end) = (1.5, 2.0, 0.5);
    for alpha in [0.4, 0.8, 1.3] {
        let power = libm::pow(end, alpha);
        let exact = power / m * mittag_leffler(alpha, alpha + 1.0, -b / m * power);
        let error = |count: usize| {
            let fraction = full(alpha, Seconds(end / count as f64), 1e-10);
            let steps: Vec<f64> = velocities(&body(m, b, fraction), (0..count).map(|_| 1.0));
            steps[count - 1] - exact
        };
        let [coarse, fine] = [error(400), error(800)];
        assert!((fine / exact).abs() < 2e-3, "{alpha}: {fine}");
        // First order, as the difference is.
        assert_close("order", libm::log2(coarse / fine), 1.0, 0.05);
    }
}

#[test]
fn single_precision_follows_double() {
    let count = 20_000;
    let double = body(1.16, 1.0, full::<f64>(0.8, T, 1e-6));
    let single = body(1.16, 1.0, full::<f32>(0.8, T, 1e-6));
    let double = velocities(&double, pushes(count));
    let single = velocities(&single, pushes(count));
    let most = double.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    for (v, w) in double.iter().zip(&single) {
        // Some digits of single precision, of the largest velocity.
        assert_close("v", f64::from(*w), *v, 2e-5 * most);
    }
}

#[test]
fn a_body_without_inertia_and_damping_and_one_below_zero_are_refused() {
    for (m, b, words) in [
        (0.0, 0.0, "give it inertia or damping"),
        (-1.0, 5.0, "inertia of the virtual body -1"),
        (1.0, f64::NAN, "damping of the virtual body NaN"),
    ] {
        let made = VirtualBody::new(m, NewtonSecondsPerMetre(b), grunwald::<2>(1.0, T.0));
        assert_refused(made, words);
    }
    let lagged = LaggedRate::<f64>::new(Seconds(-1e-3), T);
    assert_refused(lagged, "lag of the virtual mass");
    let damper = body(0.0, 4.0, grunwald::<2>(1.0, T.0));
    assert_close("v", velocities(&damper, [2.0])[0], 0.5, 1e-15);
}
