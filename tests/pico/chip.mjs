/** An RP2040 with an image in its flash, run by emulated time: nanoseconds since it was switched on. */
import { LogLevel, ConsoleLogger, RP2040 } from 'rp2040js';
import { Bootrom } from './bootrom.mjs';
import { FlashCache } from './cache.mjs';
import { repairExceptionEntry, repairFlash, repairPio, repairStream, repairWatchdog } from './repairs.mjs';

/** Where the ROM puts the second boot stage, 252 bytes, and jumps with LR = 0. */
const BOOT2 = 0x41f00;
const RAM = 0x20000000;
/** Exception of the tick: alarm 3 of the timer. */
const TICK = 16 + 3;

export class Chip {
  /** Its flash with a unique number, a cache before it or none, and what a reset by the watchdog has left in its memory, if that was the reason. */
  constructor(flash, unique, cached, sram = null) {
    this.mcu = new RP2040();
    this.clock = this.mcu.clock;
    this.mcu.logger = new ConsoleLogger(LogLevel.Error);
    repairExceptionEntry(this.mcu.core);
    this.mcu.pio.forEach((pio) => repairPio(pio, this.mcu));
    repairStream(this.mcu);
    repairFlash(this.mcu.peripherals[0x18000], unique);
    const rom = new Bootrom();
    this.mcu.loadBootrom(rom.words);
    this.extra = 0;
    this.mcu.onBreak = (n) => {
      if (this.mcu.core.PC >= 0x4000) throw new Error(`the image gave up at 0x${this.mcu.core.PC.toString(16)}`);
      this.extra = rom.call(n, this.mcu.core, this.mcu);
    };
    this.flash = flash;
    /** Ticks so far, cycles of the longest and of this one, when it began, ns; and a hook at the end of each. */
    this.ticks = { number: 0, longest: 0, last: 0, began: 0 };
    this.onTick = () => {};
    /** The watchdog has reset it: it does nothing any more. */
    this.bitten = false;
    const watchdog = this.mcu.peripherals[0x40058];
    repairWatchdog(watchdog, () => { this.bitten = true; });
    if (cached) this.cache = new FlashCache(this.mcu);
    if (sram) {
      this.mcu.sram.set(sram);
      watchdog.reason = 1;
    }
    this.start();
  }

  get nanos() {
    return this.clock.nanos;
  }

  start() {
    const { core, flash, sram } = this.mcu;
    flash.set(this.flash);
    sram.set(this.flash.subarray(0, 252), BOOT2);
    core.SP = RAM + BOOT2;
    core.LR = 0;
    core.PC = RAM + BOOT2;
  }

  /** Runs until the time, ns. */
  run(until) {
    const { core } = this.mcu;
    const { clock, ticks } = this;
    const nanos = 1e9 / this.mcu.clkSys;
    while (clock.nanos < until && !this.bitten) {
      if (core.waiting) {
        const alarm = clock.nextAlarm ? clock.nanosToNextAlarm : Infinity;
        clock.tick(Math.max(0, Math.min(alarm, until - clock.nanos)));
        continue;
      }
      const cycles = core.executeInstruction() + this.extra + (this.cache?.take() ?? 0);
      this.extra = 0;
      if (core.IPSR === TICK) {
        if (ticks.last === 0) ticks.began = clock.nanos;
        ticks.last += cycles;
      } else if (ticks.last > 0) {
        ticks.number++;
        ticks.longest = Math.max(ticks.longest, ticks.last);
        this.onTick(ticks);
        ticks.last = 0;
      }
      clock.tick(cycles * nanos);
    }
  }
}
