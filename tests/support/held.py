"""A run that cannot end by itself: it prints into a pipe of one page, which it is let empty a few lines
at a time. So it is where its steps have it when it is looked at or sent a signal, and not where a
fast or a slow machine happens to be."""

import contextlib
import fcntl
import os
import select
import shlex
import subprocess
import tempfile
import time
from pathlib import Path

MONITORS = ["-snes_view"]  # a page is some five steps
PAGE = 4096
HANG = 900  # seconds; no busy machine takes that long for one run
LOOK = 60  # seconds


def ended(command, **more):
    """(exit code, stdout, stderr) of a command; TimeoutExpired if it hangs. An mpiexec that goes on
    although all its ranks have ended (that of Open MPI 5 does now and then, when they end with an error) is
    ended, and said: it is no fault of theirs."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more) as process:
        gone = 0
        for _ in range(HANG // LOOK):
            try:
                out, err = process.communicate(timeout=LOOK)
                return process.returncode, out, err
            except subprocess.TimeoutExpired:
                gone = 0 if alive(process.pid) else gone + 1
            if gone == 2:
                print(f"{command}: its ranks have ended, mpiexec has not", flush=True)
                process.kill()
                return 1, *process.communicate()
        process.kill()
    raise subprocess.TimeoutExpired(command, HANG)


@contextlib.contextmanager
def small_disk(kilobytes):
    """A file system of this size; None where one may not be made."""
    with tempfile.TemporaryDirectory(prefix="tendril-") as place:
        made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", place],
                              capture_output=True).returncode == 0
        try:
            yield Path(place) if made else None
        finally:
            if made:
                subprocess.run(["umount", "-l", place], check=False)


def alive(parent):
    """Whether a process has children that run; one that has none and is no mpiexec counts as its own."""
    states = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, owner = stat.read_text().rpartition(")")[2].split()[:2]
        except OSError:  # it has just ended
            continue
        if int(owner) == parent:
            states.append(state)
    return not states or any(state != "Z" for state in states)


class Held:
    """with Held(command, **of Popen) as run: run.let(); run.send_signal(...); run.end()"""

    def __init__(self, command, launch=(), **more):
        self.place = tempfile.TemporaryDirectory(prefix="tendril-")
        place = shlex.quote(self.place.name)
        os.mkfifo(Path(self.place.name) / "printed")
        self.pipe = os.open(Path(self.place.name) / "printed", os.O_RDONLY | os.O_NONBLOCK)
        fcntl.fcntl(self.pipe, fcntl.F_SETPIPE_SZ, PAGE)
        # the ranks' own output, which mpiexec would take in without end
        self.process = subprocess.Popen(
            [*launch, "sh", "-c", f"echo $$ >>{place}/ranks; exec \"$@\" >{place}/printed", "sh",
             *map(str, command), *MONITORS], stderr=subprocess.PIPE, text=True, **more)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()
        os.close(self.pipe)
        self.place.cleanup()

    def let(self, size=PAGE):
        """Lets it print so many bytes more (those of a page are let go together); False if it has ended."""
        end = time.monotonic() + HANG
        while size > 0 and time.monotonic() < end:
            if not select.select([self.pipe], [], [], 0.05)[0]:
                if self.process.poll() is not None:
                    return False
                continue
            try:
                got = os.read(self.pipe, min(size, PAGE))
            except BlockingIOError:
                continue
            if not got:  # nobody prints: not yet, or no more
                if self.process.poll() is not None:
                    return False
                time.sleep(0.01)
            size -= len(got)
        return size <= 0

    def until(self, seen, pages=1):
        """Lets it go on by so many pages at a time until seen(). That may need time to pass (a file
        is stored once a second at most), so it is held in between, ever longer. False if it ended
        before."""
        held = 1.1
        while not seen():
            if not self.let(pages * PAGE):
                return False
            time.sleep(0.1)
            if not seen():
                time.sleep(held)
                held = min(2 * held, 8)
        return True

    def send_signal(self, number):
        """Sends it to all ranks while they are held: they have not ended, whatever the machine. (Not
        to mpiexec, which leaves them a second to end and then kills them.)"""
        assert self.process.poll() is None, "ended before it could be stopped"
        for rank in (Path(self.place.name) / "ranks").read_text().split():
            os.kill(int(rank), number)

    def end(self):
        """Lets it go on to its end; (exit code, what it said on stderr)."""
        while self.let():
            pass
        said = self.process.communicate(timeout=HANG)[1]
        return self.process.returncode, said
