"""Pictures of a motion as files: a GIF or an MP4 that plays it, a filmstrip of moments (Fox 1999, Figs. 1 and 2)."""

import base64
import importlib
import io
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Template
from PIL import Image, ImageDraw, ImageFont

from mbs_ref import Scene, Trajectory
from reports.film.drawing import Drawing, drawing

WIDEST, HIGHEST = 960, 540  # pixels of a picture ...
SIDE = 480  # ... and of the square that has its area
STRIP = 1120  # pixels of a row of a filmstrip at most: a page shows it as it is, with words that can be read
FINE = 2  # times as many pixels are drawn, then averaged
MARGIN = 0.06  # of the scene's size, m, around what moves
PAPER, INK, SPRING, SURFACE, ROUND = "#ffffff", "#1f4e79", "#c8502d", "#444444", "#9db7cf"
FILL, ACCENT, ACCENT_FILL = "#dbe7f2", "#d97706", "#f6d9b0"
FONT = 11  # pixels
PIN = 8  # pixels of the triangle of a joint on the ground
COIL, COILS = 5, 6  # pixels of a spring's half width, and its turns
SPANS = ((31557600.0, "years"), (86400.0, "days"), (3600.0, "h"))  # s; a Julian year
LONGEST_BAR = 0.3  # of the picture
BESIDE = 5  # pixels between a body and its name
UNITS = ((1.495978707e11, "au"), (1e3, "km"), (1.0, "m"), (1e-3, "mm"))  # m; au: IAU 2012, rounded
PLAYER = Path(__file__).parent / "player.html"
COLOURS = 32  # of a picture
SMOOTH = 30  # pictures a second of an MP4 at most: more are not seen


class Camera:
    """Turns metres on the paper into pixels; one frame holds the whole motion, of several runs if there are."""

    def __init__(self, *sceneries: Drawing, widest: float = WIDEST) -> None:
        seen: list[np.ndarray] = []
        for scenery in sceneries:
            seen += [scenery.centres.reshape(-1, 2), *(line.reshape(-1, 2) for _, line in scenery.spokes)]
            for place, radius in scenery.circles:
                seen += [place - radius, place + radius]
        points = np.concatenate(seen)
        low, high = points.min(axis=0), points.max(axis=0)
        size = float(max(*(high - low), 1e-9))
        self.low, high = low - MARGIN * size, high + MARGIN * size
        span = high - self.low
        self.scale = min(widest / span[0], HIGHEST / span[1], SIDE / np.sqrt(span[0] * span[1]))
        self.size = (max(int(self.scale * span[0]), 16), max(int(self.scale * span[1]), 16))

    def __call__(self, place: np.ndarray) -> tuple[float, float]:
        x, y = self.scale * (place - self.low)
        return float(FINE * x), float(FINE * (self.size[1] - y))

    def picture(self, scenery: Drawing, k: int, label: str = "") -> Image.Image:
        """Draw sample k, with a label below the time."""
        image = Image.new("RGB", (FINE * self.size[0], FINE * self.size[1]), PAPER)
        pen = ImageDraw.Draw(image)
        pen.font = ImageFont.load_default(FINE * FONT)
        self._bodies(pen, scenery, k)
        self._orbits(pen, scenery, k)
        # a bar of a round length
        wide, high = self.size
        length, sentence = round_length(LONGEST_BAR * wide / self.scale)
        y, end = FINE * (high - 6), FINE * (wide - 8)
        pen.line((end - FINE * length * self.scale, y, end, y), fill=SURFACE, width=FINE)
        pen.text((end, y - 2 * FINE), sentence, fill=SURFACE, anchor="rb")
        pen.text((6 * FINE, 4 * FINE), f"t = {clock(scenery.times[k], scenery.times[-1])}", fill=SURFACE)
        pen.text((6 * FINE, 18 * FINE), label, fill=INK)
        return image.reduce(FINE)

    def _bodies(self, pen: ImageDraw.ImageDraw, scenery: Drawing, k: int) -> None:
        for pin in scenery.pins:
            x, y = self(pin[k])
            pen.polygon([(x, y), (x - FINE * PIN, y + FINE * PIN), (x + FINE * PIN, y + FINE * PIN)], fill=ROUND)
        for body, corners in scenery.fills:
            fill = ACCENT_FILL if body == scenery.accent else FILL
            pen.polygon([self(corner) for corner in corners[k]], fill=fill)
        for place, radius in scenery.circles:
            pen.circle(self(place[k]), FINE * self.scale * radius, outline=ROUND, width=FINE)
        for lines, colour, width in ((scenery.surfaces, SURFACE, 2), (scenery.radii, INK, 1)):
            for line in lines:
                self._line(pen, line[k], colour, width)
        for line in scenery.springs:
            pen.line(coil(*map(self, line[k])), fill=SPRING, width=FINE)
        for body, line in scenery.spokes:
            self._line(pen, line[k], ACCENT if body == scenery.accent else INK, 3)
        for centre in scenery.centres[k]:
            pen.circle(self(centre), 2 * FINE, fill=INK)

    def _line(self, pen: ImageDraw.ImageDraw, ends: np.ndarray, colour: str, width: int) -> None:
        pen.line((self(ends[0]), self(ends[1])), fill=colour, width=FINE * width)

    def _orbits(self, pen: ImageDraw.ImageDraw, scenery: Drawing, k: int) -> None:
        """Draw the whole path of bodies that only a name distinguishes, and those names that hide no other."""
        taken: list[tuple[float, ...]] = []
        for body in scenery.labels:
            pen.line([self(place) for place in scenery.orbits[:, body]], fill=ROUND, width=FINE)
        for body, label in scenery.labels.items():
            x, y = self(scenery.centres[k, body])
            x = min(x + FINE * BESIDE, FINE * self.size[0] - pen.textlength(label))
            box = pen.textbbox((x, y - 2 * FINE * BESIDE), label)
            if not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken):
                pen.text(box[:2], label, fill=SURFACE, anchor="la")
                taken.append(box)


