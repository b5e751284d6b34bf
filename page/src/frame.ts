// Binary frames of the socket: docs/page-protocol.md.

const MAGIC = 0x32504846;
const HEADER = 52;

/** Columns of minima and maxima, as the server sends them. */
export interface Frame {
  /** The number of the request that it answers. */
  request: number;
  columns: number;
  firstTick: number;
  ticksPerColumn: number;
  sampleTimeS: number;
  /** The first tick of the picture of which these columns are the end, or all. */
  pictureTick: number;
  /** Of a live view: what the page acknowledges; 0 of a frame that comes alone. */
  number: number;
  least: Float32Array[];
  most: Float32Array[];
}

/** Reads a frame. Throws with a sentence if the bytes are none. */
export function readFrame(bytes: ArrayBuffer): Frame {
  if (bytes.byteLength < HEADER) throw new Error(`a frame of ${bytes.byteLength} bytes is shorter than its header`);
  const view = new DataView(bytes);
  if (view.getUint32(0, true) !== MAGIC) throw new Error("a binary message that is no frame of version 2");
  const channels = view.getUint32(8, true);
  const columns = view.getUint32(12, true);
  const length = HEADER + 8 * channels * columns;
  if (bytes.byteLength !== length) {
    throw new Error(`a frame of ${channels} channels and ${columns} columns has ${length} bytes, not ${bytes.byteLength}`);
  }
  const ticksPerColumn = view.getFloat64(24, true);
  const sampleTimeS = view.getFloat64(32, true);
  if (!(ticksPerColumn > 0) || !(sampleTimeS > 0)) throw new Error("a frame without a time scale");
  const part = (index: number) => new Float32Array(bytes, HEADER + 4 * columns * index, columns);
  return {
    request: view.getUint32(4, true),
    columns,
    firstTick: view.getFloat64(16, true),
    ticksPerColumn,
    sampleTimeS,
    pictureTick: view.getFloat64(40, true),
    number: view.getUint32(48, true),
    least: Array.from({ length: channels }, (_, channel) => part(2 * channel)),
    most: Array.from({ length: channels }, (_, channel) => part(2 * channel + 1)),
  };
}

/** The picture that a frame completes; null if it is not of the picture before, which then has to be asked for anew. */
export function completed(before: Frame | null, frame: Frame): Frame | null {
  const { firstTick, pictureTick, ticksPerColumn } = frame;
  if (firstTick <= pictureTick) return frame;
  if (before === null || before.request !== frame.request || before.ticksPerColumn !== ticksPerColumn) return null;
  const column = (tick: number) => (tick - before.firstTick) / ticksPerColumn;
  const [from, to] = [Math.max(0, column(pictureTick)), column(firstTick)];
  if (to < from || to > before.columns) return null;
  const joined = (old: Float32Array, now: Float32Array | undefined) => {
    const all = new Float32Array(to - from + frame.columns);
    all.set(old.subarray(from, to));
    all.set(now ?? [], to - from);
    return all;
  };
  return {
    ...frame,
    columns: to - from + frame.columns,
    firstTick: firstTick - (to - from) * ticksPerColumn,
    least: before.least.map((old, channel) => joined(old, frame.least[channel])),
    most: before.most.map((old, channel) => joined(old, frame.most[channel])),
  };
}

/** Time of the left edge of a column, s. */
export function columnTime(frame: Frame, column: number): number {
  return (frame.firstTick + column * frame.ticksPerColumn) * frame.sampleTimeS;
}

/** The newest column that has a sample of a channel, or -1. */
export function newest(frame: Frame, channel: number): number {
  const values = frame.most[channel];
  let column = frame.columns - 1;
  while (column >= 0 && (values === undefined || Number.isNaN(values[column]))) column -= 1;
  return column;
}

/** The value at the end of a channel: of the newest column the end that the motion went to. */
export function newestValue(frame: Frame, channel: number): number {
  const column = newest(frame, channel);
  const least = frame.least[channel]?.[column] ?? NaN;
  const most = frame.most[channel]?.[column] ?? NaN;
  const before = ((frame.least[channel]?.[column - 1] ?? NaN) + (frame.most[channel]?.[column - 1] ?? NaN)) / 2;
  const middle = (least + most) / 2;
  return Number.isNaN(before) ? middle : middle >= before ? most : least;
}
