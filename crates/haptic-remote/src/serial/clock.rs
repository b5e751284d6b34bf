//! The clocks of devices by that of this machine, from keep-alives, and of two devices beside each other: offset, rate, and a bound of
//! the error.
//!
//! ```text
//! keep-alive i:  sent hₛ, answered d by the device's clock, heard hᵣ     hᵢ = (hₛ + hᵣ)/2,  ρᵢ = (hᵣ − hₛ)/2
//! its clock      |D(hᵢ) − dᵢ| ≤ ρᵢ                                       however the two ways share the round trip
//! two devices    xᵢ = dᵢ of the second,  yᵢ = D(hᵢ) of the first on a straight line between its keep-alives around hᵢ,  uᵢ = ρᵢ + ρ + what
//!                the first was held back between them beyond its mean rate and their ρ
//! estimate       y = a + r·x minimises Σ wᵢ (a + r·xᵢ − yᵢ)²,   wᵢ = 1/(uᵢ + |residual of the round before| + 1 µs)²
//! ```
//! Of each stretch of keep-alives the one with the least round trip is kept. The error e(x) of the estimate is a line too, at xᵢ at most
//! eᵢ = |residual| + uᵢ. So the best points p and q of the first and the last third bound it all along:
//!
//! ```text
//! |e(x)| ≤ (|x − x_q|·e_p + |x − x_p|·e_q)/(x_q − x_p)  +  max over i of (|residual| − uᵢ)
//! ```
//! The last term is above 0 only for clocks that are no lines to each other. Two emulated ones that were held back together are.
//!
//! Source: F. Cristian, *Probabilistic clock synchronization*, Distributed Computing 3, 1989, section 3.

use haptic_loop::realtime::Moment;
use std::vec::Vec;

/// Stretches that are kept; beyond it each becomes twice as long.
const STRETCHES: usize = 512;

/// Rounds of the estimate, each with the residuals of the one before.
const ROUNDS: u32 = 8;

/// Below this span of keep-alives, µs, a rate that may be 1 is 1: clocks are better than what the round trips leave open.
const SHORT_US: f64 = 10e6;

/// A keep-alive that was answered; times of this machine from an epoch of its own, µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ping {
    /// Time at which it was sent.
    pub sent_us: u64,
    /// When its answer was heard.
    pub heard_us: u64,
    /// The device's own time in it.
    pub device_us: u64,
}

impl Ping {
    fn middle_us(&self) -> f64 {
        0.5 * (self.sent_us as f64 + self.heard_us as f64)
    }

    /// ρ, half of the round trip, µs.
    fn half_us(&self) -> f64 {
        0.5 * self.heard_us.saturating_sub(self.sent_us) as f64
    }
}

/// The best keep-alive of each stretch.
#[derive(Clone, Debug)]
pub struct Pings {
    best: Vec<Ping>,
    /// Keep-alives of a stretch, and those in the last.
    each: u32,
    in_last: u32,
}

impl Default for Pings {
    fn default() -> Self {
        Self {
            best: Vec::new(),
            each: 1,
            in_last: 1,
        }
    }
}

impl Pings {
    /// Takes a keep-alive in; of each stretch, that with the shortest round trip is kept.
    pub fn add(&mut self, ping: Ping) {
        if let Some(last) = self.best.last_mut()
            && self.in_last < self.each
        {
            self.in_last += 1;
            *last = better(*last, ping);
            return;
        }
        if self.best.len() == STRETCHES {
            let pairs = self.best.chunks(2);
            self.best = pairs
                .filter_map(|pair| pair.iter().copied().reduce(better))
                .collect();
            self.each = self.each.saturating_mul(2);
        }
        self.best.push(ping);
        self.in_last = 1;
    }

    /// The clock of the device, whose times count from `epoch` here; `None` before the first keep-alive.
    #[must_use]
    pub fn clock(&self, epoch: Moment) -> Option<DeviceClock> {
        let points = self.best.iter();
        let points = points.map(|ping| [ping.middle_us(), ping.device_us as f64, ping.half_us()]);
        let points: Vec<[f64; 3]> = points.collect();
        Some(DeviceClock {
            epoch,
            line: ClockLine::through(&points)?,
            points,
        })
    }
}

/// The one with the shorter round trip.
fn better(a: Ping, b: Ping) -> Ping {
    if b.half_us() < a.half_us() { b } else { a }
}

