"""Shared parts of the browser tests: a daemon for each test, producers, and a page that is watched for errors.

In: the environment variables `HOPES_BIN`, the daemon's program, and `HOPES_CHROMIUM`, the browser; without the latter
playwright's own browser is used. `run` sets them. Invariants: every process is stopped, also if a test fails. A test
fails if its page logs an error, throws, or requests anything from another host than its daemon. Must not know: what
tests check.
"""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.request
from pathlib import Path
from typing import Any, Callable, Protocol
from urllib.parse import urlsplit

import hopes_client as hopes
from playwright.sync_api import Browser, ConsoleMessage, Page, Playwright, TimeoutError, sync_playwright

from eyes import Eyes, Picture

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
HOPES_BIN = os.environ.get("HOPES_BIN", str(ROOT / "target/debug/hopes"))
CHROMIUM = os.environ.get("HOPES_CHROMIUM") or None
# The longest time for any wait, however busy the machine is.
PATIENCE = 20.0
# The superuser cannot use a sandbox.
FLAGS = ["--no-sandbox"]
WIDE = {"width": 1280, "height": 800}


class Ends(Protocol):
    """A test, or another object that cleans up."""

    def addCleanup(self, end: Any, *arguments: Any) -> None: ...  # noqa: N802, as tests have it


class HasPage(Protocol):
    """A server of a page."""

    @property
    def host(self) -> str: ...

    @property
    def url(self) -> str: ...


