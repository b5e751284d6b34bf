// Runs over each other: two charts on one time axis, theory beneath, and files of them.

import type { App } from "./app";
import { Chart, legend, type Line } from "./chart";
import { decimate, times, values, type Points } from "./columns";
import { el } from "./dom";
import { csvOf, pngOf, svgOf, type Picture } from "./export";
import { plain } from "./format";
import type { Frame } from "./frame";
import { readable } from "./names";
import type { OpenRun } from "./protocol";
import { save } from "./save";

/** Strokes of runs, best told apart first: as in the figures. */
const STROKES: Omit<Line, "label">[] = [
  { colour: "--blue" },
  { colour: "--verm", dash: [9, 4] },
  { colour: "--green", dash: [2.2, 3] },
  { colour: "--rose", dash: [11, 3, 2.2, 3] },
  { colour: "--ink", dash: [18, 5] },
  { colour: "--mute", dash: [4.5, 4.5] },
];
/** Theory lies beneath, broad and light, so that a curve on top of it is seen to agree all along. */
const THEORY = { colour: "--theory", width: 6 };

/** The experiment's own curve over its closed form, which no log holds. */
const JUDGED = "over its closed form";

interface Curve {
  run: OpenRun;
  channel: string;
  theory: boolean;
}

interface Sampled {
  time: number[];
  value: Points;
}

class Part {
  readonly select = el("select");
  readonly holder = el("div", { class: "chart-holder" });
  curves: Curve[] = [];
  chart: Chart | null = null;
  chosen = false;
  /** What the chart is made for. */
  key = "";
  x: number[] = [];
  drawn: Points[] = [];

  constructor(name: string, readonly prefers: RegExp) {
    this.select.setAttribute("aria-label", name);
  }
}

export class Overlay {
  readonly root: HTMLElement;
  private readonly parts = [new Part("Channel above", /^(contact_)?force_n$/), new Part("Channel below", /^(indenter_)?position_m$/)];
  private readonly all_ = el("button", { type: "button", class: "small", hidden: true }, "show all");
  private runs: OpenRun[] = [];
  private zoom: [number, number] | null = null;
  private frames = new Map<number, Frame>();
  private waiting = new Map<number, (frame: Frame) => void>();
  private round = 0;

  constructor(private readonly app: App) {
    const file = (text: string, act: (name: string) => void): HTMLButtonElement => {
      const made = el("button", { type: "button", class: "small" }, text);
      made.addEventListener("click", () => act(this.runs.map((run) => run.name.replace(/\W+/g, "-")).join("+") || "runs"));
      return made;
    };
    const [above, below] = this.parts;
    const files = el(
      "span",
      { class: "files" },
      file("PNG", (name) => void pngOf(this.pictures()).then((blob) => save(blob, `${name}.png`))),
      file("SVG", (name) => save(new Blob([svgOf(this.pictures())], { type: "image/svg+xml" }), `${name}.svg`)),
      file("CSV", (name) => save(new Blob([csvOf(this.pictures())], { type: "text/csv" }), `${name}.csv`)),
    );
    const parts = [above, below].map((part) => {
      part?.select.addEventListener("change", () => {
        part.chosen = true;
        this.load();
      });
      return el("div", { class: "overlay-part" }, part?.select ?? "", part?.holder ?? "");
    });
    this.root = el("section", { class: "card overlay" }, el("h2", {}, "Curves", this.all_, files), ...parts);
    this.all_.addEventListener("click", () => this.all());
  }

  /** Draws these runs. */
  show(runs: OpenRun[]): void {
    this.runs = runs;
    this.zoom = null;
    const judged = runs.filter(hasTheory).map((run) => `${run.curves?.quantity ?? "force"} ${JUDGED}`);
    const channels = [...new Set([...runs.flatMap((run) => run.channels), ...judged])];
    for (const part of this.parts) {
      const before = part.select.value;
      part.select.replaceChildren(...channels.map((name) => el("option", { value: name }, readable(name))));
      const best = channels.find((name) => part === this.parts[0] && name.endsWith(JUDGED)) ?? channels.find((name) => part.prefers.test(name)) ?? channels.find((name) => name !== this.parts[0]?.select.value);
      // A choice of one's own stays; what was best for other runs need not be now.
      part.select.value = part.chosen && channels.includes(before) ? before : (best ?? "");
    }
    this.load();
  }

  /** Draws anew what goes on. */
  refresh(): void {
    this.load();
  }

  /** Shows all of the time again; true if it was not. */
  all(): boolean {
    if (this.zoom === null) return false;
    this.zoom = null;
    this.load();
    return true;
  }

  frame(frame: Frame): void {
    const waiting = this.waiting.get(frame.source);
    this.waiting.delete(frame.source);
    if (waiting) waiting(frame);
    else this.frames.set(frame.source, frame);
  }

