"use strict";
// The page of scripts/view.sh. `data` is what page.py wrote: runs, with arrays as base64 of 32-bit
// numbers, all dimensionless; charts, which series are drawn together; units of the laboratory.
const data = JSON.parse(document.getElementById("data").textContent);
const element = (id) => document.getElementById(id);
// t in the units that are shown; dragged: the chart in which the mouse is held down
const state = { t: 0, lab: false, playing: false, dragged: null };
const PLAY_SECONDS = 12, DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3]];
const ARROW_SHARE = 1 / 12;  // of the picture's width: the strongest friction, or contact

function floats(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

function unpack(run) {
  run.shown = true;
  for (const table of [run.series, run.shapes])
    for (const name of Object.keys(table)) table[name] = floats(table[name]);
  run.end = run.series.t[run.series.t.length - 1];
}

const several = data.runs.length > 1;
// of a unit of the file, "l" or "N l": what its numbers are multiplied by, and the name to be shown
const factor = (run, unit) => (state.lab && run.factors[unit]) || 1;
const named = (unit) => (state.lab && data.units[unit]) || (unit === "rad" ? unit : "");
const withUnit = (text, unit) => (named(unit) ? `${text} (${named(unit)})` : text);
const lastTime = () => Math.max(...data.runs.map((run) => run.end * factor(run, "l/V")));

function number(v) {
  if (v === null || v === undefined || Number.isNaN(v)) return "–";
  const size = Math.abs(v);
  return size === 0 ? "0" : size >= 1e-3 && size < 1e5 ? String(+v.toPrecision(4)) : v.toExponential(2);
}

function tick(v) {
  const size = Math.abs(v);
  return v === null ? "" : size === 0 || (size >= 1e-3 && size < 1e5) ? String(+v.toPrecision(6))
    : v.toExponential().replace("e+", "e");
}

// The last index whose value is not above t, and how far t is on the way to the next.
function locate(values, t) {
  let low = 0, high = values.length - 1;
  if (t >= values[high]) return [high, 0];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= t) low = middle; else high = middle;
  }
  return [low, Math.max(0, (t - values[low]) / (values[high] - values[low]))];
}

// Which stored shapes are shown at a time: [the one before, the share of the next]. Where a straight motion
// between the two is not what the run did (run.shapes.fair), the nearest alone.
function stored(run, t) {
  const [k, w] = locate(run.shapes.t, t);
  if (w === 0 || run.shapes.fair[k]) return [k, w];
  return w < 0.5 ? [k, 0] : [k + 1, 0];
}

// The rod at a time; of each array of `shapes` the row.
function shapeAt(run, t) {
  const [k, w] = stored(run, t), shape = {};
  for (const [name, width] of Object.entries(run.widths)) {
    const all = run.shapes[name], a = k * width, b = (w ? k + 1 : k) * width;
    shape[name] = Float32Array.from({ length: width }, (_, i) => all[a + i] * (1 - w) + all[b + i] * w);
  }
  return shape;
}

// ---- the rod ----

const hasContact = data.runs.some((run) => "contact" in run.widths);
let rod = null;  // uPlot draws its axes, the hook below the rod itself

function limits(x) {
  let low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (let i = 0; i < x.length; i++) {
    low[i % 2] = Math.min(low[i % 2], x[i]);
    high[i % 2] = Math.max(high[i % 2], x[i]);
  }
  return [low, high];
}

// [x1 limits, x2 limits] of what is to be seen, in the units shown: the whole run, or the present shape
function view() {
  let low = [0, 0], high = [0, 0];
  for (const run of data.runs.filter((r) => r.shown)) {
    const f = factor(run, "l");
    const x = element("follow").checked ? shapeAt(run, state.t / factor(run, "l/V")).x : run.shapes.x;
    const [a, b] = limits(x);
    for (const d of [0, 1]) {
      low[d] = Math.min(low[d], a[d] * f);
      high[d] = Math.max(high[d], b[d] * f);
    }
  }
  const room = 0.06 * Math.max(high[0] - low[0], high[1] - low[1], 1e-9);
  return [0, 1].map((d) => [low[d] - room, high[d] + room]);
}

