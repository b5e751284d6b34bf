// The plane of two axes: where the hand went, the shape that it touched, and the force at the cursor.

import type { App } from "./app";
import { path, times, values, type Points } from "./columns";
import { el, onSize, say, set, svg, words } from "./dom";
import { ends, multiples, niceStep, plain, quantity } from "./format";
import type { OpenRun } from "./protocol";
import { cutOf, shapeOf, type Axes, type Cut, type Shape } from "./shape";

const NAMES = ["x", "y", "z"];
/** Columns that are asked for, if the server gives as many: of a log that is not longer each sample. */
const COLUMNS = 8192;
/** Width of an axis' name, px. */
const NAME = 52;
const EDGE = { left: 44, right: 12, top: 10, bottom: 30 };
/** Largest arrow, as a share of the picture. */
const ARROW = 0.16;
/** Room around path and shape, in which an arrow has its place. */
const MARGIN = 0.17;
/** A shape this much larger than the path is not shown whole. */
const LARGER = 4;

/** Samples of a run in the plane. */
interface Track {
  time: number[];
  /** Of the device, of the point that the hand goes to, and the force: across and up. */
  place: [Points, Points];
  hand: [Points, Points];
  force: [Points, Points];
  through: Points;
  norm: Points;
}

interface Scale {
  x: (across: number) => number;
  y: (up: number) => number;
  /** px of a metre. */
  size: number;
}

export class PlaneView {
  readonly root: HTMLElement;
  private readonly select = el("select", { "aria-label": "Plane" });
  private readonly said = el("span");
  private readonly picture = svg("svg", { class: "plane", role: "img", "aria-label": "Path in the plane" });
  private readonly matter = svg("path", { class: "matter" });
  private readonly grid = svg("g", { class: "ticks" });
  private readonly hand = svg("path", { class: "way" });
  private readonly whole = svg("path", { class: "track whole" });
  private readonly track = svg("path", { class: "track" });
  private readonly arrow = svg("path", { class: "arrow" });
  private readonly aim = svg("circle", { class: "grip", r: 6 });
  private readonly place = svg("circle", { class: "ball", r: 5 });
  private run: OpenRun | null = null;
  private shape: Shape | null = null;
  private zoom: readonly [number, number] | null = null;
  private cursor: number | null = null;
  private all: Track | null = null;
  private part: Track | null = null;
  private scaled: Scale | null = null;
  private round = 0;
  private width = 0;
  private height = 0;

  constructor(private readonly app: App) {
    this.picture.append(this.matter, this.grid, this.hand, this.whole, this.track, this.arrow, this.aim, this.place);
    this.root = el("section", { class: "card plane-card", hidden: true }, el("h2", {}, this.select, this.said), el("div", { class: "plane-holder" }));
    const holder = this.root.lastElementChild;
    holder?.append(this.picture);
    if (holder) {
      onSize(holder, (width, height) => {
        [this.width, this.height] = [width, height];
        this.draw();
      });
    }
    this.select.addEventListener("change", () => void this.load());
  }

  /** Shows the first of these runs that has several axes, the visible part of its time strongly; true if there is one. */
  show(runs: OpenRun[], zoom: readonly [number, number] | null): boolean {
    const run = runs.find(({ axes }) => (axes ?? 1) > 1) ?? null;
    this.root.hidden = run === null;
    if (run?.name !== this.run?.name || run?.axes !== this.run?.axes) {
      const pairs = run?.axes === 3 ? ["x–y", "x–z", "y–z"] : ["x–y"];
      this.select.replaceChildren(...pairs.map((pair) => el("option", { value: pair }, pair)));
      this.select.disabled = pairs.length === 1;
      [this.all, this.part, this.cursor] = [null, null, null];
    }
    this.run = run;
    this.zoom = zoom;
    this.shape = run === null ? null : shapeOf(run.metadata);
    void this.load();
    return run !== null;
  }

  /** The cursor of the charts is at a time, s. */
  at(time: number | null): void {
    this.cursor = time;
    this.drawCursor();
  }

  private axes(): Axes {
    const [across = 0, up = 1] = this.select.value.split("–").map((name) => NAMES.indexOf(name));
    return { across, up, through: this.run?.axes === 3 ? 3 - across - up : -1 };
  }

  /** Draws anew what goes on. */
  async load(): Promise<void> {
    const { run, zoom } = this;
    const round = ++this.round;
    if (run === null) return;
    try {
      const all = await this.fetch(run, null);
      const part = zoom === null ? null : await this.fetch(run, zoom);
      if (round !== this.round) return;
      [this.all, this.part] = [all, part];
      this.draw();
    } catch (error) {
      this.app.notify(words(error));
    }
  }

