// Runs over each other: two charts on one time axis, theory beneath, and files of them.

import type { App } from "./app";
import { Chart, legend, type Line } from "./chart";
import { decimate, joined, times, values, type Points } from "./columns";
import { DepthPlot } from "./depth";
import { button, el, say, words } from "./dom";
import { csvOf, pngOf, svgOf, type Picture } from "./export";
import { number, plain, tickTexts } from "./format";
import type { Frame } from "./frame";
import { plotted, readable } from "./names";
import { PlaneView } from "./plane";
import type { OpenRun, Values } from "./protocol";
import { download, save } from "./save";
import { choices, componentName, members, STROKES, strokeOf, THEORY, type Stroke } from "./vectors";

/** A measured record lies between theory and run. */
const RECORD = "measured record";
const MEASURED = { colour: "--rose", width: 4 };

/** Channels of force over depth, the position at the moments of least and largest force, and how many columns of time are asked for. */
const DEPTH = ["position_at_force_m", "commanded_force_n"];
const DEPTH_COLUMNS = 4000;

/** The experiment's own curve over its closed form, which no log holds. */
const JUDGED = "over its closed form";

interface Curve {
  run: OpenRun;
  /** Of the log, or what of the run's own curves. */
  channel: string;
  theory: boolean;
  judged: boolean;
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
  /** What the chart is made for. */
  key = "";
  /** What is drawn, with the curves that it is of. */
  drawn: { curves: Curve[]; x: number[]; points: Points[] } | null = null;

  constructor(readonly place: "above" | "below", readonly prefers: string[]) {
    this.select.setAttribute("aria-label", `Channel ${place}`);
  }
}

export class Overlay {
  readonly root: HTMLElement;
  /** Of runs with several axes. */
  readonly plane: PlaneView;
  /** Of runs with one. */
  readonly depth: HTMLElement;
  private readonly depths = new DepthPlot();
  private readonly parts = [new Part("above", ["commanded_force_n", "contact_force_n"]), new Part("below", ["position_m", "indenter_position_m"])];
  private readonly all_ = button("show all", () => this.all(), { class: "small", hidden: true });
  private runs: OpenRun[] = [];
  private readonly moment = el("span");
  private round = 0;

  constructor(private readonly app: App) {
    const file = (text: string, act: (name: string) => void) => button(text, () => act(this.runs.map(({ name }) => plainName(name)).join("+") || "runs"), { class: "small" });
    const [above, below] = this.parts;
    const files = el(
      "span",
      { class: "files" },
      file("PNG", (name) => void pngOf(this.pictures()).then((blob) => save(blob, "image/png", `${name}.png`))),
      file("SVG", (name) => save(svgOf(this.pictures()), "image/svg+xml", `${name}.svg`)),
      file("CSV", () => this.tables()),
    );
    const parts = [above, below].map((part) => {
      part?.select.addEventListener("change", () => app.dispatch({ do: "runs", part: { [part.place]: part.select.value } }));
      return el("div", { class: "overlay-part" }, part?.select ?? "", part?.holder ?? "");
    });
    this.root = el("section", { class: "card overlay" }, el("h2", {}, "Curves", this.moment, this.all_, files), ...parts);
    this.plane = new PlaneView(app);
    this.depth = el("section", { class: "card depth-card", hidden: true }, el("h2", {}, "Force over depth"), this.depths.root);
  }

  /** Draws these runs; true if one of them has a plane to show. */
  show(runs: OpenRun[]): boolean {
    this.runs = runs;
    const judged = runs.filter(hasTheory).map((run) => `${run.curves?.quantity ?? "force"} ${JUDGED}`);
    const channels = choices([...runs.flatMap((run) => run.channels), ...judged]);
    for (const part of this.parts) {
      // A list in use keeps its lines.
      if (channels.join() !== [...part.select.options].map(({ value }) => value).join()) part.select.replaceChildren(...channels.map((name) => el("option", { value: name }, plotted(name).name)));
      const best = channels.find((name) => part === this.parts[0] && name.endsWith(JUDGED)) ?? part.prefers.find((name) => channels.includes(name)) ?? channels.find((name) => name !== this.parts[0]?.select.value);
      // A choice of one's own stays; what was best for other runs need not be now.
      const chosen = this.app.state.runs[part.place];
      part.select.value = channels.includes(chosen) ? chosen : (best ?? "");
    }
    this.load();
    return this.plane.show(runs, this.zoom);
  }

