// An answer: how stiff a wall can be on a device, or the wall or coupler that suits it best.

import { Chart, legend, type Line } from "./chart";
import type { Points } from "./columns";
import { el, say } from "./dom";
import { number, plain } from "./format";
import type { Answer } from "./protocol";
import { save } from "./save";

type Values = Record<string, unknown>;

/** A column of a table: its heading, and what stands in a row. */
type Column = [string, (row: Values) => string];

/** Colours of orders, best told apart first. */
const COLOURS = ["--blue", "--verm", "--green", "--rose", "--ink", "--gold", "--mute"];

export class AnswerPanel {
  readonly root: HTMLElement;
  private readonly name = el("span");
  private readonly verdict = el("p", { class: "verdict", role: "status" });
  private readonly bar = el("progress", { max: 100, hidden: true, "aria-label": "How far it is" });
  private readonly holder = el("div", { class: "chart-holder", hidden: true });
  private readonly body = el("div", { class: "answer-body" });
  private chart: Chart | null = null;

  constructor(private readonly tryOut: (kind: string, parameters: Values) => void) {
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
    say(this.verdict, [answer.verdict ?? "", typeof ended === "string" ? `${ended}: what was found until then` : ""].filter((text) => text !== "").join(" · "));
    this.close();
    const shown = answer.kind === "zwidth" ? this.zwidth(answer.report) : this.design(answer);
    this.body.replaceChildren(...shown, this.files(answer));
  }

  private close(): void {
    this.chart?.destroy();
    this.chart = null;
    this.holder.hidden = true;
  }

  themed(): void {
    this.chart?.redraw();
  }

  // How stiff a wall can be.

  private zwidth(report: Values): Node[] {
    const orders = rows(report["orders"]);
    this.map(orders);
    const facts: [string, unknown][] = [["device", report["device"]], ["sample time, s", report["sample_time_s"]], ["δ = bT/m", report["delta"]], ["rule", report["criterion"]], ["impact, m/s", report["impact_m_per_s"]], ["push, N", report["push_n"]], ["operator", report["scheme"]], ["runs", report["runs"]]];
    const tables = orders.map((order) => {
      const points = rows(order["boundary"]);
      const columns: Column[] = [
        [`B, ${String(order["dissipation_unit"])}`, (point) => shown(point["dissipation"])],
        ["largest K, N/m", (point) => shown(point["stiffness_max"]) + (point["analysis_agrees"] === false ? " !" : "")],
        ["by the analysis, N/m", (point) => shown(point["analysis_stiffness_n_per_m"])],
        ["held by friction up to, N/m", (point) => shown(point["held_by_friction_up_to_n_per_m"])],
      ];
      const used = columns.filter(([, cell]) => points.some((point) => cell(point) !== "–"));
      const heading = `order ${shown(order["order"])}: ${points.length} walls${points.length > 0 ? `, the stiffest ${shown(Math.max(...points.map((point) => Number(point["stiffness_max"]))))} N/m` : ""}`;
      return el("details", { open: orders.length === 1 }, el("summary", {}, heading), table(used, points));
    });
    const doubt = Number(report["disagreements"]) > 0 ? [el("p", { class: "hint" }, `! trial and analysis disagree by more than 5 % at ${shown(report["disagreements"])} points: the analysis knows neither friction, encoder nor force limit.`)] : [];
    return [...tables, ...doubt, list(facts)];
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
        { line: { label: name, colour, marked: true } as Line, at: points.map((point): [number, number] => [Number(point["beta"]), Number(point["alpha"])]) },
        { line: { label: `${name}, analysis`, colour, width: 1.5 } as Line, at: analysed.map((point): [number, number] => [Number(point["beta"]), unit * Number(point["analysis_stiffness_n_per_m"])]) },
      ];
    });
    const drawn = curves.filter(({ at }) => at.length > 0);
    if (drawn.length === 0) return;
    const x = [...new Set(drawn.flatMap(({ at }) => at.map(([beta]) => beta)))].sort((a, b) => a - b);
    const place = new Map(x.map((beta, index) => [beta, index]));
    const points = drawn.map(({ at }) => {
      const line = new Array<number | undefined>(x.length);
      for (const [beta, alpha] of at) line[place.get(beta) ?? 0] = alpha;
      return line as Points;
    });
    const lines = drawn.map(({ line }) => line);
    this.chart = new Chart({ name: "Largest stiffness over dissipation", lines, yLeast: 0 });
    const caption = el("p", { class: "hint" }, "Largest stiffness α = K·T²/m over dissipation β = B·T^(2−μ)/m: dots were tried, lines are of the analysis.");
    this.holder.replaceChildren(legend(lines).root, this.chart.root, caption);
    this.holder.hidden = false;
    const width = (x.at(-1) ?? 1) - (x[0] ?? 0);
    this.chart.draw(x, points, [(x[0] ?? 0) - 0.02 * width, (x.at(-1) ?? 1) + 0.02 * width]);
  }

  // The best wall or coupler.

  private design({ report, experiment }: Answer): Node[] {
    const coupler = report["wish"] === "coupler";
    const best = report["best"] as Values | null;
    const wish = `${String(report["wish"])}, ${String(report["require"])}${typeof report["gain_margin"] === "number" ? `, gain margin ${shown(report["gain_margin"])}` : ""}`;
    const parts: Node[] = [el("p", { class: "hint" }, wish)];
    if (best) parts.push(this.proposal(best, coupler, experiment));
    const candidates = rows(report["candidates"]);
    parts.push(el("h3", {}, "Each order"), table(coupler ? COUPLERS : walls(report), candidates, (row) => best !== null && row["order"] === best["order"]));
    const notes = Array.isArray(report["notes"]) ? report["notes"].map(String) : [];
    const simulated = report["simulated"] as Values | null;
    if (simulated) notes.unshift(`The best one, tried on the simulated device: ${String(simulated["verdict"])}.`);
    const tissue = report["tissue"] as Values | null | undefined;
    if (tissue) notes.unshift(`${String(tissue["name"])} at its own order ${shown(tissue["order"])} ${tissue["fits"] === true ? "fits" : "does not fit"}; the specimen may be ${shown(tissue["largest_scale"])} of its size.`);
    const realistic = report["realistic"] as Values | null | undefined;
    if (realistic) notes.push(`On a realistic device (friction, delay, lag, encoder) the analysis calls it ${realistic["analysis_stable"] === true ? "stable" : "unstable"}, and the trial ${String((realistic["simulated"] as Values)["verdict"])}.`);
    return [...parts, ...notes.map((note) => el("p", { class: "hint" }, note))];
  }

  private proposal(best: Values, coupler: boolean, experiment: Answer["experiment"]): HTMLElement {
    const [k, b] = coupler ? ["damper, N·s/m", "spring, N·s^(1−μ)/m"] : ["stiffness K, N/m", "dissipation B, N·s^μ/m"];
    const figures = list([["order μ", best["order"]], [k, best["stiffness"]], [b, best["dissipation"]], ["margin", best["margin"]], ...(coupler ? [["felt stiffness, N/m", best["felt_stiffness_n_per_m"]] as [string, unknown]] : [])]);
    if (experiment === null) return el("div", {}, figures);
    const run = el("button", { type: "button", class: "primary" }, "Run it");
    run.addEventListener("click", () => this.tryOut(experiment.kind, experiment.parameters));
    const keep = el("button", { type: "button" }, "Save as experiment file");
    keep.addEventListener("click", () => save(new Blob([experiment.text], { type: "application/toml" }), "design.toml"));
    const text = el("details", {}, el("summary", {}, "The file"), el("pre", {}, experiment.text));
    return el("div", {}, figures, el("div", { class: "buttons" }, run, keep), text);
  }

  private files(answer: Answer): HTMLElement {
    const keep = el("button", { type: "button" }, "JSON");
    keep.addEventListener("click", () => save(new Blob([JSON.stringify(answer.report, null, 2)], { type: "application/json" }), `${answer.kind}.json`));
    return el("div", { class: "buttons" }, keep);
  }
}

