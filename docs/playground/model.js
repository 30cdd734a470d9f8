// What the page, the worker and the tests say to the core: plain numbers in, plain numbers out.
"use strict";
const RAD = Math.PI / 180, GRAVITY_M_S2 = 9.80665;

// `whole` says whose the four frictions are: the whole snake's or one link's.
const PRESETS = {
  "2005": { title: "2005 robot, its measured friction", whole: 1, links: 6, mass: 0.0756, length: 0.076,
            ct: 0.084, cn: 1.2, ft0: 0.14, fn0: 0.27, alpha: 70, beta: 75, hz: 0.5, offset: 0 },
  paper: { title: "the paper's gait study (viscous)", whole: 0, links: 6, mass: 0.0756, length: 0.076,
           ct: 0.1, cn: 10, ft0: 0, fn0: 0, alpha: 70, beta: 75, hz: 0.7957747, offset: 0 },
};
const FRICTIONS = ["ct", "cn", "ft0", "fn0"];

function perLink(s) {
  const share = s.whole ? s.links : 1;
  return Object.fromEntries(FRICTIONS.map((name) => [name, s[name] / share]));
}

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
  }

  put(s) {
    const g = perLink(s);
    const inertia = s.mass * s.length ** 2 / 12; // of a uniform rod, as the package's default
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

// Frictions that a fit allows: normal draws by its covariance, none of them negative.
function draws(fit, count) {
  const root = cholesky(fit.covariance), found = [];
  let seed = 2005;
  const uniform = () => { // mulberry32: the same draws for the same fit
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return (((t ^ (t >>> 14)) >>> 0) + 0.5) / 4294967296;
  };
  const normal = () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
  for (let tries = 0; found.length < count && tries < 100 * count; tries++) {
    const z = fit.values.map(normal);
    const draw = fit.values.map((value, i) => value + root[i].reduce((sum, r, j) => sum + r * z[j], 0));
    if (draw.every((value) => value > 0)) found.push(draw);
  }
  return found;
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

// What a dropped file says: {values, covariance, links, mass, length}; throws words for the reader.
function readFit(text) {
  let data;
  try { data = JSON.parse(text); } catch { throw new Error("This is not JSON. Drop the fit.json that `serpenoid fit` writes."); }
  const order = FRICTIONS.map((name) => name + "_whole"), p = data && data.parameters, c = data && data.covariance;
  const numbers = p && c && order.every((name) => p[name] && Number.isFinite(p[name].value) && p[name].value >= 0);
  if (!numbers || !data.robot) throw new Error("This is no fit.json: it names no friction of a whole snake. `serpenoid fit SESSION` writes one.");
  const place = order.map((name) => c.order.indexOf(name));
  const covariance = place.map((i) => place.map((j) => c.values[i] && c.values[i][j]));
  if (!covariance.flat().every(Number.isFinite)) throw new Error("The covariance in this fit.json is not complete; fit the session again.");
  return { name: (data.session && data.session.name) || "fit.json", values: order.map((name) => p[name].value),
           covariance, links: data.robot.links, mass: data.robot.link_mass_kg, length: data.robot.link_length_m };
}

const FIELDS = ["links", "mass", "length", "whole", ...FRICTIONS, "alpha", "beta", "hz", "offset"];
const LIMITS = { links: [2, 12], mass: [0.005, 1], length: [0.02, 0.4], whole: [0, 1], ct: [0, 50], cn: [0, 500],
  ft0: [0, 10], fn0: [0, 20], alpha: [1, 110], beta: [1, 180], hz: [0.05, 3], offset: [-40, 40] };

function toHash(s) { return "#" + FIELDS.map((name) => `${name}=${+(+s[name]).toPrecision(10)}`).join("&"); }

// The state in a link; what is missing or out of its limits stays as in `base`.
function fromHash(hash, base) {
  const s = { ...base };
  for (const [name, text] of new URLSearchParams(hash.slice(1))) {
    const value = Number(text), limits = LIMITS[name];
    if (limits && text !== "" && value >= limits[0] && value <= limits[1]) s[name] = value;
  }
  s.links = Math.round(s.links), s.whole = s.whole ? 1 : 0;
  return s;
}

function commandLine(s) {
  const g = perLink(s), n = (v) => String(+v.toPrecision(10));
  return `serpenoid steady --links ${s.links} --mass-kg ${n(s.mass)} --length-m ${n(s.length)}`
    + FRICTIONS.map((name) => ` --${name} ${n(g[name])}`).join("")
    + ` --alpha-deg ${n(s.alpha)} --beta-deg ${n(s.beta)} --frequency-hz ${n(s.hz)} --offset-deg ${n(s.offset)} --servo ideal`;
}

function pythonCode(s) {
  const g = perLink(s), n = (v) => String(+v.toPrecision(10));
  return `from math import pi, radians

import serpenoid as sn

robot = sn.Robot(links=${s.links}, link_mass_kg=${n(s.mass)}, link_length_m=${n(s.length)})
ground = sn.Ground(${FRICTIONS.map((name) => `${name}=${n(g[name])}`).join(", ")})
gait = sn.Gait(alpha_rad=radians(${n(s.alpha)}), beta_rad=radians(${n(s.beta)}),
               omega_rad_s=2 * pi * ${n(s.hz)}, offset_rad=radians(${n(s.offset)}))
print(sn.steady_gait(robot, ground, gait).speed_m_s)`;
}

if (typeof module === "object") module.exports = { Core, PRESETS, readFit, draws, fromHash, toHash, commandLine, pythonCode, peakTorque, refusal };
