//! Encoder, current amplifier and emergency stop, at the pins that `README.md` lists.
//!
//! Source: Raspberry Pi, *RP2040 Datasheet*: 4.5 (PWM), 4.9 (converter).

use crate::encoder::{Encoder, EncoderPins};
use embassy_rp::Peri;
#[cfg(feature = "force-sensor")]
use embassy_rp::adc::{self, Adc, Blocking, Channel};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::pac::SIO;
#[cfg(feature = "force-sensor")]
use embassy_rp::peripherals::{ADC, PIN_26};
use embassy_rp::peripherals::{PIN_4, PIN_6, PIN_7, PWM_SLICE2};
use embassy_rp::pwm::{self, Pwm};
use haptic_board::haptic_link::{Capabilities, ControllerCost, SerialNumber};
use haptic_board::haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_board::haptic_remote::{Hardware, abilities};
use haptic_board::nalgebra::Vector1;

/// The board's name, the chip's clock, the shortest tick, the longest memory of taps.
#[cfg(feature = "rp2040")]
mod chip {
    use super::ControllerCost;

    pub(crate) const NAME: &str = "rp2040";
    pub(crate) const CLOCK_MHZ: u32 = 125;
    /// There is no floating-point unit: 200 s of full memory within 1e-6 take 23 500 cycles, a fifth of it, and up to 38 000 where the
    /// encoder turns as fast as it is followed: its counts take up to 14 500.
    pub(super) const TICK_PERIOD_MIN_US: u32 = 1000;
    /// A tick of so many takes half of the shortest period: 10 000 cycles, and 240 more for each. The rest is for counts and the line.
    pub(super) const COEFFICIENTS_MAX: u32 = (CLOCK_MHZ * TICK_PERIOD_MIN_US / 2 - 10_000) / 240;
    /// Twice what a tick takes, the rest is for counts and the line: 14 000 cycles, and 520 more for each coefficient. In `tests/pico` a
    /// PI^0.9 of 39 takes 33 000, a PI^0.9D^0.9 of 83 takes 56 250, and with the second-order rule of 159 82 125.
    pub(super) const CONTROLLER_COST: ControllerCost = ControllerCost {
        tick_us: 2 * 14_000 / CLOCK_MHZ,
        coefficient_ns: 2 * 520 * 1000 / CLOCK_MHZ,
    };
}
#[cfg(feature = "rp2350")]
mod chip {
    use super::ControllerCost;

    pub(crate) const NAME: &str = "rp2350";
    pub(crate) const CLOCK_MHZ: u32 = 150;
    pub(super) const TICK_PERIOD_MIN_US: u32 = 250;
    pub(super) const COEFFICIENTS_MAX: u32 = 256;
    /// Twice what a tick takes on a Cortex-M4F, of as many instructions: 2000 cycles, and 20 more for each coefficient.
    pub(super) const CONTROLLER_COST: ControllerCost = ControllerCost {
        tick_us: 2 * 2_000 / CLOCK_MHZ + 1,
        coefficient_ns: 2 * 20 * 1000 / CLOCK_MHZ + 1,
    };
}
pub(crate) use chip::{CLOCK_MHZ, NAME};

/// Longest tick, µs: a quarter of the watchdog's time.
const TICK_PERIOD_MAX_US: u32 = 5000;

/// Steps of the PWM: 5 kHz.
const PWM_STEPS: u16 = (CLOCK_MHZ * 200) as u16;
/// Duty at no current, part of one, and its change at the largest.
const DUTY_ZERO: f32 = 0.5;
const DUTY_SPAN: f32 = 0.4;

/// Largest current, A, as the amplifier is set.
const CURRENT_MAX_A: f32 = 2.0;
/// Force of a current, N/A: torque constant 0.02 N·m/A on a pulley of 5 mm, 0.02 / 0.005 = 4.
const NEWTONS_PER_AMPERE: f32 = 4.0;
/// Position of a count, m: 500 lines are 2000 counts a turn, 2π · 5 mm / 2000 = 15.708 µm.
const METRES_PER_COUNT: f32 = 1.570_796_3e-5;

/// Force of the load cell at 3.3 V, N; the opposite at 0 V, none in the middle.
#[cfg(feature = "force-sensor")]
const SENSED_FORCE_MAX_N: f32 = 20.0;

/// GP6, for the way out of a panic.
const ENABLE_PIN: u32 = 6;

/// Disables the amplifier, whoever has its pin.
pub(crate) fn disable_motor() {
    SIO.gpio_out(0).value_clr().write_value(1 << ENABLE_PIN);
}

pub(crate) struct Pins {
    pub(crate) encoder: EncoderPins,
    pub(crate) slice: Peri<'static, PWM_SLICE2>,
    pub(crate) command: Peri<'static, PIN_4>,
    pub(crate) enable: Peri<'static, PIN_6>,
    pub(crate) stop: Peri<'static, PIN_7>,
    #[cfg(feature = "force-sensor")]
    pub(crate) load_cell: LoadCell,
}

/// The amplifier of a load cell, at the converter.
#[cfg(feature = "force-sensor")]
pub(crate) struct LoadCell(Adc<'static, Blocking>, Channel<'static>);

