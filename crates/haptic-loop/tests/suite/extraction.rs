//! Energy that motions can draw from a loop with energy bounding, by adversaries that are optimised for it.
//!
//! The oracle does not know the guard's books. It follows the commands to the device: each acts after its own delay, the
//! actuator follows with its lag, and between two events force and velocity are
//!
//! ```text
//! g(t) = u + p·e^(−t/τ),  v(t) = c + e·g(t)        ∫g·v dt and ∫v² dt in closed form, event by event
//! E = ∫ (ρb·v² − g·v) dt                          of device and loop together; passive if E never falls below 0
//! ```
//! *The worst motion inside a sample* for a displacement Δ is v = Δ/T + (g − ḡ)/(2ρb), for any displacement v = g/(2ρb).
//!
//! The environment variable `CAMPAIGN_CASES` sets how many random devices are tried; 400 if it is not set.

use fracdiff::{Real, Seconds};
use haptic_loop::units::{
    Kilograms, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{EnergyBounding, Guard, Limits, SafetyChain, SafetyState, SpeedLimit};
use nalgebra::SVector;
use testkit::Random;

/// Rounding, J.
const ROUNDING: f64 = -1e-9;

/// A stretch of time between two events: its length, and g = u + p·e^(−t/τ) on each axis.
#[derive(Clone, Debug)]
struct Stretch<const D: usize> {
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
    fn impulse(&self, lag: f64) -> SVector<f64, D> {
        self.command * self.length + self.rest * self.fading(lag, 1.0)
    }

    /// ∫ (damping·v² − g·v) dt for v = c + e·g.
    fn energy(&self, lag: f64, damping: f64, c: &SVector<f64, D>, e: f64) -> f64 {
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
struct Actuator<const D: usize> {
    lag: f64,
    /// When each acts, s; in this order.
    due: std::collections::VecDeque<(f64, SVector<f64, D>)>,
    command: SVector<f64, D>,
    force: SVector<f64, D>,
}

impl<const D: usize> Actuator<D> {
    fn new(lag: f64) -> Self {
        Self {
            lag,
            due: std::collections::VecDeque::new(),
            command: SVector::zeros(),
            force: SVector::zeros(),
        }
    }

    fn send(&mut self, at: f64, force: SVector<f64, D>) {
        let last = self.due.back().map_or(f64::NEG_INFINITY, |(due, _)| *due);
        self.due.push_back((at.max(last), force));
    }

    /// The stretches of motion and force from one time to another.
    fn run(&mut self, from: f64, to: f64) -> Vec<Stretch<D>> {
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

/// The force that the environment wants.
#[derive(Clone, Copy, Debug)]
enum Wanted {
    /// −K·x − B·v, times the passive limit.
    Wall { stiffness: f64, dissipation: f64 },
    /// Anything.
    Anything { most: f64 },
}

/// The motion of the device.
#[derive(Clone, Copy, Debug)]
enum Motion {
    /// The displacement and shape that cost the loop most, sample by sample.
    Greedy,
    /// The greatest gain of so many samples, every so often; else pushed in.
    StoreThenExtract { store: u32, extract: u32 },
    /// Random displacements, the worst shape inside each sample.
    Random,
    /// Random displacements in a random shape.
    Wild,
    /// A push that turns round when the wall is deepest, at constant velocity.
    Stroke { samples: u32 },
}

/// A device, its loop, and the adversary.
#[derive(Clone, Debug)]
struct Case {
    sample_time: f64,
    damping: f64,
    share: f64,
    forget: f64,
    /// s.
    delays: (f64, f64),
    /// Each command has a delay of its own.
    jitters: bool,
    lag: f64,
    wanted: Wanted,
    motion: Motion,
    /// N; and N/s, or none.
    limits: (f64, Option<f64>),
    /// With a ramp after the start, braking at any speed by so much (N·s/m), and a stop now and then.
    braking: Option<f64>,
    seed: u64,
}

impl Case {
    fn random(random: &mut Random) -> Self {
        let sample_time = random.log_between(1e-4, 5e-3);
        let damping = random.log_between(0.1, 20.0);
        let share = random.one_of(&[0.3, 0.8, 1.0]);
        let least = match random.bits() % 4 {
            0 => 0.0,
            1 => random.one_of(&[1.0, 2.0, 3.0]),
            _ => random.between(0.0, 3.0),
        };
        let wide = match random.bits() % 3 {
            0 => random.between(0.0, 4.0 - least),
            _ => 0.0,
        };
        let lag = if random.chance(0.5) {
            random.log_between(0.02, 20.0)
        } else {
            0.0
        };
        let passive = 2.0 * share * damping / sample_time;
        let wanted = if random.chance(0.7) {
            Wanted::Wall {
                stiffness: passive * random.between(0.5, 5.0),
                dissipation: damping * random.one_of(&[0.0, 0.5, 5.0]),
            }
        } else {
            Wanted::Anything {
                most: random.log_between(1.0, 100.0),
            }
        };
        let force = random.log_between(3.0, 100.0);
        let rate = random
            .chance(0.3)
            .then(|| force / (random.between(1.0, 30.0) * sample_time));
        Self {
            sample_time,
            damping,
            share,
            forget: random.one_of(&[0.0, sample_time, 0.5, 1000.0]),
            delays: (least * sample_time, (least + wide) * sample_time),
            jitters: wide > 0.0 && random.chance(0.5),
            lag: lag * sample_time,
            wanted,
            motion: Motion::Greedy,
            limits: (force, rate),
            braking: random
                .chance(0.3)
                .then(|| damping * random.log_between(0.5, 20.0)),
            seed: random.bits(),
        }
    }

    fn guard(&self) -> EnergyBounding {
        EnergyBounding {
            share: self.share,
            forget: Seconds(self.forget),
            delay_least: Seconds(self.delays.0),
            delay_most: Seconds(self.delays.1),
            lag: Seconds(self.lag),
            ..EnergyBounding::of(NewtonSecondsPerMetre(self.damping))
        }
    }

    /// Ways to move it, some of them drawn at random.
    fn motions(random: &mut Random) -> [Motion; 7] {
        let mut store = || Motion::StoreThenExtract {
            store: 1 + (random.bits() % 30) as u32,
            extract: 1 + (random.bits() % 10) as u32,
        };
        [
            store(),
            store(),
            store(),
            Motion::Greedy,
            Motion::Random,
            Motion::Wild,
            Motion::Stroke {
                samples: 1 + (random.bits() % 20) as u32,
            },
        ]
    }

    /// The energy that the best of these motions draws.
    fn worst<F: Real, const D: usize>(
        &self,
        motions: &[Motion],
        guard: Option<EnergyBounding>,
    ) -> (f64, f64) {
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        for &motion in motions {
            let case = Self {
                motion,
                ..self.clone()
            };
            let (energy, force) = case.least::<F, D>(guard, 400);
            assert!(energy.is_finite());
            (least, most) = (least.min(energy), most.max(force));
        }
        (least, most)
    }

    /// The limits of the chain.
    fn chain_limits(&self, guard: Option<EnergyBounding>) -> Limits {
        let t = self.sample_time;
        let (force, rate) = self.limits;
        let rate = rate.unwrap_or(2.0 * force / t);
        Limits {
            guard: guard.map(Guard::EnergyBounding),
            norm: self.braking.map(|_| Newtons(force)),
            rise_time: self.braking.map(|_| Seconds(20.0 * t)),
            speed: self.braking.map(|_| SpeedLimit {
                soft: MetresPerSecond(0.0),
                hard: MetresPerSecond(1e4),
            }),
            braking: self.braking.map(NewtonSecondsPerMetre),
            // Heavy enough to bear it, with the sample of delay that is assumed.
            device_mass: self.braking.map(|b| Kilograms(3.01 * b * t)),
            ..Limits::bare(Newtons(force), NewtonsPerSecond(rate))
        }
    }

    /// The least energy of device and loop over a run, J, and the largest force that was let through, N.
    fn least<F: Real, const D: usize>(
        &self,
        guard: Option<EnergyBounding>,
        samples: u32,
    ) -> (f64, f64) {
        let t = self.sample_time;
        let limits = self.chain_limits(guard);
        let chain = SafetyChain::<F>::from_limits(&limits, Seconds(t)).expect("valid");
        let mut state = SafetyState::<F, D>::default();
        let mut random = Random(self.seed);
        let mut actuator = Actuator::<D>::new(self.lag);
        let constant = random.between(self.delays.0, self.delays.1);
        let damping = self.share * self.damping;
        let mut x = SVector::<f64, D>::zeros();
        let mut moved = SVector::<f64, D>::zeros();
        let (mut energy, mut least, mut most) = (0.0, 0.0_f64, 0.0_f64);
        for sample in 0..samples {
            let wanted = self.wanted_force(&x, &moved, &mut random);
            if self.braking.is_some() {
                if random.chance(0.01) {
                    state.stop();
                } else if random.chance(0.1) {
                    state.clear();
                }
            }
            let (sent, _) = chain.apply(&mut state, &x.map(F::from_f64), &wanted.map(F::from_f64));
            let sent = sent.newtons().map(F::to_f64);
            most = most.max(sent.norm());
            let delay = if self.jitters {
                random.between(self.delays.0, self.delays.1)
            } else {
                constant
            };
            let now = f64::from(sample) * t;
            actuator.send(now + delay, sent);
            let stretches = actuator.run(now, now + t);
            let impulse: SVector<f64, D> = stretches.iter().map(|s| s.impulse(self.lag)).sum();
            let (displacement, shape) = self.moves(sample, &impulse, &mut random);
            // v = c + e·g with ∫v = Δ.
            let c = (displacement - impulse * shape) / t;
            let change = stretches
                .iter()
                .map(|s| s.energy(self.lag, damping, &c, shape));
            energy += change.sum::<f64>();
            least = least.min(energy);
            moved = displacement;
            x += displacement;
        }
        (least, most)
    }

    fn wanted_force<const D: usize>(
        &self,
        x: &SVector<f64, D>,
        moved: &SVector<f64, D>,
        random: &mut Random,
    ) -> SVector<f64, D> {
        match self.wanted {
            Wanted::Wall {
                stiffness,
                dissipation,
            } => -(x * stiffness + moved * (dissipation / self.sample_time)),
            Wanted::Anything { most } => SVector::from_fn(|_, _| random.between(-most, most)),
        }
    }

    /// Displacement of a sample, and e of v = c + e·g.
    fn moves<const D: usize>(
        &self,
        sample: u32,
        impulse: &SVector<f64, D>,
        random: &mut Random,
    ) -> (SVector<f64, D>, f64) {
        let e = 0.5 / (self.share * self.damping);
        let greedy = (impulse * e, e);
        // A displacement that makes a wall of the passive limit push with a few newtons.
        let step = self.limits.0 * self.sample_time / (2.0 * self.damping);
        let some =
            |random: &mut Random, most: f64| SVector::from_fn(|_, _| random.between(-most, most));
        match self.motion {
            Motion::Greedy => {
                // Something has to be in the wall first.
                let in_first = sample % 50 < 5;
                if in_first {
                    (some(random, step), e)
                } else {
                    greedy
                }
            }
            Motion::StoreThenExtract { store, extract } => {
                if sample % (store + extract) < store {
                    let towards = if (sample / (store + extract)).is_multiple_of(2) {
                        1.0
                    } else {
                        -1.0
                    };
                    (SVector::repeat(towards * step / f64::from(store)), e)
                } else {
                    greedy
                }
            }
            Motion::Random => (some(random, step), e),
            Motion::Wild => {
                let shape = e * random.between(-1.0, 3.0);
                let most = step * random.between(0.0, 2.0);
                (some(random, most), shape)
            }
            Motion::Stroke { samples } => {
                let back = (sample / samples) % 2 == 1;
                (SVector::repeat(if back { -step } else { step } * 0.3), 0.0)
            }
        }
    }
}

fn cases() -> usize {
    std::env::var("CAMPAIGN_CASES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(400)
}

#[test]
fn no_motion_draws_energy_from_a_bounded_loop() {
    let mut random = Random(13);
    let (mut worst, mut rounded) = (0.0_f64, 0.0_f64);
    let (mut unguarded, mut felt) = (0, 0);
    let count = cases();
    for index in 0..count {
        let case = Case::random(&mut random);
        let motions = Case::motions(&mut random);
        let guard = Some(case.guard());
        let (least, most) = if index % 3 == 0 {
            case.worst::<f64, 2>(&motions, guard)
        } else {
            case.worst::<f64, 1>(&motions, guard)
        };
        assert!(least >= ROUNDING, "{index}: {least} J, {case:?}");
        worst = worst.min(least);
        felt += usize::from(most > 0.1);
        let (free, strongest) = case.worst::<f64, 1>(&motions, None);
        unguarded += usize::from(free < -1e-6);
        // In single precision positions are rounded to 1e-7 of themselves, and energy with them: as a share of
        // (T/4ρb)·f², what the largest force costs in a sample.
        let (single, _) = case.worst::<f32, 1>(&motions, guard);
        let cost = case.sample_time / (4.0 * case.share * case.damping);
        rounded = rounded.min(single / (cost * strongest * strongest));
    }
    println!(
        "{count} devices: least energy {worst:e} J, in single precision {rounded:e} of the cost of the largest force; {unguarded} gave energy \
         without a guard; {felt} felt more than 0.1 N"
    );
    assert!(rounded > -1e-4, "{rounded}");
    // The adversaries are strong, and the guard does not just let nothing through.
    assert!(unguarded * 10 > count * 8, "{unguarded} of {count}");
    assert!(felt * 10 > count * 8, "{felt} of {count}");
}

/// A wall that is stiff beyond any limit, felt by an adversary.
fn stiff(delays: (f64, f64), lag: f64, motion: Motion) -> Case {
    Case {
        sample_time: 1e-3,
        damping: 1.0,
        share: 1.0,
        forget: 1000.0,
        delays,
        jitters: false,
        lag,
        wanted: Wanted::Wall {
            stiffness: 20_000.0,
            dissipation: 0.0,
        },
        motion,
        limits: (35.0, None),
        braking: None,
        seed: 1,
    }
}

#[test]
fn a_delay_rounded_up_or_down_is_not_safe() {
    let motion = Motion::StoreThenExtract {
        store: 12,
        extract: 4,
    };
    let case = stiff((0.5e-3, 0.5e-3), 0.0, motion);
    let told = |delay: f64| {
        let delay = Seconds(delay);
        let guard = EnergyBounding {
            delay_least: delay,
            delay_most: delay,
            ..case.guard()
        };
        case.least::<f64, 1>(Some(guard), 5000).0
    };
    assert!(told(0.5e-3) >= ROUNDING);
    for rounded in [0.0, 1e-3] {
        let least = told(rounded);
        println!("0.5 ms said to be {rounded} s: {least} J");
        assert!(least < -1e-3, "{rounded} {least}");
    }
    // Nor one whose lag is not said.
    let case = stiff((0.0, 0.0), 1e-3, motion);
    let guard = EnergyBounding {
        lag: Seconds(0.0),
        ..case.guard()
    };
    assert!(case.least::<f64, 1>(Some(guard), 5000).0 < -1e-3);
}
