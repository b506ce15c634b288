import { el, metres, toast } from "./dom.js";
import { Eye } from "./eye.js";
import { listen } from "./gestures.js";
import { loadPicture, showPicture } from "./pictures.js";
import { Surface } from "./surface.js";
import { loadThree } from "./three_loader.js";

// The model in 3D, loaded when it is first opened.
export function makeSpace(section, canvas, world, mapView) {
  const space = new Space(section, canvas, world, mapView);
  for (const what of ["pose", "snapshot"]) world.on(what, () => space.redraw());
  return space;
}

class Space {
  constructor(section, canvas, world, mapView) {
    Object.assign(this, { section, canvas, world, mapView });
    this.active = false;
    this.message = el("p", { class: "empty" });
    this.cut = el("input", { type: "range", min: "0", max: "100", value: "80", "aria-label": "Clip height" });
    this.cutText = el("output", {});
    this.walkButton = el("button", { type: "button", onclick: () => this.setWalking(!this.eye.walking) }, "Walk");
    this.photoButton = el("button", { type: "button", hidden: true, onclick: () => this.showPhotographs(!this.photographs?.visible) }, "Photographs");
    this.controls = el("div", { class: "controls chip", hidden: true }, this.walkButton, this.photoButton, el("label", { class: "slider" }, el("span", {}, "Cut at"), this.cut, this.cutText));
    section.append(this.message, this.controls);
    this.cut.addEventListener("input", () => { this.cutTouched = true; this.redraw(); });
  }

  get walking() {
    return this.active && (this.eye?.walking ?? false);
  }

  // Tiles of the model come once somebody looks at it; the server keeps them.
  listen(socket) {
    this.socket = socket;
  }

  takeTile(message) {
    const first = this.surface.empty;
    this.surface.takeTile(message);
    if (first && !this.surface.empty) this.fit();
    this.showState();
    this.redraw();
  }

  async activate(on) {
    this.active = on;
    if (!on) return;
    this.message.textContent = "Loading…";
    try {
      await loadThree();
      if (!this.renderer) this.begin();
      await this.loadModel();
      this.showState();
    } catch (fault) {
      this.message.textContent = fault.message;
    }
    this.resize();
    this.canvas.focus();
  }

