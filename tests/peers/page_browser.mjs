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

  async "loop closures are drawn as SLAM tells them, and go with the map"() {
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

  async "a gamepad drives while a shoulder button is held and the page has the focus"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await page.evaluate(() => {
        window.pad = { axes: [0, 0, 0, 0], buttons: Array.from({ length: 16 }, () => ({ pressed: false })) };
        navigator.getGamepads = () => [null, window.pad];  // the first place is free, as after a pad was pulled out
      });
      await (await page.createCDPSession()).send("Emulation.setFocusEmulationEnabled", { enabled: true });
      const pad = (axes, shoulder) => page.evaluate(([axes, shoulder]) => {
        window.pad.axes = axes;
        window.pad.buttons[5].pressed = shoulder;
      }, [axes, shoulder]);
      await until("a pose", async () => (await text(page, ".drive .figures")).includes("m"));
      const none = async (what, axes, shoulder) => {
        await pad(axes, shoulder);
        await wait(500);
        assert.deepEqual(robot.velocities, [], what);
      };
      await none("without a shoulder button", [0, -1, 0, 0], false);
      await none("a stick that does not quite come back", [0.05, -0.1, 0.1, 0], true);
      await pad([0, -1, 0.5, 0], true);
      await until("half speed left of ahead", () => robot.velocities.some((one) => Math.abs(one.v - 0.3) < 0.01 && Math.abs(one.w + 0.35) < 0.01), 2);
      await pad([0, -1, 0.5, 0], false);
      await until("zero at the release", () => robot.velocities.at(-1).v === 0 && robot.velocities.at(-1).w === 0, 2);
      await pad([0, -1, 0, 0], true);
      await until("that it drives again", () => robot.velocities.at(-1).v > 0.25, 2);
      await page.evaluate(() => { document.hasFocus = () => false; });
      await until("zero without the focus", () => robot.velocities.at(-1).v === 0, 2);
      await page.evaluate(() => { delete document.hasFocus; });
      await until("that it drives once more", () => robot.velocities.at(-1).v > 0.25, 2);
      await page.evaluate(() => { navigator.getGamepads = () => [null, null]; });
      await until("zero when the pad is pulled out", () => robot.velocities.at(-1).v === 0, 2);
    });
  },

  async "two fingers move, zoom and turn the map, and what is under them stays there"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url, { viewport: { ...desktop, hasTouch: true } }), touch = await fingers(page);
      await until("a map", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      const place = async ([x, y]) => {
        await page.mouse.move(x, y);
        return (await text(page, ".place")).match(/x (\S+)\s+y (\S+) m/).slice(1).map(Number);
      };
      const stays = async (what, from, to, steps) => {
        const before = [await place(from[0]), await place(from[1])];
        await touch(from, to, steps);
        for (const finger of [0, 1]) {
          const now = await place(to[finger]);
          assert.ok(Math.hypot(now[0] - before[finger][0], now[1] - before[finger][1]) < 0.04, `${what}: under finger ${finger} lies ${now}, not ${before[finger]}`);
        }
      };
      await stays("two fingers move", [[700, 450], [900, 450]], [[820, 390], [1020, 390]], 6);
      await stays("pinched apart", [[700, 450], [900, 450]], [[560, 480], [1060, 480]], 4);
      await stays("pinched together in one step", [[600, 400], [1000, 500]], [[740, 430], [880, 465]], 1);
      await touch([[700, 450], [900, 450]], [[800, 350], [800, 550]], 12);
      const turned = await page.$eval("[aria-label='Turn north up'] svg", (arrow) => arrow.style.transform);
      assert.ok(Math.abs(parseFloat(turned.match(/rotate\((.*)rad/)[1])) > 1.2, `turned by a quarter: ${turned}`);
      assert.equal(robot.told.length, 0);
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

  async "on no screen does anything lie on a button, and stop stays where it is"() {
    await withRobot({}, async (robot, url) => {
      const screens = [desktop, phone, { ...phone, width: 320, height: 568 }, { ...phone, width: 844, height: 390 }, { ...phone, width: 640, height: 360 }];
      for (const viewport of screens) {
        const page = await open(browser, url, { viewport }), size = `${viewport.width} x ${viewport.height}`;
        const buttons = "#tools button, #halt button, #bar button, [role=tab]";
        const covered = () => page.$$eval(buttons, (nodes) => nodes.filter((node) => node.offsetParent !== null).filter((node) => {
          const box = node.getBoundingClientRect(), there = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
          const outside = box.left < 0 || box.top < 0 || box.right > innerWidth || box.bottom > innerHeight;
          return outside || !(there === node || node.contains(there));
        }).map((node) => node.getAttribute("aria-label") ?? node.innerText));
        const place = () => page.$eval(".stop", (stop) => { const { x, y } = stop.getBoundingClientRect(); return [x, y]; });
        await until("the warning that leads to Health", async () => (await text(page, "#panel-health")).length > 0 || page.$eval("[role=tab]#tab-health", (tab) => tab.dataset.mark));
        for (const open of [false, true]) {
          const isOpen = await page.$eval("#panel", (panel) => !panel.classList.contains("closed"));
          if (isOpen !== open) await page.click("#tab-drive");
          await until(`no covered button, ${size}, panel ${open ? "open" : "closed"}`, async () => (await covered()).length === 0, 2).catch(async (fault) => { fault.message += `: ${await covered()}`; throw fault; });
          const before = await place();
          robot.obey("stop", { engaged: true });
          await until("the release button", () => page.$eval(".release", (button) => !button.hidden), 5);
          assert.deepEqual(await covered(), [], `${size}, panel ${open ? "open" : "closed"}, stopped`);
          assert.deepEqual(await place(), before, `${size}: stop moved away`);
          robot.obey("stop", { engaged: false });
          await until("its end", () => page.$eval(".release", (button) => button.hidden), 5);
        }
        await page.close();
      }
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

  async "two fingers move and zoom the model"() {
    if (!existsSync(three)) return console.log("  SKIPPED: no three.js (Debian: libjs-three)");
    await withFile(async (url) => {
      const page = await open(browser, url, { viewport: { ...desktop, hasTouch: true } }), touch = await fingers(page, "#model");
      await press(page, "3D model");
      await page.waitForSelector("#space .controls:not([hidden])");
      const cubes = async () => {
        const [red, blue] = await until("both cubes", async () => {
          const found = [await findImage(page, [190, 0, 0]), await findImage(page, [0, 0, 190])];
          return found.every((one) => one.count > 20) ? found : null;
        });
        return { x: (red.x + blue.x) / 2, y: (red.y + blue.y) / 2, apart: Math.hypot(red.x - blue.x, red.y - blue.y) };
      };
      const before = await cubes();
      await touch([[700, 400], [800, 400]], [[700, 400], [750, 400]], 5);
      const far = await cubes();
      assert.ok(Math.abs(far.apart / before.apart - 0.5) < 0.08, `pinched to one half: ${far.apart / before.apart}`);
      await touch([[700, 400], [800, 400]], [[780, 440], [880, 440]], 5);
      const moved = await cubes();
      assert.ok(Math.abs(moved.x - far.x - 80) < 16 && Math.abs(moved.y - far.y - 40) < 16, `two fingers moved it by ${moved.x - far.x}, ${moved.y - far.y}, not 80, 40`);
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

// Two fingers go from where they are to elsewhere, straight, in so many steps.
async function fingers(page, selector = "#map") {
  const client = await page.createCDPSession();
  return async (from, to, steps) => {
    const send = (type, touchPoints) => client.send("Input.dispatchTouchEvent", { type, touchPoints });
    const at = (part) => from.map(([x, y], id) => ({ id, x: x + part * (to[id][0] - x), y: y + part * (to[id][1] - y) }));
    await send("touchStart", at(0));
    for (let step = 1; step <= steps; ++step) await send("touchMove", at(step / steps));
    await send("touchEnd", []);
    await page.$eval(selector, () => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
  };
}

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
