// Stop of the page in random states of it, against marco-page: from the press to EMERGENCY_STOP on the bus, while poses and a
// model arrive. Also with the connection cut: then from its return.
// usage: node page_stop.mjs PROJECT MARCO_PAGE [STATES [SEED]]
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { connect, createServer } from "node:net";
import { Bus } from "./bus.mjs";
import { desktop, firefox, launch, open, phone, reachable, text, until, wait } from "./browser.mjs";
import { modelTiles } from "./page_robot.mjs";

const [project, marcoPage, states = "30", seed = "1"] = process.argv.slice(2);
const kMostMs = 500;  // of nine orders in ten; 100 are wanted of all, where the machine has time for it
const perViewport = 6;

// Numbers that are the same each time.
let random_state = Number(seed);
function random() {
  random_state = (random_state + 0x6D2B79F5) | 0;
  let t = Math.imul(random_state ^ (random_state >>> 15), 1 | random_state);
  t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
  return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
}
const pick = (list) => list[Math.floor(random() * list.length)];

// Between browser and server, to be cut.
class Link {
  constructor(port) {
    this.isCut = false;
    this.ends = new Set();
    this.server = createServer((near) => {
      if (this.isCut) return near.destroy();
      const far = connect({ port, host: "127.0.0.1", noDelay: true });
      near.setNoDelay(true);
      for (const [from, to] of [[near, far], [far, near]]) {
        this.ends.add(from);
        from.pipe(to);
        from.on("error", () => {});
        from.on("close", () => { this.ends.delete(from); to.destroy(); });
      }
    });
  }

  listen() {
    return new Promise((done) => this.server.listen(0, "127.0.0.1", () => done(this.server.address().port)));
  }

  cut() {
    this.isCut = true;
    this.ends.forEach((end) => end.destroy());
  }
}

// A robot that drives in a circle, and a model that arrives again and again.
function play(bus) {
  const begun = Date.now(), tiles = modelTiles(1, 40, 2000).map((tile) => bus.encoded("mesh_t", tile));
  let n = 0, model = 0;
  const covariance = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-4]];
  const timer = setInterval(() => {
    const angle = (Date.now() - begun) / 3000, utime = 1000 * Date.now();
    bus.send("SLAM_POSE", "slam_pose_t", { utime, x_m: 2 * Math.cos(angle), y_m: 2 * Math.sin(angle), theta_rad: angle + Math.PI / 2, covariance, status: 0, overlap: 0.9 });
    if (++n % 2 === 0) bus.send("BASE_STATUS", "base_status_t", { utime, base: "test", link: 2, command_id: 0, command: 0, motors_on: 1, num_batteries: 1, battery_v: [12.4], num_bumpers: 0, bumpers: [], note: "" });
    if (n % 80 === 0) model = tiles.length;
    for (let i = 0; i < 4 && model > 0; ++i) bus.publish("MESH", tiles[--model]);
  }, 50);
  return () => clearInterval(timer);
}

const act = (page, body, ...values) => page.evaluate(body, ...values);
const clickButton = (page, words) => act(page, (wanted) => [...document.querySelectorAll("button")].find((one) => (one.innerText.trim() || one.getAttribute("aria-label")) === wanted)?.click(), words);
function notePresses() {
  for (const what of ["pointerdown", "keydown"]) {
    addEventListener(what, (event) => { if (event.key !== "Escape") window.pressedAt = performance.timeOrigin + event.timeStamp; }, { capture: true });
  }
}
const views = { map: null, "3d": "3D model", both: "Plan and 3D side by side" };

async function setState(page) {
  const state = { view: pick(firefox ? ["map"] : Object.keys(views)), tab: pick(["drive", "map", "health", "programs"]), isClosed: random() < 0.3, night: random() < 0.3,
    tool: pick([null, null, "Measure a distance", "Go to a place"]), dialog: pick([null, null, "Save map", "Where am I", "Extend a map", "New map"]), focus: random() };
  const now = await act(page, () => document.body.dataset.view ?? "map");
  if (now !== state.view) await clickButton(page, views[state.view] ?? views[now]);
  if (!firefox) await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: state.night ? "dark" : "light" }]);
  await act(page, ({ tab, isClosed }) => {
    const panel = document.querySelector("#panel"), button = document.querySelector(`#tab-${tab}`);
    if (panel.classList.contains("closed") || button.getAttribute("aria-selected") !== "true") button.click();
    if (isClosed !== panel.classList.contains("closed")) button.click();
  }, state);
  if (state.tool) await clickButton(page, state.tool);
  if (state.dialog) await clickButton(page, state.dialog);
  state.focused = await act(page, (part) => {
    const root = document.querySelector("dialog[open]") ?? document;
    const all = [document.body, ...root.querySelectorAll("button, input, canvas, [tabindex]")].filter((node) => node === document.body || node.offsetParent);
    const node = all[Math.floor(part * all.length)];
    if (node === document.body) document.activeElement?.blur();
    else node.focus();
    return `${node.tagName} ${node.className || node.id || node.type || ""}`;
  }, state.focus);
  return state;
}

