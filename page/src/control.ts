// Control: a controller for a plant, by its wishes, with the best PID of order 1 beside it.

import type { App, ViewPart } from "./app";
import { Chart, legend, type Line } from "./chart";
import { latest, type Panel } from "./connection";
import { el, onSize, say, set, svg } from "./dom";
import { number, plain, quantity } from "./format";
import { Knob } from "./knob";
import { save } from "./save";
import { CONTROL_ENDS, type Control, type State } from "./state";

/** A controller in its loop. */
interface Candidate {
  controller: string;
  stable: boolean;
  verdict: string;
  phase_margin_rad: number | null;
  crossover_rad_s: number | null;
  gain_margin: number | null;
  gain_margin_down: number | null;
  delay_margin_s: number | null;
  sensitivity_peak: number | null;
  overshoot: number | null;
  settling_time_s: number | null;
  time_s: number[];
  step: number[];
  omega_rad_s: number[];
  open_real: number[];
  open_imaginary: number[];
  phase_rad: number[];
}

interface Designed {
  sample_time_s: number;
  fractional: Candidate;
  integer: Candidate | null;
  integer_reason: string | null;
  /** What `control design` says of it: readings, warnings, the gains for which it is proved. */
  notes: string[];
  file: string;
}

const LINES: Line[] = [
  { label: "PI^λD^μ", colour: "--blue", width: 2 },
  { label: "PID", colour: "--verm", dash: [7, 5], width: 2 },
];
/** Part of the step that is shown. */
const STEP_SHARE = 0.4;
/** Lowest phase that is shown, °. */
const PHASE_LEAST = -540;
const DEGREES = 180 / Math.PI;
/** Half the width of the Nyquist plot: −1 and the unit circle are well inside. */
const NYQUIST = 2.2;

export class ControlView implements ViewPart {
  readonly root: HTMLElement;
  private readonly plant = el("input", { type: "text", "aria-label": "Plant, a transfer function", spellcheck: "false", autocomplete: "off" });
  private readonly flat = el("input", { type: "checkbox", id: "flat" });
  private readonly crossover: Knob;
  private readonly margin: Knob;
  private readonly verdict = el("p", { class: "verdict", role: "status" });
  private readonly notes = el("div");
  private readonly figures = el("table", { class: "result" });
  private readonly file = el("button", { type: "button", class: "primary", disabled: true }, "Save the controller");
  private readonly step: Chart;
  private readonly gain: Chart;
  private readonly phase: Chart;
  private readonly nyquist = svg("svg", { class: "nyquist", role: "img", "aria-label": "Nyquist plot of the open loop" });
  private readonly panel: Panel;
  private readonly ask: (control: Control) => void;
  private designed: Designed | null = null;

  constructor(private readonly app: App) {
    const parse = (key: string, text: string): Promise<number> => app.connection.quantity(key, text);
    const { control } = app.state;
    const [low, high] = CONTROL_ENDS.crossover;
    this.crossover = new Knob({ label: "crossover", unit: "rad/s", ending: "_rad_s", log: true, least: low, most: high, value: control.crossover, help: "about 1.3 over the rise time", parse, changed: (crossover) => this.change({ crossover }) });
    const [least, most] = CONTROL_ENDS.margin;
    this.margin = new Knob({ label: "phase margin", unit: "°", ending: "_deg", least, most, value: control.margin, help: "more makes less overshoot", parse, changed: (margin) => this.change({ margin }) });
    this.step = new Chart({ name: "Step of the reference", lines: LINES, xTexts: (ticks) => ticks.map((tick) => quantity(tick, "s")) });
    const bode = { lines: LINES, logX: true, group: "bode", xTexts: (ticks: number[]): string[] => ticks.map((tick) => number(tick, 2)) };
    this.gain = new Chart({ ...bode, name: "Gain of the open loop over frequency" });
    this.phase = new Chart({ ...bode, name: "Phase of the open loop over frequency" });
    this.panel = app.connection.panel("control");
    this.ask = latest(
      (wishes) => this.design(wishes),
      (error) => this.refused(error),
    );
    this.plant.addEventListener("change", () => this.change({ plant: this.plant.value.trim() }));
    this.flat.addEventListener("change", () => this.change({ flat: this.flat.checked }));
    this.root = this.layout();
  }

