/**
 * One axis behind the pins: amplifier, motor, what it moves, a hand, and the encoder.
 *
 * ```text
 * m·x'' = s·k·i + f_push + k_h·(x_h − x) + b_h·(x_h' − x') − b·x' + r,   |r| ≤ F_c
 * τ·i' = i_c − i          i_c = 2 A · (d − 0.5) / 0.4 while enabled, else 0
 * count = ⌊x / q + 1/2⌋,  channels B A: 00 01 11 10
 * ```
 * - *Symbols*: x position m; m mass kg; i current A; k newtons per ampere; s 1, or −1 with the motor's leads swapped;
 *   f_push a force from outside N; x_h where the hand wants to be m, which it reaches at its speed m/s; k_h, b_h its
 *   stiffness N/m and damping N·s/m; b damping N·s/m; r friction, F_c its bound N; τ time constant of the current s;
 *   d duty of the command pin over its last whole period; q encoder step m.
 * - *Amplifier*: reads a pulse when it is over, so at most 200 µs late. A command that does not change its level for two
 *   periods, and an enable that is not high, are no current.
 * - *Load cell*, where a sensor's range is given: f_push and the hand's force, an offset and white noise beside them, at GP26 in
 *   4096 steps from −range to range.
 * - *Wires*: a broken encoder wire is high, by the pull-up; the stop is a contact that opens, so its broken wire stops.
 * - *Integration*: steps of 10 µs of emulated time. Damping by the trapezoid rule, positions half a step after velocities
 *   (leapfrog), so of second order: errors are 1e-7 of a motion of 100 rad/s. Friction as the simulated plant of
 *   `haptic-loop` has it (Moreau 1988): it ends a step at rest if it can. Not the plant's matrix exponential, because
 *   forces change within its sample here, at any edge of a pin.
 */
const STEP_S = 1e-5;
const PERIOD_NANOS = 200e3;
const GRAY = [0, 1, 3, 2];

/** The device of the example, as `firmware/examples/rp2040/src/axis.rs` has it, around a light handle. */
export const DEVICE = {
  mass_kg: 0.065,
  damping_n_s_per_m: 3.5,
  friction_n: 0,
  lag_s: 0,
  newtons_per_ampere: 4,
  encoder_step_m: 1.5707963e-5,
  sensor_range_n: 0,
  sensor_offset_n: 0,
  sensor_noise_n: 0,
};
const PINS = { a: 2, b: 3, command: 4, enable: 6, stop: 7 };

export class World {
  constructor(device = {}) {
    for (const key of Object.keys(device)) if (!(key in DEVICE)) throw new Error(`a device has no ${key}: ${Object.keys(DEVICE).join(', ')}`);
    this.device = { ...DEVICE, ...device };
    this.hand = { stiffness_n_per_m: 0, damping_n_s_per_m: 0, position_m: 0, speed_m_per_s: Infinity };
    this.wires = { encoder_a: true, encoder_b: true, stop: true, motor: 'right' };
    this.stop = false;
    this.push_n = 0;
    this.position_m = 0;
    this.velocity_m_per_s = 0;
    this.current_a = 0;
    this.hand_at_m = 0;
    this.touched_n = 0;
    this.duty = 0.5;
    this.enabled = false;
    /** Called after each step, and when the enable changes. */
    this.onStep = () => {};
    this.onEnable = () => {};
  }

  /** Puts a chip between amplifier and encoder, or none. */
  attach(chip) {
    this.chip = chip;
    this.enabled = false;
    this.pulse = { rise: null, edge: null };
    if (!chip) return;
    const { gpio } = chip.mcu;
    gpio[PINS.command].addListener((level) => this.edge(level === 1));
    gpio[PINS.enable].addListener((level) => {
      this.enabled = level === 1;
      this.onEnable(this.enabled);
    });
    this.setPins();
    this.loadCell(chip.mcu.adc);
    const alarm = chip.clock.createAlarm(() => {
      this.step();
      alarm.schedule(STEP_S * 1e9);
    });
    alarm.schedule(STEP_S * 1e9);
  }

