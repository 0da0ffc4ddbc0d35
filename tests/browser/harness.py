"""Fixtures of the browser's tests: a daemon, producers, and a page whose errors fail the test.

In: the environment variables `HOPES_BIN`, the path of the program, and `HOPES_CHROMIUM`, the path of the browser.
Without the latter the browser is playwright's own. `run` sets both.
Out: running processes, pages, screenshots, the state of a page.
Invariants: every process is stopped, also if a test fails. A page that logs an error, throws, or requests anything from
another host than its daemon fails the test that opened it.
Must not know: what tests check.
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

from pictures import Picture, PictureReader

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
HOPES_BIN = os.environ.get("HOPES_BIN", str(ROOT / "target/debug/hopes"))
CHROMIUM = os.environ.get("HOPES_CHROMIUM") or None
# Seconds that a test waits for anything at the most, on a busy machine.
TIMEOUT = 20.0
# Chromium has no sandbox for root.
FLAGS = ["--no-sandbox"]
WIDE = {"width": 1280, "height": 800}
# An emulated graphics card, under another name, so that the page does not recognize the emulation.
CARD_FLAGS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
CARD_PRELUDE = """
    const ask = WebGL2RenderingContext.prototype.getParameter;
    WebGL2RenderingContext.prototype.getParameter = function (name) {
      return name === 0x9246 ? "a graphics card" : ask.call(this, name);
    };
"""


class HasCleanup(Protocol):
    """A test, or anything else that runs cleanups at its end."""

    def addCleanup(self, end: Any, *arguments: Any) -> None: ...  # noqa: N802, as tests have it


class HasPage(Protocol):
    """Anything that serves a page."""

    @property
    def host(self) -> str: ...

    @property
    def url(self) -> str: ...


class Daemon:
    """A daemon with a page, in a temporary folder, stopped with the test."""

    def __init__(self, test: HasCleanup, *options: str) -> None:
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
        """Starts it at the same address as before, and waits until it answers."""
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
        with urllib.request.urlopen(self.url + path, timeout=TIMEOUT) as answer:
            return bytes(answer.read())

    def stream(self, name: str = "scan") -> dict[str, Any]:
        """The status of a stream."""
        infos = [one["info"] for one in json.loads(self.get("api/streams"))["streams"]]
        return next(info for info in infos if info["name"] == name)

    def snapshot(self, view: str, name: str = "scan") -> dict[str, Any]:
        """The newest frame of a stream in a view."""
        snapshot: dict[str, Any] = json.loads(self.get(f"api/streams/{name}/snapshot?format=json&{view}"))
        return snapshot

    def counts(self, view: str) -> tuple[int, int]:
        """The numbers of edges and critical edges of a view."""
        snapshot = self.snapshot(view)
        return len(snapshot["edges"]["add"]), len(snapshot["critical"]["set"])

    def most_persistent(self, name: str = "scan") -> hopes.Dot:
        """The most persistent cycle of a stream."""
        with hopes.connect(self.unix, timeout=TIMEOUT) as daemon:
            frame = daemon.follow(name, dots=hopes.Dots.top(1), timeout=TIMEOUT).next_frame()
            assert frame is not None and frame.dots is not None
            return frame.dots[0]

    def kill(self) -> None:
        """Kills it, without a goodbye to its clients."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGKILL)
        self._process.wait()


class Producer:
    """A process that produces a stream, and the frames of it that the daemon has committed."""

    def __init__(self, test: HasCleanup, daemon: Daemon, **options: Any) -> None:
        command = [sys.executable, str(HERE / "producer.py"), daemon.unix]
        for name, value in options.items():
            command += [f"--{name}", str(value)]
        path = f"{ROOT / 'protocol/python'}"
        pipe = subprocess.PIPE
        env = {**os.environ, "PYTHONPATH": path}
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=env)
        #: When each frame was committed; frames are numbered from 1.
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
        """Frames per second since a frame."""
        return (self.newest - since) / (self.times[-1] - self.times[since - 1])

    def wait_for(self, frame: int) -> None:
        until(lambda: self.newest >= frame, f"the producer has not reached frame {frame}")

    def make(self, frames: int) -> int:
        """Makes so many frames with a producer of rate 0. Returns the number of the last one."""
        assert self._process.stdin is not None
        wanted = self.newest + frames
        self._process.stdin.write(frames * "\n")
        self._process.stdin.flush()
        self.wait_for(wanted)
        return wanted

    def stop(self) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join(TIMEOUT)
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()


def until(holds: Callable[[], bool], what: str, timeout: float = TIMEOUT) -> None:
    """Polls until a condition holds."""
    deadline = time.monotonic() + timeout
    while not holds():
        if time.monotonic() > deadline:
            raise AssertionError(what)
        time.sleep(0.02)


