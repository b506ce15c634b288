import { el, replaceChildren } from "./dom.js";

const kDots = { running: "ok", stopped: "off", starting: "warning", stopping: "warning", failed: "error" };

// procman's commands by group: what they do, their output, start, stop and restart.
export function makeProgramsPanel(world, robot) {
  const list = el("div", {}), title = el("h2", {}), lines = el("pre", { class: "output", tabindex: "0" });
  const output = el("div", { hidden: true }, title, lines);
  let opened = null, drawn = "";

  function show() {
    const commands = world.commands?.commands ?? [];
    const now = JSON.stringify([commands, world.readOnly, opened]);
    if (now === drawn) return;
    drawn = now;
    const groups = new Map();
    for (const command of commands) {
      if (!groups.has(command.group)) groups.set(command.group, []);
      groups.get(command.group).push(command);
    }
    if (commands.length === 0) {
      return replaceChildren(list, el("p", { class: "hint" }, "No procman reports commands. Health shows programs started without procman."));
    }
    replaceChildren(list, [...groups].map(([group, members]) => [group ? el("h2", {}, group) : null, el("ul", { class: "programs" }, members.map(row))]));
  }

  function row(command) {
    const act = (label, action) => el("button", { type: "button", class: "quiet", disabled: world.readOnly, onclick: () => robot.order("procman", { command: command.name, action }) }, label);
    const runs = command.state === "running" || command.state === "starting";
    return el("li", { title: command.exec },
      el("span", { class: `dot ${kDots[command.state] ?? "warning"}`, role: "img", "aria-label": command.state }),
      el("button", { type: "button", class: "name", "aria-pressed": String(opened === command.name), onclick: () => open(command.name) }, el("strong", {}, command.name), el("small", {}, `${command.state}${command.host ? ` on ${command.host}` : ""}`)),
      el("div", { class: "row" }, runs ? [act("Restart", "restart"), act("Stop", "stop")] : act("Start", "start")));
  }

  function open(name) {
    opened = opened === name ? null : name;
    show();
    showOutput();
  }

  // Stays at the end, unless the reader has scrolled up.
  function showOutput() {
    output.hidden = opened === null;
    if (opened === null) return;
    title.textContent = `Output of ${opened}`;
    const atEnd = lines.scrollTop + lines.clientHeight >= lines.scrollHeight - 8;
    lines.textContent = (world.output.get(opened) ?? ["(nothing yet)"]).join("\n");
    if (atEnd) lines.scrollTop = lines.scrollHeight;
  }

  for (const what of ["commands", "info"]) world.on(what, show);
  world.on("output", showOutput);
  show();
  return el("div", {}, list, output);
}
