import assert from "node:assert/strict";
import { test } from "node:test";
import { cutOf, shapeOf } from "../../src/shape";

const XY = { across: 0, up: 1, through: -1 };
const of = (values: Record<string, string>) => shapeOf({ experiment: values });

test("shapes are read from the metadata of a log", () => {
  assert.deepEqual(of({ shape: "ball", centre_m: "0.01 -0.02", radius_m: "0.02" }), { kind: "ball", centre: [0.01, -0.02], radius: 0.02, hollow: false });
  assert.deepEqual(of({ shape: "plane", normal: "3 4", surface_m: "0.005" }), { kind: "plane", normal: [0.6, 0.8], surface: 0.005 });
  for (const none of [{}, { shape: "wall" }, { shape: "ball" }, { shape: "plane", normal: "0 0" }, { shape: "ball", centre_m: "0 0", radius_m: "x" }]) assert.equal(of(none as Record<string, string>), null);
  assert.equal(shapeOf({}), null);
});

test("a ball is cut in a circle, larger towards its middle, and not at all beside it", () => {
  const ball = { kind: "ball", centre: [0, 0, 0.1], radius: 0.05, hollow: false } as const;
  const radius = (at: number): number | null => {
    const cut = cutOf({ ...ball, centre: [...ball.centre] }, { across: 0, up: 1, through: 2 }, at);
    return cut.kind === "circle" ? cut.radius : null;
  };
  assert.ok(Math.abs((radius(0.1) ?? 0) - 0.05) < 1e-12);
  assert.ok(Math.abs((radius(0.13) ?? 0) - 0.04) < 1e-12);
  assert.equal(radius(0.16), null);
  assert.equal(cutOf({ kind: "ball", centre: [0, 0, 0], radius: 0.05, hollow: true }, { across: 0, up: 1, through: 2 }, 1).kind, "all");
});

test("a plane is cut in a line that holds the places of its surface", () => {
  const plane = { kind: "plane", normal: [0.6, 0, 0.8], surface: 0.02 } as const;
  const axes = { across: 0, up: 1, through: 2 };
  const shape = { ...plane, normal: [...plane.normal] };
  for (const z of [-0.03, 0, 0.01]) {
    const cut = cutOf(shape, axes, z);
    assert.ok(cut.kind === "line");
    assert.ok(Math.abs(0.6 * cut.point[0] + 0.8 * z - 0.02) < 1e-12, `${z}`);
    assert.deepEqual(cut.normal, [0.6, 0]);
  }
  // Along the surface there is no line: all of it, or nothing.
  const level = { kind: "plane", normal: [0, 0, 1], surface: 0 } as const;
  assert.equal(cutOf({ ...level, normal: [...level.normal] }, axes, 0.01).kind, "all");
  assert.equal(cutOf({ ...level, normal: [...level.normal] }, axes, -0.01).kind, "none");
  const flat = cutOf({ kind: "plane", normal: [1, 0], surface: 0.003 }, XY, NaN);
  assert.ok(flat.kind === "line" && Math.abs(flat.point[0] - 0.003) < 1e-15);
});