  private layout(): HTMLElement {
    this.file.addEventListener("click", () => {
      if (this.designed) save(new Blob([this.designed.file], { type: "application/toml" }), "controller.toml");
    });
    const holder = el("div", { class: "plane-holder" }, this.nyquist as unknown as HTMLElement);
    onSize(holder, () => this.draw());
    return el(
      "div",
      { class: "view control" },
      el(
        "section",
        { class: "card settings" },
        el("h2", {}, "Plant and wishes"),
        el("div", { class: "knobs single" }, el("label", { class: "choice" }, "Plant", this.plant), this.crossover.root, this.margin.root, el("label", { class: "check", for: "flat" }, this.flat, "flat phase: the overshoot stays when the gain of the plant changes")),
        this.verdict,
        this.notes,
        this.figures,
        el("div", { class: "buttons" }, this.file),
      ),
      el("section", { class: "card steps" }, el("h2", {}, "Step"), legend(LINES).root, this.step.root),
      el("section", { class: "card loci" }, el("h2", {}, "Nyquist"), holder),
      el("section", { class: "card curves" }, el("h2", {}, "Gain, dB"), this.gain.root, el("h2", {}, "Phase, °"), this.phase.root),
    );
  }

  private change(part: Partial<Control>): void {
    this.app.dispatch({ do: "control", part });
  }

  render(state: State, before: State): void {
    const { control } = state;
    const shown = before.view === "control" && before.hello !== null;
    if (state.view !== "control" || state.hello === null || (control === before.control && shown && this.root.dataset["drawn"])) return;
    if (document.activeElement !== this.plant) this.plant.value = control.plant;
    this.flat.checked = control.flat;
    this.crossover.show(control.crossover);
    this.margin.show(control.margin);
    this.ask(control);
  }

  private async design({ plant, crossover, margin, flat }: Control): Promise<void> {
    const wishes = { plant, crossover_rad_s: crossover, phase_margin_rad: margin / DEGREES, flat_phase: flat };
    const designed = await this.panel.ask<Designed>({ control: wishes });
    if (designed === null) return;
    this.designed = designed;
    this.draw();
    // For those who time it.
    this.root.dataset["drawn"] = String(Number(this.root.dataset["drawn"] ?? 0) + 1);
  }

  private refused(error: Error): void {
    this.designed = null;
    this.verdict.classList.add("bad");
    say(this.verdict, error.message);
    this.root.dataset["drawn"] = "0";
    this.draw();
  }