  private async fetch(run: OpenRun, zoom: readonly [number, number] | null): Promise<Track> {
    const { across, up, through } = this.axes();
    const pair = (field: string) => [across, up].map((axis) => field.replace("*", NAMES[axis] ?? "x"));
    const channels = [...pair("position_*_m"), ...pair("reference_*_m"), ...pair("commanded_force_*_n"), `position_${NAMES[Math.max(0, through)]}_m`, "commanded_force_norm_n"];
    const span = zoom === null ? {} : { from_s: Math.max(run.first_s, zoom[0]), to_s: Math.min(run.last_s, zoom[1]) };
    const frame = await this.app.connection.frame({ source: run.name, ...span, columns: Math.min(COLUMNS, this.app.state.hello?.view_columns_most ?? COLUMNS), channels });
    const at = (channel: number) => values(frame.least[channel] ?? new Float32Array(), frame.most[channel] ?? new Float32Array());
    return { time: times(frame), place: [at(0), at(1)], hand: [at(2), at(3)], force: [at(4), at(5)], through: at(6), norm: at(7) };
  }

  // The picture.

  private draw(): void {
    const { all, width, height } = this;
    if (all === null || width === 0 || height === 0) return;
    set(this.picture, { viewBox: `0 0 ${width} ${height}` });
    const scale = this.scale(all);
    this.scaled = scale;
    this.drawGrid(scale);
    set(this.hand, { d: way(all.hand, scale) });
    const strong = this.part ?? all;
    set(this.whole, { d: this.part === null ? "" : way(all.place, scale) });
    set(this.track, { d: way(strong.place, scale) });
    this.drawCursor();
  }

  /** Both axes in one scale, around path and shape. */
  private scale(track: Track): Scale {
    const [[left, right], [low, high]] = this.bounds(track);
    const [w, h] = [this.width - EDGE.left - EDGE.right, this.height - EDGE.top - EDGE.bottom];
    const size = Math.min(w / (right - left), h / (high - low));
    return { size, x: (across) => EDGE.left + w / 2 + size * (across - (left + right) / 2), y: (up) => EDGE.top + h / 2 - size * (up - (low + high) / 2) };
  }

  private bounds(track: Track): [[number, number], [number, number]] {
    const size = (both: [number, number][]) => Math.max(...both.map(([low, high]) => high - low));
    let both = ([0, 1] as const).map((axis): [number, number] => {
      const [low, high] = ends([...track.place[axis], ...track.hand[axis]]);
      const middle = Number.isFinite(low) ? low : 0;
      return high > low ? [low, high] : [middle - 1e-3, middle + 1e-3];
    });
    const { across, up } = this.axes();
    const { shape } = this;
    if (shape?.kind === "ball" && 2 * shape.radius < LARGER * size(both)) {
      const centre = [across, up].map((axis) => shape.centre[axis] ?? 0);
      both = both.map((span, n) => ends([(centre[n] ?? 0) - shape.radius, (centre[n] ?? 0) + shape.radius], ...span));
    }
    const margin = MARGIN * size(both);
    return both.map(([low, high]) => [low - margin, high + margin]) as [[number, number], [number, number]];
  }

  private drawGrid(scale: Scale): void {
    const { width, height } = this;
    const { across, up } = this.axes();
    const parts: SVGElement[] = [];
    const step = niceStep(Math.min(width, height) / scale.size, 5);
    const [from, to] = [(EDGE.left - scale.x(0)) / scale.size, (width - EDGE.right - scale.x(0)) / scale.size];
    for (const at of multiples(step, from, to)) {
      const x = scale.x(at);
      parts.push(svg("line", { x1: x, x2: x, y1: EDGE.top, y2: height - EDGE.bottom }), svg("text", { x, y: height - 12, "text-anchor": "middle" }, x > width - EDGE.right - NAME ? "" : plain(1000 * at)));
    }
    const [bottom, top] = [(scale.y(0) - (height - EDGE.bottom)) / scale.size, (scale.y(0) - EDGE.top) / scale.size];
    for (const at of multiples(step, bottom, top)) {
      const y = scale.y(at);
      parts.push(svg("line", { x1: EDGE.left, x2: width - EDGE.right, y1: y, y2: y }), svg("text", { x: EDGE.left - 6, y: y + 4, "text-anchor": "end" }, y < EDGE.top + 14 ? "" : plain(1000 * at)));
    }
    parts.push(
      svg("text", { class: "name", x: width - EDGE.right, y: height - 12, "text-anchor": "end" }, `${NAMES[across] ?? "x"} / mm`),
      svg("text", { class: "name", x: 2, y: EDGE.top + 4 }, `${NAMES[up] ?? "y"} / mm`),
    );
    this.grid.replaceChildren(...parts);
  }

