#!/usr/bin/env python3
# test: the page of a run shows what is in its file
"""The page of scripts/view.sh: what is in it, and, where Chromium is installed, what it does there.

    test_view.py build/tendril"""

import base64
import dataclasses
import html
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from chromium import FOUND as BROWSER, MISSING
from held import HANG
from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts"))
try:
    import h5py
    import numpy as np

    import tendril
    from tendril.senses import strain_rate
    from tendril.results import Table
    from tendril.solids import revolved, turn
    from tendril.surroundings import friction, pressed
except ImportError as error:
    from_venv(error)

NODE = shutil.which("node")
QUIET = """--headless --no-sandbox --disable-quic --no-first-run --disable-sync
    --disable-background-networking --disable-component-update --hide-scrollbars""".split()
DRAWN = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]  # WebGL without a graphics card
LARGEST = 5e6  # bytes of the page of a run with 200 shapes

# What is done in the page, as a user would; what it shows then is left in the element #seen.
ACTIONS = """
const seen = {};
window.onerror = (message) => { seen.error = message; };
// a browser that draws for nobody may leave out frames
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);
const frame = () => new Promise((done) => setTimeout(done, 60));
const set = async (id, change) => { change(element(id)); await frame(); };
const press = (box) => box.click();
const slide = (value) => (slider) => { slider.value = value; slider.dispatchEvent(new Event("input")); };
const titles = () => Array.from(document.querySelectorAll(".chart h2"), (h) => h.textContent);
const cursor = (u) => u.posToVal(u.cursor.left, "x");
// a mouse on a chart, at a part of its width
const mouse = (u, what, part) => {
  const box = u.over.getBoundingClientRect();
  u.over.dispatchEvent(new MouseEvent(what, { clientX: box.left + part * box.width, bubbles: true, button: 0,
    movementX: 1, buttons: what === "mousemove" ? 1 : 0, clientY: box.top + box.height / 2, cancelable: true }));
};
const mice = async (u, ...steps) => {
  for (const [what, part] of steps) { mouse(u, what, part); await frame(); }
};
(async () => {
  try {
    await frame();
    seen.ready = document.body.dataset.ready;
    seen.opened = state.t;
    if (!element("lab-label").hidden) {
      seen.first = { lab: element("lab").checked, charts: titles(), end: lastTime() };
      await set("lab", press);
    }
    seen.milliseconds = performance.now();
    seen.charts = titles();
    seen.wide = document.documentElement.scrollWidth - innerWidth;
    const [about, sheet, rest] = ["about", "charts", "stage"].map((id) => element(id).getBoundingClientRect());
    seen.about = [about.left, about.right, about.top, sheet.left, sheet.bottom, rest.bottom];
    const before = rod.root.querySelector("canvas").toDataURL();
    await set("slider", slide(500));
    seen.now = element("now").textContent;
    seen.cursors = charts.map(cursor);
    seen.values = Array.from(document.querySelectorAll(".chart:first-child .u-value"), (v) => v.textContent);
    seen.moved = before !== rod.root.querySelector("canvas").toDataURL();
    await mice(charts[0], ["mousemove", 0.2], ["mousedown", 0.2], ["mousemove", 0.6], ["mouseup", 0.6],
               ["click", 0.6]);
    seen.enlarged = charts.map((u) => [u.scales.x.min, u.scales.x.max]);
    await mice(charts[1], ["mousedown", 0.5], ["mouseup", 0.5], ["click", 0.5], ["mouseleave", 0.5]);
    seen.clicked = [state.t, ...charts.map(cursor)];
    await mice(charts[2], ["dblclick", 0.5]);
    seen.whole = charts.map((u) => u.scales.x.max);
    await set("slider", slide(500));
    if (!element("lab-label").hidden) {
      await set("lab", press);
      seen.lab = { charts: titles(), now: element("now").textContent, cursors: charts.map(cursor),
                   summary: element("about").innerText };
    }
    await set("friction", press);
    await set("follow", press);
    seen.limits = [rod.scales.x.min, rod.scales.x.max, rod.scales.y.min, rod.scales.y.max];
    seen.box = [rod.bbox.width, rod.bbox.height];
    const box = document.querySelector("#runs input");
    if (box) {
      press(box);
      await frame();
      seen.lines = charts.map((u) => u.series.filter((one) => !one.edge).length - 1);
    }
    element("slider").value = 0;
    press(element("play"));
    for (let k = 0; k < 20 && !seen.played; k++) { // a busy machine takes its time
      await new Promise((done) => setTimeout(done, 200));
      seen.played = Number(element("slider").value);
    }
    press(element("play")); // or it is drawn for as long as the browser waits
  } catch (error) { seen.error = String(error); }
  const pre = document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  document.body.append(pre);
})();
"""


