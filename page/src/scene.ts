// The thing itself: a probe in tissue that gives way, drawn from the state of the loop.

import { el, onSize, set, svg } from "./dom";
import { quantity, steady } from "./format";

/** Positions that are shown, m; the surface at rest is at 0. */
const FROM = -0.0045;
const TO = 0.0105;
const LAYERS = 5;
/** Speed of the arrow keys, m/s; with shift a tenth. */
const KEY_SPEED = 0.004;
/** Time in which the probe is taken out, s. */
const WITHDRAW_S = 0.8;

export interface SceneState {
  /** Of the probe, m. */
  position: number;
  /** Of the hand, m; NaN if nothing holds it. */
  hand: number;
  /** Reaction of the tissue, N. */
  force: number;
  /** Where the tissue's surface is under the probe, m. */
  surface: number;
}

/** What may be seen of a wall that is compared: the hand, but neither how the tissue yields nor its force. A probe that nobody holds is in front of it. */
export function blind({ position, hand }: SceneState): SceneState {
  return { position: Number.isNaN(hand) ? Math.min(position, 0) : hand, hand: NaN, force: 0, surface: 0 };
}

export interface SceneOptions {
  /** The hand is at a position, or lets go. */
  hand: (position: number, held: boolean) => void;
  /** Someone began to use it. */
  touched: () => void;
}

export class Scene {
  readonly root: HTMLElement;
  private readonly picture = svg("svg", { "aria-hidden": "true" });
  private readonly tissue = svg("path", { class: "tissue" });
  private readonly layers = Array.from({ length: LAYERS - 1 }, () => svg("path", { class: "layer" }));
  private readonly rod = svg("line", { class: "rod" });
  private readonly ball = svg("circle", { class: "ball" });
  private readonly grip = svg("circle", { class: "grip", r: 7 });
  private readonly arrow = svg("path", { class: "arrow" });
  private readonly label = svg("text", { class: "force" });
  private readonly word = svg("text", { class: "word", "text-anchor": "middle" });
  private width = 0;
  private height = 0;
  private state: SceneState = { position: FROM, hand: NaN, force: 0, surface: 0 };
  private keys = new Set<string>();
  private keyed: number | null = null;
  private fine = false;
  /** Time until a hand that takes the probe out lets go, s. */
  private leaving = 0;
  private limits: [number, number] = [FROM, TO];

  constructor(private readonly options: SceneOptions) {
    this.picture.append(this.tissue, ...this.layers, this.rod, this.ball, this.grip, this.arrow, this.label, this.word);
    this.root = el("div", {
      class: "scene",
      tabindex: 0,
      role: "slider",
      "aria-label": "Probe: arrow keys push it into the tissue",
      "aria-orientation": "horizontal",
      "aria-valuemin": 1000 * FROM,
      "aria-valuemax": 1000 * TO,
      "aria-valuenow": 0,
    });
    this.root.append(this.picture);
    onSize(this.root, (width, height) => {
      this.width = width;
      this.height = height;
      set(this.picture, { viewBox: `0 0 ${width} ${height}` });
      this.draw();
    });
    this.listen();
  }

  /** Where the hand can be, m. */
  set reach(limits: [number, number]) {
    this.limits = [Math.max(FROM, limits[0]), Math.min(TO, limits[1])];
  }

  /** The hand lets go, as after a stop: what held it does not push on. */
  letGo(): void {
    this.keys.clear();
    this.keyed = null;
    this.leaving = 0;
  }

  /** A word over the tissue, as when it stands still; empty for none. */
  set notice(text: string) {
    if (this.word.textContent !== text) this.word.textContent = text;
  }

  show(state: SceneState): void {
    this.state = state;
    this.draw();
  }

  private x(position: number): number {
    return (this.width * (position - FROM)) / (TO - FROM);
  }

  private draw(): void {
    const { width, height, state } = this;
    if (width === 0) return;
    const [middle, radius] = [0.5 * height, Math.max(11, 0.032 * width)];
    const tip = this.x(state.position);
    const depth = Math.max(0, this.x(state.surface) - this.x(0));
    set(this.tissue, { d: this.outline(middle, radius, tip, depth) });
    this.layers.forEach((layer, index) => set(layer, { d: this.layer(index + 1, middle, depth) }));
    set(this.rod, { x1: 8, x2: tip - radius, y1: middle, y2: middle });
    set(this.ball, { cx: tip - radius, cy: middle, r: radius });
    const apart = !Number.isNaN(state.hand) && Math.abs(this.x(state.hand) - tip) > 3;
    this.grip.style.display = apart ? "" : "none";
    if (apart) set(this.grip, { cx: this.x(state.hand) - radius, cy: middle });
    this.drawForce(tip, middle + radius + 0.09 * height);
    set(this.word, { x: width / 2, y: 0.12 * height });
    this.root.setAttribute("aria-valuenow", (1000 * state.position).toFixed(2));
    this.root.setAttribute("aria-valuetext", `depth ${quantity(state.position, "m")}, force ${quantity(state.force, "N")}`);
  }

