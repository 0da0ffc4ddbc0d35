"""Measures whether the page's memory stays bounded on a long stream. It is run by hand; no test runs it.

In: minutes and a scene on the command line; the environment variables of `harness`.
Out: a line every half minute: the frame, frames drawn per second, how many frames the picture is behind the producer,
the JS heap after a garbage collection, buffers outside of it, nodes of the document, the memory of the browser's page
processes. The exit code is 1 if any of them has grown by more than its bound since minute 2.
Invariants: what is held on purpose (the history of frames, the lifetimes of tracks) is at its limits before minute 2.
Must not know: what takes the memory.

    tests/browser/run --memory [--minutes 10] [--scene sweep|rings]
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

from harness import WIDE, Daemon, Producer, launch, until

EVERY = 30.0
SETTLED = 120.0
MIB = 1 << 20


class CleanupStack(contextlib.ExitStack):
    """Runs cleanups at its end, as a test does."""

    def addCleanup(self, end: Any, *arguments: Any) -> None:  # noqa: N802, as tests have it
        self.callback(end, *arguments)


@dataclass
class Sample:
    """The memory at one time."""

    minutes: float
    frame: int
    #: Frames drawn per second, and how many the picture is behind the producer.
    drawn: float
    behind: int
    heap: float
    buffers: float
    nodes: float
    resident: float

    #: The bound of each one's growth, in MiB or nodes, from the first settled sample to the last.
    BOUNDS = {"heap": 8.0, "buffers": 16.0, "nodes": 100.0, "resident": 64.0}

    def __str__(self) -> str:
        return (
            f"{self.minutes:7.1f} {self.frame:7} {self.drawn:7.1f} {self.behind:6} {self.heap:9.1f}"
            f" {self.buffers:12.1f} {self.nodes:6.0f} {self.resident:9.0f}"
        )


HEAD = "minutes   frame drawn/s behind  heap MiB  buffers MiB  nodes  RSS MiB"


def take(browser: Browser, page: Page, session: CDPSession, producer: Producer, since: float) -> Sample:
    # This comes before the garbage collection, which stops the page.
    newest, state = producer.newest, page.evaluate("hopes.state()")
    drawn, behind = state["drawn"], max(0, newest - (state["seen"] or 0))
    session.send("HeapProfiler.collectGarbage")
    usage = session.send("Runtime.getHeapUsage")
    nodes = session.send("Memory.getDOMCounters")["nodes"]
    minutes = (time.monotonic() - since) / 60
    buffers = usage.get("backingStorageSize", 0) / MIB
    return Sample(minutes, state["frame"], drawn, behind, usage["usedSize"] / MIB, buffers, nodes, resident(browser))


def resident(browser: Browser) -> float:
    """The memory of all processes that run pages."""
    session = browser.new_browser_cdp_session()
    infos = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    ids = ",".join(str(info["id"]) for info in infos if info["type"] == "renderer")
    listed = subprocess.run(["ps", "-o", "rss=", "-p", ids], capture_output=True, text=True, check=True).stdout
    return sum(int(line) for line in listed.split()) / 1024


def follow(minutes: float, scene: str, points: int) -> list[Sample]:
    """Follows a stream for some minutes."""
    with CleanupStack() as cleanups, sync_playwright() as playwright:
        daemon = Daemon(cleanups, "--track", "top:20")
        producer = Producer(cleanups, daemon, scene=scene, points=points, changed=points // 100, rings=10)
        producer.wait_for(1)
        with launch(playwright) as browser:
            page = browser.new_page(viewport=WIDE)
            page.goto(daemon.url)
            session = page.context.new_cdp_session(page)
            until(lambda: page.evaluate("hopes.state().frame") is not None, "nothing is followed")
            since = time.monotonic()
            samples = []
            print(HEAD, flush=True)
            while not samples or samples[-1].minutes < minutes:
                page.wait_for_timeout(1000 * max(0.0, since + EVERY * len(samples) - time.monotonic()))
                samples.append(take(browser, page, session, producer, since))
                print(samples[-1], flush=True)
            return samples


def judge(samples: list[Sample]) -> int:
    """Prints what has grown. Returns the exit code."""
    settled = [sample for sample in samples if 60 * sample.minutes >= SETTLED - 1]
    if len(settled) < 2:
        print("too short to judge: memory is settled from minute 2 on")
        return 1
    code = 0
    for name, bound in Sample.BOUNDS.items():
        growth = getattr(settled[-1], name) - getattr(settled[0], name)
        verdict = "within" if growth <= bound else "ABOVE"
        code |= growth > bound
        print(f"{name}: {growth:+.1f} since minute {settled[0].minutes:.0f}, {verdict} the bound of {bound:.0f}")
    return code


def main() -> int:
    parser = argparse.ArgumentParser(description="Measures the page's memory on a running stream.")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--scene", choices=["sweep", "rings"], default="sweep")
    parser.add_argument("--points", type=int, default=100_000)
    arguments = parser.parse_args()
    return judge(follow(arguments.minutes, arguments.scene, arguments.points))


if __name__ == "__main__":
    sys.exit(main())
