// Design: is it safe, and what is the best I can have?

import type { Judged, Question } from "./analysis";
import type { App, ViewPart } from "./app";
import { Chart, legend, type Line } from "./chart";
import { latest } from "./connection";
import { wallFile } from "./design-file";
import { el, say } from "./dom";
import { number, plain, quantity } from "./format";
import { numberOf } from "./fragment";
import { Knob, type KnobOptions } from "./knob";
import { RegionMap } from "./map";
import { save } from "./save";

interface Setting extends Pick<KnobOptions, "label" | "unit" | "kind" | "least" | "most" | "log"> {
  key: keyof Values;
  help: string;
}

export interface Values {
  K: number;
  B: number;
  mu: number;
  T: number;
  m: number;
  b: number;
  delay: number;
  lag: number;
  noise: number;
}

/** The device of the dissertation's section 4.4, with a wall of order 0.5. */
const START: Values = { K: 3000, B: 100, mu: 0.5, T: 1e-3, m: 0.065, b: 3.5, delay: 0, lag: 0, noise: 1e-5 };

const SETTINGS: Setting[] = [
  { key: "K", label: "stiffness K", unit: "N/m", kind: "stiffness", least: 0, most: 1e6, log: true, help: "spring of the wall" },
  { key: "B", label: "dissipation B", unit: "N·s^μ/m", kind: "number", least: 0, most: 1e5, log: true, help: "fractional part of the wall" },
  { key: "mu", label: "order μ", unit: "", kind: "number", least: 0, most: 2, help: "of the fractional part: 0 a spring, 1 a damper" },
  { key: "T", label: "sample time T", unit: "s", kind: "time", least: 1e-4, most: 1e-2, log: true, help: "of the loop" },
  { key: "m", label: "mass m", unit: "kg", kind: "mass", least: 1e-3, most: 10, log: true, help: "of device and hand" },
  { key: "b", label: "damping b", unit: "N·s/m", kind: "damping", least: 0, most: 100, log: true, help: "of device and hand" },
  { key: "delay", label: "delay", unit: "s", kind: "time", least: 0, most: 1e-2, help: "from a measurement to the force that answers it, beside the hold" },
  { key: "lag", label: "current lag", unit: "s", kind: "time", least: 0, most: 1e-2, help: "time constant of the motor current" },
  { key: "noise", label: "position noise", unit: "m", kind: "length", least: 0, most: 1e-3, log: true, help: "rms; encoder steps q make q/√12" },
];

const OPERATORS: [string, string][] = [
  ["exact", "full memory"],
  ["muir:3", "A₃, dissertation"],
];

const FREQUENCIES = 120;
const CURVES: Line[] = [
  { label: "wall alone", colour: "--mute", dash: [7, 5] },
  { label: "as felt", colour: "--blue", width: 2 },
];

export class DesignView implements ViewPart {
  readonly root: HTMLElement;
  private readonly knobs = new Map<keyof Values, Knob>();
  private readonly operator = el("select", { "aria-label": "Operator" }, ...OPERATORS.map(([value, text]) => el("option", { value }, text)));
  private readonly map: RegionMap;
  private readonly verdict = el("p", { class: "verdict", role: "status" });
  private readonly figures = el("dl", { class: "figures" });
  private readonly stiffness: Chart;
  private readonly damping: Chart;
  private readonly ask: (values: Values) => void;
  private values: Values = { ...START };
  private visible = false;

  constructor(private readonly app: App) {
    const parse = (kind: string, text: string): Promise<number> => app.analysis.parse(kind, text);
    for (const setting of SETTINGS) {
      const changed = (value: number): void => this.change({ [setting.key]: value });
      this.knobs.set(setting.key, new Knob({ ...setting, value: this.values[setting.key], parse, changed }));
    }
    this.map = new RegionMap({
      name: "Stable and passive walls",
      axes: true,
      moved: (B, K) => this.change({ B, K }),
    });
    const common = { lines: CURVES, logX: true, group: "design", xLabel: (hertz: number) => (hertz >= 1000 ? `${plain(hertz / 1000)} kHz` : `${plain(hertz)} Hz`) };
    this.stiffness = new Chart({ ...common, name: "Effective stiffness over frequency" });
    this.damping = new Chart({ ...common, name: "Effective damping over frequency" });
    this.ask = latest(
      (values) => this.judge(values),
      (error) => this.refused(error),
    );
    this.operator.addEventListener("change", () => this.change({}));
    this.root = this.layout();
  }

