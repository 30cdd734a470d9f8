// The long work, beside the page: one share of the map from coarse to fine; speed against frequency.
"use strict";
let core = null, job = 0;
const COUNT = 40, STEP = { alpha: 105 / COUNT, beta: 180 / COUNT }, STRIDES = [8, 4, 2, 1], EVERY_MS = 60;
const CURVE_POINTS = 24, BAND_POINTS = 8, TOP_HZ = 3, LEAST_HZ = 0.05;

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

const speed = (s) => { const a = core.steady(s, 1e-3, false); return a.known ? a.speed : NaN; };

// The cells of a map in the order of their work: coarse ones first, each once; {at, i, j, stride}.
function* cells() {
  const seen = new Uint8Array((COUNT + 1) ** 2);
  for (const stride of STRIDES)
    for (let i = 0; i <= COUNT; i += stride)
      for (let j = 0; j <= COUNT; j += stride) {
        const at = i * (COUNT + 1) + j;
        if (!seen[at]) seen[at] = 1, yield { at, i, j, stride };
      }
}

// Each worker takes every `share.of`-th cell, and tells what it has now and then.
async function fillMap({ id, s, mode, wanted, share }) {
  let at = [], values = [], rates = [], told = performance.now(), count = 0, stride = 0;
  const tell = (done) => (postMessage({ id, at, values, rates, done }), at = [], values = [], rates = [], told = performance.now());
  for (const cell of cells()) {
    if (count++ % share.of !== share.part) continue;
    if (performance.now() - told > EVERY_MS || (stride && cell.stride !== stride)) {
      tell(false);
      await new Promise((go) => setTimeout(go));
      if (id !== job) return;
    }
    stride = cell.stride;
    const here = { ...s, alpha: Math.max(1, cell.i * STEP.alpha), beta: Math.max(1, cell.j * STEP.beta) };
    at.push(cell.at), values.push(mode === "power" ? powerFor(here, wanted) : speed(here)), rates.push(jointRate(here));
  }
  tell(true);
}

// By how much 10 % more of each parameter changes the speed, the largest change first.
function ranked(s) {
  const withServo = s.servo && canRun(s.servo, jointRate(s));
  const of = (state) => (withServo ? core.withServo(state, s.servo).speed : speed(state)), here = of(s);
  return ["alpha", "beta", "hz", "ct", "cn", "ft0", "fn0", "mass", "length"].filter((name) => s[name] > 0)
    .map((name) => ({ name, change: of({ ...s, [name]: 1.1 * s[name] }) / here - 1 }))
    .filter((one) => Number.isFinite(one.change)).sort((a, b) => Math.abs(b.change) - Math.abs(a.change));
}

// Speed with servos, speed against frequency, what changes speed, and what a fit leaves of the first two.
async function drawCurve({ id, s, fit }) {
  const told = async (part) => { postMessage({ id, ...part }); await new Promise((go) => setTimeout(go)); return id === job; };
  const servo = s.servo ? core.withServo(s, s.servo) : null;
  const rates = (count) => Array.from({ length: count }, (_, k) => LEAST_HZ * (TOP_HZ / LEAST_HZ) ** (k / (count - 1)));
  const grounds = fit ? draws(fit) : [], among = (hz) => band(grounds.map((g) => speed({ ...s, ...g, hz, alpha: s.alpha * g.amplitude })));
  const curve = { hz: rates(CURVE_POINTS) };
  curve.speed = curve.hz.map((hz) => speed({ ...s, hz }));
  if (!await told({ servo, curve }) || !await told({ servo, curve, ranks: ranked(s) }) || !fit) return;
  curve.band = among(s.hz), curve.bandHz = [], curve.low = [], curve.high = [];
  if (!await told({ servo, curve })) return;
  for (const hz of [...rates(BAND_POINTS), s.hz].sort((a, b) => a - b)) {
    const [low, high] = among(hz);
    curve.bandHz.push(hz), curve.low.push(low), curve.high.push(high);
    if (!await told({ servo, curve })) return;
  }
}

onmessage = ({ data }) => {
  job = data.id;
  if (core && data.share) fillMap(data);
  else if (core && data.s) drawCurve(data);
};
