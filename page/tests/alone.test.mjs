// The page with nothing installed, as packaging/browser made it: in a browser, over any web server.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, afterEach, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { launch, open } from "./browser.mjs";
import { serveFolder } from "./static.mjs";

const root = fileURLToPath(new URL("../../", import.meta.url));
const FOLDER = process.env.PAGE_FOLDER ?? join(root, "target/browser/page");
const built = join(root, process.env.CARGO_TARGET_DIR ?? "target", "debug");
const HOST_CLI = process.env.HOST_CLI ?? join(built, "host-cli");
const ALONE = join(built, "examples/alone");
/** Where nobody has built it. */
const skip = process.env.REQUIRE_ALL_CHECKS !== "1" && !existsSync(FOLDER) && "skipped: no page, packaging/browser makes it";

let site, browser;
before(async () => {
  site = await serveFolder(FOLDER);
  browser = await launch();
});
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});
after(async () => {
  await browser?.close();
  site?.close();
});

const command = (...words) => JSON.parse(execFileSync(HOST_CLI, [...words, "--json"], { encoding: "utf8" }));

/** The answer of a worker of the page to a question of a panel. */
const asked = (page, question) =>
  page.evaluate(
    (question) =>
      new Promise((answered, failed) => {
        const worker = new Worker("worker.js", { name: "panels" });
        worker.onmessage = ({ data }) => {
          if (data === null) worker.postMessage(JSON.stringify({ id: 1, do: "ask", panel: "design", question }));
          else if (typeof data === "string") answered(JSON.parse(data));
          else failed(new Error(data.failed));
        };
      }),
    question,
  );

test("within three seconds a tissue is felt, then a wall from Design; a stop takes the force away", { skip, timeout: 60_000 }, async () => {
  const begun = Date.now();
  const { page, errors } = await open(browser, site.address);
  const feels = (pushes) =>
    page.waitForFunction((pushes) => {
      const [, force] = /force [−-]?([\d.]+)/.exec(document.querySelector(".scene")?.getAttribute("aria-valuetext") ?? "") ?? [];
      return force !== undefined && Number(force) > 0 === pushes;
    }, pushes);
  await page.waitForFunction(() => document.querySelector(".scene path.tissue")?.getAttribute("d")?.length > 100);
  console.log(`a tissue after ${Date.now() - begun} ms`);
  await feels(true);
  await page.locator("nav, header").getByText("Design", { exact: true }).click();
  await page.locator(".design .verdict, .design").getByText(/stable, gain margin/).first().waitFor();
  await page.getByText("Use in the loop").first().click();
  const box = await page.locator(".scene").boundingBox();
  await page.mouse.move(box.x + box.width * 0.2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2, { steps: 10 });
  await feels(true);
  await page.mouse.up();
  await page.keyboard.press("Space");
  await page.getByText("Stopped: the force is zero.").first().waitFor();
  await feels(false);
  assert.deepEqual(errors, []);
});

test("what the worker says through a script is what the program says, to the last bit", { skip, timeout: 60_000 }, async () => {
  const { page } = await open(browser, site.address);
  const script = readFileSync(join(root, "crates/haptic-answer/examples/alone.txt"), "utf8").trimEnd().split("\n");
  const said = await page.evaluate(async (script) => {
    const { instance } = await WebAssembly.instantiate(await (await fetch("haptic.wasm")).arrayBuffer());
    const server = instance.exports;
    const put = (text, hear) => {
      const bytes = new TextEncoder().encode(text);
      const at = server.room(bytes.length);
      new Uint8Array(server.memory.buffer, at, bytes.length).set(bytes);
      hear();
    };
    put("2026-12-01", server.begin);
    const said = [];
    for (const line of script) {
      if (line.startsWith("at ")) server.advance(Number(line.slice(3)));
      else put(line, server.hear);
      while (server.work());
      for (let kind = server.take(); kind !== 0; kind = server.take()) {
        const bytes = new Uint8Array(server.memory.buffer, server.taken(), server.taken_bytes()).slice();
        said.push(kind === 1 ? new TextDecoder().decode(bytes) : Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join(""));
      }
    }
    return said;
  }, script);
  assert.deepEqual(said, execFileSync(ALONE, { encoding: "utf8" }).trimEnd().split("\n"));
});

test("a wall and a loop have the numbers of the command, to the last bit", { skip, timeout: 60_000 }, async () => {
  const { page } = await open(browser, site.address);
  const wall = { scheme: "full", order: 0.5, stiffness_n_per_m: 3000, dissipation_n_s_mu_per_m: 100, mass_kg: 0.065, damping_n_s_per_m: 3.5, hand_stiffness_n_per_m: 0, delay_s: 0.0005, current_lag_s: 0, sample_time_s: 0.001 };
  const judged = await asked(page, { wall: { ...wall, position_noise_m: 1e-5, points: 200 } });
  const proved = command("analyze", "stability", "--scheme", "full", "--order", "0.5", "--stiffness", "3000", "--dissipation", "100", "--mass", "65g", "--damping", "3.5", "--delay", "0.5ms", "--sample-time", "1ms");
  assert.equal(judged.ok, true, judged.error);
  for (const key of ["stable", "gain_margin", "pulling_contact_margin"]) assert.equal(judged[key], proved[key], key);
  const loop = await asked(page, { analyze: { plant: "0.55exp(-s)/(62s+1)", controller: "9.7+0.6/s^0.9", sample_time_s: 0.1 } });
  assert.deepEqual({ ...loop.report, files: [] }, command("control", "analyze", "--plant", "0.55exp(-s)/(62s+1)", "--controller", "9.7+0.6/s^0.9", "--sample-time", "0.1s"));
});

test("a browser without WebAssembly is told so in a line", { skip, timeout: 30_000 }, async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.addInitScript(() => delete globalThis.WebAssembly);
  await page.goto(site.address);
  await page.getByText(/This browser has no WebAssembly or no workers/).first().waitFor();
});