  private drawForce(tip: number, y: number): void {
    const { force } = this.state;
    const shown = force > 5e-4;
    this.arrow.style.display = this.label.style.display = shown ? "" : "none";
    if (!shown) return;
    // 0.1 N are a tenth of the width, and strong forces do not leave the picture.
    const length = 0.5 * this.width * (1 - Math.exp(-force / 0.35)) + 8;
    const from = tip - 0.02 * this.width;
    const to = Math.max(16, from - length);
    set(this.arrow, { d: `M${from},${y}L${to + 12},${y}M${to},${y}l15,-8v16z` });
    set(this.label, { x: to, y: y + 26 });
    this.label.textContent = steady(force, 3, "N");
  }

  /** Surface of the tissue, pushed in by `depth` px at the middle, around the ball where it touches. */
  private outline(middle: number, radius: number, tip: number, depth: number): string {
    const surface = this.x(0);
    const [top, bottom, right] = [0.05 * this.height, 0.95 * this.height, 0.97 * this.width];
    const touching = tip >= surface + depth - 2 && depth > 0;
    let path = `M${right},${top}`;
    for (let step = 0; step <= 96; step += 1) {
      const y = top + ((bottom - top) * step) / 96;
      const r = y - middle;
      let x = surface + depth * this.dimple(r, 1, bottom - middle);
      if (touching && Math.abs(r) < radius) x = Math.max(x, tip - radius + Math.sqrt(radius * radius - r * r));
      path += `L${x.toFixed(1)},${y.toFixed(1)}`;
    }
    return `${path}L${right},${bottom}Z`;
  }

  private layer(index: number, middle: number, depth: number): string {
    const [surface, right] = [this.x(0), 0.97 * this.width];
    const [top, bottom] = [0.05 * this.height, 0.95 * this.height];
    const rest = surface + ((right - surface) * index) / LAYERS;
    // Deeper layers move less, in a wider dimple, and never cross.
    const pushed = depth * (1 - index / LAYERS) ** 1.6;
    let path = "";
    for (let step = 0; step <= 48; step += 1) {
      const y = top + ((bottom - top) * step) / 48;
      path += `${step === 0 ? "M" : "L"}${(rest + pushed * this.dimple(y - middle, 1 + 0.5 * index, bottom - middle)).toFixed(1)},${y.toFixed(1)}`;
    }
    return path;
  }

  private dimple(r: number, wide: number, half: number): number {
    const a = 0.2 * half * wide;
    const shape = (s: number) => (1 + (s / a) ** 2) ** -0.9;
    // The rim stays where it is.
    return (shape(r) - shape(half)) / (1 - shape(half));
  }

  private listen(): void {
    const { root } = this;
    const position = (event: PointerEvent) => {
      const { left } = root.getBoundingClientRect();
      const radius = Math.max(11, 0.032 * this.width);
      return FROM + ((event.clientX - left + radius) / this.width) * (TO - FROM);
    };
    root.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      root.setPointerCapture(event.pointerId);
      root.classList.add("held");
      this.keyed = null;
      this.leaving = 0;
      this.options.touched();
      this.options.hand(this.within(position(event)), true);
    });
    root.addEventListener("pointermove", (event) => {
      if (root.hasPointerCapture(event.pointerId)) this.options.hand(this.within(position(event)), true);
    });
    const release = (event: PointerEvent) => {
      if (!root.classList.contains("held")) return;
      root.classList.remove("held");
      this.options.hand(this.within(position(event)), false);
    };
    root.addEventListener("pointerup", release);
    root.addEventListener("pointercancel", release);
  }

  /** An arrow key went down or up; true if it was one. */
  key(event: KeyboardEvent, down: boolean): boolean {
    this.fine = event.shiftKey;
    if (event.key === "Home") {
      if (down) this.withdraw();
      return true;
    }
    if (!["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"].includes(event.key)) return false;
    if (down) this.keys.add(event.key);
    else this.keys.delete(event.key);
    if (down && this.keyed === null) {
      this.options.touched();
      this.keyed = this.within(Number.isNaN(this.state.hand) ? this.state.position : this.state.hand);
    }
    return true;
  }

  /** The hand takes the probe out, then lets go. */
  private withdraw(): void {
    this.keys.clear();
    this.options.touched();
    this.keyed = this.limits[0];
    this.leaving = WITHDRAW_S;
  }

  /** Moves a hand that is led by keys, `elapsed` seconds after the last time; a hand that is led by a pointer is left alone. */
  step(elapsed: number): void {
    if (this.keyed === null) return;
    if (this.leaving > 0) {
      this.leaving -= elapsed;
      if (this.keys.size > 0) this.leaving = 0;
      else {
        this.options.hand(this.keyed, this.leaving > 0);
        if (this.leaving <= 0) this.keyed = null;
        return;
      }
    }
    const way = (keys: string[]) => (keys.some((key) => this.keys.has(key)) ? 1 : 0);
    const direction = way(["ArrowRight", "ArrowDown"]) - way(["ArrowLeft", "ArrowUp"]);
    this.keyed = this.within(this.keyed + direction * elapsed * KEY_SPEED * (this.fine ? 0.1 : 1));
    this.options.hand(this.keyed, true);
  }

  private within(position: number): number {
    return Math.min(this.limits[1], Math.max(this.limits[0], position));
  }
}
