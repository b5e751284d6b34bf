//! Random schedules of faults, stops and missing ticks: no force comes out of its envelope.

use fracdiff::{Real, Seconds};
use haptic_loop::units::{
    Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    EnergyBounding, Fault, Guard, Limits, PassivityObserver, SafetyChain, SafetyState, SpeedLimit,
    Stuck, Workspace,
};
use nalgebra::SVector;
use rand_distr::{Distribution as _, StandardUniform};
use rand_pcg::Pcg32;

struct Random(Pcg32);

impl Random {
    fn share(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Between powers of ten.
    fn decade(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(self.within(low, high))
    }

    fn one_in(&mut self, n: u32) -> bool {
        self.share() * f64::from(n) < 1.0
    }

    fn maybe<V>(&mut self, value: impl FnOnce(&mut Self) -> V) -> Option<V> {
        self.one_in(2).then(|| value(self))
    }

    /// Limits of every size that is accepted.
    fn limits(&mut self, sample_time: Seconds) -> Limits {
        let mut limits = Limits {
            norm: self.maybe(|random| Newtons(random.decade(-1.0, 2.0))),
            rise_time: self.maybe(|random| Seconds(random.decade(-3.0, 0.5))),
            workspace: self.maybe(|random| Workspace {
                low: Metres(-random.decade(-2.0, 0.0)),
                high: Metres(random.decade(-2.0, 0.0)),
                soft: Metres(0.005),
            }),
            speed: self.maybe(|random| {
                let hard = random.decade(-1.0, 2.0);
                SpeedLimit {
                    soft: MetresPerSecond(0.6 * hard),
                    hard: MetresPerSecond(hard),
                }
            }),
            stop_time: Seconds(self.decade(-3.0, 0.0)),
            brake_force: Newtons(10.0 * self.share()),
            device_mass: self.maybe(|random| Kilograms(random.decade(-2.0, 1.0))),
            device_delay_samples: (5.0 * self.share()) as u32,
            stuck: self.maybe(|random| Stuck {
                force: Newtons(random.decade(-1.0, 1.0)),
                time: Seconds(random.decade(-3.0, -1.0)),
            }),
            jump: self.maybe(|random| Metres(random.decade(-4.0, -1.0))),
            ..Limits::bare(
                Newtons(self.decade(-1.0, 2.0)),
                NewtonsPerSecond(self.decade(-1.0, 6.0)),
            )
        };
        let most = limits.braking_max(sample_time).0;
        limits.braking =
            self.maybe(|random| NewtonSecondsPerMetre(most * random.within(0.01, 1.0)));
        limits.guard = self.maybe(|random| {
            let damping = NewtonSecondsPerMetre(random.decade(-1.0, 1.0));
            if random.one_in(2) {
                Guard::EnergyBounding(EnergyBounding::of(damping))
            } else {
                Guard::Observer(PassivityObserver {
                    damping_max: damping,
                    forget: Seconds(0.5),
                })
            }
        });
        limits
    }

    fn vector<const D: usize>(&mut self, size: f64) -> [f64; D] {
        core::array::from_fn(|_| self.within(-size, size))
    }
}

/// The test's own account of the way to zero.
struct Envelope {
    from_n: f64,
    ticks: f64,
    of: f64,
}

impl Envelope {
    /// A tick later: the force is within it, and no larger than before where nothing brakes.
    fn check<const D: usize>(
        &mut self,
        now: &[f64; D],
        before: &[f64; D],
        limits: &Limits,
        tolerance: f64,
    ) {
        self.ticks = (self.ticks - 1.0).max(0.0);
        let most = self.from_n * (self.ticks / self.of);
        let size = norm(now);
        assert!(
            size <= most * (1.0 + tolerance),
            "{size} N of {most} N, {limits:?}"
        );
        if limits.braking.is_none() {
            assert!(
                size <= norm(before) * (1.0 + tolerance),
                "it grew: {limits:?}"
            );
        }
    }
}

fn norm<const D: usize>(force: &[f64; D]) -> f64 {
    force.iter().map(|axis| axis * axis).sum::<f64>().sqrt()
}

/// A device whose position sticks, jumps and gets lost, and a world that wants any force, stops, faults and falls silent.
struct World<F, const D: usize> {
    state: SafetyState<F, D>,
    x: [f64; D],
    v: [f64; D],
    /// The position as it was told last.
    read: [f64; D],
    wanted: [f64; D],
    envelope: Option<Envelope>,
    stopped: bool,
    sticks: bool,
    offset: f64,
}

impl<F: Real, const D: usize> World<F, D> {
    fn new(random: &mut Random) -> Self {
        Self {
            state: SafetyState::default(),
            x: [0.0; D],
            v: random.vector(0.5),
            read: [0.0; D],
            wanted: [0.0; D],
            envelope: None,
            stopped: false,
            sticks: false,
            offset: 0.0,
        }
    }

