"use strict";
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
  document.querySelectorAll(".panel").forEach((panel) => { panel.hidden = panel.dataset.scene !== sceneSelect.value; });
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
const within = (value, limit) => limit === null || (value !== null && value <= limit);

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

function answer() {
  const out = document.getElementById("answer");
  out.replaceChildren();
  const error = limitFrom("pick-error"), compliance = limitFrom("pick-compliance");
  if (error === undefined || compliance === undefined) { node("p", "Give a positive length in metres, such as 1e-6.", out); return; }
  const here = rows.filter((row) => row.scene === sceneSelect.value && !hiddenEngines.has(row.engine));
  const fit = here.filter((row) => within(row.error, error) && within(row.compliance, compliance)).sort((a, b) => a.ms - b.ms);
  if (!fit.length) {
    const best = here.length ? Math.min(...here.map((row) => row.error)) : null;
    node("p", best === null ? "No run of the engines shown finished on this scene." : `No run reached this; the smallest error of any was ${short(best)} m.`, out);
    return;
  }
  const [first] = fit, next = fit.find((row) => row.engine !== first.engine);
  const head = node("p", "", out);
  node("strong", `${first.engine} ${first.method}, ${first.setting}: ${short(first.ms)} ms`, head);
  head.append(` (error ${short(first.error)} m, joints closed to ${short(first.compliance)} m).`);
  node("p", next ? `Next engine: ${next.engine} ${next.method}, ${next.setting}, at ${short(next.ms)} ms: ${short(next.ms / first.ms)} times as long.` : "No other engine shown reaches it.", out);
  const line = node("div", "", out);
  line.className = "line";
  node("code", first.command, line);
  const button = node("button", "copy", line);
  button.type = "button"; button.className = "copy"; button.dataset.command = first.command;
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
