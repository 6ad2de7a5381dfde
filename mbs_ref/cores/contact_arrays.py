"""Contact laws, friction and modes of a scene -> the arrays that every core's contacts share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbs_ref.kernels.contact import laws as shared
from mbs_ref.scene import Scene
from mbs_ref.scene.contact import (
    ConstraintLaw,
    FloresLaw,
    HuntCrossleyLaw,
    LankaraniNikraveshLaw,
    ProgressiveLaw,
    RegularisedCoulomb,
    RigidLaw,
    SpringDamperLaw,
    StickSlip,
)

NOISE = 1e-13  # of the scene's size in metres (at least 1 m): above what roundoff and projection leave of a gap
MOST_LOGGED = 100_000  # events of one run whose modes are kept for output


@dataclass(frozen=True)
class _Law:
    """One row of ContactLaws without friction."""

    stiffness: float = 0.0
    damping: float = 0.0
    exponent: float = 1.0
    damping_exponent: float = 0.0
    impact_damping: float = 0.0
    slowest: float = 1.0
    release: int = shared.RELEASE_GAP
    restitution: float = 0.0


def _spring_damper(law: SpringDamperLaw) -> _Law:
    release = shared.RELEASE_FORCE if law.release == "force" else shared.RELEASE_GAP
    return _Law(law.stiffness, law.damping, release=release)


def _by_impact_speed(law: Any, factor: float) -> _Law:
    return _Law(law.stiffness, 0.0, law.exponent, law.exponent, factor, law.slowest)


_LAWS: dict[type, Any] = {
    SpringDamperLaw: _spring_damper,
    ProgressiveLaw: lambda law: _Law(law.stiffness, law.damping, 1.0, 1.0),
    HuntCrossleyLaw: lambda law: _Law(law.stiffness, law.damping, law.exponent, law.exponent),
    LankaraniNikraveshLaw: lambda law: _by_impact_speed(law, 0.75 * (1.0 - law.restitution**2)),
    FloresLaw: lambda law: _by_impact_speed(law, 1.6 * (1.0 - law.restitution) / law.restitution),
    RigidLaw: lambda law: _Law(release=shared.RELEASE_RIGID, restitution=law.restitution),
    ConstraintLaw: lambda law: _Law(release=shared.RELEASE_CONSTRAINT),
}
_FRICTIONS: dict[type, int] = {
    type(None): shared.FRICTION_NONE,
    RegularisedCoulomb: shared.FRICTION_SMOOTH,
    StickSlip: shared.FRICTION_STICK_SLIP,
}


def contact_laws(scene: Scene, slots: dict[int, int]) -> shared.ContactLaws:
    """Return the laws and frictions; `slots` holds the row of each constraint contact, by its place."""
    laws: list[_Law] = [_LAWS[type(part.law)](part.law) for part in scene.contacts]
    frictions: list[Any] = [part.friction for part in scene.contacts]

    def of_law(field: str) -> np.ndarray:
        return np.array([getattr(law, field) for law in laws], dtype=np.int64 if field == "release" else float)

    def of_friction(field: str, default: float = 0.0) -> np.ndarray:
        values = [getattr(friction, field, default) for friction in frictions]
        return np.array([default if value is None else value for value in values], dtype=float)

    sticking = [isinstance(friction, StickSlip) for friction in frictions]
    static = [f.coefficient if s and f.static is None else getattr(f, "static", 0.0) for f, s in
              zip(frictions, sticking, strict=True)]  # fmt: skip
    return shared.ContactLaws(
        **{name: of_law(name) for name in _Law.__dataclass_fields__},
        friction=np.array([_FRICTIONS[type(friction)] for friction in frictions], dtype=np.int64),
        coefficient=of_friction("coefficient"),
        static=np.array(static, dtype=float),
        creep=of_friction("speed", 1.0),
        grip_stiffness=of_friction("stiffness"),
        grip_damping=of_friction("damping"),
        slot=np.array([slots.get(k, -1) for k in range(len(laws))], dtype=np.int64),
    )


def contact_noise(scene: Scene) -> float:
    """Return how far (m, m/s) beyond its root an event function must be."""
    return NOISE * max([1.0, *(abs(x) for body in scene.bodies for x in body.position)])


def contact_modes(scene: Scene, count: int) -> shared.ContactModes:
    """Return `count` modes before a run has settled them."""
    return shared.fresh_modes(count, contact_noise(scene), MOST_LOGGED, scene.dimension)
