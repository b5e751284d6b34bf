// The page in a browser: what a person does with it, and what they must see.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { after, afterEach, before, test } from "node:test";
import { gzipSync } from "node:zlib";
import { launch, open } from "./browser.mjs";
import { RELAX, startServer, WALL } from "./server.mjs";
import { dropped, laidOut, RELAXATION, shows, SIZES, until, violations } from "./views.mjs";

let server, browser;
before(async () => {
  server = await startServer();
  browser = await launch();
});
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});
after(async () => {
  await browser?.close();
  await server?.kill();
});

/** Waits until a part of the page says so. */
const says = (part, words, what, timeout) => until(async () => words.test((await part.allTextContents()).join(" ")), what, timeout);
const addressed = (page, words) => until(() => Promise.resolve(words.test(page.url())), page.url());
const opened = (page, run) => until(() => Promise.resolve(decodeURIComponent(page.url()).includes(`open=${run}`)), `${run}: ${page.url()}`);
const knob = (page, view, label) => page.locator(`.${view} .knob`, { hasText: label });
/** A field of the form of a new run. */
const field = (page, label) => page.locator(".form .fields label", { hasText: label }).locator("input[type=text]").first();
const enter = async (input, text) => {
  await input.fill(text);
  await input.press("Enter");
};
const downloaded = async (page, button, encoding = "utf8") => {
  const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
  return readFileSync(await download.path(), encoding);
};
const newRun = async (page, kind) => {
  await page.locator("button", { hasText: "New run" }).click();
  await page.selectOption("select[aria-label='Experiment']", kind);
};
/** Starts the run of the form, and waits for its end. */
const runs = async (page) => {
  await page.locator(".form button[type=submit]").click();
  await says(page.locator(".runs-list .progress"), /is done/, "the run does not end", 60_000);
};
/** Keeps a picture for whoever names a folder for them. */
const pictured = (page, name) => process.env.PICTURES && page.screenshot({ path: `${process.env.PICTURES}/${name}.png` });
/** The mouse goes to shares of a box. */
const aim = (page, { x, y, width, height }, across, up, steps = 1) => page.mouse.move(x + across * width, y + up * height, { steps });
const depth = (page) => page.locator(".scene").getAttribute("aria-valuenow").then(Number);
const force = async (page) => {
  const text = await page.locator(".scene").getAttribute("aria-valuetext");
  const [, number, prefix] = /force (\S+)\s*(m|µ|n)?N/.exec(text.replace("−", "-")) ?? [];
  return Number(number) * { m: 1e-3, µ: 1e-6, n: 1e-9 }[prefix] || Number(number) || 0;
};
const moving = (page) => until(() => page.evaluate(() => document.querySelector(".scene path.tissue")?.getAttribute("d")?.length > 100), "no tissue");

/** Opens the page, in a loop that runs and is this page's. */
async function begin(options, fragment = "") {
  const opened = await open(browser, server.address + fragment, options);
  if (!/^#(design|runs|control)/.test(fragment)) await moving(opened.page);
  await until(() => opened.page.locator(".device.running").count(), "no loop");
  return opened;
}

/** A test of a page of its own, which writes no error to the console. */
function visit(name, fragment, act, options = {}) {
  test(name, async () => {
    const { page, asked, errors } = await begin(options, fragment);
    await act(page, asked);
    assert.deepEqual(errors, []);
  });
}

/** Takes the hand away from the demonstration. */
async function takeOver(page) {
  await page.keyboard.press("Home");
  await until(async () => (await depth(page)) < -0.5, "the probe did not come out");
}

visit("a controller follows its wishes, and a plant that is none is refused beside its field", "#control?plant=0.55exp(-s)/(62s%2B1)&crossover=0.1&margin=65", async (page) => {
  const verdict = page.locator(".control .verdict");
  await says(verdict, /^C\(s\) = .*stable, proved/, "no controller");
  const margins = page.locator(".control .result tr", { hasText: "phase margin" }).locator("td");
  assert.deepEqual(await margins.allTextContents(), ["65.0°", "65.0°"]);
  assert.match(await page.locator(".control .settings").textContent(), /Plant as read: .*62/);
  assert.equal(await page.locator(".control .result tr", { hasText: "order λ" }).locator("td").count(), 2);
  const margin = page.getByLabel("phase margin, with unit");
  await enter(margin, "50");
  await until(async () => (await margins.first().textContent()) === "50.0°", "the margin did not follow");
  await until(() => Promise.resolve(page.url().includes("margin=50")), "the address did not follow");
  // Command, load and the family of gains are drawn as the step is.
  for (const seen of ["command", "loaded", "gains", "step"]) {
    await page.selectOption("select[aria-label='Over time']", seen);
    await until(() => page.evaluate(() => {
      const canvas = document.querySelector(".control .steps canvas");
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return data.some((value, n) => n % 4 === 2 && value > 140 && data[n - 2] < 90);
    }), `${seen} is not drawn`);
  }
  assert.match(await downloaded(page, page.getByText("Save the controller")), /\[pid\][^]*integral_order/);
  // A controller of one's own stands beside them, until it is left out.
  await dropped(page, "[pid]\nproportional_gain = 5.0\nintegral_gain_per_s_lambda = 0.1\nintegral_order = 1.0\nderivative_gain_s_mu = 0.0\nderivative_order = 1.0\n\n[loop]\nsample_time_s = 0.2\n", "mine.toml");
  await until(async () => (await margins.count()) === 3, "the own controller is not shown");
  await page.getByText("leave out").click();
  await until(async () => (await margins.count()) === 2, "it is not left out");
  const plant = page.getByLabel("Plant, a transfer function");
  await enter(plant, "1/(s+");
  await says(page.locator(".control .knobs > .trouble"), /^plant "1\/\(s\+": character/, "not refused");
  assert.match(await verdict.textContent(), /beside the field/);
  assert.ok(await page.getByText("Save the controller").isDisabled());
  // A plant from a file takes its place.
  await dropped(page, "[transfer_function]\nfunction = \"1/(2s+1)\"\n", "oven.toml");
  await says(page.locator(".control .settings"), /Plant as read: 1\/\(2s\+1\)/, "the file is not read");
});

visit("a controller is judged and run as it is, and what is missing is said beside its field", "#control?plant=1/(s%2B1)", async (page) => {
  await page.getByText("Judge or run a controller as it is").click();
  const own = page.locator(".own-loop");
  await own.getByRole("textbox", { name: /^controller / }).fill("2+1/s");
  await own.getByText("Run it").click();
  const time = own.locator("label", { hasText: "sample time, s" });
  await says(time.locator(".trouble"), /no sample time/, "not refused");
  await time.locator("input").fill("10 ms");
  await own.getByText("Run it").click();
  await until(async () => (await own.locator("canvas").count()) === 1, "the run is not drawn");
  assert.match(await own.textContent(), /plant1\/\(s\+1\)controller2\+1\/s/);
  // It is at its reference at the end.
  assert.equal(await own.locator(".answer-body .trouble").count(), 0);
  await own.getByText("Judge it").click();
  await until(async () => (await own.locator("canvas").count()) === 0, "the verdict is not shown");
  assert.match(await own.textContent(), /stableyes/);
});

visit("it is small, and asks nobody but its server", "", async (page, asked) => {
  const folder = new URL("../../crates/haptic-page/assets/", import.meta.url);
  const names = readdirSync(folder).filter((name) => !/\.(gz|br)$/.test(name));
  const size = names.reduce((sum, name) => sum + gzipSync(readFileSync(new URL(name, folder)), { level: 9 }).length, 0);
  console.log(`# ${(size / 1000).toFixed(0)} kB compressed`);
  assert.ok(size < 400_000, `${size}`);
  for (const key of ["2", "3", "1"]) {
    await page.keyboard.press(key);
    await page.waitForTimeout(300);
  }
  const own = new URL(server.address).origin.replace("http:", "");
  for (const address of asked) assert.ok(address.replace(/^\w+:/, "").startsWith(own) || /^(data|blob):/.test(address), address);
});

visit("the first visit shows a tissue that moves, and one sentence", "", async (page) => {
  await until(async () => (await depth(page)) > 0.5, "the demonstration does not push");
  assert.match(await page.locator(".feel h2").first().textContent(), /Push the tissue: drag the probe/);
});

visit("the probe is dragged into the tissue, is pushed back, and the tissue bends", "", async (page) => {
  await takeOver(page);
  const box = await page.locator(".scene").boundingBox();
  const y = box.y + box.height / 2;
  const flat = await page.locator("path.tissue").getAttribute("d");
  await page.mouse.move(box.x + box.width * 0.2, y);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.5, y, { steps: 12 });
  await until(async () => (await depth(page)) > 1, "the probe did not go in");
  await until(async () => (await force(page)) > 0.02, "there is no force");
  let first = 0;
  for (const end = Date.now() + 1200; Date.now() < end; ) first = Math.max(first, await force(page));
  await page.waitForTimeout(2500);
  const later = await force(page);
  assert.ok(later < first && later > 0.2 * first, `it relaxes: at most ${first} N, then ${later} N`);
  assert.notEqual(await page.locator("path.tissue").getAttribute("d"), flat);
  // It remembers: drawn back quickly, the surface stays behind for a while.
  await page.mouse.move(box.x + box.width * 0.08, y, { steps: 4 });
  await until(async () => (await depth(page)) < 0, "the probe did not come out");
  await page.mouse.up();
  assert.ok((await force(page)) < 1e-3);
});

