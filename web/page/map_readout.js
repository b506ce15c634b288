import { coordinate, el } from "./dom.js";

// Scale bar, coordinates under the pointer, and what the tool at hand says.
export function makeReadout(root, mapView) {
  const bar = el("div", { class: "scale-bar" }), length = el("span", { class: "scale-text" });
  const place = el("span", { class: "place", "aria-label": "Coordinates under the pointer" });
  const said = el("output", { class: "said", hidden: true });
  root.append(said, el("div", { class: "chip" }, el("div", { class: "scale" }, length, bar), place));
  mapView.onHover = (at) => {
    place.textContent = at === null ? "" : `x ${coordinate(at[0])}  y ${coordinate(at[1])} m`;
  };
  let shown = 0;
  const update = () => {
    const scale = mapView.view.scale;
    if (scale === shown) return;
    shown = scale;
    const most = 120 / scale, power = 10 ** Math.floor(Math.log10(most));
    const step = [5, 2, 1].find((factor) => factor * power <= most) * power;
    bar.style.width = `${step * scale}px`;
    length.textContent = step >= 1 ? `${step} m` : `${Math.round(step * 100)} cm`;
  };
  return {
    update,
    say(text) {
      said.textContent = text;
      said.hidden = text === "";
    },
  };
}
