// A sweep or a fit while it goes on (tendril/watching.py): a map or a curve that fills, with the rod of the member pointed at;
// the rods that a fit tries, over the points of photographs. mountStudy(element, first message): {hear(message)}.
const MAP = [[0, 32, 77], [60, 77, 110], [124, 123, 120], [187, 173, 108], [255, 233, 69]];  // cividis: told apart by all eyes
const TRIED = "rgba(90, 90, 90, 0.35)", BEST = "#0072B2", MEASURED = "#D55E00", BAD = "#A61B1B";
const OF_STEPS = /^(step|model|newton_iterations|t)$|^error_/;

function canvasOf(label, ratio) {
  const canvas = make("canvas", { "aria-label": label, role: "img" });
  canvas.style.cssText = `display: block; width: 100%; aspect-ratio: ${ratio};`;
  return canvas;
}

// A canvas ready to be drawn on: [context, width, height] in its own pixels.
function ready(canvas) {
  const box = canvas.getBoundingClientRect(), ratio = devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(box.width * ratio));
  canvas.height = Math.max(1, Math.round(box.height * ratio));
  const ctx = canvas.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.font = "12px system-ui, sans-serif";
  ctx.lineJoin = ctx.lineCap = "round";
  return [ctx, box.width, box.height];
}

// Lines, each a list of x, y, ..., fitted into a canvas at one scale: what puts a place there.
function fitted(lists, stride, wide, high, down = false) {
  const low = [Infinity, Infinity], top = [-Infinity, -Infinity];
  for (const list of lists)
    for (let i = 0; i + 1 < list.length; i += stride)
      for (const d of [0, 1]) {
        low[d] = Math.min(low[d], list[i + d]);
        top[d] = Math.max(top[d], list[i + d]);
      }
  if (!(top[0] >= low[0])) return () => [0, 0];
  const scale = 0.88 * Math.min(wide / Math.max(top[0] - low[0], 1e-12), high / Math.max(top[1] - low[1], 0.05 * (top[0] - low[0]), 1e-12));
  return (x, y) => [wide / 2 + scale * (x - (low[0] + top[0]) / 2), high / 2 + (down ? 1 : -1) * scale * (y - (low[1] + top[1]) / 2)];
}

function strokeLine(ctx, place, list, stride) {
  ctx.beginPath();
  for (let i = 0; i + 1 < list.length; i += stride) ctx[i ? "lineTo" : "moveTo"](...place(list[i], list[i + 1]));
  ctx.stroke();
}

function mountStudy(root, first) {
  root.classList.add("l-all");
  const title = document.getElementById("title");
  if (title) title.textContent = `${first.name}: ${first.what === "sweep" ? "a sweep" : "a fit"}`;
  document.title = `${first.name}, ${first.what}`;
  const home = document.getElementById("home");
  if (home) home.hidden = true;
  const study = (first.what === "sweep" ? sweepPage : fitPage)(root, first);
  let waits = false;
  const draw = () => { waits = false; study.draw(); };
  const later = () => { if (!waits) { waits = true; requestAnimationFrame(draw); } };
  addEventListener("resize", later);
  root.study = study;
  later();
  return { hear: (m) => { study.take(m); later(); } };
}

// ---- a sweep ----

