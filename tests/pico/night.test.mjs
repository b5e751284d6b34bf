// Runs that take their time: the loop closed over PWM and encoder, against the analysis and the simulated plant.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { COMMAND, SENSING, bench, root, run, start, until } from './host.mjs';
import { DEVICE } from './world.mjs';

const STEP_M = DEVICE.encoder_step_m;

/**
 * From a measurement to the force that answers it, as the pins have it, µs: age of the newest whole byte of samples, and
 * time until the amplifier has the pulse. Counts of the encoder at the ticks stand in `board.counts`.
 */
function delays(board) {
  const [ages, latencies] = [[], []];
  const machine = board.chip.mcu.pio[0].machines[0];
  let duty = 0.5;
  board.counts = [];
  board.chip.onTick = ({ began }) => {
    if (!board.world.enabled) return;
    board.counts.push(board.world.count);
    const since = machine.inputShiftCount / 2 / 160e3 * 1e9 - (board.chip.nanos - began);
    ages.push((since % 25e3 + 25e3) % 25e3);
  };
  board.world.onStep = () => {
    if (board.world.duty !== duty && board.world.enabled) latencies.push(board.chip.nanos - board.chip.ticks.began);
    duty = board.world.duty;
  };
  const middle = (values) => values.sort((one, next) => one - next)[values.length >> 1];
  return () => (middle(ages) + middle(latencies)) / 1e3;
}

/** A wall of order 0.5 on the device of the example, pushed with 1 N; the push begins 0.6 s after the run, at a tick. */
async function wall(t, { stiffness, dissipation, duration_s, more = '' }) {
  const board = await bench(t);
  const file = (extra) => `[wall]
mass_kg = ${DEVICE.mass_kg}
damping_n_s_per_m = ${DEVICE.damping_n_s_per_m}
sample_time_s = 0.001
order = 0.5
stiffness_n_per_m = ${stiffness}
dissipation_n_s_mu_per_m = ${dissipation}
force_limit_n = 8
duration_s = ${duration_s}
encoder_resolution_m = ${STEP_M}
${extra}`;
  writeFileSync(join(board.folder, 'wall.toml'), file(more));
  const delay_us = delays(board);
  const { onTick } = board.chip;
  board.chip.onTick = (tick) => {
    if (board.world.enabled && !board.pushed) {
      board.pushed = true;
      // The plant of the simulation is read at the tick, the encoder a little earlier.
      board.at(board.before + tick.began + 600e6 - 11.4e3, () => board.apply({ push_n: 1 }));
    }
    onTick(tick);
  };
  const host = await run(board, ['run', 'wall.toml', '--device', 'PORT', 'watchdog=1s', '--force-unstable', '--out', 'out', '--json']);
  const columns = (path) => readFileSync(join(board.folder, path), 'utf8').trim().split('\n').map((line) => line.split(','));
  return { board, host, file, columns, delay_us: delay_us() };
}

test('twenty seconds of a wall lose nothing and move as the simulated plant does, within an encoder step', async (t) => {
  const law = { stiffness: 1000, dissipation: 10, duration_s: 20 };
  const { board, host, file, columns, delay_us } = await wall(t, law);
  assert.equal(host.code, 0, host.err);
  const { link } = JSON.parse(host.out);
  assert.deepEqual([link.samples_lost, link.overruns, link.from_device.corrupt], [0, 0, 0]);
  writeFileSync(join(board.folder, 'sim.toml'), file(`delay_s = ${delay_us * 1e-6}\nimpact_m_per_s = 0`));
  execFileSync(COMMAND, ['run', 'sim.toml', '--out', 'sim', '-q'], { cwd: board.folder });
  const counts = (path) => columns(path).slice(1).map(([, position]) => Math.round(position / STEP_M));
  const [real, simulated] = ['out/wall.csv', 'sim/wall.csv'].map(counts);
  const apart = real.slice(600).map((count, tick) => Math.abs(count - simulated[tick]));
  const furthest = Math.max(...apart);
  t.diagnostic(`${apart.length} ticks, delay ${delay_us.toFixed(1)} µs, at most ${furthest} steps apart`);
  assert.ok(Math.max(...real) > 60, 'it moved');
  assert.ok(furthest <= 1, `${furthest} steps`);
});

