// Forms of experiments, made from the parameter tables of the command.

import type { App } from "./app";
import { el, say } from "./dom";
import { readable } from "./names";
import type { Form, Parameter } from "./protocol";

/** Kinds of quantities by the unit at the end of a key, as the command line reads them. */
const KINDS: [RegExp, string][] = [
  [/_n_s_per_m$/, "damping"],
  [/_n_per_m$/, "stiffness"],
  [/_hz$/, "frequency"],
  [/_kg$/, "mass"],
  [/_pa$/, "stress"],
  [/_m2$/, "area"],
  [/(^|_)strain$/, "strain"],
  [/_s_mu_per_m$|_per_s$|_mu$/, "number"],
  [/_s$/, "time"],
  [/_m$/, "length"],
  [/_n$/, "force"],
];

interface Field {
  parameter: Parameter;
  input: HTMLInputElement | HTMLSelectElement;
}

export class FormPanel {
  readonly root: HTMLElement;
  private readonly kind = el("select", { "aria-label": "Experiment" });
  private readonly tables = el("div", { class: "tables" });
  private readonly trouble = el("p", { class: "trouble", role: "alert" });
  private readonly realtime = el("input", { type: "checkbox", id: "realtime" });
  private forms: Form[] = [];
  private fields: Field[] = [];

  constructor(private readonly app: App, private readonly started: (name: string) => void) {
    const start = el("button", { type: "submit", class: "primary" }, "Start");
    const form = el(
      "form",
      { class: "card form" },
      el("h2", {}, "New run"),
      el("label", { class: "choice" }, "Experiment", this.kind),
      this.tables,
      this.trouble,
      el("div", { class: "buttons" }, start, el("label", { class: "check", for: "realtime" }, this.realtime, "by the clock, not in virtual time")),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.start();
    });
    this.kind.addEventListener("change", () => this.draw());
    this.root = form;
  }

  /** Asks for the tables, once. */
  shown(): void {
    if (this.forms.length > 0 || !this.app.connection.ready) return;
    this.app.connection.ask<{ forms: Form[] }>("runs.forms").then(
      ({ forms }) => {
        this.forms = forms;
        this.kind.replaceChildren(...forms.map((form) => el("option", { value: form.kind }, form.kind)));
        this.draw();
      },
      () => undefined,
    );
  }

  private draw(): void {
    this.fields = [];
    const form = this.forms.find(({ kind }) => kind === this.kind.value);
    const tables = (form?.tables ?? []).map((table, index) => {
      const rows = table.parameters.map((parameter) => this.field(parameter));
      return el("details", { open: index === 0 }, el("summary", {}, table.title), el("div", { class: "fields" }, ...rows));
    });
    this.tables.replaceChildren(...tables);
    say(this.trouble, "");
  }

  private field(parameter: Parameter): HTMLElement {
    const shown = parameter.default === null || parameter.default === undefined ? "" : String(parameter.default);
    const input = inputFor(parameter, shown);
    this.fields.push({ parameter, input });
    const help = [parameter.help, parameter.range ?? ""].filter((text) => text !== "").join("; ");
    return el("label", { title: help }, el("span", {}, readable(parameter.key) + (parameter.required ? " *" : "")), input, el("small", {}, help));
  }

  private async start(): Promise<void> {
    say(this.trouble, "");
    try {
      const parameters: Record<string, unknown> = {};
      for (const { parameter, input } of this.fields) {
        const value = await this.value(parameter, input);
        if (value !== undefined) parameters[parameter.key] = value;
      }
      const realtime = this.realtime.checked ? { realtime: true } : {};
      const { name } = await this.app.connection.ask<{ name: string }>("runs.start", { kind: this.kind.value, parameters, ...realtime });
      this.started(name);
    } catch (error) {
      say(this.trouble, error instanceof Error ? error.message : String(error));
    }
  }

  /** What differs from the default or must be said, in SI units; undefined is left to the command. */
  private async value(parameter: Parameter, input: HTMLInputElement | HTMLSelectElement): Promise<unknown> {
    if (input instanceof HTMLInputElement && input.type === "checkbox") return input.checked === (parameter.default ?? false) ? undefined : input.checked;
    const text = input.value.trim();
    const asDefault = text === String(parameter.default ?? "");
    if (text === "" || (asDefault && !parameter.required)) return undefined;
    if (asDefault) return parameter.default;
    const known = KINDS.find(([pattern]) => pattern.test(parameter.key))?.[1];
    // What is optional and has no unit is a number if it looks like one.
    if (isText(parameter) && (known === undefined || parameter.default !== null)) return Number.isNaN(Number(text)) || parameter.default !== null ? text : Number(text);
    const kind = known ?? "number";
    try {
      return await this.app.analysis.parse(kind, text);
    } catch (error) {
      input.focus();
      throw new Error(`${readable(parameter.key)}: ${error instanceof Error ? error.message : String(error)}`);
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
  return el("input", { type: "text", value: shown, placeholder: parameter.shown ?? "", spellcheck: "false", autocomplete: "off" });
}
