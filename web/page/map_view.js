import { drawSoon } from "./frames.js";
import { listen } from "./gestures.js";
import { View } from "./view.js";
import { kDraw, kLayers, drawGoal, drawPlaces, drawRobot } from "./layers.js";

const kColors = ["--surface", "--free", "--occupied", "--walls", "--odometry", "--truth", "--live-path", "--path", "--loop", "--refused", "--scan",
  "--photograph", "--robot", "--late", "--wrong", "--doubtful", "--on-accent", "--text", "--accent"];

// The floor plan on its canvas. It draws when something changed, at most once a frame.
export class MapView {
  // room(): {left, right, top, bottom} [px] that panels cover.
  constructor(canvas, world, tiles, room) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.world = world;
    this.tiles = tiles;
    this.room = room;
    this.view = new View();
    this.shown = new Map(kLayers.map((layer) => [layer.key, layer.on]));
    this.follow = false;
    this.touched = false;    // by the user: it is then not fitted by itself
    this.tool = null;        // {click(x, y), drag(what, x, y), hover(x, y), draw(context, view, colors)}
    this.overlays = [];      // functions (context, view, colors), on the screen
    this.onHover = () => {};
    this.onView = () => {};
    this.isLate = () => false;  // whether the robot is to be seen as one of the past
    this.frame = () => {
      if (canvas.clientWidth === 0) return;  // when only the 3D view is shown
      if (!this.touched && !this.follow && this.tool === null) this.fit();  // a click goes where the user aimed
      this.draw();
    };
    listen(canvas, this);
    for (const what of ["pose", "path", "scan", "walls", "goal", "snapshot"]) world.on(what, () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.readColors();
  }

  readColors() {
    const style = getComputedStyle(document.documentElement);
    this.colors = Object.fromEntries(kColors.map((name) => [name, style.getPropertyValue(name).trim()]));
    const rgb = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));
    this.tiles.setColors(rgb(this.colors["--free"]), rgb(this.colors["--occupied"]));
    this.redraw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas, ratio = window.devicePixelRatio || 1;
    if (width === 0) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const first = this.view.width === 1;
    this.view.width = width;
    this.view.height = height;
    if (first || !this.touched) this.fit();
    this.draw();
  }

  redraw() {
    drawSoon(this.frame);
  }

  fit() {
    const { robot, path } = this.world;
    let box = this.tiles.bounds();
    if (box === null && robot) box = [robot.x - 5, robot.y - 5, robot.x + 5, robot.y + 5];
    if (box === null && path.length > 0) box = [-5, -5, 5, 5];
    if (box !== null) this.view.fit(box, this.room());
  }

  fitByUser() {
    this.touched = false;
    this.setFollow(false);
    this.fit();
    this.redraw();
  }

  setFollow(on) {
    this.follow = on;
    this.onView();
    this.redraw();
  }

  lookAt(x, y, scale) {
    this.touched = true;
    this.setFollow(false);
    Object.assign(this.view, { x, y, scale: Math.max(this.view.scale, scale) });
    this.centre();
    this.redraw();
  }

  // The middle of what panels leave free.
  centre() {
    const { left, right, top, bottom } = this.room();
    this.view.panBy((left - right) / 2, (top - bottom) / 2);
  }

  draw() {
    const { context, view, world, colors } = this, ratio = window.devicePixelRatio || 1;
    if (this.follow && world.robot) {
      Object.assign(view, { x: world.robot.x, y: world.robot.y });
      this.centre();
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    view.apply(context, ratio);
    for (const layer of kLayers) {
      if (this.shown.get(layer.key) && layer.has(world)) kDraw[layer.key](context, view, world, colors, this.tiles);
    }
    if (world.goal) drawGoal(context, view, world.goal, colors);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (world.robot) drawRobot(context, world.robot, view.scale, (x, y) => view.toScreen(x, y), this.robotColor(), colors["--surface"]);
    drawPlaces(context, view, world.places, colors);
    for (const overlay of this.overlays) overlay(context, view, colors);
    this.tool?.draw?.(context, view, colors);
    this.onView();
  }

  robotColor() {
    return this.colors[this.isLate() ? "--late" : this.world.robot.status === 2 ? "--wrong" : "--robot"];
  }

  // What gestures tell.
  pan(dx, dy) {
    this.touched = true;
    if (this.follow && Math.hypot(dx, dy) > 0) this.setFollow(false);
    this.view.panBy(dx, dy);
    this.redraw();
  }

  side(dx) {
    this.change(this.view.width / 2, this.view.height / 2, 1, dx / 200);
  }

  carry(dx, dy) {
    this.pan(dx, dy);
  }

  change(px, py, factor, turn) {
    this.touched = true;
    if (this.follow) [px, py] = [this.view.width / 2, this.view.height / 2];
    this.view.changeAt(px, py, factor, turn);
    this.redraw();
  }

  zoom(factor) {
    this.change(this.view.width / 2, this.view.height / 2, factor, 0);
  }

  turnNorth() {
    this.change(this.view.width / 2, this.view.height / 2, 1, -this.view.angle);
  }

  click(px, py) {
    const at = this.view.toWorld(px, py);
    if (this.tool) this.tool.click?.(...at);
    else this.onClick?.(...at, px, py);
    this.redraw();
  }

  wantsDrag() {
    return this.tool?.drag !== undefined;
  }

  drag(what, px, py) {
    this.tool?.drag?.(what, ...this.view.toWorld(px, py));
    this.redraw();
  }

  hover(px, py) {
    const at = px === null ? null : this.view.toWorld(px, py);
    this.onHover(at);
    if (at && this.tool?.hover) {
      this.tool.hover(...at);
      this.redraw();
    }
  }

  setTool(tool) {
    this.tool?.end?.();
    this.tool = tool;
    this.canvas.style.cursor = tool ? "crosshair" : "";
    this.redraw();
  }
}
