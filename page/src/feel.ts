// Feel: what does this tissue feel like?

import type { App, ViewPart } from "./app";
import { Chart, legend, type Line } from "./chart";
import { times, values, type Points } from "./columns";
import { latest } from "./connection";
import { Demonstration } from "./demonstration";
import { el, say } from "./dom";
import { number, plain, steady } from "./format";
import { newestValue, type Frame } from "./frame";
import { numberOf } from "./fragment";
import { Knob } from "./knob";
import { RegionMap } from "./map";
import type { Environment, Feel, Hello, Mark, Unasked, Verdict } from "./protocol";
import { Scene } from "./scene";
import { Surface } from "./surface";

const SPAN_S = 30;
const GHOSTS: [string, string][] = [
  ["short,a3", "short memory, 1 s · A₃"],
  ["short", "short memory, 1 s"],
  ["a3", "A₃"],
  ["", "nothing"],
];
const FORCES: Line[] = [
  { label: "full memory", colour: "--blue", width: 2 },
  { label: "last second only", colour: "--verm", dash: [7, 5], width: 2 },
  { label: "A₃", colour: "--green", dash: [2, 4], width: 2 },
];
/** Lines of the force plot and their channels, in the order of drawing: the true one on top. */
const CHANNELS = ["ghost_a3_n", "ghost_short_n", "force_n"];
const DRAWN = [2, 1, 0].map((index) => FORCES[index]).filter((line) => line !== undefined);

interface Device {
  mass_kg: number;
  damping_n_s_per_m: number;
}

/** The server's verdict in a few words. */
export function sentence({ stable, margin, passive }: Verdict): string {
  return `${stable ? "stable" : "unstable"}, ${margin === null ? "at any gain" : `margin ${number(margin)}`} · ${passive ? "passive" : "not passive"}`;
}

/** What was felt, to begin it anew. */
function asBefore(feel: Feel): { environment: Environment; device: Device } {
  return { environment: feel.environment, device: { mass_kg: feel.mass_kg, damping_n_s_per_m: feel.damping_n_s_per_m } };
}

export class FeelView implements ViewPart {
  readonly root: HTMLElement;
  private readonly scene: Scene;
  private readonly force: Chart;
  private readonly motion: Chart;
  private readonly map = new RegionMap({ name: "Stable and passive walls on this device", axes: false });
  private readonly said = { force: el("span"), motion: el("span"), safe: el("span") };
  private readonly noMap = el("p", { class: "hint", hidden: true }, "This law has more elements than a map has axes: no map is drawn.");
  private readonly back = el("button", { type: "button", class: "small", hidden: true }, "show now");
  private readonly tissue = el("select", { "aria-label": "Tissue" });
  private readonly compare = el("select", { "aria-label": "Compare with" });
  private readonly order: Knob;
  private readonly dissipation: Knob;
  private readonly stiffness: Knob;
  private readonly legend = legend(FORCES);
  private readonly demonstration: Demonstration;
  private readonly surface: Surface;
  private readonly sendHand: (hand: { position_m: number; held: boolean }) => void;
  private readonly sendLaw: (change: object) => void;
  private readonly drawMap: (feel: Feel) => void;
  private feel: Feel | null = null;
  private frameNow: Frame | null = null;
  private dirty = false;
  private visible = false;
  private zoom: [number, number] | null = null;
  private marks: Mark[] = [];
  private wanted = new Map<string, string>();
  private asked = 0;
  private lastHand = { position_m: 0, held: false, at: 0 };
  private lastStep = 0;
  /** The server was there before. */
  private met = false;

