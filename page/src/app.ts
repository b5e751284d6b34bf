// What the views share.

import type { Analysis } from "./analysis";
import type { Connection } from "./connection";
import type { Frame } from "./frame";
import type { View } from "./fragment";
import type { Environment, Hello, RunProgress, Status, Unasked } from "./protocol";

export interface App {
  readonly connection: Connection;
  readonly analysis: Analysis;
  /** Of the last connection. */
  hello: Hello | null;
  status: Status | null;
  /** A sentence for the person. */
  notify(text: string): void;
  /** Asks, and says so if it is refused. */
  tell(what: string, keys?: object): Promise<void>;
  go(view: View): void;
  /** Values of a view in the address. */
  remember(view: View, values: Map<string, string>): void;
  /** Puts a wall into the loop and shows it. */
  feelWall(environment: Environment, device: { mass_kg: number; damping_n_s_per_m: number }): void;
}

/** One of the three views. */
export interface ViewPart {
  readonly root: HTMLElement;
  /** It is shown, with the values of the address. */
  shown(values: Map<string, string>): void;
  hidden(): void;
  connected(hello: Hello): void;
  unasked(message: Unasked): void;
  frame(frame: Frame): void;
  /** Colours have changed. */
  themed(): void;
  /** A key that is no command of the whole page; true if it meant something. */
  key(event: KeyboardEvent, down: boolean): boolean;
}

export type { RunProgress };
