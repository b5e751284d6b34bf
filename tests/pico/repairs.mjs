/**
 * What rp2040js 1.4.1 does otherwise than the chip, and this image meets. Each repair stands alone, needs nothing but the
 * emulator, and has a test in `repairs.test.mjs` that shows the fault without it.
 *
 * Source: Raspberry Pi, *RP2040 Datasheet*, 3.5 (PIO), 4.1 (USB), 4.7 (watchdog), 4.10 (SSI); Winbond, *W25Q16JV*, 8.2 (4Bh); Arm, *ARMv6-M Architecture Reference
 * Manual*, B1.5.6 (exception entry).
 */

/**
 * The lowest bit of a vector says Thumb and is no part of the address. Left in PC, it makes the next instruction that
 * reads PC one off: `add r2, pc` of a jump through a table takes the wrong byte.
 */
export function repairExceptionEntry(core) {
  const enter = core.exceptionEntry.bind(core);
  core.exceptionEntry = (number) => {
    enter(number);
    core.PC = (core.PC & ~1) >>> 0;
  };
}

/**
 * A state machine steps by the emulated clock, once every `CLKDIV` cycles and longer where an instruction has a delay, and
 * a joined FIFO has eight words. The package runs a thousand steps each turn of the host's event loop, at no clock.
 */
export function repairPio(pio, mcu) {
  const { clock } = mcu;
  pio.run = () => {};
  const starts = pio.machines.map((machine) => {
    const cycle = () => ((machine.clockDivInt || 65536) + machine.clockDivFrac / 256) * 1e9 / mcu.clkSys;
    let due = null;
    const alarm = clock.createAlarm(() => {
      if (!machine.enabled) {
        due = null;
        return;
      }
      const before = machine.cycles;
      machine.step();
      pio.checkChangedPins();
      due += Math.max(1, machine.cycles - before) * cycle();
      alarm.schedule(due - clock.nanos);
    });
    const write = machine.writeUint32.bind(machine);
    machine.writeUint32 = (offset, value) => {
      const joined = machine.shiftCtrl;
      write(offset, value);
      if ((joined ^ machine.shiftCtrl) >>> 30) {
        const fifo = machine.rxFIFO.constructor;
        const [rx, tx] = [[4, 4], [0, 8], [8, 0], [0, 0]][machine.shiftCtrl >>> 30];
        machine.rxFIFO = new fifo(rx);
        machine.txFIFO = new fifo(tx);
      }
    };
    return () => {
      if (due === null && machine.enabled) {
        due = clock.nanos + cycle();
        alarm.schedule(due - clock.nanos);
      }
    };
  });
  const write = pio.writeUint32.bind(pio);
  pio.writeUint32 = (offset, value) => {
    write(offset, value);
    if (offset === 0) starts.forEach((start) => start());
  };
}

const AVAILABLE = 1 << 10;
const SUSPENDED = 1 << 4;
const EP_BUFFERS = 0x80;

/**
 * A buffer belongs to the controller (AVAILABLE) until the host has filled or fetched it; until then the host gets, or
 * gives, NAK. The package takes an OUT buffer back at once and an IN buffer before the host had it. And SUSPENDED is
 * cleared by writing it.
 *
 * `host.takes(endpoint)` says whether the host fetches now; after it began to, call what this returns.
 */
export function repairUsb(usb, mcu, host) {
  const view = mcu.usbDPRAMView;
  const held = new Map();
  const update = usb.DPRAMUpdated.bind(usb);
  usb.DPRAMUpdated = (offset, value) => {
    const endpoint = offset - EP_BUFFERS >> 3;
    const buffer = offset >= EP_BUFFERS + 8 && offset < EP_BUFFERS + 0x80 && (value & AVAILABLE) !== 0;
    if (buffer && !(offset & 4) && !host.takes(endpoint)) {
      held.set(offset, value);
      return;
    }
    update(offset, value);
    if (buffer && offset & 4) view.setUint32(offset, view.getUint32(offset, true) | AVAILABLE, true);
  };
  const finish = usb.finishRead.bind(usb);
  usb.finishRead = (endpoint, bytes) => {
    const offset = EP_BUFFERS + 8 * endpoint + 4;
    view.setUint32(offset, view.getUint32(offset, true) & ~AVAILABLE, true);
    finish(endpoint, bytes);
  };
  const write = usb.writeUint32.bind(usb);
  usb.writeUint32 = (offset, value) => {
    if (offset === 0x50) usb.sieStatus &= ~(usb.rawWriteValue & SUSPENDED);
    write(offset, value);
  };
  return () => {
    for (const [offset, value] of [...held].filter(([offset]) => host.takes(offset - EP_BUFFERS >> 3))) {
      held.delete(offset);
      usb.DPRAMUpdated(offset, value);
    }
  };
}

const [DR0, READ_UNIQUE_NUMBER] = [0x60, 0x4b];

/** The flash answers 0x4b with four bytes of no meaning and its unique number of 64 bits. The package's has no such number. */
export function repairFlash(ssi, unique) {
  let answer = [];
  const [read, write] = [ssi.readUint32.bind(ssi), ssi.writeUint32.bind(ssi)];
  ssi.writeUint32 = (offset, value) => {
    if (offset === DR0 && (value & 0xff) === READ_UNIQUE_NUMBER) answer = [0, 0, 0, 0, ...unique];
    write(offset, value);
  };
  ssi.readUint32 = (offset) => offset === DR0 && answer.length > 0 ? answer.shift() : read(offset);
}

/** No streamed read of the flash is under way: its counter (XIP_CTRL STREAM_CTR) is 0. The package has no such registers, and reads all ones. */
export function repairStream(mcu) {
  mcu.peripherals[0x14000] = { readUint32: () => 0, writeUint32: () => {}, writeUint32Atomic: () => {} };
}

/** A watchdog triggers once. The package's triggers again at once, without end, and emulated time stands still. */
export function repairWatchdog(watchdog, triggered) {
  watchdog.onWatchdogTrigger = () => {
    watchdog.timer.enable = false;
    watchdog.alarm.enable = false;
    triggered();
  };
}
