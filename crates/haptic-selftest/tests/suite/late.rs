//! The self-test of a servo whose host stands still in the middle of a trial, or whose adapter goes away. In virtual time: what
//! stands still here is the device's time, not this machine's.

use crate::foreign::{Emulated, WITHOUT_STOP};
use crate::tested;
use haptic_devices::moteus::{MoteusAxis, MoteusSettings};
use haptic_document::Failure;
use haptic_emulator::NearLine;
use haptic_emulator::moteus::{EmulatedAdapter, EmulatedServo, Shaft};
use haptic_remote::serial::{DeviceTime, Line};
use haptic_selftest::{Promise, SelfTestReport};
use std::io::{self, Read, Write};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What happens in the middle of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mishap {
    /// The host says nothing for longer than the servo's watchdog waits.
    Stall,
    /// What serves the device stands still for longer than the test waits for a sample.
    Standstill,
    /// Nothing comes any more.
    Gone,
    /// The same before anything was armed.
    GoneAtRest,
}

/// A line to a servo. The mishap comes when it has driven for some ticks, as often as there are mishaps left, once a connection.
struct Troubled {
    line: NearLine<EmulatedAdapter>,
    adapter: Arc<Mutex<EmulatedAdapter>>,
    time: DeviceTime,
    mishap: Mishap,
    left: Arc<AtomicU32>,
    driven: u32,
    gone: bool,
}

impl Troubled {
    /// Ticks with a torque before it comes; without one if it comes at rest.
    const DRIVEN: u32 = 50;

    fn befalls(&mut self) {
        let mut adapter = self.adapter.lock().expect("nobody panicked with it");
        if adapter.servo.torque_nm() != 0.0 || self.mishap == Mishap::GoneAtRest {
            self.driven += 1;
        }
        if self.driven != Self::DRIVEN {
            return;
        }
        self.driven += 1;
        let took = |left: u32| left.checked_sub(1);
        if (self.left)
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, took)
            .is_err()
        {
            return;
        }
        match self.mishap {
            Mishap::Stall => {
                let now_us = self.time.now_us() + 150_000;
                adapter.servo.advance(now_us);
            }
            Mishap::Standstill => std::thread::sleep(Duration::from_secs(4)),
            Mishap::Gone | Mishap::GoneAtRest => self.gone = true,
        }
    }
}

impl Read for Troubled {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.gone {
            Err(io::ErrorKind::BrokenPipe.into())
        } else {
            self.line.read(into)
        }
    }
}

impl Write for Troubled {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.befalls();
        self.line.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.line.flush()
    }
}

impl Line for Troubled {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        self.line.share()
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        self.line.set_patience(patience)
    }
}

fn tested_with(mishap: Mishap, times: u32) -> SelfTestReport {
    let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
    let emulated = Emulated::new(EmulatedAdapter::new(servo));
    let left = Arc::new(AtomicU32::new(times));
    let connect = || {
        let line = Troubled {
            line: emulated.line(),
            adapter: Arc::clone(&emulated.device),
            time: emulated.time.clone(),
            mishap,
            left: Arc::clone(&left),
            driven: 0,
            gone: false,
        };
        let axis = MoteusAxis::open(line, MoteusSettings::DEFAULT, true);
        Ok(emulated.link(axis.map_err(Failure::input)?, "moteus:emulated"))
    };
    tested(&connect, WITHOUT_STOP, &|_| {})
}

/// Rows that were judged, each with its verdict; and those that this machine was too late for.
fn verdicts(report: &SelfTestReport) -> (Vec<(Promise, bool)>, Vec<Promise>) {
    let judged = (report.checks.iter()).filter_map(|check| Some((check.check, check.ok?)));
    let late = report.checks.iter().filter(|check| check.host_late);
    (judged.collect(), late.map(|check| check.check).collect())
}

pub(crate) fn a_host_that_was_late_once_tries_again_and_judges() {
    let report = tested_with(Mishap::Stall, 1);
    let (judged, late) = verdicts(&report);
    assert!(report.holds, "{report:#?}");
    assert!(late.is_empty() && judged.len() == 8, "{report:#?}");
}

pub(crate) fn a_host_that_is_always_late_judges_nothing_that_it_was_too_late_for() {
    let report = tested_with(Mishap::Stall, u32::MAX);
    let (judged, late) = verdicts(&report);
    assert_eq!(
        judged,
        [(Promise::Arm, true), (Promise::Reconnect, true)],
        "{report:#?}"
    );
    let never = [
        Promise::ForceLimit,
        Promise::Stop,
        Promise::Direction,
        Promise::FiniteCheck,
        Promise::Watchdog,
        Promise::FlightRecorder,
    ];
    assert_eq!(late, never, "{report:#?}");
    // Nothing is broken, and nothing is promised to hold either.
    assert!(!report.holds && report.link_lost.is_none());
    let seen = &report.checks[1].seen;
    assert!(
        seen.starts_with("not judged: servo 1 heard nothing for its watchdog time"),
        "{seen}"
    );
}

pub(crate) fn an_adapter_that_goes_away_is_a_link_that_is_lost() {
    for (mishap, arm) in [(Mishap::Gone, Some(true)), (Mishap::GoneAtRest, None)] {
        let report = tested_with(mishap, u32::MAX);
        let lost = report.link_lost.as_deref().unwrap_or_default();
        assert!(lost.starts_with("the adapter is gone: "), "{report:#?}");
        assert!(
            lost.contains("it may still push: switch its supply off"),
            "{lost}"
        );
        // What was not tried to its end is neither kept nor broken.
        assert_eq!(report.checks[0].ok, arm, "{report:#?}");
        let rest = &report.checks[1..];
        assert!(
            rest.iter()
                .all(|check| check.ok.is_none() && check.not_judged)
        );
        assert!(!report.holds);
    }
}

pub(crate) fn a_silence_of_a_device_that_answers_again_is_tried_again() {
    let report = tested_with(Mishap::Standstill, 1);
    let (judged, late) = verdicts(&report);
    assert!(report.holds, "{report:#?}");
    assert!(late.is_empty() && judged.len() == 8, "{report:#?}");
}
