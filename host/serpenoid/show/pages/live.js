// What pages beside a robot share: the stream of states, its loss, buttons, and parts of pictures.
const at = id => document.getElementById(id);
let heard = 0, link = (text, lost) => { at("link").textContent = text; at("link").className = lost ? "lost" : ""; };
function live(show) {
  const stream = new EventSource("states");
  const alive = () => { heard = Date.now(); link("live", false); };
  stream.onmessage = event => { alive(); show(JSON.parse(event.data)); };
  stream.addEventListener("beat", alive);
  stream.onerror = () => { if (stream.readyState === 2) { stream.close(); setTimeout(live, 1000, show); } };
  return stream;
}
setInterval(() => {
  if (heard && Date.now() - heard > 3000) link("connection lost: what is shown may be old", true); }, 500);
async function press(name) { // the answer of a button
  try { return await (await fetch(name, { method: "POST" })).json(); }
  catch { return { error: "no connection." }; }
}
function set(part, values) { for (const [name, value] of Object.entries(values)) part.setAttribute(name, value); }
function shape(kind, values, text) {
  const made = document.createElementNS(document.querySelector("svg").namespaceURI, kind);
  set(made, values);
  if (text !== undefined) made.textContent = text;
  return made;
}
