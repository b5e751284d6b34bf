// Where the tissue's surface stands: at the probe while it touches, else where the tissue has come back to.

import type { Connection } from "./connection";
import type { Feel } from "./protocol";

/** A force below this is none, N. */
const TOUCH_N = 1e-4;
/** Time between two depths that the memory hears, s. */
const STEP_S = 0.02;
/** A gap that is longer is not filled, s. */
const GAP_S = 60;
/** Depths that the server hears at a time. */
const DEPTHS = 3000;

/**
 * The remembered set of the tissue. The server keeps its memory, which hears the depths that the picture shows, at the
 * pace of the picture.
 */
export class Surface {
  private heard = NaN;
  private set = 0;
  private busy = false;
  private depths: number[] = [];
  private law: { order: number; stiffness_n_per_m: number; dissipation_n_s_mu_per_m: number } | null = null;
  /** The memory does not know the law yet, or has to forget. */
  private anew = false;

  constructor(private readonly connection: Connection) {}

  /** The tissue is untouched. */
  reset(): void {
    this.heard = NaN;
    this.set = 0;
    this.depths = [];
    this.anew = true;
  }

  /** The law that is felt; what was remembered is kept if it is the same. */
  follows(feel: Feel): void {
    const { order, stiffness_n_per_m, dissipation_n_s_mu_per_m } = feel;
    const law = { order, stiffness_n_per_m, dissipation_n_s_mu_per_m };
    if (JSON.stringify(law) === JSON.stringify(this.law)) return;
    this.law = law;
    this.anew = true;
  }

  /** The surface at a time, s, with the probe at a position and a reaction. */
  at(time: number, position: number, force: number): number {
    const depth = Math.max(0, position);
    if (!(time - this.heard < GAP_S) || time < this.heard) this.heard = time;
    while (this.heard + STEP_S <= time) {
      this.depths.push(depth);
      this.heard += STEP_S;
    }
    if (this.depths.length > 0 && !this.busy) this.tell();
    return force > TOUCH_N && position > 0 ? position : this.set;
  }

  private tell(): void {
    const depths_m = this.depths.splice(0, DEPTHS);
    if (this.law === null) return;
    this.busy = true;
    const law = this.anew ? { law: { ...this.law, step_s: STEP_S } } : {};
    this.anew = false;
    this.connection
      .ask<{ surface_m: number }>("surface", { ...law, depths_m })
      .then(({ surface_m }) => {
        this.set = surface_m;
      })
      // A server that does not know the tissue hears of it with the next depths.
      .catch(() => {
        this.anew = true;
      })
      .finally(() => {
        this.busy = false;
      });
  }
}
