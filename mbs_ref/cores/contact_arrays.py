"""Contact laws, friction and modes of a scene -> the arrays that every core's contacts share."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbs_ref.kernels.contact import laws as shared
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import FrictionNumbers
from mbs_ref.scene.scales import scales_of

NOISE = 1e-13  # of the scene's size in metres (at least 1 m): above what roundoff and projection leave of a gap
SLOW = 1e-8  # of the scene's speed, about eps^(1/2)
MOST_LOGGED = 100_000  # events of one run whose modes are kept for output


_RELEASES = {
    "gap": shared.RELEASE_GAP, "force": shared.RELEASE_FORCE, "rigid": shared.RELEASE_RIGID,
    "constraint": shared.RELEASE_CONSTRAINT,
}  # fmt: skip
_FRICTIONS = {
    "none": shared.FRICTION_NONE, "smooth": shared.FRICTION_SMOOTH, "stick_slip": shared.FRICTION_STICK_SLIP
}  # fmt: skip


def contact_laws(scene: Scene, slots: dict[int, int]) -> shared.ContactLaws:
    """Return the laws and frictions; `slots` holds the row of each constraint contact, by its place."""
    laws = [part.law.numbers() for part in scene.contacts]
    frictions = [part.friction.numbers() if part.friction else FrictionNumbers() for part in scene.contacts]
    numbers = [law._asdict() | friction._asdict() for law, friction in zip(laws, frictions, strict=True)]
    coded = {
        "release": [_RELEASES[law.release] for law in laws],
        "friction": [_FRICTIONS[friction.kind] for friction in frictions],
        "slot": [slots.get(k, -1) for k in range(len(laws))],
    }
    arrays: dict[str, Any] = {name: np.array(values, dtype=np.int64) for name, values in coded.items()}
    plain = (name for name in shared.ContactLaws._fields if name not in coded)
    arrays |= {name: np.array([row[name] for row in numbers], dtype=float) for name in plain}
    return shared.ContactLaws(**arrays)


def contact_noise(scene: Scene) -> float:
    """Return how far (m, m/s) beyond its root an event function must be."""
    return NOISE * max([1.0, *(abs(x) for body in scene.bodies for x in body.position)])


def contact_modes(scene: Scene, count: int) -> shared.ContactModes:
    """Return `count` modes before a run has settled them."""
    slow = SLOW * scales_of(scene).speed if count else 0.0  # the scales take as long as the rest
    return shared.fresh_modes(count, contact_noise(scene), slow, MOST_LOGGED, scene.dimension)
