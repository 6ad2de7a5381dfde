"""Metres on the paper as pixels of a picture."""

from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageDraw

from reports.film.drawing import Drawing

WIDTH = 480  # pixels of a picture
MOST_HEIGHT = 480
MARGIN = 0.06  # of the scene's size, m, around what moves
PAPER, INK, SPRING, SURFACE, ROUND = "#ffffff", "#1f4e79", "#c8502d", "#444444", "#b9cde0"
SPANS = ((31557600.0, "years"), (86400.0, "days"))  # s; a Julian year
LONGEST_BAR = 0.3  # of the picture
BESIDE = 5  # pixels between a body and its name
UNITS = ((1.495978707e11, "au"), (1e3, "km"), (1.0, "m"), (1e-3, "mm"))  # m; au: IAU 2012, rounded


class Camera:
    """Turns metres on the paper into pixels; one frame holds the whole motion, of several runs if there are."""

    def __init__(self, *sceneries: Drawing) -> None:
        seen: list[np.ndarray] = []
        for scenery in sceneries:
            seen += [scenery.centres.reshape(-1, 2), *(s.reshape(-1, 2) for s in scenery.spokes)]
            for place, radius in scenery.circles:
                seen += [place - radius, place + radius]
        points = np.concatenate(seen)
        low, high = points.min(axis=0), points.max(axis=0)
        size = float(max(*(high - low), 1e-9))
        self.low, high = low - MARGIN * size, high + MARGIN * size
        span = high - self.low
        self.scale = min(WIDTH / span[0], MOST_HEIGHT / span[1])
        self.size = (max(int(self.scale * span[0]), 16), max(int(self.scale * span[1]), 16))

    def __call__(self, place: np.ndarray) -> tuple[float, float]:
        x, y = self.scale * (place - self.low)
        return float(x), float(self.size[1] - y)

    def picture(self, scenery: Drawing, k: int, label: str = "") -> Image.Image:
        """Draw sample k, with a label below the time."""
        image = Image.new("RGB", self.size, PAPER)
        pen = ImageDraw.Draw(image)
        for place, radius in scenery.circles:
            x, y = self(place[k])
            r = self.scale * radius
            pen.ellipse((x - r, y - r, x + r, y + r), outline=ROUND)
        for lines, colour, width in (
            (scenery.surfaces, SURFACE, 2),
            (scenery.radii, INK, 1),
            (scenery.springs, SPRING, 1),
            (scenery.spokes, INK, 3),
        ):
            for line in lines:
                pen.line((self(line[k, 0]), self(line[k, 1])), fill=colour, width=width)
        self._orbits(pen, scenery, k)
        for centre in scenery.centres[k]:
            x, y = self(centre)
            pen.ellipse((x - 2, y - 2, x + 2, y + 2), fill=INK)
        self._scale(pen)
        pen.text((6, 4), f"t = {clock(scenery.times[k], scenery.times[-1])}", fill=SURFACE)
        pen.text((6, 18), label, fill=INK)
        return image

    def _orbits(self, pen: ImageDraw.ImageDraw, scenery: Drawing, k: int) -> None:
        """Draw the whole way of bodies that are told apart by name, and the names."""
        for body in range(len(scenery.labels)):
            pen.line([self(place) for place in scenery.centres[:, body]], fill=ROUND, width=1)
        for body, label in enumerate(scenery.labels):
            x, y = self(scenery.centres[k, body])
            pen.text((x + BESIDE, y - 2 * BESIDE), label, fill=SURFACE)

    def _scale(self, pen: ImageDraw.ImageDraw) -> None:
        """Draw a bar of a round length below."""
        wide, high = self.size
        length, sentence = round_length(LONGEST_BAR * wide / self.scale)
        y, end = high - 6, wide - 8
        pen.line((end - length * self.scale, y, end, y), fill=SURFACE, width=1)
        pen.text((end, y - 2), sentence, fill=SURFACE, anchor="rb")


def round_length(most: float) -> tuple[float, str]:
    """Return the greatest length up to `most` (m) that is 1, 2 or 5 of a decade of its unit, and what it is called."""
    unit, word = next(((size, name) for size, name in UNITS if most >= size), UNITS[-1])
    decade = 10.0 ** math.floor(math.log10(most / unit))
    lead = max(step for step in (1.0, 2.0, 5.0) if step * decade <= most / unit * (1.0 + 1e-9))
    return lead * decade * unit, f"{lead * decade:g} {word}"


def clock(time: float, end: float) -> str:
    """Return a time (s) in a unit that suits a film which ends at `end` (s)."""
    unit, word = next(((length, name) for length, name in SPANS if end >= 3.0 * length), (1.0, "s"))
    return f"{time / unit:.3f} {word}" if unit == 1.0 else f"{time / unit:.1f} {word}"
