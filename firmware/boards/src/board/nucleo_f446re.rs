//! ST NUCLEO-F446RE with one axis: encoder, current amplifier, emergency stop. **Built, not yet run on
//! hardware.**
//!
//! ```text
//! signal                  pin    connector   peripheral   note
//! encoder A               PA0    A0          TIM2 CH1     5 V tolerant
//! encoder B               PA1    A1          TIM2 CH2     5 V tolerant
//! current command         PA8    D7          TIM1 CH1     PWM 10 % to 90 %, 50 % is zero
//! amplifier enable        PC8    CN10-2      output       10 kΩ to ground: low while the chip is in reset
//! current monitor         PB0    A3          ADC1 IN8     0 V to 3.3 V, 1.65 V is zero
//! emergency stop          PC7    D9          input        normally closed to ground; open is stop
//! host, to and from       PA2, PA3           USART2       ST-Link's virtual serial port
//! ```
//! Sources: ST, *UM1724* (board), *RM0390* (chip), *DS10693* (pins).

/// Name, as the host sees it.
pub const NAME: &str = "nucleo-f446re";

/// Place of the chip's unique number, 96 bits (RM0390, 39.1).
pub(crate) const UNIQUE_NUMBER: usize = 0x1FFF_7A10;

/// Crystal of the ST-Link, Hz, fed in as a clock (UM1724, 6.7.1).
pub(crate) const HSE_HZ: u32 = 8_000_000;
/// Processor clock, Hz: 8 MHz · 180 / 8, the largest.
pub(crate) const CLOCK_HZ: u32 = 180_000_000;
/// Clock of APB1, Hz: 180 MHz / 4, the largest. Its timers run at 90 MHz.
pub(crate) const PCLK1_HZ: u32 = 45_000_000;
/// Clock of APB2, Hz: 180 MHz / 2, the largest. Its timers run at 180 MHz.
pub(crate) const PCLK2_HZ: u32 = 90_000_000;

/// Baud rate: a sample of 31 B at 1 kHz takes 310 000. Divider: 45 MHz / 921 600 = 48.83, so 49: 918 367
/// baud, −0.35 %; together with the host's side up to 3.75 % are allowed (RM0390, 25.4.5).
/// The ST-Link/V2-1 is reported to forward 1 228 800 without loss and 1 843 200 with some (ST community, 2017).
pub(crate) const BAUD: u32 = 921_600;

/// Frequency of the current command's PWM, Hz: amplifiers take 10 Hz to 5 kHz. 180 MHz / 5 kHz = 36 000
/// steps, of which 80 % are used: 28 800 from −100 % to 100 %.
pub(crate) const PWM_HZ: u32 = 5_000;
/// Duty at no current, part of one.
pub(crate) const DUTY_ZERO: f32 = 0.5;
/// Change of the duty at the largest current: 50 % ± 40 %.
pub(crate) const DUTY_SPAN: f32 = 0.4;

/// Largest current, A, as the amplifier is set.
pub(crate) const CURRENT_MAX_A: f32 = 2.0;
/// Force of a current, N/A: torque constant 0.02 N·m/A on a pulley of 5 mm, 0.02 / 0.005 = 4.
pub(crate) const NEWTONS_PER_AMPERE: f32 = 4.0;
/// Position of a count, m: 500 lines are 2000 counts a turn, 2π · 5 mm / 2000 = 15.708 µm.
pub(crate) const METRES_PER_COUNT: f32 = 1.570_796_3e-5;

/// Current of a count of the converter, A: 3.3 V / 4096 at 0.5 V/A = 1.611 mA.
pub(crate) const AMPERES_PER_COUNT: f32 = 3.3 / 4096.0 / 0.5;
/// Count at no current: 1.65 V of 3.3 V.
pub(crate) const COUNT_ZERO: f32 = 2048.0;
/// Largest difference of measured and commanded current, A: 15 % of the largest.
pub(crate) const MISMATCH_A: f32 = 0.3;
/// Time that it may last, µs: an amplifier is enabled within some ms, and its current settles in less.
pub(crate) const MISMATCH_US: u32 = 20_000;

/// Watchdog, ms: LSI is 17 kHz to 47 kHz instead of 32 kHz (DS10693, 6.3.9), so 27 ms to 75 ms. The
/// shortest is longer than two ticks of 10 ms.
pub(crate) const WATCHDOG_MS: u32 = 40;
