import { el, replaceChildren } from "./dom.js";
import { worst } from "./panel_health.js";

const kModes = { live: "live", folder: "map folder", recording: "recording" };

// The bar above, what is said when the connection is lost, and the stop button.
// showHealth() opens the panel that says more.
export function makeStatus(bar, banner, halt, world, robot, showHealth) {
  const name = el("strong", {}), mode = el("span", { class: "mode" }), chips = el("div", { class: "chips" });
  bar.append(el("div", { class: "chip title" }, name, mode), chips);

  function showBar() {
    const address = /^[a-z]+:\/\//.test(world.name);  // of a network: nothing to read
    name.textContent = address ? "Marco" : world.name || "Marco";
    name.title = world.name;
    mode.textContent = world.connection === "open" ? kModes[world.mode] ?? world.mode : world.connection === "lost" ? "not connected" : "connecting";
    bar.dataset.connection = world.connection;
    replaceChildren(chips,
      world.readOnly ? chip("Watching only", "") : null,
      battery(world.health),
      world.base?.guard ? el("button", { type: "button", class: "chip warning", title: world.base.guard, onclick: showHealth }, `Guard: ${world.base.guard.split(":")[0]}`) : null,
      world.health && worst(world.health) === "error" ? el("button", { type: "button", class: "chip error", onclick: showHealth }, "See Health") : null);
  }
  function showBanner() {
    banner.hidden = world.connection === "open";
    banner.textContent = world.connection === "lost" ? "Connection lost. What you see is old. Connecting again…" : "Connecting…";
    banner.className = world.connection;
    halt.dataset.connection = world.connection;
  }
  for (const what of ["info", "connection", "health", "guard"]) world.on(what, showBar);
  world.on("connection", showBanner);
  world.on("info", () => { showBanner(); halt.hidden = world.mode !== "live"; });
  showBar();
  halt.hidden = true;

  return {
    live() {
      const stop = el("button", { type: "button", class: "stop", onclick: () => robot().stop(true) }, el("span", {}, "Stop"));
      const release = el("button", { type: "button", class: "release", onclick: () => robot().stop(false) }, "Release");
      const by = el("p", { class: "stopped", role: "alert" });
      halt.append(by, release, stop);
      const show = () => {
        const { engaged, by: who } = world.stop;
        by.textContent = engaged ? `Stopped${who ? ` by ${who}` : ""}` : "";
        by.hidden = release.hidden = !engaged;
        stop.setAttribute("aria-pressed", String(engaged));
      };
      world.on("stop", show);
      show();
      halt.hidden = false;
      showBanner();
    },
  };
}

function chip(text, kind) {
  return el("span", { class: `chip ${kind}` }, text);
}

function battery(health) {
  const volts = health?.battery_v ?? [];
  return volts.length > 0 ? chip(`${volts[0].toFixed(1)} V`, "") : null;
}