// The limits widened until both axes have the same scale on the screen.
function equalScales(u) {
  const box = u.bbox, ratio = box.height / box.width;
  let [x, y] = view();
  const wide = Math.max(x[1] - x[0], (y[1] - y[0]) / ratio);
  return [[x, wide], [y, wide * ratio]].map(([v, size]) =>
    [(v[0] + v[1] - size) / 2, (v[0] + v[1] + size) / 2]);
}

const ENDS = [[180, 4, 38], [221, 221, 221], [59, 76, 192]];  // compression, none, tension
// Where a force stands between none and the strongest, 0 to 1: small ones are told apart, too. The colour
// bar has its numbers at these places.
const saturation = (force) => Math.asinh(20 * Math.abs(force) / data.strongest) / Math.asinh(20);

function shade(force) {
  const size = saturation(force);
  const end = force < 0 ? ENDS[0] : ENDS[2];
  const mix = ENDS[1].map((c, i) => Math.round(c + (end[i] - c) * Math.min(1, size)));
  return `rgb(${mix})`;
}

function trace(u, points, f) {
  for (let i = 0; i < points.length; i += 2) {
    const x = u.valToPos(points[i] * f, "x", true), y = u.valToPos(points[i + 1] * f, "y", true);
    if (i) u.ctx.lineTo(x, y); else u.ctx.moveTo(x, y);
  }
}

function polyline(u, points, f) {
  u.ctx.beginPath();
  trace(u, points, f);
  u.ctx.stroke();
}

function drawWalls(u, run, f) {
  u.ctx.fillStyle = "#e8e4da";
  u.ctx.strokeStyle = "#8a8371";
  u.ctx.lineWidth = devicePixelRatio;
  for (const wall of run.walls) {
    u.ctx.beginPath();
    for (const ring of wall.body) trace(u, ring, f);
    u.ctx.fill("evenodd");
    for (const line of wall.lines) polyline(u, line, f);
  }
}

// Arrows of forces, of which `strongest` is the longest; they begin at their places, or end there.
function drawForces(u, places, forces, strongest, colour, f, end) {
  const scale = ARROW_SHARE * u.bbox.width / strongest, ctx = u.ctx;
  for (let i = 0; i < places.length; i += 2) {
    const dx = forces[i] * scale, dy = -forces[i + 1] * scale;
    if (Math.hypot(dx, dy) < 2 * devicePixelRatio) continue;
    const x = u.valToPos(places[i] * f, "x", true) - (end ? dx : 0);
    const y = u.valToPos(places[i + 1] * f, "y", true) - (end ? dy : 0);
    const head = Math.min(0.35, 7 * devicePixelRatio / Math.hypot(dx, dy));  // of the arrow
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(x + dx, y + dy);
    ctx.lineTo(x + dx - head * (dx - 0.5 * dy), y + dy - head * (dy + 0.5 * dx));
    ctx.moveTo(x + dx, y + dy);
    ctx.lineTo(x + dx - head * (dx + 0.5 * dy), y + dy - head * (dy - 0.5 * dx));
    for (const [stroke, width] of [["#fffc", 3.2], [colour, 1.3]]) {  // a rim, over whatever it is drawn
      ctx.strokeStyle = stroke;
      ctx.lineWidth = width * devicePixelRatio;
      ctx.stroke();
    }
  }
}

const ended = (run) => state.t / factor(run, "l/V") > run.end * (1 + 1e-6);

function pale(colour) {
  const part = (i) => Math.round((parseInt(colour.slice(i, i + 2), 16) + 255) / 2);
  return `rgb(${[1, 3, 5].map(part)})`;
}

