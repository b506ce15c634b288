import { toast } from "./dom.js";
import { takeKept } from "./frames.js";
import { kRefusedS, Late } from "./late.js";

// What the page orders and receives. One for the page.
export class Robot {
  constructor(socket, world, tiles) {
    this.socket = socket;
    this.world = world;
    this.late = new Late(socket, world);
    socket.subscribe("page/tiles", (message) => {
      // With tiles it is the whole map, for a new subscriber.
      if (message.clear && message.tiles.length === 0) {
        takeKept();
        world.reset();
      }
      tiles.take(message).catch((fault) => console.warn("a tile cannot be drawn:", fault));
    }, "each");
    socket.subscribe("SLAM_POSE", (message, came_us) => world.takePose(message, came_us));
    socket.subscribe("TRAJECTORY", (message) => world.takeTrajectory(message));
    socket.subscribe("LINE_MAP", (message) => {
      world.walls = message.ends_m;
      world.tell("walls");
    });
    socket.subscribe("LOOP_CLOSURES", (message) => {
      world.loops = message.ends_m;
      world.tell("path");
    });
    socket.subscribe("page/scan", (message) => {
      world.scan = message;
      world.tell("scan");
    });
    socket.subscribe("BASE_COMMAND", (message) => world.takeBaseCommand(message), "each");
    socket.subscribe("BASE_STATUS", (message) => world.takeBaseStatus(message));
    socket.subscribe("PANTILT_STATE", (message) => world.takeHead(message));
    socket.subscribe("/tf", (message) => world.takeTransforms(message), "each");
    for (const [topic, field] of [["page/health", "health"], ["page/commands", "commands"], ["page/stop", "stop"]]) {
      socket.subscribe(topic, (message) => {
        world[field] = message;
        world.tell(field);
      }, topic === "page/stop" ? "each" : "newest");
    }
    socket.subscribe("page/output", ({ command, text }) => this.takeOutput(command, text), "each");
    socket.subscribe("page/goal", (message) => this.takeGoal(message), "each");
  }

  // Of any browser.
  takeGoal({ active, text, x_m, y_m }) {
    const { world } = this;
    if (world.goal && !active && text && text !== "there") toast(`The drive ended: ${text}`, "error");
    world.goal = active && x_m !== undefined ? { x: x_m, y: y_m, fate: "running" } : null;
    world.tell("goal");
  }

  takeOutput(command, text) {
    const kMost = 500, { output } = this.world;
    if (!output.has(command)) output.set(command, []);
    const lines = output.get(command);
    lines.push(...text.replace(/\n$/, "").split("\n"));
    if (lines.length > kMost) lines.splice(0, lines.length - kMost);
    this.world.tell("output");
  }

  // The response, or null; what went wrong is said.
  async order(service, request, told) {
    try {
      const response = await this.socket.call(service, request);
      if (response.ok) toast(told ? told(response) : response.text, "done");
      else toast(response.text || "refused", "error");
      return response;
    } catch (fault) {
      toast(`${service}: ${fault.message}`, "error");
      return null;
    }
  }

  slam(command, more = {}) {
    const request = { command, folder: "", x_m: 0, y_m: 0, theta_rad: 0, ...more };
    return this.order("slam", request, (response) => [response.text, response.path].filter((text) => text).join(": "));
  }

  async goTo(x_m, y_m) {
    const { world } = this;
    if (this.late.pose_s > kRefusedS) return toast(`Not sent: the robot's position is ${this.late.pose_s.toFixed(0)} s old.`, "error");
    world.order = null;
    world.goal = { x: x_m, y: y_m, fate: "asked" };
    world.tell("goal");
    const response = await this.order("go", { x_m, y_m });
    if (!response?.ok && world.goal?.fate === "asked") {
      world.goal = null;
      world.tell("goal");
    }
  }

  // Stops it, not latched.
  endGoal() {
    if (["asked", "running"].includes(this.world.goal?.fate)) this.order("end_goal", {});
  }

  release() {
    return this.order("stop", { engaged: false }, () => "Released");
  }

  // Nobody steers by what is old.
  refusesToDrive() {
    const { steering_s } = this.late, now = performance.now();
    if (steering_s < kRefusedS) return false;
    if (now - (this.refusedAt ?? -Infinity) > 3000) toast(`Not driven: the picture is ${steering_s.toFixed(0)} s old.`, "error");
    this.refusedAt = now;
    return true;
  }

  velocity(v, w) {
    const zero = { x: 0, y: 0, z: 0 };
    this.socket.publish("/cmd_vel", "geometry_msgs/Twist", { linear: { ...zero, x: v }, angular: { ...zero, z: w } });
  }
}