  constructor(private readonly app: App) {
    const quiet = (): void => undefined;
    this.surface = new Surface(app.analysis);
    this.sendHand = latest((hand) => app.connection.ask("feel.hand", hand), quiet);
    this.sendLaw = latest(
      (change) => app.connection.ask<{ feel?: Feel }>("feel.set", change).then(({ feel }) => feel && this.take(feel)),
      (error) => {
        app.notify(error.message);
        if (this.feel) this.take(this.feel);
      },
    );
    this.drawMap = latest((feel) => this.mapped(feel), quiet);
    this.demonstration = new Demonstration((position, held) => this.sendHand({ position_m: position, held }));
    this.scene = new Scene({
      hand: (position, held) => this.hand(position, held),
      touched: () => this.demonstration.end(),
    });
    const zoomed = (span: [number, number] | null): void => this.zoomTo(span);
    const marks = (): { x: number; text: string }[] => this.marks.map((mark) => ({ x: mark.time_s - this.origin(), text: mark.text }));
    const xLabel = (value: number): string => this.timeLabel(value);
    const common = { xLabel, zoomed, marks, group: "feel" };
    this.force = new Chart({ ...common, name: "Force over time", lines: DRAWN, yLeast: 0, ySpan: 0.05, cursor: (x, at) => this.sayForce(x, at) });
    const black: Line[] = [{ label: "probe", colour: "--ink", width: 2 }];
    this.motion = new Chart({ ...common, name: "Indentation over time", lines: black, yLeast: 0, ySpan: 0.5, cursor: (x, at) => this.sayMotion(x, at) });
    const parse = (kind: string, text: string): Promise<number> => app.analysis.parse(kind, text);
    this.order = new Knob({
      label: "order μ", unit: "", kind: "number", least: 0, most: 1, value: 0.5, parse,
      help: "0 is a spring, 1 a damper; between them it relaxes and remembers",
      changed: (order) => this.change({ order }),
    });
    this.dissipation = new Knob({
      label: "dissipation B", unit: "N·s^μ/m", kind: "number", least: 1, most: 1000, log: true, value: 100, parse,
      help: "of the part that remembers",
      changed: (value) => this.changeDissipation(value),
    });
    this.stiffness = new Knob({
      label: "stiffness K", unit: "N/m", kind: "stiffness", least: 0, most: 1000, log: true, value: 0, parse,
      help: "of the part that does not",
      changed: (value) => this.change({ stiffness_n_per_m: value }),
    });
    this.root = this.layout();
    this.tissue.addEventListener("change", () => this.chooseTissue());
    this.compare.addEventListener("change", () => this.change({ ghosts: this.ghosts() }));
    this.back.addEventListener("click", () => this.zoomTo(null));
    requestAnimationFrame((now) => this.tick(now));
  }

  private layout(): HTMLElement {
    const card = (heading: (Node | string)[], ...parts: Node[]): HTMLElement => el("section", { class: "card" }, el("h2", {}, ...heading), ...parts);
    const hint = el("p", { class: "hint" }, "It relaxes while you hold, and remembers when you come back.");
    const knobs = el(
      "div",
      { class: "knobs" },
      el("label", { class: "choice" }, "Tissue", this.tissue),
      el("label", { class: "choice" }, "Compare with", this.compare),
      this.order.root,
      this.dissipation.root,
      this.stiffness.root,
    );
    return el(
      "div",
      { class: "view feel" },
      el("div", { class: "left" }, card(["Push the tissue: drag the probe, or use the arrow keys"], this.scene.root, hint), el("section", { class: "card", "aria-label": "Tissue" }, knobs)),
      el(
        "div",
        { class: "right" },
        card(["Force ", this.said.force, this.back], this.legend, this.force.root),
        card(["Indentation ", this.said.motion], this.motion.root),
        card(["Is it safe? ", this.said.safe], this.map.root as unknown as HTMLElement, this.noMap),
      ),
    );
  }

  // From the server.

  connected(hello: Hello): void {
    this.tissue.replaceChildren(...hello.tissues.map((tissue) => el("option", { value: tissue.name }, `${tissue.title} · ${tissue.model}`)));
    this.compare.replaceChildren(...GHOSTS.map(([value, text]) => el("option", { value }, text)));
    const { order, hand_m } = hello.ranges;
    if (order) this.order.change({ least: order.least, most: order.most });
    if (hand_m) this.scene.reach = [hand_m.least, hand_m.most];
    this.frameNow = null;
    this.marks = [];
    this.surface.reset();
    // Whoever opens the page finds a tissue that moves; who was only cut off for a while finds what there is.
    if (hello.controls && (!hello.feel || !this.met)) {
      const { environment, device } = hello.feel && !this.settled() ? asBefore(hello.feel) : this.addressed(hello);
      this.start(environment, device);
    } else if (hello.feel) this.take(hello.feel);
    this.met = true;
    this.lookAtNow();
  }

