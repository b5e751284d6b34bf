/**
 * The cache between the core and the flash, which the emulator does not have: 16 KiB, two ways, lines of 8 bytes, the older
 * one replaced. A miss costs the transfer of a line over four wires, with address length, wait cycles and clock divider as
 * the image's second boot stage has set them:
 *
 * ```text
 * cycles = divider · (address and mode digits + wait + 16 digits of data)
 * ```
 * An estimate: neither requests that overlap nor the bus in front of the cache are in it.
 *
 * Source: Raspberry Pi, *RP2040 Datasheet*, 2.6.3 (cache), 4.10 (SSI).
 */
const SETS = 1024;

export class FlashCache {
  constructor(mcu) {
    this.tags = new Int32Array(2 * SETS).fill(-1);
    this.misses = 0;
    const ssi = mcu.peripherals[0x18000];
    /** Cycles of a miss, by what the SSI is set to. */
    this.cost = () => (ssi.baudr || 4) * ((ssi.spictlr0 >>> 2 & 0xf) + (ssi.spictlr0 >>> 11 & 0x1f) + 16);
    for (const name of ['readUint8', 'readUint16', 'readUint32']) {
      const read = mcu[name].bind(mcu);
      mcu[name] = (address) => {
        if (address >>> 24 === 0x10) this.touch((address & 0xffffff) >>> 3);
        return read(address);
      };
    }
  }

  touch(line) {
    const { tags } = this;
    const set = 2 * (line % SETS);
    if (tags[set] === line) return;
    if (tags[set + 1] !== line) this.misses++;
    tags[set + 1] = tags[set];
    tags[set] = line;
  }

  /** Cycles of the misses since this was last asked. */
  take() {
    const cycles = this.misses * this.cost();
    this.misses = 0;
    return cycles;
  }
}
