"""Another scene: gravity, a load that is missing, a number off by a factor, an inertia about another point."""

from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np

from cross_checks.trajectory_files.mistakes.case import Case, Hypothesis, vector
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.base.part import Part, is_place
from mbs_ref.scene.euler_parameters import rotation_matrices

MOST = 24  # numbers that are tried one by one; a scene with more has only those of all parts of a kind tried
WORK = 3e5  # right-hand sides times bodies of a run: a scene that takes more is not run again and again
LEAST = 1e-4  # a factor nearer to 1 is no mistake: a number that is copied with four digits is off by less
PARTS = ("bodies", "joints", "loads", "contacts")


def terms(case: Case) -> Iterator[Hypothesis]:
    """Yield changes of the scene that the file's tool may have simulated."""
    scene = case.assumed or case.scene
    if case.work > WORK:
        return
    for load in scene.loads[:MOST]:
        rest = scene.model_copy(update={"loads": tuple(other for other in scene.loads if other is not load)})
        yield _of(rest, f"the file moves as the scene does without the load {load.name!r}")
    yield from (*_gravity(scene), *_inertias(scene), *_factors(scene))


def _of(scene: Scene, said: str) -> Hypothesis:
    return Hypothesis(lambda case, x: case.rerun(assumed=scene), lambda x: said)


def _gravity(scene: Scene) -> Iterator[Hypothesis]:
    own = np.array(scene.gravity)
    size, axes = float(np.linalg.norm(own)), np.eye(scene.dimension)

    def pulled(gravity: np.ndarray) -> Scene:
        return scene.model_copy(update={"gravity": tuple(gravity.tolist())})

    if size:
        yield _of(pulled(0.0 * own), "the file moves as the scene does without gravity")
        for axis in (*axes, *-axes):
            if not np.allclose(size * axis, own):
                yield _of(pulled(size * axis), f"gravity acts along {vector(axis)} in the file")
        yield _factor(lambda x: pulled(x * own), "gravity is")


def _factor(changed: Any, said: str) -> Hypothesis:
    return Hypothesis(
        lambda case, x: case.rerun(assumed=changed(float(x[0]))), lambda x: f"{said} {x[0]:.4g} times the scene's",
        ((1.0,), (-1.0,)), True, lambda x: bool(abs(x[0] - 1.0) < LEAST),
    )  # fmt: skip


def _inertias(scene: Scene) -> Iterator[Hypothesis]:
    """Yield inertias about the marks of other parts on the body, and products of inertia with the other sign."""
    for k, body in enumerate(scene.bodies):
        if isinstance(body, SpatialBody) and any(body.inertia[3:]):
            turned = (*body.inertia[:3], *(-value for value in body.inertia[3:]))
            negated = _with(scene, "bodies", {k: {"inertia": turned}})
            yield _of(negated, f"the products of inertia of {body.name} have the other sign")
        for name, point in _marks(scene, body.name):
            if (moved := _moved(body, np.array(point))) is not None:
                said = f"the inertia of {body.name} is about the point of {name!r} instead of the centre of mass"
                yield _of(_with(scene, "bodies", {k: {"inertia": moved}}), said)


def _marks(scene: Scene, body: str) -> Iterator[tuple[str, tuple[float, ...]]]:
    for part in chain(scene.joints, scene.loads):
        for end in ("body", "body_a", "body_b"):
            if getattr(part, end, None) == body and (point := part.mark(end)) is not None:
                yield part.name, point


def _moved(body: Any, point: np.ndarray) -> Any:
    """Return the inertia about a point, by the parallel-axis theorem; None where the body has none."""
    arm = point - np.array(body.position)
    if isinstance(body, PlanarBody):
        return body.inertia + body.mass * float(arm @ arm)
    if not isinstance(body, SpatialBody):
        return None
    arm = rotation_matrices(np.array(body.orientation)).T @ arm
    matrix = body.inertia_matrix + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return (*np.diag(matrix).tolist(), matrix[0, 1], matrix[0, 2], matrix[1, 2])


def _factors(scene: Scene) -> Iterator[Hypothesis]:
    """Yield a factor on each number of the scene's parts, and on that of all parts of a kind."""
    numbers: dict[tuple[str, str, tuple[str, ...]], list[int]] = {}
    for kind in PARTS:
        for k, part in enumerate(getattr(scene, kind)):
            for path in _numbers(part):
                numbers.setdefault((kind, part.type, path), []).append(k)
    single = sum(map(len, numbers.values()))
    for (kind, type_, path), places in numbers.items():
        words = f"the {' '.join(path).replace('_', ' ')} of"
        if len(places) > 1:
            yield _scaled(scene, kind, path, places, f"{words} every {type_.replace('_', ' ')} is")
        for k in places if single <= MOST or len(places) == 1 else ():
            yield _scaled(scene, kind, path, [k], f"{words} {getattr(scene, kind)[k].name!r} is")


def _scaled(scene: Scene, kind: str, path: tuple[str, ...], places: list[int], said: str) -> Hypothesis:
    def changed(x: float) -> Scene:
        return _with(scene, kind, {k: {path[0]: _times(getattr(scene, kind)[k], path, x)} for k in places})

    return _factor(changed, said)


def _with(scene: Scene, kind: str, changes: dict[int, dict[str, Any]]) -> Scene:
    parts = [part.model_copy(update=changes.get(k)) for k, part in enumerate(getattr(scene, kind))]
    return scene.model_copy(update={kind: tuple(parts)})


def _times(part: Part, path: tuple[str, ...], x: float) -> Any:
    """Return the value of a field, x times as large in the place that the path names."""
    value = getattr(part, path[0])
    if len(path) > 1:
        return value.model_copy(update={path[1]: _times(value, path[1:], x)})
    return tuple(x * one for one in value) if isinstance(value, tuple) else x * value


def _numbers(part: Part) -> Iterator[tuple[str, ...]]:
    """Yield the path to every number of a part that is neither a place nor a direction."""
    for name in type(part).model_fields:
        value = getattr(part, name)
        if isinstance(value, Part):
            yield from ((name, *rest) for rest in _numbers(value))
        elif not is_place(type(part), name):
            numbers = value if isinstance(value, tuple) else (value,)
            if any(numbers) and all(isinstance(number, float) for number in numbers):
                yield (name,)
