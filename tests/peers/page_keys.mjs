// The table of keys in docs/page.md, each in every kind of state.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { firefox, open, press, text, three, until, wait } from "./browser.mjs";
import { modelTiles } from "./page_robot.mjs";

const dialogs = ["Save map", "Where am I", "Extend a map", "New map"];
const tab = (name) => (page) => page.click(`#tab-${name}`);
const focus = (selector) => (page) => page.focus(selector);
const dialog = (words) => async (page) => {
  await press(page, words);
  await page.waitForSelector("dialog[open]");
  await page.focus("dialog form button");
};

// What has the focus when a key comes. `same` is what the key must not change.
const states = [
  { name: "nothing", enter: async () => {} },
  { name: "the map", enter: focus("#map") },
  { name: "a tab", enter: focus("#tab-drive"), same: () => document.querySelector("#panel").className },
  { name: "a button", enter: focus(".drive .primary"), same: () => document.querySelector(".said").hidden },
  { name: "the speed", enter: focus(".drive input[type=range]"), same: () => document.querySelector(".drive input[type=range]").value },
  { name: "a layer", enter: async (page) => { await tab("map")(page); await page.focus(".layer input"); }, same: () => document.querySelector(".layer input").checked },
  { name: "a program's button", enter: async (page) => { await tab("programs")(page); await page.waitForSelector("#panel-programs .row button"); await page.focus("#panel-programs .row button"); } },
  { name: "Stop itself", enter: focus(".stop") },
  { name: "a tool", enter: async (page) => { await press(page, "Measure a distance"); await page.mouse.click(800, 500); } },
  ...dialogs.map((words) => ({ name: `the dialog ${words}`, enter: dialog(words), same: () => document.querySelectorAll("dialog[open]").length })),
  { name: "the closed panel", enter: async (page) => { await page.click("#tab-drive"); } },
  { name: "the model", needs3d: true, enter: async (page) => { await press(page, "3D model"); await page.focus("#model"); } },
  { name: "the walk", needs3d: true, enter: async (page) => { await press(page, "3D model"); await until("the model", () => page.$eval("#space .controls", (node) => !node.hidden)); await press(page, "Walk"); } },
  { name: "plan and model", needs3d: true, enter: async (page) => { await press(page, "Plan and 3D side by side"); } },
];
const usable = () => states.filter(({ needs3d }) => !needs3d || (existsSync(three) && !firefox));

// From whatever state to the first one.
async function leave(page) {
  for (let i = 0; i < 3; ++i) await page.keyboard.press("Escape");
  await page.evaluate(() => {
    document.activeElement?.blur();
    document.querySelector("#tools button[aria-pressed=true]")?.click();
    if (document.querySelector("#panel").classList.contains("closed")) document.querySelector("#tab-drive").click();
  });
  await page.click("#tab-map");
  await page.click("#tab-drive");
}

const stops = (robot) => robot.told.filter((one) => one.service === "stop" && one.engaged).length;

