// Control: a controller for a plant, by its wishes, with the best PID of order 1 beside it, and a controller of one's own.

import type { App, Dropped, TextFile, ViewPart } from "./app";
import { Chart, legend, type Line } from "./chart";
import { joined } from "./columns";
import { latest, type Panel } from "./connection";
import { button, el, onSize, say, select, set, svg } from "./dom";
import { Fields } from "./forms";
import { number, plain, quantity } from "./format";
import { Knob } from "./knob";
import { OwnLoop } from "./loop";
import { PlantRecord } from "./plant-record";
import type { Values } from "./protocol";
import { save } from "./save";
import { CONTROL_ENDS, type Control, type State } from "./state";

/** A controller in its loop; of a measured plant, which does not run, only the controller. */
interface Candidate {
  controller: string;
  gains: Record<string, number> | null;
  stable?: boolean | null;
  verdict?: string;
  /** As the command's report has them; null where nothing is proved. */
  margins?: { crossover_rad_s: number | null; phase_margin_deg: number | null; gain_up: number | null; gain_down: number | null; delay_margin_s: number | null; sensitivity_peak: number } | null;
  shape?: { overshoot: number; settling_time_s: number | null } | null;
  time_s?: number[];
  step?: number[];
  command?: number[];
  /** The output with a load of 1 on the command. */
  loaded?: number[];
  /** Steps at other gains of the plant. */
  robustness?: { gain: number; stable: boolean; step: number[] }[];
  omega_rad_s?: number[];
  open_real?: number[];
  open_imaginary?: number[];
  phase_rad?: number[];
}

export interface Designed {
  /** The plant as it was read. */
  plant: string;
  sample_time_s: number;
  fractional: Candidate;
  integer: Candidate | null;
  integer_reason: string | null;
  own: Candidate | null;
  /** What `control design` says of it: readings, warnings, the gains for which it is proved. */
  notes: string[];
  file: string;
}

const LINES: Line[] = [
  { label: "PI^λD^μ", colour: "--blue", width: 2 },
  { label: "PID", colour: "--verm", dash: [7, 5], width: 2 },
  { label: "yours", colour: "--green", dash: [2, 4], width: 2 },
];
/** The gains of a PI^λD^μ by the keys of its file. */
const GAINS: Record<string, string> = {
  proportional_gain: "proportional gain",
  integral_gain_per_s_lambda: "integral gain, s^−λ",
  integral_order: "order λ",
  derivative_gain_s_mu: "derivative gain, s^μ",
  derivative_order: "order μ",
};
/** What can be seen over time, and how it is called. */
const SEEN = { step: "Step of the reference", command: "Command in that step", loaded: "Step of a load on the command", gains: "Steps at half to double the plant's gain" };
type Seen = keyof typeof SEEN;
/** Part of the step that is shown. */
const STEP_SHARE = 0.4;
/** Lowest phase that is shown, °. */
const PHASE_LEAST = -540;
const DEGREES = 180 / Math.PI;
/** Half the width of the Nyquist plot: −1 and the unit circle are well inside. */
const NYQUIST = 2.2;
/** The first samples of a command: a kick many times the rest. */
const KICK = 5;

