//! The self-test on the emulated devices of other makers, each in its own time: what a busy machine makes late is not judged,
//! because nothing is late.

use crate::at_once::at_once;
use crate::tested;
use haptic_devices::haply::{Haply2Diy, HaplyName, Version};
use haptic_devices::moteus::{MoteusAxis, MoteusSettings};
use haptic_document::Failure;
use haptic_emulator::haply::{Board, Body, Hand};
use haptic_emulator::moteus::{EmulatedAdapter, EmulatedServo, Shaft};
use haptic_emulator::{AtLine, NearLine};
use haptic_remote::serial::{DeviceTime, SerialLink, Served, ServedHardware};
use haptic_selftest::{EmergencyStop, Promise, SelfTest, SelfTestReport};
use std::sync::{Arc, Mutex};

/// An emulated device that outlives its connections, and the time that it lives in.
pub(crate) struct Emulated<D> {
    pub(crate) device: Arc<Mutex<D>>,
    pub(crate) time: DeviceTime,
}

impl<D: AtLine> Emulated<D> {
    pub(crate) fn new(device: D) -> Self {
        Self {
            device: Arc::new(Mutex::new(device)),
            time: DeviceTime::default(),
        }
    }

    pub(crate) fn line(&self) -> NearLine<D> {
        NearLine::new(Arc::clone(&self.device), self.time.clone())
    }

    pub(crate) fn link(&self, hardware: impl ServedHardware, name: &str) -> SerialLink {
        let served = Served::in_its_own_time(hardware, self.time.clone()).expect("serves");
        SerialLink::to_served(served, name).expect("answers")
    }

    fn look<R>(&self, look: impl FnOnce(&D) -> R) -> R {
        look(&self.device.lock().expect("nobody panicked with it"))
    }
}

/// Devices of other makers have no emergency stop.
pub(crate) const WITHOUT_STOP: SelfTest = SelfTest {
    emergency_stop: EmergencyStop::Absent,
    ..SelfTest::DEFAULT
};

/// The report of a device that breaks no promise; it has no emergency stop.
fn kept(connect: &dyn Fn() -> Result<SerialLink, Failure>) -> SelfTestReport {
    let report = tested(connect, WITHOUT_STOP, &|_| {});
    let verdicts: Vec<_> = (report.checks.iter())
        .map(|check| (check.check, check.ok))
        .collect();
    let unknown = report.checks.iter().any(|check| check.not_judged);
    let promised = Promise::ALL.map(|promise| {
        // Friction lets one of them creep. It gets far enough to be judged only where a busy machine gives it more ticks.
        let creeps = promise == Promise::Direction && report.board != "moteus";
        let is_judged = if creeps {
            !unknown
        } else {
            promise != Promise::EmergencyStop
        };
        (promise, is_judged.then_some(true))
    });
    assert_eq!(verdicts, promised, "{report:#?}");
    assert!(!unknown || report.board != "moteus", "{report:#?}");
    assert_eq!(report.holds, !unknown, "{report:#?}");
    assert!(report.link_lost.is_none(), "{report:#?}");
    assert!(!report.simulated);
    report
}

pub(crate) fn a_2diy_keeps_every_promise() {
    at_once(Version::ALL.map(|version| {
        (format!("version {}", version.number()), move || {
            a_2diy_keeps_them(version);
        })
    }));
}

fn a_2diy_keeps_them(version: Version) {
    let model = version.model();
    let board = Board::new(model, Body::at_home(&model, Hand::Free));
    let emulated = Emulated::new(board);
    let name = HaplyName {
        version,
        ..HaplyName::at("emulated")
    };
    let report = kept(&|| {
        let hardware = Haply2Diy::<_, 1>::greet(emulated.line(), &name).expect("answers");
        Ok(emulated.link(hardware, &format!("{name}")))
    });
    assert!(report.board.starts_with("Haply 2DIY"), "{report:#?}");
    let (asked, left) = emulated.look(|board| (board.counted(), board.torques_nm()));
    // It did move the motors, and has let go.
    assert!(asked.largest_nm > 1e-3, "{asked:?}");
    assert!(left.iter().all(|torque| torque.abs() < 1e-30), "{left:?}");
}

pub(crate) fn a_servo_keeps_every_promise() {
    let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
    let emulated = Emulated::new(EmulatedAdapter::new(servo));
    let settings = MoteusSettings::DEFAULT;
    let report = kept(&|| {
        let axis = MoteusAxis::open(emulated.line(), settings, true).expect("answers");
        Ok(emulated.link(axis, "moteus:emulated"))
    });
    assert_eq!(report.board, "moteus");
    let (peak_nm, left_nm) =
        emulated.look(|adapter| (adapter.servo.torque_peak_nm(), adapter.servo.torque_nm()));
    let most_nm = report.force_limit_n as f64 * settings.radius_m;
    assert!(
        (peak_nm / most_nm - 1.0).abs() < 1e-6,
        "{peak_nm} of {most_nm} N·m"
    );
    assert!(left_nm.abs() <= 0.0, "{left_nm}");
}
