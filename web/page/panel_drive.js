import { ask, coordinate, el, replaceChildren } from "./dom.js";
import { makeStick } from "./drive.js";
import { kGreyS } from "./late.js";

const kFates = ["waiting for an order", "driving", "arrived", "stopped by an obstacle", "refused the order", "ended by another order"];
const kLinks = ["base not connected", "base is starting", ""];

// Stick, goal and orders to SLAM. `tools` starts the map's tools: go(), pose(chosen), stopTool().
export function makeDrivePanel(world, robot, drive, tools) {
  const where = el("dl", { class: "figures" });
  const note = el("p", { class: "note", hidden: true });
  const stick = el("div", { class: "stick", role: "application", "aria-label": "Joystick: up drives forward, sideways turns", "aria-keyshortcuts": "ArrowUp ArrowDown ArrowLeft ArrowRight W A S D" });
  const speed = el("input", { type: "range", min: "0.05", max: "1", step: "0.05", value: String(drive.limits.v), "aria-label": "Highest speed" });
  const speedText = el("output", {});
  const showSpeed = () => {
    drive.limits.v = Number(speed.value);
    drive.limits.w = Math.min(1.2, 0.4 + drive.limits.v);
    speedText.textContent = `${drive.limits.v.toFixed(2)} m/s`;
  };
  speed.addEventListener("input", showSpeed);
  showSpeed();
  makeStick(stick, drive);
  const wide = (label, what, kind = "") => el("button", { type: "button", class: kind, onclick: what }, label);
  const goButton = wide("Go to a place", () => tools.go(), "primary");
  // A laser that was left tilted maps nothing; one that sweeps is meant to.
  const level = el("div", { class: "note", hidden: true }, el("p", {}, "The laser is tilted or panned, so it adds nothing to the map."),
    wide("Level the laser", () => robot.order("head", { pan_rad: 0, tilt_rad: 0 })));
  world.on("head", () => {
    const kAheadRad = 0.05, kStillMs = 2000, { pan, tilt, since } = world.head;
    level.hidden = world.readOnly || Math.max(Math.abs(pan), Math.abs(tilt)) < kAheadRad || performance.now() - since < kStillMs;
  });
  const record = wide("Record", () => robot.order("record", { on: record.getAttribute("aria-pressed") !== "true" }));

  const orders = el("div", { class: "grid" },
    wide("Save map", () => save(robot, world)),
    record,
    wide("Keep recording", () => robot.order("keep", {})),
    wide("Pause", () => robot.slam("pause")),
    wide("Resume", () => robot.slam("resume")),
    wide("Where am I", () => localize(robot, tools)),
    wide("Extend a map", () => extend(robot)),
    wide("New map", () => reset(robot), "quiet-danger"));

  const steering = [stick, el("label", { class: "slider" }, el("span", {}, "Highest speed"), speed, speedText),
    el("p", { class: "hint" }, "Also with arrow keys or WASD while this tab is open, or a gamepad with a shoulder button held. Space is Stop; Escape ends stick and goal."),
    goButton, el("h2", {}, "Map and recording"), orders];
  const content = el("div", { class: "drive" }, note, level, where, steering);

  function showPose() {
    const pose = world.robot;
    const rows = [];
    if (pose) {
      rows.push(["Position", `${coordinate(pose.x)}, ${coordinate(pose.y)} m`], ["Heading", `${(pose.theta * 180 / Math.PI).toFixed(0)}°`],
        ["Localized", ["scan matched", "dead reckoning", "lost"][pose.status] ?? "?", pose.status === 0 ? "" : "warning"]);
      rows.push(["Seen", `${robot.late.pose_s.toFixed(1)} s ago`, robot.late.pose_s > kGreyS ? "warning" : ""]);
      if (pose.covariance) rows.push(["Known to", `${(100 * Math.sqrt(Math.max(pose.covariance[0][0] + pose.covariance[1][1], 0))).toFixed(1)} cm`]);
    } else {
      rows.push(["Position", "not yet known"]);
    }
    if (world.goal) rows.push(["Goal", `${coordinate(world.goal.x)}, ${coordinate(world.goal.y)} m`]);
    if (world.base) {
      const link = kLinks[world.base.link] ?? "";
      rows.push(["Base", link || kFates[world.base.command] || "", link ? "warning" : ""]);
      if (world.base.note) rows.push(["", world.base.note]);
      if (world.base.guard) rows.push(["Guard", world.base.guard, "warning"]);
    }
    replaceChildren(where, rows.map(([name, value, kind]) => [el("dt", {}, name), el("dd", { class: kind ?? "" }, value)]));
  }

  function showReadOnly() {
    const why = world.mode !== "live" ? "This is a recording: nothing to steer."
      : world.readOnly ? "You can only watch: open the address with its token to steer. Stop works for everybody." : "";
    note.textContent = why;
    note.hidden = why === "";
    for (const control of content.querySelectorAll("button, input")) control.disabled = why !== "";
    stick.setAttribute("aria-disabled", String(why !== ""));
    steering.forEach((part) => { part.hidden = why !== ""; });
  }

  world.on("commands", () => {
    const logger = world.commands.commands.find((command) => command.name === "logger");
    const on = logger?.state === "running";
    record.setAttribute("aria-pressed", String(on));
    record.textContent = on ? "End recording" : "Record";
  });
  let due = false;  // four times a second are enough to read
  for (const what of ["pose", "base", "goal"]) {
    world.on(what, () => {
      if (due) return;
      due = true;
      setTimeout(() => { due = false; showPose(); }, 250);
    });
  }
  world.on("info", showReadOnly);
  showPose();
  return content;
}

async function save(robot, world) {
  const answer = await ask({ title: "Save the map", accept: "Save",
    fields: [{ name: "folder", label: "Folder", value: new Date().toISOString().slice(0, 16).replace("T", "_").replace(":", ""), hint: "A name in the robot's map folder" }] });
  if (answer?.folder) robot.slam("save", { folder: answer.folder });
}

async function reset(robot) {
  const yes = await ask({ title: "Start a new map?", text: "Everything mapped since the last save will be lost.", accept: "New map", danger: true });
  if (yes) robot.slam("reset");
}

async function extend(robot) {
  const answer = await ask({ title: "Extend a saved map", accept: "Extend", text: "The robot finds its pose in that map and extends it.",
    fields: [{ name: "folder", label: "Folder of the map" }] });
  if (answer?.folder) robot.slam("extend", { folder: answer.folder });
}

// Two ways: by hand in this map, or by search in a saved one.
async function localize(robot, tools) {
  const answer = await ask({ title: "Where is the robot?", accept: "Continue",
    text: "Leave the field empty to draw the robot's pose on this map. Name a saved map to let the robot find its pose in it.",
    fields: [{ name: "folder", label: "Folder of a saved map (or empty)" }] });
  if (answer === null) return;
  if (answer.folder) robot.slam("localize", { folder: answer.folder });
  else tools.pose((x_m, y_m, theta_rad) => robot.slam("set_pose", { x_m, y_m, theta_rad }));
}
