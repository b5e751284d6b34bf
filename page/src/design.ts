// Design: is it safe, and what is the best I can have?

import type { App, ViewPart } from "./app";
import { Chart, legend, type Line } from "./chart";
import { latest, type Panel } from "./connection";
import { wallFile } from "./design-file";
import { button, chosen, el, say, select } from "./dom";
import { number, plain, quantity } from "./format";
import { Knob, type KnobOptions } from "./knob";
import { POINTS, RegionMap } from "./map";
import { prediction } from "./prediction";
import type { Judged } from "./protocol";
import { save } from "./save";
import { DESIGN_ENDS, OPERATORS, type Design, type State } from "./state";

interface Setting extends Pick<KnobOptions, "label" | "unit" | "ending" | "log"> {
  key: keyof typeof DESIGN_ENDS;
  help: string;
}

const SETTINGS: Setting[] = [
  { key: "K", label: "stiffness K", unit: "N/m", ending: "_n_per_m", log: true, help: "spring of the wall" },
  { key: "B", label: "dissipation B", unit: "N·s^μ/m", ending: "", log: true, help: "fractional part of the wall" },
  { key: "mu", label: "order μ", unit: "", ending: "", help: "of the fractional part: 0 a spring, 1 a damper" },
  { key: "T", label: "sample time T", unit: "s", ending: "_s", log: true, help: "of the loop" },
  { key: "m", label: "mass m", unit: "kg", ending: "_kg", log: true, help: "of device and hand" },
  { key: "b", label: "damping b", unit: "N·s/m", ending: "_n_s_per_m", log: true, help: "of device and hand" },
  { key: "delay", label: "delay", unit: "s", ending: "_s", help: "from a measurement to the force that answers it, beside the hold" },
  { key: "lag", label: "current lag", unit: "s", ending: "_s", help: "time constant of the motor current" },
  { key: "noise", label: "position noise", unit: "m", ending: "_m", log: true, help: "rms; encoder steps q make q/√12" },
];

/** Points of the map while a slider is dragged, and how long it is left alone before it is drawn with all. */
const DRAGGED_POINTS = 200;
const REST_MS = 150;
const CURVES: Line[] = [
  { label: "wall alone", colour: "--mute", dash: [7, 5] },
  { label: "as felt", colour: "--blue", width: 2 },
];

export class DesignView implements ViewPart {
  readonly root: HTMLElement;
  private readonly knobs = new Map<Setting["key"], Knob>();
  private readonly operator = select("Operator", OPERATORS);
  private readonly map: RegionMap;
  private readonly verdict = el("p", { class: "verdict", role: "status" });
  private readonly figures = el("dl", { class: "figures" });
  private readonly felt = el("p", { class: "hint" });
  private readonly stiffness: Chart;
  private readonly damping: Chart;
  private readonly panel: Panel;
  private readonly ask: (design: Design, points: number) => void;
  private resting = 0;

  constructor(private readonly app: App) {
    const parse = (key: string, text: string) => app.connection.quantity(key, text);
    for (const setting of SETTINGS) {
      const changed = (value: number) => this.change({ [setting.key]: value });
      const [least, most] = DESIGN_ENDS[setting.key];
      this.knobs.set(setting.key, new Knob({ ...setting, least, most, value: app.state.design[setting.key], parse, changed }));
    }
    this.map = new RegionMap({
      name: "Stable and passive walls",
      axes: true,
      moved: (B, K) => this.change({ B, K }),
    });
    const hertz = (ticks: number[]) => ticks.map((tick) => (tick >= 1000 ? `${plain(tick / 1000)} kHz` : `${plain(tick)} Hz`));
    const common = { lines: CURVES, logX: true, group: "design", xTexts: hertz };
    this.stiffness = new Chart({ ...common, name: "Effective stiffness over frequency" });
    this.damping = new Chart({ ...common, name: "Effective damping over frequency" });
    this.panel = app.connection.panel("design");
    const ask = latest(
      ({ design, points }: { design: Design; points: number }) => this.judge(design, points),
      (error) => this.refused(error),
    );
    this.ask = (design, points) => ask({ design, points });
    this.operator.addEventListener("change", () => this.change({ operator: this.operator.value }));
    this.root = this.layout();
  }

  private layout(): HTMLElement {
    const knobs = SETTINGS.map(({ key }) => this.knobs.get(key)?.root).filter((root) => root !== undefined);
    const use = button("Use in the loop", () => this.use(), { class: "primary" });
    const file = button("Save as experiment file", () => save(wallFile(this.app.state.design), "application/toml", "wall.toml"));
    return el(
      "div",
      { class: "view design" },
      el(
        "section",
        { class: "card settings" },
        el("h2", {}, "Wall and device"),
        el("div", { class: "knobs single" }, ...knobs, el("label", { class: "choice" }, "Operator", this.operator)),
        el("div", { class: "buttons" }, use, file),
      ),
      el("section", { class: "card region" }, el("h2", {}, "Drag the point, or use the arrow keys"), this.map.root as unknown as HTMLElement, this.verdict),
      el("section", { class: "card margins" }, el("h2", {}, "Margins"), this.figures, this.felt),
      el("section", { class: "card curves" }, el("h2", {}, "Effective stiffness, N/m"), legend(CURVES).root, this.stiffness.root, el("h2", {}, "Effective damping, N·s/m"), this.damping.root),
    );
  }

