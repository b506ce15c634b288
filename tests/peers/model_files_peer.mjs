// A compressed model.glb in other people's hands: Khronos' validator finds no error, neither in it nor, since it cannot look
// into compressed numbers, in what glTF-Transform makes of it uncompressed; and glTF-Transform with meshopt's own decoder finds what the plain one holds: as many triangles, the same box to half a millimetre, the same colours.
// usage: node model_files_peer.mjs MARCO_MAP [RECORDING]
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { NodeIO } from "@gltf-transform/core";
import { EXTMeshoptCompression, KHRMeshQuantization } from "@gltf-transform/extensions";
import validator from "gltf-validator";
import { MeshoptDecoder } from "meshoptimizer";

const kMostOffM = 0.0005;
let wrong = 0;

function expect(holds, complaint) {
  if (holds) return;
  wrong += 1;
  console.log(`WRONG: ${complaint}`);
}

async function validate(name, bytes) {
  const { issues } = await validator.validateBytes(new Uint8Array(bytes), { maxIssues: 20 });
  for (const issue of issues.messages) console.log(`${name}: ${issue.code} ${issue.pointer ?? ""} ${issue.message}`);
  expect(issues.numErrors === 0, `${name}: ${issues.numErrors} errors by gltf-validator`);
}

async function opened(path) {
  await MeshoptDecoder.ready;
  const io = new NodeIO().registerExtensions([EXTMeshoptCompression, KHRMeshQuantization])
    .registerDependencies({ "meshopt.decoder": MeshoptDecoder });
  const document = await io.read(path), root = document.getRoot(), primitive = root.listMeshes()[0].listPrimitives()[0];
  const all = (name) => {
    const accessor = primitive.getAttribute(name);
    return accessor && Array.from({ length: accessor.getCount() }, (_, i) => accessor.getElement(i, []));
  };
  const found = {
    extensions: root.listExtensionsRequired().map((extension) => extension.extensionName).sort(),
    triangles: primitive.getIndices().getCount() / 3,
    positions: all("POSITION"), normals: all("NORMAL"), colors: all("COLOR_0"),
  };
  document.disposeExtension("EXT_meshopt_compression");
  await validate(`${path}, uncompressed`, await io.writeBinary(document));
  return found;
}

const dot = (a, b) => a.reduce((sum, part, axis) => sum + part * b[axis], 0);

// Both lists by place, to the nearest 2^-10 m as the compressed one has it.
function byPlace(model) {
  const places = new Map();
  model.positions.forEach((at, i) => {
    const key = at.map((part) => Math.sign(part) * Math.round(Math.abs(part) * 1024) || 0).join();
    places.set(key, [...(places.get(key) ?? []), i]);
  });
  return places;
}

function compare(plain, packed) {
  expect(packed.extensions.join() === "EXT_meshopt_compression,KHR_mesh_quantization", `extensions ${packed.extensions}`);
  expect(plain.extensions.length === 0, "the plain file needs extensions");
  expect(packed.triangles === plain.triangles, `${packed.triangles} triangles, not ${plain.triangles}`);
  expect(packed.positions.length === plain.positions.length, `${packed.positions.length} vertices, not ${plain.positions.length}`);
  for (let axis = 0; axis < 3; ++axis) {
    for (const most of [(a, b) => Math.max(a, b), (a, b) => Math.min(a, b)]) {
      const end = (model) => model.positions.reduce((sofar, at) => most(sofar, at[axis]), most(Infinity, -Infinity) * -1);
      expect(Math.abs(end(plain) - end(packed)) <= kMostOffM, `axis ${axis} ends at ${end(packed)}, not ${end(plain)}`);
    }
  }
  const places = byPlace(plain);
  let lost = 0, bent = 0, painted = 0;
  packed.positions.forEach((at, i) => {
    const here = places.get(at.map((part) => Math.round(part * 1024) || 0).join());
    if (!here) return (lost += 1);
    if (packed.normals && !here.some((k) => dot(packed.normals[i], plain.normals[k]) / Math.hypot(...packed.normals[i]) > 0.9994)) bent += 1;
    if (packed.colors && !here.some((k) => packed.colors[i].every((part, c) => part === plain.colors[k][c]))) painted += 1;
  });
  expect(lost === 0, `${lost} vertices are nowhere in the plain file`);
  expect(bent === 0, `${bent} normals are off by more than 2 degrees`);
  expect(painted === 0, `${painted} vertices of another colour`);
}

const [program, recording] = process.argv.slice(2);
if (!recording) {
  console.log("SKIPPED: no recording with 3D scans, MARCO_TEST_DATA is not set");
  process.exit(0);
}
const folder = mkdtempSync(join(tmpdir(), "marco_model_files_"));
try {
  const models = {}, sizes = {};
  for (const kind of ["plain", "packed"]) {
    const out = join(folder, kind);
    execFileSync(program, [recording, "--out", out, ...(kind === "packed" ? ["--compressed-glb"] : [])], { stdio: "ignore" });
    const bytes = readFileSync(join(out, "model.glb"));
    await validate(join(out, "model.glb"), bytes);
    models[kind] = await opened(join(out, "model.glb"));
    sizes[kind] = bytes.length;
  }
  compare(models.plain, models.packed);
  console.log(`${models.packed.triangles} triangles; ${sizes.plain} bytes plain, ${sizes.packed} compressed: ${(sizes.plain / sizes.packed).toFixed(2)} times smaller`);
} finally {
  rmSync(folder, { recursive: true });
}
process.exit(wrong === 0 ? 0 : 1);
