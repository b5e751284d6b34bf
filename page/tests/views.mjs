// Every view of the page, the sizes at which a person must see all of it, and what is looked at in each.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { RELAX, WALL } from "./server.mjs";

/** CSS pixels: a laptop, a tablet, two telephones, the laptop at 200 % zoom, and a large screen. */
export const SIZES = [[1280, 720], [820, 1180], [390, 844], [360, 740], [640, 360], [2560, 1440]];

/** Waits until `look` gives something true; says what was there otherwise. */
export async function until(look, what, timeout = 8000) {
  const end = Date.now() + timeout;
  let last;
  while (Date.now() < end) {
    last = await look();
    if (last) return last;
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
  throw new Error(`${what}: ${JSON.stringify(last)}`);
}

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** What axe finds in what is shown; a policy that forbids scripts of others does not forbid those of a debugger. */
export async function violations(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { rules: { "target-size": { enabled: true } } }));
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`);
}

/** Nothing of what is shown is too small, cut or out of reach. */
export async function laidOut(page, at) {
  const plots = () => page.evaluate(() => {
    const all = [...document.querySelectorAll(".chart, .map, .scene, .depth-holder, .plane-holder")].filter((plot) => plot.getClientRects().length > 0);
    const small = all.filter((plot) => plot.clientWidth < 150 || plot.clientHeight < 60);
    return small.map((plot) => [plot.className.baseVal ?? plot.className, plot.getAttribute("aria-label"), plot.clientWidth, plot.clientHeight]);
  });
  await until(async () => (await plots()).length === 0, "too small", 3000).catch(async () => assert.deepEqual(await plots(), [], at));
  const found = await page.evaluate(() => {
    const root = document.scrollingElement;
    const cards = [...document.querySelectorAll(".card, header > *, footer > *")].filter((card) => card.getClientRects().length > 0);
    const over = cards.filter((card) => {
      const { left, right } = card.getBoundingClientRect();
      return left < -1 || right > innerWidth + 1;
    });
    // What is higher than its card lies over the next.
    const cut = cards.filter((card) => card.matches(".card") && card.scrollHeight > card.clientHeight + 2 && !["auto", "scroll"].includes(getComputedStyle(card).overflowY));
    const stop = document.querySelector("button.stop").getBoundingClientRect();
    scrollTo(0, root.scrollHeight);
    const later = document.querySelector("button.stop").getBoundingClientRect();
    scrollTo(0, 0);
    return { wide: Math.max(0, root.scrollWidth - innerWidth), over: over.map((card) => card.className || card.tagName), cut: cut.map((card) => `${card.className} ${card.scrollHeight} > ${card.clientHeight}`), stop: [stop, later].every(({ top, bottom, left, right }) => top >= 0 && bottom <= innerHeight && left >= 0 && right <= innerWidth) };
  });
  assert.deepEqual(found, { wide: 0, over: [], cut: [], stop: true }, at);
}

/** Lets a file fall on the page. */
export function dropped(page, text, name) {
  return page.evaluate(([text, name]) => {
    const data = new DataTransfer();
    data.items.add(new File([text], name));
    document.querySelector("main").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, [text, name]);
}

// σ/ε₀ = V·t^(−α)/Γ(1 − α), α = 0.3
export const RELAXATION = `time_s,modulus_pa\n${Array.from({ length: 200 }, (_, n) => 0.01 * 10 ** (n / 50)).map((t) => `${t},${1000 * t ** -0.3}`).join("\n")}\n`;

const key = (name) => async (page) => {
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press(name);
};

/** How each view is come to. */
export const shows = {
  feel: key("1"),
  design: key("2"),
  runs: async (page) => {
    await key("3")(page);
    for (const run of [WALL, RELAX]) await page.locator(".list label", { hasText: run }).locator("input").check();
    await page.locator(".overlay .chart").first().waitFor();
    // Whatever comes of the second shows the curves again.
    await page.locator(".facts h3").nth(1).waitFor({ state: "attached" });
  },
  form: async (page) => {
    await key("3")(page);
    await page.locator("button", { hasText: "New run" }).click();
    await page.locator(".form input").first().waitFor();
  },
  identify: async (page) => {
    await key("3")(page);
    await dropped(page, RELAXATION, "record.csv");
    await page.locator(".identify .chart").waitFor({ timeout: 60_000 });
  },
  control: async (page) => {
    await key("4")(page);
    await page.locator(".control .result td").first().waitFor();
  },
};
