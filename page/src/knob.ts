// A slider with a field beside it: drag it, or type a value with its unit.

import { el, words } from "./dom";
import { quantity } from "./format";

export interface KnobOptions {
  label: string;
  /** SI unit, as it is shown. */
  unit: string;
  /** End of the keys of such numbers, which says their units; empty for a pure number. */
  ending: string;
  least: number;
  most: number;
  /** Equal factors rather than equal steps. With a least of 0 the first step is a millionth of the most. */
  log?: boolean;
  value: number;
  /** What is typed may lie beyond the slider: the server says how far. */
  beyond?: boolean;
  /** A slider that is dragged changes nothing before it is let go. */
  late?: boolean;
  help?: string;
  changed: (value: number) => void;
  parse: (key: string, text: string) => Promise<number>;
}

const STEPS = 1000;
let count = 0;

export class Knob {
  readonly root: HTMLElement;
  private readonly range: HTMLInputElement;
  private readonly field: HTMLInputElement;
  private readonly label: HTMLLabelElement;
  private readonly trouble = el("span", { class: "trouble", role: "alert" });
  private current: number;

  constructor(private options: KnobOptions) {
    const id = `knob-${count++}`;
    this.current = options.value;
    this.label = el("label", { for: id, title: options.help ?? "" }, options.label);
    this.range = el("input", { id, type: "range", min: 0, max: STEPS, step: 1 });
    this.field = el("input", { type: "text", class: "value", "aria-label": `${options.label}, with unit`, spellcheck: "false", autocomplete: "off" });
    this.root = el("div", { class: "knob" }, el("div", { class: "line" }, this.label, this.field), this.range, this.trouble);
    const slid = () => this.fromStep(Number(this.range.value));
    this.range.addEventListener("input", () => (options.late ? this.show(slid()) : this.take(slid())));
    if (options.late) this.range.addEventListener("change", () => this.take(slid()));
    this.field.addEventListener("change", () => void this.typed());
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.trouble.textContent = "";
    });
    this.field.addEventListener("focus", () => this.field.select());
    this.show(options.value);
  }

  /** Shows a value. A slider that stands for it already is left alone: digits are rounded, its steps are not. */
  show(value: number): void {
    this.current = value;
    if (this.fromStep(Number(this.range.value)) !== value) this.range.value = String(this.toStep(value));
    this.range.style.setProperty("--share", `${(100 * Number(this.range.value)) / STEPS}%`);
    const text = quantity(value, this.options.unit);
    this.range.setAttribute("aria-valuetext", text);
    if (document.activeElement !== this.field) this.field.value = text;
    this.trouble.textContent = "";
  }

  /** Changes label, unit or range. */
  change(options: Partial<KnobOptions>): void {
    this.options = { ...this.options, ...options };
    this.label.textContent = this.options.label;
    this.field.setAttribute("aria-label", `${this.options.label}, with unit`);
    this.show(this.current);
  }

  /** Says why the server refused a value, with the unit that its range is in. */
  refuse(why: string): void {
    this.trouble.textContent = why.replace(/: change it$/, ` ${this.options.unit}`);
  }

  set disabled(disabled: boolean) {
    this.range.disabled = this.field.disabled = disabled;
  }

  private take(value: number): void {
    this.show(value);
    this.options.changed(value);
  }

  private async typed(): Promise<void> {
    const { ending, least, most, unit, beyond, parse } = this.options;
    try {
      // The unit that stands there already is not asked for again.
      const text = this.field.value.replace(/[\u202f\u00a0]/g, " ").replace("−", "-").trim();
      const bare = ending === "" && text.endsWith(unit) ? text.slice(0, text.length - unit.length) : text;
      const value = await parse(ending, bare);
      if (!beyond && (value < least || value > most)) {
        this.trouble.textContent = `from ${quantity(least, unit)} to ${quantity(most, unit)}`;
        return;
      }
      this.field.blur();
      this.take(value);
    } catch (error) {
      this.trouble.textContent = words(error);
    }
  }

  private floor(): number {
    return this.options.least > 0 ? this.options.least : this.options.most * 1e-6;
  }

  private toStep(value: number): number {
    const { least, most, log } = this.options;
    const share = log ? Math.log(Math.max(value, this.floor()) / this.floor()) / Math.log(most / this.floor()) : (value - least) / (most - least);
    return Math.round(STEPS * Math.min(1, Math.max(0, share)));
  }

  private fromStep(step: number): number {
    const { least, most, log } = this.options;
    if (step === 0) return least;
    if (step === STEPS) return most;
    const share = step / STEPS;
    const value = log ? this.floor() * (most / this.floor()) ** share : least + share * (most - least);
    // What is shown is what is meant.
    return Number(value.toPrecision(3));
  }
}
