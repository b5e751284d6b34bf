// The image that would be flashed, spoken to by the host's command; what a hand would feel is read from the pins.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import net from 'node:net';
import { control } from './bench.mjs';
import { bench, run, start, until } from './host.mjs';

/** Force of one step of the PWM, N: 8 N in 10 000. */
const PWM_STEP_N = 8e-4;
const MS = 1e6;

test('from the image to an answer over USB in 5 s of the processor', async (t) => {
  const began = process.cpuUsage();
  const board = await bench(t);
  assert.ok(board.nanos < 20 * MS, `enumerated after ${board.nanos / MS} ms`);
  const info = await run(board, ['device', 'info', '--device', 'PORT', '--json']);
  assert.equal(info.code, 0, info.err);
  assert.equal(JSON.parse(info.out).board, 'rp2040');
  const { user, system } = process.cpuUsage(began);
  assert.ok(user + system < 5e6, `${(user + system) / 1e6} s`);
});

test('the digest is over the flash: a byte that is another makes another', async (t) => {
  const board = await bench(t);
  const digest = async () => {
    const info = await run(board, ['device', 'info', '--device', 'PORT', '--json']);
    return JSON.parse(info.out).firmware_digest;
  };
  const before = await digest();
  assert.match(before, /^[0-9a-f]{8}$/);
  // The patch of the version, on which nothing else depends.
  board.flash[Buffer.from(board.flash).indexOf('haptic-device image\0') + 38]++;
  board.apply({ power: false });
  board.apply({ power: true });
  board.advance(50 * MS);
  assert.match(await digest(), /^[0-9a-f]{8}$/);
  assert.notEqual(await digest(), before);
});

test('two boards at one port are told apart by their flash, and each has its own limits', async (t) => {
  const board = await bench(t);
  const answer = async (...words) => {
    const host = await run(board, [...words, '--device', 'PORT', '--json']);
    assert.equal(host.code, 0, host.err);
    return { ...JSON.parse(host.out), said: host.err };
  };
  const exchange = (number) => {
    board.apply({ power: false });
    board.unique = Buffer.from(number, 'hex');
    board.apply({ power: true });
    board.advance(50 * MS);
  };
  const [first, second] = ['E6612483CB1B9221', 'E6612483CB1B9222'];
  assert.equal((await answer('device', 'info')).serial_number, first);
  await answer('device', 'set', 'force_limit=0.5N');
  exchange(second);
  const info = await answer('device', 'info');
  assert.deepEqual([info.serial_number, info.identity], [second, `rp2040 ${second}`]);
  assert.doesNotMatch((await answer('device', 'get')).said, /forgotten/);
  exchange(first);
  assert.match((await answer('device', 'get')).said, /forgotten limits.*force limit from 500 mN/);
  assert.match((await answer('device', 'forget')).limits, /force_limit_n = 0.5/);
});

test('the self-test finds all promises kept', async (t) => {
  const board = await bench(t);
  const test = await run(board, ['device', 'selftest', '--device', 'PORT', '--json'], (text) => {
    if (text.includes('press the emergency stop')) board.apply({ stop: true });
    if (text.includes('release it')) board.apply({ stop: false });
  });
  assert.equal(test.code, 0, test.err);
  assert.ok(JSON.parse(test.out).checks.every(({ ok }) => ok === true), test.out);
});

test('a relaxation loses nothing, follows the full history, and its pins are what its log says', async (t) => {
  const board = await bench(t);
  const ticks = [];
  board.chip.onTick = () => ticks.push(board.world.state());
  board.world.onEnable = (high) => high && board.apply({ hand: { position_m: 1e-3 } });
  board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 20, speed_m_per_s: 1e-3 } });
  const host = await run(board, ['relax', '--device', 'PORT', '--duration', '2s', 'watchdog=1s', '--out', 'out', '--json']);
  assert.equal(host.code, 0, host.err);
  const report = JSON.parse(host.out);
  assert.equal(report.samples, 2002);
  assert.deepEqual([report.link.samples_lost, report.link.overruns, report.link.from_device.corrupt], [0, 0, 0]);
  // A single-precision sum of some hundred terms against a sum in double precision of the same positions.
  assert.ok(report.max_relative_error < 1e-6, `${report.max_relative_error}`);
  const log = readFileSync(join(board.folder, 'out/relax.csv'), 'utf8').trim().split('\n');
  const [position, force] = ['position_m', 'rendered_force_n'].map((name) => log[0].split(',').indexOf(name));
  const rows = log.slice(1).map((line) => line.split(','));
  const first = ticks.findIndex(({ enabled }) => enabled);
  assert.equal(ticks.filter(({ enabled }) => enabled).length, report.samples, 'enabled in the ticks of the run');
  rows.slice(0, -1).forEach((row, k) => {
    // A byte of samples is up to 25 µs old, and the hand moves at 64 counts a second.
    const counts = Number(row[position]) / board.world.device.encoder_step_m;
    assert.ok(Math.abs(counts - ticks[first + k].count) < 1.01, `tick ${k}: ${counts} counts of ${ticks[first + k].count}`);
  });
  rows.slice(0, -2).forEach((row, k) => {
    // At the end of the next tick its own force is not yet at the amplifier.
    const error = ticks[first + k + 1].force_n + Number(row[force]);
    assert.ok(Math.abs(error) <= 0.51 * PWM_STEP_N, `tick ${k}: ${error} N off`);
  });
});

