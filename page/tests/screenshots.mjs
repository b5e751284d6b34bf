// Pictures of every view: node tests/screenshots.mjs FOLDER [ADDRESS]. Without an address, of the mock server.
import { mkdirSync } from "node:fs";
import { launch, open } from "./browser.mjs";
import { startMock } from "./mock-server.mjs";

const [folder = "screenshots", address] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const mock = address ? null : await startMock();
const browser = await launch();
const sizes = (process.env.SIZES ?? "1280x720,1440x900,2560x1440").split(",").map((size) => size.split("x").map(Number));
for (const theme of (process.env.THEMES ?? "light,dark").split(",")) {
  for (const [width, height] of sizes) {
    const { page, context, errors } = await open(browser, address ?? mock.address, { viewport: { width, height }, colorScheme: theme });
    await page.waitForTimeout(Number(process.env.WAIT ?? 9000));
    for (const [key, name] of [["1", "feel"], ["2", "design"], ["3", "runs"]]) {
      await page.keyboard.press(key);
      await page.waitForTimeout(1200);
      if (name === 'runs') for (const box of (await page.locator('.list input').all()).slice(0, 2)) await box.check();
      await page.waitForTimeout(400);
      await page.screenshot({ path: `${folder}/${name}-${theme}-${width}.png` });
    }
    if (errors.length > 0) console.log(theme, width, errors);
    await context.close();
  }
}
await browser.close();
await mock?.close();
