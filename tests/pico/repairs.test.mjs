// Each fault of rp2040js 1.4.1 as it is, and repaired. Needs nothing but the package.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { LogLevel, ConsoleLogger, RP2040 } from 'rp2040js';
import { repairExceptionEntry, repairFlash, repairPio, repairStream, repairUsb, repairWatchdog } from './repairs.mjs';

const RAM = 0x20000000;
const chip = () => {
  const mcu = new RP2040();
  mcu.logger = new ConsoleLogger(LogLevel.Error);
  return mcu;
};

test('PC in a handler is even', () => {
  const handler = RAM + 0x100;
  const read = (repair) => {
    const mcu = chip();
    const { core } = mcu;
    repair(core);
    core.VTOR = RAM;
    core.SP = RAM + 0x1000;
    mcu.writeUint32(RAM + 4 * 16, handler | 1);
    mcu.writeUint16(handler, 0x467a); // mov r2, pc
    core.exceptionEntry(16);
    core.executeInstruction();
    return core.registers[2];
  };
  assert.equal(read(() => {}), handler + 5);
  assert.equal(read(repairExceptionEntry), handler + 4);
});

test('a PIO samples by its divider, into a queue of eight words if joined', () => {
  const PIO0 = 0x50200000;
  const level = (mcu) => mcu.readUint32(PIO0 + 0x0c) >>> 4 & 0xf;
  const sampling = (repair) => {
    const mcu = chip();
    repair(mcu);
    mcu.writeUint32(PIO0 + 0x48, 0x4002); // in pins, 2
    mcu.writeUint32(PIO0 + 0xc8, 125e6 / 64000 * 65536 >>> 0); // 64 000 a second
    mcu.writeUint32(PIO0 + 0xcc, 0); // wrap at once
    mcu.writeUint32(PIO0 + 0xd0, (1 << 31 | 1 << 18 | 1 << 16) >>> 0); // RX joined, to the right, autopush at 32
    mcu.writeUint32(PIO0, 1);
    return mcu;
  };
  const raw = sampling(() => {});
  assert.equal(level(raw), 4, 'full before any time has passed, and of four words');
  raw.pio[0].stop();
  const mcu = sampling((mcu) => repairPio(mcu.pio[0], mcu));
  assert.equal(level(mcu), 0);
  mcu.clock.tick(1e6);
  assert.equal(level(mcu), 4, '64 samples of two bits in 1 ms');
  mcu.clock.tick(4e6);
  assert.equal(level(mcu), 8);
});

test('a USB buffer is the controller\'s until the host has filled or fetched it', () => {
  const DPRAM = 0x50100000;
  const [OUT, IN] = [DPRAM + 0x94, DPRAM + 0x98]; // endpoint 2 OUT, 3 IN
  const AVAILABLE = 1 << 10;
  const armed = (repair) => {
    const mcu = chip();
    const host = { fetches: false, takes() { return this.fetches; } };
    mcu.usbCtrl.onEndpointRead = (endpoint) => repair || mcu.usbCtrl.endpointReadDone(endpoint, new Uint8Array(0));
    const fetch = repair && repairUsb(mcu.usbCtrl, mcu, host);
    mcu.writeUint32(DPRAM + 0x08 + 8 + 4, 0xa0000180); // endpoint 2 OUT: enabled, buffer at 0x180
    mcu.writeUint32(DPRAM + 0x08 + 16, 0xa00001c0); // endpoint 3 IN: enabled, buffer at 0x1c0
    mcu.writeUint32(OUT, AVAILABLE | 64);
    mcu.writeUint32(IN, AVAILABLE | 1 << 15 | 5);
    mcu.clock.tick(1e6);
    return { mcu, host, fetch };
  };
  const state = ({ mcu }) => [OUT, IN].map((buffer) => (mcu.readUint32(buffer) & AVAILABLE) !== 0);
  assert.deepEqual(state(armed(false)), [false, false], 'taken back, though the host said and fetched nothing');
  const repaired = armed(true);
  assert.deepEqual(state(repaired), [true, true]);
  repaired.mcu.usbCtrl.endpointReadDone(2, Uint8Array.of(1, 2, 3));
  repaired.host.fetches = true;
  repaired.fetch();
  repaired.mcu.clock.tick(1e6);
  assert.deepEqual(state(repaired), [false, false]);
  assert.equal(repaired.mcu.readUint32(OUT) & 0x3ff, 3);
});

test('SUSPENDED is cleared by writing it', () => {
  const [STATUS, SUSPENDED] = [0x50110050, 1 << 4];
  const suspended = (repair) => {
    const mcu = chip();
    repair(mcu);
    mcu.usbCtrl.sieStatus |= SUSPENDED;
    mcu.writeUint32(STATUS, SUSPENDED);
    return (mcu.readUint32(STATUS) & SUSPENDED) !== 0;
  };
  assert.equal(suspended(() => {}), true);
  assert.equal(suspended((mcu) => repairUsb(mcu.usbCtrl, mcu, { takes: () => true })), false);
});

test('the flash tells its unique number', () => {
  const DR0 = 0x18000060;
  const number = Uint8Array.of(1, 2, 3, 4, 5, 6, 7, 8);
  const told = (repair) => {
    const mcu = chip();
    repair(mcu.peripherals[0x18000]);
    mcu.writeUint8(DR0, 0x4b);
    return Array.from({ length: 12 }, () => mcu.readUint8(DR0)).slice(4);
  };
  assert.deepEqual(told(() => {}), Array(8).fill(0));
  assert.deepEqual(told((ssi) => repairFlash(ssi, number)), [...number]);
});

test('a watchdog triggers once', () => {
  const triggers = (repair) => {
    const mcu = chip();
    const watchdog = mcu.peripherals[0x40058];
    let number = 0;
    repair(watchdog, () => {
      number++;
      assert.ok(number < 1000, 'again and again at one instant');
    });
    mcu.writeUint32(0x40058004, 2 * 20000); // 20 ms
    mcu.writeUint32(0x40058000, 1 << 30);
    mcu.clock.tick(30e6);
    return number;
  };
  assert.throws(() => triggers((watchdog, triggered) => { watchdog.onWatchdogTrigger = triggered; }), /again and again/);
  assert.equal(triggers(repairWatchdog), 1);
});

test('no streamed read of the flash is under way', () => {
  const read = (repair) => {
    const mcu = chip();
    repair(mcu);
    return mcu.readUint32(0x14000010);
  };
  assert.equal(read(() => {}), 0xffffffff);
  assert.equal(read(repairStream), 0);
});
