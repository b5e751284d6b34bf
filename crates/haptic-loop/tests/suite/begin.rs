//! A tick in two halves is the tick, bit for bit: over random runs with faults, stops, missing ticks and forces that
//! somebody else commands.

use crate::{T, chain, spring};
use core::convert::Infallible;
use haptic_loop::units::{
    Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    Contact, Controller, Device, EnergyBounding, Engaged, Environment, Fault, Guard, Limits,
    PassivityObserver, Reading, SafeForce, Sample, SpeedLimit, SpringDamper, Workspace,
};
use nalgebra::vector;
use proptest::prelude::*;

type Wall = Contact<f64, SpringDamper<f64, crate::Memory>, 1>;

fn wall() -> Wall {
    Contact::at(Metres(0.0), spring(500.0, 3.0, 0.5)).expect("valid")
}

type Looped = Engaged<f64, 1, Wall, Sink>;

/// A guard: 0 none, 1 the observer, 2 energy bounding.
fn looped(guard: u8) -> Looped {
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
    Controller::new(wall(), chain(limits)).into_engaged(Sink(reading(0, 0.0), Vec::new()))
}

fn reading(tick: u64, position_m: f64) -> Reading<f64, 1> {
    Reading {
        tick,
        time_s: tick as f64 * T.0,
        position_m: vector![position_m],
    }
}

/// Is where it is put, and takes any force.
struct Sink(Reading<f64, 1>, Vec<SafeForce<f64, 1>>);

impl Device<f64, 1> for Sink {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        Ok(self.0)
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        self.1.push(force);
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

fn do_to(engaged: &mut Looped, step: Step) {
    let controller = engaged.controller_mut();
    match step {
        Step::Trip => controller.trip(Fault::EmergencyStop),
        Step::Stop => controller.stop(),
        Step::Reset => controller.reset(),
        Step::LetGo => engaged.let_go(Fault::EmergencyStop),
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
        let (mut whole, mut halves) = (looped(guard), looped(guard));
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
            if let Step::Commanded(force) = step {
                // With its force commanded a tick has no halves, and no part in the history.
                for engaged in [&mut whole, &mut halves] {
                    engaged.device_mut().0 = here;
                    let sample = engaged.tick_commanded(Some(&vector![force])).expect("infallible");
                    prop_assert_eq!(sample.environment_force_n[0].to_bits(), force.to_bits());
                }
            } else {
                let want = whole.tick_reading(here).expect("infallible");
                let begun = halves.begin(here);
                let have = begun.force();
                let written = whole.device().1.last().expect("written");
                prop_assert_eq!(have.newtons(), written.newtons());
                let wanted = wall.force(&history, &here.position_m);
                prop_assert_eq!(want.environment_force_n[0].to_bits(), wanted[0].to_bits());
                wall.advance(&mut history, &here.position_m);
                if drop_some && n % 41 == 40 {
                    drop(begun);
                    whole.let_go(Fault::BoardFailed);
                } else {
                    prop_assert_eq!(bits(&begun.finish()), bits(&want), "tick {}", n);
                }
            }
            let [whole, halves] = [&whole, &halves].map(|engaged| engaged.controller().safety());
            prop_assert_eq!(halves, whole);
            tick += 1;
        }
        // The histories agree too: so does the next force, wherever it is.
        for engaged in [&mut whole, &mut halves] {
            engaged.controller_mut().trip(Fault::EmergencyStop);
        }
        let next = reading(tick, 1e-3);
        prop_assert_eq!(bits(&whole.begin(next).finish()), bits(&halves.begin(next).finish()));
    }
}

/// A tick that is given up half way is a force that did not get through: the device lets go, the fault stays, and the history has the
/// position.
#[test]
fn a_tick_that_is_never_finished_lets_go_and_skips_no_history() {
    for guard in 0..3 {
        let mut engaged = looped(guard);
        let (wall, mut history) = (wall(), wall().at_rest());
        for tick in 0..60 {
            let here = reading(tick, 1e-4 * tick as f64);
            let begun = engaged.begin(here);
            if tick == 50 {
                assert!(begun.force().newtons()[0] < -1.0, "guard {guard}");
                drop(begun);
                assert!(engaged.controller().safety().is_at_rest());
                assert_eq!(engaged.device().1, [SafeForce::zero()]);
            } else {
                let sample = begun.finish();
                let wanted = wall.force(&history, &here.position_m);
                assert_eq!(sample.environment_force_n, wanted, "tick {tick}");
                let fault = (tick > 50).then_some(Fault::BoardFailed);
                assert_eq!(sample.fault, fault, "tick {tick}");
                assert!(tick < 50 || sample.force == SafeForce::zero());
            }
            wall.advance(&mut history, &here.position_m);
        }
    }
}
