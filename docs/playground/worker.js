// The long work, beside the page: the map from coarse to fine, and speed against frequency.
"use strict";
let core = null, job = 0;
const STEP = { alpha: 90 / 40, beta: 180 / 40 }, COUNT = 40, STRIDES = [8, 4, 2, 1];

serpenoidCore().then((made) => { core = new Core(made); postMessage({ ready: true }); });

// Power where the speed is `wanted`: the rate is stretched until it is, as far as a rate may go.
function powerFor(s, wanted) {
  for (let tries = 0; tries < 12; tries++) {
    const a = core.steady(s, 1e-3, false);
    if (!a.known || !(a.speed > 0)) return NaN;
    if (Math.abs(a.speed - wanted) < 0.005 * wanted) return a.power;
    s.hz *= Math.min(4, Math.max(0.25, wanted / a.speed));
    if (!(s.hz < 10)) return NaN;
  }
  return NaN;
}

function cell(s, mode, wanted) {
  if (mode === "power") return powerFor({ ...s }, wanted);
  const a = core.steady(s, 1e-3, false);
  return a.known ? a.speed : NaN;
}

function curve(s, fit) {
  const hz = [], speed = [], low = [], high = [];
  const grounds = fit ? draws(fit, 24) : [];
  for (let k = 0; k < 24; k++) {
    const here = { ...s, hz: 0.05 * 60 ** (k / 23) };
    const a = core.steady(here, 1e-4, false);
    hz.push(here.hz), speed.push(a.known ? a.speed : NaN);
    const all = grounds.map((g) => core.steady({ ...here, ...named(g) }, 1e-3, false).speed).sort((x, y) => x - y);
    low.push(all.length ? all[0] : NaN), high.push(all.length ? all[all.length - 1] : NaN);
  }
  return { hz, speed, low, high, band: band(s, grounds) };
}

function named(values) { return { whole: 1, ct: values[0], cn: values[1], ft0: values[2], fn0: values[3] }; }

function band(s, grounds) {
  const all = grounds.map((g) => core.steady({ ...s, ...named(g) }, 1e-4, false).speed).sort((x, y) => x - y);
  return all.length ? [all[0], all[all.length - 1]] : null;
}

async function run({ id, s, mode, wanted, fit }) {
  const values = new Float64Array((COUNT + 1) ** 2).fill(NaN);
  const done = new Uint8Array(values.length), pause = () => new Promise((go) => setTimeout(go));
  let drawn = performance.now();
  for (const stride of STRIDES) {
    for (let i = 0; i <= COUNT; i += stride) {
      for (let j = 0; j <= COUNT; j += stride) {
        const at = i * (COUNT + 1) + j;
        if (done[at]) continue;
        done[at] = 1;
        values[at] = cell({ ...s, alpha: Math.max(1, i * STEP.alpha), beta: Math.max(1, j * STEP.beta) }, mode, wanted);
      }
      if (performance.now() - drawn > 60) {
        postMessage({ id, values, stride, done: false });
        await pause();
        if (id !== job) return;
        drawn = performance.now();
      }
    }
    postMessage({ id, values, stride, done: stride === 1 });
    await pause();
    if (id !== job) return;
    if (stride === STRIDES[0]) postMessage({ id, curve: curve(s, fit) });
  }
}

onmessage = (event) => {
  job = event.data.id;
  if (core) run(event.data);
};
