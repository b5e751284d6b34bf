import type { App, ViewPart } from "./app";
import { el } from "./dom";
export class RunsView implements ViewPart {
  readonly root = el("div", { class: "view runs" });
  constructor(_app: App) {}
  shown(): void {}
  hidden(): void {}
  connected(): void {}
  unasked(): void {}
  frame(): void {}
  themed(): void {}
  key(): boolean {
    return false;
  }
}
