// Feel: what does this tissue feel like?

import type { App, ViewPart } from "./app";
import { Compare } from "./compare";
import { latest } from "./connection";
import { Demonstration } from "./demonstration";
import { el } from "./dom";
import { FeelCharts } from "./feel-charts";
import { FeelControls } from "./feel-controls";
import type { Hello, Status, Unasked } from "./protocol";
import { Safety } from "./safety";
import { blind, Scene } from "./scene";
import { edited, type State } from "./state";
import { Surface } from "./surface";

export class FeelView implements ViewPart {
  readonly root: HTMLElement;
  private readonly scene: Scene;
  private readonly charts: FeelCharts;
  private readonly controls: FeelControls;
  private readonly compare: Compare;
  private readonly safety: Safety;
  private readonly demonstration: Demonstration;
  private readonly surface: Surface;
  private readonly hint = el("p", { class: "hint" }, "It relaxes while you hold, and remembers when you come back.");
  private readonly sendHand: (hand: { position_m: number; held: boolean }) => void;
  private lastHand = { position_m: 0, held: false, at: 0 };
  private lastStep = 0;

  constructor(private readonly app: App) {
    this.surface = new Surface(app.connection);
    this.sendHand = latest((hand) => app.connection.ask("feel.hand", hand), () => undefined);
    this.demonstration = new Demonstration((position, held) => this.sendHand({ position_m: position, held }));
    this.scene = new Scene({
      hand: (position, held) => this.hand(position, held),
      touched: () => this.demonstration.end(),
    });
    this.charts = new FeelCharts(app);
    this.controls = new FeelControls(app);
    this.compare = new Compare(app, () => this.demonstration.end());
    this.safety = new Safety(app);
    const heading = el("h2", {}, "Push the tissue: drag the probe, or use the arrow keys");
    this.root = el(
      "div",
      { class: "view feel" },
      el("div", { class: "left" }, el("section", { class: "card" }, heading, this.scene.root, this.hint), el("section", { class: "card", "aria-label": "Tissue" }, this.controls.root, this.compare.root)),
      el("div", { class: "right" }, this.charts.force, this.charts.motion, this.safety.root),
    );
    requestAnimationFrame((now) => this.tick(now));
  }

  render(state: State, before: State): void {
    const visible = state.view === "feel";
    const { hello, felt, status } = state;
    if (hello !== null && hello !== before.hello) this.connected(hello);
    if (state.starts !== before.starts) this.begun();
    if (visible && (before.view !== "feel" || (hello !== null && hello !== before.hello))) this.charts.look();
    if (!visible && before.view === "feel") this.left();
    if (felt !== null && felt !== before.felt) {
      this.surface.follows(felt);
      this.charts.showGhosts(felt.ghosts);
      this.safety.show(felt);
      // A spring does not, nor does what resists motion alone.
      this.hint.hidden = felt.dissipation_n_s_mu_per_m === 0 || felt.order === 0 || felt.order >= 1;
    }
    const feel = edited(state);
    if (feel !== null && (felt !== before.felt || state.sent !== before.sent || state.edits !== before.edits)) this.controls.show(feel, hello);
    if (status !== null && status !== before.status) this.told(status, felt !== null);
  }

  private connected(hello: Hello): void {
    this.controls.connected(hello);
    this.compare.connected(hello);
    const { hand_m } = hello.ranges;
    if (hand_m) this.scene.reach = [hand_m.least, hand_m.most];
    this.charts.reset();
    this.surface.reset();
  }

  private begun(): void {
    this.charts.reset();
    this.surface.reset();
    this.demonstration.begin(performance.now());
  }

  private left(): void {
    this.demonstration.rest();
    if (this.app.connection.ready) this.app.connection.ask("view.end").catch(() => undefined);
  }

  private told(status: Status, felt: boolean): void {
    this.scene.notice = status.fault ? "stopped by a fault" : status.stopped ? "stopped" : status.paused ? "paused" : "";
    if (status.stopped) this.scene.letGo();
    this.compare.show(status.compare ?? null);
    // The charts would tell the walls apart.
    this.root.classList.toggle("blind", status.compare?.running ?? false);
    if (felt && status.controls && !status.stopped && !status.paused) this.demonstration.begin(performance.now());
    else this.demonstration.rest();
  }

  unasked(message: Unasked): void {
    if (message.mark) this.charts.mark(message.mark);
  }

  private hand(position: number, held: boolean): void {
    const now = performance.now();
    const same = held === this.lastHand.held && Math.abs(position - this.lastHand.position_m) < 1e-7;
    // What holds still is said twice a second: a page that is silent has let go.
    if (same && now - this.lastHand.at < 400) return;
    if (held === this.lastHand.held && now - this.lastHand.at < 15) return;
    this.lastHand = { position_m: position, held, at: now };
    this.sendHand({ position_m: position, held });
  }

  private tick(now: number): void {
    requestAnimationFrame((next) => this.tick(next));
    const elapsed = Math.min(0.1, (now - this.lastStep) / 1000);
    this.lastStep = now;
    if (this.app.state.view !== "feel") return;
    this.scene.step(elapsed);
    this.demonstration.step(now);
    const newest = this.charts.step();
    if (newest === null || Number.isNaN(newest.position)) return;
    const { position, force, hand } = newest;
    const seen = { position, force: Math.max(0, force), hand, surface: this.surface.at(newest.time, position, force) };
    this.scene.show(this.app.state.status?.compare?.running ? blind(seen) : seen);
  }

  besideField(why: string): boolean {
    return this.controls.refused(why);
  }

  key(event: KeyboardEvent, down: boolean): boolean {
    const onControl = event.target instanceof HTMLElement && event.target.matches("input, select, textarea");
    if (!onControl && this.scene.key(event, down)) return true;
    if (!down) return false;
    if (event.key === "Escape") return this.charts.unzoom();
    if (event.key.toLowerCase() === "p") {
      void this.app.tell("feel.pause", { paused: !(this.app.state.status?.paused ?? false) });
      return true;
    }
    if (event.key.toLowerCase() === "m") {
      void this.app.tell("feel.mark", { text: String(this.charts.nextMark) });
      return true;
    }
    return false;
  }
}
