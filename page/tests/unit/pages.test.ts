import assert from "node:assert/strict";
import { test } from "node:test";
import { wallFile } from "../../src/design-file";
import { demonstrated } from "../../src/demonstration";
import { csvOf } from "../../src/export";
import { readable } from "../../src/names";

test("an experiment file has the keys and floats of the command", () => {
  const text = wallFile({ K: 3000, B: 100, mu: 0.5, T: 1e-3, m: 0.065, b: 3.5, delay: 3e-4, lag: 0, noise: 0, operator: "exact" });
  assert.match(text, /^\[wall\]$/m);
  assert.match(text, /^stiffness_n_per_m = 3000\.0$/m);
  assert.match(text, /^sample_time_s = 0\.001$/m);
  assert.match(text, /^scheme = "full"$/m);
  assert.match(text, /^delay_s = 0\.0003$/m);
  assert.doesNotMatch(text, /lag/);
});

test("the demonstration stays in its range and does not jump", () => {
  let before = demonstrated(0);
  for (let t = 0; t < 60; t += 0.01) {
    const now = demonstrated(t);
    assert.ok(now >= -0.0021 && now <= 0.0021);
    assert.ok(Math.abs(now - before) < 1e-4, `${t}`);
    before = now;
  }
});

test("a table of a closed form has all digits of the visible span", () => {
  const curves = { quantity: "force", time_s: [0, 0.001, 0.002], values: [1 / 3, 2 / 3, 1], closed_form: [0.3, 0.6, 1] };
  assert.equal(csvOf(curves, null).split("\n")[1], "0,0.3333333333333333,0.3");
  assert.equal(csvOf(curves, [0.0005, 0.0015]), "time_s,force,closed_form\n0.001,0.6666666666666666,0.6\n");
});

test("names of channels are read with their units", () => {
  assert.equal(readable("contact_force_n"), "contact force, N");
  assert.equal(readable("dissipation_n_s_mu_per_m"), "dissipation, N·s^μ/m");
  assert.equal(readable("limiter"), "limiter");
});
