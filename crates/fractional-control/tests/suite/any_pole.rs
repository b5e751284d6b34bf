//! Verdicts and margins of plants with poles from ten thousand samples slow to a ten-thousandth of one, of gains alone and of dead times alone,
//! against eigenvalues of a model of its own: modes of the partial fractions, whose samples behind a hold and a dead time are closed forms.
//!
//! ```text
//! G = c/Π(s − p_i) = Σ r_i/(s − p_i),   r_i = c/Π_{j≠i}(p_i − p_j)
//! x_i[n+1] = e^(p_i T) x_i[n] + r_i (e^(p_i T) − e^(p_i hT))/p_i · u[n−d−1] + r_i (e^(p_i hT) − 1)/p_i · u[n−d],   h → 1 − h
//! u[n] = −K_p y[n] − K_i T·Σ y
//! ```

use crate::fixture::{Draw, pi};
use fracdiff::Seconds;
use fractional_control::{
    ControlError, Crossing, HeldPlant, Plant, PowerMemory, Rule, SampledControlLoop,
    num_complex::Complex,
};
use nalgebra::DMatrix;

/// What is drawn: T is 1 s.
#[derive(Clone, Debug)]
struct Loop {
    /// k, over the time constants: 1/(τs + 1), 1/(τs − 1) of a negative one, 1/s of an infinite one.
    gain: f64,
    times: Vec<f64>,
    delay: f64,
    proportional: f64,
    integral: f64,
}

impl Loop {
    fn plant(&self) -> Plant {
        let factors = self.times.iter().map(|tau| {
            if tau.is_infinite() {
                "s".to_owned()
            } else if *tau < 0.0 {
                format!("({}s-1)", -tau)
            } else {
                format!("({tau}s+1)")
            }
        });
        let below: Vec<String> = factors.collect();
        let function = if below.is_empty() {
            format!("{}", self.gain)
        } else {
            format!("{}/({})", self.gain, below.join(""))
        };
        Plant::transfer(function.parse().expect(&function), self.delay).expect("valid")
    }

    fn closed(&self) -> Result<SampledControlLoop, ControlError> {
        let memory = PowerMemory::new(Rule::Grunwald, 1e-9, 1e4)?;
        let plant = HeldPlant::new(&self.plant(), memory, Seconds(1.0))?;
        assert!(plant.is_exact());
        let controller = pi(self.proportional, self.integral, 1.0);
        SampledControlLoop::new(controller.into(), memory, &plant)
    }

    /// Poles and residues.
    fn modes(&self) -> Vec<(f64, f64)> {
        let pole = |tau: &f64| -tau.recip();
        let poles: Vec<f64> = self.times.iter().map(pole).collect();
        let scale: f64 = (self.times.iter())
            .map(|tau| {
                if tau.is_infinite() {
                    1.0
                } else {
                    tau.abs().recip()
                }
            })
            .product();
        let spread = |i: usize| -> f64 {
            let others = (0..poles.len()).filter(|j| *j != i);
            others.map(|j| poles[i] - poles[j]).product()
        };
        let c = self.gain * scale;
        (0..poles.len())
            .map(|i| (poles[i], c / spread(i)))
            .collect()
    }

    /// The largest |z| of the closed loop.
    fn radius(&self) -> f64 {
        let modes = self.modes();
        let (d, h) = (self.delay.floor() as usize, self.delay.fract());
        // States: the modes, u[n−1] … u[n−d−1], Σ y before now.
        let (n, late) = (modes.len(), d + 1);
        let size = n + late + 1;
        let mut m = DMatrix::<f64>::zeros(size, size);
        let mut y = vec![0.0; size];
        for (i, (_, residue)) in modes.iter().enumerate() {
            // Each mode in units of its residue.
            y[i] = residue.signum();
        }
        if n == 0 {
            y[n + self.delay.ceil().max(1.0) as usize - 1] = self.gain;
        }
        let direct = self.proportional + self.integral;
        let mut u: Vec<f64> = y.iter().map(|y| -direct * y).collect();
        u[size - 1] -= self.integral;
        for (i, (pole, residue)) in modes.iter().enumerate() {
            let area = |a: f64, b: f64| match *pole {
                0.0 => b - a,
                pole => (pole * a).exp() * (pole * (b - a)).exp_m1() / pole,
            };
            let newest = area(0.0, 1.0 - h) * residue.abs();
            let before = area(1.0 - h, 1.0) * residue.abs();
            m[(i, i)] += pole.exp();
            if d == 0 {
                (0..size).for_each(|column| m[(i, column)] += newest * u[column]);
            } else {
                m[(i, n + d - 1)] += newest;
            }
            m[(i, n + d)] += before;
        }
        (0..size).for_each(|column| m[(n, column)] = u[column]);
        (1..late).for_each(|k| m[(n + k, n + k - 1)] = 1.0);
        (0..size).for_each(|column| m[(size - 1, column)] = y[column]);
        m[(size - 1, size - 1)] += 1.0;
        if self.integral == 0.0 {
            // The sum is not of the loop.
            m[(size - 1, size - 1)] = 0.0;
        }
        largest(m)
    }

    fn with_gain(&self, times: f64) -> Self {
        Self {
            gain: self.gain * times,
            ..self.clone()
        }
    }

    fn with_delay(&self, further: f64) -> Self {
        Self {
            delay: self.delay + further,
            ..self.clone()
        }
    }
}

