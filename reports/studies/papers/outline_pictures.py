"""Crash occupants drawn as bodies: the outlines of their parts, the seat's cushions and the floor."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbs_ref import scenes
from mbs_ref.crash.outlines import outlines
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import CircleOnLine
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.facts.curves import Row
from reports.studies.crash import BELIEVABLE

PICTURES = 8  # 0.025 s apart
ARMS = ("upper_arm", "lower_arm", "hand")
DRAWN: dict[str, tuple[str, dict[str, Any]]] = {
    "48 bodies, front, bare": ("vertebral", {}),
    "48 bodies, front, stops and contacts": ("vertebral", BELIEVABLE),
    "13 bodies, rear, bare": ("simplified", {"impact": "rear"}),
    "13 bodies, rear, stops and contacts": ("simplified", {"impact": "rear", **BELIEVABLE}),
    "13 bodies, rear, no head restraint": ("simplified", {"impact": "rear", "head_restraint": "none", **BELIEVABLE}),
}
# a shape: time (s), kind (body | arm | seat), both ends and the radius (m)
RUN = Settings(rtol=1e-7, samples=PICTURES + 1, estimate="off", reactions=False)


def outline_pictures() -> dict[str, tuple[Row, ...]]:
    """Return the crashes in which bare and believable models differ: the lines to draw at each time."""
    made = {title: scenes.make(f"android_{kind}", **more) for title, (kind, more) in DRAWN.items()}
    return {f"outlines: {title}": _moments(scene) for title, scene in made.items()}


def _moments(scene: Scene) -> tuple[Row, ...]:
    path = simulate(scene, RUN)
    motion = Motion(scene, path)
    shapes = outlines(scene.name)
    ends = {shape.body: [motion.point(shape.body, end)[0] for end in shape.ends] for shape in shapes}
    seats = {
        part.body_b: [motion.point(part.body_b, end)[0] for end in (part.point_1, part.point_2)]
        for part in scene.contacts
        if isinstance(part, CircleOnLine) and part.body_b.startswith("seat") and ".restraint." not in part.name
    }
    shown: list[Row] = []
    for k, time in enumerate(map(float, path.times[1:]), 1):
        shown += [_line(time, "seat", p[k], q[k], 0.0) for p, q in seats.values()]
        for shape in shapes:
            start, end = (place[k] for place in ends[shape.body])
            shown.append(_line(time, "arm" if shape.body in ARMS else "body", start, end, shape.radius))
    return tuple(shown)


def _line(time: float, kind: str, start: np.ndarray, end: np.ndarray, radius: float) -> Row:
    (x1, y1), (x2, y2) = (tuple(round(float(x), 4) for x in place[:2]) for place in (start, end))
    return {"time": time, "kind": kind, "x1": x1, "y1": y1, "x2": x2, "y2": y2, "radius": radius}
