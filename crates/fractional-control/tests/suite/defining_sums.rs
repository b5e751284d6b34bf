//! Verdicts and margins against loops that are run by their defining sums, in code of its own: no kernel, no matrix, no modes.
//!
//! ```text
//! whole lag, integrator:  y[n+1] = a·y[n] + b₀·u[n−d] + b₁·u[n−d−1], the hold switching inside the sample (modified z-transform)
//! fractional lag:         τT^(−α)·Σ w_k y[n−k] + y[n] = k·Σ p_j u[n−d−j], w_k = (−1)^k·C(α, k)
//! controller:             u[n] = −K_p·y[n] − K_i·T^λ·Σ w_k^(−λ) y[n−k]
//! ```

use crate::fixture::{Draw, pi};
use fracdiff::Seconds;
use fractional_control::{Crossing, HeldPlant, Plant, PowerMemory, Rule, SampledControlLoop};

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// k/(τs + 1)
    Lag,
    /// k/(τs − 1)
    Unstable,
    /// k/s
    Integrator,
    /// k/(τs^α + 1)
    Fractional(f64),
}

/// A plant, a controller and a sample time.
#[derive(Clone, Copy, Debug)]
struct Loop {
    kind: Kind,
    gain: f64,
    tau: f64,
    delay: f64,
    proportional: f64,
    integral: f64,
    order: f64,
    t: f64,
}

/// Samples of a run, and of longer ones where the first does not show it: a slow mode may rise before it decays.
const SAMPLES: [usize; 3] = [3000, 12_000, 48_000];

/// Grünwald's weights of D^order, without T^(−order).
fn weights(order: f64, samples: usize) -> Vec<f64> {
    let next = |last: &f64, k: usize| last * (k as f64 - 1.0 - order) / k as f64;
    let mut all = vec![1.0];
    for k in 1..samples {
        all.push(next(&all[k - 1], k));
    }
    all
}

/// The sum of the weights times x\[n − k\] from k = 1 on.
fn past(weights: &[f64], x: &[f64]) -> f64 {
    let pairs = weights[1..].iter().zip(x.iter().rev());
    pairs.map(|(w, x)| w * x).sum()
}

impl Loop {
    fn draw(draw: &mut Draw, index: usize) -> Self {
        let t = draw.from(0.01, 0.05);
        let kind = match index % 4 {
            0 => Kind::Lag,
            1 => Kind::Unstable,
            2 => Kind::Integrator,
            _ => Kind::Fractional(draw.from(0.3, 1.7)),
        };
        Self {
            kind,
            gain: draw.scale(0.3, 3.0),
            tau: draw.from(0.2, 2.0),
            delay: draw.from(0.0, 6.0) * t,
            proportional: draw.scale(0.5, 20.0),
            integral: draw.from(0.0, 3.0),
            order: draw.from(0.4, 1.2),
            t,
        }
    }

    fn plant(&self) -> Plant {
        let Self {
            gain, tau, delay, ..
        } = self;
        let function = match self.kind {
            Kind::Lag => format!("{gain}/({tau}s+1)"),
            Kind::Unstable => format!("{gain}/({tau}s-1)"),
            Kind::Integrator => format!("{gain}/s"),
            Kind::Fractional(order) => format!("{gain}/({tau}s^{order}+1)"),
        };
        Plant::transfer(function.parse().expect("valid"), *delay).expect("valid")
    }

    fn closed(&self) -> SampledControlLoop {
        let memory = PowerMemory::new(Rule::Grunwald, 1e-9, 1e4).expect("valid");
        let plant = HeldPlant::new(&self.plant(), memory, Seconds(self.t)).expect("runs");
        let controller = pi(self.proportional, self.integral, self.order);
        SampledControlLoop::new(controller.into(), memory, &plant).expect("valid")
    }

    fn with_gain(self, times: f64) -> Self {
        Self {
            gain: self.gain * times,
            ..self
        }
    }

    fn with_delay(self, further: f64) -> Self {
        Self {
            delay: self.delay + further,
            ..self
        }
    }

    /// True if a change of a hundredth shows at this frequency in so many samples.
    fn is_seen(&self, crossing: &Crossing) -> bool {
        crossing.omega_rad_s * self.t * SAMPLES[0] as f64 > 150.0
    }

    /// Loops just within and just beyond each margin.
    fn beside_margins(self) -> Vec<(&'static str, Self, bool)> {
        let closed = self.closed();
        let margins = closed.margins();
        let seen = |crossing: Option<Crossing>| crossing.filter(|at| self.is_seen(at));
        let mut tried = Vec::new();
        if let Some(up) = seen(margins.gain_up) {
            tried.push(("gain up", self.with_gain(0.99 * up.value), false));
            tried.push(("gain up", self.with_gain(1.01 * up.value), true));
        }
        if let Some(down) = seen(margins.gain_down) {
            tried.push(("gain down", self.with_gain(1.01 * down.value), false));
            tried.push(("gain down", self.with_gain(0.99 * down.value), true));
        }
        // Of a plant that follows a rule it is that of the plant: `held_loops`.
        let is_exact = closed.of_plant().is_none();
        if let Some(first) = seen(margins.delay_s).filter(|_| is_exact) {
            let later = |further| Ok::<_, ()>(self.with_delay(further).closed());
            let delay = SampledControlLoop::delay_margin(Some(first), &later).expect("runs");
            let delay = delay.expect("a crossover").value;
            tried.push(("delay", self.with_delay(0.99 * delay), false));
            tried.push(("delay", self.with_delay(1.01 * delay), true));
        }
        tried
    }

