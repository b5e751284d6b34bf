/** The host's command against the bench, in one process with it, so that a test turns the world as it likes. */
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { Bench } from './bench.mjs';

export const root = fileURLToPath(new URL('../..', import.meta.url));
const IMAGE = process.env.PICO_IMAGE ?? join(root, 'target/firmware/thumbv6m-none-eabi/release/haptic-rp2040');
/** The image with a load cell. */
export const SENSING = `${IMAGE}-force-sensor`;
export const COMMAND = process.env.HOST_CLI ?? join(root, 'target/debug/host-cli');

/** A bench for one test, with a folder that goes with the test. */
export async function bench(test, device = {}, cached = Boolean(process.env.PICO_CACHE), image = IMAGE) {
  for (const file of [image, COMMAND]) if (!existsSync(file)) throw new Error(`${file} is missing: README.md says how it is built`);
  const folder = mkdtempSync(join(tmpdir(), 'pico-'));
  const made = new Bench(image, device, cached);
  made.folder = folder;
  // What is remembered of a device goes with the test.
  made.options = { cwd: folder, env: { ...process.env, FRACTIONAL_HAPTICS_STATE: join(folder, 'state') } };
  made.hosts = [];
  await made.listen(0);
  test.after(async () => {
    made.end();
    // A host that still runs, or stands still, would write on while its folder goes.
    for (const { child } of made.hosts) child.kill('SIGKILL');
    await Promise.all(made.hosts.map(({ closed }) => closed));
    rmSync(folder, { recursive: true });
  });
  return made;
}

/** Starts the command, or another, the port's name at the place of `PORT`; the bench has to run meanwhile. */
export function start(made, args, heard = () => {}, [command, options] = [COMMAND, made.options]) {
  const child = spawn(command, args.map((word) => word.replace('PORT', made.name)), options);
  const host = { child, out: '', err: '', code: undefined };
  for (const [stream, key] of [[child.stdout, 'out'], [child.stderr, 'err']]) {
    stream.on('data', (text) => {
      host[key] += text;
      heard(String(text), host);
    });
  }
  host.closed = new Promise((done) => child.on('close', (code, signal) => done(host.code = code ?? signal)));
  made.hosts.push(host);
  return host;
}

/** Runs the command to its end. */
export async function run(made, args, heard, command) {
  const host = start(made, args, heard, command);
  await made.live(() => host.code !== undefined);
  return host;
}

/** Runs the bench until something holds, checked each tick; fails after so much emulated time, s. */
export async function until(made, holds, patience_s) {
  const end = made.nanos + patience_s * 1e9;
  await made.live(() => holds() || made.nanos > end);
  if (!holds()) throw new Error(`not within ${patience_s} s of emulated time: ${JSON.stringify(made.state())}`);
}
