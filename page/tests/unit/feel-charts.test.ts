import assert from "node:assert/strict";
import { test } from "node:test";
import { lateness } from "../../src/feel-charts";
import type { Status } from "../../src/protocol";

const status = (running: boolean, picture_late_s: number): Status => ({ running, picture_late_s }) as Status;

test("a picture that is late is said to be, by the server's word or its silence", () => {
  assert.equal(lateness(status(true, 0.1), 100), "");
  assert.equal(lateness(status(true, 0.82), 100), "The picture is 0.8 s late: the connection or the server is slow.");
  assert.match(lateness(status(true, 0), 2500), /2\.5 s late/);
  assert.equal(lateness(status(false, 0), 2500), "");
  assert.equal(lateness(null, 2500), "");
});