  /** Draws anew what goes on. */
  refresh(): void {
    this.load();
    void this.plane.load();
  }

  /** Shows all of the time again; true if it was not. */
  all(): boolean {
    if (this.zoom === null) return false;
    this.zoomTo(null);
    return true;
  }

  private get zoom(): readonly [number, number] | null {
    return this.app.state.runs.span;
  }

  private zoomTo(span: [number, number] | null): void {
    this.app.dispatch({ do: "runs", part: { span } });
  }

  private load(): void {
    const round = ++this.round;
    this.all_.hidden = this.zoom === null;
    for (const part of this.parts) void this.loadPart(part, round);
    void this.loadDepth(round);
  }

  /** Force over depth of each run with one axis, of the same span. */
  private async loadDepth(round: number): Promise<void> {
    const runs = this.runs.filter((run) => run.axes === 1);
    this.depth.hidden = runs.length === 0;
    try {
      const frames = await Promise.all(runs.map((run) => this.frameOf(run, DEPTH, DEPTH_COLUMNS)));
      if (round !== this.round) return;
      const curves = frames.map((frame, n) => ({ ...this.strokeOf(runs[n]), sign: isPress(runs[n]) ? 1 : -1, depth: [frame.least[0], frame.most[0]] as const, force: [frame.least[1], frame.most[1]] as const }));
      this.depths.draw(curves.reverse());
    } catch (error) {
      this.app.notify(words(error));
    }
  }

  /** The stroke of a run among those that are open. */
  private strokeOf(run: OpenRun | undefined): Stroke {
    return STROKES[(run === undefined ? 0 : this.runs.indexOf(run)) % STROKES.length] ?? { colour: "--blue" };
  }

  private async loadPart(part: Part, round: number): Promise<void> {
    const choice = part.select.value;
    const judged = choice.endsWith(JUDGED);
    const runs = this.runs.filter((run) => (judged ? hasTheory(run) : members(choice, run.channels).length > 0));
    part.curves = runs.flatMap((run) => (judged ? [choice] : members(choice, run.channels)).map((channel) => ({ run, channel, theory: false, judged })));
    const behind = (channel: string, of: OpenRun[]) => of.map((run) => ({ run, channel, theory: true, judged }));
    if (judged) part.curves.unshift(...behind("closed form", runs), ...behind(RECORD, runs.filter((run) => run.curves?.record)));
    const key = JSON.stringify([choice, part.curves.map(({ run, channel }) => [run.name, channel])]);
    if (key !== part.key) this.makeChart(part);
    part.key = key;
    const { chart, curves } = part;
    if (!chart) return;
    try {
      const columns = await this.fetch(curves, chart.columns);
      if (round !== this.round) return;
      this.draw(part, chart, curves, columns);
    } catch (error) {
      this.app.notify(words(error));
    }
  }

  /** Points of the curves: of each run one frame with all of its channels. */
  private async fetch(curves: Curve[], columns: number): Promise<Sampled[]> {
    const logged = [...new Set(curves.filter(({ judged }) => !judged).map(({ run }) => run))];
    const frames = new Map<OpenRun, { channels: string[]; frame: Frame }>();
    await Promise.all(
      logged.map(async (run) => {
        const channels = curves.filter((curve) => curve.run === run).map(({ channel }) => channel);
        frames.set(run, { channels, frame: await this.frameOf(run, channels, columns) });
      }),
    );
    return curves.map(({ run, channel, theory }) => {
      const found = frames.get(run);
      if (found) return sampled(found.frame, found.channels.indexOf(channel), plotted(channel).factor);
      if (channel === RECORD) return decimate(run.curves?.record_time_s ?? [], run.curves?.record ?? [], columns);
      return decimate(run.curves?.time_s ?? [], (theory ? run.curves?.closed_form : run.curves?.values) ?? [], columns);
    });
  }

  private frameOf(run: OpenRun, channels: string[], columns: number): Promise<Frame> {
    return this.app.connection.frame({ source: run.name, ...this.span(run), columns, channels });
  }

