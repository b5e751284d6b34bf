// Runs: what happened? A list, curves over each other, answers, new runs, records to identify.

import { AnswerPanel } from "./answer";
import type { App, Dropped, ViewPart } from "./app";
import { button, el, say, words } from "./dom";
import { bytes, duration, number } from "./format";
import { FormPanel, isQuestion } from "./forms";
import { IdentifyPanel } from "./identify";
import { Overlay } from "./overlay";
import type { Answer, Form, OpenRun, RecordParameter, RunEntry, RunProgress, Unasked, Values } from "./protocol";
import type { Shown, State } from "./state";

/** Runs that can be told apart over each other. */
const OPEN_MOST = 6;

/** Time between two looks at the folder, ms. */
const LOOK_MS = 2000;

/** Time between two pictures of a run that goes on, ms. */
const WATCH_MS = 300;

type Panel = "curves" | "answer" | "form" | "identify";

export class RunsView implements ViewPart {
  readonly root: HTMLElement;
  private readonly list = el("ul", { class: "list" });
  private readonly folder = el("span");
  private readonly facts = el("div", { class: "facts", tabindex: 0, role: "region", "aria-label": "Report" });
  private readonly progress = el("p", { class: "progress", role: "status" });
  private readonly stop = button("End the run", () => void this.app.tell("runs.stop"), { hidden: true });
  private readonly overlay: Overlay;
  private readonly answer: AnswerPanel;
  private readonly form: FormPanel;
  private readonly identify: IdentifyPanel;
  private hasForms = false;
  private readonly panels: Record<Panel, HTMLElement>;
  private entries: RunEntry[] = [];
  /** What the server said of the runs that are open, and what it is asked and has not answered. */
  private readonly loaded = new Map<string, OpenRun>();
  private readonly loading = new Map<string, symbol>();
  /** The answer that is shown. */
  private answered = "";
  /** The run that goes on, and when it was drawn last, ms. */
  private going: { name: string; drawn: number } | null = null;
  /** A run of this page that is to be drawn as soon as there is something. */
  private awaited: string | null = null;

  constructor(private readonly app: App) {
    this.overlay = new Overlay(app);
    this.form = new FormPanel(app, (name, kind) => this.started(name, kind));
    this.answer = new AnswerPanel((kind, parameters) => void this.tryOut(kind, parameters), (text) => app.dispatch({ do: "open", what: { file: { name: "design.toml", text } } }), (values) => app.dispatch({ do: "start", values }));
    this.identify = new IdentifyPanel(app);
    this.panels = {
      curves: el("div", { class: "panel curves-panel" }, this.overlay.root, el("div", { class: "side" }, this.overlay.plane.root, this.overlay.depth, el("section", { class: "card facts-card" }, el("h2", {}, "Report"), this.facts))),
      answer: el("div", { class: "panel" }, this.answer.root),
      form: el("div", { class: "panel" }, this.form.root),
      identify: el("div", { class: "panel" }, this.identify.root),
    };
    const buttons = el("div", { class: "buttons" }, button("New run", () => this.show("form")), button("Identify a record", () => this.show("identify")));
    const list = el("section", { class: "card runs-list" }, el("h2", {}, "Runs", this.folder), this.list, this.progress, this.stop, buttons);
    this.root = el("div", { class: "view runs" }, list, ...Object.values(this.panels));
    this.show("curves");
    this.drawFacts([]);
    setInterval(() => void this.look(), LOOK_MS);
  }

  /** Runs that a command beside the server writes are seen by looking. */
  private async look(): Promise<void> {
    if (!this.visible || document.hidden || !this.app.connection.ready) return;
    const before = JSON.stringify(this.entries);
    await this.refresh();
    if (JSON.stringify(this.entries) === before) return;
    const others = this.app.state.runs.open.filter((name) => this.loaded.get(name)?.running && this.going?.name !== name);
    for (const name of others) this.loaded.delete(name);
    if (others.length > 0) void this.load();
  }

