import assert from "node:assert/strict";
import { test } from "node:test";
import { numberOf, readFragment, writeFragment } from "../../src/fragment";

test("an address is read as it was written", () => {
  const state = { view: "runs" as const, values: new Map([["open", "relax-0001/relax,wall-0002/wall"], ["name", "a&b=c d%"], ["empty", ""]]) };
  const written = writeFragment(state);
  const read = readFragment(written);
  assert.equal(read.view, "runs");
  assert.deepEqual([...read.values], [...state.values].filter(([, value]) => value !== ""));
  assert.equal(writeFragment(read), written);
});

test("what is not understood opens Feel", () => {
  for (const text of ["", "#", "#nonsense", "#?a=1", "#%%%"]) assert.equal(readFragment(text).view, "feel");
  const { values } = readFragment("#design?K=abc&B=1e3&mu=&T=Infinity");
  assert.equal(numberOf(values, "K"), undefined);
  assert.equal(numberOf(values, "B"), 1000);
  assert.equal(numberOf(values, "mu"), undefined);
  assert.equal(numberOf(values, "T"), undefined);
});
