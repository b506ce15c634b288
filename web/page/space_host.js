import { SpaceScene } from "./space_scene.js";
import { loadThree } from "./three_loader.js";

// Begins the scene: in a worker, or in the page where it cannot be in one (a page from disk has none).
// @returns ask(what, ...values): calls it. Rejects with a word for the user; what fails later is said to told.failed(text).
export async function beginScene(canvas, told) {
  if (document.getElementById("snapshot") || !canvas.transferControlToOffscreen) {
    await loadThree();
    const scene = new SpaceScene(canvas, told);
    return (what, ...values) => scene[what](...values);
  }
  const worker = new Worker(new URL("page/space_worker.js", document.baseURI), { type: "module" }), drawn_on = canvas.transferControlToOffscreen();
  worker.postMessage(["begin", drawn_on, new URL(`page/three.js${location.search}`, document.baseURI).href], [drawn_on]);
  return new Promise((begun, failed) => {
    worker.onerror = ({ message }) => failed(new Error(`3D cannot begin: ${message}`));
    worker.onmessage = ({ data: [what, ...values] }) => {
      if (what === "failed") failed(new Error(values[0]));  // which counts before it has begun
      if (what !== "begun") told[what](...values);
      else begun((...words) => worker.postMessage(words, words.filter((word) => word instanceof ArrayBuffer || word instanceof ImageBitmap)));
    };
  });
}