/** Factor by which the analysis lets stiffness and dissipation of a wall grow together. */
function margin_of({ stiffness, dissipation }, delay_us) {
  const args = ['analyze', 'stability', '--order', '0.5', '--mass', `${DEVICE.mass_kg}kg`, '--damping', `${DEVICE.damping_n_s_per_m}`,
    '--sample-time', '1ms', '--stiffness', `${stiffness}`, '--dissipation', `${dissipation}`, '--delay', `${delay_us}us`, '--json'];
  return JSON.parse(execFileSync(COMMAND, args)).gain_margin;
}

test('a wall 5 % below what the analysis allows rests, and one 5 % beyond bounces', async (t) => {
  const base = { stiffness: 2000, dissipation: 10, duration_s: 4 };
  const { delay_us } = await wall(t, { ...base, duration_s: 1 });
  const gain_margin = margin_of(base, delay_us);
  const swing = async (share) => {
    const [stiffness, dissipation] = [base.stiffness, base.dissipation].map((value) => value * gain_margin * share);
    const { board } = await wall(t, { ...base, stiffness, dissipation });
    const counts = board.counts.slice(-200);
    return { board, steps: Math.max(...counts) - Math.min(...counts) };
  };
  const [below, beyond] = [await swing(0.95), await swing(1.05)];
  t.diagnostic(`delay ${delay_us.toFixed(1)} µs, margin ${gain_margin.toFixed(3)}: ${below.steps} steps below, ${beyond.steps} beyond`);
  // At rest the encoder itself may keep up a swing where its gain by the describing function, 2/(πA)·Σ √(1 − (t/A)²) over its thresholds t,
  // is 1/0.95 = 1.053: at most 1.072 over 4 steps, 1.049 over 5 (a swing about the middle between two counts), 1.036 over 6. The delay is
  // known to 1 µs, which moves the margin by 0.3 %, so 5 steps can be and 6 cannot.
  assert.ok(below.steps <= 5, `${below.steps} steps from end to end`);
  assert.ok(beyond.steps > 50, `${beyond.steps} steps from end to end`);
  assert.deepEqual([beyond.board.world.enabled, beyond.board.world.force_n], [false, 0]);
});

