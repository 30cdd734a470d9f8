// Pictures: the snake, the map, the curve. Colours come from the style sheet.
"use strict";
let colours = {}; // as looked up; emptied when the page turns dark or light
const colour = (name) => (colours[name] ??= getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim());

// A canvas as sharp as the screen; returns its context in CSS pixels.
function sharp(canvas) {
  const ratio = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio))
    canvas.width = Math.round(w * ratio), canvas.height = Math.round(h * ratio);
  const g = canvas.getContext("2d");
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, w, h);
  return { g, w, h };
}

// Round numbers from 0 to beyond `most`, about `count` of them.
function ticks(most, count = 4) {
  const raw = most / count, ten = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * ten).find((v) => v >= raw * 0.999);
  return Array.from({ length: Math.floor(most / step + 1e-9) + 1 }, (_, k) => +(k * step).toPrecision(6));
}

// Turned so that the first period's way lies along x. Link 1 starts a period at the origin along x:
// where it ends is the turn and shift of each period.
function moved(motion, cycle, k, link) {
  const p = unturned(motion, cycle, k, link), way = motion.way;
  return { ...p, x: way.c * p.x + way.s * p.y, y: way.c * p.y - way.s * p.x, theta: p.theta - way.angle };
}

function setWay(motion) {
  motion.way = { c: 1, s: 0, angle: 0 };
  const a = centre(motion, 0, 0), b = centre(motion, 0, motion.frames), angle = Math.atan2(b.y - a.y, b.x - a.x);
  motion.way = { c: Math.cos(angle), s: Math.sin(angle), angle };
}

function unturned(motion, cycle, k, link) {
  const at = k * motion.row + 5 * link, d = motion.data, end = motion.frames * motion.row;
  let x = d[at], y = d[at + 1], theta = d[at + 2];
  const shift = [d[end], d[end + 1], d[end + 2]];
  for (let c = 0; c < cycle; c++) {
    const cos = Math.cos(shift[2]), sin = Math.sin(shift[2]);
    [x, y, theta] = [shift[0] + cos * x - sin * y, shift[1] + sin * x + cos * y, theta + shift[2]];
  }
  return { x, y, theta, along: d[at + 3], across: d[at + 4] };
}

function centre(motion, cycle, k) {
  let x = 0, y = 0;
  for (let i = 0; i < motion.links; i++) {
    const p = moved(motion, cycle, k, i);
    x += p.x / motion.links, y += p.y / motion.links;
  }
  return { x, y };
}

// A wheel rests where it moves less than a millionth of the gait's own speed.
function drawSnake(canvas, motion, s, time) {
  const { g, w, h } = sharp(canvas);
  const cycles = 6, beat = (time / motion.period) % cycles, cycle = Math.floor(beat);
  const k = Math.min(motion.frames, Math.round((beat - cycle) * motion.frames));
  if (!motion.way) setWay(motion);
  const turns = Math.abs(motion.data[motion.frames * motion.row + 2]) > 0.02;
  const body = s.links * s.length, scale = Math.min(w / (1.4 * body), h / ((turns ? 1 : 0.62) * body));
  const c = centre(motion, cycle, k);
  const X = (x) => w / 2 + (x - c.x) * scale, Y = (y) => h / 2 - (y - c.y) * scale;
  grid(g, w, h, c, scale, s.length);
  g.strokeStyle = colour("path"), g.lineWidth = 2, g.beginPath();
  for (let back = cycle * motion.frames + k, m = 0; back >= 0; back -= 3, m++) {
    const p = centre(motion, Math.floor(back / motion.frames), back % motion.frames);
    m ? g.lineTo(X(p.x), Y(p.y)) : g.moveTo(X(p.x), Y(p.y));
  }
  g.stroke();
  const rests = 1e-6 * s.length * s.links * 2 * Math.PI * s.hz, half = s.length / 2;
  for (let i = 0; i < s.links; i++) {
    const p = moved(motion, cycle, k, i), cos = Math.cos(p.theta), sin = Math.sin(p.theta);
    const at = (a, b) => [X(p.x + a * cos - b * sin), Y(p.y + a * sin + b * cos)];
    g.lineCap = "round", g.strokeStyle = colour("body"), g.lineWidth = Math.max(5, 0.2 * s.length * scale);
    g.beginPath(), g.moveTo(...at(-0.8 * half, 0)), g.lineTo(...at(0.8 * half, 0)), g.stroke();
    const stuck = Math.abs(p.across) < rests;
    g.lineCap = "butt", g.strokeStyle = colour(stuck ? "stuck" : "slides"), g.lineWidth = Math.max(4, 0.13 * s.length * scale);
    for (const side of [-1, 1]) {
      g.beginPath(), g.moveTo(...at(-0.3 * half, side * 0.42 * half)), g.lineTo(...at(0.3 * half, side * 0.42 * half)), g.stroke();
      if (stuck) g.strokeStyle = colour("ink"), g.lineWidth = 1.2, g.strokeRect(at(0, side * 0.42 * half)[0] - 2, at(0, side * 0.42 * half)[1] - 2, 4, 4),
        g.strokeStyle = colour("stuck"), g.lineWidth = Math.max(4, 0.13 * s.length * scale);
    }
    if (i === s.links - 1) {
      g.fillStyle = colour("ink"), g.beginPath(), g.arc(...at(0.75 * half, 0), Math.max(2, 0.05 * s.length * scale), 0, 7), g.fill();
    }
  }
}

