// Is it safe? The server's verdict on what runs, and where that stands among the walls of its device.

import type { App } from "./app";
import { latest, type Panel } from "./connection";
import { el, say } from "./dom";
import { number } from "./format";
import { POINTS, RegionMap } from "./map";
import { prediction } from "./prediction";
import type { Feel, Judged, Verdict } from "./protocol";

/** The server's verdict in a few words. */
export function sentence({ stable, margin, passive }: Verdict): string {
  return `${stable ? "stable" : "unstable"}, ${margin === null ? "at any gain" : `margin ${number(margin)}`} · ${passive ? "passive" : "not passive"}`;
}

export class Safety {
  readonly root: HTMLElement;
  private readonly said = el("span");
  private readonly map = new RegionMap({ name: "Stable and passive walls on this device", axes: false });
  private readonly hint = el("p", { class: "hint" });
  private readonly felt = el("p", { class: "hint" });
  private readonly panel: Panel;
  /** Shows what is felt. */
  readonly show: (feel: Feel) => void;

  constructor(private readonly app: App) {
    this.panel = app.connection.panel("safety");
    this.root = el("section", { class: "card" }, el("h2", {}, "Is it safe? ", this.said), el("div", { class: "beside safe" }, this.map.root as unknown as HTMLElement, el("div", { tabindex: 0, role: "region", "aria-label": "What is proved" }, this.hint, this.felt)));
    const draw = latest((feel: Feel) => this.draw(feel), (error) => app.notify(error.message));
    this.show = (feel) => {
      say(this.said, sentence(feel.verdict));
      this.said.title = feel.verdict.line;
      if (feel.order_free) draw(feel);
      else {
        this.map.hide();
        say(this.felt, "");
        say(this.hint, "This law has more elements than a map has axes: no map is drawn.");
      }
    };
  }

  /** The map of the law and the device that run. */
  private async draw(feel: Feel): Promise<void> {
    const { verdict, scale } = feel;
    const [stiffness, dissipation] = [feel.stiffness_n_per_m * scale, feel.dissipation_n_s_mu_per_m * scale];
    const device = {
      scheme: feel.scheme === "full" ? "exact" : feel.scheme, order: feel.order, sample_time_s: feel.sample_time_s,
      mass_kg: verdict.mass_kg, damping_n_s_per_m: verdict.damping_n_s_per_m, hand_stiffness_n_per_m: verdict.hand_stiffness_n_per_m,
      delay_s: verdict.delay_s, current_lag_s: verdict.current_lag_s,
    };
    const wall = { ...device, stiffness_n_per_m: stiffness, dissipation_n_s_mu_per_m: dissipation, position_noise_m: 0, points: POINTS, device_damping_n_s_per_m: feel.damping_n_s_per_m };
    const judged = await this.panel.ask<Judged>({ wall });
    // Another law may have come meanwhile.
    if (judged === null || this.app.state.felt !== feel) return;
    this.map.show(judged, JSON.stringify(device), dissipation, stiffness, sentence(verdict));
    say(this.hint, `Contact that never pulls, as here, is not proved. Every motion of contact that may pull: ${judged.pulling_contact}`);
    say(this.felt, prediction(judged.hand));
  }
}