test("what is drawn is what was sent, to a pixel's worth", async () => {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  // Least and most of the force in each column that was sent, by its first tick: each frame goes on from those before it.
  let [sent, width, sample] = [new Map(), 0, 0];
  const taken = (frame) => {
    const [channels, columns] = [8, 12].map((at) => frame.readUInt32LE(at));
    const [first, ticks, period, picture] = [16, 24, 32, 40].map((at) => frame.readDoubleLE(at));
    assert.ok(channels >= 7);
    if (ticks !== width || first <= picture) sent = new Map();
    [width, sample] = [ticks, period];
    const at = (part, column) => -frame.readFloatLE(52 + 4 * (part * columns + column));
    for (let column = 0; column < columns; column += 1) sent.set(first + column * width, [at(4, column), at(5, column)]);
    for (const tick of sent.keys()) if (tick < picture) sent.delete(tick);
  };
  page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => typeof payload !== "string" && taken(Buffer.from(payload))));
  await page.goto(server.address);
  await moving(page);
  await page.selectOption("select[aria-label='Compare with']", "");
  // Until the hand of the demonstration has pushed; a busy machine takes longer.
  await until(() => Promise.resolve(sent.size > 70 && [...sent.values()].some(([most]) => most > 0.02)), "no columns with a force", 120_000);
  await page.keyboard.press("p");
  await until(() => page.locator(".device.paused").count(), "it does not pause");
  await page.waitForTimeout(500);
  const picture = await page.evaluate(() => {
    const root = document.querySelector(".chart[aria-label='Force over time']");
    const canvas = root.querySelector("canvas");
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const rows = Array.from({ length: width }, () => []);
    for (let y = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1) {
        const [r, g, b, a] = data.slice(4 * (y * width + x), 4 * (y * width + x) + 4);
        if (a > 120 && b > 140 && r < 90 && g < 160) rows[x].push(y);
      }
    }
    return { scale: JSON.parse(root.dataset.scale), rows };
  });
  const { scale, rows } = picture;
  const ticks = [...sent.keys()].sort((a, b) => a - b);
  const end = (ticks.at(-1) + width) * sample;
  const px = (t) => scale.left + ((t - scale.x[0]) / (scale.x[1] - scale.x[0])) * scale.width;
  const py = (f) => scale.top + ((scale.y[1] - f) / (scale.y[1] - scale.y[0])) * scale.height;
  let [checked, peak] = [0, 0];
  for (const column of ticks.slice(1, -1)) {
    const [most, least] = sent.get(column);
    if (Number.isNaN(most) || Number.isNaN(least)) continue;
    peak = Math.max(peak, most);
    const x = px((column + 0.5 * width) * sample - end);
    if (x < scale.left + 2 || x > scale.left + scale.width - 2) continue;
    const near = [-1, 0, 1].flatMap((dx) => rows[Math.round(x) + dx] ?? []);
    assert.ok(near.length > 0, `nothing is drawn at column ${column}`);
    // Two pixels of stroke and one of the grid of pixels.
    for (const value of [most, least]) {
      const y = py(value);
      assert.ok(near.some((row) => Math.abs(row + 0.5 - y) <= 2), `column ${column}: ${value} N is at ${y}, drawn at ${near}`);
    }
    checked += 1;
  }
  assert.ok(checked > 50 && peak > 0.01, `${checked} columns, ${peak} N`);
  await page.keyboard.press("p");
});

