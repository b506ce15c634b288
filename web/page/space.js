import { el, metres, toast } from "./dom.js";
import { drawSoon } from "./frames.js";
import { listen } from "./gestures.js";
import { drawRobot } from "./layers.js";
import { loadPicture, showPicture } from "./pictures.js";
import { beginScene } from "./space_host.js";

// The model in 3D next to the plan or instead of it, loaded when it is first opened: its buttons, and what goes to the scene and back.
export function makeSpace(section, canvas, world, mapView) {
  const space = new Space(section, canvas, world, mapView);
  world.on("pose", () => space.markSoon());
  return space;
}

class Space {
  constructor(section, canvas, world, mapView) {
    Object.assign(this, { section, canvas, world, mapView });
    this.active = this.walking = false;
    this.ask = () => {};  // until it has begun
    this.onMarked = () => {};
    this.message = el("p", { class: "empty" });
    this.cut = el("input", { type: "range", min: "0", max: "100", value: "80", "aria-label": "Clip height" });
    this.cutText = el("output", {});
    this.walkButton = el("button", { type: "button", onclick: () => this.setWalking(!this.walking) }, "Walk");
    this.photoButton = el("button", { type: "button", hidden: true, onclick: () => this.showPhotographs(!this.showsPhotographs) }, "Photographs");
    this.controls = el("div", { class: "controls chip", hidden: true }, this.walkButton, this.photoButton, el("label", { class: "slider" }, el("span", {}, "Cut at"), this.cut, this.cutText));
    this.marks = el("canvas", { class: "marks", "aria-hidden": "true" });
    section.append(this.marks, this.message, this.controls);
    this.cut.addEventListener("input", () => this.ask("setCut", Number(this.cut.value) / 100));
    this.mark = () => this.markRobot();
  }

  // Tiles of the model come once somebody looks at it; the server keeps them.
  listen(socket) {
    this.socket = socket;
  }

  async activate(on) {
    this.active = on;
    if (!on) return this.ask("activate", false);
    this.canvas.focus();  // now: who has gone on to another place by the end of this stays there
    this.message.textContent = "Loading…";
    try {
      await (this.beginning ??= this.begin());
      this.ask("activate", this.active);
      await this.loadModel();
      this.message.textContent = "There is no 3D model yet. It grows while a laser is tilted or panned.";
    } catch (fault) {
      this.message.textContent = fault.message;
    }
    this.resize();
  }

  async begin() {
    this.ask = await beginScene(this.canvas, {
      drawn: (view) => this.drawn(view),
      measured: (length_m) => this.say?.(length_m === null ? "Click the end point" : metres(length_m)),
      picked: showPicture,
      failed: (text) => { this.message.textContent = text; },
    });
    listen(this.canvas, this);
    new ResizeObserver(() => this.resize()).observe(this.section);
    addEventListener("keydown", (event) => this.key(event, true));
    addEventListener("keyup", (event) => this.key(event, false));
    addEventListener("blur", () => this.ask("letKeysGo"));
    this.readColors();
    if (this.say) this.ask("measure", true);
    this.socket?.subscribe("MESH", (bytes, from) => this.ask("takeTile", bytes, from), "raw");
  }

  async loadModel() {
    const model = this.world.snapshot?.model;
    if (!model || model === this.loaded) return;
    this.loaded = model;
    const answer = await fetch(model.startsWith("data:") ? model : `${model}${location.search}`);
    if (!answer.ok) throw new Error(`The model cannot be loaded (${answer.status})`);
    await this.ask("loadGlb", await answer.arrayBuffer());
  }

  markSoon() {
    if (this.active && this.view) drawSoon(this.mark);
  }

  // The robot lies over the picture, which may be slow to draw, and is seen through walls.
  markRobot() {
    const { marks, view: { isEmpty, floor_m, screen_from_world: m, focal }, world: { robot } } = this, context = marks.getContext("2d");
    const { width, height } = marks, along = (row, x, y) => m[row] * x + m[row + 4] * y + m[row + 8] * floor_m + m[row + 12];
    const toScreen = (x, y) => [width / 2 * (1 + along(0, x, y) / along(3, x, y)), height / 2 * (1 - along(1, x, y) / along(3, x, y))];
    context.clearRect(0, 0, width, height);
    this.onMarked();
    const kNearestM = 0.5, far = robot && !isEmpty ? along(3, robot.x, robot.y) : 0;
    if (far > kNearestM) drawRobot(context, robot, focal * height / 2 / far, toScreen, this.mapView.robotColor(), this.mapView.colors["--surface"]);
  }

