// The state of the page: answers, edits and the address go through one reducer. Nothing here knows the document or the socket.

import { numberOf, readFragment, writeFragment, type View } from "./fragment";
import type { Device, Environment, Feel, Hello, Opened, Status, Tissue, Wall } from "./protocol";

/** A change of what is felt; what is not named stays. */
export interface FeelChange {
  environment?: Environment;
  order?: number;
  stiffness_n_per_m?: number;
  dissipation_n_s_mu_per_m?: number;
  scale?: number;
  ghosts?: string[];
}

export interface FeelStart extends Omit<FeelChange, "environment"> {
  environment: Environment | Opened;
  device?: Partial<Device>;
}

/** A request that changes what is felt. */
export type Outgoing = { do: "feel.start"; keys: FeelStart } | { do: "feel.set"; keys: FeelChange };

/** The wall and the device of Design. */
export interface Design {
  K: number;
  B: number;
  mu: number;
  T: number;
  m: number;
  b: number;
  delay: number;
  lag: number;
  noise: number;
  operator: string;
}

/** The plant and the wishes of Control. */
export interface Control {
  plant: string;
  /** rad/s. */
  crossover: number;
  /** Degrees. */
  margin: number;
  flat: boolean;
}

/** What Runs shows. */
export interface Shown {
  open: readonly string[];
  /** The answer of a question. */
  answer: string;
  /** Channels that were chosen; empty for those that suit the runs best. */
  above: string;
  below: string;
  /** The part of the time that is visible, s; null for all of it. */
  span: readonly [number, number] | null;
}

export interface State {
  readonly view: View;
  /** Folds that are open, by their names. */
  readonly folds: readonly string[];
  /** Null without a connection. */
  readonly hello: Hello | null;
  /** Why there is none; null until one is lost. */
  readonly lost: string | null;
  readonly status: Status | null;
  /** What runs, as the server said last. */
  readonly felt: Feel | null;
  /** A start that waits, as an address. */
  readonly asked: ReadonlyMap<string, string> | null;
  /** A file or a run that waits to be felt. */
  readonly opening: Opened | null;
  /** The request that is on its way, and the edits after it. */
  readonly sent: Outgoing | null;
  readonly edits: FeelChange | null;
  /** Loops that were started: each begins with an untouched tissue. */
  readonly starts: number;
  /** The server was there before. */
  readonly met: boolean;
  readonly design: Design;
  readonly runs: Shown;
  readonly control: Control;
}

export type PageEvent =
  | { do: "address"; fragment: string }
  | { do: "go"; view: View }
  | { do: "folds"; open: readonly string[] }
  | { do: "hello"; hello: Hello }
  | { do: "lost"; reason: string }
  | { do: "status"; status: Status }
  /** What is felt, unasked or as an answer. */
  | { do: "felt"; feel: Feel; answers?: true }
  | { do: "refused" }
  | { do: "sent" }
  | { do: "change"; change: FeelChange }
  | { do: "start"; values: ReadonlyMap<string, string> }
  /** Feel what is written in a file or a log. */
  | { do: "open"; what: Opened }
  | { do: "design"; part: Partial<Design> }
  | { do: "runs"; part: Partial<Shown> }
  | { do: "control"; part: Partial<Control> };

export const OPERATORS: readonly [string, string][] = [
  ["exact", "full memory"],
  ["muir:3", "A₃, dissertation ch. 4"],
  ["tustin-muir:3", "Tustin, degree 3"],
  ["grunwald:100", "last 100 samples"],
  ["piecewise-linear", "full memory, piecewise linear"],
];

/** Operators as an address may name them. */
const SCHEME = /^(exact|full|full-bdf2|piecewise-linear|grunwald|muir|tustin-muir|oustaloup)(:[\w.+-]+)*$/;

/** Numbers of a device in an address. */
const DEVICE: readonly [string, keyof Device][] = [
  ["m", "mass_kg"], ["b", "damping_n_s_per_m"], ["delay", "delay_s"], ["lag", "current_lag_s"], ["friction", "friction_n"],
  ["encoder", "encoder_resolution_m"], ["noise", "sensor_noise_m"], ["T", "sample_time_s"],
];

