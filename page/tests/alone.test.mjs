// The page with nothing installed, as packaging/browser made it: in a browser, over any web server.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, afterEach, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { launch, open } from "./browser.mjs";
import { serveFolder } from "./static.mjs";
import { laidOut, shows, SIZES, until, violations } from "./views.mjs";

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

/** The answer of a worker of the page, to a question of a panel or to this request. */
const asked = (page, question, name = "panels", request = { do: "ask", panel: "design", question }) =>
  page.evaluate(
    ([name, request]) =>
      new Promise((answered, failed) => {
        const worker = new Worker("worker.js", { name });
        worker.onmessage = ({ data }) => {
          if (data === null) worker.postMessage(JSON.stringify({ id: 1, ...request }));
          else if (typeof data === "string" && JSON.parse(data).id === 1) answered(JSON.parse(data));
          else if (typeof data === "string") return;
          else failed(new Error(data.failed));
        };
      }),
    [name, request],
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

/** The columns of a table, by their names. */
const columns = (text) => {
  const [head, ...rows] = text.trimEnd().split("\n").map((line) => line.split(","));
  return new Map(head.map((name, column) => [name, rows.map((row) => Number(row[column]))]));
};

const RUNS = {
  relax: {},
  creep: {},
  wall: { mass_kg: 0.065, damping_n_s_per_m: 3.5, sample_time_s: 0.001, order: 0.5, stiffness_n_per_m: 3000, dissipation_n_s_mu_per_m: 100 },
};

test("runs from their forms have the samples of the command's logs, to the last bit", { skip, timeout: 120_000 }, async () => {
  const { page, errors } = await open(browser, `${site.address}#runs`);
  const folder = mkdtempSync(join(tmpdir(), "runs-"));
  const command = (...words) => execFileSync(HOST_CLI, [...words, "-q"]);
  for (const [number, [kind, keys]] of Object.entries(RUNS).entries()) {
    await page.locator("button", { hasText: "New run" }).click();
    await page.selectOption("select[aria-label='Experiment']", kind);
    await page.locator(".form button[type=submit]").click();
    await page.locator(".runs-list .progress").getByText(new RegExp(`^${kind}-000${number + 1}/${kind} is done${kind === "wall" ? ": stable" : ""}$`)).waitFor();
    await until(() => Promise.resolve(decodeURIComponent(page.url()).includes(`open=${kind}-`)), page.url());
    await page.locator(".facts h3", { hasText: kind }).waitFor();
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(".files button", { hasText: "CSV" }).click()]);
    const kept = columns(readFileSync(await download.path(), "utf8"));
    const file = join(folder, `${kind}.toml`);
    writeFileSync(file, `[${kind}]\n${Object.entries(keys).map(([key, value]) => `${key} = ${value}\n`).join("")}`);
    command("run", file, "--out", join(folder, kind));
    command("log", "export", join(folder, kind, `${kind}.mcap`), join(folder, `${kind}.csv`));
    const logged = columns(readFileSync(join(folder, `${kind}.csv`), "utf8"));
    assert.ok(kept.size > 2 && kept.get("time_s").length === (kind === "wall" ? 5001 : 200_001), [...kept.keys()].join());
    for (const [name, numbers] of kept) assert.deepEqual(numbers, logged.get(name), `${kind}: ${name}`);
  }
  rmSync(folder, { recursive: true });
  // What is no run of this page is refused with its command.
  const refused = await asked(page, undefined, "loop", { do: "runs.start", kind: "zwidth", parameters: {} });
  assert.match(refused.error, /`host-cli zwidth`/);
  assert.deepEqual(errors, []);
});

test("keys alone: arrows push, space stops, R starts again, each view is reached", { skip, timeout: 60_000 }, async () => {
  const { page, errors } = await open(browser, site.address);
  const scene = page.locator(".scene");
  const text = () => scene.getAttribute("aria-valuetext");
  const pushes = async () => /force [\d.]*[1-9]/.test(await text());
  await until(() => page.locator(".device.running").count(), "no loop");
  await until(async () => {
    await page.keyboard.press("Tab");
    return scene.evaluate((scene) => scene === document.activeElement);
  }, "Tab does not come to the probe");
  await page.keyboard.press("Home");
  await until(async () => Number(await scene.getAttribute("aria-valuenow")) < -0.5, "the probe did not come out");
  await page.keyboard.down("ArrowRight");
  await until(pushes, "no force");
  await page.keyboard.up("ArrowRight");
  await page.keyboard.press(" ");
  await until(async () => !(await pushes()) && page.locator("button.start").isVisible(), "no stop");
  await page.keyboard.press("r");
  await until(() => page.locator(".device.running").count(), "no start");
  for (const [key, view] of [["2", "design"], ["3", "runs"], ["4", "control"], ["1", "feel"]]) {
    await page.keyboard.press(key);
    await until(() => page.locator(`.view.${view}`).isVisible(), view);
  }
  assert.deepEqual(errors, []);
});

test("axe finds nothing, and nothing is cut, from 360 to 2560 px", { skip, timeout: 300_000 }, async () => {
  const { feel, design, identify, control } = shows;
  for (const [colorScheme, sizes] of [["light", SIZES], ["dark", SIZES.slice(0, 1)]]) {
    for (const [width, height] of sizes) {
      const { page, context, errors } = await open(browser, site.address, { colorScheme, viewport: { width, height } });
      await until(() => page.locator(".device.running").count(), "no loop");
      for (const [name, show] of Object.entries({ feel, design, identify, control })) {
        await show(page);
        const at = `${name}, ${width}×${height}, ${colorScheme}`;
        await laidOut(page, at);
        assert.deepEqual(await violations(page), [], at);
        if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, `${name}-${colorScheme}-${width}.png`), fullPage: true });
      }
      assert.deepEqual(errors, []);
      await context.close();
    }
  }
});

test("a browser without WebAssembly is told so in a line", { skip, timeout: 30_000 }, async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.addInitScript(() => delete globalThis.WebAssembly);
  await page.goto(site.address);
  await page.getByText(/This browser has no WebAssembly or no workers/).first().waitFor();
});
