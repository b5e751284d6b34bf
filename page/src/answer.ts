// An answer: how stiff a wall can be on a device, or the wall or coupler that suits it best.

import { Chart, legend, type Line as Curve } from "./chart";
import { joined } from "./columns";
import { button, el, say } from "./dom";
import { FrontMap } from "./front";
import { number, plain } from "./format";
import { spoken } from "./names";
import type { Answer, Line, Values } from "./protocol";
import { save } from "./save";

/** Colours of orders, best told apart first. */
const COLOURS = ["--blue", "--verm", "--green", "--rose", "--ink", "--gold", "--mute"];

export class AnswerPanel {
  readonly root: HTMLElement;
  private readonly name = el("span");
  private readonly verdict = el("p", { class: "verdict", role: "status" });
  private readonly bar = el("progress", { max: 100, hidden: true, "aria-label": "How far it is" });
  private readonly holder = el("div", { class: "chart-holder", hidden: true });
  private readonly body = el("div", { class: "answer-body" });
  private charts: Chart[] = [];
  private front: FrontMap | null = null;

  constructor(
    private readonly tryOut: (kind: string, parameters: Values) => void,
    private readonly feelIt: (text: string) => void,
    private readonly useIt: (values: ReadonlyMap<string, string>) => void,
  ) {
    this.root = el("section", { class: "card answer" }, el("h2", {}, "Answer", this.name), this.verdict, this.bar, this.holder, this.body);
  }

  /** It is not there yet. */
  wait(name: string, share = 0): void {
    say(this.name, name);
    say(this.verdict, `It is being looked for: ${share} %`);
    this.verdict.classList.remove("bad");
    this.bar.hidden = false;
    this.bar.value = share;
    this.close();
    this.body.replaceChildren();
  }

  /** There is none. */
  refuse(why: string): void {
    this.bar.hidden = true;
    this.verdict.classList.add("bad");
    say(this.verdict, `No answer: ${why}`);
  }

  show(answer: Answer): void {
    say(this.name, answer.name);
    if (answer.running) {
      this.wait(answer.name);
      return;
    }
    this.bar.hidden = true;
    this.verdict.classList.remove("bad");
    const ended = answer.report["ended_early"];
    say(this.verdict, spoken([answer.verdict ?? "", typeof ended === "string" ? `${ended}: what was found until then` : ""].filter((text) => text !== "").join(" · ")));
    this.close();
    if (answer.kind === "zwidth") this.map(rows(answer.report["orders"]));
    if (answer.kind === "design") this.orders(answer.report);
    if (rows(answer.report["walls"]).length > 0) {
      this.front = new FrontMap(answer.report, COLOURS, this.useIt);
      this.holder.replaceChildren(this.front.root);
      this.holder.hidden = false;
    }
    this.body.replaceChildren(...this.proposal(answer), ...answer.lines.flatMap(line), this.files(answer));
  }

  private close(): void {
    for (const chart of this.charts) chart.destroy();
    this.charts = [];
    this.front?.destroy();
    this.front = null;
    this.holder.hidden = true;
  }

  /** Largest stiffness over dissipation, both without units, so that all orders go into one picture. */
  private map(orders: Values[]): void {
    const curves = orders.flatMap((order, index) => {
      const points = rows(order["boundary"]);
      const colour = COLOURS[index % COLOURS.length] ?? "--blue";
      const known = points.find((point) => Number(point["stiffness_max"]) > 0);
      const unit = known === undefined ? 0 : Number(known["alpha"]) / Number(known["stiffness_max"]);
      const analysed = points.filter((point) => typeof point["analysis_stiffness_n_per_m"] === "number");
      const name = `μ = ${shown(order["order"])}`;
      return [
        { line: { label: name, colour, marked: true } as Curve, at: points.map((point): [number, number] => [Number(point["beta"]), Number(point["alpha"])]) },
        { line: { label: `${name}, analysis`, colour, width: 1.5 } as Curve, at: analysed.map((point): [number, number] => [Number(point["beta"]), unit * Number(point["analysis_stiffness_n_per_m"])]) },
      ];
    });
    const drawn = curves.filter(({ at }) => at.length > 0);
    if (drawn.length === 0) return;
    const { x, points } = joined(drawn.map(({ at }) => ({ time: at.map(([beta]) => beta), value: at.map(([, alpha]) => alpha) })));
    // One dissipation, as of a specimen, is no curve.
    if (x.length < 2) return;
    const lines = drawn.map(({ line }) => line);
    const chart = new Chart({ name: "Largest stiffness over dissipation", lines, yLeast: 0 });
    this.charts = [chart];
    const caption = el("p", { class: "hint" }, "Largest stiffness α = K·T²/m over dissipation β = B·T^(2−μ)/m: dots were tried, lines are of the analysis.");
    this.holder.replaceChildren(legend(lines).root, chart.root, caption);
    this.holder.hidden = false;
    const width = (x.at(-1) ?? 1) - (x[0] ?? 0);
    chart.draw(x, points, [(x[0] ?? 0) - 0.02 * width, (x.at(-1) ?? 1) + 0.02 * width]);
  }

