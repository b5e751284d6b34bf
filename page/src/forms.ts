// Forms of experiments, made from the parameter tables of the command.

import type { App } from "./app";
import type { Panel } from "./connection";
import { el, say, words } from "./dom";
import { readable, spoken } from "./names";
import type { Form, Parameter, Values } from "./protocol";

/** What is asked, in words. */
const TITLES: Record<string, string> = {
  relax: "relax: strain held, force falls",
  creep: "creep: force held, strain grows",
  wall: "wall: pushed into a wall",
  coupler: "coupler: an object behind a coupler",
  touch: "touch: a hand over a shape, 2 or 3 axes",
  teleoperation: "teleoperation: two hands over a line",
  zwidth: "zwidth: how stiff can a wall be?",
  design: "design: what is the best wall?",
  "analyze-environment": "analyze: what does a wall feel like?",
  "analyze-stability": "analyze: is a wall stable?",
  "analyze-stability-region": "analyze: which walls are stable?",
  "analyze-passivity": "analyze: is a wall passive?",
  "analyze-coupling": "analyze: is a coupler passive?",
  "analyze-teleoperation": "analyze: what does a hand feel over a line?",
  "analyze-transparency": "analyze: what does a wall feel like through a device?",
  "analyze-admittance": "analyze: does a robot bear these hands?",
  "analyze-difference": "analyze: does a hand feel the difference?",
  "analyze-sensitivity": "analyze: how much do model errors grow?",
};

/** Kinds that have no pace and no log: they are answered, not run. */
export function isQuestion(kind: string | null): boolean {
  return kind === "zwidth" || kind === "design" || kind?.startsWith("analyze-") === true;
}

/** How lists are written. */
const LIST_HINT: Record<string, string> = { way_points: "0, 25 mm, 0; 2, 15 mm, 0;", mass_kg: "65 g, 120 g" };

interface Field {
  parameter: Parameter;
  input: HTMLInputElement | HTMLSelectElement;
  row: HTMLElement;
  trouble: HTMLElement;
}

/** Fields for parameters, and the values that people give them. */
export class Fields {
  readonly all: Field[] = [];

  constructor(private readonly app: App) {}

  add(parameter: Parameter): HTMLElement {
    const shown = parameter.default === null || parameter.default === undefined ? "" : String(parameter.default);
    const input = inputFor(parameter, shown);
    const help = [parameter.help, parameter.range ?? ""].filter((text) => text !== "").join("; ");
    const trouble = el("small", { class: "trouble", role: "alert" });
    const row = el("label", { title: help }, el("span", {}, readable(parameter.key) + (parameter.required ? " *" : "")), input, trouble, el("small", {}, help));
    this.all.push({ parameter, input, row, trouble });
    return row;
  }

  /** Asks for the parameters of this name among the forms, and puts their fields into `rows`, once. */
  async once(name: string, rows: HTMLElement): Promise<void> {
    if (this.all.length > 0) return;
    const forms = await this.app.connection.ask<Record<string, Parameter[]>>("runs.forms");
    if (this.all.length === 0) rows.replaceChildren(...(forms[name] ?? []).map((one) => this.add(one)));
  }

  /** Asks a panel with the values of fields and more; null if it is refused, beside a field or in `state`, or something newer was asked. */
  async ask<Found>(panel: Panel, state: HTMLElement, question: () => Promise<object>, refused: () => void): Promise<Found | null> {
    state.classList.remove("trouble");
    this.refuse("");
    try {
      return await panel.ask<Found>(question());
    } catch (error) {
      refused();
      const text = words(error);
      const beside = this.refuse(text);
      state.classList.add("trouble");
      say(state, beside === null ? spoken(text) : `Not understood yet: see ${beside}.`);
      return null;
    }
  }

  /** Says a sentence beside the field that it is about, and nothing beside the others; the name of the field, or null if it is about none. */
  refuse(text: string): string | null {
    const field = this.all.find(({ parameter, row }) => !row.hidden && parameter.key === keyOf(text, this.all.map((one) => one.parameter.key)));
    for (const one of this.all) say(one.trouble, one === field ? text : "");
    if (field === undefined) return null;
    field.row.closest("details")?.setAttribute("open", "");
    field.input.focus();
    return readable(field.parameter.key);
  }

  /** Fills the fields with the values of a file, in SI units. */
  fill(values: Values): void {
    for (const { parameter, input } of this.all) {
      const value = values[parameter.key];
      if (value === undefined) continue;
      if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = value === true;
      else input.value = Array.isArray(value) ? value.map((part: unknown) => (Array.isArray(part) ? part.join(", ") : String(part))).join(value.some(Array.isArray) ? "; " : ", ") : String(value);
    }
  }

  /** What is given, by its keys, in SI units. */
  async values(): Promise<Values> {
    const values: Values = {};
    for (const { parameter, input, row } of this.all) {
      const value = row.hidden ? undefined : await this.value(parameter, input);
      if (value !== undefined) values[parameter.key] = value;
    }
    return values;
  }

  /** What differs from the default or must be said, in SI units; undefined is left to the command. */
  private async value(parameter: Parameter, input: HTMLInputElement | HTMLSelectElement): Promise<unknown> {
    if (input instanceof HTMLInputElement && input.type === "checkbox") return input.checked === (parameter.default ?? false) ? undefined : input.checked;
    const text = input.value.trim();
    const asDefault = text === String(parameter.default ?? "");
    if (text === "" || (asDefault && !parameter.required)) return undefined;
    if (asDefault) return parameter.default;
    if (parameter.kind === "list") return this.list(parameter, text);
    if (isText(parameter)) return text;
    return this.number(parameter, text);
  }