test('a search for the stiffest wall finds on the device what the analysis promises', async (t) => {
  const { delay_us } = await wall(t, { stiffness: 1000, dissipation: 10, duration_s: 1 });
  const board = await bench(t);
  // Between two trials a hand holds the device where the wall begins; in one a weight pushes.
  const holds = { stiffness_n_per_m: 2e4, damping_n_s_per_m: 70, position_m: 0, speed_m_per_s: 0.2 };
  const away = { stiffness_n_per_m: 0, damping_n_s_per_m: 0 };
  board.apply({ hand: holds });
  const trials = [];
  let trial;
  board.world.onEnable = (high) => {
    if (high) {
      const mine = trial = { counts: [], forces: [] };
      board.at(board.nanos + 600e6, () => mine === trial && board.world.enabled && board.apply({ hand: away, push_n: 1 }));
    } else {
      trials.push(trial);
      // It takes it where it is.
      board.world.hand_at_m = board.world.position_m;
      board.apply({ hand: holds, push_n: 0 });
    }
  };
  board.chip.onTick = () => {
    if (!board.world.enabled) return;
    trial.counts.push(board.world.count);
    trial.forces.push(board.world.force_n);
  };
  writeFileSync(join(board.folder, 'model.toml'), `[device]
mass_kg = ${DEVICE.mass_kg}
damping_n_s_per_m = ${DEVICE.damping_n_s_per_m}
delay_s = ${delay_us * 1e-6}
encoder_resolution_m = ${STEP_M}
`);
  const args = ['zwidth', '--device', 'PORT', '--device-model', 'model.toml', '--orders', '0.5', '--points', '2', '--force-limit', '3N'];
  const host = await run(board, [...args, 'duration=3s', 'watchdog=1s', '--json']);
  assert.equal(host.code, 0, host.err);
  const swing = (values) => Math.max(...values) - Math.min(...values);
  const last = trials.map(({ counts, forces }) => [counts, forces].map((values) => values.slice(2600, 3000)));
  const rests = last.filter(([counts]) => swing(counts) <= 4);
  assert.ok(rests.length >= 4 && last.length >= rests.length + 4, `${rests.length} of ${last.length} at rest`);
  for (const [, forces] of rests) {
    const mean = forces.reduce((sum, force) => sum + force) / forces.length;
    assert.ok(Math.abs(mean + 1) < 0.02, `${mean} N against a push of 1 N`);
  }
  // Without dissipation: with much of it the steps of the encoder end the rest, which the analysis does not know.
  const [{ stiffness_max }] = JSON.parse(host.out).orders[0].boundary;
  const margin = margin_of({ stiffness: stiffness_max, dissipation: 0 }, delay_us);
  t.diagnostic(`${last.length} trials, ${rests.length} at rest; ${stiffness_max.toFixed(0)} N/m, of ${(stiffness_max * margin).toFixed(0)} by the analysis`);
  // In the 2 s that a trial has, an oscillation next to the margin does not die away.
  assert.ok(margin > 0.98 && margin < 1.2, `margin ${margin}`);
});

test('twenty seconds of a relaxation lose nothing and follow the full history', async (t) => {
  const board = await bench(t);
  board.world.onEnable = (high) => high && board.apply({ hand: { position_m: 1e-3 } });
  board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 20, speed_m_per_s: 1e-3 } });
  const host = await run(board, ['relax', '--device', 'PORT', '--duration', '20s', 'watchdog=1s', '--out', 'out', '--json']);
  assert.equal(host.code, 0, host.err);
  const report = JSON.parse(host.out);
  assert.deepEqual([report.link.samples_lost, report.link.overruns, report.link.from_device.corrupt], [0, 0, 0]);
  assert.ok(report.max_relative_error < 1e-6, `${report.max_relative_error}`);
});

test('a relaxation with its loop on the host loses nothing either', async (t) => {
  const board = await bench(t);
  board.world.onEnable = (high) => high && board.apply({ hand: { position_m: 1e-3 } });
  board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 20, speed_m_per_s: 1e-3 } });
  const options = ['--loop', 'host', '--duration', '4s', 'watchdog=1s', 'max_age_ticks=1000', '--out', 'out', '--json'];
  const host = await run(board, ['relax', '--device', 'PORT', ...options]);
  assert.equal(host.code, 0, host.err);
  // How old its forces are is the host's affair, and that of what else the machine does.
  const { link, peak_force_n } = JSON.parse(host.out);
  assert.deepEqual([link.samples_lost, link.overruns, link.from_device.corrupt], [0, 0, 0]);
  assert.ok(peak_force_n > 0.1, `${peak_force_n} N`);
});

test('a measurement finds the world: mass and damping to 5 %, delay to 0.1 sample, lag to 20 %', async (t) => {
  const world = { friction_n: 0.1, lag_s: 5e-4 };
  const board = await bench(t, world);
  const delay_us = delays(board);
  const options = ['--force-limit', '8N', '--box', '20mm', 'watchdog=1s', 'max_age_ticks=1000', '--out', 'device.toml'];
  const host = await run(board, ['device', 'measure', '--device', 'PORT', ...options]);
  assert.equal(host.code, 0, host.err);
  const toml = readFileSync(join(board.folder, 'device.toml'), 'utf8');
  const found = (key) => Number(toml.match(new RegExp(`^${key} = (.*)$`, 'm'))[1]);
  const within = (key, value, tolerance) => {
    t.diagnostic(`${key} ${found(key)}, true ${value}`);
    assert.ok(Math.abs(found(key) - value) <= tolerance, `${key} ${found(key)} for ${value}`);
  };
  within('mass_kg', DEVICE.mass_kg, 0.05 * DEVICE.mass_kg);
  within('damping_n_s_per_m', DEVICE.damping_n_s_per_m, 0.05 * DEVICE.damping_n_s_per_m);
  within('current_lag_s', world.lag_s, 0.2 * world.lag_s);
  within('delay_s', delay_us() * 1e-6, 1e-4);
});

