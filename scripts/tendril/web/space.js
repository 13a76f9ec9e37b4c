// ---- the rod in space ----

// Drawn by three.js as a tube; where there is no WebGL as lines on a canvas, seen by the same camera.
const hasContact = data.touches && data.runs.some((run) => "contact" in run.widths);
const SIDES = 14, GHOSTS = 5, LEAST = 3;  // of a tube; earlier shapes; the least thickness in pixels
const V = (x, y, z) => new THREE.Vector3(x, y, z);
const axis = (d) => V(...[0, 1, 2].map((i) => (i === Math.abs(d) - 1 ? Math.sign(d) : 0)));
const UP = axis(data.up), RIGHT = axis(Math.abs(data.up) === 1 ? 2 : 1), BACK = RIGHT.clone().cross(UP);
let rod = null, stage = null;

for (const surface of data.runs.flatMap((run) => run.surfaces)) {
  surface.positions = floats(surface.positions);
  surface.index = new Uint32Array(Uint8Array.from(atob(surface.index), (c) => c.charCodeAt(0)).buffer);
  surface.lines = surface.lines.map(floats);
}

const ended = (run) => state.t / factor(run, "l/V") > run.end * (1 + 1e-6);

const parsed = (colour) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);

// [3 n], a colour a node: of the run, or of the field that is chosen
function coloursOf(run, shape) {
  const field = data.fields[shownField()], along = field && shape.fields[shownField()], n = run.nodes;
  const all = new Float32Array(3 * n), own = along ? null : several ? parsed(run.colour) : [0.3, 0.45, 0.6];
  for (let i = 0; i < n; i++) all.set(own || shade(along[i], field).map((c) => c / 255), 3 * i);
  return all;
}

// ---- curves and the frames along them ----

const at = (points, i) => V(points[3 * i], points[3 * i + 1], points[3 * i + 2]);

function scaled(points, f) {
  return Float32Array.from(points, (v) => v * f);
}

// Unit tangents of a curve, and directions across it that are carried along without turning about it.
function framesOf(points, first) {
  const n = points.length / 3, t = [], normal = [], third = [];
  for (let i = 0; i < n; i++)
    t.push(at(points, Math.min(i + 1, n - 1)).sub(at(points, Math.max(i - 1, 0))).normalize());
  let v = first.clone().addScaledVector(t[0], -first.dot(t[0])).normalize();
  for (let i = 0; i < n; i++) {
    if (i) {
      const chord = at(points, i).sub(at(points, i - 1)), c = chord.dot(chord) || 1e-30;
      v = v.clone().addScaledVector(chord, -2 * chord.dot(v) / c);
      const before = t[i - 1].clone().addScaledVector(chord, -2 * chord.dot(t[i - 1]) / c);
      const back = t[i].clone().sub(before), b = back.dot(back) || 1e-30;
      v.addScaledVector(back, -2 * back.dot(v) / b);
      v.addScaledVector(t[i], -v.dot(t[i])).normalize();
    }
    normal.push(v);
    third.push(t[i].clone().cross(v));
  }
  return { t, normal, third };
}

// The line of material that lies in the direction of d2, on the surface: [points, where they point].
function stripeOf(points, frames, turn, radius) {
  const places = [], out = [];
  for (let i = 0; i + 1 < turn.length; i++) {
    const pieces = Math.min(24, Math.max(1, Math.ceil(Math.abs(turn[i + 1] - turn[i]) / 0.25)));
    for (let k = 0; k < pieces + (i + 2 === turn.length); k++) {
      const w = k / pieces, angle = turn[i] * (1 - w) + turn[i + 1] * w;
      const mix = (list) => list[i].clone().lerp(list[i + 1], w);
      const e = mix(frames.normal).multiplyScalar(Math.cos(angle))
        .addScaledVector(mix(frames.third), Math.sin(angle)).normalize();
      places.push(at(points, i).lerp(at(points, i + 1), w).addScaledVector(e, 1.02 * radius));
      out.push([e, mix(frames.t)]);
    }
  }
  return [places, out];
}

