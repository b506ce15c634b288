// Hands on the page: mouse, keys, gamepad and fingers, on screens of all sizes.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { desktop, drawn, findColor, findImage, firefox, freeDay, open, phone, press, reachable, text, three, until, wait } from "./browser.mjs";
import { withFile } from "./page_file.mjs";

export const handCases = (browser, withRobot, marcoExport) => ({
  async "a gamepad drives while a shoulder button is held and the page has the focus"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await page.evaluate(() => {
        window.pad = { axes: [0, 0, 0, 0], buttons: Array.from({ length: 16 }, () => ({ pressed: false })) };
        navigator.getGamepads = () => [null, window.pad];  // the first place is free, as after a pad was pulled out
      });
      if (!firefox) await (await page.createCDPSession()).send("Emulation.setFocusEmulationEnabled", { enabled: true });
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
      await until("half speed left of ahead", () => robot.velocities.some((one) => Math.abs(one.v - 0.3) < 0.01 && Math.abs(one.w + 0.35) < 0.01), 5);
      await pad([0, -1, 0.5, 0], false);
      await until("zero at the release", () => robot.velocities.at(-1).v === 0 && robot.velocities.at(-1).w === 0, 5);
      await pad([0, -1, 0, 0], true);
      await until("that it drives again", () => robot.velocities.at(-1).v > 0.25, 5);
      await page.evaluate(() => { document.hasFocus = () => false; });
      await until("zero without the focus", () => robot.velocities.at(-1).v === 0, 5);
      await page.evaluate(() => { delete document.hasFocus; });
      await until("that it drives once more", () => robot.velocities.at(-1).v > 0.25, 5);
      await page.evaluate(() => { navigator.getGamepads = () => [null, null]; });
      await until("zero when the pad is pulled out", () => robot.velocities.at(-1).v === 0, 5);
    });
  },

  async "two fingers move, zoom and turn the map, and what is under them stays there"() {
    if (firefox) return console.log("  SKIPPED: no touch");
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url, { viewport: { ...desktop, hasTouch: true } }), touch = await fingers(page);
      await until("a map", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      await press(page, "Zoom out");  // from here on the view stays, though the map grows
      await drawn(page);
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

  async "stop is in reach everywhere, stops, is shown to all, and is released"() {
    await withRobot({}, async (robot, url) => {
      const [page, second] = [await open(browser, url, { viewport: phone }), await open(browser, url)];
      await until("the button", () => reachable(page, ".stop"));
      for (const tab of ["drive", "map", "health", "programs"]) {
        await page.click(`#tab-${tab}`);
        await until(`stop is covered while ${tab} is open`, () => reachable(page, ".stop"));
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

  async "stick and keys drive while held, ten times a second, and end with zero"() {
    await withRobot({}, async (robot, url) => {
      const page = await open(browser, url);
      await until("a pose", async () => (await text(page, ".drive .figures")).includes("m"));
      const ends = async (what) => {
        await until(`${what} ends with zero`, () => robot.velocities.length > 0 && robot.velocities.at(-1).v === 0 && robot.velocities.at(-1).w === 0, 5);
        const { length } = robot.velocities;
        await wait(800);
        assert.ok(robot.velocities.length <= length + 3, `${what}: orders after the release`);
        robot.velocities = [];
      };
      const stick = await (await page.$(".stick")).boundingBox(), middle = [stick.x + stick.width / 2, stick.y + stick.height / 2];
      await page.mouse.move(...middle);
      await page.mouse.down();
      await page.mouse.move(middle[0], middle[1] - 80);
      const held = await until("a dozen orders", () => {
        const orders = robot.velocities.filter((one) => one.v > 0.25);
        return orders.length >= 12 ? orders : null;
      });
      const gaps = held.slice(1).map((one, i) => one.at - held[i].at).sort((a, b) => a - b);
      assert.ok(gaps[5] >= 60 && gaps[5] <= 160, `an order every ${gaps[5]} ms`);
      await page.mouse.up();
      await ends("stick");
      await page.keyboard.down("KeyA");
      await until("a turn to the left", () => robot.velocities.some((one) => one.w > 0.5 && one.v === 0), 5);
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

  async "two fingers move and zoom the model"() {
    if (firefox || !existsSync(three)) return console.log("  SKIPPED: no touch, or no three.js (Debian: libjs-three)");
    await withFile(marcoExport, async (url) => {
      const page = await open(browser, url, { viewport: { ...desktop, hasTouch: true } }), touch = await fingers(page);
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
});

// Two fingers go from where they are to elsewhere, straight, in so many steps.
async function fingers(page) {
  const client = await page.createCDPSession();
  return async (from, to, steps) => {
    const send = (type, touchPoints) => client.send("Input.dispatchTouchEvent", { type, touchPoints });
    const at = (part) => from.map(([x, y], id) => ({ id, x: x + part * (to[id][0] - x), y: y + part * (to[id][1] - y) }));
    await send("touchStart", at(0));
    for (let step = 1; step <= steps; ++step) await send("touchMove", at(step / steps));
    await send("touchEnd", []);
    await drawn(page);
  };
}