visit("keys alone: arrows push, Home lets go, space stops, R starts again", "", async (page) => {
  await takeOver(page);
  await page.keyboard.down("ArrowRight");
  await until(async () => (await force(page)) > 0.01, "the arrow key does not push");
  await page.keyboard.up("ArrowRight");
  await page.keyboard.press(" ");
  await until(() => page.locator(".device.stopped").count(), "space does not stop");
  await until(async () => (await force(page)) < 1e-3, "there is still a force");
  assert.match(await page.locator(".banner").textContent(), /Stopped: the force is zero/);
  await page.keyboard.press("r");
  await until(() => page.locator(".device.running").count(), "it does not start again");
  await page.keyboard.press("?");
  assert.ok(await page.locator("dialog.help").isVisible());
  await page.keyboard.press("Escape");
  // Every control is reached with Tab, and the focus is seen.
  const reached = new Set();
  for (let n = 0; n < 24; n += 1) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => {
      const { activeElement: at } = document;
      const seen = at.matches(":focus-visible");
      return `${at.tagName}.${at.className || at.type || ""}${seen ? "" : " unseen"}`;
    }));
  }
  for (const want of ["BUTTON.stop", "DIV.scene", "SELECT.select-one", "INPUT.range"]) assert.ok([...reached].some((each) => each.startsWith(want)), `${want} of ${[...reached]}`);
  assert.ok(![...reached].some((each) => each.includes("unseen") && !each.startsWith("BODY")), `${[...reached]}`);
});

visit("sliders and fields change the law while it runs, and the address keeps it", "", async (page) => {
  const order = knob(page, "feel", "order");
  await order.locator("input[type=range]").focus();
  for (let n = 0; n < 5; n += 1) await page.keyboard.press("ArrowRight");
  await until(async () => Math.abs(Number(await order.locator(".value").inputValue()) - 0.23) < 0.0051, "the order did not change");
  await addressed(page, /order=0\.23/);
  const dissipation = knob(page, "feel", "dissipation B");
  await enter(dissipation.locator(".value"), "60");
  await addressed(page, /B=60(&|$)/);
  // The answer to the former change, if it comes after, takes the words away.
  await until(async () => {
    await enter(dissipation.locator(".value"), "nonsense");
    await page.waitForTimeout(300);
    return /is not a number/.test(await dissipation.locator(".trouble").textContent());
  }, "nonsense is not refused");
  const address = page.url();
  // A copied address opens the same page.
  const copied = await begin({}, new URL(address).hash);
  await until(async () => (await knob(copied.page, "feel", "dissipation B").locator(".value").inputValue()).startsWith("60"), "the copied address is another");
});

visit("Compare: two walls are felt blind, answered by keys, and counted at the end", "#feel?order=1&K=300&B=0&m=0.065&b=3.5", async (page) => {
  const card = page.locator(".compare");
  const told = (words) => says(card.locator("[role=status]"), words, String(words));
  const press = async (name) => {
    await page.getByRole("button", { name }).focus();
    await page.keyboard.press("Enter");
  };
  await page.getByText("Compare two walls, blind").click();
  await page.getByLabel("Trials").fill("2");
  await page.getByLabel("B is stiffer by, %").fill("50");
  await press("Begin");
  const charts = page.locator(".feel .right");
  await told(/^Trial 1 of 2: ask for wall 1/);
  await until(async () => !(await charts.isVisible()) && !(await page.getByLabel("stiffness K, with unit").isVisible()), "it is not blind");
  const answer = page.getByRole("button", { name: "2 was stiffer" });
  const force = () => page.locator(".scene").getAttribute("aria-valuetext");
  for (const trial of [1, 2]) {
    for (const wall of [1, 2]) {
      await until(async () => !(await answer.isVisible()), "an answer before the walls");
      await press("Next wall");
      await page.keyboard.press("Home");
      await told(new RegExp(`^Trial ${trial} of 2: press wall ${wall}`));
      await until(async () => (await depth(page)) < -0.5, "the probe did not come out");
      await page.keyboard.down("ArrowRight");
      await told(wall === 1 ? /ask for wall 2/ : /which was stiffer/);
      assert.match(await force(), /force 0\b/);
      assert.ok(!(await page.locator(".scene .arrow").isVisible()), "the force is shown");
      await page.keyboard.up("ArrowRight");
    }
    await press("2 was stiffer");
  }
  await told(/^[012] of 2 answers were right; the table is compare-0001\/compare.csv/);
  assert.ok(await charts.isVisible());
});

visit("Is it safe? shows the verdict of the server, and a map of what runs or none", "#feel?tissue=prostate-cancerous&order=0.2247&K=0&B=173&scale=1&m=0.065&b=3.5&ghosts=none", async (page) => {
  const card = page.locator(".feel .right .card", { hasText: "Is it safe?" });
  const verdict = () => card.locator("h2 span").textContent();
  const told = () => page.evaluate(() => new Promise((resolve) => {
    const socket = new WebSocket(new URL("ws", location.href.split("#")[0]).href.replace("http", "ws"));
    socket.onopen = () => socket.send(JSON.stringify({ id: 1, do: "hello", version: 1 }));
    socket.onmessage = ({ data }) => typeof data === "string" && JSON.parse(data).id === 1 && (resolve(JSON.parse(data).feel.verdict), socket.close());
  }));
  const agrees = async () => {
    const { stable, passive, margin } = await told();
    const said = await verdict();
    return said.startsWith(stable ? "stable, margin " : "unstable, margin ") && said.endsWith(passive ? "· passive" : "· not passive") && Math.abs(Number(/margin ([\d.]+)/.exec(said)?.[1]) - margin) < 0.006 * margin;
  };
  await until(agrees, "another verdict than the server's");
  const map = card.locator("svg.map");
  await until(async () => ((await map.locator("path.stable").getAttribute("d")) ?? "").length > 200, "no map of a spring-pot");
  await says(card, /: proved up to B = /, "nothing is said of every motion");
  assert.match(await card.textContent(), /Prediction: a hand should (not )?tell this wall from the best spring and damper, K = .*most at [\d.]+.Hz, [\d.]+ × the least/);
  // The size of the specimen changes the margin by as much.
  const before = (await told()).margin;
  const dissipation = knob(page, "feel", "dissipation B").locator(".value");
  await enter(dissipation, "346");
  await until(async () => Math.abs((await told()).margin - before / 2) < 0.01 * before && (await agrees()), "the verdict does not follow");
  // A model of more elements: its verdict is the server's, and it has no map.
  await page.selectOption("select[aria-label='Tissue']", "fish-muscle");
  await until(async () => !(await map.isVisible()) && (await card.locator(".hint").first().isVisible()) && (await agrees()), "a map of something else");
  assert.match(await verdict(), /^stable, margin 19\.2 /);
});

