// ---- the rod ----

const hasContact = data.touches && data.runs.some((run) => "contact" in run.widths);
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
  const t = state.t / factor(run, "l/V");
  u.ctx.fillStyle = "#e8e4da";
  u.ctx.strokeStyle = "#8a8371";
  u.ctx.lineWidth = devicePixelRatio;
  for (const wall of run.walls) {
    u.ctx.beginPath();
    const there = (line) => (wall.motion ? lineAt(line, wall.motion, t) : line);
    for (const ring of wall.body) trace(u, there(ring), f);
    u.ctx.fill("evenodd");
    for (const line of wall.lines) polyline(u, there(line), f);
  }
}

// A star of eight rays.
function drawLamp(u, run, f) {
  if (!run.lamp) return;
  const [x, y] = ["x", "y"].map((axis, i) => u.valToPos(run.lamp[i] * f, axis, true)), ctx = u.ctx;
  ctx.beginPath();
  for (let k = 0; k < 16; k++) {
    const far = (k % 2 ? 3 : 8) * devicePixelRatio, angle = k * Math.PI / 8;
    ctx.lineTo(x + far * Math.cos(angle), y + far * Math.sin(angle));
  }
  ctx.closePath();
  ctx.fillStyle = "#f0c000";
  ctx.fill();
  ctx.strokeStyle = "#8a6d00";
  ctx.lineWidth = devicePixelRatio;
  ctx.stroke();
}

// Arrows of forces, of which `strongest` is the longest; they begin at their places, or end there.
function drawForces(u, places, forces, strongest, colour, f, end) {
  const scale = ARROW_SHARE * u.bbox.width / strongest, ctx = u.ctx;
  for (let i = 0; i < places.length; i += 2) {
    const dx = forces[i] * scale, dy = -forces[i + 1] * scale;
    if (Math.hypot(dx, dy) < 2 * devicePixelRatio) continue;
    const x = u.valToPos(places[i] * f, "x", true) - (end ? dx : 0);
    const y = u.valToPos(places[i + 1] * f, "y", true) - (end ? dy : 0);
    arrowPath(ctx, x, y, dx, dy, Math.min(0.35, 7 * devicePixelRatio / Math.hypot(dx, dy)));
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
  const shape = bodyAt(run, state.t / factor(run, "l/V")), f = factor(run, "l"), ctx = u.ctx;
  const thick = Math.abs(u.valToPos(run.diameter * f, "x", true) - u.valToPos(0, "x", true));
  ctx.globalAlpha = ended(run) ? 0.4 : 1;  // it stands where its run has ended
  if (element("friction").checked) drawForces(u, shape.places, shape.friction, strongest("drag") / factor(run, "N"), "#777", f, false);
  ctx.lineWidth = Math.max((shownField() ? 5 : 2.5) * devicePixelRatio, thick);
  ctx.strokeStyle = several ? run.colour : "#333";
  polyline(u, shape.x, f);
  ctx.lineWidth = Math.max(3.4 * devicePixelRatio, thick - 1.6 * devicePixelRatio);
  if (!shownField() && thick > 6 * devicePixelRatio) {  // strands that touch stay apart for the eye
    ctx.lineWidth = thick - 2 * devicePixelRatio;
    ctx.strokeStyle = pale(run.colour);
    polyline(u, shape.x, f);
    ctx.lineWidth = thick - 1.6 * devicePixelRatio;
  }
  const field = data.fields[shownField()], along = field && shape.fields[shownField()];
  for (let i = 0; along && i + 1 < along.length; i++) {
    ctx.strokeStyle = rgb(shade((along[i] + along[i + 1]) / 2, field));
    polyline(u, shape.x.subarray(2 * i, 2 * i + 4), f);
  }
  if (shape.contact && element("contact").checked)
    drawForces(u, shape.touched, shape.contact, strongest("press") / factor(run, "N"), "#C2410C", f, true);
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
  for (const run of shown) drawLamp(u, run, factor(run, "l"));
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
  if (rod) rod.destroy(); else offerFields();
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

// The colours with their numbers, and how strong the longest arrows are.
function makeBar() {
  makeRamp();
  const long = ARROW_SHARE * rod.bbox.width / devicePixelRatio;
  for (const [id, kind, there] of [["friction", "drag", true], ["contact", "press", hasContact]]) {
    const key = element(`${id}-key`);
    key.hidden = !there || !element(id).checked;
    key.querySelector("i").style.width = `${long}px`;
    key.querySelector("b").textContent = `${id} ${number(strongest(kind))} ${named("N") || "per length"}`;
  }
}

