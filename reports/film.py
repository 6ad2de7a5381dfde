"""Pictures of a motion: a GIF that plays it, and a filmstrip of moments (Fox 1999, Figs. 1 and 2).

Any scene, planar or spatial: bodies are drawn as spokes from the centre of mass to whatever is attached
to them; circles and surfaces of contact as they are. Space is seen along (1, 1, 1).
"""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import GROUND, CoordinateDrive, Scene
from mbs_ref.scene.base.directions import normals, unit
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, SphereOnPlane, SphereOnSphere
from mbs_ref.trajectory import Trajectory

WIDTH = 480  # pixels of a picture
MOST_HEIGHT = 480
MARGIN = 0.06  # of the scene's size, m, around what moves
PAPER, INK, SPRING, SURFACE, ROUND = "#ffffff", "#1f4e79", "#c8502d", "#444444", "#b9cde0"
ISOMETRIC = np.array([[-1.0, 1.0, 0.0], [-0.5, -0.5, 1.0]]) / np.array([[2.0**0.5], [1.5**0.5]])


@dataclass(frozen=True)
class Drawing:
    """What is drawn at every sample, in metres on the paper."""

    spokes: list[np.ndarray]  # (n_t, 2, 2) from a centre of mass to an attachment
    springs: list[np.ndarray]  # (n_t, 2, 2)
    surfaces: list[np.ndarray]  # (n_t, 2, 2)
    circles: list[tuple[np.ndarray, float]]  # (n_t, 2) and radius; spheres, which look the same from everywhere
    centres: np.ndarray  # (n_t, n_bodies, 2)
    times: np.ndarray  # (n_t,) s


def drawing(scene: Scene, trajectory: Trajectory) -> Drawing:
    """Follow every mark of a scene along its motion."""
    motion = Motion(scene, trajectory)
    centres = _on_paper(trajectory.position)
    spokes, springs = [], []
    for part in (*scene.joints, *scene.loads):
        ends = _marks(part)
        places = [_on_paper(motion.point(body, mark)[0]) for body, mark in ends]
        for (body, _), place in zip(ends, places, strict=True):
            if body != GROUND:
                spokes.append(np.stack((centres[:, scene.body_index(body)], place), axis=1))
        if len(places) == 2 and part in scene.loads:
            springs.append(np.stack(places, axis=1))
    surfaces, circles = _contacts(motion)
    surfaces = [_on_paper(surface) for surface in surfaces]
    circles = [(_on_paper(place), radius) for place, radius in circles]
    return Drawing(spokes, springs, surfaces, circles, centres, trajectory.times)


def _marks(part) -> list[tuple[str, tuple[float, ...]]]:
    """Return the bodies and world points (t = 0) that a joint or load ties together."""
    if isinstance(part, CoordinateDrive):
        return []
    shared = getattr(part, "point", None)
    found = []
    for body, mark in (("body_a", "point_a"), ("body_b", "point_b"), ("body", "point")):
        name, place = getattr(part, body, None), getattr(part, mark, None) or shared
        if name is not None and place is not None:
            found.append((name, place))
    return found


def _contacts(motion: Motion) -> tuple[list[np.ndarray], list[tuple[np.ndarray, float]]]:
    surfaces, circles = [], []
    for contact in motion.scene.contacts:
        if isinstance(contact, CircleOnLine):
            circles.append((motion.point(contact.body_a, contact.center)[0], contact.radius))
            ends = [motion.point(contact.body_b, end)[0] for end in (contact.point_1, contact.point_2)]
            surfaces.append(np.stack(ends, axis=1))
        elif isinstance(contact, SphereOnPlane):
            circles.append((motion.point(contact.body_a, contact.center)[0], contact.radius))
            surfaces += _sides(motion, contact)
        elif isinstance(contact, CircleOnCircle | SphereOnSphere):
            circles.append((motion.point(contact.body_a, contact.center_a)[0], contact.radius_a))
            circles.append((motion.point(contact.body_b, contact.center_b)[0], contact.radius_b))
    return surfaces, circles


def _sides(motion: Motion, contact: SphereOnPlane) -> list[np.ndarray]:
    """Return the four sides of a rectangle; of a plane, of the part under the sphere's path."""
    edge = normals(contact.normal)[0] if contact.edge is None else unit(contact.edge)
    across = np.cross(unit(contact.normal), edge)
    middle, half = np.array(contact.point), np.ones(2)
    if contact.size is not None:
        half = 0.5 * np.array(contact.size)
    else:
        path = motion.point(contact.body_a, contact.center)[0] - middle
        along = np.stack((path @ edge, path @ across), axis=1)
        low, high = along.min(axis=0) - 2.0 * contact.radius, along.max(axis=0) + 2.0 * contact.radius
        middle, half = middle + np.array((edge, across)).T @ (0.5 * (low + high)), 0.5 * (high - low)
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    corners = [tuple(middle + p * half[0] * edge + q * half[1] * across) for p, q in signs]
    places = [motion.point(contact.body_b, corner)[0] for corner in corners]
    return [np.stack((places[k - 1], places[k]), axis=1) for k in range(4)]


def _on_paper(place: np.ndarray) -> np.ndarray:
    """Return (..., 2) of (..., 2) or, seen from (1, 1, 1), of (..., 3)."""
    return place if place.shape[-1] == 2 else place @ ISOMETRIC.T


class Camera:
    """Turns metres on the paper into pixels; one frame holds the whole motion."""

    def __init__(self, scenery: Drawing) -> None:
        seen = [scenery.centres.reshape(-1, 2), *(s.reshape(-1, 2) for s in scenery.spokes)]
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

    def picture(self, scenery: Drawing, k: int) -> Image.Image:
        """Draw sample k."""
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
        return image


def gif(scene: Scene, trajectory: Trajectory, seconds: float = 4.0) -> bytes:
    """Return a GIF of every sample that plays for `seconds`, whatever the run's own duration."""
    scenery = drawing(scene, trajectory)
    camera = Camera(scenery)
    pictures = [camera.picture(scenery, k) for k in range(len(scenery.times))]
    palette = pictures[0].quantize(16)  # every picture has the same few colours
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    buffer = io.BytesIO()
    pause = max(round(1000.0 * seconds / len(frames)), 20)  # ms; players slow anything quicker down
    frames[0].save(buffer, "GIF", save_all=True, append_images=frames[1:], duration=pause, loop=0)
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
    buffer = io.BytesIO()
    sheet.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
