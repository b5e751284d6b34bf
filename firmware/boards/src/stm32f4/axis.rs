//! Encoder, current amplifier and emergency stop.

use crate::board::nucleo_f446re::{
    AMPERES_PER_COUNT, COUNT_ZERO, CURRENT_MAX_A, DUTY_SPAN, DUTY_ZERO, METRES_PER_COUNT,
    MISMATCH_A, MISMATCH_US, NAME, NEWTONS_PER_AMPERE,
};
use cortex_m::peripheral::DWT;
use haptic_board::haptic_link::{Capabilities, SerialNumber};
use haptic_board::haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_board::haptic_remote::{Hardware, abilities};
use haptic_board::nalgebra::SVector;
use stm32f4xx_hal::adc::Adc;
use stm32f4xx_hal::gpio::{Input, Output, PC7, PC8};
use stm32f4xx_hal::pac::{ADC1, TIM1, TIM2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::qei::Qei;
use stm32f4xx_hal::timer::PwmChannel;

/// One axis. The amplifier is enabled by the first force of a run and disabled whenever none may act.
///
/// - *Sign*: a positive current pushes towards positive positions; swap A and B, or the motor, if not.
/// - *Zero*: the position is zero where the device was switched on.
/// - *Cut*: an open emergency stop and a current that does not follow disable the amplifier at once, in
///   hardware's time and not at the rate limit, until the next run begins.
pub struct Axis {
    encoder: Qei<TIM2>,
    command: PwmChannel<TIM1, 0>,
    enable: PC8<Output>,
    stop: PC7<Input>,
    monitor: Adc<ADC1>,
    tick: u64,
    commanded_a: f32,
    mismatched: u32,
    /// Ticks that the current may be off its command.
    patience: u32,
    cut: bool,
    stopped: bool,
}

impl core::fmt::Debug for Axis {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Axis")
            .field("tick", &self.tick)
            .field("cut", &self.cut)
            .finish_non_exhaustive()
    }
}

impl Axis {
    /// Axis at power-up: no force has been asked for yet, so none may act.
    pub(super) const fn new(
        encoder: Qei<TIM2>,
        command: PwmChannel<TIM1, 0>,
        enable: PC8<Output>,
        stop: PC7<Input>,
        monitor: Adc<ADC1>,
    ) -> Self {
        Self {
            encoder,
            command,
            enable,
            stop,
            monitor,
            tick: 0,
            commanded_a: 0.0,
            mismatched: 0,
            patience: 1,
            cut: true,
            stopped: false,
        }
    }

    /// No current, and an amplifier that could make none.
    fn neutral(&mut self) {
        self.enable.set_low();
        self.command(0.0);
    }

    fn command(&mut self, amperes: f32) {
        self.commanded_a = amperes.clamp(-CURRENT_MAX_A, CURRENT_MAX_A);
        let duty = DUTY_ZERO + DUTY_SPAN * self.commanded_a / CURRENT_MAX_A;
        let steps = f32::from(self.command.get_max_duty());
        self.command.set_duty((duty * steps + 0.5) as u16);
    }

    fn cut(&mut self, fault: Fault) -> Fault {
        self.cut = true;
        self.neutral();
        fault
    }

    /// A new fault of the axis, told once, so that a loop that lets its force fall goes on.
    fn check(&mut self) -> Result<(), Fault> {
        let was_stopped = core::mem::replace(&mut self.stopped, self.stop.is_high());
        if self.stopped && !was_stopped {
            return Err(self.cut(Fault::EmergencyStop));
        }
        // The conversion was started when the current was commanded, a tick ago.
        let count = f32::from(self.monitor.current_sample());
        let measured = (count - COUNT_ZERO) * AMPERES_PER_COUNT;
        let follows = (measured - self.commanded_a).abs() <= MISMATCH_A;
        self.mismatched = if follows {
            0
        } else {
            self.mismatched.saturating_add(1)
        };
        if self.mismatched == self.patience {
            return Err(self.cut(Fault::CurrentMismatch));
        }
        Ok(())
    }

    fn reading(&mut self) -> Reading<f32, 1> {
        // Two's complement: the counter starts at zero and wraps at 2³².
        let count = self.encoder.count() as i32;
        self.tick += 1;
        Reading {
            tick: self.tick - 1,
            time_s: super::now_us() as f64 * 1e-6,
            position_m: SVector::from([count as f32 * METRES_PER_COUNT]),
        }
    }
}

impl Device<f32, 1> for Axis {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.check()?;
        Ok(self.reading())
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        if self.cut {
            self.neutral();
        } else {
            self.command(force.newtons()[0] / NEWTONS_PER_AMPERE);
            self.enable.set_high();
        }
        self.monitor.start_conversion();
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
            force_max_n: CURRENT_MAX_A * NEWTONS_PER_AMPERE,
            // The whole range in a tick of 1 ms; an amplifier's own limit is far above.
            force_rate_max_n_per_s: 2000.0 * CURRENT_MAX_A * NEWTONS_PER_AMPERE,
            position_resolution_m: METRES_PER_COUNT,
            ..abilities(NAME, 1)
        }
    }

    fn serial_number(&self) -> SerialNumber {
        super::serial_number()
    }

    fn install(&mut self, (): (), tick_period_us: u32) {
        self.patience = MISMATCH_US / tick_period_us;
    }

    fn restart(&mut self) {
        self.tick = 0;
        self.mismatched = 0;
        self.cut = self.stopped;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.neutral();
        // Nothing is commanded, so only the emergency stop can be wrong.
        self.mismatched = 0;
        self.monitor.start_conversion();
        self.read()
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.stop.is_high().then_some(Fault::EmergencyStop)
    }

    fn cycles(&self) -> u32 {
        DWT::cycle_count()
    }
}