function drawRun(u, run) {
  const shape = shapeAt(run, state.t / factor(run, "l/V")), f = factor(run, "l"), ctx = u.ctx;
  const thick = Math.abs(u.valToPos(run.diameter * f, "x", true) - u.valToPos(0, "x", true));
  ctx.globalAlpha = ended(run) ? 0.4 : 1;  // it stands where its run has ended
  if (element("friction").checked) drawForces(u, shape.places, shape.friction, data.drag, "#777", f, false);
  ctx.lineWidth = Math.max((several ? 2.5 : 5) * devicePixelRatio, thick);
  ctx.strokeStyle = several ? run.colour : "#333";
  polyline(u, shape.x, f);
  ctx.lineWidth = Math.max(3.4 * devicePixelRatio, thick - 1.6 * devicePixelRatio);
  if (several && thick > 6 * devicePixelRatio) {  // strands that touch stay apart for the eye
    ctx.lineWidth = thick - 2 * devicePixelRatio;
    ctx.strokeStyle = pale(run.colour);
    polyline(u, shape.x, f);
    ctx.lineWidth = thick - 1.6 * devicePixelRatio;
  }
  for (let i = 0; !several && i + 1 < shape.axial.length; i++) {
    ctx.strokeStyle = shade((shape.axial[i] + shape.axial[i + 1]) / 2);
    polyline(u, shape.x.subarray(2 * i, 2 * i + 4), f);
  }
  if (shape.contact && element("contact").checked)
    drawForces(u, shape.touched, shape.contact, data.press, "#C2410C", f, true);
  ctx.globalAlpha = 1;
}

function drawRods(u) {
  u.ctx.save();
  u.ctx.beginPath();
  u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
  u.ctx.clip();
  u.ctx.lineCap = u.ctx.lineJoin = "round";
  const shown = data.runs.filter((run) => run.shown);
  for (const run of shown) drawWalls(u, run, factor(run, "l"));
  for (const run of shown) drawRun(u, run);
  const x = u.valToPos(0, "x", true), y = u.valToPos(0, "y", true), size = 8 * devicePixelRatio;
  u.ctx.fillStyle = "#000";
  u.ctx.fillRect(x - size / 2, y - size / 2, size, size);  // the clamp
  u.ctx.restore();
}

function rodSize() {
  const width = element("rod").clientWidth, [x, y] = view();
  const aspect = Math.min(1, Math.max(0.35, (y[1] - y[0]) / (x[1] - x[0])));
  return { width, height: Math.min(width * aspect + 50, Math.max(260, 0.6 * innerHeight)) };
}

function makeRod() {
  if (rod) rod.destroy();
  const range = (d) => (u) => equalScales(u)[d];
  rod = new uPlot({
    ...rodSize(), legend: { show: false }, cursor: { show: false },
    scales: { x: { time: false, range: range(0) }, y: { range: range(1) } },
    axes: [{ label: withUnit("x₁", "l"), labelSize: 20, size: 34 },
           { label: withUnit("x₂", "l"), labelSize: 20, size: 50 }],
    series: [{}, { show: false }], hooks: { draw: [drawRods] },
    padding: [8, 16, 0, 0],  // fixed, so that the box is what the limits were made for
  }, [[0, 1], [0, 0]], element("rod"));
  makeBar();
}

// The colours of the axial force with its numbers, and how strong the longest arrows are.
function makeBar() {
  const unit = factor(data.runs[0], "N l"), most = data.strongest * unit, ticks = element("ticks");
  const place = (v) => 50 + 50 * Math.sign(v) * saturation(v / unit);
  const inner = [];
  for (let power = Math.floor(Math.log10(most)); power > Math.log10(most) - 2; power--)
    if (Math.abs(place(10 ** power) - (inner.length ? place(inner.at(-1)) : 100)) > 14) inner.push(10 ** power);
  const values = [most, ...inner.filter((v) => place(v) > 60 && place(v) < 88)];
  ticks.replaceChildren(...[...values.map((v) => -v), 0, ...values].map((v) => {
    const label = document.createElement("span");
    label.style.left = `${place(v)}%`;
    label.textContent = number(v);
    return label;
  }));
  element("bar-label").textContent = withUnit("axial force, compression < 0", "N l");
  const long = ARROW_SHARE * rod.bbox.width / devicePixelRatio;
  for (const [id, strongest, there] of [["friction", data.drag, true], ["contact", data.press, hasContact]]) {
    const key = element(`${id}-key`), f = factor(data.runs[0], "N");
    key.hidden = !there || !element(id).checked;
    key.querySelector("i").style.width = `${long}px`;
    key.querySelector("b").textContent = `${id} ${number(strongest * f)} ${named("N") || "per length"}`;
  }
}