/** Least and most of the numbers of Design. */
export const DESIGN_ENDS: Record<Exclude<keyof Design, "operator">, readonly [number, number]> = {
  K: [0, 1e6], B: [0, 1e5], mu: [0, 2], T: [1e-4, 1e-2], m: [1e-3, 10], b: [0, 100], delay: [0, 1e-2], lag: [0, 1e-2], noise: [0, 1e-3],
};

/** Least and most of the wishes of Control. */
export const CONTROL_ENDS: Record<"crossover" | "margin", readonly [number, number]> = { crossover: [1e-3, 1e3], margin: [20, 85] };

/** The first tissue of a first visit, and what is compared with it. */
const FIRST = "prostate-cancerous";
const GHOSTS = "short,a3";

export const START: State = {
  view: "feel",
  folds: [],
  hello: null,
  lost: null,
  status: null,
  felt: null,
  asked: null,
  opening: null,
  sent: null,
  edits: null,
  starts: 0,
  met: false,
  // The device of the dissertation's section 4.4, with a wall of order 0.5.
  design: { K: 3000, B: 100, mu: 0.5, T: 1e-3, m: 0.065, b: 3.5, delay: 0, lag: 0, noise: 1e-5, operator: "exact" },
  runs: { open: [], answer: "", above: "", below: "", span: null },
  // The tank of Monje and others, 2008.
  control: { plant: "0.55exp(-s)/(62s+1)", crossover: 0.1, margin: 65, flat: true },
};

export function reduce(state: State, event: PageEvent): State {
  switch (event.do) {
    case "address":
      return addressed(state, event.fragment);
    case "go":
      return { ...state, view: event.view };
    case "folds":
      return { ...state, folds: event.open };
    case "hello":
      return greeted(state, event.hello);
    case "lost":
      return { ...state, hello: null, lost: event.reason || (state.lost ?? ""), sent: null, edits: null };
    case "status":
      return { ...state, status: event.status };
    case "felt":
      if (!event.answers) return { ...state, felt: event.feel };
      return { ...state, felt: event.feel, sent: null, starts: state.starts + (state.sent?.do === "feel.start" ? 1 : 0) };
    case "refused":
      return { ...state, sent: null };
    case "sent":
      return sent(state);
    case "change":
      return { ...state, edits: merged(state.edits ?? {}, event.change) };
    case "start":
      return { ...state, view: "feel", asked: event.values, opening: null, edits: null };
    case "open":
      return { ...state, view: "feel", asked: null, opening: event.what, edits: null };
    case "design":
      return { ...state, design: { ...state.design, ...event.part } };
    case "runs":
      return { ...state, runs: { ...state.runs, ...event.part } };
    case "control":
      return { ...state, control: { ...state.control, ...event.part } };
  }
}

/** A later change over an earlier one. Another environment brings its own numbers. */
export function merged(before: FeelChange, after: FeelChange): FeelChange {
  const kept = after.environment === undefined ? before : before.ghosts === undefined ? {} : { ghosts: before.ghosts };
  return { ...kept, ...after };
}

/** What is felt with all edits, also those that the server has not answered. */
export function edited(state: State): Feel | null {
  const { felt, sent, edits, hello } = state;
  if (felt === null) return null;
  const changes = [sent?.do === "feel.set" ? sent.keys : {}, edits ?? {}];
  return changes.reduce<Feel>((feel, change) => changed(feel, change, hello?.tissues ?? []), felt);
}

function changed(feel: Feel, change: FeelChange, tissues: Tissue[]): Feel {
  const { environment } = change;
  if (environment && "wall" in environment) return { ...feel, title: "a wall", note: null, order_free: true, scale: 1, ...environment.wall, ...change };
  const tissue = environment && "tissue" in environment ? tissues.find(({ name }) => name === environment.tissue) : undefined;
  if (tissue === undefined) return { ...feel, ...change };
  const { title, order, order_free, stiffness_n_per_m, dissipation_n_s_mu_per_m } = tissue;
  return { ...feel, title, note: null, order, order_free, stiffness_n_per_m, dissipation_n_s_mu_per_m, scale: 1, ...change };
}

/** The request that is next; null while one is on its way or there is nothing to ask. */
export function outgoing(state: State): Outgoing | null {
  const { hello, sent, asked, opening, edits } = state;
  if (hello === null || sent !== null) return null;
  if (opening !== null) return { do: "feel.start", keys: { environment: opening } };
  if (asked !== null) return { do: "feel.start", keys: startOf(asked, hello.tissues) };
  return edits === null ? null : { do: "feel.set", keys: edits };
}

