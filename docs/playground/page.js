// The page: sliders to state, state to answer, picture, link and commands.
"use strict";
const $ = (id) => document.getElementById(id), text = (id) => $(id).textContent;
const run = (source) => document.head.appendChild(Object.assign(document.createElement("script"), { textContent: source }));
run(text("core-text")), run(text("tables-text")), run(text("model-text"));

const SLIDERS = {
  gait: [["alpha", "Amplitude α, °", 1], ["beta", "Phase lag β, °", 1], ["hz", "Frequency, Hz", 0.01], ["offset", "Bend (steers), °", 1]],
  ground: [["ct", "Viscous along, N s/m", 0], ["cn", "Viscous across, N s/m", 0], ["ft0", "Dry along, N", 0], ["fn0", "Dry across, N", 0]],
  body: [["links", "Links", 1], ["mass", "Mass of a link, kg", 0.0001], ["length", "Length of a link, m", 0.001]],
};
const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
let state = fromHash(location.hash, PRESETS["2005"]), core = null, fit = null, motion = null;
let answer = null, servo = null, map = null, curve = null, job = 0, open = 0, playing = !still, time = 0;

// Friction spans decades: its slider moves by the square root.
const rooted = (name) => FRICTIONS.includes(name);
const top_ = (name) => LIMITS[name][1] / (state.whole || !rooted(name) ? 1 : state.links);
const toSlider = (name, v) => (rooted(name) ? Math.sqrt(v / top_(name)) : v);
const fromSlider = (name, v) => (rooted(name) ? +(v * v * top_(name)).toPrecision(3) : v);

function addRow(parent, name, title, step, limits) {
  const row = document.createElement("div");
  row.className = "row";
  row.innerHTML = `<label for="n-${name}">${title}</label><input type="number" id="n-${name}" step="any" min="${limits[0]}" max="${limits[1]}">`;
  const range = rooted(name) ? [0, 1, 0.001] : [...limits, step];
  row.innerHTML += `<input type="range" id="r-${name}" aria-label="${title}" min="${range[0]}" max="${range[1]}" step="${range[2]}">`;
  row.lastChild.addEventListener("input", () => slide(name));
  parent.append(row);
  return $("n-" + name);
}

// At most one answer a frame, however many moves a mouse tells in it.
const slid = new Set();
function slide(name) {
  if (!slid.size) requestAnimationFrame(() => {
    const some = Object.fromEntries([...slid].map((n) => [n, fromSlider(n, +$("r-" + n).value)]));
    slid.clear(), change(some);
  });
  slid.add(name);
}

function build() {
  for (const [key, p] of Object.entries(PRESETS)) $("preset").add(new Option(p.title, key));
  $("preset").add(new Option("your own", "own"));
  for (const [group, rows] of Object.entries(SLIDERS))
    for (const [name, title, step] of rows)
      addRow($(group), name, title, step, LIMITS[name]).addEventListener("change", (e) => typed(name, e.target));
  $("servo").add(new Option("ideal joints", ""));
  for (const name of Object.keys(TABLES.servos)) $("servo").add(new Option(name === "hobby" ? "any hobby servo" : name, name));
}
const TITLES = Object.fromEntries(Object.values(SLIDERS).flat().map(([name, title]) => [name, title.split(", ")]));
const kindOf = () => (state.servo === "hobby" ? "typical hobby servos" : `${state.servo} servos`);

function typed(name, input) {
  const [low, high] = LIMITS[name], value = Number(input.value), good = input.value !== "" && value >= low && value <= high;
  input.setAttribute("aria-invalid", String(!good));
  if (good) return change({ [name]: name === "links" ? Math.round(value) : value });
  complain(`${name} is ${input.value || "empty"}; it can be ${low} to ${high}.`);
}

// The same ground, told for the whole snake or for each link.
function tellFor(whole) {
  const told = FRICTIONS.map((name) => [name, +(state[name] * (whole ? state.links : 1 / state.links)).toPrecision(12)]);
  change({ whole, ...Object.fromEntries(told) }, true);
}

const OF_FIT = [...FRICTIONS, "links", "mass", "length"];
function change(some, keepFit = false) {
  if (!keepFit && OF_FIT.some((name) => name in some)) fit = null, $("fit").textContent = "";
  if (!keepFit && ("mass" in some || "length" in some)) some.inertia = 0; // of a uniform rod
  state = { ...state, ...some };
  refresh();
}

