import { el, iconButton, narrow, toast } from "./dom.js";
import { Drive } from "./drive.js";
import { listenKeys } from "./keys.js";
import { kGreyS } from "./late.js";
import { makeReadout } from "./map_readout.js";
import { measureTool, pointTool, poseTool } from "./map_tools.js";
import { MapView } from "./map_view.js";
import { Panel } from "./panel.js";
import { makeDrivePanel } from "./panel_drive.js";
import { makeHealthPanel } from "./panel_health.js";
import { makeMapPanel } from "./panel_map.js";
import { makeProgramsPanel } from "./panel_programs.js";
import { Robot } from "./robot.js";
import { Socket } from "./socket.js";
import { makeSpace } from "./space.js";
import { makeStatus } from "./status.js";
import { Stop } from "./stop.js";
import { applyTheme, nextTheme } from "./theme.js";
import { Tiles } from "./tiles.js";
import { World } from "./world.js";
import { showPicture } from "./pictures.js";

let panel = null, robot = null, drive = null, stop = null;
const byId = (id) => document.getElementById(id);
const inlined = byId("snapshot");  // of a page that was exported as one file

applyTheme();
const world = new World();
const tiles = new Tiles(() => mapView.redraw());
const mapView = new MapView(byId("map"), world, tiles, coveredRoom);
const readout = makeReadout(byId("readout"), mapView);
const space = makeSpace(byId("space"), byId("model"), world, mapView);

// What panels and bars hide of the plan [px].
function coveredRoom() {
  if (narrow.matches) return { left: 16, right: 60, top: 64, bottom: 72 };
  const alone = byId("stage").dataset.view === "map";
  return { left: panel?.open && alone ? 372 : 24, right: alone ? 84 : 24, top: 72, bottom: 72 };
}

const buttons = {
  measure: iconButton("ruler", "Measure a distance", () => useTool("measure", (say) => measureTool(say))),
  follow: iconButton("follow", "Follow the robot", () => mapView.setFollow(!mapView.follow)),
  north: iconButton("north", "Turn north up", () => mapView.turnNorth()),
  space: iconButton("cube", "3D model", () => setView(byId("stage").dataset.view === "3d" ? "map" : "3d")),
  both: iconButton("both", "Plan and 3D side by side", () => setView(byId("stage").dataset.view === "both" ? "map" : "both")),
};
byId("tools").append(
  el("div", { class: "stack" }, iconButton("plus", "Zoom in", () => zoom(1.5)), iconButton("minus", "Zoom out", () => zoom(1 / 1.5)), iconButton("fit", "Show all", () => (space.active && byId("stage").dataset.view === "3d" ? space.fit() : mapView.fitByUser()))),
  el("div", { class: "stack" }, buttons.follow, buttons.north, buttons.measure),
  el("div", { class: "stack" }, buttons.space, buttons.both),
  el("div", { class: "stack" }, iconButton("sun", "Day, night, or as the system says", () => toast(nextTheme()))));
document.addEventListener("themechange", () => { mapView.readColors(); space.readColors(); });

function zoom(factor) {
  if (byId("stage").dataset.view === "3d") space.zoom(factor);
  else mapView.zoom(factor);
}

let toolName = "";
function useTool(name, make) {
  const off = name === toolName;
  toolName = "";
  mapView.setTool(null);
  space.measure(null);
  if (!off) {
    toolName = name;
    mapView.setTool(make(readout.say));
    if (name === "measure") space.measure(readout.say);
  }
  buttons.measure.setAttribute("aria-pressed", String(toolName === "measure"));
}

const putToolAway = () => toolName !== "" && useTool(toolName);
const letGo = () => {
  putToolAway();
  drive?.release();
};
listenKeys({
  canStop: () => stop !== null && world.mode === "live",
  stop: (isRepeated) => (isRepeated && (stop.waits || world.stop.engaged)) || stop.press(),
  end() {
    letGo();
    robot?.endGoal();
  },
});

// The map's tools, for panels.
const mapTools = {
  go() {
    if (narrow.matches && panel.open) panel.toggle();
    useTool("go", (say) => pointTool(say, "Click the robot's goal", (x, y) => {
      useTool("go");
      robot.goTo(x, y);
    }));
  },
  pose(chosen) {
    if (narrow.matches && panel.open) panel.toggle();
    useTool("pose", (say) => poseTool(say, "Press at the robot's position and drag in its heading", (x, y, theta) => {
      useTool("pose");
      chosen(x, y, theta);
    }));
  },
};

async function setView(view) {
  byId("stage").dataset.view = view;
  byId("space").hidden = view === "map";
  byId("plan").hidden = view === "3d";
  document.body.dataset.view = view;
  for (const closed of { map: ["space"], "3d": ["plan"] }[view] ?? []) robot?.late.shown(closed, null);
  buttons.space.setAttribute("aria-pressed", String(view === "3d"));
  buttons.both.setAttribute("aria-pressed", String(view === "both"));
  await space.activate(view !== "map");
}

