// A client of Foxglove's WebSocket protocol, JSON only: https://github.com/foxglove/ws-protocol
// It reconnects by itself, and subscribes what was asked for as soon as channels and services are there.
import { keepNewest } from "./frames.js";

const kProtocols = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
const kSilentMs = 5000;  // page/health comes once a second
const kRetryMs = [300, 1000, 2000, 4000];
const kHurriedMs = 1500;
const kCallMs = 15000;
const kAliveMs = 150;  // a goal waits 0.45 s after the last one, and ends after 1 s

export class Socket {
  // told: {state(word), info(serverInfo), services(), status(level, text)}; state is "connecting", "open" or "lost".
  // services(): orders may be given from here on, before anything else is sent.
  constructor(url, told) {
    this.url = url;
    this.told = told;
    this.handlers = new Map();  // topic -> {handler, how}
    this.tries = 0;
    this.state = "connecting";
    this.decoder = new TextDecoder();
    this.encoder = new TextEncoder();
    setInterval(() => this.watch(), 1000);
    setInterval(() => this.send({ op: "alive" }), kAliveMs);
    this.connect();
  }

  connect() {
    this.forget();
    clearTimeout(this.retry);
    this.heard = performance.now();
    this.newest_us = 0;  // when the server had the newest state that was taken
    const socket = this.socket = new WebSocket(this.url, kProtocols);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => {
      this.heard = performance.now();
      if (typeof event.data === "string") this.takeText(JSON.parse(event.data));
      else this.takeBinary(new DataView(event.data));
    };
    socket.onclose = () => this.lose(socket);
  }

  forget() {
    for (const call of this.calls?.values() ?? []) call.reject(new Error("connection lost"));
    this.channels = new Map();       // topic -> id
    this.subscribed = new Map();     // subscription id -> topic
    this.services = new Map();       // name -> id
    this.calls = new Map();          // call id -> {resolve, reject}
    this.published = new Map();      // topic -> own channel id
    this.nextId = 1;
  }

  lose(socket) {
    if (socket !== this.socket) return;
    this.socket = null;
    this.forget();
    this.setState("lost");
    this.retry = setTimeout(() => this.connect(), kRetryMs[Math.min(this.tries++, kRetryMs.length - 1)]);
  }

  // Somebody waits for the connection: a new one is tried at once, also instead of a silent one.
  hurry() {
    this.watch(kHurriedMs);
    if (this.socket === null) this.connect();
  }

  // A network that swallows everything closes nothing.
  watch(most_ms = kSilentMs) {
    const socket = this.socket;
    if (socket === null || performance.now() - this.heard < most_ms) return;
    this.lose(socket);
    socket.onmessage = null;
    socket.close();
  }

  setState(word) {
    if (word === this.state) return;
    this.state = word;
    this.told.state(word);
  }

  takeText(message) {
    switch (message.op) {
      case "serverInfo":
        this.tries = 0;
        this.told.info(message);
        this.setState("open");
        break;
      case "advertise":
        for (const channel of message.channels) if (channel.encoding === "json") this.channels.set(channel.topic, channel.id);
        if (this.services.size > 0) this.subscribeKnown();
        break;
      case "unadvertise":
        for (const [topic, id] of this.channels) if (message.channelIds.includes(id)) this.dropChannel(topic);
        break;
      case "advertiseServices":
        for (const service of message.services) this.services.set(service.name, service.id);
        this.told.services();
        this.subscribeKnown();
        break;
      case "serviceCallFailure":
        this.finish(message.callId, (call) => call.reject(new Error(message.message)));
        break;
      case "status":
        this.told.status(message.level, message.message);
        break;
    }
  }

  dropChannel(topic) {
    this.channels.delete(topic);
    for (const [id, name] of this.subscribed) if (name === topic) this.subscribed.delete(id);
  }