export class ControlView implements ViewPart {
  readonly root: HTMLElement;
  private readonly plant = el("input", { type: "text", "aria-label": "Plant, a transfer function", spellcheck: "false", autocomplete: "off" });
  private readonly flat = el("input", { type: "checkbox", id: "flat" });
  private readonly choose = el("input", { type: "file", accept: ".toml,.csv,.tsv", "aria-label": "File of a plant or a controller" });
  private readonly files = el("p", { class: "hint" });
  private readonly trouble = el("span", { class: "trouble", role: "alert" });
  private readonly crossover: Knob;
  private readonly margin: Knob;
  private readonly verdict = el("p", { class: "verdict", role: "status" });
  private readonly read = el("p", { class: "hint" });
  private readonly notes = el("div");
  private readonly figures = el("table", { class: "result", tabindex: 0, "aria-label": "Controllers" });
  private readonly file = button("Save the controller", () => this.designed && save(this.designed.file, "application/toml", "controller.toml"), { class: "primary", disabled: true });
  private readonly seen = select("Over time", Object.entries(SEEN));
  private readonly said = el("p", { class: "hint" });
  private readonly legend = legend(LINES).root;
  private readonly steps = el("div", { class: "chart-holder" });
  private step: Chart | null = null;
  /** What it is made for. */
  private stepKey = "";
  private readonly gain: Chart;
  private readonly phase: Chart;
  private readonly nyquist = svg("svg", { class: "nyquist", role: "img", "aria-label": "Nyquist plot of the open loop" });
  private readonly panel: Panel;
  private readonly record: PlantRecord;
  private readonly loop: OwnLoop;
  private readonly fields: Fields;
  private readonly rows = el("div", { class: "fields" });
  private readonly more = el("details", { class: "more", "data-fold": "more" }, el("summary", {}, "More: a device as the plant, noise, peaks, limits, sample time"), this.rows);
  private readonly ask: (control: Control) => void;
  private designed: Designed | null = null;
  /** Files that were dropped or chosen: they are not in the address. */
  private plantFile: TextFile | null = null;
  private controllerFile: TextFile | null = null;

  constructor(private readonly app: App) {
    const parse = (key: string, text: string) => app.connection.quantity(key, text);
    const { control } = app.state;
    const [low, high] = CONTROL_ENDS.crossover;
    this.crossover = new Knob({ label: "crossover", unit: "rad/s", ending: "_rad_s", log: true, least: low, most: high, value: control.crossover, help: "about 1.3 over the rise time", parse, changed: (crossover) => this.change({ crossover }) });
    const [least, most] = CONTROL_ENDS.margin;
    this.margin = new Knob({ label: "phase margin", unit: "°", ending: "_deg", least, most, value: control.margin, help: "more makes less overshoot", parse, changed: (margin) => this.change({ margin }) });
    const bode = { lines: LINES, logX: true, group: "bode", xTexts: (ticks: number[]) => ticks.map((tick) => number(tick, 2)) };
    this.gain = new Chart({ ...bode, name: "Gain of the open loop over frequency" });
    this.phase = new Chart({ ...bode, name: "Phase of the open loop over frequency" });
    this.panel = app.connection.panel("control");
    this.fields = new Fields(app);
    this.more.addEventListener("toggle", () => this.more.open && void this.fields.once("control_design", this.rows));
    this.rows.addEventListener("change", () => this.ask(app.state.control));
    this.record = new PlantRecord(app, (file) => this.take({ is: "plant", file }));
    this.loop = new OwnLoop(app, (values) => this.given(app.state.control.plant, values));
    this.ask = latest(
      (wishes) => this.design(wishes),
      (error) => this.refused(error),
    );
    this.plant.addEventListener("change", () => {
      this.plantFile = null;
      this.change({ plant: this.plant.value.trim() });
    });
    this.flat.addEventListener("change", () => this.change({ flat: this.flat.checked }));
    this.seen.addEventListener("change", () => this.draw());
    this.choose.addEventListener("change", () => {
      const file = this.choose.files?.[0];
      if (file) void app.given(file);
      this.choose.value = "";
    });
    this.root = this.layout();
  }

