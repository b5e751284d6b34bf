// A loop as it is, or a plant alone: its verdict, or its run. The plant is that of the view.

import { line } from "./answer";
import type { App } from "./app";
import { Chart, legend, type Line as Curve } from "./chart";
import type { Panel } from "./connection";
import { el, say } from "./dom";
import { Fields } from "./forms";
import { quantity } from "./format";
import { spoken } from "./names";
import { chosen } from "./plant-record";
import type { Line, Parameter } from "./protocol";

/** As `control analyze` and `control simulate` have it; signals of a run alone. */
export interface Answered {
  report: { warnings: string[] };
  lines: Line[];
  time_s?: number[];
  reference?: number[];
  output?: number[];
  command?: number[];
}

const LINES: Curve[] = [
  { label: "reference", colour: "--theory", dash: [2, 4] },
  { label: "output", colour: "--blue", width: 2 },
  { label: "command", colour: "--verm", dash: [7, 5] },
];

export class OwnLoop {
  readonly root: HTMLDetailsElement;
  private readonly reference = el("input", { type: "file", accept: ".csv,.tsv,.txt", "aria-label": "Reference over time" });
  private readonly rows = el("div", { class: "fields" });
  private readonly said = el("p", { class: "hint", role: "status" });
  private readonly found = el("div", { class: "answer-body" });
  private readonly fields: Fields;
  private readonly panel: Panel;
  private chart: Chart | null = null;

  /** `given` adds the plant to the values of fields, and the controller's file if there is one. */
  constructor(private readonly app: App, private readonly given: (values: Record<string, unknown>) => object) {
    this.fields = new Fields(app);
    this.panel = app.connection.panel("loop");
    const ask = (what: "analyze" | "simulate", text: string): HTMLElement => {
      const button = el("button", { type: "button" }, text);
      button.addEventListener("click", () => void this.ask(what));
      return button;
    };
    this.root = el(
      "details",
      { class: "own-loop", "data-fold": "loop" },
      el("summary", {}, "Judge or run a controller as it is"),
      this.rows,
      el("label", { class: "choice" }, "Reference over time, in place of a step", this.reference),
      el("div", { class: "buttons" }, ask("analyze", "Judge it"), ask("simulate", "Run it")),
      this.said,
      this.found,
    );
    this.root.addEventListener("toggle", () => void this.askFields());
  }

  themed(): void {
    this.chart?.redraw();
  }

  /** Asks for the keys of a loop, once. */
  private async askFields(): Promise<void> {
    if (!this.root.open || this.fields.all.length > 0) return;
    const { control_loop: keys } = await this.app.connection.ask<{ control_loop: Parameter[] }>("runs.forms");
    if (this.fields.all.length === 0) this.rows.replaceChildren(...keys.map((key) => this.fields.add(key)));
  }

  private async ask(what: "analyze" | "simulate"): Promise<void> {
    this.said.classList.remove("trouble");
    this.fields.refuse("");
    const question = async (): Promise<object> => {
      const [reference, values] = await Promise.all([chosen(this.reference), this.fields.values()]);
      return { [what]: { ...this.given(values), ...(reference === null ? {} : { reference_file: reference }) } };
    };
    try {
      const found = await this.panel.ask<Answered>(question());
      if (found !== null) this.show(found);
    } catch (error) {
      this.found.replaceChildren();
      this.fields.refusedIn(this.said, error instanceof Error ? error.message : String(error));
    }
  }

  private show(found: Answered): void {
    say(this.said, "");
    const warnings = found.report.warnings.map((text) => el("p", { class: "hint trouble" }, spoken(text)));
    const rows = found.lines.filter(({ key }) => key !== "warnings").flatMap(line);
    this.chart?.destroy();
    this.chart = null;
    this.found.replaceChildren(...warnings, ...rows);
    const { time_s: time, reference = [], output = [], command = [] } = found;
    if (time === undefined) return;
    this.chart = new Chart({ name: "The loop over time", lines: LINES, xTexts: (ticks) => ticks.map((tick) => quantity(tick, "s")) });
    this.found.append(legend(LINES).root, el("div", { class: "chart-holder" }, this.chart.root));
    this.chart.draw(time, [reference, output, command], [0, time.at(-1) ?? 1]);
  }
}
