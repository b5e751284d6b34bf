import assert from "node:assert/strict";
import { test } from "node:test";
import { bytes, duration, niceStep, number, plain, quantity, steady, tickTexts } from "../../src/format";

test("three significant digits, whatever the size", () => {
  const cases: [number, string][] = [
    [0, "0"], [0.0761, "0.0761"], [1, "1.00"], [9.996, "10.0"], [99.96, "100"], [12345, "12345"],
    [-0.5, "−0.500"], [1e-5, "1.00·10⁻⁵"], [2.5e7, "2.50·10⁷"], [Infinity, "∞"], [NaN, "–"],
  ];
  for (const [value, text] of cases) assert.equal(number(value), text);
  assert.equal(number(null), "–");
});

test("a unit always, with a prefix where it has one", () => {
  const plainSpace = (text: string): string => text.replace(/\u202f/g, " ");
  assert.equal(plainSpace(quantity(0.001, "m")), "1.00 mm");
  assert.equal(plainSpace(quantity(-2.1e-4, "J")), "−210 µJ");
  assert.equal(plainSpace(quantity(3000, "N/m")), "3.00 kN/m");
  assert.equal(plainSpace(quantity(999.6, "Pa")), "1.00 kPa");
  assert.equal(plainSpace(quantity(999.4, "Pa")), "999 Pa");
  assert.equal(plainSpace(quantity(0.065, "kg")), "0.0650 kg");
  assert.equal(plainSpace(quantity(173, "N·s^μ/m")), "173 N·s^μ/m");
  assert.equal(plainSpace(quantity(0, "s")), "0 s");
  assert.equal(quantity(0.5, ""), "0.500");
  assert.equal(plainSpace(duration(90)), "90.0 s");
  assert.equal(plainSpace(bytes(412345)), "412 kB");
});

test("an axis has steps of 1, 2 and 5 and no idle digits", () => {
  assert.deepEqual([1, 0.3, 7, 12, 0].map((span) => niceStep(span, 4)), [0.5, 0.1, 2, 5, 1]);
  assert.equal(plain(-25), "−25");
  assert.equal(plain(0.1 + 0.2), "0.3");
});

test("digits of a value that changes stand still", () => {
  assert.equal(steady(0.0764, 3, "N"), "0.076\u202fN");
  assert.equal(steady(-0.0001, 2, "mJ"), "0.00\u202fmJ");
  assert.equal(steady(NaN, 2, "mm"), "–\u202fmm");
});

test("the texts of an axis tell its ticks apart, wherever it is", () => {
  assert.deepEqual(tickTexts([-0.5, 0, 0.5]), ["−0.5", "0.0", "0.5"]);
  assert.deepEqual(tickTexts([0, 200000, 400000]), ["0", "2·10⁵", "4·10⁵"]);
  assert.deepEqual(tickTexts([3.0e-3, 3.0e-3 + 2e-7, 3.0e-3 + 4e-7]), ["3.0000·10⁻³", "3.0002·10⁻³", "3.0004·10⁻³"]);
  for (let power = -9; power <= 9; power += 1) {
    for (const start of [0, 1, 3.1234567, -7.5]) {
      for (const step of [1e-5, 2e-4, 5e-3, 0.1, 2]) {
        const ticks = [0, 1, 2, 3].map((n) => (Math.round(start / step) + n) * step * 10 ** power);
        const texts = tickTexts(ticks);
        assert.equal(new Set(texts).size, ticks.length, `${ticks}: ${texts}`);
      }
    }
  }
});
