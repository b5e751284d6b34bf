// A wall as an experiment file for `host-cli run`.

import type { Design } from "./state";

/** TOML with the keys of `[wall]`; every number is written so that it is read back the same. */
export function wallFile(design: Design): string {
  const scheme = design.operator === "exact" ? "full" : design.operator;
  const lines: [string, number | string][] = [
    ["mass_kg", design.m],
    ["damping_n_s_per_m", design.b],
    ["sample_time_s", design.T],
    ["order", design.mu],
    ["stiffness_n_per_m", design.K],
    ["dissipation_n_s_mu_per_m", design.B],
    ["scheme", scheme],
  ];
  if (design.delay > 0) lines.push(["delay_s", design.delay]);
  if (design.lag > 0) lines.push(["current_lag_s", design.lag]);
  if (design.noise > 0) lines.push(["sensor_noise_m", design.noise]);
  const written = lines.map(([key, value]) => `${key} = ${typeof value === "string" ? JSON.stringify(value) : toml(value)}`);
  return `# From the page's Design view: host-cli run wall.toml\n[wall]\n${written.join("\n")}\n`;
}

/** A float of TOML has a point or an exponent. */
function toml(value: number): string {
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
}