  /** The shape where the hand is, the hand, and the force on the device. */
  private drawCursor(): void {
    const track = this.part ?? this.all;
    const scale = this.scaled;
    if (track === null || this.all === null || scale === null) return;
    const index = this.cursor === null ? newest(track) : nearest(track.time, this.cursor);
    const [x, y] = [track.place[0][index] ?? null, track.place[1][index] ?? null];
    const { through } = this.axes();
    const at = track.through[index] ?? 0;
    set(this.matter, { d: this.shape === null ? "" : outline(cutOf(this.shape, this.axes(), at), scale, this.width, this.height) });
    this.place.style.display = this.aim.style.display = this.arrow.style.display = x === null || y === null ? "none" : "";
    if (x === null || y === null) return;
    set(this.place, { cx: scale.x(x), cy: scale.y(y) });
    set(this.aim, { cx: scale.x(track.hand[0][index] ?? x), cy: scale.y(track.hand[1][index] ?? y) });
    const [fx, fy] = [track.force[0][index] ?? 0, track.force[1][index] ?? 0];
    const largest = this.all.norm.reduce<number>((most, value) => Math.max(most, value ?? 0), 0);
    const length = largest > 0 ? (ARROW * Math.min(this.width, this.height)) / largest : 0;
    set(this.arrow, { d: arrow([scale.x(x), scale.y(y)], [length * fx, -length * fy]) });
    const cut = through < 0 || this.shape === null ? "" : `, cut at ${NAMES[through]} = ${quantity(at, "m")}`;
    say(this.said, `${quantity(track.norm[index] ?? null, "N")} at ${plain(Number((track.time[index] ?? 0).toFixed(3)))} s${cut}`);
  }
}

function way([across, up]: [Points, Points], { x, y }: Scale): string {
  return path(across, up, x, y);
}

/** The matter of a cut, within the picture. */
function outline(cut: Cut, scale: Scale, width: number, height: number): string {
  const frame = `M0,0H${width}V${height}H0Z`;
  if (cut.kind === "all") return frame;
  if (cut.kind === "none") return "";
  if (cut.kind === "circle") {
    const [x, y, r] = [scale.x(cut.centre[0]), scale.y(cut.centre[1]), scale.size * cut.radius];
    const circle = `M${x - r},${y}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0Z`;
    return cut.hollow ? frame + circle : circle;
  }
  // Longer than the picture is wide: what is outside is not seen.
  const far = width + height + Math.hypot(scale.x(cut.point[0]), scale.y(cut.point[1]));
  const [x, y] = [scale.x(cut.point[0]), scale.y(cut.point[1])];
  const length = Math.hypot(...cut.normal);
  const [nx, ny] = [(far * cut.normal[0]) / length, (-far * cut.normal[1]) / length];
  return `M${x - ny},${y + nx}L${x + ny},${y - nx}L${x + ny + nx},${y - nx + ny}L${x - ny + nx},${y + nx + ny}Z`;
}

/** An arrow from a point, px; nothing for a force that is none. */
function arrow([x, y]: [number, number], [dx, dy]: [number, number]): string {
  const length = Math.hypot(dx, dy);
  if (length < 2) return "";
  const [ux, uy] = [dx / length, dy / length];
  const [tx, ty] = [x + dx, y + dy];
  return `M${x},${y}L${tx},${ty}M${tx + 7 * ux},${ty + 7 * uy}L${tx - 5 * uy},${ty + 5 * ux}L${tx + 5 * uy},${ty - 5 * ux}Z`;
}

/** The last place that has a number. */
function newest(track: Track): number {
  let index = track.time.length - 1;
  while (index > 0 && (track.place[0][index] ?? null) === null) index -= 1;
  return index;
}

/** The place of the time that is nearest; times rise. */
function nearest(time: number[], at: number): number {
  let [low, high] = [0, time.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((time[middle] ?? 0) <= at) low = middle;
    else high = middle;
  }
  return at - (time[low] ?? 0) <= (time[high] ?? 0) - at ? low : high;
}
