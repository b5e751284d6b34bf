// Start: the shell, the views, the socket, the keys; and the one place that changes the state.

import { Analysis } from "./analysis";
import type { App, ViewPart } from "./app";
import { Connection } from "./connection";
import { ControlView } from "./control";
import { DesignView } from "./design";
import { isTextField } from "./dom";
import { FeelView } from "./feel";
import type { View } from "./fragment";
import type { Feel } from "./protocol";
import { RunsView } from "./runs";
import { Shell } from "./shell";
import { address, outgoing, reduce, START, type PageEvent, type State } from "./state";

/** The force is zero a tenth of a second after a stop. */
const ARM_AGAIN_MS = 400;
const ARM_ATTEMPTS = 4;
/** Time between two changes of the address: browsers refuse many. */
const ADDRESS_MS = 200;

class Page implements App {
  readonly analysis = new Analysis();
  readonly connection: Connection;
  state: State = START;
  private readonly shell: Shell;
  /** Feel, and those that were shown: none of the others holds up the first tissue. */
  private readonly views = new Map<View, ViewPart>();
  private addressed = 0;
  /** Stops and starts that were asked for. */
  private arming = 0;
  /** What a text field held when it was entered. */
  private entered = "";

  constructor() {
    this.shell = new Shell({
      go: (view) => this.go(view),
      stop: () => this.stop(),
      start: () => void this.arm(),
      takeControls: () => void this.tell("controls.take", { force: true }),
      record: () => this.record(),
      themed: () => this.views.forEach((view) => view.themed()),
    });
    this.connection = new Connection({
      open: (hello) => {
        this.shell.connected(hello);
        this.dispatch({ do: "hello", hello });
      },
      lost: (reason) => {
        this.shell.lost(reason);
        this.dispatch({ do: "lost" });
      },
      unasked: (message) => {
        if (message.notice) this.notify(message.notice);
        if (message.status) this.dispatch({ do: "status", status: message.status });
        if (message.feel) this.dispatch({ do: "felt", feel: message.feel });
        for (const view of this.views.values()) view.unasked(message);
      },
    });
    // It answers after all of this was made; the sooner it is asked, the sooner there is a tissue.
    this.connection.start();
    this.make("feel");
    this.listen();
    this.dispatch({ do: "address", fragment: location.hash });
  }

  dispatch(event: PageEvent): void {
    const before = this.state;
    this.state = reduce(before, event);
    if (this.state === before) return;
    const { view, status } = this.state;
    const made = this.views.has(view) ? undefined : this.make(view);
    for (const [name, { root }] of this.views) root.hidden = name !== view;
    this.shell.show(view);
    if (status !== null && status !== before.status) this.shell.status(status);
    for (const part of this.views.values()) part.render(this.state, part === made ? START : before);
    this.write();
    this.send();
  }

  private make(name: View): ViewPart {
    const makes: Record<View, () => ViewPart> = {
      feel: () => new FeelView(this),
      design: () => new DesignView(this),
      runs: () => new RunsView(this),
      control: () => new ControlView(this),
    };
    const part = makes[name]();
    this.views.set(name, part);
    this.shell.main.append(part.root);
    return part;
  }

  /** Asks for what the state wants of the loop. */
  private send(): void {
    const next = outgoing(this.state);
    if (next === null) return;
    this.dispatch({ do: "sent" });
    this.connection.ask<{ feel: Feel }>(next.do, next.keys).then(
      ({ feel }) => this.dispatch({ do: "felt", feel, answers: true }),
      (error: Error) => {
        if (this.state.hello !== null) this.notify(error.message);
        this.dispatch({ do: "refused" });
      },
    );
  }

  private write(): void {
    if (this.addressed !== 0) return;
    this.addressed = window.setTimeout(() => {
      this.addressed = 0;
      const now = address(this.state);
      if (now !== location.hash) history.replaceState(null, "", now);
    }, ADDRESS_MS);
  }

  notify(text: string): void {
    this.shell.notify(text);
  }

  async tell(what: string, keys: object = {}): Promise<void> {
    try {
      await this.connection.ask(what, keys);
    } catch (error) {
      this.notify(error instanceof Error ? error.message : String(error));
    }
  }

  private stop(): void {
    this.arming += 1;
    void this.tell("stop");
  }

  private record(): void {
    void this.tell("feel.record", { on: !this.state.status?.recording });
  }

  /** Starts again. While the force still falls to zero the loop does not listen, so it is asked again, unless it is to stop. */
  private async arm(): Promise<void> {
    const arming = ++this.arming;
    for (let attempt = 0; attempt < ARM_ATTEMPTS; attempt += 1) {
      await this.tell("arm");
      await new Promise((resolve) => setTimeout(resolve, ARM_AGAIN_MS));
      if (arming !== this.arming || !this.state.status?.stopped) return;
    }
  }

  private go(view: View): void {
    // What was shown is one step back.
    history.replaceState(null, "", address(this.state));
    history.pushState(null, "", address({ ...this.state, view }));
    this.dispatch({ do: "go", view });
  }

  private listen(): void {
    addEventListener("popstate", () => this.dispatch({ do: "address", fragment: location.hash }));
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("keyup", (event) => {
      if (isTextField(event.target)) return;
      // A button is pressed when the key goes up.
      if (event.key === " ") event.preventDefault();
      this.views.get(this.state.view)?.key(event, false);
    });
    addEventListener("focusin", ({ target }) => {
      if (isTextField(target)) this.entered = target.value;
    });
    // A key that goes up elsewhere does not push on.
    addEventListener("blur", () => {
      for (const key of ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]) this.views.get(this.state.view)?.key(new KeyboardEvent("keyup", { key }), false);
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
    } else if (this.views.get(this.state.view)?.key(event, true)) event.preventDefault();
  }
}

new Page();
