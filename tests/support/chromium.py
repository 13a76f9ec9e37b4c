"""A page in Chromium without a screen, by its own protocol; where there is none, tests are left out with a word."""

import base64
import contextlib
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request

FOUND = os.environ.get("TENDRIL_CHROMIUM") or next(
    (found for name in ("chromium", "chromium-browser", "google-chrome", "chromium-headless-shell") if (found := shutil.which(name))), None)
MISSING = "NOT TRIED, for there is no browser here: apt-get install chromium-headless-shell"


class Chromium:
    """One browser with one page. at: its width and height; touch: a phone's."""

    def __init__(self, at=(1400, 900), touch=False):
        from websockets.sync.client import connect

        self.home = tempfile.TemporaryDirectory(prefix="tendril-chromium-", ignore_cleanup_errors=True)
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--remote-debugging-port=0", "--no-first-run",
                 "--disable-extensions", "--disable-background-networking", f"--user-data-dir={self.home.name}", "about:blank"]
        self.process = subprocess.Popen([FOUND, *flags], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        port = next(int(found[1]) for line in self.process.stderr if (found := re.search(r"DevTools listening on ws://[^:]+:(\d+)/", line)))
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
            pages = json.load(answer)
        self.open = contextlib.ExitStack()
        self.socket = self.open.enter_context(connect(next(p["webSocketDebuggerUrl"] for p in pages if p["type"] == "page"), max_size=None))
        self.number, self.complaints = 0, []
        self.call("Page.enable")
        self.call("Runtime.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=at[0], height=at[1], deviceScaleFactor=2 if touch else 1, mobile=touch)
        if touch:
            self.call("Emulation.setTouchEmulationEnabled", enabled=True)
        self.touch = touch

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self.socket.recv(timeout=60))
            if answer.get("method") == "Runtime.exceptionThrown":
                self.complaints.append(answer["params"]["exceptionDetails"].get("exception", {}).get("description", "?"))
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def go(self, address):
        self.call("Page.navigate", url=address)

    def say(self, script):
        """The value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", script))
        return answer["result"].get("value")

    def until(self, script, seconds=60):
        """Waits for an expression to be true; its value."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                if value := self.say(script):
                    return value
            except RuntimeError:
                pass  # the page is not there yet
            time.sleep(0.05)
        raise AssertionError(f"in {seconds} s it has not become true: {script}; {self.complaints}")

    def drawn(self):
        """Waits for the page's next frame: what was to be drawn in it is there, however late a busy machine draws."""
        self.say("new Promise((go) => requestAnimationFrame(go))")

    def press(self, key, code=None):
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=code or key, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code or key)

    def drag(self, start, end, steps=6, wait=0.05):
        """By the mouse, or a finger."""
        def event(kind, x, y):
            if self.touch:
                points = [] if kind == "up" else [{"x": x, "y": y}]
                self.call("Input.dispatchTouchEvent", type={"down": "touchStart", "move": "touchMove", "up": "touchEnd"}[kind], touchPoints=points)
            else:
                self.call("Input.dispatchMouseEvent", type={"down": "mousePressed", "move": "mouseMoved", "up": "mouseReleased"}[kind], x=x, y=y,
                          button="left", buttons=0 if kind == "up" else 1, clickCount=1)

        event("down", *start)
        for k in range(1, steps + 1):
            event("move", *(a + (b - a) * k / steps for a, b in zip(start, end)))
            time.sleep(wait)
        event("up", *end)

    def picture(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def close(self):
        self.open.close()
        self.process.terminate()
        self.process.wait(20)
        self.process.stderr.close()
        self.home.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self.close()
