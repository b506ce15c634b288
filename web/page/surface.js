import { readGlb } from "./glb.js";

// The model in the colours and the light of Marco's renders (viewer/shading.hpp).
const kHeightColors = [[0.60, 0.69, 0.82], [0.62, 0.81, 0.82], [0.91, 0.91, 0.80], [0.97, 0.84, 0.64], [0.90, 0.63, 0.53]];
const kVertex = `
varying vec3 world_m, surface_normal, towards_eye;
#if defined(OWN_COLOR)
attribute vec3 own_color;
varying vec3 base_color;
#elif defined(TEXTURE)
varying vec2 at;
#endif
void main() {
  world_m = position;
  surface_normal = normal;
  towards_eye = cameraPosition - position;
#if defined(OWN_COLOR)
  base_color = own_color;
#elif defined(TEXTURE)
  at = uv;
#endif
  gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
}`;
const kFragment = `
varying vec3 world_m, surface_normal, towards_eye;
uniform float low_m, high_m, cut_m;
uniform vec3 height_colors[5], lamp;
#if defined(OWN_COLOR)
varying vec3 base_color;
#elif defined(TEXTURE)
varying vec2 at;
uniform sampler2D picture;
#endif
vec3 height_color(float part) {
  float place = clamp(part, 0.0, 1.0) * 4.0;
  vec3 color = height_colors[0];
  for (int i = 0; i < 4; ++i) color = mix(color, height_colors[i + 1], clamp(place - float(i), 0.0, 1.0));
  return color;
}
void main() {
  if (world_m.z > cut_m) discard;
  vec3 n = normalize(surface_normal);
  if (dot(n, towards_eye) < 0.0) n = -n;
#if defined(OWN_COLOR)
  vec3 base = base_color;
#elif defined(TEXTURE)
  vec3 base = texture2D(picture, at).rgb;
#else
  vec3 base = height_color((world_m.z - low_m) / max(high_m - low_m, 0.001));
#endif
  gl_FragColor = vec4(base * (0.66 + 0.09 * n.z + 0.30 * max(dot(n, lamp), 0.0)), 1.0);
}`;

const kBinM = 0.05;  // of heights

export class Surface {
  constructor() {
    this.group = new THREE.Group();
    this.tiles = new Map();  // of MESH: number -> mesh
    this.floor_m = 0;
    this.ceiling_m = 2.5;
    this.shared = { low_m: { value: 0 }, high_m: { value: 2.5 }, cut_m: { value: 1e9 }, lamp: { value: new THREE.Vector3(0, 0, 1) },
      height_colors: { value: kHeightColors.map((color) => new THREE.Vector3(...color)) } };
  }

  async loadGlb(buffer) {
    for (const part of readGlb(buffer)) {
      this.group.add(this.mesh(part, part.image ? await textureOf(part.image) : null));
    }
    this.survey();
  }

  mesh({ positions, normals, colors, uvs, indices }, texture) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    if (normals) geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
    else geometry.computeVertexNormals();
    if (colors) geometry.setAttribute("own_color", new THREE.BufferAttribute(Float32Array.from(colors), 3));
    if (uvs) geometry.setAttribute("uv", new THREE.BufferAttribute(uvs, 2));
    geometry.computeBoundingBox();
    const defines = texture ? { TEXTURE: 1 } : colors ? { OWN_COLOR: 1 } : {};
    const uniforms = { ...this.shared, picture: { value: texture } };
    const mesh = new THREE.Mesh(geometry, new THREE.ShaderMaterial({ vertexShader: kVertex, fragmentShader: kFragment, uniforms, defines, side: THREE.DoubleSide }));
    mesh.levels = levelsOf(geometry);
    return mesh;
  }

  // A message of MESH: one tile of the model as it grows. survey() is due.
  takeTile({ tile, tiles, vertices_m, normals, triangles }) {
    for (const number of [...this.tiles.keys()]) if (number === tile || number >= tiles) this.drop(number);
    if (triangles.length > 0) {
      const mesh = this.mesh({ positions: flat(vertices_m), normals: normals.length > 0 ? flat(normals) : null, indices: Uint32Array.from(triangles.flat()) }, null);
      this.tiles.set(tile, mesh);
      this.group.add(mesh);
    }
  }

  drop(number) {
    const mesh = this.tiles.get(number);
    this.group.remove(mesh);
    mesh.geometry.dispose();
    mesh.material.dispose();
    this.tiles.delete(number);
  }

  box() {
    return this.group.children.reduce((box, { geometry }) => box.union(geometry.boundingBox), new THREE.Box3());
  }

  get isEmpty() {
    return this.group.children.length === 0;
  }

  // Floor and ceiling: the lowest and the highest level with much level surface (viewer/model_survey.cpp).
  survey() {
    const levels = new Map();
    let largest = 0;
    for (const mesh of this.group.children) mesh.levels.forEach((area, bin) => levels.set(bin, (levels.get(bin) ?? 0) + area));
    for (const area of levels.values()) largest = Math.max(largest, area);
    const large = [...levels].filter(([, area]) => area > 0.2 * largest).map(([bin]) => bin).sort((a, b) => a - b);
    if (large.length === 0) return;
    const box = this.box();
    this.floor_m = large[0] * kBinM;
    const top = large[large.length - 1] * kBinM;
    this.has_ceiling = top - this.floor_m > 1.5;
    this.ceiling_m = this.has_ceiling ? top : box.max.z;
    this.shared.low_m.value = this.floor_m;
    this.shared.high_m.value = this.ceiling_m;
  }
}

// Level surface by height: [m2] in bins of kBinM.
function levelsOf(geometry) {
  const at = geometry.attributes.position.array, index = geometry.index.array, levels = new Map();
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [3 * index[i], 3 * index[i + 1], 3 * index[i + 2]];
    const [ux, uy, uz] = [at[b] - at[a], at[b + 1] - at[a + 1], at[b + 2] - at[a + 2]];
    const [vx, vy, vz] = [at[c] - at[a], at[c + 1] - at[a + 1], at[c + 2] - at[a + 2]];
    const [nx, ny, nz] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], twice = Math.hypot(nx, ny, nz);
    if (Math.abs(nz) < 0.85 * twice) continue;
    const level = Math.floor((at[a + 2] + at[b + 2] + at[c + 2]) / 3 / kBinM);
    levels.set(level, (levels.get(level) ?? 0) + twice / 2);
  }
  return levels;
}

function flat(vectors) {
  const values = new Float32Array(3 * vectors.length);
  vectors.forEach((vector, i) => values.set(vector, 3 * i));
  return values;
}

async function textureOf(blob) {
  const texture = new THREE.Texture(await createImageBitmap(blob));
  texture.flipY = false;  // glTF's first row is v = 0
  texture.needsUpdate = true;
  return texture;
}
