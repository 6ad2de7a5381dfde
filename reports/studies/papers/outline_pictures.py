"""Crash occupants drawn as bodies: the outlines of their parts, the seat's cushions and the floor."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbs_ref import scenes
from mbs_ref.crash.outlines import Capsule, outlines
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import CircleOnLine
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.studies.papers.facts import Moment, Outline

PICTURES = 8  # 0.025 s apart
ARMS = ("upper_arm", "lower_arm", "hand")
BELIEVABLE: dict[str, Any] = {"stops": True, "body_contacts": True}
DRAWN: dict[str, tuple[str, dict[str, Any]]] = {
    "48 bodies, front, bare": ("vertebral", {}),
    "48 bodies, front, stops and contacts": ("vertebral", BELIEVABLE),
    "13 bodies, rear, bare": ("simplified", {"impact": "rear"}),
    "13 bodies, rear, stops and contacts": ("simplified", {"impact": "rear", **BELIEVABLE}),
    "13 bodies, rear, no head restraint": ("simplified", {"impact": "rear", "head_restraint": "none", **BELIEVABLE}),
}
RUN = Settings(rtol=1e-7, samples=PICTURES + 1, estimate="off", reactions=False)


def outline_pictures() -> dict[str, tuple[Moment, ...]]:
    """Return the crashes that bare and believable models are told apart by."""
    return {title: _moments(scenes.make(f"android_{kind}", **more)) for title, (kind, more) in DRAWN.items()}


def _moments(scene: Scene) -> tuple[Moment, ...]:
    path = simulate(scene, RUN)
    motion = Motion(scene, path)
    shapes = outlines(scene.name)
    ends = {shape.body: [motion.point(shape.body, end)[0] for end in shape.ends] for shape in shapes}
    seats = {
        part.body_b: [motion.point(part.body_b, end)[0] for end in (part.point_1, part.point_2)]
        for part in scene.contacts
        if isinstance(part, CircleOnLine) and part.body_b.startswith("seat") and ".restraint." not in part.name
    }
    moments = []
    for k in range(1, len(path.times)):
        cushions = [Outline("seat", _point(p[k]), _point(q[k]), 0.0) for p, q in seats.values()]
        parts = [_part(shape, ends[shape.body][0][k], ends[shape.body][1][k]) for shape in shapes]
        moments.append(Moment(float(path.times[k]), (*cushions, *parts)))
    return tuple(moments)


def _part(shape: Capsule, start: np.ndarray, end: np.ndarray) -> Outline:
    return Outline("arm" if shape.body in ARMS else "body", _point(start), _point(end), shape.radius)


def _point(place: np.ndarray) -> tuple[float, float]:
    return round(float(place[0]), 4), round(float(place[1]), 4)
