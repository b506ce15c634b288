// The panel is a sheet from below; as in page.css.
export const narrow = matchMedia("(max-width: 559px), (max-width: 760px) and (orientation: portrait)");

// Elements, made without markup: what comes by the network is only ever text.

export function el(tag, properties, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(properties ?? {})) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name in node && typeof value !== "string") node[name] = value;
    else if (value !== undefined && value !== null) node.setAttribute(name, value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return node;
}

const kIcons = {
  plus: "M12 5v14M5 12h14",
  minus: "M5 12h14",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  follow: "M12 3v3M12 18v3M3 12h3M18 12h3M12 17a5 5 0 1 0 0-10 5 5 0 0 0 0 10z",
  north: "M12 3l5 17-5-4-5 4z",
  ruler: "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l2 2M13 6l2 2",
  cube: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9",
  both: "M3 5h18v14H3zM12 5v14",
  sun: "M12 16a4 4 0 1 0 0-8 4 4 0 0 0 0 8zM12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.5 1.5M17.5 17.5L19 19M5 19l1.5-1.5M17.5 6.5L19 5",
};

export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(svg.namespaceURI, "path");
  path.setAttribute("d", kIcons[name]);
  svg.append(path);
  return svg;
}

export function iconButton(name, label, onclick) {
  return el("button", { class: "icon", type: "button", "aria-label": label, title: label, onclick }, icon(name));
}

// A word to the user that goes by itself; kind "error" stays longer.
export function toast(text, kind = "info") {
  const note = el("div", { class: `toast ${kind}` }, text);
  const toasts = document.getElementById("toasts");
  while (toasts.children.length > 3) toasts.firstChild.remove();
  toasts.append(note);
  setTimeout(() => note.remove(), kind === "error" ? 9000 : 5000);
}

// Stop goes along: what is modal makes all else dead. It is the first to be reached there, too. A dialog's event `close` comes late,
// when another one may be open.
export function showDialog(dialog) {
  const halt = document.getElementById("halt");
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.prepend(halt);
  dialog.showModal();
  new MutationObserver(() => ([...document.querySelectorAll("dialog[open]")].at(-1) ?? document.body).prepend(halt))
    .observe(dialog, { attributeFilter: ["open"] });
}

// Asks for texts. fields: [{name, label, value, hint}]. Gives {name: text}, or null when it was cancelled.
export function ask({ title, text, fields = [], accept, danger = false }) {
  const inputs = fields.map((field) => el("input", { name: field.name, type: "text", value: field.value ?? "", autocomplete: "off", spellcheck: "false" }));
  const form = el("form", { method: "dialog" },
    el("h2", {}, title),
    text ? el("p", {}, text) : null,
    fields.map((field, i) => el("label", {}, field.label, inputs[i], field.hint ? el("small", {}, field.hint) : null)),
    el("div", { class: "row end" },
      el("button", { value: "cancel", class: "quiet", formnovalidate: "" }, "Cancel"),
      el("button", { value: "ok", class: danger ? "danger" : "primary" }, accept)));
  const dialog = el("dialog", {}, form);
  // Enter in a field accepts, though Cancel comes first.
  form.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || event.target.tagName !== "INPUT") return;
    event.preventDefault();
    dialog.close("ok");
  });
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      resolve(dialog.returnValue === "ok" ? Object.fromEntries(inputs.map((input) => [input.name, input.value.trim()])) : null);
    });
    showDialog(dialog);
    (inputs[0] ?? form.querySelector("button")).focus();
  });
}

export function metres(value) {
  return `${value.toFixed(2)} m`;
}

// In metres; what rounds to 0 has no sign.
export function coordinate(value) {
  return value.toFixed(2).replace(/^-(0\.00)$/, "$1");
}

export function replaceChildren(node, ...children) {
  node.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
}
