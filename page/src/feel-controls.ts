// The tissue, what it is compared with, the knobs of its law, and the device.

import type { App } from "./app";
import { chosen, el, say, select } from "./dom";
import { number, quantity } from "./format";
import { Knob, type KnobOptions } from "./knob";
import type { Device, Feel, Hello, Wall } from "./protocol";
import { edited, onDevice, OPERATORS, type FeelChange } from "./state";

const GHOSTS: [string, string][] = [
  ["short,a3", "short memory, 1 s · A₃"],
  ["short", "short memory, 1 s"],
  ["a3", "A₃"],
  ["", "nothing"],
];

type Setting = Pick<KnobOptions, "label" | "unit" | "ending" | "log" | "help" | "least" | "most"> & { key: keyof Device };

const DEVICE: Setting[] = [
  { key: "mass_kg", label: "mass m", unit: "kg", ending: "_kg", log: true, least: 5e-3, most: 2, help: "of the device" },
  { key: "damping_n_s_per_m", label: "damping b", unit: "N·s/m", ending: "_n_s_per_m", least: 0, most: 50, help: "of the device" },
  { key: "delay_s", label: "delay", unit: "s", ending: "_s", least: 0, most: 1e-2, help: "from a measurement to the force that answers it, beside the hold" },
  { key: "current_lag_s", label: "current lag", unit: "s", ending: "_s", least: 0, most: 1e-2, help: "time constant of the motor current" },
  { key: "encoder_resolution_m", label: "encoder step", unit: "m", ending: "_m", log: true, least: 0, most: 1e-3, help: "what the loop reads is a whole number of these" },
  { key: "sensor_noise_m", label: "sensor noise", unit: "m", ending: "_m", log: true, least: 0, most: 1e-3, help: "rms, beside the steps" },
];

export class FeelControls {
  readonly root: HTMLElement;
  private readonly tissue = el("select", { "aria-label": "Tissue" });
  private readonly compare = select("Compare with", GHOSTS);
  private readonly operator = select("Operator of the wall", OPERATORS);
  private readonly operators = el("label", { class: "choice" }, "Operator", this.operator);
  private readonly note = el("p", { class: "hint", role: "status", hidden: true });
  private readonly said = el("span");
  private readonly order: Knob;
  private readonly dissipation: Knob;
  private readonly stiffness: Knob;
  private readonly device = new Map<keyof Device, Knob>();

  constructor(private readonly app: App) {
    const parse = (key: string, text: string) => app.connection.quantity(key, text);
    this.order = new Knob({
      label: "order μ", unit: "", ending: "", least: 0, most: 1, value: 0.5, beyond: true, parse,
      help: "0 is a spring, 1 a damper; between them it relaxes and remembers",
      changed: (order) => this.change({ order }),
    });
    this.dissipation = new Knob({
      label: "dissipation B", unit: "N·s^μ/m", ending: "", least: 1, most: 1000, log: true, value: 100, beyond: true, parse,
      help: "of the part that remembers",
      changed: (value) => this.changeDissipation(value),
    });
    this.stiffness = new Knob({
      label: "stiffness K", unit: "N/m", ending: "_n_per_m", least: 0, most: 1000, log: true, value: 0, beyond: true, parse,
      help: "of the part that does not",
      changed: (value) => this.change({ stiffness_n_per_m: value }),
    });
    for (const { key, ...setting } of DEVICE) {
      // Another device begins anew.
      const changed = (value: number) => app.dispatch({ do: "start", values: onDevice(app.state, key, value) });
      this.device.set(key, new Knob({ ...setting, value: 0, beyond: true, late: true, parse, changed }));
    }
    const knobs = [...this.device.values()].map(({ root }) => root);
    this.root = el(
      "div",
      {},
      el(
        "div",
        { class: "knobs" },
        el("label", { class: "choice" }, "Tissue", this.tissue),
        el("label", { class: "choice" }, "Compare with", this.compare),
        this.order.root,
        this.dissipation.root,
        this.stiffness.root,
        this.operators,
      ),
      this.note,
      el("details", { class: "device-numbers", "data-fold": "device" }, el("summary", {}, "Device ", this.said), el("div", { class: "knobs" }, ...knobs)),
    );
    this.tissue.addEventListener("change", () => {
      if (this.tissue.value !== "") this.change({ environment: { tissue: this.tissue.value } });
    });
    this.compare.addEventListener("change", () => this.change({ ghosts: this.compare.value.split(",").filter((name) => name !== "") }));
    this.operator.addEventListener("change", () => this.changeOperator(this.operator.value));
  }