  unasked(message: Unasked): void {
    if (message.feel) this.take(message.feel);
    if (message.mark) {
      this.marks.push(message.mark);
      this.dirty = true;
    }
    const { status } = message;
    if (!status) return;
    this.scene.notice = status.fault ? "stopped by a fault" : status.stopped ? "stopped" : status.paused ? "paused" : "";
    if (status.stopped) this.scene.letGo();
    const may = status.controls && !status.stopped && !status.paused && this.feel !== null;
    if (may) this.demonstration.begin(performance.now());
    else this.demonstration.rest();
  }

  frame(frame: Frame): void {
    if (frame.source !== 0) return;
    if (this.zoom !== null && Math.abs(frame.firstTick * frame.sampleTimeS - this.zoom[0]) > 0.1 + 2 * frame.ticksPerColumn * frame.sampleTimeS) return;
    this.frameNow = frame;
    this.dirty = true;
  }

  // To the server.

  private start(environment: Environment, device: Device | undefined): void {
    this.app.connection
      .ask<{ feel: Feel }>("feel.start", { environment, ...(device ? { device } : {}), ghosts: this.ghosts() })
      .then(
        ({ feel }) => {
          this.marks = [];
          this.surface.reset();
          this.take(feel);
          this.zoomTo(null);
          this.demonstration.begin(performance.now());
        },
        (error: Error) => {
          this.app.notify(error.message);
          if (this.feel) this.take(this.feel);
        },
      );
  }

  /** A wall of the Design view. */
  startWall(environment: Environment, device: Device): void {
    this.start(environment, device);
  }

  private change(change: object): void {
    this.sendLaw(change);
  }

  private changeDissipation(value: number): void {
    const { feel } = this;
    if (!feel) return;
    if (feel.order_free) this.change({ dissipation_n_s_mu_per_m: value / feel.scale });
    else this.change({ scale: (feel.scale * value) / this.shownDissipation(feel) });
  }

  /** B as it acts, or the scale of a tissue that is no spring-pot beside a spring. */
  private shownDissipation(feel: Feel): number {
    return feel.order_free ? feel.dissipation_n_s_mu_per_m * feel.scale : feel.scale;
  }

  private chooseTissue(): void {
    const name = this.tissue.value;
    if (name === "") return;
    this.change({ environment: { tissue: name } });
  }

  private ghosts(): string[] {
    return this.compare.value.split(",").filter((name) => name !== "");
  }

  private hand(position: number, held: boolean): void {
    const now = performance.now();
    const same = held === this.lastHand.held && Math.abs(position - this.lastHand.position_m) < 1e-7;
    // What holds still is said twice a second: a page that is silent has let go.
    if (same && now - this.lastHand.at < 400) return;
    if (held === this.lastHand.held && now - this.lastHand.at < 15) return;
    this.lastHand = { position_m: position, held, at: now };
    this.sendHand({ position_m: position, held });
  }

  pause(): void {
    void this.app.tell("feel.pause", { paused: !(this.app.status?.paused ?? false) });
  }

  mark(): void {
    void this.app.tell("feel.mark", { text: String(this.marks.length + 1) });
  }

  // What is felt.

  private take(feel: Feel): void {
    this.feel = feel;
    this.surface.follows(feel);
    const tissue = "tissue" in feel.environment ? feel.environment.tissue : "";
    const own = this.tissue.querySelector("option[value='']");
    if (tissue === "" && !own) this.tissue.append(el("option", { value: "" }, "own wall"));
    this.tissue.value = tissue;
    this.compare.value = GHOSTS.find(([value]) => value === feel.ghosts.join(","))?.[0] ?? "";
    this.order.disabled = !feel.order_free;
    this.order.show(feel.order);
    const ranges = this.app.hello?.ranges;
    const range = feel.order_free ? ranges?.["dissipation_n_s_mu_per_m"] : ranges?.["scale"];
    if (range) {
      const names = feel.order_free ? { label: "dissipation B", unit: "N·s^μ/m" } : { label: "size", unit: "×" };
      this.dissipation.change({ ...names, least: Math.max(range.least, range.most * 1e-4), most: range.most });
    }
    this.dissipation.show(this.shownDissipation(feel));
    const wall = "wall" in feel.environment || feel.stiffness_n_per_m > 0;
    this.stiffness.root.hidden = !wall;
    const stiffness = ranges?.["stiffness_n_per_m"];
    if (stiffness) this.stiffness.change({ least: stiffness.least, most: stiffness.most });
    this.stiffness.show(feel.stiffness_n_per_m);
    this.legend.children[1]?.toggleAttribute("hidden", !feel.ghosts.includes("short"));
    this.legend.children[2]?.toggleAttribute("hidden", !feel.ghosts.includes("a3"));
    say(this.said.safe, sentence(feel.verdict));
    this.said.safe.title = feel.verdict.line;
    this.drawMap(feel);
    this.app.remember("feel", this.address(feel));
  }

