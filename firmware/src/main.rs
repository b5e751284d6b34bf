//! The device: starts the board, wires its interrupts, serves the host.
#![no_std]
#![no_main]

use boards::{Parts, Retained, Shared, Ticker, chip, serve};
use core::cell::RefCell;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use critical_section::Mutex;
use haptic_loop::Fault;
use haptic_remote::{DeviceSession, Exclusive as _, TickSide};

/// Major, minor, patch.
const VERSION: [u8; 3] = [0, 1, 0];

/// The image's identity: a mark, the board's name in 16 bytes, the version. `host-cli device flash` reads it
/// and compares it with the device that answers afterwards.
static IDENTITY: [u8; 39] = {
    const MARK: [u8; 20] = *b"haptic-device image\0";
    let board = haptic_link::Capabilities::board_name(chip::NAME);
    let mut identity = [0; 39];
    let (mark, rest) = identity.split_at_mut(MARK.len());
    mark.copy_from_slice(&MARK);
    let (name, version) = rest.split_at_mut(board.len());
    name.copy_from_slice(&board);
    version.copy_from_slice(&VERSION);
    identity
};

static TICKER: Mutex<RefCell<Option<Ticker<chip::Board, chip::Timer>>>> =
    Mutex::new(RefCell::new(None));

#[entry]
fn main() -> ! {
    static mut DEVICE: MaybeUninit<Shared<chip::Board>> = MaybeUninit::uninit();
    static mut SESSION: MaybeUninit<DeviceSession> = MaybeUninit::uninit();

    let Parts {
        hardware,
        timer,
        mut line,
        mut watchdog,
    } = chip::start();
    let retained = Retained::take();
    // Kept in the image though nothing here reads it.
    core::hint::black_box(&IDENTITY);
    let device = power_up(DEVICE, hardware, retained);
    critical_section::with(|token| {
        TICKER
            .borrow_ref_mut(token)
            .replace(Ticker::new(device, timer));
    });
    chip::enable_interrupts();
    let session = SESSION.write(DeviceSession::new(VERSION, retained.boot));
    serve(device, session, &mut line, &mut watchdog)
}

/// Makes the device in its place. On its own, so that what it needs of the stack is free again; and here, as it needs three
/// times as much where it is compiled for size.
#[inline(never)]
fn power_up(
    place: &'static mut MaybeUninit<Shared<chip::Board>>,
    hardware: chip::Board,
    retained: Retained,
) -> &'static Shared<chip::Board> {
    let Ok(passive) = TickSide::passive(&hardware) else {
        chip::give_up();
    };
    let device = place.write(Shared::new(TickSide::with(hardware, passive)));
    if retained.was_armed {
        device.with(|device| device.trip(Fault::Reset));
    }
    device
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

#[cfg(feature = "board-nucleo-f446re")]
mod wiring {
    use super::chip::{self, interrupt};

    #[interrupt]
    fn TIM7() {
        super::tick();
    }

    #[interrupt]
    fn USART2() {
        chip::on_uart();
    }

    #[interrupt]
    fn DMA1_STREAM5() {
        chip::on_round();
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
