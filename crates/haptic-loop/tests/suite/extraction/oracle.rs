//! What a motion draws from device and loop, in closed form, event by event.

use nalgebra::SVector;

/// A sum with the error of its rounding (Knuth's two-sum), J.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    pub(super) fn add(&mut self, value: f64) {
        let sum = self.high + value;
        let added = sum - self.high;
        self.low += (self.high - (sum - added)) + (value - added);
        self.high = sum;
    }

    pub(super) fn value(&self) -> f64 {
        self.high + self.low
    }
}

/// A stretch of time between two events: its length, and g = u + p·e^(−t/τ) on each axis.
#[derive(Clone, Debug)]
pub(super) struct Stretch<const D: usize> {
    length: f64,
    command: SVector<f64, D>,
    rest: SVector<f64, D>,
}

impl<const D: usize> Stretch<D> {
    /// ∫ e^(−k·t/τ) dt.
    fn fading(&self, lag: f64, k: f64) -> f64 {
        if lag > 0.0 {
            -lag / k * (-k * self.length / lag).exp_m1()
        } else {
            0.0
        }
    }

    /// ∫ g dt.
    pub(super) fn impulse(&self, lag: f64) -> SVector<f64, D> {
        self.command * self.length + self.rest * self.fading(lag, 1.0)
    }

    /// ∫ (damping·v² − g·v) dt for v = c + e·g.
    pub(super) fn energy(&self, lag: f64, damping: f64, c: &SVector<f64, D>, e: f64) -> f64 {
        let (one, two) = (self.fading(lag, 1.0), self.fading(lag, 2.0));
        let mean = c + self.command * e;
        let vv = mean.norm_squared() * self.length
            + 2.0 * e * mean.dot(&self.rest) * one
            + e * e * self.rest.norm_squared() * two;
        let gv = self.command.dot(&mean) * self.length
            + (self.rest.dot(&mean) + e * self.command.dot(&self.rest)) * one
            + e * self.rest.norm_squared() * two;
        damping * vv - gv
    }
}

/// The actuator: commands on their way, and its force.
#[derive(Clone, Debug)]
pub(super) struct Actuator<const D: usize> {
    lag: f64,
    /// When each acts, s; in this order.
    due: std::collections::VecDeque<(f64, SVector<f64, D>)>,
    command: SVector<f64, D>,
    force: SVector<f64, D>,
}

impl<const D: usize> Actuator<D> {
    pub(super) fn new(lag: f64) -> Self {
        Self {
            lag,
            due: std::collections::VecDeque::new(),
            command: SVector::zeros(),
            force: SVector::zeros(),
        }
    }

    pub(super) fn send(&mut self, at: f64, force: SVector<f64, D>) {
        let last = self.due.back().map_or(f64::NEG_INFINITY, |(due, _)| *due);
        self.due.push_back((at.max(last), force));
    }

    /// The stretches of motion and force from one time to another.
    pub(super) fn run(&mut self, from: f64, to: f64) -> Vec<Stretch<D>> {
        let mut stretches = Vec::new();
        let mut now = from;
        while now < to {
            while self.due.front().is_some_and(|(due, _)| *due <= now) {
                self.command = self.due.pop_front().expect("there").1;
            }
            let next = self.due.front().map_or(to, |(due, _)| due.min(to));
            let lags = self.lag > 0.0;
            let rest = if lags {
                self.force - self.command
            } else {
                SVector::zeros()
            };
            let length = next - now;
            stretches.push(Stretch {
                length,
                command: self.command,
                rest,
            });
            let left = if lags {
                (-length / self.lag).exp()
            } else {
                0.0
            };
            self.force = self.command + rest * left;
            now = next;
        }
        stretches
    }
}
