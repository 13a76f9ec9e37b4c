// ---- the curves ----

let charts = [];

// The times of all runs that are shown, and a series of a run at these; null beyond its ends.
function commonTimes(runs) {
  const all = new Set();
  for (const run of runs) for (const t of run.series.t) all.add(t * factor(run, "l/V"));
  return Float64Array.from(all).sort();
}

function resample(run, name, unit, times, log) {
  const ft = factor(run, "l/V"), fy = factor(run, unit);
  return Array.from(times, (time) => {
    if (time / ft > run.end * (1 + 1e-6)) return null;
    const value = valueAt(run, name, time / ft) * fy;
    return log && !(value > 0) ? null : value;
  });
}

// The band in which a series is, as far as the run tells its errors; null: it does not.
function band(run, name, chart, times) {
  if (!(run.uncertain && name in run.uncertain)) return null;
  const [error, over] = run.uncertain[name], ft = factor(run, "l/V"), fy = factor(run, chart.unit);
  return [-1, 1].map((side) => Array.from(times, (time) => {
    if (time / ft > run.end * (1 + 1e-6)) return null;
    const value = valueAt(run, name, time / ft), size = over ? valueAt(run, over, time / ft) : Math.abs(value);
    const edge = (value + side * Math.min(1, valueAt(run, error, time / ft)) * size) * fy;
    return chart.log && !(edge > 0) ? null : edge;
  }));
}

function columns(chart, runs, times) {
  const lines = [], values = [], bands = [];
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
    const edges = band(run, name, chart, times), { stroke } = lines[lines.length - 1];
    if (!edges) return;
    bands.push({ series: [lines.length + 2, lines.length + 1], fill: stroke + "30" });
    for (const edge of edges) {
      lines.push({ stroke: "transparent", points: { show: false }, width: 0, name, run, edge: true, label: "" });
      values.push(edge);
    }
  }));
  return [lines, values, bands];
}

const MODELS = ["linear", "of the plane", "linear, then of the plane", "in space"];

// The value of a series that is the same throughout all runs; else undefined.
function constant(name) {
  const all = data.runs.map((run) => run.series[name]).filter(Boolean), v = all[0][0];
  return all.every((values) => values.every((one) => one === v)) ? v : undefined;
}

// In the legend a piece of each line, so that its dashes can be told.
function showDashes(u, lines) {
  u.root.querySelectorAll(".u-legend .u-series").forEach((row, i) => {
    if (!i) return;
    const { stroke, dash, name, edge } = lines[i - 1], marker = row.querySelector(".u-marker");
    if (edge) {
      row.style.display = "none";
      return;
    }
    marker.style.border = "none";
    marker.innerHTML = `<svg width="26" height="8"><line x1="0" y1="4" x2="26" y2="4" stroke="${stroke}"
      stroke-width="2" stroke-dasharray="${dash.join(" ")}"/></svg>`;
    row.title = `${data.names[name]}: ${data.notes[name]}`;
  });
}

// A dot where a run ends before the others.
function markEnds(u, lines) {
  lines.forEach(({ run, stroke, edge }, i) => {
    if (edge || run.end * factor(run, "l/V") > lastTime() * (1 - 1e-6)) return;
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
  const [lines, values, bands] = columns(chart, runs, times);
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
    series: [{ label: withUnit("t", "l/V"), value: (u, v) => number(v) }, ...lines], bands,
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
  tellNumbers();
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

// Where the table has the numbers that follow the time: of each row the cells of the runs.
let following = [];

function tellNumbers() {
  numbersNow().forEach((texts, i) => texts.forEach((text, k) => { following[i][k].textContent = text; }));
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
    return Array.from(line.cells).slice(1);
  };
  if (several) row(["", ...data.runs.map((run) => run.name)], "th");
  following = data.follows.map(([text, unit]) => row([withUnit(text, unit), ...data.runs.map(() => "")], "td"));
  row(["of the whole run", ...data.runs.map(() => "")], "th");
  for (const text of data.whole) row([text, ...data.runs.map((run) => String(run.summary[text]))], "td");
  const open = Array.from(about.querySelectorAll("details"), (d) => d.open);
  const same = Object.keys(data.names).filter((name) => name !== "t" && constant(name) !== undefined);
  const note = document.createElement("p");
  note.className = "hint";
  const unitOf = (name) => (data.charts.find((chart) => chart.series.includes(name)) || { unit: "1" }).unit;
  const told = (name) => (name === "model" ? MODELS[constant(name)] : `${number(constant(name) * factor(data.runs[0], unitOf(name)))} ${named(unitOf(name))}`);
  note.textContent = same.length ? `The same throughout: ${same.map((name) => `${data.names[name]} ${told(name)}`.trim()).join(", ")}` : "";
  const wide = matchMedia("(min-width: 1250px)").matches, more = document.createElement("div");
  more.className = "more";
  more.append(note, ...data.runs.map((run, i) => {
    const details = document.createElement("details"), pre = document.createElement("pre");
    details.append(document.createElement("summary"), pre);
    details.firstChild.textContent = `options of ${run.name}`;
    details.open = open[i] ?? (wide && !several);  // beside the summary there is room for them
    pre.textContent = run.options;
    return details;
  }));
  about.replaceChildren(table, more);
}

function connect() {
  element("play").onclick = play;
  element("slider").oninput = () => goTo(element("slider").value / 1000 * lastTime());
  element("lab").checked = state.lab;
  element("lab").onchange = changeUnits;
  element("lab-label").hidden = Object.keys(data.units).length === 0;
  element("contact-label").hidden = !hasContact;
  for (const id of ["friction", "contact"])
    element(id).onchange = () => {
      makeBar();
      goTo(state.t);
    };
  element("follow").onchange = redraw;
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
