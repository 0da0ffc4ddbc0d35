"""The layout: the page fits wide and narrow screens, and is readable and usable, light and dark."""

from __future__ import annotations

import unittest
from typing import Any

from playwright.sync_api import Page

from harness import WIDE, BrowserTest, Daemon, Producer

NARROW = {"width": 390, "height": 844}

# Controls that cannot be reached: outside of the page's width, tiny, or covered once they are scrolled to.
UNREACHABLE = """
(width) => [...document.querySelectorAll("button, select, input, summary")].filter((control) => {
  const shown = control.labels?.[0] ?? control;
  if (shown.getClientRects().length === 0) return false;
  shown.scrollIntoView({ block: "center" });
  const { left, right, top, bottom } = shown.getBoundingClientRect();
  const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
  const isReached = shown.contains(hit) || hit?.contains(control);
  return left < 0 || right > width || right - left < 18 || bottom - top < 18 || !isReached;
}).map((control) => control.outerHTML)
"""

# Texts that are cut off, or that stand out of their box.
CLIPPED = """
() => [...document.querySelectorAll("h1, h2 span, label, button, output, dt, dd, li, footer span, #steps")]
  .filter((element) => element.getClientRects().length > 0)
  .filter((element) => {
    const { left, right, top, bottom } = element.getBoundingClientRect();
    const isCut = element.scrollWidth > element.clientWidth + 1 && getComputedStyle(element).overflow !== "visible";
    return isCut || left < 0 || top < 0 || right > innerWidth || bottom > innerHeight;
  })
  .map((element) => element.outerHTML)
"""

# Texts with too little contrast to their background.
UNREADABLE = """
() => {
  const parts = (css) => css.match(/[\\d.]+/g).map(Number);
  const light = ([red, green, blue]) => {
    const [r, g, b] = [red, green, blue].map((part) => {
      const share = part / 255;
      return share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    const color = parts(getComputedStyle(element).backgroundColor);
    if (color.length === 3 || color[3] === 1) return color;
    return behind(element.parentElement);
  };
  const texts = [...document.body.querySelectorAll("*")].filter(
    (element) =>
      element.getClientRects().length > 0 &&
      !element.matches(":disabled, option, script") &&
      [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim() !== ""),
  );
  return texts.flatMap((element) => {
    const [one, other] = [light(parts(getComputedStyle(element).color)), light(behind(element))];
    const contrast = (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
    return contrast < 4.5 ? [`${contrast.toFixed(2)}: ${element.outerHTML}`] : [];
  });
}
"""


class Layout(BrowserTest):
    def setUp(self) -> None:
        super().setUp()
        self.daemon = Daemon(self, "--track", "view")

    def check_layout(self, **options: Any) -> Page:
        producer = Producer(self, self.daemon, points=600, changed=20, rings=6, rate=0)
        producer.make(1)
        page = self.open(self.daemon, reduced_motion="reduce", **options)
        self.wait_for(page, "state.frame === 1")
        producer.make(20)
        self.wait_for(page, "state.seen === 21 && state.tracks > 0")
        self.assert_fits(page)
        for view in ("Reduced", "Derived"):
            page.get_by_text(view, exact=True).click()
            self.assert_fits(page)
        page.keyboard.press("?")
        self.assertEqual(page.evaluate(UNREADABLE), [])
        page.click("#help-close")
        self.wait_for(page, "state.view.cut.Derived && state.seen === state.frame")
        self.assertEqual(page.evaluate(UNREADABLE), [])
        for picture in ("#plane", "#diagram", "#lives"):
            self.assertGreater(self.see_still(page, picture).vivid, 40, f"there is nothing in {picture}")
        return page

    def assert_fits(self, page: Page) -> None:
        """Nothing is wider than the screen, and every control can be reached."""
        # A mobile browser widens its layout for a page that is too wide, so `innerWidth` would not tell.
        assert page.viewport_size is not None
        width = page.viewport_size["width"]
        self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), width, "it is too wide")
        self.assertEqual(page.evaluate(UNREACHABLE, width), [])

    def test_wide_and_light(self) -> None:
        page = self.check_layout(viewport=WIDE, color_scheme="light")
        self.assertEqual(page.evaluate("document.documentElement.scrollHeight - innerHeight"), 0, "it is too high")
        self.assertEqual(page.evaluate("getComputedStyle(document.body).backgroundColor"), "rgb(251, 252, 253)")

    def test_wide_and_dark(self) -> None:
        page = self.check_layout(viewport=WIDE, color_scheme="dark")
        self.assertEqual(page.evaluate("getComputedStyle(document.body).backgroundColor"), "rgb(20, 23, 26)")
        dark = self.see_still(page)
        page.emulate_media(color_scheme="light")
        self.wait_for(page, "getComputedStyle(document.body).backgroundColor === 'rgb(251, 252, 253)'")
        self.assertGreater(self.pictures.difference(dark, self.see_still(page)), dark.panel, "the plane stays dark")

    def test_half_wide(self) -> None:
        page = self.check_layout(viewport={"width": 1024, "height": 720}, color_scheme="light")
        self.assertEqual(page.evaluate("document.documentElement.scrollHeight - innerHeight"), 0, "it is too high")
        for view in ("#view=derived&k=1000&l=1000", "#view=reduced&alpha=12.3456789"):
            page.goto(self.daemon.url + view)
            page.reload()
            self.wait_for(page, "state.seen > 0")
            page.click("#pause")
            page.wait_for_function("document.querySelector('#steps').textContent !== ''")
            self.assertEqual(page.evaluate(CLIPPED), [])

    def test_narrow_and_light(self) -> None:
        self.check_layout(viewport=NARROW, color_scheme="light", is_mobile=True, has_touch=True, device_scale_factor=2)

    def test_narrow_and_dark(self) -> None:
        self.check_layout(viewport=NARROW, color_scheme="dark", is_mobile=True, has_touch=True, device_scale_factor=2)


if __name__ == "__main__":
    unittest.main()
