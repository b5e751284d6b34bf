// The state of the page in its address: `#view?key=value&…`.

export const VIEWS = ["feel", "design", "runs", "control"] as const;
export type View = (typeof VIEWS)[number];

export interface State {
  view: View;
  values: ReadonlyMap<string, string>;
}

/** Reads a fragment; what is not understood is left out, never an error. */
export function readFragment(fragment: string): State {
  const text = fragment.replace(/^#/, "");
  const [name = "", query = ""] = text.split("?", 2);
  const view = VIEWS.find((known) => known === name) ?? "feel";
  return { view, values: new Map(new URLSearchParams(query)) };
}

/** Writes it; keys in the order of the map. Slashes and commas stay readable. */
export function writeFragment(state: State): string {
  const query = [...state.values]
    .filter(([, value]) => value !== "")
    .map(([key, value]) => `${encodeURIComponent(key)}=${encodeURIComponent(value).replace(/%2C/g, ",").replace(/%3A/g, ":")}`);
  return `#${state.view}${query.length > 0 ? `?${query.join("&")}` : ""}`;
}

/** A finite number of the state. */
export function numberOf(values: ReadonlyMap<string, string>, key: string): number | undefined {
  const text = values.get(key);
  if (text === undefined || text.trim() === "") return undefined;
  const value = Number(text);
  return Number.isFinite(value) ? value : undefined;
}