visit("no key on a slider is lost, whatever the server answers meanwhile", "#feel?tissue=prostate-cancerous&order=0.2&K=0&B=173&scale=1&m=0.065&b=3.5&ghosts=none", async (page) => {
  const press = async (slider, expected, name) => {
    await slider.focus();
    const before = Number(await slider.inputValue());
    for (let n = 0; n < 60; n += 1) {
      await page.keyboard.press("ArrowRight");
      await page.waitForTimeout(8);
    }
    assert.equal(Number(await slider.inputValue()) - before, 60, name);
    await until(expected, `${name}: ${page.url()}`);
    assert.equal(Number(await slider.inputValue()) - before, 60, `${name}, later`);
  };
  await until(async () => (await knob(page, "feel", "order").locator("input[type=range]").inputValue()) === "200", "the address is not opened");
  await press(knob(page, "feel", "order").locator("input[type=range]"), () => Promise.resolve(/order=0\.26(&|$)/.test(page.url())), "order");
  const dissipation = knob(page, "feel", "dissipation B").locator("input[type=range]");
  await press(dissipation, async () => /B=(\d+)/.exec(page.url())?.[1] !== "173", "dissipation");
  // Both edits are there.
  assert.match(page.url(), /order=0\.26(&|$)/);
  // Where neighbouring steps show the same digits, too.
  await page.keyboard.press("2");
  await enter(knob(page, "design", "order").locator(".value"), "1");
  await addressed(page, /mu=1(&|$)/);
  await press(knob(page, "design", "order").locator("input[type=range]"), () => Promise.resolve(/mu=1\.12(&|$)/.test(page.url())), "order of Design");
});

test("an edit that is refused is taken back with a sentence, the others stay", async () => {
  const { page } = await begin({}, "#feel?tissue=prostate-cancerous&order=0.3&K=0&B=173&scale=1&m=0.065&b=3.5&ghosts=none");
  const order = knob(page, "feel", "order").locator(".value");
  await until(async () => (await order.inputValue()) === "0.300", "the address is not opened");
  // K = 0 leaves nothing to hold such a wall: B is at its most.
  await enter(knob(page, "feel", "dissipation B").locator(".value"), "2000");
  await addressed(page, /B=2000(&|$)/);
  await enter(order, "1");
  await says(page.locator(".notice"), /unstable/, "it is not refused");
  await until(async () => (await order.inputValue()) === "0.300", "the refused number stays");
  await addressed(page, /order=0\.3(&|$)/);
});

