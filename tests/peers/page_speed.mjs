// Frames a second of a page while its plan is panned and zoomed, and while its model turns: the time from a change to what is
// drawn is a frame. By hand: node page_speed.mjs FILE.html...
import { launch, open, press, wait } from "./browser.mjs";

const browser = await launch();
for (const file of process.argv.slice(2)) {
  const page = await open(browser, `file://${file}`);
  await wait(1500);
  const drag = async (canvas) => {
    await page.mouse.move(900, 450);
    await page.evaluate(() => {
      window.frameTimes = [];
      const count = (now) => { window.frameTimes.push(now); requestAnimationFrame(count); };
      requestAnimationFrame(count);
    });
    await page.evaluate(async (selector) => {
      const node = document.querySelector(selector), send = (type, x, y) => node.dispatchEvent(new PointerEvent(type, { pointerId: 1, pointerType: "mouse", clientX: x, clientY: y, buttons: 1, bubbles: true }));
      node.setPointerCapture = () => {};
      send("pointerdown", 900, 450);
      const begin = performance.now();
      while (performance.now() - begin < 4000) {
        const at = (performance.now() - begin) / 300;
        send("pointermove", 900 + 200 * Math.sin(at), 450 + 100 * Math.cos(at));
        await new Promise((resolve) => requestAnimationFrame(resolve));
      }
      send("pointerup", 900, 450);
    }, canvas);
    const times = await page.evaluate(() => window.frameTimes);
    const steps = times.slice(1).map((time, i) => time - times[i]).sort((a, b) => a - b);
    return `${(1000 * steps.length / (times.at(-1) - times[0])).toFixed(0)} frames/s, slowest of a hundred ${steps[Math.floor(0.99 * steps.length)].toFixed(0)} ms`;
  };
  console.log(`${file}: plan ${await drag("#map")}`);
  if (await page.evaluate(() => [...document.querySelectorAll("#tools .stack")].some((stack) => !stack.hidden && stack.innerHTML.includes("3D model")))) {
    await press(page, "3D model");
    await page.waitForSelector("#space .controls:not([hidden])");
    await wait(500);
    console.log(`${file}: model ${await drag("#model")}`);
  }
  await page.close();
}
await browser.close();
