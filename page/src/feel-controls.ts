// The tissue, what it is compared with, and the knobs of its law.

import type { App } from "./app";
import { el } from "./dom";
import { Knob } from "./knob";
import type { Feel, Hello } from "./protocol";
import { edited, type FeelChange } from "./state";

const GHOSTS: [string, string][] = [
  ["short,a3", "short memory, 1 s · A₃"],
  ["short", "short memory, 1 s"],
  ["a3", "A₃"],
  ["", "nothing"],
];

export class FeelControls {
  readonly root: HTMLElement;
  private readonly tissue = el("select", { "aria-label": "Tissue" });
  private readonly compare = el("select", { "aria-label": "Compare with" }, ...GHOSTS.map(([value, text]) => el("option", { value }, text)));
  private readonly order: Knob;
  private readonly dissipation: Knob;
  private readonly stiffness: Knob;

  constructor(private readonly app: App) {
    const parse = (key: string, text: string): Promise<number> => app.connection.quantity(key, text);
    this.order = new Knob({
      label: "order μ", unit: "", ending: "", least: 0, most: 1, value: 0.5, parse,
      help: "0 is a spring, 1 a damper; between them it relaxes and remembers",
      changed: (order) => this.change({ order }),
    });
    this.dissipation = new Knob({
      label: "dissipation B", unit: "N·s^μ/m", ending: "", least: 1, most: 1000, log: true, value: 100, parse,
      help: "of the part that remembers",
      changed: (value) => this.changeDissipation(value),
    });
    this.stiffness = new Knob({
      label: "stiffness K", unit: "N/m", ending: "_n_per_m", least: 0, most: 1000, log: true, value: 0, parse,
      help: "of the part that does not",
      changed: (value) => this.change({ stiffness_n_per_m: value }),
    });
    this.root = el(
      "div",
      { class: "knobs" },
      el("label", { class: "choice" }, "Tissue", this.tissue),
      el("label", { class: "choice" }, "Compare with", this.compare),
      this.order.root,
      this.dissipation.root,
      this.stiffness.root,
    );
    this.tissue.addEventListener("change", () => {
      if (this.tissue.value !== "") this.change({ environment: { tissue: this.tissue.value } });
    });
    this.compare.addEventListener("change", () => this.change({ ghosts: this.compare.value.split(",").filter((name) => name !== "") }));
  }

  connected(hello: Hello): void {
    this.tissue.replaceChildren(...hello.tissues.map((tissue) => el("option", { value: tissue.name }, `${tissue.title} · ${tissue.model}`)), el("option", { value: "", hidden: true }, "own wall"));
    const { order, stiffness_n_per_m: stiffness } = hello.ranges;
    if (order) this.order.change({ least: order.least, most: order.most });
    if (stiffness) this.stiffness.change({ least: stiffness.least, most: stiffness.most });
  }

  show(feel: Feel, hello: Hello | null): void {
    this.tissue.value = "tissue" in feel.environment ? feel.environment.tissue : "";
    this.compare.value = GHOSTS.find(([value]) => value === feel.ghosts.join(","))?.[0] ?? "";
    this.order.disabled = !feel.order_free;
    this.order.show(feel.order);
    const range = feel.order_free ? hello?.ranges["dissipation_n_s_mu_per_m"] : hello?.ranges["scale"];
    if (range) {
      const names = feel.order_free ? { label: "dissipation B", unit: "N·s^μ/m" } : { label: "size", unit: "×" };
      this.dissipation.change({ ...names, least: Math.max(range.least, range.most * 1e-4), most: range.most });
    }
    // B as it acts, or the scale of a tissue that is no spring-pot beside a spring.
    this.dissipation.show(feel.order_free ? feel.dissipation_n_s_mu_per_m * feel.scale : feel.scale);
    this.stiffness.root.hidden = !("wall" in feel.environment || feel.stiffness_n_per_m > 0);
    this.stiffness.show(feel.stiffness_n_per_m);
  }

  private change(change: FeelChange): void {
    this.app.dispatch({ do: "change", change });
  }

  private changeDissipation(value: number): void {
    const feel = edited(this.app.state);
    if (feel?.order_free) this.change({ dissipation_n_s_mu_per_m: value / feel.scale });
    else this.change({ scale: value });
  }
}
