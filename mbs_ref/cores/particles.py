"""A scene of particles compiled: three coordinates a body, no constraints, and the arrays of the fields it uses."""

import itertools
from typing import Any, get_args

import numpy as np

from mbs_ref.cores.system import Poses, System
from mbs_ref.kernels.border.groups import absent, declared, floats, ints
from mbs_ref.kernels.particles import model as arrays
from mbs_ref.kernels.particles.model import particle_scratch
from mbs_ref.scene import Scene, celestial
from mbs_ref.scene.base.part import normals
from mbs_ref.scene.scales import Scales, free_fall_time

_FORMS = {"central": 1, "eih": 2}
_SOURCES = {"sun": 0, "moon": 1}
_AIRS = {celestial.Drag: arrays.EXPONENTIAL, celestial.StandardDrag: arrays.STANDARD}
PROFILE = ("density", "altitude", "scale_height")  # of an exponential atmosphere


def build_particles(scene: Scene) -> arrays.ParticleGroups:
    """Compile a scene of particles; ValueError where a part contradicts another."""
    place = scene.body_index
    by_kind: dict[type, list[Any]] = {kind: [] for kind in get_args(celestial.CelestialLoad)}
    for load in scene.loads:
        by_kind[type(load)].append(load)
    zonals, rings, third = by_kind[celestial.Oblateness], by_kind[celestial.Ring], by_kind[celestial.ThirdBody]
    drags = [*by_kind[celestial.Drag], *by_kind[celestial.StandardDrag]]
    lights, relativity = by_kind[celestial.RadiationPressure], celestial.at_most_one(by_kind[celestial.Relativity])

    def columns(group: type, parts: list[Any], **own: list[Any]) -> Any:
        """Return a group: an array of each field of the parts, where a body's index replaces its name, and `own`."""
        if not parts:
            return absent(group)
        values = {name: own[name] if name in own else [getattr(x, name) for x in parts] for name in declared(group)}
        numbers = {name: [place(x) if isinstance(x, str) else x for x in column] for name, column in values.items()}
        return group(**{
            name: np.array(numbers[name], array.dtype).reshape(len(parts), *array.shape[1:])
            for name, array in declared(group).items()
        })  # fmt: skip

    return arrays.ParticleGroups(
        particles=_particles(scene, by_kind),
        relativity=arrays.RelativityArrays(
            ints([_FORMS[relativity.form] if relativity else 0]), floats([relativity.c**-2 if relativity else 0.0])
        ),
        zonals=columns(
            arrays.Zonals, zonals, precesses=[x.pole != "fixed" for x in zonals],
            harmonic=[(*x.zonal, *(0.0,) * (5 - len(x.zonal))) for x in zonals],
        ),
        figures=columns(arrays.Figures, by_kind[celestial.LunarFigure]),
        tides=columns(arrays.Tides, by_kind[celestial.Tide]),
        points=arrays.Points(
            floats([x.gm / x.count for x in rings for _ in range(x.count)]),
            np.concatenate([np.zeros((0, 3)), *map(_circle, rings)]),
        ),
        third_bodies=columns(arrays.ThirdBodies, third, source=[_SOURCES[x.source] for x in third]),
        drags=columns(
            arrays.Drags, drags, air=[_AIRS[type(x)] for x in drags],
            number=[(x.coefficient, *(getattr(x, name, 0.0) for name in PROFILE), x.radius, x.spin) for x in drags],
        ),
        lights=columns(arrays.Lights, lights, number=[(x.coefficient, x.radius, x.pressure) for x in lights]),
    )  # fmt: skip


