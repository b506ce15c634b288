// Fingers, mouse and wheel on a canvas. `told`: pan(dx, dy) by one finger or the left button, side(dx, dy) by the right one or
// with Shift, carry(dx, dy) by two fingers, change(x, y, factor, turn), click(x, y), hover(x, y) or hover(null); and for a tool that wants drags: wantsDrag(), drag("start" | "move" | "end" | "cancel", x, y).
const kClickPx = 6;
const kTurnRad = 0.15;  // two fingers turn the map only when they mean it

export function listen(canvas, told) {
  const fingers = new Map();  // pointer id -> [x, y]
  let moved = 0, turning = false, turned = 0, dragging = false;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "mouse" && event.button === 1) return;
    canvas.setPointerCapture(event.pointerId);
    const at = place(event);
    fingers.set(event.pointerId, at);
    if (fingers.size === 1) {
      moved = 0;
      dragging = event.button === 0 && !event.shiftKey && told.wantsDrag();
      if (dragging) told.drag("start", ...at);
    } else {
      if (dragging) told.drag("cancel", ...at);
      dragging = false;
      moved = Infinity;
      turning = false;
      turned = 0;
    }
  });

  canvas.addEventListener("pointermove", (event) => {
    const at = place(event), before = fingers.get(event.pointerId);
    if (event.pointerType !== "touch") told.hover(...at);
    if (before === undefined) return;
    const [dx, dy] = [at[0] - before[0], at[1] - before[1]];
    moved += Math.hypot(dx, dy);
    if (fingers.size === 2) pinch(event.pointerId, before, at);
    fingers.set(event.pointerId, at);
    if (fingers.size > 1) return;
    if (dragging) told.drag("move", ...at);
    else if (event.shiftKey || (event.buttons & 2)) told.side(dx, dy);
    else if (moved > kClickPx) told.pan(dx, dy);
  });

  function pinch(id, before, at) {
    const [, other] = [...fingers].find(([key]) => key !== id);
    const a = [before[0] - other[0], before[1] - other[1]], b = [at[0] - other[0], at[1] - other[1]];
    const middle = [(before[0] + other[0]) / 2, (before[1] + other[1]) / 2];  // what lies there moves with it
    let turn = Math.atan2(a[1], a[0]) - Math.atan2(b[1], b[0]);
    turn = Math.atan2(Math.sin(turn), Math.cos(turn));
    turned += turn;
    if (Math.abs(turned) > kTurnRad) turning = true;
    told.change(...middle, Math.hypot(...b) / Math.max(Math.hypot(...a), 1), turning ? turn : 0);
    told.carry((at[0] - before[0]) / 2, (at[1] - before[1]) / 2);
  }

  function lift(event) {
    const at = fingers.get(event.pointerId);
    if (at === undefined) return;
    fingers.delete(event.pointerId);
    if (fingers.size > 0) return;
    const cancelled = event.type === "pointercancel";
    if (dragging) told.drag(cancelled ? "cancel" : "end", ...at);
    else if (moved <= kClickPx && !cancelled && event.button === 0) told.click(...at);
    dragging = false;
  }
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("pointerleave", () => told.hover(null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;  // of a mouse whose wheel counts lines
    const at = place(event);
    if (event.shiftKey) told.change(...at, 1, (event.deltaY || event.deltaX) * lines / 600);
    else told.change(...at, Math.exp(-event.deltaY * lines / (event.ctrlKey ? 100 : 500)), 0);
  }, { passive: false });
}
