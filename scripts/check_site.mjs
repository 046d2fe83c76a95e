// Checks pages of the site in Chromium, on a wide and on a narrow screen: axe-core finds nothing, nothing is loaded from elsewhere.
// In an empty folder: npm install playwright-core axe-core; cp .../scripts/check_site.mjs . ; node check_site.mjs PAGE.html ...
import { chromium } from "playwright-core";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const runOnly = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
let failed = 0;
for (const page of process.argv.slice(2)) {
  for (const [width, colorScheme] of [[1400, "light"], [390, "dark"]]) {
    const tab = await browser.newPage({ viewport: { width, height: 900 }, colorScheme });
    const faults = [];
    tab.on("console", (message) => message.type() === "error" && faults.push(message.text()));
    tab.on("pageerror", (error) => faults.push(String(error)));
    tab.on("request", (request) => /^(file|data):/.test(request.url()) || faults.push(`loads ${request.url()}`));
    await tab.goto(`file://${resolve(page)}`);
    if (await tab.evaluate(() => document.documentElement.scrollWidth > innerWidth)) faults.push("is scrolled sideways");
    const found = faults.length; // axe reads style sheets, which a browser refuses it for files
    await tab.evaluate(axe);
    const { violations } = await tab.evaluate((runOnly) => axe.run(document, { runOnly }), runOnly);
    const told = [...faults.slice(0, found), ...violations.map(({ id, nodes }) => `${id} (${nodes.length}) ${nodes[0].target.join(" ")}`)];
    failed += told.length > 0;
    console.log(told.length ? "FAIL" : "ok  ", page, width, told.join("; "));
    await tab.close();
  }
}
await browser.close();
process.exit(failed ? 1 : 0);