// ---- the curves ----

let charts = [];

// The times of all runs that are shown, and a series of a run at these; null beyond its ends.
function commonTimes(runs) {
  const all = new Set();
  for (const run of runs) for (const t of run.series.t) all.add(t * factor(run, "l/V"));
  return Float64Array.from(all).sort();
}

function resample(run, name, unit, times, log) {
  const t = run.series.t, y = run.series[name], ft = factor(run, "l/V"), fy = factor(run, unit);
  return Array.from(times, (time) => {
    if (time / ft > run.end * (1 + 1e-6)) return null;
    const [k, w] = locate(t, time / ft);
    const value = (w ? y[k] * (1 - w) + y[k + 1] * w : y[k]) * fy;
    return log && !(value > 0) ? null : value;
  });
}

function columns(chart, runs, times) {
  const lines = [], values = [];
  runs.forEach((run) => chart.series.forEach((name, i) => {
    if (!(name in run.series) || run.series[name].every((v) => v === 0) && !data.runs.some((other) =>
      other.series[name] && other.series[name].some((v) => v !== 0))) return;
    lines.push({
      label: several ? (chart.series.length > 1 ? `${run.name}, ${data.symbols[name]}` : run.name)
        : chart.series.length > 1 ? data.symbols[name] : data.names[name],
      stroke: several ? run.colour : data.colours[i % data.colours.length],
      dash: several ? DASHES[i % DASHES.length] : [], width: 1.5, points: { show: false }, name, run,
      value: (u, v) => number(v),
    });
    values.push(resample(run, name, chart.unit, times, chart.log));
  }));
  return [lines, values];
}

// On a logarithmic axis only decades, and of many only some, have a line and a number.
function decades(u, splits) {
  const [low, high] = [u.scales.y.min, u.scales.y.max].map(Math.log10);
  const every = Math.max(1, Math.ceil((high - low) / 6));
  return splits.map((v) => {
    const power = Math.log10(v);
    return Math.abs(power - Math.round(power)) < 1e-9 && Math.round(power) % every === 0 ? v : null;
  });
}

function valueAxis(log) {
  const axis = { size: 58, values: (u, ticks) => ticks.map(tick) };
  return log ? { ...axis, space: 1, filter: decades, grid: { filter: decades }, ticks: { filter: decades } } : axis;
}

// The value of a series that is the same throughout all runs; else undefined.
function constant(name) {
  const all = data.runs.map((run) => run.series[name]).filter(Boolean), v = all[0][0];
  return all.every((values) => values.every((one) => one === v)) ? v : undefined;
}

// In the legend a piece of each line, so that its dashes can be told.
function showDashes(u, lines) {
  u.root.querySelectorAll(".u-legend .u-series").forEach((row, i) => {
    if (!i) return;
    const { stroke, dash, name } = lines[i - 1], marker = row.querySelector(".u-marker");
    marker.style.border = "none";
    marker.innerHTML = `<svg width="26" height="8"><line x1="0" y1="4" x2="26" y2="4" stroke="${stroke}"
      stroke-width="2" stroke-dasharray="${dash.join(" ")}"/></svg>`;
    row.title = `${data.names[name]}: ${data.notes[name]}`;
  });
}

