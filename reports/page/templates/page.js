// Folds wide tables, draws plots, first those near the screen, and answers the pick box.
"use strict";
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const narrow = () => window.innerWidth < 760;

// on a narrow screen every cell stands beneath the last, with its column's title before it
function fold() {
  for (const table of document.querySelectorAll("table.fold")) {
    const titles = [...table.querySelectorAll("thead th")].map((cell) => cell.textContent.trim());
    for (const row of table.querySelectorAll("tbody tr")) {
      let column = 0;
      for (const cell of row.cells) { if (cell.colSpan === 1) cell.dataset.label = titles[column] ?? ""; column += cell.colSpan; }
    }
  }
}

function themed() {
  const axis = { gridcolor: css("--grid"), linecolor: css("--line"), tickcolor: css("--line") };
  const look = { "font.color": css("--soft"), "font.family": getComputedStyle(document.body).fontFamily,
    "hoverlabel.bgcolor": css("--card"), "hoverlabel.bordercolor": css("--line"), "hoverlabel.font.color": css("--ink"), "hoverlabel.align": "left" };
  for (const [key, value] of Object.entries(axis)) { look[`xaxis.${key}`] = value; look[`yaxis.${key}`] = value; }
  return look;
}

function forScreen(layout) {
  if (!narrow()) return layout;
  const below = { orientation: "h", y: -0.22, yanchor: "top", font: { size: 11 }, groupclick: "toggleitem" };
  const title = { ...layout.xaxis?.title, font: { size: 11 } };  // one line of a phone
  title.text = title.text?.replace(/^(.{20,44}?) (?=.{20})/, "$1<br>");
  return { ...layout, xaxis: { ...layout.xaxis, title }, legend: { ...layout.legend, ...below }, margin: { ...layout.margin, l: 52, r: 8 }, height: layout.height + 190 };
}

let library = null;
function plotly() {
  if (window.Plotly) return Promise.resolve(window.Plotly);
  library ??= new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = "plotly.js";
    script.onload = () => resolve(window.Plotly);
    script.onerror = () => reject(new Error("plotly.js is not beside this page"));
    document.head.append(script);
  });
  return library;
}

async function draw(div) {
  if (div.dataset.drawn) return;
  div.dataset.drawn = "yes";
  try {
    const Plotly = await plotly();
    const { data, layout } = JSON.parse(div.nextElementSibling.textContent);
    const options = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
    const fitted = forScreen(layout);
    div.style.minHeight = `${fitted.height}px`; // a responsive plot fills its box, and would be cut off by a lower one
    await Plotly.newPlot(div, data, fitted, options);
    Plotly.relayout(div, themed());
  } catch (error) { div.textContent = `This plot could not be drawn: ${error.message}.`; }
}

const near = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) { near.unobserve(entry.target); draw(entry.target); }
}, { rootMargin: "400px" });
// those near the screen first, the others once the browser is idle, so that a printed page has them, too
async function drawAll() {
  document.querySelectorAll(".plot").forEach((div) => near.observe(div));
  for (const div of document.querySelectorAll(".plot")) { await new Promise((next) => setTimeout(next)); if (div.isConnected) await draw(div); }
}

function drawnPlots() { return document.querySelectorAll(".plot[data-drawn]"); }

function everyMethod(event) {
  for (const div of drawnPlots()) {
    const detail = div.data.map((trace, k) => (trace.meta && trace.meta.detail ? k : -1)).filter((k) => k >= 0);
    if (detail.length) window.Plotly.restyle(div, { visible: event.target.checked ? true : "legendonly" }, detail);
  }
}