export const keyCases = (browser, withRobot) => ({
  async "Space is Stop whatever has the focus, and presses nothing else"() {
    await withRobot({}, async (robot, url) => {
      robot.last.set("MESH", modelTiles(1, 1, 100)[0]);
      const page = await open(browser, url);
      await until("a pose", async () => (await text(page, ".drive .figures")).includes(" m"));
      for (const { name, enter, same = () => 0 } of usable()) {
        await enter(page);
        const before = await page.evaluate(same), told = robot.told.length;
        await page.keyboard.press("Space");
        await until(`the stop from ${name}`, () => robot.engaged, 5);
        assert.equal(stops({ told: robot.told.slice(told) }), 1, `${name}: one press is one order`);
        assert.equal(robot.told.length, told + 1, `${name}: ${JSON.stringify(robot.told.slice(told))}`);
        assert.deepEqual(await page.evaluate(same), before, `${name}: Space changed it`);
        robot.obey("stop", { engaged: false });
        await until("the release", () => page.$eval(".release", (button) => button.hidden), 5);
        await leave(page);
      }
      assert.deepEqual(page.faults, []);
    });
  },

  async "Space is known by its place or by its name, also repeated; a text field keeps it"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url), client = firefox ? null : await page.createCDPSession();
      await until("a pose", async () => (await text(page, ".drive .figures")).includes(" m"));
      for (const [code, key, modifiers] of [["Space", "\u00a0", 0], ["", " ", 0], ["Space", " ", 8], ["Space", "Process", 0]]) {
        await page.evaluate(([code, key, modifiers]) => document.body.dispatchEvent(new KeyboardEvent("keydown", { code, key, shiftKey: modifiers === 8, bubbles: true })), [code, key, modifiers]);
        await until(`the stop by ${code} ${key}`, () => robot.engaged, 5);
        robot.obey("stop", { engaged: false });
      }
      const before = stops(robot);
      for (const autoRepeat of [false, true, true, true]) {
        await client?.send("Input.dispatchKeyEvent", { type: "keyDown", code: "Space", key: " ", autoRepeat });
        await wait(60);
      }
      if (client) assert.equal(stops(robot), before + 1, "a held key is one order");
      robot.obey("stop", { engaged: false });
      await until("the release", () => page.$eval(".release", (button) => button.hidden), 5);
      await client?.send("Input.dispatchKeyEvent", { type: "keyDown", code: "Space", key: " ", autoRepeat: true });
      if (client) await until("that a key which is still held stops again", () => robot.engaged, 5);
      robot.obey("stop", { engaged: false });
      const told = robot.told.length;
      await press(page, "Save map");
      await page.waitForSelector("dialog input");
      await page.$eval("dialog input", (input) => input.select());
      await page.keyboard.type("first floor");
      assert.equal(await page.$eval("dialog input", (input) => input.value), "first floor");
      await page.keyboard.press("Enter");
      await until("the order to save", () => robot.told.length > told);
      assert.deepEqual(robot.told.slice(told).map((one) => [one.service, one.folder]), [["slam", "first floor"]]);
    });
  },

  async "Escape closes what is open, and ends stick and goal without a latch"() {
    await withRobot({}, async (robot, url) => {
      robot.last.set("MESH", modelTiles(1, 1, 100)[0]);
      const page = await open(browser, url);
      await until("a pose", async () => (await text(page, ".drive .figures")).includes(" m"));
      for (const { name, enter } of usable()) {
        await enter(page);
        robot.held = true;
        robot.obey("go", { x_m: 3, y_m: 0.5 });
        await until("the goal on the page", async () => (await text(page, ".drive .figures")).includes("Goal") || page.$eval("#panel-drive", (body) => body.hidden || !body.offsetParent), 5);
        await wait(50);
        await page.keyboard.press("Escape");
        await until(`the goal's end from ${name}`, () => robot.told.some((one) => one.service === "end_goal") && robot.goal === null, 5);
        assert.equal(await page.$$eval("dialog[open]", (nodes) => nodes.length), 0, `${name}: a dialog stays`);
        assert.equal(await text(page, ".said"), "", `${name}: a tool stays`);
        robot.told = [];
        await leave(page);
      }
      await page.keyboard.down("KeyW");
      await until("that it drives", () => robot.velocities.some((one) => one.v > 0.25), 5);
      await page.keyboard.press("Escape");
      await until("zero while the key is still down", () => robot.velocities.at(-1).v === 0, 5);
      await wait(400);
      assert.equal(robot.velocities.at(-1).v, 0);
      await page.keyboard.up("KeyW");
      const stick = await (await page.$(".stick")).boundingBox(), middle = [stick.x + stick.width / 2, stick.y + stick.height / 2];
      await page.mouse.move(...middle);
      await page.mouse.down();
      await until("that the stick drives", async () => {  // again where the page was late, and refused it
        await page.mouse.move(middle[0], middle[1] - 80 - Math.random());
        return robot.velocities.at(-1).v > 0.25;
      }, 5);
      await page.keyboard.press("Escape");
      await page.mouse.move(middle[0], middle[1] - 70);
      await until("zero while the stick is still held", () => robot.velocities.at(-1).v === 0, 5);
      await page.mouse.up();
      assert.equal(stops(robot), 0, "it is not latched");
      await page.keyboard.press("Escape");
      await wait(200);
      assert.deepEqual(robot.told, [], "without a goal nobody is told");
    });
  },

  async "Stop is the first stop of the Tab key, Enter presses it, and Enter presses buttons"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url), at = () => page.evaluate(() => document.activeElement.className);
      await until("a pose", async () => (await text(page, ".drive .figures")).includes(" m"));
      await page.keyboard.press("Tab");
      assert.equal(await at(), "stop");
      await page.keyboard.press("Enter");
      await until("the stop", () => robot.engaged, 5);
      robot.obey("stop", { engaged: false });
      for (const words of dialogs) {
        await press(page, words);
        await page.waitForSelector("dialog[open]");
        assert.equal(await page.$eval("dialog", (node) => node.querySelector("button, input").className), "stop", `${words}: Stop is first`);
        assert.equal(await page.$eval("dialog", (node) => node.getElementsByClassName("stop").length), 1);
        await page.focus(".stop");
        await page.keyboard.press("Enter");
        await until(`the stop in ${words}`, () => robot.engaged, 5);
        robot.obey("stop", { engaged: false });
        await page.evaluate((next) => {  // at once
          document.querySelector("dialog").close();
          [...document.querySelectorAll("button")].find((one) => one.innerText === next).click();
        }, dialogs[0]);
        await until("the end of the first", () => page.$$eval("dialog", (nodes) => nodes.length === 1), 5);
        assert.ok(await page.$eval("dialog[open]", (node) => node.contains(document.querySelector(".stop"))), `Stop is in the dialog after ${words}`);
        await page.keyboard.press("Escape");
        await until("its end", () => page.$$eval("dialog", (nodes) => nodes.length === 0), 5);
        assert.equal(await page.$eval("#halt", (node) => node.parentNode.tagName), "BODY");
      }
      assert.ok(await page.$$eval("[role=tabpanel]", (bodies) => bodies.every((body) => body.tabIndex === 0)), "by keys, too, a long tab is scrolled");
      await page.focus("#tools [aria-label='Measure a distance']");
      await page.keyboard.press("Enter");
      assert.notEqual(await text(page, ".said"), "");
      assert.equal(robot.told.filter((one) => one.service === "stop" && one.engaged).length, 1 + dialogs.length);
    });
  },
});
