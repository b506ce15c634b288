// Our Create 2, driven by a library for the real one: npm's `create2` (Pecacheu). It asks for packet group 100, drives by
// speeds, by radius and by PWM, and sends what else a robot has, which must not put the emulator out of step.
// usage: node create2_peer.mjs MARCO_SIM CONFIG_FOLDER
import { execFileSync, spawn } from "node:child_process";
import { closeSync, constants, existsSync, mkdtempSync, openSync, readSync, rmSync, writeSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { Duplex } from "node:stream";

const create2 = createRequire(import.meta.url)("create2");
const kTickMm = (Math.PI * 72) / 508.8;
const kTrackMm = 235;
const kAnswer = 80; // bytes of packet group 100
let checks = 0;

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

function expect(what, value, wanted, tolerance = 0) {
  const good = typeof wanted === "number" ? Math.abs(value - wanted) <= tolerance : value === wanted;
  if (!good) throw new Error(`${what}: got ${value}, wanted ${wanted} +- ${tolerance}`);
  checks += 1;
}

// The library wants a stream; a serial port of its own would bring a driver to compile. It takes whatever came within 8 ms
// for one answer, and forgets the rest when it asks again: a late answer would be read from its middle. So it gets whole ones.
class Port extends Duplex {
  constructor(path) {
    super();
    execFileSync("stty", ["-F", path, "115200", "raw", "-echo"]);
    this.file = openSync(path, constants.O_RDWR | constants.O_NOCTTY | constants.O_NONBLOCK);
    this.come = Buffer.alloc(0);
    this.answers = 0;
    this.timer = setInterval(() => this.look(), 2);
    setImmediate(() => this.emit("open"));
  }
  look() {
    const bytes = Buffer.alloc(4096);
    try {
      const count = readSync(this.file, bytes);
      this.come = Buffer.concat([this.come, bytes.subarray(0, count)]);
    } catch (error) {
      if (error.code !== "EAGAIN") throw error;
    }
    if (this.come.length < kAnswer) return;
    this.push(this.come.subarray(0, kAnswer));
    this.come = this.come.subarray(kAnswer);
    this.answers += 1;
  }
  _read() {}
  _write(bytes, encoding, done) {
    writeSync(this.file, bytes);
    done();
  }
  close() {
    clearInterval(this.timer);
    closeSync(this.file);
  }
}

const folder = mkdtempSync(join(tmpdir(), "create2_peer_"));
const simulator = spawn(process.argv[2], ["--config", `${process.argv[3]}/robots/create.toml`, "--world",
  `${process.argv[3]}/worlds/lab.toml`, "--start", "2", "3", "0", "--ports", folder, "--lcm-url", "memq://"], { stdio: "ignore" });

async function judge() {
  for (let i = 0; i < 300 && !existsSync(`${folder}/base`); ++i) await wait(100);
  const port = new Port(`${folder}/base`);
  const robot = await new Promise((resolve) => create2.open(port, resolve));
  // Version 1.3.2 loses its own object here.
  port.removeAllListeners("data");
  port.on("data", robot.read.bind(robot));

  let asked = 1; // by open()
  const write = robot.write;
  robot.write = (...bytes) => {
    if (bytes.length === 2 && bytes[0] === 142) asked += 1;
    write.apply(robot, bytes);
  };
  let read_last = 0;
  const parse = robot.dataParser;
  robot.dataParser = (bytes) => {
    parse(bytes);
    read_last = port.answers;
  };
  // What it reads behind the orders: two answers on, because it may take two for one.
  const read = async () => {
    const wanted = asked + 2;
    for (let i = 0; i < 1000 && read_last < wanted; ++i) await wait(10);
    if (read_last < wanted) throw new Error(`answer ${read_last} of ${wanted} within 10 s`);
    return { ...robot.data };
  };
  const way = (from, to, name) => ((((to[name] - from[name]) % 65536) + 65536 + 32768) % 65536 - 32768) * kTickMm;
  const driven = async (order) => {
    const from = await read();
    order();
    const start = performance.now();
    await wait(1500);
    robot.driveSpeed(0, 0);
    const seconds = (performance.now() - start) / 1000;
    await wait(500);
    const to = await read();
    return [way(from, to, "encoderLeft"), way(from, to, "encoderRight"), seconds];
  };

  let data = await read();
  expect("passive", data.mode, 1);
  expect("battery [mV]", data.voltage, 15000, 1000);
  for (const name of ["bumpLeft", "bumpRight", "dropLeft", "dropRight", "cliffLeft", "cliffRight", "docked"]) {
    expect(name, data[name], false);
  }
  let [left, right, seconds] = await driven(() => robot.driveSpeed(100, 100));
  expect("passive, it does not drive", Math.abs(left) + Math.abs(right), 0);
  robot.safe();
  expect("safe", (await read()).mode, 2);
  robot.full();
  expect("full", (await read()).mode, 3);

  [left, right, seconds] = await driven(() => robot.driveSpeed(150, 90));
  expect("left wheel goes on [mm]", left, 150 * seconds, 45);
  expect("the right one is slower", right / left, 90 / 150, 0.02);
  [left, right] = await driven(() => robot.driveSpeed(-100, 100));
  expect("on the spot", right / left, -1, 0.03);
  [left, right] = await driven(() => robot.drive(120, 500));
  expect("round a centre on the left", left / right, (500 - kTrackMm / 2) / (500 + kTrackMm / 2), 0.02);
  [left, right] = await driven(() => robot.drive(-120, -500));
  expect("back, round a centre on the right", right / left, (500 - kTrackMm / 2) / (500 + kTrackMm / 2), 0.02);
  expect("backwards", left < -100, true);
  [left, right] = await driven(() => robot.drive(100, -1));
  expect("clockwise on the spot", [Math.sign(left), Math.sign(right)].join(), "1,-1");
  [left, right] = await driven(() => robot.drivePower(60, 30));
  expect("by PWM", left / right, 2, 0.06);

  robot.setLeds(1, 0, 1, 0, 128, 255);
  robot.setFaceLeds(1, 0, 1, 0, 1, 0, 1, 0, 1, 1);
  robot.setDigitsRaw(1, 2, 3, 4);
  robot.setSong(0, [[60, 16], [142, 100], [128, 7]]); // its notes are opcodes
  robot.play(0);
  robot.setMotor("side", 0);
  data = await read();
  expect("in step behind lights, digits and a song", data.mode, 3);
  expect("in step: battery [mV]", data.voltage, 15000, 1000);
  robot.stop();
  port.close();
}

try {
  await judge();
  console.log(`create: ${checks} checks`);
} finally {
  simulator.kill();
  rmSync(folder, { recursive: true, force: true });
}
process.exit(0);
