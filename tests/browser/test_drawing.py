"""The drawing of a stream, with and without a graphics card, and the data of the cycle under the pointer."""

from __future__ import annotations

import math
import re
import unittest

from playwright.sync_api import Page

from harness import CARD_FLAGS, CARD_PRELUDE, BrowserTest, Daemon, Producer, position_in, until


class WithoutGraphicsCard(BrowserTest):
    """The software renderer draws the plane."""

    #: Whether WebGL draws the plane.
    has_card = False
    #: Pixels of the colour of edges at the least. With antialiasing the rims of points have it too.
    least_edges = 800

    def open_page(self, rate: int, *options: str) -> tuple[Daemon, Producer, Page]:
        """A page that is opened after ten frames of a stream. At a rate of 0 the test makes the further frames."""
        daemon = Daemon(self, *options)
        producer = Producer(self, daemon, points=400, changed=20, rings=4, rate=rate)
        if rate == 0:
            producer.make(10)
        producer.wait_for(10)
        page = self.open(daemon)
        self.wait_for(page, "state.connected && state.seen >= 10")
        is_card = page.evaluate("document.getElementById('plane').getContext('2d') === null")
        self.assertEqual(is_card, self.has_card)
        return daemon, producer, page

    def assert_drawn(self, page: Page) -> None:
        plane = self.see(page)
        self.assertGreater(plane.point, 400, "there are too few pixels of points")
        self.assertGreater(plane.vivid, 100, "there are too few pixels of critical edges")
        self.assertGreater(plane.tinted, 20_000, "there are too few pixels of holes")
        self.assertGreater(plane.panel, 100_000, "everything is covered")

    def test_a_running_stream_is_drawn_and_followed(self) -> None:
        daemon, producer, page = self.open_page(30, "--track", "view")
        self.wait_for(page, "state.tracks >= 4")
        self.assert_drawn(page)
        before = self.see(page)
        self.wait_for(page, "state.seen >= argument", producer.newest + 20)
        self.assertGreater(self.pictures.difference(before, self.see(page)), 200, "the plane does not change")
        self.assertGreater(self.see(page, "#diagram").vivid, 60, "there are no dots of tracks in the diagram")
        self.assertGreater(self.see(page, "#lives").vivid, 60, "there are no lives")

        producer.stop()
        until(lambda: daemon.stream()["producers"] == 0, "the daemon still counts the producer")
        info = daemon.stream()
        state = self.wait_for(page, "state.seen === argument", info["frame"])
        self.assertEqual(info["points"], 400)
        self.assertEqual((state["points"], state["vertices"]), (info["points"], info["vertices"]))
        self.assertEqual((state["edges"], state["critical"]), daemon.counts("k=1&l=1"))
        self.assertEqual(state["resyncs"], 0)

    def test_a_tree_is_drawn_without_tracks(self) -> None:
        _, _, page = self.open_page(0)
        # There are no holes and few thick lines, whose rims would have the colour of edges too.
        plane = self.see_still(page)
        self.assertGreater(plane.point, 400, "there are too few pixels of points")
        self.assertGreater(plane.edge, self.least_edges, "there are too few pixels of edges")
        self.assertGreater(plane.vivid, 20, "there are too few pixels of critical edges")

    def test_the_cycle_under_the_pointer_is_described_and_highlighted(self) -> None:
        daemon, producer, page = self.open_page(0, "--track", "view")
        last = producer.make(10)
        self.wait_for(page, "state.seen === argument && state.tracks >= 4", last)
        dot = daemon.most_persistent()
        vertices = [(x, y) for _, x, y in daemon.snapshot("full")["vertices"]["add"]]
        diagram, plane = self.see_still(page, "#diagram"), self.see_still(page)
        self.assertFalse(page.locator("#cycle").is_visible())

        page.locator("#plane").hover(position=position_in(page, vertices, dot.center))
        page.locator("#cycle").wait_for(state="visible")
        self.assertEqual(shown(page, "birth"), rounded(dot.birth))
        self.assertEqual(shown(page, "death"), rounded(dot.death))
        self.assertEqual(shown(page, "persistence"), rounded(dot.death - dot.birth))
        self.assertRegex(page.inner_text("#cycle-id"), r"^track [1-9]\d*$")
        age = int(re.fullmatch(r"(\d+) frames", page.inner_text("#cycle-age")).group(1))  # type: ignore[union-attr]
        self.assertTrue(1 < age <= last, f"an age of {age} frames")
        highlighted = self.see_still(page, "#diagram")
        self.assertGreater(self.pictures.difference(diagram, highlighted), 40, "no dot is highlighted")
        self.assertGreater(self.pictures.difference(plane, self.see_still(page)), 1000, "no hole is highlighted")

        page.mouse.move(1, 1)
        page.locator("#cycle").wait_for(state="hidden")
        after = self.see_still(page, "#diagram")
        self.assertLess(self.pictures.difference(diagram, after), 10, "a dot is still highlighted")


class WithGraphicsCard(WithoutGraphicsCard):
    """The same, drawn by WebGL, on an emulated card."""

    has_card = True
    least_edges = 1500
    flags = CARD_FLAGS
    prelude = CARD_PRELUDE

    def test_drawing_continues_after_the_card_was_lost_and_restored(self) -> None:
        _, producer, page = self.open_page(30, "--track", "view")
        page.evaluate(
            """() => {
                const gl = document.getElementById("plane").getContext("webgl2");
                window.card = gl.getExtension("WEBGL_lose_context");
                window.card.loseContext();
            }"""
        )
        self.wait_for(page, "state.frame > argument", producer.newest + 5)
        page.evaluate("card.restoreContext()")
        self.wait_for(page, "state.seen > argument", producer.newest + 10)
        self.assert_drawn(page)


def shown(page: Page, what: str) -> float:
    """A number of the picked cycle."""
    return float(page.inner_text(f"#cycle-{what}"))


def rounded(value: float) -> float:
    """A number with the four digits that the page shows."""
    return float(f"{value:.4g}") if math.isfinite(value) else value


if __name__ == "__main__":
    unittest.main()
