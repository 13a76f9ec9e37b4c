#!/usr/bin/env python3
"""The film of README: a live run in Chromium, in which a stone is dragged into the rod's way, as docs/figures/live.gif.

    TENDRIL=build/tendril .venv/bin/python scripts/lab/live_film.py"""

import base64
import io
import json
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "scripts")]
import chromium
import tendril

PAGE = "document.getElementById('live').tendril"
WIDE, HIGH, SHOWN = 1180, 640, 720  # of the page; of the film
SCENE = dict(growth_type="feed", growth_initial_length=1, contact_diameter=0.12, shape_amplitude=0.05, rod_cells=120, ts_max_time=9,
             wall_file=["circle 1.9 -1.05 0.5 outside friction 0.1", "circle 3.4 1.0 0.5 outside friction 0.1"])
ENDS = 8.4


def main():
    frames = []
    with tempfile.TemporaryDirectory() as results, tendril.live(results=results, **SCENE) as live, chromium.Chromium((WIDE, HIGH)) as browser:
        browser.go(live.address)
        browser.until(f"{PAGE} && {PAGE}.S.frame && {PAGE}.stage.now")

        def shot():
            data = base64.b64decode(browser.call("Page.captureScreenshot", format="png")["data"])
            frames.append(Image.open(io.BytesIO(data)).convert("RGB").resize((SHOWN, SHOWN * HIGH // WIDE), Image.LANCZOS))

        def mouse(kind, x, y):
            browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=0 if kind == "mouseReleased" else 1, clickCount=1)

        browser.say(f"{PAGE}.send('pace', {{pace: 0.9}})")
        browser.press(" ", "Space")
        browser.until(f"{PAGE}.S.t > 0.3")
        grip, way = None, 0.0
        while not browser.say(f"!!{PAGE}.S.ended || {PAGE}.S.t > {ENDS}"):
            t = browser.say(f"{PAGE}.S.t")
            if 0.6 < t and way < 1:
                if grip is None:
                    grip = json.loads(browser.say(f"""(() => {{ const {{stage}} = {PAGE}, box = document.querySelector('.l-stage canvas').getBoundingClientRect();
                      const [x, y] = stage.place(1.9, -1.05, 0); return JSON.stringify([x + box.left, y + box.top, stage.scale]); }})()"""))
                    mouse("mousePressed", *grip[:2])
                way = min(1.0, way + 0.1)
                mouse("mouseMoved", grip[0], grip[1] - 0.55 * way * grip[2])
                if way == 1:
                    mouse("mouseReleased", grip[0], grip[1] - 0.55 * grip[2])
            shot()
    step = max(1, len(frames) // 48)
    chosen = frames[::step] + [frames[-1]] * 6
    palette = chosen[len(chosen) // 2].quantize(64)
    chosen = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in chosen]
    to = ROOT / "docs/figures/live.gif"
    chosen[0].save(to, save_all=True, append_images=chosen[1:], duration=110, loop=0, optimize=True)
    print(f"live_film: {to}, {len(chosen)} frames, {to.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
