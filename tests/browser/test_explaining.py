"""The page explains itself: legend, tooltips, words, help, scale bar and coordinates; and says what it waits for."""

from __future__ import annotations

import re
import unittest

from playwright.sync_api import Page, expect

from harness import BrowserTest, Daemon, Producer, position_in, until


class Explaining(BrowserTest):
    def open_still(self, *options: str, frames: int = 3, fragment: str = "", **scene: object) -> tuple[Daemon, Page]:
        """A page of a stream that rests after some frames."""
        daemon = Daemon(self, *options)
        producer = Producer(self, daemon, **{"points": 400, "changed": 20, "rings": 4, "rate": 0, **scene})
        producer.make(frames)
        page = self.open(daemon, fragment)
        self.wait_for(page, "state.seen === argument", frames)
        return daemon, page

    def test_every_control_and_number_has_a_tooltip(self) -> None:
        _, page = self.open_still()
        expected = {
            "label:has(#view-derived)": "gap",
            "label:has(#view-reduced)": "α",
            "label:has(#view-full)": "critical edge",
            "[aria-label^='k,']": "diagonal gap",
            "[aria-label^='l,']": "vertical gap",
            "#ds": "persistence",
            "#vs": "scale",
        }
        for element, word in expected.items():
            self.assertIn(word, page.locator(element).get_attribute("title") or "", element)
        self.assertRegex(page.inner_text("#ds"), r"^ds [\d.]+$")
        self.assertRegex(page.inner_text("#vs"), r"^vs [\d.]+$")

    def test_the_legend_names_what_is_drawn(self) -> None:
        _, page = self.open_still()
        names = page.locator("#plane-legend li").filter(visible=True)
        self.assertEqual(
            names.all_inner_texts(), ["point", "tree edge", "critical edge", "hole of a track", "hole of another cycle"]
        )
        expect(page.get_by_text("simplified skeleton")).to_be_hidden()
        page.get_by_label("Simplified").check()
        expect(page.get_by_text("simplified skeleton")).to_be_visible()

    def test_cycles_and_tracks_are_told_in_words(self) -> None:
        daemon, page = self.open_still("--track", "top:3", fragment="#view=derived&k=1&l=1")
        cycles = daemon.counts("k=1&l=1")[1]
        words = "1 cycle" if cycles == 1 else f"{cycles} cycles"
        self.wait_for(page, "state.seen === 3")
        self.assertRegex(page.inner_text("#words"), rf"^{words} in the view, \d+ tracks?$")

    def test_a_question_mark_opens_the_help(self) -> None:
        _, page = self.open_still()
        page.keyboard.press("?")
        expect(page.locator("#help")).to_be_visible()
        for word in ("born", "dies", "space", "Derived", "vs"):
            self.assertIn(word, page.inner_text("#help"))
        page.keyboard.press("k")
        self.assertEqual(page.inner_text("#k"), "1", "keys are the help's while it is open")
        page.keyboard.press("Escape")
        expect(page.locator("#help")).to_be_hidden()
        page.click("#help-open")
        expect(page.locator("#help")).to_be_visible()
        page.click("#help-close")
        expect(page.locator("#help")).to_be_hidden()

    def test_the_plane_has_a_scale_bar_and_coordinates(self) -> None:
        daemon, page = self.open_still(frames=1)
        vertices = [(x, y) for _, x, y in daemon.snapshot("full")["vertices"]["add"]]
        place = position_in(page, vertices, (50.0, 20.0))
        page.locator("#plane").hover(position=place)
        found = re.fullmatch(r"x (-?[\d.]+), y (-?[\d.]+)", page.inner_text("#place"))
        assert found, page.inner_text("#place")
        self.assertAlmostEqual(float(found[1]), 50.0, delta=1.5)
        self.assertAlmostEqual(float(found[2]), 20.0, delta=1.5)
        length = float(page.inner_text("#scale-length"))
        other = position_in(page, vertices, (50.0 + length, 20.0))
        box = page.locator("#scale-bar").bounding_box()
        assert box is not None
        self.assertAlmostEqual(box["width"], other["x"] - place["x"], delta=4.0)
        page.mouse.move(1, 1)
        self.assertEqual(page.inner_text("#place"), "")

    def test_the_diagonal_rises_by_45_degrees(self) -> None:
        _, page = self.open_still()
        for size in ({"width": 1280, "height": 800}, {"width": 700, "height": 900}, {"width": 1600, "height": 600}):
            page.set_viewport_size(size)  # type: ignore[arg-type]
            page.wait_for_timeout(300)
            self.assertAlmostEqual(page.evaluate(SLOPE), 1.0, delta=0.02)

    def test_crowds_of_dots_are_counted(self) -> None:
        _, page = self.open_still(points=4000, rings=9)
        counts = page.evaluate(CROWDS)
        self.assertGreater(len(counts), 0, "there is no crowd")
        self.assertGreater(max(counts), 50)

    def test_blank_lives_say_how_to_follow_tracks(self) -> None:
        _, page = self.open_still()
        expect(page.locator("#lives-blank")).to_contain_text("--track view")
        self.assertIn("no tracks", page.inner_text("#words"))

    def test_a_single_frame_shows_its_tracks(self) -> None:
        _, page = self.open_still("--track", "view", "--track-confirm", "1", frames=1)
        self.wait_for(page, "state.tracks > 0")
        self.assertGreater(self.see_still(page, "#lives").vivid, 10, "there are no lives")
        self.assertGreater(self.see_still(page).tinted, 5000, "there are no holes")

    def test_a_resting_stream_shows_its_cycles_and_says_when_they_become_tracks(self) -> None:
        # Nobody followed it before, so no hole has been seen twice.
        _, page = self.open_still("--track", "view")
        expect(page.locator("#lives-blank")).to_contain_text("--track-confirm")
        self.assertGreater(self.see_still(page).vivid, 300, "there are no circles of holes")

    def test_points_without_a_commit_are_told(self) -> None:
        daemon = Daemon(self)
        producer = Producer(self, daemon, points=25, rate=0, commit=0)
        producer.make(1)
        until(lambda: daemon.stream()["vertices"] == 25, "the points do not come")
        page = self.open(daemon)
        message = page.locator("#message")
        expect(message).to_contain_text("25 points wait for a commit", timeout=10_000)
        for way in ("blank line", '{"commit":true}', "--frame-every"):
            expect(message).to_contain_text(way)
        self.assertIsNone(self.state(page)["frame"])


