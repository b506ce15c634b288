import { el, toast } from "./dom.js";

const kTriesMs = 10000, kAnswerMs = 1000, kAgainMs = 250, kClickMs = 1000;

// The red Stop with its Release, one for the page: an open dialog holds it meanwhile (dom.js). It is sent as soon as the pointer
// is down. Where the robot cannot be reached it says so, and tries for ten seconds.
export class Stop {
  // pressed(): stops what the page itself drives.
  constructor(root, world, robot, pressed) {
    Object.assign(this, { world, robot, pressed });
    this.until = 0;  // tries go on, by performance.now()
    this.said = "";
    let down = -Infinity;  // the click that follows is no second press; one of Enter has no pointer
    this.button = el("button", { type: "button", class: "stop", title: "Stop the robot (Space)", "aria-keyshortcuts": "Space",
      onpointerdown: ({ button, timeStamp }) => { if (button === 0) { down = timeStamp; this.press(); } },
      onclick: ({ detail, timeStamp }) => { if (detail === 0 || timeStamp - down > kClickMs) this.press(); } }, el("span", {}, "Stop"));
    this.release = el("button", { type: "button", class: "release", onclick: () => robot.release() }, "Release");
    this.note = el("p", { class: "stopped", role: "alert" });
    root.append(this.button, this.release, this.note);
    world.on("stop", () => this.say(world.stop.engaged ? "" : this.said));
    this.show();
  }

  show() {
    const { engaged, by } = this.world.stop;
    this.note.textContent = this.said || (engaged ? `Stopped${by ? ` by ${by}` : ""}` : "");
    this.note.hidden = this.note.textContent === "";
    this.release.hidden = !engaged;
    this.button.setAttribute("aria-pressed", String(engaged));
  }

  press() {
    this.pressed();
    this.until = performance.now() + kTriesMs;
    this.send();
  }

  get waits() {
    return performance.now() < this.until;
  }

  async send() {
    clearTimeout(this.again);
    const { until } = this;
    try {
      const { ok, text } = await this.robot.socket.call("stop", { engaged: true }, kAnswerMs);
      if (until !== this.until) return;  // pressed again
      this.until = 0;
      this.say("");
      toast(ok ? "Stop sent" : text, ok ? "done" : "error");
    } catch {
      if (until === this.until) this.goOn();
    }
  }

  goOn() {
    if (!this.waits) return this.say("Stop did NOT reach the robot. Press again, or use the robot's own switch.");
    this.say("The robot is unreachable. Stop will be sent as soon as possible…");
    this.robot.socket.hurry();
    this.again = setTimeout(() => this.send(), kAgainMs);
  }

  say(text) {
    this.said = text;
    this.show();
  }
}
