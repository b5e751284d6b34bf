// The map of walls: which are stable, which passive, and where this one is.

import { onSize, say, set, svg } from "./dom";
import { ends, number, plain, ticks } from "./format";
import type { Walls } from "./protocol";

export interface MapOptions {
  name: string;
  /** Numbers on the axes; without them only their names. */
  axes: boolean;
  /** The operating point was moved to B, K; a map without it cannot be moved on. */
  moved?: (dissipation: number, stiffness: number) => void;
}

const KEY_STEP = 0.01;
/** Points on the boundary of a map that stands still: a chord is nearer to the boundary than a pixel. */
export const POINTS = 500;

export class RegionMap {
  readonly root = svg("svg", { class: "map" });
  private readonly grid = svg("g");
  private readonly stable = svg("path", { class: "stable" });
  private readonly passive = svg("path", { class: "passive" });
  private readonly names = {
    stable: svg("text", { class: "name" }, "stable"),
    passive: svg("text", { class: "name" }, "passive"),
    x: svg("text", { class: "axis" }),
    y: svg("text", { class: "axis" }),
  };
  private readonly point = svg("circle", { r: 6, class: "point" });
  private readonly here = svg("text", { class: "axis" }, "here");
  private width = 0;
  private height = 0;
  private most: [number, number] = [1, 1];
  private at: [number, number] = [0, 0];
  private walls: Walls | null = null;
  private device = "";
  private said = "";

  constructor(private readonly options: MapOptions) {
    this.root.append(this.grid, this.stable, this.passive, ...Object.values(this.names), this.here, this.point);
    this.root.setAttribute("aria-label", options.name);
    this.root.setAttribute("role", "img");
    onSize(this.root, (width, height) => {
      this.width = width;
      this.height = height;
      this.draw();
    });
    if (options.moved) this.listen(options.moved);
  }

  /** Shows a wall at B, K among all of its device, and what is said of it. The axes stay while the device does. */
  show(walls: Walls, device: string, dissipation: number, stiffness: number, said: string): void {
    const anew = this.device !== device;
    this.device = device;
    this.walls = walls;
    this.said = said;
    this.at = [dissipation, stiffness];
    this.root.style.display = "";
    if (anew) this.most = reach(walls, this.options.axes ? this.at : [0, 0]);
    this.draw();
  }

  /** Shows nothing: what runs has no place on a map. */
  hide(): void {
    this.root.style.display = "none";
  }

  /** Moves the point alone. */
  private draw(): void {
    if (!this.walls || this.width === 0) return;
    set(this.root, { viewBox: `0 0 ${this.width} ${this.height}` });
    this.drawAxes();
    const { stable, passive } = this.names;
    const { region, passive_walls: edge } = this.walls;
    set(this.stable, { d: region.map((polygon) => this.path(polygon)).join("") });
    set(this.passive, { d: edge.length > 0 ? this.path([...edge, [0, 0]]) : "" });
    const [bMost, kMost] = this.most;
    const place = (text: SVGElement, [x, y]: [number, number]) => set(text, { x, y });
    place(stable, this.coordinates(...centre(region[0] ?? [])));
    stable.style.display = region.length > 0 ? "" : "none";
    const [passiveWide] = edge.at(-1) ?? [0];
    const [, passiveHigh] = edge[0] ?? [0, 0];
    place(passive, this.coordinates(passiveWide * 0.22, passiveHigh * 0.3));
    const room = (passiveWide / bMost) * this.width > 150 && (passiveHigh / kMost) * this.height > 44;
    passive.style.display = room ? "" : "none";
    const [x, y] = this.coordinates(Math.min(this.at[0], bMost), Math.min(this.at[1], kMost));
    set(this.point, { cx: x, cy: y });
    this.point.classList.toggle("outside", this.at[0] > bMost || this.at[1] > kMost);
    set(this.here, { x: x + 12, y: this.options.axes ? y - 8 : this.height - 4 });
    if (this.options.moved) {
      set(this.point, {
        "aria-valuetext": `B ${number(this.at[0])} N·s^μ/m, K ${number(this.at[1])} N/m: ${this.said}`,
        "aria-valuenow": this.at[1],
        "aria-valuemin": 0,
        "aria-valuemax": Math.max(kMost, this.at[1]),
      });
    }
  }

