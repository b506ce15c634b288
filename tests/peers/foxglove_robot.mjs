// A robot of ROS 2 behind the official server of Foxglove's WebSocket protocol (@foxglove/ws-protocol): it sends scans and
// odometry in CDR (@foxglove/rosmsg2-serialization), 40 scans a second, through marco-bridge to marco-slam, and reads
// pose, map, path and transform back. How long a pose takes, and how many are lost.
// usage: node foxglove_robot.mjs MARCO_BRIDGE MARCO_SLAM [SECONDS]
import { spawn } from "node:child_process";
import rosmsg from "@foxglove/rosmsg";
import serialization from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import { WebSocketServer } from "ws";

const { FoxgloveServer } = protocol, { parse } = rosmsg, { MessageReader, MessageWriter } = serialization;
const [bridge, slam, seconds = "12"] = process.argv.slice(2);
const hz = 40, beams = 720, rangeMax = 25;

const parts = {
  "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
  "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
  "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
  "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
  "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
  "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
  "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
  "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
  "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
  "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
  "geometry_msgs/TransformStamped":
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform",
  "nav_msgs/MapMetaData":
    "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\ngeometry_msgs/Pose origin",
};
const wholes = {
  "sensor_msgs/LaserScan":
    "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\n" +
    "float32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\nfloat32[] intensities",
  "nav_msgs/Odometry":
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n" +
    "geometry_msgs/TwistWithCovariance twist",
  "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
  "nav_msgs/OccupancyGrid": "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data",
  "geometry_msgs/PoseStamped": parts["geometry_msgs/PoseStamped"],
  "nav_msgs/Path": "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses",
};
const definition = (type) =>
  [wholes[type], ...Object.entries(parts).map(([name, text]) => `MSG: ${name}\n${text}`)].join(
    `\n${"=".repeat(80)}\n`);
const parsed = (type) => parse(definition(type), { ros2: true });
const writers = new Map(), readers = new Map();
for (const type of Object.keys(wholes)) {
  writers.set(type, new MessageWriter(parsed(type)));
  readers.set(type, new MessageReader(parsed(type)));
}

// A room that is no two ways alike; the robot stands for three seconds, then drives circles.
const walls = [];
function box(x0, y0, x1, y1) {
  walls.push([x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]);
}
box(-3, -2, 4, 4);
box(2, -1.2, 2.7, -0.4);
box(-2.2, 2.6, -1.8, 3.4);
function rangeOf(x, y, bearing) {
  const c = Math.cos(bearing), s = Math.sin(bearing);
  let nearest = Infinity;
  for (const [x0, y0, x1, y1] of walls) {
    const ax = x1 - x0, ay = y1 - y0, bx = x0 - x, by = y0 - y, det = ax * s - ay * c;
    if (Math.abs(det) < 1e-12) continue;
    const range = (ax * by - ay * bx) / det, part = (c * by - s * bx) / det;
    if (range > 0 && part >= 0 && part <= 1) nearest = Math.min(nearest, range);
  }
  return nearest;
}
function poseAt(time) {
  const turned = 0.3 * Math.max(0, time - 3);
  return { x: Math.sin(turned), y: 1 - Math.cos(turned), theta: turned };
}
const quaternion = (theta) => ({ x: 0, y: 0, z: Math.sin(theta / 2), w: Math.cos(theta / 2) });
const stampOf = (time) => ({ sec: Math.floor(time), nanosec: Math.round((time % 1) * 1e6) * 1000 });
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