  takeBinary(view) {
    const opcode = view.getUint8(0);
    if (opcode === 1) {
      const topic = this.subscribed.get(view.getUint32(1, true));
      if (this.handlers.has(topic)) this.takeData(topic, view);
    } else if (opcode === 3) {
      const length = view.getUint32(9, true);
      this.finish(view.getUint32(5, true), (call) => call.resolve(this.json(view, 13 + length)));
    }
  }

  takeData(topic, view) {
    const { handler, how } = this.handlers.get(topic), came_us = Number(view.getBigUint64(5, true)) / 1e3, kMessageAt = 13;
    if (how === "raw") handler(view.buffer, kMessageAt);
    else if (how === "each") handler(this.json(view, kMessageAt), came_us);
    else {
      keepNewest(topic, () => {
        this.newest_us = Math.max(this.newest_us, came_us);
        handler(this.json(view, kMessageAt), came_us);
      });
    }
  }

  json(view, offset) {
    return JSON.parse(this.decoder.decode(new Uint8Array(view.buffer, offset)));
  }

  finish(id, how) {
    const call = this.calls.get(id);
    if (call === undefined) return;
    this.calls.delete(id);
    clearTimeout(call.timer);
    how(call);
  }

  // The last handler of a topic counts: handler(message, when the server had it [us]). how: "newest", of a state, once a frame;
  // "each" at once; "raw": handler(bytes, where the text begins).
  subscribe(topic, handler, how = "newest") {
    this.handlers.set(topic, { handler, how });
    this.subscribeKnown();
  }

  unsubscribe(topic) {
    this.handlers.delete(topic);
    for (const [id, name] of this.subscribed) {
      if (name !== topic) continue;
      this.subscribed.delete(id);
      this.send({ op: "unsubscribe", subscriptionIds: [id] });
    }
  }

  subscribeKnown() {
    const taken = new Set(this.subscribed.values());
    const subscriptions = [];
    for (const topic of this.handlers.keys()) {
      const channelId = this.channels?.get(topic);
      if (channelId === undefined || taken.has(topic)) continue;
      const id = this.nextId++;
      this.subscribed.set(id, topic);
      subscriptions.push({ id, channelId });
    }
    if (subscriptions.length > 0) this.send({ op: "subscribe", subscriptions });
  }

  send(message) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(message instanceof Uint8Array ? message : JSON.stringify(message));
    return true;
  }

  // The response; rejects with what the server said, or when nothing comes.
  call(name, request, most_ms = kCallMs) {
    const service = this.services.get(name);
    if (service === undefined) {
      return Promise.reject(new Error(this.state === "open" ? `the server offers no '${name}'` : "not connected"));
    }
    const id = this.nextId++;
    const payload = this.encoder.encode(JSON.stringify(request));
    const message = new Uint8Array(17 + payload.length), view = new DataView(message.buffer);
    view.setUint8(0, 2);
    view.setUint32(1, service, true);
    view.setUint32(5, id, true);
    view.setUint32(9, 4, true);
    message.set(this.encoder.encode("json"), 13);
    message.set(payload, 17);
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => this.finish(id, (call) => call.reject(new Error("no answer"))), most_ms);
      this.calls.set(id, { resolve, reject, timer });
      if (!this.send(message)) this.finish(id, (call) => call.reject(new Error("not connected")));
    });
  }

  // Whether it could be sent.
  publish(topic, schemaName, message) {
    if (!this.published.has(topic)) {
      const id = this.nextId++;
      if (!this.send({ op: "advertise", channels: [{ id, topic, encoding: "json", schemaName }] })) return false;
      this.published.set(topic, id);
    }
    const payload = this.encoder.encode(JSON.stringify(message));
    const frame = new Uint8Array(5 + payload.length), view = new DataView(frame.buffer);
    view.setUint8(0, 1);
    view.setUint32(1, this.published.get(topic), true);
    frame.set(payload, 5);
    return this.send(frame);
  }
}
