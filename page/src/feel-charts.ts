// Force and indentation over time: now, or a span of the past while they are zoomed.

import type { App } from "./app";
import { Chart, legend, type Line } from "./chart";
import { times, values } from "./columns";
import { DepthPlot } from "./depth";
import { button, el, say } from "./dom";
import { plain, steady, tickTexts } from "./format";
import { newestValue, type Frame } from "./frame";
import type { Mark, Status } from "./protocol";

const SPAN_S = 30;
/** A picture that is older is said to be late, s. */
const LATE_S = 0.3;
const DEPTH_MS = 100;
const FORCES: Line[] = [
  { label: "full memory", colour: "--blue", width: 2 },
  { label: "last second only", colour: "--verm", dash: [7, 5], width: 2 },
  { label: "A₃", colour: "--green", dash: [2, 4], width: 2 },
];
/** Lines of the force plot and their channels, in the order of drawing: the true one on top. */
const CHANNELS = ["ghost_a3_n", "ghost_short_n", "force_n"];
/** The position at the moments of least and largest force of each. */
const DEPTHS = ["position_at_a3_m", "position_at_short_m", "position_at_force_m"];
const DRAWN = [2, 1, 0].map((index) => FORCES[index]).filter((line) => line !== undefined);
const PROBE: Line[] = [{ label: "probe", colour: "--ink", width: 2 }];

/** The newest numbers. */
export interface Newest {
  time: number;
  position: number;
  force: number;
  hand: number;
}

export class FeelCharts {
  readonly force: HTMLElement;
  readonly motion: HTMLElement;
  private readonly said = { force: el("span"), motion: el("span") };
  private readonly late = el("span", { class: "late" });
  private readonly back = button("show now", () => this.zoomTo(null), { class: "small", hidden: true });
  private readonly legend = legend(FORCES);
  private readonly forces: Chart;
  private readonly motions: Chart;
  private readonly depths = new DepthPlot();
  private depthDrawn = 0;
  private readonly marks: Mark[] = [];
  private live: Frame | null = null;
  private still: Frame | null = null;
  private zoom: [number, number] | null = null;
  private dirty = false;
  private columns = 0;
  private pointed = false;

  constructor(private readonly app: App) {
    const common = {
      xTexts: (ticks: number[]) => this.timeTexts(ticks),
      zoomed: (span: [number, number] | null) => this.zoomTo(span),
      marks: (): { x: number; text: string }[] => this.marks.map((mark) => ({ x: mark.time_s - this.origin(), text: mark.text })),
      group: "feel",
    };
    this.forces = new Chart({ ...common, name: "Force over time", lines: DRAWN, yLeast: 0, ySpan: 0.05, cursor: (x, at) => this.sayForce(x, at) });
    this.motions = new Chart({ ...common, name: "Indentation over time", lines: PROBE, yLeast: 0, ySpan: 0.5, cursor: (x, at) => this.sayMotion(x, at) });
    this.force = el("section", { class: "card" }, el("h2", {}, "Force ", this.said.force, this.late, this.back), this.legend.root, el("div", { class: "beside" }, this.forces.root, this.depths.root));
    this.motion = el("section", { class: "card" }, el("h2", {}, "Indentation ", this.said.motion), this.motions.root);
  }

  /** A loop begins anew, or another one is looked at. */
  reset(): void {
    this.marks.length = 0;
    this.live = null;
    this.zoomTo(null);
  }

  mark(mark: Mark): void {
    this.marks.push(mark);
    this.dirty = true;
  }

  /** Number of the next mark. */
  get nextMark(): number {
    return this.marks.length + 1;
  }

  showGhosts(ghosts: string[]): void {
    this.legend.root.children[1]?.toggleAttribute("hidden", !ghosts.includes("short"));
    this.legend.root.children[2]?.toggleAttribute("hidden", !ghosts.includes("a3"));
  }

  /** Asks for what goes on. */
  look(): void {
    if (!this.app.connection.ready) return;
    this.dirty = true;
    this.columns = this.forces.columns;
    const taken = (frame: Frame) => {
      this.live = frame;
      this.dirty = true;
    };
    this.app.connection.follow({ last_s: SPAN_S, columns: this.columns }, taken).catch((error: Error) => this.app.notify(error.message));
  }

  /** True if it was zoomed. */
  unzoom(): boolean {
    if (this.zoom === null) return false;
    this.zoomTo(null);
    return true;
  }

