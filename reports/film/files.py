"""Pictures of a motion as files: a GIF or an MP4 that plays it, a filmstrip of moments (Fox 1999, Figs. 1 and 2)."""

import base64
import importlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Template
from PIL import Image

from mbs_ref import Scene, Trajectory
from reports.film.camera import PAPER, Camera, clock
from reports.film.drawing import drawing

PLAYER = Path(__file__).parent / "player.html"
COLOURS = 32  # of a picture
SMOOTH = 30  # pictures a second of an MP4 at most: more are not seen


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
    shown = [base64.b64encode(_png(picture.quantize(COLOURS))).decode() for picture in pictures]
    whole = Template(PLAYER.read_text(encoding="utf-8"), autoescape=True).render(
        title=title, width=pictures[0].width, pictures=shown,
        times=[clock(float(t), float(times[-1])) for t in times], pause=round(1000.0 * seconds / len(pictures)),
    )  # fmt: skip
    return whole.encode()


def _png(picture: Image.Image) -> bytes:
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
    camera = Camera(scenery)
    wide, high = camera.size
    columns = min(count, 4)
    sheet = Image.new("RGB", (wide * columns, high * -(-count // columns)), PAPER)
    picks = np.linspace(0, len(scenery.times) - 1, count, endpoint=False).round().astype(int)
    for place, k in enumerate(picks):
        sheet.paste(camera.picture(scenery, int(k)), (wide * (place % columns), high * (place // columns)))
    return _png(sheet)
