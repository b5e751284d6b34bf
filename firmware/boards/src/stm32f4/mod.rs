//! NUCLEO-F446RE. **Built, not yet run on hardware.**
//!
//! Why this board: a Cortex-M4F at 180 MHz that many people own, with a 32-bit encoder counter, and
//! `stm32f4xx-hal`, which is maintained; a probe and a serial port are on it.

mod axis;
mod uart;

pub use crate::board::nucleo_f446re::NAME;
use crate::board::nucleo_f446re::{
    BAUD, CLOCK_HZ, DUTY_ZERO, HSE_HZ, PCLK1_HZ, PCLK2_HZ, PWM_HZ, UNIQUE_NUMBER, WATCHDOG_MS,
};
pub use axis::Axis;
use cortex_m::peripheral::NVIC;
use haptic_board::haptic_link::SerialNumber;
use haptic_board::{Clock, TickTimer};
use stm32f4xx_hal::adc::config::{AdcConfig, SampleTime, Sequence};
use stm32f4xx_hal::adc::{self, Adc};
use stm32f4xx_hal::dma::StreamsTuple;
use stm32f4xx_hal::gpio::PinState;
pub use stm32f4xx_hal::pac::interrupt;
use stm32f4xx_hal::pac::{DBGMCU, GPIOC, IWDG, Interrupt, Peripherals, TIM5, TIM7};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::qei::Qei;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::{self, Serial};
use stm32f4xx_hal::timer::{CounterUs, Event, FTimer, Flag};
use stm32f4xx_hal::watchdog::IndependentWatchdog;
pub use uart::{Uart, on_round, on_uart};

/// Sensor and actuator: encoder, amplifier, emergency stop.
pub type Board = Axis;
/// The timer whose interrupt is the tick.
pub type Timer = TickCounter;
/// Watches tick and main loop.
pub type Watchdog = Iwdg;
/// This board, at power-up.
pub type Parts = haptic_board::Parts<Board, Timer, Uart, Watchdog>;

/// Priority of the tick; smaller is more urgent.
const TICK_PRIORITY: u8 = 0x40;
/// Priority of the UART and its DMA.
const UART_PRIORITY: u8 = 0x80;

static CLOCK: Clock = Clock::new();

/// Time since power-up, µs, by TIM5.
pub fn now_us() -> u64 {
    CLOCK.now_us(|| {
        #[expect(unsafe_code, reason = "a counter is read from everywhere")]
        // SAFETY: nobody writes TIM5 once it runs, and reading the count has no effect.
        let counter = unsafe { &*TIM5::ptr() };
        counter.cnt().read().bits()
    })
}

/// TIM7, counting microseconds.
pub struct TickCounter(CounterUs<TIM7>);

impl core::fmt::Debug for TickCounter {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("TickCounter")
    }
}

impl TickTimer for TickCounter {
    fn acknowledge(&mut self) {
        self.0.clear_flags(Flag::Update);
    }

    fn is_pending(&self) -> bool {
        self.0.flags().contains(Flag::Update)
    }

    fn set_period_us(&mut self, period_us: u32) {
        // At most 10 000, which 16 bits hold.
        let _ = self.0.start(period_us.micros());
        self.0.listen(Event::Update);
    }
}

/// The independent watchdog, which resets the chip if it is not fed.
#[derive(Debug)]
pub struct Iwdg(IndependentWatchdog);

impl haptic_board::Watchdog for Iwdg {
    fn feed(&mut self) {
        self.0.feed();
    }
}