function grid(g, w, h, c, scale, length) {
  const step = length * 2;
  g.strokeStyle = colour("grid"), g.lineWidth = 1, g.beginPath();
  for (let x = Math.ceil((c.x - w / 2 / scale) / step) * step; x < c.x + w / 2 / scale; x += step)
    g.moveTo(w / 2 + (x - c.x) * scale, 0), g.lineTo(w / 2 + (x - c.x) * scale, h);
  for (let y = Math.ceil((c.y - h / 2 / scale) / step) * step; y < c.y + h / 2 / scale; y += step)
    g.moveTo(0, h / 2 - (y - c.y) * scale), g.lineTo(w, h / 2 - (y - c.y) * scale);
  g.stroke();
}

// Viridis at five points: even in lightness, and told apart by all kinds of colour vision.
const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function viridis(x) {
  const at = Math.min(3.999, Math.max(0, x * 4)), i = Math.floor(at), f = at - i;
  return `rgb(${VIRIDIS[i].map((v, k) => Math.round(v + f * (VIRIDIS[i + 1][k] - v))).join(",")})`;
}

const FRAME = { left: 46, right: 12, top: 12, bottom: 40 }, CELLS = 40, TOP_ALPHA = 105;
function mapFrame(w, h) {
  const x0 = FRAME.left, y0 = h - FRAME.bottom, width = w - x0 - FRAME.right, height = y0 - FRAME.top;
  return { X: (beta) => x0 + beta / 180 * width, Y: (alpha) => y0 - alpha / TOP_ALPHA * height, x0, y0, width, height };
}

// The cell, or the coarser one that stands for it; -1 where none is known.
function knownAt(values, i, j, stride) {
  for (let step = 1; step <= stride; step *= 2) {
    const at = Math.floor(i / step) * step * (CELLS + 1) + Math.floor(j / step) * step;
    if (Number.isFinite(values[at])) return at;
  }
  return -1;
}

// The cells stay as they are while only the ring moves: they are kept as a picture, made anew when
// `map.fresh` says so or the canvas has another size.
function drawMap(canvas, map, s) {
  const { g, w, h } = sharp(canvas), f = mapFrame(w, h);
  if (map && (map.fresh || map.picture.width !== canvas.width || map.picture.height !== canvas.height)) {
    map.fresh = false, map.best = drawCells(g, f, map);
    map.picture = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    map.picture.getContext("2d").drawImage(canvas, 0, 0);
  } else if (map) g.drawImage(map.picture, 0, 0, w, h);
  axes(g, f, [0, 45, 90, 135, 180], [0, 35, 70, 105], f.X, f.Y, "phase lag β, °", "amplitude α, °");
  if (map && map.best) mark(g, f.X(map.best.beta), f.Y(map.best.alpha), "★");
  ring(g, f.X(s.beta), f.Y(Math.min(s.alpha, TOP_ALPHA)));
}

