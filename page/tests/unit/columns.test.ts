import assert from "node:assert/strict";
import { test } from "node:test";
import { decimate, times, values } from "../../src/columns";
import type { Frame } from "../../src/frame";

test("each column gives both its ends, gaps stay gaps", () => {
  const least = Float32Array.of(0, 1, NaN, 3);
  const most = Float32Array.of(0.5, 2, NaN, 2.5 + 1);
  assert.deepEqual(values(least, most, 2), [0, 1, 2, 4, null, null, 6, 7]);
  // Falling: the upper end first.
  assert.deepEqual(values(Float32Array.of(2, 0), Float32Array.of(3, 1)), [2, 3, 1, 0]);
  // Behind a peak that is the end of a column, the next column begins at its top.
  assert.deepEqual(values(Float32Array.of(0, 1), Float32Array.of(4, 3)), [0, 4, 3, 1]);
  // A depth has the order of its force, of which it has the moments.
  const [depth, deeper] = [Float32Array.of(5, 8), Float32Array.of(6, 7)];
  assert.deepEqual(values(depth, deeper, 1, [Float32Array.of(2, 0), Float32Array.of(3, 1)]), [5, 6, 7, 8]);
});

test("points lie inside their columns, in order", () => {
  const frame = { columns: 3, firstTick: 100, ticksPerColumn: 5, sampleTimeS: 0.01 } as Frame;
  const points = times(frame, 1);
  assert.equal(points.length, 6);
  points.forEach((time, index) => {
    const left = 1 + Math.floor(index / 2) * 0.05 - 1;
    assert.ok(time >= left - 1e-12 && time < left + 0.05, `${time}`);
    if (index > 0) assert.ok(time >= (points[index - 1] ?? 0));
  });
});

test("decimation loses no peak, for any number of columns", () => {
  const count = 10_007;
  const time = Array.from({ length: count }, (_, n) => n);
  const value = time.map((n) => Math.sin(n / 50) + (n === 4321 ? 9 : 0) - (n === 8765 ? 7 : 0));
  for (const columns of [1, 2, 7, 100, 999, 5003]) {
    const thin = decimate(time, value, columns);
    assert.ok(thin.value.length <= 2 * columns);
    assert.equal(Math.max(...thin.value), Math.max(...value));
    assert.equal(Math.min(...thin.value), Math.min(...value));
    thin.time.forEach((at, index) => assert.equal(thin.value[index], value[at]));
    assert.deepEqual([...thin.time].sort((a, b) => a - b), thin.time);
  }
  assert.deepEqual(decimate([1, 2], [3, 4], 10), { time: [1, 2], value: [3, 4] });
});
