//! The device half on positions that another board has read: compiled by the target and by the host, for the same bits.

use super::listed::{capabilities, shape};
use super::lists::List;
use crc::{CRC_32_ISO_HDLC, Crc};
use haptic_link::{Capabilities, Configuration, Limits, Start};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{Hardware, TickSide, prepare};
use nalgebra::SVector;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A board without motor, which reads what it is given, m.
#[derive(Debug)]
struct Replay<P> {
    positions_m: P,
    next: u32,
}

impl<P: Fn(u32) -> f32> Device<f32, 1> for Replay<P> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let tick = self.next;
        self.next += 1;
        Ok(Reading {
            tick: u64::from(tick),
            time_s: 0.0,
            position_m: SVector::from([(self.positions_m)(tick)]),
        })
    }

    fn write(&mut self, _: SafeForce<f32, 1>) -> Result<(), Fault> {
        Ok(())
    }

    fn let_go(&mut self) {}
}

impl<P: Fn(u32) -> f32> Hardware for Replay<P> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        capabilities("replay")
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        self.next = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.next = 0;
        let reading = self.read();
        self.next = 0;
        reading
    }
}

/// A spring and this operator, behind the whole chain.
pub(crate) fn configuration(list: &List) -> Configuration {
    Configuration {
        stiffness_n_per_m: 200.0,
        dissipation_n_s_mu_per_m: 5.0,
        order: 0.2247,
        operator: shape(list),
        limits: Limits {
            force_n: 8.0,
            watchdog_ms: 1000,
            late_ticks: 0,
            ..Limits::DEFAULT
        },
        ..Configuration::PASSIVE
    }
}

/// Tells the force of each tick of a run on these positions, and gives the CRC-32 over all, little-endian.
pub(crate) fn forces<P: Fn(u32) -> f32>(
    list: &List,
    ticks: u32,
    positions_m: P,
    mut tell: impl FnMut(u32, f32),
) -> u32 {
    let (values, count) = list.values();
    let values = &values[..count];
    let replay = Replay {
        positions_m,
        next: 0,
    };
    let capabilities = replay.capabilities();
    let mut device = TickSide::new(replay).expect("a board");
    let prepared =
        prepare::<Replay<P>, 1>(configuration(list), values, &capabilities).expect("good");
    device.install(prepared, values).expect("idle");
    device.arm(0).expect("nothing is wrong");
    let start = Start {
        ticks,
        ..Start::ENDLESS
    };
    device.start(start).expect("armed");
    let mut digest = CRC.digest();
    for tick in 0..ticks {
        let now_us = 1000 * u64::from(tick + 1);
        device.heard(now_us, false);
        device.tick(now_us);
        while device.next_report().is_some() {}
        let force = device.newest().force_n[0];
        digest.update(&force.to_le_bytes());
        tell(tick, force);
    }
    digest.finalize()
}