test('a steady speed has as many counts in each tick of 1.1 ms', async (t) => {
  const board = await bench(t);
  const COUNTS_A_TICK = 44;
  board.world.onEnable = (high) => high && board.apply({ hand: { position_m: 1 } });
  const speed_m_per_s = COUNTS_A_TICK * board.world.device.encoder_step_m / 1.1e-3;
  board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 70, speed_m_per_s } });
  const options = ['--sample-time', '1.1ms', '--duration', '0.5s', '--ramp-time', '0.1s', 'force_limit=0.1', 'watchdog=1s'];
  const host = await run(board, ['relax', '--device', 'PORT', ...options, '--out', 'out']);
  assert.equal(host.code, 0, host.err);
  const [head, ...rows] = readFileSync(join(board.folder, 'out/relax.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
  const counts = rows.map((row) => Math.round(row[head.indexOf('position_m')] / board.world.device.encoder_step_m));
  const steps = counts.slice(101, 400).map((count, k) => count - counts[100 + k]);
  assert.deepEqual([...new Set(steps)], [COUNTS_A_TICK]);
});

/**
 * Cycles of a tick with 200 s of memory at most: at rest, for each byte of four samples in which the encoder moves, and for each count. 1 ms has
 * 40 such bytes and at most 160 counts that are followed, so no tick takes more than 38 000.
 */
const most_cycles = (counts) => 23_500 + 240 * Math.min(counts, 40) + 30 * counts;

for (const cached of [false, true]) {
  test(`a tick with 200 s of memory keeps its cycles at every speed${cached ? ' behind the cache of the flash' : ''}`, async (t) => {
    const board = await bench(t, {}, cached);
    const ticks = [];
    let [before, counts, later] = [0, 0, 0];
    // Where it turns there are more than those between two ticks. While a tick is worked out, the counts are the next one's.
    board.world.onStep = () => {
      const moved = Math.abs(board.world.count - before);
      before = board.world.count;
      if (board.chip.ticks.last > 0) later += moved;
      else counts += moved;
    };
    board.chip.onTick = ({ last }) => {
      if (board.world.enabled) ticks.push({ cycles: last, counts });
      [counts, later] = [later, 0];
    };
    // To and fro, at a speed that grows to 1.35 m/s: 86 counts a tick.
    let place = 0.02;
    const swing = () => {
      if (board.world.enabled) board.apply({ hand: { position_m: place *= -1, speed_m_per_s: Math.min(1.35, 0.05 + ticks.length * 1e-3) } });
      board.at(board.nanos + 60 * MS, swing);
    };
    swing();
    board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 70 } });
    const host = start(board, ['relax', '--device', 'PORT', '--duration', '200s', '--scheme', 'full:1e-6', 'watchdog=1s', '--out', 'out']);
    await until(board, () => ticks.length >= 2000, 5);
    const [most, fastest] = ['cycles', 'counts'].map((key) => Math.max(...ticks.map((tick) => tick[key])));
    t.diagnostic(`the longest of ${ticks.length}: ${most} cycles, at most ${fastest} counts`);
    assert.ok(fastest > 80, `${fastest} counts`);
    // The samples of a tick are those up to 25 µs before it: 4 counts may be of the tick before.
    for (const { cycles, counts } of ticks) assert.ok(cycles <= most_cycles(counts + 4), `${cycles} for ${counts} counts`);
  });
}

/** A run in which 0.2 N and more act; `act` happens then. Times from there on, ms: until enable is low, until no force is left. */
async function felt(t, act, watch_s) {
  const board = await bench(t);
  board.apply({ hand: { stiffness_n_per_m: 500, damping_n_s_per_m: 2, speed_m_per_s: 0.1 } });
  const host = start(board, ['relax', '--device', 'PORT', '--duration', '20s', 'watchdog=500ms', '--out', 'out']);
  await until(board, () => board.world.enabled, 5);
  board.apply({ hand: { position_m: 5e-3 } });
  await until(board, () => board.world.force_n < -0.2, 2);
  const began = board.nanos;
  const seen = { low_ms: Infinity, zero_ms: Infinity, most_n: 0 };
  board.world.onEnable = (high) => { seen.low_ms = high ? Infinity : (board.nanos - began) / MS; };
  board.world.onStep = () => {
    seen.most_n = Math.max(seen.most_n, Math.abs(board.world.force_n));
    if (board.world.force_n !== 0) seen.zero_ms = Infinity;
    else seen.zero_ms = Math.min(seen.zero_ms, (board.nanos - began) / MS);
  };
  act(board, host);
  await until(board, () => board.nanos > began + watch_s * 1e9, watch_s + 1);
  return { board, host, ...seen };
}

