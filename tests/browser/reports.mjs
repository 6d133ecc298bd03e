// Opens reports in a headless Chromium, from disk and without network, and uses them as a reader would.
//   node reports.mjs FOLDER REPORT.html... [--brief REPORT.html...]
// Those after --brief are opened and played, no more: large ones, which take a software renderer long.
// Fails on any message on the console, any request, an empty picture, a Play button that moves nothing, a control that changes
// nothing. Pictures of what was seen go to FOLDER.
import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { basename, dirname, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [folder, ...names] = process.argv.slice(2);
const cut = names.includes("--brief") ? names.indexOf("--brief") : names.length;
const [reports, brief] = [names.filter((name) => name !== "--brief"), new Set(names.slice(cut + 1))];
if (!reports.length) throw new Error("usage: node reports.mjs FOLDER REPORT.html... [--brief REPORT.html...]");
await mkdir(folder, { recursive: true });
const browser = await puppeteer.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  // Machines that test have no graphics card.
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--force-color-profile=srgb"],
});
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

// Pixels of a canvas: how many colours, and a sum that changes with any of them.
const look = (canvas) =>
  canvas.evaluate((element) => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [element.width, element.height];
    const context = copy.getContext("2d");
    context.drawImage(element, 0, 0);
    const words = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
    const colours = new Map();
    let sum = 0;
    for (const word of words) {
      colours.set(word, (colours.get(word) ?? 0) + 1);
      sum = (Math.imul(sum, 31) + word) | 0;
    }
    return { sum, colours: colours.size, drawn: 1 - Math.max(...colours.values()) / words.length };
  });

async function open(report) {
  const page = await browser.newPage();
  const complaints = [];
  page.on("console", (message) => {
    // What the software renderer says of its own speed is not about the page.
    if (!/GPU stall due to ReadPixels/.test(message.text())) complaints.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`error: ${error.message}`));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) complaints.push(`request: ${request.url()}`);
  });
  await page.setViewport({ width: 1280, height: 900 });
  await page.goto(pathToFileURL(resolve(report)).href, { waitUntil: "load" });
  return { page, complaints };
}

async function useView(page, view, name, isBrief) {
  const canvas = await view.waitForSelector("canvas");
  const before = await look(canvas);
  assert.ok(before.colours > 20 && before.drawn > 0.005, `${name}: nothing to be seen: ${JSON.stringify(before)}`);
  const changes = async (what, act) => {
    const [old] = [await look(canvas)];
    await act();
    await pause(150);
    assert.notEqual((await look(canvas)).sum, old.sum, `${name}: ${what} changes nothing`);
  };
  const button = (text) => view.$(`::-p-xpath(.//button[text()="${text}"])`);
  const play = await button("Play");
  await changes("Play", async () => {
    await play.click();
    await pause(900);
  });
  await play.click();
  await pause(100);
  const still = await look(canvas);
  await pause(200);
  assert.equal((await look(canvas)).sum, still.sum, `${name}: Pause does not hold it`);
  await changes("the slider", () =>
    view.$eval("input[type=range]", (slider) => {
      slider.value = slider.value > 0.4 ? 0.2 : 0.7;
      slider.dispatchEvent(new Event("input"));
    }),
  );
  await canvas.screenshot({ path: `${folder}/${name}.png` });
  if (isBrief) return;
  const box = await canvas.boundingBox();
  await changes("dragging", async () => {
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 80, box.y + box.height / 2 + 30, { steps: 4 });
    await page.mouse.up();
  });
  await changes("Reset view", async () => (await button("Reset view")).click());
  const lists = await view.$$eval("select", (all) => all.map((list) => [...list.options].map((option) => option.value)));
  for (const [i, values] of lists.entries()) {
    const list = (await view.$$("select"))[i];
    if (values.includes("A")) await changes("frame A", () => list.select("A"));
    // Motion, if there is any, is the first; modes come after it.
    if (values.includes("-1")) {
      await changes("a mode", () => list.select("0"));
      await changes("playing a mode", async () => {
        await play.click();
        await pause(600);
      });
      await play.click();
      await canvas.screenshot({ path: `${folder}/${name}-mode.png` });
      await list.select("-1");
    }
  }
}

let views = 0;
for (const report of reports) {
  const name = `${basename(dirname(resolve(report)))}-${basename(report, ".html")}`;
  const { page, complaints } = await open(report);
  const plots = await page.$$eval(".plot", (all) => all.map((box) => box.querySelector("canvas") != null));
  assert.ok(plots.every(Boolean), `${name}: a plot without a picture`);
  const boxes = await page.$$("[data-scene]");
  for (const [i, view] of boxes.entries()) await useView(page, view, i ? `${name}-${i}` : name, brief.has(report));
  views += boxes.length;
  if (brief.has(report)) {
    assert.deepEqual(complaints, [], name);
    console.log(`${name}: ${plots.length} plots, ${boxes.length} views in space, played`);
    await page.close();
    continue;
  }
  await page.screenshot({ path: `${folder}/${name}-light.png`, fullPage: true });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "dark" }]);
  await pause(400);
  await page.screenshot({ path: `${folder}/${name}-dark.png` });
  await page.emulateMediaFeatures([]);
  await page.pdf({ path: `${folder}/${name}.pdf`, format: "A4" });
  assert.deepEqual(complaints, [], name);
  console.log(`${name}: ${plots.length} plots, ${boxes.length} views in space`);
  await page.close();
}
await browser.close();
assert.ok(views > 0, "no report has a view in space");