let asked = 0;
function refresh() {
  curve = servo = null;
  solve();
  clearTimeout(asked);
  asked = setTimeout(settle, 150);
}
// What can wait until the slider rests: the address, and the long work.
function settle() {
  history.replaceState(null, "", toHash(state));
  order();
}

function complain(words) { $("problem").textContent = words, $("problem").hidden = !words; }

function solve() {
  for (const name of FIELDS) {
    if (name === "whole") $("whole").value = state.whole;
    else $("n-" + name).value = +state[name].toPrecision(6), $("r-" + name).value = toSlider(name, state[name]), $("n-" + name).removeAttribute("aria-invalid"),
      $("r-" + name).setAttribute("aria-valuetext", `${$("n-" + name).value} ${TITLES[name][1] || ""}`);
  }
  const same = Object.keys(PRESETS).find((key) => toHash(PRESETS[key]) === toHash(state));
  $("preset").value = same || "own", $("servo").value = state.servo;
  for (const [id, words] of [["command", commandLine(state)], ["python", pythonCode(state)]])
    if ($(id).textContent !== words) $(id).textContent = words;
  if (!core) return;
  const why = refusal(state);
  complain(why);
  answer = why ? null : core.steady(state);
  motion = answer && answer.known ? core.motion(state) : null;
  if (answer && !answer.known) complain("The core found no periodic motion here. Move one slider a little.");
  else if (answer && !answer.converged) complain("The errors are larger than usual here: look at the numbers behind ±.");
  show(), painting = painting || requestAnimationFrame(paint);
}

// A value of two digits; on demand to the last digit that its error leaves, and the error to one digit.
const two = (value) => (value && Math.abs(value) < 100 ? value.toPrecision(2) : String(+value.toPrecision(2)));
function figure(value, error, unit) {
  if (!$("digits").checked) return `${two(value)} ${unit}`;
  const place = Math.max(0, Math.min(9, error > 0 ? -Math.floor(Math.log10(error)) : 9));
  const digits = Math.min(place, Math.max(0, 5 - Math.floor(Math.log10(Math.max(Math.abs(value), 1e-9)))));
  const small = error < 0.5 * 10 ** -digits ? `${error.toExponential(0)}` : error.toFixed(digits);
  return `${value.toFixed(digits)} ${unit} <span class="error">± ${small}</span>`;
}

function show() {
  const a = answer;
  if (!a || !a.known) { $("speed").innerHTML = `<span class="big">no answer</span>`; $("figures").innerHTML = ""; return; }
  showSpeed(figure(a.speed, a.speedError, "m/s"));
  const weight = state.links * state.mass * GRAVITY_M_S2, rows = [["Power", figure(a.power, a.powerError, "W")]];
  rows.push(["Power of servos that do not recover", figure(a.positivePower, a.positiveError, "W")]);
  if (a.speed > 10 * a.speedError) {
    const cost = a.power / (weight * a.speed), error = cost * (a.powerError / Math.max(a.power, 1e-12) + a.speedError / a.speed);
    rows.push(["Cost of transport P/(m g v)", figure(cost, error, "")]);
  }
  if (motion) {
    const torque = peakTorque(motion);
    rows.push(["Largest joint torque", ofServo(figure(torque.value, Math.max(torque.error, 1e-4 * torque.value), "N m"), torque.value, 1)]);
  }
  rows.push(["Largest joint speed", ofServo(`${two(jointRate(state))} °/s`, jointRate(state), 0)]);
  rows.push(["Body lengths a cycle", figure(a.speed / state.hz / (state.links * state.length), a.speedError / state.hz / (state.links * state.length), "")]);
  if (Math.abs(a.turn) > 10 * a.turnError) rows.push(["Turn a cycle", figure(a.turn / RAD, a.turnError / RAD, "°")]);
  if (curve && curve.band) rows.push(["Speed that your fit allows, 95 %", `${two(curve.band[0])} to ${two(curve.band[1])} m/s`]);
  $("figures").innerHTML = rows.map(([name, value]) => `<div><dt>${name}</dt><dd>${value}</dd></div>`).join("");
}

// The speed with servos, and beside it that of ideal joints.
function showSpeed(ideal) {
  const big = (value, words) => { $("speed").innerHTML = `<span class="big">${value}</span> ${words}`; };
  const can = canRun(state.servo, jointRate(state)), settles = servo && servo.known && servo.converged;
  $("servo-speed").hidden = !state.servo;
  if (!state.servo) return big(ideal, "with ideal joints");
  if (!can) big("too fast", `for most ${state.servo} servos`);
  else if (servo) big(settles ? figure(servo.speed, servo.error, "m/s") : "no answer", `with ${kindOf()}`);
  else big("…", `with ${kindOf()}`);
  $("servo-speed").innerHTML = `Ideal joints: <strong>${ideal}</strong>. `
    + (can && settles ? `Servos reach ${Math.round(100 * servo.amplitude)} % of the amplitude.` : "");
}

