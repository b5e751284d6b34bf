/**
 * The host's end of the cable: enumerates the chip, opens its serial port (CDC ACM), and moves bytes.
 *
 * - *Port closed*: nobody fetches what the chip has to say, so its buffer stays full, as on a computer.
 * - *Cable out*: nothing moves; after 3 ms of silence the bus is suspended. Cable in: the chip is enumerated anew.
 */
import { USBCDC } from 'rp2040js';
import { repairUsb } from './repairs.mjs';

const SUSPENDED = 1 << 4;
const SUSPEND_AFTER_NS = 3e6;
const PACKET = 64;

export class Cable {
  constructor(mcu) {
    this.usb = mcu.usbCtrl;
    this.plugged = true;
    this.opened = false;
    this.toChip = [];
    this.wanted = 0;
    /** What the chip said, while the port is open. */
    this.onBytes = () => {};
    this.onConnected = () => {};
    this.fetch = repairUsb(this.usb, mcu, { takes: (endpoint) => this.plugged && (this.opened || endpoint !== this.host.inEndpoint) });
    this.silence = mcu.clock.createAlarm(() => this.status(SUSPENDED));
    this.attach();
  }

  attach() {
    this.connected = false;
    this.host = new USBCDC(this.usb);
    this.host.onDeviceConnected = () => {
      this.connected = true;
      this.onConnected();
    };
    this.host.onSerialData = (bytes) => this.opened && this.onBytes(bytes);
    this.usb.onEndpointRead = (endpoint, size) => {
      if (endpoint === this.host.outEndpoint) {
        this.wanted = size;
        this.feed();
      }
    };
  }

  status(bit) {
    this.usb.sieStatus |= bit;
    this.usb.sieStatusUpdated();
  }

  open() {
    this.opened = true;
    this.fetch();
  }

  close() {
    this.opened = false;
    this.toChip.length = 0;
  }

  send(bytes) {
    for (const byte of bytes) this.toChip.push(byte);
    this.feed();
  }

  feed() {
    if (!this.plugged || this.wanted === 0 || this.toChip.length === 0) return;
    const packet = this.toChip.splice(0, Math.min(this.wanted, PACKET));
    this.wanted = 0;
    this.usb.endpointReadDone(this.host.outEndpoint, Uint8Array.from(packet));
  }

  unplug() {
    this.plugged = false;
    this.connected = false;
    this.toChip.length = 0;
    this.silence.schedule(SUSPEND_AFTER_NS);
  }

  plug() {
    this.silence.cancel();
    this.plugged = true;
    this.attach();
    this.usb.resetDevice();
  }
}
