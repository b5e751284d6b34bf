// Messages of the socket, version 1: docs/page-protocol.md.

export const VERSION = 1;

/** Fields of a message that are shown by their names, or handed on. */
export type Values = Record<string, unknown>;

export interface Range {
  least: number;
  most: number;
  default: number;
}

export interface Tissue {
  name: string;
  title: string;
  model: string;
  order: number;
  order_free: boolean;
  stiffness_n_per_m: number;
  dissipation_n_s_mu_per_m: number;
}

export interface Wall {
  order: number;
  stiffness_n_per_m: number;
  dissipation_n_s_mu_per_m: number;
  scheme?: string;
  /** Its memory is fed with the position in front of the surface too. */
  signed?: boolean;
}

/** What is felt. */
export type Environment = { tissue: string } | { wall: Wall };

/** Where it is written: the server opens it. */
export type Opened = { file: { name: string; text: string } } | { run: string };

/** The simulated device, and the sample time of its loop. */
export interface Device {
  mass_kg: number;
  damping_n_s_per_m: number;
  delay_s: number;
  current_lag_s: number;
  friction_n: number;
  encoder_resolution_m: number;
  sensor_noise_m: number;
  sample_time_s: number;
}

export interface Feel extends Device {
  environment: Environment;
  title: string;
  /** Why a tissue is not felt in its full size. */
  note: string | null;
  scheme: string;
  signed: boolean;
  order: number;
  order_free: boolean;
  stiffness_n_per_m: number;
  dissipation_n_s_mu_per_m: number;
  scale: number;
  hand_stiffness_n_per_m: number;
  hand_damping_n_s_per_m: number;
  ghosts: string[];
  force_limit_n: number;
  verdict: Verdict;
}

/** Of the loop that runs, and the device that it is of: with the hand or without. */
export interface Verdict {
  stable: boolean;
  /** Factor on K and B that takes it to the edge; null if none does. */
  margin: number | null;
  passive: boolean;
  delay_s: number;
  current_lag_s: number;
  mass_kg: number;
  damping_n_s_per_m: number;
  hand_stiffness_n_per_m: number;
  /** All of it in a line. */
  line: string;
}

/** Stable and passive walls of a device: polygons, and an edge, of B and K. */
export interface Walls {
  region: [number, number][][];
  passive_walls: [number, number][];
}

/** The largest difference of a wall from the best spring and damper that a hand should feel; just noticed at 1. */
export type Noticed =
  | { difference: number; felt: boolean; frequency_hz: number; part: string; best_stiffness_n_per_m: number; best_damping_n_s_per_m: number; best_stable: boolean }
  | { reason: string };

/** A wall on a device, judged; null where there is none of a number. */
export interface Judged extends Walls {
  stable: boolean;
  gain_margin: number | null;
  gain_margin_down: number | null;
  /** Factor up to which every motion of contact that may pull is proved. */
  pulling_contact_margin: number | null;
  /** In words, rounded down. */
  pulling_contact: string;
  delay_margin_s: number | null;
  sensitivity_peak: number | null;
  sensitivity_peak_hz: number | null;
  passive: boolean;
  /** It pulls at rest, which no damping makes passive. */
  negative_at_rest: boolean;
  required_damping_n_s_per_m: number;
  /** With its unit, rounded up. */
  required_damping: string;
  force_noise_n: number;
  /** Frequency, effective stiffness and damping of the wall alone, and both as felt through the device. */
  curves: [number, number, number, number, number][];
  hand: Noticed;
}

export interface Hello {
  controls: boolean;
  watching: number;
  sample_time_s: number;
  channels: string[];
  limiters: string[];
  tissues: Tissue[];
  ranges: Record<string, Range>;
  feel: Feel | null;
  /** The file that the server was started with. */
  opens?: Feel | null;
  /** The device, but for what a start says. */
  device?: Device;
  view_columns_most: number;
  runs_folder: string;
}