// ---- two ways to draw: tubes by WebGL, lines on a canvas ----

class Tubes {
  constructor(canvas, context) {
    THREE.ColorManagement.enabled = false;
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.canvas = canvas;
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;  // colours are those of the bar
    this.renderer.setClearColor(0xffffff, 1);
    this.scene = new THREE.Scene();
    this.moving = new THREE.Group();
    this.standing = new THREE.Group();
    const sun = new THREE.DirectionalLight(0xffffff, 1.3);
    sun.position.copy(UP).addScaledVector(BACK, 0.8).addScaledVector(RIGHT, -0.5);
    this.scene.add(this.moving, this.standing, new THREE.HemisphereLight(0xffffff, 0xb0b0b0, 2.5), sun);
    this.looks = {};
  }

  size(width, height) {
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
  }

  look(kind, opacity, colour) {
    const key = [kind, opacity, colour].join();
    const over = kind === "arrow";  // forces are seen through the rod that they act on
    const common = { transparent: over || opacity < 1, opacity, depthWrite: !over && opacity === 1, depthTest: !over,
      side: THREE.DoubleSide };
    const shaded = { ...common, ...(colour ? { color: colour } : { vertexColors: true }) };
    return this.looks[key] ||= kind === "lines" ? new THREE.LineBasicMaterial({ ...common, color: colour })
      : kind === "flat" || over ? new THREE.MeshBasicMaterial({ ...common, color: colour }) : new THREE.MeshLambertMaterial(shaded);
  }

  mesh(group, arrays, index, look) {
    const body = new THREE.BufferGeometry();
    for (const [name, values] of Object.entries(arrays))
      body.setAttribute(name, new THREE.BufferAttribute(values instanceof Float32Array ? values : Float32Array.from(values), 3));
    body.setIndex(new THREE.BufferAttribute(Uint32Array.from(index), 1));
    if (!arrays.normal) body.computeVertexNormals();
    const mesh = new THREE.Mesh(body, look);
    group.add(mesh);
    return mesh;
  }

  clear(group) {
    for (const child of group.children) child.geometry.dispose();
    group.clear();
  }

  tube(points, frames, radius, colours, opacity) {
    const n = points.length / 3, rows = n + 2, count = rows * SIDES;  // a ring at each node, and one to close each end
    const position = new Float32Array(3 * count), normal = new Float32Array(3 * count);
    const color = new Float32Array(3 * count), index = [];
    for (let row = 0; row < rows; row++) {
      const i = Math.min(Math.max(row - 1, 0), n - 1), closes = row === 0 || row === rows - 1;
      for (let k = 0; k < SIDES; k++) {
        const a = 2 * Math.PI * k / SIDES, j = 3 * (row * SIDES + k), c = Math.cos(a), s = Math.sin(a);
        const e = frames.normal[i].clone().multiplyScalar(c).addScaledVector(frames.third[i], s);
        const to = closes ? frames.t[i].clone().multiplyScalar(row ? 1 : -1) : e;
        const r = closes ? 0 : radius, more = closes ? 0.5 * radius : 0;
        position.set([points[3 * i] + r * e.x + more * to.x, points[3 * i + 1] + r * e.y + more * to.y,
          points[3 * i + 2] + r * e.z + more * to.z], j);
        normal.set([to.x, to.y, to.z], j);
        color.set(colours.subarray(3 * i, 3 * i + 3), j);
        const [b, d] = [row * SIDES + (k + 1) % SIDES, (row + 1) * SIDES + k];
        if (row + 1 < rows) index.push(row * SIDES + k, b, d, b, (row + 1) * SIDES + (k + 1) % SIDES, d);
      }
    }
    this.mesh(this.moving, { position, normal, color }, index, this.look("shaded", opacity));
  }

