// The front of a design: walls that none beats, of which one is chosen and felt.

import { legend } from "./chart";
import { button, el, onSize, say, set, svg } from "./dom";
import { ends, number, plain } from "./format";
import type { Values } from "./protocol";

interface Wall {
  order: number;
  margin: number;
  stiffness: number;
  values: Values;
}

const EDGES = { left: 52, right: 14, top: 24, bottom: 40 };

export class FrontMap {
  readonly root: HTMLElement;
  private readonly map = svg("svg", { class: "map front", tabindex: 0, role: "slider", "aria-label": "Walls that none beats: effective stiffness over gain margin" });
  private readonly chosen = svg("circle", { r: 7, class: "point" });
  private readonly words = el("p", { class: "hint", role: "status" });
  private readonly walls: Wall[];
  private readonly ends: { margin: [number, number]; stiffness: [number, number] };
  private readonly unsize: () => void;
  private size: [number, number] = [0, 0];
  private at = 0;

  constructor(
    private readonly report: Values,
    private readonly colours: readonly string[],
    use: (values: ReadonlyMap<string, string>) => void,
  ) {
    const all = (report["walls"] as Values[]).map((values): Wall => ({ order: Number(values["order"]), margin: Number(values["margin"]), stiffness: Number(values["effective_stiffness_n_per_m"]), values }));
    this.walls = all.filter((wall) => wall.stiffness > 0).sort((a, b) => a.margin - b.margin || a.stiffness - b.stiffness);
    this.ends = { margin: ends(this.walls.map((wall) => wall.margin)), stiffness: ends(this.walls.map((wall) => wall.stiffness)) };
    const lines = this.orders().map((order, index) => ({ label: `μ = ${plain(order)}`, colour: this.colour(index) }));
    this.root = el("div", { class: "front-holder" }, legend(lines).root, this.map as unknown as HTMLElement, this.words, el("div", { class: "buttons" }, button("Use in the loop", () => use(this.wall()), { class: "primary" })));
    this.map.addEventListener("click", (event) => this.choose(this.nearest(event.offsetX, event.offsetY)));
    this.map.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.choose(this.at + step);
    });
    this.unsize = onSize(this.map, (width, height) => {
      this.size = [width, height];
      this.draw();
    });
    this.choose(0);
  }

  destroy(): void {
    this.unsize();
    this.root.remove();
  }

  private choose(index: number): void {
    this.at = Math.max(0, Math.min(this.walls.length - 1, index));
    const wall = this.walls[this.at];
    if (wall === undefined) return;
    const { values } = wall;
    const noise = values["force_noise_rms_n"];
    const parts = [
      `μ = ${plain(wall.order)}`,
      `K = ${number(Number(values["stiffness_n_per_m"]))} N/m`,
      `B = ${number(Number(values["dissipation_n_s_mu_per_m"]))} N·s^μ/m`,
      `gain margin ${number(wall.margin)}`,
      `felt ${number(wall.stiffness)} N/m and ${number(Number(values["effective_damping_n_s_per_m"]))} N·s/m`,
      ...(typeof noise === "number" ? [`force noise ${number(1e3 * noise)} mN`] : []),
    ];
    say(this.words, parts.join(" · "));
    set(this.map, { "aria-valuemin": 1, "aria-valuemax": this.walls.length, "aria-valuenow": this.at + 1, "aria-valuetext": parts.join(", ") });
    const [x, y] = this.place(wall);
    set(this.chosen, { cx: x, cy: y });
  }

  private orders(): number[] {
    return [...new Set(this.walls.map((wall) => wall.order))].sort((a, b) => a - b);
  }

  private colour(index: number): string {
    return this.colours[index % this.colours.length] ?? "--blue";
  }

  private place({ margin, stiffness }: Wall): [number, number] {
    const [width, height] = this.size;
    const { left, right, top, bottom } = EDGES;
    return [
      left + share(this.ends.margin, margin) * (width - left - right),
      height - bottom - share(this.ends.stiffness, stiffness) * (height - top - bottom),
    ];
  }

  private nearest(x: number, y: number): number {
    const distance = (wall: Wall) => Math.hypot(...this.place(wall).map((value, axis) => value - (axis === 0 ? x : y)));
    return this.walls.reduce((best, wall, index) => (distance(wall) < distance(this.walls[best] ?? wall) ? index : best), 0);
  }

  private draw(): void {
    const [width, height] = this.size;
    if (width === 0) return;
    set(this.map, { viewBox: `0 0 ${width} ${height}` });
    const orders = this.orders();
    const dots = this.walls.map((wall) => {
      const [cx, cy] = this.place(wall);
      return svg("circle", { cx, cy, r: 2.5, style: `fill: var(${this.colour(orders.indexOf(wall.order))})` });
    });
    const text = (x: number, y: number, anchor: string, words: string) => svg("text", { x, y, "text-anchor": anchor, class: "axis" }, words);
    const [least, most] = this.ends.margin;
    const [softest, stiffest] = this.ends.stiffness;
    const { left, right, top, bottom } = EDGES;
    this.map.replaceChildren(
      text(left, height - bottom + 18, "middle", plain(Number(least.toPrecision(3)))),
      text(width - right, height - bottom + 18, "end", plain(Number(most.toPrecision(3)))),
      text(width - right, height - 6, "end", "gain margin, logarithmic"),
      text(left - 7, height - bottom, "end", number(softest)),
      text(left - 7, top + 4, "end", number(stiffest)),
      text(left, top - 10, "start", "effective stiffness, N/m, logarithmic"),
      ...dots,
      this.chosen,
    );
    this.choose(this.at);
  }

  /** The chosen wall and its device, as Feel starts them. */
  private wall(): ReadonlyMap<string, string> {
    const values = this.walls[this.at]?.values ?? {};
    const imperfections = (this.report["imperfections"] ?? {}) as Values;
    const all: [string, unknown][] = [
      ["order", values["order"]],
      ["scheme", this.report["scheme"]],
      ["K", values["stiffness_n_per_m"]],
      ["B", values["dissipation_n_s_mu_per_m"]],
      ["m", this.report["mass_kg"]],
      ["b", this.report["damping_n_s_per_m"]],
      ["T", this.report["sample_time_s"]],
      ["delay", imperfections["delay_s"]],
      ["lag", imperfections["current_lag_s"]],
      ["encoder", imperfections["encoder_resolution_m"]],
      ["noise", imperfections["sensor_noise_m"]],
      ["friction", imperfections["friction_n"]],
    ];
    return new Map(all.map(([key, value]) => [key, String(value ?? 0)]));
  }
}

/** The place on a logarithmic axis. */
function share([low, high]: [number, number], value: number): number {
  return high > low ? Math.log(value / low) / Math.log(high / low) : 0.5;
}
