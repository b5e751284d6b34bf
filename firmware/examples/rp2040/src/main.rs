//! A haptic device on an RP2040 or RP2350 with embassy: encoder by PIO, motor by PWM, the host over USB. **Not yet run on
//! hardware.**
//!
//! ```text
//! alarm 3, highest priority:  Ticker ─▶ encoder ─▶ force ─▶ safety chain ─▶ PWM
//! embassy's executor:         USB ─▶ queue ─▶ MainLoop ─▶ queue ─▶ USB;  watchdog, fed if ticks come
//! ```
#![no_std]
#![no_main]

mod axis;
mod encoder;
mod tick;
mod usb;

use axis::{Axis, NAME, Pins};
use cortex_m::singleton;
#[cfg(feature = "defmt")]
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_futures::join::join4;
use embassy_futures::select::select;
#[cfg(feature = "rp2040")]
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::interrupt;
#[cfg(feature = "rp2350")]
use embassy_rp::otp;
use embassy_rp::watchdog::Watchdog;
#[cfg(feature = "rp2040")]
use embassy_rp::{Peri, peripherals::FLASH};
use embassy_time::{Duration, Timer};
use encoder::EncoderPins;
use haptic_board::haptic_link::SerialNumber;
use haptic_board::{
    DeviceMemory, Image, MainLoop, RetainedMemory, Ticker, TickerSlot, image, power_up,
};
use tick::{Alarm, now_us};
use usb::{Buffers, UsbLine};

// SAFETY: the linker script of `cortex-m-rt` lays the image out.
static IMAGE: Image = image!(unsafe NAME, [0, 1, 0]);

#[expect(unsafe_code, reason = "a section is named")]
// SAFETY: the linker script has the section, in RAM, and any values of the words are allowed.
#[unsafe(link_section = ".uninit.retained")]
static RETAINED: RetainedMemory = RetainedMemory::new();

static TICKER: TickerSlot<Axis, Alarm> = TickerSlot::empty();

#[cfg(feature = "rp2040")]
#[interrupt]
fn TIMER_IRQ_3() {
    TICKER.tick(now_us);
}

#[cfg(feature = "rp2350")]
#[interrupt]
fn TIMER0_IRQ_3() {
    TICKER.tick(now_us);
}

/// Time without a tick after which the chip is reset: more than two ticks of the longest period.
const WATCHDOG: Duration = Duration::from_millis(20);
/// Time until the main loop runs, while nothing enables the motor: much more than the digest takes.
const START_UP: Duration = Duration::from_secs(1);
/// Longest time between two looks of the main loop for something to send: half a tick of 1 ms.
const ROUND: Duration = Duration::from_micros(500);

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let chip = embassy_rp::init(embassy_rp::config::Config::default());
    // The motor first: disabled.
    let mut axis = Axis::new(Pins {
        encoder: EncoderPins {
            pio: chip.PIO0,
            a: chip.PIN_2,
            b: chip.PIN_3,
            dma: (chip.DMA_CH0, chip.DMA_CH1),
        },
        slice: chip.PWM_SLICE2,
        command: chip.PIN_4,
        enable: chip.PIN_6,
        stop: chip.PIN_7,
        #[cfg(feature = "force-sensor")]
        load_cell: axis::LoadCell::new(chip.ADC, chip.PIN_26),
    });
    #[cfg(feature = "rp2040")]
    let unique = unique_number(chip.FLASH);
    #[cfg(feature = "rp2350")]
    let unique = otp::get_chipid().map(u64::to_be_bytes).ok();
    axis.serial_number = unique.map_or(SerialNumber::NONE, |unique| SerialNumber::of_chip(&unique));
    let serial_number = axis.serial_number;
    let mut watchdog = Fed(Watchdog::new(chip.WATCHDOG));
    watchdog.0.start(START_UP);
    let retained = RETAINED.take();
    let place = singleton!(: DeviceMemory<Axis> = DeviceMemory::new());
    let device = place.and_then(|place| power_up(place, axis, IMAGE.version(), retained).ok());
    let buffers = singleton!(: Buffers = Buffers::default());
    let (Some((device, session)), Some(buffers)) = (device, buffers) else {
        panic!("the board starts once, and without a configuration of its own");
    };
    TICKER.put(Ticker::new(device, Alarm::start(), &RETAINED));

    let (mut device_side, mut sender, mut receiver) = usb::start(chip.USB, buffers, serial_number);
    let serve = async {
        // 11 ms, while the host looks what was plugged in.
        session.set_image_digest(IMAGE.digest());
        watchdog.0.start(WATCHDOG);
        let mut main_loop = MainLoop::new(device, session);
        loop {
            while !main_loop.round(&mut UsbLine, &mut watchdog, tick::now_us) {}
            select(usb::RECEIVED_SOME.wait(), Timer::after(ROUND)).await;
        }
    };
    join4(
        device_side.run(),
        usb::receive(&mut receiver),
        usb::send(&mut sender),
        serve,
    )
    .await;
}

/// The unique number of the flash: an RP2040 has none of its own.
#[cfg(feature = "rp2040")]
fn unique_number(flash: Peri<'static, FLASH>) -> Option<[u8; 8]> {
    let mut unique = [0; 8];
    let mut flash = Flash::<_, Blocking, 0>::new_blocking(flash);
    flash.blocking_unique_id(&mut unique).ok()?;
    Some(unique)
}

struct Fed(Watchdog);

impl haptic_board::Watchdog for Fed {
    fn feed(&mut self) {
        self.0.feed(WATCHDOG);
    }
}

/// No force, and the watchdog resets the chip.
fn give_up() -> ! {
    cortex_m::interrupt::disable();
    axis::disable_motor();
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    give_up()
}

#[expect(unsafe_code, reason = "the runtime wants the handler marked so")]
mod fault {
    use cortex_m_rt::{ExceptionFrame, exception};

    #[exception]
    unsafe fn HardFault(_: &ExceptionFrame) -> ! {
        crate::give_up()
    }
}