def coil(start: tuple[float, float], end: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the zigzag of a spring between two places, in pixels."""
    one, two = np.array(start), np.array(end)
    along = (two - one) / max(np.hypot(*(two - one)), 1e-9)
    across = FINE * COIL * np.array((-along[1], along[0]))
    turns = [one + (two - one) * (k + 0.5) / (2 * COILS) + (-1) ** k * across for k in range(2 * COILS)]
    return [tuple(place) for place in (one, *turns, two)]


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


def beside(scene: Scene, runs: Mapping[str, Trajectory]) -> list[Image.Image]:
    """Return a picture a sample, with runs of one scene at the same times side by side under their labels."""
    sceneries = {label: drawing(scene, path) for label, path in runs.items()}
    camera = Camera(*sceneries.values())
    wide, high = camera.size
    pictures = []
    for k in range(min(len(scenery.times) for scenery in sceneries.values())):
        sheet = Image.new("RGB", (wide * len(sceneries), high), PAPER)
        for place, (label, scenery) in enumerate(sceneries.items()):
            sheet.paste(camera.picture(scenery, k, label if len(sceneries) > 1 else ""), (wide * place, 0))
        pictures.append(sheet)
    return pictures


def gif(scene: Scene, trajectory: Trajectory, seconds: float = 4.0) -> bytes:
    """Return a GIF of every sample that plays for `seconds`, whatever the run's own duration."""
    return as_gif(beside(scene, {"": trajectory}), seconds)


def as_gif(pictures: list[Image.Image], seconds: float) -> bytes:
    """Return a GIF of pictures that plays for `seconds`."""
    palette = pictures[0].quantize(COLOURS)  # every picture has the same few colours
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    buffer = io.BytesIO()
    pause = max(round(1000.0 * seconds / len(frames)), 20)  # ms; players slow anything quicker down
    frames[0].save(buffer, "GIF", save_all=True, append_images=frames[1:], duration=pause, loop=0)
    return buffer.getvalue()


def as_page(title: str, pictures: list[Image.Image], times: np.ndarray, seconds: float) -> bytes:
    """Return an HTML page that plays pictures of `times` (s) for `seconds`, stops, and goes to any of them."""
    shown = [base64.b64encode(png(picture.quantize(COLOURS))).decode() for picture in pictures]
    whole = Template(PLAYER.read_text(encoding="utf-8"), autoescape=True).render(
        title=title, width=pictures[0].width, pictures=shown,
        times=[clock(float(t), float(times[-1])) for t in times], pause=round(1000.0 * seconds / len(pictures)),
    )  # fmt: skip
    return whole.encode()


def png(picture: Image.Image) -> bytes:
    """Return a PNG of a picture, as small as it gets."""
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def video_library() -> Any:
    """Return what encodes an MP4; ImportError with what to install."""
    try:
        return importlib.import_module("av")
    except ModuleNotFoundError as error:
        if error.name != "av":
            raise
        raise ImportError("MP4 needs the package av: pip install 'mbs-ref[film]'; a .gif needs nothing") from error


def as_mp4(pictures: list[Image.Image], seconds: float, av: Any) -> bytes:
    """Return an MP4 (H.264) of pictures that plays for `seconds`; `av` is the video library."""
    rate = min(SMOOTH, max(1, round(len(pictures) / seconds)))
    shown = np.linspace(0, len(pictures) - 1, max(1, round(rate * seconds))).round().astype(int)
    wide, high = (length - length % 2 for length in pictures[0].size)  # H.264 takes even lengths alone
    buffer = io.BytesIO()
    with av.open(buffer, "w", format="mp4") as film:
        stream = film.add_stream("h264", rate=rate)
        stream.width, stream.height, stream.pix_fmt = wide, high, "yuv420p"
        for k in shown:
            film.mux(stream.encode(av.VideoFrame.from_image(pictures[k].crop((0, 0, wide, high)))))
        film.mux(stream.encode())
    return buffer.getvalue()


def filmstrip(scene: Scene, trajectory: Trajectory, count: int = 8) -> bytes:
    """Return a PNG of `count` pictures in rows of four, a `count`-th of the run apart from t = 0 on."""
    scenery = drawing(scene, trajectory)
    columns = min(count, 4)
    camera = Camera(scenery, widest=STRIP / columns)
    wide, high = camera.size
    sheet = Image.new("RGB", (wide * columns, high * -(-count // columns)), PAPER)
    picks = np.linspace(0, len(scenery.times) - 1, count, endpoint=False).round().astype(int)
    for place, k in enumerate(picks):
        sheet.paste(camera.picture(scenery, int(k)), (wide * (place % columns), high * (place // columns)))
    return png(sheet)
