// Pictures of every view: node tests/screenshots.mjs FOLDER [ADDRESS]. Without an address, of a server of its own.
import { mkdirSync } from "node:fs";
import { launch, open } from "./browser.mjs";
import { startServer } from "./server.mjs";
import { dropped, shows, SIZES } from "./views.mjs";

const [folder = "screenshots", address] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const own = address ? null : await startServer();
const browser = await launch();
const sizes = process.env.SIZES ? process.env.SIZES.split(",").map((size) => size.split("x").map(Number)) : SIZES;
const wanted = process.env.VIEWS?.split(",");
for (const theme of (process.env.THEMES ?? "light,dark").split(",")) {
  for (const [width, height] of sizes) {
    const { page, context, errors } = await open(browser, address ?? own.address, { viewport: { width, height }, colorScheme: theme });
    await page.waitForTimeout(Number(process.env.WAIT ?? 9000));
    for (const [name, show] of Object.entries(shows)) {
      if (wanted && !wanted.includes(name)) continue;
      await show(page);
      await page.waitForTimeout(1000);
      await page.screenshot({ path: `${folder}/${name}-${theme}-${width}.png`, fullPage: true });
    }
    if (errors.length > 0) console.log(theme, width, errors);
    await context.close();
  }
}
await browser.close();
await own?.kill();