  themed(): void {
    for (const part of this.parts) part.chart?.redraw();
  }

  private load(): void {
    const round = ++this.round;
    this.all_.hidden = this.zoom === null;
    for (const part of this.parts) void this.loadPart(part, round);
  }

  private async loadPart(part: Part, round: number): Promise<void> {
    const channel = part.select.value;
    const judged = channel.endsWith(JUDGED);
    const runs = this.runs.filter((run) => (judged ? hasTheory(run) : run.channels.includes(channel)));
    part.curves = runs.map((run) => ({ run, channel, theory: false }));
    if (judged) part.curves.unshift(...runs.map((run) => ({ run, channel: "closed form", theory: true })));
    const key = JSON.stringify([channel, this.runs.map((run) => run.name)]);
    if (key !== part.key) this.makeChart(part);
    part.key = key;
    const chart = part.chart;
    if (!chart) return;
    try {
      const columns = await Promise.all(part.curves.map((curve) => this.fetch(curve, chart.columns)));
      if (round !== this.round) return;
      this.draw(part, chart, columns);
    } catch (error) {
      this.app.notify(error instanceof Error ? error.message : String(error));
    }
  }

  private async fetch(curve: Curve, columns: number): Promise<Sampled> {
    const { curves } = curve.run;
    if (curves && (curve.theory || curve.channel.endsWith(JUDGED))) return decimate(curves.time_s, (curve.theory ? curves.closed_form : curves.values) ?? [], columns);
    return sampled(await this.frameOf(curve, columns));
  }

  private async frameOf(curve: Curve, columns: number): Promise<Frame> {
    const span = this.zoom === null ? {} : { from_s: Math.max(curve.run.first_s, this.zoom[0]), to_s: Math.min(curve.run.last_s, this.zoom[1]) };
    const { view } = await this.app.connection.ask<{ view: number }>("view", { source: curve.run.name, ...span, columns, channels: [curve.channel] });
    return this.frameOfView(view);
  }

  /** The frame of a view, which comes before or after the answer. */
  async frameOfView(view: number): Promise<Frame> {
    const there = this.frames.get(view);
    this.frames.delete(view);
    return there ?? new Promise<Frame>((resolve) => this.waiting.set(view, resolve));
  }

  private makeChart(part: Part): void {
    const lines = part.curves.map((curve): Line => {
      const index = this.runs.indexOf(curve.run);
      const label = curve.theory ? readable(curve.channel) : this.runs.length > 1 ? curve.run.name : readable(curve.channel);
      return curve.theory ? { label, ...THEORY } : { label, width: 1.8, ...(STROKES[index % STROKES.length] ?? { colour: "--blue" }) };
    });
    part.chart = new Chart({
      name: `${readable(part.select.value)} over time`,
      lines,
      xLabel: (value) => `${plain(value)} s`,
      zoomed: (zoom) => {
        this.zoom = zoom;
        this.load();
      },
      group: "runs",
    });
    part.holder.replaceChildren(legend(lines), part.chart.root);
  }

  /** All curves on the times of all of them: where another has none, it has a gap that is not drawn. */
  private draw(part: Part, chart: Chart, columns: Sampled[]): void {
    const x = [...new Set(columns.flatMap(({ time }) => time))].sort((a, b) => a - b);
    const place = new Map(x.map((time, index) => [time, index]));
    const drawn = columns.map(({ time, value }) => {
      // undefined joins, null is a gap.
      const points = new Array<number | null | undefined>(x.length);
      time.forEach((at, index) => (points[place.get(at) ?? 0] = value[index] ?? null));
      return points as Points;
    });
    [part.x, part.drawn] = [x, drawn];
    const range = this.zoom ?? [Math.min(...this.runs.map((run) => run.first_s)), Math.max(...this.runs.map((run) => run.last_s))];
    chart.draw(x, drawn, range[0] < range[1] ? range : [0, 1]);
  }

  private pictures(): Picture[] {
    return this.parts
      .filter((part) => part.curves.length > 0)
      .map((part) => ({
        title: readable(part.select.value),
        x: part.x,
        lines: part.curves.map((curve, index) => ({
          name: `${curve.run.name} ${curve.channel}`,
          points: part.drawn[index] ?? [],
          ...(curve.theory ? THEORY : { width: 1.8, ...(STROKES[this.runs.indexOf(curve.run) % STROKES.length] ?? { colour: "--blue" }) }),
        })),
      }));
  }
}

function hasTheory(run: OpenRun): boolean {
  return (run.curves?.closed_form?.length ?? 0) > 0;
}

function sampled(frame: Frame): Sampled {
  const [least = new Float32Array(), most = new Float32Array()] = [frame.least[0], frame.most[0]];
  return { time: times(frame), value: values(least, most) };
}
