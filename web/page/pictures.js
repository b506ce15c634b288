import { el, showDialog } from "./dom.js";

// A picture of a map folder. Browsers know no PPM and PGM (cameras without JPEG): those are read here.
// @returns {Promise<HTMLCanvasElement | HTMLImageElement>}
export async function loadPicture(file) {
  const url = file.startsWith("data:") ? file : `files/${file}${location.search}`;
  if (/\.p[pg]m$/.test(file)) return readPnm(new Uint8Array(await (await fetch(url)).arrayBuffer()));
  const image = new Image();
  image.src = url;
  await image.decode();
  return image;
}

function readPnm(bytes) {
  const words = [];
  let at = 0;
  while (words.length < 4) {
    let word = "";
    while (bytes[at] > 32) word += String.fromCharCode(bytes[at++]);
    ++at;
    if (word !== "") words.push(word);
  }
  const [kind, width, height] = [words[0], Number(words[1]), Number(words[2])], canvas = el("canvas", { width, height });
  const image = new ImageData(width, height), step = kind === "P6" ? 3 : 1;
  for (let i = 0; i < width * height; ++i) {
    const from = at + i * step;
    image.data.set([bytes[from], bytes[from + (step > 1 ? 1 : 0)], bytes[from + (step > 1 ? 2 : 0)], 255], 4 * i);
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}

// In a window of its own on the page.
export async function showPicture(file) {
  const content = el("div", {}, "Loading…"), close = ({ target }) => target.closest("#halt") ?? dialog.close();
  const dialog = el("dialog", { class: "picture", onclick: close }, content, el("button", { type: "button", class: "quiet" }, "Close"));
  showDialog(dialog);
  content.replaceChildren(await loadPicture(file).catch(() => "Cannot read this picture."));
}
