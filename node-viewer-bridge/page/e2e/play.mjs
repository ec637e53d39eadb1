// Looks at a page on which a recording is being played, in headless Chromium: the objects of the recording are there,
// and the time line goes through it.
//
//     node e2e/play.mjs URL
//
// CHROMIUM names the browser. Writes a line per check on stderr; exit code 1 when one failed.

import { check, end } from "./checks.mjs";
import { launch } from "./chromium.mjs";

const [url] = process.argv.slice(2);
const timeout = 60_000;
const browser = await launch();
try {
  const page = await browser.newPage();
  await page.goto(url);
  const wait = (condition, argument) => page.waitForFunction(condition, argument, { timeout, polling: 100 });

  await check("the object of the recording is there", () => wait(() => window.sextant.site.objects.size > 0 && Object.keys(window.sextant.positions()).length > 0));

  await check("the time line goes through the recording", async () => {
    await wait(() => {
      const range = window.sextant.playback.range();
      return range !== null && range[1] - range[0] > 2;
    });
    const at = (share) =>
      page.evaluate(
        (share) => {
          const slider = document.querySelector("[data-testid=timeline-slider]");
          slider.value = String(Number(slider.max) * share);
          slider.dispatchEvent(new Event("input"));
        },
        share,
      );
    const drawn = () => page.evaluate(() => JSON.stringify(window.sextant.positions()));
    await at(0.2);
    await wait(() => document.body.dataset.replaying === "true");
    const early = await drawn();
    await at(0.8);
    await wait((early) => JSON.stringify(window.sextant.positions()) !== early, early);
  });

  await check("and back to its end", async () => {
    await page.click("[data-testid=timeline-live]");
    await wait(() => document.body.dataset.replaying === "false");
  });
} finally {
  await browser.close();
}
end();
