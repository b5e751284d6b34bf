//! The passivity guard: walls that shake without it, its books, and its price.
//!
//! The device of O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4: 65 g, 3.5 N·s/m, T = 2 ms, pushed with
//! 1 N into a wall at its start for 5 s; unstable if the position varies by more than 0.1 mm over the last 0.4 s.
//! Walls lie on rays of (α, β), at multiples of Corollary 1, δ = α/2 + β·2^(μ−1), and of what is stable in simulation.

use fracdiff::{Order, Real, Seconds, ShortMemory};
use haptic_loop::plant::{EncoderQuantiser, MassDamper, MassDamperConfig};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
use haptic_loop::{
    Controller, Device, EnergyBounding, Fault, Guard, Limiters, Limits, PassivityObserver, Reading,
    SafeForce, SafetyChain, SafetyState, SpringDamper,
};
use nalgebra::{SVector, vector};
use proptest::prelude::*;
use std::convert::Infallible;

const MASS: f64 = 0.065;
const DAMPING: f64 = 3.5;
const T: Seconds = Seconds(2e-3);
const DELTA: f64 = DAMPING * T.0 / MASS;
const SAMPLES: usize = 2501;
const ORDERS: [f64; 4] = [0.0, 0.5, 1.0, 1.5];
/// Directions of (α, β): spring alone, then ever less of it.
const RAYS: [(f64, f64); 5] = [(1.0, 0.0), (4.0, 1.0), (1.0, 1.0), (1.0, 3.0), (1.0, 5.0)];
/// The largest standard deviation of a stable wall, m.
const STABLE: f64 = 1e-4;

fn observer() -> Option<Guard> {
    Some(Guard::Observer(PassivityObserver::bearable(
        Kilograms(MASS),
        T,
    )))
}

/// For a known delay, in samples.
fn bounding(delay: f64) -> Option<Guard> {
    let delay = Seconds(delay * T.0);
    Some(Guard::EnergyBounding(EnergyBounding {
        delay_least: delay,
        delay_most: delay,
        ..EnergyBounding::of(NewtonSecondsPerMetre(DAMPING))
    }))
}

/// A wall and what makes the device less than ideal.
#[derive(Clone, Copy, Debug)]
struct Case {
    order: f64,
    alpha: f64,
    beta: f64,
    /// m per count.
    encoder: f64,
    /// Samples.
    delay: f64,
}

/// A device with an encoder, or without for a resolution of 0.
enum Sensed {
    Ideal(MassDamper<1>),
    Encoder(EncoderQuantiser<MassDamper<1>>),
}

impl Device<f64, 1> for Sensed {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        match self {
            Self::Ideal(device) => device.read(),
            Self::Encoder(device) => device.read(),
        }
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        match self {
            Self::Ideal(device) => device.write(force),
            Self::Encoder(device) => device.write(force),
        }
    }
}

/// The end of a run: standard deviation and mean of the true position over the last 0.4 s, m.
#[derive(Clone, Copy, Debug)]
struct End {
    deviation: f64,
    mean: f64,
}

impl Case {
    fn on_ray(order: f64, (alpha, beta): (f64, f64), multiple: f64) -> Self {
        Self {
            order,
            alpha: alpha * multiple,
            beta: beta * multiple,
            encoder: 0.0,
            delay: 0.0,
        }
    }

    /// 100 N, crossed within a sample, as the command line's wall.
    fn run(&self, guard: Option<Guard>) -> End {
        self.run_with(&Limits {
            guard,
            ..Limits::bare(Newtons(100.0), NewtonsPerSecond(200.0 / T.0))
        })
    }

