"""The controls by mouse and keys: the view, and the history."""

from __future__ import annotations

import unittest
from typing import Any

from playwright.sync_api import Page

from harness import BrowserTest, Daemon, Producer, until

# The view in the state is the one that the daemon's frames have.
VIEW_IS = "JSON.stringify(state.view) === JSON.stringify(argument) && state.seen === state.frame"


def derived(k: int, l: int, simplify: str = "No") -> dict[str, Any]:  # noqa: E741
    return {"cut": {"Derived": [k, l]}, "simplify": simplify}


class Views(BrowserTest):
    """A cloud that does not change, so that only the user's actions change the page."""

    def setUp(self) -> None:
        super().setUp()
        self.daemon = Daemon(self, "--track", "view")
        producer = Producer(self, self.daemon, points=600, changed=20, rings=6, shrink=0.6, rate=0)
        producer.make(1)
        self.page = self.open(self.daemon)
        self.wait_for(self.page, "state.frame === 1")
        producer.make(5)
        self.wait_for(self.page, "state.frame === 6 && state.seen === 6 && state.tracks > 0")

    def wait_for_scale(self, above: float) -> dict[str, Any]:
        """Waits for a reduced view of the scale in the address."""
        chosen = "Number(new URLSearchParams(location.hash.slice(1)).get('alpha'))"
        condition = f"state.view.cut.Reduced > argument && state.view.cut.Reduced === {chosen}"
        return self.wait_for(self.page, f"{condition} && state.seen === state.frame", above)

    def wait_for_view(self, view: dict[str, Any]) -> dict[str, Any]:
        return self.wait_for(self.page, VIEW_IS, view)

    def test_ranks_by_mouse_and_keys(self) -> None:
        first = self.wait_for_view(derived(1, 1))
        narrow = self.see_still(self.page)
        for times in range(2, 5):
            self.page.click("#k-more")
            self.wait_for_view(derived(times, 1))
        wide = self.state(self.page)
        self.assertGreater(wide["critical"], first["critical"])
        difference = self.pictures.difference(narrow, self.see_still(self.page))
        self.assertGreater(difference, 20, "more cycles, and the same picture")
        self.page.click("#k-less")
        self.wait_for_view(derived(3, 1))
        self.page.click("#l-more")
        self.wait_for_view(derived(3, 2))
        self.page.keyboard.press("k")
        self.wait_for_view(derived(4, 2))
        self.page.keyboard.press("l")
        self.wait_for_view(derived(4, 3))
        self.page.keyboard.press("Shift+K")
        self.page.keyboard.press("Shift+L")
        self.wait_for_view(derived(3, 2))
        self.assertEqual((self.page.inner_text("#k"), self.page.inner_text("#l")), ("3", "2"))
        self.assertEqual(self.daemon.counts("k=3&l=2"), counts(self.state(self.page)))

    def test_full_and_reduced_views(self) -> None:
        narrow = self.see_still(self.page)
        self.page.get_by_text("Full", exact=True).click()
        everything = self.wait_for_view({"cut": "Full", "simplify": "No"})
        self.assertEqual(self.daemon.counts("full"), counts(everything))
        self.assertGreater(self.see_still(self.page).vivid, narrow.vivid + 100, "not all critical edges are drawn")

        self.page.get_by_text("Reduced", exact=True).click()
        self.wait_for_scale(above=0)
        slider = self.page.get_by_label("alpha, the scale")
        box = slider.bounding_box()
        assert box is not None
        self.page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + box["height"] / 2)
        low = self.wait_for_scale(above=0)
        for _ in range(60):
            slider.press("ArrowRight")
        high = self.wait_for_scale(above=low["view"]["cut"]["Reduced"])
        self.assertEqual(self.daemon.counts(f"alpha={high['view']['cut']['Reduced']!r}"), counts(high))
        self.assertNotEqual(counts(low), counts(high))

        self.page.keyboard.press("1")
        self.wait_for_view(derived(1, 1))
        self.page.keyboard.press("3")
        self.wait_for_view({"cut": "Full", "simplify": "No"})

    def test_a_simplified_view_keeps_its_points(self) -> None:
        before = self.wait_for_view(derived(1, 1))
        full = self.see_still(self.page)
        self.page.get_by_label("Simplified").check()
        after = self.wait_for_view(derived(1, 1, "AtScale"))
        self.assertEqual(after["vertices"], before["vertices"])
        self.assertTrue(0 < after["simplified"] < before["vertices"], after["simplified"])
        bold = self.see_still(self.page)
        self.assertGreater(self.pictures.difference(full, bold), 500, "no simplified skeleton is drawn")
        self.assertGreater(bold.point, 0.5 * full.point, "the points are gone")
        self.page.get_by_label("Simplified").uncheck()
        self.wait_for_view(derived(1, 1))
        self.assertLess(self.pictures.difference(full, self.see_still(self.page)), 20)

    def test_the_address_keeps_the_choice(self) -> None:
        self.page.click("#k-more")
        self.page.keyboard.press("s")
        self.wait_for_view(derived(2, 1, "AtScale"))
        self.page.reload()
        self.wait_for_view(derived(2, 1, "AtScale"))
        self.assertEqual(self.page.inner_text("#k"), "2")
        self.assertTrue(self.page.get_by_label("Simplified").is_checked())
        address = self.page.evaluate("location.hash")
        other = self.open(self.daemon, address)
        self.wait_for(other, VIEW_IS, derived(2, 1, "AtScale"))


