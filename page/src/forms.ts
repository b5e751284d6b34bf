// Forms of experiments, made from the parameter tables of the command.

import type { App } from "./app";
import { el, say } from "./dom";
import { readable } from "./names";
import type { Form, Parameter } from "./protocol";

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
};
/** Kinds that have no pace: they are answered, not run. */
const QUESTIONS = ["zwidth", "design"];

/** How lists are written. */
const LIST_HINT: Record<string, string> = { way_points: "0, 25 mm, 0; 2, 15 mm, 0;", mass_kg: "65 g, 120 g" };

interface Field {
  parameter: Parameter;
  input: HTMLInputElement | HTMLSelectElement;
  row: HTMLElement;
}

/** Fields for parameters, and the values that people give them. */
export class Fields {
  readonly all: Field[] = [];

  constructor(private readonly app: App) {}

  add(parameter: Parameter): HTMLElement {
    const shown = parameter.default === null || parameter.default === undefined ? "" : String(parameter.default);
    const input = inputFor(parameter, shown);
    const help = [parameter.help, parameter.range ?? ""].filter((text) => text !== "").join("; ");
    const row = el("label", { title: help }, el("span", {}, readable(parameter.key) + (parameter.required ? " *" : "")), input, el("small", {}, help));
    this.all.push({ parameter, input, row });
    return row;
  }

  /** What is given, by its keys, in SI units. */
  async values(): Promise<Record<string, unknown>> {
    const values: Record<string, unknown> = {};
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
    if (parameter.kind === "list") return this.list(parameter, text, input);
    if (isText(parameter)) return text;
    return this.number(parameter, text, input);
  }

  private async number(parameter: Parameter, text: string, input: HTMLElement): Promise<number> {
    try {
      return await this.app.connection.quantity(parameter.key, text);
    } catch (error) {
      input.focus();
      throw new Error(`${readable(parameter.key)}: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  /** Numbers with commas between them; rows of them with semicolons. */
  private async list(parameter: Parameter, text: string, input: HTMLElement): Promise<number[] | number[][]> {
    const row = (text: string): Promise<number[]> => {
      const parts = text.split(",").map((part) => part.trim());
      return Promise.all(parts.filter((part) => part !== "").map((part) => this.number(parameter, part, input)));
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

  private draw(): void {
    this.fields = new Fields(this.app);
    const form = this.forms.find(({ kind }) => kind === this.kind.value);
    const tables = (form?.tables ?? []).map((table, index) => {
      const rows = table.parameters.map((parameter) => this.fields.add(parameter));
      return el("details", { open: index === 0 }, el("summary", {}, table.title), el("div", { class: "fields" }, ...rows));
    });
    this.tables.replaceChildren(...tables);
    this.pace.hidden = QUESTIONS.includes(this.kind.value);
    say(this.trouble, "");
  }

  private async start(): Promise<void> {
    say(this.trouble, "");
    try {
      const parameters = await this.fields.values();
      const kind = this.kind.value;
      const realtime = this.realtime.checked && !this.pace.hidden ? { realtime: true } : {};
      const { name } = await this.app.connection.ask<{ name: string }>("runs.start", { kind, parameters, ...realtime });
      this.started(name, kind);
    } catch (error) {
      say(this.trouble, error instanceof Error ? error.message : String(error));
    }
  }
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
