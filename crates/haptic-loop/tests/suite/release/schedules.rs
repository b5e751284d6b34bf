//! Random schedules of faults, stops, missing ticks and wild numbers: no force leaves its limits, its norm, its rate or its envelope.

use fracdiff::{Real, Seconds};
use haptic_loop::units::{
    Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    EnergyBounding, Fault, PassivityGuard, PassivityObserver, SafetyChain, SafetyLimits,
    SafetyState, SpeedLimit, Stuck, Workspace,
};
use nalgebra::SVector;
use testkit::Random;

fn maybe<V>(random: &mut Random, value: impl FnOnce(&mut Random) -> V) -> Option<V> {
    random.chance(0.5).then(|| value(random))
}

/// Limits of every size that is accepted.
fn any_limits(random: &mut Random, sample_time: Seconds) -> SafetyLimits {
    let mut limits = SafetyLimits {
        norm: maybe(random, |random| Newtons(random.log_between(0.1, 100.0))),
        rise_time: maybe(random, |random| Seconds(random.log_between(1e-3, 3.0))),
        workspace: maybe(random, |random| Workspace {
            low: Metres(-random.log_between(0.01, 1.0)),
            high: Metres(random.log_between(0.01, 1.0)),
            soft: Metres(0.005),
        }),
        speed: maybe(random, |random| {
            let hard = random.log_between(0.1, 100.0);
            SpeedLimit {
                soft: MetresPerSecond(0.6 * hard),
                hard: MetresPerSecond(hard),
            }
        }),
        stop_time: Seconds(random.log_between(1e-3, 1.0)),
        brake_force: Newtons(10.0 * random.share()),
        device_mass: maybe(random, |random| Kilograms(random.log_between(0.01, 10.0))),
        device_delay_samples: (5.0 * random.share()) as u32,
        stuck: maybe(random, |random| Stuck {
            force: Newtons(random.log_between(0.1, 10.0)),
            time: Seconds(random.log_between(1e-3, 0.1)),
        }),
        jump: maybe(random, |random| Metres(random.log_between(1e-4, 0.1))),
        ..SafetyLimits::bare(
            Newtons(random.log_between(0.1, 100.0)),
            NewtonsPerSecond(random.log_between(0.1, 1e6)),
        )
    };
    let most = limits.braking_max(sample_time).0;
    limits.braking = maybe(random, |random| {
        NewtonSecondsPerMetre(most * random.between(0.01, 1.0))
    });
    limits.guard = maybe(random, |random| {
        let damping = NewtonSecondsPerMetre(random.log_between(0.1, 10.0));
        if random.chance(0.5) {
            PassivityGuard::EnergyBounding(EnergyBounding::of(damping))
        } else {
            PassivityGuard::Observer(PassivityObserver {
                damping_max: damping,
                forget: Seconds(0.5),
            })
        }
    });
    limits
}

fn any_vector<const D: usize>(random: &mut Random, size: f64) -> [f64; D] {
    core::array::from_fn(|_| random.between(-size, size))
}

/// The test's own account of the way to zero.
struct Envelope {
    from_n: f64,
    ticks: f64,
    whole_ticks: f64,
}

