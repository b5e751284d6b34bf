//! UART0, by interrupts in both directions.

use super::register::Register;
use crate::board::mps2::{UART_DIVIDER, UART0};
use haptic_board::{HostLine, Queue};

/// Bytes that wait to be fetched at most: the longest frame, twice.
const RECEIVED_MAX: usize = 512;
/// Bytes that wait to be sent at most.
const TO_SEND_MAX: usize = 512;

/// Bits of `STATE`.
const TX_FULL: u32 = 1 << 0;
const RX_FULL: u32 = 1 << 1;
const RX_OVERRUN: u32 = 1 << 3;
/// Bits of `CTRL`: both directions on, with their interrupts.
const CONTROL: u32 = 0b1111;
/// Bits of `INTCLEAR`.
const CLEAR_TX: u32 = 1 << 0;
const CLEAR_RX: u32 = 1 << 1;

#[derive(Debug)]
struct Registers {
    data: Register,
    state: Register,
    control: Register,
    clear: Register,
    divider: Register,
}

impl Registers {
    #[expect(unsafe_code, reason = "a board names its registers")]
    // SAFETY: AN386 has a CMSDK UART with these registers here; none of them touches memory.
    const UART: Self = unsafe {
        Self {
            data: Register::at(UART0),
            state: Register::at(UART0 + 0x04),
            control: Register::at(UART0 + 0x08),
            clear: Register::at(UART0 + 0x0C),
            divider: Register::at(UART0 + 0x10),
        }
    };
}

static RECEIVED: Queue<RECEIVED_MAX> = Queue::new();
static TO_SEND: Queue<TO_SEND_MAX> = Queue::new();

/// Receives; to be called by the interrupt `UART0_RX`.
pub fn on_receive() {
    let uart = Registers::UART;
    // Acknowledge first: a byte that comes between draining and acknowledging would be forgotten.
    uart.clear.write(CLEAR_RX);
    if uart.state.read() & RX_OVERRUN != 0 {
        uart.state.write(RX_OVERRUN);
        RECEIVED.count_lost(1);
    }
    while uart.state.read() & RX_FULL != 0 {
        RECEIVED.push(uart.data.read() as u8);
    }
}

/// Sends on; to be called by the interrupt `UART0_TX`.
pub fn on_sent() {
    let uart = Registers::UART;
    // Nobody else may write a byte in between.
    critical_section::with(|_| {
        uart.clear.write(CLEAR_TX);
        // The interrupt comes when the buffer has become empty, so the first byte is written unasked.
        while uart.state.read() & TX_FULL == 0
            && let Some(byte) = TO_SEND.pop()
        {
            uart.data.write(u32::from(byte));
        }
    });
}

/// UART0 as a line to the host.
#[derive(Debug)]
pub struct Uart(());

impl Uart {
    pub(super) fn start() -> Self {
        let uart = Registers::UART;
        uart.divider.write(UART_DIVIDER);
        uart.control.write(CONTROL);
        Self(())
    }
}

impl HostLine for Uart {
    fn receive(&mut self) -> Option<u8> {
        RECEIVED.pop()
    }

    fn take_lost(&mut self) -> u32 {
        RECEIVED.take_lost()
    }

    fn room(&self) -> usize {
        TO_SEND.room()
    }

    fn send(&mut self, bytes: &[u8]) {
        TO_SEND.extend(bytes);
        on_sent();
    }
}