# What the table of the page says at some times, without a browser.
TABLE = """
globalThis.document = { getElementById: () => ({ textContent: require("fs").readFileSync(process.argv[3], "utf8") }) };
(0, eval)(["format.js", "data.js"].map((name) => require("fs").readFileSync(process.argv[1] + name, "utf8")).join("") + `
  data.runs.forEach(unpack);
  const [lab, times] = JSON.parse(process.argv[2]);
  state.lab = lab;
  console.log(JSON.stringify(times.map((t) => { state.t = t; return numbersNow(); })));`);
"""


# ... in the page of a rod in space; what the canvas shows is read from its pixels.
SPACE = """
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);
const seen = {};
window.onerror = (message) => { seen.error = message; };
const wait = (time = 60) => new Promise((done) => setTimeout(done, time));
const canvas = stage.painter.canvas;
canvas.setPointerCapture = canvas.releasePointerCapture = () => {};  // these pointers are not the browser's own
function pixels() {
  const copy = document.createElement("canvas");
  Object.assign(copy, { width: canvas.width, height: canvas.height });
  const ctx = copy.getContext("2d", { willReadFrequently: true });
  ctx.fillStyle = "#fff";
  ctx.fillRect(0, 0, copy.width, copy.height);
  ctx.drawImage(canvas, 0, 0);
  return ctx;
}
// Of nodes of the present shape: where the camera has them, and the colour there.
function nodes() {
  const shape = bodyAt(data.runs[0], state.t / factor(data.runs[0], "l/V")), f = factor(data.runs[0], "l");
  const ctx = pixels(), n = data.runs[0].nodes;
  return [0.3, 0.6, 0.9].map((s) => {
    const i = Math.round(s * (n - 1)), p = at(shape.x, i).multiplyScalar(f).project(stage.camera);
    const place = [Math.round((p.x + 1) / 2 * canvas.width), Math.round((1 - p.y) / 2 * canvas.height)];
    return { place, size: [canvas.width, canvas.height], colour: Array.from(ctx.getImageData(...place, 1, 1).data.slice(0, 3)) };
  });
}
const ink = () => {
  const all = pixels().getImageData(0, 0, canvas.width, canvas.height).data;
  let dark = 0;
  for (let i = 0; i < all.length; i += 4) dark += all[i + 1] < 180;
  return dark / (all.length / 4);
};
const pointer = (what, x, y) => {
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new PointerEvent(what, { pointerId: 1, pointerType: "touch", clientX: box.left + x * box.width,
    clientY: box.top + y * box.height, pageX: box.left + x * box.width, pageY: box.top + y * box.height,
    bubbles: true, cancelable: true, button: 0, buttons: 1 }));
};
(async () => {
  try {
    await wait();
    for (const id of ["friction", "stripe"]) if (element(id).checked) element(id).click();
    await wait();
    seen.ready = document.body.dataset.ready;
    seen.lines = !element("lines-note").hidden;
    seen.wide = document.documentElement.scrollWidth - innerWidth;
    seen.charts = Array.from(document.querySelectorAll(".chart h2"), (h) => h.textContent);
    seen.grid = element("grid").textContent;
    seen.first = nodes();
    seen.ink = [ink()];
    const before = stage.direction.toArray();
    for (const [what, x] of [["pointerdown", 0.5], ["pointermove", 0.6], ["pointermove", 0.7], ["pointerup", 0.7]]) pointer(what, x, 0.5);
    await wait();
    seen.turned = stage.direction.toArray().map((v, i) => v - before[i]);
    seen.second = nodes();
    const far = distance();
    canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -400, bubbles: true, cancelable: true }));
    await wait();
    seen.nearer = distance() / far;
    element("side-12").click();
    await wait();
    seen.above = stage.direction.toArray();
    element("first-look").click();
    seen.fields = Array.from(element("field").options, (o) => o.value);
    element("field").value = "curvature";
    element("field").dispatchEvent(new Event("change"));
    await wait();
    seen.third = nodes();
    seen.ticks = Array.from(document.querySelectorAll("#ticks span"), (v) => Number(v.textContent));
    element("earlier").click();
    element("stripe").click();
    await wait();
    seen.ink.push(ink());
    element("slider").value = 500;
    element("slider").dispatchEvent(new Event("input"));
    await wait();
    seen.now = element("now").textContent;
    seen.fourth = nodes();
    element("slider").value = 0;
    element("play").click();
    for (let k = 0; k < 20 && !seen.played; k++) {
      await wait(200);
      seen.played = Number(element("slider").value);
    }
    element("play").click(); // or it is drawn for as long as the browser waits
  } catch (error) { seen.error = String(error) + error.stack; }
  const pre = document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  document.body.append(pre);
})();
"""


