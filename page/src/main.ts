// Start: the socket, then the screen; and the one place that changes the state.

import type { App } from "./app";
import { Connection } from "./connection";
import { words } from "./dom";
import type { Feel } from "./protocol";
import { Screen } from "./screen";
import { bySocket, byWorkers } from "./transport";
import { address, outgoing, reduce, START, type PageEvent, type State } from "./state";

/** Time between two changes of the address: browsers refuse many. */
const ADDRESS_MS = 200;

/** The file of the server, where it comes with the page. */
const worker = document.documentElement.dataset.worker;

class Page implements App {
  readonly connection: Connection;
  state: State = START;
  private screen: Screen | null = null;
  private addressed = 0;

  constructor() {
    this.connection = new Connection({
      open: (hello) => this.dispatch({ do: "hello", hello }),
      lost: (reason) => this.dispatch({ do: "lost", reason }),
      unasked: (message) => {
        if (message.notice) this.notify(message.notice);
        if (message.status) this.dispatch({ do: "status", status: message.status });
        if (message.feel) this.dispatch({ do: "felt", feel: message.feel });
        this.screen?.unasked(message);
      },
    }, worker === undefined ? bySocket : byWorkers(worker));
    this.connection.start();
    this.dispatch({ do: "address", fragment: location.hash });
    void this.show();
    addEventListener("popstate", () => this.dispatch({ do: "address", fragment: location.hash }));
  }

  dispatch(event: PageEvent): void {
    const before = this.state;
    this.state = reduce(before, event);
    if (this.state === before) return;
    this.screen?.render(this.state, before);
    this.write();
    this.send();
  }

  /** Makes the screen in pieces: what the socket says comes in between, so that the server starts the loop meanwhile. */
  private async show(): Promise<void> {
    const others = () => new Promise((resolve) => setTimeout(resolve));
    await others();
    const screen = new Screen(this);
    await others();
    this.screen = screen;
    screen.render(this.state, START);
  }

  /** Asks for what the state wants of the loop. */
  private send(): void {
    const next = outgoing(this.state);
    if (next === null) return;
    this.dispatch({ do: "sent" });
    this.connection.ask<{ feel: Feel }>(next.do, next.keys).then(
      ({ feel }) => this.dispatch({ do: "felt", feel, answers: true }),
      (error: Error) => {
        this.dispatch({ do: "refused" });
        if (this.state.hello !== null) this.screen?.refused(error.message);
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
    this.screen?.notify(text);
  }

  async given(file: File): Promise<void> {
    await this.screen?.take(file);
  }

  async tell(what: string, keys: object = {}): Promise<void> {
    try {
      await this.connection.ask(what, keys);
    } catch (error) {
      this.notify(words(error));
    }
  }
}

new Page();
