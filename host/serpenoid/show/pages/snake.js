// Draws a robot from above on a canvas: lines, dots, links with their wheels, a bar of scale. The page names the colours.
"use strict";
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

// A canvas as sharp as the screen; returns its context in CSS pixels.
function sharp(canvas) {
  const ratio = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight, g = canvas.getContext("2d");
  canvas.width = Math.round(w * ratio), canvas.height = Math.round(h * ratio);
  g.scale(ratio, ratio), g.font = "12px system-ui, sans-serif", g.lineCap = g.lineJoin = "round";
  return { g, w, h };
}

function line(g, points, style, width) {
  g.beginPath();
  for (const [x, y] of points) g.lineTo(x, y);
  g.strokeStyle = style, g.lineWidth = width, g.stroke();
}

function dot(g, x, y, radius, style) { g.beginPath(), g.arc(x, y, radius, 0, 7), g.fillStyle = style, g.fill(); }

// A link about its middle, `size` px long, its wheels in a colour; the head has a dot.
function drawLink(g, x, y, angle, size, wheel, framed, head) {
  g.save(), g.translate(x, y), g.rotate(angle);
  for (const side of [-0.25, 0.25]) {
    const ends = [[-0.15 * size, side * size], [0.15 * size, side * size]];
    if (framed) line(g, ends, colour("ink"), 0.1 * size + 4);
    line(g, ends, wheel, Math.max(3, 0.1 * size));
  }
  line(g, [[-0.38 * size, 0], [0.38 * size, 0]], colour("body"), Math.max(4, 0.2 * size));
  if (head) dot(g, 0.38 * size, 0, Math.max(2, 0.07 * size), colour("paper"));
  g.restore();
}

function scaleBar(g, h, length, scale) {
  const x = 14, y = h - 14, end = x + length * scale, ink = colour("ink");
  line(g, [[x, y - 5], [x, y], [end, y], [end, y - 5]], ink, 2);
  g.fillStyle = ink, g.textAlign = "left", g.fillText(length < 1 ? `${Math.round(100 * length)} cm` : `${length} m`, end + 8, y);
}
