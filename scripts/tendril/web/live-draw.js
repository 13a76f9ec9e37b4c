// The picture of a run one can touch: a rod and what stands around it, in the plane or in space, on a canvas.
const INK = "#222", SOLID = "#e8e4da", EDGE = "#8a8371", HAND = "#7A2E8E", PUSH = "#C2410C", DRAG = "#777";
const ENDS_OF = { axial: SIGNED, bend: [[0, 109, 91], [225, 225, 225], [140, 81, 10]],
  growth: [[118, 42, 131], [230, 230, 230], [27, 120, 55]], speed: [[230, 230, 230], [230, 230, 230], [178, 24, 43]] };

function unpackFrame(frame) {
  const made = {};
  for (const [name, value] of Object.entries(frame)) made[name] = typeof value === "string" ? floats(value) : value;
  return made;
}

// Where that of a wall is which is given at a place: turned by an angle about its axis, and displaced.
function wallAt(wall, [dx, dy, dz, angle = 0] = [0, 0, 0]) {
  if (!angle || !wall.about) return (x, y, z) => [x + dx, y + dy, z + dz];
  const [px, py, pz, ax, ay, az] = wall.about, size = Math.hypot(ax, ay, az), [u, v, w] = [ax / size, ay / size, az / size], c = Math.cos(angle), s = Math.sin(angle);
  return (X, Y, Z) => {
    const x = X - px, y = Y - py, z = Z - pz, along = (1 - c) * (u * x + v * y + w * z);
    return [px + c * x + s * (v * z - w * y) + along * u + dx, py + c * y + s * (w * x - u * z) + along * v + dy, pz + c * z + s * (u * y - v * x) + along * w + dz];
  };
}

// A picture on a canvas. what() says what is to be drawn: {scene, frame, ghost, walls, hand, grabbed, picked, colour, arrows}.
class Stage {
  constructor(canvas, what) {
    Object.assign(this, { canvas, what, fit: true, middle: [0, 0, 0], scale: 100, turn: -0.6, rise: 0.5, most: {} });
    this.reach = [[0, 0, 0], [1e-9, 1e-9, 1e-9]];
  }

  forget() {
    this.fit = true;
    this.most = {};
    this.reach = [[0, 0, 0], [1e-9, 1e-9, 1e-9]];
  }

  // where the axes of the screen point in the laboratory
  axes() {
    if (this.flat) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const c = Math.cos(this.turn), s = Math.sin(this.turn), C = Math.cos(this.rise), S = Math.sin(this.rise);
    return [[c, s, 0], [s * S, -c * S, C], [s * C, -c * C, -S]];
  }

  place(x, y, z) {
    const [right, up] = this.now, m = this.middle, dx = x - m[0], dy = y - m[1], dz = z - m[2];
    return [this.width / 2 + this.scale * (right[0] * dx + right[1] * dy + right[2] * dz),
      this.height / 2 - this.scale * (up[0] * dx + up[1] * dy + up[2] * dz)];
  }

  // what a way on the screen is in the laboratory, in the plane of the screen
  way(dx, dy) {
    const [right, up] = this.now || this.axes();
    return [0, 1, 2].map((d) => (right[d] * dx - up[d] * dy) / this.scale);
  }

  at(px, py) {
    const way = this.way(px - this.width / 2, py - this.height / 2);
    return way.map((w, d) => w + this.middle[d]);
  }

  see(x) {
    for (let i = 0; i < x.length; i += 3)
      for (let d = 0; d < 3; d++) {
        this.reach[0][d] = Math.min(this.reach[0][d], x[i + d]);
        this.reach[1][d] = Math.max(this.reach[1][d], x[i + d]);
      }
  }

