import assert from "node:assert/strict";
import { test } from "node:test";
import { columnTime, newest, newestValue, readFrame } from "../../src/frame";

function bytes(channels: number, columns: number, value: (channel: number, column: number, most: boolean) => number): ArrayBuffer {
  const buffer = new ArrayBuffer(40 + 8 * channels * columns);
  const view = new DataView(buffer);
  [0x31504846, 3, channels, columns].forEach((number, index) => view.setUint32(4 * index, number, true));
  [1000, 4, 1e-3].forEach((number, index) => view.setFloat64(16 + 8 * index, number, true));
  for (let channel = 0; channel < channels; channel += 1) {
    for (let column = 0; column < columns; column += 1) {
      view.setFloat32(40 + 4 * (2 * channel * columns + column), value(channel, column, false), true);
      view.setFloat32(40 + 4 * ((2 * channel + 1) * columns + column), value(channel, column, true), true);
    }
  }
  return buffer;
}

test("a frame is read as it was written", () => {
  const frame = readFrame(bytes(2, 5, (channel, column, most) => 100 * channel + 10 * column + (most ? 1 : 0)));
  assert.deepEqual([frame.request, frame.columns, frame.ticksPerColumn, frame.sampleTimeS], [3, 5, 4, 1e-3]);
  assert.deepEqual([frame.least[1]?.[2], frame.most[1]?.[2]], [120, 121]);
  assert.ok(Math.abs(columnTime(frame, 2) - 1.008) < 1e-12);
});

test("bytes that are no frame are refused with a sentence", () => {
  assert.throws(() => readFrame(new ArrayBuffer(8)), /shorter than its header/);
  assert.throws(() => readFrame(new ArrayBuffer(64)), /no frame/);
  const cut = bytes(2, 5, () => 0).slice(0, 100);
  assert.throws(() => readFrame(cut), /120 bytes, not 100/);
  const still = bytes(1, 1, () => 0);
  new DataView(still).setFloat64(24, 0, true);
  assert.throws(() => readFrame(still), /time scale/);
});

test("the newest value is the end that the motion went to", () => {
  const rising = readFrame(bytes(1, 4, (_, column, most) => (column === 3 ? NaN : column + (most ? 0.5 : 0))));
  assert.equal(newest(rising, 0), 2);
  assert.equal(newestValue(rising, 0), 2.5);
  const falling = readFrame(bytes(1, 3, (_, column, most) => -column + (most ? 0.5 : 0)));
  assert.equal(newestValue(falling, 0), -2);
  assert.ok(Number.isNaN(newestValue(readFrame(bytes(1, 2, () => NaN)), 0)));
});
