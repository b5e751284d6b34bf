// Every view of the page, and the sizes at which a person must see all of it.
import { RELAX, WALL } from "./server.mjs";

/** CSS pixels: a laptop, a tablet, a telephone, and the laptop at 200 % zoom. */
export const SIZES = [[1280, 720], [820, 1180], [390, 844], [640, 360]];

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
