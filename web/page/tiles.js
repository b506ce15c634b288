import { turn } from "./frames.js";

// The map: tiles of occupancy, drawn once in the colours of the day or the night, moved by the view's transform.
const kUnknown = 255;
const kLevels = [1, 2, 4];  // cells a side that are one pixel, for views from afar

function bytesOf(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

export class Tiles {
  constructor(changed) {
    this.changed = changed;
    this.tiles = new Map();  // "x y" of the corner in millimetres -> tile
    this.newest = new Map(); // the same -> number of the last tile that came
    this.count = 0;
    this.lut = new Uint32Array(256);
  }

  clear() {
    for (const tile of this.tiles.values()) close(tile);
    this.tiles.clear();
    this.newest.clear();
    this.changed();
  }

  // A message of page/tiles, or a snapshot.
  async take({ resolution_m, tiles, clear }) {
    if (clear || (this.resolution_m !== undefined && resolution_m !== this.resolution_m)) this.clear();
    this.resolution_m = resolution_m;
    await Promise.all(tiles.map((tile) => this.add(tile, resolution_m)));
  }

  async add({ x_m, y_m, width, height, png }, resolution_m) {
    const key = `${Math.round(x_m * 1000)} ${Math.round(y_m * 1000)}`, number = ++this.count;
    this.newest.set(key, number);
    const isOld = () => this.newest.get(key) !== number;  // a newer one came, or all were dropped
    await turn();
    if (isOld()) return;
    const picture = await createImageBitmap(new Blob([bytesOf(png)], { type: "image/png" }), { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    await turn();
    if (isOld()) return picture.close();
    const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    context.drawImage(picture, 0, 0);
    picture.close();
    const rgba = context.getImageData(0, 0, width, height).data, cells = new Uint8Array(width * height);
    for (let i = 0; i < cells.length; ++i) cells[i] = rgba[4 * i];
    const tile = { x_m, y_m, width, height, width_m: width * resolution_m, height_m: height * resolution_m, levels: kLevels.map((step) => reduced(cells, width, height, step)), bitmaps: [] };
    await this.paint(tile);
    if (isOld()) return close(tile);
    if (this.tiles.has(key)) close(this.tiles.get(key));
    this.tiles.set(key, tile);
    this.changed();
  }

  async paint(tile) {
    const bitmaps = await Promise.all(tile.levels.map(({ cells, width, height }) => {
      const image = new ImageData(width, height), pixels = new Uint32Array(image.data.buffer);
      for (let i = 0; i < pixels.length; ++i) pixels[i] = this.lut[cells[i]];
      return createImageBitmap(image);
    }));
    close(tile);
    tile.bitmaps = bitmaps;
  }

  // free, occupied: [red, green, blue]. Unknown cells stay transparent.
  async setColors(free, occupied) {
    for (let percent = 0; percent <= 100; ++percent) {
      // Rather free reads as free: cells seen once are no grey fans.
      const part = Math.min(Math.max((percent - 40) / 30, 0), 1);
      const [r, g, b] = [0, 1, 2].map((i) => Math.round(free[i] + part * (occupied[i] - free[i])));
      this.lut[percent] = (255 << 24 | b << 16 | g << 8 | r) >>> 0;
    }
    this.lut[kUnknown] = 0;
    await Promise.all([...this.tiles.values()].map((tile) => this.paint(tile)));
    this.changed();
  }

  // `context` draws in metres, y up. Half a pixel more to the right and up hides the seams.
  draw(context, view) {
    const { min, max } = view.visible(), more = 0.5 / view.scale, cell_px = view.scale * this.resolution_m * (window.devicePixelRatio || 1);
    const level = cell_px > 0.9 ? 0 : cell_px > 0.45 ? 1 : 2;
    context.imageSmoothingEnabled = cell_px < 2;
    context.imageSmoothingQuality = "medium";
    for (const tile of this.tiles.values()) {
      const off = tile.x_m > max[0] || tile.y_m > max[1] || tile.x_m + tile.width_m < min[0] || tile.y_m + tile.height_m < min[1];
      if (off || tile.bitmaps.length === 0) continue;
      const { width, height } = tile.levels[level], step = kLevels[level] * this.resolution_m;
      context.drawImage(tile.bitmaps[level], tile.x_m, tile.y_m, width * step + more, height * step + more);
    }
  }

  // [x0, y0, x1, y1] of the known cells; null without any.
  bounds() {
    let box = null;
    for (const tile of this.tiles.values()) {
      tile.known ??= knownBox(tile);
      if (tile.known === null) continue;
      const [x0, y0, x1, y1] = tile.known, step = this.resolution_m;
      const here = [tile.x_m + x0 * step, tile.y_m + y0 * step, tile.x_m + x1 * step, tile.y_m + y1 * step];
      box = box === null ? here : [Math.min(box[0], here[0]), Math.min(box[1], here[1]), Math.max(box[2], here[2]), Math.max(box[3], here[3])];
    }
    return box;
  }
}

function close(tile) {
  for (const bitmap of tile.bitmaps) bitmap.close();
  tile.bitmaps = [];
}

// Squares of cells as one: a wall stays a wall however far away, and known stays known.
function reduced(cells, width, height, step) {
  if (step === 1) return { cells, width, height };
  const w = Math.ceil(width / step), h = Math.ceil(height / step), small = new Uint8Array(w * h).fill(kUnknown);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const cell = cells[y * width + x], at = Math.floor(y / step) * w + Math.floor(x / step);
      if (cell !== kUnknown && (small[at] === kUnknown || cell > small[at])) small[at] = cell;
    }
  }
  return { cells: small, width: w, height: h };
}

function knownBox(tile) {
  const { cells } = tile.levels[0];
  let x0 = tile.width, y0 = tile.height, x1 = 0, y1 = 0;
  for (let y = 0; y < tile.height; ++y) {
    for (let x = 0; x < tile.width; ++x) {
      if (cells[y * tile.width + x] === kUnknown) continue;
      x0 = Math.min(x0, x);
      x1 = Math.max(x1, x + 1);
      y0 = Math.min(y0, y);
      y1 = Math.max(y1, y + 1);
    }
  }
  return x1 > x0 ? [x0, y0, x1, y1] : null;
}
