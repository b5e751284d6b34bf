import assert from "node:assert/strict";
import { test } from "node:test";
import { Panel } from "../../src/connection";

const after = <T>(ms: number, value: T): Promise<T> => new Promise((done) => setTimeout(() => done(value), ms));

test("the answer of a long question is not shown after that of a short one", async () => {
  const asked: string[] = [];
  const panel = new Panel(async (question) => {
    const { name, ms } = question as { name: string; ms: number };
    asked.push(name);
    return after(ms, name);
  });
  const long = panel.ask({ name: "long", ms: 40 });
  await after(1, null);
  assert.equal(await panel.ask({ name: "short", ms: 5 }), "short");
  assert.equal(await long, null);
  assert.equal(await panel.ask({ name: "again", ms: 1 }), "again");
  // A file that is read for long is not sent after a newer question.
  const slow = panel.ask(after(20, { name: "slow file", ms: 1 }));
  assert.equal(await panel.ask({ name: "quick file", ms: 1 }), "quick file");
  assert.equal(await slow, null);
  assert.deepEqual(asked, ["long", "short", "again", "quick file"]);
});

test("a refusal is told only of the newest question, and of none that was forgotten", async () => {
  const panel = new Panel((question) => after(10, question).then(() => Promise.reject(new Error((question as { name: string }).name))));
  const old = panel.ask({ name: "old" });
  // It is on its way; one that was never sent could not be refused.
  await after(1, null);
  await assert.rejects(panel.ask({ name: "new" }), /new/);
  assert.equal(await old, null);
  const forgotten = panel.ask({ name: "forgotten" });
  await after(1, null);
  panel.forget();
  assert.equal(await forgotten, null);
});
