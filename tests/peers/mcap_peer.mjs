// The official reader of MCAP (@mcap/core) and ours on the same files: the same messages, times and bytes.
// usage: node mcap_peer.mjs ROS_DIGEST FILE...
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import lz4 from "lz4js";

const decompressHandlers = {
  zstd: (bytes) => decompress(bytes),
  lz4: (bytes) => lz4.decompress(bytes),
};

const table = Uint32Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; ++bit) byte = byte & 1 ? (byte >>> 1) ^ 0xedb88320 : byte >>> 1;
  return byte;
});

// As zlib's; node has none before version 20.
function crc32(bytes, before) {
  let crc = ~before;
  for (const byte of bytes) crc = (crc >>> 8) ^ table[(crc ^ byte) & 0xff];
  return ~crc >>> 0;
}

function nanoseconds(time) {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setBigInt64(0, time, true);
  return bytes;
}

function digest(path) {
  const reader = new McapStreamReader({ decompressHandlers });
  reader.append(readFileSync(path));
  const schemas = new Map(), channels = new Map(), messages = [];
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type === "Message") messages.push(record);
  }
  messages.sort((a, b) => (a.logTime < b.logTime ? -1 : a.logTime > b.logTime ? 1 : 0));
  const topics = new Map();
  for (const message of messages) {
    const channel = channels.get(message.channelId);
    const type = (schemas.get(channel.schemaId)?.name ?? "").replace("/msg/", "/");
    const key = `${path} ${channel.topic} ${type}`;
    const entry = topics.get(key) ?? { count: 0, crc: 0 };
    entry.count += 1;
    entry.crc = crc32(message.data, crc32(nanoseconds(message.logTime), entry.crc));
    topics.set(key, entry);
  }
  return new Set([...topics].map(([key, e]) => `${key} ${e.count} ${e.crc.toString(16).padStart(8, "0")}`));
}

const [program, ...files] = process.argv.slice(2);
if (files.length === 0) {
  console.log("SKIPPED: no files, MARCO_TEST_DATA is not set");
  process.exit(0);
}
let wrong = 0;
for (const file of files) {
  const lines = execFileSync(program, [file], { encoding: "utf8" }).split("\n").filter(Boolean);
  const ours = new Set(lines.map((line) => line.split(" ").slice(0, -2).join(" ")));
  const theirs = digest(file);
  const differences = [...ours, ...theirs].filter((line) => !(ours.has(line) && theirs.has(line)));
  if (differences.length > 0) console.log(`${file}:\n  ${differences.join("\n  ")}`);
  wrong += differences.length;
}
console.log(`${files.length} files, ${wrong} differences`);
process.exit(wrong === 0 ? 0 : 1);
