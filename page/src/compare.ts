// Compare: what is felt and a stiffer one, or another tissue, blind. The server draws which comes first, counts the answers and keeps the table.

import type { App } from "./app";
import { button, el, say, select, set } from "./dom";
import type { Compared, Hello } from "./protocol";
import { edited } from "./state";

/** Ends of the scales of ratings, and their names. */
const SCALES = [["", "no rating"], ["0 10", "from 0 to 10"], ["1 7", "from 1 to 7"], ["0 100", "from 0 to 100"]] as const;

export class Compare {
  readonly root: HTMLDetailsElement;
  private readonly subject = field("Subject, a code", { type: "text", value: "p00", maxlength: 32, spellcheck: "false", autocomplete: "off" });
  private readonly stiffer = field("B is stiffer by, %", { type: "number", value: 20, min: 1, max: 500, step: "any" });
  private readonly trials = field("Trials", { type: "number", value: 10, min: 1, max: 1000 });
  private readonly other = el("select", { "aria-label": "B is" });
  private readonly scale = select("Rate each", SCALES);
  private readonly rating = field("Rating", { type: "number", step: "any" });
  private readonly said = el("p", { class: "hint", role: "status" });
  private readonly before: HTMLElement;
  private readonly during: HTMLElement;
  private wasRated = false;
  private readonly next: HTMLButtonElement;
  private readonly rate: HTMLButtonElement;
  private readonly answers: HTMLButtonElement[];

  /** `begins` is called before the first trial. */
  constructor(private readonly app: App, begins: () => void) {
    const asks = (text: string, what: string, keys: object = {}) => button(text, () => void app.tell(`compare.${what}`, keys));
    const start = button("Begin", () => {
      begins();
      void this.start();
    });
    this.before = el("div", {}, el("div", { class: "knobs" }, this.subject.label, el("label", { class: "choice" }, "B is", this.other), this.stiffer.label, el("label", { class: "choice" }, "Rate each", this.scale), this.trials.label), el("div", { class: "buttons" }, start));
    this.next = asks("Next wall", "feel");
    this.answers = [1, 2].map((stiffer) => asks(`${stiffer} was stiffer`, "answer", { stiffer }));
    this.rate = button("Rate", () => void app.tell("compare.rate", { rating: this.rating.input.valueAsNumber }));
    this.other.addEventListener("change", () => (this.stiffer.label.hidden = this.other.value !== ""));
    this.during = el("div", { class: "buttons" }, this.rating.label, this.rate, this.next, ...this.answers, asks("End the comparison", "end"));
    this.root = el("details", { class: "device-numbers compare", "data-fold": "compare" }, el("summary", {}, "Compare two walls, blind"), this.before, this.said, this.during);
    this.show(null);
  }

  /** B may be any tissue that is known. */
  connected({ tissues }: Hello): void {
    const { value } = this.other;
    this.other.replaceChildren(el("option", { value: "" }, "A with more force"), ...tissues.map(({ name, title }) => el("option", { value: name }, title)));
    if (tissues.some(({ name }) => name === value)) this.other.value = value;
  }

  /** A is what is felt, B its whole force by so much larger, or another tissue. */
  private async start(): Promise<void> {
    const feel = edited(this.app.state);
    if (feel === null) return;
    const b = this.other.value === "" ? { scale: feel.scale * (1 + this.stiffer.input.valueAsNumber / 100) } : { environment: { tissue: this.other.value } };
    const scale = this.scale.value === "" ? {} : { rating_scale: this.scale.value.split(" ").map(Number) };
    const [seed] = crypto.getRandomValues(new Uint32Array(1));
    await this.app.tell("compare.start", { b, trials: this.trials.input.valueAsNumber, subject: this.subject.input.value.trim(), seed, ...scale });
  }

  show(compared: Compared | null): void {
    const runs = compared?.running ?? false;
    if (runs) this.root.open = true;
    [this.before.hidden, this.during.hidden] = [runs, !runs];
    const [rated, asked] = [compared !== null && isRated(compared), compared !== null && isAsked(compared)];
    this.rating.label.hidden = this.rate.hidden = !rated;
    if (this.wasRated && !rated) this.rating.input.value = "";
    this.wasRated = rated;
    const [least, most] = compared?.rating_scale ?? ["", ""];
    set(this.rating.input, { min: least, max: most });
    this.next.hidden = rated || asked;
    for (const answer of this.answers) answer.hidden = !asked;
    say(this.said, compared === null ? "" : sentence(compared));
  }
}

function field(name: string, attributes: Record<string, string | number>): { label: HTMLElement; input: HTMLInputElement } {
  const input = el("input", attributes);
  return { label: el("label", { class: "choice" }, name, input), input };
}

/** The newest wall was touched, and its rating is asked for. */
export function isRated({ rating_scale: scale, wall, touched, rated }: Compared): boolean {
  return scale !== null && touched && rated < wall;
}

/** Both walls were touched, and rated where that is asked: only now there is an answer. */
export function isAsked(compared: Compared): boolean {
  return compared.wall === 2 && compared.touched && !isRated(compared);
}

/** What a person does next, or how it ended. */
export function sentence(compared: Compared): string {
  const { running, trial, trials, wall, touched, rating_scale: scale, right, table } = compared;
  if (!running) {
    const answers = right === null ? `${trial} answers, of which none is right or wrong: each wall is the stiffer one at some speeds` : `${right} of ${trial} answers were right`;
    return `${answers}; the table is ${table}, in the folder of the runs.`;
  }
  if (isRated(compared)) return `Trial ${trial + 1} of ${trials}: rate wall ${wall}, from ${scale?.join(" to ")}`;
  const next = wall === 0 ? "ask for wall 1, and press it" : !touched ? `press wall ${wall}` : wall === 1 ? "come out, ask for wall 2, and press it" : "come out: which was stiffer?";
  return `Trial ${trial + 1} of ${trials}: ${next}`;
}
