//! The line to the host: a serial port over USB (CDC ACM), with a queue each way.

use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::{Peri, bind_interrupts};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver, Sender, State};
use embassy_usb::{Builder, Config, UsbDevice};
use haptic_board::haptic_link::SerialNumber;
use haptic_board::{HostLine, Queue};

type Port = Driver<'static, USB>;

/// Bytes in a packet at most, of USB at full speed.
const PACKET: usize = 64;

bind_interrupts!(struct Interrupts {
    USBCTRL_IRQ => InterruptHandler<USB>;
});

static RECEIVED: Queue<512> = Queue::new();
static TO_SEND: Queue<512> = Queue::new();
pub(crate) static RECEIVED_SOME: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static SEND_SOME: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Memory of the USB stack.
#[derive(Default)]
pub(crate) struct Buffers {
    configuration: Text<256>,
    bos: Text<64>,
    control: Text<64>,
    state: State<'static>,
    serial_number: Option<SerialNumber>,
}

struct Text<const N: usize>([u8; N]);

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

pub(crate) fn start(
    usb: Peri<'static, USB>,
    buffers: &'static mut Buffers,
    serial_number: SerialNumber,
) -> (
    UsbDevice<'static, Port>,
    Sender<'static, Port>,
    Receiver<'static, Port>,
) {
    // TODO of whoever sells it: a number of one's own. This one is for experiments (pid.codes 1209:0001).
    let mut config = Config::new(0x1209, 0x0001);
    config.manufacturer = Some("fractional-haptics");
    config.product = Some(crate::axis::NAME);
    let number = buffers.serial_number.insert(serial_number);
    config.serial_number = number.text();
    config.max_power = 100;
    let mut builder = Builder::new(
        Driver::new(usb, Interrupts),
        config,
        &mut buffers.configuration.0,
        &mut buffers.bos.0,
        &mut [],
        &mut buffers.control.0,
    );
    let class = CdcAcmClass::new(&mut builder, &mut buffers.state, PACKET as u16);
    let (sender, receiver) = class.split();
    (builder.build(), sender, receiver)
}

/// Packets from the host, into the queue.
pub(crate) async fn receive(receiver: &mut Receiver<'static, Port>) {
    let mut packet = [0; PACKET];
    loop {
        receiver.wait_connection().await;
        while let Ok(length) = receiver.read_packet(&mut packet).await {
            RECEIVED.extend(&packet[..length]);
            RECEIVED_SOME.signal(());
        }
    }
}

/// Sends the queue to the host.
pub(crate) async fn send(sender: &mut Sender<'static, Port>) {
    let mut packet = [0; PACKET];
    loop {
        sender.wait_connection().await;
        SEND_SOME.wait().await;
        loop {
            // One byte short of a whole packet, which says by itself that nothing follows.
            let mut length = 0;
            while length < PACKET - 1
                && let Some(byte) = TO_SEND.pop()
            {
                packet[length] = byte;
                length += 1;
            }
            if length == 0 || sender.write_packet(&packet[..length]).await.is_err() {
                break;
            }
        }
    }
}

#[derive(Debug)]
pub(crate) struct UsbLine;

impl HostLine for UsbLine {
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
        if !bytes.is_empty() {
            SEND_SOME.signal(());
        }
    }
}
