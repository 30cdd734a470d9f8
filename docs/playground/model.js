// What the page, the worker and the tests say to the core: plain numbers in, plain numbers out.
"use strict";
const RAD = Math.PI / 180, GRAVITY_M_S2 = 9.80665;

// `whole` says whose the four frictions are: the whole snake's or one link's.
const PRESETS = {
  "2005": { title: "2005 robot, its measured friction", whole: 1, links: 6, mass: 0.0756, length: 0.076,
            ct: 0.084, cn: 1.2, ft0: 0.14, fn0: 0.27, alpha: 70, beta: 75, hz: 0.5, offset: 0, inertia: 0, servo: "hobby" },
  paper: { title: "the paper's gait study (viscous)", whole: 0, links: 6, mass: 0.0756, length: 0.076,
           ct: 0.1, cn: 10, ft0: 0, fn0: 0, alpha: 70, beta: 75, hz: 0.7957747, offset: 0, inertia: 0, servo: "" },
};
const FRICTIONS = ["ct", "cn", "ft0", "fn0"];

function perLink(s) {
  const share = s.whole ? s.links : 1;
  return Object.fromEntries(FRICTIONS.map((name) => [name, s[name] / share]));
}

// The fastest rate that a gait asks of a joint, °/s, and whether most servos of a kind can run it.
const jointRate = (s) => s.alpha * 2 * Math.PI * s.hz;
const canRun = (servo, rate) => !servo || rate <= TABLES.limits[servo][0];

// Why a state has no answer, or "" when it has one.
function refusal(s) {
  if (FRICTIONS.every((name) => !(s[name] > 0)))
    return "There is no friction at all, so nothing decides the motion. Give some friction.";
  if (!(s.alpha > 0)) return "The joints do not move. Give an amplitude.";
  return "";
}

class Core {
  constructor(module) {
    this.module = module;
    this.at = module._malloc(14 * 8);
    this.to = module._malloc(9 * 8);
    this.servoAt = module._malloc(TABLES.servoFields.length * 8);
  }

  put(s) {
    const g = perLink(s);
    const inertia = s.inertia || s.mass * s.length ** 2 / 12; // else a uniform rod's, as in the package
    this.module.HEAPF64.set([s.links, s.mass, s.length, inertia, g.ct, g.cn, g.ft0, g.fn0, g.ct, g.ft0,
      s.alpha * RAD, s.beta * RAD, 2 * Math.PI * s.hz, s.offset * RAD], this.at / 8);
  }

  steady(s, rtol = 1e-6, powers = true) {
    this.put(s);
    const code = this.module._serpenoid_steady(this.at, rtol, powers ? 1 : 0, this.to);
    const v = this.module.HEAPF64.subarray(this.to / 8, this.to / 8 + 9);
    const [speed, power, absPower, positivePower, turn, speedError, powerError, positiveError, turnError] = v;
    return { known: code >= 0, converged: code === 1, speed, power, absPower, positivePower, turn,
             speedError, powerError, positiveError, turnError };
  }

  // The speed with servos of a kind on the board's frames, steps as the package takes them.
  withServo(s, kind) {
    this.put(s);
    const servo = TABLES.servos[kind], frame = servo[TABLES.servoFields.indexOf("frame_s")];
    this.module.HEAPF64.set(servo, this.servoAt / 8);
    const longest = Math.min(1 / s.hz > 2 ? 2e-3 : 1e-3, frame / 4);
    const code = this.module._serpenoid_servo(this.at, this.servoAt, longest, this.to);
    const [speed, spread, error, amplitude, lag] = this.module.HEAPF64.subarray(this.to / 8, this.to / 8 + 5);
    return { known: code >= 0 && Number.isFinite(speed), converged: code === 1, speed, spread, error, amplitude, lag };
  }

  // One period: links and torques at frames + 1 times, or null.
  motion(s, frames = 120) {
    this.put(s);
    const row = 5 * s.links + s.links - 1, size = row * (frames + 2);
    const to = this.module._malloc(size * 8);
    const times = this.module._serpenoid_motion(this.at, frames, to);
    const data = this.module.HEAPF64.slice(to / 8, to / 8 + size);
    this.module._free(to);
    if (times < frames + 1) return null;
    return { links: s.links, frames, row, data, period: 1 / s.hz };
  }
}

// The largest torque of a period, and by how much half as many times would have missed it.
function peakTorque(motion) {
  let all = 0, half = 0;
  for (let k = 0; k <= motion.frames; k++)
    for (let j = 5 * motion.links; j < motion.row; j++) {
      const size = Math.abs(motion.data[k * motion.row + j]);
      all = Math.max(all, size);
      if (k % 2 === 0) half = Math.max(half, size);
    }
  return { value: all, error: all - half };
}