  stripe(places, out, radius) {
    const position = [], index = [];
    places.forEach((p, i) => {
      const side = out[i][1].clone().cross(out[i][0]).multiplyScalar(0.3 * radius);
      position.push(p.x + side.x, p.y + side.y, p.z + side.z, p.x - side.x, p.y - side.y, p.z - side.z);
      if (i) index.push(2 * i - 2, 2 * i - 1, 2 * i, 2 * i - 1, 2 * i + 1, 2 * i);
    });
    this.mesh(this.moving, { position }, index, this.look("flat", 1, "#1a1a1a"));
  }

  arrow(from, to, colour, radius) {
    const along = to.clone().sub(from), long = along.length(), d = along.normalize();
    const a = (Math.abs(d.x) < 0.7 ? V(1, 0, 0) : V(0, 1, 0)).cross(d).normalize(), b = d.clone().cross(a);
    const head = Math.min(0.45 * long, 7 * radius), position = [], index = [];
    for (const [where, r] of [[0, radius], [long - head, radius], [long - head, 2.6 * radius], [long, 0]])
      for (let k = 0; k < 6; k++) {
        const p = from.clone().addScaledVector(d, where).addScaledVector(a, r * Math.cos(k * Math.PI / 3))
          .addScaledVector(b, r * Math.sin(k * Math.PI / 3));
        position.push(p.x, p.y, p.z);
      }
    for (let row = 0; row < 3; row++)
      for (let k = 0; k < 6; k++) {
        const p = 6 * row + k, q = 6 * row + (k + 1) % 6;
        index.push(p, q, p + 6, q, q + 6, p + 6);
      }
    this.mesh(this.moving, { position }, index, this.look("arrow", 1, colour)).renderOrder = 3;
  }

