// Start: the shell, the three views, the socket, the keys.

import { Analysis } from "./analysis";
import type { App, ViewPart } from "./app";
import { Connection } from "./connection";
import { DesignView } from "./design";
import { typing } from "./dom";
import { FeelView } from "./feel";
import { readFragment, VIEWS, writeFragment, type View } from "./fragment";
import type { Environment, Hello, Status } from "./protocol";
import { RunsView } from "./runs";
import { Shell } from "./shell";

/** The force is zero a tenth of a second after a stop. */
const ARM_AGAIN_MS = 400;
const ARM_ATTEMPTS = 4;

class Page implements App {
  readonly analysis = new Analysis();
  readonly connection: Connection;
  hello: Hello | null = null;
  status: Status | null = null;
  private readonly shell: Shell;
  private readonly views: Record<View, ViewPart>;
  private readonly feel: FeelView;
  /** What each view had in the address. */
  private readonly remembered = new Map<View, Map<string, string>>();
  private view: View = "feel";

  constructor() {
    this.shell = new Shell({
      go: (view) => this.go(view),
      stop: () => this.stop(),
      takeControls: () => void this.tell("controls.take", { force: true }),
      record: () => void this.tell("feel.record", { on: !this.status?.recording }),
      themed: () => Object.values(this.views ?? {}).forEach((view: ViewPart) => view.themed()),
    });
    this.connection = new Connection({
      open: (hello) => this.connected(hello),
      lost: (reason) => this.shell.lost(reason),
      unasked: (message) => {
        if (message.status) {
          this.status = message.status;
          this.shell.status(message.status);
        }
        if (message.notice) this.shell.notify(message.notice);
        for (const view of VIEWS) this.views[view].unasked(message);
      },
      frame: (frame) => this.views[this.view].frame(frame),
    });
    // It answers after all of this was made; the sooner it is asked, the sooner there is a tissue.
    this.connection.start();
    this.feel = new FeelView(this);
    this.views = { feel: this.feel, design: new DesignView(this), runs: new RunsView(this) };
    for (const view of VIEWS) this.shell.main.append(this.views[view].root);
    this.listen();
    this.fromAddress();
  }

  private connected(hello: Hello): void {
    this.hello = hello;
    this.shell.connected(hello);
    for (const view of VIEWS) this.views[view].connected(hello);
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

  stop(): void {
    void this.tell("stop");
  }

  /** Starts again. While the force still falls to zero the loop does not listen, so it is asked again. */
  private async arm(): Promise<void> {
    for (let attempt = 0; attempt < ARM_ATTEMPTS; attempt += 1) {
      await this.tell("arm");
      await new Promise((resolve) => setTimeout(resolve, ARM_AGAIN_MS));
      if (!this.status?.stopped) return;
    }
  }

  go(view: View): void {
    history.pushState(null, "", writeFragment({ view, values: this.remembered.get(view) ?? new Map() }));
    this.fromAddress();
  }

  remember(view: View, values: Map<string, string>): void {
    this.remembered.set(view, values);
    if (view === this.view) history.replaceState(null, "", writeFragment({ view, values }));
  }

  feelWall(environment: Environment, device: { mass_kg: number; damping_n_s_per_m: number }): void {
    this.feel.startWall(environment, device);
    this.go("feel");
  }

  private fromAddress(): void {
    const { view, values } = readFragment(location.hash);
    for (const name of VIEWS) {
      this.views[name].root.hidden = name !== view;
      if (name !== view && name === this.view) this.views[name].hidden();
    }
    this.view = view;
    this.shell.show(view);
    this.views[view].shown(values);
  }

  private listen(): void {
    addEventListener("popstate", () => this.fromAddress());
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("keyup", (event) => {
      if (!typing(event.target)) this.views[this.view].key(event, false);
    });
    // A key that goes up elsewhere does not push on.
    addEventListener("blur", () => {
      for (const key of ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]) this.views[this.view].key(new KeyboardEvent("keyup", { key }), false);
    });
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    const command: Record<string, () => void> = {
      " ": () => this.stop(),
      "?": () => this.shell.toggleHelp(),
      "1": () => this.go("feel"),
      "2": () => this.go("design"),
      "3": () => this.go("runs"),
      t: () => this.shell.nextTheme(),
      r: () => void this.arm(),
      l: () => void this.tell("feel.record", { on: !this.status?.recording }),
    };
    const act = command[event.key] ?? command[event.key.toLowerCase()];
    if (act) {
      event.preventDefault();
      if (!event.repeat) act();
    } else if (this.views[this.view].key(event, true)) event.preventDefault();
  }
}

new Page();
