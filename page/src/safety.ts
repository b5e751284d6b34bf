// Is it safe? The server's verdict on what runs, and where that stands among the walls of its device.

import type { App } from "./app";
import { latest } from "./connection";
import { el, say } from "./dom";
import { number } from "./format";
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
  private readonly none = el("p", { class: "hint", hidden: true }, "This law has more elements than a map has axes: no map is drawn.");
  /** Shows what is felt. */
  readonly show: (feel: Feel) => void;

  constructor(private readonly app: App) {
    this.root = el("section", { class: "card" }, el("h2", {}, "Is it safe? ", this.said), this.map.root as unknown as HTMLElement, this.none);
    const draw = latest((feel: Feel) => this.draw(feel), (error) => app.notify(error.message));
    this.show = (feel) => {
      say(this.said, sentence(feel.verdict));
      this.said.title = feel.verdict.line;
      this.none.hidden = feel.order_free;
      if (feel.order_free) draw(feel);
      else this.map.hide();
    };
  }

  /** The map of the law and the device that run. */
  private async draw(feel: Feel): Promise<void> {
    const { verdict } = feel;
    const walls = await this.app.analysis.walls({
      scheme: "exact", order: feel.order, sampleTime: this.app.state.hello?.sample_time_s ?? 1e-3,
      mass: verdict.mass_kg, damping: verdict.damping_n_s_per_m, handStiffness: verdict.hand_stiffness_n_per_m,
      delay: verdict.delay_s, lag: verdict.current_lag_s,
    });
    // Another law may have come meanwhile.
    if (this.app.state.felt === feel) this.map.show(walls, feel.dissipation_n_s_mu_per_m * feel.scale, feel.stiffness_n_per_m * feel.scale, sentence(verdict));
  }
}
