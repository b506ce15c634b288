// A page that is late says so: the age of the robot's pose where it is seen, and what is refused then.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { findColor, firefox, open, press, text, three, toasts, until, wait } from "./browser.mjs";
import { modelTiles } from "./page_robot.mjs";

const grey = [125, 135, 144], blue = [10, 95, 214];
const figures = (page) => text(page, ".drive .figures");
const seen_s = async (page) => Number((await figures(page)).match(/Seen\s+(\S+) s ago/)?.[1]);
const isGrey = async (page, selector) => (await pixels(page, grey, selector)) > 20 && (await pixels(page, blue, selector)) < 10;
const isOfNow = async (page, selector) => (await pixels(page, blue, selector)) > 20 && (await pixels(page, grey, selector)) < 10;
const pixels = async (page, color, selector = "#map") => (await findColor(page, selector, color)).count;
const canDraw3d = !firefox && existsSync(three);

// Frames come each so many milliseconds (window.frameMs; Infinity: none), and the user's clock is an hour ahead.
const slow = (frameMs) => async (page) => {
  await page.evaluateOnNewDocument((frameMs) => {
    const kHourMs = 3.6e6, now = Date.now.bind(Date), waiting = [];
    Date.now = () => now() + kHourMs;
    window.frameMs = frameMs;
    window.requestAnimationFrame = (draw) => waiting.push(draw);
    let last = 0;
    setInterval(() => {
      if (performance.now() - last < window.frameMs) return;
      last = performance.now();
      for (const draw of waiting.splice(0)) draw(last);
    }, 15);
  }, frameMs);
};

export const lateCases = (browser, withRobot) => ({
  async "the age of the pose is told, whatever the user's clock shows"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url, { before: slow(0) });
      await until("an age", async () => (await seen_s(page)) < 0.5);
      assert.ok(await isOfNow(page), "the robot is of now");
      assert.match(await text(page, "#bar"), /live/);
    });
  },

  async "drawn once a second, the robot is grey, on the plan and in the model"() {
    await withRobot({}, async (robot, url) => {
      [robot.x, robot.y] = [-1, -1];
      robot.last.set("MESH", modelTiles(1, 1, 100)[0]);
      const page = await open(browser, url, { before: slow(1000) });
      await until("a grey robot", () => isGrey(page));
      await until("its age", async () => { const age = await seen_s(page); return age >= 1 && age < 3; });
      await page.evaluate(() => { window.frameMs = 0; });
      await until("a robot of now", () => isOfNow(page));
      if (!canDraw3d) return console.log("  SKIPPED: 3D");
      await page.evaluate(() => { window.frameMs = 1000; });
      await press(page, "3D model");
      await until("a grey robot in the model", () => isGrey(page, "#space .marks"));
      await page.evaluate(() => { window.frameMs = 0; });
      await until("one of now", () => isOfNow(page, "#space .marks"));
      for (const button of ["3D model", "Plan and 3D side by side", "3D model"]) {
        await wait(2000);
        assert.match(await text(page, "#bar"), /live/, "what nobody sees is not late");
        await press(page, button);
      }
    });
  },

  async "a page that stands still says how late it is, and refuses stick and goal"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url, { before: slow(0) });
      await until("an age", async () => (await seen_s(page)) < 0.5);
      await page.keyboard.down("KeyW");
      await until("that it drives", () => robot.velocities.some((one) => one.v > 0.25), 5);
      await page.evaluate(() => { window.frameMs = Infinity; });
      const begun = Date.now();
      await until("that it is told late", async () => /late \d+ s/.test(await text(page, "#bar")), 8);
      await until("zero though the key is held", () => robot.velocities.at(-1).v === 0, 8);
      assert.ok(Date.now() - begun > 1000, "not before it is late");
      await until("why", async () => /Not driven: the picture is \d+ s old/.test(await toasts(page)), 5);
      await page.keyboard.up("KeyW");
      await press(page, "Go to a place");
      await page.mouse.click(800, 560);
      await until("that the goal was not sent", async () => /Not sent: the robot's position is \d+ s old/.test(await toasts(page)), 5);
      assert.ok(!robot.told.some((one) => one.service === "go"));
      await page.keyboard.press("Space");
      await until("that Stop is sent all the same", () => robot.engaged, 5);
      robot.obey("stop", { engaged: false });
      await page.evaluate(() => { window.frameMs = 0; });
      await until("that it is live", async () => /live/.test(await text(page, "#bar")), 8);
      robot.velocities = [];
      await page.keyboard.down("KeyW");
      await until("that it drives again", () => robot.velocities.some((one) => one.v > 0.25), 8);
      await page.keyboard.up("KeyW");
    });
  },

  async "where SLAM alone is silent, the position is old, goals are refused, and the stick drives"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await until("an age", async () => (await seen_s(page)) < 0.5);
      robot.muted = "SLAM_POSE";
      await until("that it is told", async () => /position \d+ s old/.test(await text(page, "#bar")), 8);
      await until("a grey robot", () => isGrey(page));
      await until("an age that grows", async () => (await seen_s(page)) > 3, 8);
      await press(page, "Go to a place");
      await page.mouse.click(800, 560);
      await until("the refusal", async () => (await toasts(page)).includes("Not sent"), 5);
      await page.keyboard.down("KeyA");
      await until("that the stick turns it", () => robot.velocities.some((one) => one.w > 0.3), 5);
      await page.keyboard.up("KeyA");
    });
  },

  async "while a model arrives, the robot is where it is"() {
    if (!canDraw3d) return console.log("  SKIPPED: 3D");
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url), way = [], ages = [];
      await until("a pose", async () => (await figures(page)).includes(" m"));
      await press(page, "3D model");
      [robot.x, robot.y, robot.theta] = [-3, -2, 0];
      const circle = setInterval(() => {
        [robot.v, robot.w, robot.heardAt] = [0.4, 0.5, Date.now()];
        way.push({ at: Date.now(), x: robot.x, y: robot.y });
      }, 20);
      for (let revision = 1; revision <= 3; ++revision) {
        for (const tile of modelTiles(revision, 40, 2000)) robot.publish("MESH", tile);
        for (let i = 0; i < 8; ++i) {
          await wait(250);
          const [x, y] = ((await figures(page)).match(/Position\s+(\S+), (\S+) m/) ?? []).slice(1).map(Number), now = Date.now();
          const nearest = way.filter((place) => Math.hypot(place.x - x, place.y - y) < 0.02).at(-1);
          ages.push(nearest ? (now - nearest.at) / 1000 : Infinity);
        }
      }
      clearInterval(circle);
      await until("the model", () => page.$eval("#space .controls", (node) => !node.hidden));
      ages.sort((a, b) => a - b);
      console.log(`  position on the page: ${ages[12].toFixed(2)} s old, at most ${ages.at(-1).toFixed(2)} s`);
      assert.ok(ages[12] < 1 && ages.at(-1) < 5, `the position on the page is ${ages.map((age) => age.toFixed(1))} s old`);
      assert.deepEqual(page.faults, []);
    });
  },
});