  private async number(parameter: Parameter, text: string): Promise<number> {
    try {
      return await this.app.connection.quantity(parameter.key, text);
    } catch (error) {
      throw new Error(`\`${parameter.key}\`: ${words(error)}`);
    }
  }

  /** Numbers with commas between them; rows of them with semicolons. */
  private async list(parameter: Parameter, text: string): Promise<number[] | number[][]> {
    const row = (text: string): Promise<number[]> => {
      const parts = text.split(",").map((part) => part.trim());
      return Promise.all(parts.filter((part) => part !== "").map((part) => this.number(parameter, part)));
    };
    if (!text.includes(";")) return row(text);
    return Promise.all(text.split(";").map((part) => part.trim()).filter((part) => part !== "").map(row));
  }
}

export class FormPanel {
  readonly root: HTMLElement;
  private readonly kind = el("select", { "aria-label": "Experiment" });
  private readonly tables = el("div", { class: "tables" });
  private readonly trouble = el("p", { class: "trouble", role: "alert" });
  private readonly realtime = el("input", { type: "checkbox", id: "realtime" });
  private readonly pace = el("label", { class: "check", for: "realtime" }, this.realtime, "by the clock, not in virtual time");
  private forms: Form[] = [];
  private fields: Fields;

  constructor(private readonly app: App, private readonly started: (name: string, kind: string) => void) {
    this.fields = new Fields(app);
    const start = el("button", { type: "submit", class: "primary" }, "Start");
    const form = el(
      "form",
      { class: "card form" },
      el("h2", {}, "New run"),
      el("label", { class: "choice" }, "Experiment", this.kind),
      this.tables,
      this.trouble,
      el("div", { class: "buttons" }, start, this.pace),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.start();
    });
    this.kind.addEventListener("change", () => this.draw());
    this.root = form;
  }

  take(forms: Form[]): void {
    this.forms = forms;
    this.kind.replaceChildren(...forms.map((form) => el("option", { value: form.kind }, TITLES[form.kind] ?? form.kind)));
    this.draw();
  }

  /** The form of an experiment file, filled. */
  fill(kind: string, parameters: Values): void {
    this.kind.value = kind;
    this.draw();
    this.fields.fill(parameters);
    for (const details of this.tables.querySelectorAll("details")) details.open = true;
  }

  private draw(): void {
    this.fields = new Fields(this.app);
    const form = this.forms.find(({ kind }) => kind === this.kind.value);
    const tables = (form?.tables ?? []).map((table, index) => {
      const rows = table.parameters.map((parameter) => this.fields.add(parameter));
      return el("details", { open: index === 0 || table.parameters.some((one) => one.required) }, el("summary", {}, table.title), el("div", { class: "fields" }, ...rows));
    });
    this.tables.replaceChildren(...tables);
    // A worker has no clock.
    this.pace.hidden = isQuestion(this.kind.value) || document.documentElement.dataset.worker !== undefined;
    say(this.trouble, "");
  }

  private async start(): Promise<void> {
    say(this.trouble, "");
    this.fields.refuse("");
    try {
      const parameters = await this.fields.values();
      const kind = this.kind.value;
      const realtime = this.realtime.checked && !this.pace.hidden ? { realtime: true } : {};
      const { name } = await this.app.connection.ask<{ name: string }>("runs.start", { kind, parameters, ...realtime });
      this.started(name, kind);
    } catch (error) {
      const text = words(error);
      if (this.fields.refuse(text) === null) say(this.trouble, text);
    }
  }
}

/** The key that a sentence is about: the first that it names as `key`, key = or key:, else the first of several words. */
export function keyOf(text: string, keys: string[]): string | undefined {
  const places = keys.map((key) => {
    const named = new RegExp(`\`${key}\`|\\b${key}(?= =|:)`).exec(text)?.index;
    const word = key.includes("_") ? new RegExp(`\\b${key}\\b`).exec(text)?.index : undefined;
    return { key, at: named ?? (word === undefined ? undefined : word + text.length) };
  });
  const found = places.filter((place): place is { key: string; at: number } => place.at !== undefined);
  return found.sort((a, b) => a.at - b.at)[0]?.key;
}

function isText(parameter: Parameter): boolean {
  return parameter.kind === "text" || (parameter.choices?.length ?? 0) > 0;
}

function inputFor(parameter: Parameter, shown: string): HTMLInputElement | HTMLSelectElement {
  if (parameter.choices && parameter.choices.length > 0) {
    const options = parameter.choices.includes(shown) ? parameter.choices : [shown, ...parameter.choices];
    const select = el("select", {}, ...options.map((choice) => el("option", { value: choice }, choice || "–")));
    select.value = shown;
    return select;
  }
  if (/flag|bool/.test(parameter.kind)) {
    const box = el("input", { type: "checkbox" });
    box.checked = parameter.default === true;
    return box;
  }
  const hint = parameter.kind === "list" && shown === "" ? LIST_HINT[parameter.key] ?? "numbers with commas" : (parameter.shown ?? "");
  return el("input", { type: "text", value: shown, placeholder: hint, spellcheck: "false", autocomplete: "off" });
}