// A dot where a run ends before the others.
function markEnds(u, lines) {
  lines.forEach(({ run, stroke }, i) => {
    if (run.end * factor(run, "l/V") > lastTime() * (1 - 1e-6)) return;
    const [times, values] = [u.data[0], u.data[i + 1]];
    let k = values.length - 1;
    while (k > 0 && values[k] === null) k--;
    if (values[k] === null || !Number.isFinite(u.valToPos(values[k], "y", true))) return;
    u.ctx.beginPath();
    u.ctx.arc(u.valToPos(times[k], "x", true), u.valToPos(values[k], "y", true), 3.5 * devicePixelRatio, 0, 7);
    u.ctx.fillStyle = stroke;
    u.ctx.fill();
  });
}

function makeChart(chart, runs, times) {
  if (chart.series.every((name) => constant(name) !== undefined)) return null;
  const [lines, values] = columns(chart, runs, times);
  if (!values.length) return null;
  const box = document.createElement("div");
  box.className = "chart";
  box.innerHTML = "<h2></h2>";
  box.firstChild.textContent = withUnit(chart.title, chart.unit);
  element("charts").append(box);
  const u = new uPlot({
    width: box.clientWidth, height: 210,
    pxAlign: 0,  // lines go where their points are, not to whole pixels
    cursor: {
      // who drags out of one chart into another is still in the first
      sync: { key: "time", filters: { pub: (type, u) => !state.dragged || state.dragged === u } },
      drag: { x: true, y: false, click: () => {} },  // else the first click after it is lost
      y: false,
    },
    scales: { x: { time: false }, y: chart.log ? { distr: 3 } : {} },
    axes: [{ size: 32 }, valueAxis(chart.log)],
    series: [{ label: withUnit("t", "l/V"), value: (u, v) => number(v) }, ...lines],
    hooks: { draw: [mark, (u) => markEnds(u, lines)] },
  }, [times, ...values], box);
  showDashes(u, lines);
  follow(u);
  return u;
}

// What the mouse, or a finger, does on a chart: a click goes to its time, a drag is uPlot's.
function follow(u) {
  let from = 0;
  u.over.addEventListener("mousedown", (event) => {
    from = event.clientX;
    state.dragged = u;
    if (state.playing) play();
  });
  u.over.addEventListener("click", (event) => {
    if (Math.abs(event.clientX - from) < 4)
      goTo(u.posToVal(event.clientX - u.over.getBoundingClientRect().left, "x"));
  });
  u.over.addEventListener("mouseleave", (event) => { if (!event.buttons) requestAnimationFrame(markTime); });
}

function makeCharts() {
  charts.forEach((u) => u.destroy());
  element("charts").replaceChildren();
  const runs = data.runs.filter((run) => run.shown), times = commonTimes(runs);
  charts = data.charts.map((chart) => makeChart(chart, runs, times)).filter(Boolean);
}

// ---- time, units, runs ----

function mark(u) {
  const left = u.valToPos(state.t, "x");
  if (Number.isFinite(left)) u.setCursor({ left, top: 10 }, false, false);  // once it has its scales
}

function markTime() {
  charts.forEach(mark);
}

function goTo(t) {
  state.t = Math.min(Math.max(t, 0), lastTime());
  element("slider").value = 1000 * state.t / lastTime();
  element("now").textContent = `t = ${number(state.t)} ${named("l/V")}`;
  tellShapes();
  rod.redraw(false, element("follow").checked);
  if (element("follow").checked) rod.setData(rod.data);  // takes its limits anew
  markTime();
}

// Which run has ended, and of which time the shape is where none is known in between.
function tellShapes() {
  for (const run of data.runs) if (run.note) run.note.textContent = ended(run) ? " (ended)" : "";
  const held = data.runs.filter((run) => run.shown && !ended(run)).map((run) => {
    const f = factor(run, "l/V"), [k, w] = stored(run, state.t / f), at = run.shapes.t[k] * f;
    return w === 0 && Math.abs(at - state.t) > 1e-3 * lastTime() ? at : null;
  }).filter((t) => t !== null);
  element("held").textContent = held.length ? `few shapes are stored: that of t = ${number(held[0])} is shown` : "";
}

