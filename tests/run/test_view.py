#!/usr/bin/env python3
"""The page of scripts/view.sh: what is in it, and, where Chromium is installed, what it does there.

    test_view.py build/tendril"""

import base64
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from interpreter import ROOT, from_venv

sys.path.insert(0, str(ROOT / "scripts"))
try:
    import numpy as np

    import tendril
except ImportError as error:
    from_venv(error)

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
QUIET = """--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-sync
    --disable-background-networking --disable-component-update --hide-scrollbars""".split()
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
    seen.milliseconds = performance.now();
    seen.charts = titles();
    seen.wide = document.documentElement.scrollWidth - innerWidth;
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
      seen.lines = charts.map((u) => u.series.length - 1);
    }
    element("slider").value = 0;
    press(element("play"));
    for (let k = 0; k < 20 && !seen.played; k++) { // a busy machine takes its time
      await new Promise((done) => setTimeout(done, 200));
      seen.played = Number(element("slider").value);
    }
  } catch (error) { seen.error = String(error); }
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

    def test_a_motion_that_happened(self):
        """Between two stored shapes the rod is drawn in a straight motion only where that is what it did; of
        a run of which the first and the last are stored it is not."""
        rod = dict(growth_type="feed", growth_initial_length=2, shape_amplitude=0.1, rod_cells=60, ts_max_time=8)
        fair = [array(content(self.page(tendril.run(rod, output_shapes=n)))["runs"][0]["shapes"]["fair"])
                for n in (1, 80)]
        self.assertEqual((len(fair[0]), fair[0].sum()), (1, 0))
        self.assertEqual((len(fair[1]), fair[1].sum()), (80, 80))

    def test_size(self):
        r = tendril.run("feed", output_interval=0.04)
        self.assertGreaterEqual(len(r.shapes.t), 200)
        self.assertLess(len(self.page(r).encode()), LARGEST)

    def seen(self, page, size):
        """What the page shows after all has been tried, at this size of the window."""
        file = self.place / "tried.html"
        file.write_text(page.replace("</body>", f"<script>{ACTIONS}</script></body>"), encoding="utf-8")
        with tempfile.TemporaryDirectory(prefix="tendril-") as profile:
            done = subprocess.run([BROWSER, *QUIET, f"--user-data-dir={profile}", f"--window-size={size}",
                                   "--virtual-time-budget=8000", "--dump-dom", file.as_uri()],
                                  capture_output=True, text=True, timeout=120)
        found = re.search(r'(?s)<pre id="seen">(.*?)</pre>', done.stdout)
        self.assertTrue(found, done.stdout[-500:] + done.stderr[-2000:])
        return json.loads(html.unescape(found[1]))

    @unittest.skipUnless(BROWSER, "no Chromium here")
    def test_one_run_on_a_screen(self):
        r = self.runs[0]
        seen = self.seen(self.page(r), "1280,900")
        self.assertNotIn("error", seen)
        self.assertEqual((seen["ready"], seen["moved"], seen["wide"]), ("yes", True, 0))
        self.assertAlmostEqual(seen["opened"], r.series.t[-1], 4)  # on what has come of it
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
        self.assertRegex(lab["summary"], r"length \(cm\)\s+21\b")
        x0, x1, y0, y1 = seen["limits"]  # both axes in one scale, around the present rod
        self.assertAlmostEqual((x1 - x0) / (y1 - y0), seen["box"][0] / seen["box"][1], 3)
        shape = r.at(middle).x * 100 * r.scale("length")
        self.assertTrue(x0 < shape[:, 0].min() and shape[:, 0].max() < x1)
        self.assertTrue(y0 < shape[:, 1].min() and shape[:, 1].max() < y1)
        self.assertGreater(seen["played"], 0)

    @unittest.skipUnless(BROWSER, "no Chromium here")
    def test_two_runs_on_a_phone(self):
        """Both in every chart, or the one that is not ticked off; nothing is wider than the screen."""
        seen = self.seen(self.page(self.runs), "500,850")
        self.assertNotIn("error", seen)
        self.assertEqual(seen["wide"], 0)
        np.testing.assert_allclose(seen["lab"]["cursors"], 20, rtol=0.01)
        charts = content(self.page(self.runs))["charts"]
        self.assertEqual(seen["lines"][0], len(charts[0]["series"]))


if __name__ == "__main__":
    os.environ["TENDRIL"] = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
