//! The clock of a device by that of this machine, from keep-alives: offset, rate, and a bound of the error.
//!
//! ```text
//! keep-alive i:  sent hₛ, answered d by the device's clock, heard hᵣ     hᵢ = (hₛ + hᵣ)/2,  ρᵢ = (hᵣ − hₛ)/2
//! the clock      D(h) = a + r·h     with     |D(hᵢ) − dᵢ| ≤ r·ρᵢ        however the two ways share the round trip
//! estimate       minimises Σ wᵢ (a + r·hᵢ − dᵢ)²,   wᵢ = 1/(ρᵢ + 1 µs)²
//! ```
//! Of each stretch of keep-alives the one with the least round trip is kept. The error e(h) of the estimate is a line too,
//! at hᵢ at most eᵢ = |residual| + r·ρᵢ. So the best keep-alives p and q of the first and the last third bound it all along:
//!
//! ```text
//! |e(h)| ≤ (|h − h_q|·e_p + |h − h_p|·e_q)/(h_q − h_p)  +  max over i of (|residual| − r·ρᵢ)
//! ```
//! The last term is above 0 only for a clock that is not a line, such as an emulated one that was held back.
//!
//! Source: F. Cristian, *Probabilistic clock synchronization*, Distributed Computing 3, 1989, section 3.

use haptic_loop::realtime::Moment;
use std::vec::Vec;

/// Stretches that are kept; beyond it each becomes twice as long.
const STRETCHES: usize = 512;

/// Below this span of keep-alives, µs, a rate that may be 1 is 1: clocks are better than what the round trips leave open.
const SHORT_US: f64 = 10e6;

/// A keep-alive that was answered; times of this machine from an epoch of its own, µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ping {
    /// When it was sent.
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
    /// Takes one in.
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
        let (first, last) = (self.best.first()?, self.best.last()?);
        let span_us = last.middle_us() - first.middle_us();
        let weight = |ping: &Ping| (ping.half_us() + 1.0).powi(-2);
        let total: f64 = self.best.iter().map(weight).sum();
        let mean = |of: &dyn Fn(&Ping) -> f64| {
            let sum: f64 = self.best.iter().map(|ping| weight(ping) * of(ping)).sum();
            sum / total
        };
        // From the first on, so that no digits are lost.
        let here = |ping: &Ping| ping.middle_us() - first.middle_us();
        let there = |ping: &Ping| ping.device_us as f64 - first.device_us as f64;
        let (here_mean, there_mean) = (mean(&here), mean(&there));
        let spread = mean(&|ping| (here(ping) - here_mean).powi(2));
        let both = mean(&|ping| (here(ping) - here_mean) * (there(ping) - there_mean));
        let slope = if spread > 0.0 { both / spread } else { 1.0 };
        let widest = self.best.iter().map(Ping::half_us).fold(0.0, f64::max);
        let open = span_us < SHORT_US && (slope - 1.0).abs() * span_us < 2.0 * widest;
        let rate = if open { 1.0 } else { slope };
        let mut clock = DeviceClock {
            epoch,
            here_us: first.middle_us() + here_mean,
            there_us: first.device_us as f64 + there_mean,
            rate,
            error_us: 0.0,
        };
        clock.error_us = self.error_us(&clock, [first.middle_us(), last.middle_us()]);
        Some(clock)
    }

    /// The bound of the module over these times.
    fn error_us(&self, clock: &DeviceClock, [from, to]: [f64; 2]) -> f64 {
        let residual = |ping: &Ping| (clock.at(ping.middle_us()) - ping.device_us as f64).abs();
        let within = |ping: &Ping| residual(ping) + clock.rate * ping.half_us();
        let third = self.best.len().div_ceil(3);
        let least = |part: &[Ping]| {
            let points = part.iter().map(|ping| (ping.middle_us(), within(ping)));
            points.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let bent = self
            .best
            .iter()
            .map(|ping| residual(ping) - clock.rate * ping.half_us());
        let bent = bent.fold(0.0, f64::max);
        let ends = least(&self.best[..third]).zip(least(&self.best[self.best.len() - third..]));
        let Some(((p, e_p), (q, e_q))) = ends else {
            return f64::INFINITY;
        };
        if q - p <= 0.0 {
            return e_p + bent;
        }
        let error = |h: f64| ((h - q).abs() * e_p + (h - p).abs() * e_q) / (q - p);
        error(from).max(error(to)) + bent
    }
}

/// The one with the shorter round trip.
fn better(a: Ping, b: Ping) -> Ping {
    if b.half_us() < a.half_us() { b } else { a }
}

/// D(h): the time of a device by that of this machine, µs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceClock {
    epoch: Moment,
    /// A time here, and the device's at it.
    here_us: f64,
    there_us: f64,
    /// Its seconds in one of this machine.
    pub rate: f64,
    /// Largest error over the keep-alives that it is made from, µs of the device.
    pub error_us: f64,
}

impl DeviceClock {
    fn at(&self, here_us: f64) -> f64 {
        self.there_us + self.rate * (here_us - self.here_us)
    }

    /// The time of this device when it is `other_us` on another, µs.
    #[must_use]
    pub fn when(&self, other: &Self, other_us: f64) -> f64 {
        let here_us = other.here_us + (other_us - other.there_us) / other.rate;
        let us = |a: Moment, b: Moment| a.saturating_duration_since(b).as_secs_f64() * 1e6;
        self.at(here_us + us(other.epoch, self.epoch) - us(self.epoch, other.epoch))
    }

    /// The largest error of [`when`](Self::when), µs of this device.
    #[must_use]
    pub fn error_beside_us(&self, other: &Self) -> f64 {
        self.error_us + other.error_us * self.rate / other.rate
    }

    /// The time of the device of which these are the lower 32 bits: the one nearest to now.
    #[must_use]
    pub fn whole_us(&self, low: u32) -> f64 {
        const TURN: f64 = 4_294_967_296.0;
        let now_us = self.at(self.epoch.elapsed().as_secs_f64() * 1e6);
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
            let (there, back) = (way(self.ways_us[0]), way(self.ways_us[1]));
            Ping {
                sent_us: now_us as u64,
                heard_us: (now_us + there + back) as u64,
                device_us: self.at(now_us + there) as u64,
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
                    let own = |us: u64| (us as f64 + begun_us) as u64;
                    let (sent_us, heard_us) = (own(ping.sent_us), own(ping.heard_us));
                    pings.add(Ping {
                        sent_us,
                        heard_us,
                        ..ping
                    });
                }
            }
            let clocks = [0, 1].map(|n| pings[n].clock(epochs[n]).expect("pings"));
            // What passed between the two epochs while this test took them.
            let between =
                epochs[1].saturating_duration_since(epochs[0]).as_secs_f64() * 1e6 + begun_us[1];
            let bound_us = clocks[0].error_beside_us(&clocks[1]);
            for n in 0..=200 {
                let here_us = 1e6 + 1e6 * f64::from(n);
                let second_us = devices[1].at(here_us - between);
                let error = clocks[0].when(&clocks[1], second_us) - devices[0].at(here_us);
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
        let clock = pings.clock(Moment::now()).expect("pings");
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
        let clock = pings.clock(Moment::now()).expect("one");
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
        assert!((clock.rate - 20.0).abs() < 1e-9, "{clock:?}");
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