  /** The map of the law and the device that run; a law of more elements has no place on one. */
  private async mapped(feel: Feel): Promise<void> {
    this.noMap.hidden = feel.order_free;
    if (!feel.order_free) {
      this.map.hide();
      return;
    }
    const { verdict } = feel;
    const walls = await this.app.analysis.walls({
      scheme: "exact", order: feel.order, sampleTime: this.app.hello?.sample_time_s ?? 1e-3,
      mass: verdict.mass_kg, damping: verdict.damping_n_s_per_m, handStiffness: verdict.hand_stiffness_n_per_m,
      delay: verdict.delay_s, lag: verdict.current_lag_s,
    });
    this.map.show(walls, feel.dissipation_n_s_mu_per_m * feel.scale, feel.stiffness_n_per_m * feel.scale, sentence(verdict));
  }

  // The address.

  private address(feel: Feel): Map<string, string> {
    const entries: [string, string][] = [];
    if ("tissue" in feel.environment) entries.push(["tissue", feel.environment.tissue]);
    entries.push(
      ["order", String(feel.order)],
      ["K", String(feel.stiffness_n_per_m)],
      ["B", String(feel.dissipation_n_s_mu_per_m)],
      ["scale", String(feel.scale)],
      ["m", String(feel.mass_kg)],
      ["b", String(feel.damping_n_s_per_m)],
      ["ghosts", feel.ghosts.join(",") || "none"],
    );
    return new Map(entries);
  }

  /** True if the address says what to feel. */
  private settled(): boolean {
    return this.wanted.has("tissue") || this.wanted.has("B");
  }

  private addressed(hello: Hello): { environment: Environment; device: Device | undefined } {
    return { environment: this.environmentOfAddress(hello), device: this.deviceOfAddress() };
  }

  private environmentOfAddress(hello: Hello): Environment {
    const ghosts = this.wanted.get("ghosts");
    this.compare.value = ghosts === "none" ? "" : (GHOSTS.find(([value]) => value === ghosts)?.[0] ?? "short,a3");
    const tissue = hello.tissues.find(({ name }) => name === this.wanted.get("tissue"));
    const order = numberOf(this.wanted, "order") ?? tissue?.order;
    const stiffness = numberOf(this.wanted, "K") ?? tissue?.stiffness_n_per_m;
    const dissipation = numberOf(this.wanted, "B") ?? tissue?.dissipation_n_s_mu_per_m;
    const same = tissue && order === tissue.order && stiffness === tissue.stiffness_n_per_m && dissipation === tissue.dissipation_n_s_mu_per_m;
    if (tissue && (same || !tissue.order_free)) return { tissue: tissue.name };
    if (order !== undefined && dissipation !== undefined) {
      return { wall: { order, stiffness_n_per_m: stiffness ?? 0, dissipation_n_s_mu_per_m: dissipation } };
    }
    const first = hello.tissues.find(({ name }) => name === "prostate-cancerous") ?? hello.tissues[0];
    return { tissue: first?.name ?? "" };
  }

  private deviceOfAddress(): Device | undefined {
    const [mass, damping] = [numberOf(this.wanted, "m"), numberOf(this.wanted, "b")];
    return mass === undefined || damping === undefined ? undefined : { mass_kg: mass, damping_n_s_per_m: damping };
  }

  // The picture.

  shown(wanted: Map<string, string>): void {
    this.wanted = wanted;
    this.visible = true;
    this.dirty = true;
    this.lookAtNow();
  }

  hidden(): void {
    this.visible = false;
    this.demonstration.rest();
    if (this.app.connection.ready) this.app.connection.ask("view.end", { view: 0 }).catch(() => undefined);
  }

  themed(): void {
    this.force.redraw();
    this.motion.redraw();
  }

