//! Encoder, current amplifier and emergency stop.
//!
//! ```text
//! signal            pin          note
//! encoder A, B      GP2, GP3     sampled by PIO 0, 64 000 times a second
//! current command   GP4          PWM 5 kHz: 10 % is the largest negative current, 50 % none, 90 % the largest positive
//! amplifier enable  GP6          high enables; 10 kΩ to ground, as the pin floats while the chip is in reset
//! emergency stop    GP7          normally closed contact to ground; open is stop
//! ```
//! Source: Raspberry Pi, *RP2040 Datasheet*: 3 (PIO), 4.5 (PWM).

use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::pac::SIO;
use embassy_rp::peripherals::{PIN_2, PIN_3, PIN_4, PIN_6, PIN_7, PIO0, PWM_SLICE2};
use embassy_rp::pio::{self, FifoJoin, Pio, ShiftConfig, ShiftDirection, StateMachine};
use embassy_rp::pio_programs::clock_divider::calculate_pio_clock_divider;
use embassy_rp::pwm::{self, Pwm};
use embassy_rp::{Peri, bind_interrupts};
use haptic_board::Quadrature;
use haptic_board::haptic_link::{Capabilities, Refusal, Simulation};
use haptic_board::haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_board::haptic_remote::{Hardware, abilities, only_real};
use haptic_board::nalgebra::Vector1;

pub(crate) const NAME: &str = "rp2040";

/// Samples of the encoder a second: as many counts a second can be followed. A word has 16 of them, the queue 8 words, so
/// 2 ms.
const SAMPLES_PER_S: u32 = 64_000;
const SAMPLES_PER_WORD: u32 = 16;
/// Longest tick, µs, before samples are lost, with a quarter of the queue in reserve.
const TICK_PERIOD_MAX_US: u32 = 1500;
/// Shortest: this processor has no floating point.
const TICK_PERIOD_MIN_US: u32 = 1000;

/// Steps of the PWM: 125 MHz / 25 000 = 5 kHz.
const PWM_STEPS: u16 = 25_000;
/// Duty at no current, part of one, and its change at the largest.
const DUTY_ZERO: f32 = 0.5;
const DUTY_SPAN: f32 = 0.4;

/// Largest current, A, as the amplifier is set.
const CURRENT_MAX_A: f32 = 2.0;
/// Force of a current, N/A: torque constant 0.02 N·m/A on a pulley of 5 mm, 0.02 / 0.005 = 4.
const NEWTONS_PER_AMPERE: f32 = 4.0;
/// Position of a count, m: 500 lines are 2000 counts a turn, 2π · 5 mm / 2000 = 15.708 µm.
const METRES_PER_COUNT: f32 = 1.570_796_3e-5;

/// GP6, for the way out of a panic.
const ENABLE_PIN: u32 = 6;

bind_interrupts!(struct Interrupts {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
});

/// Disables the amplifier, whoever has its pin.
pub(crate) fn disable_motor() {
    SIO.gpio_out(0).value_clr().write_value(1 << ENABLE_PIN);
}

pub(crate) struct Pins {
    pub(crate) pio: Peri<'static, PIO0>,
    pub(crate) a: Peri<'static, PIN_2>,
    pub(crate) b: Peri<'static, PIN_3>,
    pub(crate) slice: Peri<'static, PWM_SLICE2>,
    pub(crate) command: Peri<'static, PIN_4>,
    pub(crate) enable: Peri<'static, PIN_6>,
    pub(crate) stop: Peri<'static, PIN_7>,
}

/// One axis. The amplifier is enabled by the first force of a run and disabled whenever none may act.
///
/// - *Sign*: a positive current pushes towards positive positions; swap A and B, or the motor, if not.
/// - *Zero*: the position is zero where the device was switched on. It is up to 0.25 ms old, as a word of samples
///   comes when it is full.
/// - *Cut*: an open emergency stop, and an encoder that was not followed, disable the amplifier at once, until the next
///   run begins.
pub(crate) struct Axis {
    samples: StateMachine<'static, PIO0, 0>,
    encoder: Quadrature,
    command: Pwm<'static>,
    duty: pwm::Config,
    enable: Output<'static>,
    stop: Input<'static>,
    tick: u64,
    stopped: bool,
    cut: bool,
}

impl Axis {
    /// At power-up: no force has been asked for yet, so none may act.
    pub(crate) fn new(pins: Pins) -> Self {
        let enable = Output::new(pins.enable, Level::Low);
        let mut duty = pwm::Config::default();
        duty.top = PWM_STEPS - 1;
        duty.compare_a = steps(0.0);
        let mut axis = Self {
            samples: sampled(pins.pio, pins.a, pins.b),
            encoder: Quadrature::new(),
            command: Pwm::new_output_a(pins.slice, pins.command, duty.clone()),
            duty,
            enable,
            stop: Input::new(pins.stop, Pull::Up),
            tick: 0,
            stopped: false,
            cut: true,
        };
        axis.neutral();
        axis
    }

