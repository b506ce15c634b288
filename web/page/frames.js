// The page's frames: what came since the last one is taken, then what changed is drawn, once and in the same frame.
// Of a state only the newest is kept, so that a browser that draws seldom is at most one frame late.
const kept = new Map(), takers = [];  // topic -> how the newest one is taken
let drawers = new Set(), asked = false;

function ask() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(run);
}

// One that fails leaves the others alone.
function attempt(act) {
  try {
    act();
  } catch (fault) {
    setTimeout(() => { throw fault; });
  }
}

function run() {
  takeKept();
  const due = drawers;
  drawers = new Set();
  asked = false;
  due.forEach(attempt);
}

export function takeKept() {
  const newest = [...kept.values()];
  kept.clear();
  newest.forEach(attempt);
  if (newest.length > 0) takers.forEach(attempt);
}

// take() is called in the next frame, unless a newer one of its name takes its place.
export function keepNewest(name, take) {
  kept.delete(name);
  kept.set(name, take);
  ask();
}

// After what came was taken, before anything is drawn.
export function onTaken(taker) {
  takers.push(taker);
}

// draw() is called once in the next frame; in this one, where it is asked for by what is taken.
export function drawSoon(draw) {
  drawers.add(draw);
  ask();
}

// Turns for work that may wait, a few milliseconds of each frame's: orders and poses come first.
const kSliceMs = 6, kFrameMs = 16, waiting = [];
let runs = false;

async function giveTurns() {
  runs = true;
  while (waiting.length > 0) {
    const end = performance.now() + kSliceMs;
    while (waiting.length > 0 && performance.now() < end) {
      waiting.shift()();
      await null;  // the work itself
    }
    await new Promise((rested) => setTimeout(rested, kFrameMs - kSliceMs));
  }
  runs = false;
}

export function turn() {
  return new Promise((mine) => {
    waiting.push(mine);
    if (!runs) giveTurns();
  });
}
