// From where the model is seen: around a point, or standing in it at a person's height. z is up.
const kEyeHeightM = 1.6;
const kWalkM = 1.4;        // a second
const kTurnRad = 0.006;    // a pixel
const kFieldDeg = 55;

export class Eye {
  constructor() {
    this.camera = new THREE.PerspectiveCamera(kFieldDeg, 1, 0.05, 2000);
    this.camera.up.set(0, 0, 1);
    this.target = new THREE.Vector3();
    this.yaw = -Math.PI / 2;   // where it looks
    this.pitch = -0.9;
    this.distance = 20;
    this.walking = false;
    this.keys = new Set();
  }

  ahead() {
    const c = Math.cos(this.pitch);
    return new THREE.Vector3(c * Math.cos(this.yaw), c * Math.sin(this.yaw), Math.sin(this.pitch));
  }

  place(width, height) {
    const { camera, target } = this, ahead = this.ahead();
    camera.aspect = width / height;
    if (this.walking) camera.position.copy(target);
    else camera.position.copy(target).addScaledVector(ahead, -this.distance);
    camera.lookAt(camera.position.clone().add(ahead));
    camera.near = this.walking ? 0.05 : Math.max(this.distance / 500, 0.05);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  // All of a box, from above and a little aside.
  fit(box, aspect) {
    const size = box.getSize(new THREE.Vector3());
    this.walking = false;
    box.getCenter(this.target);
    this.yaw = size.x >= size.y * Math.min(aspect, 1) ? Math.PI / 2 - 0.3 : -0.3;
    this.pitch = -0.95;
    const ahead = this.ahead(), right = new THREE.Vector3(Math.sin(this.yaw), -Math.cos(this.yaw), 0), up = right.clone().cross(ahead);
    const half = Math.tan(kFieldDeg * Math.PI / 360);
    this.distance = 0;
    for (let i = 0; i < 8; ++i) {
      const corner = new THREE.Vector3(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).multiply(size);
      const far = Math.max(Math.abs(corner.dot(right)) / (half * aspect), Math.abs(corner.dot(up)) / half) - corner.dot(ahead);
      this.distance = Math.max(this.distance, 1.06 * far);
    }
  }

  walkFrom(x, y, floor) {
    this.walking = true;
    this.target.set(x, y, floor + kEyeHeightM);
    this.pitch = 0;
  }

  turn(dx, dy) {
    const sign = this.walking ? -0.5 : 1;  // what is seen follows the finger
    this.yaw -= sign * dx * kTurnRad;
    const limit = Math.PI / 2 - 0.01;
    this.pitch = Math.min(Math.max(this.pitch - sign * dy * kTurnRad, -limit), this.walking ? limit : 0.3);
  }

  // Along the floor, as far as a pixel is at the target.
  shift(dx, dy, height) {
    const step = (this.walking ? 3 : this.distance) * 2 * Math.tan(kFieldDeg * Math.PI / 360) / height;
    this.move(dy * step, -dx * step);
  }

  move(ahead, right) {
    const c = Math.cos(this.yaw), s = Math.sin(this.yaw);
    this.target.x += c * ahead + s * right;
    this.target.y += s * ahead - c * right;
  }

  zoom(factor) {
    if (this.walking) this.move(Math.log(factor), 0);
    else this.distance = Math.min(Math.max(this.distance / factor, 0.3), 1000);
  }

  // Held keys for `seconds`. @returns whether anything moved.
  step(seconds) {
    const held = (...codes) => codes.some((code) => this.keys.has(code));
    const ahead = held("KeyW", "ArrowUp") - held("KeyS", "ArrowDown"), right = held("KeyD") - held("KeyA");
    const turn = held("ArrowLeft", "KeyQ") - held("ArrowRight", "KeyE");
    if (!this.walking || (ahead === 0 && right === 0 && turn === 0)) return false;
    this.move(ahead * kWalkM * seconds, right * kWalkM * seconds);
    this.yaw += turn * 1.2 * seconds;
    return true;
  }
}