  private lookAtNow(): void {
    if (!this.app.connection.ready || !this.visible) return;
    this.asked = this.force.columns;
    const span = this.zoom === null ? { last_s: SPAN_S } : { from_s: Math.max(0, this.zoom[0]), to_s: this.zoom[1] };
    this.app.connection.ask("view", { source: "live", ...span, columns: this.asked }).catch((error: Error) => this.app.notify(error.message));
  }

  /** Shows a span of the time axis, which is seconds before now, or of the run while zoomed. */
  private zoomTo(span: [number, number] | null): void {
    const origin = this.origin();
    this.zoom = span === null ? null : [span[0] + origin, span[1] + origin];
    this.back.hidden = this.zoom === null;
    this.lookAtNow();
  }

  /** Time that is 0 on the axis. */
  private origin(): number {
    if (this.zoom !== null || !this.frameNow) return 0;
    return this.end(this.frameNow);
  }

  private end(frame: Frame): number {
    return (frame.firstTick + frame.columns * frame.ticksPerColumn) * frame.sampleTimeS;
  }

  private timeLabel(value: number): string {
    if (this.zoom === null) return Math.abs(value) < 1e-9 ? "now" : `${plain(value)} s`;
    const step = (this.zoom[1] - this.zoom[0]) / 6;
    const places = Math.min(6, Math.max(0, Math.ceil(-Math.log10(step))));
    return `${value.toFixed(places)} s`;
  }

  private tick(now: number): void {
    requestAnimationFrame((next) => this.tick(next));
    const elapsed = Math.min(0.1, (now - this.lastStep) / 1000);
    this.lastStep = now;
    if (!this.visible) return;
    this.scene.step(elapsed);
    this.demonstration.step(now);
    if (Math.abs(this.force.columns - this.asked) > 4) this.lookAtNow();
    if (!this.dirty || !this.frameNow) return;
    this.dirty = false;
    this.draw(this.frameNow);
  }

  private draw(frame: Frame): void {
    const channel = (name: string): number => this.app.hello?.channels.indexOf(name) ?? -1;
    const line = (name: string, factor: number): Points => {
      const index = channel(name);
      const [least, most] = [frame.least[index], frame.most[index]];
      return least && most ? values(least, most, factor) : [];
    };
    const origin = this.origin();
    const x = times(frame, origin);
    const range: [number, number] = this.zoom ?? [-SPAN_S, 0];
    // A force is positive along the position; the tissue pushes back.
    this.force.draw(x, CHANNELS.map((name) => line(name, -1)), range);
    this.motion.draw(x, [line("position_m", 1000)], range);
    if (this.zoom !== null) return;
    const now = (name: string): number => newestValue(frame, channel(name));
    const [position, force] = [now("position_m"), -now("force_n")];
    if (Number.isNaN(position)) return;
    const surface = this.surface.at(this.end(frame), position, force);
    this.scene.show({ position, force: Math.max(0, force), hand: now("hand_m"), surface });
    if (!this.pointed) {
      say(this.said.force, steady(Math.max(0, force), 3, "N"));
      say(this.said.motion, steady(1000 * position, 2, "mm"));
    }
  }

  private pointed = false;

  private sayForce(x: number | null, at: (number | null)[]): void {
    this.pointed = x !== null;
    if (x === null) return;
    const [a3, short, full] = at;
    const ghosts = [short === null ? "" : ` · last second ${steady(short, 3, "N")}`, a3 === null ? "" : ` · A₃ ${steady(a3, 3, "N")}`];
    say(this.said.force, `${steady(full, 3, "N")}${ghosts.join("")} at ${number(x)} s`);
  }

  private sayMotion(x: number | null, at: (number | null)[]): void {
    if (x === null) return;
    const [position] = at;
    say(this.said.motion, `${steady(position, 2, "mm")} at ${number(x)} s`);
  }

  key(event: KeyboardEvent, down: boolean): boolean {
    const onControl = event.target instanceof HTMLElement && event.target.matches("input, select, textarea");
    if (!onControl && this.scene.key(event, down)) return true;
    if (!down) return false;
    if (event.key === "Escape" && this.zoom !== null) {
      this.zoomTo(null);
      return true;
    }
    if (event.key === "p" || event.key === "P") {
      this.pause();
      return true;
    }
    if (event.key === "m" || event.key === "M") {
      this.mark();
      return true;
    }
    return false;
  }
}
