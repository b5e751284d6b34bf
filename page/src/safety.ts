// Is it safe? The server's verdict on what runs, and where that stands among the walls of its device.

import type { App } from "./app";
import { latest } from "./connection";
import { el, say } from "./dom";
import { everyMotion, number } from "./format";
import { RegionMap } from "./map";
import type { Feel, Verdict } from "./protocol";

/** The server's verdict in a few words. */
export function sentence({ stable, margin, passive }: Verdict): string {
  return `${stable ? "stable" : "unstable"}, ${margin === null ? "at any gain" : `margin ${number(margin)}`} · ${passive ? "passive" : "not passive"}`;
}

export class Safety {
  readonly root: HTMLElement;
  private readonly said = el("span");
  private readonly map = new RegionMap({ name: "Stable and passive walls on this device", axes: false });
  private readonly hint = el("p", { class: "hint" });
  /** Shows what is felt. */
  readonly show: (feel: Feel) => void;

  constructor(private readonly app: App) {
    this.root = el("section", { class: "card" }, el("h2", {}, "Is it safe? ", this.said), this.map.root as unknown as HTMLElement, this.hint);
    const draw = latest((feel: Feel) => this.draw(feel), (error) => app.notify(error.message));
    this.show = (feel) => {
      say(this.said, sentence(feel.verdict));
      this.said.title = feel.verdict.line;
      if (feel.order_free) draw(feel);
      else {
        this.map.hide();
        say(this.hint, "This law has more elements than a map has axes: no map is drawn.");
      }
    };
  }

  /** The map of the law and the device that run. */
  private async draw(feel: Feel): Promise<void> {
    const { verdict, scale } = feel;
    const [stiffness, dissipation] = [feel.stiffness_n_per_m * scale, feel.dissipation_n_s_mu_per_m * scale];
    const judged = await this.app.analysis.judge({
      scheme: "exact", order: feel.order, sampleTime: this.app.state.hello?.sample_time_s ?? 1e-3,
      mass: verdict.mass_kg, damping: verdict.damping_n_s_per_m, handStiffness: verdict.hand_stiffness_n_per_m,
      delay: verdict.delay_s, lag: verdict.current_lag_s, stiffness, dissipation, noise: 0, omega: [],
    });
    // Another law may have come meanwhile.
    if (this.app.state.felt !== feel) return;
    this.map.show(judged, dissipation, stiffness, sentence(verdict));
    say(this.hint, `Contact that never pulls, as here, is not proved. Every motion of contact that may pull: ${everyMotion(judged, stiffness, dissipation)}`);
  }
}
