// Map folders whose measures are known: two posts on a floor plan, two coloured cubes as a model.
import { mkdir, writeFile } from "node:fs/promises";

const resolution = 0.05, width = 240, height = 160, origin = [-3.35, -2.15];

// Cells of the posts' lower left corners; each is 2 x 2 cells.
const posts = [[30, 30], [180, 110]];
export const postsApart_m = resolution * Math.hypot(posts[1][0] - posts[0][0], posts[1][1] - posts[0][1]);

// Edge of a cube 0.1 m, between their middles 3 m along x and 1 m along y.
export const cubes = [{ at: [0, 0, 0.5], rgb: [255, 0, 0] }, { at: [3, 1, 0.5], rgb: [0, 0, 255] }];
export const cubesApart_m = Math.hypot(3, 1);

function glb() {
  const positions = [], colors = [], indices = [];
  for (const { at, rgb } of cubes) {
    const first = positions.length / 3;
    for (let i = 0; i < 8; ++i) {
      positions.push(at[0] + (i & 1 ? 0.05 : -0.05), at[1] + (i & 2 ? 0.05 : -0.05), at[2] + (i & 4 ? 0.05 : -0.05));
      colors.push(...rgb, 255);
    }
    for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) indices.push(...[a, b, c, a, c, d].map((i) => first + i));
  }
  const parts = [Buffer.from(Float32Array.from(positions).buffer), Buffer.from(colors), Buffer.from(Uint32Array.from(indices).buffer)], count = positions.length / 3;
  let offset = 0;
  const bufferViews = parts.map((part) => {
    const view = { buffer: 0, byteOffset: offset, byteLength: part.length };
    offset += part.length;
    return view;
  });
  const half = Math.SQRT1_2;
  let text = JSON.stringify({ asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, rotation: [-half, 0, 0, half] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, COLOR_0: 1 }, indices: 2, mode: 4 }] }], buffers: [{ byteLength: offset }], bufferViews,
    accessors: [{ bufferView: 0, componentType: 5126, count, type: "VEC3" }, { bufferView: 1, componentType: 5121, normalized: true, count, type: "VEC4" }, { bufferView: 2, componentType: 5125, count: indices.length, type: "SCALAR" }] });
  text += " ".repeat((4 - text.length % 4) % 4);
  const head = Buffer.alloc(20), binHead = Buffer.alloc(8);
  [0x46546C67, 2, 28 + text.length + offset, text.length, 0x4E4F534A].forEach((word, i) => head.writeUInt32LE(word, 4 * i));
  binHead.writeUInt32LE(offset);
  binHead.writeUInt32LE(0x004E4942, 4);
  return Buffer.concat([head, Buffer.from(text), binHead, ...parts]);
}

export async function writeFolder(folder) {
  await mkdir(folder, { recursive: true });
  const pixels = Buffer.alloc(width * height, 254);
  for (const [x, y] of posts) for (const [dx, dy] of [[0, 0], [1, 0], [0, 1], [1, 1]]) pixels[(height - 1 - y - dy) * width + x + dx] = 0;
  await writeFile(`${folder}/map.pgm`, Buffer.concat([Buffer.from(`P5\n${width} ${height}\n255\n`), pixels]));
  await writeFile(`${folder}/map.yaml`, `image: map.pgm\nresolution: ${resolution}\norigin: [${origin[0]}, ${origin[1]}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n`);
  await writeFile(`${folder}/report.json`, JSON.stringify({ verdict: "doubtful", doctor: { reasons: [{ why: "<b>bent</b> here", verdict: "doubtful", x_m: 1, y_m: 1, picture: "doctor_1.png", edits: ["forbid_loop 1 2"] }] } }));
  await writeFile(`${folder}/model.glb`, glb());
}
