// The page in a browser: against a robot of its own (page_robot.mjs), and as one file from disk.
// usage: node page_browser.mjs MARCO_EXPORT PAGE_FOLDER
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { findColor, freeDay, launch, open, press, text, three, toasts, until, wait } from "./browser.mjs";
import { fileCases } from "./page_file.mjs";
import { handCases } from "./page_hands.mjs";
import { keyCases } from "./page_keys.mjs";
import { lateCases } from "./page_late.mjs";
import { PageRobot } from "./page_robot.mjs";

const [marcoExport, pageFolder] = process.argv.slice(2);
const browser = await launch();

async function withRobot(options, body) {
  const robot = new PageRobot(pageFolder, { three: existsSync(three) ? three : null, ...options });
  const url = await robot.start();
  try {
    await body(robot, url);
  } finally {
    await robot.stop();
  }
}

const cases = {
  async "the map grows as the robot drives"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await until("a map", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      const before = robot.tiles.size;
      robot.obey("go", { x_m: 0, y_m: 0 });
      await until("a larger map", async () => robot.tiles.size > before && !robot.goal, 20);
      robot.obey("go", { x_m: 3, y_m: 0.5 });
      await until("the robot in the other room", () => !robot.goal, 20);
      await until("its position", async () => /^[23]\.\d\d, 0\.\d\d m/.test((await text(page, ".drive .figures dd"))), 5);
      assert.deepEqual(page.faults, []);
    });
  },

  async "loop closures are drawn as SLAM reports them, and go with the map"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url), loopDay = [43, 138, 62];
      await until("a map", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      await page.click("#tab-map");
      const layer = () => page.$$eval(".layer", (rows) => rows.some((row) => row.innerText === "Loop closures" && row.offsetParent !== null));
      assert.ok(!(await layer()), "there are none yet");
      robot.loops = [[-5, -3, -1, -3], [-5, -2.5, -1, -2.5]];
      await until("the layer", layer);
      assert.equal((await findColor(page, "#map", loopDay)).count, 0, "they are drawn when asked for");
      await page.evaluate(() => [...document.querySelectorAll(".layer")].find((row) => row.innerText === "Loop closures").click());
      await until("their lines", async () => (await findColor(page, "#map", loopDay)).count > 200);
      robot.obey("slam", { command: "reset" });
      await until("their end", async () => !(await layer()) && (await findColor(page, "#map", loopDay)).count === 0);
      assert.deepEqual(page.faults, []);
    });
  },

  async "a click sends the robot to the place under the pointer, and every browser sees the goal"() {
    await withRobot({}, async (robot, url) => {
      const [page, second] = [await open(browser, url), await open(browser, url)];
      await until("a map", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      robot.held = true;
      await press(page, "Go to a place");
      await page.mouse.move(800, 560);
      const place = (await text(page, ".place")).match(/x (\S+)\s+y (\S+) m/).slice(1).map(Number);
      await page.mouse.click(800, 560);
      const order = await until("the order", () => robot.told.find((one) => one.service === "go"));
      assert.ok(Math.hypot(order.x_m - place[0], order.y_m - place[1]) < 0.01, `${order.x_m}, ${order.y_m} is not ${place}`);
      const third = await open(browser, url);
      const shown = async (one) => (await text(one, ".drive .figures")).match(/Goal\s+(\S+), (\S+) m/)?.slice(1).map(Number);
      for (const one of [page, second, third]) {
        const goal = await until("the goal in every browser", () => shown(one));
        assert.ok(Math.hypot(goal[0] - order.x_m, goal[1] - order.y_m) < 0.01, `${goal} is not ${order.x_m}, ${order.y_m}`);
      }
      robot.held = false;
      await until("arrival", () => !robot.goal, 20);
      await until("the goal's end", async () => !(await shown(second)));
      assert.ok(Math.hypot(robot.x - order.x_m, robot.y - order.y_m) < 0.15);
      await press(page, "Measure a distance");
      assert.equal(robot.told.filter((one) => one.service === "go").length, 1, "one click is one order");
    });
  },

  async "before anything was heard the map says so"() {
    await withRobot({}, async (robot, url) => {
      clearInterval(robot.timer);
      const page = await open(browser, url);
      await until("that there is nothing to draw", async () => (await text(page, "#plan .empty")).includes("Nothing to draw yet"));
      robot.timer = setInterval(() => robot.step(), 50);
      await until("the map instead", () => page.$eval("#plan .empty", (note) => note.hidden));
    });
  },

  async "orders to SLAM and procman arrive, and what comes of them is said"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      const answer = async (words, value) => {
        await press(page, words);
        await page.waitForSelector("dialog");
        if (value !== undefined) await page.$eval("dialog input", (input, text) => { input.value = text; }, value);
        await page.keyboard.press("Enter");
      };
      await until("the services", async () => !(await page.$eval(".drive .primary", (button) => button.disabled)));
      await answer("Save map", "first floor");
      await until("where it was saved", async () => (await toasts(page)).includes("/home/robot/maps/first floor"));
      await answer("Extend a map", "nowhere");
      await until("the refusal", async () => (await toasts(page)).includes("nowhere: no map there"));
      await press(page, "Pause");
      await answer("Where am I", "");
      await page.mouse.move(700, 500);
      await page.mouse.down();
      await page.mouse.move(700, 400, { steps: 4 });
      await page.mouse.up();
      const pose = await until("the pose", () => robot.told.find((one) => one.command === "set_pose"));
      assert.ok(Math.abs(pose.theta_rad - Math.PI / 2) < 0.01, `drawn to the north, got ${pose.theta_rad}`);
      assert.ok(robot.told.some((one) => one.command === "pause"));
      await press(page, "Record");
      await until("the recording", () => robot.recording);
      await page.click("#tab-programs");
      await until("procman's commands", async () => (await text(page, "#panel-programs")).includes("marco-camera"));
      await press(page, "marco-camera\nfailed on robot");
      await until("its output", async () => (await text(page, ".output")).includes("/dev/video0: no such device"));
      await page.evaluate(() => [...document.querySelectorAll("#panel-programs li")].find((row) => row.innerText.includes("marco-camera")).querySelector(".row button").click());
      await until("its start", () => robot.told.find((one) => one.service === "procman" && one.command === "marco-camera" && one.action === "start"));
      assert.deepEqual(page.faults, []);
    });
  },

  async "a laser that was left tilted is levelled"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await wait(3000);
      assert.ok(!(await text(page, ".drive")).includes("Level the laser"), "it is level");
      robot.tilt = -0.4;
      await until("the button", async () => (await text(page, ".drive")).includes("Level the laser"), 5);
      await press(page, "Level the laser");
      await until("the order", () => robot.tilt === 0);
      await until("the button's end", async () => !(await text(page, ".drive")).includes("Level the laser"), 5);
    });
  },

  async "a lost connection is said at once, and comes back by itself"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await until("the banner's end", () => page.$eval("#banner", (banner) => banner.hidden));
      await robot.stop();
      await until("what is said", () => page.$eval("#banner", (banner) => !banner.hidden && banner.innerText.includes("Connection lost")), 5);
      await robot.start();
      await until("the connection", () => page.$eval("#banner", (banner) => banner.hidden));
      const before = robot.now;
      await until("poses again", async () => robot.now > before && robot.clients.size === 1);
    });
  },

  async "Stop without a connection says so, and is the first to be sent when there is one within ten seconds"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url), said = (words) => async () => (await text(page, ".stopped")).includes(words);
      await until("the banner's end", () => page.$eval("#banner", (banner) => banner.hidden));
      await robot.stop();
      await page.click(".stop");
      await until("that it cannot be reached", said("is unreachable"), 5);
      robot.firsts = [];
      await robot.start();
      await until("the stop", () => robot.engaged, 5);
      assert.deepEqual(robot.firsts, ["stop"], "the first on the new connection");
      await until("whose it is", said("Stopped by the page"), 5);
      robot.obey("stop", { engaged: false });

      // A network that swallows everything.
      for (const client of robot.clients) client.isDeaf = true;
      await page.keyboard.press("Space");
      await until("that it cannot be reached", said("is unreachable"), 5);
      await until("the stop by another connection", () => robot.engaged, 9);
      assert.equal(robot.firsts.at(-1), "stop");
      robot.obey("stop", { engaged: false });
      await until("the release", () => page.$eval(".release", (button) => button.hidden), 5);

      await robot.stop();
      await page.click(".stop");
      await until("that it did not reach the robot", said("did NOT reach the robot"), 15);
      await robot.start();
      await until("the connection", () => page.$eval("#banner", (banner) => banner.hidden));
      await wait(1000);
      assert.ok(!robot.engaged, "a stop of long ago is not sent");
      assert.ok(await said("did NOT reach the robot")());
    });
  },

  async "who may only watch is told so, and may stop"() {
    await withRobot({ readOnly: true }, async (robot, url) => {
      const page = await open(browser, url);
      await until("why", async () => (await text(page, ".note")).includes("can only watch"));
      assert.equal(await page.$eval(".stick", (stick) => stick.hidden), true);
      await page.keyboard.down("KeyW");
      await wait(300);
      await page.keyboard.up("KeyW");
      assert.deepEqual(robot.velocities, []);
      await page.click(".stop");
      await until("the stop", () => robot.engaged);
    });
  },

  async "names that are markup stay text"() {
    await withRobot({ hostile: true }, async (robot, url) => {
      const page = await open(browser, url);
      await page.click("#tab-health");
      await until("the name as it is", async () => (await text(page, "#panel-health")).includes("marco-slam<img src=x"));
      await page.click("#tab-programs");
      await until("the name as it is", async () => (await text(page, "#panel-programs")).includes("marco-slam<img src=x"));
      await wait(300);
      assert.equal(await page.evaluate(() => window.hacked), undefined);
      assert.equal(await page.$$eval("#panel img, #panel script", (nodes) => nodes.length), 0);
    });
  },

  ...handCases(browser, withRobot, marcoExport),
  ...keyCases(browser, withRobot),
  ...lateCases(browser, withRobot),
  ...fileCases(browser, marcoExport),
};

let failed = 0;
for (const [name, body] of Object.entries(cases)) {
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const begun = Date.now();
  try {
    await body();
    console.log(`ok      ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
  } catch (fault) {
    ++failed;
    console.log(`FAILED  ${name}\n${fault.stack}`);
  }
  // Pages left open go on drawing.
  for (const context of browser.browserContexts()) if (context !== browser.defaultBrowserContext()) await context.close();
}
await browser.close();
process.exit(failed === 0 ? 0 : 1);
