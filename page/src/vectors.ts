// Channels of a log with several axes: which of them are components of one vector.

import type { Line } from "./chart";

export type Stroke = Omit<Line, "label">;

/** Strokes of runs, models and components, best told apart first, without colour too: as in the figures. */
export const STROKES: Stroke[] = [
  { colour: "--blue" },
  { colour: "--verm", dash: [9, 4] },
  { colour: "--green", dash: [2.2, 3] },
  { colour: "--rose", dash: [11, 3, 2.2, 3] },
  { colour: "--ink", dash: [18, 5] },
  { colour: "--mute", dash: [4.5, 4.5] },
];
/** Theory lies beneath, broad and light, so that a curve on top of it is seen to agree all along. */
export const THEORY: Stroke = { colour: "--theory", width: 6 };

/** The stroke of a component. */
function componentStroke(of: string | undefined): Stroke | undefined {
  return of === "norm" ? { colour: "--ink", width: 1.5 } : STROKES["xyz".indexOf(of ?? "-")];
}

/** The vector that a channel belongs to, and its component: `force_n` and `x` of `force_x_n`; null for a number by itself. */
export function component(channel: string): { vector: string; of: string } | null {
  const [, name, of, unit] = /^(.+)_(x|y|z|norm)_([a-z]+)$/.exec(channel) ?? [];
  return name === undefined || of === undefined || unit === undefined ? null : { vector: `${name}_${unit}`, of };
}

/** What can be chosen: vectors first, each as one, then every channel by itself. */
export function choices(channels: string[]): string[] {
  const vectors = channels.flatMap((channel) => component(channel)?.vector ?? []);
  return [...new Set([...vectors, ...channels])];
}

/** The channels that a choice shows: itself, or the components of the vector. */
export function members(choice: string, channels: string[]): string[] {
  return channels.includes(choice) ? [choice] : channels.filter((channel) => component(channel)?.vector === choice);
}

/** How a component is drawn beside the others of its vector; of a further run with that run's dashes. */
export function strokeOf(channel: string, dash: number[] | undefined): Stroke | null {
  const own = componentStroke(component(channel)?.of);
  return own === undefined ? null : dash === undefined ? own : { ...own, dash };
}

/** Its component for people: `x` of `force_x_n`. */
export function componentName(channel: string): string {
  return component(channel)?.of ?? channel;
}
