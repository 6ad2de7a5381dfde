// Draws the plots of the chosen scene, keeps scene and engine choice common to all, and answers the pick box.
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const narrow = () => window.innerWidth < 760;
const hiddenEngines = new Set();
const sceneSelect = document.getElementById("scene");

function themed() {
  const axis = { gridcolor: css("--grid"), linecolor: css("--line"), tickcolor: css("--line") };
  const look = { "font.color": css("--soft"), "font.family": getComputedStyle(document.body).fontFamily,
    "hoverlabel.bgcolor": css("--card"), "hoverlabel.bordercolor": css("--line"), "hoverlabel.font.color": css("--ink"), "hoverlabel.align": "left" };
  for (const [key, value] of Object.entries(axis)) { look[`xaxis.${key}`] = value; look[`yaxis.${key}`] = value; }
  return look;
}

function engineVisibility(traces) {
  return traces.map((trace) => !(trace.meta && hiddenEngines.has(trace.meta.engine)));
}

function forScreen(layout) {
  if (!narrow()) return layout;
  const below = { orientation: "h", y: -0.22, yanchor: "top", font: { size: 11 }, groupclick: "toggleitem" };
  return { ...layout, legend: { ...layout.legend, ...below }, margin: { ...layout.margin, l: 52, r: 8 }, height: layout.height + 190 };
}

async function draw(div) {
  if (div.dataset.drawn) return;
  div.dataset.drawn = "yes";
  const { data, layout } = JSON.parse(div.nextElementSibling.textContent);
  engineVisibility(data).forEach((visible, k) => { data[k].visible = visible; });
  const options = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
  await Plotly.newPlot(div, data, forScreen(layout), options);
  Plotly.relayout(div, themed());
}

// one after the other, so that the page stays responsive
async function drawShown() {
  for (const div of document.querySelectorAll(".panel:not([hidden]) .plot")) {
    await draw(div);
    await new Promise((resume) => setTimeout(resume));
  }
}

function drawnPlots() { return document.querySelectorAll(".plot[data-drawn]"); }

function chooseScene() {
  document.querySelectorAll(".panel[data-scene]").forEach((panel) => { panel.hidden = panel.dataset.scene !== sceneSelect.value; });
  document.querySelectorAll(".panel:not([hidden]) .plot[data-drawn]").forEach((div) => Plotly.Plots.resize(div));
  drawShown();
  answer();
}

function chooseEngines(event) {
  if (event.target.type !== "checkbox") return;
  if (event.target.checked) hiddenEngines.delete(event.target.value); else hiddenEngines.add(event.target.value);
  drawnPlots().forEach((div) => Plotly.restyle(div, { visible: engineVisibility(div.data) }));
  answer();
}

const short = (value) => (value === null ? "unknown" : value === 0 ? "0" : Number(value.toPrecision(2)) >= 0.01 && value < 1e4 ? String(Number(value.toPrecision(3))) : value.toExponential(1));
const rows = JSON.parse(document.getElementById("pick-rows").textContent);

function limitFrom(id) {
  const text = document.getElementById(id).value.trim();
  if (text === "") return null;
  const value = Number(text);
  return value > 0 ? value : undefined;
}

function node(tag, text, parent) {
  const made = document.createElement(tag);
  made.textContent = text;
  parent.append(made);
  return made;
}

const named = (row) => `${row.engine} ${row.method}, ${row.setting}`;

function answer() {
  const out = document.getElementById("answer");
  out.replaceChildren();
  const bounds = { error: limitFrom("pick-error"), compliance: limitFrom("pick-compliance"), ms: limitFrom("pick-budget") };
  if (Object.values(bounds).includes(undefined)) { node("p", "Give positive numbers, such as 1e-6; leave a field empty to ask nothing.", out); return; }
  const here = rows.filter((row) => row.scene === sceneSelect.value && !hiddenEngines.has(row.engine));
  const found = choose(here, bounds);
  if (!found.best) { node("p", refusal(found, bounds), out); return; }
  const { best, second, margin, limit } = found;
  const head = node("p", "", out);
  node("strong", `${named(best)}: ${short(best.ms)} ms`, head);
  head.append(` (error ${short(best.error)} m, joints closed to ${short(best.compliance)} m).`);
  node("p", second ? `Runner-up: ${named(second)}, at ${short(second.ms)} ms: ${short(margin)} times as long.` : "No other method shown reaches it.", out);
  node("p", limits(limit), out);
  const line = node("div", "", out);
  line.className = "line";
  node("code", best.command, line);
  const button = node("button", "copy", line);
  button.type = "button"; button.className = "copy"; button.dataset.command = best.command;
}

function refusal({ why, near, floor, count }, bounds) {
  if (why === "nothing") return "No run of the engines shown finished on this scene.";
  if (why === "floor") return `The truth of this scene judges no error below ${short(floor)} m; ask for more.`;
  if (why === "budget") return `None within ${short(bounds.ms)} ms; the cheapest is ${named(near)} at ${short(near.ms)} ms.`;
  if (why === "compliance") return `${count} settings reach the error, but none keeps the joints within ${short(bounds.compliance)} m; the nearest is ${named(near)} with ${short(near.compliance)} m.`;
  return `None reached this; the nearest is ${named(near)} with ${short(near.error)} m.`;
}

function limits(limit) {
  if (!limit) return "Nothing cheaper misses one bound alone.";
  const { bound, cheaper } = limit;
  const off = bound === "error" ? `an error of ${short(cheaper.error)} m` : `joints open by ${short(cheaper.compliance)} m`;
  return `The ${bound} limits it: the nearest cheaper one is ${named(cheaper)}, at ${short(cheaper.ms)} ms with ${off}.`;
}

async function copy(button) {
  const text = button.dataset.command;
  try { await navigator.clipboard.writeText(text); } catch { copyBySelection(text); }
  button.textContent = "copied";
  setTimeout(() => { button.textContent = "copy"; }, 1500);
}

// file:// pages may not reach the clipboard interface
function copyBySelection(text) {
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  document.execCommand("copy");
  area.remove();
}

document.addEventListener("click", (event) => { if (event.target.matches(".copy")) copy(event.target); });
sceneSelect.addEventListener("change", chooseScene);
document.getElementById("toolbar").addEventListener("change", chooseEngines);
for (const id of ["pick", "toolbar"]) document.getElementById(id).addEventListener("submit", (event) => event.preventDefault());
document.getElementById("pick").addEventListener("input", answer);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawnPlots().forEach((div) => Plotly.relayout(div, themed())));

const links = new Map([...document.querySelectorAll("nav li a")].map((link) => [link.hash.slice(1), link]));
const here = new IntersectionObserver((entries) => {
  for (const entry of entries) links.get(entry.target.id).classList.toggle("here", entry.isIntersecting);
}, { rootMargin: "-20% 0px -70% 0px" });
document.querySelectorAll("section[id]").forEach((section) => here.observe(section));
answer();
drawShown();
