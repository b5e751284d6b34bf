// The difference that a hand should feel between a wall and the best spring and damper: the server's prediction in a sentence.

import { number, quantity } from "./format";
import type { Noticed } from "./protocol";

export function prediction(hand: Noticed): string {
  if ("reason" in hand) return `No prediction of what a hand notices: ${hand.reason}`;
  const best = `the best spring and damper, K = ${quantity(hand.best_stiffness_n_per_m, "N/m")} and B = ${quantity(hand.best_damping_n_s_per_m, "N·s/m")}`;
  const unstable = hand.best_stable ? "" : ", which this loop cannot render";
  const most = `most at ${number(hand.frequency_hz)} Hz, ${number(hand.difference)} × the least ${hand.part} that it notices`;
  return `Prediction: a hand should ${hand.felt ? "" : "not "}tell this wall from ${best}${unstable} (${most}).`;
}
