//! The device: starts the board, wires its interrupts, serves the host.
#![no_std]
#![no_main]

use boards::{RETAINED, chip, serve};
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use haptic_board::{DeviceMemory, Image, Parts, Ticker, TickerSlot, image, power_up};

// SAFETY: the linker script of `cortex-m-rt` lays the image out.
static IMAGE: Image = image!(unsafe chip::NAME, [0, 1, 0]);

static TICKER: TickerSlot<chip::Board, chip::Timer> = TickerSlot::empty();

#[entry]
fn main() -> ! {
    static mut PLACE: DeviceMemory<chip::Board> = DeviceMemory::new();

    let Parts {
        hardware,
        timer,
        mut line,
        mut watchdog,
    } = chip::start();
    let retained = RETAINED.take();
    // Compiled here, for speed: for size it needs three times as much of the stack.
    let Ok((device, session)) = power_up(PLACE, hardware, IMAGE.version(), retained) else {
        chip::give_up();
    };
    session.set_image_digest(IMAGE.digest());
    TICKER.put(Ticker::new(device, timer, &RETAINED));
    chip::enable_interrupts();
    serve(device, session, &mut line, &mut watchdog)
}

fn tick() {
    TICKER.tick(chip::now_us);
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