  drawn(view) {
    this.view = view;
    this.cutText.textContent = view.cut;
    this.controls.hidden = view.isEmpty;
    this.photoButton.hidden = this.world.photographs.length === 0;
    this.message.hidden = !view.isEmpty;
    this.markSoon();
    this.mapView.redraw();
  }

  readColors() {
    this.ask("setColor", this.mapView.colors["--accent"]);
  }

  resize() {
    const { clientWidth, clientHeight } = this.section;
    if (clientWidth === 0) return;
    Object.assign(this.marks, { width: clientWidth, height: clientHeight });
    this.ask("resize", clientWidth, Math.max(clientHeight, 1), window.devicePixelRatio || 1);
  }

  fit() {
    this.showWalking(false);
    this.ask("fit");
  }

  zoom(factor) {
    this.ask("zoom", factor);
  }

  // On the plan next to it: where the eye is and looks.
  drawEye(context, view, colors) {
    if (!this.active || !this.view || this.view.isEmpty) return;
    const { x, y, yaw } = this.view.eye, [px, py] = view.toScreen(x, y), turn = -(yaw + view.angle);
    context.fillStyle = colors["--photograph"];
    context.globalAlpha = 0.25;
    context.beginPath();
    context.moveTo(px, py);
    context.arc(px, py, 60, turn - 0.5, turn + 0.5);
    context.fill();
    context.globalAlpha = 1;
    context.beginPath();
    context.arc(px, py, 6, 0, 7);
    context.fill();
  }

  setWalking(on) {
    const { world, view: { eye, target } } = this;
    if (on) {
      this.ask("walkFrom", world.robot ?? placeOnPath(world.path, target) ?? { ...target, theta: eye.yaw });
      this.showWalking(true);
      toast("WASD or arrows walk, a drag looks around, a click on the floor moves there");
    } else {
      this.cut.value = "80";
      this.ask("setCut", null);
      this.fit();
    }
    this.canvas.focus();
  }

  showWalking(on) {
    this.walking = on;
    this.walkButton.setAttribute("aria-pressed", String(on));
  }

  key(event, down) {
    if (!this.active || !this.walking || event.target.closest?.("input[type=text], dialog") || event.ctrlKey || event.metaKey) return;
    if (!/^(Key[WASDQE]|Arrow)/.test(event.code)) return;
    event.preventDefault();
    this.ask("key", event.code, down);
  }

  // Two clicks on the surface; `say` gets the distance. null ends it.
  measure(say) {
    this.say = say;
    this.ask("measure", say !== null);
  }

  async showPhotographs(on) {
    this.showsPhotographs = on;
    this.photoButton.setAttribute("aria-pressed", String(on));
    this.ask("showPhotographs", on);
    if (this.hasPhotographs) return;
    this.hasPhotographs = true;
    for (const photograph of this.world.photographs) this.addPhotograph(photograph);
  }

  async addPhotograph(photograph) {
    const picture = await loadPicture(photograph.file).catch(() => null);
    if (picture) this.ask("addPhotograph", await createImageBitmap(picture, { imageOrientation: "flipY" }), photograph);
  }

  // What gestures tell.
  pan(dx, dy) { this.ask("pan", dx, dy); }
  side(dx, dy) { this.ask("side", dx, dy); }
  carry(dx, dy) { this.ask("side", dx, dy); }
  change(px, py, factor) { this.ask("zoom", factor); }
  click(px, py) { this.ask("click", px, py); }
  hover() {}
  wantsDrag() { return false; }
}

// Where the robot once was, nearest to a point, and where it drove then.
function placeOnPath(path, { x, y }) {
  if (path.length < 2) return null;
  let best = 0;
  const far = ([px, py]) => Math.hypot(px - x, py - y);
  path.forEach((place, i) => { if (far(place) < far(path[best])) best = i; });
  const later = path[Math.min(best + 8, path.length - 1)], earlier = path[Math.max(best - 8, 0)];
  return { x: path[best][0], y: path[best][1], theta: Math.atan2(later[1] - earlier[1], later[0] - earlier[0]) };
}