  frameAll(scene, x, lamp) {
    const [low, high] = this.reach.map((r) => [...r]), [from, to] = this.reach;
    const size = Math.max(...[0, 1, 2].map((d) => high[d] - low[d]), 1e-9);
    if (lamp && !this.lampSeen) {  // one that is not far off is seen, too
      this.lampSeen = true;
      if (Math.hypot(lamp[0] - to[0], lamp[1] - to[1]) < 12 * size) this.see(lamp);
    }
    for (const wall of scene.walls) {  // stones near the rod are seen whole
      if (!wall.circle || wall.inside) continue;
      const [x, y, r] = wall.circle;
      const far = Math.max(0.5 * size, Math.min(scene.reach || 0, 5 * size));  // as far as the rod will come
      if (x - r < to[0] + far && x + r > from[0] - far && y - r < to[1] + far && y + r > from[1] - far) {
        low[0] = Math.min(low[0], x - r); high[0] = Math.max(high[0], x + r);
        low[1] = Math.min(low[1], y - r); high[1] = Math.max(high[1], y + r);
      }
    }
    if (!this.flat) return this.frameRod(x);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((d) => (k >> d & 1 ? high : low)[d]));
    const [right, up] = this.now, span = (axis) => {
      const along = corners.map((c) => c[0] * axis[0] + c[1] * axis[1] + c[2] * axis[2]);
      return Math.max(...along) - Math.min(...along);
    };
    const wanted = 0.86 * Math.min(this.width / Math.max(span(right), 0.02 * size), this.height / Math.max(span(up), 0.02 * size));
    const middle = [0, 1, 2].map((d) => (low[d] + high[d]) / 2);
    const way = this.settled ? 0.12 : 1;
    this.scale *= (wanted / this.scale) ** way;
    for (let d = 0; d < 3; d++) this.middle[d] += way * (middle[d] - this.middle[d]);
    this.settled = true;
  }

  // in space: as the rod is seen now
  frameRod(x) {
    const [right, up, back] = this.now, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i + 2 < x.length; i += 3)
      [right, up, back].forEach((axis, k) => {
        const at = axis[0] * x[i] + axis[1] * x[i + 1] + axis[2] * x[i + 2];
        low[k] = Math.min(low[k], at);
        high[k] = Math.max(high[k], at);
      });
    if (!(high[0] > low[0])) return;
    const size = Math.max(high[0] - low[0], high[1] - low[1], 1e-9), way = this.settled ? 0.15 : 1;
    const wanted = 0.84 * Math.min(this.width / Math.max(high[0] - low[0], 0.1 * size), this.height / Math.max(high[1] - low[1], 0.1 * size));
    this.scale *= (wanted / this.scale) ** way;
    const mid = low.map((v, k) => (v + high[k]) / 2);
    for (let d = 0; d < 3; d++) this.middle[d] += way * (right[d] * mid[0] + up[d] * mid[1] + back[d] * mid[2] - this.middle[d]);
    this.settled = true;
  }

  draw() {
    const { scene, frame, ghost, walls, hand, lamp, pull, grabbed, picked, colour, arrows } = this.what();
    const box = this.canvas.getBoundingClientRect(), ratio = devicePixelRatio || 1;
    if (!scene || !box.width) return;
    if (this.canvas.width !== Math.round(box.width * ratio) || this.canvas.height !== Math.round(box.height * ratio)) {
      this.canvas.width = Math.round(box.width * ratio);
      this.canvas.height = Math.round(box.height * ratio);
    }
    [this.width, this.height] = [box.width, box.height];
    this.flat = scene.flat;
    this.now = this.axes();
    const ctx = this.ctx = this.canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, box.width, box.height);
    ctx.lineCap = ctx.lineJoin = "round";
    if (frame) this.see(frame.x);
    if (this.fit) this.frameAll(scene, frame ? frame.x : [], lamp);
    for (const wall of scene.walls) this.drawWall(wall, (walls || {})[wall.line], grabbed === wall.line);
    if (this.flat) this.drawRuler();
    if (ghost) this.drawRod(ghost, "#ccc", scene, null);
    if (frame) this.drawRod(frame, null, scene, colour);
    if (frame && arrows) this.drawForces(frame);
    this.drawClamp(frame);
    if (lamp) this.drawLamp(lamp);
    if (pull) this.drawPull(pull);
    if (frame && hand && Math.hypot(...hand) > 0) this.drawHand(frame, hand);
    for (const wall of scene.walls) if (wall.line === picked && wall.about) this.drawHandle(wall, (walls || {})[wall.line]);
  }

  // what turns a wall: where its axis is on the screen, and the knob
  handle(wall, place) {
    const [px, py, pz, ax, ay, az] = wall.about, long = wall.circle ? wall.circle[2] + 26 / this.scale : 60 / this.scale;
    const way = Math.abs(ax) > 0.9 * Math.hypot(ax, ay, az) ? [0, 1, 0] : [1, 0, 0], there = wallAt(wall, place);
    const off = (way[0] * ax + way[1] * ay + way[2] * az) / (ax * ax + ay * ay + az * az), across = [way[0] - off * ax, way[1] - off * ay, way[2] - off * az];
    const size = Math.hypot(...across) / long;
    return [this.place(...there(px, py, pz)), this.place(...there(px + across[0] / size, py + across[1] / size, pz + across[2] / size))];
  }

  // is a turn about its axis to the left on the screen (1), or to the right (-1)?
  sense(wall) {
    const [right, up] = this.now, [a, b, c] = wall.about.slice(3);
    return a * (right[1] * up[2] - right[2] * up[1]) + b * (right[2] * up[0] - right[0] * up[2]) + c * (right[0] * up[1] - right[1] * up[0]) < 0 ? -1 : 1;
  }

  drawHandle(wall, place) {
    const { ctx } = this, [from, to] = this.handle(wall, place);
    ctx.strokeStyle = HAND;
    ctx.fillStyle = "#fff";
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.moveTo(...from);
    ctx.lineTo(...to);
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(...to, 7, 0, 2 * Math.PI);
    ctx.fill();
    ctx.stroke();
  }

  line(points, n = 3, there = (...x) => x) {
    const { ctx } = this;
    ctx.beginPath();
    for (let i = 0; i + n - 1 < points.length; i += n) {
      const [x, y] = this.place(...there(points[i], points[i + 1], n > 2 ? points[i + 2] : 0));
      if (i) ctx.lineTo(x, y); else ctx.moveTo(x, y);
    }
  }

  drawWall(wall, place, grabbed) {
    const { ctx } = this, there = wallAt(wall, place);
    ctx.fillStyle = SOLID;
    ctx.strokeStyle = grabbed ? HAND : EDGE;
    ctx.lineWidth = grabbed ? 2.5 : 1.6;
    if (!this.flat && wall.vertices) {
      this.drawMesh(wall, there);
      return;
    }
    if (wall.circle) {
      const [x, y, r] = wall.circle, [px, py] = this.place(...there(x, y, wall.height || 0));
      ctx.beginPath();
      if (wall.inside) ctx.rect(-10, -10, this.width + 20, this.height + 20);
      ctx.arc(px, py, r * this.scale, 0, 2 * Math.PI);
      ctx.fill("evenodd");
      ctx.beginPath();
      ctx.arc(px, py, r * this.scale, 0, 2 * Math.PI);
      ctx.stroke();
      return;
    }
    if (wall.rings) {
      ctx.beginPath();
      for (const ring of wall.rings)
        for (let i = 0; i < ring.length; i += 2) {
          const [x, y] = this.place(...there(ring[i], ring[i + 1], 0));
          if (i) ctx.lineTo(x, y); else ctx.moveTo(x, y);
        }
      ctx.fill("evenodd");
    }
    for (const line of wall.lines || []) {
      this.line(line, 2, there);
      ctx.stroke();
    }
  }

  drawMesh(wall, there) {
    const { ctx } = this, v = wall.vertices, t = wall.triangles;
    ctx.globalAlpha = wall.inside ? 0.10 : 0.30;
    ctx.beginPath();
    const every = Math.max(1, Math.ceil(t.length / 3 / 3000));
    for (let i = 0; i + 2 < t.length; i += 3 * every) {
      const p = [0, 1, 2].map((k) => this.place(...there(v[3 * t[i + k]], v[3 * t[i + k] + 1], v[3 * t[i + k] + 2])));
      const [a, b, c] = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) < (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]) ? [p[0], p[2], p[1]] : p;  // all one way round
      ctx.moveTo(...a); ctx.lineTo(...b); ctx.lineTo(...c); ctx.closePath();
    }
    ctx.fillStyle = "#b9ad8e";
    ctx.fill();
    ctx.globalAlpha = 0.7;
    for (const line of wall.lines3 || []) {
      this.line(line, 3, there);
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  drawRuler() {
    const { ctx } = this, [factor, unit] = this.unit || [1, ""], wide = factor * this.width / 5 / this.scale, step = 10 ** Math.floor(Math.log10(wide));
    const round = [5, 2, 1].map((k) => k * step).find((k) => k <= wide) || step;  // in the unit that is shown
    const long = round / factor * this.scale, x = 12, y = this.height - 12;
    ctx.strokeStyle = ctx.fillStyle = "#555";
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(x, y - 4); ctx.lineTo(x, y); ctx.lineTo(x + long, y); ctx.lineTo(x + long, y - 4);
    ctx.stroke();
    ctx.font = "12px system-ui, sans-serif";
    ctx.fillText(`${number(round)} ${unit}`, x + 6, y - 6);
  }

  drawRod(frame, plain, scene, kind) {
    const { ctx } = this, x = frame.x, thick = Math.max(4, scene.diameter * this.scale), values = kind && frame[kind];
    ctx.lineWidth = thick + 1.6;
    ctx.strokeStyle = plain || "#333";
    this.line(x);
    ctx.stroke();
    if (!values) return;
    let most = 0;
    for (const v of values) most = Math.max(most, Math.abs(v));
    this.most[kind] = kind === "growth" ? most || 1 : Math.max(this.most[kind] || 0, most);
    ctx.lineWidth = thick - 0.4;
    for (const i of [0, values.length - 1]) {  // its ends are round
      ctx.fillStyle = rgb(signed(ENDS_OF[kind], values[i], this.most[kind]));
      ctx.beginPath();
      ctx.arc(...this.place(x[3 * i], x[3 * i + 1], x[3 * i + 2]), ctx.lineWidth / 2, 0, 2 * Math.PI);
      ctx.fill();
    }
    ctx.lineCap = "butt";
    for (let i = 0; i + 1 < values.length; i++) {
      const [ax, ay] = this.place(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
      const [bx, by] = this.place(x[3 * i + 3], x[3 * i + 4], x[3 * i + 5]), long = Math.hypot(bx - ax, by - ay) || 1;
      ctx.strokeStyle = rgb(signed(ENDS_OF[kind], (values[i] + values[i + 1]) / 2, this.most[kind]));
      ctx.beginPath();
      ctx.moveTo(ax, ay);
      ctx.lineTo(bx + 0.5 * (bx - ax) / long, by + 0.5 * (by - ay) / long);
      ctx.stroke();
    }
    ctx.lineCap = "round";
  }

  arrow(from, way, colour, width = 1.4) {
    const { ctx } = this, [x, y] = from, [dx, dy] = way, long = Math.hypot(dx, dy);
    if (long < 2) return;
    arrowPath(ctx, x, y, dx, dy, Math.min(0.4, 8 / long));
    for (const [stroke, w] of [["#fffc", width + 2], [colour, width]]) {
      ctx.strokeStyle = stroke;
      ctx.lineWidth = w;
      ctx.stroke();
    }
  }

  // where a force, per length or not, points on the screen
  shown(f, i, scale) {
    const [right, up] = this.now;
    return [scale * (right[0] * f[i] + right[1] * f[i + 1] + right[2] * f[i + 2]), -scale * (up[0] * f[i] + up[1] * f[i + 1] + up[2] * f[i + 2])];
  }

  // of places along the rod each so manieth, so that they are not closer than arrows can be told apart
  apart(places) {
    const n = places.length / 3, a = this.place(places[0], places[1], places[2]);
    let long = 0;
    for (let i = 3, b = a; i < places.length; i += 3) { const c = this.place(places[i], places[i + 1], places[i + 2]); long += Math.hypot(c[0] - b[0], c[1] - b[1]); b = c; }
    return Math.max(1, Math.min(n, Math.ceil(22 * n / (long + 1))));
  }

  drawForces(frame) {
    for (const [name, colour, end] of [["friction", DRAG, false], ["contact", PUSH, true]]) {
      const f = frame[name];
      if (!f) continue;
      let most = 0;
      for (let i = 0; i < f.length; i += 3) most = Math.max(most, Math.hypot(f[i], f[i + 1], f[i + 2]));
      this.most[name] = Math.max((this.most[name] || 0) * 0.98, most, 1e-12);
      const scale = Math.min(46, this.width / 11) / this.most[name], step = 3 * this.apart(frame.places);
      for (let i = 0; i < f.length; i += name === "friction" ? step : 3) {
        const way = this.shown(f, i, scale), at = this.place(frame.places[i], frame.places[i + 1], frame.places[i + 2]);
        this.arrow(end ? [at[0] - way[0], at[1] - way[1]] : at, way, colour, end ? 1.8 : 1.2);
      }
    }
  }

  drawClamp(frame) {
    const { ctx } = this, x = frame ? frame.x : [0, 0, 0], [px, py] = this.place(x[0], x[1], x[2]);
    ctx.fillStyle = "#000";
    ctx.fillRect(px - 5, py - 5, 10, 10);
  }

  drawLamp(place) {
    const { ctx } = this, [x, y] = this.place(...place);
    ctx.strokeStyle = "#B8860B";
    ctx.fillStyle = "#FFD23F";
    ctx.lineWidth = 2;
    ctx.beginPath();
    for (let k = 0; k < 8; k++) {
      const c = Math.cos(k * Math.PI / 4), s = Math.sin(k * Math.PI / 4);
      ctx.moveTo(x + 12 * c, y + 12 * s);
      ctx.lineTo(x + 18 * c, y + 18 * s);
    }
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(x, y, 9, 0, 2 * Math.PI);
    ctx.fill();
    ctx.stroke();
  }

  // where gravity pulls growth to, in a corner
  drawPull(way) {
    const [dx, dy] = this.shown(way, 0, 1), long = Math.hypot(dx, dy) || 1, x = this.width - 60, y = 44;
    this.arrow([x - 22 * dx / long, y - 22 * dy / long], [44 * dx / long, 44 * dy / long], "#3A6B35", 3);
    this.ctx.fillStyle = "#3A6B35";
    this.ctx.font = "12px system-ui, sans-serif";
    this.ctx.textAlign = "center";
    this.ctx.fillText("growth is pulled", x, y + 42);
    this.ctx.textAlign = "start";
  }

  tip(frame) {
    const x = frame.x, n = x.length;
    return this.place(x[n - 3], x[n - 2], x[n - 1]);
  }

  drawHand(frame, hand) {
    const size = Math.hypot(...hand), scale = Math.min(90, 26 + 30 * size) / size, way = this.shown(hand, 0, scale), at = this.tip(frame);
    this.arrow(at, way, HAND, 3);
    this.ctx.fillStyle = HAND;
    this.ctx.font = "600 13px system-ui, sans-serif";
    this.ctx.fillText(`${number(size * (this.force || [1, ""])[0])} ${(this.force || [1, ""])[1]}`, at[0] + way[0] + 6, at[1] + way[1]);
  }
}