/// The largest |eigenvalue|: lim |M^n|^(1/n), I. M. Gelfand, by n = 2^30.
fn largest(mut m: DMatrix<f64>) -> f64 {
    let (mut log, mut share) = (0.0, 1.0);
    for _ in 0..30 {
        let size = m.norm();
        if size == 0.0 {
            return 0.0;
        }
        log += share * size.ln();
        m /= size;
        m = &m * &m;
        share *= 0.5;
    }
    log.exp()
}

fn drawn(draw: &mut Draw, index: usize) -> Loop {
    let count = index % 4;
    let mut times: Vec<f64> = Vec::new();
    while times.len() < count {
        let tau = draw.scale(1e-4, 1e4);
        // Near each other partial fractions cancel.
        if times.iter().all(|other| (tau / other).ln().abs() > 1.0) {
            times.push(tau);
        }
    }
    if let Some(first) = times.first_mut() {
        match index % 12 {
            5 => *first = f64::INFINITY,
            6 => *first = -first.max(0.1),
            _ => {}
        }
    }
    let delay = match index % 5 {
        0 => 0.0,
        1 => draw.from(0.0, 5.0).floor(),
        _ => draw.from(0.0, 5.0),
    };
    // Slow ones take gain.
    let slow: f64 = times
        .iter()
        .filter(|tau| tau.is_finite())
        .map(|tau| tau.abs().max(1.0))
        .fold(1.0, f64::max);
    Loop {
        gain: draw.scale(0.1, 3.0) * slow,
        times,
        delay,
        proportional: draw.scale(0.1, 3.0),
        integral: if index.is_multiple_of(3) {
            draw.scale(1e-3, 0.3) / slow
        } else {
            0.0
        },
    }
}

/// Nearer to the circle the eigenvalues of three slow modes are not known.
const KNOWN: f64 = 1e-6;

/// Loops with what the code says of them, that the model contradicts.
fn contradicted(case: &Loop, tried: &mut usize) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut check = |what: &str, other: &Loop, stable: bool| {
        let radius = other.radius();
        if (radius - 1.0).abs() > KNOWN {
            *tried += 1;
            if (radius < 1.0) != stable {
                wrong.push(format!(
                    "{what}, called stable: {stable}, |z| = {radius}: {other:?}"
                ));
            }
        }
    };
    let closed = case.closed().expect("runs");
    let verdict = closed.verdict();
    if verdict.unstable_poles.is_none() {
        return Vec::new();
    }
    check("verdict", case, verdict.stable);
    if !verdict.stable {
        return wrong;
    }
    let margins = closed.margins();
    if let Some(up) = margins.gain_up {
        check("gain up", &case.with_gain(0.99 * up.value), true);
        check("gain up", &case.with_gain(1.01 * up.value), false);
    }
    let most = margins.gain_up.map_or(1e3, |up| 0.99 * up.value);
    for share in 1..10 {
        let gain = most.powf(f64::from(share) / 10.0);
        check("below gain up", &case.with_gain(gain), true);
    }
    if let Some(down) = margins.gain_down {
        check("gain down", &case.with_gain(1.01 * down.value), true);
        check("gain down", &case.with_gain(0.99 * down.value), false);
    }
    let tried = |delay: &Crossing| delay.value < 50.0 && !case.times.is_empty();
    if let Some(first) = margins.delay_s.filter(tried) {
        let later = |further| case.with_delay(further).closed();
        let delay = SampledControlLoop::delay_margin(Some(first), &later).expect("runs");
        let delay = delay.expect("a crossover").value;
        check("delay", &case.with_delay(0.99 * delay), true);
        check("delay", &case.with_delay(1.01 * delay), false);
    }
    wrong
}

/// `CAMPAIGN_CASES`: loops to try, 120 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn verdicts_and_margins_are_those_of_the_eigenvalues() {
    let cases: usize = testkit::cases(120);
    let (mut draw, mut tried) = (Draw(31), 0);
    let wrong: Vec<String> = (0..cases)
        .flat_map(|index| contradicted(&drawn(&mut draw, index), &mut tried))
        .collect();
    assert!(tried > 4 * cases, "{tried}");
    assert_eq!(wrong, [""; 0]);
}

/// Time constants of 1e-6 to 1e6 samples in one plant: at each frequency the held response is the sum of its modes. Three slow ones cancel in
/// that sum at high frequency, so there it is not asked.
#[test]
fn the_whole_range_in_one_plant() {
    for (times, thetas) in [
        (
            vec![1e6, 2.0, 0.3, 1e-6],
            &[1e-7, 1e-5, 1e-3, 0.1, 1.0, 3.0][..],
        ),
        (vec![1e6, 3e5, 1e5, 1e-6], &[1e-7, 1e-6, 1e-5][..]),
    ] {
        let case = Loop {
            gain: 3.0,
            times,
            delay: 0.3,
            proportional: 1.0,
            integral: 0.0,
        };
        let closed = case.closed().expect("runs");
        for theta in thetas {
            let w = Complex::from_polar(1.0, -theta);
            let modes = case.modes().into_iter().map(|(pole, residue)| {
                let a =
                    |from: f64, to: f64| (pole * from).exp() * (pole * (to - from)).exp_m1() / pole;
                (w * a(0.0, 0.7) + w * w * a(0.7, 1.0)) * residue / (-w * pole.exp() + 1.0)
            });
            let want: Complex<f64> = modes.sum();
            let have = closed.open(*theta);
            assert!((have / want - 1.0).norm() < 1e-5, "{theta}: {have} {want}");
        }
    }
}