def content(page):
    """What the page's script is given."""
    text = re.search(r'(?s)<script id="data" type="application/json">(.*?)</script>', page)[1]
    return json.loads(text)


def array(text):
    return np.frombuffer(base64.b64decode(text), "<f4")


class View(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory(prefix="tendril-")
        cls.place = Path(cls.directory.name)
        shared = dict(growth_type="feed", growth_initial_length="1cm", si_bending_stiffness="2.209Nmm^2",
                      si_speed="5mm/s", rod_curvature="3/m", shape_type="straight", rod_cells=80)
        cls.runs = [tendril.run(si_friction_dry=f"{n}N/m", ts_max_time=t, output_interval="1s", **shared)
                    for n, t in ((0.5, "40s"), (1, "20s"))]

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def page(self, runs, name="page.html", **more):
        return tendril.view(runs, self.place / name, **more).read_text(encoding="utf-8")

    def test_holds_all(self):
        """Every series and shape as in the file, options and units; nothing from elsewhere."""
        page = self.page(self.runs, titles=["soft <b>", "hard"])
        data = content(page)
        for r, run in zip(self.runs, data["runs"]):
            self.assertEqual(run["series"].keys(), r.series.keys())
            np.testing.assert_allclose(array(run["series"]["width"]), r.series.width, rtol=1e-6)
            x = array(run["shapes"]["x"]).reshape(-1, 81, 2)
            np.testing.assert_allclose(x, r.shapes.x, rtol=1e-6, atol=1e-6)
            self.assertIn("-growth_initial_length 1cm", run["options"])
            self.assertAlmostEqual(run["factors"]["l"], 100 * r.scale("length"))
        drawn = [name for chart in data["charts"] for name in chart["series"]]
        self.assertEqual(sorted(drawn), sorted(set(self.runs[0].series) - {"t"}))
        self.assertEqual(data["units"]["l/V"], "s")
        self.assertIn("soft &lt;b&gt;", page)
        self.assertNotRegex(page, r'(src|href)="')
        self.assertIn("Permission is hereby granted", page)

    def test_growth_as_colour(self):
        """The colours of a rod in the plane may show how fast it grows, if only a part of it does."""
        r = tendril.run(growth_type="apical", growth_zone=0.3, growth_initial_length=1, rod_cells=40, ts_max_time=0.1, output_shapes=2)
        data = content(self.page(r))
        packed = data["runs"][0]["fields"]["growth"]
        rate = np.frombuffer(base64.b64decode(packed["values"]), "<i2").reshape(3, 41) * packed["most"] / 32767
        np.testing.assert_allclose(rate, [strain_rate(r, r.stored(k)) for k in range(3)], atol=packed["most"] / 32767)
        self.assertGreater(packed["most"], 1)
        self.assertEqual(list(data["fields"]), ["axial", "curvature", "growth"])
        self.assertNotIn("growth", content(self.page(self.runs))["fields"])

    def test_nothing_to_say_of_contact(self):
        """Arrows of contact have a key, and a box to tick, only where something was touched."""
        for place, touches in ((9, False), (2.5, True)):
            r = tendril.run(growth_type="feed", growth_initial_length=2, shape_amplitude=0.1, rod_cells=40, ts_max_time=1,
                            wall_file=[tendril.plane((place, 0), (-1, 0))], contact_diameter=0.1)
            self.assertEqual((content(self.page(r))["touches"], bool(r.series.contact_force.any())), (touches, touches))

    def test_a_motion_that_happened(self):
        """Between two stored shapes the rod is drawn in a straight motion only where that is what it did; of
        a run of which the first and the last are stored it is not."""
        rod = dict(growth_type="feed", growth_initial_length=2, shape_amplitude=0.1, rod_cells=60, ts_max_time=8)
        fair = [array(content(self.page(tendril.run(rod, output_shapes=n)))["runs"][0]["shapes"]["fair"])
                for n in (1, 80)]
        self.assertEqual((len(fair[0]), fair[0].sum()), (1, 0))
        self.assertEqual((len(fair[1]), fair[1].sum()), (80, 80))

    def table(self, runs, times, lab=True):
        """What the page's table says at these times: of each a dictionary by row of lists by run."""
        page = self.page(runs)
        file = self.place / "content.json"
        file.write_text(re.search(r'(?s)<script id="data" type="application/json">(.*?)</script>', page)[1])
        done = subprocess.run([NODE, "-e", TABLE, f"{ROOT}/scripts/tendril/web/", json.dumps([lab, times]),
                               str(file)], capture_output=True, text=True, timeout=HANG)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        rows = [text for text, _, _ in content(page)["follows"]]
        return [dict(zip(rows, values, strict=True)) for values in json.loads(done.stdout)]

    @unittest.skipUnless(NODE, "no Node.js here")
    def test_a_table_of_the_time_shown(self):
        """Numbers are those of the slider's time, straight on between steps, each run in its units; of a run that has
        ended its last ones."""
        for lab in (True, False):
            times = [0, 7.3, 20, 33.3, 40] if lab else [r.series.t[-1] * part for r in self.runs[:1] for part in (0, 0.3, 1)]
            for t, table in zip(times, self.table(self.runs, times, lab)):
                for k, r in enumerate(self.runs):
                    factor = {name: r.scale(unit) * si if lab else 1 for name, unit, si in (
                        ("t", "time", 1), ("length", "length", 100), ("tip_x2", "length", 100))}
                    at = min(t / factor["t"], r.series.t[-1])
                    for text, name in (("time", "t"), ("length", "length"), ("tip x2", "tip_x2")):
                        told, true = float(table[text][k]), np.interp(at, r.series.t, r.series[name]) * factor[name]
                        self.assertLess(abs(told - true), 1e-3 * abs(true) + 1e-6, (lab, t, text, k))
        first, last = self.table(self.runs, [0, 40])
        self.assertTrue(all(first[text] != last[text] for text in ("time", "length", "energy", "tip x1")), last)

    def test_size(self):
        r = tendril.run("feed", output_interval=0.04)
        self.assertGreaterEqual(len(r.shapes.t), 200)
        self.assertLess(len(self.page(r).encode()), LARGEST)

    def seen(self, page, size, actions=ACTIONS, graphics=("--disable-gpu",)):
        """What the page shows after all has been tried, at this size of the window."""
        file = self.place / "tried.html"
        file.write_text(page.replace("</body>", f"<script>{actions}</script></body>"), encoding="utf-8")
        with tempfile.TemporaryDirectory(prefix="tendril-") as profile:
            done = subprocess.run([BROWSER, *QUIET, *graphics, f"--user-data-dir={profile}", f"--window-size={size}",
                                   "--virtual-time-budget=8000", "--dump-dom", file.as_uri()],
                                  capture_output=True, text=True, timeout=HANG)
        found = re.search(r'(?s)<pre id="seen">(.*?)</pre>', done.stdout)
        self.assertTrue(found, done.stdout[-500:] + done.stderr[-2000:])
        return json.loads(html.unescape(found[1]))

    @unittest.skipUnless(BROWSER, MISSING)
    def test_one_run_on_a_screen(self):
        r = self.runs[0]
        seen = self.seen(self.page(r), "1280,900")
        self.assertNotIn("error", seen)
        self.assertEqual((seen["ready"], seen["moved"], seen["wide"]), ("yes", True, 0))
        second = r.scale("time")
        self.assertAlmostEqual(seen["opened"], r.series.t[-1] * second, 3)  # on what has come of it, in the laboratory
        self.assertTrue(seen["first"]["lab"] and "distance (cm)" in seen["first"]["charts"], seen["first"])
        self.assertIn("energy", seen["charts"])
        middle = r.series.t[-1] / 2
        self.assertEqual(seen["now"].strip(), f"t = {middle:.4g}")
        np.testing.assert_allclose(seen["cursors"], middle, rtol=0.01)
        step = r.series.t[np.argmin(np.abs(r.series.t - middle))]
        np.testing.assert_allclose([float(v) for v in seen["values"][:2]], [step, r.value("length", step)],
                                   rtol=0.02)
        end = r.series.t[-1]
        np.testing.assert_allclose(seen["enlarged"], [[0.2 * end, 0.6 * end]] * len(seen["charts"]), rtol=0.02)
        np.testing.assert_allclose(seen["clicked"], 0.4 * end, rtol=0.02)  # the middle of what is enlarged
        np.testing.assert_allclose(seen["whole"], end)
        lab = seen["lab"]
        self.assertEqual(lab["now"], "t = 20 s")
        np.testing.assert_allclose(lab["cursors"], 20, rtol=0.01)
        self.assertTrue({"distance (cm)", "force at the clamp (mN)"} <= set(lab["charts"]))
        self.assertRegex(lab["summary"], r"length \(cm\)\s+11\b")  # at the slider's time, of 1 cm to 21
        self.assertRegex(lab["summary"], r"time \(s\)\s+20\b")
        x0, x1, y0, y1 = seen["limits"]  # both axes in one scale, around the present rod
        self.assertAlmostEqual((x1 - x0) / (y1 - y0), seen["box"][0] / seen["box"][1], 3)
        shape = r.at(middle).x * 100 * r.scale("length")
        self.assertTrue(x0 < shape[:, 0].min() and shape[:, 0].max() < x1)
        self.assertTrue(y0 < shape[:, 1].min() and shape[:, 1].max() < y1)
        self.assertGreater(seen["played"], 0)
        _, right, top, beside, _, stage = seen["about"]  # no empty column below the rod
        self.assertTrue(right <= beside and stage <= top < stage + 40, seen["about"])

    @unittest.skipUnless(BROWSER, MISSING)
    def test_two_runs_on_a_phone(self):
        """Both in every chart, or the one that is not ticked off; nothing is wider than the screen."""
        seen = self.seen(self.page(self.runs), "500,850")
        self.assertNotIn("error", seen)
        self.assertEqual(seen["wide"], 0)
        self.assertGreaterEqual(seen["about"][2], seen["about"][4])  # below the curves
        np.testing.assert_allclose(seen["lab"]["cursors"], 20, rtol=0.01)
        charts = content(self.page(self.runs))["charts"]
        self.assertEqual(seen["lines"][0], len(charts[0]["series"]))

    @unittest.skipUnless(BROWSER, MISSING)
    def test_a_series_of_hardly_anything_on_a_logarithmic_axis(self):
        """Errors of a tip that is held are 1e-27: their chart has numbers at decades, as any."""
        drawn = """const seen = {}; window.onerror = (message) => { seen.error = message; };
            const told = [[1e-27, 1], [2e-5, 3e-4]].map(([low, high]) => new uPlot({ width: 400, height: 210, scales: { x: { time: false }, y: { distr: 3 } },
              axes: [{}, valueAxis(true)], series: [{}, { stroke: "red" }] }, [[0, 1], [low, high]], document.body));
            setTimeout(() => { seen.numbers = told.map((u) => u.axes[1]._values);
              const pre = document.createElement("pre"); pre.id = "seen"; pre.textContent = JSON.stringify(seen);
              document.body.append(pre); }, 300);"""
        seen = self.seen(self.page(self.runs[0]), "800,600", drawn)
        self.assertNotIn("error", seen)
        self.assertEqual(seen["numbers"], [["1e-25", "1e-20", "1e-15", "1e-10", "1e-5", "1"], ["1e-4", "0.001"]])

    # ---- a rod in space ----

    @classmethod
    def wire(cls):
        """Fed, bent by nature, and turned at its clamp: made once."""
        if not hasattr(cls, "spun"):
            cls.spun = tendril.run(growth_type="feed", growth_initial_length=1, rod_curvature=0.6, clamp_spin="60deg",
                                   friction_radius=0.05, shape_type="straight", rod_cells=60, ts_max_time=8,
                                   output_interval=0.2)
        return cls.spun

    def test_space_holds_all(self):
        """Shapes as in the file, fields to a part in 32767 of the largest; the turns of the material about the
        centre line are the twist of the series, which the program integrates by itself."""
        r = self.wire()
        page = self.page(r)
        data = content(page)
        run = data["runs"][0]
        x = array(run["shapes"]["x"]).reshape(r.shapes.x.shape)
        np.testing.assert_allclose(x, r.shapes.x, rtol=1e-6, atol=1e-6)
        for name, true in (("curvature", r.shapes.curvature), ("twist", r.shapes.strain[..., 0]),
                           ("axial", np.sum(r.shapes.force * r.shapes.d1, axis=-1)),
                           ("twisting_moment", np.sum(r.shapes.moment * r.shapes.d1, axis=-1))):
            packed = run["fields"][name]
            values = np.frombuffer(base64.b64decode(packed["values"]), "<i2").reshape(true.shape) * packed["most"] / 32767
            np.testing.assert_allclose(values, true, atol=packed["most"] / 32767)
            self.assertEqual(data["fields"][name]["most"], packed["most"])
        turns = array(run["shapes"]["turn"]).reshape(true.shape)[:, -1]
        twist = [r.value("twist", t) for t in r.shapes.t]
        np.testing.assert_allclose(turns, twist, atol=2e-3)
        self.assertGreater(np.ptp(twist), 1)
        self.assertEqual(run["diameter"], 0.1)
        self.assertEqual(data["up"], 3)
        x3 = array(run["series"]["norm_x3"])  # begins from rounding: that sets no axis
        self.assertGreater(x3[x3 > 0].min(), 0.05 * r.series.norm_x2[r.series.norm_x2 > 0].min())
        self.assertAlmostEqual(x3[-1] / r.series.norm_x3[-1], 1, 6)
        drawn = [name for chart in data["charts"] for name in chart["series"]]
        self.assertEqual(sorted(drawn), sorted(set(r.series) - {"t"}))
        self.assertIn("three.js authors", page)
        self.assertNotRegex(page, r'(src|href)="')

    def test_space_size(self):
        """Whatever is stored, the page is below 4 MB, of one run and of six."""
        r = tendril.run(growth_type="feed", growth_initial_length=1, rod_curvature=0.6, clamp_spin="60deg",
                        friction_radius=0.05, shape_type="straight", ts_max_time=3, output_interval=0.005)
        self.assertGreater(len(r.shapes.t), 500)
        long = dataclasses.replace(r, series=Table({name: np.interp(np.linspace(0, 1, 30000), np.linspace(0, 1, len(values)),
                                                                    values) for name, values in r.series.items()}))
        for runs in ([r], [r] * 6, [long], [long] * 6):
            page = self.page(runs)
            self.assertLess(len(page.encode()), 4e6)
            for run in content(page)["runs"]:  # series end where they end
                self.assertAlmostEqual(array(run["series"]["length"])[-1], r.series.length[-1], 5)

    def test_space_weight(self):
        """Up is against the weight, which is no friction: a rod that hangs at rest has none."""
        r = tendril.run(growth_initial_length=0.5, rod_weight="0,-0.3,0", shape_type="straight", rod_model="space",
                        friction_mu=0, rod_cells=40, ts_max_time=0.2, output_shapes=2)
        self.assertEqual(content(self.page(r))["up"], 2)
        shape = r.at(0)
        _, held = friction(r, shape, 10)
        n = -np.diff(np.column_stack([np.interp(np.linspace(0, 1, 11), shape.s, f) for f in shape.force.T]), axis=0)
        np.testing.assert_allclose(held, n / (shape.length / 10) - [0, -0.3, 0], atol=2e-3)

    def test_friction_where_touched(self):
        """Friction is drawn where the rod is touched, too: one that slides over the ground and along a rough floor has that
        of both, and no arrow of what presses."""
        floor = [tendril.plane((0, -0.05), (0, 1), friction=0.3)]
        r = tendril.run(growth_type="feed", growth_initial_length=1, rod_weight="0,-2", shape_type="straight", friction_mu=1,
                        contact_diameter=0.1, wall_file=floor, rod_cells=100, ts_max_time=1, output_shapes=2)
        shape = r.at(1)
        self.assertTrue(np.any(r.shapes.contact[shape.index], axis=1).mean() > 0.9)
        _, held = friction(r, shape, 20)
        np.testing.assert_allclose(held[5:-2], [[-1.6, 0]] * 13, atol=0.05)  # (the clamp is in the line of the floor)

    def body(self, path, mesh):
        """A ball at (1, 0, 0), of radius 1/2, as a file of its distance; with the triangles that it was made from."""
        axes = [np.linspace(-0.8, 0.8, 41) + middle for middle in (0, 0, 1)]
        x3, x2, x1 = np.meshgrid(*axes, indexing="ij")
        with h5py.File(path, "w") as file:
            file["distance"] = np.sqrt((x1 - 1)**2 + x2**2 + x3**2) - 0.5
            file["origin"], file["spacing"] = [0.2, -0.8, -0.8], 3 * [0.04]
            if mesh:
                ball = revolved((1, 0, 0), (0, 0, 1), 0.5 * np.sin(turn(-0.5, 0.5)), 0.5 * np.cos(turn(-0.5, 0.5)))
                file["mesh/points"], file["mesh/triangles"] = ball.vertices, ball.triangles

    def test_surfaces(self):
        """Walls of space are drawn where they are: each vertex lies on its surface."""
        r = dataclasses.replace(self.wire(), attributes=dict(self.wire().attributes))
        self.body(self.place / "ball.h5", True)
        self.body(self.place / "cut.h5", False)
        size = np.linalg.norm
        truths = {
            "plane 0 0 -1.5 0 0 2": lambda x: x[:, 2] + 1.5,
            "sphere 1 1 1 0.4 outside": lambda x: size(x - 1, axis=1) - 0.4,
            "cylinder 0 0 1 2 0 0 1.6 inside": lambda x: size(x[:, 1:] - [0, 1], axis=1) - 1.6,
            "cylinder 2 0 -1 0 0 1 0.3 2 outside": lambda x: np.maximum(np.abs(size(x[:, :2] - [2, 0], axis=1) - 0.3),
                                                                        np.abs(x[:, 2]) - 1),
            "cone 3 0 0 1 0 0 0.6 0.2 2 inside": lambda x: size(x[:, 1:], axis=1) - 0.6 + 0.2 * (x[:, 0] - 3),
            "torus 0 1 0 0 0 1 0.5 0.2 inside": lambda x: np.hypot(size(x[:, :2] - [0, 1], axis=1) - 0.5, x[:, 2]) - 0.2,
            "circle 1 -1.5 0.3 outside": lambda x: size(x[:, :2] - [1, -1.5], axis=1) - 0.3,
            "tube inside 0 0 0 0.3 2 0 0 0.3 5 0 0 0.3": lambda x: size(x[:, 1:], axis=1) - 0.3,
            f"body {self.place}/ball.h5 outside": lambda x: 0.02 * (size(x - [1, 0, 0], axis=1) - 0.5)}
        if importlib.util.find_spec("skimage"):
            truths[f"body {self.place}/cut.h5 outside"] = lambda x: 0.01 * (size(x - [1, 0, 0], axis=1) - 0.5)
        r.attributes["walls"] = "\n".join(f"{line} friction 0.3" for line in truths)
        data = content(self.page(r))
        surfaces = data["runs"][0]["surfaces"]
        self.assertEqual(len(surfaces), len(truths))
        for surface, (line, off) in zip(surfaces, truths.items()):
            x = array(surface["positions"]).reshape(-1, 3)
            self.assertLess(np.abs(off(x)).max(), 1e-5, line)
            index = np.frombuffer(base64.b64decode(surface["index"]), "<u4")
            self.assertLess(index.max(), len(x))
            self.assertGreater(np.ptp(x[index], axis=0).max(), 0.3)
        self.assertEqual(tendril.plot(r, "space").axes[0].name, "3d")
        r.attributes["walls"] = "body gone.h5 inside friction 0\nblob 1 2 3 friction 0"  # what cannot be drawn is left out
        self.assertEqual(content(self.page(r))["runs"][0]["surfaces"], [])

    def test_contact_in_space(self):
        """What presses on a rod in a tube is a field on it, and arrows that point away from the wall, in the page and
        along the rod on paper."""
        (self.place / "duct.txt").write_text("cylinder 0 0 0  1 0 0  0.3 inside friction 0.2\n")
        r = tendril.run(growth_type="feed", growth_initial_length=1, rod_curvature=0.3, rod_curvature_2=0.1, rod_cells=60,
                        contact_diameter=0.1, wall_file=self.place / "duct.txt", friction_mu=0.5, shape_type="straight",
                        ts_max_time=1, output_interval=0.25)
        force = np.linalg.norm(r.shapes.contact, axis=-1)
        self.assertGreater(force.max(), 0.1)
        run = content(self.page(r))["runs"][0]
        self.assertAlmostEqual(run["fields"]["contact"]["most"], force.max())
        self.assertEqual(len(run["surfaces"]), 1)
        places, pushes = (array(run["shapes"][name]).reshape(len(r.shapes.t), -1, 3)[-1] for name in ("touched", "contact"))
        pressed_on = np.linalg.norm(pushes, axis=1) > 0.01
        np.testing.assert_allclose(np.linalg.norm(places[pressed_on, 1:], axis=1), 0.3, atol=0.01)
        self.assertTrue(np.all(np.sum(places[pressed_on, 1:] * pushes[pressed_on, 1:], axis=1) < 0))
        line = tendril.plot(r, "pressure").axes[0].lines[-1]
        np.testing.assert_allclose(line.get_ydata(), force[-1])
        with self.assertRaisesRegex(tendril.ResultsError, "a rod in space"):
            tendril.plot(r, "touch")
        self.assertTrue(tendril.plot(r, "all").axes)

    def check_pictures(self, seen, lines):
        """The rod is where its camera has it, in the colours of its field; it turns with the finger and
        comes nearer with the wheel."""
        self.assertNotIn("error", seen)
        self.assertEqual((seen["ready"], seen["wide"], seen["lines"]), ("yes", 0, lines))
        r = self.wire()
        for name in ("first", "second", "third", "fourth"):
            for node in seen[name]:
                self.assertTrue(all(0 <= p < s for p, s in zip(node["place"], node["size"])), (name, node))
                self.assertLess(min(node["colour"]), 225, (name, node))  # the paper is white
        self.assertNotEqual([n["place"] for n in seen["first"]], [n["place"] for n in seen["second"]])
        self.assertGreater(np.abs(seen["turned"]).max(), 0.2)
        self.assertLess(seen["nearer"], 0.95)
        np.testing.assert_allclose(seen["above"], [0, 0, 1], atol=1e-3)
        self.assertTrue({"axial", "curvature", "twist", "twisting_moment"} <= set(seen["fields"]))
        self.assertAlmostEqual(max(seen["ticks"]), r.shapes.curvature.max(), 2)
        for node in seen["third"]:  # curvature: from grey over orange to dark red
            self.assertGreater(node["colour"][0], node["colour"][2] + 30)
        self.assertGreater(seen["ink"][0], 0.005)
        self.assertGreater(seen["ink"][1], 1.05 * seen["ink"][0])  # earlier shapes are there, too
        self.assertEqual(seen["now"].strip(), "t = 4")
        self.assertTrue({"turns", "moment at the clamp"} <= set(seen["charts"]))
        self.assertGreater(seen["played"], 0)

    @unittest.skipUnless(BROWSER, MISSING)
    def test_space_on_a_screen(self):
        seen = self.seen(self.page(self.wire()), "1400,900", SPACE, DRAWN)
        if seen.get("lines"):
            self.skipTest("this Chromium has no WebGL")
        self.check_pictures(seen, False)

    @unittest.skipUnless(BROWSER, MISSING)
    def test_plane_beside_space(self):
        """Of two runs one may lie in the plane: it has x3 = 0, and what presses on it is where it was."""
        (self.place / "wall.txt").write_text("plane 1.5 0 -1 0\n")
        flat = tendril.run(growth_type="feed", growth_initial_length=1, shape_amplitude=0.1, contact_diameter=0.1,
                           wall_file=self.place / "wall.txt", rod_cells=40, ts_max_time=1, output_interval=0.1)
        page = self.page([flat, self.wire()])
        end = f"""const seen = {{}}; window.onerror = (message) => {{ seen.error = message; }};
            try {{ const shape = bodyAt(data.runs[0], {float(flat.series.t[-1])}), nodes = data.runs[0].nodes;
              seen.places = Array.from(shape.touched); seen.forces = Array.from(shape.contact);
              seen.x3 = Array.from(shape.x).filter((v, i) => i % 3 === 2); seen.field = shape.fields.contact.length - nodes;
            }} catch (error) {{ seen.error = String(error); }}
            const pre = document.createElement("pre"); pre.id = "seen"; pre.textContent = JSON.stringify(seen);
            document.body.append(pre);"""
        seen = self.seen(page, "1280,900", end, ["--disable-3d-apis"])
        self.assertNotIn("error", seen)
        places, forces = pressed(flat, flat.stored(-1), len(seen["forces"]) // 3)
        self.assertGreater(np.abs(forces).max(), 0.1)
        np.testing.assert_allclose(np.reshape(seen["forces"], (-1, 3))[:, :2], forces, rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(np.reshape(seen["places"], (-1, 3))[:, :2], places, rtol=1e-5, atol=1e-5)
        self.assertEqual((np.abs(seen["x3"]).max(), seen["field"]), (0, 0))

    @unittest.skipUnless(BROWSER, MISSING)
    def test_space_on_a_phone_without_webgl(self):
        """Lines, by the same camera."""
        self.check_pictures(self.seen(self.page(self.wire()), "500,850", SPACE, ["--disable-3d-apis"]), True)


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
