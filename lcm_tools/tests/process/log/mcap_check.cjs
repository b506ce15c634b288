// Reads an MCAP file with the format's own library, through the index and as a stream, and prints
// what it found as JSON. Exit code 77: the library, or fzstd, is not installed (NODE_PATH says where they are).
const fs = require('node:fs');

let mcap, fzstd;
try {
  mcap = require('@mcap/core');
  fzstd = require('fzstd');
} catch {
  process.exit(77);
}

const decompressHandlers = { zstd: (bytes) => fzstd.decompress(bytes) };

async function main(path) {
  const bytes = fs.readFileSync(path);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
  const reader = await mcap.McapIndexedReader.Initialize({ readable, decompressHandlers });
  const text = new TextDecoder();
  const topics = {};
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const topic = reader.channelsById.get(message.channelId).topic;
    topics[topic] = (topics[topic] ?? 0) + 1;
    JSON.parse(text.decode(message.data));
  }
  const schemas = [];
  for (const schema of reader.schemasById.values()) {
    if (JSON.parse(text.decode(schema.data)).type === 'object') schemas.push(schema.name);
  }
  const stream = new mcap.McapStreamReader({ validateCrcs: true, decompressHandlers });
  stream.append(new Uint8Array(bytes));
  let streamed = 0;
  for (let record; (record = stream.nextRecord()); ) {
    if (record.type === 'Message') ++streamed;
  }
  console.log(JSON.stringify({ topics, schemas, streamed, whole: stream.done() }));
}

main(process.argv[2]).catch((failure) => {
  console.error(failure);
  process.exit(1);
});
