"""The page of `hopes demo`, from its first frames to its end."""

from __future__ import annotations

import re
import signal
import subprocess
import unittest
from urllib.parse import urlsplit

from harness import HOPES_BIN, TIMEOUT, WIDE, BrowserTest, HasCleanup

# Screenshots that are looked at.
LOOKS = 20


class Demo:
    """A demo that has printed its address, stopped with the test."""

    def __init__(self, test: HasCleanup, *options: str) -> None:
        command = [HOPES_BIN, "demo", "--view", "127.0.0.1:0", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        test.addCleanup(self.process.communicate)
        test.addCleanup(self.process.kill)
        assert self.process.stdout is not None
        first = self.process.stdout.readline()
        found = re.search(r"^open (http://\S+) in a browser", first)
        assert found, f"{first!r} has no address to open"
        self.url = found[1]
        self.host = urlsplit(self.url).netloc


class DemoTest(BrowserTest):
    def shown(self, shape: str, *options: str) -> None:
        # The browser itself logs that it cannot connect; a page cannot prevent that.
        self.tolerated = re.compile(r"WebSocket connection to '\S+' failed")
        demo = Demo(self, *options)
        page = self.open(demo)
        self.wait_for(page, "state.stream === 'demo' && state.seen > 10 && state.tracks > 0")

        # Scenes are rows of shapes, so the plane has the whole width.
        page.locator(f"body[data-shape={shape}]").wait_for()
        plane = page.locator("#plane").bounding_box()
        assert plane is not None
        self.assertEqual(plane["width"] > 0.9 * WIDE["width"], shape == "wide")

        # Every single look has all of it: nothing is drawn without its holes.
        for _ in range(LOOKS):
            picture = self.see(page)
            self.assertGreater(picture.point, 300, "there are too few pixels of points")
            self.assertGreater(picture.tinted, 300, "there are too few pixels of holes")
        demo.process.send_signal(signal.SIGINT)
        out, log = demo.process.communicate(timeout=TIMEOUT)
        # On a busy machine the terminal gets several frames as one, and is told so.
        rest = re.sub(r"^.*frames \d+ to \d+ come as one\n", "", log, flags=re.MULTILINE)
        self.assertEqual((demo.process.returncode, rest), (0, ""))
        self.assertRegex(out, r"track 1 is born: at \(")
        self.assertTrue(out.endswith("\nSIGINT\n"), out)
        page.locator("body[data-state=gone]").wait_for()

    def test_a_scene_is_shown(self) -> None:
        self.shown("wide")

    def test_the_film_is_shown(self) -> None:
        self.shown("compact", "--video", "--rate", "20")


if __name__ == "__main__":
    unittest.main()
