// A wall as an experiment file for `host-cli run`.

import type { Values } from "./design";

/** TOML with the keys of `[wall]`; every number is written so that it is read back the same. */
export function wallFile(values: Values, operator: string): string {
  const scheme = operator === "exact" ? "full" : operator;
  const lines: [string, number | string][] = [
    ["mass_kg", values.m],
    ["damping_n_s_per_m", values.b],
    ["sample_time_s", values.T],
    ["order", values.mu],
    ["stiffness_n_per_m", values.K],
    ["dissipation_n_s_mu_per_m", values.B],
    ["scheme", scheme],
  ];
  if (values.delay > 0) lines.push(["delay_s", values.delay]);
  if (values.lag > 0) lines.push(["current_lag_s", values.lag]);
  const written = lines.map(([key, value]) => `${key} = ${typeof value === "string" ? JSON.stringify(value) : toml(value)}`);
  return `# From the page's Design view: host-cli run wall.toml\n[wall]\n${written.join("\n")}\n`;
}

/** A float of TOML has a point or an exponent. */
function toml(value: number): string {
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
}