  render(state: State, before: State): void {
    const { hello, runs } = state;
    if (hello !== null && hello !== before.hello) {
      say(this.folder, hello.runs_folder);
      // Another server may have other runs of these names.
      this.loaded.clear();
      this.answered = "";
    }
    if (!this.visible || hello === null) return;
    const came = before.view !== "runs" || hello !== before.hello;
    if (came) {
      void this.askForms();
      void this.refresh();
    }
    if (came || runs !== before.runs) void this.load(runs !== before.runs);
  }

  private get visible(): boolean {
    return this.app.state.view === "runs";
  }

  /** Asks for the forms, once. */
  private async askForms(): Promise<void> {
    if (this.hasForms || !this.app.connection.ready) return;
    try {
      const { forms, record } = await this.app.connection.ask<{ forms: Form[]; record: RecordParameter[] }>("runs.forms");
      if (this.hasForms) return;
      this.hasForms = true;
      this.form.take(forms);
      this.identify.take(record);
    } catch (error) {
      this.app.notify(words(error));
    }
  }

  private show(panel: Panel): void {
    for (const [name, element] of Object.entries(this.panels)) element.hidden = name !== panel;
  }

  // The list.

  private async refresh(): Promise<void> {
    if (!this.app.connection.ready || !this.visible) return;
    try {
      const { runs } = await this.app.connection.ask<{ runs: RunEntry[] }>("runs.list");
      const same = JSON.stringify(runs) === JSON.stringify(this.entries) && this.list.childElementCount > 0;
      this.entries = runs;
      if (same) return;
      this.drawList();
      this.drawFacts(this.shown);
    } catch (error) {
      this.app.notify(words(error));
    }
  }

  private drawList(): void {
    const rows = this.entries.map((entry) => {
      const facts = [entry.kind, entry.running ? "running" : entry.duration_s === null ? "" : duration(entry.duration_s), entry.size_bytes > 0 ? bytes(entry.size_bytes) : "", entry.verdict ?? ""];
      const text = el("span", { class: "run" }, el("b", {}, entry.name), el("small", {}, facts.filter((fact) => fact).join(" · ")));
      if (isQuestion(entry.kind)) {
        const attributes = { class: "row", "data-run": entry.name, "aria-current": this.app.state.runs.answer === entry.name };
        return el("li", {}, button(text, () => this.change({ answer: entry.name }), attributes));
      }
      const box = el("input", { type: "checkbox", "data-run": entry.name });
      box.checked = this.app.state.runs.open.includes(entry.name);
      box.addEventListener("change", () => this.toggle(entry.name, box.checked));
      return el("li", {}, el("label", {}, box, text));
    });
    if (rows.length === 0) rows.push(el("li", { class: "hint" }, document.documentElement.dataset.worker === undefined ? "No runs yet. Start one, or record in Feel." : "No runs yet. relax, creep and wall run here, in virtual time, and a record is identified; other runs and logs need host-cli serve."));
    // The focus stays on its run.
    const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset["run"] : undefined;
    this.list.replaceChildren(...rows);
    if (focused !== undefined) this.list.querySelector<HTMLElement>(`[data-run="${CSS.escape(focused)}"]`)?.focus();
  }

  private change(part: Partial<Shown>): void {
    this.app.dispatch({ do: "runs", part });
  }

  private toggle(name: string, wanted: boolean): void {
    const others = this.app.state.runs.open.filter((open) => open !== name);
    if (wanted && others.length >= OPEN_MOST) {
      this.app.notify(`${OPEN_MOST} runs are shown at most: take one away first.`);
      this.drawList();
      return;
    }
    this.change({ open: wanted ? [...others, name] : others, answer: "", span: null });
  }

