//! UART0, by interrupts in both directions.

use super::register::Register;
use crate::board::mps2::{UART_DIVIDER, UART0};
use crate::parts::Line;
use core::cell::RefCell;
use critical_section::Mutex;
use heapless::Deque;

/// Bytes that wait to be fetched at most: the longest frame, twice.
const RECEIVED: usize = 512;
/// Bytes that wait to be sent at most.
const TO_SEND: usize = 512;

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

/// Shared by interrupts and main loop.
#[derive(Debug)]
struct Queues {
    received: Deque<u8, RECEIVED>,
    to_send: Deque<u8, TO_SEND>,
    lost: u32,
}

static QUEUES: Mutex<RefCell<Queues>> = Mutex::new(RefCell::new(Queues {
    received: Deque::new(),
    to_send: Deque::new(),
    lost: 0,
}));

fn with<R>(user: impl FnOnce(&mut Queues, &Registers) -> R) -> R {
    critical_section::with(|token| user(&mut QUEUES.borrow_ref_mut(token), &Registers::UART))
}

impl Queues {
    fn fetch(&mut self, uart: &Registers) {
        // Acknowledge first: a byte that comes between draining and acknowledging would be forgotten.
        uart.clear.write(CLEAR_RX);
        let state = uart.state.read();
        if state & RX_OVERRUN != 0 {
            uart.state.write(RX_OVERRUN);
            self.lost = self.lost.wrapping_add(1);
        }
        while uart.state.read() & RX_FULL != 0 {
            let byte = uart.data.read() as u8;
            if self.received.push_back(byte).is_err() {
                self.lost = self.lost.wrapping_add(1);
            }
        }
    }

    fn give(&mut self, uart: &Registers) {
        uart.clear.write(CLEAR_TX);
        // The interrupt comes when the buffer has become empty, so the first byte is written unasked.
        while uart.state.read() & TX_FULL == 0
            && let Some(byte) = self.to_send.pop_front()
        {
            uart.data.write(u32::from(byte));
        }
    }
}

/// To be called by the interrupt `UART0_RX`.
pub fn on_receive() {
    with(Queues::fetch);
}

/// To be called by the interrupt `UART0_TX`.
pub fn on_sent() {
    with(Queues::give);
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

impl Line for Uart {
    fn receive(&mut self) -> Option<u8> {
        with(|queues, _| queues.received.pop_front())
    }

    fn take_lost(&mut self) -> u32 {
        with(|queues, _| core::mem::take(&mut queues.lost))
    }

    fn room(&self) -> usize {
        with(|queues, _| TO_SEND - queues.to_send.len())
    }

    fn send(&mut self, bytes: &[u8]) {
        // Piece by piece, so that a tick waits for no more than a few bytes.
        for piece in bytes.chunks(16) {
            with(|queues, uart| {
                for &byte in piece {
                    // There is room, the caller has looked.
                    let _ = queues.to_send.push_back(byte);
                }
                queues.give(uart);
            });
        }
    }
}