    fn run_with(&self, limits: &Limits) -> End {
        let stiffness = self.alpha * MASS / (T.0 * T.0);
        let dissipation = self.beta * MASS / T.0.powf(2.0 - self.order);
        let order = Order::new(self.order).expect("valid");
        let operator = ShortMemory::<f64, SAMPLES>::new(order, T).expect("valid");
        let wall = SpringDamper::new(stiffness, dissipation, operator).expect("valid");
        let chain = SafetyChain::from_limits(limits, T).expect("valid");
        let mut controller = Controller::new(wall, chain);
        let ideal = MassDamperConfig::ideal(Kilograms(MASS), NewtonSecondsPerMetre(DAMPING), T);
        let delay = Seconds(self.delay * T.0);
        let mut mass = MassDamper::new(MassDamperConfig { delay, ..ideal }).expect("valid");
        mass.set_external_force(vector![1.0]);
        let mut device = if self.encoder > 0.0 {
            Sensed::Encoder(EncoderQuantiser::new(mass, Metres(self.encoder)).expect("valid"))
        } else {
            Sensed::Ideal(mass)
        };
        let mut positions = Vec::with_capacity(SAMPLES);
        for _ in 0..SAMPLES {
            let _ = controller.tick(&mut device).expect("infallible");
            positions.push(match &device {
                Sensed::Ideal(mass) => mass.position()[0],
                Sensed::Encoder(encoder) => encoder.device().position()[0],
            });
        }
        let last = &positions[SAMPLES - 200..];
        let mean = last.iter().sum::<f64>() / 200.0;
        let squares: f64 = last.iter().map(|x| (x - mean) * (x - mean)).sum();
        End {
            deviation: (squares / 200.0).sqrt(),
            mean,
        }
    }

    fn is_stable(&self, guard: Option<Guard>) -> bool {
        self.run(guard).deviation < STABLE
    }
}

/// Multiple of a ray at which δ = α/2 + β·2^(μ−1).
fn passivity_limit(order: f64, (alpha, beta): (f64, f64)) -> f64 {
    DELTA / (alpha / 2.0 + beta * 2f64.powf(order - 1.0))
}

