"""Pixels of an element on the page, counted by colour.

In: an element of a page.
Out: counts.
Invariants: pixels are those of a screenshot, so they are what a person would see, and the page is not asked.
Screenshots are decoded in a page of their own.
Must not know: what is drawn.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass

from playwright.sync_api import Page

# Greys of the style sheet. A pixel between the panel's colour and one of the others is grey, and counts as the nearest
# one. Any other pixel of a strong colour is `vivid`, as lines of cycles are; of a pale one `tinted`, as holes are.
NAMES = ("panel", "point", "edge", "ink")

_READ = """
async (png) => {
  const image = new Image();
  image.src = `data:image/png;base64,${png}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.width, image.height];
  const to = canvas.getContext("2d", { willReadFrequently: true });
  to.drawImage(image, 0, 0);
  return to.getImageData(0, 0, image.width, image.height).data;
}
"""

_COUNT = f"""
async ([png, colors]) => {{
  const data = await ({_READ})(png);
  const counts = {{ vivid: 0, tinted: 0 }};
  for (const name of Object.keys(colors)) counts[name] = 0;
  const known = Object.entries(colors);
  const ground = colors.panel;
  const greys = known.filter(([name]) => name !== "panel").map(([, color]) => color);
  const isBetween = (pixel, grey) => {{
    const [along, from] = [grey.map((part, i) => part - ground[i]), pixel.map((part, i) => part - ground[i])];
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const share = Math.min(1, Math.max(0, dot(along, from) / dot(along, along)));
    return Math.hypot(...from.map((part, i) => part - share * along[i])) < 12;
  }};
  for (let at = 0; at < data.length; at += 4) {{
    const red = data[at];
    const green = data[at + 1];
    const blue = data[at + 2];
    const pixel = [red, green, blue];
    if (!greys.some((grey) => isBetween(pixel, grey))) {{
      const spread = Math.max(red, green, blue) - Math.min(red, green, blue);
      counts[spread > 60 ? "vivid" : "tinted"] += 1;
      continue;
    }}
    let [best, nearest] = [null, Infinity];
    for (const [name, [r, g, b]] of known) {{
      const distance = (red - r) ** 2 + (green - g) ** 2 + (blue - b) ** 2;
      if (distance < nearest) [best, nearest] = [name, distance];
    }}
    counts[best] += 1;
  }}
  return counts;
}}
"""

_DIFFER = f"""
async ([one, other]) => {{
  const [a, b] = [await ({_READ})(one), await ({_READ})(other)];
  if (a.length !== b.length) return Infinity;
  let count = 0;
  for (let at = 0; at < a.length; at += 4) {{
    if (Math.abs(a[at] - b[at]) + Math.abs(a[at + 1] - b[at + 1]) + Math.abs(a[at + 2] - b[at + 2]) > 30) count += 1;
  }}
  return count;
}}
"""

_COLORS = """
(names) => {
  const style = getComputedStyle(document.documentElement);
  const parts = (css) => [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16));
  return Object.fromEntries(names.map((name) => [name, parts(style.getPropertyValue(`--${name}`).trim())]));
}
"""


@dataclass
class Picture:
    """A screenshot of an element, and its counts."""

    png: str
    panel: int
    point: int
    edge: int
    ink: int
    vivid: int
    tinted: int


class PictureReader:
    """Takes screenshots of pages, and counts their pixels in a page of its own."""

    def __init__(self, own: Page) -> None:
        self._own = own

    def screenshot(self, page: Page, element: str) -> str:
        """A screenshot of an element, as PNG in base64."""
        return base64.b64encode(page.locator(element).screenshot()).decode()

    def count(self, page: Page, png: str) -> Picture:
        """The counts of a screenshot, by the colours of its page."""
        counts = self._own.evaluate(_COUNT, [png, page.evaluate(_COLORS, NAMES)])
        return Picture(png, **counts)

    def difference(self, one: Picture, other: Picture) -> float:
        """The number of pixels that differ."""
        count: float = self._own.evaluate(_DIFFER, [one.png, other.png])
        return count