visit("space stops wherever the focus is but in a text field, where Escape gives up the edit", "#feel?tissue=prostate-cancerous&order=0.2247&K=0&B=173&scale=1&m=0.065&b=3.5&ghosts=short,a3", async (page) => {
  const stops = async (what) => {
    await page.keyboard.press(" ");
    await until(() => page.locator(".device.stopped").count(), `space does not stop with the focus on ${what}`);
    await page.locator("button.start").click();
    await until(() => page.locator(".device.running").count(), "Start does not start");
  };
  for (const focus of [".scene", "select[aria-label='Tissue']", ".feel input[type=range]", "nav a", ".record", "button.stop"]) {
    await page.locator(focus).first().focus();
    await stops(focus);
  }
  const tissue = await page.locator("select[aria-label='Tissue']").inputValue();
  // A list goes on by its keys, which are no commands there.
  await page.locator("select[aria-label='Compare with']").focus();
  await page.keyboard.press("ArrowDown");
  await addressed(page, /ghosts=short(&|$)/);
  await page.keyboard.press("2");
  assert.match(page.url(), /#feel/);
  const field = knob(page, "feel", "dissipation B").locator(".value");
  const kept = await field.inputValue();
  await field.focus();
  await page.keyboard.type("12 34");
  assert.equal(await field.inputValue(), "12 34", "a space in a text field is a space");
  assert.equal(await page.locator(".device.stopped").count(), 0);
  await page.keyboard.press("Escape");
  assert.equal(await field.inputValue(), kept);
  assert.equal(await page.evaluate(() => document.activeElement.tagName), "BODY");
  await page.waitForTimeout(400);
  assert.equal(await page.locator("select[aria-label='Tissue']").inputValue(), tissue);
  assert.match(page.url(), /B=173(&|$)/);
  // Boxes in Runs: Enter ticks, space stops, the focus stays.
  await page.keyboard.press("3");
  const box = page.locator(".list label", { hasText: WALL }).locator("input");
  await box.focus();
  await page.keyboard.press("Enter");
  await opened(page, WALL);
  assert.equal(await page.evaluate(() => document.activeElement.dataset.run), WALL);
  assert.equal(await box.isChecked(), true);
  await stops("a box");
  assert.equal(await box.isChecked(), true);
  await box.focus();
  await page.keyboard.press("Enter");
  await until(async () => !(await box.isChecked()), "Enter does not untick");
});

visit("a finger stops and starts again", "", async (page) => {
  assert.equal(await page.locator("button.start").isVisible(), false);
  await page.locator("button.stop").tap();
  await until(() => page.locator("button.start").isVisible(), "no Start");
  const [stop, start] = [await page.locator("button.stop").boundingBox(), await page.locator("button.start").boundingBox()];
  assert.ok(Math.abs(stop.y - start.y) < 8 && Math.abs(stop.x - start.x - start.width) < 40, "Start is not beside Stop");
  assert.ok(stop.x + stop.width <= 820, "Stop is not on the screen");
  await page.locator("button.start").tap();
  await until(() => page.locator(".device.running").count(), "it does not start again");
  await until(async () => !(await page.locator("button.start").isVisible()), "Start stays");
}, { hasTouch: true, viewport: { width: 820, height: 1180 } });

const SCALED = "tissue=prostate-healthy&order=0.31&K=0&B=72.2&scale=2.5&m=0.08&b=4&ghosts=a3";
visit("the address opens the same page, its scale too, also on the way back", `#feel?${SCALED}`, async (page) => {
  const same = () => {
    const [now, wanted] = [page.url().split("?").at(-1), SCALED].map((text) => new URLSearchParams(text));
    return [...wanted].every(([key, value]) => key === "ghosts" || key === "tissue" ? now.get(key) === value : Math.abs(Number(now.get(key)) - Number(value)) < 1e-3 * Number(value) + 1e-12);
  };
  await until(async () => same() && (await page.locator("select[aria-label='Tissue']").inputValue()) === "prostate-healthy", `another page: ${page.url()}`);
  assert.equal(await knob(page, "feel", "order").locator(".value").inputValue(), "0.310");
  assert.match(await knob(page, "feel", "dissipation B").locator(".value").inputValue(), /^18[01]/);
  assert.equal(await page.locator("select[aria-label='Compare with']").inputValue(), "a3");
  await page.keyboard.press("2");
  const stiffness = knob(page, "design", "stiffness K").locator(".value");
  await enter(stiffness, "250");
  await page.selectOption("select[aria-label='Operator']", "muir:3");
  await addressed(page, /#design.*K=250.*operator=muir/);
  const design = page.url();
  await page.goBack();
  await until(() => Promise.resolve(/#feel/.test(page.url()) && same()), page.url());
  await page.goForward();
  await until(async () => page.url() === design && (await stiffness.inputValue()).startsWith("250"), page.url());
});

visit("markers, cursor values and zoom", "", async (page) => {
  await page.waitForTimeout(4500);
  await page.keyboard.press("m");
  const chart = page.locator(".chart[aria-label='Force over time'] .u-over");
  const box = await chart.boundingBox();
  await aim(page, box, 0.98, 0.5);
  await says(page.locator(".right h2").first(), / at /, "no cursor value");
  await aim(page, box, 0.9, 0.5);
  await page.mouse.down();
  await aim(page, box, 0.99, 0.5, 5);
  await page.mouse.up();
  await until(() => page.locator("text=show now").isVisible(), "it does not zoom");
  const scale = await until(() => page.evaluate(() => {
    const { x } = JSON.parse(document.querySelector(".chart[aria-label='Force over time']").dataset.scale);
    return x[1] - x[0] < 5 ? x : null;
  }), "the span is not the chosen one");
  assert.ok(scale[0] >= -0.5);
  // The picture of the past stands, the probe goes on.
  await takeOver(page);
  await page.keyboard.down("ArrowRight");
  await until(async () => (await depth(page)) > 0, "a zoomed picture holds the probe");
  await page.keyboard.up("ArrowRight");
  await page.mouse.move(box.x, box.y - 60);
  await page.keyboard.press("Escape");
  await until(async () => !(await page.locator("text=show now").isVisible()), "Escape does not go back");
});

visit("Design: a region follows the slider, the point is dragged, units are read", "#design", async (page) => {
  const region = page.locator(".design path.stable");
  await until(async () => (await region.getAttribute("d"))?.length > 200, "no region");
  const before = await region.getAttribute("d");
  await knob(page, "design", "order").locator("input[type=range]").press("ArrowRight");
  await until(async () => (await region.getAttribute("d")) !== before, "the region does not follow");

  const box = await page.locator(".design svg.map").boundingBox();
  await aim(page, box, 0.3, 0.7);
  await page.mouse.down();
  await aim(page, box, 0.95, 0.1, 6);
  await page.mouse.up();
  const every = () => page.locator(".design .figures dt", { hasText: "every motion" }).locator("xpath=following-sibling::dd[1]").textContent();
  await says(page.locator(".design .verdict"), /unstable/, "far outside is not unstable");
  assert.equal(await every(), "unstable");
  const mass = knob(page, "design", "mass");
  await enter(mass.locator(".value"), "45 g");
  await addressed(page, /[?&]m=0\.045(&|$)/);
  await enter(mass.locator(".value"), "45 parsecs");
  await says(mass.locator(".trouble"), /is not a mass/, "parsecs are not refused");
  assert.match(await downloaded(page, page.locator("text=Save as experiment file")), /\[wall\][^]*mass_kg = 0\.045/);
});

visit("a wall of Design runs in the loop; one that is not stable is refused with a sentence", "#design?K=200&B=5&mu=0.5&T=0.001&m=0.065&b=3.5", async (page) => {
  await until(async () => (await page.locator(".design path.stable").getAttribute("d"))?.length > 200, "no region");
  assert.match(await page.locator(".design .figures").textContent(), /every motionproved up to K = /);
  assert.match(await page.locator(".design .margins .hint").textContent(), /^Prediction: a hand should /);
  await page.locator("text=Use in the loop").click();
  await addressed(page, /#feel\?.*K=200&B=5/);
  assert.ok(await knob(page, "feel", "stiffness K").isVisible());
  await page.goto(`${server.address}#design?K=900000&B=0&mu=0.5&T=0.001&m=0.065&b=3.5`);
  await page.keyboard.press("2");
  await page.locator("text=Use in the loop").click();
  await says(page.locator(".notice"), /.{20}/, "it is not refused");
});

visit("Runs: one is started from a form, watched, opened, laid over another, and kept as files", "#runs", async (page) => {
  for (let round = 0; round < 2; round += 1) {
    await newRun(page, "wall");
    await page.locator(".form input").first().waitFor();
    if (round === 0) {
      await field(page, /^order/).fill("");
      await page.locator(".form button[type=submit]").click();
      await says(page.locator(".form .trouble"), /.{10}/, "a form that lacks something is not refused");
      const seen = await page.evaluate(() => {
        const trouble = [...document.querySelectorAll(".fields .trouble")].find((one) => one.textContent !== "");
        const field = trouble.parentElement.querySelector("input");
        const { outlineOffset, outlineWidth } = getComputedStyle(field);
        const ring = field.getBoundingClientRect().bottom + parseFloat(outlineOffset) + parseFloat(outlineWidth);
        return { focused: document.activeElement === field, red: getComputedStyle(trouble).color, bad: getComputedStyle(document.documentElement).getPropertyValue("--bad"), room: trouble.getBoundingClientRect().top - ring };
      });
      assert.ok(seen.focused && seen.room >= 0, JSON.stringify(seen));
      const [red, green, blue] = /#(..)(..)(..)/.exec(seen.bad).slice(1).map((part) => parseInt(part, 16));
      assert.equal(seen.red, `rgb(${red}, ${green}, ${blue})`);
    }
    await page.evaluate(() => document.querySelectorAll(".form details").forEach((each) => (each.open = true)));
    await field(page, /^order/).fill(round === 0 ? "0.5" : "1");
    await field(page, /^dissipation/).fill("10");
    await field(page, /^stiffness/).fill("1 kN/m");
    await runs(page);
  }
  const boxes = page.locator(".list input[type=checkbox]");
  await until(async () => (await boxes.count()) >= 2, "the runs are not listed");
  for (const box of (await boxes.all()).slice(0, 2)) await box.check();
  await until(() => page.evaluate(() => document.querySelectorAll(".overlay .chart canvas").length === 2), "no charts");
  await addressed(page, /open=/);
  await until(() => page.evaluate(() => document.querySelector(".overlay-part select").value !== ""), "no channel");
  // On a busy machine the second run is drawn later.
  await until(() => page.evaluate(() => {
    const legend = document.querySelector(".overlay .legend");
    const scale = JSON.parse(legend?.nextElementSibling?.dataset.scale ?? "null");
    const runs = [...(legend?.children ?? [])].filter((line) => line.textContent.startsWith("wall-"));
    return runs.length === 2 && typeof scale?.x[0] === "number";
  }), "the runs are not both drawn");
  const kept = (name) => downloaded(page, page.locator(".files button", { hasText: name }), "latin1");
  assert.ok((await kept("PNG")).startsWith("\x89PNG"));
  const svg = await kept("SVG");
  const opened = new URLSearchParams(page.url().split("?").at(-1)).get("open").split(",");
  for (const run of opened) assert.match(svg, new RegExp(`<text [^>]*>${run} \\w+</text>`), "no legend");
  // One run alone: a table is its samples, all of them, of the channels that are chosen.
  await boxes.nth(1).uncheck();
  await until(() => page.evaluate(() => document.querySelectorAll(".facts h3").length === 1), "it is still open");
  const samples = Number(/^(\d+) of/.exec(await page.locator(".facts dd").first().textContent())[1]);
  await page.locator("select[aria-label='Channel below']").selectOption("position_m");
  await page.locator("select[aria-label='Channel above']").selectOption("contact_force_n");
  // At once: what is not drawn yet has its own name all the same.
  const rows = (await kept("CSV")).trim().split("\n").map((line) => line.split(","));
  assert.deepEqual(rows[0], ["time_s", "contact_force_n", "position_m"]);
  assert.equal(rows.length - 1, samples);
  const [first, last] = [rows[1], rows.at(-1)].map(([time]) => Number(time));
  await until(async () => (await page.locator(".overlay .legend").first().textContent()).startsWith("contact force, N"), "no such curve");
  // The cursor says the values, and a zoom chooses the samples.
  const box = await page.locator(".overlay .u-over").first().boundingBox();
  await aim(page, box, 0.5, 0.5);
  await says(page.locator(".overlay .legend b").first(), /^−?[\d.·⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+$/, "no value at the cursor");
  const at = Number(/at ([\d.]+) s/.exec(await page.locator(".overlay h2 span").first().textContent())[1]);
  assert.ok(Math.abs(at - (first + last) / 2) < 0.02 * (last - first), `${at}`);
  const said = Number((await page.locator(".overlay .legend b").last().textContent()).replace("−", "-").replace(/·10.*/, ""));
  assert.ok(Number.isFinite(said));
  await page.mouse.down();
  await aim(page, box, 0.75, 0.5, 5);
  await page.mouse.up();
  await until(() => page.locator("text=show all").isVisible(), "no zoom");
  const part = (await kept("CSV")).trim().split("\n").slice(1).map((line) => Number(line.split(",")[0]));
  assert.ok(Math.abs(part.length / samples - 0.25) < 0.03, `${part.length} of ${samples}`);
  assert.ok(Math.abs(part[0] - at) < 0.02 * (last - first) && part.at(-1) < last);
  // The address opens the same runs, channels and span.
  await addressed(page, /above=contact_force_n.*from=[\d.]+&to=/);
  const copied = await begin({}, new URL(page.url()).hash);
  await until(async () => (await copied.page.locator(".overlay .legend").first().textContent().catch(() => "")).startsWith("contact force, N"), "another channel");
  await until(() => copied.page.locator("text=show all").isVisible(), "another span");
  assert.equal(await copied.page.locator(".facts h3").textContent(), opened[0]);
});

test("Runs: a chart that is closed is gone", async () => {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  await page.addInitScript(() => {
    globalThis.watched = 0;
    const { observe, disconnect } = ResizeObserver.prototype;
    ResizeObserver.prototype.observe = function (...given) {
      globalThis.watched += 1;
      observe.apply(this, given);
    };
    ResizeObserver.prototype.disconnect = function () {
      globalThis.watched -= 1;
      disconnect.apply(this);
    };
  });
  await page.goto(`${server.address}#runs`);
  await page.keyboard.press("3");
  const box = page.locator(".list input[type=checkbox]").first();
  await box.waitFor();
  const counts = [];
  for (let round = 0; round < 6; round += 1) {
    await box.check();
    await until(() => page.evaluate(() => document.querySelectorAll(".overlay .chart canvas").length === 2), "no charts");
    counts.push(await page.evaluate(() => globalThis.watched));
    await box.uncheck();
    await page.waitForTimeout(150);
  }
  assert.ok(Math.max(...counts) <= counts[0] && counts[0] > 0, `${counts}`);
});

visit("Runs: a log with two axes shows components, the norm, and the plane with its shape", "#runs", async (page) => {
  await newRun(page, "touch");
  await field(page, /^centre, m/).fill("0, 0 mm");
  await runs(page);
  await until(() => page.locator(".plane-card .track:not(.whole)").isVisible(), "no plane");
  await until(async () => ((await page.locator(".plane .track:not(.whole)").getAttribute("d")) ?? "").length > 500, "no path");
  assert.ok(((await page.locator(".plane .matter").getAttribute("d")) ?? "").includes("a"), "no disc");
  const legends = await page.locator(".overlay .legend").allTextContents();
  assert.match(legends[0], /x.*y.*norm/);
  assert.match(legends[1], /^xy$/);
  // The cursor of a chart is a place in the plane, with the force there.
  const before = await page.locator(".plane-card h2 span").textContent();
  const box = await page.locator(".overlay .u-over").first().boundingBox();
  await aim(page, box, 0.4, 0.5);
  await until(async () => (await page.locator(".plane-card h2 span").textContent()) !== before, "the cursor does nothing");
  assert.match(await page.locator(".plane-card h2 span").textContent(), /N at [0-9.]+ s/);
  // A zoom in time draws that part of the path strongly, the rest behind it.
  await page.mouse.down();
  await aim(page, box, 0.6, 0.5, 5);
  await page.mouse.up();
  await until(async () => ((await page.locator(".plane .track.whole").getAttribute("d")) ?? "").length > 500, "no zoom");
  await page.keyboard.press("Escape");
  await until(async () => ((await page.locator(".plane .track.whole").getAttribute("d")) ?? "") === "", "no way back");
  // A component by itself.
  await page.locator("select[aria-label='Channel above']").selectOption("commanded_force_y_n");
  await until(async () => (await page.locator(".overlay .legend").first().textContent()) === "commanded force y, N", "no component by itself");
  await pictured(page, "touch");
});

visit("Runs: a Z-width is asked for from its form and answered by map and tables, and stays in the list", "#runs", async (page) => {
  await newRun(page, "zwidth");
  assert.equal(await page.locator("#realtime").isVisible(), false);
  await field(page, /^orders/).fill("0, nonsense");
  await page.locator(".form button[type=submit]").click();
  await says(page.locator(".form .trouble"), /orders.*nonsense/, "nonsense is not refused");
  await field(page, /^orders/).fill("0, 1");
  await field(page, /^points/).fill("3");
  await page.locator(".form button[type=submit]").click();
  await says(page.locator(".answer .verdict"), /stiffest wall/, "no answer", 120_000);
  await until(async () => (await page.locator(".answer table").count()) === 2, "not two tables");
  await until(() => page.locator(".answer .chart canvas").isVisible(), "no map");
  assert.ok((await page.locator(".answer tbody tr").first().textContent()).length > 3);
  assert.equal(JSON.parse(await downloaded(page, page.locator(".answer button", { hasText: "JSON" }))).orders.length, 2);
  assert.match(page.url(), /answer=zwidth/);
  await pictured(page, "zwidth");
  // Away, and back by the list.
  await page.locator("button", { hasText: "New run" }).click();
  await page.locator(".list .row", { hasText: "zwidth" }).first().click();
  await until(() => page.locator(".answer .verdict").isVisible(), "the list does not lead back");
});

visit("Runs: of the walls that none beats one is chosen by key and click, and felt", "#runs", async (page) => {
  await newRun(page, "design");
  await page.locator(".form .fields label", { hasText: /^front/ }).locator("input[type=checkbox]").check();
  await page.locator(".form button[type=submit]").click();
  const map = page.locator(".answer svg.front");
  await until(() => map.isVisible(), "no map", 120_000);
  const words = page.locator(".answer .front-holder .hint");
  const first = await words.textContent();
  assert.match(first, /μ = .*gain margin 2\.00 .*felt/);
  await map.press("ArrowRight");
  const second = await words.textContent();
  assert.notEqual(second, first);
  const dot = await map.locator("circle").nth(40).boundingBox();
  await page.mouse.click(dot.x + dot.width / 2, dot.y + dot.height / 2);
  await until(async () => (await words.textContent()) !== second, "a click chooses none");
  const stiffness = / K = ([\d.]+) N\/m/.exec(await words.textContent())[1];
  await pictured(page, "front");
  await page.locator(".answer button", { hasText: "Use in the loop" }).click();
  await until(async () => new RegExp(`K=${stiffness.slice(0, 3)}`).test(page.url()), `it is not felt: ${page.url()}`);
});

visit("a CSV that is dropped is identified; one that is none is refused with a sentence", "#runs", async (page) => {
  const drop = (text, name) => dropped(page, text, name);
  await drop(RELAXATION, "record.csv");
  await says(page.locator(".identify .hint").first(), /record\.csv: .*200 samples/, "it is not identified", 30_000);
  assert.ok((await page.locator(".identify tbody tr").count()) > 0);
  // A sphere of 4 mm, by Hertz: f = 16/9·√R·E·δ^1.5, E = 1 kPa, at a depth that grows to 1 mm within 1 s.
  const depths = Array.from({ length: 200 }, (_, n) => (n / 199) * 1e-3);
  await drop(`time_s,position_m,force_n\n${depths.map((d) => `${d * 1000},${d},${(16 / 9) * Math.sqrt(4e-3) * 1000 * d ** 1.5}`).join("\n")}\n`, "sphere.csv");
  await until(async () => (await page.locator(".identify p.trouble").count()) === 1, "a force without a specimen is not refused", 30_000);
  await page.getByText("How it is read").click();
  await says(page.locator(".identify .result table").first(), /position_m/, "its columns are not explained");
  await pictured(page, "explained");
  const field = (name) => page.locator(".identify .fields label", { hasText: name });
  await field(/^loading/).locator("select").selectOption("sphere");
  assert.equal(await field(/^half angle/).isVisible(), false);
  assert.ok(await field(/^bonded/).isVisible());
  await field(/^indenter radius/).locator("input").fill("4 mm");
  await field(/^indenter radius/).locator("input").blur();
  await says(page.locator(".identify .hint").first(), /sphere\.csv: record, 200 samples, Young's modulus/, "the indentation is not identified", 30_000);
  await pictured(page, "identify");
  await drop("GIF89a\u0000\u0001 no table at all", "picture.csv");
  await until(async () => (await page.locator(".identify p.trouble").allTextContents()).join("").length > 10, "garbage is not refused", 15_000);
});

visit("a tissue that was identified is saved once, and felt", "", async (page) => {
  await dropped(page, RELAXATION, "My gel.csv");
  await until(() => page.locator(".identify .chart canvas").isVisible(), "no chart", 30_000);
  const text = await page.locator(".identify tbody").first().textContent();
  assert.match(text, /order 0\.[23]\d* \(0\.\d+ to 0\.\d+\)/);
  const name = page.getByLabel("Name of the tissue");
  await name.fill("My Gel");
  await page.getByText("Save as tissue").click();
  await says(page.locator(".keep"), /is not made of lower-case letters/, "a bad name is not refused");
  await name.fill("my-gel");
  await page.getByText("Save as tissue").click();
  await says(page.locator(".keep"), /Saved in .*tissues.my-gel\.toml/, "it is not saved");
  await page.getByText("Feel it").click();
  await addressed(page, /#feel\?tissue=my-gel&/);
  await moving(page);
  assert.equal(await page.locator("select[aria-label='Tissue']").inputValue(), "my-gel");
  // The same once more is another tissue of that name.
  await dropped(page, RELAXATION, "My gel.csv");
  await until(() => page.locator(".keep").isVisible(), "no tissue", 30_000);
  await name.fill("my-gel");
  await page.getByText("Save as tissue").click();
  await says(page.locator(".keep"), /already/, "it was overwritten");
});

test("a file that falls anywhere goes where it belongs; any other is refused with a sentence", async () => {
  const { page, errors } = await begin();
  await dropped(page, "[wall]\norder = 0.75\nstiffness_n_per_m = 1234.0\ndissipation_n_s_mu_per_m = 5.0\none_sided = true\n", "wall.toml");
  const field = (name) => page.locator(".form .fields label", { hasText: name }).locator("input").first();
  await until(async () => (await page.locator(".form .fields").count()) > 0 && (await field(/^order/).inputValue()) === "0.75", "the form is not filled");
  assert.equal(await field(/^stiffness/).inputValue(), "1234");
  assert.ok(await field(/^one sided/).isChecked());
  await page.keyboard.press("1");
  await dropped(page, "GIF89a", "picture.gif");
  await says(page.locator(".notice"), /picture\.gif is no file for this page/, "a picture is not refused");
  await dropped(page, "[dance]\n", "dance.toml");
  await says(page.locator(".notice"), /dance\.toml.*\[wall\]/, "a dance is not refused");
  assert.match(page.url(), /#feel/);
  assert.deepEqual(errors, []);
  // A log is opened where it lies, which a browser does not say.
  await dropped(page, "a log", "far away.mcap");
  await says(page.locator(".notice"), /far away\.mcap is not in the folder of the runs/, "a log from elsewhere is not refused");
  await dropped(page, "x".repeat(server.wallBytes), "wall.mcap");
  await opened(page, WALL);
  await until(() => page.evaluate(() => document.querySelectorAll(".overlay .chart canvas").length === 2), "it is not opened");
});

visit("force over depth is drawn beside the charts of Feel and of a run", "#feel?tissue=prostate-cancerous&order=0.2247&K=0&B=173&scale=1&m=0.065&b=3.5&ghosts=none", async (page) => {
  const path = (view) => page.locator(`.${view} .depth-holder .track`).last().getAttribute("d");
  await until(async () => ((await path("feel")) ?? "").length > 100, "not in Feel");
  await page.evaluate((hash) => (location.hash = hash), `#runs?open=${WALL},${RELAX}`);
  await until(async () => (await page.locator(".runs .depth-holder .track").count()) === 2 && (await path("runs")).length > 100, "not of two runs");
  // The largest force is at the largest depth.
  const points = (await path("runs")).slice(1).split("L").map((point) => point.split(",").map(Number));
  const right = Math.max(...points.map(([x]) => x));
  const highest = points.reduce((a, b) => (b[1] < a[1] ? b : a));
  assert.ok(Math.abs(highest[0] - right) < 2, `${highest} ${right}`);
});

test("nothing is cut at any size: no horizontal scroll, charts seen, stop reached", async () => {
  for (const [width, height] of SIZES) {
    const { page, context, errors } = await begin({ viewport: { width, height } });
    for (const [name, show] of Object.entries(shows)) {
      await show(page);
      const at = `${name} at ${width}×${height}`;
      await laidOut(page, at);
    }
    // After a stop there is one button more.
    await page.evaluate(() => document.activeElement?.blur());
    await page.keyboard.press(" ");
    await until(() => page.locator("button.start").isVisible(), "no Start");
    assert.ok((await page.evaluate(() => document.scrollingElement.scrollWidth - innerWidth)) <= 0, `stopped at ${width}`);
    assert.deepEqual(errors, []);
    await context.close();
  }
});

test("a second page watches, says so, and may take the controls", async () => {
  const first = await begin();
  const second = await open(browser, server.address);
  await moving(second.page);
  await says(second.page.locator(".banner"), /Another page holds the controls/, "it does not say that it watches");
  await second.page.locator("text=Take the controls").click();
  await says(first.page.locator(".banner"), /Another page holds the controls/, "the first page does not say so");
  assert.deepEqual([...first.errors, ...second.errors], []);
});

visit("garbage on the socket is answered with a sentence and the page goes on", "", async (page) => {
  const answers = await page.evaluate(() => new Promise((resolve) => {
    const socket = new WebSocket(new URL("ws", location.href.split("#")[0]).href.replace("http", "ws"));
    const said = [];
    socket.onopen = () => ["{", "[]", "\u0000"].forEach((text) => socket.send(text));
    socket.onmessage = ({ data }) => typeof data === "string" && data.includes('"id":null') && said.push(data);
    socket.onclose = ({ code }) => resolve([code, ...said]);
  }));
  assert.equal(answers[0], 1008);
  assert.equal(answers.length, 4);
  const before = await depth(page);
  await until(async () => (await depth(page)) !== before, "the page stands still");
});

visit("a certificate that is dropped is shown", "#runs", async (page) => {
  const report = { date: "2026-11-23T10:00:00Z", board: "rp2040", firmware: "0.1.0", firmware_digest: "a1ef9414", holds: true, checks: [{ check: "arm", promised: "no force", seen: "none", ok: true, not_judged: false }] };
  await dropped(page, JSON.stringify(report), "pico.json");
  await says(page.locator(".answer .verdict"), /rp2040: every promise was kept/, "it is not shown");
  assert.match(await page.locator(".answer-body").textContent(), /a1ef9414.*armyesno forcenone/s);
  await pictured(page, "certificate");
});

test("axe finds nothing in any view, at any size, light and dark", async () => {
  const large = [1440, 900];
  for (const [colorScheme, sizes] of [["light", [large, ...SIZES]], ["dark", [large]]]) {
    for (const [width, height] of sizes) {
      const { page, context } = await begin({ colorScheme, viewport: { width, height } });
      for (const [name, show] of Object.entries(shows)) {
        await show(page);
        await page.waitForTimeout(300);
        assert.deepEqual(await violations(page), [], `${name}, ${width}×${height}, ${colorScheme}`);
      }
      await context.close();
    }
  }
});

test("a connection that breaks is told, and comes back by itself; a server that is gone is told", async () => {
  const sockets = [];
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  await page.routeWebSocket(/\/ws$/, (socket) => {
    socket.connectToServer();
    sockets.push(socket);
  });
  await page.goto(server.address);
  await until(() => page.locator(".device.running").count(), "no loop");
  await sockets[0].close();
  await says(page.locator(".banner"), /tries again by itself/, "the page does not say so");
  await until(async () => (await page.locator(".banner").isHidden()) && (await page.locator(".device.running").count()) > 0, "it does not come back");
  await server.kill();
  await says(page.locator(".banner"), /tries again by itself/, "the page does not say so");
  assert.match(await page.locator(".device").textContent(), /no connection/);
});
