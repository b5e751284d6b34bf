//! Our host, as `host-cli` has it, at the port of a bridge.

use crate::bench::wall;
use haptic_link::Start;
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::{ConnectOptions, DeviceMessage, SerialLink};
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
}
