"""Metres on the paper as pixels of a picture."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from reports.film.drawing import Drawing

WIDTH = 480  # pixels of a picture
MOST_HEIGHT = 480
MARGIN = 0.06  # of the scene's size, m, around what moves
PAPER, INK, SPRING, SURFACE, ROUND = "#ffffff", "#1f4e79", "#c8502d", "#444444", "#b9cde0"


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
            (scenery.springs, SPRING, 1),
            (scenery.spokes, INK, 3),
        ):
            for line in lines:
                pen.line((self(line[k, 0]), self(line[k, 1])), fill=colour, width=width)
        for centre in scenery.centres[k]:
            x, y = self(centre)
            pen.ellipse((x - 2, y - 2, x + 2, y + 2), fill=INK)
        pen.text((6, 4), f"t = {scenery.times[k]:.3f} s", fill=SURFACE)
        pen.text((6, 18), label, fill=INK)
        return image