for (const [name, act] of [['pressed', { stop: true }], ['with its wire off', { wires: { stop: false } }]]) {
  test(`the emergency stop ${name} disables the amplifier within a tick`, async (t) => {
    const { low_ms, zero_ms } = await felt(t, (board) => board.apply(act), 0.05);
    assert.ok(low_ms <= 1.05, `enable is low after ${low_ms} ms: at most a tick, which reads the pin first`);
    assert.ok(zero_ms <= low_ms + 0.02, `no force after ${zero_ms} ms`);
  });
}

for (const [name, act] of [
  ['the cable is out', (board) => board.apply({ cable: false })],
  ['the host is killed', (board, host) => host.child.kill('SIGKILL')],
  ['the host stands still', (board, host) => host.child.kill('SIGSTOP')],
]) {
  test(`when ${name}, no force is left after the watchdog's time and the stop time`, async (t) => {
    const { zero_ms, most_n, board } = await felt(t, act, 0.8);
    // 500 ms from the last frame, 100 ms to let go, and a tick each.
    assert.ok(zero_ms <= 602, `no force after ${zero_ms} ms`);
    assert.ok(most_n < 1, `${most_n} N on the way`);
    assert.equal(board.state().enabled, false);
    if (board.cable.plugged) return;
    board.apply({ cable: true });
    board.advance(50 * MS);
    const info = await run(board, ['device', 'info', '--device', 'PORT', '--json']);
    assert.match(JSON.parse(info.out).fault, /heard nothing/, info.err);
  });
}

test('a start that hangs before the main loop is a reset, and the next one succeeds', async (t) => {
  const board = await bench(t);
  board.apply({ power: false });
  board.apply({ power: true });
  board.advance(5 * MS);
  assert.equal(board.cable.connected, false, 'it still computes its digest');
  const { mcu } = board.chip;
  mcu.writeUint16(0x20040000, 0xe7fe); // b .
  Object.assign(mcu.core, { PM: true, PC: 0x20040000 });
  board.advance(500 * MS);
  assert.deepEqual([board.resets, board.world.enabled], [0, false]);
  board.advance(600 * MS);
  assert.equal(board.resets, 1);
  const info = await run(board, ['device', 'info', '--device', 'PORT', '--json']);
  assert.equal(JSON.parse(info.out).fault ?? null, null, info.err);
});

test('a tick that does not come is a reset, and no force is left', async (t) => {
  const { low_ms, board } = await felt(t, (board) => { board.chip.mcu.core.enabledInterrupts &= ~(1 << 3); }, 0.1);
  assert.ok(low_ms <= 21.5, `enable is low after ${low_ms} ms: the watchdog's 20, fed after a sleep of 0.5 by a round of less than a tick`);
  assert.equal(board.resets, 1);
  const info = await run(board, ['device', 'info', '--device', 'PORT', '--json']);
  assert.match(JSON.parse(info.out).fault, /watchdog/, 'a reset while armed is latched');
  const refused = await run(board, ['relax', '--device', 'PORT', '--duration', '2s', 'watchdog=1s', '--out', 'again']);
  assert.equal(refused.code, 3, refused.err);
  assert.match(refused.err, /watchdog, and with that the device lost its zero/);
});

test('without power there is no force, and none when it is back', async (t) => {
  const { low_ms, board } = await felt(t, (board) => board.apply({ power: false }), 0.05);
  assert.ok(low_ms <= 0.02 || !board.world.enabled);
  board.apply({ power: true });
  board.advance(50 * MS);
  assert.deepEqual([board.world.enabled, board.world.force_n], [false, 0]);
});

test('the self-test finds a motor with its leads swapped, with a force below the start force', async (t) => {
  const board = await bench(t);
  board.apply({ wires: { motor: 'swapped' } });
  let most_n = 0;
  board.world.onStep = () => { most_n = Math.max(most_n, Math.abs(board.world.force_n)); };
  const test = await run(board, ['device', 'selftest', '--device', 'PORT', '--emergency-stop', 'none', '--json']);
  const { ok, seen } = JSON.parse(test.out).checks.find(({ check }) => check === 'direction');
  assert.equal(ok, false, seen);
  assert.match(seen, /against its force: .* swap/);
  assert.ok(most_n <= 0.1 + PWM_STEP_N, `${most_n} N`);
});

