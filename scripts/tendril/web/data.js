"use strict";
// The page of scripts/view.sh. `data` is what page.py wrote: runs, with arrays as base64 of 32-bit
// numbers, all dimensionless; charts, which series are drawn together; units of the laboratory.
const data = JSON.parse(document.getElementById("data").textContent);
const element = (id) => document.getElementById(id);
// t in the units that are shown; dragged: the chart in which the mouse is held down
const state = { t: 0, lab: data.lab, playing: false, dragged: null };
const PLAY_SECONDS = 12, DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3]];
const ARROW_SHARE = 1 / 12;  // of the picture's width: the strongest friction, or contact

function unpack(run) {
  run.shown = true;
  for (const table of [run.series, run.shapes])
    for (const name of Object.keys(table)) table[name] = floats(table[name]);
  run.along = {};
  for (const [name, { most, values }] of Object.entries(run.fields)) {  // 16 bits a number, in parts of the largest
    const bytes = Uint8Array.from(atob(values), (c) => c.charCodeAt(0));
    run.along[name] = Float32Array.from(new Int16Array(bytes.buffer), (v) => v * most / 32767);
  }
  run.end = run.series.t[run.series.t.length - 1];
}

const several = data.runs.length > 1;
// of a unit of the file, "l" or "N l": what its numbers are multiplied by, and the name to be shown
const factor = (run, unit) => (state.lab && run.factors[unit]) || 1;
const named = (unit) => (state.lab && data.units[unit]) || (unit === "rad" ? unit : "");
const withUnit = (text, unit) => (named(unit) ? `${text} (${named(unit)})` : text);
// the longest arrow of all runs, "drag" or "press", in the unit that is shown; each run has it in its own
const strongest = (kind) => Math.max(...data.runs.map((run) => run[kind] * factor(run, "N"))) || 1;
const lastTime = () => Math.max(...data.runs.map((run) => run.end * factor(run, "l/V")));

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

// A series of a run at a time, straight on between steps; beyond its ends what it is there.
function valueAt(run, name, t) {
  const [k, w] = locate(run.series.t, t), y = run.series[name];
  return w ? y[k] * (1 - w) + y[k + 1] * w : y[k];
}

// The numbers of the table at the time that is shown, as texts: of each row the runs.
function numbersNow() {
  return data.follows.map(([, unit, name]) => data.runs.map((run) => (name in run.series
    ? number(valueAt(run, name, state.t / factor(run, "l/V")) * factor(run, unit)) : "–")));
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

// The same with the scalars along it, `fields`.
function bodyAt(run, t) {
  const shape = shapeAt(run, t), [k, w] = stored(run, t);
  shape.fields = {};
  for (const [name, all] of Object.entries(run.along)) {
    const width = run.nodes, a = k * width, b = (w ? k + 1 : k) * width;
    shape.fields[name] = Float32Array.from({ length: width }, (_, i) => all[a + i] * (1 - w) + all[b + i] * w);
  }
  return shape;
}

const shownField = () => element("field").value;
const shade = (value, { most, signed: sign }) => (sign ? signed(SIGNED, value, most) : mixed(RISING, saturation(value, most)));

// What the colours may show.
function offerFields() {
  for (const [name, field] of Object.entries(data.fields)) element("field").append(new Option(field.label, name));
  if (several) element("field").prepend(new Option("which run", "", true, true));
  element("field").onchange = () => { makeBar(); rod.redraw(); };
}

// The colours of the field that is shown, with its numbers.
function makeRamp() {
  const field = data.fields[shownField()], ticks = element("ticks");
  element("ramp").hidden = element("bar-label").hidden = !field;
  if (!field) return;
  const unit = factor(data.runs[0], field.unit), most = field.most * unit;
  const place = (v) => (field.signed ? 50 + 50 * Math.sign(v) * saturation(v / unit, field.most)
    : 100 * saturation(v / unit, field.most));
  const inner = [];
  for (let power = Math.floor(Math.log10(most)); power > Math.log10(most) - 2; power--)
    if (Math.abs(place(10 ** power) - (inner.length ? place(inner.at(-1)) : 100)) > 14) inner.push(10 ** power);
  const values = [most, ...inner.filter((v) => place(v) > (field.signed ? 60 : 14) && place(v) < 88)];
  element("ramp").style.background = `linear-gradient(to right, ${(field.signed ? SIGNED : RISING).map(rgb)})`;
  ticks.replaceChildren(...[...(field.signed ? values.map((v) => -v) : []), 0, ...values].map((v) => {
    const label = document.createElement("span");
    label.style.left = `${place(v)}%`;
    label.textContent = number(v);
    return label;
  }));
  element("bar-label").textContent = named(field.unit) && `(${named(field.unit)})`;
}

// Where what moves as given in time is then (courses.py): by polynomials between knots, evenly beyond them.
function along({ knots, pieces, ends }, t) {
  const last = knots.length - 1, within = Math.min(Math.max(t, knots[0]), knots[last]);
  let k = 0;
  while (k < last - 1 && knots[k + 1] <= within) k++;
  return ends[t > within ? 1 : 0].map((rate, d) =>
    pieces[k].reduce((sum, coefficient) => sum * (within - knots[k]) + coefficient[d], 0) + rate * (t - within));
}

// How far what moves has been carried along at a time.
const shiftOf = ({ shift, moves = [0, 0, 0] }, t) => (shift ? along(shift, t) : moves.map((v) => v * t));

// By what angle it has turned.
const turnedBy = ({ angle, turns = [0] }, t) => (angle ? along(angle, t)[0] : turns[0] * t);

// A line of a wall of the plane, [x, y, x, y, ...], where that is at a time.
function lineAt(line, motion, t) {
  const [dx, dy] = shiftOf(motion, t), [, x0, y0, , , , up] = motion.turns || [0, 0, 0, 0, 0, 0, 1], angle = Math.sign(up) * turnedBy(motion, t);
  const c = Math.cos(angle), s = Math.sin(angle);
  return line.map((_, i) => {
    const k = i - i % 2, x = line[k] - x0, y = line[k + 1] - y0;
    return i % 2 ? y0 + s * x + c * y + dy : x0 + c * x - s * y + dx;
  });
}
