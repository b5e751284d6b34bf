// Force over depth: the same columns as over time, drawn against each other.

import { path, values, type Points } from "./columns";
import { el, onSize, set, svg } from "./dom";
import { ends, ticks, tickTexts } from "./format";
import type { Line } from "./chart";

/** Room for the numbers of the axes, px. */
const EDGE = { left: 46, right: 12, top: 8, bottom: 34 };

/** Least and most force in each column of time, and the depth at both moments, as a frame has them. */
export interface DepthCurve extends Omit<Line, "label"> {
  /** 1 where the device itself presses; else a force against the motion is shown as positive. */
  sign?: number;
  depth: readonly [Float32Array | undefined, Float32Array | undefined];
  force: readonly [Float32Array | undefined, Float32Array | undefined];
}

interface Track extends Omit<Line, "label"> {
  depth: Points;
  force: Points;
}

export class DepthPlot {
  readonly root: HTMLElement;
  private readonly picture = svg("svg", { role: "img", "aria-label": "Force over depth" });
  private readonly grid = svg("g", { class: "ticks" });
  private readonly lines = svg("g");
  private tracks: Track[] = [];
  private width = 0;
  private height = 0;

  constructor() {
    this.picture.append(this.grid, this.lines);
    this.root = el("div", { class: "depth-holder plane" }, this.picture as unknown as HTMLElement);
    onSize(this.root, (width, height) => {
      [this.width, this.height] = [width, height];
      this.show();
    });
  }

  /** Draws curves, the last on top. */
  draw(curves: DepthCurve[]): void {
    const none = new Float32Array();
    this.tracks = curves.map(({ depth, force, sign = -1, ...stroke }) => {
      const [least, most] = [force[0] ?? none, force[1] ?? none];
      return { ...stroke, depth: values(depth[0] ?? none, depth[1] ?? none, 1000, [least, most]), force: values(least, most, sign) };
    });
    this.show();
  }

  private show(): void {
    const [width, height] = [this.width - EDGE.left - EDGE.right, this.height - EDGE.top - EDGE.bottom];
    if (width <= 0 || height <= 0) return;
    set(this.picture, { viewBox: `0 0 ${this.width} ${this.height}` });
    // Where nothing pushes there is nothing to see.
    const [x0, x1] = span(this.tracks.map(({ depth, force }) => depth.filter((_, n) => force[n])));
    const [y0, y1] = span(this.tracks.map(({ force }) => force));
    const x = (depth: number) => EDGE.left + ((depth - x0) / (x1 - x0)) * width;
    const y = (force: number) => EDGE.top + ((y1 - force) / (y1 - y0)) * height;
    const parts: SVGElement[] = [];
    const across = ticks(x0, x1, width / 60);
    tickTexts(across).forEach((text, n) => parts.push(svg("text", { x: x(across[n] ?? 0), y: this.height - 18, "text-anchor": "middle" }, text)));
    const up = ticks(y0, y1, height / 40);
    tickTexts(up).forEach((text, n) => {
      const at = y(up[n] ?? 0);
      parts.push(svg("line", { x1: EDGE.left, x2: this.width - EDGE.right, y1: at, y2: at }), svg("text", { x: EDGE.left - 6, y: at + 4, "text-anchor": "end" }, text));
    });
    parts.push(svg("text", { x: this.width - EDGE.right, y: this.height - 3, "text-anchor": "end" }, "force in N over depth in mm"));
    this.grid.replaceChildren(...parts);
    const paths = this.tracks.map(({ depth, force, colour, dash, width: thick }) => {
      const style = `stroke: var(${colour}); stroke-width: ${thick ?? 2}`;
      return svg("path", { class: "track", d: path(depth, force, (at) => x(Math.max(x0, at)), y), "stroke-dasharray": (dash ?? []).join(" "), style });
    });
    this.lines.replaceChildren(...paths);
  }
}

/** From the least to the most of all points, 0 included. */
function span(lines: Points[]): [number, number] {
  const [low, high] = ends(lines.flat(), 0, 0);
  return low < high ? [low, high] : [0, 1];
}
