//! The self-test on devices of two and three axes whose positions are told as they are, mirrored, or swapped, in their own time.

use crate::at_once::at_once;
use crate::foreign::WITHOUT_STOP;
use crate::tested;
use haptic_link::{Capabilities, Refusal, Simulation};
use haptic_loop::nalgebra::SVector;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Seconds};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{BoardTrouble, DeviceTime, SerialLink, Served, ServedHardware};
use haptic_remote::{Hardware, abilities, only_real};
use haptic_selftest::{Promise, SelfTestReport};

/// For each axis that is told, which one of the device it is, and its sign.
type Told<const D: usize> = [(usize, f32); D];

/// A mass that moves freely.
struct Arm<const D: usize> {
    plant: MassDamper<D>,
    told: Told<D>,
}

fn plant<const D: usize>(period_s: f64) -> MassDamper<D> {
    let (mass, damping) = (Kilograms(0.1), NewtonSecondsPerMetre(2.0));
    MassDamper::new(MassDamperConfig::ideal(mass, damping, Seconds(period_s))).expect("good")
}

impl<const D: usize> Device<f32, D> for Arm<D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        let Ok(there) = Device::<f32, D>::read(&mut self.plant);
        let position_m = SVector::from_fn(|axis, _| {
            let (of, sign) = self.told[axis];
            sign * there.position_m[of]
        });
        Ok(Reading {
            position_m,
            ..there
        })
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        let Ok(()) = self.plant.write(force);
        Ok(())
    }

    fn let_go(&mut self) {}
}

impl<const D: usize> Hardware<D> for Arm<D> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: 5.0,
            force_rate_max_n_per_s: 1e5,
            position_resolution_m: 1e-6,
            ..abilities("arm", D as u8)
        }
    }

    fn prepare(simulation: &Simulation, _: u32) -> Result<(), Refusal> {
        only_real(simulation)
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.plant = plant(1e-6 * f64::from(tick_period_us));
    }

    fn restart(&mut self) {}

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.write(SafeForce::zero())?;
        self.read()
    }
}

impl<const D: usize> ServedHardware<D> for Arm<D> {
    fn trouble(&self) -> Option<BoardTrouble> {
        None
    }
}

fn report<const D: usize>(told: Told<D>) -> SelfTestReport {
    let connect = || {
        let arm = Arm {
            plant: plant(1e-3),
            told,
        };
        let served = Served::in_its_own_time(arm, DeviceTime::default()).expect("serves");
        Ok(SerialLink::to_served(served, "arm").expect("answers"))
    };
    tested(&connect, WITHOUT_STOP, &|_| {})
}

/// The row of the direction, when every other promise is kept.
fn direction<const D: usize>(told: Told<D>) -> (Option<bool>, String) {
    let report = report(told);
    for check in &report.checks {
        // This one is what is asked for, and there is no emergency stop.
        let expected = match [Promise::Direction, Promise::EmergencyStop].contains(&check.check) {
            true => check.ok,
            false => Some(true),
        };
        assert_eq!(check.ok, expected, "{report:#?}");
    }
    let row = report
        .checks
        .iter()
        .find(|row| row.check == Promise::Direction);
    let row = row.expect("a row");
    (row.ok, row.seen.clone())
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn each_axis_is_tried_and_one_that_is_mirrored_or_swapped_is_named() {
    let right = direction([(0, 1.0), (1, 1.0), (2, 1.0)]);
    assert_eq!(right.0, Some(true), "{right:?}");
    for axis in ["x: ", "; y: ", "; z: "] {
        assert!(right.1.contains(axis), "{right:?}");
    }
    assert_eq!(direction([(0, 1.0), (1, 1.0)]).0, Some(true));
    let cases: [(Told<3>, &'static [&str]); 4] = [
        (
            [(0, 1.0), (1, -1.0), (2, 1.0)],
            &["y: ", "mm against its force"],
        ),
        (
            [(0, 1.0), (2, 1.0), (1, 1.0)],
            &[
                "y: a force along it moves z",
                "z: a force along it moves y",
                "with the force: these axes are swapped",
            ],
        ),
        // From a frame with y up to one with z up.
        (
            [(0, 1.0), (2, -1.0), (1, 1.0)],
            &[
                "z: a force along it moves y",
                "against the force: these axes are swapped",
            ],
        ),
        (
            [(1, 1.0), (2, 1.0), (0, 1.0)],
            &[
                "x: a force along it moves z",
                "y: a force along it moves x",
                "z: a force along it moves y",
            ],
        ),
    ];
    at_once(cases.map(|(told, words)| {
        (format!("{told:?}"), move || {
            let (ok, seen) = direction(told);
            assert_eq!(ok, Some(false), "{seen}");
            for word in words {
                assert!(seen.contains(word), "{seen}");
            }
        })
    }));
}
