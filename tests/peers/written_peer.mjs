// Files of ours and the format's own readers (@mcap/core, @foxglove/rosmsg*): through the index and as a stream, with every
// checksum, each message decoded by the definition that the file carries.
// usage: node written_peer.mjs FILE.mcap...
import { readFileSync } from "node:fs";
import { parse } from "@foxglove/rosmsg";
import { MessageReader as Ros1Reader } from "@foxglove/rosmsg-serialization";
import { MessageReader as Ros2Reader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";

const decompressHandlers = { zstd: (bytes) => decompress(bytes) };
const text = new TextDecoder();

function decoderOf(channel, schema) {
  const definition = text.decode(schema.data);
  if (channel.messageEncoding === "json") {
    if (JSON.parse(definition).type !== "object") throw new Error(`${schema.name}: no JSON schema`);
    return (data) => JSON.parse(text.decode(data));
  }
  const isRos2 = channel.messageEncoding === "cdr";
  const types = parse(definition, { ros2: isRos2 });
  const reader = isRos2 ? new Ros2Reader(types) : new Ros1Reader(types);
  return (data) => reader.readMessage(data);
}

async function check(path) {
  const bytes = readFileSync(path);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const decoders = new Map(), counts = new Map();
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    if (!decoders.has(channel.id)) {
      decoders.set(channel.id, decoderOf(channel, reader.schemasById.get(channel.schemaId)));
    }
    const value = decoders.get(channel.id)(message.data);
    if (typeof value !== "object") throw new Error(`${channel.topic}: not an object`);
    if (message.logTime < last) throw new Error("not in the order of time");
    last = message.logTime;
    counts.set(channel.topic, (counts.get(channel.topic) ?? 0) + 1);
  }
  const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  stream.append(new Uint8Array(bytes));
  let streamed = 0;
  for (let record; (record = stream.nextRecord()); ) streamed += record.type === "Message" ? 1 : 0;
  const indexed = [...counts.values()].reduce((sum, count) => sum + count, 0);
  if (streamed !== indexed || streamed === 0 || !stream.done()) {
    throw new Error(`${streamed} messages in the stream, ${indexed} by the index`);
  }
  return `profile '${reader.header.profile}', ${[...counts].map(([topic, n]) => `${topic} ${n}`).sort().join(", ")}`;
}

for (const path of process.argv.slice(2)) {
  try {
    console.log(`${path}: ${await check(path)}`);
  } catch (failure) {
    console.log(`${path}: FAILED: ${failure.stack}`);
    process.exitCode = 1;
  }
}
