/**
 * A boot ROM with what the image calls, as the package has none and the chip's own may only be used on the chip.
 *
 * Tables, their order and the search through them are as in the chip (version 2), so an image that looks a function up
 * before each call pays for it here too. Behind each entry stands `bkpt #n; bx lr`: the emulator hands the breakpoint to
 * `Bootrom.call`, which computes the result and the cycles that it takes. Not our own soft floats in Thumb: those would
 * have neither the chip's bits nor its cycles.
 *
 * - *Floats*: round to nearest, even. Subnormal numbers are read as zeros, and results below 2⁻¹²⁶ are zeros, of their sign.
 *   The image itself catches infinities and NaN before it calls. So bits differ from IEEE 754 below 1.2e-38 only.
 * - *Cycles*: the averages of the datasheet for floats; counted by hand for the others. A call takes them at once, so an
 *   interrupt comes up to 0.6 µs late.
 *
 * Source: Raspberry Pi, *RP2040 Datasheet*, 2.8.2 (contents), 2.8.3 (functions, cycles of version 2).
 */
const FUNCTION_TABLE = 0x100;
const DATA_TABLE = 0x180;
const LOOKUP = 0x1c0;
const FLOAT_TABLE = 0x200;
const STUBS = 0x300;
const BKPT = 0xbe00;
const BX_LR = 0x4770;
/** Cycles of `bkpt` and `bx lr`, which the emulator counts itself. */
const STUB_CYCLES = 3;

const word = new DataView(new ArrayBuffer(4));
const float = (bits) => (word.setUint32(0, bits), word.getFloat32(0));
const bits = (value) => (word.setFloat32(0, value), word.getUint32(0));
/** Without subnormal numbers. */
const flushed = (raw) => ((raw & 0x7f800000) === 0 ? raw & 0x80000000 : raw) >>> 0;
/** A result rounded to a double and then to a float is rounded once, as 53 ≥ 2 · 24 + 2 (Figueroa 1995). */
const arithmetic = (compute, cycles) => (core) => {
  const [a, b] = [0, 1].map((r) => float(flushed(core.registers[r])));
  core.registers[0] = flushed(bits(compute(a, b)));
  return cycles;
};

const fill = (core, mcu) => {
  const [to, value, count] = core.registers;
  for (let i = 0; i < count; i++) mcu.writeUint8(to + i, value & 0xff);
};
const copy = (core, mcu) => {
  const [to, from, count] = core.registers;
  for (let i = 0; i < count; i++) mcu.writeUint8(to + i, mcu.readUint8(from + i));
};

/** Offset in the table of floats, and the function. */
const FLOATS = [
  [0x00, arithmetic((a, b) => a + b, 71)],
  [0x04, arithmetic((a, b) => a - b, 74)],
  [0x08, arithmetic((a, b) => a * b, 58)],
  [0x0c, arithmetic((a, b) => a / b, 71)],
];

/** Code and function, in the order of the chip; what the image does not call says so when it does. */
const FUNCTIONS = [
  ['P3', null], ['R3', null],
  ['L3', (core) => { core.registers[0] = Math.clz32(core.registers[0]); return 17; }],
  ['T3', null],
  ['MS', (core, mcu) => { fill(core, mcu); return 20 + 4 * core.registers[2]; }],
  ['S4', (core, mcu) => { fill(core, mcu); return 20 + core.registers[2] / 2; }],
  ['MC', (core, mcu) => { copy(core, mcu); return 20 + 6 * core.registers[2]; }],
  ['C4', (core, mcu) => { copy(core, mcu); return 20 + core.registers[2] * 5 / 8; }],
  ['UB', null], ['DT', null], ['DE', null], ['WV', null],
  // The flash is connected, and leaves XIP: as in the chip, nothing else shows.
  ['IF', () => 100], ['EX', () => 2000], ['RE', null], ['RP', null],
  ['FC', null], ['CX', null], ['EC', null],
];

/** Searches a table of (code, address) for the code in r1: r0 is the address, or 0. */
const LOOKUP_CODE = [
  0x2300, //       movs r3, #0
  0x8802, // next: ldrh r2, [r0]
  0x2a00, //       cmp  r2, #0
  0xd003, //       beq  found
  0x8843, //       ldrh r3, [r0, #2]
  0x3004, //       adds r0, #4
  0x4291, //       cmp  r1, r2
  0xd1f7, //       bne  the first
  0x4618, // found: mov r0, r3
  0x4770, //       bx   lr
];

/** The ROM of one chip. */
export class Bootrom {
  constructor() {
    this.words = new Uint32Array(4096);
    this.functions = [];
    const half = new DataView(this.words.buffer);
    const put = (at, ...values) => values.forEach((value, i) => half.setUint16(at + 2 * i, value, true));
    const code = (name) => name.charCodeAt(0) | name.charCodeAt(1) << 8;
    const stub = (name, call) => {
      const at = STUBS + 4 * this.functions.length;
      put(at, BKPT | this.functions.length, BX_LR);
      this.functions.push([name, call]);
      return at | 1;
    };
    half.setUint32(0, 0x20041f00, true);
    put(0x10, 0x754d, 0x0201, FUNCTION_TABLE, DATA_TABLE, LOOKUP | 1); // "Mu", 1, version 2
    put(LOOKUP, ...LOOKUP_CODE);
    FUNCTIONS.forEach(([name, call], i) => put(FUNCTION_TABLE + 4 * i, code(name), stub(name, call)));
    const missing = stub('of floats', null);
    for (let offset = 0; offset < 0x80; offset += 4) half.setUint32(FLOAT_TABLE + offset, missing, true);
    for (const [offset, call] of FLOATS) half.setUint32(FLOAT_TABLE + offset, stub('of floats', call), true);
    put(DATA_TABLE, code('GR'), 0, code('CR'), 0, code('SF'), FLOAT_TABLE);
  }

  /** Function n was called; what it takes, in cycles, beyond those of its stub. */
  call(n, core, mcu) {
    const [name, call] = this.functions[n] ?? ['?', null];
    if (!call) throw new Error(`the image calls function ${name} of the boot ROM, which tests/pico/bootrom.mjs does not have`);
    return Math.round(call(core, mcu)) - STUB_CYCLES;
  }
}
