//! A tick in two halves is the tick, bit for bit: over random runs with faults, stops, missing ticks and forces that
//! somebody else commands.

use core::convert::Infallible;
use fracdiff::{Order, Seconds, ShortMemory};
use haptic_loop::units::{
    Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    Contact, Controller, Device, EnergyBounding, Environment, Fault, Guard, Limits,
    PassivityObserver, Reading, SafeForce, SafetyChain, Sample, SpeedLimit, SpringDamper,
    Workspace,
};
use nalgebra::vector;
use proptest::prelude::*;

const T: Seconds = Seconds(1e-3);

type Wall = Contact<f64, SpringDamper<f64, ShortMemory<f64, 32>>, 1>;

fn wall() -> Wall {
    let operator = ShortMemory::new(Order::new(0.5).expect("valid"), T).expect("valid");
    let wall = SpringDamper::new(500.0, 3.0, operator).expect("valid");
    Contact::new([1.0], Metres(0.0), wall).expect("valid")
}

/// A guard: 0 none, 1 the observer, 2 energy bounding.
fn controller(guard: u8) -> Controller<f64, 1, Wall> {
    let damping = NewtonSecondsPerMetre(2.0);
    let limits = Limits {
        guard: match guard {
            0 => None,
            1 => Some(Guard::Observer(PassivityObserver::bearable(
                Kilograms(0.1),
                T,
            ))),
            _ => Some(Guard::EnergyBounding(EnergyBounding::of(damping))),
        },
        workspace: Some(Workspace {
            low: Metres(-0.05),
            high: Metres(0.05),
            soft: Metres(0.01),
        }),
        speed: Some(SpeedLimit {
            soft: MetresPerSecond(1.0),
            hard: MetresPerSecond(20.0),
        }),
        braking: Some(damping),
        ..Limits::bare(Newtons(8.0), NewtonsPerSecond(2000.0))
    };
    let chain = SafetyChain::from_limits(&limits, T).expect("valid");
    Controller::new(wall(), chain)
}

fn reading(tick: u64, position_m: f64) -> Reading<f64, 1> {
    Reading {
        tick,
        time_s: tick as f64 * T.0,
        position_m: vector![position_m],
    }
}

/// Takes any force.
struct Sink(Vec<SafeForce<f64, 1>>);

impl Device<f64, 1> for Sink {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        unreachable!("its reading is given")
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        self.0.push(force);
        Ok(())
    }
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Tick,
    Commanded(f64),
    Skip(u64),
    Trip,
    Stop,
    Reset,
    LetGo,
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        30 => Just(Step::Tick),
        2 => prop_oneof![-20.0..20.0, Just(f64::NAN)].prop_map(Step::Commanded),
        1 => (1_u64..5).prop_map(Step::Skip),
        1 => Just(Step::Trip),
        1 => Just(Step::Stop),
        3 => Just(Step::Reset),
        1 => Just(Step::LetGo),
    ]
}

/// All bits of a sample: a NaN equals itself.
fn bits(sample: &Sample<f64, 1>) -> [u64; 5] {
    [
        sample.reading.tick,
        sample.environment_force_n[0].to_bits(),
        sample.force.newtons()[0].to_bits(),
        u64::from(sample.limiters.bits()),
        sample.observed_energy_j.to_bits(),
    ]
}

fn do_to(controller: &mut Controller<f64, 1, Wall>, step: Step) {
    match step {
        Step::Trip => controller.trip(Fault::EmergencyStop),
        Step::Stop => controller.stop(),
        Step::Reset => controller.reset(),
        Step::LetGo => controller.let_go(),
        Step::Tick | Step::Commanded(_) | Step::Skip(_) => {}
    }
}

proptest! {
    #[test]
    fn two_halves_are_a_tick_over_random_runs(
        guard in 0_u8..3,
        steps in prop::collection::vec((step(), -4e-3..4e-3_f64), 1..300),
        drop_some in any::<bool>(),
    ) {
        let (mut whole, mut halves) = (controller(guard), controller(guard));
        let mut sink = Sink(Vec::new());
        let (mut tick, mut position) = (0, 0.0);
        // The environment's own history, kept by hand.
        let (wall, mut history) = (wall(), wall().at_rest());
        for (n, (step, moved)) in steps.into_iter().enumerate() {
            position = f64::clamp(position + moved, -0.06, 0.06);
            // A sensor that breaks for a tick.
            let seen = if n % 97 == 96 { f64::NAN } else { position };
            do_to(&mut whole, step);
            do_to(&mut halves, step);
            match step {
                Step::Skip(ticks) => tick += ticks,
                Step::Reset => history = wall.at_rest(),
                _ => {}
            }
            let here = reading(tick, seen);
            let (want, have);
            if let Step::Commanded(force) = step {
                let command = vector![force];
                want = whole.begin_commanded(here, &command).finish();
                let begun = halves.begin_commanded(here, &command);
                have = begun.force();
            } else {
                want = whole.tick_reading(&mut sink, here).expect("infallible");
                let begun = halves.begin(here);
                have = begun.force();
                prop_assert_eq!(have.newtons(), sink.0.last().expect("written").newtons());
                let wanted = wall.force(&history, &here.position_m);
                prop_assert_eq!(want.environment_force_n[0].to_bits(), wanted[0].to_bits());
                wall.advance(&mut history, &here.position_m);
                if drop_some && n % 3 == 0 {
                    drop(begun);
                } else {
                    prop_assert_eq!(bits(&begun.finish()), bits(&want), "tick {}", n);
                }
            }
            prop_assert_eq!(have.newtons()[0].to_bits(), want.force.newtons()[0].to_bits());
            prop_assert_eq!(halves.safety(), whole.safety());
            tick += 1;
        }
        // The histories agree too: so does the next force, wherever it is.
        for controller in [&mut whole, &mut halves] {
            controller.trip(Fault::EmergencyStop);
        }
        let next = reading(tick, 1e-3);
        prop_assert_eq!(bits(&whole.begin(next).finish()), bits(&halves.begin(next).finish()));
    }
}

/// A tick that is given up half way leaves no gap: the next force remembers its position.
#[test]
fn a_tick_that_is_never_finished_skips_no_history_and_gives_no_energy() {
    let positions: Vec<f64> = (0..200_u32)
        .map(|n| 2e-3 * f64::from(n % 50) / 50.0)
        .collect();
    for guard in 0..3 {
        let (mut kept, mut given_up) = (controller(guard), controller(guard));
        let (wall, mut history) = (wall(), wall().at_rest());
        for (tick, &position) in (0..).zip(&positions) {
            let want = kept.begin(reading(tick, position)).finish();
            let given_up = given_up.begin(reading(tick, position)).force();
            assert_eq!(given_up, want.force, "guard {guard}, tick {tick}");
            let x = vector![position];
            assert_eq!(
                want.environment_force_n,
                wall.force(&history, &x),
                "tick {tick}"
            );
            wall.advance(&mut history, &x);
        }
        assert_eq!(kept.safety(), given_up.safety(), "guard {guard}");
        assert_eq!(kept.guarded_energy_j(), given_up.guarded_energy_j());
    }
}
