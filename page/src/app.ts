// What the views share.

import type { Connection } from "./connection";
import type { Answer, Unasked, Values } from "./protocol";
import type { PageEvent, State } from "./state";

export interface App {
  readonly connection: Connection;
  readonly state: State;
  /** All that changes the state. */
  dispatch(event: PageEvent): void;
  /** A sentence for the person. */
  notify(text: string): void;
  /** A file was dropped or chosen: the view that it is for takes it. */
  given(file: File): Promise<void>;
  /** Asks, and says so if it is refused. */
  tell(what: string, keys?: object): Promise<void>;
}

/** One of the views. */
export interface ViewPart {
  readonly root: HTMLElement;
  /** The state has changed. */
  render(state: State, before: State): void;
  /** Marks and runs. */
  unasked?(message: Unasked): void;
  /** A key that is no command of the whole page; true if it meant something. */
  key?(event: KeyboardEvent, down: boolean): boolean;
  /** What was asked of the loop is refused; true if it is said beside the field that it is about. */
  besideField?(why: string): boolean;
  /** A file that fell on the page and is for this view. */
  take?(dropped: Dropped): void;
}

export interface TextFile {
  name: string;
  text: string;
}

/** What a view may be given. */
export type Dropped =
  | { is: "record"; file: File }
  | { is: "certificate"; answer: Answer }
  | { is: "plant" | "controller"; file: TextFile }
  | { is: "experiment"; kind: string; parameters: Values }
  | { is: "log"; name: string };
