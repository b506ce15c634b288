import { el, replaceChildren } from "./dom.js";
import { kSaidS } from "./late.js";
import { worst } from "./panel_health.js";

const kConnections = { lost: "not connected", connecting: "connecting" };
const kModes = { live: "live", folder: "map folder", recording: "recording" };

// The bar above, and what is said when the connection is lost. late(): of robot.late, or null; showHealth() opens the panel that
// says more. @returns what shows anew whether that is late.
export function makeStatus(bar, banner, halt, world, late, showHealth) {
  const name = el("h1", {}), mode = el("span", { class: "mode" }), chips = el("div", { class: "chips" });
  bar.append(el("div", { class: "chip title" }, name, mode), chips);

  function showMode() {
    const isOpen = world.connection === "open", old = isOpen && late() ? sayLate(late()) : "";
    mode.textContent = isOpen ? old || (kModes[world.mode] ?? world.mode) : kConnections[world.connection];
    bar.dataset.state = old ? "late" : world.connection;
  }
  function showBar() {
    const address = /^[a-z]+:\/\//.test(world.name);  // of a network: nothing to read
    name.textContent = address ? "Marco" : world.name || "Marco";
    name.title = world.name;
    showMode();
    replaceChildren(chips,
      world.readOnly ? chip("Watching only", "") : null,
      battery(world.health),
      world.base?.guard ? el("button", { type: "button", class: "chip warning", title: world.base.guard, onclick: showHealth }, `Guard: ${world.base.guard.split(":")[0]}`) : null,
      world.health && worst(world.health) === "error" ? el("button", { type: "button", class: "chip error", onclick: showHealth }, "See Health") : null);
  }
  function showBanner() {
    banner.hidden = world.connection === "open";
    banner.textContent = world.connection === "lost" ? "Connection lost. The picture is old. Reconnecting…" : "Connecting…";
    banner.className = world.connection;
  }
  for (const what of ["info", "connection", "health", "guard"]) world.on(what, showBar);
  world.on("connection", showBanner);
  world.on("info", () => { showBanner(); halt.hidden = world.mode !== "live"; });
  showBar();
  showBanner();
  return showMode;
}

function sayLate({ page_s, pose_s }) {
  if (page_s > kSaidS) return `late ${page_s.toFixed(0)} s`;
  return pose_s > kSaidS ? `position ${pose_s.toFixed(0)} s old` : "";
}

function chip(text, kind) {
  return el("span", { class: `chip ${kind}` }, text);
}

function battery(health) {
  const volts = health?.battery_v ?? [];
  return volts.length > 0 ? chip(`${volts[0].toFixed(1)} V`, "") : null;
}
