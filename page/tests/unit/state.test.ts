import assert from "node:assert/strict";
import { test } from "node:test";
import type { Feel, Hello, Status, Tissue } from "../../src/protocol";
import { address, edited, merged, outgoing, reduce, START, type PageEvent, type State } from "../../src/state";

const PROSTATE = { name: "prostate-cancerous", title: "prostate", order: 0.2247, order_free: true, stiffness_n_per_m: 0, dissipation_n_s_mu_per_m: 173 } as Tissue;
const MUSCLE = { name: "fish-muscle", title: "muscle", order: 0.5, order_free: false, stiffness_n_per_m: 10, dissipation_n_s_mu_per_m: 20 } as Tissue;
const FELT = {
  environment: { tissue: PROSTATE.name }, title: "prostate", order: 0.2247, order_free: true, stiffness_n_per_m: 0, dissipation_n_s_mu_per_m: 173, scale: 1,
  mass_kg: 0.065, damping_n_s_per_m: 3.5, ghosts: ["short", "a3"],
} as unknown as Feel;

const hello = (parts: Partial<Hello> = {}): Hello => ({ controls: true, feel: null, tissues: [PROSTATE, MUSCLE], ranges: {}, channels: [], ...parts }) as unknown as Hello;
const after = (events: PageEvent[], state: State = START): State => events.reduce(reduce, state);
/** The server starts what it was asked to. */
const running = (feel: Feel = FELT): State => after([{ do: "hello", hello: hello() }, { do: "sent" }, { do: "felt", feel, answers: true }]);

test("a first visit starts the first tissue, once", () => {
  const state = after([{ do: "address", fragment: "" }, { do: "hello", hello: hello() }]);
  assert.deepEqual(outgoing(state), { do: "feel.start", keys: { environment: { tissue: PROSTATE.name }, ghosts: ["short", "a3"] } });
  const sent = reduce(state, { do: "sent" });
  assert.equal(outgoing(sent), null);
  const begun = reduce(sent, { do: "felt", feel: FELT, answers: true });
  assert.deepEqual([begun.starts, outgoing(begun)], [1, null]);
});

test("a page that only watches starts nothing", () => {
  const state = after([{ do: "hello", hello: hello({ controls: false, feel: FELT }) }]);
  assert.deepEqual([outgoing(state), state.felt], [null, FELT]);
});

test("who was cut off for a while finds what there is, or starts what there was", () => {
  const lost = after([{ do: "lost", reason: "" }], running());
  assert.equal(outgoing(lost), null);
  const back = after([{ do: "hello", hello: hello({ feel: { ...FELT, scale: 2 } }) }], lost);
  assert.deepEqual([outgoing(back), back.felt?.scale], [null, 2]);
  const anew = outgoing(after([{ do: "hello", hello: hello() }], after([{ do: "felt", feel: { ...FELT, scale: 2, order: 0.3 } }], lost)));
  assert.deepEqual([anew?.do, anew?.keys.scale, anew?.keys.order], ["feel.start", 2, 0.3]);
  // Why the server went is not forgotten while the page tries again.
  const why = (...reasons: string[]): string | null => after(reasons.map((reason) => ({ do: "lost", reason })), running()).lost;
  assert.deepEqual([why("the server was stopped", "", ""), why(""), back.lost], ["the server was stopped", "", null]);
});

test("edits are shown at once and not undone by answers to earlier ones", () => {
  let state = after([{ do: "change", change: { order: 0.3 } }, { do: "sent" }], running());
  for (const order of [0.31, 0.32, 0.33]) state = reduce(state, { do: "change", change: { order } });
  assert.equal(edited(state)?.order, 0.33);
  // The answer to the first, and the same told to all pages.
  state = after([{ do: "felt", feel: { ...FELT, order: 0.3 } }, { do: "felt", feel: { ...FELT, order: 0.3 }, answers: true }], state);
  assert.equal(edited(state)?.order, 0.33);
  assert.deepEqual(outgoing(state), { do: "feel.set", keys: { order: 0.33 } });
});

test("changes that wait are merged, none is lost", () => {
  const state = after([{ do: "change", change: { order: 0.3 } }, { do: "sent" }, { do: "change", change: { order: 0.4 } }, { do: "change", change: { scale: 2 } }, { do: "change", change: { ghosts: [] } }], running());
  assert.deepEqual(state.edits, { order: 0.4, scale: 2, ghosts: [] });
});

test("another tissue brings its own numbers, and keeps the ghosts", () => {
  const other = { environment: { tissue: MUSCLE.name } };
  assert.deepEqual(merged({ order: 0.4, scale: 2, ghosts: ["a3"] }, other), { ...other, ghosts: ["a3"] });
  assert.deepEqual(merged(other, { scale: 2 }), { ...other, scale: 2 });
  const shown = edited(after([{ do: "change", change: other }], running({ ...FELT, scale: 3 })));
  assert.deepEqual([shown?.order, shown?.order_free, shown?.scale], [0.5, false, 1]);
});

