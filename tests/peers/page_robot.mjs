// A robot for the page's tests: the server's side of the contract between page and marco-page, without LCM. It drives in four
// rooms, sees what its laser sees, obeys and counts what it was told, tells who subscribes what was said last, and can be cut
// off, held where it is, muted on a channel, deaf to a client, made read-only or hostile.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { deflateSync, crc32 } from "node:zlib";
import { WebSocketServer } from "ws";

const resolution = 0.05, tileCells = 64, hz = 20;
// x0, y0, x1, y1 [m]
const walls = [[-6, -4, 6, -4], [6, -4, 6, 4], [6, 4, -6, 4], [-6, 4, -6, -4], [0, -4, 0, -1], [0, 1, 0, 4], [-6, 0.5, -2, 0.5], [2, -0.5, 6, -0.5], [3, 2, 4, 2], [4, 2, 4, 3]];

function range(x, y, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  let best = 30;
  for (const [x0, y0, x1, y1] of walls) {
    const [ex, ey] = [x1 - x0, y1 - y0], det = c * ey - s * ex;
    if (Math.abs(det) < 1e-9) continue;
    const t = ((x0 - x) * ey - (y0 - y) * ex) / det, u = ((x0 - x) * s - (y0 - y) * c) / det;
    if (t > 0 && u >= -1e-9 && u <= 1 + 1e-9) best = Math.min(best, t);
  }
  return best;
}

function png(cells, width, height) {
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]), out = Buffer.alloc(8 + body.length);
    out.writeUInt32BE(data.length);
    body.copy(out, 4);
    out.writeUInt32BE(crc(body), 4 + body.length);
    return out;
  };
  const head = Buffer.alloc(13), rows = Buffer.alloc(height * (width + 1));
  head.writeUInt32BE(width);
  head.writeUInt32BE(height, 4);
  head[8] = 8;
  for (let y = 0; y < height; ++y) cells.copy(rows, y * (width + 1) + 1, y * width, (y + 1) * width);
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]).toString("base64");
}
const crcTable = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xEDB88320 ^ (n >>> 1) : n >>> 1;
  return n;
});
const crc = crc32 ?? ((bytes) => (bytes.reduce((sum, byte) => crcTable[(sum ^ byte) & 255] ^ (sum >>> 8), 0xFFFFFFFF) ^ 0xFFFFFFFF) >>> 0);

const channels = ["SLAM_POSE", "TRAJECTORY", "LOOP_CLOSURES", "BASE_COMMAND", "BASE_STATUS", "PANTILT_STATE", "LINE_MAP", "MESH", "/tf", "page/tiles", "page/scan", "page/health", "page/commands", "page/output", "page/stop", "page/goal"];
const services = ["slam", "go", "head", "stop", "procman", "record", "end_goal", "time"];
const types = { html: "text/html", css: "text/css", js: "text/javascript" };

// Messages of MESH: a floor of 12 m by 8 m in strips, each of so many triangles.
export function modelTiles(revision, tiles, triangles) {
  const columns = triangles / 2, width_m = 8 / tiles, x = (i) => Number((12 * i / columns - 6).toFixed(4));
  return Array.from({ length: tiles }, (_, tile) => {
    const y = (row) => Number((width_m * (tile + row) - 4).toFixed(4)), vertices_m = [], indices = [];
    for (let i = 0; i <= columns; ++i) for (const row of [0, 1]) vertices_m.push([x(i), y(row), Number((0.1 * Math.sin(i / 9)).toFixed(4))]);
    for (let i = 0; i < columns; ++i) indices.push([2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]);
    return { utime: 1e15, revision, tile, tiles, num_vertices: vertices_m.length, vertices_m, normals: vertices_m.map(() => [0, 0, 1]), num_triangles: triangles, triangles: indices };
  });
}

export class PageRobot {
  // page: the folder web/page. three: the file of three.js, or nothing.
  constructor(page, { readOnly = false, hostile = false, three = null, port = 0 } = {}) {
    Object.assign(this, { page, readOnly, hostile, three, port, told: [], velocities: [], tiles: new Map(), changed: new Set(), last: new Map(), clients: new Set(), now: 1e15, path: [], loops: [] });
    Object.assign(this, { x: -3, y: -2, theta: 0.3, v: 0, w: 0, goal: null, commandId: 0, fate: 0, held: false, engaged: false, recording: false, tilt: 0, firsts: [] });
  }