function sweepPage(root, m) {
  const S = { first: m, members: new Array(m.count).fill(null), ended: "", chosen: null, quantity: "width", fixed: m.axes.map(() => 0),
    get done() { return this.members.filter(Boolean).length; }, get failed() { return this.members.filter((one) => one && one.failed).length; } };
  const plotted = canvasOf("the quantity over the options that are varied; an arrow key or a tap chooses a run", 1.35), rod = canvasOf("the rod of the run that is chosen", 1.9);
  plotted.tabIndex = 0;
  const told = make("p", { className: "l-told", role: "status" }), about = make("p", { className: "hint" }), end = make("pre", { className: "l-report" });
  const quantity = make("select", { "aria-label": "quantity", onchange: () => { S.quantity = quantity.value; draw(); } });
  const others = m.axes.slice(2).map((axis, j) => make("label", {}, `${axis.label} `, make("select", { "aria-label": axis.name, onchange: (e) => { S.fixed[j + 2] = +e.target.value; draw(); } },
    ...axis.texts.map((text, i) => make("option", { value: i, textContent: text })))));
  root.replaceChildren(make("div", { className: "l-run" }, make("div", {}, told, make("div", { className: "l-bar" }, make("label", {}, "shown: ", quantity), ...others), plotted, about), make("div", {}, rod, end)));

  const value = (k) => (S.members[k] && !S.members[k].failed ? S.members[k].values[S.quantity] : undefined);
  const member = (place) => m.points.findIndex((p) => p.every((i, d) => i === place[d]));
  const shown = () => m.points.map((p, k) => k).filter((k) => m.points[k].every((i, d) => d < 2 || i === S.fixed[d]));
  const words = (k) => m.axes.map((axis, d) => `${axis.label} ${axis.texts[m.points[k][d]]}`).join(", ");

  function take(one) {
    if (one.kind === "ended") S.ended = one.text;
    if (one.kind !== "member") return;
    S.members[one.k] = { ...one, x: one.x ? floats(one.x) : null };
    if (S.chosen === null || !S.picked) S.chosen = one.k;
    const names = Object.keys(one.values).filter((name) => !OF_STEPS.test(name));
    if (!quantity.options.length && names.length) {
      if (!names.includes(S.quantity)) S.quantity = names[0];
      quantity.replaceChildren(...names.map((name) => make("option", { value: name, textContent: name.replace(/_/g, " "), selected: name === S.quantity })));
    }
  }

  const margin = { left: 64, right: 92, top: 12, bottom: 46 };
  let cells = [];
  function draw() {
    told.innerHTML = `<span><b>${S.done}</b> of ${m.count} runs${S.failed ? `, <b style="color: ${BAD}">${S.failed} failed</b>` : ""}${S.ended ? `; ${S.ended}` : ""}</span>`;
    const [ctx, wide, high] = ready(plotted), known = shown().map(value).filter((v) => v !== undefined);
    const low = Math.min(...known), top = Math.max(...known), unit = S.members.find((one) => one && one.units[S.quantity]);
    const name = `${S.quantity.replace(/_/g, " ")}${unit && unit.units[S.quantity] !== "1" ? ` (${unit.units[S.quantity]})` : ""}`;
    cells = [];
    ctx.textAlign = "center";
    if (m.axes.length === 1) drawCurve(ctx, wide, high, low, top, name); else drawMap(ctx, wide, high, low, top, name);
    drawChosen();
  }

  function drawMap(ctx, wide, high, low, top, name) {
    const [a, b] = m.axes, w = (wide - margin.left - margin.right) / a.texts.length, h = (high - margin.top - margin.bottom) / b.texts.length;
    for (const k of shown()) {
      const [i, j] = m.points[k], x = margin.left + i * w, y = high - margin.bottom - (j + 1) * h, v = value(k), one = S.members[k];
      cells.push({ k, x, y, w, h });
      ctx.fillStyle = one ? (one.failed ? "#f3d9d4" : rgb(mixed(MAP, top > low ? (v - low) / (top - low) : 0.5))) : "#f4f4f2";
      ctx.fillRect(x + 0.5, y + 0.5, w - 1, h - 1);
      if (one && one.failed && w > 12) { ctx.fillStyle = BAD; ctx.fillText("✕", x + w / 2, y + h / 2 + 4); }
      if (k === S.chosen) { ctx.strokeStyle = "#D55E00"; ctx.lineWidth = 3; ctx.strokeRect(x + 1.5, y + 1.5, w - 3, h - 3); }
    }
    ctx.fillStyle = "#222";
    const each = (n, room) => Math.ceil(n * 44 / room);
    a.texts.forEach((text, i) => { if (i % each(a.texts.length, w * a.texts.length) === 0) ctx.fillText(text, margin.left + (i + 0.5) * w, high - margin.bottom + 16); });
    ctx.textAlign = "right";
    b.texts.forEach((text, j) => { if (j % each(b.texts.length, 2.4 * h * b.texts.length) === 0) ctx.fillText(text, margin.left - 6, high - margin.bottom - (j + 0.5) * h + 4); });
    ctx.textAlign = "center";
    ctx.fillText(a.label, (margin.left + wide - margin.right) / 2, high - 10);
    ctx.save(); ctx.translate(13, (margin.top + high - margin.bottom) / 2); ctx.rotate(-Math.PI / 2); ctx.fillText(b.label, 0, 0); ctx.restore();
    if (!(top >= low)) return;
    const tall = high - margin.top - margin.bottom, x = wide - margin.right + 14;
    for (let i = 0; i < 60; i++) { ctx.fillStyle = rgb(mixed(MAP, 1 - i / 59)); ctx.fillRect(x, margin.top + i * tall / 60, 12, tall / 60 + 1); }
    ctx.fillStyle = "#222"; ctx.textAlign = "left";
    ctx.fillText(number(top), x + 16, margin.top + 10); ctx.fillText(number(low), x + 16, margin.top + tall);
    ctx.save(); ctx.translate(wide - 8, margin.top + tall / 2); ctx.rotate(-Math.PI / 2); ctx.textAlign = "center"; ctx.fillText(name, 0, 0); ctx.restore();
  }

  function drawCurve(ctx, wide, high, low, top, name) {
    const [axis] = m.axes, at = axis.numbers || axis.texts.map((_, i) => i), from = Math.min(...at), to = Math.max(...at), right = 20;
    const log = axis.numbers && from > 0 && to > 20 * from, along = (v) => (log ? Math.log(v / from) / Math.log(to / from) : to > from ? (v - from) / (to - from) : 0.5);
    const X = (v) => margin.left + 14 + along(v) * (wide - margin.left - right - 28), Y = (v) => (top > low ? high - margin.bottom - 10 - (v - low) / (top - low) * (high - margin.top - margin.bottom - 24) : high / 2);
    ctx.strokeStyle = "#ccc"; ctx.lineWidth = 1;
    ctx.strokeRect(margin.left, margin.top, wide - margin.left - right, high - margin.top - margin.bottom);
    ctx.fillStyle = "#222";
    const every = Math.max(1, Math.ceil(at.length * 52 / (wide - margin.left)));
    axis.texts.forEach((text, i) => { if (i % every === 0) ctx.fillText(text, X(at[i]), high - margin.bottom + 18); });
    ctx.fillText(axis.label, (margin.left + wide) / 2, high - 8);
    ctx.save(); ctx.translate(13, high / 2); ctx.rotate(-Math.PI / 2); ctx.fillText(name, 0, 0); ctx.restore();
    const points = shown().map((k) => [k, at[m.points[k][0]], value(k)]).sort((p, q) => p[1] - q[1]);
    if (top >= low) { ctx.textAlign = "right"; ctx.fillText(number(top), margin.left - 6, Y(top) + 4); if (top > low) ctx.fillText(number(low), margin.left - 6, Y(low) + 4); }
    ctx.strokeStyle = BEST; ctx.lineWidth = 1.5; ctx.beginPath();
    let open = false;
    for (const [, x, v] of points) { if (v === undefined) open = false; else { ctx[open ? "lineTo" : "moveTo"](X(x), Y(v)); open = true; } }
    ctx.stroke();
    ctx.textAlign = "center";
    for (const [k, x, v] of points) {
      const failed = S.members[k] && S.members[k].failed, y = v === undefined ? high - margin.bottom - 6 : Y(v);
      cells.push({ k, x: X(x) - 12, y: margin.top, w: 24, h: high - margin.top - margin.bottom });
      if (failed) { ctx.fillStyle = BAD; ctx.fillText("✕", X(x), y); continue; }
      if (v === undefined) continue;
      ctx.fillStyle = k === S.chosen ? "#D55E00" : BEST;
      ctx.beginPath(); ctx.arc(X(x), y, k === S.chosen ? 6 : 4, 0, 2 * Math.PI); ctx.fill();
    }
  }

  function drawChosen() {
    const one = S.members[S.chosen], [ctx, wide, high] = ready(rod);
    about.textContent = one ? `${words(S.chosen)}: ${one.failed || `${S.quantity.replace(/_/g, " ")} ${number(one.values[S.quantity])}`}` : "the first runs are under way";
    if (!one || !one.x) return;
    const place = fitted([one.x, [0, 0, 0]], 3, wide, high);
    ctx.strokeStyle = BEST; ctx.lineWidth = 4;
    strokeLine(ctx, place, one.x, 3);
    ctx.fillStyle = "#000";
    const [x, y] = place(one.x[0], one.x[1]);
    ctx.fillRect(x - 5, y - 5, 10, 10);
    ctx.fillStyle = "#555";
    ctx.fillText(`its rod at the end${one.space ? ", seen along x₃" : ""}`, 10, 18);
  }

  plotted.onpointerdown = plotted.onpointermove = (event) => {
    const box = plotted.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const cell = cells.find((c) => x >= c.x && x < c.x + c.w && y >= c.y && y < c.y + c.h);
    if (!cell || (event.type === "pointermove" && event.pointerType === "touch")) return;
    S.picked = true;
    S.chosen = cell.k;
    draw();
  };
  plotted.onkeydown = (event) => {
    const way = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowUp: [1, 1], ArrowDown: [1, -1] }[event.key];
    if (!way || S.chosen === null || way[0] >= m.axes.length) return;
    event.preventDefault();
    const place = [...m.points[S.chosen]];
    place[way[0]] = Math.max(0, Math.min(m.axes[way[0]].texts.length - 1, place[way[0]] + way[1]));
    S.picked = true;
    S.chosen = member(place);
    draw();
  };
  return { take, draw, S };
}