// Fill the cells, hatched where servos cannot run them. Return the best of the others: the fastest,
// or the one with the least power.
function drawCells(g, f, map) {
  const known = [...map.values].filter(Number.isFinite), power = map.mode === "power";
  const sorted = known.sort((a, b) => a - b), low = power ? sorted[0] : 0;
  const high = power ? sorted[Math.floor(0.6 * (sorted.length - 1))] : sorted[sorted.length - 1];
  let best = null;
  const dx = f.width / CELLS, dy = f.height / CELLS, hatch = new Path2D();
  map.low = low, map.high = high;
  for (let i = 0; i <= CELLS; i++)
    for (let j = 0; j <= CELLS; j++) {
      const at = knownAt(map.values, i, j, 8), can = canRun(map.servo, map.rates[at]);
      if (at < 0) continue;
      const shade = high > low ? (map.values[at] - low) / (high - low) : 0;
      g.fillStyle = viridis(power ? 1 - shade : shade);
      const x = Math.max(f.x0, f.x0 + (j - 0.5) * dx), y = Math.max(FRAME.top, f.y0 - (i + 0.5) * dy);
      g.fillRect(x, y, Math.min(dx + 1, f.x0 + f.width - x), Math.min(dy + 1, f.y0 - y));
      if (!can) hatch.moveTo(x, Math.min(y + dy, f.y0)), hatch.lineTo(Math.min(x + dx, f.x0 + f.width), y);
      const exact = map.values[i * (CELLS + 1) + j];
      if (i && j && can && Number.isFinite(exact) && (!best || (power ? exact < best.v : exact > best.v)))
        best = { v: exact, alpha: i * TOP_ALPHA / CELLS, beta: j * 180 / CELLS };
    }
  g.strokeStyle = "#fff", g.lineWidth = 1.2, g.stroke(hatch);
  if (map.done) cliff(g, f, map, high - low);
  return best;
}

// White edges between neighbours that differ by more than a fifth of the whole range.
function cliff(g, f, map, range) {
  const v = (i, j) => map.values[i * (CELLS + 1) + j];
  g.strokeStyle = "#fff", g.lineWidth = 2, g.beginPath();
  for (let i = 1; i <= CELLS; i++)
    for (let j = 1; j <= CELLS; j++) {
      const dx = f.width / CELLS, dy = f.height / CELLS, x = f.x0 + (j - 0.5) * dx, y = f.y0 - (i - 0.5) * dy;
      if (Math.abs(v(i, j) - v(i, j - 1)) > range / 5) g.moveTo(x, y), g.lineTo(x, y - dy);
      if (Math.abs(v(i, j) - v(i - 1, j)) > range / 5) g.moveTo(x, y), g.lineTo(x + dx, y);
    }
  g.stroke();
}

function mark(g, x, y, sign) {
  g.font = "20px sans-serif", g.textAlign = "center", g.textBaseline = "middle";
  g.lineWidth = 4, g.strokeStyle = "#000", g.strokeText(sign, x, y), g.fillStyle = "#fff", g.fillText(sign, x, y);
}
function ring(g, x, y) {
  for (const [width, c] of [[5, "#000"], [2.5, "#fff"]])
    g.strokeStyle = c, g.lineWidth = width, g.beginPath(), g.arc(x, y, 8, 0, 7), g.stroke();
}

function axes(g, f, xs, ys, X, Y, xTitle, yTitle) {
  g.strokeStyle = colour("ink"), g.fillStyle = colour("ink"), g.lineWidth = 1, g.font = "12px system-ui, sans-serif";
  g.strokeRect(f.x0, FRAME.top, f.width, f.height);
  g.textAlign = "center", g.textBaseline = "top";
  for (const x of xs) g.fillText(x, X(x), f.y0 + 5);
  g.fillText(xTitle, f.x0 + f.width / 2, f.y0 + 22);
  g.textAlign = "right", g.textBaseline = "middle";
  for (const y of ys) g.fillText(y, f.x0 - 5, Y(y));
  g.save(), g.translate(11, FRAME.top + f.height / 2), g.rotate(-Math.PI / 2), g.textAlign = "center", g.fillText(yTitle, 0, 0), g.restore();
}

function drawCurve(canvas, curve, s, speed) {
  const { g, w, h } = sharp(canvas), f = mapFrame(w, h);
  const all = [...curve.speed, ...(curve.high || []), speed].filter(Number.isFinite), most = 1.08 * Math.max(...all, 1e-6);
  const X = (hz) => f.x0 + hz / 3 * f.width, Y = (v) => f.y0 - v / most * f.height;
  if (curve.bandHz) {
    g.fillStyle = colour("band"), g.beginPath();
    curve.bandHz.forEach((hz, k) => g.lineTo(X(hz), Y(curve.low[k])));
    for (let k = curve.bandHz.length - 1; k >= 0; k--) g.lineTo(X(curve.bandHz[k]), Y(curve.high[k]));
    g.fill();
  }
  g.strokeStyle = colour("stuck"), g.lineWidth = 2.5, g.beginPath();
  curve.hz.forEach((hz, k) => (k ? g.lineTo(X(hz), Y(curve.speed[k])) : g.moveTo(X(hz), Y(curve.speed[k]))));
  g.stroke();
  axes(g, f, [0, 1, 2, 3], ticks(most), X, Y, "frequency, Hz", "speed, m/s");
  ring(g, X(s.hz), Y(speed));
}
