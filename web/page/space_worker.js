import { SpaceScene } from "./space_scene.js";

// Draws the model in a worker. Messages are [what, ...values], to SpaceScene and from it.
let scene = null;
const told = Object.fromEntries(["drawn", "measured", "picked"].map((what) => [what, (...values) => postMessage([what, ...values])]));

async function begin(canvas, three) {
  await import(three).catch(() => { throw new Error("3D needs three.js, which is not installed (Debian: apt install libjs-three)"); });
  scene = new SpaceScene(canvas, told);
  postMessage(["begun"]);
}

onmessage = async ({ data: [what, ...values] }) => {
  try {
    await (what === "begin" ? begin(...values) : scene[what](...values));
  } catch (fault) {
    postMessage(["failed", fault.message]);
  }
};
