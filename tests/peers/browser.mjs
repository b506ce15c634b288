// Debian's Chromium without a screen (by hand also Firefox: BROWSER=firefox), driven by puppeteer-core, and what the page's tests ask of it.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import puppeteer from "puppeteer-core";

export const three = "/usr/share/javascript/three/three.min.js";
export const freeDay = [255, 255, 255], occupiedDay = [28, 37, 48];
export const desktop = { width: 1440, height: 900 }, phone = { width: 390, height: 844, deviceScaleFactor: 2, hasTouch: true, isMobile: true };

// It has no touch screen, no wish for day or night, and, without a GPU, no WebGL.
export const firefox = process.env.BROWSER === "firefox";

export async function launch() {
  if (firefox) return puppeteer.launch({ browser: "firefox", executablePath: "/usr/bin/firefox-esr" });
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
  if (!executablePath) {
    console.log("SKIPPED: no Chromium (Debian: chromium)");
    process.exit(0);
  }
  return puppeteer.launch({ executablePath, args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });
}

// A page on which any error of a script is one of the test.
export async function open(browser, url, { viewport = desktop, scheme = "light", before = null } = {}) {
  const page = await (await browser.createBrowserContext()).newPage();
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(error.message));
  await page.setViewport(firefox ? { width: viewport.width, height: viewport.height } : viewport);
  if (!firefox) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await before?.(page);
  await page.goto(url);
  return page;
}

export const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Until what was told of by now is drawn.
export const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

// Until `what` gives something true; says what it waited for. Generous: only a failure waits that long.
export async function until(text, what, seconds = 30) {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    const value = await what();
    if (value) return value;
    assert.ok(Date.now() < end, `not within ${seconds} s: ${text}`);
    await wait(50);
  }
}

export const text = (page, selector) => page.$$eval(selector, (nodes) => nodes.map((node) => node.innerText).join(" | "));
export const toasts = (page) => text(page, ".toast");

// A click that does not ask whether something lies above: for buttons by their words.
export const press = (page, words) => page.evaluate((wanted) => {
  const button = [...document.querySelectorAll("button")].find((one) => (one.innerText.trim() || one.getAttribute("aria-label")) === wanted);
  if (!button || button.disabled) throw new Error(`no button "${wanted}" to press`);
  button.click();
}, words);

// Whether a finger in its middle meets it.
export const reachable = (page, selector) => page.$eval(selector, (node) => {
  const box = node.getBoundingClientRect();
  const there = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  return box.width > 0 && (there === node || node.contains(there));
});

// The middle of all pixels of a canvas that are nearly of a colour, and how many there are; in pixels of the page.
export const findColor = (page, selector, rgb, within = null) => page.evaluate((selector, rgb, within) => {
  const canvas = document.querySelector(selector), copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data, width } = context.getImageData(0, 0, copy.width, copy.height), box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
  let [count, x, y] = [0, 0, 0];
  for (let i = 0; i < data.length; i += 4) {
    const [px, py] = [(i / 4) % width, Math.floor(i / 4 / width)];
    if (within && (px / ratio < within[0] || px / ratio > within[2] || py / ratio < within[1] || py / ratio > within[3])) continue;
    if (data[i + 3] < 200 || [0, 1, 2].some((k) => Math.abs(data[i + k] - rgb[k]) > 24)) continue;
    ++count;
    x += px + 0.5;
    y += py + 0.5;
  }
  return { count, x: box.x + x / count / ratio, y: box.y + y / count / ratio };
}, selector, rgb, within);

// As findColor; what WebGL drew is kept for a screenshot only.
export async function findImage(page, rgb) {
  const png = Buffer.from(await page.screenshot()).toString("base64");
  return page.evaluate(async (url, rgb) => {
    const image = new Image();
    image.src = url;
    await image.decode();
    const copy = new OffscreenCanvas(image.width, image.height).getContext("2d");
    copy.drawImage(image, 0, 0);
    const { data } = copy.getImageData(372, 72, image.width - 500, image.height - 200), width = image.width - 500;
    let [count, x, y] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const strong = [0, 1, 2].every((k) => (rgb[k] === 0 ? data[i + k] < 60 : data[i + k] > 120));
      if (!strong) continue;
      ++count;
      x += (i / 4) % width;
      y += Math.floor(i / 4 / width);
    }
    return { count, x: 372 + x / count, y: 72 + y / count };
  }, `data:image/png;base64,${png}`, rgb);
}
