// Pictures: the robot, speed over frequency, the map. Colours come from the style sheet.
"use strict";
// ---- the robot: positions of the motion, turned so that it crawls to the right

function middle(motion, k) {
  let x = 0, y = 0;
  for (let i = 0; i < motion.links; i++) {
    const at = k * motion.row + 4 * i;
    x += motion.data[at] / motion.links, y += motion.data[at + 1] / motion.links;
  }
  return [x, y];
}

// Add the path of the middle along and across the way of a cycle, and the way's direction.
function findWay(motion) {
  const [x0, y0] = middle(motion, 0), [x1, y1] = middle(motion, motion.frames);
  motion.advance = Math.hypot(x1 - x0, y1 - y0);
  motion.way = Math.atan2(y1 - y0, x1 - x0);
  motion.path = Array.from({ length: motion.frames + 1 }, (_, k) => alongWay(motion, middle(motion, k), [x0, y0]));
}

// A point from another one, along and across the way.
function alongWay({ way }, [x, y], [x0, y0]) {
  const c = Math.cos(way), d = Math.sin(way);
  return [c * (x - x0) + d * (y - y0), c * (y - y0) - d * (x - x0)];
}

// The middle at a phase counted in cycles from 0, m.
function pathAt(motion, phase) {
  const cycle = Math.floor(phase), [x, y] = motion.path[Math.round((phase - cycle) * motion.frames)];
  return [x + cycle * motion.advance, y];
}

// `gone`: by how far the robot has crawled, m; the ground is drawn by it.
function drawSnake(canvas, motion, phase, gone) {
  const { g, w, h } = sharp(canvas), body = motion.links * motion.length;
  const scale = Math.min(w / (1.02 * body), h / (0.5 * body));
  const [here, side] = pathAt(motion, phase), k = Math.round(phase % 1 * motion.frames);
  const step = 10 ** Math.floor(Math.log10(0.6 * w / scale)), Y0 = h / 2 - 8; // m, between the lines
  for (let x = -((gone % step) + step) * scale + w / 2 % (step * scale); x < w + step * scale; x += step * scale)
    line(g, [[x, 0], [x, h]], colour("grid"), 1);
  const back = [];
  for (let p = phase; p > phase - 4; p -= 0.02) {
    const [x, y] = pathAt(motion, p);
    back.push([w / 2 + (x - here) * scale, Y0 - y * scale]);
  }
  line(g, back, colour("path"), 2);
  const centre = middle(motion, k);
  for (let i = 0; i < motion.links; i++) {
    const at = k * motion.row + 4 * i, [x, y, theta, across] = motion.data.slice(at, at + 4);
    const [right, up] = alongWay(motion, [x, y], centre);
    // A wheel holds where it slips by less than a thousandth of a link in a cycle.
    const holds = Math.abs(across) < 1e-3 * motion.length * motion.hz;
    drawLink(g, w / 2 + right * scale, Y0 - (side + up) * scale, motion.way - theta, motion.length * scale,
      colour(holds ? "holds" : "slips"), holds, i === motion.links - 1);
  }
  scaleBar(g, h, step, scale);
}

// ---- charts

const FRAME = { left: 50, right: 14, top: 10, bottom: 42 };
function chart(canvas, xEnd, xs, ys, xTitle, yTitle) {
  const drawn = sharp(canvas), { g, w, h } = drawn, x1 = w - FRAME.right, y1 = h - FRAME.bottom;
  const X = (x) => FRAME.left + x / xEnd * (x1 - FRAME.left), Y = (y) => y1 - y / ys.at(-1) * (y1 - FRAME.top);
  const finish = () => {
    g.fillStyle = colour("ink"), g.textBaseline = "middle", g.textAlign = "center";
    line(g, [[FRAME.left, FRAME.top], [FRAME.left, y1], [x1, y1]], colour("ink"), 1);
    for (const x of xs) g.fillText(x, X(x), y1 + 13);
    g.fillText(xTitle, (FRAME.left + x1) / 2, y1 + 31);
    g.textAlign = "right";
    for (const y of ys) g.fillText(y, FRAME.left - 6, Y(y));
    g.translate(10, (FRAME.top + y1) / 2), g.rotate(-Math.PI / 2), g.textAlign = "center", g.fillText(yTitle, 0, 0);
  };
  return { ...drawn, X, Y, finish };
}