  async start() {
    this.http = createServer((request, response) => this.serve(request, response));
    this.sockets = new WebSocketServer({ server: this.http, handleProtocols: (offered) => [...offered][0] });
    this.sockets.on("connection", (socket) => this.greet(socket));
    await new Promise((resolve) => this.http.listen(this.port, "127.0.0.1", resolve));
    this.port = this.http.address().port;
    this.timer = setInterval(() => this.step(), 1000 / hz);
    return `http://127.0.0.1:${this.port}/`;
  }

  async stop() {
    clearInterval(this.timer);
    this.sockets.clients.forEach((client) => client.terminate());
    this.http.closeAllConnections();
    await new Promise((resolve) => this.http.close(resolve));
  }

  async serve(request, response) {
    const path = new URL(request.url, "http://x").pathname, name = path === "/" ? "index.html" : path.replace(/^\/page\//, "");
    const file = name === "three.js" ? this.three : /^[a-z0-9_]+\.(html|css|js)$/.test(name) ? `${this.page}/${name}` : null;
    const content = file ? await readFile(file).catch(() => null) : null;
    response.writeHead(content ? 200 : 404, { "content-type": types[name.split(".").pop()] ?? "text/plain",
      "content-security-policy": "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self' ws: data: blob:" });
    response.end(content ?? "not found");
  }

  greet(socket) {
    const client = { socket, subscriptions: new Map(), topics: new Map() };
    this.clients.add(client);
    socket.on("close", () => this.clients.delete(client));
    socket.on("message", (data, binary) => {
      if (client.isDeaf) return;
      if (!client.hasSpoken) this.firsts.push(binary ? services[data.readUInt32LE(1) - 1] : JSON.parse(data).op);
      client.hasSpoken = true;
      if (binary) this.takeBinary(client, data);
      else this.takeText(client, JSON.parse(data));
    });
    const say = (message) => socket.send(JSON.stringify(message));
    say({ op: "serverInfo", name: "marco-page", capabilities: ["clientPublish", "services"], supportedEncodings: ["json"], sessionId: String(process.pid),
      metadata: { marco: "0", mode: "live", read_only: String(this.readOnly), name: "Test robot" } });
    say({ op: "advertise", channels: channels.map((topic, i) => ({ id: i + 1, topic, encoding: "json", schemaName: topic, schema: "{}", schemaEncoding: "jsonschema" })) });
    say({ op: "advertiseServices", services: services.map((name, i) => ({ id: i + 1, name, type: name, request: { encoding: "json" }, response: { encoding: "json" } })) });
  }

  takeText(client, message) {
    if (message.op === "subscribe") {
      for (const { id, channelId } of message.subscriptions) {
        client.subscriptions.set(channels[channelId - 1], id);
        const topic = channels[channelId - 1];
        if (topic === "page/tiles") this.sendTiles(client, [...this.tiles.keys()]);
        if (this.last.has(topic)) this.publish(topic, this.last.get(topic), client);
      }
    }
    if (message.op === "advertise") for (const { id, topic } of message.channels) client.topics.set(id, topic);
  }

  takeBinary(client, data) {
    if (data[0] === 1) {
      const message = JSON.parse(data.subarray(5));
      if (client.topics.get(data.readUInt32LE(1)) !== "/cmd_vel" || this.engaged || this.readOnly) return;
      [this.v, this.w, this.heardAt] = [message.linear.x, message.angular.z, Date.now()];
      if (this.v !== 0 || this.w !== 0) this.endGoal("somebody is driving manually");
      this.velocities.push({ v: this.v, w: this.w, at: this.heardAt });
    }
    if (data[0] !== 2) return;
    const service = services[data.readUInt32LE(1) - 1], call = data.readUInt32LE(5), request = JSON.parse(data.subarray(13 + data.readUInt32LE(9)));
    if (service !== "time") this.told.push({ service, ...request });
    if (this.readOnly && !["stop", "time"].includes(service)) {
      return client.socket.send(JSON.stringify({ op: "serviceCallFailure", serviceId: data.readUInt32LE(1), callId: call, message: "read-only" }));
    }
    const answer = Buffer.from(JSON.stringify(this.obey(service, request))), head = Buffer.alloc(17);
    head[0] = 3;
    data.copy(head, 1, 1, 9);
    head.writeUInt32LE(4, 9);
    head.write("json", 13);
    client.socket.send(Buffer.concat([head, answer]));
  }

  obey(service, request) {
    if (service === "stop") {
      this.engaged = request.engaged;
      [this.v, this.w] = [0, 0];
      this.endGoal("stopped");
      this.publish("page/stop", { engaged: this.engaged, by: "the page" });
      return { ok: true, text: "sent" };
    }
    if (service === "go") {
      this.goal = [request.x_m, request.y_m];
      [this.fate, this.commandId] = [1, this.commandId + 1];
      this.publish("page/goal", { active: true, text: "", x_m: request.x_m, y_m: request.y_m });
      return { ok: true, text: "on the way" };
    }
    if (service === "time") return { utime: 1000 * Date.now() };
    if (service === "end_goal") this.endGoal("ordered in the browser");
    if (service === "head") this.tilt = request.tilt_rad;
    if (service === "record") this.recording = request.on;
    if (service === "slam" && request.command === "save") return { ok: true, text: "saved", path: `/home/robot/maps/${request.folder}` };
    if (service === "slam" && request.command === "reset") {
      this.tiles.clear();
      this.path = [];
      this.loops = [];
      this.publish("page/tiles", { revision: 0, resolution_m: resolution, tiles: [], clear: true });
    }
    if (service === "slam" && request.command === "extend") return { ok: false, text: `${request.folder}: no map there`, path: "" };
    return { ok: true, text: `${request.command ?? service}: done` };
  }

  publish(topic, message, only = null) {
    if (this.muted === topic) return;
    if (topic !== "page/tiles") this.last.set(topic, message);
    const payload = Buffer.from(JSON.stringify(message));
    for (const client of only ? [only] : this.clients) {
      const id = client.subscriptions.get(topic);
      if (id === undefined || client.isDeaf) continue;
      const head = Buffer.alloc(13);
      head[0] = 1;
      head.writeUInt32LE(id, 1);
      head.writeBigUInt64LE(BigInt(Date.now()) * 1000000n, 5);
      client.socket.send(Buffer.concat([head, payload]));
    }
  }

  step() {
    const dt = 1 / hz;
    this.now += 1e6 * dt;
    this.ticks = (this.ticks ?? 0) + 1;
    if (!this.goal && Date.now() - (this.heardAt ?? 0) > 500) [this.v, this.w] = [0, 0];
    if (this.goal && !this.held) this.steer();
    if (range(this.x, this.y, this.theta) > 0.4 || this.v <= 0) {
      this.x += this.v * dt * Math.cos(this.theta);
      this.y += this.v * dt * Math.sin(this.theta);
    }
    this.theta += this.w * dt;
    this.look();
    const pose = { utime: this.now, x_m: this.x, y_m: this.y, theta_rad: this.theta, covariance: [[0.004, 0.001, 0], [0.001, 0.002, 0], [0, 0, 1e-4]], status: 0, overlap: 0.9 };
    this.publish("SLAM_POSE", pose);
    if (this.ticks % 10 === 0) {
      this.sendTiles(null, [...this.changed]);
      this.changed.clear();
      this.path.push([this.now, this.x, this.y, this.theta]);
      this.publish("TRAJECTORY", { utime: this.now, revision: this.ticks, num_poses: this.path.length, utimes: this.path.map((p) => p[0]), x_m: this.path.map((p) => p[1]), y_m: this.path.map((p) => p[2]), theta_rad: this.path.map((p) => p[3]) });
      this.publish("LOOP_CLOSURES", { utime: this.now, revision: this.ticks, num_loops: this.loops.length, ends_m: this.loops });
      this.publish("/tf", { transforms: [{ parent_frame_id: "map", child_frame_id: "odom", translation: { x: 0, y: 0, z: 0 }, rotation: { x: 0, y: 0, z: 0, w: 1 } }] });
      this.publish("PANTILT_STATE", { utime: this.now, pan_rad: 0, tilt_rad: this.tilt });
      this.publish("BASE_STATUS", { utime: this.now, base: "test", link: 2, command_id: this.commandId, command: this.fate, motors_on: true, battery_v: [12.4], bumpers: [], note: "" });
    }
    if (this.ticks % hz === 0) this.tellHealth();
  }

  endGoal(why) {
    if (!this.goal) return;
    [this.v, this.w, this.goal, this.fate] = [0, 0, null, 2];
    this.publish("page/goal", { active: false, text: why });
  }

  steer() {
    const [dx, dy] = [this.goal[0] - this.x, this.goal[1] - this.y], turn = Math.atan2(dy, dx) - this.theta, error = Math.atan2(Math.sin(turn), Math.cos(turn));
    this.w = Math.min(Math.max(4 * error, -1.5), 1.5);
    this.v = Math.abs(error) < 0.2 ? 0.8 : 0;
    if (Math.hypot(dx, dy) < 0.1) this.endGoal("there");
  }

  look() {
    const x_m = [], y_m = [];
    for (let i = 0; i < 361; ++i) {
      const angle = this.theta + (i - 180) * Math.PI / 240, far = range(this.x, this.y, angle);
      x_m.push(Number((this.x + far * Math.cos(angle)).toFixed(3)));
      y_m.push(Number((this.y + far * Math.sin(angle)).toFixed(3)));
      for (let d = 0; d < far; d += 0.7 * resolution) this.see(this.x + d * Math.cos(angle), this.y + d * Math.sin(angle), 0);
      this.see(this.x + far * Math.cos(angle), this.y + far * Math.sin(angle), 100);
    }
    this.publish("page/scan", { utime: this.now, x_m, y_m });
  }

  see(x, y, percent) {
    const [cx, cy] = [Math.floor(x / resolution + 1e-6), Math.floor(y / resolution + 1e-6)], [tx, ty] = [Math.floor(cx / tileCells), Math.floor(cy / tileCells)], key = `${tx} ${ty}`;
    if (!this.tiles.has(key)) this.tiles.set(key, Buffer.alloc(tileCells * tileCells, 255));
    const cells = this.tiles.get(key), at = (cy - ty * tileCells) * tileCells + cx - tx * tileCells;
    const now = percent === 100 ? 100 : cells[at] === 100 ? 100 : 0;
    if (cells[at] !== now) this.changed.add(key);
    cells[at] = now;
  }

  sendTiles(only, keys) {
    if (keys.length === 0) return;
    const tiles = keys.map((key) => {
      const [tx, ty] = key.split(" ").map(Number);
      return { x_m: tx * tileCells * resolution, y_m: ty * tileCells * resolution, width: tileCells, height: tileCells, png: png(this.tiles.get(key), tileCells, tileCells) };
    });
    this.publish("page/tiles", { revision: this.ticks, resolution_m: resolution, tiles }, only);
  }

  tellHealth() {
    const evil = this.hostile ? "<img src=x onerror=\"window.hacked=1\"><script>window.hacked=1</script>" : "";
    this.publish("page/health", { utime: this.now, programs: [{ name: `marco-slam${evil}`, state: "ok", text: `40 scans/s ${evil}`, age_s: 0.4 }, { name: "marco-sick", state: "ok", text: "37.5 scans/s", age_s: 0.2 },
      { name: "marco-camera", state: "silent", text: "", age_s: 12 }],
      channels: [{ name: "LIDAR", type: "bot_core.planar_lidar_t", hz: 37.5, lost: 0, age_s: 0 }, { name: "SLAM_POSE", type: "marco.slam_pose_t", hz: 37.5, lost: 2, age_s: 0 }, { name: `ODOMETRY${evil}`, type: "marco.odometry_t", hz: 9.8, lost: 0, age_s: 0 }],
      findings: [{ severity: "warning", text: `marco-camera has been silent for 12 s${evil}`, remedy: "Look at its output under Programs, and start it again." }], battery_v: [12.4], latency_ms: 38, clients: this.clients.size, refused: 0, dropped: 0 });
    const command = (name, state) => ({ name, group: name.startsWith("marco-s") ? "mapping" : "devices", host: "robot", state, exec: `${name} --config x.toml` });
    this.publish("page/commands", { deputies: ["robot"], commands: [command(`marco-slam${evil}`, "running"), command("marco-sick", "running"), command("marco-camera", "failed"), command("logger", this.recording ? "running" : "stopped")] });
    this.publish("page/output", { command: "marco-camera", text: `/dev/video0: no such device${evil}\n` });
    this.publish("page/stop", { engaged: this.engaged, by: "the page" });
  }
}

// By hand: node page_robot.mjs [PORT], and the address in a browser.
if (process.argv[1] === new URL(import.meta.url).pathname) {
  const robot = new PageRobot(new URL("../../web/page", import.meta.url).pathname, { three: "/usr/share/javascript/three/three.min.js", port: Number(process.argv[2] ?? 8080) });
  console.log(await robot.start());
}