  private drawAxes(): void {
    const { left, right, top, bottom } = this.edges();
    const lines: SVGElement[] = [];
    const line = (x1: number, y1: number, x2: number, y2: number) => {
      lines.push(svg("line", { x1, y1, x2, y2, class: "grid" }));
    };
    const text = (x: number, y: number, anchor: string, label: string) => {
      lines.push(svg("text", { x, y, "text-anchor": anchor, class: "axis" }, label));
    };
    if (this.options.axes) {
      const [bMost, kMost] = this.most;
      const kUnit = kMost >= 2000 ? 1000 : 1;
      for (const value of ticks(0, kMost, Math.max(2, this.height / 60))) {
        const y = this.coordinates(0, value)[1];
        line(left, y, this.width - right, y);
        text(left - 7, y + 4, "end", plain(value / kUnit));
      }
      for (const value of ticks(0, bMost, Math.max(2, this.width / 110))) {
        text(this.coordinates(value, 0)[0], this.height - bottom + 18, "middle", plain(value));
      }
      say(this.names.y, `K, ${kUnit === 1000 ? "kN/m" : "N/m"}`);
      set(this.names.y, { x: left, y: top - 10, "text-anchor": "start" });
      say(this.names.x, "B, N·s^μ/m");
      set(this.names.x, { x: this.width - right, y: this.height - 6, "text-anchor": "end" });
    } else {
      line(left, this.height - bottom, this.width - right, this.height - bottom);
      say(this.names.x, "dissipation B");
      set(this.names.x, { x: this.width - right, y: this.height - 4, "text-anchor": "end" });
      say(this.names.y, "stiffness K");
      set(this.names.y, { x: left, y: 11, "text-anchor": "start" });
    }
    this.grid.replaceChildren(...lines);
  }

  private edges(): { left: number; right: number; top: number; bottom: number } {
    return this.options.axes ? { left: 52, right: 14, top: 28, bottom: 44 } : { left: 46, right: 14, top: 18, bottom: 20 };
  }

  private coordinates(dissipation: number, stiffness: number): [number, number] {
    const { left, right, top, bottom } = this.edges();
    const x = left + (dissipation / this.most[0]) * (this.width - left - right);
    const y = this.height - bottom - (stiffness / this.most[1]) * (this.height - top - bottom);
    return [x, y];
  }

  private path(points: [number, number][]): string {
    return `M${points.map((point) => this.coordinates(...point).map((part) => part.toFixed(2)).join(",")).join("L")}Z`;
  }

  private listen(moved: (dissipation: number, stiffness: number) => void): void {
    set(this.point, { tabindex: 0, role: "slider", "aria-label": "Operating point", "aria-valuenow": 0, "aria-valuemin": 0, "aria-valuemax": 1 });
    this.root.classList.add("live");
    this.root.setAttribute("role", "group");
    const to = (event: PointerEvent) => {
      const { left, top } = this.root.getBoundingClientRect();
      const edges = this.edges();
      const x = (event.clientX - left - edges.left) / (this.width - edges.left - edges.right);
      const y = (this.height - edges.bottom - (event.clientY - top)) / (this.height - edges.top - edges.bottom);
      const within = (share: number, most: number) => Number((Math.min(1, Math.max(0, share)) * most).toPrecision(4));
      moved(within(x, this.most[0]), within(y, this.most[1]));
    };
    this.root.addEventListener("pointerdown", (event) => {
      this.root.setPointerCapture(event.pointerId);
      this.point.focus();
      event.preventDefault();
      to(event);
    });
    this.root.addEventListener("pointermove", (event) => {
      if (this.root.hasPointerCapture(event.pointerId)) to(event);
    });
    this.point.addEventListener("keydown", (event) => {
      const step = KEY_STEP * (event.shiftKey ? 0.1 : 1);
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      const next = (value: number, most: number, by: number) => Number(Math.max(0, value + by * step * most).toPrecision(6));
      moved(next(this.at[0], this.most[0], way[0] ?? 0), next(this.at[1], this.most[1], way[1] ?? 0));
    });
  }
}

/** Largest B and K that are shown: all of the region, the point if it is not far outside. */
function reach(walls: Walls, at: [number, number]): [number, number] {
  const points = [...walls.region.flat(), ...walls.passive_walls];
  return at.map((point, axis) => {
    const [, region] = ends(points.map((each) => each[axis]), 0, 0);
    if (region === 0) return Math.max(1, 2 * point);
    return point > region && point < 3 * region ? point * 1.1 : region * 1.05;
  }) as [number, number];
}

/** Somewhere in the middle of a polygon. */
function centre(polygon: [number, number][]): [number, number] {
  const mean = (axis: 0 | 1) => polygon.reduce((sum, point) => sum + point[axis], 0) / Math.max(1, polygon.length);
  return [0.9 * mean(0), mean(1)];
}
