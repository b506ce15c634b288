// What is drawn on the floor plan. Each layer draws in metres, or on the screen by view.toScreen, in the colours of the theme.

// Layers in the order they are drawn, with the shape of their colour in the legend; `has` says whether there is anything to switch on.
export const kLayers = [
  { key: "tiles", label: "Floor plan", color: "--occupied", on: true, has: () => true },
  { key: "walls", swatch: "line", label: "Walls (lines)", color: "--walls", on: true, has: (world) => world.walls.length > 0 },
  { key: "odometry", swatch: "line", label: "Odometry", color: "--odometry", on: false, has: (world) => world.odometry.length > 1 },
  { key: "truth", swatch: "line", label: "True path", color: "--truth", on: false, has: (world) => world.truth.length > 1 },
  { key: "livePath", swatch: "line", label: "Path as first published", color: "--live-path", on: false, has: (world) => world.livePath.length > 1 },
  { key: "path", swatch: "line", label: "Path", color: "--path", on: true, has: (world) => world.path.length > 1 || world.trail.length > 1 },
  { key: "loops", swatch: "line", label: "Loop closures", color: "--loop", on: false, has: (world) => world.loops.length > 0 },
  { key: "scan", label: "Scan", color: "--scan", on: true, has: (world) => world.scan !== null },
  { key: "photographs", label: "Photographs", color: "--photograph", on: true, has: (world) => world.photographs.length > 0 },
  { key: "covariance", swatch: "round", label: "Uncertainty", color: "--robot", on: true, has: (world) => world.robot !== null },
];

const polylines = new WeakMap();  // array of points -> Path2D: built once, since paths are replaced and not changed

function polyline(points) {
  let path = polylines.get(points);
  if (path === undefined) {
    path = new Path2D();
    points.forEach(([x, y], i) => (i === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
    polylines.set(points, path);
  }
  return path;
}

function stroke(context, view, path, color, width_px, dash_px = []) {
  context.strokeStyle = color;
  context.lineWidth = width_px / view.scale;
  context.setLineDash(dash_px.map((length) => length / view.scale));
  context.lineJoin = context.lineCap = "round";
  context.stroke(path);
  context.setLineDash([]);
}

function segments(list) {
  const path = new Path2D();
  for (const [x0, y0, x1, y1] of list) {
    path.moveTo(x0, y0);
    path.lineTo(x1, y1);
  }
  return path;
}

export const kDraw = {
  tiles: (context, view, world, colors, tiles) => tiles.draw(context, view),
  walls: (context, view, world, colors) => stroke(context, view, segments(world.walls), colors["--walls"], 3),
  odometry: (context, view, world, colors) => stroke(context, view, polyline(world.odometry), colors["--odometry"], 1.5, [5, 4]),
  truth: (context, view, world, colors) => stroke(context, view, polyline(world.truth), colors["--truth"], 1.5, [2, 4]),
  livePath: (context, view, world, colors) => stroke(context, view, polyline(world.livePath), colors["--live-path"], 1.5),
  path(context, view, world, colors) {
    stroke(context, view, polyline(world.path), colors["--path"], 2);
    const trail = world.trail.map((step) => [step.x, step.y]);
    if (world.path.length > 0 && trail.length > 0) trail.unshift(world.path[world.path.length - 1]);
    stroke(context, view, polyline(trail), colors["--path"], 2);
  },
  loops(context, view, world, colors) {
    stroke(context, view, segments(world.loops.filter((loop) => loop[4] !== "refused")), colors["--loop"], 1.5);
    stroke(context, view, segments(world.loops.filter((loop) => loop[4] === "refused")), colors["--refused"], 1.5, [5, 4]);
  },
  scan(context, view, world, colors) {
    const { x_m, y_m } = world.scan, size = Math.max(2.5 / view.scale, 0.02);
    context.fillStyle = colors["--scan"];
    context.beginPath();
    for (let i = 0; i < x_m.length; ++i) context.rect(x_m[i] - size / 2, y_m[i] - size / 2, size, size);
    context.fill();
  },
  photographs(context, view, world, colors) {
    context.fillStyle = colors["--photograph"];
    for (const { x_m, y_m, theta_rad } of world.photographs) {
      const r = 15 / view.scale;
      context.globalAlpha = 0.35;
      context.beginPath();
      context.moveTo(x_m, y_m);
      context.arc(x_m, y_m, r, theta_rad - 0.5, theta_rad + 0.5);
      context.fill();
      context.globalAlpha = 1;
      context.beginPath();
      context.arc(x_m, y_m, 4 / view.scale, 0, 7);
      context.fill();
    }
  },
  covariance(context, view, world, colors) {
    const c = world.robot.covariance;
    if (!c) return;
    const middle = (c[0][0] + c[1][1]) / 2, off = Math.hypot((c[0][0] - c[1][1]) / 2, c[0][1]);
    const axis = (variance) => 2 * Math.sqrt(Math.max(variance, 0));  // two standard deviations
    context.save();
    context.translate(world.robot.x, world.robot.y);
    context.rotate(Math.atan2(2 * c[0][1], c[0][0] - c[1][1]) / 2);
    context.beginPath();
    context.ellipse(0, 0, Math.max(axis(middle + off), 1e-4), Math.max(axis(middle - off), 1e-4), 0, 0, 7);
    context.fillStyle = colors["--robot"];
    context.globalAlpha = 0.15;
    context.fill();
    context.globalAlpha = 0.8;
    context.lineWidth = 1 / view.scale;
    context.strokeStyle = colors["--robot"];
    context.stroke();
    context.restore();
  },
};

// Always on top, whatever is shown. On the screen: toScreen(x, y) of a place there, where a metre is `scale` pixels.
export function drawRobot(context, { x, y, theta }, scale, toScreen, color, outline) {
  const size = Math.max(0.22, 11 / scale), c = size * Math.cos(theta), s = size * Math.sin(theta);  // [m], at least to be found
  context.beginPath();
  for (const [ahead, left] of [[1.25, 0], [-0.75, 0.8], [-0.4, 0], [-0.75, -0.8]]) context.lineTo(...toScreen(x + c * ahead - s * left, y + s * ahead + c * left));
  context.closePath();
  context.fillStyle = color;
  context.lineWidth = 2.5;
  context.lineJoin = "round";
  context.strokeStyle = outline;
  context.stroke();
  context.fill();
}

export function drawGoal(context, view, goal, colors) {
  const r = 9 / view.scale;
  context.lineWidth = 2.5 / view.scale;
  context.strokeStyle = { refused: colors["--wrong"], shortened: colors["--doubtful"] }[goal.fate] ?? colors["--robot"];
  context.beginPath();
  context.arc(goal.x, goal.y, r, 0, 7);
  context.moveTo(goal.x - 1.6 * r, goal.y);
  context.lineTo(goal.x + 1.6 * r, goal.y);
  context.moveTo(goal.x, goal.y - 1.6 * r);
  context.lineTo(goal.x, goal.y + 1.6 * r);
  context.stroke();
}

// Numbers of the doctor's places, as in the list next to the map.
export function drawPlaces(context, view, places, colors) {
  context.font = "600 13px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const { x, y, number, word } of places) {
    const [px, py] = view.toScreen(x, y);
    context.beginPath();
    context.arc(px, py, 12, 0, 7);
    context.fillStyle = colors[word === "wrong" ? "--wrong" : "--doubtful"];
    context.fill();
    context.fillStyle = colors["--on-accent"];
    context.fillText(String(number), px, py + 1);
  }
}