const short = (value) => (value === null ? "unknown" : value === 0 ? "0" : Number(value.toPrecision(2)) >= 0.01 && value < 1e4 ? String(Number(value.toPrecision(3))) : value.toExponential(1));
let rows = [];

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
  const found = choose(rows, bounds);
  if (!found.best) { node("p", refusal(found, bounds), out); return; }
  const { best, second, margin, limit } = found;
  const head = node("p", "", out);
  node("strong", `${named(best)}: ${short(best.ms)} ms`, head);
  if (best.ours) head.append(" by this project's own solver");
  head.append(` (error ${short(best.error)}, joints closed to ${short(best.compliance)} m, rad).`);
  node("p", second ? `Runner-up: ${named(second)}, at ${short(second.ms)} ms: ${short(margin)} times as long.` : "No other engine or method shown reaches it.", out);
  if (limit) node("p", limits(limit), out);
  const line = node("div", "", out);
  line.className = "line";
  node("code", best.command, line);
  const button = node("button", "copy", line);
  button.type = "button"; button.className = "copy"; button.dataset.command = best.command;
}

function refusal({ why, near, floor, count }, bounds) {
  if (why === "nothing") return "No run of the engines shown finished on this scene.";
  if (why === "floor") return `Errors below ${short(floor)} cannot be resolved: that is the uncertainty of this scene's truth. Request an error above it.`;
  if (why === "budget") return `None within ${short(bounds.ms)} ms; the cheapest is ${named(near)} at ${short(near.ms)} ms.`;
  if (why === "compliance") return `${count} settings reach the error, but none keeps the joints within ${short(bounds.compliance)} m, rad; the nearest is ${named(near)} with ${short(near.compliance)} m, rad.`;
  return `None reached this; the nearest is ${named(near)} with ${short(near.error)}.`;
}

function limits({ bound, cheaper }) {
  const off = bound === "error" ? `an error of ${short(cheaper.error)}` : `joints open by ${short(cheaper.compliance)} m, rad`;
  return `The ${bound} limits it: the nearest cheaper one is ${named(cheaper)}, at ${short(cheaper.ms)} ms with ${off}.`;
}

async function copy(button) {
  const text = button.dataset.command, told = button.textContent;
  try { await navigator.clipboard.writeText(text); } catch { copyBySelection(text); }
  button.textContent = "copied";
  setTimeout(() => { button.textContent = told; }, 1500);
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

function startPick(pick) {
  rows = JSON.parse(document.getElementById("pick-rows").textContent);
  pick.addEventListener("submit", (event) => event.preventDefault());
  pick.addEventListener("input", answer);
  answer();
}

function start() {
  fold();
  const pick = document.getElementById("pick");
  if (pick) startPick(pick);
  document.getElementById("every-method")?.addEventListener("change", everyMethod);
  if (narrow()) document.querySelectorAll("nav details").forEach((part) => { part.open = false; });
  drawAll();
}

// a report in one file holds its pages as templates; the fragment names the one that is shown
const whole = [...document.querySelectorAll("template[data-page]")];
const isAll = () => location.hash === `#${document.body.dataset.all}`;

function open() {
  const [file, place] = location.hash.slice(1).split("/").map(decodeURIComponent);
  const shown = isAll() ? whole : [whole.find((page) => page.dataset.page === file) ?? whole[0]];
  document.getElementById("shown").replaceChildren(...shown.map((page) => page.content.cloneNode(true)));
  document.body.classList.toggle("printed", isAll());
  start();
  if (place) document.getElementById(place)?.scrollIntoView(); else if (!isAll()) window.scrollTo(0, 0);
}

function follow(event) {
  const link = event.target.closest("a[href]");
  if (!link) return;
  const [file, place] = link.getAttribute("href").split("#");
  if (file && !whole.some((page) => page.dataset.page === file)) return;
  event.preventDefault();
  if (file) location.hash = place ? `${file}/${place}` : file; else document.getElementById(place)?.scrollIntoView();
}

document.addEventListener("click", (event) => { if (event.target.matches(".copy")) copy(event.target); });
if (whole.length) { document.addEventListener("click", follow); window.addEventListener("hashchange", open); open(); }
else start();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawnPlots().forEach((div) => window.Plotly.relayout(div, themed())));
window.addEventListener("beforeprint", () => isAll() || document.querySelectorAll("details").forEach((part) => { part.open = true; }));