async function run(subprotocol) {
  const server = new FoxgloveServer({
    name: "robot", capabilities: ["clientPublish"], supportedEncodings: ["cdr"], sessionId: subprotocol });
  const sockets = new WebSocketServer({
    host: "127.0.0.1", port: 0,
    handleProtocols: (offered) => (offered.has(subprotocol) ? subprotocol : false) });
  await new Promise((resolve) => sockets.on("listening", resolve));
  sockets.on("connection", (socket, request) => server.handleConnection(socket, request.url ?? ""));
  const channel = (topic, type) => server.addChannel({
    topic, encoding: "cdr", schemaName: type.replace("/", "/msg/"), schema: definition(type),
    schemaEncoding: "ros2msg" });
  const scan = channel("/scan", "sensor_msgs/LaserScan"), odom = channel("/odom", "nav_msgs/Odometry");
  const place = channel("/tf_static", "tf2_msgs/TFMessage");
  const wanted = new Set();
  server.on("subscribe", (id) => wanted.add(id));

  const sentAt = new Map(), latencies = [], errors = [], count = {};
  let grid, transform, begun = Infinity;
  server.on("message", ({ channel: from, data }) => {
    count[from.topic] = (count[from.topic] ?? 0) + 1;
    const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
    const value = readers.get(from.schemaName.replace("/msg/", "/")).readMessage(bytes);
    if (from.topic === "/map") grid = value;
    if (from.topic === "/tf") transform = value.transforms[0];
    if (from.topic !== "/slam_pose") return;
    const { sec, nanosec } = value.header.stamp, sent = sentAt.get(sec * 1e6 + Math.round(nanosec / 1000));
    if (!sent) return;
    begun = Math.min(begun, sent.number);
    latencies.push(performance.now() - sent.at);
    errors.push(Math.hypot(value.pose.position.x - sent.pose.x, value.pose.position.y - sent.pose.y));
  });

  const url = `ws://127.0.0.1:${sockets.address().port}`;
  const programs = [[bridge, url], [slam]].map(([program, ...args]) =>
    spawn("timeout", ["120", program, ...args], { stdio: ["ignore", "ignore", "inherit"] }));
  for (let i = 0; i < 100 && wanted.size < 3; ++i) await sleep(100);

  const send = (id, type, time, value) =>
    server.sendMessage(id, BigInt(Math.round(time * 1e6)) * 1000n, writers.get(type).writeMessage(value));
  const start = Date.now() / 1000;
  send(place, "tf2_msgs/TFMessage", start, { transforms: [{
    header: { stamp: stampOf(start), frame_id: "base_link" }, child_frame_id: "laser",
    transform: { translation: { x: 0, y: 0, z: 0.2 }, rotation: quaternion(0) } }] });
  const first = performance.now();
  let number = 0;
  for (; number < Number(seconds) * hz; ++number) {
    await sleep(Math.max(0, first + (number * 1000) / hz - performance.now()));
    const time = start + number / hz, pose = poseAt(number / hz), stamp = stampOf(time);
    send(odom, "nav_msgs/Odometry", time, {
      header: { stamp, frame_id: "odom" }, child_frame_id: "base_link",
      pose: { pose: { position: { x: pose.x, y: pose.y, z: 0 }, orientation: quaternion(pose.theta) },
              covariance: new Float64Array(36) },
      twist: { twist: { linear: { x: 0, y: 0, z: 0 }, angular: { x: 0, y: 0, z: 0 } },
               covariance: new Float64Array(36) } });
    const step = (2 * Math.PI) / beams, ranges = new Float32Array(beams);
    for (let i = 0; i < beams; ++i) ranges[i] = rangeOf(pose.x, pose.y, pose.theta - Math.PI + i * step);
    sentAt.set(stamp.sec * 1e6 + Math.round(stamp.nanosec / 1000), { at: performance.now(), pose, number });
    send(scan, "sensor_msgs/LaserScan", time, {
      header: { stamp, frame_id: "laser" }, angle_min: -Math.PI, angle_max: Math.PI - step,
      angle_increment: step, time_increment: 0, scan_time: 1 / hz, range_min: 0.1, range_max: rangeMax,
      ranges, intensities: new Float32Array(0) });
  }
  await sleep(1000);
  for (const program of programs) program.kill("SIGTERM");
  await Promise.all(programs.map((program) => new Promise((done) => program.on("exit", done))));
  for (const socket of sockets.clients) socket.terminate();
  sockets.close();

  latencies.sort((a, b) => a - b);
  errors.sort((a, b) => a - b);
  const at = (values, part) => values[Math.min(values.length - 1, Math.floor(part * values.length))];
  const lost = number - begun - latencies.length;
  const occupied = grid ? grid.data.filter((cell) => cell > 65).length : 0;
  console.log(
    `${subprotocol}: ${number} scans at ${hz} Hz, the first ${begun} while the bridge looked; ` +
    `${latencies.length} poses, ${lost} lost; latency ${at(latencies, 0.5)?.toFixed(1)} ms in the median, ` +
    `${at(latencies, 0.95)?.toFixed(1)} ms in 95 of 100, ${at(latencies, 1)?.toFixed(1)} ms at most; error of the pose ` +
    `${(1000 * at(errors, 0.5))?.toFixed(0)} mm in the median; ${count["/map"] ?? 0} maps (${occupied} cells occupied), ` +
    `${count["/marco/path"] ?? 0} paths, ${count["/tf"] ?? 0} transforms`);
  // Half a second at most at the end of the drive waits for its odometry; the rest is to come, and soon.
  const good = lost <= hz / 2 && latencies.length > 100 && at(latencies, 0.5) < 200 && at(errors, 0.5) < 0.05 &&
    occupied > 100 && transform?.header.frame_id === "map" && transform?.child_frame_id === "odom" &&
    count["/marco/path"] > 0;
  if (!good) console.log(`FAILED: ${subprotocol}`);
  return good;
}

let good = true;
for (const subprotocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) good = (await run(subprotocol)) && good;
process.exit(good ? 0 : 1);
