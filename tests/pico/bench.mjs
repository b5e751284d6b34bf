/**
 * The bench: a chip with the image that would be flashed, its cable to a host, and a world behind its pins.
 *
 * ```text
 * host-cli ══ TCP ══ Cable ══ Chip ── pins ── World          control port: one JSON line a command
 * ```
 * Time is emulated. With a host it never runs ahead of the wall clock, as the host has a clock of its own, and what a busy
 * machine loses is not made up for at a gallop. Without a host it runs as fast as it can.
 *
 * node bench.mjs IMAGE --line PORT --control PORT       see README.md
 */
import { randomBytes } from 'node:crypto';
import net from 'node:net';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { Chip } from './chip.mjs';
import { flashOf } from './image.mjs';
import { Cable } from './usb.mjs';
import { World } from './world.mjs';

/** Emulated at once, ns: bytes of the host wait no longer than this. */
const SLICE_NANOS = 250e3;
/** A host that is silent for so long may only have got no turn on a busy machine, so emulated time waits for it. */
const SILENT_NANOS = 300e6;
const WAIT_MS = 2000;
/** What may be made up for, ms. */
const BEHIND_MS = 20;
const TURN_MS = 4;

export class Bench {
  constructor(image, device = {}, cached = false, number = 'E6612483CB1B9221') {
    this.flash = flashOf(image);
    this.unique = Buffer.from(number, 'hex');
    this.cached = cached;
    this.world = new World(device);
    this.before = 0;
    this.resets = 0;
    this.later = [];
    this.power(true);
  }

  /** Emulated time since the bench was built, ns. */
  get nanos() {
    return this.before + (this.chip?.nanos ?? 0);
  }

  /** Power on, or off. A watchdog's reset is both, but memory stays. */
  power(on, sram = null) {
    this.before = this.nanos;
    this.chip = null;
    this.cable = null;
    this.socket?.destroy();
    this.world.attach(null);
    if (!on) return;
    this.chip = new Chip(this.flash, this.unique, this.cached, sram);
    this.cable = new Cable(this.chip.mcu);
    this.cable.onBytes = (bytes) => this.socket?.write(Buffer.from(bytes));
    this.world.attach(this.chip);
  }

  /** Runs for so long, ns. */
  advance(nanos) {
    const end = this.nanos + nanos;
    while (this.nanos < end) {
      const due = this.later.length > 0 ? Math.max(this.nanos, Math.min(end, this.later[0].at)) : end;
      if (this.chip) {
        this.chip.run(due - this.before);
        if (this.chip.bitten) {
          this.resets++;
          this.power(true, this.chip.mcu.sram);
        }
      } else {
        this.world.step();
        this.before += 1e4;
      }
      while (this.later.length > 0 && this.later[0].at <= this.nanos) this.later.shift().act();
    }
  }

  /** Does something at an emulated time, ns. */
  at(at, act) {
    this.later.push({ at, act });
    this.later.sort((one, next) => one.at - next.at);
  }

  /** Lets the host command open `tcp:127.0.0.1:PORT`, once the chip's port is there; one program at a time, as a serial port. */
  listen(port) {
    while (!this.cable.connected) this.advance(SLICE_NANOS);
    this.server = net.createServer({ noDelay: true }, (socket) => {
      socket.on('error', () => {});
      if (this.socket) return socket.end('busy: it serves another program\n');
      if (!this.cable?.connected) return socket.destroy();
      this.socket = socket;
      this.cable.open();
      const heard = () => { this.heard = { nanos: this.nanos, ms: performance.now() }; };
      heard();
      socket.on('data', (bytes) => {
        heard();
        this.cable?.send(bytes);
      });
      socket.on('close', () => {
        this.socket = null;
        this.cable?.close();
      });
    });
    return new Promise((done) => this.server.listen(port, '127.0.0.1', () => {
      const { port: free } = this.server.address();
      this.name = `tcp:127.0.0.1:${free}`;
      done();
    }));
  }