def _particles(scene: Scene, by_kind: dict[type, list[Any]]) -> arrays.Particles:
    n = len(scene.bodies)
    newton, epoch = celestial.at_most_one(by_kind[celestial.Newton]), celestial.at_most_one(by_kind[celestial.Epoch])
    gm = np.array(newton.gm if newton else np.zeros(n), dtype=float)
    radius = np.array(newton.radius if newton and newton.radius else np.zeros(n), dtype=float)
    if len(gm) != n or len(radius) != n:
        got = f"{len(gm)}, {len(radius)}"
        raise ValueError(f"load {newton.name!r}: gm and radius need {n} entries, one a body; got {got}")
    velocity = (celestial.Relativity, celestial.Tide, celestial.Drag, celestial.StandardDrag)
    seconds = (epoch.jd_tdb - celestial.J2000_JD) * celestial.DAY_S if epoch else 0.0
    return arrays.Particles(
        gm, radius, np.array(scene.gravity, dtype=float), np.array([seconds]),
        ints([int(any(by_kind[kind] for kind in velocity))]),
    )  # fmt: skip


def _circle(part: celestial.Ring) -> np.ndarray:
    first, second = normals(part.normal)
    angle = 2.0 * np.pi * np.arange(part.count) / part.count
    return -part.radius * (np.outer(np.cos(angle), first) + np.outer(np.sin(angle), second))


class ParticleSystem(System):
    """Particles in space as arrays and compiled functions.

    State y = concatenate(q.ravel(), v.ravel()) with q, v of shape (n_bodies, 3): m, m/s. Raises ValueError
    where two bodies that attract each other are at one place, or start inside each other.
    """

    CORE = "particles"

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.n_bodies = len(scene.bodies)
        self._set_arrays(build_particles(scene))
        self._refuse_coincidence()

    def _new_scratch(self) -> Any:
        return particle_scratch(self.n_bodies)

    def _refuse_coincidence(self) -> None:
        particles = self.groups.particles
        for i, j in itertools.combinations(range(self.n_bodies), 2):
            gap = float(np.linalg.norm(np.subtract(self.scene.bodies[i].position, self.scene.bodies[j].position)))
            names = f"bodies {self.scene.bodies[i].name!r} and {self.scene.bodies[j].name!r}"
            if gap == 0.0 and max(particles.gm[i], particles.gm[j]) > 0.0:
                raise ValueError(f"{names} coincide at t = 0; their attraction is infinite")
            if gap < particles.radius[i] + particles.radius[j]:
                raise ValueError(f"{names} overlap at t = 0: {gap:.6g} m apart, less than the sum of their radii")

    def initial_state(self) -> np.ndarray:
        q = [body.position for body in self.scene.bodies]
        v = [body.velocity for body in self.scene.bodies]
        return np.concatenate((np.ravel(q), np.ravel(v))).astype(float)

    @staticmethod
    def state_units(scene: Scene, scales: Scales) -> np.ndarray:
        """Return L for every position and L / T for every velocity (6 n_bodies,).

        T is the free-fall time over L, where bodies are closer than L at the start, too.
        """
        time = free_fall_time(scene, scales.length)
        return np.repeat([scales.length, scales.length / time], 3 * len(scene.bodies))

    def poses(self, states: np.ndarray) -> Poses:
        n = self.n_bodies
        q, v = np.moveaxis(states.reshape(len(states), 2, n, 3), 1, 0)
        turn = np.zeros((len(states), n, 4))
        turn[:, :, 0] = 1.0
        return Poses(q, turn, v, np.zeros_like(v))

    def states_of(self, poses: Poses) -> np.ndarray:
        count = len(poses.position)
        return np.concatenate((poses.position.reshape(count, -1), poses.velocity.reshape(count, -1)), axis=1)


def nearest(scene: Scene, y: np.ndarray) -> str:
    """Return a sentence on the two bodies nearest to each other."""
    q = y[: len(y) // 2].reshape(-1, 3)
    if len(q) < 2:
        return "one body alone"
    gap = np.linalg.norm(q[:, None] - q[None], axis=2) + np.diag(np.full(len(q), np.inf))
    i, j = np.unravel_index(int(np.argmin(gap)), gap.shape)
    names = scene.body_names
    return f"{names[min(i, j)]!r} and {names[max(i, j)]!r} are {gap[i, j]:.6g} m apart"
