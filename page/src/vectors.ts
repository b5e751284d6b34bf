// Channels of a log with several axes: which of them are components of one vector.

import type { Line } from "./chart";

/** Names of components, and how each is drawn: told apart without colour too. */
const COMPONENTS: Record<string, Omit<Line, "label">> = {
  x: { colour: "--blue" },
  y: { colour: "--verm", dash: [9, 4] },
  z: { colour: "--green", dash: [2.2, 3] },
  norm: { colour: "--ink", width: 1.5 },
};

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
export function strokeOf(channel: string, dash: number[] | undefined): Omit<Line, "label"> | null {
  const own = COMPONENTS[component(channel)?.of ?? ""];
  return own === undefined ? null : dash === undefined ? own : { ...own, dash };
}

/** Its component for people: `x` of `force_x_n`. */
export function componentName(channel: string): string {
  return component(channel)?.of ?? channel;
}
