// All that is known of robot and map, and who wants to hear of a change.
export class World {
  constructor() {
    this.listeners = new Map();
    this.reset();
    this.mode = "live";       // "live", "folder" or "recording"
    this.name = "";
    this.readOnly = false;
    this.connection = "connecting";
    this.health = null;
    this.commands = null;
    this.output = new Map();  // command -> lines
    this.stop = { engaged: false, by: "" };
    this.base = null;
    this.head = null;         // {pan, tilt, since}: [rad], and since when it looks there [ms]
    this.snapshot = null;
  }

  // The map begins anew.
  reset() {
    this.robot = null;        // {x, y, theta, covariance, status, overlap, utime, came_us (at the server), under_way_us (until then)}
    this.path = [];           // [x, y] of the keyframes, oldest first
    this.pathUtime = 0;
    this.trail = [];          // {utime, x, y} since the newest keyframe
    this.scan = null;         // {x_m, y_m}
    this.walls = [];          // [x0, y0, x1, y1]
    this.loops = [];          // [x0, y0, x1, y1, "taken" | "refused"]
    this.livePath = [];
    this.odometry = [];
    this.truth = [];
    this.places = [];         // the doctor's: {x, y, number, word}
    this.photographs = [];
    this.goal = null;         // {x, y, fate}, on the map
    this.order = null;        // the same as sent to the base: in the odometry frame, with the order's id
    this.mapFromOdom = null;
  }

  on(what, listener) {
    if (!this.listeners.has(what)) this.listeners.set(what, []);
    this.listeners.get(what).push(listener);
  }

  tell(what) {
    for (const listener of this.listeners.get(what) ?? []) listener();
  }

  takePose(message, came_us) {
    const before = this.robot, kOtherClockUs = 60e6;  // of a recording that is played
    const under_way_us = Math.abs(came_us - message.utime) < kOtherClockUs ? Math.max(came_us - message.utime, 0) : 0;
    if (before && message.utime < before.utime - 5e6) this.trail = [];  // a recording that begins again
    this.robot = { x: message.x_m, y: message.y_m, theta: message.theta_rad, covariance: message.covariance,
      status: message.status, overlap: message.overlap, utime: message.utime, came_us, under_way_us };
    const last = this.trail[this.trail.length - 1];
    if (!last || Math.hypot(message.x_m - last.x, message.y_m - last.y) > 0.03) {
      this.trail.push({ utime: message.utime, x: message.x_m, y: message.y_m });
      if (this.trail.length > 20000) this.trail.splice(0, 10000);
    }
    this.tell("pose");
  }

  // The keyframes moved: what was driven before the newest one lies along them.
  takeTrajectory(message) {
    this.path = message.x_m.map((x, i) => [x, message.y_m[i]]);
    this.pathUtime = message.utimes.length > 0 ? message.utimes[message.utimes.length - 1] : 0;
    this.trail = this.trail.filter((step) => step.utime >= this.pathUtime);
    this.tell("path");
  }

  takeSnapshot(snapshot) {
    this.snapshot = snapshot;
    const places = (path) => (path ?? []).map((pose) => [pose[1], pose[2]]);
    this.path = places(snapshot.path);
    this.livePath = places(snapshot.live_path);
    this.odometry = places(snapshot.odometry);
    this.truth = places(snapshot.truth);
    this.loops = snapshot.loops ?? [];
    this.walls = snapshot.walls ?? [];
    this.photographs = snapshot.photographs ?? [];
    this.places = (snapshot.verdict?.reasons ?? []).map((reason, i) => ({ x: reason.x_m, y: reason.y_m, word: reason.word, number: i + 1 }))
      .filter((place) => Number.isFinite(place.x));
    for (const what of ["path", "walls", "snapshot"]) this.tell(what);
  }

  // BASE_COMMAND is in the odometry frame, and the base keeps to that: on the map the goal moves as the odometry is corrected.
  takeBaseCommand(message) {
    const kGoTo = 4;
    if (message.kind === kGoTo) this.order = { x: message.x_m, y: message.y_m, id: message.id, fate: "running" };
    else if (this.order?.fate === "running" && this.order.id !== message.id) this.order = this.goal = null;
    this.placeGoal();
  }

  takeBaseStatus(message) {
    const kFates = ["none", "running", "done", "shortened", "refused", "aborted"];
    // As C++'s BaseNote: what the guard lacks stands at the end.
    const [, note, , guard] = /^(.*?)((?:^|; )guard: (.*))?$/s.exec(message.note);
    const news = (guard ?? "") !== (this.base?.guard ?? "");
    this.base = { ...message, note, guard: guard ?? "" };
    if (news) this.tell("guard");
    if (this.order?.id === message.command_id) {
      this.order.fate = kFates[message.command] ?? "running";
      if (this.order.fate === "done") this.order = this.goal = null;
      this.placeGoal();
    }
    this.tell("base");
  }

  placeGoal() {
    if (this.order && this.mapFromOdom) {
      const { x, y, theta } = this.mapFromOdom, c = Math.cos(theta), s = Math.sin(theta), { order } = this;
      this.goal = { x: x + c * order.x - s * order.y, y: y + s * order.x + c * order.y, fate: order.fate };
    }
    this.tell("goal");
  }

  takeHead({ pan_rad, tilt_rad }) {
    const kStillRad = 0.01, { head } = this;
    const still = head && Math.abs(pan_rad - head.pan) < kStillRad && Math.abs(tilt_rad - head.tilt) < kStillRad;
    if (!still) this.head = { pan: pan_rad, tilt: tilt_rad, since: performance.now() };
    this.tell("head");
  }

  takeTransforms({ transforms }) {
    for (const { parent_frame_id, child_frame_id, translation, rotation } of transforms) {
      if (parent_frame_id !== "map" || child_frame_id !== "odom") continue;
      this.mapFromOdom = { x: translation.x, y: translation.y, theta: 2 * Math.atan2(rotation.z, rotation.w) };
      if (this.order) this.placeGoal();
    }
  }
}
