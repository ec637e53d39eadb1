// Whether a running bridge's page tells what is wrong with the site, in headless Chromium:
//
//     node e2e/faults.mjs URL WORDS... [--gone OBJECT] [--screenshot FILE] [--timeout SECONDS]
//
// Waits until each of the WORDS stands in the health panel, and until no row shows OBJECT. Exit code 1 when one is
// missing.

import { parseArgs } from "node:util";
import { launch } from "./chromium.mjs";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { gone: { type: "string" }, screenshot: { type: "string" }, timeout: { type: "string", default: "30" } },
});
const [url, ...words] = positionals;
const timeout = Number(options.timeout) * 1000;

const browser = await launch();
let missing = 0;
try {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  await page.goto(url, { timeout });
  const notices = () => page.$$eval("[data-testid=notices] li", (items) => items.map((item) => item.textContent));
  for (const wanted of words) {
    const told = page.waitForFunction(
      (text) => [...document.querySelectorAll("[data-testid=notices] li")].some((item) => item.textContent.includes(text)),
      wanted,
      { timeout, polling: 100 },
    );
    await told.catch(async () => {
      missing += 1;
      console.error(`FAIL "${wanted}" is not in ${JSON.stringify(await notices())}`);
    });
  }
  if (options.gone) {
    const gone = page.waitForFunction((id) => !document.querySelector(`[data-testid=object-row-${id}]`), options.gone, { timeout });
    await gone.catch(() => {
      missing += 1;
      console.error(`FAIL ${options.gone} is still there`);
    });
  }
  if (options.screenshot) {
    await page.click("[data-testid=tab-health]");
    await page.screenshot({ path: options.screenshot });
  }
} finally {
  await browser.close();
}
process.exit(missing === 0 ? 0 : 1);