/// A straight line between two clocks, y(x) in µs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockLine {
    x_us: f64,
    y_us: f64,
    /// Seconds of y in one of x.
    pub rate: f64,
    /// Largest error over the points that it is made from, µs.
    pub error_us: f64,
}

impl ClockLine {
    /// y at this x, µs.
    #[must_use]
    pub fn at(&self, x_us: f64) -> f64 {
        self.y_us + self.rate * (x_us - self.x_us)
    }

    /// The estimate of the module by points x, y and u, in the order of x.
    fn through(points: &[[f64; 3]]) -> Option<Self> {
        let first = points.first()?;
        let mut line = Self {
            x_us: first[0],
            y_us: first[1],
            rate: 1.0,
            error_us: 0.0,
        };
        // The first round knows no line, and so no residuals.
        let mut weights: Vec<f64> = points
            .iter()
            .map(|[_, _, u]| libm::pow(u + 1.0, -2.0))
            .collect();
        for _ in 0..ROUNDS {
            line = Self::fitted(points, &weights)?;
            let weight = |point: &[f64; 3]| libm::pow(point[2] + line.residual(point) + 1.0, -2.0);
            weights = points.iter().map(weight).collect();
        }
        line.error_us = line.bound_us(points);
        Some(line)
    }

    fn fitted(points: &[[f64; 3]], weights: &[f64]) -> Option<Self> {
        let (first, last) = (points.first()?, points.last()?);
        let total: f64 = weights.iter().sum();
        // From the first on, so that no digits are lost.
        let mean = |of: &dyn Fn(f64, f64) -> f64| {
            let weighed = points.iter().zip(weights);
            let weighed =
                weighed.map(|([x, y, _], weight)| weight * of(x - first[0], y - first[1]));
            weighed.sum::<f64>() / total
        };
        let (x_mean, y_mean) = (mean(&|x, _| x), mean(&|_, y| y));
        let spread = mean(&|x, _| libm::pow(x - x_mean, 2.0));
        let both = mean(&|x, y| (x - x_mean) * (y - y_mean));
        let slope = if spread > 0.0 { both / spread } else { 1.0 };
        let span_us = last[0] - first[0];
        let widest = points.iter().map(|[_, _, u]| *u).fold(0.0, f64::max);
        let open = span_us < SHORT_US && (slope - 1.0).abs() * span_us < 2.0 * widest;
        Some(Self {
            x_us: first[0] + x_mean,
            y_us: first[1] + y_mean,
            rate: if open { 1.0 } else { slope },
            error_us: 0.0,
        })
    }

    fn residual(&self, [x, y, _]: &[f64; 3]) -> f64 {
        (self.at(*x) - y).abs()
    }

    /// The bound of the module over these x.
    fn bound_us(&self, points: &[[f64; 3]]) -> f64 {
        let third = points.len().div_ceil(3);
        let least = |part: &[[f64; 3]]| {
            let bounds = part
                .iter()
                .map(|point| (point[0], self.residual(point) + point[2]));
            bounds.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let bent = points.iter().map(|point| self.residual(point) - point[2]);
        let bent = bent.fold(0.0, f64::max);
        let ends = least(&points[..third]).zip(least(&points[points.len() - third..]));
        let Some(((p, e_p), (q, e_q))) = ends else {
            return f64::INFINITY;
        };
        if q - p <= 0.0 {
            return e_p + bent;
        }
        let error = |x: f64| ((x - q).abs() * e_p + (x - p).abs() * e_q) / (q - p);
        let ends = points.iter().map(|point| error(point[0]));
        ends.fold(0.0, f64::max) + bent
    }
}

/// The clock of a device by that of this machine.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceClock {
    epoch: Moment,
    /// Line of the device's clock by times from the epoch.
    line: ClockLine,
    points: Vec<[f64; 3]>,
}

impl DeviceClock {
    /// The time of this device by that of another; `None` if no keep-alive of the other lies between two of this one.
    #[must_use]
    pub fn relative_to(&self, other: &Self) -> Option<ClockLine> {
        let us = |a: Moment, b: Moment| a.saturating_duration_since(b).as_secs_f64() * 1e6;
        let shift_us = us(other.epoch, self.epoch) - us(self.epoch, other.epoch);
        let points = other.points.iter().filter_map(|[h, theirs, their_u]| {
            let h = h + shift_us;
            let after = self.points.partition_point(|[host_us, ..]| *host_us < h);
            let [h_0, d_0, u_0] = *self.points.get(after.checked_sub(1)?)?;
            let [h_1, d_1, u_1] = *self.points.get(after)?;
            let share = (h - h_0) / (h_1 - h_0);
            let between = |a: f64, b: f64| a + share * (b - a);
            // Longest time for which the device was held up in between, early or late.
            let held = (d_1 - d_0 - self.line.rate * (h_1 - h_0)).abs() - u_0 - u_1;
            let held = held.max(0.0) * share.max(1.0 - share);
            Some([
                *theirs,
                between(d_0, d_1),
                between(u_0, u_1) + their_u + held,
            ])
        });
        ClockLine::through(&points.collect::<Vec<_>>())
    }