  private layout(): HTMLElement {
    const holder = el("div", { class: "plane-holder" }, this.nyquist as unknown as HTMLElement);
    onSize(holder, () => this.draw());
    return el(
      "div",
      { class: "view control" },
      el(
        "section",
        { class: "card settings" },
        el("h2", {}, "Plant and wishes"),
        el(
          "div",
          { class: "knobs single" },
          el("label", { class: "choice" }, "Plant", this.plant),
          el("label", { class: "choice" }, "or a file of a plant or of your controller", this.choose),
          this.record.root,
          this.files,
          this.trouble,
          this.crossover.root,
          this.margin.root,
          el("label", { class: "check", for: "flat" }, this.flat, "flat phase: the overshoot stays when the gain of the plant changes"),
          this.more,
          this.loop.root,
        ),
        this.verdict,
        this.read,
        this.notes,
        el("div", { class: "buttons" }, this.file),
        this.figures,
      ),
      el("section", { class: "card steps" }, el("h2", {}, this.seen), this.legend, this.said, this.steps),
      el("section", { class: "card loci" }, el("h2", {}, "Nyquist"), holder),
      el("section", { class: "card curves" }, el("h2", {}, "Gain, dB, over rad/s"), this.gain.root, el("h2", {}, "Phase, °, over rad/s"), this.phase.root),
    );
  }

  private change(part: Partial<Control>): void {
    this.app.dispatch({ do: "control", part });
  }

  /** A file of a plant or a controller. */
  take(dropped: Dropped): void {
    if (dropped.is === "plant") this.plantFile = dropped.file;
    else if (dropped.is === "controller") this.controllerFile = dropped.file;
    else {
      if (dropped.is === "record") this.record.take(dropped.file);
      return;
    }
    this.ask(this.app.state.control);
  }