test("what is refused is taken back, later edits stay", () => {
  const state = after([{ do: "change", change: { order: 0.99 } }, { do: "sent" }, { do: "change", change: { scale: 2 } }, { do: "refused" }], running());
  assert.deepEqual([edited(state)?.order, edited(state)?.scale], [0.2247, 2]);
});

test("the address opens the same page", () => {
  const wall = { ...FELT, environment: { wall: { order: 0.5, stiffness_n_per_m: 200, dissipation_n_s_mu_per_m: 5 } }, order: 0.5, stiffness_n_per_m: 200, dissipation_n_s_mu_per_m: 5, ghosts: [] };
  const muscle = { ...FELT, environment: { tissue: MUSCLE.name }, order: 0.5, order_free: false, stiffness_n_per_m: 10, dissipation_n_s_mu_per_m: 20 };
  for (const feel of [FELT, { ...FELT, scale: 0.4, order: 0.31, mass_kg: 0.1 }, { ...muscle, scale: 2 }, { ...wall, scale: 3 }]) {
    const start = outgoing(after([{ do: "address", fragment: address(running(feel as Feel)) }, { do: "hello", hello: hello() }]));
    assert.ok(start?.do === "feel.start");
    const { environment, device, ghosts, ...numbers } = start.keys;
    const own = feel.order_free ? PROSTATE : MUSCLE;
    const brings = "wall" in environment ? environment.wall : { order: own.order, stiffness_n_per_m: own.stiffness_n_per_m, dissipation_n_s_mu_per_m: own.dissipation_n_s_mu_per_m };
    const opened = { ...feel, environment, ...brings, scale: 1, ...numbers, ...device, ghosts };
    assert.deepEqual(opened, feel);
    if (!feel.order_free) assert.equal(numbers.order, undefined, "its model has no single order");
  }
});

test("an address that is opened stays until the server has it", () => {
  const opened = after([{ do: "address", fragment: "#feel?tissue=fish-muscle&scale=2" }]);
  assert.equal(address(opened), "#feel?tissue=fish-muscle&scale=2");
  const waiting = reduce(opened, { do: "hello", hello: hello() });
  assert.equal(waiting.asked?.get("scale"), "2");
  assert.deepEqual(outgoing(waiting)?.keys.scale, 2);
});

test("going back to another tissue starts it, to the same one does not", () => {
  const state = after([{ do: "go", view: "design" }], running());
  assert.equal(outgoing(after([{ do: "address", fragment: address(running()) }], state)), null);
  const other = after([{ do: "address", fragment: "#feel?tissue=fish-muscle" }], state);
  assert.deepEqual([other.view, outgoing(other)?.keys.environment], ["feel", { tissue: MUSCLE.name }]);
});

test("Design and Runs open as they were", () => {
  const designed = after([{ do: "go", view: "design" }, { do: "design", part: { K: 250, operator: "muir:3" } }]);
  const design = after([{ do: "address", fragment: address(designed) }]).design;
  assert.deepEqual(design, designed.design);
  assert.deepEqual(after([{ do: "address", fragment: "#design?K=-5&mu=9&operator=nonsense&T=x" }]).design, { ...START.design, K: 0, mu: 2 });
  const shown = after([{ do: "go", view: "runs" }, { do: "runs", part: { open: ["relax-0001/relax", "b"], answer: "c/zwidth", above: "force_n", span: [0.25, 1.5] } }]);
  assert.deepEqual(after([{ do: "address", fragment: address(shown) }]).runs, shown.runs);
  // What is folded out goes with the link, whatever is shown.
  const folded = after([{ do: "folds", open: ["device", "compare"] }, { do: "go", view: "design" }]);
  assert.deepEqual(after([{ do: "address", fragment: address(folded) }]).folds, folded.folds);
  assert.deepEqual(after([{ do: "address", fragment: "#runs" }], shown).runs, START.runs);
});

test("the reducer changes nothing that it was given", () => {
  const freeze = <T>(value: T): T => {
    if (typeof value === "object" && value !== null && !(value instanceof Map)) Object.values(Object.freeze(value)).forEach(freeze);
    return value;
  };
  const events: PageEvent[] = [
    { do: "hello", hello: hello() }, { do: "sent" }, { do: "felt", feel: FELT, answers: true }, { do: "change", change: { ghosts: [] } }, { do: "sent" }, { do: "change", change: { scale: 2 } }, { do: "refused" },
    { do: "status", status: {} as Status }, { do: "design", part: { K: 1 } }, { do: "runs", part: { open: ["a"] } }, { do: "address", fragment: "#design?K=2" }, { do: "start", values: new Map([["tissue", "x"]]) }, { do: "go", view: "runs" }, { do: "lost", reason: "" },
  ];
  events.reduce((state, event) => freeze(reduce(state, freeze(event))), freeze(START));
});