    /// The time of the device of which these are the lower 32 bits: the one nearest to now.
    #[must_use]
    pub fn whole_us(&self, low: u32) -> f64 {
        const TURN: f64 = 4_294_967_296.0;
        let now_us = self.line.at(self.epoch.elapsed().as_secs_f64() * 1e6);
        let low = f64::from(low);
        low + TURN * ((now_us - low) / TURN).round().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Chances of a test: the same with the same seed (splitmix64, Steele, Lea and Flood, 2014).
    struct Chance(u64);

    impl Chance {
        /// Uniform in 0..1.
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn between(&mut self, low: f64, high: f64) -> f64 {
            low + (high - low) * self.uniform()
        }
    }

    /// A device, its clock against that of this machine, and the least times of its line, µs.
    struct Device {
        offset_us: f64,
        rate: f64,
        ways_us: [f64; 2],
    }

    impl Device {
        fn new(chance: &mut Chance) -> Self {
            Self {
                offset_us: chance.between(0.0, 1e9),
                rate: 1.0 + chance.between(-1e-4, 1e-4),
                ways_us: [chance.between(30.0, 70.0), chance.between(30.0, 70.0)],
            }
        }

        fn at(&self, here_us: f64) -> f64 {
            self.offset_us + self.rate * here_us
        }

        /// A keep-alive sent now; each way takes its least time, and now and then much longer.
        fn ping(&self, now_us: f64, chance: &mut Chance) -> Ping {
            let mut way = |least: f64| {
                let long = chance.uniform() < 0.2;
                least - chance.between(5.0, 200.0) * (1.0 - chance.uniform()).ln()
                    + if long { chance.between(0.0, 2e4) } else { 0.0 }
            };
            let (outward_us, homeward_us) = (way(self.ways_us[0]), way(self.ways_us[1]));
            Ping {
                sent_us: now_us as u64,
                heard_us: (now_us + outward_us + homeward_us) as u64,
                device_us: self.at(now_us + outward_us) as u64,
            }
        }
    }

    /// What 200 s of keep-alives tell of two clocks is within 50 µs of the truth all along, and within its own bound.
    #[test]
    fn two_clocks_are_known_within_50_us_and_within_what_is_said() {
        let (mut worst, mut widest) = (0.0_f64, 0.0_f64);
        for seed in 0..200 {
            let chance = &mut Chance(seed);
            let devices = [Device::new(chance), Device::new(chance)];
            let epochs = [Moment::now(), Moment::now() + Duration::from_millis(seed)];
            let begun_us = [0.0, -1e3 * seed as f64];
            let mut pings = [Pings::default(), Pings::default()];
            for n in 0..1600 {
                let now_us = 1e6 + 125e3 * f64::from(n) + chance.between(0.0, 1e3);
                for ((device, pings), begun_us) in devices.iter().zip(&mut pings).zip(begun_us) {
                    let ping = device.ping(now_us, chance);
                    // Counted from an epoch of its own.
                    let device_time = |us: u64| (us as f64 + begun_us) as u64;
                    let (sent_us, heard_us) =
                        (device_time(ping.sent_us), device_time(ping.heard_us));
                    pings.add(Ping {
                        sent_us,
                        heard_us,
                        ..ping
                    });
                }
            }
            let clocks: [DeviceClock; 2] =
                [0, 1].map(|n| pings[n].clock(epochs[n]).expect("pings"));
            // What passed between the two epochs while this test took them.
            let between =
                epochs[1].saturating_duration_since(epochs[0]).as_secs_f64() * 1e6 + begun_us[1];
            let line = clocks[0].relative_to(&clocks[1]).expect("between");
            let bound_us = line.error_us;
            for n in 0..=200 {
                let here_us = 1e6 + 1e6 * f64::from(n);
                let second_us = devices[1].at(here_us - between);
                let error = line.at(second_us) - devices[0].at(here_us);
                worst = worst.max(error.abs());
                assert!(
                    error.abs() <= bound_us + 2.0,
                    "{seed} at {here_us}: {error} {bound_us}"
                );
            }
            widest = widest.max(bound_us);
        }
        assert!(worst < 50.0, "{worst}");
        // A bound that says nothing would be no use: half of the least round trips is 60 to 140 µs, the best of each third took longer.
        assert!((60.0..400.0).contains(&widest), "{widest}");
    }

    /// Two clocks that one busy machine holds back together stay a line to each other.
    #[test]
    fn clocks_that_are_held_back_together_are_told_apart_from_a_bent_one() {
        let chance = &mut Chance(3);
        let device = Device {
            offset_us: 0.0,
            rate: 1.0,
            ways_us: [50.0; 2],
        };
        let mut pings = [Pings::default(), Pings::default()];
        let mut held_us = 0;
        for n in 0..1600 {
            let now_us = 1e6 + 125e3 * f64::from(n);
            held_us += if chance.uniform() < 0.02 { 20_000 } else { 0 };
            for pings in &mut pings {
                let ping = device.ping(now_us, chance);
                // Now and then one of them is behind its own clock.
                let behind_us = if chance.uniform() < 0.1 {
                    chance.between(0.0, 5e3)
                } else {
                    0.0
                };
                pings.add(Ping {
                    device_us: ping.device_us.saturating_sub(held_us + behind_us as u64),
                    ..ping
                });
            }
        }
        let epoch = Moment::now();
        let [first, second] = [0, 1].map(|n: usize| pings[n].clock(epoch).expect("pings"));
        let line = first.relative_to(&second).expect("between");
        for n in 0..200 {
            let error = (line.at(1e6 * f64::from(n)) - 1e6 * f64::from(n)).abs();
            assert!(error < 50.0, "{n}: {error}");
        }
        assert!(first.line.error_us > 1e4, "{}", first.line.error_us);
    }

    #[test]
    fn a_clock_that_was_held_back_says_so() {
        let device = Device {
            offset_us: 0.0,
            rate: 1.0,
            ways_us: [50.0; 2],
        };
        let chance = &mut Chance(1);
        let mut pings = Pings::default();
        for n in 0..1000 {
            let held_us = if n < 500 { 0 } else { 7000 };
            let ping = device.ping(1e6 + 1e5 * f64::from(n), chance);
            pings.add(Ping {
                device_us: ping.device_us - held_us,
                ..ping
            });
        }
        let clock = pings.clock(Moment::now()).expect("pings").line;
        for n in [0.0_f64, 250.0, 499.0, 500.0, 750.0, 999.0] {
            let here_us = 1e6 + 1e5 * n;
            let truth = here_us - if n < 500.0 { 0.0 } else { 7000.0 };
            let error = (clock.at(here_us) - truth).abs();
            assert!(error <= clock.error_us, "{n}: {error} {}", clock.error_us);
        }
        assert!(clock.error_us > 3000.0, "{}", clock.error_us);
    }

    #[test]
    fn a_fast_clock_is_followed_and_one_keep_alive_is_enough_to_begin() {
        let ping = Ping {
            sent_us: 1000,
            heard_us: 1200,
            device_us: 70_000,
        };
        let mut pings = Pings::default();
        assert!(pings.clock(Moment::now()).is_none());
        pings.add(ping);
        let clock = pings.clock(Moment::now()).expect("one").line;
        assert_eq!(
            (clock.at(1100.0), clock.rate, clock.error_us),
            (70_000.0, 1.0, 100.0)
        );
        // Twenty of its seconds in one.
        for n in 1..40 {
            pings.add(Ping {
                sent_us: ping.sent_us + 5000 * n,
                heard_us: ping.heard_us + 5000 * n,
                device_us: ping.device_us + 100_000 * n,
            });
        }
        let clock = pings.clock(Moment::now()).expect("forty");
        assert!((clock.line.rate - 20.0).abs() < 1e-9, "{clock:?}");
        let low = (1_u32 << 31) + 7;
        assert!((clock.whole_us(low) - f64::from(low)).abs() < 0.5);
        // More stretches than are kept: each becomes longer, and what it spans stays.
        for n in 40..3000 {
            pings.add(Ping {
                sent_us: ping.sent_us + 5000 * n,
                heard_us: ping.heard_us + 5000 * n,
                device_us: ping.device_us + 100_000 * n,
            });
        }
        assert!(
            pings.best.len() <= STRETCHES && pings.each == 8,
            "{}",
            pings.each
        );
        assert_eq!(pings.best.first(), Some(&ping));
    }
}
