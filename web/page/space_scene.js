import { Eye } from "./eye.js";
import { Surface } from "./surface.js";

const kSliceMs = 6, kShowMs = 500;  // of what is read
const text = new TextDecoder();

// The model in 3D and who looks at it, without a document. Without a graphics card a frame takes long, and nothing that a person
// presses may wait for it: so it draws in a worker (space_worker.js), in the page only where there is none.
// told: drawn({isEmpty, eye, target, floor_m, screen_from_world, focal, cut}), measured(metres; null after the first end), picked(file)
export class SpaceScene {
  constructor(canvas, told) {
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    } catch {
      throw new Error("3D needs WebGL, which this browser does not offer: its settings or the graphics driver may disable it.");
    }
    this.told = told;
    this.surface = new Surface();
    this.eye = new Eye();
    this.marks = new THREE.Group();
    this.photographs = new THREE.Group();
    this.tiles = new Map();  // of MESH, undecoded: number -> bytes
    this.points = null;      // that are measured
    this.shownAt = -Infinity;
    this.scene = new THREE.Scene();
    this.scene.add(this.surface.group, this.marks, this.photographs);
    [this.width, this.height] = [1, 1];
  }

  // Whether somebody looks.
  activate(on) {
    this.active = on;
    this.redraw();
  }

  setColor(color) {
    this.color = color;
    this.marks.children.forEach((mark) => mark.material.color.set(color));
    this.redraw();
  }

  resize(width, height, ratio) {
    [this.width, this.height] = [width, height];
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    if (!this.touched) this.fit();
    this.redraw();
  }

  async loadGlb(buffer) {
    await this.surface.loadGlb(buffer);
    this.fit();
  }

  // A message of MESH, its text from a byte on. Of each tile the newest is read, a few at a time.
  takeTile(buffer, from) {
    const number = /"tile":(\d+)/.exec(text.decode(new Uint8Array(buffer, from, Math.min(200, buffer.byteLength - from))))?.[1];
    this.tiles.set(number, new Uint8Array(buffer, from));
    if (this.tiles.size === 1) setTimeout(() => this.readTiles());
  }

  readTiles() {
    const end = performance.now() + kSliceMs, { surface } = this;
    for (const [number, bytes] of this.tiles) {
      this.tiles.delete(number);
      surface.takeTile(JSON.parse(text.decode(bytes)));
      if (performance.now() > end) break;
    }
    if (this.tiles.size > 0) setTimeout(() => this.readTiles(), kSliceMs);
    if (this.tiles.size > 0 && performance.now() - this.shownAt < kShowMs) return;
    surface.survey();
    if (!this.touched) this.fit();
    this.redraw();
  }

  fit() {
    this.touched = false;
    if (!this.surface.isEmpty) this.eye.fit(this.surface.box(), this.width / this.height);
    this.redraw();
  }

  // Of the height, 0..1; null: by itself.
  setCut(part) {
    this.cut = part;
    this.redraw();
  }

  // The cut as a height: by itself below the ceiling, so that one looks into the rooms; the whole when walking.
  cutHeight() {
    const { floor_m, ceiling_m, has_ceiling } = this.surface, kByItself = 0.8;
    const part = this.cut ?? (this.eye.walking || !has_ceiling ? 1 : kByItself);
    return part >= 1 ? ceiling_m + 10 : floor_m + part * (ceiling_m - floor_m);
  }

  redraw() {
    if (!this.active || this.waiting) return;
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
    const { eye, surface } = this, { camera } = eye, cut = this.cutHeight();
    eye.place(this.width, this.height);
    surface.shared.cut_m.value = cut;
    surface.shared.lamp.value.set(-0.5, 0.6, 0.6).normalize().transformDirection(camera.matrixWorld);
    this.renderer.render(this.scene, camera);
    const { x, y } = camera.position, screen_from_world = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements;
    const drawn = { isEmpty: surface.isEmpty, eye: { x, y, yaw: eye.yaw }, target: { x: eye.target.x, y: eye.target.y }, floor_m: surface.floor_m, screen_from_world, focal: camera.projectionMatrix.elements[5],
      cut: cut > surface.ceiling_m ? "whole" : `${(cut - surface.floor_m).toFixed(2)} m` };
    setTimeout(() => {  // when it is seen: behind the browser's part of the frame
      this.shownAt = performance.now();
      this.told.drawn(drawn);
    });
  }

  walkFrom({ x, y, theta }) {
    this.eye.walkFrom(x, y, this.surface.floor_m);
    this.eye.yaw = theta;
    this.touched = true;
    this.setCut(null);
  }

  // While walking.
  key(code, isDown) {
    if (isDown) this.eye.keys.add(code);
    else this.eye.keys.delete(code);
    this.redraw();
  }

  letKeysGo() {
    this.eye.keys.clear();
  }

  // Two clicks on the surface.
  measure(on) {
    this.points = on ? [] : null;
    this.marks.remove(...this.marks.children);
    this.redraw();
  }

  click(px, py) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera({ x: 2 * px / this.width - 1, y: 1 - 2 * py / this.height }, this.eye.camera);
    const picture = this.photographs.visible ? caster.intersectObjects(this.photographs.children)[0] : null;
    const hit = caster.intersectObject(this.surface.group, true).find((one) => one.point.z <= this.cutHeight());
    if (this.points) this.addPoint(hit);
    else if (picture && (!hit || picture.distance <= hit.distance + 0.3)) this.told.picked(picture.object.userData.file);
    else if (hit && this.eye.walking && hit.point.z < this.surface.floor_m + 0.3) this.eye.walkFrom(hit.point.x, hit.point.y, this.surface.floor_m);
    this.redraw();
  }

  addPoint(hit) {
    if (!hit) return;
    if (this.points.length === 2) this.measure(true);
    this.points.push(hit.point);
    const look = { color: this.color, depthTest: false };
    const dot = new THREE.Mesh(new THREE.SphereGeometry(0.04, 12, 8), new THREE.MeshBasicMaterial(look));
    dot.position.copy(hit.point);
    this.marks.add(dot);
    if (this.points.length < 2) return this.told.measured(null);
    this.marks.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(this.points), new THREE.LineBasicMaterial(look)));
    this.told.measured(this.points[0].distanceTo(this.points[1]));
  }

  showPhotographs(on) {
    this.photographs.visible = on;
    this.redraw();
  }

  // A small picture where the camera stood, turned as it looked. bitmap: its last row first
  addPhotograph(bitmap, { file, x_m, y_m, z_m, theta_rad }) {
    const texture = new THREE.Texture(bitmap), kWidthM = 0.5;
    texture.needsUpdate = true;
    texture.minFilter = THREE.LinearFilter;
    const plane = new THREE.Mesh(new THREE.PlaneGeometry(kWidthM, kWidthM * bitmap.height / bitmap.width), new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide }));
    plane.position.set(x_m, y_m, z_m ?? this.surface.floor_m + 1);
    plane.up.set(0, 0, 1);
    plane.lookAt(x_m - Math.cos(theta_rad), y_m - Math.sin(theta_rad), plane.position.z);
    plane.userData.file = file;
    this.photographs.add(plane);
    this.redraw();
  }

  // What gestures tell.
  pan(dx, dy) { this.touched = true; this.eye.turn(dx, dy); this.redraw(); }
  side(dx, dy) { this.touched = true; this.eye.shift(dx, dy, this.height); this.redraw(); }
  zoom(factor) { this.touched = true; this.eye.zoom(factor); this.redraw(); }
}