  /** Asks for what is to be shown and is not there yet, and draws it; comes to the fore if it was `chosen`. */
  private async load(chosen = false): Promise<void> {
    const { open, answer } = this.app.state.runs;
    this.drawList();
    for (const name of this.loaded.keys()) if (!open.includes(name)) this.loaded.delete(name);
    const missing = open.filter((name) => !this.loaded.has(name) && !this.loading.has(name));
    await Promise.all(missing.map((name) => this.loadRun(name)));
    if (answer !== "") await this.loadAnswer(answer, chosen);
    else if (chosen) this.show("curves");
    this.drawOpen();
  }

  private async loadRun(name: string): Promise<void> {
    const asked = Symbol(name);
    this.loading.set(name, asked);
    try {
      const run = await this.app.connection.ask<OpenRun>("runs.open", { name });
      // A run that ended meanwhile is asked for anew, and this answer is of its middle.
      if (this.loading.get(name) === asked) this.loaded.set(name, run);
    } catch (error) {
      this.app.notify(words(error));
      this.change({ open: this.app.state.runs.open.filter((open) => open !== name) });
    } finally {
      if (this.loading.get(name) === asked) this.loading.delete(name);
    }
  }

  private async loadAnswer(name: string, chosen: boolean): Promise<void> {
    const anew = name !== this.answered;
    if (anew) {
      this.answered = name;
      try {
        this.answer.show(await this.app.connection.ask<Answer>("runs.open", { name }));
      } catch (error) {
        this.answered = "";
        this.app.notify(words(error));
        this.change({ answer: "" });
        return;
      }
    }
    if (anew || chosen) this.show("answer");
  }

  private drawOpen(): void {
    this.drawFacts(this.shown);
    this.panels.curves.classList.toggle("with-plane", this.overlay.show(this.shown));
  }

  /** The runs that are open, as far as they are loaded. */
  private get shown(): OpenRun[] {
    return this.app.state.runs.open.flatMap((name) => this.loaded.get(name) ?? []);
  }

  /** Runs the experiment of a proposal. */
  private async tryOut(kind: string, parameters: Values): Promise<void> {
    try {
      const { name } = await this.app.connection.ask<{ name: string }>("runs.start", { kind, parameters });
      this.started(name, kind);
    } catch (error) {
      this.app.notify(words(error));
    }
  }