impl Envelope {
    /// A tick later: the force is within it, and no larger than before where nothing brakes.
    fn check<const D: usize>(
        &mut self,
        now: &[f64; D],
        before: &[f64; D],
        limits: &SafetyLimits,
        tolerance: f64,
    ) {
        self.ticks = (self.ticks - 1.0).max(0.0);
        let most = self.from_n * (self.ticks / self.whole_ticks);
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

const WILD: [f64; 6] = [f64::NAN, f64::INFINITY, 1e38, -1e300, 5e-324, 0.0];

/// The force is within limits and norm, and one step from the last in both; energy bounding and the way to zero may take it away
/// faster, not turn it round.
fn keeps_its_limits<F: Real, const D: usize>(
    (now, before): (&[f64; D], &[f64; D]),
    limits: &SafetyLimits,
    (step_n, released): (f64, bool),
    tolerance: f64,
) {
    let context = || format!("{before:?} {now:?} {limits:?}");
    let most = F::from_f64(limits.force.0).to_f64();
    assert!(now.iter().all(|f| f.abs() <= most), "{}", context());
    assert!(
        limits.norm.is_none_or(|most| norm(now) <= most.0),
        "{}",
        context()
    );
    let bounding = matches!(limits.guard, Some(PassivityGuard::EnergyBounding(_)));
    let change: [f64; D] = core::array::from_fn(|axis| {
        let (now, before) = (now[axis], before[axis]);
        let taken = bounding && now.abs() <= before.abs() && now * before >= 0.0;
        if taken { 0.0 } else { now - before }
    });
    let slewed = norm(&change) <= step_n + tolerance * (step_n + norm(now).max(norm(before)));
    let falls = released && norm(now) <= norm(before);
    assert!(slewed || falls, "{}", context());
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
            v: any_vector(random, 0.5),
            read: [0.0; D],
            wanted: [0.0; D],
            envelope: None,
            stopped: false,
            sticks: false,
            offset: 0.0,
        }
    }

    /// Whatever happens before a tick. Returns the ticks that are missing before it.
    fn happens(&mut self, random: &mut Random, limits: &SafetyLimits) -> u64 {
        match (60.0 * random.share()) as u32 {
            0 => (self.state.stop(), self.stopped = true).0,
            1 => (self.state).trip(Fault::ALL[(10.0 * random.share()) as usize]),
            2 => self.sticks = !self.sticks,
            3 => self.offset = random.between(-0.05, 0.05),
            4 => return (20.0 * random.share()) as u64,
            5 => self.wanted[random.bits() as usize % D] = random.one_of(&WILD),
            6..16 => self.wanted = any_vector(random, 2.0 * limits.force.0),
            16..20 if self.state.is_at_rest() => {
                self.state.clear();
                (self.stopped, self.envelope) = (false, None);
                (self.x, self.v) = ([0.0; D], any_vector(random, 0.5));
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
        if random.chance(1.0 / 2000.0) {
            position[0] = random.one_of(&WILD);
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
    let mut random = Random(seed);
    let t = random.one_of(&[1e-4, 5e-4, 1e-3, 2e-3, 1e-2]);
    let limits = any_limits(&mut random, Seconds(t));
    let chain = SafetyChain::<F>::from_limits(&limits, Seconds(t)).expect("acceptable");
    let mass = limits.device_mass.map_or(0.065, |mass| mass.0);
    let ticks = (limits.stop_time.0 / t * (1.0 - 1e-6)).ceil().max(1.0);
    let single = size_of::<F>() == 4;
    let tolerance = 1e-9 + if single { 1e-5 } else { 0.0 };
    let rounding = 40.0
        * if single {
            f64::from(f32::EPSILON)
        } else {
            f64::EPSILON
        };
    let mut world = World::<F, D>::new(&mut random);
    let (mut sent, mut faults) = ([0.0; D], 0);
    for _ in 0..200 + (400.0 * random.share()) as u32 {
        let missed = world.happens(&mut random, &limits);
        let position = world.position(&mut random);
        world.skip(missed);
        let wanted = SVector::from(world.wanted.map(F::from_f64));
        let (force, _) = chain.apply(&mut world.state, &position, &wanted);
        let now: [f64; D] = force.newtons().map(F::to_f64).into();
        let released = world.stopped || world.state.fault().is_some();
        let step = (limits.rate.0 * t, released);
        keeps_its_limits::<F, D>((&now, &sent), &limits, step, rounding);
        if released {
            faults += u64::from(world.envelope.is_none());
            let known = world.envelope.get_or_insert_with(|| Envelope {
                from_n: norm(&sent).max(limits.brake_force.0),
                ticks,
                whole_ticks: ticks,
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
    assert!(faults > cases);
}
