// What is on the screen: the shell, the views, the keys.

import type { App, ViewPart } from "./app";
import { ControlView } from "./control";
import { DesignView } from "./design";
import { isTextField, words } from "./dom";
import { listenForFiles, look } from "./drop";
import { FeelView } from "./feel";
import type { View } from "./fragment";
import type { Unasked } from "./protocol";
import { RunsView } from "./runs";
import { Shell } from "./shell";
import { address, START, type State } from "./state";

/** The force is zero a tenth of a second after a stop. */
const ARM_AGAIN_MS = 400;
const ARM_ATTEMPTS = 4;
/** Time between two looks at what is awaited, ms. */
const LOOK_MS = 200;

/** The folds of the views that were shown. */
const folds = () => [...document.querySelectorAll<HTMLDetailsElement>("details[data-fold]")];

export class Screen {
  private readonly shell: Shell;
  /** Those that were shown: no other holds up the first. */
  private readonly views = new Map<View, ViewPart>();
  /** Stops and starts that were asked for. */
  private arming = 0;
  /** What a text field held when it was entered. */
  private entered = "";

  constructor(private readonly app: App) {
    this.shell = new Shell({
      go: (view) => this.go(view),
      stop: () => this.stop(),
      start: () => void this.arm(),
      takeControls: () => void app.tell("controls.take", { force: true }),
      record: () => this.record(),
      link: () => this.link(),
    });
    setInterval(() => this.shell.awaits(app.connection.waits), LOOK_MS);
    this.listen();
  }

  render(state: State, before: State): void {
    const { view, hello, lost, status } = state;
    if (hello !== null && hello !== before.hello) this.shell.connected(hello);
    if (lost !== null && lost !== before.lost) this.shell.lost(lost);
    const made = this.views.has(view) ? undefined : this.make(view);
    for (const [name, { root }] of this.views) root.hidden = name !== view;
    this.shell.show(view);
    if (made !== undefined || state.folds !== before.folds) for (const fold of folds()) fold.open = state.folds.includes(fold.dataset["fold"] ?? "");
    if (status !== null && status !== before.status) this.shell.status(status);
    for (const part of this.views.values()) part.render(state, part === made ? START : before);
  }

  private make(name: View): ViewPart {
    const makes: Record<View, () => ViewPart> = {
      feel: () => new FeelView(this.app),
      design: () => new DesignView(this.app),
      runs: () => new RunsView(this.app),
      control: () => new ControlView(this.app),
    };
    const part = makes[name]();
    this.views.set(name, part);
    this.shell.main.append(part.root);
    return part;
  }

  /** Marks and runs. */
  unasked(message: Unasked): void {
    for (const view of this.views.values()) view.unasked?.(message);
  }

  notify(text: string): void {
    this.shell.notify(text);
  }

  /** Says why the loop does not do what was asked: beside the field, if that is shown. */
  refused(why: string): void {
    if (!this.views.get(this.app.state.view)?.besideField?.(why)) this.notify(why);
  }

  private stop(): void {
    this.arming += 1;
    void this.app.tell("stop");
  }

  /** The state of the page is in its address: whoever opens it sees the same. */
  private async link(): Promise<string> {
    const link = location.href.replace(/#.*/, "") + address(this.app.state);
    try {
      await navigator.clipboard.writeText(link);
      return "The address is in the clipboard.";
    } catch {
      return link;
    }
  }

  private record(): void {
    void this.app.tell("feel.record", { on: !this.app.state.status?.recording });
  }

  /** Starts again. While the force still falls to zero the loop does not listen, so it is asked again, unless it is to stop. */
  private async arm(): Promise<void> {
    const arming = ++this.arming;
    for (let attempt = 0; attempt < ARM_ATTEMPTS; attempt += 1) {
      await this.app.tell("arm");
      await new Promise((resolve) => setTimeout(resolve, ARM_AGAIN_MS));
      if (arming !== this.arming || !this.app.state.status?.stopped) return;
    }
  }

  private go(view: View): void {
    // What was shown is one step back.
    const { state } = this.app;
    history.replaceState(null, "", address(state));
    history.pushState(null, "", address({ ...state, view }));
    this.app.dispatch({ do: "go", view });
  }

  /** Gives a file to the view that it is for. */
  async take(file: File): Promise<void> {
    try {
      const found = await look(this.app, file);
      if (found === null) return;
      if (found.view !== this.app.state.view) this.go(found.view);
      this.views.get(found.view)?.take?.(found.dropped);
    } catch (error) {
      this.notify(words(error));
    }
  }

  /** What is folded out is kept in the address. */
  private toggled(): void {
    const all = folds();
    const others = this.app.state.folds.filter((name) => all.every((fold) => fold.dataset["fold"] !== name));
    const open = [...others, ...all.flatMap((fold) => (fold.open ? (fold.dataset["fold"] ?? []) : []))];
    if (open.join() !== this.app.state.folds.join()) this.app.dispatch({ do: "folds", open });
  }

  private listen(): void {
    // A toggle does not bubble.
    document.addEventListener("toggle", () => this.toggled(), true);
    listenForFiles((file) => void this.take(file));
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("keyup", (event) => {
      if (isTextField(event.target)) return;
      // A button is pressed when the key goes up.
      if (event.key === " ") event.preventDefault();
      this.views.get(this.app.state.view)?.key?.(event, false);
    });
    addEventListener("focusin", ({ target }) => {
      if (isTextField(target)) this.entered = target.value;
    });
    // A key that goes up elsewhere does not push on.
    addEventListener("blur", () => {
      for (const key of ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]) this.views.get(this.app.state.view)?.key?.(new KeyboardEvent("keyup", { key }), false);
    });
  }

  private key(event: KeyboardEvent): void {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (isTextField(target)) {
      if (event.key === "Escape") {
        target.value = this.entered;
        target.blur();
      }
      return;
    }
    // A list finds its lines by their letters.
    if (target instanceof HTMLSelectElement && event.key !== " ") return;
    if (target instanceof HTMLInputElement && target.type === "checkbox" && event.key === "Enter") {
      event.preventDefault();
      target.click();
      return;
    }
    const command: Record<string, () => void> = {
      " ": () => this.stop(),
      "?": () => this.shell.toggleHelp(),
      "1": () => this.go("feel"),
      "2": () => this.go("design"),
      "3": () => this.go("runs"),
      "4": () => this.go("control"),
      t: () => this.shell.nextTheme(),
      r: () => void this.arm(),
      l: () => this.record(),
    };
    const act = command[event.key] ?? command[event.key.toLowerCase()];
    if (act) {
      event.preventDefault();
      if (!event.repeat) act();
    } else if (this.views.get(this.app.state.view)?.key?.(event, true)) event.preventDefault();
  }
}
