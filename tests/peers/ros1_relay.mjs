// The official server of Foxglove's WebSocket protocol in front of a graph of ROS 1: what foxglove_bridge, which Debian does
// not have, does on a robot. Frames on standard input and output: u32 of what follows, u32 of the head, the head in JSON,
// the message's bytes. In: {topic, type, schema} announces a topic, {topic, ns} a message. Out: {port}, then for each
// message that a client publishes {topic, type}.
import protocol from "@foxglove/ws-protocol";
import { WebSocketServer } from "ws";

const server = new protocol.FoxgloveServer({
  name: "ros1", capabilities: ["clientPublish"], supportedEncodings: ["ros1"], sessionId: "1" });
const sockets = new WebSocketServer({
  host: "127.0.0.1", port: 0,
  handleProtocols: (offered) => (offered.has("foxglove.websocket.v1") ? "foxglove.websocket.v1" : false) });
sockets.on("connection", (socket, request) => server.handleConnection(socket, request.url ?? ""));

function say(head, bytes = Buffer.alloc(0)) {
  const text = Buffer.from(JSON.stringify(head)), sizes = Buffer.alloc(8);
  sizes.writeUInt32LE(4 + text.length + bytes.length, 0);
  sizes.writeUInt32LE(text.length, 4);
  process.stdout.write(Buffer.concat([sizes, text, bytes]));
}
sockets.on("listening", () => say({ port: sockets.address().port }));
server.on("message", ({ channel, data }) => say(
  { topic: channel.topic, type: channel.schemaName }, Buffer.from(data.buffer, data.byteOffset, data.byteLength)));

const channels = new Map();
let held = Buffer.alloc(0);
process.stdin.on("data", (more) => {
  held = Buffer.concat([held, more]);
  while (held.length >= 4 && held.length >= 4 + held.readUInt32LE(0)) {
    const frame = held.subarray(4, 4 + held.readUInt32LE(0));
    held = held.subarray(4 + frame.length);
    const at = 4 + frame.readUInt32LE(0), head = JSON.parse(frame.subarray(4, at).toString());
    if (head.schema === undefined) {
      server.sendMessage(channels.get(head.topic), BigInt(head.ns), new Uint8Array(frame.subarray(at)));
    } else {
      channels.set(head.topic, server.addChannel({
        topic: head.topic, encoding: "ros1", schemaName: head.type, schema: head.schema }));
    }
  }
});
process.stdin.on("end", () => process.exit(0));
