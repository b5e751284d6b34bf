// Names of fields, which carry their unit, for people.

/** A channel's name with its unit, for people. */
export function readable(channel: string): string {
  const units: [RegExp, string][] = [
    [/_n_s_mu_per_m$/, ", N·s^μ/m"],
    [/_n_s_per_m$/, ", N·s/m"],
    [/_n_per_s$/, ", N/s"],
    [/_n_per_m$/, ", N/m"],
    [/_m_per_s$/, ", m/s"],
    [/_pa$/, ", Pa"],
    [/_m2$/, ", m²"],
    [/_kg$/, ", kg"],
    [/_hz$/, ", Hz"],
    [/_rad$/, ", rad"],
    [/_us$/, ", µs"],
    [/_n$/, ", N"],
    [/_m$/, ", m"],
    [/_j$/, ", J"],
    [/_s$/, ", s"],
  ];
  const unit = units.find(([pattern]) => pattern.test(channel));
  return (unit ? channel.replace(unit[0], "") : channel).replace(/_/g, " ") + (unit?.[1] ?? "");
}

/** A channel as it is drawn, lengths in mm. */
export function plotted(channel: string): { name: string; factor: number } {
  const name = readable(channel);
  return name.endsWith(", m") ? { name: `${name.slice(0, -1)}mm`, factor: 1000 } : { name, factor: 1 };
}

/** A sentence of the server with its keys as the fields are called. */
export function spoken(sentence: string): string {
  return sentence.replace(/`([a-z]\w*)`/g, (_, key: string) => readable(key).replace(/,.*/, ""));
}
