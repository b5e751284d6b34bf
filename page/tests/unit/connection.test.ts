import assert from "node:assert/strict";
import { test } from "node:test";
import { newest } from "../../src/connection";

test("the answer of a long file is not shown under the name of a short one", async () => {
  const asked = newest();
  const shown: string[] = [];
  const ask = async (name: string, ms: number): Promise<void> => {
    const isNewest = asked();
    await new Promise((done) => setTimeout(done, ms));
    if (isNewest()) shown.push(name);
  };
  await Promise.all([ask("long", 40), ask("short", 5)]);
  assert.deepEqual(shown, ["short"]);
  await ask("again", 1);
  assert.deepEqual(shown, ["short", "again"]);
});