for (const wire of ['encoder_a', 'encoder_b']) {
  test(`${wire} that breaks in a tissue is a fault before the device has been thrown out`, async (t) => {
    const { zero_ms, most_n, board, host } = await felt(t, (board) => {
      // The hand is gone too, and the force of the place where the wire broke would stay.
      board.apply({ wires: { [wire]: false }, hand: { stiffness_n_per_m: 0, damping_n_s_per_m: 0 } });
      board.broke_m = board.world.position_m;
    }, 0.2);
    assert.ok(most_n > 0.2 && most_n < 1, `${most_n} N`);
    assert.ok(zero_ms < 80, `no force after ${zero_ms} ms`);
    assert.ok(Math.abs(board.world.position_m - board.broke_m) < 5e-3, `${board.world.position_m - board.broke_m} m`);
    await until(board, () => host.code !== undefined, 5);
    assert.match(host.err, /one channel of the encoder changes without the other/);
  });
}

test('an encoder wire that is off is a fault when a hand moves the device, and no force was there', async (t) => {
  const board = await bench(t);
  board.apply({ wires: { encoder_a: false }, hand: { stiffness_n_per_m: 500, damping_n_s_per_m: 2, speed_m_per_s: 0.1 } });
  const host = start(board, ['relax', '--device', 'PORT', '--duration', '2s', 'watchdog=1s', '--out', 'out']);
  await until(board, () => board.world.enabled, 5);
  let most_n = 0;
  board.world.onStep = () => { most_n = Math.max(most_n, Math.abs(board.world.force_n)); };
  board.apply({ hand: { position_m: 5e-3 } });
  await until(board, () => !board.world.enabled, 1);
  assert.ok(most_n < 0.05, `${most_n} N`);
  await until(board, () => host.code !== undefined, 5);
  assert.equal(host.code, 1);
  assert.match(host.err, /one channel of the encoder changes without the other/);
  // Mended, but the counts of meanwhile are gone.
  board.apply({ wires: { encoder_a: true }, hand: { position_m: 0 } });
  board.advance(200 * MS);
  const refused = await run(board, ['relax', '--device', 'PORT', '--duration', '2s', 'watchdog=1s', '--out', 'again']);
  assert.equal(refused.code, 3, refused.err);
  assert.match(refused.err, /one channel .* with that the device lost its zero/);
});

test('a board that lost counts refuses to be armed until it is restarted at its zero', async (t) => {
  const relax = ['relax', '--device', 'PORT', '--duration', '0.2s', '--ramp-time', '0.1s', 'watchdog=1s', '--out', 'out', '--overwrite'];
  const { board, host } = await felt(t, (board) => {
    // 3 m/s are 190 000 counts a second, of 160 000 samples.
    board.apply({ hand: { stiffness_n_per_m: 2e4, damping_n_s_per_m: 70, speed_m_per_s: 3, position_m: -0.03 } });
  }, 0.2);
  await until(board, () => host.code !== undefined, 5);
  assert.equal(host.code, 1, host.err);
  assert.match(host.err, /the position jumped/);
  let most_n = 0;
  board.world.onStep = () => { most_n = Math.max(most_n, Math.abs(board.world.force_n)); };
  for (const place_m of [-0.03, -0.0323]) {
    board.apply({ hand: { position_m: place_m } });
    board.advance(100 * MS);
    const refused = await run(board, relax);
    assert.equal(refused.code, 3, refused.err);
    assert.match(refused.err, /with that the device lost its zero: put it at its zero, then switch it off and on/);
  }
  assert.equal(most_n, 0);
  board.apply({ hand: { position_m: 0 } });
  board.advance(100 * MS);
  board.apply({ power: false });
  board.apply({ power: true });
  board.advance(50 * MS);
  const again = await run(board, relax);
  assert.equal(again.code, 0, again.err);
});

test('the control port takes JSON lines', async (t) => {
  const board = await bench(t);
  const server = await control(board, 0);
  t.after(() => server.close());
  const socket = net.connect(server.address().port, '127.0.0.1');
  const lines = [];
  socket.on('data', (bytes) => lines.push(...String(bytes).trim().split('\n').map(JSON.parse)));
  socket.write('{"push_n": 0.035, "at_s": 0.02}\n{"spring": 1}\n{"get": true}\n');
  await board.live(() => lines.length === 3);
  socket.destroy();
  assert.match(lines[1].error, /no command spring/);
  board.advance(1e9 - board.nanos);
  // Terminal velocity f/b = 10 mm/s.
  assert.ok(Math.abs(board.state().velocity_m_per_s - 0.01) < 1e-6);
});
