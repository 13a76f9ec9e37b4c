// The page of a run one can touch: what the server (tendril/live_server.py) sends is shown, what is done goes there.
// mount(element, connection): in a page of its own, or in a notebook's cell.

// A connection to the server, which comes again by itself when it was lost.
function connect(token) {
  const connection = { hear: () => {}, lost: () => {}, open: false };
  const wait = [];
  let socket = null, tries = 0;
  const begin = () => {
    socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/ws?token=${encodeURIComponent(token)}`);
    socket.onopen = () => {
      connection.open = true;
      tries = 0;
      connection.lost(false);
      while (wait.length) socket.send(wait.shift());
    };
    socket.onmessage = (event) => connection.hear(JSON.parse(event.data));
    socket.onclose = (event) => {
      connection.open = false;
      connection.lost(true, event.code === 1009 ? "what was sent is too large" : "");
      setTimeout(begin, Math.min(4000, 300 * 2 ** tries++));
    };
  };
  connection.send = (message) => {
    const text = JSON.stringify(message);
    if (connection.open) socket.send(text); else if (wait.length < 20) wait.push(text);
  };
  connection.file = (name) => `/file/${encodeURIComponent(name)}?token=${encodeURIComponent(token)}`;
  connection.picture = (name) => `/picture/${encodeURIComponent(name)}.png?token=${encodeURIComponent(token)}`;
  begin();
  return connection;
}

function make(tag, about = {}, ...children) {
  const one = document.createElement(tag);
  for (const [name, value] of Object.entries(about))
    if (name.startsWith("on")) one[name] = value; else if (name in one && name !== "list") one[name] = value; else one.setAttribute(name, value);
  one.append(...children);
  return one;
}

const COLOURS = { axial: "axial force", bend: "curvature", growth: "growth", speed: "speed", "": "none" };
const FIRST_CHARTS = [/force at the clamp/, /^tip$/, /force of walls|energy$/, /estimated error/];
const OVERLAY = "#b9b9b9", LINES = ["#0072B2", "#D55E00", "#009E73", "#CC79A7"];

function mount(root, connection) {
  const S = { scene: null, rows: [], frames: [], frame: null, before: null, came: 0, every: 50, running: false, pace: null, end: 1, values: {},
    branches: [], branch: 0, ended: "", t: 0, looking: null, walls: {}, hand: [0, 0, 0], ghost: null, rates: [0, 0], colour: "axial",
    arrows: true, lab: false, grabbed: null, slow: 0, written: [], changes: [] };
  root.classList.add("l-all");
  const send = (what, more = {}) => connection.send({ do: what, ...more });
  const unit = (name) => (S.lab && S.scene && S.scene.factors[name]) || 1;
  const unitName = (name) => (S.lab && S.scene && S.scene.units[name]) || "";
  let page = null, stage = null, charts = [];
  const link = document.getElementById("link"), home = document.getElementById("home");
  if (home) home.onclick = () => send("home");

  connection.lost = (lost, why) => { if (link) link.textContent = lost ? `${why || "the server does not answer"}; trying again` : ""; };
  let study = null;
  connection.hear = (m) => {
    if (m.kind === "study") { study = mountStudy(root, m); page = null; return; }
    if (study && ["member", "tried", "fresh", "stage", "ended"].includes(m.kind)) { study.hear(m); return; }
    const act = { scene: hearScene, whole: hearWhole, frame: hearFrame, state: hearState, happened: hearHappened, done: hearDone, refused: hearRefused,
      busy: (one) => { S.slow = one.seconds; tell(); }, start: showStart, drawn: showDrawn, made: hearMade }[m.kind];
    if (act) act(m);
  };

  // ---- what comes ----

  function hearScene(scene) {
    S.scene = scene;
    S.names = null;
    S.rows = [];
    S.frames = [];
    S.lab = Object.keys(scene.units).length > 0;
    S.ghost = S.frame = S.before = null;
    S.looking = null;
    document.title = `${scene.name}, live`;
    const title = document.getElementById("title");
    if (title) title.textContent = scene.name;
    if (home) home.hidden = false;
    showRun();
  }

  function hearWhole(m) {
    if (S.rows.length && S.branch !== m.branch && page) S.ghost = { rows: S.rows, frames: S.frames };
    S.names = m.names;
    S.rows = m.rows;
    S.frames = m.frames;
    S.looking = null;
    S.walls = m.walls;
    Object.assign(S, { hand: m.hand, lamp: m.lamp, pull: m.pull });
    S.before = null;
    S.frame = m.frames.length ? unpackFrame(m.frames[m.frames.length - 1][1]) : null;
    if (page) page.news.replaceChildren();
    m.happened.forEach(([t, text]) => say(`t = ${time(t)}: ${text}`));
    hearState(m);
    drawCharts();
  }

  function hearFrame(m) {
    if (!S.scene || !S.names || m.branch !== S.branch) return;
    for (let numbers = doubles(m.rows), n = S.names.length, i = 0; i < numbers.length; i += n) S.rows.push(Array.from(numbers.subarray(i, i + n)));
    if (S.rows.length > 9000) S.rows = S.rows.filter((_, i) => i % 2 === 0 || i > S.rows.length - 1000);
    S.frames.push([m.t, m.frame]);
    if (S.frames.length > 700) S.frames = S.frames.filter((_, i) => i % 2 === 0);
    const now = performance.now(), waits = S.running && S.pace ? 1000 * (m.t - S.t) / S.pace : 0;
    S.before = waits > 120 ? shown() : S.frame;  // (from where it is seen to be)
    S.frame = unpackFrame(m.frame);
    S.every = waits > 120 ? Math.min(waits, 2000) : Math.min(120, Math.max(16, now - S.came));
    S.came = now;
    Object.assign(S, { t: m.t, walls: m.walls, rates: m.rates, hand: m.hand, lamp: m.lamp, pull: m.pull, slow: 0 });
    S.fresh = true;
    tell();
  }

  function hearState(m) {
    for (const name of ["running", "pace", "end", "values", "branches", "branch", "ended", "changes", "written"]) S[name] = m[name];
    S.t = m.t;
    if (page) {
      refreshControls();
      showTree();
      tell();
    }
  }

  const hearHappened = (m) => { if (m.branch === S.branch) say(`t = ${time(m.t)}: ${m.text}`, m.text.startsWith("gave up") ? "l-bad" : ""); };
  const hearDone = (m) => { if (m.text.endsWith("is written")) S.wrote = (S.wrote || 0) + 1; said(m); };
  const said = (m) => say(m.text, m.text.startsWith("checked") ? "l-good" : m.text.includes("differs") ? "l-bad" : "");

  function hearRefused(m) {
    if (page && page.surfaceGo) page.surfaceGo.disabled = false;
    if (m.field && page && page.fields && page.fields[m.field]) {
      page.fields[m.field].why.textContent = m.text;
      page.fields[m.field].input.focus();
      return;
    }
    if (page && page.trouble) { page.trouble.textContent = m.text; return; }
    const control = page && page.controls && m.command && m.command.do === "set" && page.controls[m.command.name];
    if (control) control.why.textContent = m.text; else say(m.text, "l-bad");
  }

  function say(text, look = "") {
    if (!page || !page.news) return;
    const at = page.news.scrollHeight - page.news.scrollTop - page.news.clientHeight < 30;
    page.news.append(make("div", { className: look, textContent: text }));
    while (page.news.children.length > 80) page.news.firstChild.remove();
    if (at) page.news.scrollTop = page.news.scrollHeight;
  }

  const time = (t) => `${number(t * unit("l/V"))}${unitName("l/V") ? ` ${unitName("l/V")}` : ""}`;

  // ---- the run ----

  function showRun() {
    charts.forEach((c) => c.plot && c.plot.destroy());
    const canvas = make("canvas", { "aria-label": "the rod; drag stones, the tip, or the view", tabIndex: 0 });
    page = { canvas, news: make("div", { className: "l-news", role: "log" }), told: make("div", { className: "l-told" }), controls: {} };
    page.box = make("div", { className: "l-stage" }, canvas);
    page.run = make("button", { type: "button", className: "l-main", title: "space", onclick: () => send(S.running ? "pause" : "run") });
    page.slider = make("input", { type: "range", className: "l-slider", min: 0, max: 1000, value: 1000, "aria-label": "time: look back",
      oninput: () => look(page.slider.value / 1000 * S.t) });
    page.now = make("output", { className: "l-now" });
    page.branch = make("button", { type: "button", textContent: "go on from here", hidden: true, onclick: () => { send("back", { t: S.looking }); S.looking = null; } });
    page.toEnd = make("button", { type: "button", textContent: "to now", hidden: true, onclick: () => look(S.t) });
    page.paceNow = make("span", { className: "l-now" });
    const step = make("button", { type: "button", textContent: "step", title: ".", onclick: () => send("step") });
    const slower = make("button", { type: "button", textContent: "slower", title: "-", onclick: () => pace(0.5) });
    const faster = make("button", { type: "button", textContent: "faster", title: "+", onclick: () => pace(2) });
    const most = make("button", { type: "button", textContent: "as fast as it can", onclick: () => send("pace", { pace: null }) });
    const undo = make("button", { type: "button", textContent: "undo", title: "z", onclick: () => send("undo") });
    page.undo = undo;
    const colour = make("select", { "aria-label": "colour of the rod", onchange: () => { S.colour = colour.value; } },
      ...Object.entries(COLOURS).map(([value, text]) => make("option", { value, textContent: text })));
    const arrows = make("label", {}, make("input", { type: "checkbox", checked: true, onchange: (e) => { S.arrows = e.target.checked; } }), " forces");
    const lab = make("label", { hidden: !Object.keys(S.scene.units).length }, make("input", { type: "checkbox", checked: S.lab, onchange: (e) => {
      S.lab = e.target.checked; setUnits(); refreshControls(); drawCharts(); tell(); } }), " laboratory units");
    const fit = make("button", { type: "button", textContent: "whole", title: "see all of it", onclick: () => stage.forget() });
    const saves = ["scene", "result", "picture", "film", "page"].map((what) => make("button", { type: "button", textContent: what, onclick: () => send("save", { what: [what] }) }));
    page.files = make("div", { className: "l-files" });
    page.tree = make("div", { className: "l-tree" });
    page.charts = make("div", { className: "l-charts" });
    const left = make("div", {},
      page.box, make("div", { className: "l-bar" }, page.run, step, page.slider, page.now, page.branch, page.toEnd),
      page.told, make("div", { className: "l-bar" }, slower, faster, most, page.paceNow, undo, fit, colour, arrows, lab),
      page.news, keysAndButtons(), make("div", { className: "l-bar" }, make("b", { textContent: "write the" }), ...saves), page.files,
      make("div", { className: "l-controls" }, ...S.scene.controls.map(control)), page.tree);
    const options = make("details", {}, make("summary", { textContent: "options it began with" }), make("pre", { textContent: S.scene.options }));
    root.replaceChildren(make("div", { className: "l-run" }, left, make("div", {}, page.charts, options)));
    stage = new Stage(canvas, () => ({ scene: S.scene, frame: shown(), ghost: ghostFrame(), walls: S.looking === null ? S.walls : {}, hand: S.hand, lamp: S.lamp, pull: S.pull, grabbed: S.grabbed, picked: S.picked,
      colour: S.colour || null, arrows: S.arrows }));
    setUnits();
    resize();
    touch(canvas);
    makeCharts();
    tell();
  }

  function setUnits() {
    stage.unit = [unit("l"), unitName("l")];
    stage.force = [unit("N l"), unitName("N l")];
  }

  function resize() {
    if (!page || !page.box) return;
    const wide = page.box.clientWidth;
    page.box.style.height = `${Math.round(Math.min(0.62 * wide + 40, Math.max(230, 0.56 * innerHeight)))}px`;
  }

  // the frame that is shown: the present one, on the way to it from the one before, or an earlier one
  function shown() {
    if (S.looking !== null) {
      const frame = nearest(S.frames, S.looking);
      return frame ? unpackFrame(frame) : null;
    }
    if (!S.frame || !S.before || S.before.x.length !== S.frame.x.length) return S.frame;
    const part = Math.min(1, (performance.now() - S.came + 16) / S.every);
    if (part >= 1) return S.frame;
    const x = Float32Array.from(S.frame.x, (v, i) => S.before.x[i] + part * (v - S.before.x[i]));
    return { ...S.frame, x };
  }

  const ghostFrame = () => {
    if (!S.ghost || !S.ghost.frames.length) return null;
    const frame = nearest(S.ghost.frames, S.looking === null ? S.t : S.looking);
    return frame ? unpackFrame(frame) : null;
  };

  function nearest(frames, t) {
    if (!frames.length) return null;
    let best = frames[0];
    for (const one of frames) if (Math.abs(one[0] - t) < Math.abs(best[0] - t)) best = one;
    return best[1];
  }

  function look(t) {
    S.looking = t >= S.t * 0.9995 ? null : t;
    if (S.looking !== null && S.running) send("pause");
    tell();
    markTime();
  }

  const column = (name) => S.names.indexOf(name);

  // in words and numbers, where the run is
  function tell() {
    if (!page || !page.told || !S.rows.length) return;
    page.run.textContent = S.running ? "pause" : "run";
    page.run.disabled = !!S.ended;
    page.undo.disabled = !S.changes.length;
    const t = S.looking === null ? S.t : S.looking;
    page.now.textContent = `t = ${time(t)}`;
    if (document.activeElement !== page.slider || S.looking === null) page.slider.value = S.t > 0 ? 1000 * t / S.t : 1000;
    page.branch.hidden = page.toEnd.hidden = S.looking === null;
    page.paceNow.textContent = S.pace ? `${number(S.pace * unit("l/V"))} ${unitName("l/V")} a second, ${Math.max(0, Math.round((S.end - S.t) / S.pace))} s left` : "no limit";
    const row = S.rows[S.rows.length - 1], get = (name) => row[column(name)];
    const parts = [];
    if (column("error_tip") >= 0) {
      const errors = ["error_tip", "error_norm_x2", "error_energy"].map(get);
      parts.push(`error so far: tip <b>${number(errors[0])}</b>, |x₂| <b>${number(errors[1])}</b>, energy <b>${number(errors[2])}</b>${whereItGrows()}`);
    }
    parts.push(`<b>${S.rates[0].toFixed(0)}</b> steps, <b>${S.rates[1].toFixed(0)}</b> iterations a second`);
    parts.push(`step ${number(get("step") * unit("l/V"))} ${unitName("l/V")}`);
    if (S.slow > 0.7) parts.push(`<b>this step has taken ${S.slow} s so far</b>: the rod may be about to give way, or much of it touches`);
    if (S.ended) parts.push(`<b>${S.ended.replace(/</g, "&lt;")}</b>`);
    page.told.innerHTML = parts.map((part) => `<span>${part}</span>`).join("");
  }

  function whereItGrows() {
    const k = column("error_tip"), n = S.rows.length;
    if (n < 8) return "";
    let best = 0, at = 0;
    for (let i = Math.max(1, n - 4000); i < n; i++) {
      const more = S.rows[i][k] - S.rows[i - 1][k];
      if (more > best) [best, at] = [more, i];
    }
    return best > 0.2 * S.rows[n - 1][k] ? `, most of it at t = ${time(S.rows[at][column("t")])}` : "";
  }

  // ---- controls ----

  function control(one) {
    const range = make("input", { type: "range", min: 0, max: 1000, step: 1, "aria-label": one.label });
    const box = make("input", { type: "number", step: "any", "aria-label": one.label });
    const why = make("small", { className: "l-why" }), name = make("span");
    const from = (v) => (one.log ? 1000 * Math.log(v / one.low) / Math.log(one.high / one.low) : 1000 * (v - one.low) / (one.high - one.low));
    const to = (s) => (one.log ? one.low * (one.high / one.low) ** (s / 1000) : +(one.low + (one.high - one.low) * s / 1000).toPrecision(6));
    let later = null, last = 0;
    const give = (value) => {
      why.textContent = "";
      clearTimeout(later);
      later = setTimeout(() => { last = performance.now(); send("set", { name: one.name, value }); }, Math.max(0, 120 - (performance.now() - last)));
    };
    range.oninput = () => { box.value = number(to(+range.value) * unit(one.unit)); give(to(+range.value)); };
    box.onchange = () => give(box.value === "" ? "" : Number(box.value) / unit(one.unit));
    page.controls[one.name] = { why, show: (value) => {
      name.textContent = `${one.label}${unitName(one.unit) ? ` (${unitName(one.unit)})` : ""}`;
      if (document.activeElement !== range) range.value = from(value);
      if (document.activeElement !== box) box.value = number(value * unit(one.unit));
    } };
    return make("label", { className: "l-control" }, name, range, box, why);
  }

  function refreshControls() {
    for (const one of S.scene.controls) page.controls[one.name] && page.controls[one.name].show(S.values[one.name] ?? one.value);
    const links = S.written.map((name) => make("a", { href: connection.file ? connection.file(name) : "#", textContent: name, target: "_blank" }));
    const seen = connection.file ? S.written.filter((name) => /\.(png|gif)$/.test(name)) : [];
    if (page.files.told !== `${S.written} ${S.wrote}`)  // (a picture that is written anew is another)
      page.files.replaceChildren(...links, ...seen.map((name) => make("img", { src: `${connection.file(name)}&${S.wrote}`, alt: `${name}, as it was written` })));
    page.files.told = `${S.written} ${S.wrote}`;
  }

  const pace = (times) => send("pace", { pace: Math.min(1e6, (S.pace || S.end / 4) * times) });
  const letGo = () => S.scene.pulls && send("hand", { force: [0, 0, 0] });
  const has = (name) => S.scene && S.scene.controls.some((one) => one.name === name);
  const feed = (speed) => has("feed_speed") && send("set", { name: "feed_speed", value: speed });
  const spin = (rate) => has("clamp_spin") && send("set", { name: "clamp_spin", value: rate });

  const putStone = () => {
    if (!S.scene.posts) return;
    S.putting = true;
    say("click where the stone is to stand");
  };

  function keysAndButtons() {
    const button = (text, title, onclick) => make("button", { type: "button", textContent: text, title, onclick });
    const tools = make("div", { className: "l-tools" });
    if (has("feed_speed")) tools.append(button("◀ pull back", "left", () => feed(-1)), button("■ hold", "down", () => feed(0)), button("▶ feed", "right", () => feed(1)));
    if (has("clamp_spin")) tools.append(button("↺ twist", "q", () => spin(-1)), button("untwist ↻", "e", () => spin(1)), button("no twist", "w", () => spin(0)));
    if (S.scene.pulls) tools.append(button("let the tip go", "x", letGo));
    if (S.scene.posts) tools.append(button("put a stone", "p", putStone));
    const words = [["space", "run, pause"], [".", "step"], ["z", "undo"]];
    if (has("feed_speed")) words.push(["← ↓ →", "pull back, hold, feed"]);
    if (has("clamp_spin")) words.push(["q w e", "twist"]);
    const keys = make("div", { className: "l-keys" });
    for (const [key, text] of words) keys.append(make("span", { className: "l-key", textContent: key }), ` ${text}  `);
    const drags = [S.scene.walls.length && "stones (one that was touched has a handle, which turns it)", S.scene.lamp && "the lamp", S.scene.pulls && "the tip (a force)", S.scene.leads && "the held tip"].filter(Boolean);
    const told = drags.length ? `Drag ${drags.join(", ")}${S.scene.flat ? "; the rest moves the view" : "; the rest turns the view"}.` : "";
    return make("div", {}, tools, keys, make("div", { className: "l-keys", textContent: told }));
  }

  function keydown(event) {
    if (!page || !page.run || ["INPUT", "SELECT", "TEXTAREA"].includes(event.target.tagName) && event.target.type !== "range") return;
    if (!root.isConnected || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = { " ": () => send(S.running ? "pause" : "run"), ".": () => send("step"), z: () => send("undo"), ArrowRight: () => feed(1), ArrowLeft: () => feed(-1),
      ArrowDown: () => feed(0), q: () => spin(-1), e: () => spin(1), w: () => spin(0), x: letGo, p: putStone,
      "+": () => pace(2), "-": () => pace(0.5) }[event.key];
    if (!act || event.key === " " && ["BUTTON", "SUMMARY"].includes(event.target.tagName)) return;
    event.preventDefault();
    act();
  }
  document.addEventListener("keydown", keydown);

  // ---- touching the picture ----

  function touch(canvas) {
    const pointers = new Map();
    let grip = null, sent = 0;
    const point = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    const stoneAt = ([px, py]) => {
      let best = null, near = 14;
      for (const wall of S.scene.walls) {
        const there = wallAt(wall, S.walls[wall.line]);
        if (wall.circle) {
          const [x, y] = stage.place(...there(wall.circle[0], wall.circle[1], wall.height || 0));
          const past = Math.hypot(px - x, py - y) - wall.circle[2] * stage.scale, off = wall.inside ? Math.abs(past) : Math.max(0, past);
          if (off < (wall.inside ? Math.min(near, 10) : near)) [best, near] = [wall, off];
        } else for (const line of wall.lines || [])
          for (let i = 0; i + 3 < line.length; i += 2) {
            const a = stage.place(...there(line[i], line[i + 1], 0)), b = stage.place(...there(line[i + 2], line[i + 3], 0));
            const l2 = (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 || 1, z = Math.max(0, Math.min(1, ((px - a[0]) * (b[0] - a[0]) + (py - a[1]) * (b[1] - a[1])) / l2));
            const off = Math.hypot(px - a[0] - z * (b[0] - a[0]), py - a[1] - z * (b[1] - a[1]));
            if (off < Math.min(near, 10)) [best, near] = [wall, off];
          }
      }
      return best;
    };
    const handleAt = (at, wide) => S.scene.walls.find((wall) => {
      if (wall.line !== S.picked || !wall.about) return false;
      const [, to] = stage.handle(wall, S.walls[wall.line]);
      return Math.hypot(at[0] - to[0], at[1] - to[1]) < wide;
    });
    const aboutPivot = (wall, at) => { const [from] = stage.handle(wall, S.walls[wall.line]); return Math.atan2(from[1] - at[1], at[0] - from[0]); };
    const move = (last) => {
      if (!grip || grip.to === undefined) return;
      const now = performance.now();
      if (!last && now - sent < 110) return;
      sent = now;
      if (grip.kind === "stone") send("wall", { line: grip.wall.line, shift: grip.to });
      if (grip.kind === "handle") send("turn", { line: grip.wall.line, angle: grip.to });
      if (grip.kind === "hand") send("hand", { force: grip.to });
      if (grip.kind === "lead" || grip.kind === "lamp") send(grip.kind, { place: grip.to });
    };
    canvas.onpointerdown = (event) => {
      if (!S.scene || !S.frame) return;
      canvas.setPointerCapture(event.pointerId);
      const at = point(event);
      pointers.set(event.pointerId, at);
      if (pointers.size > 1) { grip = { kind: "pinch" }; return; }
      if (S.putting) {
        S.putting = false;
        send("post", { place: stage.at(...at).slice(0, 2) });
        return;
      }
      const tip = stage.tip(S.frame), wide = event.pointerType === "touch" ? 30 : 18;
      const stone = stoneAt(at), turned = S.looking === null && handleAt(at, wide), lamp = S.lamp && stage.place(...S.lamp);
      if (turned) grip = { kind: "handle", wall: turned, angle: (S.walls[turned.line] || [])[3] || 0, seen: aboutPivot(turned, at) };
      else if (S.looking === null && Math.hypot(at[0] - tip[0], at[1] - tip[1]) < wide && (S.scene.pulls || S.scene.leads))
        grip = { kind: S.scene.leads ? "lead" : "hand", from: at };
      else if (S.looking === null && lamp && Math.hypot(at[0] - lamp[0], at[1] - lamp[1]) < wide) grip = { kind: "lamp", from: at, start: S.lamp };
      else if (S.looking === null && stone) {
        grip = { kind: "stone", wall: stone, from: at, shift: (S.walls[stone.line] || [0, 0, 0]).slice(0, 3) };
        S.grabbed = stone.line;
      } else grip = { kind: S.scene.flat ? "pan" : "turn", from: at };
      S.picked = grip.wall ? grip.wall.line : null;
      event.preventDefault();
      canvas.focus({ preventScroll: true });
    };
    canvas.onpointermove = (event) => {
      const at = point(event), before = pointers.get(event.pointerId);
      if (!before) {
        canvas.style.cursor = S.scene && S.frame && stage.now && (stoneAt(at) || handleAt(at, 18) || Math.hypot(at[0] - stage.tip(S.frame)[0], at[1] - stage.tip(S.frame)[1]) < 18) ? "grab" : "default";
        return;
      }
      if (pointers.size > 1) {
        const [a, b] = [...pointers.values()], apart = Math.hypot(a[0] - b[0], a[1] - b[1]);
        pointers.set(event.pointerId, at);
        const [c, d] = [...pointers.values()];
        stage.fit = false;
        stage.scale *= Math.hypot(c[0] - d[0], c[1] - d[1]) / (apart || 1);
        return;
      }
      pointers.set(event.pointerId, at);
      if (!grip) return;
      if (grip.kind === "pan") {
        stage.fit = false;
        stage.way(before[0] - at[0], before[1] - at[1]).forEach((w, d) => { stage.middle[d] += w; });
      } else if (grip.kind === "turn") {
        stage.turn -= (at[0] - before[0]) / 160;
        stage.rise = Math.max(-1.57, Math.min(1.57, stage.rise + (at[1] - before[1]) / 160));
      } else if (grip.kind === "stone") {
        grip.to = stage.way(at[0] - grip.from[0], at[1] - grip.from[1]).map((w, d) => w + grip.shift[d]);
        if (S.scene.flat) grip.to[2] = 0;
        move(false);
      } else if (grip.kind === "handle") {
        const seen = aboutPivot(grip.wall, at), more = seen - grip.seen;
        grip.angle += stage.sense(grip.wall) * Math.atan2(Math.sin(more), Math.cos(more));
        grip.seen = seen;
        grip.to = +grip.angle.toPrecision(6);
        move(false);
      } else if (grip.kind === "hand") {
        const tip = stage.tip(S.frame), way = stage.way(at[0] - tip[0], at[1] - tip[1]), px = Math.hypot(at[0] - tip[0], at[1] - tip[1]);
        const size = Math.hypot(...way) || 1, force = px / 60;  // 60 pixels: the friction of a unit of length
        grip.to = way.map((w) => +(w / size * force).toPrecision(4));
        if (S.scene.flat) grip.to[2] = 0;
        move(false);
      } else if (grip.kind === "lead" || grip.kind === "lamp") {
        const x = S.frame.x, n = x.length;
        grip.start = grip.start || [x[n - 3], x[n - 2], x[n - 1]];
        grip.to = stage.way(at[0] - grip.from[0], at[1] - grip.from[1]).map((w, d) => w + grip.start[d]);
        if (S.scene.flat) grip.to[2] = 0;
        move(false);
      }
    };
    const end = (event) => {
      pointers.delete(event.pointerId);
      move(true);
      if (grip && grip.kind === "hand" && grip.to) say("the tip is pulled on; “let the tip go” ends it");
      grip = null;
      S.grabbed = null;
    };
    canvas.onpointerup = canvas.onpointercancel = end;
    canvas.onwheel = (event) => {
      event.preventDefault();
      const at = stage.at(...point(event));
      stage.fit = false;
      const times = Math.exp(-event.deltaY / 500);
      stage.scale *= times;
      stage.middle = stage.middle.map((m, d) => at[d] + (m - at[d]) / times);
    };
  }

  // ---- series ----

  function makeCharts() {
    const all = S.scene.charts, wanted = [];
    for (const pattern of FIRST_CHARTS) {
      const k = all.findIndex((c, i) => pattern.test(c.title) && !wanted.includes(i));
      if (k >= 0) wanted.push(k);
    }
    charts = wanted.map((which) => {
      const box = make("div", { className: "l-chart" }), place = make("div");
      const one = { which, place, plot: null };
      const choose = make("select", { "aria-label": "which series", onchange: () => { one.which = +choose.value; makeChart(one); } },
        ...all.map((c, i) => make("option", { value: i, textContent: c.title, selected: i === which })));
      box.append(choose, place);
      page.charts.append(box);
      return one;
    });
    drawCharts();
  }

  function table(rows, chart) {
    const f = unit("l/V"), g = unit(chart.unit), t = rows.map((row) => row[column("t")] * f);
    return [t, ...chart.series.map((name) => { const k = column(name); return rows.map((row) => (chart.log && !(row[k] > 0) ? null : row[k] * g)); })];
  }

  function makeChart(one) {
    if (one.plot) one.plot.destroy();
    const chart = S.scene.charts[one.which];
    const abscissa = { label: `t${unitName("l/V") ? ` (${unitName("l/V")})` : ""}`, value: (u, v) => number(v) };
    const series = chart.series.map((name, i) => ({ label: S.scene.symbols[name], stroke: LINES[i % 4], width: 1.6, dash: i > 3 ? [5, 3] : [], points: { show: false }, spanGaps: true,
      value: (u, v) => number(v) }));
    const ghosts = S.ghost ? chart.series.map(() => ({ label: "before", stroke: OVERLAY, width: 1.2, points: { show: false }, spanGaps: true, value: (u, v) => number(v) })) : [];
    const names = chart.unit !== "1" && unitName(chart.unit) ? unitName(chart.unit) : "";
    one.plot = new uPlot({ width: Math.max(200, one.place.clientWidth || 300), height: 165, pxAlign: 0, series: [abscissa, ...ghosts, ...series], scales: { x: { time: false }, y: chart.log ? { distr: 3 } : {} },
      axes: [{ size: 30 }, { ...valueAxis(chart.log), label: names, labelSize: names ? 16 : 0 }], legend: { show: chart.series.length > 1 || S.ghost },
      cursor: { drag: { x: false, y: false } }, padding: [8, 8, 0, 0] }, data(chart), one.place);
    one.plot.over.addEventListener("click", () => { const t = one.plot.posToVal(one.plot.cursor.left, "x") / unit("l/V"); look(Math.max(0, Math.min(S.t, t))); });
    one.plot.root.querySelectorAll(".u-legend .u-series").forEach((row, i) => { if (i > 1 && i <= ghosts.length) row.style.display = "none"; });  // one is told
    one.looks = looks();
  }

  function data(chart) {
    const now = table(S.rows, chart);
    return S.ghost ? uPlot.join([table(S.ghost.rows, chart), now]) : now;
  }

  const looks = () => `${!!S.ghost} ${S.lab}`;  // what a chart is made for

  function drawCharts() {
    if (!S.rows.length || !page || !page.charts) return;
    for (const one of charts) if (!one.plot || one.looks !== looks()) makeChart(one); else one.plot.setData(data(S.scene.charts[one.which]));
  }

  function markTime() {
    for (const one of charts)
      if (one.plot) one.plot.setCursor({ left: S.looking === null ? -10 : one.plot.valToPos(S.looking * unit("l/V"), "x"), top: 10 }, false);
  }

  // ---- branches ----

  function showTree() {
    if (S.branches.length < 2) { page.tree.replaceChildren(); return; }
    const list = (parent, deep) => S.branches.filter((b) => b.parent === parent).flatMap((b) => [
      make("div", { style: `padding-left: ${deep * 18}px` }, deep ? "└ " : "", make("button", { type: "button", textContent: `branch ${b.number}`, "aria-pressed": b.number === S.branch,
        onclick: () => b.number !== S.branch && send("branch", { branch: b.number }) }),
      ` ${b.parent === null ? "" : `from t = ${time(b.since)} `}to t = ${time(b.t)}, ${b.changes} change${b.changes === 1 ? "" : "s"}`), ...list(b.number, deep + 1)]);
    page.tree.replaceChildren(make("b", { textContent: "branches" }), ...list(null, 0));
  }

  // ---- the page to begin from ----

  function showStart(m) {
    S.scene = null;
    S.rows = [];
    page = { fields: {} };
    if (home) home.hidden = !m.runs;
    const title = document.getElementById("title");
    if (title) title.textContent = "tendril live";
    const posts = make("select", { "aria-label": "stones to put" }, ...[0, 1, 3, 5, 10].map((n) => make("option", { value: n, textContent: n })));
    const cards = m.gallery.map((one) => make("button", { type: "button", className: "l-card", onclick: () => send("start", { scene: one.name, posts: +posts.value }) },
      ...(one.picture && connection.picture ? [make("img", { src: connection.picture(one.name), alt: `${one.name}: ${one.text}`, loading: "lazy" })] : []),
      make("b", { textContent: one.name }), make("small", { textContent: one.text })));
    const form = {}, walls = make("textarea", { className: "l-walls", value: m.form.walls, spellcheck: false, "aria-label": "walls" });
    const gather = () => ({ ...Object.fromEntries(Object.entries(form).map(([name, input]) => [name, input.value])), walls: walls.value });
    let later = null;
    const changed = () => {
      for (const field of Object.values(page.fields)) field.why.textContent = "";
      page.trouble.textContent = "";
      clearTimeout(later);
      later = setTimeout(() => send("draw", { form: gather() }), 350);
    };
    const fields = m.form.fields.map((field) => {
      const input = field.choices ? make("select", {}, ...field.choices.map((c) => make("option", { value: c, textContent: c }))) : make("input", { value: field.value, inputMode: "text" });
      input.setAttribute("aria-label", field.label);
      const why = make("span", { className: "l-why", role: "alert" });
      input.oninput = input.onchange = changed;
      form[field.name] = input;
      page.fields[field.name] = { input, why };
      return make("div", { className: "l-field" }, make("span", { textContent: field.label }), input, make("span", { textContent: field.unit }), make("small", { textContent: field.about }), why);
    });
    page.trouble = make("p", { className: "l-why", role: "alert", style: "color: #A61B1B" });
    page.drawn = make("canvas", { className: "l-drawn", "aria-label": "the scene before it runs" });
    page.told = null;
    page.words = make("p", { className: "hint" });
    const why = make("span", { className: "l-why", role: "alert" });
    page.fields.walls = page.fields.file = { input: walls, why };
    Object.assign(page, { wallText: walls, changed });
    walls.oninput = changed;
    const surfaces = make("div", { className: "l-bar" });
    const asSurface = (file) => {  // what is to be made of a mesh or centre line is asked before
      const mesh = /\.(stl|obj|ply|vtp|vtk)$/i.test(file.name);
      const choice = (label, ...words) => make("select", { "aria-label": label }, ...words.map((word) => make("option", { value: word, textContent: word })));
      const unitOf = choice("its unit", "mm", "cm", "m", "in"), side = mesh ? choice("where the rod is", "outside", "inside") : choice("where the rod is", "inside", "outside");
      const at = make("input", { value: "60 0 0", "aria-label": "its middle", size: 9 });
      const middle = make("label", { hidden: !mesh }, " with its middle at ", at);
      side.onchange = () => { middle.hidden = !mesh || side.value === "inside"; };
      const go = make("button", { type: "button", textContent: "make a wall of it", onclick: () => {
        go.disabled = true;
        why.textContent = "";
        sendFile(file, { unit: unitOf.value, side: side.value, at: mesh && side.value === "outside" ? at.value : "", diameter: form.contact_diameter.value });
      } });
      page.surfaceGo = go;
      surfaces.replaceChildren(make("b", { textContent: file.name }), " in ", unitOf, " the rod is ", side, middle, go);
    };
    const take = (file) => {
      if (!file) return;
      why.textContent = "";
      if (/\.(stl|obj|ply|vtp|vtk|csv|dat|json|fcsv)$/i.test(file.name)) { asSurface(file); return; }
      if (file.size > 300000) { why.textContent = `${file.name} is too large for a wall file of the page; name it on the command line, with -wall_file`; return; }
      file.text().then((text) => {
        if (/[^\t\n\r\x20-\x7e\u0080-\uffff]/.test(text)) { why.textContent = `${file.name} is neither a wall file, nor a mesh (stl, obj, ply, vtp, vtk), nor a centre line (csv, dat, json, fcsv)`; return; }
        walls.value = text;
        changed();
      });
    };
    const addStone = make("button", { type: "button", textContent: "add a stone", onclick: () => {
      const [x, y] = page.stage ? page.stage.at(page.stage.width * 0.6, page.stage.height * 0.35) : [1, 1];
      walls.value = `${walls.value.replace(/\s*$/, "")}\ncircle ${page.length(x)} ${page.length(y)} 8mm outside\n`;
      changed();
    } });
    walls.ondragover = (e) => { e.preventDefault(); walls.classList.add("l-over"); };
    walls.ondragleave = () => walls.classList.remove("l-over");
    walls.ondrop = (e) => { e.preventDefault(); walls.classList.remove("l-over"); take(e.dataTransfer.files[0]); };
    const go = make("button", { type: "button", className: "l-main", textContent: "run it", onclick: () => send("start", { form: gather(), posts: +posts.value }) });
    root.replaceChildren(make("div", {}, make("h2", { textContent: "A scene of one's own" }),
      make("div", { className: "l-form" }, make("div", {}, ...fields), make("div", {}, page.drawn, page.words, page.trouble, make("div", { className: "l-bar" }, go, addStone, make("small", { textContent: "Stones can be dragged in the drawing." })), make("b", { textContent: "walls" }),
        make("small", { textContent: " one a line: circle X Y R outside, plane X Y NX NY, path R X Y X Y, polygon. Or drop a file: of walls, a mesh (STL, OBJ, PLY, VTP, VTK), a centre line (CSV)." }), walls, why,
        make("input", { type: "file", "aria-label": "a wall file, mesh or centre line", onchange: (e) => take(e.target.files[0]) }), surfaces)),
      make("label", {}, "stones to be put somewhere in the run, beside those above or of the scene: ", posts), make("h2", { textContent: "or one of the gallery" }), make("div", { className: "l-gallery" }, ...cards)));
    changed();
  }

  function showDrawn(m) {
    if (!page || !page.drawn) return;
    page.words.textContent = m.told;
    const x = Float32Array.from(m.x), old = page.stage;
    const one = new Stage(page.drawn, () => ({ scene: { flat: !m.space, walls: m.walls, diameter: m.diameter }, frame: { x }, walls: {}, colour: null, arrows: false }));
    page.length = (v) => (m.length !== 1 ? `${+(100 * m.length * v).toPrecision(3)}cm` : `${+v.toPrecision(3)}`);
    one.unit = [m.length * 100, m.length !== 1 ? "cm" : ""];
    one.see([-0.05 * m.end, 0, 0, Math.min(m.end, 8), 0, 0]);
    for (const wall of m.walls) {
      if (wall.circle && !wall.inside) one.see([wall.circle[0] - wall.circle[2], wall.circle[1] - wall.circle[2], 0, wall.circle[0] + wall.circle[2], wall.circle[1] + wall.circle[2], 0]);
      else if (wall.vertices && m.space) one.see(wall.vertices.length < 30000 ? wall.vertices : wall.vertices.slice(0, 30000));
    }
    if (old && page.dragged) Object.assign(one, { fit: false, scale: old.scale, middle: old.middle });  // what is under the finger stays there
    one.whole = true;
    page.stage = one;
    S.drawn = { ...m, stage: one };
    dragStones(page.drawn, one, m);
    one.draw();
  }

  // stones of the drawing are dragged: their lines among the walls say then where they are
  function dragStones(canvas, one, m) {
    let held = null;
    const point = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    const under = (at) => m.walls.find((wall) => {
      if (!wall.circle || wall.inside || m.space) return false;
      const [px, py] = one.place(wall.circle[0], wall.circle[1], 0);
      return Math.hypot(at[0] - px, at[1] - py) < wall.circle[2] * one.scale + 8;
    });
    canvas.style.touchAction = "pan-y";
    canvas.ontouchstart = (event) => { const t = event.touches[0]; if (under(point(t))) event.preventDefault(); };
    canvas.onpointerdown = (event) => {
      const at = point(event), wall = under(at);
      if (!wall) return;
      canvas.setPointerCapture(event.pointerId);
      held = { wall, from: at, start: [...wall.circle] };
      event.preventDefault();
    };
    canvas.onpointermove = (event) => {
      if (!held) { canvas.style.cursor = under(point(event)) ? "grab" : "default"; return; }
      const at = point(event), [dx, dy] = one.way(at[0] - held.from[0], at[1] - held.from[1]), circle = held.wall.circle;
      [circle[0], circle[1]] = [held.start[0] + dx, held.start[1] + dy];
      one.fit = false;
      one.draw();
    };
    canvas.onpointerup = canvas.onpointercancel = () => {
      if (!held) return;
      const lines = page.wallText.value.split("\n"), k = held.wall.line - 1, circle = held.wall.circle;
      lines[k] = (lines[k] || "").replace(/^(\s*circle[\s,]+)\S+?([\s,]+)\S+?([\s,])/, `$1${page.length(circle[0])}$2${page.length(circle[1])}$3`);
      page.wallText.value = lines.join("\n");
      page.dragged = true;
      held = null;
      page.changed();
    };
  }

  // a file in parts, none of which is larger than a message may be
  async function sendFile(file, more) {
    const bytes = new Uint8Array(await file.arrayBuffer()), size = 180000, parts = Math.max(1, Math.ceil(bytes.length / size));
    for (let part = 0; part < parts; part++) {
      let text = "";
      for (const byte of bytes.subarray(part * size, (part + 1) * size)) text += String.fromCharCode(byte);
      send("file", { name: file.name, part, parts, data: btoa(text), ...more });
    }
  }

  function hearMade(m) {
    if (!page || !page.wallText) return;
    page.surfaceGo.disabled = false;
    page.surfaceGo.parentElement.replaceChildren(make("small", { textContent: m.notes.join("; ") }));
    page.wallText.value = `${page.wallText.value.replace(/\s*$/, "")}\n${m.line}\n`;
    page.dragged = false;
    page.changed();
  }

  // ---- by frames ----

  let drawnAt = 0;
  function frame(now) {
    if (!root.isConnected && S.scene) return;
    if (stage && page && page.canvas && page.canvas.isConnected) {
      stage.draw();
      if (S.fresh && now - drawnAt > 250) { drawCharts(); drawnAt = now; S.fresh = false; }
    }
    requestAnimationFrame(frame);
  }
  requestAnimationFrame(frame);
  addEventListener("resize", () => { resize(); charts.forEach((one) => one.plot && one.plot.setSize({ width: Math.max(200, one.place.clientWidth), height: 165 })); });
  root.tendril = { S, send, get stage() { return stage; } };
  return root.tendril;
}