  /** What the converter reads of the load cell, each time it is asked; equal seeds make equal noise. */
  loadCell(converter) {
    const { sensor_range_n: range, sensor_offset_n: offset, sensor_noise_n: noise } = this.device;
    if (range === 0) return;
    const convert = converter.onADCRead;
    let seed = 1;
    const share = () => (seed = Math.imul(seed, 1664525) + 1013904223 >>> 0) / 2 ** 32;
    converter.onADCRead = (channel) => {
      // Twelve shares of variance 1/12 each.
      let normal = -6;
      for (let n = 0; n < 12; n++) normal += share();
      const counts = 2048 * (1 + (this.touched_n + offset + noise * normal) / range);
      converter.channelValues[0] = Math.max(0, Math.min(4095, Math.round(counts)));
      convert(channel);
    };
  }

  edge(high) {
    const { pulse, chip: { nanos } } = this;
    pulse.edge = nanos;
    if (!high) pulse.width = nanos - pulse.rise;
    else {
      if (pulse.rise !== null) this.duty = pulse.width / (nanos - pulse.rise);
      pulse.rise = nanos;
    }
  }

  /** Current that the amplifier is asked for, A. */
  commanded() {
    const alive = this.enabled && this.pulse.edge !== null && this.chip.nanos - this.pulse.edge < 2 * PERIOD_NANOS;
    return alive ? 2 * (this.duty - 0.5) / 0.4 : 0;
  }

  /** Force of the motor, N. */
  get force_n() {
    return (this.wires.motor === 'swapped' ? -1 : 1) * this.device.newtons_per_ampere * this.current_a;
  }

  step() {
    const { device, hand } = this;
    const h = STEP_S;
    const left = device.lag_s > 0 ? (this.current_a - this.commanded()) * Math.exp(-h / device.lag_s) : 0;
    this.current_a = this.commanded() + (Math.abs(left) < 1e-12 ? 0 : left);
    const reach = hand.speed_m_per_s * h;
    const moved = Math.max(-reach, Math.min(reach, hand.position_m - this.hand_at_m));
    this.hand_at_m += moved;
    const held = hand.stiffness_n_per_m > 0 || hand.damping_n_s_per_m > 0;
    const speed = held && Number.isFinite(hand.speed_m_per_s) ? moved / h : 0;
    const damping = device.damping_n_s_per_m + hand.damping_n_s_per_m;
    const push = this.push_n + hand.stiffness_n_per_m * (this.hand_at_m - this.position_m) + hand.damping_n_s_per_m * speed;
    const force = this.force_n + push;
    this.touched_n = push - hand.damping_n_s_per_m * this.velocity_m_per_s;
    const half = damping * h / (2 * device.mass_kg);
    const free = ((1 - half) * this.velocity_m_per_s + force * h / device.mass_kg) / (1 + half);
    const braking = device.friction_n * h / device.mass_kg / (1 + half);
    this.velocity_m_per_s = Math.abs(free) <= braking ? 0 : free - Math.sign(free) * braking;
    this.position_m += h * this.velocity_m_per_s;
    this.setPins();
    this.onStep();
  }

  get count() {
    return Math.floor(this.position_m / this.device.encoder_step_m + 0.5);
  }

  setPins() {
    const { count, wires, chip } = this;
    const levels = GRAY[count & 3];
    const a = !wires.encoder_a || (levels & 1) !== 0;
    const b = !wires.encoder_b || (levels & 2) !== 0;
    const stop = this.stop || !wires.stop;
    const all = a | b << 1 | stop << 2;
    if (!chip || this.levels === all && this.driven === chip) return;
    this.levels = all;
    this.driven = chip;
    [[PINS.a, a], [PINS.b, b], [PINS.stop, stop]].forEach(([pin, level]) => chip.mcu.gpio[pin].setInputValue(level));
  }

  /** What can be seen from outside. */
  state() {
    const { position_m, velocity_m_per_s, force_n, count, duty, enabled } = this;
    return { position_m, velocity_m_per_s, force_n, count, duty, enabled };
  }
}
