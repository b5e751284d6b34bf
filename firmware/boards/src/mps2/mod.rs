//! Arm MPS2 with AN386, as QEMU emulates it: a simulated plant, and nothing that could move.

mod register;
mod uart;
mod vectors;

pub use crate::board::mps2::NAME;
use crate::board::mps2::{CLOCKS_PER_US, FPGAIO};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use haptic_board::{Clock, NoWatchdog, TickTimer};
use haptic_remote::SimulatedPlant;
use register::Register;
pub use uart::{Uart, on_receive, on_sent};
pub use vectors::interrupt;

/// Sensor and actuator: a plant that is stepped by its ticks.
pub type Board = SimulatedPlant;
/// The timer whose interrupt is the tick.
pub type Timer = SysTick;
/// Nothing on this board can move, so nothing has to be stopped.
pub type Watchdog = NoWatchdog;
/// This board, at power-up.
pub type Parts = haptic_board::Parts<Board, Timer, Uart, Watchdog>;

/// Priority of the tick; smaller is more urgent.
const TICK_PRIORITY: u8 = 0x40;
/// Priority of the UART.
const UART_PRIORITY: u8 = 0x80;

#[expect(unsafe_code, reason = "a board names its registers")]
// SAFETY: AN386 has COUNTER here, a free-running counter; reading it has no effect.
const COUNTER: Register = unsafe { Register::at(FPGAIO + 0x18) };
#[expect(unsafe_code, reason = "a board names its registers")]
// SAFETY: AN386 has PRESCALE of COUNTER here.
const PRESCALE: Register = unsafe { Register::at(FPGAIO + 0x1C) };

static CLOCK: Clock = Clock::new();

/// Time since power-up by the counter of the FPGA, µs.
pub fn now_us() -> u64 {
    CLOCK.now_us(|| COUNTER.read())
}

/// QEMU has no cycle counter, and without its option `-icount` `SysTick` does not count instructions.
fn no_cycles() -> u32 {
    0
}

/// `SysTick`.
pub struct SysTick(pub SYST);

impl core::fmt::Debug for SysTick {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("SysTick")
    }
}

impl TickTimer for SysTick {
    fn acknowledge(&mut self) {
        // Entering the handler has done it.
    }

    fn is_pending(&self) -> bool {
        SCB::is_pendst_pending()
    }

    fn set_period_us(&mut self, period_us: u32) {
        let timer = &mut self.0;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(period_us * CLOCKS_PER_US - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
    }
}

/// Starts the board. To be called once.
///
/// # Panics
/// The second time.
pub fn start() -> Parts {
    let Some(mut core) = cortex_m::Peripherals::take() else {
        panic!("the board is started once");
    };
    // COUNTER at 25 MHz / 25 = 1 MHz.
    PRESCALE.write(CLOCKS_PER_US - 1);
    #[expect(unsafe_code, reason = "priorities decide who interrupts whom")]
    // SAFETY: no interrupt is enabled yet, and no critical section depends on priorities.
    unsafe {
        core.SCB.set_priority(SystemHandler::SysTick, TICK_PRIORITY);
        core.NVIC.set_priority(interrupt::UART0_RX, UART_PRIORITY);
        core.NVIC.set_priority(interrupt::UART0_TX, UART_PRIORITY);
    }
    Parts {
        hardware: SimulatedPlant::new(NAME, no_cycles),
        timer: SysTick(core.SYST),
        line: Uart::start(),
        watchdog: NoWatchdog,
    }
}

/// Lets the interrupts of the line come. Those of the tick come once its period is set.
pub fn enable_interrupts() {
    #[expect(unsafe_code, reason = "interrupts begin")]
    // SAFETY: everything that the handlers use is set up; no critical section is made by masking.
    unsafe {
        NVIC::unmask(interrupt::UART0_RX);
        NVIC::unmask(interrupt::UART0_TX);
    }
}

/// The end after a fault in the program: nothing here makes a force, so start anew.
pub fn give_up() -> ! {
    SCB::sys_reset()
}