// Frictions that a fit allows: evenly many of the draws that it holds. A file of format 1 holds none.
function draws(fit) {
  const rows = fit.rows ? TABLES.amplitude.map((_, k) => fit.rows[Math.floor((k + 0.5) * fit.rows.length / TABLES.samples)]) : normalDraws(fit);
  return rows.map(([ct, cn, ft0, fn0], k) => ({ whole: 1, ct, cn, ft0, fn0, amplitude: TABLES.amplitude[k] }));
}

// Draws by values, covariance and intervals: normal on either side of the value, as much wider on one
// side as its interval is, none below 0.
function normalDraws(fit) {
  const n = fit.values.length, sigma = fit.covariance.map((row, i) => Math.sqrt(row[i]));
  const root = cholesky(fit.covariance.map((row, i) => row.map((c, j) => c / (sigma[i] * sigma[j]))));
  const side = (i, end) => 2 * sigma[i] * Math.abs(fit.intervals[i][end] - fit.values[i]) / (fit.intervals[i][1] - fit.intervals[i][0]);
  const found = [];
  for (const normal of TABLES.normal) {
    const unit = root.map((row) => row.reduce((sum, r, j) => sum + r * normal[j], 0));
    const draw = fit.values.map((value, i) => value + unit[i] * side(i, unit[i] < 0 ? 0 : 1));
    if (found.length < TABLES.samples && draw.every((value) => value > 0)) found.push(draw);
  }
  return found;
}

// The ends of the 95 % that the draws come from, as the package takes them: means of all draws in
// order, each weighted by a beta distribution's share of its cell. With u = x^a that is smooth at 0.
function band(speeds) {
  const sorted = [...speeds].sort((a, b) => a - b), n = sorted.length, parts = 200;
  const tail = Math.max(((n + 1) * 0.025 - 0.5) / n, 1e-6), a = (n + 1) * tail, b = (n + 1) * (1 - tail);
  const weight = sorted.map((_, k) => {
    const from = (k / n) ** a, wide = (((k + 1) / n) ** a - from) / parts;
    let sum = 0;
    for (let i = 0; i < parts; i++) sum += (1 - (from + wide * (i + 0.5)) ** (1 / a)) ** (b - 1);
    return sum * wide;
  });
  const whole = weight.reduce((sum, w) => sum + w, 0);
  const mean = (values) => values.reduce((sum, value, k) => sum + weight[k] * value, 0) / whole;
  return [mean(sorted), mean([...sorted].reverse())];
}

function cholesky(a) {
  const n = a.length, root = a.map(() => new Array(n).fill(0));
  for (let i = 0; i < n; i++)
    for (let j = 0; j <= i; j++) {
      let sum = a[i][j];
      for (let k = 0; k < j; k++) sum -= root[i][k] * root[j][k];
      root[i][j] = i === j ? Math.sqrt(Math.max(sum, 0)) : root[j][j] > 0 ? sum / root[j][j] : 0;
    }
  return root;
}

const MOST_BYTES = 5e6, LATER_MS = 60e3;

// Of what was dropped the fit.json to read, {text}; throws words for the reader.
async function findFit(files) {
  const named = (name) => files.find((f) => f.name === name), session = named("session.toml") || named("readings.csv");
  const fits = files.filter((f) => f.name === "fit.json"), fit = fits[0] || files.find((f) => f.name.endsWith(".json"));
  if (fits.length > 1) throw new Error(`There are ${fits.length} sessions in it. Drop one of them.`);
  if (!fit && session) throw new Error("This session has no fit yet. Run `serpenoid fit` on its folder, then drop the folder again.");
  if (!fit) throw new Error("There is no fit.json in it. Drop a session's folder after `serpenoid fit`, or the fit.json that it wrote.");
  if (fit.size > MOST_BYTES) throw new Error(`${fit.name} is far too large for a fit. Drop the fit.json that \`serpenoid fit\` writes.`);
  const readings = named("readings.csv");
  const old = readings && readings.lastModified - fit.lastModified > LATER_MS;
  return { text: await fit.text(), note: old ? " Its readings are newer than its fit: run `serpenoid fit` again." : "" };
}