# The least and the most dots of a crowd, as the pointer finds them on a walk along the diagonal.
CROWDS = """
() => {
  const { left, top, width, height } = document.getElementById("diagram").getBoundingClientRect();
  const canvas = document.getElementById("diagram");
  const counts = new Set();
  for (let x = 0; x < width; x += 4) {
    for (let y = 0; y < height; y += 4) {
      canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: left + x, clientY: top + y, buttons: 1 }));
      const found = /^([\\d,]+) dots here$/.exec(document.getElementById("diagram-place").textContent);
      if (found) counts.add(Number(found[1].replace(",", "")));
    }
  }
  return [...counts];
}
"""

# Pixels of a unit of death, as a share of those of a unit of birth.
SLOPE = """
() => {
  const canvas = document.getElementById("diagram");
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const at = (x, y) => {
    canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: left + x, clientY: top + y, buttons: 1 }));
    const found = /^birth (.+), death (.+)$/.exec(document.getElementById("diagram-place").textContent);
    return found && { x, y, birth: Number(found[1]), death: Number(found[2]) };
  };
  const found = [];
  for (let x = 0; x < width; x += 3) for (let y = 0; y < height; y += 3) found.push(at(x, y));
  const places = found.filter((place) => place !== null);
  const widest = (axis) => places.reduce((best, place) => (place[axis] > best[axis] ? place : best));
  const narrowest = (axis) => places.reduce((best, place) => (place[axis] < best[axis] ? place : best));
  const [right, leftmost, high, low] = [widest("birth"), narrowest("birth"), widest("death"), narrowest("death")];
  const ofBirth = (right.x - leftmost.x) / (right.birth - leftmost.birth);
  const ofDeath = (low.y - high.y) / (high.death - low.death);
  return ofDeath / ofBirth;
}
"""


if __name__ == "__main__":
    unittest.main()