class Time(BrowserTest):
    def test_pause_step_back_and_go_on(self) -> None:
        daemon = Daemon(self, "--track", "view")
        producer = Producer(self, daemon, points=400, changed=40)
        page = self.open(daemon)
        self.wait_for(page, "state.frames > 20 && state.back > 15")
        page.click("#pause")
        self.wait_for(page, "state.paused && state.seen === state.frame")
        self.assertEqual(page.inner_text("#state"), "paused")
        still, picture = self.state(page), self.see_still(page)
        producer.wait_for(producer.newest + 30)
        self.assertEqual(self.state(page)["frame"], still["frame"])
        self.assertEqual(self.pictures.difference(picture, self.see_still(page)), 0, "a paused plane moves")

        for _ in range(4):
            page.click("#back")
        page.keyboard.press(",")
        back = self.wait_for(page, "state.back === argument && state.seen === state.frame", still["back"] - 5)
        self.assertLessEqual(back["frame"], still["frame"] - 5)
        self.assertEqual(back["vertices"], 400)
        older = self.see_still(page)
        self.assertGreater(self.pictures.difference(picture, older), 100, "an older frame looks the same")
        for _ in range(4):
            page.click("#forward")
        page.keyboard.press(".")
        self.wait_for(page, "state.seen === argument", still["frame"])
        self.assertEqual(self.pictures.difference(picture, self.see_still(page)), 0, "back again, it looks different")

        self.click_away(page)
        page.keyboard.press(" ")
        self.wait_for(page, "!state.paused && state.seen >= argument", producer.newest)
        self.assertEqual(page.inner_text("#state"), "live")

    def test_a_change_of_the_view_while_paused_stays_paused(self) -> None:
        daemon = Daemon(self, "--track", "view")
        producer = Producer(self, daemon, points=400, changed=40)
        page = self.open(daemon)
        self.wait_for(page, "state.back > 5")
        page.click("#pause")
        self.wait_for(page, "state.paused && state.seen === state.frame")
        page.click("#k-more")
        self.wait_for(page, f"state.paused && {VIEW_IS}", derived(2, 1))
        page.keyboard.press("s")
        still = self.wait_for(page, f"state.paused && {VIEW_IS}", derived(2, 1, "AtScale"))
        until(lambda: daemon.stream()["consumers"] == 0, "a paused page follows the stream")
        producer.wait_for(producer.newest + 30)
        after = self.state(page)
        self.assertEqual((after["frame"], after["paused"]), (still["frame"], True))
        self.assertEqual(page.inner_text("#state"), "paused")

    def click_away(self, page: Page) -> None:
        """Takes the focus off buttons, which handle the space key themselves."""
        page.click("h1")


def counts(state: dict[str, Any]) -> tuple[int, int]:
    return state["edges"], state["critical"]


if __name__ == "__main__":
    unittest.main()
