import { el, replaceChildren } from "./dom.js";

const kOrder = { error: 0, silent: 1, warning: 2, ok: 3 };

// What is missing and what to do first; then programs and channels.
export function makeHealthPanel(world, panelMark) {
  const content = el("div", {});
  world.on("health", () => {
    const { health } = world;
    panelMark(worst(health));
    replaceChildren(content,
      findings(health.findings ?? []),
      el("dl", { class: "figures" },
        figure("Battery", (health.battery_v ?? []).map((volts) => `${volts.toFixed(1)} V`).join(", ") || "unknown"),
        figure("Latency", health.latency_ms === null || health.latency_ms === undefined ? "not known" : `${health.latency_ms.toFixed(0)} ms`),
        figure("Watching", `${health.clients} browser${health.clients === 1 ? "" : "s"}`),
        health.refused > 0 ? figure("Refused", String(health.refused)) : null,
        health.dropped > 0 ? figure("Dropped for slow browsers", String(health.dropped)) : null),
      el("h2", {}, "Programs"), programs(health.programs ?? []),
      el("h2", {}, "Channels"), channels(health.channels ?? []));
  });
  content.append(el("p", { class: "hint" }, "No data yet."));
  return content;
}

export function worst(health) {
  const states = [...(health.findings ?? []).map((finding) => finding.severity), ...(health.programs ?? []).map((program) => (program.state === "silent" ? "error" : program.state))];
  return states.includes("error") ? "error" : states.includes("warning") ? "warning" : "";
}

function figure(name, value) {
  return [el("dt", {}, name), el("dd", {}, value)];
}

function findings(list) {
  if (list.length === 0) return el("p", { class: "verdict good" }, "No problems");
  return el("ul", { class: "findings" }, list.map((finding) => el("li", { class: finding.severity },
    el("p", {}, finding.text), finding.remedy ? el("p", { class: "remedy" }, finding.remedy) : null)));
}

function programs(list) {
  const sorted = [...list].sort((a, b) => (kOrder[a.state] ?? 3) - (kOrder[b.state] ?? 3) || a.name.localeCompare(b.name));
  if (sorted.length === 0) return el("p", { class: "hint" }, "No program reports its status.");
  return el("ul", { class: "programs" }, sorted.map((program) => el("li", {},
    el("span", { class: `dot ${program.state}`, role: "img", "aria-label": program.state }),
    el("div", {}, el("strong", {}, program.name),
      el("small", {}, program.state === "silent" ? `silent for ${program.age_s.toFixed(0)} s` : program.text)))));
}

function channels(list) {
  const rows = [...list].sort((a, b) => a.name.localeCompare(b.name)).map((channel) => el("tr", { class: channel.lost > 0 ? "warning" : "" },
    el("td", {}, channel.name, el("small", {}, channel.type)), el("td", {}, channel.hz >= 10 ? channel.hz.toFixed(0) : channel.hz.toFixed(1)), el("td", {}, String(channel.lost ?? 0))));
  return el("table", { class: "channels" }, el("thead", {}, el("tr", {}, el("th", {}, "Channel"), el("th", {}, "Hz"), el("th", {}, "Lost"))), el("tbody", {}, rows));
}