  private layout(): HTMLElement {
    const knobs = SETTINGS.map(({ key }) => this.knobs.get(key)?.root).filter((root) => root !== undefined);
    const use = el("button", { type: "button", class: "primary" }, "Use in the loop");
    const file = el("button", { type: "button" }, "Save as experiment file");
    use.addEventListener("click", () => this.use());
    file.addEventListener("click", () => save(new Blob([wallFile(this.values, this.operator.value)], { type: "application/toml" }), "wall.toml"));
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
      el("section", { class: "card margins" }, el("h2", {}, "Margins"), this.figures),
      el("section", { class: "card curves" }, el("h2", {}, "Effective stiffness, N/m"), legend(CURVES), this.stiffness.root, el("h2", {}, "Effective damping, N·s/m"), this.damping.root),
    );
  }

  private change(part: Partial<Values>): void {
    this.values = { ...this.values, ...part };
    for (const [key, knob] of this.knobs) if (knob.value !== this.values[key]) knob.show(this.values[key]);
    this.ask(this.values);
    this.app.remember("design", this.address());
  }

  private question(values: Values, omega: number[]): Question {
    return {
      scheme: this.operator.value, order: values.mu, stiffness: values.K, dissipation: values.B,
      mass: values.m, damping: values.b, handStiffness: 0, delay: values.delay, lag: values.lag,
      sampleTime: values.T, noise: values.noise, omega,
    };
  }

  private async judge(values: Values): Promise<void> {
    // From 0.1 Hz up to the frequency that two samples make.
    const [low, high] = [0.1, 0.5 / values.T];
    const hertz = Array.from({ length: FREQUENCIES }, (_, n) => low * (high / low) ** (n / (FREQUENCIES - 1)));
    const omega = hertz.map((f) => Math.min(2 * Math.PI * f, Math.PI / values.T));
    const judged = await this.app.analysis.judge(this.question(values, omega));
    if (!this.visible) return;
    this.map.show(judged, values.B, values.K, judged.sentence);
    this.verdict.classList.toggle("bad", !judged.stable);
    say(this.verdict, judged.sentence);
    this.say(judged);
    const curve = (part: number): number[] => hertz.map((_, n) => judged.effective[4 * n + part] ?? NaN);
    const range: [number, number] = [low, high];
    this.stiffness.draw(hertz, [curve(0), curve(2)], range, around(curve(0)));
    this.damping.draw(hertz, [curve(1), curve(3)], range, around(curve(1)));
    // For those who time it.
    this.root.dataset["drawn"] = String(Number(this.root.dataset["drawn"] ?? 0) + 1);
  }

  private refused(error: Error): void {
    this.verdict.classList.add("bad");
    say(this.verdict, error.message);
  }

  private say(judged: Judged): void {
    const rows: [string, string, string][] = [
      ["gain margin", judged.gainMargin === undefined ? "none" : number(judged.gainMargin), "factor on the whole wall that takes it to the edge"],
      ["lower gain margin", judged.gainMarginDown === undefined ? "none" : number(judged.gainMarginDown), "factor below 1 that does"],
      ["delay margin", judged.delayMargin === undefined ? "none" : quantity(judged.delayMargin, "s"), "additional delay that does"],
      ["sensitivity", judged.sensitivity === undefined ? "–" : `${number(judged.sensitivity)} at ${quantity(judged.sensitivityHz, "Hz")}`, "largest, 1 is neutral"],
      ["passive from b =", quantity(judged.requiredDamping, "N·s/m"), "damping of the device that passivity asks for"],
      ["force noise", quantity(judged.forceNoise, "N"), "rms"],
    ];
    this.figures.replaceChildren(...rows.flatMap(([name, value, help]) => [el("dt", { title: help }, name), el("dd", {}, value)]));
  }

  private use(): void {
    const { K, B, mu, T, m, b, delay, lag } = this.values;
    const sample = this.app.hello?.sample_time_s;
    if (sample !== undefined && sample !== T) this.app.notify(`The loop runs at T = ${quantity(sample, "s")}, not at ${quantity(T, "s")}.`);
    if (delay > 0 || lag > 0) this.app.notify("The simulated device has no delay and no lag.");
    this.app.feelWall({ wall: { order: mu, stiffness_n_per_m: K, dissipation_n_s_mu_per_m: B } }, { mass_kg: m, damping_n_s_per_m: b });
  }

  // The address.

  private address(): Map<string, string> {
    const entries = SETTINGS.map(({ key }): [string, string] => [key, String(this.values[key])]);
    return new Map([...entries, ["operator", this.operator.value]]);
  }

  shown(wanted: Map<string, string>): void {
    this.visible = true;
    const part: Partial<Values> = {};
    for (const { key, least, most } of SETTINGS) {
      const value = numberOf(wanted, key);
      if (value !== undefined) part[key] = Math.min(most, Math.max(least, value));
    }
    const operator = wanted.get("operator");
    if (OPERATORS.some(([value]) => value === operator)) this.operator.value = operator ?? "exact";
    this.change(part);
  }

  hidden(): void {
    this.visible = false;
  }

  connected(): void {
    // The server is not asked here.
  }

  unasked(): void {
    // Nothing of it is shown here.
  }

  frame(): void {
    // Nothing of it is shown here.
  }

  themed(): void {
    this.stiffness.redraw();
    this.damping.redraw();
  }

  key(): boolean {
    return false;
  }
}

/** A span that shows the wall: what is felt beyond, as the mass at high frequencies, leaves the picture. */
function around(wall: number[]): [number, number] {
  const [low, high] = [Math.min(0, ...wall), Math.max(0, ...wall)];
  const size = Math.max(high - low, 1e-9);
  return [low - 0.1 * size, high + 0.2 * size];
}
