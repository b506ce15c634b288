// marco-page against the official client of Foxglove's WebSocket protocol (@foxglove/ws-protocol): under either name of the
// protocol it lists every channel, reads a message of each by the channel's own schema, calls a service, and publishes a goal,
// which is answered: by the odometry of a recording, which is old, nothing drives.
// usage: node foxglove_page.mjs MARCO_PAGE MARCO_SLAM SAMPLE.lcm
import { spawn } from "node:child_process";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { FoxgloveClient } = protocol;
const [page, slam, sample] = process.argv.slice(2);
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const running = [];
const start = (program, ...args) => {
  const child = spawn("timeout", ["120", program, ...args], { stdio: ["ignore", "pipe", "inherit"] });
  running.push(child);
  return child;
};

// What of a value is not as the schema says; "" where all is.
function mismatch(value, schema, path = "") {
  const types = [schema.type ?? []].flat();
  if (types.length === 0) return "";
  const is = (type) =>
    type === "null" ? value === null
    : type === "array" ? Array.isArray(value)
    : type === "object" ? typeof value === "object" && value !== null && !Array.isArray(value)
    : type === "integer" ? Number.isInteger(value)
    : typeof value === type;
  // JSON has no NaN: the server writes null.
  if (!types.some(is) && !(value === null && types.includes("number"))) return `${path}: ${typeof value}, not ${types}`;
  if (Array.isArray(value)) {
    for (const item of value.slice(0, 20)) {
      const found = schema.items ? mismatch(item, schema.items, `${path}[]`) : "";
      if (found) return found;
    }
  } else if (typeof value === "object" && value !== null) {
    for (const [name, item] of Object.entries(value)) {
      if (!schema.properties?.[name]) return `${path}.${name}: not in the schema`;
      const found = mismatch(item, schema.properties[name], `${path}.${name}`);
      if (found) return found;
    }
  }
  return "";
}

async function run(subprotocol) {
  const socket = new WebSocket("ws://127.0.0.1:8765", [subprotocol]);
  const client = new FoxgloveClient({ ws: socket });
  const channels = new Map(), services = new Map(), messages = new Map(), topicOf = new Map(), faults = [];
  let info, answer, refused;
  client.on("serverInfo", (event) => (info = event));
  client.on("advertise", (list) => {
    for (const channel of list) {
      channels.set(channel.topic, channel);
      topicOf.set(client.subscribe(channel.id), channel.topic);
    }
  });
  client.on("advertiseServices", (list) => list.forEach((service) => services.set(service.name, service)));
  client.on("serviceCallResponse", (event) => (answer = JSON.parse(new TextDecoder().decode(event.data))));
  client.on("message", ({ subscriptionId, data }) => {
    const topic = topicOf.get(subscriptionId);
    messages.set(topic, (messages.get(topic) ?? 0) + 1);
    if (messages.get(topic) > 3) return;
    const value = JSON.parse(new TextDecoder().decode(data));
    const found = mismatch(value, JSON.parse(channels.get(topic).schema));
    if (found) faults.push(`${topic}${found}`);
  });
  client.on("status", ({ message }) => (refused ??= /no odometry/.exec(message)?.[0]));
  client.on("error", (error) => faults.push(String(error)));
  await new Promise((resolve) => client.on("open", resolve));
  const player = spawn("lcm-logplayer", ["--speed=3", sample], { stdio: "ignore" });
  const played = new Promise((resolve) => player.on("exit", resolve));
  const goal = client.advertise({ topic: "/goal_pose", encoding: "json", schemaName: "geometry_msgs/PoseStamped" });
  const text = JSON.stringify({ header: { stamp: { sec: 0, nsec: 0 }, frame_id: "map" },
    pose: { position: { x: 1, y: 2, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } } });
  // A goal on the map needs SLAM's pose, which ends with the recording.
  for (let n = 0; n < 100 && !messages.has("/pose"); ++n) await sleep(100);
  await sleep(500);
  client.sendMessage(goal, new TextEncoder().encode(text));
  await played;
  await sleep(2500);
  const service = services.get("slam");
  client.sendServiceCallRequest({ serviceId: service.id, callId: 7, encoding: "json",
    data: new TextEncoder().encode(JSON.stringify({ command: "pause" })) });
  await sleep(1500);
  client.sendServiceCallRequest({ serviceId: service.id, callId: 8, encoding: "json",
    data: new TextEncoder().encode(JSON.stringify({ command: "resume" })) });
  await sleep(300);
  // What the recording and SLAM do not send: pictures, 3D, walls, procman's.
  const silent = [...channels.keys()].filter((topic) => !messages.has(topic)).sort();
  const may = new Set(["/camera", "/log", "/model", "/walls", "page/output"]);
  console.log(`${subprotocol}: ${channels.size} channels, ${messages.size} decoded; silent: ${silent.join(" ") || "none"}; ` +
              `${services.size} services, the goal: ${refused}, slam answers ${JSON.stringify(answer)}`);
  faults.slice(0, 10).forEach((fault) => console.log(`  ${fault}`));
  const good = socket.protocol === subprotocol && info?.metadata?.mode === "live" && faults.length === 0 &&
    channels.size > 20 && silent.every((topic) => may.has(topic)) && refused && answer?.ok === true;
  client.close();
  if (!good) console.log(`FAILED: ${subprotocol}`);
  return good;
}

const server = start(page);
await new Promise((resolve) => server.stdout.once("data", resolve));
start(slam);
await sleep(500);
let good = true;
for (const subprotocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) good = (await run(subprotocol)) && good;
for (const child of running) child.kill("SIGTERM");
process.exit(good ? 0 : 1);
