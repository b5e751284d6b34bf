// What is there in every view: head, stop, notices, foot, help.

import { recolour } from "./chart";
import { button, el, say } from "./dom";
import { number, plain, steady } from "./format";
import { VIEWS, type View } from "./fragment";
import type { Hello, Status } from "./protocol";

export const KEYS: [string, string][] = [
  ["space", "stops: the force goes to zero, wherever the focus is but in a text field"],
  ["Enter", "presses a button, ticks a box"],
  ["R", "starts again after a stop or fault"],
  ["← →", "moves the probe; with shift slowly"],
  ["Home", "takes the probe out and lets go"],
  ["P", "pauses and goes on"],
  ["M", "sets a marker"],
  ["L", "records, or ends the recording"],
  ["Esc", "shows what is now, after a zoom; in a text field gives up the edit"],
  ["1 2 3 4", "Feel, Design, Runs, Control"],
  ["T", "light, dark, as the system"],
  ["?", "this list"],
];

const NAMES: Record<View, string> = { feel: "Feel", design: "Design", runs: "Runs", control: "Control" };

/** A sample rate. */
function rate(hertz: number): string {
  return hertz >= 1000 ? `${plain(hertz / 1000)} kHz` : `${plain(hertz)} Hz`;
}

export interface ShellOptions {
  go: (view: View) => void;
  stop: () => void;
  start: () => void;
  takeControls: () => void;
  record: () => void;
  /** Puts the address of what is shown into the clipboard, and says so. */
  link: () => Promise<string>;
}

export class Shell {
  readonly main = el("main", { id: "main" });
  private readonly tabs = new Map<View, HTMLAnchorElement>();
  private readonly device = el("span", { class: "device" });
  private readonly waits = el("span", { class: "waits", role: "status" });
  private readonly start = el("button", { type: "button", class: "start", "aria-keyshortcuts": "R", hidden: true }, "Start", el("kbd", { "aria-hidden": "true" }, "R"));
  private readonly banner = el("div", { class: "banner", role: "status", hidden: true });
  private readonly notices = el("div", { class: "notices", role: "status", "aria-live": "polite" });
  private readonly foot = {
    tick: el("b"),
    period: el("span"),
    late: el("b"),
    lost: el("b"),
    limiter: el("b"),
    energy: el("b"),
  };
  private readonly record = el("button", { class: "record", type: "button" });
  private readonly watching = el("span");
  private readonly help = el("dialog", { class: "help", "aria-label": "Keys" });
  private hello: Hello | null = null;