    /// Whatever happens before a tick. Returns the ticks that are missing before it.
    fn happens(&mut self, random: &mut Random, limits: &Limits) -> u64 {
        match (60.0 * random.share()) as u32 {
            0 => (self.state.stop(), self.stopped = true).0,
            1 => (self.state).trip(Fault::ALL[(10.0 * random.share()) as usize]),
            2 => self.sticks = !self.sticks,
            3 => self.offset = random.within(-0.05, 0.05),
            4 => return (20.0 * random.share()) as u64,
            5 => self.wanted[0] = [f64::NAN, f64::INFINITY, 1e38][(3.0 * random.share()) as usize],
            6..16 => self.wanted = random.vector(2.0 * limits.force.0),
            16..20 if self.state.is_at_rest() => {
                self.state.clear();
                (self.stopped, self.envelope) = (false, None);
                (self.x, self.v) = ([0.0; D], random.vector(0.5));
            }
            _ => {}
        }
        0
    }

    /// The position that is told.
    fn position(&mut self, random: &mut Random) -> SVector<F, D> {
        if !self.sticks {
            self.read = self.x.map(|x| x + self.offset);
        }
        let mut position = self.read;
        if random.one_in(2000) {
            position[0] = f64::NAN;
        }
        SVector::from(position.map(F::from_f64))
    }

    /// Periods without a tick.
    fn skip(&mut self, missed: u64) {
        if missed > 0 {
            self.state.skip(missed);
            if let Some(envelope) = &mut self.envelope {
                envelope.ticks -= missed as f64;
            }
        }
    }
}

/// A device of some mass under the force of the chain in such a world. Returns the faults.
fn schedule<F: Real, const D: usize>(seed: u64) -> u64 {
    let mut random = Random(Pcg32::new(seed, 0x2545_f491_4f6c_dd1d));
    let t = [1e-4, 5e-4, 1e-3, 2e-3, 1e-2][(5.0 * random.share()) as usize];
    let limits = random.limits(Seconds(t));
    let chain = SafetyChain::<F>::from_limits(&limits, Seconds(t)).expect("acceptable");
    let mass = limits.device_mass.map_or(0.065, |mass| mass.0);
    let ticks = (limits.stop_time.0 / t * (1.0 - 1e-6)).ceil().max(1.0);
    let tolerance = 1e-9 + if size_of::<F>() == 4 { 1e-5 } else { 0.0 };
    let mut world = World::<F, D>::new(&mut random);
    let (mut sent, mut faults) = ([0.0; D], 0);
    for _ in 0..200 + (400.0 * random.share()) as u32 {
        let missed = world.happens(&mut random, &limits);
        let position = world.position(&mut random);
        world.skip(missed);
        let wanted = SVector::from(world.wanted.map(F::from_f64));
        let (force, _) = chain.apply(&mut world.state, &position, &wanted);
        let now: [f64; D] = force.newtons().map(F::to_f64).into();
        assert!(
            now.iter()
                .all(|f| f.is_finite() && f.abs() <= limits.force.0 * (1.0 + tolerance))
        );
        if world.stopped || world.state.fault().is_some() {
            faults += u64::from(world.envelope.is_none());
            let known = world.envelope.get_or_insert_with(|| Envelope {
                from_n: norm(&sent).max(limits.brake_force.0),
                ticks,
                of: ticks,
            });
            known.check(&now, &sent, &limits, tolerance);
            assert!(known.ticks > 0.0 || world.state.is_at_rest());
        }
        for (axis, force) in now.iter().enumerate() {
            world.v[axis] += (force - 0.5 * world.v[axis]) / mass * t;
            world.x[axis] += world.v[axis] * t * (1 + missed) as f64;
        }
        sent = now;
    }
    faults
}

#[test]
fn no_schedule_brings_a_force_out_of_its_envelope() {
    let cases = testkit::cases(4000);
    let mut faults = 0;
    for seed in 0..cases {
        faults += match seed % 6 {
            0 => schedule::<f32, 1>(seed),
            1 => schedule::<f64, 1>(seed),
            2 => schedule::<f32, 2>(seed),
            3 => schedule::<f64, 2>(seed),
            4 => schedule::<f32, 3>(seed),
            _ => schedule::<f64, 3>(seed),
        };
    }
    println!("{cases} schedules, {faults} ways to zero");
    assert!(faults > cases);
}
