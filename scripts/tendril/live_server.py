"""Runs a scene that one can touch, in a browser: run, pause, step, change what may be changed, drag stones and the tip, go
back, branch, and save what was done as a scene.

    tendril-py live                      a page to begin from: the gallery, and a form for one's first scene
    tendril-py live feed                 a scene of the gallery
    tendril-py live mine.opts --posts 3  one's own, with three posts to put somewhere

Its first line is the address, which holds a token: who has it may run scenes here. Results go to results/live, or where --results
says. Ctrl-C ends it, and leaves there what the run has found."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import secrets
import shutil
import signal
import tempfile
import threading
import time
import webbrowser
from http import HTTPStatus
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from .command import Parser
from .dropped import Parts
from .errors import TendrilError
from .outbox import Outbox
from .playing import prepare, save_scene
from .sessions import Session
from .starting_page import begin, first_scene, gallery, picture_file

WEB = Path(__file__).resolve().parent / "web"
LARGEST = 400_000  # bytes of a message: a wall file that is dropped on the page
MOST_COMMANDS = 1000  # that wait for the end of a step
FRAMES_A_SECOND = 60
SCRIPTS = ("uplot/uPlot.iife.min.js", "format.js", "drawing.js", "live-draw.js", "live.js", "study.js")  # of a page, each on those before
KINDS = {".h5": "application/x-hdf5", ".png": "image/png", ".gif": "image/gif", ".html": "text/html; charset=utf-8", ".opts": "text/plain; charset=utf-8",
         ".txt": "text/plain; charset=utf-8"}


def websockets():
    """The library, or what to do without it."""
    try:
        import websockets.asyncio.server as server
        from websockets.datastructures import Headers
        from websockets.http11 import Response
    except ImportError:
        raise TendrilError("live: needs the library websockets, 13 or newer: pip install 'tendril[live]', or pip install websockets") from None
    return server, Headers, Response


class Server:
    """A run, and the pages that look at it. One run at a time; pages may come and go."""

    def __init__(self, results="results/live", port=0, host="127.0.0.1", posts=0, study=None):
        self.results, self.host, self.port, self.posts = Path(results), host, port, posts
        self.study = study  # a sweep or fit that is shown, and no run
        self.token = secrets.token_urlsafe(24)
        self.session: Session | None = None
        self.pages: dict = {}
        self.directory = tempfile.TemporaryDirectory(prefix="tendril-live-")
        self.loop = None
        self.runs, self.starting = 0, threading.Lock()
        self.codes: set[str] = set()  # that open the page once
        self.dropped: dict[str, Path] = {}  # files of walls that were dropped on the page, by the names they have there

    @property
    def address(self):
        return f"http://{self.host}:{self.port}/?token={self.token}"

    def opening(self):
        """An address that is good for one look, and leads to the other: what a program is started with others on this machine can
        read."""
        code = secrets.token_urlsafe(24)
        self.codes.add(code)
        return f"http://{self.host}:{self.port}/?once={code}"

    # ---- the run ----

    def start(self, scene=None, posts=None, **options):
        """Begins a run in the place of the present one; what is wrong with it is raised, and leaves that."""
        with self.starting:
            self.start_alone(scene, options, posts)

    def start_alone(self, scene, options, posts):
        directory = Path(self.directory.name) / f"run-{self.runs}"
        directory.mkdir()
        self.runs += 1
        played = prepare(scene, options, directory, self.posts if posts is None else posts)
        session = Session(played, directory, self.publish, self.results, leaves=True)
        before, self.session = self.session, session.begin()
        if before:
            threading.Thread(target=self.clear, args=(before,), daemon=True, name="tendril live ends").start()
        for page in self.pages.values():
            page.greet()

    @staticmethod
    def clear(session):
        """Ends a run that another one has taken the place of, and forgets its states."""
        session.close(600)
        shutil.rmtree(session.directory, ignore_errors=True)

    def publish(self, message):
        """From the run's thread to all pages, or to one."""
        if self.loop and not self.loop.is_closed():
            with contextlib.suppress(RuntimeError):  # it is closing
                self.loop.call_soon_threadsafe(self.hand_out, message)

    def hand_out(self, message):
        for page in list(self.pages.values()):
            if message.get("to") in (None, page.number):
                page.take(message)

    # ---- who may ----

    def may(self, path, headers):
        """None, or why a request is refused."""
        try:
            return self.judge(path, headers)
        except (ValueError, LookupError):  # an address that is none, a header twice
            return "not as a browser asks"

    def judge(self, path, headers):
        query = parse_qs(urlsplit(path).query)
        host = headers.get("Host", "").rsplit(":", 1)[0]
        if host not in (self.host, "localhost", "127.0.0.1", "[::1]"):
            return "of another host"
        origin = headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != headers.get("Host", ""):
            return "from another page"
        if urlsplit(path).path == "/" and (code := (query.get("once") or [""])[0]) in self.codes:
            return None
        if not hmac.compare_digest((query.get("token") or [""])[0].encode(errors="replace"), self.token.encode()):
            return "without the token that is in the address"
        return None

    def answer(self, path, headers):
        """(status, content type, bytes) of what a browser asks for by its address."""
        why = self.may(path, headers)
        if why:
            return HTTPStatus.FORBIDDEN, "text/plain; charset=utf-8", f"refused: {why}\n".encode()
        code = (parse_qs(urlsplit(path).query).get("once") or [""])[0]
        if code in self.codes:
            self.codes.discard(code)
            return HTTPStatus.OK, "text/html; charset=utf-8", f'<meta http-equiv="refresh" content="0; url=/?token={self.token}">'.encode()
        parts = urlsplit(path).path.split("/")[1:]
        if parts == [""]:
            return HTTPStatus.OK, "text/html; charset=utf-8", page_text(self.token).encode()
        if len(parts) == 2 and parts[0] == "picture" and (file := picture_file(parts[1])):
            return HTTPStatus.OK, "image/png", file.read_bytes()
        if len(parts) == 2 and parts[0] == "file" and self.session and (file := self.session.written.get(parts[1])) and file.is_file():
            return HTTPStatus.OK, KINDS.get(file.suffix, "application/octet-stream"), file.read_bytes()
        return HTTPStatus.NOT_FOUND, "text/plain; charset=utf-8", b"there is nothing of that name\n"

    # ---- serving ----

    async def serve(self, ready=None, stop=None):
        server, Headers, Response = websockets()
        self.loop = asyncio.get_running_loop()

        async def process(connection, request):
            if request.headers.get("Upgrade", "").lower() == "websocket":
                why = self.may(request.path, request.headers)
                return connection.respond(HTTPStatus.FORBIDDEN, f"refused: {why}\n") if why else None
            status, kind, body = self.answer(request.path, request.headers)
            about = Headers({"Content-Type": kind, "Content-Length": str(len(body)), "Cache-Control": "no-store", "Referrer-Policy": "no-referrer",
                             "X-Content-Type-Options": "nosniff", "Connection": "close",
                             "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                                                        "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"})
            return Response(int(status), status.phrase, about, body)

        stop = stop or asyncio.Event()
        try:
            async with server.serve(self.meet, self.host, self.port, process_request=process, max_size=LARGEST, max_queue=64,
                                    compression=None) as listening:
                self.port = listening.sockets[0].getsockname()[1]
                beat = asyncio.ensure_future(self.beat())
                if ready:
                    ready(self)
                await stop.wait()
                beat.cancel()
        except OSError as fault:
            raise TendrilError(f"port {self.port}: {fault.strerror or fault}; give another with --port, or none") from None

    async def beat(self):
        """Says that a step is still under way, where it takes long."""
        while True:
            await asyncio.sleep(0.5)
            session = self.session
            since = session.busy_since if session else None
            if since and time.monotonic() - since > 0.7:
                self.hand_out({"kind": "busy", "seconds": round(time.monotonic() - since, 1), "to": None})

    async def meet(self, socket):
        writer = None
        page = OnePage(self, socket, self.runs * 1000 + len(self.pages) + secrets.randbelow(10 ** 9))
        self.pages[page.number] = page
        try:
            page.greet()
            writer = asyncio.ensure_future(page.write())
            async for message in socket:
                page.hear(message)
        except Exception as fault:  # the page is gone, or sent what no page sends: the run goes on
            page.fault = fault
        finally:
            self.pages.pop(page.number, None)
            if writer:
                writer.cancel()

    def close(self):
        """Ends the run behind its step; the file in which it is kept, or None."""
        session, self.session = self.session, None
        kept = None
        if session:
            session.running = False
            session.close()
            if session.branch.rows and session.branch.rows[-1][0] > 0:
                session.save("result")
                kept = session.written.get(f"{session.played.name}-played.h5")
                if changes := session.table():
                    save_scene(session.played, changes, session.results, f"{session.played.name}-played", "as it was left")
        with contextlib.suppress(OSError):
            self.directory.cleanup()
        return kept


class OnePage:
    """A page that looks."""

    def __init__(self, server, socket, number):
        self.server, self.socket, self.number = server, socket, number
        self.outbox, self.wake = Outbox(), asyncio.Event()
        self.fault, self.parts = None, Parts()

    def greet(self):
        """All there is, for a page that has just come, or for another run."""
        session = self.server.session
        if self.server.study is not None:
            for message in self.server.study.whole():
                self.take(message)
        elif session is None:
            self.take({"kind": "start", "gallery": gallery(), "form": first_scene()})
        else:
            self.take(session.scene())
            self.take(session.whole())

    def take(self, message):
        self.outbox.put(message)
        self.wake.set()

    async def write(self):
        while True:
            await self.wake.wait()
            self.wake.clear()
            for message in self.outbox.take():
                await self.socket.send(json.dumps(message))
                if message["kind"] == "frame":
                    await asyncio.sleep(1 / FRAMES_A_SECOND)

    def hear(self, message):
        """What a page asks for. What makes no sense is answered, and does nothing."""
        try:
            command = json.loads(message)
            if not isinstance(command, dict) or not isinstance(command.get("do"), str):
                raise ValueError("no command")
        except (ValueError, RecursionError):
            self.take({"kind": "refused", "text": "this is no command", "command": {}})
            return
        command["from"] = self.number
        if self.server.study is not None:
            self.take({"kind": "refused", "text": "it is only looked at", "command": {}})
            return
        if command["do"] in ("start", "draw", "home", "file"):
            asyncio.ensure_future(self.begin(command))
        elif self.server.session is None:
            self.take({"kind": "refused", "text": "nothing runs yet", "command": command})
        elif self.server.session.commands.qsize() >= MOST_COMMANDS:
            self.take({"kind": "refused", "text": "too much is asked for at once; wait for the end of the step", "command": command})
        else:
            self.server.session.do(command)

    async def begin(self, command):
        try:
            if command["do"] == "file":
                command["whole"] = self.parts.take(command)
                if command["whole"] is None:
                    return
            answer = await asyncio.get_running_loop().run_in_executor(None, begin, self.server, command)
            if answer:
                self.take(answer)
        except (TendrilError, OSError, ValueError, TypeError, KeyError) as fault:
            self.take({"kind": "refused", "text": str(fault), "command": {"do": command["do"]},
                       "field": "file" if command["do"] == "file" else getattr(fault, "field", None)})


def page_text(token):
    """The page, one text: its scripts and styles are in it."""
    def text(*names):
        return "".join((WEB / name).read_text(encoding="utf-8") for name in names)

    parts = {"style": text("uplot/uPlot.min.css", "page.css", "live.css"), "uplot": text(SCRIPTS[0]), "licence": text("uplot/LICENSE"), "script": text(*SCRIPTS[1:]), "token": json.dumps(token)}
    page = (WEB / "live.html").read_text(encoding="utf-8")
    for name, part in parts.items():
        page = page.replace(f"@{name}@", part)
    return page


class Live:
    """A server in a thread of its own, as Python and notebooks have it. close() ends it."""

    def __init__(self, scene=None, *, port=0, results="results/live", posts=0, study=None, **options):
        websockets()
        self.server = Server(results, port, posts=posts, study=study)
        if scene is not None or options:
            self.server.start(scene, **options)
        self.stop, self.ready, self.fault = None, threading.Event(), None
        self.thread = threading.Thread(target=self.run, daemon=True, name="tendril live server")
        self.thread.start()
        self.ready.wait(20)
        if self.fault:
            raise self.fault

    def run(self):
        async def main():
            self.stop = asyncio.Event()
            await self.server.serve(lambda _: self.ready.set(), self.stop)

        try:
            asyncio.run(main())
        except TendrilError as fault:
            self.fault = fault
        self.ready.set()

    @property
    def address(self):
        return self.server.address

    @property
    def session(self):
        return self.server.session

    def close(self):
        """Ends the run; the file that has what it found, or None."""
        loop = self.server.loop
        if loop and not loop.is_closed() and self.stop:
            loop.call_soon_threadsafe(self.stop.set)
        self.thread.join(10)
        return self.server.close()

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self.close()

    def __call__(self, message):
        """A message of a sweep or fit that is shown."""
        self.server.study.take(message)
        self.server.publish(message)

    def _repr_html_(self):
        if self.server.study is not None:
            return f'<a href="{self.address}" target="_blank">sweeps and fits, seen while they go on</a>'
        return f'<a href="{self.address}" target="_blank">a run one can touch</a>; in the notebook itself: tendril.widget()'

    def __repr__(self):
        return f"<a run one can touch: {self.address.split('?')[0]}>"


def live(scene=None, *, port=0, results="results/live", posts=0, **options) -> Live:
    """Runs a scene that one can touch in a browser at .address (in a notebook: widget()). Scene and options are as for
    run().

    posts  so many more stones, to be put somewhere"""
    return Live(scene, port=port, results=results, posts=posts, **options)


def main(arguments=None):
    parser = Parser("scripts/live.sh", __doc__)
    parser.add_argument("scene", nargs="?", help="an options file, or the name of a scene; without: a page to begin from")
    parser.add_argument("--port", type=int, default=0, help="of the address; default: a free one")
    parser.add_argument("--no-browser", action="store_true", help="opens none")
    parser.add_argument("--results", default="results/live", metavar="DIRECTORY", help="where results are written; default: results/live")
    parser.add_argument("--posts", type=int, default=0, metavar="N", help="posts that can be put somewhere in the run")
    choice = parser.parse_args(arguments)
    if not 0 <= choice.port < 65536:
        raise TendrilError(f"--port {choice.port}: give 0 to 65535")
    if not 0 <= choice.posts <= 20:
        raise TendrilError(f"--posts {choice.posts}: give 0 to 20")
    websockets()
    server = Server(choice.results, choice.port, posts=choice.posts)
    if choice.scene:
        server.start(choice.scene)

    def ready(server):
        print(server.address, flush=True)
        print("live: open this in a browser; Ctrl-C ends it", flush=True)
        if not choice.no_browser:
            threading.Thread(target=webbrowser.open, args=(server.opening(),), daemon=True).start()

    async def run():
        stop = asyncio.Event()
        for one in (signal.SIGINT, signal.SIGTERM):
            with contextlib.suppress(NotImplementedError):
                asyncio.get_running_loop().add_signal_handler(one, stop.set)
        await server.serve(ready, stop)

    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(run())
    kept = server.close()
    print(f"live: {kept} holds the run; go on with -restart" if kept else "live: ended", flush=True)
    return 0