  path(points, colour, group, opacity = 1) {
    const body = new THREE.BufferGeometry();
    body.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(points), 3));
    (group || this.moving).add(new THREE.Line(body, this.look("lines", opacity, colour)));
  }

  pairs(points, colour) {
    const body = new THREE.BufferGeometry();
    body.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(points), 3));
    this.standing.add(new THREE.LineSegments(body, this.look("lines", 1, colour)));
  }

  surface(positions, index, colour, opacity, lines, group) {
    this.mesh(group, { position: positions }, index, this.look("shaded", opacity, colour)).renderOrder = 2;
    for (const line of lines) this.path(line, "#8a8371", group, 0.7);
  }

  box(centre, size, turn) {
    const position = [], index = [];
    for (const [d, e, g] of [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
      for (const sign of [-1, 1]) {
        const first = position.length / 3;
        for (const [p, q] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
          const at = centre.clone().addScaledVector(turn[d], sign * size).addScaledVector(turn[e], p * size)
            .addScaledVector(turn[g], q * size);
          position.push(at.x, at.y, at.z);
        }
        index.push(first, first + 1, first + 2, first, first + 2, first + 3);
      }
    this.mesh(this.moving, { position }, index, this.look("shaded", 1, "#333"));
  }

  show(camera) {
    this.renderer.render(this.scene, camera);
  }
}

class Lines {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.moving = [];
    this.standing = [];
  }

  size(width, height) {
    Object.assign(this.canvas, { width: width * devicePixelRatio, height: height * devicePixelRatio });
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
  }

  clear(group) {
    group.length = 0;
  }

  piece(group, a, b, colour, width, opacity) {
    group.push({ a, b, colour, width, opacity });
  }

  tube(points, frames, radius, colours, opacity) {
    for (let i = 0; i + 1 < points.length / 3; i++) {
      const rgb = [0, 1, 2].map((d) => Math.round(127.5 * (colours[3 * i + d] + colours[3 * i + 3 + d])));
      this.piece(this.moving, at(points, i), at(points, i + 1), `rgb(${rgb})`, 2 * radius, opacity);
    }
  }

  stripe(places) {
    for (let i = 0; i + 1 < places.length; i++)
      this.piece(this.moving, places[i], places[i + 1], "#1a1a1a", 0, 1);
  }

  arrow(from, to, colour) {
    this.piece(this.moving, from, to, colour, "arrow", 1);
  }

  path(points, colour, group, opacity = 1) {
    for (let i = 0; i + 1 < points.length / 3; i++)
      this.piece(group || this.moving, at(points, i), at(points, i + 1), colour, 0, opacity);
  }

  pairs(points, colour) {
    for (let i = 0; i + 1 < points.length / 3; i += 2)
      this.piece(this.standing, at(points, i), at(points, i + 1), colour, 0, 1);
  }

  surface(positions, index, colour, opacity, lines, group) {
    for (const line of lines) this.path(line, "#8a8371", group, 0.8);
  }

  box(centre, size, turn) {
    this.piece(this.moving, centre.clone().addScaledVector(turn[0], -size), centre.clone().addScaledVector(turn[0], size),
      "#333", 2 * size, 1);
  }

  show(camera) {
    const ctx = this.canvas.getContext("2d"), { width, height } = this.canvas;
    const scale = height / 2 / Math.tan(camera.fov * Math.PI / 360);  // pixels that 1 has at a distance of 1
    ctx.clearRect(0, 0, width, height);
    const seen = [...this.standing, ...this.moving].map((piece) => {
      const [a, b] = [piece.a, piece.b].map((p) => p.clone().applyMatrix4(camera.matrixWorldInverse));
      return { ...piece, a, b, depth: -(a.z + b.z) / 2 };
    }).filter(({ a, b }) => a.z < -camera.near && b.z < -camera.near).sort((one, other) => other.depth - one.depth);
    const place = (p) => [width / 2 - scale * p.x / p.z, height / 2 + scale * p.y / p.z];
    for (const { a, b, colour, width: thick, opacity, depth } of seen) {
      const [p, q] = [place(a), place(b)];
      ctx.globalAlpha = opacity;
      ctx.lineCap = opacity < 1 ? "butt" : "round";
      ctx.strokeStyle = colour;
      ctx.lineWidth = thick === "arrow" ? 1.3 * devicePixelRatio : Math.max(devicePixelRatio, scale * thick / depth);
      const [dx, dy] = [q[0] - p[0], q[1] - p[1]], head = thick === "arrow" ? Math.min(0.35, 7 * devicePixelRatio / (Math.hypot(dx, dy) || 1)) : 0;
      if (head) {
        arrowPath(ctx, ...p, dx, dy, head);
      } else {
        ctx.beginPath();
        ctx.moveTo(...p);
        ctx.lineTo(...q);
      }
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }
}

function painterOf() {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
  element("lines-note").hidden = Boolean(context);
  return context ? new Tubes(canvas, context) : new Lines();
}

// ---- what is seen from where ----

// [low, high] corners of arrays of points
function cornersOf(lists) {
  const low = V(Infinity, Infinity, Infinity), high = V(-Infinity, -Infinity, -Infinity);
  for (const [points, f] of lists)
    for (let i = 0; i < points.length / 3; i++) {
      const p = at(points, i).multiplyScalar(f);
      low.min(p);
      high.max(p);
    }
  return [low, high];
}

// What the camera is to hold: the whole run, or the present shape, with the clamp; [points, factor] lists
function held() {
  const lists = [[stage.floor, 1]];
  for (const run of data.runs.filter((r) => r.shown)) {
    const f = factor(run, "l");
    lists.push(element("follow").checked ? [shapeAt(run, state.t / factor(run, "l/V")).x, f] : [run.shapes.x, f]);
  }
  return lists;
}

// Sets the camera on its present direction so that all of that is just seen.
function fit() {
  const { camera, controls } = stage, lists = held(), [low, high] = cornersOf(lists);
  const centre = low.clone().add(high).multiplyScalar(0.5), back = stage.direction;
  const right = UP.clone().cross(back).normalize(), up = back.clone().cross(right);
  const tall = Math.tan(camera.fov * Math.PI / 360), wide = tall * camera.aspect;
  const middle = [0, 0];
  let far = 1e-6;
  for (let round = 0; round < 3; round++) {  // the middle of what is seen is not that of the box
    const span = [[Infinity, -Infinity], [Infinity, -Infinity]];
    far = 1e-6;
    const eye = centre.clone().addScaledVector(right, middle[0]).addScaledVector(up, middle[1]);
    for (const [points, f] of lists) {
      const every = Math.max(1, Math.floor(points.length / 3 / 4000));
      for (let i = 0; i < points.length / 3; i += every) {
        const p = at(points, i).multiplyScalar(f).sub(eye), [x, y, z] = [p.dot(right), p.dot(up), p.dot(back)];
        far = Math.max(far, Math.abs(x) / wide + z, Math.abs(y) / tall + z);
        [x, y].forEach((v, d) => { span[d] = [Math.min(span[d][0], v), Math.max(span[d][1], v)]; });
      }
    }
    if (round < 2) span.forEach(([a, b], d) => { middle[d] += (a + b) / 2; });
  }
  controls.target.copy(centre).addScaledVector(right, middle[0]).addScaledVector(up, middle[1]);
  camera.position.copy(controls.target).addScaledVector(back, 1.08 * far);
  controls.update();
}

const distance = () => stage.camera.position.distanceTo(stage.controls.target);
const pixel = () => 2 * distance() * Math.tan(stage.camera.fov * Math.PI / 360) / stage.height;  // its size at the target

// A plane of squares under the rod, whose side is told, and the walls.
function drawStanding() {
  const { painter } = stage, shown = data.runs.filter((run) => run.shown);
  painter.clear(painter.standing);
  const [low, high] = cornersOf(shown.map((run) => [run.shapes.x, factor(run, "l")]).concat([[[0, 0, 0], 1]]));
  const extent = Math.max(...high.clone().sub(low).toArray()) || 1, power = 10 ** Math.floor(Math.log10(extent / 6));
  const side = [1, 2, 5, 10].map((k) => k * power).find((v) => extent / v <= 9) || extent;
  const lowest = Math.min(low.dot(UP), high.dot(UP)) - 0.03 * extent, lines = [];
  const span = (d) => [Math.min(low.dot(d), high.dot(d)), Math.max(low.dot(d), high.dot(d))];
  const [a, b] = [RIGHT, BACK].map(span).map(([p, q]) => [Math.floor(p / side - 0.3), Math.ceil(q / side + 0.3)]);
  const point = (i, j) => UP.clone().multiplyScalar(lowest).addScaledVector(RIGHT, i * side).addScaledVector(BACK, j * side).toArray();
  stage.floor = [[a[0], b[0]], [a[0], b[1]], [a[1], b[0]], [a[1], b[1]]].flatMap(([i, j]) => point(i, j)).concat([0, 0, 0]);
  for (let i = a[0]; i <= a[1]; i++) lines.push(...point(i, b[0]), ...point(i, b[1]));
  for (let j = b[0]; j <= b[1]; j++) lines.push(...point(a[0], j), ...point(a[1], j));
  painter.pairs(lines, "#d4d4d4");
  for (const run of shown) run.surfaces.filter((one) => !one.motion).forEach((one) => drawSurface(run, one, painter.standing));
  stage.extent = extent;
  element("grid").textContent = `a square: ${number(side)} ${named("l")}`;
}

function drawSurface(run, { positions, index, lines }, group) {
  const f = factor(run, "l");
  stage.painter.surface(scaled(positions, f), index, "#cfc6ae", 0.28, lines.map((line) => scaled(line, f)), group);
}

// A surface that moves, where it is at a time; what has no end is laid under the rod anew (solids.py).
function carried(surface, t) {
  const { turns: [, ...place] = [0, 0, 0, 0, 0, 0, 1], endless = [], middle = [0, 0, 0] } = surface.motion;
  const turn = turnedBy(surface.motion, t);
  const about = V(...place.slice(0, 3)), axle = V(...place.slice(3));
  const to = about.clone().add(V(...shiftOf(surface.motion, t)));
  const under = V(...middle).sub(to).applyAxisAngle(axle, -turn).add(about).sub(V(...middle)), laid = V(0, 0, 0);
  for (const d of endless) laid.addScaledVector(V(...d), under.dot(V(...d)));
  const moved = (points) => {
    const all = new Float32Array(points.length);
    for (let i = 0; i < points.length / 3; i++)
      all.set(at(points, i).add(laid).sub(about).applyAxisAngle(axle, turn).add(to).toArray(), 3 * i);
    return all;
  };
  return { ...surface, positions: moved(surface.positions), lines: surface.lines.map(moved) };
}

function drawForces3(places, forces, strongest, colour, f, end) {
  const scale = ARROW_SHARE * stage.extent / strongest;
  for (let i = 0; i < places.length / 3; i++) {
    const force = at(forces, i).multiplyScalar(scale);
    if (force.length() < 0.004 * stage.extent) continue;
    const place = at(places, i).multiplyScalar(f);
    stage.painter.arrow(end ? place.clone().sub(force) : place, end ? place : place.clone().add(force), colour,
      Math.max(0.7 * pixel(), 0.0012 * stage.extent));
  }
}

function drawEarlier(run, t, f, radius) {
  for (let k = 1; k <= GHOSTS; k++) {
    const then = run.end * k / (GHOSTS + 1);
    if (then > t * (1 - 1e-6)) break;
    const shape = shapeAt(run, then), points = scaled(shape.x, f);
    const grey = new Float32Array(points.length).fill(several ? 0 : 0.45);
    if (several) for (let i = 0; i < grey.length; i++) grey[i] = parsed(run.colour)[i % 3];
    stage.painter.tube(points, framesOf(points, at(shape.base, 0)), 0.7 * radius, grey, 0.22);
  }
  const [k] = locate(run.series.t, t), way = [];
  for (let i = 0; i <= k; i++)
    way.push(...[1, 2, 3].map((d) => f * (run.series[`tip_x${d}`] ? run.series[`tip_x${d}`][i] : 0)));
  if (way.length > 3) stage.painter.path(way, several ? run.colour : "#2b6777");
}

function drawRun(run) {
  const t = Math.min(state.t / factor(run, "l/V"), run.end), f = factor(run, "l"), { painter } = stage;
  const shape = bodyAt(run, t), points = scaled(shape.x, f), frames = framesOf(points, at(shape.base, 0));
  const radius = Math.max(f * (run.diameter || data.visible) / 2, LEAST / 2 * pixel());
  for (const one of run.surfaces.filter(({ motion }) => motion)) drawSurface(run, carried(one, t), painter.moving);
  painter.tube(points, frames, radius, coloursOf(run, shape), ended(run) ? 0.4 : 1);
  if (element("stripe").checked) painter.stripe(...stripeOf(points, frames, shape.turn, radius), radius);
  if (element("earlier").checked) drawEarlier(run, t, f, radius);
  if (element("friction").checked) drawForces3(shape.places, shape.friction, strongest("drag") / factor(run, "N"), "#8a8a8a", f, false);
  if (shape.contact && element("contact").checked)
    drawForces3(shape.touched, shape.contact, strongest("press") / factor(run, "N"), "#C2410C", f, true);
  painter.box(V(0, 0, 0).addScaledVector(frames.t[0], -1.6 * radius), 1.6 * radius,
    [frames.t[0], frames.normal[0], frames.third[0]]);
}

// Where the axes point, in a corner.
function drawAxes() {
  const canvas = element("axes"), ctx = canvas.getContext("2d"), size = 84, half = size / 2;
  canvas.width = canvas.height = size * devicePixelRatio;
  ctx.scale(devicePixelRatio, devicePixelRatio);
  ctx.font = "12px system-ui, sans-serif";
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  [["x₁", V(1, 0, 0)], ["x₂", V(0, 1, 0)], ["x₃", V(0, 0, 1)]].map(([name, d]) =>
    [name, d.transformDirection(stage.camera.matrixWorldInverse)]).sort((a, b) => a[1].z - b[1].z).forEach(([name, d]) => {
    ctx.strokeStyle = ctx.fillStyle = d.z < -0.3 ? "#999" : "#222";
    ctx.beginPath();
    ctx.moveTo(half, half);
    ctx.lineTo(half + 26 * d.x, half - 26 * d.y);
    ctx.stroke();
    ctx.fillText(name, half + 35 * d.x, half - 35 * d.y);
  });
}

function draw() {
  const { camera, controls, painter } = stage, d = distance();
  camera.near = Math.max(d / 500, d - 4 * stage.extent);
  camera.far = d + 8 * stage.extent;
  camera.updateProjectionMatrix();
  camera.lookAt(controls.target);
  camera.updateMatrixWorld();
  painter.clear(painter.moving);
  for (const run of data.runs.filter((r) => r.shown)) drawRun(run);
  painter.show(camera);
  drawAxes();
}

function look(direction) {
  stage.direction = direction.normalize();
  stage.touched = false;
  fit();
  draw();
}

// The first look: along the rod's plane of squares, from the front and above.
const FIRST = () => BACK.clone().addScaledVector(RIGHT, 0.35).addScaledVector(UP, 0.4);

function makeStage() {
  const painter = painterOf(), camera = new THREE.PerspectiveCamera(24, 1, 0.1, 100);
  camera.up.copy(UP);
  element("rod").prepend(painter.canvas);
  const controls = new THREE.OrbitControls(camera, painter.canvas);
  stage = { painter, camera, controls, direction: FIRST().normalize(), touched: false, extent: 1, height: 1, shown: "" };
  controls.addEventListener("start", () => { stage.touched = true; });
  controls.addEventListener("change", () => {
    if (!stage.touched) return;
    stage.direction.copy(camera.position).sub(controls.target).normalize();
    draw();
  });
  const sides = { "side-12": [1, 2, 3], "side-13": [1, 3, -2], "side-23": [2, 3, 1] };
  for (const [id, [, , from]] of Object.entries(sides))
    element(id).onclick = () => look(axis(from).addScaledVector(BACK, 1e-4).addScaledVector(UP, 1e-4));
  element("first-look").onclick = () => look(FIRST());
  element("stripe").checked = data.twisted;
  for (const id of ["stripe", "earlier"]) element(id).onchange = draw;
  offerFields();
  rod = { root: element("rod"), data: null, redraw: draw, setData: () => { fit(); draw(); } };
}

function makeRod() {
  if (!stage) makeStage();
  const width = element("rod").clientWidth, height = Math.round(Math.min(0.85 * width, Math.max(300, 0.62 * innerHeight)));
  const shown = [state.lab, element("follow").checked].join();
  stage.height = height;
  stage.camera.aspect = width / height;
  stage.painter.size(width, height);
  drawStanding();
  if (!stage.touched || shown !== stage.shown) fit();
  stage.shown = shown;
  makeBar();
}

// The colours of the field with its numbers, and how strong the longest arrows are.
function makeBar() {
  makeRamp();
  const long = ARROW_SHARE * stage.extent / pixel();
  for (const [id, kind, there] of [["friction", "drag", true], ["contact", "press", hasContact]]) {
    const key = element(`${id}-key`);
    key.hidden = !there || !element(id).checked;
    key.querySelector("i").style.width = `${Math.min(120, Math.max(12, long))}px`;
    key.querySelector("b").textContent = `${id} ${number(strongest(kind))} ${named("N") || "per length"}`;
  }
}

