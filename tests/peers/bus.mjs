// LCM on the network without LCM, for tests of programs as a whole: messages as objects, by the .lcm files of the project.
import dgram from "node:dgram";
import { readdirSync, readFileSync } from "node:fs";

const kWidths = { int8_t: 1, byte: 1, boolean: 1, int16_t: 2, int32_t: 4, float: 4, int64_t: 8, double: 8 };
const kReads = { int8_t: "readInt8", byte: "readUInt8", boolean: "readUInt8", int16_t: "readInt16BE", int32_t: "readInt32BE", float: "readFloatBE", double: "readDoubleBE" };
const kFragment = 60000;
const to64 = (value) => BigInt.asIntN(64, value);

// Types of plain members: {name: [{name, type, sizes: [text]}]}.
function readTypes(folders) {
  const types = {};
  for (const file of folders.flatMap((folder) => readdirSync(folder).map((name) => `${folder}/${name}`))) {
    const source = readFileSync(file, "utf8").replace(/\/\/.*|\/\*[^]*?\*\//g, "");
    const [, name, body] = source.match(/struct\s+(\w+)\s*\{([^]*)\}/);
    types[name] = [...body.matchAll(/^\s*(?!const)(\w+)\s+(\w+)((?:\[\w+\])*);/gm)]
      .map(([, type, member, sizes]) => ({ type, name: member, sizes: [...sizes.matchAll(/\w+/g)].map(([size]) => size) }));
  }
  return types;
}

// As lcm-gen counts it.
function fingerprintOf(members) {
  const add = (hash, value) => to64(((hash << 8n) ^ (hash >> 55n)) + BigInt(value));
  const addText = (hash, text) => Buffer.from(text).reduce((sum, byte) => add(sum, (byte << 24) >> 24), add(hash, text.length));
  let hash = 0x12345678n;
  for (const { name, type, sizes } of members) {
    hash = add(addText(addText(hash, name), type), sizes.length);
    for (const size of sizes) hash = addText(add(hash, /^\d/.test(size) ? 0 : 1), size);
  }
  return to64((hash << 1n) + ((hash >> 63n) & 1n));
}

export class Bus {
  // address: of LCM_DEFAULT_URL
  constructor(project, address = process.env.LCM_DEFAULT_URL ?? "udpm://239.255.76.67:7667") {
    this.types = readTypes([`${project}/lcmtypes/marco`, `${project}/lcm_tools/lcmtypes/marco`]);
    [, this.group, this.port] = address.match(/\/\/([\d.]+):(\d+)/);
    this.number = 0;
    this.heard = new Map();  // channel -> function(message, [ms] of performance.now())
    this.link = dgram.createSocket({ type: "udp4", reuseAddr: true, recvBufferSize: 4 << 20 });
    this.link.on("message", (data) => this.take(data, performance.now()));
  }

  open() {
    return new Promise((opened) => this.link.bind(Number(this.port), () => {
      this.link.addMembership(this.group);
      this.link.setMulticastTTL(0);
      opened();
    }));
  }

  close() {
    this.link.close();
  }

  on(channel, type, listener) {
    this.heard.set(channel, (payload, at) => listener(this.decoded(type, payload), at));
  }

  // Messages of one datagram: orders are such.
  take(data, at) {
    if (data.toString("latin1", 0, 4) !== "LC02") return;
    const end = data.indexOf(0, 8);
    this.heard.get(data.toString("latin1", 8, end))?.(data.subarray(end + 1), at);
  }

  send(channel, type, message) {
    this.publish(channel, this.encoded(type, message));
  }

  publish(channel, payload) {
    const name = Buffer.from(`${channel}\0`), number = ++this.number >>> 0;
    const datagram = (magic, size, parts) => {
      const head = Buffer.alloc(size);
      head.write(magic);
      head.writeUInt32BE(number, 4);
      return [head, ...parts];
    };
    if (payload.length < kFragment) return this.link.send(datagram("LC02", 8, [name, payload]), Number(this.port), this.group);
    const count = Math.ceil((payload.length + name.length) / kFragment), whole = Buffer.concat([name, payload]);
    for (let i = 0; i < count; ++i) {
      const parts = datagram("LC03", 20, [whole.subarray(i * kFragment, (i + 1) * kFragment)]);
      parts[0].writeUInt32BE(payload.length, 8);
      parts[0].writeUInt32BE(i === 0 ? 0 : i * kFragment - name.length, 12);
      parts[0].writeUInt16BE(i, 16);
      parts[0].writeUInt16BE(count, 18);
      this.link.send(parts, Number(this.port), this.group);
    }
  }

  encoded(type, message) {
    const members = this.types[type], parts = [Buffer.alloc(8)];
    parts[0].writeBigInt64BE(fingerprintOf(members));
    for (const member of members) {
      const flat = member.sizes.length === 0 ? [message[member.name]] : message[member.name].flat(Infinity);
      parts.push(...(member.type === "string" ? flat.map(text32) : [numbers(member.type, flat)]));
    }
    return Buffer.concat(parts);
  }

  // Without arrays: what orders are made of.
  decoded(type, payload) {
    const message = {};
    let at = 8;
    for (const { name, type: kind, sizes } of this.types[type]) {
      if (sizes.length > 0) break;
      if (kind === "string") {
        const length = payload.readInt32BE(at);
        message[name] = payload.toString("utf8", at + 4, at + 3 + length);
        at += 4 + length;
      } else {
        message[name] = kind === "int64_t" ? Number(payload.readBigInt64BE(at)) : payload[kReads[kind]](at);
        at += kWidths[kind];
      }
    }
    return message;
  }
}

function text32(text) {
  const out = Buffer.alloc(5 + Buffer.byteLength(text));
  out.writeInt32BE(out.length - 4);
  out.write(text, 4);
  return out;
}

function numbers(type, values) {
  const width = kWidths[type], out = Buffer.alloc(width * values.length);
  values.forEach((value, i) => {
    if (type === "int64_t") out.writeBigInt64BE(BigInt(Math.round(value)), width * i);
    else out[kReads[type].replace("read", "write")](Number(value), width * i);
  });
  return out;
}
