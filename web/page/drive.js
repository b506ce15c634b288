// Velocities by stick, keys and gamepad: sent ten times a second while held, zero at release. The base drops an order after 0.5 s.
const kPeriodMs = 100;
const kZeros = 3;  // a message may be lost
const kDeadZone = 0.12;
const kShoulders = [4, 5, 6, 7];  // of the standard gamepad: one is held, or nothing drives

const kKeys = { ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0], ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1], KeyD: [0, -1] };

export class Drive {
  // send(v_m_per_s, w_rad_per_s); enabled(): whether keys and gamepad count now; refused(): whether none may drive, which it says;
  // limits: {v, w}.
  constructor({ send, enabled, refused }, limits) {
    Object.assign(this, { send, enabled, refused, limits });
    this.stick = [0, 0];   // forward, left: -1..1
    this.keys = new Set();
    this.zerosLeft = 0;
    this.onRelease = () => {};
    addEventListener("keydown", (event) => this.key(event, true));
    addEventListener("keyup", (event) => this.key(event, false));
    addEventListener("blur", () => this.release());
    document.addEventListener("visibilitychange", () => document.hidden && this.release());
    addEventListener("pagehide", () => this.release());
    setInterval(() => this.tick(), kPeriodMs);
  }

  key(event, down) {
    if (!(event.code in kKeys)) return;
    const typing = event.target.closest?.("input, textarea, select, dialog");
    if (down && (typing || !this.enabled() || event.ctrlKey || event.metaKey || event.altKey)) return;
    if (down) event.preventDefault();
    if (event.repeat || down === this.keys.has(event.code)) return;
    if (down) this.keys.add(event.code);
    else this.keys.delete(event.code);
    this.tick();
  }

  setStick(forward, left) {
    const begins = this.stick[0] === 0 && this.stick[1] === 0;
    this.stick = [forward, left];
    if (begins || (forward === 0 && left === 0)) this.tick();
  }

  // Held keys count as released until they are released and pressed again.
  release() {
    this.padRests = true;
    this.stick = [0, 0];
    this.keys.clear();
    this.onRelease();
    this.tick();
  }

  gamepad() {
    if (!this.enabled() || !document.hasFocus()) return [0, 0];
    const held = [...navigator.getGamepads?.() ?? []].find((pad) => pad && kShoulders.some((button) => pad.buttons[button]?.pressed));
    this.padRests &&= held !== undefined;
    if (this.padRests || !held) return [0, 0];
    const axis = (value) => (Math.abs(value ?? 0) < kDeadZone ? 0 : value);
    return [-axis(held.axes[1]), -(axis(held.axes[0]) || axis(held.axes[2]))];
  }

  wanted() {
    const pad = this.gamepad();
    let [forward, left] = [this.stick[0] + pad[0], this.stick[1] + pad[1]];
    for (const code of this.keys) {
      forward += kKeys[code][0];
      left += kKeys[code][1];
    }
    const clamp = (value) => Math.min(Math.max(value, -1), 1);
    return [clamp(forward), clamp(left)];
  }

  tick() {
    let [forward, left] = this.wanted();
    if ((forward !== 0 || left !== 0) && this.refused()) [forward, left] = [0, 0];
    const still = forward === 0 && left === 0;
    if (!still) this.zerosLeft = kZeros;
    else if (this.zerosLeft === 0) return;
    else --this.zerosLeft;
    this.send(forward * this.limits.v, left * this.limits.w);
  }
}

// A round stick for finger and mouse.
export function makeStick(root, drive) {
  const knob = document.createElement("div");
  knob.className = "knob";
  root.append(knob);
  let holder = null;
  const show = (x, y) => { knob.style.transform = `translate(${x}px, ${y}px)`; };
  const move = (event) => {
    const box = root.getBoundingClientRect(), radius = box.width / 2 - 28;
    let x = event.clientX - box.left - box.width / 2, y = event.clientY - box.top - box.height / 2;
    const length = Math.hypot(x, y), part = length > radius ? radius / length : 1;
    [x, y] = [x * part, y * part];
    show(x, y);
    const ease = (value) => Math.sign(value) * value * value;  // fine near the middle
    drive.setStick(ease(-y / radius), ease(-x / radius));
  };
  drive.onRelease = () => {
    holder = null;
    root.classList.remove("held");
    show(0, 0);
  };
  const lift = (event) => event.pointerId === holder && drive.release();
  root.addEventListener("pointerdown", (event) => {
    if (holder !== null || root.getAttribute("aria-disabled") === "true") return;
    holder = event.pointerId;
    root.setPointerCapture(holder);
    root.classList.add("held");
    move(event);
  });
  root.addEventListener("pointermove", (event) => event.pointerId === holder && move(event));
  for (const what of ["pointerup", "pointercancel", "lostpointercapture"]) root.addEventListener(what, lift);
}