    /// No current, and an amplifier that could make none.
    fn neutral(&mut self) {
        self.enable.set_low();
        self.command(0.0);
    }

    fn command(&mut self, amperes: f32) {
        self.duty.compare_a = steps(amperes);
        self.command.set_config(&self.duty);
    }

    fn cut(&mut self, fault: Fault) -> Fault {
        self.cut = true;
        self.neutral();
        fault
    }

    /// Counts what has come since the last tick.
    fn count(&mut self) -> Result<(), Fault> {
        let mut followed = Ok(());
        while let Some(word) = self.samples.rx().try_pull() {
            followed = followed.and(self.encoder.take(word, SAMPLES_PER_WORD));
        }
        // Samples that found no room are motion that nobody has seen.
        if self.samples.rx().stalled() {
            followed = Err(Fault::PositionJump);
        }
        followed
    }
}

/// Steps of the PWM at a current.
fn steps(amperes: f32) -> u16 {
    let share = amperes.clamp(-CURRENT_MAX_A, CURRENT_MAX_A) / CURRENT_MAX_A;
    ((DUTY_ZERO + DUTY_SPAN * share) * f32::from(PWM_STEPS) + 0.5) as u16
}

/// PIO 0 samples both channels: one instruction, for ever.
fn sampled(
    pio: Peri<'static, PIO0>,
    a: Peri<'static, PIN_2>,
    b: Peri<'static, PIN_3>,
) -> StateMachine<'static, PIO0, 0> {
    let Pio {
        mut common,
        sm0: mut machine,
        ..
    } = Pio::new(pio, Interrupts);
    let program = pio::program::pio_asm!("in pins, 2");
    let mut pins = [common.make_pio_pin(a), common.make_pio_pin(b)];
    for pin in &mut pins {
        pin.set_pull(Pull::Up);
    }
    let [a, b] = &pins;
    let mut config = pio::Config::default();
    config.use_program(&common.load_program(&program.program), &[]);
    config.set_in_pins(&[a, b]);
    config.clock_divider = calculate_pio_clock_divider(SAMPLES_PER_S);
    config.fifo_join = FifoJoin::RxOnly;
    // To the right: the oldest sample ends up lowest.
    config.shift_in = ShiftConfig {
        threshold: 2 * SAMPLES_PER_WORD as u8,
        direction: ShiftDirection::Right,
        auto_fill: true,
    };
    machine.set_pin_dirs(pio::Direction::In, &[a, b]);
    machine.set_config(&config);
    machine
}

impl Device<f32, 1> for Axis {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let was_stopped = core::mem::replace(&mut self.stopped, self.stop.is_high());
        let followed = self.count();
        if self.stopped && !was_stopped {
            return Err(self.cut(Fault::EmergencyStop));
        }
        if let Err(fault) = followed {
            return Err(self.cut(fault));
        }
        let tick = self.tick;
        self.tick += 1;
        Ok(Reading {
            tick,
            time_s: crate::tick::now_us() as f64 * 1e-6,
            position_m: Vector1::new(self.encoder.count() as f32 * METRES_PER_COUNT),
        })
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        if self.cut {
            self.neutral();
        } else {
            self.command(force.newtons()[0] / NEWTONS_PER_AMPERE);
            self.enable.set_high();
        }
        Ok(())
    }

    fn let_go(&mut self) {
        self.neutral();
    }
}

impl Hardware for Axis {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            tick_period_min_us: TICK_PERIOD_MIN_US,
            tick_period_max_us: TICK_PERIOD_MAX_US,
            force_max_n: CURRENT_MAX_A * NEWTONS_PER_AMPERE,
            // The whole range in a tick of 1 ms; an amplifier's own limit is far above.
            force_rate_max_n_per_s: 2000.0 * CURRENT_MAX_A * NEWTONS_PER_AMPERE,
            position_resolution_m: METRES_PER_COUNT,
            ..abilities(NAME, 1)
        }
    }

    fn prepare(simulation: &Simulation, _: u32) -> Result<(), Refusal> {
        only_real(simulation)
    }

    fn install(&mut self, (): (), _: u32) {
        // Only now, as ticks fetch the samples from here on.
        self.samples.set_enable(true);
    }

    fn restart(&mut self) {
        self.tick = 0;
        self.cut = self.stopped;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.neutral();
        self.read()
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.stop.is_high().then_some(Fault::EmergencyStop)
    }
}
