//! The device: starts the board, wires its interrupts, serves the host.
#![no_std]
#![no_main]

use core::cell::RefCell;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use critical_section::Mutex;
use firmware::{Parts, Retained, Shared, Ticker, chip};
use haptic_loop::Fault;
use haptic_loop::remote::{Session, TickSide};

/// Major, minor, patch.
const VERSION: [u8; 3] = [0, 1, 0];

static TICKER: Mutex<RefCell<Option<Ticker<chip::Board, chip::Timer>>>> =
    Mutex::new(RefCell::new(None));

#[entry]
fn main() -> ! {
    static mut DEVICE: MaybeUninit<Shared<chip::Board>> = MaybeUninit::uninit();
    static mut SESSION: MaybeUninit<Session> = MaybeUninit::uninit();

    let Parts {
        hardware,
        timer,
        mut line,
        mut watchdog,
    } = chip::start();
    let retained = Retained::take();
    let Ok(mut device) = TickSide::new(hardware) else {
        chip::give_up();
    };
    if retained.was_armed {
        device.trip(Fault::Reset);
    }
    let device = &*DEVICE.write(Shared::new(device));
    let session = SESSION.write(Session::new(VERSION, retained.boot));
    critical_section::with(|token| {
        TICKER.borrow_ref_mut(token).replace(Ticker::new(device, timer));
    });
    chip::enable_interrupts();
    firmware::serve(device, session, &mut line, &mut watchdog, chip::now_us)
}

fn tick() {
    critical_section::with(|token| {
        if let Some(ticker) = TICKER.borrow_ref_mut(token).as_mut() {
            ticker.tick(chip::now_us());
        }
    });
}

#[cfg(feature = "board-mps2")]
mod wiring {
    use super::chip::{self, interrupt};
    use cortex_m_rt::{exception, interrupt};

    #[exception]
    fn SysTick() {
        super::tick();
    }

    #[interrupt]
    fn UART0_RX() {
        chip::on_receive();
    }

    #[interrupt]
    fn UART0_TX() {
        chip::on_sent();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    chip::give_up()
}

#[expect(unsafe_code, reason = "the runtime wants the handler marked so")]
mod fault {
    use cortex_m_rt::{ExceptionFrame, exception};

    #[exception]
    unsafe fn HardFault(_: &ExceptionFrame) -> ! {
        crate::chip::give_up()
    }
}
