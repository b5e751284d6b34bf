// A record that someone measured: which tissue is it?

import type { App } from "./app";
import { Chart, legend, type Line } from "./chart";
import { decimate } from "./columns";
import type { Panel } from "./connection";
import { el, say } from "./dom";
import { Fields } from "./forms";
import { number } from "./format";
import type { Parameter } from "./protocol";

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
  /** What is known of how it was measured. */
  loading: { kind: string | null; modulus: string | null };
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
const MODULI: Record<string, string> = { shear: "shear modulus", young: "Young's modulus" };
const SIZE_MOST = 15e6;

export class IdentifyPanel {
  readonly root: HTMLElement;
  private readonly file = el("input", { type: "file", accept: ".csv,.tsv,.txt,text/csv", "aria-label": "CSV file" });
  private readonly state = el("p", { class: "hint", role: "status" }, "Drop a CSV of a relaxation, a creep, a modulus over frequency, or force and depth anywhere on this view.");
  private readonly result = el("div", { class: "result" });
  private readonly holder = el("div", { class: "chart-holder" });
  private readonly rows = el("div", { class: "fields" });
  private readonly fields: Fields;
  private chart: Chart | null = null;
  private readonly panel: Panel;
  private record: { name: string; text: Promise<string> } | null = null;

  constructor(app: App) {
    this.fields = new Fields(app);
    this.panel = app.connection.panel("identify");
    this.file.addEventListener("change", () => {
      const file = this.file.files?.[0];
      if (file) this.read(file);
    });
    this.rows.addEventListener("change", () => {
      this.fit();
      void this.ask();
    });
    this.root = el("section", { class: "card identify" }, el("h2", {}, "Identify a record"), this.file, this.rows, this.state, this.holder, this.result);
  }

  /** What a table does not say. */
  take(record: Parameter[]): void {
    this.rows.replaceChildren(...record.map((parameter) => this.fields.add(parameter)));
  }

  /** A loading has its own fields. */
  private fit(): void {
    const loading = this.fields.all.find(({ parameter }) => parameter.key === "loading")?.input.value ?? "";
    for (const { parameter, row } of this.fields.all) row.hidden = loading !== "" && !(parameter.loadings ?? [loading]).includes(loading);
  }

  /** Reads a file and asks what it is. */
  read(file: File): void {
    if (file.size > SIZE_MOST) {
      this.panel.forget();
      this.record = null;
      this.refuse(`${file.name} is larger than 15 MB: cut it into pieces.`);
      return;
    }
    this.record = { name: file.name, text: file.text() };
    void this.ask();
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
    const { record } = this;
    if (!record) return;
    const { name } = record;
    this.state.classList.remove("trouble");
    say(this.state, `${name} is looked at …`);
    const question = async (): Promise<object> => ({ record: { name, text: await record.text, ...(await this.fields.values()) } });
    try {
      const found = await this.panel.ask<Identified>(question());
      if (found !== null) this.show(name, found);
    } catch (error) {
      this.refuse(error instanceof Error ? error.message : String(error));
    }
  }

  private show(name: string, found: Identified): void {
    const { modulus } = found.loading;
    const measured = [found.kind, `${found.samples} samples`, ...(modulus === null ? [] : [MODULI[modulus] ?? modulus])];
    say(this.state, `${name}: ${measured.join(", ")}.${found.best ? ` Best: ${found.best}.` : " No model fits."}`);
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