class Daemon:
    """A daemon with a page, in its own folder. It is stopped at the end of the test."""

    def __init__(self, test: Ends, *options: str) -> None:
        folder = tempfile.TemporaryDirectory()
        test.addCleanup(folder.cleanup)
        test.addCleanup(self.kill)
        self.unix = f"unix:{folder.name}/socket"
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.host = f"127.0.0.1:{free.getsockname()[1]}"
        self._log = Path(folder.name) / "log"
        self._options = options
        self.start()

    @property
    def url(self) -> str:
        return f"http://{self.host}/"

    def start(self) -> None:
        """Starts it, at its previous address if it has one, and waits until it answers."""
        command = [HOPES_BIN, "serve", "--view", self.host, "--listen", self.unix, *self._options]
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        until(self._answers, f"the daemon does not answer: {self._log.read_text()}")

    def _answers(self) -> bool:
        if self._process.poll() is not None:
            raise AssertionError(f"the daemon has ended: {self._log.read_text()}")
        try:
            return self.get("healthz").strip() == b"ok"
        except OSError:
            return False

    def get(self, path: str) -> bytes:
        with urllib.request.urlopen(self.url + path, timeout=PATIENCE) as answer:
            return bytes(answer.read())

    def stream(self, name: str = "scan") -> dict[str, Any]:
        """The daemon's data of a stream."""
        infos = [one["info"] for one in json.loads(self.get("api/streams"))["streams"]]
        return next(info for info in infos if info["name"] == name)

    def snapshot(self, view: str, name: str = "scan") -> dict[str, Any]:
        """The newest frame of a stream in a view, as the daemon sends it to other consumers."""
        told: dict[str, Any] = json.loads(self.get(f"api/streams/{name}/snapshot?format=json&{view}"))
        return told

    def counts(self, view: str) -> tuple[int, int]:
        """The numbers of edges and critical edges of a view."""
        told = self.snapshot(view)
        return len(told["edges"]["add"]), len(told["critical"]["set"])

    def most_persistent(self, name: str = "scan") -> hopes.Dot:
        """The most persistent cycle of a stream."""
        with hopes.connect(self.unix, timeout=PATIENCE) as daemon:
            frame = daemon.follow(name, dots=hopes.Dots.top(1), timeout=PATIENCE).next_frame()
            assert frame is not None and frame.dots is not None
            return frame.dots[0]

    def kill(self) -> None:
        """Kills it."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGKILL)
        self._process.wait()


class Producer:
    """A process that sends points to a daemon. It knows the newest committed frame."""

    def __init__(self, test: Ends, daemon: Daemon, **options: Any) -> None:
        command = [sys.executable, str(HERE / "producer.py"), daemon.unix]
        for name, value in options.items():
            command += [f"--{name}", str(value)]
        path = f"{ROOT / 'protocol/python'}"
        pipe = subprocess.PIPE
        env = {**os.environ, "PYTHONPATH": path}
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=env)
        #: When each frame was taken; frames are numbered from 1.
        self.times: list[float] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        test.addCleanup(self.stop)

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            assert int(line) == len(self.times) + 1, line
            self.times.append(time.monotonic())

    @property
    def newest(self) -> int:
        return len(self.times)

    def rate(self, since: int) -> float:
        """Frames in a second since a given frame."""
        return (self.newest - since) / (self.times[-1] - self.times[since - 1])

    def wait_for(self, frame: int) -> None:
        until(lambda: self.newest >= frame, f"the producer has not come to frame {frame}")

    def make(self, frames: int) -> int:
        """Lets a producer without a rate of its own make frames, and returns the number of the last."""
        assert self._process.stdin is not None
        self._process.stdin.write(frames * "\n")
        self._process.stdin.flush()
        wanted = self.newest + frames
        self.wait_for(wanted)
        return wanted

    def stop(self) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join(PATIENCE)
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()


def until(holds: Callable[[], bool], what: str, patience: float = PATIENCE) -> None:
    """Polls until a condition holds."""
    deadline = time.monotonic() + patience
    while not holds():
        if time.monotonic() > deadline:
            raise AssertionError(what)
        time.sleep(0.02)


def launch(playwright: Playwright, *flags: str) -> Browser:
    return playwright.chromium.launch(executable_path=CHROMIUM, args=[*FLAGS, *flags])


class BrowserTest(unittest.TestCase):
    """One browser for all tests of a class; a daemon and a page for each test."""

    browser: Browser
    eyes: Eyes
    #: What the browser is started with beside what all are.
    flags: tuple[str, ...] = ()
    #: What runs in a page before its own scripts.
    prelude = ""

    @classmethod
    def setUpClass(cls) -> None:
        playwright = sync_playwright().start()
        cls.addClassCleanup(playwright.stop)
        cls.browser = launch(playwright, *cls.flags)
        cls.addClassCleanup(cls.browser.close)
        cls.eyes = Eyes(cls.browser.new_page())

    def setUp(self) -> None:
        self.complaints: list[str] = []
        #: What the console may say all the same.
        self.tolerated = re.compile(r"(?!)")

    def open(self, daemon: HasPage, fragment: str = "", **options: Any) -> Page:
        """Opens a daemon's page, and watches it until the test's end."""
        options = {"viewport": WIDE, **options}
        context = self.browser.new_context(**options)
        self.addCleanup(context.close)
        context.add_init_script(self.prelude)
        page = context.new_page()
        page.set_default_timeout(1000 * PATIENCE)
        self.watch(page, daemon.host)
        page.goto(daemon.url + fragment)
        return page

    def watch(self, page: Page, host: str) -> None:
        """Records errors of the page."""

        def asks(url: str) -> None:
            place = urlsplit(url)
            if place.scheme != "data" and place.netloc != host:
                self.complaints.append(f"it asks another host: {url}")

        def says(message: ConsoleMessage) -> None:
            # Browsers warn of many things, such as WebGL without a graphics card. Only warnings of wrong calls count.
            is_wrong = message.type == "error" or (message.type == "warning" and "INVALID_" in message.text)
            if is_wrong and not self.tolerated.search(message.text):
                self.complaints.append(f"{message.type}: {message.text}")

        page.on("request", lambda request: asks(request.url))
        page.on("websocket", lambda socket: asks(socket.url))
        page.on("console", says)
        page.on("pageerror", lambda error: self.complaints.append(f"thrown: {error}"))
        page.on("crash", lambda _: self.complaints.append("the page has crashed"))

    def tearDown(self) -> None:
        self.assertEqual(self.complaints, [], "the page did what it must not do")

    def see(self, page: Page, element: str = "#plane") -> Picture:
        return self.eyes.look(page, self.eyes.glance(page, element))

    def see_still(self, page: Page, element: str = "#plane") -> Picture:
        """Takes a picture when nothing changes any more. Dots and tracks come after their frame, and small pictures
        later.
        """
        deadline = time.monotonic() + PATIENCE
        png = self.eyes.glance(page, element)
        while time.monotonic() < deadline:
            page.wait_for_timeout(100)
            before, png = png, self.eyes.glance(page, element)
            if png == before:
                return self.eyes.look(page, png)
        raise AssertionError(f"{element} does not come to rest")

    def state(self, page: Page) -> dict[str, Any]:
        """The state that the page reports."""
        state: dict[str, Any] = page.evaluate("hopes.state()")
        return state

    def wait_for(self, page: Page, condition: str, argument: Any = None) -> dict[str, Any]:
        """Waits until a condition on `state` (and optionally `argument`) holds. Returns that state."""
        body = f"(argument) => {{ const state = window.hopes?.state(); return state && ({condition}) ? state : null; }}"
        try:
            found: dict[str, Any] = page.wait_for_function(body, arg=argument, polling=50).json_value()
        except TimeoutError:
            raise AssertionError(f"not in time: {condition}, {argument}: {self.state(page)}") from None
        return found