def position_in(page: Page, vertices: list[tuple[float, float]], point: tuple[float, float]) -> dict[str, float]:
    """The position in the canvas of a point of the plane, as long as the camera fits all points."""
    box = page.locator("#plane").bounding_box()
    assert box is not None
    low = [min(vertex[axis] for vertex in vertices) for axis in (0, 1)]
    high = [max(vertex[axis] for vertex in vertices) for axis in (0, 1)]
    scale = min(box["width"] / (high[0] - low[0]), box["height"] / (high[1] - low[1])) / 1.1
    x, y = [point[axis] - (low[axis] + high[axis]) / 2 for axis in (0, 1)]
    return {"x": box["width"] / 2 + x * scale, "y": box["height"] / 2 - y * scale}


def launch(playwright: Playwright, *flags: str) -> Browser:
    return playwright.chromium.launch(executable_path=CHROMIUM, args=[*FLAGS, *flags])


class BrowserTest(unittest.TestCase):
    """A browser for all tests of a class; a daemon and a page for each of them."""

    browser: Browser
    pictures: PictureReader
    #: Further flags of the browser.
    flags: tuple[str, ...] = ()
    #: A script that runs in a page before its own scripts.
    prelude = ""

    @classmethod
    def setUpClass(cls) -> None:
        playwright = sync_playwright().start()
        cls.addClassCleanup(playwright.stop)
        cls.browser = launch(playwright, *cls.flags)
        cls.addClassCleanup(cls.browser.close)
        cls.pictures = PictureReader(cls.browser.new_page())

    def setUp(self) -> None:
        self.violations: list[str] = []
        #: Errors in the console that are expected.
        self.tolerated = re.compile(r"(?!)")

    def open(self, daemon: HasPage, fragment: str = "", **options: Any) -> Page:
        """Opens a daemon's page, and watches it until the end of the test."""
        options = {"viewport": WIDE, **options}
        context = self.browser.new_context(**options)
        self.addCleanup(context.close)
        context.add_init_script(self.prelude)
        page = context.new_page()
        page.set_default_timeout(1000 * TIMEOUT)
        self.watch(page, daemon.host)
        page.goto(daemon.url + fragment)
        return page

    def watch(self, page: Page, host: str) -> None:
        """Collects violations: errors, and requests to other hosts."""

        def check_host(url: str) -> None:
            parts = urlsplit(url)
            if parts.scheme != "data" and parts.netloc != host:
                self.violations.append(f"request to another host: {url}")

        def check_message(message: ConsoleMessage) -> None:
            # Most warnings are the browser's own, such as WebGL without a card. Those of invalid calls are the page's.
            is_wrong = message.type == "error" or (message.type == "warning" and "INVALID_" in message.text)
            if is_wrong and not self.tolerated.search(message.text):
                self.violations.append(f"{message.type}: {message.text}")

        page.on("request", lambda request: check_host(request.url))
        page.on("websocket", lambda socket: check_host(socket.url))
        page.on("console", check_message)
        page.on("pageerror", lambda error: self.violations.append(f"thrown: {error}"))
        page.on("crash", lambda _: self.violations.append("the page has crashed"))

    def tearDown(self) -> None:
        self.assertEqual(self.violations, [], "the page has errors or requests to other hosts")

    def see(self, page: Page, element: str = "#plane") -> Picture:
        """An element as it is now."""
        return self.pictures.count(page, self.pictures.screenshot(page, element))

    def see_still(self, page: Page, element: str = "#plane") -> Picture:
        """An element once it no longer changes: dots and tracks come after their frame, and panels are drawn later."""
        deadline = time.monotonic() + TIMEOUT
        png = self.pictures.screenshot(page, element)
        while time.monotonic() < deadline:
            page.wait_for_timeout(100)
            before, png = png, self.pictures.screenshot(page, element)
            if png == before:
                return self.pictures.count(page, png)
        raise AssertionError(f"{element} keeps changing")

    def state(self, page: Page) -> dict[str, Any]:
        """The state that the page exposes for tests."""
        state: dict[str, Any] = page.evaluate("hopes.state()")
        return state

    def wait_for(self, page: Page, condition: str, argument: Any = None) -> dict[str, Any]:
        """Waits until a condition on `state` (and perhaps `argument`) holds. Returns that state."""
        body = f"(argument) => {{ const state = window.hopes?.state(); return state && ({condition}) ? state : null; }}"
        try:
            found: dict[str, Any] = page.wait_for_function(body, arg=argument, polling=50).json_value()
        except TimeoutError:
            raise AssertionError(f"not in time: {condition}, {argument}: {self.state(page)}") from None
        return found
