// Reads what Marco writes and what is alike: binary glTF 2.0, uncompressed, triangles with positions, and perhaps normals,
// colours and a texture. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
const kArrays = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const kParts = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

// @returns [{positions, normals, colors, uvs (Float32Array or null), indices (Uint32Array), image (Blob or null)}], z up.
export function readGlb(buffer) {
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== 0x46546C67 || view.getUint32(4, true) !== 2) throw new Error("no binary glTF 2.0");
  let document = null, binary = null;
  for (let at = 12; at + 8 <= buffer.byteLength;) {
    const length = view.getUint32(at, true), kind = view.getUint32(at + 4, true);
    if (kind === 0x4E4F534A) document = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, at + 8, length)));
    if (kind === 0x004E4942) binary = { offset: at + 8, length };
    at += 8 + length;
  }
  const parts = [];
  const walk = (number, turn) => {
    const node = document.nodes[number], here = multiply(turn, matrixOf(node));
    if (node.mesh !== undefined) {
      for (const primitive of document.meshes[node.mesh].primitives) parts.push(readPrimitive(document, buffer, binary, primitive, here));
    }
    for (const child of node.children ?? []) walk(child, here);
  };
  for (const root of document.scenes?.[document.scene ?? 0]?.nodes ?? []) walk(root, kZUp);
  return parts;
}

// glTF's y is up, ours is z.
const kZUp = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1];

// Column by column, as glTF has them.
function multiply(a, b) {
  const product = new Array(16).fill(0);
  for (let column = 0; column < 4; ++column) {
    for (let row = 0; row < 4; ++row) {
      for (let k = 0; k < 4; ++k) product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    }
  }
  return product;
}

function matrixOf(node) {
  if (node.matrix) return node.matrix;
  const [x, y, z, w] = node.rotation ?? [0, 0, 0, 1], [sx, sy, sz] = node.scale ?? [1, 1, 1], [tx, ty, tz] = node.translation ?? [0, 0, 0];
  return [(1 - 2 * (y * y + z * z)) * sx, 2 * (x * y + z * w) * sx, 2 * (x * z - y * w) * sx, 0,
    2 * (x * y - z * w) * sy, (1 - 2 * (x * x + z * z)) * sy, 2 * (y * z + x * w) * sy, 0,
    2 * (x * z + y * w) * sz, 2 * (y * z - x * w) * sz, (1 - 2 * (x * x + y * y)) * sz, 0, tx, ty, tz, 1];
}

function readPrimitive(document, buffer, binary, primitive, matrix) {
  if ((primitive.mode ?? 4) !== 4) throw new Error("only triangles can be drawn");
  const read = (number) => (number === undefined ? null : readAccessor(document, buffer, binary, number));
  const positions = read(primitive.attributes.POSITION), normals = read(primitive.attributes.NORMAL);
  let colors = read(primitive.attributes.COLOR_0);
  const count = positions.length / 3;
  if (colors && colors.length === 4 * count) colors = colors.filter((_, i) => i % 4 !== 3);
  move(positions, matrix, 1);
  if (normals) move(normals, matrix, 0);
  const indices = primitive.indices === undefined ? Uint32Array.from({ length: count }, (_, i) => i) : Uint32Array.from(read(primitive.indices));
  return { positions, normals, colors, uvs: read(primitive.attributes.TEXCOORD_0), indices, image: readImage(document, buffer, binary, primitive) };
}

function move(vectors, m, w) {
  for (let i = 0; i < vectors.length; i += 3) {
    const [x, y, z] = [vectors[i], vectors[i + 1], vectors[i + 2]];
    for (let row = 0; row < 3; ++row) vectors[i + row] = m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row] * w;
  }
}

// As floats, whole numbers that are "normalized" as 0..1; indices stay whole.
function readAccessor(document, buffer, binary, number) {
  const accessor = document.accessors[number], view = document.bufferViews[accessor.bufferView], Kind = kArrays[accessor.componentType];
  if (!view || accessor.sparse || (view.buffer ?? 0) !== 0 || document.buffers[0].uri) throw new Error("compressed or linked glTF");
  const parts = kParts[accessor.type], stride = view.byteStride ?? parts * Kind.BYTES_PER_ELEMENT;
  const first = binary.offset + (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const factor = accessor.normalized ? 1 / (2 ** (8 * Kind.BYTES_PER_ELEMENT - (accessor.componentType % 2 === 0 ? 1 : 0)) - 1) : 1;
  const values = new (accessor.type === "SCALAR" ? Uint32Array : Float32Array)(accessor.count * parts);
  // A slice, since the bytes need not begin where numbers of their kind may.
  const step = stride / Kind.BYTES_PER_ELEMENT, end = first + (accessor.count - 1) * stride + parts * Kind.BYTES_PER_ELEMENT;
  const elements = new Kind(buffer.slice(first, end));
  for (let i = 0; i < accessor.count; ++i) {
    for (let k = 0; k < parts; ++k) values[i * parts + k] = elements[i * step + k] * factor;
  }
  return values;
}

function readImage(document, buffer, binary, primitive) {
  const texture = document.materials?.[primitive.material]?.pbrMetallicRoughness?.baseColorTexture;
  const image = texture && document.images?.[document.textures[texture.index].source];
  if (!image || image.bufferView === undefined) return null;
  const view = document.bufferViews[image.bufferView];
  return new Blob([new Uint8Array(buffer, binary.offset + (view.byteOffset ?? 0), view.byteLength)], { type: image.mimeType });
}
