// Where the floor plan is looked at: its centre [m], pixels a metre, and how far it is turned [rad].
export class View {
  constructor() {
    this.x = 0;
    this.y = 0;
    this.scale = 40;
    this.angle = 0;
    this.width = 1;
    this.height = 1;
  }

  toScreen(x, y) {
    const c = Math.cos(this.angle) * this.scale, s = Math.sin(this.angle) * this.scale;
    const dx = x - this.x, dy = y - this.y;
    return [this.width / 2 + c * dx - s * dy, this.height / 2 - s * dx - c * dy];
  }

  toWorld(px, py) {
    const c = Math.cos(this.angle) / this.scale, s = Math.sin(this.angle) / this.scale;
    const dx = px - this.width / 2, dy = this.height / 2 - py;
    return [this.x + c * dx + s * dy, this.y - s * dx + c * dy];
  }

  // A context then draws in metres, y up; `ratio` is its pixels for one of the page's.
  apply(context, ratio) {
    const [e, f] = this.toScreen(0, 0), c = Math.cos(this.angle) * this.scale, s = Math.sin(this.angle) * this.scale;
    context.setTransform(ratio * c, -ratio * s, -ratio * s, -ratio * c, ratio * e, ratio * f);
  }

  visible() {
    const corners = [[0, 0], [this.width, 0], [0, this.height], [this.width, this.height]].map(([x, y]) => this.toWorld(x, y));
    const xs = corners.map((corner) => corner[0]), ys = corners.map((corner) => corner[1]);
    return { min: [Math.min(...xs), Math.min(...ys)], max: [Math.max(...xs), Math.max(...ys)] };
  }

  panBy(dx, dy) {
    const [x, y] = this.toWorld(this.width / 2 - dx, this.height / 2 - dy);
    this.x = x;
    this.y = y;
  }

  // What lies at the pixel stays there.
  changeAt(px, py, factor, turn) {
    const [x, y] = this.toWorld(px, py);
    this.scale = Math.min(Math.max(this.scale * factor, 0.5), 4000);
    this.angle += turn;
    const [qx, qy] = this.toScreen(x, y);
    this.panBy(px - qx, py - qy);
  }

  // [x0, y0, x1, y1] in the middle of what `room` {left, right, top, bottom} [px] leaves free.
  fit([x0, y0, x1, y1], room) {
    const c = Math.abs(Math.cos(this.angle)), s = Math.abs(Math.sin(this.angle));
    const w = Math.max(x1 - x0, 1), h = Math.max(y1 - y0, 1);
    const freeW = Math.max(this.width - room.left - room.right, 80), freeH = Math.max(this.height - room.top - room.bottom, 80);
    this.scale = 0.92 * Math.min(freeW / (c * w + s * h), freeH / (s * w + c * h), 400);
    this.x = (x0 + x1) / 2;
    this.y = (y0 + y1) / 2;
    this.panBy((room.left - room.right) / 2, (room.top - room.bottom) / 2);
  }
}