  /** The files that count, each with a way to leave it out. */
  private drawFiles(): void {
    const of = (file: TextFile | null, what: string, forget: () => void) => {
      if (file === null) return [];
      const leave = () => {
        forget();
        this.ask(this.app.state.control);
      };
      return [el("span", {}, `${what}: ${file.name}`, button("leave out", leave, { class: "small" }))];
    };
    this.files.replaceChildren(...of(this.plantFile, "plant", () => (this.plantFile = null)), ...of(this.controllerFile, "your controller", () => (this.controllerFile = null)));
    this.plant.disabled = this.plantFile !== null;
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

  /** The values of fields, with the plant and the files that count. A device stands in place of the view's plant. */
  private given(plant: string, values: Values): object {
    const named = values["mass_kg"] === undefined ? { plant, ...(this.plantFile === null ? {} : { plant_file: this.plantFile }) } : {};
    return { ...named, ...(this.controllerFile === null ? {} : { controller_file: this.controllerFile }), ...values };
  }

  private async design({ plant, crossover, margin, flat }: Control): Promise<void> {
    this.drawFiles();
    this.fields.refuse("");
    const wishes = { ...this.given(plant, await this.fields.values()), crossover_rad_s: crossover, phase_margin_rad: margin / DEGREES, not_flat: !flat };
    const designed = await this.panel.ask<Designed>({ control: wishes });
    if (designed === null) return;
    this.designed = designed;
    this.beside("");
    this.draw();
    // For those who time it.
    this.root.dataset["drawn"] = String(Number(this.root.dataset["drawn"] ?? 0) + 1);
  }

  private refused(error: Error): void {
    this.designed = null;
    this.verdict.classList.add("bad");
    say(this.verdict, this.beside(error.message) ? "No controller: see beside the field." : error.message);
    this.root.dataset["drawn"] = "0";
    this.draw();
  }

  /** Says a sentence beside the field that it is about; false if it is about none. */
  private beside(text: string): boolean {
    const files = [this.plantFile?.name, this.controllerFile?.name].filter((name) => name !== undefined);
    const of = { plant: /^plant /.test(text) || files.some((name) => text.includes(name)), margin: /^`?phase[ _]margin/.test(text), crossover: /crossover/.test(text) };
    say(this.trouble, of.plant ? text : "");
    this.margin.refuse(!of.plant && of.margin ? text : "");
    this.crossover.refuse(!of.plant && !of.margin && of.crossover ? text : "");
    return of.plant || of.margin || of.crossover || this.fields.refuse(text) !== null;
  }

  /** The three, of which each may be absent. */
  private get candidates(): (Candidate | null)[] {
    const { designed } = this;
    return designed === null ? [] : [designed.fractional, designed.integer, designed.own];
  }

  private draw(): void {
    const { designed, candidates } = this;
    this.file.disabled = designed === null;
    this.legend.lastElementChild?.toggleAttribute("hidden", designed?.own == null);
    this.drawSteps();
    const over = (chart: Chart, of: (one: Candidate) => number[], within?: (all: number[]) => [number, number]) => {
      const { x, points } = joined(LINES.map((_, n) => ({ time: candidates[n]?.omega_rad_s ?? [], value: candidates[n] ? of(candidates[n]) : [] })));
      chart.draw(x, points, [x[0] ?? 1, x.at(-1) ?? 10], within?.(candidates.flatMap((one) => (one === null ? [] : of(one)))));
    };
    over(this.gain, (one) => (one.open_real ?? []).map((re, n) => 20 * Math.log10(Math.hypot(re, one.open_imaginary?.[n] ?? 0))));
    // A dead time turns for ever.
    over(this.phase, (one) => (one.phase_rad ?? []).map((phase) => phase * DEGREES), (phases) => [Math.max(PHASE_LEAST, Math.min(0, ...phases)), Math.max(0, ...phases)]);
    this.drawNyquist();
    this.notes.replaceChildren(...(designed?.notes ?? []).map((text) => el("p", { class: text.startsWith("Warning") ? "hint trouble" : "hint" }, text)));
    say(this.read, designed === null ? "" : `Plant as read: ${designed.plant}`);
    if (designed === null) {
      this.figures.replaceChildren();
      return;
    }
    const { fractional } = designed;
    this.verdict.classList.toggle("bad", fractional.stable === false);
    say(this.verdict, `C(s) = ${fractional.controller.replace(/\d+\.\d+(e-?\d+)?/g, (text) => String(Number(Number(text).toPrecision(4))))}: ${fractional.verdict ?? "tuned for a measured plant"}.`);
    this.drawFigures(designed);
  }

  private drawFigures({ fractional, integer, integer_reason: reason, own, sample_time_s: sample }: Designed): void {
    type Margins = NonNullable<Candidate["margins"]>;
    // Nothing is said of a loop that is not proved stable: "none" would be the best of margins.
    const margin = (of: (margins: Margins) => string) => (one: Candidate) => (one.margins ? of(one.margins) : "–");
    const value = (given: number | null, unit: string) => (given === null ? "none" : quantity(given, unit));
    const rows: [string, (one: Candidate) => string][] = [
      ["verdict", (one) => one.verdict ?? "–"],
      ...Object.entries(GAINS).map(([key, name]): [string, (one: Candidate) => string] => [name, (one) => (one.gains === null ? "–" : number(one.gains[key] ?? 0, 4))]),
      ["crossover", margin((of) => value(of.crossover_rad_s, "rad/s"))],
      ["phase margin", margin((of) => (of.phase_margin_deg === null ? "none" : `${number(of.phase_margin_deg)}°`))],
      ["gain margin", margin((of) => value(of.gain_up, ""))],
      ["lower gain margin", margin((of) => value(of.gain_down, ""))],
      ["delay margin", margin((of) => value(of.delay_margin_s, "s"))],
      ["largest |S|", margin((of) => number(of.sensitivity_peak))],
      ["overshoot", (one) => (one.shape ? `${number(100 * one.shape.overshoot)}\u202f%` : "–")],
      ["settled within 2 % at", (one) => (one.shape && one.shape.settling_time_s !== null ? quantity(one.shape.settling_time_s, "s") : "–")],
    ];
    const shown = own === null ? [fractional, integer] : [fractional, integer, own];
    const cells = (of: (one: Candidate) => string) => shown.map((one) => el("td", {}, one === null ? "–" : of(one)));
    const head = el("tr", {}, el("td"), ...shown.map((_, n) => el("th", { scope: "col" }, LINES[n]?.label ?? "")));
    const said = reason === null ? [] : [el("caption", { class: "hint" }, `No PID: ${reason}`)];
    const sampled = el("tr", {}, el("th", { scope: "row" }, "sample time"), el("td", { colspan: shown.length }, quantity(sample, "s")));
    this.figures.replaceChildren(...said, el("tbody", {}, head, ...rows.map(([name, of]) => el("tr", {}, el("th", { scope: "row" }, name), ...cells(of))), sampled));
  }

  /** What is chosen over time: a curve of each controller, or one for each gain of the plant. */
  private drawSteps(): void {
    const seen = this.seen.value as Seen;
    const curves = this.candidates.flatMap((one, n) => {
      const time = one?.time_s ?? [];
      const line = LINES[n] ?? { label: "", colour: "--ink" };
      if (one === null || time.length === 0) return [];
      if (seen !== "gains") return [{ line, time, value: one[seen] ?? [] }];
      return (one.robustness ?? []).map(({ gain, step }) => ({ line: { ...line, width: gain === 1 ? 2.5 : 1 }, time, value: step }));
    });
    const lines = curves.map(({ line }) => line);
    // A slider that is dragged keeps its chart.
    const key = JSON.stringify([seen, lines]);
    if (key !== this.stepKey || this.step === null) {
      this.step?.destroy();
      this.step = new Chart({ name: SEEN[seen], lines, xTexts: (ticks) => ticks.map((tick) => quantity(tick, "s")) });
      this.steps.replaceChildren(this.step.root);
      this.stepKey = key;
    }
    const unstable = this.candidates.some((one) => one?.robustness?.some(({ stable }) => !stable));
    const whole = curves.flatMap(({ value }) => value);
    const first = curves[0]?.value ?? [];
    // An unstable loop does not press the others to the ground, nor a kick the rest of a command.
    const calm = seen === "command" ? curves.flatMap(({ value }) => value.slice(KICK)) : seen === "gains" ? whole : first;
    const [low, high] = [Math.min(0, ...calm), Math.max(seen === "loaded" || seen === "command" ? 1e-9 : 1.2, ...calm)];
    const [least, most] = seen === "step" || seen === "gains" ? [Math.max(low, -1), Math.min(high, 3)] : [low, high];
    const highest = whole.reduce((most, value) => Math.max(most, value), 0);
    const cut = seen === "command" && highest > 3 * most ? `The first samples reach ${number(highest)}.` : "";
    say(this.said, seen === "gains" && unstable ? "Not stable at all of these gains." : cut);
    const { x, points } = joined(curves);
    this.step.draw(x, points, [x[0] ?? 0, STEP_SHARE * (this.candidates[0]?.time_s?.at(-1) ?? x.at(-1) ?? 1)], [least, most]);
  }

  /** L from low frequencies on, in the circle that counts; +1 on both axes is a quarter of the picture. */
  private drawNyquist(): void {
    const size = 100 / NYQUIST;
    const far = (value: number) => Math.max(-1e4, Math.min(1e4, value));
    const path = (one: Candidate) => (one.open_real === undefined ? "" : `M${one.open_real.map((re, n) => `${far(re * size).toFixed(2)} ${far(-(one.open_imaginary?.[n] ?? 0) * size).toFixed(2)}`).join("L")}`);
    const curves = this.candidates.map((one, n) => {
      const curve = svg("path", { d: one === null ? "" : path(one) });
      set(curve, { stroke: `var(${LINES[n]?.colour ?? "--ink"})`, "stroke-dasharray": (LINES[n]?.dash ?? []).map((length) => length / 4).join(" ") });
      return curve;
    });
    const texts = [-2, -1, 1, 2].map((at) => {
      const text = svg("text", { x: at * size, y: 10 });
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
}