  /** Runs by the wall clock until `done()` or `end()`. */
  async live(done = () => this.ended) {
    let origin = performance.now() - this.nanos / 1e6;
    while (!done()) {
      const turn = performance.now() + TURN_MS;
      origin = Math.max(origin, performance.now() - this.nanos / 1e6 - BEHIND_MS);
      const waits = () => {
        const silent = this.socket && this.nanos > this.heard.nanos + SILENT_NANOS;
        return silent && performance.now() < this.heard.ms + WAIT_MS || this.nanos / 1e6 >= performance.now() - origin;
      };
      while (performance.now() < turn && !waits()) this.advance(SLICE_NANOS);
      await new Promise((next) => waits() ? setTimeout(next, 1) : setImmediate(next));
    }
  }

  end() {
    this.ended = true;
    this.socket?.destroy();
    this.server?.close();
  }

  /** One command, as the control port takes it; the answer is the state after it. */
  apply(command) {
    const { at_s, ...now } = command;
    if (at_s !== undefined) {
      this.at(at_s * 1e9, () => this.apply(now));
      return this.state();
    }
    for (const [key, value] of Object.entries(now)) {
      const act = ACTS[key];
      if (!act) throw new Error(`no command ${key}: ${Object.keys(ACTS).join(', ')}`);
      act(this, value);
    }
    return this.state();
  }

  state() {
    const { number, longest } = this.chip?.ticks ?? { number: 0, longest: 0 };
    const chip = { time_s: this.nanos / 1e9, power: this.chip !== null, resets: this.resets, ticks: number, longest_tick_cycles: longest };
    return { ...chip, ...this.world.state() };
  }
}

/** Copies known keys. */
const change = (what, into, values) => {
  for (const key of Object.keys(values)) if (!(key in into)) throw new Error(`${what} has no ${key}: ${Object.keys(into).join(', ')}`);
  Object.assign(into, values);
};

const ACTS = {
  get: () => {},
  stop: (bench, pressed) => { bench.world.stop = pressed; },
  push_n: (bench, force) => { bench.world.push_n = force; },
  hand: (bench, hand) => change('the hand', bench.world.hand, hand),
  wires: (bench, wires) => change('the wiring', bench.world.wires, wires),
  cable: (bench, plugged) => {
    // The port is gone, and who has it open is told, as by an operating system.
    bench.socket?.destroy();
    if (plugged) bench.cable.plug();
    else bench.cable.unplug();
  },
  power: (bench, on) => bench.power(on),
  quit: (bench) => bench.end(),
};

/** Answers commands, one JSON line each, with one JSON line. */
export function control(bench, port) {
  const server = net.createServer((socket) => {
    let text = '';
    socket.on('error', () => {});
    socket.on('data', (bytes) => {
      text += bytes;
      const lines = text.split('\n');
      text = lines.pop();
      for (const line of lines) {
        let answer;
        try {
          answer = bench.apply(JSON.parse(line));
        } catch (error) {
          answer = { error: error.message };
        }
        socket.write(`${JSON.stringify(answer)}\n`);
      }
    });
  });
  return new Promise((done) => server.listen(port, '127.0.0.1', () => done(server)));
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const { positionals: [image], values } = parseArgs({
    allowPositionals: true,
    options: {
      line: { type: 'string', default: '4250' },
      control: { type: 'string', default: '4251' },
      device: { type: 'string', default: '{}' },
      number: { type: 'string', default: randomBytes(8).toString('hex') },
      cache: { type: 'boolean', default: false },
    },
  });
  if (!image) {
    console.error('node bench.mjs IMAGE [--line PORT] [--control PORT] [--device JSON] [--number HEX] [--cache]');
    process.exit(2);
  }
  const bench = new Bench(image, JSON.parse(values.device), values.cache, values.number);
  await bench.listen(Number(values.line));
  const server = await control(bench, Number(values.control));
  console.log(`host-cli device info --device ${bench.name}; commands at 127.0.0.1:${server.address().port}`);
  await bench.live();
  server.close();
}
