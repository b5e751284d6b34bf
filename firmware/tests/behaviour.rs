//! Ticks by the real timer interrupt: their period, and what happens when they take longer. What else the device promises is tried
//! from outside, by the self-test.
#![no_std]
#![no_main]

mod support;

use boards::{RETAINED, chip};
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::{entry, exception};
use haptic_board::{DeviceMemory, Shared, TickTimer, Ticker, TickerSlot, power_up};
use haptic_link::State;
use haptic_loop::Fault;
use haptic_remote::{Exclusive, Hardware as _, SimulatedPlant, prepare};

/// Ticks that still take longer than their period.
static SLOW: AtomicU32 = AtomicU32::new(0);

/// The timer of the chip, asked late in a tick that is to take long.
struct Slow(chip::Timer);

impl TickTimer for Slow {
    fn set_period_us(&mut self, period_us: u32) {
        self.0.set_period_us(period_us);
    }

    fn acknowledge(&mut self) {
        self.0.acknowledge();
    }

    fn is_pending(&self) -> bool {
        let slow = SLOW.load(Ordering::Relaxed);
        if slow > 0 {
            SLOW.store(slow - 1, Ordering::Relaxed);
            // A tick of 1 ms is 15 625 instructions of 64 ns, and this loop takes two for one asked for at most.
            cortex_m::asm::delay(20_000);
        }
        self.0.is_pending()
    }
}

static TICKER: TickerSlot<SimulatedPlant, Slow> = TickerSlot::empty();

#[exception]
fn SysTick() {
    TICKER.tick(chip::now_us);
}

fn wait(device: &Shared<SimulatedPlant>, ticks: u32) {
    let count = || device.with(|device| device.statistics().ticks);
    let end = count() + ticks;
    // Not asleep: with `-icount` and `sleep=off`, QEMU 7.2 sleeps over every other tick.
    while count() < end {}
}

fn set_period(device: &Shared<SimulatedPlant>, period_us: u32) {
    let (mut configuration, capabilities) =
        device.with(|device| (*device.configuration().0, device.hardware().capabilities()));
    configuration.tick_period_us = period_us;
    let prepared =
        prepare::<SimulatedPlant, 1>(configuration, &[0.0], &capabilities).expect("good");
    device
        .with(|device| device.install(prepared, &[0.0]))
        .expect("idle");
}

#[entry]
fn main() -> ! {
    let board = chip::start();
    let place =
        cortex_m::singleton!(: DeviceMemory<SimulatedPlant> = DeviceMemory::new()).expect("once");
    let (device, _) = power_up(place, board.hardware, [1, 2, 3], RETAINED.take()).expect("a board");
    TICKER.put(Ticker::new(device, Slow(board.timer), &RETAINED));
    let overruns = || device.with(|device| device.statistics().overruns);
    wait(device, 50);
    for period_us in [100, 10_000, 1000] {
        set_period(device, period_us);
        // The first is still of the old period, and the next may have waited for the configuration to be put in place.
        wait(device, 2);
        let (before, overran) = (chip::now_us(), overruns());
        wait(device, 20);
        let passed = chip::now_us() - before;
        let want = 20 * u64::from(period_us);
        // Looked at from a loop of some µs, between two ticks.
        assert!(
            passed.abs_diff(want) <= 30,
            "20 ticks of {period_us} us: {passed} us"
        );
        assert_eq!(overruns(), overran, "none in a steady period");
    }
    let before = overruns();
    assert!(before <= 3, "one for each change at most: {before}");

    device.with(|device| {
        device.arm(0).expect("no fault");
        // In a while.
        device.heard(1 << 62, false);
        SLOW.store(19, Ordering::Relaxed);
    });
    wait(device, 30);
    assert_eq!(overruns(), before + 19, "each is counted once");
    let state = device.with(|device| device.status().state);
    assert_eq!(state, State::Armed, "19 are not 20 in a row");

    SLOW.store(20, Ordering::Relaxed);
    wait(device, 30);
    let status = device.with(|device| device.status());
    assert_eq!(
        (status.state, status.fault),
        (State::Fault, Fault::TickOverrun.code())
    );
    assert_eq!(overruns(), before + 19 + 20);
    support::pass()
}
