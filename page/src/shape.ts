// What is touched, from the metadata of a log, and its cut by a plane of two axes.

import type { Values } from "./protocol";

export type Shape =
  | { kind: "plane"; normal: number[]; surface: number }
  | { kind: "ball"; centre: number[]; radius: number; hollow: boolean };

/** Two axes that are drawn, and the third of three. */
export interface Axes {
  across: number;
  up: number;
  /** -1 with two axes. */
  through: number;
}

/** The cut of a shape: a circle, or a line with the matter on the side that its normal points to; all or nothing where the shape has no edge there. */
export type Cut =
  | { kind: "circle"; centre: [number, number]; radius: number; hollow: boolean }
  | { kind: "line"; point: [number, number]; normal: [number, number] }
  | { kind: "all" }
  | { kind: "none" };

function numbers(text: unknown): number[] {
  return typeof text === "string" ? text.split(/\s+/).map(Number).filter(Number.isFinite) : [];
}

/** The shape of a touch; null of another experiment. */
export function shapeOf(metadata: Values): Shape | null {
  const values = (metadata["experiment"] ?? {}) as Values;
  const name = values["shape"];
  if (name === "plane") {
    const normal = numbers(values["normal"]);
    const length = Math.hypot(...normal);
    return length > 0 ? { kind: "plane", normal: normal.map((part) => part / length), surface: Number(values["surface_m"] ?? 0) } : null;
  }
  if (name !== "ball" && name !== "hollow-ball") return null;
  const [centre, radius] = [numbers(values["centre_m"]), Number(values["radius_m"])];
  return centre.length >= 2 && radius > 0 ? { kind: "ball", centre, radius, hollow: name === "hollow-ball" } : null;
}

/** The cut at a place of the third axis, m. */
export function cutOf(shape: Shape, { across, up, through }: Axes, at: number): Cut {
  const part = (vector: number[], axis: number) => vector[axis] ?? 0;
  if (shape.kind === "ball") {
    const off = through < 0 ? 0 : at - part(shape.centre, through);
    const squared = shape.radius ** 2 - off ** 2;
    if (squared <= 0) return { kind: shape.hollow ? "all" : "none" };
    return { kind: "circle", centre: [part(shape.centre, across), part(shape.centre, up)], radius: Math.sqrt(squared), hollow: shape.hollow };
  }
  const normal: [number, number] = [part(shape.normal, across), part(shape.normal, up)];
  const distance = shape.surface - (through < 0 ? 0 : part(shape.normal, through) * at);
  const squared = normal[0] ** 2 + normal[1] ** 2;
  if (squared < 1e-12) return { kind: distance < 0 ? "all" : "none" };
  return { kind: "line", point: [(normal[0] * distance) / squared, (normal[1] * distance) / squared], normal };
}