    /// y after a tap on the command, by the sums above.
    fn run(&self, samples: usize) -> Vec<f64> {
        let late = self.delay / self.t;
        let (d, h) = (late.floor() as usize, late.fract());
        let integral = weights(-self.order, samples);
        let k_i = self.integral * self.t.powf(self.order);
        let (mut u, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let fractional = match self.kind {
            Kind::Fractional(order) => weights(order, samples),
            Kind::Lag | Kind::Unstable | Kind::Integrator => Vec::new(),
        };
        for n in 0..samples {
            let late = |u: &[f64], lag: usize| n.checked_sub(lag).map_or(0.0, |place| u[place]);
            let of_the_law = k_i * past(&integral, &y);
            let tap = if n == 0 { 1.0 } else { 0.0 };
            let direct = self.proportional + k_i;
            let now = match self.kind {
                Kind::Fractional(order) => {
                    let scale = self.tau * self.t.powf(-order);
                    let hat = [0.5 * (1.0 - h) * (1.0 - h), 0.5 + h - h * h, 0.5 * h * h];
                    let known = (0..3).filter(|j| d + j > 0);
                    let held: f64 = known.map(|j| hat[j] * late(&u, d + j)).sum();
                    let free = self.gain * held - scale * past(&fractional, &y);
                    // Without dead time u[n], which is tap − direct·y[n] − of_the_law, acts at once.
                    let at_once = if d == 0 { self.gain * hat[0] } else { 0.0 };
                    (free + at_once * (tap - of_the_law)) / (1.0 + scale + at_once * direct)
                }
                Kind::Lag | Kind::Unstable | Kind::Integrator => {
                    self.state(
                        &y,
                        h,
                        |lag| if n == 0 { 0.0 } else { late(&u, d + lag + 1) },
                    )
                }
            };
            y.push(now);
            u.push(tap - direct * now - of_the_law);
        }
        y
    }

    /// The next y of one that is a state, from the commands at the last sample (lag 0) and the one before, both so late.
    fn state(&self, y: &[f64], h: f64, command: impl Fn(usize) -> f64) -> f64 {
        let rate = match self.kind {
            Kind::Lag => -1.0 / self.tau,
            Kind::Unstable => 1.0 / self.tau,
            Kind::Integrator | Kind::Fractional(_) => 0.0,
        };
        let scale = if rate == 0.0 {
            self.gain
        } else {
            self.gain / self.tau
        };
        // ∫ e^(rate·s) ds from a to b.
        let area = |a: f64, b: f64| match rate {
            0.0 => b - a,
            rate => ((rate * b).exp() - (rate * a).exp()) / rate,
        };
        let early = scale * area(0.0, (1.0 - h) * self.t);
        let last = scale * area((1.0 - h) * self.t, self.t);
        let before = y.last().copied().unwrap_or(0.0);
        (rate * self.t).exp() * before + early * command(0) + last * command(1)
    }
}

/// The swing of the last of three thirds over that of the second; infinite where it has overflowed.
fn growth(y: &[f64]) -> f64 {
    let third = y.len() / 3;
    let swing = |part: &[f64]| {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = part
            .iter()
            .fold(ends, |(low, high), y| (low.min(*y), high.max(*y)));
        high - low
    };
    if y.iter().any(|y| !y.is_finite()) {
        return f64::INFINITY;
    }
    let last = swing(&y[2 * third..]);
    // At rest, but for rounding.
    if last < 1e-200 {
        0.0
    } else {
        last / swing(&y[third..2 * third])
    }
}

/// `CAMPAIGN_CASES`: loops to try, 60 by default.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn verdicts_and_margins_are_those_of_the_defining_sums() {
    let cases: usize = testkit::cases(60);
    let mut draw = Draw(24);
    let mut wrong = Vec::new();
    let mut tried: std::collections::BTreeMap<_, usize> = std::collections::BTreeMap::new();
    for index in 0..cases {
        let case = Loop::draw(&mut draw, index);
        let stable = case.closed().verdict().stable;
        let mut loops = vec![(if stable { "stable" } else { "unstable" }, case, !stable)];
        if stable {
            loops.extend(case.beside_margins());
        }
        for (what, tap, grows) in loops {
            *tried.entry(what).or_default() += 1;
            let shows = |samples: &usize| (growth(&tap.run(*samples)) > 1.0) == grows;
            if !SAMPLES.iter().any(shows) {
                wrong.push(format!("{index}, {what}, must grow: {grows}; {tap:?}"));
            }
        }
    }
    for what in ["stable", "unstable", "gain up", "delay"] {
        let count = tried.get(what).copied().unwrap_or(0);
        assert!(count >= cases / 10, "{what}: {count}");
    }
    assert_eq!(wrong, [""; 0]);
}
