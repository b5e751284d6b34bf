// From columns of minima and maxima to the points of a line, and from samples to columns.

import { columnTime, type Frame } from "./frame";

export type Points = (number | null)[];

/** Times of the points: two a column, a quarter of it from its edges. `origin` is the time that counts as 0. */
export function times(frame: Frame, origin = 0): number[] {
  const quarter = (frame.ticksPerColumn - 1) * frame.sampleTimeS * 0.25;
  const points = new Array<number>(2 * frame.columns);
  for (let column = 0; column < frame.columns; column += 1) {
    const time = columnTime(frame, column) - origin;
    points[2 * column] = time + quarter;
    points[2 * column + 1] = time + 3 * quarter;
  }
  return points;
}

/**
 * Values of the points: minimum and maximum of each column, the nearer to the point before it first, so that the
 * line does not cross itself. `factor` converts units; null stands where nothing is. A channel that follows another has its
 * order, that of `led`.
 */
export function values(least: Float32Array, most: Float32Array, factor = 1, led: readonly [Float32Array, Float32Array] = [least, most]): Points {
  const points = new Array<number | null>(2 * least.length);
  let before = NaN;
  for (let column = 0; column < least.length; column += 1) {
    const low = least[column] ?? NaN;
    const high = most[column] ?? NaN;
    if (Number.isNaN(low) || Number.isNaN(high)) {
      points[2 * column] = points[2 * column + 1] = null;
      before = NaN;
      continue;
    }
    const [first, second] = [led[0][column] ?? NaN, led[1][column] ?? NaN];
    const rising = Number.isNaN(before) || Math.abs(first - before) <= Math.abs(second - before);
    points[2 * column] = factor * (rising ? low : high);
    points[2 * column + 1] = factor * (rising ? high : low);
    before = rising ? second : first;
  }
  return points;
}

/** Samples at ascending times as points of at most `columns` minima and maxima: no peak is lost. */
export function decimate(time: ArrayLike<number>, value: ArrayLike<number>, columns: number): { time: number[]; value: number[] } {
  const count = Math.min(time.length, value.length);
  if (count <= 2 * columns) return { time: Array.from(time).slice(0, count), value: Array.from(value).slice(0, count) };
  const result = { time: [] as number[], value: [] as number[] };
  for (let column = 0; column < columns; column += 1) {
    const from = Math.floor((column * count) / columns);
    const to = Math.floor(((column + 1) * count) / columns);
    let low = from;
    let high = from;
    for (let index = from; index < to; index += 1) {
      if ((value[index] ?? NaN) < (value[low] ?? NaN)) low = index;
      if ((value[index] ?? NaN) > (value[high] ?? NaN)) high = index;
    }
    for (const index of low < high ? [low, high] : [high, low]) {
      result.time.push(time[index] ?? NaN);
      result.value.push(value[index] ?? NaN);
    }
  }
  return result;
}

/** Curves with points of their own, over the times of all of them. undefined joins, null is a gap. */
export function joined(curves: { time: number[]; value: Points }[]): { x: number[]; points: Points[] } {
  const x = [...new Set(curves.flatMap(({ time }) => time))].sort((a, b) => a - b);
  const place = new Map(x.map((at, index) => [at, index]));
  const points = curves.map(({ time, value }) => {
    const line = new Array<number | null | undefined>(x.length);
    time.forEach((at, index) => (line[place.get(at) ?? 0] = value[index] ?? null));
    return line as Points;
  });
  return { x, points };
}

/** The path of a curve in a picture: a gap where a number is null; undefined is left out. */
export function path(across: Points, up: readonly (number | null | undefined)[], x: (across: number) => number, y: (up: number) => number): string {
  let [text, open] = ["", false];
  across.forEach((at, n) => {
    const value = up[n];
    if (value === undefined) return;
    const there = at !== null && value !== null;
    if (there) text += `${open ? "L" : "M"}${x(at).toFixed(2)},${y(value).toFixed(2)}`;
    open = there;
  });
  return text;
}