  /** The part of a run that is visible. */
  private span(run: OpenRun): { from_s?: number; to_s?: number } {
    return this.zoom === null ? {} : { from_s: Math.max(run.first_s, this.zoom[0]), to_s: Math.min(run.last_s, this.zoom[1]) };
  }

  private makeChart(part: Part): void {
    const lines = part.curves.map((curve): Line => ({ label: this.label(curve, part.select.value), ...this.stroke(curve) }));
    part.chart?.destroy();
    part.drawn = null;
    const names = legend(lines);
    part.chart = new Chart({
      name: `${plotted(part.select.value).name} over time`,
      lines,
      xTexts: (ticks) => tickTexts(ticks).map((text) => `${text} s`),
      zoomed: (zoom) => this.zoomTo(zoom),
      cursor: (time, values) => {
        names.say(time === null ? [] : values.map((value) => number(value, 4)));
        say(this.moment, time === null ? "" : `at ${plain(time)} s`);
        this.plane.at(time);
      },
      group: "runs",
    });
    part.holder.replaceChildren(names.root, part.chart.root);
  }

  private label({ run, channel, theory, judged }: Curve, choice: string): string {
    if (theory) return readable(channel);
    const part = channel === choice ? "" : componentName(channel);
    if (this.runs.length > 1 || judged) return part === "" ? run.name : `${run.name} ${part}`;
    return part === "" ? plotted(channel).name : part;
  }

  /** Runs are told apart by colour and dashes; components of vectors by colour, and of several runs by the dashes of the run. */
  private stroke({ run, channel, theory }: Curve): Stroke {
    if (theory) return channel === RECORD ? MEASURED : THEORY;
    const own = this.strokeOf(run);
    const several = this.runs.length > 1 ? (own.dash ?? []) : undefined;
    return strokeOf(channel, several) ?? { width: 2, ...own };
  }

  /** All curves on the times of all of them: where another has none, it has a gap that is not drawn. */
  private draw(part: Part, chart: Chart, curves: Curve[], columns: Sampled[]): void {
    const { x, points } = joined(columns);
    part.drawn = { curves, x, points };
    const range: readonly [number, number] = this.zoom ?? [Math.min(...this.runs.map((run) => run.first_s)), Math.max(...this.runs.map((run) => run.last_s))];
    chart.draw(x, points, range[0] < range[1] ? range : [0, 1]);
  }

  private pictures(): Picture[] {
    return this.parts.flatMap(({ drawn, select }) => {
      if (drawn === null || drawn.curves.length === 0) return [];
      const lines = drawn.curves.map((curve, index) => ({ name: `${curve.run.name} ${curve.channel}`, points: drawn.points[index] ?? [], ...this.stroke(curve) }));
      return { title: plotted(select.value).name, x: drawn.x, lines };
    });
  }

  /** The samples of the visible span: of each log from the server, of a curve that no log holds from the run. */
  private tables(): void {
    const curves = this.parts.flatMap((part) => part.curves);
    for (const run of this.runs) {
      const channels = [...new Set(curves.filter((curve) => curve.run === run && !curve.judged).map(({ channel }) => channel))];
      const name = plainName(run.name);
      if (channels.length > 0) {
        this.app.connection.ask<{ address?: string; text?: string }>("runs.table", { name: run.name, channels, ...this.span(run) }).then(
          ({ address, text = "" }) => (address === undefined ? save(text, "text/csv", `${name}.csv`) : download(address, `${name}.csv`)),
          (error: Error) => this.app.notify(error.message),
        );
      }
      if (run.curves && curves.some((curve) => curve.run === run && curve.judged)) save(csvOf(run.curves, this.zoom), "text/csv", `${name}-closed-form.csv`);
    }
  }
}

/** The name of a run as that of a file. */
function plainName(name: string): string {
  return name.replace(/\W+/g, "-");
}

function isPress(run: OpenRun | undefined): boolean {
  return ((run?.metadata["experiment"] ?? {}) as Values)["experiment"] === "press";
}

function hasTheory(run: OpenRun): boolean {
  return (run.curves?.closed_form?.length ?? 0) > 0;
}

function sampled(frame: Frame, channel: number, factor: number): Sampled {
  const [least = new Float32Array(), most = new Float32Array()] = [frame.least[channel], frame.most[channel]];
  return { time: times(frame), value: values(least, most, factor) };
}