// What a fit.json says; throws words for the reader.
function readFit(text) {
  let data;
  try { data = JSON.parse(text); } catch { throw new Error("This is not JSON. Drop the fit.json that `serpenoid fit` writes."); }
  const order = FRICTIONS.map((name) => name + "_whole"), p = data && data.parameters, c = data && data.covariance;
  const finite = (list) => Array.isArray(list) && list.every(Number.isFinite);
  const good = p && c && data.robot && Array.isArray(c.order) && Array.isArray(c.values) && order.every((name) =>
    p[name] && p[name].value >= 0 && finite(p[name].interval) && p[name].interval.length === 2 && p[name].interval[1] > p[name].interval[0]);
  if (!good) throw new Error("This is no fit: it names no friction of a whole snake with its interval. `serpenoid fit SESSION` writes one.");
  if (p.ct_back_whole) throw new Error("This robot has another friction backwards; the page knows one. Use `serpenoid steady --session`.");
  const place = order.map((name) => c.order.indexOf(name));
  const covariance = place.map((i) => place.map((j) => (c.values[i] || [])[j]));
  if (!covariance.every((row, i) => finite(row) && row[i] > 0)) throw new Error("Its covariance is not complete: run `serpenoid fit` again.");
  const r = data.robot, robot = { links: r.links, mass: r.link_mass_kg, length: r.link_length_m, inertia: r.link_inertia_kg_m2 };
  for (const [name, value] of Object.entries(robot))
    if (!(value >= LIMITS[name][0] && value <= LIMITS[name][1]))
      throw new Error(`Its robot has ${name} ${value}; the page takes ${LIMITS[name].join(" to ")}. Use \`serpenoid steady --session\`.`);
  if (Math.abs(robot.inertia / (robot.mass * robot.length ** 2 / 12) - 1) < 1e-6) robot.inertia = 0; // a rod's
  const drawn = data.format >= 2 && data.draws, columns = drawn && FRICTIONS.map((name) => (drawn.order || []).indexOf(name));
  const rows = drawn && (drawn.values || []).map((row) => columns.map((column) => row[column]));
  if (data.format >= 2 && !(rows && rows.length && rows.every((row) => finite(row) && row.every((value) => value >= 0))))
    throw new Error("Its draws are not complete: run `serpenoid fit` again.");
  return { name: String((data.session && data.session.name) || "fit.json"), robot, covariance, rows,
           values: order.map((name) => p[name].value), intervals: order.map((name) => p[name].interval) };
}

const FIELDS = ["links", "mass", "length", "whole", ...FRICTIONS, "alpha", "beta", "hz", "offset"];
const LIMITS = { links: [2, 12], mass: [0.005, 1], length: [0.02, 0.4], whole: [0, 1], ct: [0, 50], cn: [0, 500],
  ft0: [0, 10], fn0: [0, 20], alpha: [1, 110], beta: [1, 180], hz: [0.05, 3], offset: [-40, 40], inertia: [0, 1] };

// `inertia` is 0 for uniform rods, and then left out; `servo` is empty for ideal joints.
function toHash(s) {
  const numbers = [...FIELDS, ...(s.inertia ? ["inertia"] : [])].map((name) => `${name}=${+(+s[name]).toPrecision(10)}`);
  return "#" + [...numbers, `servo=${s.servo}`].join("&");
}

// The state in a link; what is missing or out of its limits stays as in `base`.
function fromHash(hash, base) {
  const s = { ...base };
  for (const [name, text] of new URLSearchParams(hash.slice(1))) {
    const value = Number(text), limits = LIMITS[name];
    if (limits && text !== "" && value >= limits[0] && value <= limits[1]) s[name] = value;
  }
  const servo = new URLSearchParams(hash.slice(1)).get("servo");
  if (servo === "" || Object.hasOwn(TABLES.servos, servo)) s.servo = servo;
  s.links = Math.round(s.links), s.whole = s.whole ? 1 : 0;
  return s;
}

function commandLine(s) {
  const g = perLink(s), n = (v) => String(+v.toPrecision(10));
  return `serpenoid steady --links ${s.links} --mass-kg ${n(s.mass)} --length-m ${n(s.length)}`
    + FRICTIONS.map((name) => ` --${name} ${n(g[name])}`).join("")
    + ` --alpha-deg ${n(s.alpha)} --beta-deg ${n(s.beta)} --frequency-hz ${n(s.hz)} --offset-deg ${n(s.offset)}`
    + (s.inertia ? ` --inertia-kg-m2 ${n(s.inertia)}` : "") + ` --servo ${s.servo || "ideal"}`;
}

function pythonCode(s) {
  const g = perLink(s), n = (v) => String(+v.toPrecision(10));
  return `from math import pi, radians

import serpenoid as sn

robot = sn.Robot(links=${s.links}, link_mass_kg=${n(s.mass)}, link_length_m=${n(s.length)}${s.inertia ? `,
                 link_inertia_kg_m2=${n(s.inertia)}` : ""})
ground = sn.Ground(${FRICTIONS.map((name) => `${name}=${n(g[name])}`).join(", ")})
gait = sn.Gait(alpha_rad=radians(${n(s.alpha)}), beta_rad=radians(${n(s.beta)}),
               omega_rad_s=2 * pi * ${n(s.hz)}, offset_rad=radians(${n(s.offset)}))
print(sn.steady_gait(robot, ground, gait${s.servo ? `, servo=sn.servo("${s.servo}")` : ""}).speed_m_s)`;
}

if (typeof module === "object") module.exports = { Core, PRESETS, LIMITS, findFit, readFit, draws, band, fromHash, toHash, commandLine, pythonCode, peakTorque, refusal };