/// Starts the board, the amplifier first: disabled. To be called once.
///
/// # Panics
/// The second time.
pub fn start() -> Parts {
    let (Some(board), Some(mut core)) = (Peripherals::take(), cortex_m::Peripherals::take()) else {
        panic!("the board is started once");
    };
    let clock = Config::hse(HSE_HZ.Hz()).bypass_hse_oscillator();
    let mut rcc = board.RCC.freeze(
        clock
            .sysclk(CLOCK_HZ.Hz())
            .pclk1(PCLK1_HZ.Hz())
            .pclk2(PCLK2_HZ.Hz()),
    );

    let gpioc = board.GPIOC.split(&mut rcc);
    let enable = gpioc.pc8.into_push_pull_output_in_state(PinState::Low);
    let stop = gpioc.pc7.into_pull_up_input();
    let gpioa = board.GPIOA.split(&mut rcc);
    let gpiob = board.GPIOB.split(&mut rcc);

    let (_, (command, ..)) = board.TIM1.pwm_hz(PWM_HZ.Hz(), &mut rcc);
    let mut command = command.with(gpioa.pa8);
    command.set_duty((f32::from(command.get_max_duty()) * DUTY_ZERO) as u16);
    command.enable();

    let encoder = Qei::new(board.TIM2, (gpioa.pa0, gpioa.pa1), &mut rcc);
    // 90 MHz / 4 = 22.5 MHz; 36 MHz is the most (DS10693, 6.3.20).
    let conversion = AdcConfig::default().clock(adc::config::Clock::Pclk2_div_4);
    let mut monitor = Adc::new(board.ADC1, true, conversion, &mut rcc);
    monitor.configure_channel(
        &gpiob.pb0.into_analog(),
        Sequence::One,
        SampleTime::Cycles_56,
    );
    monitor.start_conversion();

    let mut time = FTimer::<TIM5, 1_000_000>::new(board.TIM5, &mut rcc).counter();
    // Around once in 71 minutes, one count early: 1 µs.
    let _ = time.start(u32::MAX.micros());

    let config = serial::Config::default()
        .baudrate(BAUD.bps())
        .dma(serial::config::DmaConfig::Rx);
    let Ok(line) = Serial::new(board.USART2, (gpioa.pa2, gpioa.pa3), config, &mut rcc) else {
        panic!("45 MHz / 921 600 is a divider");
    };
    let (tx, rx) = line.split();
    // Turns DMA1 on; its stream 5 is set up by hand.
    let _ = StreamsTuple::new(board.DMA1, &mut rcc);

    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    set_priorities(&mut core.NVIC);
    let watchdog = watchdog(board.IWDG, &board.DBGMCU);
    let timer = board.TIM7.counter_us(&mut rcc);
    Parts {
        hardware: Axis::new(encoder, command, enable, stop, monitor),
        timer: TickCounter(timer),
        line: Uart::start(tx, rx),
        watchdog,
    }
}

/// The chip's own number.
pub(crate) fn serial_number() -> SerialNumber {
    #[expect(unsafe_code, reason = "a number is read where the chip has it")]
    // SAFETY: the chip has 12 bytes there, which are never written.
    let unique = unsafe { (UNIQUE_NUMBER as *const [u8; 12]).read_volatile() };
    SerialNumber::of_chip(&unique)
}

/// The tick interrupts the line, and nothing interrupts the tick.
fn set_priorities(nvic: &mut NVIC) {
    #[expect(unsafe_code, reason = "priorities decide who interrupts whom")]
    // SAFETY: no interrupt is enabled yet, and no critical section depends on priorities.
    unsafe {
        nvic.set_priority(Interrupt::TIM7, TICK_PRIORITY);
        nvic.set_priority(Interrupt::USART2, UART_PRIORITY);
        nvic.set_priority(Interrupt::DMA1_STREAM5, UART_PRIORITY);
    }
}

/// The watchdog, running.
fn watchdog(registers: IWDG, debug: &DBGMCU) -> Iwdg {
    let mut watchdog = IndependentWatchdog::new(registers);
    // It runs on while a debugger holds the processor: the amplifier must not hold its force meanwhile.
    watchdog.stop_on_debug(debug, false);
    watchdog.start(WATCHDOG_MS.millis());
    Iwdg(watchdog)
}

/// Lets the interrupts of tick and line come.
pub fn enable_interrupts() {
    #[expect(unsafe_code, reason = "interrupts begin")]
    // SAFETY: everything that the handlers use is set up; no critical section is made by masking.
    unsafe {
        NVIC::unmask(Interrupt::USART2);
        NVIC::unmask(Interrupt::DMA1_STREAM5);
        NVIC::unmask(Interrupt::TIM7);
    }
}

/// The end after a fault in the program: the amplifier is disabled, then the watchdog resets the chip.
pub fn give_up() -> ! {
    cortex_m::interrupt::disable();
    #[expect(unsafe_code, reason = "the pin is taken from whoever has it")]
    // SAFETY: nothing else runs any more; writing the reset half of BSRR changes this pin only.
    let port = unsafe { &*GPIOC::ptr() };
    port.bsrr().write(|w| w.br8().set_bit());
    loop {
        cortex_m::asm::nop();
    }
}