// Round numbers from 0 to `most` or just beyond.
function ticks(most) {
  const ten = 10 ** Math.floor(Math.log10(most / 4)), step = [1, 2, 5, 10].map((m) => m * ten).find((one) => 5 * one >= most);
  return Array.from({ length: Math.ceil(most / step - 1e-9) + 1 }, (_, k) => +(k * step).toPrecision(3));
}

function hatch(g, x0, y0, x1, y1, style) {
  if (x1 <= x0 || y1 <= y0) return;
  g.save(), g.beginPath(), g.rect(x0, y0, x1 - x0, y1 - y0), g.clip();
  for (let x = x0 - (y1 - y0); x < x1; x += 9) line(g, [[x, y1], [x + y1 - y0, y0]], style, 1);
  g.restore();
}

function drawCurve(canvas, { top, limit, ideal, typical, band }, s, speed) {
  const most = Math.max(1e-6, ...[...ideal, ...band].flatMap(([, ...values]) => values).filter(Number.isFinite));
  const { g, X, Y, finish } = chart(canvas, top, ticks(top).filter((hz) => hz <= top), ticks(most), "frequency, Hz", "speed, m/s");
  const place = (points, of = 1) => [[0, 0, 0], ...points].map((point) => [X(point[0]), Y(point[of])]);
  hatch(g, X(limit), FRAME.top, X(top), Y(0), colour("hatch"));
  if (band.length) {
    g.fillStyle = colour("band"), g.beginPath();
    for (const [x, y] of [...place(band), ...place(band, 2).reverse()]) g.lineTo(x, y);
    g.fill();
  }
  g.setLineDash([2, 5]), line(g, place(ideal), colour("ink"), 1.5), g.setLineDash([]);
  line(g, place(typical), colour("holds"), 3);
  if (speed >= 0) ring(g, X(s.hz), Y(speed));
  finish();
}

function ring(g, x, y) {
  for (const [width, style] of [[5, "#000"], [2.5, "#fff"]])
    g.beginPath(), g.arc(x, y, 8, 0, 7), g.strokeStyle = style, g.lineWidth = width, g.stroke();
}

// Viridis at five points: even in lightness, and distinct for all kinds of colour vision.
const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function viridis(share) {
  const at = Math.min(3.999, Math.max(0, share * 4)), i = Math.floor(at);
  return `rgb(${VIRIDIS[i].map((low, k) => Math.round(low + (at - i) * (VIRIDIS[i + 1][k] - low)))})`;
}

// Return the scales of the map and its fastest gait that servos can follow.
function drawMap(canvas, { values, stride }, s) {
  const alphas = [0, 20, 40, 60, 80, 100, 120], betas = [0, 45, 90, 135, 180];
  const { g, X, Y, finish } = chart(canvas, 180, betas, alphas, "phase lag, °", "amplitude, °");
  const most = Math.max(...values.filter(Number.isFinite)), allowed = s.alpha * highestHz(s) / s.hz;
  let best = null;
  for (let i = 0; i < CELLS; i++)
    for (let j = 0; j < CELLS; j++) {
      const coarse = (k) => Math.floor(k / stride) * stride, exact = values[i * (CELLS + 1) + j];
      const value = Number.isFinite(exact) ? exact : values[coarse(i) * (CELLS + 1) + coarse(j)];
      const alpha = i * CELL_ALPHA, beta = j * CELL_BETA, x = X(beta), y = Y(alpha + CELL_ALPHA);
      g.fillStyle = Number.isFinite(value) ? viridis(value / most) : colour("paper");
      g.fillRect(x, y, X(beta + CELL_BETA) - x + 0.7, Y(alpha) - y + 0.7);
      if (alpha && alpha <= allowed && (!best || value > best.speed)) best = { alpha, beta, speed: value };
    }
  hatch(g, X(0), FRAME.top, X(180), Y(Math.min(120, allowed)), "#ffffffa0"); // The map is mostly dark.
  ring(g, X(s.beta), Y(s.alpha)), finish();
  return { most, best, X, Y };
}
