// A hand that pushes the tissue until someone else does: the first thing to see is a tissue that moves.

const DEPTH_M = 0.002;
const OUT_M = -0.002;
/** In, hold, out, away, s. */
const PHASES = [1.2, 6, 1.2, 3];
const PERIOD = PHASES.reduce((sum, phase) => sum + phase, 0);

/** Position of the hand, m, at a time of its round, s. */
export function demonstrated(time: number): number {
  const [into = 1, hold = 1, out = 1] = PHASES;
  const t = ((time % PERIOD) + PERIOD) % PERIOD;
  const smooth = (share: number) => share * share * (3 - 2 * share);
  const share = t < into ? smooth(t / into) : t < into + hold ? 1 : t < into + hold + out ? smooth(1 - (t - into - hold) / out) : 0;
  return OUT_M + share * (DEPTH_M - OUT_M);
}

export class Demonstration {
  private since: number | null = null;
  private over = matchMedia("(prefers-reduced-motion: reduce)").matches;
  private last = 0;

  constructor(private readonly hand: (position: number, held: boolean) => void) {}

  /** Begins, unless it has or someone took over. */
  begin(now: number): void {
    if (!this.over && this.since === null) this.since = now;
  }

  /** Pauses: it begins anew. */
  rest(): void {
    this.since = null;
  }

  /** Ends for good: the hand is someone's. */
  end(): void {
    this.over = true;
    this.since = null;
  }

  step(now: number): void {
    if (this.since === null || now - this.last < 15) return;
    this.last = now;
    this.hand(demonstrated((now - this.since) / 1000), true);
  }
}
