// How long a person waits: node tests/times.mjs. It prints times, which are those of the machine, and fails only if the
// map of Design is slow on it and slower than when the browser computed it.
// HOST_CLI=path/to/host-cli says which. ROUNDS of loads, MOVES of a slider.
import { launch, open } from "./browser.mjs";
import { startServer } from "./server.mjs";

const ROUNDS = Number(process.env.ROUNDS ?? 9);
const MOVES = Number(process.env.MOVES ?? 120);

/** Longest time from a slider to its map, ms, on two idle cores. */
const MAP_MS = 40;
/** The same when the browser computed the map by WebAssembly, in times of a million square roots: the median of four runs on a busy machine, 2026-11-26 (6.3 to 8.9). */
const EARLIER = 6.5;

const median = (times) => times.toSorted((a, b) => a - b)[Math.floor(times.length / 2)];
const said = (times) => {
  const sorted = times.toSorted((a, b) => a - b);
  const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))]?.toFixed(1);
  return `median ${at(0.5)} ms, ${at(0)} to ${at(1)}, p95 ${at(0.95)} (${times.length})`;
};
const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

const server = await startServer();
const browser = await launch();
const system = await browser.newBrowserCDPSession();
/** Processor time of the browser with all its processes, ms. */
const spent = async () => {
  const { processInfo } = await system.send("SystemInfo.getProcessInfo");
  return 1000 * processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0);
};

/** Opens an address in a browser without a cache; time until `done` of its frames says so, and processor time. */
async function load(address, done) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  await page.addInitScript(`{
    const done = ${done};
    globalThis.done = new Promise((resolve) => {
      const look = () => (done() ? resolve(performance.now()) : requestAnimationFrame(look));
      look();
    });
  }`);
  const before = await spent();
  await page.goto(address);
  const time = await page.evaluate(() => globalThis.done);
  const work = (await spent()) - before;
  await context.close();
  await wait(400);
  return { time, work };
}

/** The tissue has moved: the probe is somewhere else than where it was seen first. */
const moved = `(() => {
  let first;
  return () => {
    const at = document.querySelector(".scene")?.getAttribute("aria-valuenow");
    first ??= at && Number(at) !== 0 ? at : undefined;
    return first !== undefined && at !== first;
  };
})()`;
/** Two frames of what is there: as many as a move needs. */
const shown = `(() => {
  let frames = 0;
  return () => document.readyState === "complete" && ++frames > 2;
})()`;

const [empty, first] = [[], []];
for (let round = 0; round < ROUNDS; round += 1) {
  empty.push(await load(`${server.address}icon.svg`, shown));
  first.push(await load(server.address, moved));
}
const part = (loads, name) => said(loads.map((load) => load[name]));
console.log(`load of nothing: ${part(empty, "time")}; processor ${part(empty, "work")}`);
console.log(`load to moving tissue: ${part(first, "time")}; processor ${part(first, "work")}`);

/** Moves a slider; times from each input to the drawing that answers it, and beside each of a million square roots. */
async function follow(view, knob, [from, step]) {
  const { page, context } = await open(browser, `${server.address}#${view}`);
  await page.waitForFunction((view) => document.querySelector(`.view.${view}`)?.dataset.drawn, view);
  await wait(1500);
  const times = await page.evaluate(
    async ([view, knob, from, step, moves]) => {
      const root = document.querySelector(`.view.${view}`);
      const slider = [...root.querySelectorAll(".knob")].find((each) => each.textContent.includes(knob)).querySelector("input[type=range]");
      const [times, yardstick] = [[], []];
      let sum = 0;
      for (let n = 0; n < moves; n += 1) {
        const began = performance.now();
        for (let root = 0; root < 1e6; root += 1) sum += Math.sqrt(root);
        yardstick.push(performance.now() - began);
        await new Promise((resolve) => {
          const since = performance.now();
          const seen = new MutationObserver(() => {
            times.push(performance.now() - since);
            seen.disconnect();
            resolve();
          });
          seen.observe(root, { attributeFilter: ["data-drawn"] });
          slider.value = String(from + step * n);
          slider.dispatchEvent(new Event("input", { bubbles: true }));
        });
        await new Promise((resolve) => setTimeout(resolve, 20));
      }
      return { times, yardstick, sum };
    },
    [view, knob, from, step, MOVES],
  );
  await context.close();
  return times;
}

const map = await follow("design", "order", [150, 5]);
const ratio = median(map.times) / median(map.yardstick) / EARLIER;
console.log(`Design, order to redrawn region: ${said(map.times)}; ${(ratio * EARLIER).toFixed(2)} yardsticks of ${median(map.yardstick).toFixed(2)} ms, ${ratio.toFixed(2)} times as long as in the browser`);
console.log(`Control, crossover to redrawn loop: ${said((await follow("control", "crossover", [250, 1])).times)}`);
console.log(`Control, phase margin to redrawn loop: ${said((await follow("control", "phase margin", [500, 1])).times)}`);

/** From a hand that moves to a force that has risen by a twentieth. */
async function felt() {
  const { page, context } = await open(browser, server.address);
  await page.waitForSelector(".device.running");
  await page.keyboard.press("Home");
  await wait(1500);
  const times = await page.evaluate(async () => {
    const scene = document.querySelector(".scene");
    const { left, top, width, height } = scene.getBoundingClientRect();
    const at = (share) => ({ clientX: left + share * width, clientY: top + height / 2, pointerId: 1, button: 0, bubbles: true });
    const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
    // Without a real pointer there is no capture.
    [scene.setPointerCapture, scene.hasPointerCapture] = [() => undefined, () => true];
    const force = () => parseFloat(scene.querySelector("text.force").textContent) * (/mN/.test(scene.querySelector("text.force").textContent) ? 1e-3 : 1);
    const times = [];
    for (let round = 0; round < 5; round += 1) {
      scene.dispatchEvent(new PointerEvent("pointerdown", at(0.38)));
      await wait(1500);
      const rest = force();
      const since = performance.now();
      scene.dispatchEvent(new PointerEvent("pointermove", at(0.6)));
      while (force() <= 1.05 * rest && performance.now() - since < 2000) await new Promise((resolve) => requestAnimationFrame(resolve));
      times.push(performance.now() - since);
      scene.dispatchEvent(new PointerEvent("pointerup", at(0.1)));
      await wait(3000);
    }
    return times;
  });
  await context.close();
  return said(times);
}

console.log(`Feel, mouse to force: ${await felt()}`);
await browser.close();
await server.kill();
if (median(map.times) > MAP_MS && ratio > 1.5) {
  console.error(`a slider moves its map within ${median(map.times).toFixed(1)} ms, which is more than ${MAP_MS} ms and ${ratio.toFixed(2)} times the earlier way`);
  process.exit(1);
}
