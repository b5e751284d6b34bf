//! A device that fails in the middle of a run, or whose loop panics, has zero as its last force: by reference, and owned as in the
//! static of a tick interrupt.

use crate::{BARE, T, chain, spring};
use core::borrow::BorrowMut;
use haptic_loop::{Controller, Device, Engaged, Fault, Limiters, Reading, SafeForce, SpringDamper};
use nalgebra::vector;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

type Spring = SpringDamper<f64, crate::Memory>;

/// 2 N at the place of the device, 1 N a tick.
fn controller() -> Controller<f64, 1, Spring> {
    Controller::new(spring(100.0, 1.0, 0.5), chain(BARE))
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fails {
    Read,
    Write,
    ReadPanics,
    WritePanics,
}

/// The forces that have come to its motor, which holds the last.
type Motor = Rc<RefCell<Vec<f64>>>;

/// A device that stands still, and fails once.
struct Failing {
    motor: Motor,
    tick: u64,
    at: u64,
    fails: Fails,
}

impl Device<f64, 1> for Failing {
    type Error = Fails;

    fn read(&mut self) -> Result<Reading<f64, 1>, Fails> {
        let fails = (self.tick == self.at).then_some(self.fails);
        if matches!(fails, Some(Fails::Read | Fails::ReadPanics)) {
            self.tick += 1;
            assert_eq!(fails, Some(Fails::Read), "the sensor's code panics");
            return Err(Fails::Read);
        }
        Ok(Reading {
            tick: self.tick,
            time_s: self.tick as f64 * T.0,
            position_m: vector![0.02],
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Fails> {
        let fails = (self.tick == self.at).then_some(self.fails);
        self.tick += 1;
        if matches!(fails, Some(Fails::Write | Fails::WritePanics)) {
            assert_eq!(fails, Some(Fails::Write), "the motor's code panics");
            return Err(Fails::Write);
        }
        RefCell::borrow_mut(&self.motor).push(force.newtons()[0]);
        Ok(())
    }
}

fn last(motor: &Motor) -> Option<f64> {
    RefCell::borrow(motor).last().copied()
}

/// Ticks up to the error and beyond it: whoever goes on gets no force, and is told why.
fn run_on<C: BorrowMut<Controller<f64, 1, Spring>>>(
    mut engaged: Engaged<f64, 1, Spring, Failing, C>,
) {
    let motor = Rc::clone(&engaged.device().motor);
    let (at, fails) = (engaged.device().at, engaged.device().fails);
    for tick in 0..at {
        let sample = engaged.tick().expect("not yet");
        assert_eq!(sample.fault, None, "tick {tick}");
    }
    assert_eq!(engaged.tick(), Err(fails));
    assert_eq!(last(&motor), Some(0.0), "{fails:?} at {at}: at once");
    assert!(engaged.controller().safety().is_at_rest());
    for _ in 0..20 {
        let sample = engaged.tick().expect("it fails once");
        assert_eq!(sample.fault, Some(Fault::BoardFailed));
        assert!(sample.limiters.contains(Limiters::FAULT));
        assert_eq!(last(&motor), Some(0.0));
    }
    // Until somebody has seen to it.
    engaged.controller_mut().clear();
    for _ in 0..5 {
        engaged.tick().expect("it fails once");
    }
    assert!(last(&motor) < Some(-1.0));
    drop(engaged);
    assert_eq!(last(&motor), Some(0.0));
}

#[test]
fn an_error_of_the_device_leaves_zero_force_and_a_fault() {
    for fails in [Fails::Read, Fails::Write] {
        for at in [0, 1, 2, 30] {
            let device = || Failing {
                motor: Motor::default(),
                tick: 0,
                at,
                fails,
            };
            run_on(controller().engage(device()));
            run_on(controller().into_engaged(device()));
        }
    }
}

#[test]
fn a_panic_that_unwinds_leaves_zero_force() {
    for fails in [Fails::ReadPanics, Fails::WritePanics] {
        for owned in [false, true] {
            let motor = Motor::default();
            let device = Failing {
                motor: Rc::clone(&motor),
                tick: 0,
                at: 10,
                fails,
            };
            let mut controller = controller();
            let unwound = catch_unwind(AssertUnwindSafe(|| {
                if owned {
                    run_on(controller.into_engaged(device));
                } else {
                    run_on(controller.engage(device));
                }
            }));
            assert!(unwound.is_err());
            let forces = RefCell::borrow(&motor);
            assert_eq!(forces.len(), 11, "ten ticks, and the end");
            assert!(forces[9] < -1.0);
            assert_eq!(forces.last(), Some(&0.0), "{fails:?}, owned: {owned}");
        }
    }
}