function walls(report: Values): Column[] {
  const columns: Column[] = [
    ["μ", (row) => shown(row["order"])],
    ["K, N/m", (row) => shown(row["stiffness"])],
    ["B, N·s^μ/m", (row) => shown(row["dissipation"])],
    ["margin", (row) => shown(row["margin"])],
    ["passive", (row) => (row["passive"] === true ? "yes" : row["passive"] === false ? "no" : "–")],
    ["noise, N rms", (row) => shown(row["force_noise_rms_n"])],
    [`damping at ${shown(report["frequency_hz"])} Hz, N·s/m`, (row) => shown(row["effective_damping_n_s_per_m"])],
    ["largest scale", (row) => shown(row["largest_scale"])],
    ["why not", (row) => String(row["reason"] ?? "–")],
  ];
  const candidates = rows(report["candidates"]);
  return columns.filter(([, cell]) => candidates.some((row) => cell(row) !== "–"));
}

const COUPLERS: Column[] = [
  ["μ", (row) => shown(row["order"])],
  ["damper, N·s/m", (row) => shown(row["stiffness"])],
  ["spring, N·s^(1−μ)/m", (row) => shown(row["dissipation"])],
  ["felt, N/m", (row) => shown(row["felt_stiffness_n_per_m"])],
  ["margin of the loop", (row) => shown(row["loop_margin"])],
  ["why not", (row) => String(row["reason"] ?? "–")],
];

function shown(value: unknown): string {
  if (typeof value !== "number") return typeof value === "string" ? value : "–";
  // Four digits, without zeros that say nothing.
  return value !== 0 && Math.abs(value) < 1e-4 ? number(value) : plain(Number(value.toPrecision(4)));
}

function rows(value: unknown): Values[] {
  return Array.isArray(value) ? (value as Values[]) : [];
}

function table(columns: Column[], of: Values[], best: (row: Values) => boolean = () => false): HTMLElement {
  const head = el("tr", {}, ...columns.map(([name]) => el("th", { scope: "col" }, name)));
  const body = of.map((row) => el("tr", { class: best(row) ? "best" : undefined }, ...columns.map(([, cell]) => el("td", {}, cell(row)))));
  return el("table", {}, el("thead", {}, head), el("tbody", {}, ...body));
}

function list(facts: [string, unknown][]): HTMLElement {
  const known = facts.filter(([, value]) => typeof value === "number" || typeof value === "string");
  return el("dl", { class: "figures" }, ...known.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, shown(value))]));
}