  private draw(): void {
    const { designed } = this;
    this.file.disabled = designed === null;
    const both = designed === null ? [] : [designed.fractional, designed.integer];
    const lines = (of: (one: Candidate) => number[]): number[][] => LINES.map((_, n) => (both[n] ? of(both[n]) : []));
    const drawn = (chart: Chart, x: number[], y: number[][], share = 1, within?: [number, number]): void => {
      chart.draw(x, y.map((line) => (line.length === x.length ? line : x.map(() => null))), [x[0] ?? 0, share * (x.at(-1) ?? 1)], within);
    };
    const { time_s: time = [], omega_rad_s: omega = [], step = [] } = both[0] ?? {};
    // An unstable PID does not press the other to the ground.
    const most = Math.max(1.2, ...step.map((y) => Math.min(y, 3)));
    drawn(this.step, time, lines((one) => one.step), STEP_SHARE, [Math.min(0, ...step.map((y) => Math.max(y, -1))), most]);
    drawn(this.gain, omega, lines((one) => one.open_real.map((re, n) => 20 * Math.log10(Math.hypot(re, one.open_imaginary[n] ?? 0)))));
    const phases = lines((one) => one.phase_rad.map((phase) => phase * DEGREES));
    // A dead time turns for ever.
    drawn(this.phase, omega, phases, 1, [Math.max(PHASE_LEAST, Math.min(0, ...phases.flat())), Math.max(0, ...phases.flat())]);
    this.drawNyquist(both);
    this.notes.replaceChildren(...(designed?.notes ?? []).map((text) => el("p", { class: text.startsWith("Warning") ? "hint trouble" : "hint" }, text)));
    if (designed === null) {
      this.figures.replaceChildren();
      return;
    }
    const { fractional, integer } = designed;
    this.verdict.classList.toggle("bad", !fractional.stable);
    say(this.verdict, `C(s) = ${fractional.controller.replace(/\d+\.\d+(e-?\d+)?/g, (text) => String(Number(Number(text).toPrecision(4))))}: ${fractional.verdict}.`);
    // Nothing is said of a loop that is not proved stable: "none" would be the best of margins.
    const margin = (of: (one: Candidate) => string) => (one: Candidate): string => (one.sensitivity_peak === null ? "–" : of(one));
    const rows: [string, (one: Candidate) => string][] = [
      ["verdict", (one) => one.verdict],
      ["crossover", (one) => quantity(one.crossover_rad_s, "rad/s")],
      ["phase margin", margin((one) => (one.phase_margin_rad === null ? "none" : `${number(one.phase_margin_rad * DEGREES)}°`))],
      ["gain margin", margin((one) => (one.gain_margin === null ? "none" : number(one.gain_margin)))],
      ["lower gain margin", margin((one) => (one.gain_margin_down === null ? "none" : number(one.gain_margin_down)))],
      ["delay margin", margin((one) => (one.delay_margin_s === null ? "none" : quantity(one.delay_margin_s, "s")))],
      ["largest |S|", margin((one) => number(one.sensitivity_peak ?? NaN))],
      ["overshoot", (one) => (one.overshoot === null ? "–" : `${number(100 * one.overshoot)}\u202f%`)],
      ["settled within 2 % at", (one) => (one.settling_time_s === null ? "–" : quantity(one.settling_time_s, "s"))],
    ];
    const cells = (of: (one: Candidate) => string): HTMLElement[] => [fractional, integer].map((one) => el("td", {}, one === null ? "–" : of(one)));
    const head = el("tr", {}, el("th", {}), ...LINES.map(({ label }) => el("th", { scope: "col" }, label)));
    const said = designed.integer_reason === null ? [] : [el("caption", { class: "hint" }, `No PID: ${designed.integer_reason}`)];
    const sampled = el("tr", {}, el("th", { scope: "row" }, "sample time"), el("td", { colspan: 2 }, quantity(designed.sample_time_s, "s")));
    this.figures.replaceChildren(...said, el("tbody", {}, head, ...rows.map(([name, of]) => el("tr", {}, el("th", { scope: "row" }, name), ...cells(of))), sampled));
  }

  /** L from low frequencies on, in the circle that counts; +1 on both axes is a quarter of the picture. */
  private drawNyquist(both: (Candidate | null)[]): void {
    const size = 100 / NYQUIST;
    const far = (value: number): number => Math.max(-1e4, Math.min(1e4, value));
    const path = (one: Candidate): string => `M${one.open_real.map((re, n) => `${far(re * size).toFixed(2)} ${far(-(one.open_imaginary[n] ?? 0) * size).toFixed(2)}`).join("L")}`;
    const curves = both.map((one, n) => {
      const curve = svg("path", { d: one === null ? "" : path(one) });
      set(curve, { stroke: `var(${LINES[n]?.colour ?? "--ink"})`, "stroke-dasharray": (LINES[n]?.dash ?? []).map((length) => length / 4).join(" ") });
      return curve;
    });
    const texts = [-2, -1, 1, 2].map((at) => {
      const text = svg("text", { x: at * size, y: 6 });
      text.textContent = plain(at);
      return text;
    });
    set(this.nyquist, { viewBox: "-100 -100 200 200" });
    this.nyquist.replaceChildren(
      svg("path", { class: "axis", d: "M-100 0H100M0 -100V100" }),
      svg("circle", { class: "axis", r: size }),
      ...texts,
      ...curves,
      svg("circle", { class: "point", cx: -size, r: 1.6 }),
    );
  }

  unasked(): void {
    // Nothing of it is shown here.
  }

  themed(): void {
    for (const chart of [this.step, this.gain, this.phase]) chart.redraw();
  }

  key(): boolean {
    return false;
  }
}
