"""The page keeps up with a stream of many points, and no page slows the daemon down."""

from __future__ import annotations

import time
import unittest

from playwright.sync_api import Page

from harness import BrowserTest, Daemon, Producer

RATE = 30
# Below this rate of the producer the machine is too slow to judge the page.
LEAST_RATE = 15
SECONDS = 15.0


class Following(BrowserTest):
    def assert_rate(self, producer: Producer, since: int) -> None:
        """The daemon has committed frames at the producer's rate."""
        rate = producer.rate(since)
        self.assertGreaterEqual(
            rate,
            LEAST_RATE,
            f"NOT THE PAGE: program and machine take {rate:.1f} frames/s here, and {RATE} are wanted; is it busy?",
        )

    def assert_never_behind(self, page: Page, producer: Producer, seconds: float) -> None:
        """The held frame and the drawn frame are at no time more than a second old."""
        since = producer.newest
        held = drawn = 0
        while producer.times[-1] - producer.times[since - 1] < seconds:
            newest = producer.newest
            state = self.state(page)
            held = max(held, newest - state["frame"])
            drawn = max(drawn, newest - state["seen"])
            time.sleep(0.1)
        self.assert_rate(producer, since)
        self.assertLessEqual(held, RATE, "frames that the mirror is behind")
        self.assertLessEqual(drawn, RATE, "frames that the drawing is behind")

    def test_a_hundred_thousand_points_at_thirty_frames_a_second(self) -> None:
        daemon = Daemon(self, "--track", "top:20")
        producer = Producer(self, daemon, scene="sweep", points=100_000, changed=1000, rings=10, rate=RATE)
        producer.wait_for(1)
        page = self.open(daemon)
        first = self.wait_for(page, "state.seen > 0")
        self.assert_never_behind(page, producer, SECONDS)
        state = self.state(page)
        self.assertEqual((state["points"], state["vertices"]), (100_000, 100_000))
        # Every frame was applied by its diff and verified, without a resync.
        self.assertEqual(state["resyncs"], 0)
        self.assertGreaterEqual(state["frames"], state["frame"] - first["frame"] - RATE)
        self.assertGreater(self.see(page).point, 10_000)

    def test_a_page_that_is_stuck_delays_nothing(self) -> None:
        daemon = Daemon(self)
        producer = Producer(self, daemon, points=20_000, changed=200, scene="sweep", rate=RATE)
        page = self.open(daemon)
        self.wait_for(page, "state.seen > 0")
        since = producer.newest
        page.evaluate("{ const end = performance.now() + 3000; while (performance.now() < end); }")
        self.assert_rate(producer, since)
        self.assertGreater(producer.newest, since + 2 * LEAST_RATE)
        self.wait_for(page, "state.seen >= argument", producer.newest)

    def test_a_hidden_page_delays_nothing(self) -> None:
        daemon = Daemon(self)
        producer = Producer(self, daemon, points=2000, changed=20, rate=RATE)
        page = self.open(daemon)
        self.wait_for(page, "state.seen > 0")
        self.hide(page, True)
        hidden = self.wait_for(page, "document.hidden")
        since = producer.newest
        producer.wait_for(since + 3 * RATE)
        self.assert_rate(producer, since)
        # It receives only frames that were already on their way.
        self.assertLess(self.state(page)["frames"], hidden["frames"] + RATE)
        self.assertEqual(daemon.stream()["consumers"], 0)
        self.hide(page, False)
        self.wait_for(page, "!document.hidden && state.seen >= argument", producer.newest)

    def hide(self, page: Page, hidden: bool) -> None:
        """Makes the page believe that it is hidden or visible. A headless browser never hides a tab itself."""
        page.evaluate(
            """(hidden) => {
                Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
                document.dispatchEvent(new Event("visibilitychange"));
            }""",
            hidden,
        )


if __name__ == "__main__":
    unittest.main()