  connected(hello: Hello): void {
    this.tissue.replaceChildren(...hello.tissues.map((tissue) => el("option", { value: tissue.name }, `${tissue.title} · ${tissue.model}`)), el("option", { value: "", hidden: true }, "own wall"));
    const { stiffness_n_per_m: stiffness } = hello.ranges;
    if (stiffness) this.stiffness.change({ least: stiffness.least, most: stiffness.most });
  }

  show(feel: Feel, hello: Hello | null): void {
    const wall = "wall" in feel.environment;
    chosen(this.tissue, "tissue" in feel.environment ? feel.environment.tissue : "", feel.title);
    this.compare.value = GHOSTS.find(([value]) => value === feel.ghosts.join(","))?.[0] ?? "";
    this.operators.hidden = !wall;
    chosen(this.operator, feel.scheme === "full" ? "exact" : feel.scheme);
    say(this.note, feel.note ?? "");
    this.note.hidden = !feel.note;
    this.order.disabled = !feel.order_free;
    this.order.change({ most: wall ? hello?.ranges["order"]?.most ?? 2 : 1 });
    this.order.show(feel.order);
    const range = feel.order_free ? hello?.ranges["dissipation_n_s_mu_per_m"] : hello?.ranges["scale"];
    if (range) {
      const names = feel.order_free ? { label: "dissipation B", unit: "N·s^μ/m" } : { label: "size", unit: "×" };
      this.dissipation.change({ ...names, least: Math.max(range.least, range.most * 1e-4), most: range.most });
    }
    // B as it acts, or the scale of a tissue that is no spring-pot beside a spring.
    this.dissipation.show(feel.order_free ? feel.dissipation_n_s_mu_per_m * feel.scale : feel.scale);
    this.stiffness.root.hidden = !(wall || feel.stiffness_n_per_m > 0);
    this.stiffness.show(feel.stiffness_n_per_m);
    for (const [key, knob] of this.device) knob.show(feel[key] ?? 0);
    say(this.said, device(feel));
  }

  /** A refusal begins with the name of the number that it is about. */
  refused(why: string): boolean {
    const [, key = "", rest = ""] = /^`(\w+)`(?: = )?(.*)$/.exec(why) ?? [];
    const law: Record<string, Knob> = { order: this.order, stiffness_n_per_m: this.stiffness, dissipation_n_s_mu_per_m: this.dissipation, scale: this.dissipation };
    const knob = this.device.get(key as keyof Device) ?? law[key];
    knob?.refuse(rest);
    return knob !== undefined && knob.root.checkVisibility();
  }

  private change(change: FeelChange): void {
    this.app.dispatch({ do: "change", change });
  }

  private changeDissipation(value: number): void {
    const feel = edited(this.app.state);
    if (feel?.order_free) this.change({ dissipation_n_s_mu_per_m: value / feel.scale });
    else this.change({ scale: value });
  }

  private changeOperator(scheme: string): void {
    const feel = edited(this.app.state);
    if (feel === null) return;
    const { order, stiffness_n_per_m, dissipation_n_s_mu_per_m, signed } = feel;
    const wall: Wall = { order, stiffness_n_per_m, dissipation_n_s_mu_per_m, signed, scheme };
    this.change({ environment: { wall } });
  }
}

/** A device in short: what it has none of is left out. */
function device(feel: Feel): string {
  const parts: [number, string, string][] = [
    [feel.delay_s, "s", " delay"],
    [feel.current_lag_s, "s", " lag"],
    [feel.friction_n, "N", " friction"],
    [feel.encoder_resolution_m, "m", " encoder"],
    [feel.sensor_noise_m, "m", " noise"],
  ];
  const less = parts.filter(([value]) => value > 0).map(([value, unit, name]) => quantity(value, unit) + name);
  return [`${number(1000 * feel.mass_kg)} g`, quantity(feel.damping_n_s_per_m, "N·s/m"), ...less].join(" · ");
}