/** Runs a test of the workspace that is made for this. */
async function cargo(board, name, ticks = '100000') {
  const args = ['test', '--quiet', '--locked', '--test', 'firmware', '--', '--ignored', '--nocapture', '--exact', name];
  const env = { ...process.env, PICO_LINE: board.name, PICO_TICKS: process.env.PICO_TICKS ?? ticks };
  const host = await run(board, args, undefined, ['cargo', { cwd: root, env }]);
  assert.equal(host.code, 0, host.out + host.err);
  return host;
}

test('as the master of a teleoperation its hand feels coupler and remote spring in series', async (t) => {
  const board = await bench(t);
  board.apply({ hand: { stiffness_n_per_m: 500, damping_n_s_per_m: 20, speed_m_per_s: 0.05 } });
  const felt = [];
  board.world.onEnable = (high) => {
    if (!high) return;
    [4e-3, -3e-3, 0].forEach((position_m, i) => {
      board.at(board.nanos + i * 1300e6 + 100e6, () => board.apply({ hand: { position_m } }));
      board.at(board.nanos + i * 1300e6 + 1280e6, () => felt.push(board.state()));
    });
  };
  const host = await cargo(board, 'pico::by_night_a_pico_is_the_master_of_a_teleoperation');
  t.diagnostic(host.out.match(/given.*/)[0]);
  assert.equal(felt.length, 3);
  for (const { position_m, force_n } of felt) {
    // 200 and 100 N/m; a count and a step of the PWM are 1.8 mN, and both couplers see the positions of a tick ago.
    const promised = -200 / 3 * position_m;
    t.diagnostic(`${(1e3 * position_m).toFixed(3)} mm: ${force_n.toFixed(4)} N, promised ${promised.toFixed(4)} N`);
    assert.ok(Math.abs(force_n - promised) < 0.01, `${force_n} N for ${promised} N`);
  }
  assert.ok(Math.abs(felt[0].position_m) > 3e-3 && Math.abs(felt[1].position_m) > 2e-3, 'it moved');
  assert.deepEqual([board.world.enabled, board.world.force_n], [false, 0]);
});

test('a hundred thousand ticks have the forces of the host and of a Cortex-M4F in QEMU, bit for bit', async (t) => {
  const board = await bench(t);
  board.apply({ hand: { stiffness_n_per_m: 2000, damping_n_s_per_m: 5 } });
  const swing = () => {
    const turn = 2 * Math.PI * board.nanos / 1e9;
    // At rest at zero, where a run may start, until it has.
    if (board.world.enabled) board.world.hand.position_m = 1.5e-3 * Math.sin(1.3 * turn) + 1e-3 * Math.sin(0.07 * turn);
    board.at(board.nanos + 1e6, swing);
  };
  swing();
  const host = await cargo(board, 'pico::by_night_a_pico_has_the_forces_of_the_host_and_of_a_cortex_m4f_bit_for_bit');
  t.diagnostic(host.out.match(/\d+ ticks.*/)[0]);
});

test('a controller on the board has the bits of the host, in no longer a tick than promised', async (t) => {
  const host = await cargo(await bench(t), 'pico::by_night_a_pico_has_the_bits_of_the_hosts_controller_within_its_promised_tick', '10000');
  t.diagnostic(host.out.match(/\d+ ticks.*/)[0]);
});

