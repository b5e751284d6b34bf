//! Devices, their loops, and motions that are to draw energy from them.

use super::oracle::{Actuator, Sum};
use fracdiff::{Real, Seconds};
use haptic_loop::units::{
    Kilograms, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    EnergyBounding, PassivityGuard, SafetyChain, SafetyLimits, SafetyState, SpeedLimit,
};
use nalgebra::SVector;
use testkit::Random;

/// The force that the environment wants.
#[derive(Clone, Copy, Debug)]
pub(super) enum Wanted {
    /// −K·x − B·v, times the passive limit.
    Wall { stiffness: f64, dissipation: f64 },
    /// Anything.
    Anything { most: f64 },
}

/// The motion of the device.
#[derive(Clone, Copy, Debug)]
pub(super) enum Motion {
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
    /// Stored, then drawn in so small parts that a plain sum would lose each of them, then all of it at once. A part is this share
    /// of 2^−24 of what the guard believes to have.
    Erode { store: u32, erode: u32, share: f64 },
}

/// A device, its loop, and the adversary.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) sample_time: f64,
    pub(super) damping: f64,
    pub(super) share: f64,
    pub(super) forget: f64,
    /// s.
    pub(super) delays: (f64, f64),
    /// Each command has a delay of its own.
    pub(super) jitters: bool,
    pub(super) lag: f64,
    pub(super) wanted: Wanted,
    pub(super) motion: Motion,
    /// N; and N/s, or none.
    pub(super) limits: (f64, Option<f64>),
    /// Braking at any speed, N·s/m, with a ramp after the start and a stop now and then.
    pub(super) braking: Option<f64>,
    pub(super) seed: u64,
}

impl Case {
    pub(super) fn random(random: &mut Random) -> Self {
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

    pub(super) fn guard(&self) -> EnergyBounding {
        EnergyBounding {
            share: self.share,
            forget: Seconds(self.forget),
            delay_least: Seconds(self.delays.0),
            delay_most: Seconds(self.delays.1),
            current_lag: Seconds(self.lag),
            ..EnergyBounding::of(NewtonSecondsPerMetre(self.damping))
        }
    }

    /// One way to move it for long, and so many samples.
    pub(super) fn long(random: &mut Random) -> (Motion, u32) {
        let samples = random.log_between(400.0, 4e5) as u32;
        let [motions @ .., _] = Self::motions(random);
        let erode = Motion::Erode {
            store: 1 + (random.bits() % 30) as u32,
            erode: random.log_between(10.0, f64::from(samples)) as u32,
            share: random.log_between(0.1, 10.0),
        };
        let motion = if random.chance(0.5) {
            erode
        } else {
            random.one_of(&motions)
        };
        (motion, samples)
    }

    /// Ways to move it, some of them drawn at random.
    pub(super) fn motions(random: &mut Random) -> [Motion; 7] {
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
    pub(super) fn worst<F: Real, const D: usize>(
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
    fn chain_limits(&self, guard: Option<EnergyBounding>) -> SafetyLimits {
        let t = self.sample_time;
        let (force, rate) = self.limits;
        let rate = rate.unwrap_or(2.0 * force / t);
        SafetyLimits {
            guard: guard.map(PassivityGuard::EnergyBounding),
            norm: self.braking.map(|_| Newtons(force)),
            rise_time: self.braking.map(|_| Seconds(20.0 * t)),
            speed: self.braking.map(|_| SpeedLimit {
                soft: MetresPerSecond(0.0),
                hard: MetresPerSecond(1e4),
            }),
            braking: self.braking.map(NewtonSecondsPerMetre),
            // Heavy enough to bear it, with the sample of delay that is assumed.
            device_mass: self.braking.map(|b| Kilograms(3.01 * b * t)),
            ..SafetyLimits::bare(Newtons(force), NewtonsPerSecond(rate))
        }
    }

    /// The least energy of device and loop over a run, J, and the largest force that was let through, N.
    pub(super) fn least<F: Real, const D: usize>(
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
        let (mut energy, mut least, mut most) = (Sum::default(), 0.0_f64, 0.0_f64);
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
            let believed = state.observed_energy_j().to_f64();
            let (wish, shape) = self.moves(sample, &impulse, believed, &mut random);
            // The device is where it says it is: at a number of the loop's type.
            let position = (x + wish).map(|axis| F::from_f64(axis).to_f64());
            let displacement = position - x;
            x = position;
            // v = c + e·g with ∫v = Δ.
            let c = (displacement - impulse * shape) / t;
            let change = stretches
                .iter()
                .map(|s| s.energy(self.lag, damping, &c, shape));
            energy.add(change.sum());
            least = least.min(energy.value());
            moved = displacement;
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
        believed: f64,
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
            Motion::Erode {
                store,
                erode,
                share,
            } => {
                let phase = sample % (store + erode + 10);
                let force = impulse.norm() / self.sample_time;
                if phase < store {
                    (SVector::repeat(step / f64::from(store)), e)
                } else if phase < store + erode && force > 0.0 {
                    let part = share * believed.max(0.0) * 2_f64.powi(-24);
                    (impulse * (part / force / impulse.norm()), 0.0)
                } else {
                    greedy
                }
            }
        }
    }
}
