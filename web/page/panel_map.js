import { el, replaceChildren } from "./dom.js";
import { kLayers } from "./layers.js";

const kWords = { good: "The map is good", doubtful: "The map is doubtful", wrong: "The map is wrong" };

// The doctor's verdict with its places, a few figures, and the layers, which are the legend as well.
export function makeMapPanel(world, mapView) {
  const verdict = el("div", {}), figures = el("dl", { class: "figures" }), layers = el("div", { class: "layers" });
  const boxes = new Map(kLayers.map((layer) => [layer.key, layerRow(layer, mapView)]));
  layers.append(...boxes.values());

  function showLayers() {
    for (const layer of kLayers) boxes.get(layer.key).hidden = !layer.has(world);
  }
  function showSnapshot() {
    showVerdict(verdict, world.snapshot, mapView);
    showFigures(figures, world.snapshot);
    showLayers();
  }
  let had = "";  // which layers there are changes seldom
  for (const what of ["pose", "path", "scan", "walls"]) {
    world.on(what, () => {
      const has = kLayers.map((layer) => Number(layer.has(world))).join("");
      if (has !== had) showLayers();
      had = has;
    });
  }
  world.on("snapshot", showSnapshot);
  showLayers();
  return el("div", {}, verdict, figures, el("h2", {}, "Layers"), layers);
}

function layerRow(layer, mapView) {
  const box = el("input", { type: "checkbox", checked: mapView.shown.get(layer.key) });
  box.addEventListener("change", () => {
    mapView.shown.set(layer.key, box.checked);
    mapView.redraw();
  });
  const swatch = el("span", { class: `swatch ${layer.swatch ?? ""}` });
  swatch.style.background = `var(${layer.color})`;
  return el("label", { class: "layer" }, box, swatch, el("span", {}, layer.label));
}

function showVerdict(root, snapshot, mapView) {
  const found = snapshot?.verdict;
  if (!found) return replaceChildren(root);
  const reasons = found.reasons.map((reason, i) => {
    const place = Number.isFinite(reason.x_m);
    const look = place ? el("button", { type: "button", class: "quiet", onclick: () => mapView.lookAt(reason.x_m, reason.y_m, 60) }, "Show on the map") : null;
    return el("li", { class: reason.word ?? "" },
      el("span", { class: "number" }, String(i + 1)),
      el("div", {}, el("p", {}, reason.text),
        reason.remedy ? el("p", { class: "remedy" }, "Suggested fixes, the likeliest first; put the lines in a file for --edits:", el("code", {}, reason.remedy)) : null, look));
  });
  replaceChildren(root, el("p", { class: `verdict ${found.word}` }, kWords[found.word] ?? found.word), reasons.length > 0 ? el("ol", { class: "reasons" }, reasons) : null);
}

function showFigures(root, snapshot) {
  const report = snapshot?.report ?? {}, rows = [];
  if (report.inputs) rows.push(["Recording", report.inputs.join(", ")]);
  if (report.distance_m !== undefined) rows.push(["Driven", `${report.distance_m.toFixed(1)} m in ${time(report.recorded_s)}`]);
  if (report.posed !== undefined) rows.push(["Scans", `${report.matched} of ${report.posed} matched`]);
  if (report.keyframes !== undefined) rows.push(["Keyframes", String(report.keyframes)]);
  const loops = snapshot?.loops ?? [];
  if (loops.length > 0) {
    const refused = loops.filter((loop) => loop[4] === "refused").length;
    rows.push(["Loop closures", refused > 0 ? `${loops.length - refused}, ${refused} refused` : String(loops.length)]);
  }
  for (const [name, value] of Object.entries(report.errors ?? {})) {
    const text = name.match(/^(path error rms|map error rms|model error rms)_m$/);
    if (text) rows.push([text[1].replace(" rms", " (rms)").replace(/^./, (first) => first.toUpperCase()), `${(value * 100).toFixed(1)} cm`]);
  }
  replaceChildren(root, rows.map(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]));
}

function time(seconds) {
  const minutes = Math.floor(seconds / 60);
  return minutes > 0 ? `${minutes} min ${Math.round(seconds % 60)} s` : `${Math.round(seconds)} s`;
}
