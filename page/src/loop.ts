// A loop as it is, or a plant alone: its verdict, or its run. The plant is that of the view.

import { line } from "./answer";
import type { App } from "./app";
import { Chart, legend, type Line as Curve } from "./chart";
import type { Panel } from "./connection";
import { button, el, say } from "./dom";
import { Fields } from "./forms";
import { quantity } from "./format";
import { spoken } from "./names";
import { chosen } from "./plant-record";
import type { Line, Values } from "./protocol";

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
  constructor(app: App, private readonly given: (values: Values) => object) {
    this.fields = new Fields(app);
    this.panel = app.connection.panel("loop");
    this.root = el(
      "details",
      { class: "own-loop", "data-fold": "loop" },
      el("summary", {}, "Judge or run a controller as it is"),
      this.rows,
      el("label", { class: "choice" }, "Reference over time, in place of a step", this.reference),
      el("div", { class: "buttons" }, button("Judge it", () => void this.ask("analyze")), button("Run it", () => void this.ask("simulate"))),
      this.said,
      this.found,
    );
    this.root.addEventListener("toggle", () => this.root.open && void this.fields.once("control_loop", this.rows));
  }

  private async ask(what: "analyze" | "simulate"): Promise<void> {
    const question = async () => {
      const [reference, values] = await Promise.all([chosen(this.reference), this.fields.values()]);
      return { [what]: { ...this.given(values), ...(reference === null ? {} : { reference_file: reference }) } };
    };
    const found = await this.fields.ask<Answered>(this.panel, this.said, question, () => this.found.replaceChildren());
    if (found !== null) this.show(found);
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
