//! Clock, tick and serial line of the chip. As it is: Arm's MPS2 with AN386, which QEMU emulates.
//!
//! TODO: your chip in its place; its HAL does most of it. `firmware/boards/src/stm32f4` has a chip with an encoder, a
//! current amplifier, DMA and a watchdog, `firmware/examples/rp2040` one with embassy and USB.

use crate::board::{Board, disable_motor};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use haptic_board::{Clock, HostLine, NoWatchdog, TickTimer};

/// Processor clock, Hz.
const CLOCK_HZ: u32 = 25_000_000;
/// Clocks in a microsecond.
const CLOCKS_PER_US: u32 = CLOCK_HZ / 1_000_000;

/// All that `main` needs of the chip. TODO: `NoWatchdog` is for emulators; yours stops the motor when the program hangs.
pub type Parts = haptic_board::Parts<Board, Timer, Uart, NoWatchdog>;

/// Starts the chip. To be called once.
///
/// # Panics
/// The second time.
pub fn start() -> Parts {
    let core = cortex_m::Peripherals::take().expect("the chip is started once");
    Register::Prescale.write(CLOCKS_PER_US - 1);
    Parts {
        hardware: Board::new(now_us),
        timer: Timer(core.SYST),
        line: Uart::start(),
        watchdog: NoWatchdog,
    }
}

/// The end after a fault in the program: no force first, then anew.
pub fn give_up() -> ! {
    disable_motor();
    SCB::sys_reset()
}

static CLOCK: Clock = Clock::new();

/// Time since power-up, µs. TODO: a free-running counter of microseconds, 32 bits.
pub fn now_us() -> u64 {
    CLOCK.now_us(|| Register::Counter.read())
}

/// Makes the ticks. TODO: any timer with an interrupt; `SysTick` is in every Cortex-M.
pub struct Timer(SYST);

impl TickTimer for Timer {
    fn acknowledge(&mut self) {
        // Entering the handler has done it. Other timers have a flag to clear.
    }

    fn is_pending(&self) -> bool {
        SCB::is_pendst_pending()
    }

    fn set_period_us(&mut self, period_us: u32) {
        let Self(timer) = self;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(period_us * CLOCKS_PER_US - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
    }
}

/// The line to the host: UART0, without interrupts. QEMU loses nothing.
///
/// TODO: a chip does: a byte comes every 10.9 µs at 921 600 baud, and a tick takes longer. Receive by interrupt or DMA
/// into a `haptic_board::Queue<512>`, send from another one.
#[derive(Debug)]
pub struct Uart(());

impl Uart {
    fn start() -> Self {
        // 25 MHz / 921 600 = 27.
        Register::UartDivider.write(27);
        Register::UartControl.write(0b11);
        Self(())
    }
}

impl HostLine for Uart {
    fn receive(&mut self) -> Option<u8> {
        const FULL: u32 = 1 << 1;
        (Register::UartState.read() & FULL != 0).then(|| Register::UartData.read() as u8)
    }

    fn take_lost(&mut self) -> u32 {
        0
    }

    fn room(&self) -> usize {
        usize::MAX
    }

    fn send(&mut self, bytes: &[u8]) {
        const FULL: u32 = 1 << 0;
        for &byte in bytes {
            while Register::UartState.read() & FULL != 0 {}
            Register::UartData.write(u32::from(byte));
        }
    }
}

/// Registers of this chip, by address. TODO: your HAL names them, and needs none of this.
#[derive(Clone, Copy)]
#[repr(usize)]
enum Register {
    UartData = 0x4000_4000,
    UartState = 0x4000_4004,
    UartControl = 0x4000_4008,
    UartDivider = 0x4000_4010,
    Counter = 0x4002_8018,
    Prescale = 0x4002_801C,
}

impl Register {
    fn read(self) -> u32 {
        // SAFETY: AN386 has a register at each of these addresses; none of them touches memory.
        unsafe { (self as usize as *const u32).read_volatile() }
    }

    fn write(self, value: u32) {
        // SAFETY: as above.
        unsafe { (self as usize as *mut u32).write_volatile(value) }
    }
}
