// Checks a page of `gsiirl report` in Chromium: nothing is loaded, no error, axe-core finds nothing, charts answer.
// In an empty folder: npm install playwright-core axe-core; cp .../scripts/check_report.mjs . ; node check_report.mjs PAGE [SCREENSHOTS]
import { chromium } from "playwright-core";
import { mkdtempSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const [page, screenshots] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const runOnly = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];
const quiet = ["quic", "gpu", "background-networking", "component-update", "sync"].map((name) => `--disable-${name}`);
const browser = await chromium.launchPersistentContext(mkdtempSync(join(tmpdir(), "report-")), {
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--no-first-run", ...quiet],
});
let failed = 0;
const tell = (what, good, more = "") => { failed += !good; console.log(`${good ? "ok  " : "FAIL"} ${what} ${more}`); };

for (const [width, colorScheme] of [[1400, "light"], [1400, "dark"], [390, "light"], [390, "dark"]]) {
  const tab = await browser.newPage();
  const errors = [], requests = [], name = `${width}-${colorScheme}`;
  tab.on("console", (message) => ["error", "warning"].includes(message.type()) && errors.push(message.text()));
  tab.on("pageerror", (error) => errors.push(String(error)));
  tab.on("request", (request) => request.url().startsWith("data:") || requests.push(request.url()));
  await tab.setViewportSize({ width, height: 900 });
  await tab.emulateMedia({ colorScheme, reducedMotion: "reduce" });
  await tab.goto(`file://${resolve(page)}`);
  const charts = await tab.locator(".charts").count();
  if (charts) await tab.waitForSelector(".charts + [hidden]", { state: "attached" });
  const wide = await tab.evaluate(() => document.documentElement.scrollWidth > document.documentElement.clientWidth);
  tell(`${name}: the page itself is not scrolled sideways`, !wide);
  if (screenshots) await tab.screenshot({ path: join(screenshots, `${name}.png`), fullPage: true });
  if (charts) {
    const chart = tab.locator(".chart").first(), seeds = tab.locator(".charts").first().locator("[name=seed]");
    const toggle = (await seeds.count()) ? seeds.last() : tab.locator(".charts [name=run]").first();
    await chart.scrollIntoViewIfNeeded();
    const box = await chart.boundingBox();
    await tab.mouse.move(box.x + box.width / 2, box.y + 60);
    await tab.mouse.move(box.x + box.width / 2 + 3, box.y + 62);
    await tab.waitForSelector("#vg-tooltip-element.visible", { timeout: 3000 }).catch(() => {});
    const told = await tab.locator("#vg-tooltip-element").innerText().catch(() => "");
    tell(`${name}: the pointer shows a value`, /(mean|value):?\s*\S/.test(told), told.replace(/\s+/g, " "));
    const lines = () => chart.locator("svg .mark-line path").count();
    const before = await lines();
    await tab.mouse.move(0, 0);
    await toggle.focus();
    await tab.keyboard.press("Space");
    await tab.waitForTimeout(300);
    tell(`${name}: a seed or curve that is switched off is not drawn`, (await lines()) < before, `${before} -> ${await lines()}`);
    await tab.keyboard.press("Space");
  }
  for (const moving of await tab.locator(".moving").all()) {
    const shown = async () => (await moving.locator("img:visible").getAttribute("src")).slice(5, 14);
    const still = await shown();
    await moving.locator("summary").focus();
    await tab.keyboard.press("Enter");
    tell(`${name}: an animation waits to be played`, still === "image/png" && (await shown()) === "image/gif");
    await tab.keyboard.press("Enter");
    tell(`${name}: and can be stopped`, (await shown()) === "image/png");
  }
  const drawing = tab.locator(".drawn:visible").first();
  if (width < 700 && (await drawing.count())) {
    const before = (await drawing.boundingBox()).width;
    await drawing.locator("img").click();
    tell(`${name}: a tap enlarges a figure`, (await drawing.boundingBox()).width > 2 * before);
    await drawing.locator("input").press("Space");
  }
  await tab.evaluate(axe);
  const { violations, incomplete } = await tab.evaluate((runOnly) => axe.run(document, { runOnly }), runOnly);
  const unsure = incomplete.map((each) => `${each.id} (${each.nodes.length})`).join(", ");
  tell(`${name}: axe finds nothing`, !violations.length, unsure && `cannot tell: ${unsure}`);
  for (const { id, nodes } of violations) console.log("    ", id, nodes.length, nodes[0].target.join(" "));
  tell(`${name}: nothing but the page is loaded`, requests.length === 1, requests.slice(1).join(" "));
  tell(`${name}: no error`, !errors.length, errors.join(" | "));
  await tab.close();
}
await browser.close();
process.exit(failed ? 1 : 0);
