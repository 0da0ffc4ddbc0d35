"""Streams in a space: a cloud in R^3 is drawn, turned and followed, and one in R^20 by its principal components."""

from __future__ import annotations

import unittest
from typing import Any

from playwright.sync_api import Page

from harness import CARD_FLAGS, CARD_PRELUDE, BrowserTest, Daemon, Producer

POINTS = 200


class WithoutGraphicsCard(BrowserTest):
    """The software renderer draws the cloud."""

    has_card = False

    def open_page(self, dimension: int, rate: int, *options: str) -> tuple[Producer, Page]:
        """A page of two linked rings, with their critical edges in the view."""
        daemon = Daemon(self, *options)
        producer = Producer(
            self, daemon, scene="links", metric="euclidean", rings=dimension, points=POINTS, changed=10, rate=rate
        )
        if rate == 0:
            producer.make(3)
        producer.wait_for(3)
        page = self.open(daemon)
        state = self.wait_for(page, "state.connected && state.seen >= 3")
        self.assertEqual(state["picture"]["space"], f"R^{dimension}, euclidean")
        is_card = page.evaluate("document.getElementById('plane').getContext('2d') === null")
        self.assertEqual(is_card, self.has_card)
        return producer, page

    def drag(self, page: Page, right: int, down: int, **options: Any) -> None:
        """Drags from the middle of the picture."""
        box = page.locator("#plane").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down(**options)
        page.mouse.move(x + right, y + down, steps=5)
        page.mouse.up(**options)
        page.mouse.move(1, 1)

    def test_a_cloud_is_drawn_and_said_to_be_in_space(self) -> None:
        _, page = self.open_page(3, 0)
        self.assertEqual(page.inner_text("#space"), "R^3, euclidean")
        self.assertEqual(page.locator("#stream option").all_inner_texts(), ["scan (R^3)"])
        legend = page.locator("#plane-legend li").filter(visible=True).all_inner_texts()
        self.assertEqual(legend, ["point", "tree edge", "critical edge", "cycle of a track"])
        state = self.state(page)
        self.assertEqual((state["points"], state["vertices"]), (POINTS, POINTS))
        self.assertGreaterEqual(state["critical"], 2)
        plane = self.see_still(page)
        self.assertGreater(plane.point + plane.edge, 800, "there are too few pixels of points and edges")
        self.assertGreater(plane.vivid, 10, "there are too few pixels of critical edges")
        # Coordinates on the screen are those of no axis.
        page.locator("#plane").hover()
        self.assertEqual(page.inner_text("#place"), "")
        self.assertTrue(page.locator("#scale").is_visible())

    def test_tracks_are_loops_in_their_colours(self) -> None:
        producer, page = self.open_page(3, 0, "--track", "view")
        last = producer.make(5)
        state = self.wait_for(page, "state.seen === argument && state.tracks === 2", last)
        self.assertEqual((state["picture"]["walks"], state["picture"]["holes"]), (2, 0))
        plane = self.see_still(page)
        self.assertGreater(plane.vivid + plane.tinted, 600, "there are too few pixels of loops")
        self.assertLess(plane.tinted, 20_000, "a hole is filled")
        self.assertGreater(self.see(page, "#diagram").vivid, 60, "there are no dots of tracks in the diagram")
        self.assertGreater(self.see(page, "#lives").vivid, 20, "there are no lives")

        page.keyboard.press("]")
        page.locator("#cycle").wait_for(state="visible")
        self.assertRegex(page.inner_text("#cycle-id"), r"^track [1-9]\d*$")
        self.assertGreater(self.pictures.difference(plane, self.see_still(page)), 500, "no loop is highlighted")

    def test_dragging_turns_and_a_double_click_turns_back(self) -> None:
        _, page = self.open_page(3, 0)
        start, box = self.see_still(page), self.state(page)["picture"]["box"]
        self.drag(page, 150, 60)
        turned = self.see_still(page)
        self.assertGreater(self.pictures.difference(start, turned), 500, "dragging does not turn")
        self.assertEqual([round(side, 6) for side in self.state(page)["picture"]["box"]], [round(s, 6) for s in box])
        page.locator("#plane").dblclick()
        page.mouse.move(1, 1)
        self.assertLess(self.pictures.difference(start, self.see_still(page)), 60, "a double click does not turn back")
        # The first key also draws the frame of what has the focus.
        page.locator("#plane").press("ArrowLeft")
        before = self.see_still(page)
        page.locator("#plane").press("ArrowLeft")
        self.assertGreater(self.pictures.difference(before, self.see_still(page)), 300, "an arrow does not turn")

    def test_shift_and_the_right_button_move(self) -> None:
        _, page = self.open_page(3, 0)
        start = self.see_still(page)
        page.keyboard.down("Shift")
        self.drag(page, 90, 0)
        page.keyboard.up("Shift")
        moved = self.see_still(page)
        self.assertGreater(self.pictures.difference(start, moved), 500, "a drag with shift does not move")
        self.drag(page, -90, 0, button="right")
        # Moved there and back, and not turned: the picture is the same.
        self.assertLess(self.pictures.difference(start, self.see_still(page)), 60, "it was not only moved")

    def test_a_turned_cloud_is_followed_and_stepped_through(self) -> None:
        producer, page = self.open_page(3, 20)
        self.drag(page, 100, -40)
        state = self.wait_for(page, "state.seen >= argument", producer.newest + 20)
        self.assertEqual(state["resyncs"], 0)
        page.keyboard.press(" ")
        self.wait_for(page, "state.paused && state.back > 3")
        newest = self.see_still(page)
        for _ in range(3):
            page.keyboard.press(",")
        stepped = self.see_still(page)
        self.assertGreater(self.pictures.difference(newest, stepped), 60, "a step back shows the same frame")
        for _ in range(3):
            page.keyboard.press(".")
        self.assertLess(self.pictures.difference(newest, self.see_still(page)), 30, "steps lead to another picture")

    def test_many_dimensions_are_shown_without_jumps(self) -> None:
        producer, page = self.open_page(20, 0)
        before = self.see_still(page)
        blank = before.panel + before.point + before.edge
        last = producer.make(1)
        self.wait_for(page, "state.seen === argument", last)
        changed = self.pictures.difference(before, self.see_still(page))
        self.assertLess(changed, 0.02 * blank, "the picture jumps")
        self.drag(page, 150, 60)
        self.assertGreater(self.pictures.difference(before, self.see_still(page)), 500, "dragging does not turn")


class WithGraphicsCard(WithoutGraphicsCard):
    """The same, drawn by WebGL, on an emulated card."""

    has_card = True
    flags = CARD_FLAGS
    prelude = CARD_PRELUDE


if __name__ == "__main__":
    unittest.main()
