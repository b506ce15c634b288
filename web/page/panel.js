import { el, narrow } from "./dom.js";

// The panel: tabs at the side, on a phone a sheet from below that is drawn up and down.
export class Panel {
  // tabs: [{key, label, content}]
  constructor(root, tabs, changed) {
    this.root = root;
    this.changed = changed;
    this.tabs = tabs;
    this.handle = el("button", { class: "handle", type: "button", "aria-label": "Open or close the panel", onclick: () => this.toggle() });
    this.buttons = tabs.map((tab) => el("button", { type: "button", role: "tab", id: `tab-${tab.key}`, "aria-controls": `panel-${tab.key}`, onclick: () => this.press(tab.key) }, tab.label, el("span", { class: "mark" })));
    this.bodies = tabs.map((tab) => el("section", { role: "tabpanel", tabindex: "0", id: `panel-${tab.key}`, "aria-labelledby": `tab-${tab.key}` }, tab.content));
    root.append(this.handle, el("div", { role: "tablist", class: tabs.length < 2 ? "single" : null }, this.buttons), el("div", { class: "bodies" }, this.bodies));
    this.handle.addEventListener("pointerdown", (event) => this.pull(event));
    this.open = !narrow.matches;
    this.select(tabs[0].key);
  }

  press(key) {
    if (key === this.selected) this.toggle();
    else this.reveal(key);
  }

  reveal(key) {
    this.open = true;
    this.select(key);
  }

  toggle() {
    if (this.pulled) return;
    this.open = !this.open;
    this.show();
  }

  select(key) {
    this.selected = key;
    this.show();
  }

  show() {
    this.tabs.forEach((tab, i) => {
      this.buttons[i].setAttribute("aria-selected", String(tab.key === this.selected));
      this.bodies[i].hidden = tab.key !== this.selected;
    });
    this.root.classList.toggle("closed", !this.open);
    this.handle.setAttribute("aria-expanded", String(this.open));
    this.changed();
  }

  // A sheet follows the finger up or down.
  pull(event) {
    this.pulled = false;
    const start = event.clientY;
    this.handle.setPointerCapture(event.pointerId);
    this.handle.onpointermove = (move) => {
      const way = move.clientY - start;
      if (Math.abs(way) < 24 || this.open === way < 0) return;
      this.open = way < 0;
      this.show();
      this.pulled = true;
    };
    this.handle.onpointerup = this.handle.onpointercancel = () => {
      this.handle.onpointermove = null;
      setTimeout(() => { this.pulled = false; });
    };
  }

  // "warning", "error" or "" next to a tab's name.
  mark(key, state) {
    const i = this.tabs.findIndex((tab) => tab.key === key);
    if (i >= 0) this.buttons[i].dataset.mark = state;
  }
}
