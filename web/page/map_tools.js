import { metres } from "./dom.js";

// A mark with a text next to it, on the screen.
function label(context, x, y, text, colors) {
  context.font = "600 14px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  const width = context.measureText(text).width + 16;
  context.fillStyle = colors["--surface"];
  context.beginPath();
  context.rect(x - width / 2, y - 13, width, 26);
  context.fill();
  context.fillStyle = colors["--accent"];
  context.fillText(text, x, y + 1);
}

function line(context, from, to, color, width) {
  context.strokeStyle = color;
  context.lineWidth = width;
  context.lineCap = "round";
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}

// Two clicks and the metres between them. Stays until it is put away; a third click begins anew. `say` gets the distance.
export function measureTool(say) {
  const points = [];
  let pointer = null;
  const length = () => {
    const end = points[1] ?? pointer;
    return points.length > 0 && end ? Math.hypot(end[0] - points[0][0], end[1] - points[0][1]) : null;
  };
  const tell = () => say(points.length === 0 ? "Click the start point" : points.length === 1 && !pointer ? "Click the end point" : metres(length()));
  tell();
  return {
    click(x, y) {
      if (points.length === 2) points.length = 0;
      points.push([x, y]);
      pointer = null;
      tell();
    },
    hover(x, y) {
      if (points.length !== 1) return;
      pointer = [x, y];
      tell();
    },
    draw(context, view, colors) {
      if (points.length === 0) return;
      const from = view.toScreen(...points[0]), end = points[1] ?? pointer;
      if (end) {
        const to = view.toScreen(...end);
        line(context, from, to, colors["--surface"], 6);
        line(context, from, to, colors["--accent"], 2.5);
        label(context, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2 - 22, metres(length()), colors);
      }
      context.fillStyle = colors["--accent"];
      for (const point of points) {
        context.beginPath();
        context.arc(...view.toScreen(...point), 5, 0, 7);
        context.fill();
      }
    },
    end: () => say(""),
  };
}

// One click: the place.
export function pointTool(say, text, chosen) {
  say(text);
  return { click: (x, y) => chosen(x, y), end: () => say("") };
}

// A drag: from where the robot stands to where it looks.
export function poseTool(say, text, chosen) {
  let from = null, to = null;
  say(text);
  return {
    drag(what, x, y) {
      if (what === "start") from = to = [x, y];
      if (what === "move") to = [x, y];
      if (what === "cancel") from = to = null;
      if (what !== "end" || from === null) return;
      const heading = Math.hypot(x - from[0], y - from[1]) > 0.05 ? Math.atan2(y - from[1], x - from[0]) : null;
      if (heading === null) say("Drag in the robot's heading");
      else chosen(from[0], from[1], heading);
      from = to = null;
    },
    draw(context, view, colors) {
      if (from === null) return;
      const a = view.toScreen(...from), b = view.toScreen(...to), turn = Math.atan2(b[1] - a[1], b[0] - a[0]);
      line(context, a, b, colors["--accent"], 4);
      if (Math.hypot(b[0] - a[0], b[1] - a[1]) > 12) {
        for (const side of [2.6, -2.6]) line(context, b, [b[0] + 16 * Math.cos(turn + side), b[1] + 16 * Math.sin(turn + side)], colors["--accent"], 4);
      }
      context.fillStyle = colors["--accent"];
      context.beginPath();
      context.arc(...a, 7, 0, 7);
      context.fill();
    },
    end: () => say(""),
  };
}