/// Largest multiple of a ray that settles in simulation.
fn stability_limit(order: f64, ray: (f64, f64)) -> f64 {
    let (mut low, mut high) = (passivity_limit(order, ray), 8.0);
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        let stable = Case::on_ray(order, ray, middle).is_stable(None);
        *(if stable { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn both_guards_hold_walls_of_twice_and_three_times_the_passivity_limit() {
    let mut shaking = Vec::new();
    for order in ORDERS {
        for ray in RAYS {
            for multiple in [2.0, 3.0] {
                let case = Case::on_ray(order, ray, multiple * passivity_limit(order, ray));
                if !case.is_stable(None) {
                    shaking.push((order, ray, multiple));
                }
                assert!(case.is_stable(observer()), "observer {case:?}");
                assert!(case.is_stable(bounding(0.0)), "bounding {case:?}");
            }
        }
    }
    // A damper does not shake so soon: what is beyond passivity is mostly stable for μ ≥ 0.5.
    let alone = |order: f64| {
        shaking
            .iter()
            .filter(|(mu, ..)| (mu - order).abs() < 0.1)
            .count()
    };
    assert_eq!(ORDERS.map(alone), [10, 4, 3, 3], "{shaking:?}");
}

#[test]
fn energy_bounding_holds_what_is_twice_and_three_times_beyond_stability() {
    for order in ORDERS {
        for ray in RAYS {
            let limit = stability_limit(order, ray);
            for multiple in [2.0, 3.0] {
                let case = Case::on_ray(order, ray, multiple * limit);
                assert!(!case.is_stable(None), "{case:?}");
                assert!(case.is_stable(bounding(0.0)), "{case:?}");
            }
        }
    }
}

#[test]
fn damping_cannot_hold_what_is_twice_beyond_stability_for_a_derivative() {
    // Where the observer ends, as its documentation says.
    for order in [0.5, 1.0, 1.5] {
        for ray in &RAYS[2..] {
            let limit = stability_limit(order, *ray);
            let case = Case::on_ray(order, *ray, 2.0 * limit);
            assert!(!case.is_stable(observer()), "{case:?}");
        }
    }
    // Nor a wall with a sample of delay, for which the energy bounding must know of the delay.
    for order in ORDERS {
        for ray in RAYS {
            let case = Case {
                delay: 1.0,
                ..Case::on_ray(order, ray, 3.0 * passivity_limit(order, ray))
            };
            let shakes = !case.is_stable(None);
            assert_eq!(case.is_stable(observer()), !shakes, "{case:?}");
            assert_eq!(case.is_stable(bounding(0.0)), !shakes, "{case:?}");
            assert!(case.is_stable(bounding(1.0)), "{case:?}");
        }
    }
}

#[test]
fn an_encoder_and_delays_do_not_shake_a_bounded_wall() {
    for order in ORDERS {
        for ray in RAYS {
            let limit = passivity_limit(order, ray);
            for encoder in [1e-6, 1e-5] {
                for multiple in [2.0, 3.0] {
                    let case = Case {
                        encoder,
                        ..Case::on_ray(order, ray, multiple * limit)
                    };
                    assert!(case.is_stable(observer()), "observer {case:?}");
                    for delay in [0.0, 1.0, 2.0] {
                        let late = Case { delay, ..case };
                        let end = late.run(bounding(delay));
                        // A count or two.
                        assert!(end.deviation < STABLE, "{late:?} {end:?}");
                    }
                }
            }
        }
    }
}

/// 1/x under the push of 1 N, N/m.
fn rendered(case: Case, guard: Option<Guard>) -> f64 {
    1.0 / case.run(guard).mean
}

#[test]
fn the_price_is_the_stiffness_above_what_the_damping_can_pay() {
    // c = 2ρb/T = 2800 N/m, and c/(d + 1) with delay.
    let most = 2.0 * 0.8 * DAMPING / T.0;
    for delay in [0.0, 0.5, 1.0, 2.0] {
        let most = most / (1.0 + delay);
        // With delay a spring is passive up to c/(2d + 1) only, and between the two a little is lost.
        let (below, off) = if delay == 0.0 {
            (0.9, 1e-3)
        } else {
            (0.5, 0.05)
        };
        for share in [0.1, below, 1.5, 4.0] {
            let case = Case {
                delay,
                ..Case::on_ray(0.0, (share * most * T.0 * T.0 / MASS, 0.0), 1.0)
            };
            let have = rendered(case, bounding(delay));
            let want = most * f64::min(share, 1.0);
            assert!((have / want - 1.0).abs() < off, "{case:?} {have} {want}");
        }
    }
    // The observer adds damping only: the stiffness at rest is the commanded one.
    let case = Case::on_ray(0.0, (1.0, 0.0), 3.0 * passivity_limit(0.0, (1.0, 0.0)));
    let have = rendered(case, observer());
    assert!((have / 10_500.0 - 1.0).abs() < 1e-3, "{have}");
}

#[test]
fn a_passive_wall_is_left_as_it_is() {
    for order in ORDERS {
        for ray in &RAYS[1..] {
            // Up to ρ of what is passive.
            let case = Case::on_ray(order, *ray, 0.8 * passivity_limit(order, *ray));
            let free = case.run(None).mean;
            for guard in [observer(), bounding(0.0)] {
                let kept = case.run(guard).mean;
                assert!((kept / free - 1.0).abs() < 1e-3, "{case:?} {kept} {free}");
            }
        }
    }
}

#[test]
fn guards_work_within_the_whole_chain() {
    // Start-up over 0.5 s, 10 N, 1000 N/s, braking: all defaults.
    for guard in [observer(), bounding(0.0)] {
        for ray in RAYS {
            let case = Case::on_ray(0.5, ray, 3.0 * passivity_limit(0.5, ray));
            let limits = Limits {
                guard,
                ..Limits::default()
            };
            let end = case.run_with(&limits);
            assert!(end.deviation < STABLE, "{case:?} {end:?}");
        }
    }
}

#[test]
fn single_precision_holds_a_force_for_minutes() {
    let limits = Limits {
        guard: bounding(0.0),
        ..Limits::bare(Newtons(10.0), NewtonsPerSecond(1e4))
    };
    let chain = SafetyChain::<f32>::from_limits(&limits, T).expect("valid");
    let mut state = SafetyState::<f32, 1>::default();
    let mut held = 0.0;
    // 1 mm deep into a wall of 10 kN/m, then nothing moves for 400 s.
    for tick in 0..200_000_u32 {
        let x = 1e-5 * tick.min(100) as f32;
        let (force, limiters) = chain.apply(&mut state, &vector![x], &vector![-1e4 * x]);
        if tick == 101 {
            held = force.newtons()[0];
            assert!(limiters.contains(Limiters::GUARD));
            assert!((-held / 2.8 - 1.0).abs() < 0.05, "{held}");
        }
        if tick > 101 {
            assert!((force.newtons()[0] / held - 1.0).abs() < 1e-6, "{tick}");
        }
    }
}

#[test]
fn the_observer_predicts_that_a_motion_goes_on_and_damps_no_more_than_needed() {
    let limits = Limits {
        guard: observer(),
        ..Limits::bare(Newtons(10.0), NewtonsPerSecond(1e6))
    };
    let chain = SafetyChain::<f64>::from_limits(&limits, T).expect("valid");
    let mut state = SafetyState::<f64, 1>::default();
    // 1 mm against 1 N and back, from where it would go on and draw 1 mJ more: no damping, none, all.
    for (x, energy, force) in [(0.0, 0.0, -1.0), (1e-3, 1e-3, -1.0), (0.0, 0.0, 0.0)] {
        let (sent, limiters) = chain.apply(&mut state, &vector![x], &vector![-1.0]);
        // Of the energy 1/250 is forgotten in a sample.
        assert!((state.observed_energy_j() - energy).abs() < 5e-6, "{x}");
        assert!((sent.newtons()[0] - force).abs() < 5e-3, "{x}");
        assert_eq!(limiters.contains(Limiters::GUARD), force > -1.0);
    }
}

#[test]
fn the_books_go_on_while_a_force_falls_to_zero() {
    for (guard, damping) in [(observer(), 0.0), (bounding(0.0), 0.8 * DAMPING / T.0)] {
        let limits = Limits {
            guard,
            ..Limits::bare(Newtons(10.0), NewtonsPerSecond(0.1 / T.0))
        };
        let chain = SafetyChain::<f64>::from_limits(&limits, T).expect("valid");
        let mut state = SafetyState::<f64, 1>::default();
        let mut x = 0.0;
        for _ in 0..20 {
            x += 1e-3;
            chain.apply(&mut state, &vector![x], &vector![-1.0]);
        }
        let before = state.observed_energy_j();
        state.stop();
        chain.apply(&mut state, &vector![x], &vector![-1.0]);
        // Back by 1 mm under the 0.9 N that are left.
        chain.apply(&mut state, &vector![x - 1e-3], &vector![-1.0]);
        let lost = before - state.observed_energy_j();
        let want = 0.9e-3 - damping * 1e-6;
        // But for what is forgotten, 1/250 of at most 50 mJ a sample.
        assert!((lost - want).abs() < 4e-4, "{lost} {want}");
    }
}

/// A chain with nothing but this guard.
fn bare<F: Real>(bounding: EnergyBounding, sample_time: Seconds) -> SafetyChain<F> {
    let limits = Limits {
        guard: Some(Guard::EnergyBounding(bounding)),
        ..Limits::bare(Newtons(100.0), NewtonsPerSecond(200.0 / sample_time.0))
    };
    SafetyChain::from_limits(&limits, sample_time).expect("valid")
}

fn late(least: f64, most: f64, lag: f64) -> EnergyBounding {
    EnergyBounding {
        delay_least: Seconds(least),
        delay_most: Seconds(most),
        lag: Seconds(lag),
        ..EnergyBounding::of(NewtonSecondsPerMetre(DAMPING))
    }
}

#[test]
fn an_energy_that_is_no_number_gives_no_force() {
    // Jumps whose squares are beyond the number type, at once and after a good motion.
    for jump in [2e19_f32, 1e25, -1e25, 3e34] {
        for before in [0, 5] {
            let chain = bare::<f32>(late(0.0, 0.0, 0.0), T);
            let mut state = SafetyState::<f32, 1>::default();
            for step in 0..=before {
                chain.apply(&mut state, &vector![1e-3 * step as f32], &vector![0.0]);
            }
            for back in [jump, jump, 0.0, jump] {
                let (force, _) = chain.apply(&mut state, &vector![back], &vector![-10.0]);
                assert!(force.newtons()[0].abs() <= 0.0, "{jump} {back}");
                assert!(state.observed_energy_j() <= 0.0, "{jump} {back}");
            }
        }
    }
    // The same in double precision, and a position that is no number: nothing more is credited.
    let chain = bare::<f64>(late(0.0, 0.0, 0.0), T);
    for jump in [1e160, f64::NAN, f64::INFINITY] {
        let mut state = SafetyState::<f64, 1>::default();
        chain.apply(&mut state, &vector![0.0], &vector![0.0]);
        for x in [jump, 0.0, 0.0] {
            let (force, _) = chain.apply(&mut state, &vector![x], &vector![-10.0]);
            assert!(force.newtons()[0].abs() <= 0.0, "{jump}");
        }
        assert!(state.observed_energy_j() <= 0.0, "{jump}");
    }
    // The observer takes it for no credit too: all the damping there is.
    let limits = Limits {
        guard: observer(),
        ..Limits::bare(Newtons(100.0), NewtonsPerSecond(1e9))
    };
    let chain = SafetyChain::<f32>::from_limits(&limits, T).expect("valid");
    let mut state = SafetyState::<f32, 1>::default();
    for x in [0.0, -1e37, -2e37] {
        chain.apply(&mut state, &vector![x], &vector![100.0]);
    }
    assert!(state.observed_energy_j() <= 0.0);
    // Work of −∞ is not "nothing is owed": no force follows from it.
    let mut state = SafetyState::<f32, 1>::default();
    for (x, wanted) in [(0.0, 0.0), (-1e10, 1e30), (-2e10, 1e30)] {
        let (force, _) = chain.apply(&mut state, &vector![x], &vector![wanted]);
        assert!(force.newtons()[0].abs() <= 0.0, "{x}");
    }
    assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
}

#[test]
fn after_the_device_has_let_go_no_force_is_on_its_way_and_no_credit_is_left() {
    let chain = bare::<f64>(late(2.5 * T.0, 2.5 * T.0, 0.0), T);
    // The same motion, pushed or not: once it has let go, the books are the same, to the bit.
    let [pushed, alone] = [-2.0, 0.0].map(|wanted| {
        let mut state = SafetyState::<f64, 1>::default();
        let tick = |state: &mut _, wanted: f64, n: i32| {
            let position = vector![1e-3 * f64::from(n)];
            let (force, _) = chain.apply(state, &position, &vector![wanted]);
            force.newtons()[0]
        };
        let sent = (0..10).map(|n| tick(&mut state, wanted, n)).last();
        assert_eq!(
            sent.is_some_and(|sent| sent < -0.5),
            wanted < 0.0,
            "{sent:?}"
        );
        assert!(state.observed_energy_j() > 0.0);
        state.let_go();
        assert!(state.observed_energy_j() <= 0.0);
        (10..20)
            .map(|n| {
                tick(&mut state, 0.0, n);
                state.observed_energy_j().to_bits()
            })
            .collect::<Vec<_>>()
    });
    assert_eq!(pushed, alone);
}

#[test]
fn a_rate_limit_does_not_keep_up_a_force_that_the_guard_takes_away() {
    // 1 N/s: without the guard 10 N would take 10 s to fall.
    let limits = Limits {
        guard: bounding(0.0),
        ..Limits::bare(Newtons(10.0), NewtonsPerSecond(1.0))
    };
    let chain = SafetyChain::<f64>::from_limits(&limits, T).expect("valid");
    let mut state = SafetyState::<f64, 1>::default();
    let (mut x, mut last) = (0.0, 0.0);
    for _ in 0..1000 {
        x += 1e-4;
        let (force, _) = chain.apply(&mut state, &vector![x], &vector![-10.0]);
        // It holds back what grows.
        assert!(force.newtons()[0] - last >= -T.0 - 1e-12);
        last = force.newtons()[0];
    }
    assert!((last + 2.0).abs() < 1e-2, "{last}");
    // The worst motion, sample by sample.
    let mut acted = false;
    for _ in 0..5000 {
        x += last * T.0 / (2.0 * 0.8 * DAMPING);
        let (force, limiters) = chain.apply(&mut state, &vector![x], &vector![-10.0]);
        assert!(state.observed_energy_j() >= -1e-12);
        let fell = force.newtons()[0] - last;
        acted |= limiters.contains(Limiters::GUARD) && fell > 2.0 * T.0;
        last = force.newtons()[0];
    }
    assert!(acted, "faster than the rate");
    assert!(last.abs() < 1e-2, "{last}");
}

#[test]
fn a_force_is_held_exactly_through_delay_and_lag() {
    for (least, most, lag) in [(1e-3, 1e-3, 0.0), (0.0, 2e-3, 0.0), (0.5e-3, 3e-3, 5e-3)] {
        let chain = bare::<f32>(late(least, most, lag), T);
        let mut state = SafetyState::<f32, 1>::default();
        let mut held = 0.0;
        for tick in 0..100_000_u32 {
            let x = 1e-5 * tick.min(100) as f32;
            let (force, _) = chain.apply(&mut state, &vector![x], &vector![-1e4 * x]);
            if tick == 300 {
                held = force.newtons()[0];
                assert!(held < -0.2, "{held}");
            }
            if tick > 300 {
                assert!(
                    (force.newtons()[0] / held - 1.0).abs() < 1e-5,
                    "{tick} {held}"
                );
            }
        }
    }
}

#[test]
fn the_price_of_delay_lag_and_interval_is_that_of_its_formula() {
    let most = 2.0 * 0.8 * DAMPING / T.0;
    for (least, wide, lag) in [
        (0.0, 0.0, 0.0),
        (0.5, 0.0, 0.0),
        (2.25, 0.0, 0.0),
        (0.0, 0.0, 0.5),
        (0.75, 0.0, 3.0),
        (0.0, 1.0, 0.0),
        (0.5, 3.0, 1.0),
    ] {
        let guard = late(least * T.0, (least + wide) * T.0, lag * T.0);
        let chain = bare::<f64>(guard, T);
        let mut state = SafetyState::<f64, 1>::default();
        // Slowly 1 mm into a wall of 1 MN/m, in 2 s.
        let mut force = 0.0;
        for tick in 0..=1000 {
            let x = 1e-6 * f64::from(tick);
            force = chain
                .apply(&mut state, &vector![x], &vector![-1e6 * x])
                .0
                .newtons()[0];
        }
        let held = 1.0 + least + 0.5 * wide + 0.5 * lag;
        let spread = f64::ceil(0.5 * wide) * 0.5 * wide;
        let want = most / held / (1.0 + (spread / held).sqrt()).powi(2);
        let have = -force / 1e-3;
        println!("{least} {wide} {lag}: {have} {want}");
        assert!((have / want - 1.0).abs() < 0.02, "{have} {want}");
    }
}

#[test]
fn the_noise_of_a_sensor_is_no_motion() {
    // 10 µm rms on a device that stands still for 3 s, then a wish for 10 N: what is let through at once, in the mean of
    // 50 runs.
    let let_through = |noise: f64| {
        let guard = EnergyBounding {
            noise: Metres(noise),
            ..late(0.0, 0.0, 0.0)
        };
        let chain = bare::<f64>(guard, T);
        let mut seed = 7_u64;
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut sum = 0.0;
        for _ in 0..50 {
            let mut state = SafetyState::<f64, 1>::default();
            for tick in 0..=1500 {
                // Twelve uniform numbers are as good as a normal one.
                let x = 1e-5 * (0..12).map(|_| uniform()).sum::<f64>();
                let wanted = if tick == 1500 { -10.0 } else { 0.0 };
                let force = chain.apply(&mut state, &vector![x], &vector![wanted]).0;
                sum += force.newtons()[0].abs() / 50.0;
            }
        }
        sum
    };
    let (taken, credited) = (let_through(1e-5), let_through(0.0));
    println!("noise said: {taken} N, not said: {credited} N");
    assert!(taken < 0.1 * credited, "{taken} {credited}");
}

#[test]
fn noise_is_owed_for_a_thousand_samples_and_paid_only_with_energy_to_spare() {
    const SIGMA: f64 = 1e-5;
    // ρb/T; 2ρ(b/T)σ² a sample; what one sample leaves of a surplus.
    let (damping, keep) = (0.8 * DAMPING / T.0, 1.0 - T.0 / 0.5);
    let noise = 2.0 * damping * SIGMA * SIGMA;
    let guard = EnergyBounding {
        noise: Metres(SIGMA),
        ..late(0.0, 0.0, 0.0)
    };
    let chain = bare::<f64>(guard, T);
    let tick = |state: &mut _, x: f64, wanted: f64| {
        let (force, _) = chain.apply(state, &vector![x], &vector![wanted]);
        force.newtons()[0]
    };
    let mut state = SafetyState::<f64, 1>::default();
    for _ in 0..5000 {
        tick(&mut state, 0.0, 0.0);
    }
    // A motion that pays for half of what is owed leaves nothing, and no debt in the books.
    tick(&mut state, (500.0 * noise / damping).sqrt(), 0.0);
    assert!(state.observed_energy_j().abs() < 1e-9 * noise);
    // Half is left, and a sample more has come to it. Twice that: the rest is a surplus.
    let x = (500.0 * noise / damping).sqrt() + (1002.0 * noise / damping).sqrt();
    tick(&mut state, x, 0.0);
    let left = state.observed_energy_j() / (keep * noise);
    assert!((left - 501.0).abs() < 1e-6, "{left}");
    // All that is covered for a force is not spent on noise: it is held for a minute.
    let sent = tick(&mut state, x, -10.0);
    assert!((-10.0..-0.1).contains(&sent), "{sent}");
    for _ in 0..30_000 {
        let held = tick(&mut state, x, -10.0);
        assert!((held - sent).abs() < 1e-9, "{held} {sent}");
    }
}

#[test]
fn a_force_that_was_bounded_has_no_surplus_to_forget() {
    // f = 2ρ(b/T)·|Δ| of the first motion, and its energy ρ(b/T)·Δ² stays.
    let chain = bare::<f64>(late(0.0, 0.0, 0.0), T);
    let mut state = SafetyState::<f64, 1>::default();
    for (x, wanted) in [(0.0, 0.0), (1e-3, -100.0)] {
        chain.apply(&mut state, &vector![x], &vector![wanted]);
    }
    let energy = 0.8 * DAMPING / T.0 * 1e-6;
    assert!((state.observed_energy_j() / energy - 1.0).abs() < 1e-12);
}

#[test]
fn what_a_guard_cannot_promise_is_refused() {
    let refused = |bounding| {
        let limits = Limits {
            guard: Some(Guard::EnergyBounding(bounding)),
            ..Limits::default()
        };
        let error = SafetyChain::<f64>::from_limits(&limits, T).expect_err("refused");
        error.to_string()
    };
    let nan = f64::NAN;
    for (bounding, words) in [
        (
            EnergyBounding::of(NewtonSecondsPerMetre(0.0)),
            "damping of the device 0",
        ),
        (
            EnergyBounding::of(NewtonSecondsPerMetre(nan)),
            "damping of the device",
        ),
        (
            late(-1e-6, 0.0, 0.0),
            "least delay of the guard -0.000001 s is not at least 0",
        ),
        (late(nan, 0.0, 0.0), "least delay"),
        (
            late(1e-3, 0.9e-3, 0.0),
            "delay of the guard 0.0009 s is not from the least delay to 4 sample times",
        ),
        (
            late(0.0, 8.1e-3, 0.0),
            "0.0081 s is not from the least delay to 4 sample times",
        ),
        (late(0.0, f64::INFINITY, 0.0), "delay of the guard inf"),
        (
            late(0.0, 0.0, 0.129),
            "lag of the actuator 0.129 s is not from 0 to 64 sample times",
        ),
        (late(0.0, 0.0, nan), "lag of the actuator NaN"),
        (
            EnergyBounding {
                noise: Metres(-1e-6),
                ..late(0.0, 0.0, 0.0)
            },
            "noise for the guard",
        ),
        (
            EnergyBounding {
                share: 1.01,
                ..late(0.0, 0.0, 0.0)
            },
            "share of the damping",
        ),
    ] {
        let text = refused(bounding);
        assert!(text.contains(words), "{text}");
    }
    // The ends of the ranges are good.
    for good in [
        late(0.0, 8e-3, 0.128),
        late(8e-3, 8e-3, 0.0),
        late(0.0, 0.0, 1e-9),
    ] {
        let _ = bare::<f32>(good, T);
        let _ = bare::<f64>(good, T);
    }
}

/// Motions in µm and wanted forces in N.
fn motions() -> impl Strategy<Value = Vec<([f64; 2], [f64; 2])>> {
    let steps = proptest::array::uniform2(-300.0..300.0);
    let forces = proptest::array::uniform2(-20.0..20.0);
    proptest::collection::vec((steps, forces), 1..400)
}

proptest! {
    #[test]
    fn no_motion_draws_more_than_the_damping_of_the_device(
        motions in motions(), delay in 0usize..=4, forget in prop_oneof![Just(0.0), 0.002..2.0],
    ) {
        let guard = EnergyBounding {
            delay_least: Seconds(delay as f64 * T.0),
            delay_most: Seconds(delay as f64 * T.0),
            forget: Seconds(forget),
            ..EnergyBounding::of(NewtonSecondsPerMetre(DAMPING))
        };
        let limits = Limits {
            guard: Some(Guard::EnergyBounding(guard)),
            ..Limits::bare(Newtons(100.0), NewtonsPerSecond(200.0 / T.0))
        };
        let chain = SafetyChain::from_limits(&limits, T).expect("valid");
        let mut state = SafetyState::<f64, 2>::default();
        let (mut x, mut energy) = (SVector::<f64, 2>::zeros(), 0.0);
        let mut line = [SVector::<f64, 2>::zeros(); 5];
        for (step, wanted) in motions {
            let moved = SVector::from(step) * 1e-6;
            x += moved;
            // What the force that acts does, and what the damping surely takes.
            energy += 0.8 * DAMPING / T.0 * moved.norm_squared() - line[delay].dot(&moved);
            prop_assert!(energy >= -1e-12, "{energy}");
            let (force, _) = chain.apply(&mut state, &x, &SVector::from(wanted));
            prop_assert!(state.observed_energy_j() <= energy + 1e-12);
            prop_assert!(state.observed_energy_j() >= -1e-12);
            line.rotate_right(1);
            line[0] = *force.newtons();
        }
    }

    #[test]
    fn the_observer_never_credits_more_than_was_given(motions in motions()) {
        let limits = Limits {
            guard: observer(),
            ..Limits::bare(Newtons(100.0), NewtonsPerSecond(200.0 / T.0))
        };
        let chain = SafetyChain::from_limits(&limits, T).expect("valid");
        let mut state = SafetyState::<f64, 2>::default();
        let (mut x, mut given) = (SVector::<f64, 2>::zeros(), 0.0);
        let mut last = SVector::<f64, 2>::zeros();
        let most = MASS / (2.0 * T.0);
        for (index, (step, wanted)) in motions.into_iter().enumerate() {
            // The first position is where it starts.
            let moved = SVector::from(step) * if index == 0 { 0.0 } else { 1e-6 };
            x += moved;
            given -= last.dot(&moved);
            let wanted = SVector::from(wanted);
            let (force, limiters) = chain.apply(&mut state, &x, &wanted);
            last = *force.newtons();
            prop_assert!(state.observed_energy_j() <= given + 1e-12);
            // Damping along the motion, no more than the device bears.
            let damping = (wanted - last) * T.0;
            prop_assert!((damping.dot(&moved) - damping.norm() * moved.norm()).abs() < 1e-12);
            prop_assert!(damping.norm() <= most * moved.norm() + 1e-12);
            prop_assert_eq!(limiters.contains(Limiters::GUARD), damping.norm() > 1e-15 );
        }
    }
}