  begin() {
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    } catch {
      throw new Error("This browser offers no WebGL here, which 3D needs: its settings or the graphics driver may forbid it.");
    }
    this.scene = new THREE.Scene();
    this.surface = new Surface();
    this.eye = new Eye();
    this.marks = new THREE.Group();
    this.robot = robotMark();
    this.scene.add(this.surface.group, this.marks, this.robot);
    listen(this.canvas, this);
    new ResizeObserver(() => this.resize()).observe(this.section);
    addEventListener("keydown", (event) => this.key(event, true));
    addEventListener("keyup", (event) => this.key(event, false));
    addEventListener("blur", () => this.eye.keys.clear());
    this.readColors();
    this.socket?.subscribe("MESH", (message) => this.takeTile(message));
  }

  async loadModel() {
    const model = this.world.snapshot?.model;
    if (!model || model === this.loaded) return;
    this.loaded = model;
    const answer = await fetch(model.startsWith("data:") ? model : `${model}${location.search}`);
    if (!answer.ok) throw new Error(`The model cannot be loaded (${answer.status})`);
    await this.surface.loadGlb(await answer.arrayBuffer());
    this.fit();
  }

  showState() {
    this.controls.hidden = this.surface.empty;
    this.photoButton.hidden = this.world.photographs.length === 0;
    this.message.hidden = !this.surface.empty;
    this.message.textContent = "There is no 3D model yet. It grows where a laser is tilted or panned.";
  }

  readColors() {
    if (!this.renderer) return;
    const color = getComputedStyle(document.documentElement).getPropertyValue("--accent").trim();
    this.robot.material.color.set(color);
    this.marks.children.forEach((mark) => mark.material.color.set(color));
    this.redraw();
  }

  resize() {
    if (!this.renderer || this.section.clientWidth === 0) return;
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(this.section.clientWidth, this.section.clientHeight, false);
    if (!this.touched && !this.surface.empty) this.fit();
    this.redraw();
  }

  fit() {
    this.touched = false;
    if (!this.renderer || this.surface.empty) return;
    this.eye.fit(this.surface.box(), Math.max(this.section.clientWidth, 1) / Math.max(this.section.clientHeight, 1));
    this.showWalking();
    this.redraw();
  }

  // The cut as a height: by itself below the ceiling, so that one looks into the rooms; the whole when walking.
  cutHeight() {
    const { floor_m, ceiling_m, has_ceiling } = this.surface;
    if (!this.cutTouched && (this.eye.walking || !has_ceiling)) return ceiling_m + 10;
    const part = Number(this.cut.value) / 100;
    return part >= 1 ? ceiling_m + 10 : floor_m + part * (ceiling_m - floor_m);
  }

  redraw() {
    if (!this.active || !this.renderer || this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      const moves = this.eye.step(this.steppedAt ? Math.min((now - this.steppedAt) / 1000, 0.1) : 0.016);
      this.steppedAt = moves ? now : 0;
      this.draw();
      if (moves) this.redraw();
    });
  }

  draw() {
    const { eye, surface, world } = this;
    eye.place(this.section.clientWidth, Math.max(this.section.clientHeight, 1));
    const cut = this.cutHeight();
    surface.shared.cut_m.value = cut;
    surface.shared.lamp.value.set(-0.5, 0.6, 0.6).normalize().transformDirection(eye.camera.matrixWorld);
    this.cutText.textContent = cut > surface.ceiling_m ? "whole" : `${(cut - surface.floor_m).toFixed(2)} m`;
    this.robot.visible = world.robot !== null && !surface.empty;
    if (world.robot) {
      this.robot.position.set(world.robot.x, world.robot.y, surface.floor_m + 0.15);
      this.robot.rotation.set(0, 0, world.robot.theta - Math.PI / 2);
    }
    this.renderer.render(this.scene, eye.camera);
    this.frames = (this.frames ?? 0) + 1;
    this.mapView.redraw();
  }

  // On the plan beside it: where the eye is and looks.
  drawEye(context, view, colors) {
    if (!this.active || !this.eye || this.surface.empty) return;
    const { x, y } = this.eye.camera.position, [px, py] = view.toScreen(x, y), turn = -(this.eye.yaw + view.angle);
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
    const { eye, surface, world } = this;
    if (on) {
      const from = world.robot ?? placeOnPath(world.path, eye.target) ?? { ...eye.target, theta: eye.yaw };
      eye.walkFrom(from.x, from.y, surface.floor_m);
      eye.yaw = from.theta;
      this.touched = true;
      toast("WASD or arrows walk, a drag looks around, a click on the floor goes there");
    } else {
      this.fit();
    }
    this.cutTouched = false;
    this.showWalking();
    this.canvas.focus();
    this.redraw();
  }

  showWalking() {
    this.walkButton.setAttribute("aria-pressed", String(this.eye.walking));
  }

  key(event, down) {
    if (!this.walking || event.target.closest?.("input[type=text], dialog") || event.ctrlKey || event.metaKey) return;
    if (!/^(Key[WASDQE]|Arrow)/.test(event.code)) return;
    event.preventDefault();
    if (down) this.eye.keys.add(event.code);
    else this.eye.keys.delete(event.code);
    this.redraw();
  }

  // Two clicks on the surface; `say` gets the distance. null ends it.
  measure(say) {
    this.say = say;
    this.points = [];
    this.marks?.remove(...this.marks.children);
    this.redraw();
  }

  ray(px, py) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera({ x: 2 * px / this.section.clientWidth - 1, y: 1 - 2 * py / this.section.clientHeight }, this.eye.camera);
    return caster;
  }

  click(px, py) {
    const caster = this.ray(px, py), picture = this.photographs?.visible ? caster.intersectObjects(this.photographs.children)[0] : null;
    const hit = caster.intersectObject(this.surface.group, true).find((one) => one.point.z <= this.cutHeight());
    if (this.say) this.addPoint(hit);
    else if (picture && (!hit || picture.distance <= hit.distance + 0.3)) showPicture(picture.object.userData.file);
    else if (hit && this.eye.walking && hit.point.z < this.surface.floor_m + 0.3) this.eye.walkFrom(hit.point.x, hit.point.y, this.surface.floor_m);
    this.redraw();
  }

  addPoint(hit) {
    if (!hit) return;
    if (this.points.length === 2) this.measure(this.say);
    this.points.push(hit.point);
    const material = () => new THREE.MeshBasicMaterial({ color: this.robot.material.color, depthTest: false });
    const dot = new THREE.Mesh(new THREE.SphereGeometry(0.04, 12, 8), material());
    dot.position.copy(hit.point);
    this.marks.add(dot);
    if (this.points.length < 2) return this.say("Click the other end");
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(this.points), new THREE.LineBasicMaterial({ color: this.robot.material.color, depthTest: false }));
    this.marks.add(line);
    this.say(metres(this.points[0].distanceTo(this.points[1])));
  }

  async showPhotographs(on) {
    if (!this.photographs) {
      this.photographs = new THREE.Group();
      this.scene.add(this.photographs);
      for (const photograph of this.world.photographs) this.addPhotograph(photograph);
    }
    this.photographs.visible = on;
    this.photoButton.setAttribute("aria-pressed", String(on));
    this.redraw();
  }

  // A small picture where the camera stood, turned as it looked.
  async addPhotograph({ file, x_m, y_m, z_m, theta_rad }) {
    const picture = await loadPicture(file).catch(() => null);
    if (picture === null) return;
    const texture = new THREE.Texture(picture), kWidthM = 0.5;
    texture.needsUpdate = true;
    texture.minFilter = THREE.LinearFilter;
    const plane = new THREE.Mesh(new THREE.PlaneGeometry(kWidthM, kWidthM * picture.height / picture.width), new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide }));
    plane.position.set(x_m, y_m, z_m ?? this.surface.floor_m + 1);
    plane.up.set(0, 0, 1);
    plane.lookAt(x_m - Math.cos(theta_rad), y_m - Math.sin(theta_rad), plane.position.z);
    plane.userData.file = file;
    this.photographs.add(plane);
    this.redraw();
  }

  // What gestures tell.
  pan(dx, dy) { this.touched = true; this.eye.turn(dx, dy); this.redraw(); }
  side(dx, dy) { this.touched = true; this.eye.shift(dx, dy, this.section.clientHeight); this.redraw(); }
  carry(dx, dy) { this.side(dx, dy); }
  change(px, py, factor) { this.touched = true; this.eye.zoom(factor); this.redraw(); }
  zoom(factor) { if (this.eye) this.change(0, 0, factor); }
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

function robotMark() {
  const cone = new THREE.ConeGeometry(0.18, 0.5, 4);  // points along y
  return new THREE.Mesh(cone, new THREE.MeshBasicMaterial());
}
