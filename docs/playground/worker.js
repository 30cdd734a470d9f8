// What the page asks the core: speed and motion of a gait, speed over frequency, and the map.
"use strict";
// Step lengths of the package: of the typical servo's speed, and of the range's rough ones.
const FINE_STEP_S = 1e-3, ROUGH_STEP_S = 4e-3;
const CYCLES = 5, FRAMES = 120; // of the motion: cycles from rest until it repeats, pictures of the last one
const CURVE_POINTS = 40, BAND_POINTS = 10, MAP_RTOL = 1e-3, MAP_STRIDES = [8, 4, 2, 1];

class Core {
  constructor(module) { this.module = module; }

  // Call a function of the core. Return the numbers that it fills, or null where it has no answer.
  ask(name, arrays, rest, size) {
    const { module } = this, places = arrays.map((values) => module._malloc(8 * values.length)), to = module._malloc(8 * size);
    arrays.forEach((values, k) => module.HEAPF64.set(values, places[k] / 8));
    const known = module["_serpenoid_" + name](...places, ...rest, to);
    const values = known ? module.HEAPF64.slice(to / 8, to / 8 + size) : null;
    [...places, to].forEach((place) => module._free(place));
    return values;
  }

  // Numbers as the core takes them: of one link, in radians.
  scene(s) {
    const frictions = [s.ct, s.cn, s.ft0, s.fn0].map((whole) => whole / s.links);
    return [s.links, s.mass / s.links, s.length, ...frictions, s.alpha * RAD, s.beta * RAD, 2 * Math.PI * s.hz];
  }

  ideal(s, rtol = 1e-6) {
    const values = this.ask("ideal", [this.scene(s)], [rtol], 2);
    return values ? values[0] : NaN;
  }

  servoSpeeds(s, servos, rough) {
    const step = rough ? ROUGH_STEP_S : FINE_STEP_S;
    const speeds = this.ask("servos", [this.scene(s), servos.flat()], [servos.length, step, rough ? 1 : 0], servos.length);
    return speeds || new Float64Array(servos.length).fill(NaN);
  }

  typical(s) { return this.servoSpeeds(s, [TABLES.servos[s.servo].typical], false)[0]; }

  // The 95 % interval of the speed over servos of the kind: rough speeds, put right by the typical servo's.
  range(s, typical = this.typical(s)) {
    const kind = TABLES.servos[s.servo], [rough, ...others] = this.servoSpeeds(s, [kind.typical, ...kind.samples], true);
    const speeds = others.map((speed) => speed * typical / rough).sort((a, b) => a - b);
    const mean = (values) => values.reduce((sum, value, k) => sum + TABLES.lowEndWeights[k] * value, 0);
    return [mean(speeds), mean(speeds.reverse())];
  }

  motion(s) {
    const row = 4 * s.links;
    const data = this.ask("motion", [this.scene(s), TABLES.servos[s.servo].typical], [CYCLES, FRAMES], row * (FRAMES + 1));
    return data && { data, row, links: s.links, length: s.length, frames: FRAMES, hz: s.hz };
  }
}

let core = null, job = 0;
// Tell the page a part of an answer. Return whether it still wants the rest.
async function tell(id, part) {
  postMessage({ id, ...part });
  await new Promise((next) => setTimeout(next));
  return id === job;
}

async function answer({ id, s }) {
  if (!await tell(id, { ideal: core.ideal(s) })) return;
  if (!await tell(id, { speed: core.typical(s) })) return;
  if (!await tell(id, { motion: core.motion(s) })) return;
  if (s.hz <= highestHz(s)) await tell(id, { range: core.range(s) });
}

async function curve(id, s) {
  const top = topHz(s), limit = Math.min(top, highestHz(s));
  const spread = (count, end) => Array.from({ length: count }, (_, k) => end * (k + 1) / count);
  const ideal = spread(CURVE_POINTS, top).map((hz) => [hz, core.ideal({ ...s, hz }, MAP_RTOL)]);
  const typical = [], band = [];
  for (const hz of spread(BAND_POINTS, limit)) {
    typical.push([hz, core.typical({ ...s, hz })]);
    if (!await tell(id, { curve: { top, limit, ideal, typical, band } })) return false;
  }
  for (const [hz, speed] of typical) {
    band.push([hz, ...core.range({ ...s, hz }, speed)]);
    if (!await tell(id, { curve: { top, limit, ideal, typical, band } })) return false;
  }
  return true;
}

// Ideal speeds of all cells, coarse ones first.
async function map(id, s) {
  const values = new Float64Array((CELLS + 1) ** 2).fill(NaN);
  for (const stride of MAP_STRIDES)
    for (let i = 0; i <= CELLS; i += stride) {
      for (let j = 0; j <= CELLS; j += stride) {
        const at = i * (CELLS + 1) + j, gait = { alpha: Math.max(1, i * CELL_ALPHA), beta: Math.max(1, j * CELL_BETA) };
        if (Number.isNaN(values[at])) values[at] = core.ideal({ ...s, ...gait }, MAP_RTOL);
      }
      if (!await tell(id, { map: { values, stride, done: stride === 1 && i === CELLS } })) return;
    }
}

onmessage = async ({ data }) => {
  job = data.id;
  if (!data.curve) answer(data);
  else if (await curve(data.id, data.s) && data.map) map(data.id, data.s);
};
serpenoidCore().then((module) => { core = new Core(module), postMessage({ ready: true }); });
