//! USART2: received by a circular DMA, sent by interrupts.
//!
//! A byte comes every 10.9 µs and the USART holds one: a tick may take longer, so only DMA loses none.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use critical_section::Mutex;
use haptic_board::{HostLine, Queue};
use stm32f4xx_hal::pac::{DMA1, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Rx, Tx};

/// Received bytes that wait to be fetched at most: 1024 at 91 837 B/s are 11 ms, longer than any tick.
const RECEIVED: usize = 1024;
/// Bytes that wait to be sent at most.
const TO_SEND_MAX: usize = 512;
/// DMA1 stream 5, channel 4: `USART2_RX` (RM0390, table 28).
const STREAM: usize = 5;
const CHANNEL: u8 = 4;

/// Written by the DMA, read by the main loop.
static RING: [AtomicU8; RECEIVED] = [const { AtomicU8::new(0) }; RECEIVED];
/// Times that the DMA went round.
static ROUNDS: AtomicU32 = AtomicU32::new(0);

struct Sender {
    tx: Option<Tx<USART2>>,
    rx: Option<Rx<USART2>>,
}

static TO_SEND: Queue<TO_SEND_MAX> = Queue::new();

static SENDER: Mutex<RefCell<Sender>> = Mutex::new(RefCell::new(Sender { tx: None, rx: None }));

fn with<R>(user: impl FnOnce(&mut Sender) -> R) -> R {
    critical_section::with(|token| user(&mut SENDER.borrow_ref_mut(token)))
}

/// Handler to be called by the interrupt `USART2`: a byte has gone, or the host fell silent.
pub fn on_uart() {
    with(|Sender { tx, rx }| {
        if let Some(rx) = rx
            && rx.is_idle()
        {
            // It has woken the main loop, which is all it is for. Clearing the flag by hand means reading DR,
            // which could take a byte from the DMA; the DMA's own next reading clears it as well.
            rx.unlisten_idle();
        }
        let Some(tx) = tx else { return };
        // If there is no room now, the interrupt comes again.
        if !TO_SEND.offer(|byte| tx.write(byte).is_ok()) {
            tx.unlisten();
        }
    });
}

/// Handler to be called by the interrupt `DMA1_STREAM5`: the ring is full once more.
pub fn on_round() {
    critical_section::with(|_| count_round(dma()));
}

fn dma() -> &'static stm32f4xx_hal::pac::dma1::RegisterBlock {
    #[expect(unsafe_code, reason = "the HAL has no circular reception")]
    // SAFETY: only this module uses DMA1, whose streams the HAL has given away unused.
    unsafe {
        &*DMA1::ptr()
    }
}

/// Counts a round if there was one. Inside a critical section.
fn count_round(dma: &stm32f4xx_hal::pac::dma1::RegisterBlock) {
    if dma.hisr().read().tcif5().bit_is_set() {
        dma.hifcr().write(|w| w.ctcif5().set_bit());
        // Only here, inside a critical section.
        ROUNDS.store(
            ROUNDS.load(Ordering::Relaxed).wrapping_add(1),
            Ordering::Relaxed,
        );
    }
}

/// Bytes received since the start, modulo 2³².
fn received() -> u32 {
    critical_section::with(|_| {
        let dma = dma();
        let left = || u32::from(dma.st(STREAM).ndtr().read().ndt().bits());
        let before = left();
        count_round(dma);
        let mut after = left();
        if after > before {
            // It went round in between: count that too, and look once more.
            count_round(dma);
            after = left();
        }
        let rounds = ROUNDS.load(Ordering::Relaxed);
        rounds
            .wrapping_mul(RECEIVED as u32)
            .wrapping_add(RECEIVED as u32 - after)
    })
}

/// USART2 as a line to the host.
#[derive(Debug)]
pub struct Uart {
    fetched: u32,
    known: u32,
    lost: u32,
}

impl Uart {
    /// `rx` has its DMA request enabled, DMA1 its clock.
    pub(super) fn start(tx: Tx<USART2>, mut rx: Rx<USART2>) -> Self {
        let stream = dma().st(STREAM);
        stream.cr().modify(|_, w| w.en().clear_bit());
        while stream.cr().read().en().bit_is_set() {}
        #[expect(unsafe_code, reason = "the HAL has no circular reception")]
        // SAFETY: the DMA writes bytes into RING, which lives for ever, has this length, and is atomic.
        unsafe {
            let source = (*USART2::ptr()).dr().as_ptr();
            stream.par().write(|w| w.pa().bits(source as u32));
            stream.m0ar().write(|w| w.m0a().bits(RING.as_ptr() as u32));
            stream.ndtr().write(|w| w.ndt().bits(RECEIVED as u16));
            stream.cr().write(|w| {
                w.chsel().bits(CHANNEL);
                w.minc().set_bit().circ().set_bit().tcie().set_bit()
            });
        }
        stream.cr().modify(|_, w| w.en().set_bit());
        rx.listen_idle();
        with(|sender| {
            sender.tx = Some(tx);
            sender.rx = Some(rx);
        });
        Self {
            fetched: 0,
            known: 0,
            lost: 0,
        }
    }
}

impl HostLine for Uart {
    fn receive(&mut self) -> Option<u8> {
        if self.fetched == self.known {
            self.known = received();
            if self.known != self.fetched {
                with(|sender| {
                    if let Some(rx) = &mut sender.rx {
                        rx.listen_idle();
                    }
                });
            }
            let waiting = self.known.wrapping_sub(self.fetched);
            if let Some(lost) = waiting.checked_sub(RECEIVED as u32) {
                // The oldest were overwritten.
                self.lost = self.lost.wrapping_add(lost);
                self.fetched = self.fetched.wrapping_add(lost);
            }
        }
        if self.fetched == self.known {
            return None;
        }
        let byte = RING[self.fetched as usize % RECEIVED].load(Ordering::Relaxed);
        self.fetched = self.fetched.wrapping_add(1);
        Some(byte)
    }

    fn take_lost(&mut self) -> u32 {
        core::mem::take(&mut self.lost)
    }

    fn room(&self) -> usize {
        TO_SEND.room()
    }

    fn send(&mut self, bytes: &[u8]) {
        TO_SEND.extend(bytes);
        with(|Sender { tx, .. }| {
            if let Some(tx) = tx {
                tx.listen();
            }
        });
    }
}