  private drawFacts(runs: OpenRun[]): void {
    const parts: Node[] = [];
    for (const run of runs) {
      const rows: [string, string][] = [
        ["samples", `${run.samples} of ${number(run.sample_time_s * 1000)} ms`],
        ["log", run.running ? "goes on" : run.damage?.length ? [run.damage].flat().join("; ") : run.complete ? "whole" : "not closed: the run was cut off"],
        ...(run.missing_samples ? [["missing", String(run.missing_samples)] as [string, string]] : []),
        ...flat(run.metadata),
        ...(run.end ? [["end", [run.end.ended, run.end.reason].filter((text) => text !== "").join(": ")] as [string, string]] : []),
        ...run.events.slice(0, 50).map((event): [string, string] => [`${number(event.time_s)} s`, event.text || event.kind]),
      ];
      const verdict = this.entries.find(({ name }) => name === run.name)?.verdict;
      parts.push(el("h3", {}, run.name), ...(verdict ? [el("p", { class: "verdict" }, verdict)] : []), ...this.feelIt(run), el("dl", {}, ...rows.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)])));
    }
    if (parts.length === 0) parts.push(el("p", { class: "hint" }, "Choose runs on the left: several are drawn over each other. The file of device selftest --json is shown where it is dropped."));
    this.facts.replaceChildren(...parts);
  }

  /** The wall of a run can be felt. */
  private feelIt({ name, running, metadata }: OpenRun): Node[] {
    const { document } = (metadata["experiment"] ?? {}) as { document?: string };
    if (running || !document?.includes("[wall]")) return [];
    return [button("Feel its wall", () => this.app.dispatch({ do: "open", what: { run: name } }), { class: "small" })];
  }

  // Runs that go on.

  private started(name: string, kind: string): void {
    say(this.progress, `${name} goes on`);
    this.stop.hidden = false;
    void this.refresh();
    if (isQuestion(kind)) {
      this.change({ answer: name });
      return;
    }
    // With its first word it is drawn.
    this.awaited = name;
    this.change({ open: [], answer: "", span: null });
    this.show("curves");
  }

  private progressed(run: RunProgress): void {
    const share = run.samples > 0 ? Math.floor((100 * run.samples_done) / run.samples) : 0;
    const going = run.state === "running";
    const end = { running: "", done: "is done", failed: "failed", stopped: "was stopped" }[run.state];
    say(this.progress, going ? `${run.name}: ${share} %` : `${run.name} ${end}${run.verdict ? `: ${run.verdict}` : ""}${run.error ? `: ${run.error}` : ""}`);
    this.stop.hidden = !going;
    if (isQuestion(run.kind)) {
      this.questionProgressed(run, share);
      return;
    }
    if (going) {
      this.watch(run);
      return;
    }
    const awaited = this.awaited === run.name;
    [this.going, this.awaited] = [null, null];
    this.loaded.delete(run.name);
    this.loading.delete(run.name);
    void this.refresh().then(() => {
      const listed = this.entries.some(({ name }) => name === run.name);
      if (awaited && listed) this.toggle(run.name, true);
      else if (this.app.state.runs.open.includes(run.name)) void this.load();
    });
  }

  /** A question has no curves: how far it is, then its answer. */
  private questionProgressed(run: RunProgress, share: number): void {
    const mine = this.app.state.runs.answer === run.name;
    if (run.state === "running") {
      if (mine) this.answer.wait(run.name, share);
      return;
    }
    if (mine && run.report === undefined) this.answer.refuse(run.error ?? "it was stopped");
    void this.refresh().then(() => {
      if (!mine || run.report === undefined) return;
      this.answered = "";
      void this.load();
    });
  }

  /** Draws the run that goes on, a few times a second. */
  private watch(run: RunProgress): void {
    if (this.going?.name !== run.name) this.going = { name: run.name, drawn: 0 };
    const now = performance.now();
    if (!this.visible || now - this.going.drawn < WATCH_MS) return;
    this.going.drawn = now;
    if (this.awaited === run.name) {
      this.awaited = null;
      this.toggle(run.name, true);
    } else if (this.loaded.has(run.name)) this.overlay.refresh();
  }

  // Files.

  /** A file that fell on the page. */
  take(dropped: Dropped): void {
    if (dropped.is === "record") {
      this.show("identify");
      this.identify.read(dropped.file);
    } else if (dropped.is === "log") {
      void this.refresh();
      this.change({ open: [dropped.name], answer: "", span: null });
      this.show("curves");
    } else if (dropped.is === "experiment") {
      void this.askForms().then(() => {
        this.form.fill(dropped.kind, dropped.parameters);
        this.show("form");
      });
    } else if (dropped.is === "certificate") {
      // The answer that was there is asked for anew when it is chosen again.
      this.answered = "";
      this.answer.show(dropped.answer);
      this.show("answer");
    }
  }

  // The page.

  unasked(message: Unasked): void {
    if (message.run) this.progressed(message.run);
  }

  key(event: KeyboardEvent, down: boolean): boolean {
    return down && event.key === "Escape" && this.overlay.all();
  }
}

/** Keys and values of a report, one level down. */
function flat(values: Values): [string, string][] {
  return Object.entries(values).flatMap(([key, value]): [string, string][] => {
    if (value === null || value === undefined || value === "") return [];
    if (typeof value === "object" && !Array.isArray(value)) return flat(value as Values);
    return [[key, typeof value === "number" ? number(value, 4) : Array.isArray(value) ? value.join(", ") : String(value)]];
  });
}