function sent(state: State): State {
  const next = outgoing(state);
  if (next === null) return state;
  return next.do === "feel.start" ? { ...state, sent: next, asked: null, opening: null } : { ...state, sent: next, edits: null };
}

/** The server answers: first time or after it was lost. */
function greeted(state: State, hello: Hello): State {
  const { opens } = hello;
  // The wall of a file is that of Design too, unless an address said another.
  const design = opens && state.design === START.design && "wall" in opens.environment ? designOfWall(opens) : state.design;
  const next: State = { ...state, hello, design, lost: null, felt: hello.feel, met: true, sent: null, edits: null };
  if (!hello.controls) return { ...next, asked: null, opening: null };
  // Whoever opens the page finds a tissue that moves; who was only cut off for a while finds what there is.
  if (state.asked !== null || state.opening !== null || (hello.feel !== null && state.met)) return next;
  const before = hello.feel ?? state.felt ?? hello.opens ?? null;
  return { ...next, asked: before === null ? new Map() : feelValues(before, hello.device) };
}

// The address.

function addressed(state: State, fragment: string): State {
  const { view, values: all } = readFragment(fragment);
  const values = new Map([...all].filter(([key]) => key !== "folds"));
  const next = { ...state, view, folds: (all.get("folds") ?? "").split(",").filter((name) => name !== "") };
  if (view === "feel") return settled(values) && !same(values, feelAddress(state)) ? { ...next, asked: values, edits: null } : next;
  if (view === "runs") return { ...next, runs: runsOf(values) };
  if (view === "control") return { ...next, control: controlOf(values, state.control) };
  return { ...next, design: designOf(values, state.design) };
}

/** True if an address says what to feel. */
function settled(values: ReadonlyMap<string, string>): boolean {
  return values.has("tissue") || values.has("B");
}

function same(one: ReadonlyMap<string, string>, other: ReadonlyMap<string, string>): boolean {
  return one.size === other.size && [...one].every(([key, value]) => other.get(key) === value);
}

/** The address of a state: it opens the same page. */
export function address(state: State): string {
  const { view, folds } = state;
  return writeFragment({ view, values: new Map([...viewValues(state), ["folds", folds.join(",")]]) });
}

function viewValues(state: State): ReadonlyMap<string, string> {
  const { view, design, runs, control } = state;
  if (view === "feel") return feelAddress(state);
  if (view === "design") return new Map(Object.entries(design).map(([key, value]) => [key, String(value)]));
  if (view === "control") return new Map(Object.entries(control).map(([key, value]) => [key, String(value)]));
  const [from, to] = (runs.span ?? ["", ""]).map(String);
  return new Map(Object.entries({ open: runs.open.join(","), answer: runs.answer, above: runs.above, below: runs.below, from: from ?? "", to: to ?? "" }));
}

function feelAddress(state: State): ReadonlyMap<string, string> {
  const feel = edited(state);
  return state.asked ?? (feel === null ? new Map() : feelValues(feel, state.hello?.device));
}

/** What is felt, as an address says it; of the device mass, damping, and what is not as the server has it. */
export function feelValues(feel: Feel, usual?: Device): ReadonlyMap<string, string> {
  const wall = "wall" in feel.environment;
  const device = DEVICE.filter(([short, key]) => ["m", "b"].includes(short) || (feel[key] !== undefined && feel[key] !== usual?.[key]));
  return new Map([
    ...("tissue" in feel.environment ? [["tissue", feel.environment.tissue] as const] : []),
    ["order", String(feel.order)],
    ["K", String(feel.stiffness_n_per_m)],
    ["B", String(feel.dissipation_n_s_mu_per_m)],
    ...(wall && feel.scheme !== undefined && feel.scheme !== "full" ? [["scheme", feel.scheme] as const] : []),
    ...(wall && feel.signed ? [["signed", "true"] as const] : []),
    ["scale", String(feel.scale)],
    ...device.map(([short, key]) => [short, String(feel[key])] as const),
    ["ghosts", feel.ghosts.join(",") || "none"],
  ]);
}