// A value beside what servos of the kind can do: `which` is 0 for their speed, 1 for their torque.
function ofServo(shown, value, which) {
  if (!state.servo) return shown;
  const share = Math.round(100 * value / TABLES.limits[state.servo][which]), words = `${shown}, ${share} % of the servo's`;
  return share > 100 ? `<span class="over">${words}</span>` : words;
}

function showRanks() {
  const most = Math.abs(curve.ranks[0].change) || 1;
  $("ranks").innerHTML = curve.ranks.map(({ name, change }) => `<li>${TITLES[name][0]} <b>${change < 0 ? "−" : "+"}${two(100 * Math.abs(change))} %</b>`
    + `<i style="width:${100 * Math.abs(change) / most}%"></i></li>`).join("");
}

// ---- the workers: one draws the curve, the others share the map; they start after the first answer
const HELPERS = Math.min(4, Math.max(2, navigator.hardwareConcurrency || 2));
const workers = [];
function startWorkers() {
  const source = ["core-text", "tables-text", "model-text", "worker-text"].map((id) => text(id) + "\n");
  const url = URL.createObjectURL(new Blob(source, { type: "text/javascript" }));
  for (let k = 0; k <= HELPERS; k++) {
    const worker = new Worker(url);
    worker.onmessage = ({ data }) => (data.ready ? (workers.push(worker), workers.length > HELPERS && order()) : hear(data));
  }
}
function hear(data) {
  if (data.id !== job) return;
  if (data.curve) {
    curve = data.curve, servo = data.servo, show();
    if (data.ranks) curve.ranks = data.ranks, showRanks();
  }
  else {
    if (!map || map.id !== job) map = { id: job, values: new Float64Array((CELLS + 1) ** 2).fill(NaN), rates: [], mode: $("mode").value, servo: state.servo };
    data.at.forEach((at, k) => { map.values[at] = data.values[k], map.rates[at] = data.rates[k]; }), map.fresh = true;
    if (data.done && --open === 0) map.done = true;
  }
  painting = painting || requestAnimationFrame(paint);
}
let painting = 0;
function order() {
  document.body.dataset.map = "working";
  if (refusal(state) || workers.length <= HELPERS) return;
  const ask = { id: ++job, s: state, mode: $("mode").value, wanted: answer ? answer.speed : 0 };
  open = HELPERS;
  workers.forEach((worker, k) => worker.postMessage(k ? { ...ask, share: { part: k - 1, of: HELPERS } } : { ...ask, fit }));
}

function paint() {
  painting = 0;
  if (!$("map").clientWidth) return; // hidden: painted anew when it has a size
  if (map) {
    drawMap($("map"), map, state);
    const best = map.best;
    const power = map.mode === "power", what = power ? "Least power" : "Fastest", unit = power ? "W" : "m/s";
    const star = best ? `★ ${what}: α ${Math.round(best.alpha)}°, β ${Math.round(best.beta)}°: ${two(best.v)} ${unit} with ideal joints. ` : "";
    $("map-says").textContent = star + (map.servo ? `Hatched: too fast for most ${map.servo} servos. ` : "")
      + "○ is where you are. White edges: a cliff between neighbours. " + (map.done ? "Complete." : "Still filling …");
    [$("dark").textContent, $("bright").textContent] = (power ? [map.high, map.low] : [map.low, map.high]).map((v) => `${two(v)} ${unit}`);
    if (map.done) document.body.dataset.map = "done";
  }
  if (curve && answer) {
    drawCurve($("curve"), curve, state, answer.speed);
    $("curve-says").textContent = "Ideal joints; ○ is where you are." + (curve.band ? " Band: 95 %, of the frictions that your fit allows and of joints 3 % off." : "");
  }
  if (!playing && motion) drawSnake($("snake"), motion, state, time);
}

