// The page in a browser: against a robot of its own (page_robot.mjs), and as one file from disk.
// usage: node page_browser.mjs MARCO_EXPORT PAGE_FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { desktop, findColor, findImage, launch, open, phone, press, reachable, text, three, toasts, until, wait } from "./browser.mjs";
import { cubesApart_m, postsApart_m, writeFolder } from "./page_folder.mjs";
import { PageRobot } from "./page_robot.mjs";

const [marcoExport, pageFolder] = process.argv.slice(2);
const browser = await launch();
const freeDay = [255, 255, 255], occupiedDay = [28, 37, 48];

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

  async "a click sends the robot to the place under the pointer, and every browser sees the goal"() {
    await withRobot({}, async (robot, url) => {
      const [page, second] = [await open(browser, url), await open(browser, url)];
      await until("a map", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      await press(page, "Go to a place");
      await page.mouse.move(800, 560);
      const place = (await text(page, ".place")).match(/x (\S+)\s+y (\S+) m/).slice(1).map(Number);
      await page.mouse.click(800, 560);
      const order = await until("the order", () => robot.told.find((one) => one.service === "go"));
      assert.ok(Math.hypot(order.x_m - place[0], order.y_m - place[1]) < 0.01, `${order.x_m}, ${order.y_m} is not ${place}`);
      const goal = `${order.x_m.toFixed(2)}, ${order.y_m.toFixed(2)} m`;
      for (const one of [page, second]) await until("the goal in both browsers", async () => (await text(one, ".drive .figures")).includes(goal));
      await until("arrival", () => !robot.goal, 20);
      await until("the goal's end", async () => !(await text(second, ".drive .figures")).includes(goal));
      assert.ok(Math.hypot(robot.x - order.x_m, robot.y - order.y_m) < 0.15);
      await press(page, "Measure a distance");
      assert.equal(robot.told.filter((one) => one.service === "go").length, 1, "one click is one order");
    });
  },

  async "stop is in reach everywhere, stops, is shown to all, and is released"() {
    await withRobot({}, async (robot, url) => {
      const [page, second] = [await open(browser, url, { viewport: phone }), await open(browser, url)];
      await until("the button", () => reachable(page, ".stop"));
      for (const tab of ["drive", "map", "health", "programs"]) {
        await page.click(`#tab-${tab}`);
        await wait(350);
        assert.ok(await reachable(page, ".stop"), `stop is covered while ${tab} is open`);
      }
      robot.obey("go", { x_m: 3, y_m: 0 });
      await page.tap(".stop");
      await until("the order", () => robot.engaged);
      assert.equal(robot.goal, null);
      await until("the second browser", async () => (await text(second, ".stopped")).includes("Stopped by the page"));
      await second.click(".release");
      await until("the release", () => !robot.engaged);
    });
  },

  async "stick and keys drive while held, ten times a second, and end with zero"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await until("a pose", async () => (await text(page, ".drive .figures")).includes("m"));
      const ends = async (what) => {
        await until(`${what} ends with zero`, () => robot.velocities.length > 0 && robot.velocities.at(-1).v === 0 && robot.velocities.at(-1).w === 0, 1);
        const { length } = robot.velocities;
        await wait(800);
        assert.ok(robot.velocities.length <= length + 3, `${what}: orders after the release`);
        robot.velocities = [];
      };
      const stick = await (await page.$(".stick")).boundingBox(), middle = [stick.x + stick.width / 2, stick.y + stick.height / 2];
      await page.mouse.move(...middle);
      await page.mouse.down();
      await page.mouse.move(middle[0], middle[1] - 80);
      await wait(1050);
      const held = robot.velocities.filter((one) => one.v > 0.25);
      assert.ok(held.length >= 8 && held.length <= 13, `${held.length} orders a second`);
      await page.mouse.up();
      await ends("stick");
      await page.keyboard.down("KeyA");
      await until("a turn to the left", () => robot.velocities.some((one) => one.w > 0.5 && one.v === 0), 1);
      await page.evaluate(() => window.dispatchEvent(new Event("blur")));  // another window
      await ends("a key when the window loses the focus");
      await page.keyboard.up("KeyA");
      await page.click("#tab-map");
      await page.keyboard.down("KeyW");
      await wait(400);
      await page.keyboard.up("KeyW");
      assert.deepEqual(robot.velocities, [], "keys drive while another tab is open");
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
      await until("what is said", () => page.$eval("#banner", (banner) => !banner.hidden && banner.innerText.includes("Connection lost")), 2);
      await press(page, "Stop");
      await until("that stop was not sent", async () => (await toasts(page)).includes("not connected"), 2);
      await robot.start();
      await until("the connection", () => page.$eval("#banner", (banner) => banner.hidden));
      const before = robot.now;
      await until("poses again", async () => robot.now > before && robot.clients.size === 1);
    });
  },

  async "who may only watch is told so, and may stop"() {
    await withRobot({ readOnly: true }, async (robot, url) => {
      const page = await open(browser, url);
      await until("why", async () => (await text(page, ".note")).includes("watching only"));
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

  async "one file from disk: without network, a distance is the world's within 1 cm"() {
    await withFile(async (url) => {
      const page = await open(browser, url, { viewport: desktop });
      await page.setOfflineMode(true);
      await page.reload();
      await until("the plan", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      assert.match(await text(page, "#panel-map"), /The map is doubtful[^]*<b>bent<\/b> here[^]*forbid_loop 1 2/);
      await page.keyboard.press("Tab");
      for (const turned of [false, true]) {
        if (turned) await turnMap(page);
        await press(page, "Measure a distance");
        for (const end of [0, 1]) await clickPost(page, end);
        const said = Number((await text(page, ".said")).replace(" m", ""));
        assert.ok(Math.abs(said - postsApart_m) <= 0.01, `${said} m is not ${postsApart_m.toFixed(3)} m`);
        console.log(`  measured ${said} m, the world has ${postsApart_m.toFixed(4)} m`);
        await press(page, "Measure a distance");
      }
      assert.deepEqual(page.faults, []);
    });
  },

  async "one file from disk: the model, measured"() {
    if (!existsSync(three)) return console.log("  SKIPPED: no three.js (Debian: libjs-three)");
    await withFile(async (url) => {
      const page = await open(browser, url);
      await press(page, "3D model");
      await page.waitForSelector("#space .controls:not([hidden])");
      await press(page, "Measure a distance");
      for (const rgb of [[190, 0, 0], [0, 0, 190]]) {
        const cube = await until("a cube", async () => {
          const found = await findImage(page, rgb);
          return found.count > 20 ? found : null;
        });
        await page.mouse.click(cube.x, cube.y);
      }
      const said = Number((await text(page, ".said")).replace(" m", ""));
      assert.ok(Math.abs(said - cubesApart_m) < 0.1, `${said} m is not ${cubesApart_m.toFixed(2)} m`);
      await press(page, "Walk");
      await wait(300);
      assert.deepEqual(page.faults, []);
    });
  },
};

async function withFile(body) {
  const folder = await mkdtemp(`${tmpdir()}/marco_page_`);
  try {
    await writeFolder(folder);
    execFileSync(marcoExport, [folder, "--html", `${folder}/map.html`]);
    await body(`file://${folder}/map.html`);
  } finally {
    await rm(folder, { recursive: true });
  }
}

// To the nearer or the farther post: at the wheel's closest, its middle is a pixel of a few millimetres.
async function clickPost(page, end) {
  await press(page, "Show all");
  await wait(100);  // until it is drawn
  const split = desktop.width / 2 + 140, half = end === 0 ? [372, 72, split, 900] : [split, 72, 1440, 900];
  let post = await findColor(page, "#map", occupiedDay, half);
  for (let i = 0; i < 6; ++i) {
    await page.mouse.move(post.x, post.y);
    await page.mouse.wheel({ deltaY: -200 });
    await wait(60);
    const near = [post.x - 120, post.y - 120, post.x + 120, post.y + 120];
    post = await findColor(page, "#map", occupiedDay, near);
  }
  await page.mouse.click(post.x, post.y);
}

async function turnMap(page) {
  await page.keyboard.down("Shift");
  await page.mouse.move(800, 700);
  await page.mouse.wheel({ deltaY: 90 });
  await page.keyboard.up("Shift");
}

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
}
await browser.close();
process.exit(failed === 0 ? 0 : 1);
