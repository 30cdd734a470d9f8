// The page: inputs to a state, the state to workers, their answers to words and pictures.
"use strict";
const $ = (id) => document.getElementById(id), form = document.forms[0], fields = [...form.elements].filter((one) => one.name);
for (const name of Object.keys(TABLES.servos)) form.elements.servo.add(new Option(name === "hobby" ? "any hobby servo" : name, name));
const two = (value) => (value && value < 100 ? value.toPrecision(2) : String(Math.round(value)));
const frictionSum = () => state.ct + state.cn + state.ft0 + state.fn0;
const UNITS = { alpha: "°", beta: "°", hz: " Hz" };

let state = null, shown = {}, job = 0, phase = 0, gone = 0, last = 0;
let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;

// ---- from the address and the inputs to the state

function readAddress() {
  for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
    const field = fields.find((one) => one.name === name), before = field && field.value;
    if (!field || value === "") continue;
    field.value = value;
    if (field.value === "" || !field.checkValidity()) field.value = before;
  }
  change();
}

function change() {
  for (const output of form.querySelectorAll("output")) {
    const input = output.nextElementSibling;
    output.textContent = input.value + UNITS[input.name];
    input.setAttribute("aria-valuetext", output.textContent);
  }
  if (!fields.every((field) => field.value !== "" && field.checkValidity())) return form.reportValidity();
  state = Object.fromEntries(fields.map(({ name, value }) => [name, name === "servo" ? value : Number(value)]));
  document.body.dataset.map = document.body.dataset.curve = "working";
  shown = { motion: shown.motion, curve: shown.curve, map: shown.map };
  $("python").textContent = pythonCode(state);
  setTimeout(() => history.replaceState(null, "", "#" + new URLSearchParams(new FormData(form))));
  ask();
}

function pythonCode({ links, mass, length, ct, cn, ft0, fn0, alpha, beta, hz, servo }) {
  return `from math import pi, radians

import serpenoid as sn

robot = sn.Robot.whole_body(links=${links}, mass_kg=${mass}, link_length_m=${length})
ground = sn.Ground.whole_body(links=${links}, ct=${ct}, cn=${cn}, ft0=${ft0}, fn0=${fn0})
gait = sn.Gait(alpha_rad=radians(${alpha}), beta_rad=radians(${beta}), omega_rad_s=2 * pi * ${hz})
print(sn.steady_gait(robot, ground, gait, servo=sn.servo("${servo}")).in_words())`;
}

// ---- two workers: one for the gait that is shown, one for the curve and the map

const source = ["core-text", "shared-text", "worker-text"].map((id) => $(id).textContent + "\n");
const url = URL.createObjectURL(new Blob(source, { type: "text/javascript" }));
const workers = [false, true].map((curve) => Object.assign(new Worker(url), { curve, onmessage: ({ data }) => hear(data) }));
let ready = 0;
function ask() {
  if (ready < workers.length) return;
  job++;
  if (!frictionSum()) return show();
  for (const worker of workers) worker.postMessage({ id: job, s: state, curve: worker.curve, map: $("mapped").open });
}
function hear(data) {
  if (data.ready) return ++ready === workers.length && ask();
  if (data.id !== job) return;
  if (data.motion) findWay(data.motion);
  Object.assign(shown, data), show(), paint();
}

function show() {
  const { ideal, speed, range } = shown, kind = state.servo, limit = two(highestHz(state));
  const big = (value, words) => { $("speed").innerHTML = `<b>${value}</b> ${words}`; };
  if (!frictionSum()) big("no answer", "There is no friction, so nothing decides the motion.");
  else if (ideal === undefined) return;
  else if (Number.isNaN(ideal)) big("no answer", "The core finds no periodic motion here. Move a slider a little.");
  else if (state.hz > highestHz(state)) big("too fast", `for a typical ${kind} servo: stay below ${limit} Hz. Ideal joints: ${two(ideal)} m/s.`);
  else if (speed === undefined) big("…", "");
  else if (Number.isNaN(speed)) big("no answer", `With ${kind} servos the robot settles to no speed. Ideal joints: ${two(ideal)} m/s.`);
  else big(`${two(speed)} m/s`, `with typical ${kind} servos${range ? `; ${two(range[0])} to ${two(range[1])} with 95 % of them` : ""}. Ideal joints: ${two(ideal)}.`);
  $("curve-says").textContent = `Line: typical ${kind} servos. Band: 95 % of them. Dotted: joints that follow the gait exactly. `
    + `Hatched: beyond ${limit} Hz they cannot follow.`;
}

// ---- pictures

function paint() {
  const { curve, map, motion, speed } = shown;
  if (motion && !playing) drawSnake($("snake"), motion, phase, gone);
  if (curve) drawCurve($("curve"), curve, state, speed);
  if (curve && curve.band.length === curve.typical.length) document.body.dataset.curve = "done";
  if (!map || !$("mapped").open) return;
  const { most, best } = drawMap($("map"), map, state);
  $("map-says").textContent = `Colour: speed of ideal joints at ${state.hz} Hz, from 0 (dark) to ${two(most)} m/s (bright). Hatched: too fast for the servos. `
    + (best ? `Fastest below: ${two(best.speed)} m/s at amplitude ${Math.round(best.alpha)}°, phase lag ${Math.round(best.beta)}°.` : "");
  if (map.done) document.body.dataset.map = "done";
}

function frame(now) {
  const seconds = Math.min(0.1, (now - last) / 1000), { motion } = shown;
  last = now;
  if (motion) {
    const [before] = pathAt(motion, phase);
    phase += seconds * motion.hz;
    gone += pathAt(motion, phase)[0] - before;
    drawSnake($("snake"), motion, phase, gone);
  }
  if (playing) requestAnimationFrame(frame);
}
function play(on) {
  playing = on, $("play").textContent = on ? "Pause" : "Play";
  if (on) last = performance.now(), requestAnimationFrame(frame);
}

function setGait(alpha, beta) {
  form.elements.alpha.value = Math.round(alpha), form.elements.beta.value = Math.round(beta), change();
}
$("map").onclick = (event) => {
  const { X, Y } = drawMap($("map"), shown.map, state);
  setGait(120 * (event.offsetY - Y(0)) / (Y(120) - Y(0)), 180 * (event.offsetX - X(0)) / (X(180) - X(0)));
};
$("map").onkeydown = (event) => {
  const [up, right] = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] }[event.key] || [0, 0];
  if (up || right) event.preventDefault(), setGait(state.alpha + up, state.beta + right);
};
form.oninput = change, form.onsubmit = (event) => event.preventDefault();
$("mapped").ontoggle = ask;
$("play").onclick = () => play(!playing);
addEventListener("hashchange", readAddress);
addEventListener("resize", paint);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
if (parent !== self) document.body.classList.add("embedded");
readAddress(), show(), play(playing);
