//! Our host, as `host-cli` has it, at the port of a bridge.

use crate::bench::{stiff_wall, wall};
use haptic_link::{Refusal, Start};
use haptic_loop::Fault;
use haptic_remote::{
    LinkError,
    serial::{ConnectOptions, DeviceMessage, SerialError, SerialLink},
};
use std::time::Duration;

pub(crate) struct Host {
    link: SerialLink,
    pub(crate) fault: Option<Fault>,
}

impl Host {
    pub(crate) fn connect(port: u16) -> Self {
        let path = format!("tcp:127.0.0.1:{port}");
        let link = SerialLink::connect(&path, ConnectOptions::default()).expect("answers");
        Self { link, fault: None }
    }

    /// Hears out a run until it is over, for a reason that nobody here knows.
    pub(crate) fn over(&mut self) -> LinkError {
        loop {
            if let Some(DeviceMessage::Over(error)) = self.link.hear(Duration::from_secs(1)) {
                return error;
            }
        }
    }

    /// Runs the wall for so many ticks; the largest force that the samples tell, N.
    pub(crate) fn presses(&mut self, ticks: u32) -> f32 {
        let (mut configuration, values) = wall();
        // The longest: this machine may be busy.
        configuration.limits.watchdog_ms = 1000;
        self.link.set(configuration, &values).expect("good");
        self.link.arm(Duration::from_secs(1)).expect("is well");
        self.link
            .start(Start {
                run: 1,
                ..Start::ENDLESS
            })
            .expect("starts");
        let (mut heard, mut largest_n) = (0, 0.0_f32);
        while heard < ticks && self.fault.is_none() {
            match self.link.hear(testkit::PATIENCE) {
                Some(DeviceMessage::Sample(sample)) => {
                    heard += 1;
                    let forces = sample.axes.iter().map(|axis| axis.force_n.abs());
                    largest_n = forces.fold(largest_n, f32::max);
                }
                Some(DeviceMessage::Fault(report)) => {
                    self.fault = Fault::from_code(report.status.fault);
                }
                Some(DeviceMessage::Over(error)) => panic!("{error}"),
                Some(DeviceMessage::Event(_)) | None => {}
            }
        }
        largest_n
    }

    /// Why it arms a robot of which it knows nothing.
    pub(crate) fn armed(&self) -> SerialError {
        let armed = self.link.arm(Duration::from_secs(1));
        armed.expect_err("a robot that it does not know")
    }

    /// Starts a wall of 1000 N/m at 1 cm on a robot that has rested.
    pub(crate) fn starts_the_robot(&mut self) {
        self.link.knows_robot();
        let (configuration, values) = stiff_wall();
        self.link.set(configuration, &values).expect("good");
        self.link.arm(Duration::from_secs(1)).expect("is well");
        let mut run = 0;
        let refused = Refusal::FaultPersists(Fault::ForceSensor.code());
        loop {
            run += 1;
            match self.link.start(Start {
                run,
                ..Start::ENDLESS
            }) {
                Ok(()) => return,
                // It has not rested for long enough yet.
                Err(SerialError::Link(LinkError::Refused { refusal, .. }))
                    if refusal == refused && run < 20 =>
                {
                    std::thread::sleep(Duration::from_millis(300));
                }
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// Hears until a fault has latched, and what comes after it.
    pub(crate) fn until_a_fault(&mut self) {
        while self.fault.is_none() {
            self.until(1);
        }
        self.link.stream(1, 1).expect("answers");
    }

    /// The virtual port after so many ticks more.
    pub(crate) fn until(&mut self, ticks: u32) -> Port {
        let (mut heard, mut port) = (0, Port::default());
        while heard < ticks {
            match self.link.hear(testkit::PATIENCE) {
                Some(DeviceMessage::Sample(sample)) => {
                    heard += 1;
                    port = Port {
                        position_m: sample.axes[0].position_m.into(),
                        force_n: sample.axes[0].force_n.into(),
                    };
                }
                Some(DeviceMessage::Fault(report)) => {
                    self.fault = Fault::from_code(report.status.fault);
                }
                Some(DeviceMessage::Over(error)) => panic!("{error}"),
                Some(DeviceMessage::Event(_)) => {}
                None => panic!("silent after {heard} ticks"),
            }
        }
        port
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Port {
    pub(crate) position_m: f64,
    pub(crate) force_n: f64,
}
