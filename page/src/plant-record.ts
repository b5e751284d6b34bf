// A record of input and output: which plant is it? Then a controller is designed for it.

import type { App, TextFile } from "./app";
import { Chart, legend, type Line } from "./chart";
import { decimate, joined } from "./columns";
import type { Panel } from "./connection";
import { button, el, say } from "./dom";
import { choose, textOf } from "./drop";
import { Fields } from "./forms";
import { number, quantity } from "./format";
import { spoken } from "./names";

interface NumberRow {
  name: string;
  value: number;
  /** Null where the record says nothing. */
  standard_error: number | null;
  determined: boolean;
}

/** As `control identify --json` has it, with the record and the function's output. */
export interface FoundPlant {
  function: string;
  delay_s: number;
  delay_low_s: number | null;
  delay_high_s: number | null;
  begins: string;
  samples: number;
  fit: number;
  order_reason: string;
  numbers: NumberRow[];
  validation: { fit: number; rms_residual: number } | null;
  warnings: string[];
  x: number[];
  measured: number[];
  predicted: number[];
  file: TextFile;
}

/** As it has it of a frequency response. */
interface FoundResponse extends Pick<FoundPlant, "function" | "delay_s" | "numbers" | "warnings" | "x" | "measured" | "predicted" | "file"> {
  frequencies: number;
  relative_residual: number;
  kramers_kronig_reason: string;
}

const LINES: Line[] = [
  { label: "record", colour: "--theory", width: 5 },
  { label: "function", colour: "--blue" },
];

function record(found: FoundPlant): string {
  const interval = found.delay_low_s === null ? "" : ` (${quantity(found.delay_low_s, "s")} to ${quantity(found.delay_high_s ?? 0, "s")})`;
  const tried = found.validation === null ? "" : ` On the second record: fit ${number(found.validation.fit, 4)}.`;
  return `${interval}; ${found.begins}, ${found.samples} samples, fit ${number(found.fit, 4)}. ${found.order_reason}.${tried}`;
}

function response(found: FoundResponse): string {
  return `; ${found.frequencies} frequencies, relative residual ${number(found.relative_residual, 2)}; Kramers–Kronig: ${found.kramers_kronig_reason}.`;
}

/** A file as its name and text; null where none is chosen. */
export async function chosen(input: HTMLInputElement): Promise<TextFile | null> {
  const file = input.files?.[0];
  return file ? { name: file.name, text: await textOf(file) } : null;
}

export class PlantRecord {
  readonly root: HTMLDetailsElement;
  private readonly record = el("input", { type: "file", accept: ".csv,.tsv,.txt,.dat,.dta,.mpt,.z", "aria-label": "Record of input and output, or frequency response" });
  private readonly other = el("input", { type: "file", accept: ".csv,.tsv,.txt", "aria-label": "Second record" });
  private readonly rows = el("div", { class: "fields" });
  private readonly said = el("p", { class: "hint", role: "status" });
  private readonly found = el("div");
  private readonly use: HTMLButtonElement;
  private readonly fields: Fields;
  private readonly panel: Panel;
  private chart: Chart | null = null;
  private file: TextFile | null = null;

  constructor(app: App, taken: (plant: TextFile) => void) {
    this.fields = new Fields(app);
    this.panel = app.connection.panel("identify");
    const asks = [this.record, this.other, this.rows];
    for (const part of asks) part.addEventListener("change", () => void this.ask());
    this.use = button("Design for this plant", () => this.file && taken(this.file), { class: "primary", hidden: true });
    this.root = el(
      "details",
      { class: "plant-record", "data-fold": "record" },
      el("summary", {}, "or a record of its input and output"),
      el("label", { class: "choice" }, "Record", this.record),
      el("label", { class: "choice" }, "Second record, to try the function on", this.other),
      this.rows,
      this.said,
      this.found,
      this.use,
    );
    this.root.addEventListener("toggle", () => void this.askFields());
  }

  /** A record that fell on the page. */
  take(file: File): void {
    choose(this.record, file);
    this.root.open = true;
    void this.askFields().then(() => this.ask());
  }

  private async askFields(): Promise<void> {
    if (this.root.open) await this.fields.once("plant_record", this.rows);
  }

  private async ask(): Promise<void> {
    const question = async () => {
      const [record, other] = await Promise.all([chosen(this.record), chosen(this.other)]);
      return { plant_record: { ...record, ...(other === null ? {} : { more: [other] }), ...(await this.fields.values()) } };
    };
    if (!this.record.files?.[0]) return;
    say(this.said, "The record is looked at …");
    const found = await this.fields.ask<FoundPlant | FoundResponse>(this.panel, this.said, question, () => {
      this.file = null;
      this.use.hidden = true;
      this.found.replaceChildren();
    });
    if (found !== null) this.show(found);
  }

  private show(found: FoundPlant | FoundResponse): void {
    this.file = found.file;
    this.use.hidden = false;
    const isResponse = "frequencies" in found;
    say(this.said, `${found.function} behind ${quantity(found.delay_s, "s")}${isResponse ? response(found) : record(found)}`);
    const rows = found.numbers.map((row) => {
      const error = row.standard_error === null ? "?" : number(row.standard_error, 2);
      const cells = [row.name.replace(/_/g, " "), `${number(row.value, 5)} ± ${error}`, row.determined ? "" : "not determined"];
      return el("tr", {}, ...cells.map((text) => el("td", {}, text)));
    });
    const warnings = found.warnings.map((text) => el("p", { class: "hint trouble" }, spoken(text)));
    this.chart?.destroy();
    this.chart = new Chart({ name: "The record and its function", lines: LINES, xTexts: (ticks) => ticks.map((tick) => quantity(tick, isResponse ? "rad/s" : "s")) });
    const holder = el("div", { class: "chart-holder" }, this.chart.root);
    this.found.replaceChildren(...warnings, el("table", { class: "result", tabindex: 0, "aria-label": "The plant" }, el("tbody", {}, ...rows)), legend(LINES).root, holder);
    const { x, points } = joined([found.measured, found.predicted].map((y) => decimate(found.x, y, 800)));
    this.chart.draw(x, points, [x[0] ?? 0, x.at(-1) ?? 1]);
  }
}