  /** Shows a span of the time axis, which is seconds before now, or of the run while zoomed. */
  private zoomTo(span: [number, number] | null): void {
    const origin = this.origin();
    const zoom: [number, number] | null = span === null ? null : [Math.max(0, span[0] + origin), span[1] + origin];
    this.dirty = true;
    if (zoom === null) {
      [this.zoom, this.still] = [null, null];
      this.back.hidden = true;
      return;
    }
    this.app.connection.frame({ source: "live", from_s: zoom[0], to_s: zoom[1], columns: this.forces.columns }).then(
      (frame) => {
        [this.zoom, this.still] = [zoom, frame];
        this.back.hidden = false;
        this.dirty = true;
      },
      (error: Error) => this.app.notify(error.message),
    );
  }

  /** Draws what is new; the newest numbers of the loop, zoomed or not. */
  step(): Newest | null {
    const { ready, heard } = this.app.connection;
    say(this.late, ready ? lateness(this.app.state.status, performance.now() - heard) : "");
    if (Math.abs(this.forces.columns - this.columns) > 4) this.look();
    const { live } = this;
    if (!this.dirty || live === null) return null;
    this.dirty = false;
    this.draw(this.still ?? live);
    const now = (name: string) => newestValue(live, this.channel(name));
    const newest = { time: end(live), position: now("position_m"), force: -now("force_n"), hand: now("hand_m") };
    if (!this.pointed && !Number.isNaN(newest.position)) {
      say(this.said.force, steady(Math.max(0, newest.force), 3, "N"));
      say(this.said.motion, steady(1000 * newest.position, 2, "mm"));
    }
    return newest;
  }

  private channel(name: string): number {
    return this.app.state.hello?.channels.indexOf(name) ?? -1;
  }

  private draw(frame: Frame): void {
    const line = (name: string, factor: number) => {
      const index = this.channel(name);
      const [least, most] = [frame.least[index], frame.most[index]];
      return least && most ? values(least, most, factor) : [];
    };
    const x = times(frame, this.origin());
    const range: [number, number] = this.zoom ?? [-SPAN_S, 0];
    // A force is positive along the position; the tissue pushes back.
    this.forces.draw(x, CHANNELS.map((name) => line(name, -1)), range);
    this.motions.draw(x, [line("position_m", 1000)], range);
    // Ten pictures a second are enough for the eye, and for a slow machine.
    if (performance.now() - this.depthDrawn < DEPTH_MS && this.zoom === null) return;
    this.depthDrawn = performance.now();
    const ends = (name: string): [Float32Array | undefined, Float32Array | undefined] => [frame.least[this.channel(name)], frame.most[this.channel(name)]];
    this.depths.draw(CHANNELS.map((name, n) => ({ ...(DRAWN[n] ?? { colour: "--blue" }), depth: ends(DEPTHS[n] ?? ""), force: ends(name) })));
  }

  /** Time that is 0 on the axis. */
  private origin(): number {
    return this.zoom !== null || this.live === null ? 0 : end(this.live);
  }

  private timeTexts(ticks: number[]): string[] {
    if (this.zoom === null) return ticks.map((tick) => (Math.abs(tick) < 1e-9 ? "now" : `${plain(tick)} s`));
    return tickTexts(ticks).map((text) => `${text} s`);
  }

  private sayForce(x: number | null, at: (number | null)[]): void {
    this.pointed = x !== null;
    if (x === null) return;
    const [a3, short, full] = at;
    const ghosts = [short === null ? "" : ` · last second ${steady(short, 3, "N")}`, a3 === null ? "" : ` · A₃ ${steady(a3, 3, "N")}`];
    say(this.said.force, `${steady(full, 3, "N")}${ghosts.join("")} at ${steady(x, 3, "s")}`);
  }

  private sayMotion(x: number | null, at: (number | null)[]): void {
    if (x === null) return;
    const [position] = at;
    say(this.said.motion, `${steady(position, 2, "mm")} at ${steady(x, 3, "s")}`);
  }
}

/** A sentence if the picture is late: as the server says, or as long as nothing was heard of it, ms. Without a loop it is silent. */
export function lateness(status: Status | null, silentMs: number): string {
  if (status === null || !status.running) return "";
  const late = Math.max(status.picture_late_s, silentMs / 1000);
  return late > LATE_S ? `The picture is ${late.toFixed(1)} s late: the connection or the server is slow.` : "";
}

function end(frame: Frame): number {
  return (frame.firstTick + frame.columns * frame.ticksPerColumn) * frame.sampleTimeS;
}
