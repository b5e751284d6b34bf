import assert from "node:assert/strict";
import { test } from "node:test";
import { columnTime, completed, newest, newestValue, readFrame, type Frame } from "../../src/frame";

function bytes(channels: number, columns: number, value: (channel: number, column: number, most: boolean) => number): ArrayBuffer {
  const buffer = new ArrayBuffer(52 + 8 * channels * columns);
  const view = new DataView(buffer);
  [0x32504846, 3, channels, columns].forEach((number, index) => view.setUint32(4 * index, number, true));
  [1000, 4, 1e-3, 992].forEach((number, index) => view.setFloat64(16 + 8 * index, number, true));
  view.setUint32(48, 11, true);
  for (let channel = 0; channel < channels; channel += 1) {
    for (let column = 0; column < columns; column += 1) {
      view.setFloat32(52 + 4 * (2 * channel * columns + column), value(channel, column, false), true);
      view.setFloat32(52 + 4 * ((2 * channel + 1) * columns + column), value(channel, column, true), true);
    }
  }
  return buffer;
}

test("a frame is read as it was written", () => {
  const frame = readFrame(bytes(2, 5, (channel, column, most) => 100 * channel + 10 * column + (most ? 1 : 0)));
  assert.deepEqual([frame.request, frame.columns, frame.ticksPerColumn, frame.sampleTimeS], [3, 5, 4, 1e-3]);
  assert.deepEqual([frame.pictureTick, frame.number], [992, 11]);
  assert.deepEqual([frame.least[1]?.[2], frame.most[1]?.[2]], [120, 121]);
  assert.ok(Math.abs(columnTime(frame, 2) - 1.008) < 1e-12);
});

test("bytes that are no frame are refused with a sentence", () => {
  assert.throws(() => readFrame(new ArrayBuffer(8)), /shorter than its header/);
  assert.throws(() => readFrame(new ArrayBuffer(64)), /no frame/);
  const cut = bytes(2, 5, () => 0).slice(0, 100);
  assert.throws(() => readFrame(cut), /132 bytes, not 100/);
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

/** Columns of what the tick `n` shows in channel `c`, until `made`; the last column is of the ticks there are. */
function columns(from: number, made: number, width: number, pictureTick = from): Frame {
  const count = Math.ceil((made - from) / width);
  const part = (channel: number, end: number): Float32Array =>
    Float32Array.from({ length: count }, (_, n) => 1000 * channel + (end === 0 ? from + n * width : Math.min(made, from + (n + 1) * width) - 1));
  return { request: 3, number: 1, columns: count, firstTick: from, pictureTick, ticksPerColumn: width, sampleTimeS: 1e-3, least: [part(0, 0), part(1, 0)], most: [part(0, 1), part(1, 1)] };
}

test("increments over any of the pictures before make the whole picture", () => {
  let seed = 1;
  const random = (most: number): number => (seed = (seed * 48271) % 2147483647) % most;
  for (let round = 0; round < 300; round += 1) {
    const [width, last] = [1 + random(60), 1 + random(5000)];
    const left = (made: number): number => Math.floor(Math.max(0, made - last) / width) * width;
    let made = 1 + random(9000);
    let picture = completed(null, columns(left(made), made, width));
    let acknowledged = made;
    for (let step = 0; step < 20; step += 1) {
      made += 1 + random(400);
      const from = Math.max(left(made), Math.floor(acknowledged / width) * width);
      picture = completed(picture, columns(from, made, width, left(made)));
      assert.ok(picture !== null);
      assert.deepEqual(picture, columns(left(made), made, width));
      // Now and then a frame is on its way when the next is made.
      if (random(3) > 0) acknowledged = made;
    }
  }
});

test("a frame that does not go on from the picture completes none", () => {
  const before = columns(0, 100, 10);
  assert.equal(completed(null, columns(90, 120, 10, 0)), null);
  assert.equal(completed(before, columns(110, 120, 10, 0)), null);
  assert.equal(completed(before, columns(90, 120, 5, 0)), null);
  assert.equal(completed({ ...before, request: 2 }, columns(90, 120, 10, 0)), null);
  // Of an older picture.
  assert.equal(completed(columns(50, 100, 10), columns(30, 90, 10, 20)), null);
  // A loop that begins anew comes whole.
  assert.equal(completed(before, columns(0, 5, 10))?.columns, 1);
});