/** Uniform in [0, 1), the same in every run: a counter through a mixer (Steele, Lea, Flood 2014, in 32 bits). */
function chance(seed) {
  let state = seed;
  return () => {
    state = state + 0x6d2b79f5 | 0;
    let mixed = Math.imul(state ^ state >>> 15, 1 | state);
    mixed = mixed + Math.imul(mixed ^ mixed >>> 7, 61 | mixed) ^ mixed;
    return ((mixed ^ mixed >>> 14) >>> 0) / 2 ** 32;
  };
}

test('a hundred thousand corrupted frames among the host\'s own change nothing', async (t) => {
  const [FRAMES, EVERY_NANOS] = [1e5, 250e3];
  const board = await bench(t);
  const random = chance(7);
  const said = [];
  let frame = [];
  const send = board.cable.send.bind(board.cable);
  board.cable.send = (bytes) => {
    for (const byte of bytes) {
      if (byte !== 0) frame.push(byte);
      else {
        if (frame.length > 4) said.push(frame);
        frame = [];
      }
    }
    send(bytes);
  };
  let sent = 0;
  const inject = () => {
    // Between two frames of the host, one that it has said, with one to three bits turned.
    if (said.length > 0 && frame.length === 0 && board.cable.toChip.length < 256 && sent < FRAMES) {
      const bad = [...said[Math.floor(random() * said.length)]];
      const below = (limit) => Math.floor(random() * limit);
      for (let flips = 1 + below(3); flips > 0; flips--) bad[below(bad.length)] ^= 1 << below(8);
      send([...bad, 0]);
      sent++;
    }
    board.at(board.nanos + EVERY_NANOS, inject);
  };
  board.at(board.nanos, inject);
  board.world.onEnable = (high) => high && board.apply({ hand: { position_m: 1e-3 } });
  board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 20, speed_m_per_s: 1e-3 } });
  const host = await run(board, ['relax', '--device', 'PORT', '--duration', '27s', 'watchdog=1s', '--out', 'out', '--json']);
  assert.equal(host.code, 0, host.err);
  const report = JSON.parse(host.out);
  t.diagnostic(`${sent} sent, ${report.link.to_device.corrupt} found corrupt`);
  assert.equal(sent, FRAMES);
  assert.deepEqual([report.link.samples_lost, report.link.overruns, board.resets], [0, 0, 0]);
  assert.ok(report.max_relative_error < 1e-6, `${report.max_relative_error}`);
});