function whatIsThere() {
  const { x, y, width, height } = document.querySelector(".stop").getBoundingClientRect(), there = document.elementFromPoint(x + width / 2, y + height / 2);
  return `${there?.outerHTML.slice(0, 80)} at ${[x, y, width, height]}, Stop in ${document.querySelector("#halt").parentNode.tagName}`;
}

// How it is pressed; a text field keeps the Space.
async function press(page, isTouch) {
  const isTyping = await act(page, () => document.activeElement.matches("input[type=text]"));
  const how = pick(isTyping ? ["pointer"] : ["pointer", "Space", "Space", "Enter"]);
  if (how === "Enter") await page.focus(".stop");
  assert.ok(await reachable(page, ".stop"), `Stop is covered, or outside: ${await act(page, whatIsThere)}`);
  const box = await (await page.$(".stop")).boundingBox(), at = [box.x + box.width * (0.3 + 0.4 * random()), box.y + box.height * (0.3 + 0.4 * random())];
  if (how !== "pointer") await page.keyboard.down(how);
  else if (isTouch) await page.touchscreen.touchStart(...at);
  else await page.mouse.move(...at).then(() => page.mouse.down());
  return [how, () => (how !== "pointer" ? page.keyboard.up(how) : isTouch ? page.touchscreen.touchEnd() : page.mouse.up())];
}

const browser = await launch();
const server = spawn(marcoPage, ["--listen", "127.0.0.1:0"]);
server.said = "";
for (const stream of [server.stdout, server.stderr]) stream.on("data", (data) => { server.said += data; });
const bus = new Bus(project), times = { pointer: [], Space: [], Enter: [], "after a cut": [] };
await bus.open();
const stops = [];
bus.on("EMERGENCY_STOP", "emergency_stop_t", ({ engaged, sender }, at) => engaged && sender !== "test" && stops.push(at));
const end = play(bus);

async function released(page) {
  await until("the release", () => {
    bus.send("EMERGENCY_STOP", "emergency_stop_t", { utime: 1000 * Date.now(), engaged: 0, sender: "test", reason: "" });
    return act(page, () => document.querySelector(".release").hidden);
  }, 10);
  for (let i = 0; i < 3; ++i) await page.keyboard.press("Escape");
  await wait(60);
  stops.length = 0;
}

async function tryState(page, link, isTouch) {
  await released(page);
  const isCut = random() < 0.12, state = { ...await setState(page), isCut };
  let how = "", letGo = null;
  try {
    if (isCut) {
      link.cut();
      await until("that it is lost", () => act(page, () => document.querySelector("#banner").className === "lost"), 10);
    }
    [how, letGo] = await press(page, isTouch);
    let from = await until("the press in the page", () => act(page, () => window.pressedAt), 10);
    if (isCut) {
      await until("that it says so", async () => (await text(page, ".stopped")).includes("is unreachable"), 5);
      await wait(3000 * random());
      link.isCut = false;
      from = performance.timeOrigin + performance.now();
    }
    const at = performance.timeOrigin + await until("the order", () => stops[0], 10);
    await letGo();
    times[isCut ? "after a cut" : how].push(at - from);
    await until("what is said", async () => (await text(page, ".stopped")).startsWith("Stopped"), 10);
    await until("that it is live", async () => (await text(page, "#bar .mode")) === "live");
  } catch (fault) {
    console.log(`${how} in ${JSON.stringify(state)}: ${await text(page, ".stopped, .toast, #bar, #banner")}`);
    throw fault;
  }
}

let failed = 1;
try {
  const port = new URL(await until("the address", () => server.said.match(/^http:\S+/m)?.[0])).port, link = new Link(port), near = await link.listen();
  const viewports = [desktop, phone, { width: 1440, height: 757 }, { ...phone, width: 360, height: 640 }, { ...phone, width: 844, height: 390 }];
  for (let done = 0; done < Number(states); done += perViewport) {
    const viewport = viewports[(done / perViewport) % viewports.length];
    const page = await open(browser, `http://127.0.0.1:${near}/`, { viewport, before: (page) => page.evaluateOnNewDocument(notePresses) });
    await until("a pose", async () => (await text(page, ".drive .figures")).includes(" m"));
    for (let i = 0; i < perViewport && done + i < Number(states); ++i) {
      await act(page, () => { window.pressedAt = 0; });
      await tryState(page, link, viewport.hasTouch ?? false);
    }
    assert.deepEqual(page.faults, []);
    await page.close();
  }
  const all = [...times.pointer, ...times.Space, ...times.Enter];
  for (const [how, list] of Object.entries(times)) {
    list.sort((a, b) => a - b);
    const part = (share) => list[Math.min(list.length - 1, Math.floor(share * list.length))]?.toFixed(0);
    console.log(`${how}: ${list.length} presses, the order on the bus after ${part(0.5)} ms, 9 of 10 after ${part(0.9)}, all after ${part(1)} ms`);
  }
  assert.ok(all.filter((ms) => ms < kMostMs).length >= 0.9 * all.length, "orders come late");
  failed = 0;
} catch (fault) {
  console.log(fault.stack, "\n", server.said.slice(-2000));
}
end();
await browser.close();
server.kill("SIGTERM");
process.exit(failed);
