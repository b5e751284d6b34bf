//! The self-test on devices of two and three axes that tell their positions as they are, mirrored, or swapped, in their own time.

use crate::at_once::at_once;
use crate::foreign::WITHOUT_STOP;
use crate::tested;
use haptic_link::Capabilities;
use haptic_loop::nalgebra::SVector;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Seconds};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{BoardTrouble, DeviceTime, SerialLink, Served, ServedHardware};
use haptic_remote::{Hardware, abilities};
use haptic_selftest::Promise;

/// Number of the device's own axis, from 1 on and with a sign, for each axis as the device reports it.
type Mapping<const D: usize> = [i8; D];

/// A mass that moves freely.
struct Arm<const D: usize> {
    plant: MassDamper<D>,
    mapping: Mapping<D>,
}

fn plant<const D: usize>(period_s: f64) -> MassDamper<D> {
    let (mass, damping) = (Kilograms(0.1), NewtonSecondsPerMetre(2.0));
    MassDamper::new(MassDamperConfig::ideal(mass, damping, Seconds(period_s))).expect("good")
}

impl<const D: usize> Device<f32, D> for Arm<D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        let Ok(reading) = Device::<f32, D>::read(&mut self.plant);
        let position_m = SVector::from_fn(|axis, _| {
            let source = self.mapping[axis];
            f32::from(source.signum()) * reading.position_m[usize::from(source.unsigned_abs()) - 1]
        });
        Ok(Reading {
            position_m,
            ..reading
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

/// The row of the direction, when every other promise is kept.
fn direction<const D: usize>(mapping: Mapping<D>) -> (Option<bool>, String) {
    let connect = || {
        let arm = Arm {
            plant: plant(1e-3),
            mapping,
        };
        let served = Served::in_its_own_time(arm, DeviceTime::default()).expect("serves");
        Ok(SerialLink::to_served(served, "arm").expect("answers"))
    };
    let report = tested(&connect, WITHOUT_STOP, &|_| {});
    let (asked, others): (Vec<_>, Vec<_>) = (report.checks.iter())
        .filter(|row| row.check != Promise::EmergencyStop)
        .partition(|row| row.check == Promise::Direction);
    let kept = others.iter().all(|row| row.ok == Some(true));
    assert!(kept, "{report:#?}");
    (asked[0].ok, asked[0].seen.clone())
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn each_axis_is_tried_and_one_that_is_mirrored_or_swapped_is_named() {
    let right = direction([1, 2, 3]);
    assert_eq!(right.0, Some(true), "{right:?}");
    for axis in ["x: ", "; y: ", "; z: "] {
        assert!(right.1.contains(axis), "{right:?}");
    }
    assert_eq!(direction([1, 2]).0, Some(true));
    let y_moves_z = "y: a force along it moves z";
    let z_moves_y = "z: a force along it moves y";
    let with = "with the force: these axes are swapped";
    let against = "against the force: these axes are swapped";
    let rotated = ["x: a force along it moves z", "y: a force along it moves x"];
    let cases: [(Mapping<3>, Vec<&str>); 4] = [
        ([1, -2, 3], vec!["y: ", "mm against its force"]),
        ([1, 3, 2], vec![y_moves_z, z_moves_y, with]),
        // From a frame with y up to one with z up.
        ([1, -3, 2], vec![z_moves_y, against]),
        ([2, 3, 1], [&rotated[..], &[z_moves_y]].concat()),
    ];
    at_once(cases.map(|(mapping, words)| {
        (format!("{mapping:?}"), move || {
            let (ok, seen) = direction(mapping);
            assert_eq!(ok, Some(false), "{seen}");
            for word in words {
                assert!(seen.contains(word), "{seen}");
            }
        })
    }));
}