  /** What was wished over the order, and the dissipation that allows it, as the command draws them. */
  private orders(report: Values): void {
    const candidates = rows(report["candidates"]).sort((one, other) => Number(one["order"]) - Number(other["order"]));
    const best = report["best"] as Values | null | undefined;
    // A controller is a single point.
    const orders = candidates.map((candidate) => Number(candidate["order"]));
    if (!best || orders.length < 2 || report["wish"] === "controller") return;
    const lines: Curve[] = [{ label: "each order", colour: "--blue" }, { label: "best, six pushes passed", colour: "--verm", marked: true }];
    const panel = (heading: string, key: string) => {
      const values = candidates.map((candidate) => numeric(candidate[key]));
      const known = values.filter((value) => value !== null);
      if (known.length < 2) return [];
      // B falls by decades with the order, as its unit does not stay.
      const logY = key === "dissipation_n_s_mu_per_m" && known.some((value) => value > 0);
      const seen = (value: number | null): number | null => (logY && value !== null && value <= 0 ? null : value);
      const chosen = { time: [Number(best["order"])], value: [seen(numeric(best[key]))] };
      const { x, points } = joined([{ time: orders, value: values.map(seen) }, chosen]);
      const chart = new Chart({ name: `${heading} over order`, lines, logY });
      this.charts.push(chart);
      const [low, high] = [x[0] ?? 0, x.at(-1) ?? 1];
      const edge = 0.02 * (high - low || 1);
      chart.draw(x, points, [low - edge, high + edge]);
      return [el("div", { class: "chart-holder" }, el("h3", {}, heading), chart.root)];
    };
    const [heading, key] = WISHES[String(report["wish"])] ?? ["largest stiffness K, N/m", "stiffness_n_per_m"];
    const panels = [...panel(heading, key), ...panel("dissipation B that allows it, N·s^μ/m", "dissipation_n_s_mu_per_m")];
    this.holder.replaceChildren(legend(lines).root, el("div", { class: "beside" }, ...panels), el("p", { class: "hint" }, "Over the order μ."));
    this.holder.hidden = panels.length === 0;
  }

  // The best wall or coupler.

  private proposal({ experiment }: Answer): Node[] {
    if (experiment === null) return [];
    const run = button("Run it", () => this.tryOut(experiment.kind, experiment.parameters), { class: "primary" });
    const keep = button("Save as experiment file", () => save(experiment.text, "application/toml", "design.toml"));
    const feel = button("Feel it", () => this.feelIt(experiment.text), { hidden: experiment.kind !== "wall" });
    return [el("div", { class: "buttons" }, run, feel, keep), el("details", {}, el("summary", {}, "The file"), el("pre", {}, experiment.text))];
  }

  private files(answer: Answer): HTMLElement {
    return el("div", { class: "buttons" }, button("JSON", () => save(JSON.stringify(answer.report, null, 2), "application/json", `${answer.kind}.json`)));
  }
}

/** What is drawn of each wish but the largest stiffness, and the key of a candidate that has it. */
const WISHES: Record<string, [string, string]> = {
  "most-damping": ["effective damping, N·s/m", "effective_damping_n_s_per_m"],
  tissue: ["largest scale of the specimen", "largest_scale"],
};

function numeric(value: unknown): number | null {
  return typeof value === "number" ? value : null;
}

function shown(value: unknown): string {
  if (typeof value !== "number") return typeof value === "string" ? value : "–";
  // Four digits, without zeros that say nothing.
  return value !== 0 && Math.abs(value) < 1e-4 ? number(value) : plain(Number(value.toPrecision(4)));
}

function rows(value: unknown): Values[] {
  return Array.isArray(value) ? (value as Values[]) : [];
}

/** A line of a report. */
export function line(line: Line): Node[] {
  if ("columns" in line) {
    const head = el("tr", {}, ...line.columns.map((name) => el("th", { scope: "col" }, name)));
    const body = line.rows.map((row) => el("tr", {}, ...row.map((cell) => el("td", {}, cell))));
    const heading = line.rows.length < line.length ? `${line.label} (${line.rows.length} of ${line.length})` : line.label;
    return [el("h3", {}, heading), el("table", { tabindex: 0, "aria-label": heading }, el("thead", {}, head), el("tbody", {}, ...body))];
  }
  if (line.value === "" && line.reason === "") return [el("h3", {}, line.label)];
  const value = line.reason === "" ? line.value : `${line.value} (${line.reason})`;
  return [el("dl", { class: "figures" }, el("dt", {}, line.label), el("dd", {}, value))];
}
