import assert from "node:assert/strict";
import { test } from "node:test";
import { wallFile } from "../../src/design-file";
import type { Device, Feel, Hello } from "../../src/protocol";
import { address, edited, onDevice, outgoing, reduce, START, type PageEvent, type State } from "../../src/state";

const DEVICE: Device = { mass_kg: 0.065, damping_n_s_per_m: 3.5, delay_s: 1e-3, current_lag_s: 0, friction_n: 0, encoder_resolution_m: 0, sensor_noise_m: 0, sample_time_s: 1e-3 };
const WALL = { order: 1.6, stiffness_n_per_m: 900, dissipation_n_s_mu_per_m: 0.02, scheme: "muir:3", signed: true };
const FELT = { ...DEVICE, ...WALL, environment: { wall: WALL }, title: "a wall", note: null, order_free: true, scale: 1, ghosts: [] } as unknown as Feel;
const hello = { controls: true, feel: null, opens: FELT, device: DEVICE, tissues: [{ name: "tendon", order: 0.2, order_free: true }], ranges: {}, channels: [] } as unknown as Hello;
const after = (events: PageEvent[], state: State = START): State => events.reduce(reduce, state);

test("the file of the server is felt first, unless the address says something else", () => {
  const first = outgoing(after([{ do: "hello", hello }]));
  assert.deepEqual(first?.keys.environment, { wall: WALL });
  // What the device has of the server's is left to it.
  assert.deepEqual(first?.do === "feel.start" && first.keys.device, { mass_kg: 0.065, damping_n_s_per_m: 3.5 });
  const named = outgoing(after([{ do: "address", fragment: "#feel?tissue=tendon" }, { do: "hello", hello }]));
  assert.deepEqual(named?.keys.environment, { tissue: "tendon" });
});

test("another number of the device starts the loop anew with all else as it was", () => {
  const running = after([{ do: "hello", hello }, { do: "sent" }, { do: "felt", feel: FELT, answers: true }]);
  const state = reduce(running, { do: "start", values: onDevice(running, "delay_s", 0) });
  const start = outgoing(state);
  assert.deepEqual(start?.do === "feel.start" && [start.keys.environment, start.keys.device], [{ wall: WALL }, { mass_kg: 0.065, damping_n_s_per_m: 3.5, delay_s: 0 }]);
  assert.match(address(state), /delay=0(&|$)/);
});

test("a wall of Design goes into the loop with its operator, sample time and device", () => {
  const values = new Map(Object.entries({ order: "1.6", K: "900", B: "0.02", scheme: "tustin-muir:3", T: "0.002", m: "0.2", b: "3", delay: "0.001", lag: "0", noise: "1e-6" }));
  const start = outgoing(after([{ do: "hello", hello }, { do: "sent" }, { do: "felt", feel: FELT, answers: true }, { do: "start", values }]));
  assert.deepEqual(start?.keys, {
    environment: { wall: { order: 1.6, stiffness_n_per_m: 900, dissipation_n_s_mu_per_m: 0.02, scheme: "tustin-muir:3" } }, ghosts: ["short", "a3"],
    device: { mass_kg: 0.2, damping_n_s_per_m: 3, delay_s: 0.001, current_lag_s: 0, sensor_noise_m: 1e-6, sample_time_s: 0.002 },
  });
  // As in the file, which the server opens too.
  assert.match(wallFile({ ...START.design, noise: 1e-6 }), /sensor_noise_m = 0\.000001|sensor_noise_m = 1e-6/);
});

test("a file or a log is opened by the server, once", () => {
  const file = { file: { name: "wall.toml", text: "[wall]" } };
  const state = after([{ do: "hello", hello }, { do: "sent" }, { do: "felt", feel: FELT, answers: true }, { do: "open", what: file }]);
  assert.deepEqual([state.view, outgoing(state)], ["feel", { do: "feel.start", keys: { environment: file } }]);
  assert.equal(outgoing(after([{ do: "sent" }, { do: "refused" }], state)), null);
});

test("a tissue is left as large as it can be, unless it was made smaller", () => {
  const start = (fragment: string) => outgoing(after([{ do: "address", fragment }, { do: "hello", hello }]))?.keys.scale;
  assert.deepEqual([start("#feel?tissue=tendon&scale=1"), start("#feel?tissue=tendon&scale=0.001")], [undefined, 0.001]);
});

test("another operator is shown at once", () => {
  const running = after([{ do: "hello", hello }, { do: "sent" }, { do: "felt", feel: FELT, answers: true }]);
  const wall = { ...WALL, scheme: "full", order: 0.5 };
  const shown = edited(reduce(running, { do: "change", change: { environment: { wall } } }));
  assert.deepEqual([shown?.scheme, shown?.order, shown?.mass_kg], ["full", 0.5, 0.065]);
});

test("the wall of the file that the server was given is that of Design, unless the address has another", () => {
  const wall = { order: 1.2, stiffness_n_per_m: 2600, dissipation_n_s_mu_per_m: 0.5 };
  const device = { sample_time_s: 5e-4, mass_kg: 0.2, damping_n_s_per_m: 0.7, delay_s: 1e-3, current_lag_s: 2e-3, sensor_noise_m: 3e-6 };
  const opens = { ...FELT, ...wall, ...device, environment: { wall }, scheme: "full" };
  const greeting = { ...hello, opens } as Hello;
  const { design } = reduce(START, { do: "hello", hello: greeting });
  assert.deepEqual([design.mu, design.K, design.B, design.operator], [1.2, 2600, 0.5, "exact"]);
  assert.deepEqual([design.T, design.m, design.b, design.delay, design.lag, design.noise], [5e-4, 0.2, 0.7, 1e-3, 2e-3, 3e-6]);
  const addressed = reduce(START, { do: "address", fragment: "#design?K=5000" });
  assert.equal(reduce(addressed, { do: "hello", hello: greeting }).design.K, 5000);
});