/** What is felt, on a device of which one number is another. */
export function onDevice(state: State, key: keyof Device, value: number): ReadonlyMap<string, string> {
  const feel = edited(state);
  return feel === null ? new Map() : feelValues({ ...feel, [key]: value }, state.hello?.device);
}

/** The start that an address asks for; the first tissue where it says none. */
export function startOf(values: ReadonlyMap<string, string>, tissues: Tissue[]): FeelStart {
  const [order, stiffness, dissipation, scale] = ["order", "K", "B", "scale"].map((key) => numberOf(values, key));
  const device = DEVICE.flatMap(([short, key]) => {
    const value = numberOf(values, short);
    return value === undefined ? [] : [[key, value] as const];
  });
  const named = tissues.find(({ name }) => name === values.get("tissue"));
  const isWall = named === undefined && order !== undefined && dissipation !== undefined;
  const tissue = named ?? tissues.find(({ name }) => name === FIRST) ?? tissues[0];
  const ghosts = values.get("ghosts") ?? GHOSTS;
  const wall = (order: number, dissipation: number): Wall => {
    const [scheme, signed] = [values.get("scheme"), values.get("signed") === "true"];
    return { order, stiffness_n_per_m: stiffness ?? 0, dissipation_n_s_mu_per_m: dissipation, ...(scheme === undefined ? {} : { scheme }), ...(signed ? { signed } : {}) };
  };
  const start: FeelStart = {
    environment: isWall ? { wall: wall(order, dissipation) } : { tissue: tissue?.name ?? "" },
    ghosts: ghosts.split(",").filter((name) => ["short", "a3"].includes(name)),
  };
  // In its full size a tissue is felt as large as it can be.
  if (scale !== undefined && (isWall || scale !== 1)) start.scale = scale;
  if (device.length > 0) start.device = Object.fromEntries(device);
  if (isWall || named === undefined || !named.order_free) return start;
  // Its own numbers are left to the library.
  if (order !== undefined && order !== named.order) start.order = order;
  if (stiffness !== undefined && stiffness !== named.stiffness_n_per_m) start.stiffness_n_per_m = stiffness;
  if (dissipation !== undefined && dissipation !== named.dissipation_n_s_mu_per_m) start.dissipation_n_s_mu_per_m = dissipation;
  return start;
}

function runsOf(values: ReadonlyMap<string, string>): Shown {
  const text = (key: string) => values.get(key) ?? "";
  const [from, to] = [numberOf(values, "from"), numberOf(values, "to")];
  const span = from !== undefined && to !== undefined && from < to ? ([from, to] as const) : null;
  return { open: text("open").split(",").filter((name) => name !== ""), answer: text("answer"), above: text("above"), below: text("below"), span };
}

function controlOf(values: ReadonlyMap<string, string>, control: Control): Control {
  const within = (key: "crossover" | "margin") => {
    const [least, most] = CONTROL_ENDS[key];
    return Math.min(most, Math.max(least, numberOf(values, key) ?? control[key]));
  };
  return { plant: values.get("plant") ?? control.plant, crossover: within("crossover"), margin: within("margin"), flat: (values.get("flat") ?? String(control.flat)) !== "false" };
}

function designOfWall(feel: Feel): Design {
  const numbers = {
    K: feel.stiffness_n_per_m, B: feel.dissipation_n_s_mu_per_m, mu: feel.order, T: feel.sample_time_s, m: feel.mass_kg, b: feel.damping_n_s_per_m,
    delay: feel.delay_s, lag: feel.current_lag_s, noise: feel.sensor_noise_m,
  };
  const values = Object.entries(numbers).map(([key, value]) => [key, String(value)] as const);
  return designOf(new Map([...values, ["operator", feel.scheme === "full" ? "exact" : feel.scheme]]), START.design);
}

function designOf(values: ReadonlyMap<string, string>, design: Design): Design {
  const next = { ...design };
  for (const [key, [least, most]] of Object.entries(DESIGN_ENDS) as [Exclude<keyof Design, "operator">, readonly [number, number]][]) {
    const value = numberOf(values, key);
    if (value !== undefined) next[key] = Math.min(most, Math.max(least, value));
  }
  const operator = values.get("operator") ?? "";
  if (SCHEME.test(operator)) next.operator = operator;
  return next;
}