// ---- a fit ----

function fitPage(root, m) {
  const S = { first: m, tried: [], costs: [], best: null, stage: "", ended: "", count: 0 };
  const told = make("p", { className: "l-told", role: "status" }), report = make("pre", { className: "l-report" });
  const panels = m.photographs.map((p) => ({ p, points: floats(p.points), canvas: canvasOf(`photograph at ${p.title}: its points, the rods that are tried in grey, the best in blue`, 1.25) }));
  const curves = m.curves.map((c) => ({ c, at: floats(c.at), values: floats(c.values), canvas: canvasOf(`${c.name} over ${c.over}: measured, and of the best scene`, 1.25) }));
  const costs = canvasOf("cost of each point of the search", 2.4), places = m.parameters.map((p) => canvasOf(`${p.name}: values tried`, 7));
  const boxed = (one, text) => make("figure", { className: "l-panel" }, make("figcaption", { textContent: text }), one);
  root.replaceChildren(make("div", { className: "l-run" }, make("div", {}, told,
    make("p", { className: "hint" }, make("b", { textContent: "● measured", style: `color: ${MEASURED}` }), "   ", make("b", { textContent: "— best so far", style: `color: ${BEST}` }), "   ", make("span", { textContent: "— tried lately", style: "color: #777" }),
      m.of > m.photographs.length ? `   ${m.photographs.length} of ${m.of} photographs` : ""),
    make("div", { className: "l-panels" }, ...panels.map((one) => boxed(one.canvas, one.p.title)), ...curves.map((one) => boxed(one.canvas, `${one.c.name}${one.c.unit ? ` (${one.c.unit})` : ""}`)))),
  make("div", {}, boxed(costs, "cost since the noise was last estimated; the least in blue"), ...m.parameters.map((p, k) => boxed(places[k], `${p.name}${p.unit ? ` (${p.unit})` : ""}`)), report)));

  function take(one) {
    if (one.kind === "ended") { S.ended = one.text; report.textContent = one.text; }
    if (one.kind === "stage") S.stage = one.text;
    if (one.kind === "fresh") S.costs = [];
    if (one.kind !== "tried") return;
    const made = { ...one, lines: one.lines.map(floats), curves: one.curves.map(floats) };
    S.count = Math.max(S.count, one.runs);
    S.tried.push(made);
    S.costs.push(one.cost);
    if (S.costs.length > 3000) S.costs.splice(0, 1000);
    if (S.tried.length > 1500) S.tried.splice(0, 500);
    if (one.better) S.best = made;
    for (const old of S.tried.slice(0, -8)) if (old !== S.best) old.lines = old.curves = [];
  }

  const latest = () => S.tried.slice(-8);

  function draw() {
    told.innerHTML = `<span><b>${S.count}</b> runs</span><span>${S.ended ? "it has ended" : S.stage.replace(/</g, "&lt;")}</span>`
      + (S.best ? `<span>least cost <b>${number(S.best.cost)}</b></span>${m.parameters.map((p) => `<span>${p.name} <b>${number(S.best.values[p.name])}</b> ${p.unit}</span>`).join("")}` : "");
    panels.forEach((one, k) => {
      const [ctx, wide, high] = ready(one.canvas), best = S.best && S.best.lines[k];
      const place = fitted(best ? [one.points, best] : [one.points], 2, wide, high, one.p.down);
      ctx.fillStyle = MEASURED;
      for (let i = 0; i + 1 < one.points.length; i += 2) { const [x, y] = place(one.points[i], one.points[i + 1]); ctx.beginPath(); ctx.arc(x, y, 1.7, 0, 7); ctx.fill(); }
      ctx.strokeStyle = TRIED; ctx.lineWidth = 1;
      for (const t of latest()) if (t.lines[k]) strokeLine(ctx, place, t.lines[k], 2);
      ctx.strokeStyle = BEST; ctx.lineWidth = 2;
      if (best) strokeLine(ctx, place, best, 2);
    });
    curves.forEach((one, k) => drawSeries(one, S.best && S.best.curves[k], latest().map((t) => t.curves[k]).filter(Boolean)));
    drawCosts();
    m.parameters.forEach((p, k) => drawTrack(places[k], p));
  }

  function drawSeries(one, best, tried) {
    const [ctx, wide, high] = ready(one.canvas), all = [one.values, best || []].flatMap((v) => [...v]), low = Math.min(...all), top = Math.max(...all), t = one.at;
    const X = (v) => 8 + (wide - 16) * (v - t[0]) / ((t[t.length - 1] - t[0]) || 1), Y = (v) => high - 8 - (high - 16) * (v - low) / ((top - low) || 1);
    ctx.fillStyle = MEASURED;
    one.values.forEach((v, i) => { ctx.beginPath(); ctx.arc(X(t[i]), Y(v), 1.7, 0, 7); ctx.fill(); });
    const line = (values) => { ctx.beginPath(); values.forEach((v, i) => ctx[i ? "lineTo" : "moveTo"](X(t[i]), Y(v))); ctx.stroke(); };
    ctx.strokeStyle = TRIED; ctx.lineWidth = 1;
    tried.forEach(line);
    ctx.strokeStyle = BEST; ctx.lineWidth = 2;
    if (best) line(best);
  }

  function drawCosts() {
    const [ctx, wide, high] = ready(costs), sizes = S.costs.map((cost) => Math.log10(Math.max(cost, 1e-12)));
    if (!sizes.length) return;
    const low = Math.min(...sizes), top = Math.max(...sizes), X = (i) => 52 + (wide - 60) * i / Math.max(sizes.length - 1, 1), Y = (v) => high - 12 - (high - 24) * (v - low) / ((top - low) || 1);
    ctx.fillStyle = "#222"; ctx.textAlign = "right";
    ctx.fillText(number(10 ** top), 46, Y(top) + 4);
    if (top > low) ctx.fillText(number(10 ** low), 46, Y(low) + 4);
    ctx.fillStyle = TRIED;
    sizes.forEach((v, i) => { ctx.beginPath(); ctx.arc(X(i), Y(v), 2, 0, 7); ctx.fill(); });
    ctx.strokeStyle = BEST; ctx.lineWidth = 1.5; ctx.beginPath();
    let least = Infinity;
    sizes.forEach((v, i) => { least = Math.min(least, v); ctx[i ? "lineTo" : "moveTo"](X(i), Y(least)); });
    ctx.stroke();
  }

  function drawTrack(canvas, p) {
    const [ctx, wide, high] = ready(canvas), along = (v) => 60 + (wide - 120) * (p.log ? Math.log(v / p.low) / Math.log(p.high / p.low) : (v - p.low) / (p.high - p.low));
    ctx.strokeStyle = "#ccc"; ctx.beginPath(); ctx.moveTo(60, high / 2); ctx.lineTo(wide - 60, high / 2); ctx.stroke();
    ctx.fillStyle = "#222"; ctx.textAlign = "right"; ctx.fillText(number(p.low), 54, high / 2 + 4); ctx.textAlign = "left"; ctx.fillText(number(p.high), wide - 54, high / 2 + 4);
    ctx.fillStyle = "rgba(90, 90, 90, 0.2)";
    for (const t of S.tried.slice(-200)) { ctx.beginPath(); ctx.arc(along(t.values[p.name]), high / 2, 3, 0, 7); ctx.fill(); }
    if (!S.best) return;
    ctx.fillStyle = BEST; ctx.beginPath(); ctx.arc(along(S.best.values[p.name]), high / 2, 6, 0, 7); ctx.fill();
  }
  return { take, draw, S };
}