test('the first hour as the guide prints it, on a slide that rubs and has a load cell: nothing stands still without a word', async (t) => {
  const slide = { friction_n: 0.3, sensor_range_n: 20, sensor_offset_n: 0.2, sensor_noise_n: 0.002 };
  const board = await bench(t, slide, undefined, SENSING);
  const step = async (line, code, words) => {
    const { out, err, code: ended } = await run(board, `${line} --device PORT`.split(' '), (text) => {
      if (text.includes('press the emergency stop')) board.apply({ stop: true });
      if (text.includes('release it')) board.apply({ stop: false });
    });
    t.diagnostic(`${line}: ${ended} ${err.trim().split('\n').join(' | ')}`);
    assert.equal(ended, code, err);
    assert.match(out + err, words);
    return out;
  };
  await step('device set force_limit=0.5N force_rate_limit=20N/s workspace=-20mm:20mm speed_limit=0.25 stop_time=0.1s', 0, /500 mN/);
  await step('device selftest', 3, /hardly moved under 0.1 N/);
  await step('device selftest --force-limit 0.4N --out first.md', 0, /mm with its force/);
  const form = readFileSync(join(board.folder, 'first.md'), 'utf8');
  assert.match(form, new RegExp(`host-cli device measure --device ${board.name} --force-limit 2.5N`));
  const measure = 'watchdog=1s max_age_ticks=1000 --out device.toml';
  const held = await run(board, `device measure --device PORT --force-limit 2.5N ${measure}`.split(' '));
  t.diagnostic(held.err);
  assert.equal(held.code, 1, held.err);
  // What it asks for, then back: two fingers hold half a newton beside the friction.
  const [, limit, own, rate] = held.err.match(/began to move at 3\d\d(?:\.\d)? mN, .* give --force-limit (\S+), and the device (\S+) N instead of its own 500 mN, and (\S+) N\/s/);
  await step(`device set force_limit=${own}N force_rate_limit=${rate}`, 0, /loosened/);
  await step(`device measure --force-limit ${limit}N ${measure}`, 0, /friction/);
  await step('device set force_limit=0.8N force_rate_limit=20N/s', 0, /800 mN/);
  const found = Number(readFileSync(join(board.folder, 'device.toml'), 'utf8').match(/^friction_n = (.*)$/m)[1]);
  assert.ok(Math.abs(found - slide.friction_n) < 0.02, `${found} N of friction`);
  writeFileSync(join(board.folder, 'first-wall.toml'), readFileSync(join(root, 'docs/guide/src/first-time.md'), 'utf8').match(/```toml first-wall.toml\n([^]*?)```/)[1]);
  const wall = 'run first-wall.toml push=0.4N force_limit=0.8N watchdog=1s';
  const away = { stiffness_n_per_m: 0, damping_n_s_per_m: 0 };
  // A hand puts the handle where the wall begins on both sides, and lets it rest there.
  const home = async () => {
    board.world.onEnable = () => {};
    board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 70, speed_m_per_s: 0.1, position_m: 0 } });
    const { world } = board;
    await until(board, () => Math.abs(world.position_m) < 1e-4 && Math.abs(world.velocity_m_per_s) < 1e-4, 10);
  };
  await home();
  board.apply({ hand: away });
  const alone = JSON.parse(await step(`${wall} duration=1s --out alone --json`, 0, /nobody touched it/));
  assert.equal(alone.felt.contacts, 0, JSON.stringify(alone.felt));
  // A finger that goes 8 mm into the wall, when the run has begun for certain.
  const finger = async () => {
    await home();
    board.apply({ hand: { stiffness_n_per_m: 300, damping_n_s_per_m: 2, speed_m_per_s: 0.01 } });
    board.world.onEnable = (high) => high && board.at(board.nanos + 2e9, () => board.apply({ hand: { position_m: 8e-3 } }));
  };
  await finger();
  const felt = JSON.parse(await step(`${wall} duration=5s --out wall --json`, 0, /felt/));
  assert.ok(felt.felt.contacts > 0 && felt.felt.peak_force_n > 0.2, JSON.stringify(felt.felt));
  t.diagnostic(JSON.stringify(felt.felt));
  // The cable, then the program, is taken away while it pushes: the watchdog of a second takes the force.
  for (const [words, take] of [
    ['the cable is out', () => board.apply({ cable: false })],
    ['the program is killed', (host) => host.child.kill('SIGKILL')],
  ]) {
    await finger();
    const host = start(board, `${wall} duration=60s --out ${words.replaceAll(' ', '-')} --device PORT`.split(' '));
    await until(board, () => board.world.force_n < -0.2, 20);
    const [from_n, began] = [board.world.force_n, board.nanos];
    take(host);
    await until(board, () => board.world.force_n === 0 && !board.world.enabled, 3);
    t.diagnostic(`${words}: ${from_n.toFixed(3)} N, gone after ${((board.nanos - began) / 1e6).toFixed(0)} ms`);
    assert.ok(board.nanos - began < 1.2e9);
    board.world.onEnable = () => {};
    await board.live(() => host.code !== undefined);
    t.diagnostic(`${words}: ${host.code} ${host.err.trim()}`);
    if (!board.cable.plugged) board.apply({ cable: true });
    await until(board, () => board.cable.connected, 5);
    // The device says what it was, and goes on.
    await step('device info', 0, /silent|heard nothing|2/);
  }
});