  private change(part: Partial<Design>): void {
    this.app.dispatch({ do: "design", part });
  }

  render(state: State, before: State): void {
    const { design } = state;
    const shown = before.view === "design" && before.hello !== null;
    if (state.view !== "design" || (design === before.design && shown)) return;
    for (const [key, knob] of this.knobs) knob.show(design[key]);
    chosen(this.operator, design.operator);
    // It is asked for as soon as there is a server, or again.
    if (state.hello === null) return;
    this.ask(design, DRAGGED_POINTS);
    clearTimeout(this.resting);
    this.resting = window.setTimeout(() => this.ask(design, POINTS), REST_MS);
  }

  private async judge(design: Design, points: number): Promise<void> {
    const { K, B, noise } = design;
    const device = {
      scheme: design.operator, order: design.mu, sample_time_s: design.T, mass_kg: design.m, damping_n_s_per_m: design.b,
      hand_stiffness_n_per_m: 0, delay_s: design.delay, current_lag_s: design.lag,
    };
    const wall = { ...device, stiffness_n_per_m: K, dissipation_n_s_mu_per_m: B, position_noise_m: noise, points };
    const judged = await this.panel.ask<Judged>({ wall });
    if (judged === null || this.app.state.view !== "design") return;
    const said = sentence(judged);
    this.map.show(judged, JSON.stringify(device), B, K, said);
    this.verdict.classList.toggle("bad", !judged.stable);
    say(this.verdict, said);
    this.say(judged);
    const [hertz, stiffness, damping, feltStiffness, feltDamping] = ([0, 1, 2, 3, 4] as const).map((column) => judged.curves.map((row) => row[column])) as [number[], number[], number[], number[], number[]];
    const range: [number, number] = [hertz[0] ?? 0, hertz.at(-1) ?? 1];
    this.stiffness.draw(hertz, [stiffness, feltStiffness], range, around(stiffness));
    this.damping.draw(hertz, [damping, feltDamping], range, around(damping));
    // For those who time it.
    this.root.dataset["drawn"] = String(Number(this.root.dataset["drawn"] ?? 0) + 1);
  }

  private refused(error: Error): void {
    this.verdict.classList.add("bad");
    say(this.verdict, error.message);
  }

  private say(judged: Judged): void {
    const rows: [string, string, string][] = [
      ["gain margin", judged.gain_margin === null ? "none" : number(judged.gain_margin), "factor on the whole wall that takes it to the edge"],
      ["lower gain margin", judged.gain_margin_down === null ? "none" : number(judged.gain_margin_down), "factor below 1 that does"],
      ["every motion", judged.pulling_contact, "contact that may pull, acts on one side or stiffens, and is nowhere steeper; a wall that never pulls is not proved"],
      ["delay margin", judged.delay_margin_s === null ? "none" : quantity(judged.delay_margin_s, "s"), "additional delay that does"],
      ["sensitivity", judged.sensitivity_peak === null ? "–" : `${number(judged.sensitivity_peak)} at ${quantity(judged.sensitivity_peak_hz, "Hz")}`, "largest, 1 is neutral"],
      ["passive from b =", judged.required_damping, "damping of the device that passivity asks for"],
      ["force noise", quantity(judged.force_noise_n, "N"), "rms"],
    ];
    say(this.felt, prediction(judged.hand));
    this.figures.replaceChildren(...rows.flatMap(([name, value, help]) => [el("dt", { title: help }, name), el("dd", {}, value)]));
  }

  private use(): void {
    const { mu, operator, ...rest } = this.app.state.design;
    const values = Object.entries({ order: mu, scheme: operator, ...rest, encoder: 0, friction: 0 }).map(([key, value]): [string, string] => [key, String(value)]);
    this.app.dispatch({ do: "start", values: new Map(values) });
  }
}

/** The verdict in a sentence. */
function sentence({ stable, gain_margin: margin, passive, negative_at_rest: pulls, required_damping: least }: Judged): string {
  const loop = !stable ? "unstable" : margin === null ? "stable at any gain" : `stable, gain margin ${number(margin)}`;
  return `${loop} · ${passive ? "passive" : pulls ? "not passive: it pulls at rest" : `not passive: that takes a damping of ${least}`}`;
}

/** A span that shows the wall: what is felt beyond, as the mass at high frequencies, leaves the picture. */
function around(wall: number[]): [number, number] {
  const [low, high] = [Math.min(0, ...wall), Math.max(0, ...wall)];
  const size = Math.max(high - low, 1e-9);
  return [low - 0.1 * size, high + 0.2 * size];
}
