import { onTaken } from "./frames.js";

// How old what is seen is, by the server's clock: the user's own clock may show anything. [s]
const kPingMs = 2000, kFirstPingMs = 200, kDriftUsPerS = 100;
export const kGreyS = 1, kSaidS = 1.5, kRefusedS = 2;

// The server's clock, from the middle of the fastest question and answer.
class Clock {
  constructor(socket) {
    this.socket = socket;
    this.ask();
  }

  async ask() {
    const asked = performance.now();
    const answer = await this.socket.call("time", {}, kPingMs).catch(() => null), now = performance.now();
    if (answer) this.take(answer.utime - 500 * (asked + now), 500 * (now - asked), now);
    setTimeout(() => this.ask(), this.ahead_us === undefined ? kFirstPingMs : kPingMs);
  }

  // A slow answer changes nothing, unless the server's clock was set meanwhile.
  take(ahead_us, unsure_us, now) {
    const before_us = this.unsure_us + kDriftUsPerS * (now - this.at) / 1000, is_set = Math.abs(ahead_us - this.ahead_us) > unsure_us + before_us;
    if (unsure_us > before_us && !is_set) return;
    if (is_set) this.socket.newest_us = 0;
    Object.assign(this, { ahead_us, unsure_us, at: now });
  }

  now_us() {
    return 1000 * performance.now() + this.ahead_us;
  }
}

// The age of what is replaced now and then, and how old it had become before: what one looks at is that old again and again.
class Age {
  set(stamp_us, now_us) {
    if (stamp_us === this.stamp_us) return;
    this.before_us = now_us - this.stamp_us || 0;
    this.stamp_us = stamp_us;
  }

  at(now_us) {
    return 1e-6 * Math.max(now_us - this.stamp_us, this.before_us) || 0;
  }
}

export class Late {
  constructor(socket, world) {
    this.clock = new Clock(socket);
    this.world = world;
    this.views = new Map();  // name -> {age, came_us}, of the pose that each view shows
    this.newest = new Age();
    onTaken(() => this.newest.set(socket.newest_us, this.clock.now_us()));
  }

  // A view has drawn this robot; null: none, or it is closed.
  shown(view, robot) {
    if (!robot) return this.views.delete(view);
    const shown = this.views.get(view) ?? { age: new Age() };
    shown.age.set(robot.came_us - robot.under_way_us, this.clock.now_us());
    shown.came_us = robot.came_us;
    this.views.set(view, shown);
  }

  // Of the robot's pose, where it is seen oldest; 0 without one.
  get pose_s() {
    return this.oldest([...this.views.values()].map(({ age }) => age));
  }

  // Of the page as a whole. A pose that no newer one followed says only that SLAM is silent.
  get page_s() {
    const { robot } = this.world, behind = [...this.views.values()].filter(({ came_us }) => robot && came_us < robot.came_us);
    return this.oldest([this.newest, ...behind.map(({ age }) => age)]);
  }

  // Of what one steers by. SLAM may itself be slow.
  get steering_s() {
    const { robot } = this.world, speaks = robot && this.clock.now_us() - robot.came_us < 1e6 * kRefusedS;
    return this.page_s + (speaks ? 1e-6 * robot.under_way_us : 0);
  }

  oldest(ages) {
    const now_us = this.clock.now_us();
    return this.world.mode === "live" ? Math.max(0, ...ages.map((age) => age.at(now_us))) : 0;
  }
}