function go(event) {
  const box = $("map").getBoundingClientRect(), f = mapFrame(box.width, box.height);
  const beta = (event.clientX - box.left - f.x0) / f.width * 180, alpha = (f.y0 - (event.clientY - box.top)) / f.height * TOP_ALPHA;
  const to = (v, [low, high]) => Math.round(Math.min(high, Math.max(low, v)) * 10) / 10;
  change({ alpha: to(alpha, [1, TOP_ALPHA]), beta: to(beta, LIMITS.beta) });
}
const ARROWS = { ArrowLeft: ["beta", -1], ArrowRight: ["beta", 1], ArrowUp: ["alpha", 1], ArrowDown: ["alpha", -1] };
function arrow(event) {
  const move = ARROWS[event.key];
  if (!move) return;
  event.preventDefault();
  const [low, high] = LIMITS[move[0]];
  change({ [move[0]]: Math.min(high, Math.max(low, state[move[0]] + move[1])) });
}

async function take(coming) {
  let what = "Not taken";
  try {
    const files = await coming;
    what = files.length === 1 ? files[0].name : `${files.length} files`;
    if (!files.length) throw new Error("Nothing that can be read was dropped.");
    const { text, note } = await findFit(files), found = readFit(text), [ct, cn, ft0, fn0] = found.values;
    state = { ...state, whole: 1 }, fit = found;
    change({ ct, cn, ft0, fn0, ...found.robot }, true);
    $("fit").textContent = `Friction and robot of ${found.name}.${note}`;
  } catch (error) {
    $("fit").textContent = `${what}: ${error.message}`;
  }
}

const topFiles = (list) => [...list].filter((f) => (f.webkitRelativePath || "").split("/").length <= 2);

// The files of what was dropped; of a folder those directly in it.
async function dropped(items) {
  const entries = [...items].filter((i) => i.kind === "file").map((i) => [i.webkitGetAsEntry && i.webkitGetAsEntry(), i.getAsFile()]);
  const found = [];
  for (const [entry, file] of entries) {
    if (!entry || entry.isFile) { if (file) found.push(file); continue; }
    try { await readFolder(entry.createReader(), found); }
    catch { throw new Error("the browser does not open a dropped folder here. Press \u201cChoose a folder\u201d, or drop its fit.json."); }
  }
  return found;
}
async function readFolder(reader, found) {
  for (let some = [0]; some.length && found.length < 1000;) {
    some = await new Promise((good, bad) => reader.readEntries(good, bad));
    for (const one of some.filter((e) => e.isFile)) found.push(await new Promise((good, bad) => one.file(good, bad)));
  }
}

function listen() {
  $("preset").onchange = () => PRESETS[$("preset").value] && (fit = null, $("fit").textContent = "", change({ ...PRESETS[$("preset").value] }, true));
  $("whole").onchange = () => tellFor(+$("whole").value);
  $("mode").onchange = () => { map = null; order(); };
  $("map").addEventListener("click", go), $("map").addEventListener("keydown", arrow);
  $("controls").onsubmit = (e) => e.preventDefault();
  $("digits").onchange = show;
  $("servo").onchange = () => change({ servo: $("servo").value });
  for (const name of ["file", "folder"]) $(name).onchange = () => { if ($(name).files.length) take(topFiles($(name).files)); $(name).value = ""; };
  for (const kind of ["dragover", "dragleave", "drop"])
    addEventListener(kind, (e) => { e.preventDefault(), $("drop").classList.toggle("over-it", kind === "dragover"); });
  addEventListener("drop", (e) => take(dropped(e.dataTransfer.items)));
  addEventListener("hashchange", () => { state = fromHash(location.hash, state); refresh(); });
  addEventListener("resize", paint);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colours = {}; if (map) map.fresh = true; paint(); });
  $("play").onclick = () => setPlaying(!playing);
  document.querySelectorAll("[data-copy]").forEach((b) => b.addEventListener("click", () => copy(b.dataset.copy)));
}

function setPlaying(on) {
  playing = on;
  $("play").textContent = on ? "Pause" : "Play";
  $("play").setAttribute("aria-pressed", String(on));
  if (on) last = performance.now(), requestAnimationFrame(frame);
}
async function copy(what) {
  const content = what === "link" ? location.href : text(what);
  try { await navigator.clipboard.writeText(content); $("copied").textContent = "Copied."; }
  catch { $("copied").textContent = what === "link" ? location.href : "Select the text above and copy it."; }
}

let last = 0;
function frame(now) {
  time += Math.min(0.1, (now - last) / 1000), last = now;
  if (motion) drawSnake($("snake"), motion, state, time);
  if (playing) requestAnimationFrame(frame);
}

if (parent !== self) document.body.classList.add("embedded");
build(), listen(), setPlaying(playing), solve();
serpenoidCore().then((made) => {
  core = new Core(made), solve(), document.body.dataset.ready = "yes";
  document.body.dataset.firstMs = Math.round(performance.now());
  setTimeout(startWorkers);
});