function play() {
  state.playing = !state.playing;
  element("play").textContent = state.playing ? "❚❚" : "▶";
  if (state.playing && state.t >= lastTime() * 0.999) state.t = 0;
  let before = performance.now();
  const frame = (now) => {
    if (!state.playing) return;
    goTo(state.t + lastTime() * (now - before) / 1000 / PLAY_SECONDS);
    before = now;
    if (state.t >= lastTime()) play(); else requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

function redraw() {
  makeRod();
  makeCharts();
  makeAbout();
  goTo(state.t);
}

function changeUnits() {
  const part = state.t / lastTime();
  state.lab = element("lab").checked;
  state.t = part * lastTime();
  redraw();
}

function makeRuns() {
  for (const run of several ? data.runs : []) {
    const label = document.createElement("label"), box = document.createElement("input");
    const swatch = document.createElement("span");
    box.type = "checkbox";
    box.checked = true;
    box.onchange = () => {
      run.shown = box.checked;
      if (!data.runs.some((r) => r.shown)) box.checked = run.shown = true;  // one is always there
      redraw();
    };
    swatch.className = "swatch";
    swatch.style.background = run.colour;
    run.note = document.createElement("small");
    label.append(box, swatch, run.name, run.note);
    element("runs").append(label);
  }
}

function makeAbout() {
  const table = document.createElement("table"), about = element("about");
  table.className = "summary";
  const row = (cells, tag) => {
    const line = table.insertRow();
    for (const text of cells) line.appendChild(document.createElement(tag)).textContent = text;
    if (tag === "td") line.cells[0].outerHTML = `<th>${line.cells[0].innerHTML}</th>`;
  };
  if (several) row(["", ...data.runs.map((run) => run.name)], "th");
  for (const [text, unit] of data.summary)
    row([withUnit(text, unit), ...data.runs.map((run) => {
      const value = run.summary[text];
      return typeof value === "number" ? number(value * factor(run, unit)) : value ?? "–";
    })], "td");
  const open = Array.from(about.querySelectorAll("details"), (d) => d.open);
  const same = Object.keys(data.names).filter((name) => name !== "t" && constant(name) !== undefined);
  const note = document.createElement("p");
  note.className = "hint";
  const unitOf = (name) => (data.charts.find((chart) => chart.series.includes(name)) || { unit: "1" }).unit;
  note.textContent = same.length ? `The same throughout: ${same.map((name) => `${data.names[name]} ${
    number(constant(name) * factor(data.runs[0], unitOf(name)))} ${named(unitOf(name))}`.trim()).join(", ")}` : "";
  about.replaceChildren(table, note, ...data.runs.map((run, i) => {
    const details = document.createElement("details"), pre = document.createElement("pre");
    details.append(document.createElement("summary"), pre);
    details.firstChild.textContent = `options of ${run.name}`;
    details.open = Boolean(open[i]);
    pre.textContent = run.options;
    return details;
  }));
}

function connect() {
  element("play").onclick = play;
  element("slider").oninput = () => goTo(element("slider").value / 1000 * lastTime());
  element("lab").onchange = changeUnits;
  element("lab-label").hidden = Object.keys(data.units).length === 0;
  element("contact-label").hidden = !hasContact;
  for (const id of ["friction", "contact"])
    element(id).onchange = () => {
      makeBar();
      goTo(state.t);
    };
  element("follow").onchange = redraw;
  element("colours").hidden = several;
  element("friction").checked = !several;  // the arrows of many rods hide one another
  document.addEventListener("keydown", (event) => {
    if (event.code === "Space" && !["INPUT", "BUTTON", "SUMMARY"].includes(event.target.tagName)) {
      event.preventDefault();
      play();
    }
  });
  document.addEventListener("mouseup", () => requestAnimationFrame(() => {
    state.dragged = null;
    markTime();
  }));
  let width = innerWidth;  // a phone that hides its address bar changes the height alone
  addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; redraw(); } });
}

data.runs.forEach(unpack);
connect();
makeRuns();
state.t = lastTime();  // it opens on the last shape: what has come of it
redraw();
document.body.dataset.ready = "yes";
