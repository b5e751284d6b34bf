// A record that someone measured: which tissue is it? Then it is kept, and felt.

import { line } from "./answer";
import type { App } from "./app";
import { Chart, legend, type Line } from "./chart";
import { decimate, joined } from "./columns";
import type { Panel } from "./connection";
import { button, el, say, words } from "./dom";
import { choose, feelTissue, keepTissue, textOf } from "./drop";
import { Fields } from "./forms";
import { number } from "./format";
import { spoken } from "./names";
import type { Line as Row, RecordParameter, Values } from "./protocol";
import { STROKES, THEORY } from "./vectors";

interface Estimate {
  value: number;
  unit: string;
  standard_error: number | null;
  low_95: number | null;
  high_95: number | null;
}

/** The rms of its residuals is called by its unit. */
interface Candidate extends Values {
  model: string;
  parameters: Record<string, Estimate>;
  aic: number;
  bic: number;
}

export interface Identified {
  /** As `identify` has it, with what is known of how it was measured. */
  report: { kind: string; loading: { kind: string | null; modulus: string | null }; samples: number; model: string; warnings: string[]; candidates: Candidate[] };
  lines: Row[];
  /** Time or frequency, what was measured there, and what each candidate says. */
  x: number[];
  measured: number[];
  predicted: number[][];
  /** The tissue of the best model, or why it is none. */
  tissue: { name: string; text: string } | null;
  tissue_reason: string | null;
}

/** How each table is read. */
export interface Explained {
  read: { name: string; lines: Row[] }[];
}

const COLOURS = [THEORY, ...STROKES.slice(0, 4)];
/** Rows of the report that stand above it, or in its table of models. */
const SHOWN = ["kind", "samples", "loading", "model", "rms_residual_per_pa", "rms_residual_pa", "rms_log_residual", "aic", "bic", "candidates", "notes", "warnings"];
const MODULI: Record<string, string> = { shear: "shear modulus", young: "Young's modulus" };
/** What stands on the axes of a record. */
const AXES: Record<string, [string, string]> = {
  relaxation: ["time, s", "relaxation modulus, Pa"],
  creep: ["time, s", "creep compliance, 1/Pa"],
  oscillation: ["angular frequency, rad/s", "storage, then loss modulus, Pa"],
  history: ["time, s", "stress, Pa"],
};

export class IdentifyPanel {
  readonly root: HTMLElement;
  private readonly file = el("input", { type: "file", accept: ".csv,.tsv,.txt,text/csv", multiple: true, "aria-label": "CSV files" });
  private readonly state = el("p", { class: "hint", role: "status" }, "Drop a CSV of a relaxation, a creep, a modulus over frequency, or force and depth anywhere on the page.");
  private readonly result = el("div", { class: "result", tabindex: 0, role: "region", "aria-label": "Models" });
  private readonly holder = el("div", { class: "chart-holder", hidden: true });
  private readonly rows = el("div", { class: "fields" });
  private readonly name = el("input", { type: "text", "aria-label": "Name of the tissue", spellcheck: "false", autocomplete: "off" });
  private readonly kept = el("span", { role: "status" });
  private readonly tissue = el("div", { class: "keep", hidden: true });
  private readonly fields: Fields;
  /** For which loadings each field is. */
  private loadings = new Map<string, string[]>();
  private chart: Chart | null = null;
  private readonly panel: Panel;
  private records: { name: string; text: Promise<string> }[] = [];
  private found: Identified | null = null;
  /** The name under which what is shown was kept. */
  private saved = "";

  constructor(private readonly app: App) {
    this.fields = new Fields(app);
    this.panel = app.connection.panel("identify");
    this.file.addEventListener("change", () => this.look([...(this.file.files ?? [])]));
    this.rows.addEventListener("change", () => {
      this.fit();
      void this.ask();
    });
    const explain = button("How it is read", () => void this.explain());
    const keep = button("Save as tissue", () => void this.keep());
    const feel = button("Feel it", () => void this.keep().then((name) => name !== "" && feelTissue(app, name)), { class: "primary" });
    this.tissue.append(el("label", {}, "Tissue ", this.name), keep, feel, this.kept);
    this.root = el(
      "section",
      { class: "card identify" },
      el("h2", {}, "Identify a record"),
      el("div", { class: "measured" }, this.file, explain, this.rows),
      el("div", { class: "found" }, this.state, this.holder, this.tissue, this.result),
    );
  }

  /** What a table does not say. */
  take(record: RecordParameter[]): void {
    this.loadings = new Map(record.map(({ key, loadings }) => [key, loadings]));
    const rows = (options: boolean) => record.filter(({ option }) => option === options).map((parameter) => this.fields.add(parameter));
    const options = el("details", { "data-fold": "options" }, el("summary", {}, "Options"), el("div", { class: "fields" }, ...rows(true)));
    this.rows.replaceChildren(...rows(false), options);
  }

  /** A loading has its own fields. */
  private fit(): void {
    const loading = this.fields.all.find(({ parameter }) => parameter.key === "loading")?.input.value ?? "";
    for (const { parameter, row } of this.fields.all) row.hidden = loading !== "" && this.loadings.get(parameter.key)?.includes(loading) === false;
  }

  /** Reads a file that was dropped, and asks what it is. */
  read(file: File): void {
    choose(this.file, file);
    this.look([file]);
  }