#[cfg(feature = "force-sensor")]
impl LoadCell {
    pub(crate) fn new(converter: Peri<'static, ADC>, pin: Peri<'static, PIN_26>) -> Self {
        let converter = Adc::new_blocking(converter, adc::Config::default());
        Self(converter, Channel::new_pin(pin, Pull::None))
    }
}

/// One axis. The amplifier is enabled by the first force of a run and disabled whenever none may act.
///
/// - *Sign*: a positive current pushes towards positive positions; swap A and B, or the motor, if not.
/// - *Zero*: the position is zero where the device was switched on; an encoder that lost counts has lost it until the next time.
/// - *Cut*: an open emergency stop, and an encoder that was not followed, disable the amplifier at once, until the next
///   run begins.
pub(crate) struct Axis {
    /// Known only when the motor is disabled.
    pub(crate) serial_number: SerialNumber,
    encoder: Encoder,
    command: Pwm<'static>,
    duty: pwm::Config,
    enable: Output<'static>,
    stop: Input<'static>,
    tick: u64,
    stopped: bool,
    cut: bool,
    #[cfg(feature = "force-sensor")]
    load_cell: LoadCell,
}

impl Axis {
    /// Axis at power-up: no force has been asked for yet, so none may act.
    pub(crate) fn new(pins: Pins) -> Self {
        let enable = Output::new(pins.enable, Level::Low);
        let mut duty = pwm::Config::default();
        duty.top = PWM_STEPS - 1;
        duty.compare_a = steps(0.0);
        let mut axis = Self {
            serial_number: SerialNumber::NONE,
            encoder: Encoder::new(pins.encoder),
            command: Pwm::new_output_a(pins.slice, pins.command, duty.clone()),
            duty,
            enable,
            stop: Input::new(pins.stop, Pull::Up),
            tick: 0,
            stopped: false,
            cut: true,
            #[cfg(feature = "force-sensor")]
            load_cell: pins.load_cell,
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
}

/// Steps of the PWM at a current, in as few operations as a chip without floating-point unit likes.
fn steps(amperes: f32) -> u16 {
    const ZERO: f32 = DUTY_ZERO * PWM_STEPS as f32 + 0.5;
    const AN_AMPERE: f32 = DUTY_SPAN * PWM_STEPS as f32 / CURRENT_MAX_A;
    (ZERO + AN_AMPERE * amperes.clamp(-CURRENT_MAX_A, CURRENT_MAX_A)) as u16
}

impl Device<f32, 1> for Axis {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let was_stopped = core::mem::replace(&mut self.stopped, self.stop.is_high());
        let counted = self.encoder.count();
        if self.stopped && !was_stopped {
            return Err(self.cut(Fault::EmergencyStop));
        }
        let count = match counted {
            Ok(count) => count,
            Err(fault) => return Err(self.cut(fault)),
        };
        let tick = self.tick;
        self.tick += 1;
        Ok(Reading {
            tick,
            // The tick that asks has its time already; a double costs this chip 700 cycles.
            time_s: 0.0,
            position_m: Vector1::new(count as f32 * METRES_PER_COUNT),
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
            tick_period_min_us: chip::TICK_PERIOD_MIN_US,
            tick_period_max_us: TICK_PERIOD_MAX_US,
            force_max_n: CURRENT_MAX_A * NEWTONS_PER_AMPERE,
            // The whole range in a tick of 1 ms; an amplifier's own limit is far above.
            force_rate_max_n_per_s: 2000.0 * CURRENT_MAX_A * NEWTONS_PER_AMPERE,
            position_resolution_m: METRES_PER_COUNT,
            coefficients_max: chip::COEFFICIENTS_MAX as u16,
            #[cfg(feature = "force-sensor")]
            sensed_force_max_n: SENSED_FORCE_MAX_N,
            ..abilities(NAME, 1)
        }
    }

    fn serial_number(&self) -> SerialNumber {
        self.serial_number
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        Some(chip::CONTROLLER_COST)
    }

    fn install(&mut self, (): (), _: u32) {
        // Only now, as ticks fetch the samples from here on.
        self.encoder.start();
    }

    /// A conversion takes 2 µs.
    #[cfg(feature = "force-sensor")]
    fn sense(&mut self) -> [f32; 1] {
        const A_COUNT_N: f32 = SENSED_FORCE_MAX_N / 2048.0;
        let LoadCell(converter, channel) = &mut self.load_cell;
        let counts = converter.blocking_read(channel);
        [counts.map_or(f32::NAN, |counts| {
            A_COUNT_N * f32::from(counts) - SENSED_FORCE_MAX_N
        })]
    }

    fn restart(&mut self) {
        self.tick = 0;
        self.cut = self.stopped;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.neutral();
        self.read()
    }

    /// Cycles in steps of a microsecond.
    fn cycles(&self) -> u32 {
        crate::tick::counter_us().wrapping_mul(CLOCK_MHZ)
    }

    fn persisting_fault(&self) -> Option<Fault> {
        let stopped = self.stop.is_high().then_some(Fault::EmergencyStop);
        self.encoder.lost().or(stopped)
    }
}
