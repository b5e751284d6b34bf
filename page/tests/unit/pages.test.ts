import assert from "node:assert/strict";
import { test } from "node:test";
import { joined } from "../../src/columns";
import { keyOf } from "../../src/forms";
import { certificate } from "../../src/certificate";
import { isAsked, isRated, sentence } from "../../src/compare";
import { blind } from "../../src/scene";
import { wallFile } from "../../src/design-file";
import { demonstrated } from "../../src/demonstration";
import { textOf } from "../../src/drop";
import { csvOf } from "../../src/export";
import { plotted, readable } from "../../src/names";

test("an experiment file has the keys and floats of the command", () => {
  const text = wallFile({ K: 3000, B: 100, mu: 0.5, T: 1e-3, m: 0.065, b: 3.5, delay: 3e-4, lag: 0, noise: 0, operator: "exact" });
  assert.match(text, /^\[wall\]$/m);
  assert.match(text, /^stiffness_n_per_m = 3000\.0$/m);
  assert.match(text, /^sample_time_s = 0\.001$/m);
  assert.match(text, /^scheme = "full"$/m);
  assert.match(text, /^delay_s = 0\.0003$/m);
  assert.doesNotMatch(text, /lag/);
});

test("a file is read as the command reads it, whatever program has saved it", async () => {
  const wide = (text: string, little: boolean, tail: number[] = []): Blob => {
    const units = new DataView(new ArrayBuffer(2 * text.length));
    [...text].forEach((letter, at) => units.setUint16(2 * at, letter.charCodeAt(0), little));
    return new Blob([units.buffer, Uint8Array.from(tail)]);
  };
  const text = "t;Δ\n0;21 °C\n";
  const one = Uint8Array.from("t;F\n0;21 °C\n", (letter) => letter.charCodeAt(0));
  for (const file of [new Blob([text]), new Blob(["\ufeff", text]), wide(`\ufeff${text}`, true), wide(`\ufeff${text}`, false), wide(`\ufeff${text}`, true, [10])]) assert.equal(await textOf(file), text);
  for (const little of [true, false]) assert.equal(await textOf(wide("time_s\n", little)), "time_s\n");
  assert.equal(await textOf(new Blob([one])), "t;F\n0;21 °C\n");
  assert.deepEqual(await Promise.all(["", "a"].map((short) => textOf(new Blob([short])))), ["", "a"]);
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
  assert.deepEqual(plotted("position_m"), { name: "position, mm", factor: 1000 });
  assert.deepEqual(plotted("stiffness_n_per_m"), { name: "stiffness, N/m", factor: 1 });
});

test("a self-test is shown as a certificate, and nothing else is one", () => {
  const check = { check: "arm", promised: "no force", seen: "0.5 N", ok: false, not_judged: false };
  const unknown = { ...check, check: "watchdog", ok: null, not_judged: true };
  const report = { date: "2026-11-23T10:00:00Z", board: "rp2040", firmware: "0.1.0", firmware_digest: "a1ef9414", holds: false, checks: [check, unknown] };
  const shown = certificate("pico.json", JSON.stringify(report));
  assert.equal(shown?.verdict, "rp2040: not every promise was judged and kept");
  assert.deepEqual(shown.lines.map((line) => ("value" in line ? line.value : line.rows.map((row) => row.slice(0, 2)))), [
    report.date,
    "0.1.0",
    "a1ef9414",
    [
      ["arm", "no"],
      ["watchdog", "not judged"],
    ],
  ]);
  const { firmware_digest: _, ...foreign } = report;
  assert.equal(certificate("moteus.json", JSON.stringify({ ...foreign, holds: true }))?.lines.length, 3);
  for (const other of ["", "time_s,force_n", "[]", "null", JSON.stringify({ ...report, checks: [{}] }), JSON.stringify({ ...report, board: 1 })]) {
    assert.equal(certificate("x.json", other), null, other);
  }
});

test("a sentence is said beside the field that it is about", () => {
  const keys = ["order", "stiffness_n_per_m", "strain", "loading", "columns"];
  assert.equal(keyOf("strain = 5 is not above 0 and at most 1", keys), "strain");
  assert.equal(keyOf("`order` is missing: give a number", keys), "order");
  assert.equal(keyOf("wall.toml:3: stiffness_n_per_m = -1 is below 0; change it, in order to go on", keys), "stiffness_n_per_m");
  assert.equal(keyOf("the columns make no record: give `loading` and an area", keys), "loading");
  assert.equal(keyOf("in order to go on, wait", keys), undefined);
  assert.equal(keyOf("", keys), undefined);
});

test("curves at other times are drawn over each other without joining their gaps", () => {
  const { x, points } = joined([{ time: [0, 2], value: [1, 2] }, { time: [0, 1, 2], value: [3, null, 5] }]);
  assert.deepEqual(x, [0, 1, 2]);
  assert.deepEqual(points.map((line) => [...line]), [[1, undefined, 2], [3, null, 5]]);
});

test("a comparison shows nothing that tells the walls apart, and asks once both were touched", () => {
  const held = { position: 2e-3, hand: 5e-3, force: 0.9, surface: 2e-3 };
  assert.deepEqual(blind(held), { position: 5e-3, hand: NaN, force: 0, surface: 0 });
  // As a softer wall that yields more, and as one that pushes a free probe out.
  assert.deepEqual(blind({ ...held, position: 4e-3, force: 0.3, surface: 4e-3 }), blind(held));
  assert.equal(blind({ ...held, hand: NaN }).position, 0);
  const compared = { running: true, trial: 0, trials: 2, rating_scale: null, rated: 0, right: null, table: "" };
  for (const [wall, touched] of [[0, true], [1, false], [1, true], [2, false], [2, true]] as const) {
    const now = { ...compared, wall, touched };
    assert.equal(isAsked(now), sentence(now).endsWith("which was stiffer?"));
    // A rating is asked for after each touch, and before the answer.
    const rates = { ...now, rating_scale: [0, 10] as [number, number], rated: Math.max(0, wall - 1) };
    assert.deepEqual([isRated(rates), isAsked(rates)], [wall > 0 && touched, false]);
    assert.equal(isRated(rates), sentence(rates).endsWith(`rate wall ${wall}, from 0 to 10`));
    assert.deepEqual([isRated({ ...rates, rated: wall }), isAsked({ ...rates, rated: wall })], [false, isAsked(now)]);
  }
});