  /** Asks what these files are: motions, specimens or temperatures of one tissue. */
  private look(files: File[]): void {
    // What was found of another record is not that of this.
    this.clear();
    this.records = files.map((file) => ({ name: file.name, text: textOf(file) }));
    void this.ask();
  }

  private clear(): void {
    this.found = null;
    this.result.replaceChildren();
    this.chart?.destroy();
    this.chart = null;
    this.holder.replaceChildren();
    this.holder.hidden = this.tissue.hidden = true;
  }

  private ask(): Promise<void> {
    return this.answered<Identified>("record", (name, found) => this.show(name, found));
  }

  /** What each column is taken for, whether or not the tables make a record. */
  private explain(): Promise<void> {
    return this.answered<Explained>("explain_record", (name, { read }) => {
      this.clear();
      say(this.state, `${name}, as it is read:`);
      this.result.replaceChildren(...read.flatMap(({ name, lines }) => [...(read.length > 1 ? [el("h3", {}, name)] : []), ...lines.flatMap(line)]));
    });
  }

  private async answered<Found>(question: string, show: (name: string, found: Found) => void): Promise<void> {
    const [first, ...others] = this.records;
    if (!first) return;
    const name = this.records.map((record) => record.name).join(", ");
    say(this.state, `${name} is looked at …`);
    const file = async (record: typeof first) => ({ name: record.name, text: await record.text });
    const asked = async () => {
      const more = await Promise.all(others.map(file));
      return { [question]: { ...(await file(first)), ...(more.length === 0 ? {} : { more }), ...(await this.fields.values()) } };
    };
    const found = await this.fields.ask<Found>(this.panel, this.state, asked, () => this.clear());
    if (found !== null) show(name, found);
  }

  private show(name: string, found: Identified): void {
    this.found = found;
    const { report } = found;
    const { modulus } = report.loading;
    const measured = [report.kind, `${report.samples} samples`, ...(modulus === null ? [] : [MODULI[modulus] ?? modulus])];
    say(this.state, `${name}: ${measured.join(", ")}. Best: ${report.model}.`);
    const models = report.candidates.map((model) => {
      const cells = Object.entries(model.parameters).map(([name, estimate]) => el("div", {}, sentence(name, estimate)));
      const rms = Object.entries(model).find(([key]) => key.startsWith("rms"));
      const figures = `rms ${number(Number(rms?.[1]))}, AIC ${number(model.aic, 4)}`;
      return el("tr", { class: model.model === report.model ? "best" : undefined }, el("th", { scope: "row" }, model.model), el("td", {}, ...cells), el("td", {}, figures));
    });
    const said = report.warnings.map((text) => el("p", { class: "hint" }, spoken(text)));
    const head = el("tr", {}, ...["model", "numbers, with 95 % intervals", "fit"].map((text) => el("th", { scope: "col" }, text)));
    this.result.replaceChildren(el("table", {}, el("thead", {}, head), el("tbody", {}, ...models)), ...said, ...found.lines.filter(({ key }) => !SHOWN.includes(key)).flatMap(line));
    this.drawCurves(found);
    this.tissue.hidden = false;
    for (const part of this.tissue.querySelectorAll("input, button")) part.toggleAttribute("disabled", found.tissue === null);
    this.name.value = found.tissue?.name ?? "";
    this.saved = "";
    say(this.kept, found.tissue_reason ?? "");
  }

  /** Keeps the tissue under the name in the field, once; the name, or nothing if it was refused. */
  private async keep(): Promise<string> {
    const { found } = this;
    const name = this.name.value.trim();
    if (!found?.tissue) return "";
    if (this.saved === name) return name;
    try {
      say(this.kept, `Saved in ${await keepTissue(this.app, name, found.tissue.text)}`);
      this.kept.classList.remove("trouble");
      this.saved = name;
      return name;
    } catch (error) {
      this.kept.classList.add("trouble");
      say(this.kept, words(error));
      return "";
    }
  }

  private drawCurves(found: Identified): void {
    const curves = [{ name: "measured", y: found.measured }, ...found.report.candidates.slice(0, COLOURS.length - 1).map(({ model }, index) => ({ name: model, y: found.predicted[index] ?? [] }))];
    const lines = curves.map(({ name }, index): Line => ({ label: name, ...(COLOURS[index % COLOURS.length] ?? { colour: "--ink" }) }));
    const positive = found.x.every((x) => x > 0);
    const [across, up] = AXES[found.report.kind] ?? ["", ""];
    this.chart?.destroy();
    this.chart = new Chart({ name: "The record and its models", lines, logX: positive, ...(positive ? { xTexts: (ticks: number[]) => ticks.map((tick) => number(tick, 2)) } : {}) });
    this.holder.hidden = false;
    this.holder.replaceChildren(legend(lines).root, el("p", { class: "hint" }, up === "" ? "" : `${up}, over ${across}`), this.chart.root);
    const { x, points } = joined(curves.map((curve) => decimate(found.x, curve.y, 800)));
    this.chart.draw(x, points, [x[0] ?? 0, x.at(-1) ?? 1]);
  }
}

/** A number with its interval; with its standard error where there is none. */
function sentence(name: string, { unit, value, standard_error: error, low_95: low, high_95: high }: Estimate): string {
  const between = low !== null || high !== null ? ` (${number(low, 4)} to ${number(high, 4)})` : error !== null ? ` ± ${number(error, 2)}` : " (not bounded)";
  return `${name.replace(/_pa(_s_\w+)?$/, "").replace(/_/g, " ")} ${number(value, 4)}${between} ${unit === "1" ? "" : unit}`;
}