  constructor(private readonly options: ShellOptions) {
    this.head();
    document.body.append(this.banner, this.main);
    this.footer();
    this.helpDialog();
    document.body.append(this.notices, this.help);
    this.theme(localStorage.getItem("theme"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.theme(localStorage.getItem("theme")));
  }

  /** Marks the view that is shown. */
  show(view: View): void {
    for (const [name, tab] of this.tabs) {
      if (name === view) tab.setAttribute("aria-current", "page");
      else tab.removeAttribute("aria-current");
    }
    document.title = `${NAMES[view]} · fractional-haptics`;
    document.body.dataset["view"] = view;
  }

  connected(hello: Hello): void {
    this.hello = hello;
    this.say("");
  }

  lost(reason: string): void {
    this.device.className = "device lost";
    say(this.device, "no connection");
    const said = reason ? `${reason[0]?.toUpperCase()}${reason.slice(1)}. ` : "The server does not answer. ";
    const remedy = "This page tries again by itself. If host-cli serve was started anew, open the address that it printed.";
    this.say(document.documentElement.dataset.worker === undefined ? said + remedy : said);
  }

  status(status: Status): void {
    const period = status.sample_time_s ?? this.hello?.sample_time_s ?? NaN;
    say(this.foot.period, ` of ${number(period * 1e6)}`);
    const hertz = Number((1 / period).toPrecision(6));
    const state = status.fault ? "fault" : status.stopped ? "stopped" : status.paused ? "paused" : status.running ? "running" : "idle";
    this.device.className = `device ${state}`;
    say(this.device, `simulated device · ${state === "running" ? rate(hertz) : state}`);
    say(this.foot.tick, `${number(status.tick_p50_us ?? null)} µs`);
    say(this.foot.late, String(status.late ?? 0));
    say(this.foot.lost, String((status.lost ?? 0) + status.samples_missed));
    // Both would tell walls apart that are compared.
    const blind = status.compare?.running ?? false;
    say(this.foot.limiter, blind ? "–" : this.limiters(status.limiter ?? 0));
    say(this.foot.energy, steady(typeof status.energy_j === "number" && !blind ? 1000 * status.energy_j : null, 2, "mJ"));
    say(this.record, status.recording ? `● recording ${status.recording}` : "○ record");
    this.record.classList.toggle("on", Boolean(status.recording));
    this.record.disabled = !status.controls || !status.running;
    say(this.watching, status.watching > 0 ? `${status.watching} ${status.watching === 1 ? "page watches" : "pages watch"}` : "");
    this.start.hidden = !status.controls || !(status.stopped || status.fault);
    if (status.fault) this.say(`Fault: ${status.fault}. Start, or the key R, begins again.`);
    else if (!status.controls) this.say("Another page holds the controls; this one watches.", this.options.takeControls, "Take the controls");
    else if (status.stopped) this.say("Stopped: the force is zero. Start, or the key R, begins again.");
    else this.say("");
  }

  private limiters(bits: number): string {
    const names = this.hello?.limiters.filter((_, bit) => (bits >> bit) & 1) ?? [];
    return names.length > 0 ? names.join(", ") : "none";
  }

  /** Says that an answer is awaited, once that takes longer than a look. */
  awaits(ms: number): void {
    say(this.waits, ms > 400 ? "waiting for an answer …" : "");
  }

  /** A sentence under the head that stays; empty for none. */
  say(text: string, act?: () => void, label = ""): void {
    if (this.banner.dataset["said"] === text + label) return;
    this.banner.dataset["said"] = text + label;
    this.banner.hidden = text === "";
    this.banner.replaceChildren(text);
    if (!act) return;
    this.banner.append(button(label, act, { class: "small" }));
  }

  /** A sentence that goes away. */
  notify(text: string): void {
    if (this.notices.lastElementChild?.firstChild?.textContent === text) return;
    const notice = el("div", { class: "notice" }, el("span", {}, text), button("×", () => notice.remove(), { class: "close", "aria-label": "Dismiss" }));
    this.notices.append(notice);
    while (this.notices.childElementCount > 3) this.notices.firstElementChild?.remove();
    setTimeout(() => notice.remove(), 12_000);
  }

  toggleHelp(): void {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }

  /** Light, dark, as the system, in turn. */
  nextTheme(): void {
    const now = localStorage.getItem("theme");
    const next = now === null ? "light" : now === "light" ? "dark" : null;
    if (next === null) localStorage.removeItem("theme");
    else localStorage.setItem("theme", next);
    this.theme(next);
    this.notify(`Colours: ${next ?? "as the system"}`);
  }

  private theme(chosen: string | null): void {
    const dark = chosen === null ? matchMedia("(prefers-color-scheme: dark)").matches : chosen === "dark";
    document.documentElement.dataset["theme"] = dark ? "dark" : "light";
    recolour();
  }

  private head(): void {
    const stop = el("button", { type: "button", class: "stop", "aria-keyshortcuts": "Space" }, "Stop", el("kbd", { "aria-hidden": "true" }, "␣"));
    stop.addEventListener("click", this.options.stop);
    this.start.addEventListener("click", this.options.start);
    const nav = el("nav", { "aria-label": "Views" });
    for (const view of VIEWS) {
      const tab = el("a", { href: `#${view}` }, NAMES[view]);
      tab.addEventListener("click", (event) => {
        event.preventDefault();
        this.options.go(view);
      });
      this.tabs.set(view, tab);
      nav.append(tab);
    }
    document.body.append(el("header", {}, el("h1", {}, "fractional‑haptics"), nav, this.waits, this.device, this.start, stop));
  }

  private footer(): void {
    const { tick, period, late, lost, limiter, energy } = this.foot;
    this.record.addEventListener("click", this.options.record);
    const link = button("copy link", () => void this.options.link().then((said) => this.notify(said)), { class: "keys", title: "The address of what is shown here" });
    document.body.append(
      el(
        "footer",
        {},
        el("span", {}, "tick ", tick, period),
        el("span", {}, "late ", late),
        el("span", {}, "lost ", lost),
        el("span", {}, "limiter ", limiter),
        el("span", {}, "energy given back ", energy),
        this.record,
        this.watching,
        link,
        button("space stops · P pauses · M marks · ? keys", () => this.toggleHelp()),
      ),
    );
  }

  private helpDialog(): void {
    const list = el("dl");
    for (const [key, what] of KEYS) list.append(el("dt", {}, el("kbd", {}, key)), el("dd", {}, what));
    this.help.append(el("h2", {}, "Keys"), list, button("Close", () => this.help.close()));
  }
}
