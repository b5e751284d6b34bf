//! The encoder: PIO 0 samples both channels, the DMA writes them into a ring, the tick counts.
//!
//! ```text
//! pins ─▶ PIO 0: in pins, 2 ─▶ FIFO, a word for four samples ─▶ DMA 0 ⇄ 1 ─▶ ring of bytes ─▶ tick: Quadrature
//! ```
//! A channel of the DMA ends after some number of transfers, so two of them take turns, each from the ring's beginning.
//! Source: Raspberry Pi, *RP2040 Datasheet*: 2.5 (DMA), 3 (PIO).

use crate::tick::{BYTE_US, until_tick_us};
use core::sync::atomic::AtomicU8;
use embassy_rp::gpio::Pull;
use embassy_rp::pac::DMA;
use embassy_rp::pac::dma::regs::CtrlTrig;
use embassy_rp::pac::dma::vals::DataSize;
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, PIN_2, PIN_3, PIO0};
use embassy_rp::pio::{self, FifoJoin, Pio, ShiftConfig, ShiftDirection, StateMachine};
use embassy_rp::pio_programs::clock_divider::calculate_pio_clock_divider;
use embassy_rp::{Peri, bind_interrupts};
use haptic_board::Quadrature;
use haptic_board::haptic_loop::Fault;

/// Samples of the encoder a second: as many counts a second can be followed.
const SAMPLES_PER_S: u32 = 4_000_000 / BYTE_US;
/// Time from the end of a byte to a tick that is due, µs: with the way into the tick about half a byte, so that a tick that comes some
/// microseconds sooner or later reads the same one.
const BEFORE_TICK_US: u32 = 8;
/// 25 ms of them. No tick comes that late: the watchdog is sooner.
const RING_BYTES: usize = 1024;
/// Transfers of a channel before the other takes over, 56 minutes: whole rings.
const TRANSFERS: u32 = 1 << 27;

#[repr(align(1024))]
struct Ring([AtomicU8; RING_BYTES]);

static RING: Ring = Ring([const { AtomicU8::new(0) }; RING_BYTES]);

bind_interrupts!(struct Interrupts {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
});

pub(crate) struct EncoderPins {
    pub(crate) pio: Peri<'static, PIO0>,
    pub(crate) a: Peri<'static, PIN_2>,
    pub(crate) b: Peri<'static, PIN_3>,
    /// Taken, and written to by their numbers.
    pub(crate) dma: (Peri<'static, DMA_CH0>, Peri<'static, DMA_CH1>),
}

/// Counts from where it stood when it was started. The position is up to 25 µs old, a byte of samples.
pub(crate) struct Encoder {
    machine: StateMachine<'static, PIO0, 0>,
    _dma: (Peri<'static, DMA_CH0>, Peri<'static, DMA_CH1>),
    quadrature: Quadrature,
    started: bool,
}

impl Encoder {
    /// Prepared, but not started.
    pub(crate) fn new(pins: EncoderPins) -> Self {
        let Pio {
            mut common,
            sm0: mut machine,
            ..
        } = Pio::new(pins.pio, Interrupts);
        let program = pio::program::pio_asm!("in pins, 2");
        let mut channels = [common.make_pio_pin(pins.a), common.make_pio_pin(pins.b)];
        for pin in &mut channels {
            pin.set_pull(Pull::Up);
        }
        let [a, b] = &channels;
        let mut config = pio::Config::default();
        config.use_program(&common.load_program(&program.program), &[]);
        config.set_in_pins(&[a, b]);
        config.clock_divider = calculate_pio_clock_divider(SAMPLES_PER_S);
        config.fifo_join = FifoJoin::RxOnly;
        // To the right: the oldest sample ends up lowest, of the highest byte.
        config.shift_in = ShiftConfig {
            threshold: 8,
            direction: ShiftDirection::Right,
            auto_fill: true,
        };
        machine.set_pin_dirs(pio::Direction::In, &[a, b]);
        machine.set_config(&config);
        for (channel, other) in [(1, 0), (0, 1)] {
            let registers = DMA.ch(channel);
            registers
                .read_addr()
                .write_value(machine.rx_fifo_ptr() as u32 + 3);
            registers.write_addr().write_value(ring_address());
            #[cfg(feature = "rp2040")]
            registers.trans_count().write_value(TRANSFERS);
            #[cfg(feature = "rp2350")]
            registers
                .trans_count()
                .write(|count| count.set_count(TRANSFERS));
            let mut control = CtrlTrig::default();
            control.set_treq_sel(machine.rx_treq());
            control.set_data_size(DataSize::SIZE_BYTE);
            control.set_incr_write(true);
            control.set_ring_sel(true);
            control.set_ring_size(RING_BYTES.ilog2() as u8);
            control.set_chain_to(other);
            control.set_irq_quiet(true);
            control.set_en(true);
            match channel {
                // The last one begins.
                0 => registers.ctrl_trig().write_value(control),
                _ => registers.al1_ctrl().write_value(control.0),
            }
        }
        Self {
            machine,
            _dma: pins.dma,
            quadrature: Quadrature::new(),
            started: false,
        }
    }

    /// Starts the samples: from here on they come, and are to be counted.
    pub(crate) fn start(&mut self) {
        if self.started {
            return;
        }
        self.started = true;
        while until_tick_us().rem_euclid(BYTE_US as i32) as u32 != BEFORE_TICK_US {}
        self.machine.set_enable(true);
    }

    /// The count now.
    ///
    /// # Errors
    /// Samples that were lost, or too far apart: the count is wrong from then on.
    pub(crate) fn count(&mut self) -> Result<i32, Fault> {
        // The channel whose turn it is not stands at the ring's beginning.
        let written = |channel| DMA.ch(channel).write_addr().read() - ring_address();
        let end = (written(0) + written(1)) as usize;
        self.quadrature.take_ring(&RING.0, end)?;
        if self.machine.rx().stalled() {
            Err(self.quadrature.lose(Fault::PositionJump))
        } else {
            Ok(self.quadrature.count())
        }
    }

    /// The fault since which the count is wrong.
    pub(crate) fn lost(&self) -> Option<Fault> {
        self.quadrature.lost()
    }
}

fn ring_address() -> u32 {
    (&raw const RING) as u32
}
