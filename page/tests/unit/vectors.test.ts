import assert from "node:assert/strict";
import { test } from "node:test";
import { choices, component, members, strokeOf } from "../../src/vectors";

const TWO = ["position_x_m", "position_y_m", "environment_force_x_n", "environment_force_y_n", "force_x_n", "force_y_n", "force_norm_n", "observed_energy_j", "limiter"];

test("a component knows its vector, a number by itself has none", () => {
  assert.deepEqual(component("force_x_n"), { vector: "force_n", of: "x" });
  assert.deepEqual(component("environment_force_y_n"), { vector: "environment_force_n", of: "y" });
  assert.deepEqual(component("force_norm_n"), { vector: "force_n", of: "norm" });
  for (const alone of ["force_n", "observed_energy_j", "limiter", "x_m", "hand_m"]) assert.equal(component(alone), null, alone);
});

test("vectors can be chosen as one, and every channel by itself", () => {
  const all = choices(TWO);
  assert.deepEqual(all.slice(0, 3), ["position_m", "environment_force_n", "force_n"]);
  assert.deepEqual(all.slice(3), TWO);
  assert.equal(choices(["force_n", "force_x_n", "force_n"]).filter((name) => name === "force_n").length, 1);
});

test("a choice shows its components, of a log with one axis the channel itself", () => {
  assert.deepEqual(members("force_n", TWO), ["force_x_n", "force_y_n", "force_norm_n"]);
  assert.deepEqual(members("force_n", ["position_m", "force_n"]), ["force_n"]);
  assert.deepEqual(members("force_y_n", TWO), ["force_y_n"]);
  assert.deepEqual(members("contact_force_n", TWO), []);
});

test("components are told apart without colour, and those of a further run have its dashes", () => {
  const dashes = ["force_x_n", "force_y_n", "force_z_n"].map((channel) => JSON.stringify(strokeOf(channel, undefined)?.dash ?? null));
  assert.equal(new Set(dashes).size, 3);
  assert.deepEqual(strokeOf("force_y_n", [1, 2])?.dash, [1, 2]);
  assert.equal(strokeOf("limiter", undefined), null);
});