const empty = el("p", { class: "empty", hidden: true }, "Nothing to draw yet: the map begins with the first scan. Health lists what is missing.");
byId("plan").append(empty);

mapView.onView = () => {
  readout.update();
  empty.hidden = world.mode === "folder" || tiles.bounds() !== null || world.robot !== null || world.scan !== null;
  buttons.follow.setAttribute("aria-pressed", String(mapView.follow));
  buttons.north.firstChild.style.transform = `rotate(${-mapView.view.angle}rad)`;
  robot?.late.shown("plan", byId("plan").hidden ? null : world.robot);
};
mapView.overlays.push((context, view, colors) => space.drawEye(context, view, colors));
mapView.onClick = (x, y) => {
  if (!mapView.shown.get("photographs")) return;
  const near = world.photographs.map((photograph) => ({ photograph, far: Math.hypot(photograph.x_m - x, photograph.y_m - y) })).sort((a, b) => a.far - b.far)[0];
  if (near && near.far * mapView.view.scale < 16) showPicture(near.photograph.file);
};

function showButtons() {
  const folder = world.mode === "folder";
  buttons.follow.hidden = folder;
  buttons.space.parentNode.hidden = folder && !world.snapshot?.model;
}
for (const what of ["info", "snapshot"]) world.on(what, showButtons);

const showMode = makeStatus(byId("bar"), byId("banner"), byId("halt"), world, () => robot?.late, () => panel.reveal("health"));

if (inlined) showFolder(JSON.parse(inlined.textContent), "folder");
else connect();

function makePanel(tabs) {
  byId("panel").replaceChildren();
  panel = new Panel(byId("panel"), tabs, () => {
    document.body.classList.toggle("panel-open", panel?.open ?? true);
    if (panel && !mapView.touched) mapView.fitByUser();
  });
  document.body.classList.toggle("panel-open", panel.open);
}

function showFolder(snapshot, mode) {
  Object.assign(world, { mode, name: snapshot.name, connection: "open" });
  document.title = `${snapshot.name} - Marco`;
  document.body.dataset.mode = mode;
  makePanel([{ key: "map", label: "About this map", content: makeMapPanel(world, mapView) }]);
  takeSnapshot(snapshot);
  world.tell("info");
}

function takeSnapshot(snapshot) {
  world.takeSnapshot(snapshot);
  tiles.take(snapshot).catch((fault) => toast(`The map cannot be drawn: ${fault.message}`, "error"));
}

async function fetchSnapshot() {
  const answer = await fetch(`snapshot.json${location.search}`).catch(() => null);
  if (answer?.ok) takeSnapshot(await answer.json());
}

function connect() {
  const url = new URL(`ws${location.search}`, location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  const socket = new Socket(url, {
    state(word) {
      world.connection = word;
      drive.release();
      world.tell("connection");
    },
    services: () => stop.waits && stop.send(),
    info(message) {
      const { metadata = {} } = message;
      const isNew = world.session !== message.sessionId;
      world.session = message.sessionId;
      world.mode = metadata.mode ?? "live";
      world.readOnly = metadata.read_only === "true";
      world.name = metadata.name ?? message.name;
      document.title = world.mode === "live" ? "Marco" : `${world.name} - Marco`;
      document.body.dataset.mode = world.mode;
      if (isNew) world.reset();
      if (isNew && world.mode !== "live") fetchSnapshot();
      world.tell("info");
    },
    status: (level, text) => level > 0 && toast(text, level === 2 ? "error" : "warning"),
  });
  robot = new Robot(socket, world, tiles);
  drive = new Drive({
    send: (v, w) => robot.velocity(v, w),
    enabled: () => panel.selected === "drive" && panel.open && !world.readOnly && world.mode === "live" && !(space.active && space.walking),
    refused: () => robot.refusesToDrive(),
  }, { v: 0.3, w: 0.7 });
  stop = new Stop(byId("halt"), world, robot, letGo);
  byId("halt").hidden = false;
  makePanel([
    { key: "drive", label: "Drive", content: makeDrivePanel(world, robot, drive, mapTools) },
    { key: "map", label: "Map", content: makeMapPanel(world, mapView) },
    { key: "health", label: "Health", content: makeHealthPanel(world, (state) => panel.mark("health", state)) },
    { key: "programs", label: "Programs", content: makeProgramsPanel(world, robot) },
  ]);
  space.listen(socket);
  showAges(robot.late);
}

// What is late is seen to be so, also when nothing comes any more.
function showAges(late) {
  let wasLate = false;
  const isLate = () => late.pose_s > kGreyS;
  mapView.isLate = isLate;
  space.onMarked = () => late.shown("space", space.active ? world.robot : null);
  setInterval(() => {
    showMode();
    if (isLate() || wasLate) world.tell("pose");
    wasLate = isLate();
  }, 250);
}
