// Compare: what is felt and a stiffer one, blind. The server draws which comes first, counts the answers and keeps the table.

import type { App } from "./app";
import { el, say } from "./dom";
import type { Compared } from "./protocol";
import { edited } from "./state";

export class Compare {
  readonly root: HTMLDetailsElement;
  private readonly subject = field("Subject, a code", { type: "text", value: "p00", maxlength: 32, spellcheck: "false", autocomplete: "off" });
  private readonly stiffer = field("B is stiffer by, %", { type: "number", value: 20, min: 1, max: 500, step: "any" });
  private readonly trials = field("Trials", { type: "number", value: 10, min: 1, max: 1000 });
  private readonly said = el("p", { class: "hint", role: "status" });
  private readonly before: HTMLElement;
  private readonly during: HTMLElement;
  private readonly next: HTMLButtonElement;
  private readonly answers: HTMLButtonElement[];

  /** `begins` is called before the first trial. */
  constructor(private readonly app: App, begins: () => void) {
    const button = (text: string, act: () => void): HTMLButtonElement => {
      const made = el("button", { type: "button" }, text);
      made.addEventListener("click", act);
      return made;
    };
    const asks = (text: string, what: string, keys: object = {}): HTMLButtonElement => button(text, () => void app.tell(`compare.${what}`, keys));
    const start = button("Begin", () => {
      begins();
      void this.start();
    });
    this.before = el("div", {}, el("div", { class: "knobs" }, ...[this.subject, this.stiffer, this.trials].map(({ label }) => label)), el("div", { class: "buttons" }, start));
    this.next = asks("Next wall", "feel");
    this.answers = [1, 2].map((stiffer) => asks(`${stiffer} was stiffer`, "answer", { stiffer }));
    this.during = el("div", { class: "buttons" }, this.next, ...this.answers, asks("End the comparison", "end"));
    this.root = el("details", { class: "device-numbers compare" }, el("summary", {}, "Compare two walls, blind"), this.before, this.said, this.during);
    this.show(null);
  }

  /** A is what is felt, B its whole force by so much larger. */
  private async start(): Promise<void> {
    const feel = edited(this.app.state);
    if (feel === null) return;
    const b = { scale: feel.scale * (1 + this.stiffer.input.valueAsNumber / 100) };
    const [seed] = crypto.getRandomValues(new Uint32Array(1));
    await this.app.tell("compare.start", { b, trials: this.trials.input.valueAsNumber, subject: this.subject.input.value.trim(), seed });
  }

  show(compared: Compared | null): void {
    const runs = compared?.running ?? false;
    if (runs) this.root.open = true;
    [this.before.hidden, this.during.hidden] = [runs, !runs];
    const asked = compared !== null && isAsked(compared);
    this.next.hidden = asked;
    for (const answer of this.answers) answer.hidden = !asked;
    say(this.said, compared === null ? "" : sentence(compared));
  }
}

function field(name: string, attributes: Record<string, string | number>): { label: HTMLElement; input: HTMLInputElement } {
  const input = el("input", attributes);
  return { label: el("label", { class: "choice" }, name, input), input };
}

/** Both walls were touched: only now there is an answer. */
export function isAsked({ wall, touched }: Compared): boolean {
  return wall === 2 && touched;
}

/** What a person does next, or how it ended. */
export function sentence({ running, trial, trials, wall, touched, right, table }: Compared): string {
  if (!running) return `${right ?? 0} of ${trial} answers were right; the table is ${table}, in the folder of the runs.`;
  const next = wall === 0 ? "ask for wall 1, and press it" : !touched ? `press wall ${wall}` : wall === 1 ? "come out, ask for wall 2, and press it" : "come out: which was stiffer?";
  return `Trial ${trial + 1} of ${trials}: ${next}`;
}
