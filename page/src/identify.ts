// A record that someone measured: which tissue is it?

import type { App } from "./app";
import { Chart, legend, type Line } from "./chart";
import { decimate } from "./columns";
import { el, say } from "./dom";
import { number } from "./format";

interface Estimate {
  name: string;
  unit: string;
  value: number;
  standard_error?: number | null;
}

interface Model {
  model: string;
  parameters: Estimate[];
  rms: number;
  aic: number;
  bic: number;
  predicted: number[];
}

interface Identified {
  kind: string;
  samples: number;
  notes: string[];
  warnings: string[];
  best: string | null;
  models: Model[];
  /** Time or frequency, and what was measured there. */
  x: number[];
  measured: number[];
}

const COLOURS: Omit<Line, "label">[] = [
  { colour: "--theory", width: 6 },
  { colour: "--blue" },
  { colour: "--verm", dash: [9, 4] },
  { colour: "--green", dash: [2.2, 3] },
  { colour: "--rose", dash: [11, 3, 2.2, 3] },
];
const SIZE_MOST = 15e6;

export class IdentifyPanel {
  readonly root: HTMLElement;
  private readonly file = el("input", { type: "file", accept: ".csv,.tsv,.txt,text/csv", "aria-label": "CSV file" });
  private readonly state = el("p", { class: "hint", role: "status" }, "Drop a CSV of a relaxation, a creep or a modulus over frequency anywhere on this view.");
  private readonly result = el("div", { class: "result" });
  private readonly holder = el("div", { class: "chart-holder" });
  private readonly extra = new Map<string, HTMLInputElement>();
  private chart: Chart | null = null;
  private text: { name: string; text: string } | null = null;

  constructor(private readonly app: App) {
    const extra = (key: string, label: string, placeholder: string): HTMLElement => {
      const input = el("input", { type: "text", placeholder, spellcheck: "false", autocomplete: "off" });
      this.extra.set(key, input);
      input.addEventListener("change", () => void this.ask());
      return el("label", {}, el("span", {}, label), input);
    };
    this.file.addEventListener("change", () => {
      const file = this.file.files?.[0];
      if (file) void this.read(file);
    });
    const fields = el(
      "div",
      { class: "fields" },
      extra("strain", "strain that was held", "if the CSV has forces or stresses"),
      extra("stress_pa", "stress that was held, Pa", "if it has strains"),
      extra("area_m2", "area, m²", "if it has forces"),
      extra("thickness_m", "thickness, m", "if it has lengths"),
    );
    this.root = el("section", { class: "card identify" }, el("h2", {}, "Identify a record"), this.file, fields, this.state, this.holder, this.result);
  }

  /** Reads a file and asks what it is. */
  async read(file: File): Promise<void> {
    if (file.size > SIZE_MOST) {
      this.refuse(`${file.name} is larger than 15 MB: cut it into pieces.`);
      return;
    }
    this.text = { name: file.name, text: await file.text() };
    await this.ask();
  }

  themed(): void {
    this.chart?.redraw();
  }

  private refuse(text: string): void {
    this.state.classList.add("trouble");
    say(this.state, text);
    this.result.replaceChildren();
    this.chart?.destroy();
    this.chart = null;
    this.holder.replaceChildren();
  }

  private async ask(): Promise<void> {
    if (!this.text) return;
    this.state.classList.remove("trouble");
    say(this.state, `${this.text.name} is looked at …`);
    try {
      const options: Record<string, number> = {};
      const kinds: Record<string, string> = { strain: "strain", stress_pa: "stress", area_m2: "area", thickness_m: "length" };
      for (const [key, input] of this.extra) {
        if (input.value.trim() !== "") options[key] = await this.app.analysis.parse(kinds[key] ?? "number", input.value);
      }
      this.show(await this.app.connection.ask<Identified>("identify", { ...this.text, ...options }));
    } catch (error) {
      this.refuse(error instanceof Error ? error.message : String(error));
    }
  }

  private show(found: Identified): void {
    say(this.state, `${this.text?.name ?? ""}: ${found.kind}, ${found.samples} samples.${found.best ? ` Best: ${found.best}.` : " No model fits."}`);
    const models = found.models.map((model) => {
      const cells = model.parameters.map(({ name, unit, value, standard_error: error }) =>
        el("div", {}, `${name.replace(/_pa(_s_\w+)?$/, "").replace(/_/g, " ")} ${number(value, 4)}${typeof error === "number" ? ` ± ${number(error, 2)}` : ""} ${unit}`),
      );
      const figures = `rms ${number(model.rms)}, AIC ${number(model.aic, 4)}`;
      return el("tr", { class: model.model === found.best ? "best" : undefined }, el("th", { scope: "row" }, model.model), el("td", {}, ...cells), el("td", {}, figures));
    });
    const said = [...found.warnings, ...found.notes].map((text) => el("p", { class: "hint" }, text));
    this.result.replaceChildren(el("table", {}, el("tbody", {}, ...models)), ...said);
    this.drawCurves(found);
  }

  private drawCurves(found: Identified): void {
    const curves = [{ name: "measured", y: found.measured }, ...found.models.slice(0, COLOURS.length - 1).map(({ model, predicted }) => ({ name: model, y: predicted }))];
    const lines = curves.map(({ name }, index): Line => ({ label: name, ...(COLOURS[index % COLOURS.length] ?? { colour: "--ink" }) }));
    const positive = found.x.every((x) => x > 0);
    this.chart?.destroy();
    this.chart = new Chart({ name: "The record and its models", lines, logX: positive, ...(positive ? { xTexts: (ticks: number[]) => ticks.map((tick) => number(tick, 2)) } : {}) });
    this.holder.replaceChildren(legend(lines).root, this.chart.root);
    const thin = curves.map((curve) => decimate(found.x, curve.y, 800));
    const x = [...new Set(thin.flatMap(({ time }) => time))].sort((a, b) => a - b);
    const place = new Map(x.map((at, index) => [at, index]));
    const points = thin.map(({ time, value }) => {
      const line = new Array<number | null | undefined>(x.length);
      time.forEach((at, index) => (line[place.get(at) ?? 0] = value[index] ?? null));
      return line as (number | null)[];
    });
    this.chart.draw(x, points, [x[0] ?? 0, x.at(-1) ?? 1]);
  }
}
