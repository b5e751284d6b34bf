// Where the tissue's surface stands: at the probe while it touches, else where the tissue has come back to.

import type { Feel } from "./protocol";

/** A force below this is none, N. */
const TOUCH_N = 1e-4;
/** Steps of the memory, s. */
const STEP_S = 0.02;
const MEMORY = 1500;

/**
 * The remembered set: the depth x₀ at which the tissue, with its history of indentations, would push with nothing,
 * K·x₀ + B·T^(−μ)·(x₀ + Σ_{j≥1} c_j·x[n−j]) = 0, from the positions that were shown.
 */
export class Surface {
  private weights: number[] = [];
  private past: number[] = [];
  private next = 0;
  private share = 1;

  reset(): void {
    this.past = [];
    this.next = 0;
  }

  /** The law that is felt. */
  law(feel: Feel): void {
    // c_0 = 1, c_j = c_(j−1)·(j − 1 − μ)/j
    this.weights = [1];
    for (let j = 1; j <= MEMORY; j += 1) this.weights.push(((this.weights[j - 1] ?? 0) * (j - 1 - feel.order)) / j);
    const memory = feel.dissipation_n_s_mu_per_m * STEP_S ** -feel.order;
    this.share = memory > 0 ? memory / (memory + feel.stiffness_n_per_m) : 0;
  }

  /** The surface at a time, s, with the probe at a position and a reaction. */
  at(time: number, position: number, force: number): number {
    if (time < this.next - 10 * STEP_S) this.reset();
    if (this.past.length === 0) this.next = time;
    const depth = Math.max(0, position);
    while (this.next <= time) {
      this.past.unshift(depth);
      this.next += STEP_S;
      if (time - this.next > MEMORY * STEP_S) this.next = time;
    }
    this.past.length = Math.min(this.past.length, MEMORY);
    if (force > TOUCH_N && position > 0) return position;
    let sum = 0;
    for (let j = 1; j < this.past.length; j += 1) sum -= (this.weights[j] ?? 0) * (this.past[j] ?? 0);
    const set = this.share * sum;
    // The probe may rest on what is still pushed in, never above it.
    return Math.max(0, set);
  }
}