/** Two walls that are compared, or were; nothing of their order. */
export interface Compared {
  running: boolean;
  /** Trials that were answered. */
  trial: number;
  trials: number;
  /** The wall of this trial that was asked for: 0, 1 or 2. */
  wall: number;
  touched: boolean;
  /** Ends of the scale, if ratings are asked for, and how many this trial has. */
  rating_scale: [number, number] | null;
  rated: number;
  /** Right answers; null before the end, and where neither is the stiffer one. */
  right: number | null;
  table: string;
}

/** Without a loop there is only what a socket knows. */
export interface Status {
  sample_time_s?: number;
  tick?: number;
  time_s?: number;
  tick_p50_us?: number | null;
  tick_p999_us?: number | null;
  late?: number;
  skipped?: number;
  lost?: number;
  limiter?: number;
  fault?: string | null;
  energy_j?: number | null;
  armed: boolean;
  stopped?: boolean;
  paused?: boolean;
  running: boolean;
  recording?: string | null;
  compare?: Compared | null;
  watching: number;
  controls: boolean;
  samples_made?: number;
  samples_kept?: number;
  samples_sent: number;
  samples_missed: number;
  /** Time by which the live view is known to be behind. */
  picture_late_s: number;
}

export interface Mark {
  tick: number;
  time_s: number;
  text: string;
}

export interface RunEntry {
  name: string;
  kind: string;
  started_utc: string | null;
  duration_s: number | null;
  samples: number | null;
  size_bytes: number;
  verdict: string | null;
  running: boolean;
}

export interface OpenRun {
  name: string;
  channels: string[];
  /** One, or those of the vectors. */
  axes?: number;
  samples: number;
  sample_time_s: number;
  first_s: number;
  last_s: number;
  complete: boolean;
  /** It goes on. */
  running?: boolean;
  damage: string[] | string | null;
  missing_samples: number | null;
  metadata: Values;
  events: { time_s: number; kind: string; text: string }[];
  end: { ended: string; reason: string } | null;
  /** What the experiment drew of itself, if it ran since the server was started. */
  curves?: RunCurves | null;
}

/** A row, or a table, of a report. */
export type Line = { level: number; key: string; label: string } & ({ value: string; reason: string } | { columns: string[]; rows: string[][]; length: number });

/** An answer of a question, as its file has it. */
export interface Answer {
  name: string;
  kind: string;
  /** It is not there yet. */
  running?: boolean;
  verdict: string | null;
  report: Values;
  /** The report as people read it. */
  lines: Line[];
  /** The experiment that tries a proposal. */
  experiment: { kind: string; text: string; parameters: Values } | null;
}

/** A run over its closed form. */
export interface RunCurves {
  title?: string;
  quantity?: string;
  label?: string;
  time_s: number[];
  values?: number[];
  closed_form?: number[];
  /** A measured record of the quantity, at its own times. */
  record_time_s?: number[];
  record?: number[];
}

export interface Parameter {
  key: string;
  kind: string;
  default: unknown;
  least: number | null;
  most: number | null;
  range: string | null;
  required: boolean;
  /** The default as the help shows it. */
  shown?: string;
  choices: string[] | null;
  help: string;
}

/** A key of `identify`. */
export interface RecordParameter extends Parameter {
  /** Those that it is for. */
  loadings: string[];
  /** It stands in the fold. */
  option: boolean;
}

export interface Form {
  kind: string;
  tables: { title: string; parameters: Parameter[] }[];
}

export interface RunProgress {
  name: string;
  kind: string;
  state: "running" | "done" | "failed" | "stopped";
  samples_done: number;
  samples: number;
  verdict: string | null;
  error: string | null;
  report: unknown;
}

/** What comes unasked. */
export interface Unasked {
  status?: Status;
  feel?: Feel;
  mark?: Mark;
  run?: RunProgress;
  notice?: string;
}
