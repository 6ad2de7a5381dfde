"""A scene with other numbers, parameters or another start, for every run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.scene import messages as problems
from mbs_ref.scene.euler_parameters import product
from mbs_ref.self_checks.consistent_start import InconsistentScene
from mbs_ref.self_checks.kept_rates import keeping
from mbs_ref.simulate.ensemble.numbers import TURN, Place, place_of, value_at, with_values

# at t = 0: a body is moved, and joints, springs and contacts stay where they are on it
POSE = ("position", "angle", TURN)
RATES = ("velocity", "angular_velocity")
FIELDS = {"angle": "orientation"}  # of a body, as Poses has them


class Target(NamedTuple):
    """What a name stands for: a parameter of the scene, or else a place in it."""

    name: str
    own: float | None
    place: Place | None

    @property
    def start(self) -> str:
        """The field of a body's start that it belongs to, or nothing."""
        if self.place is None or self.place[0] != "bodies":
            return ""
        field = str(self.place[2])
        return field if field in (*POSE, *RATES) else ""


@dataclass(frozen=True)
class Source:
    """The scene that is varied, and how it is made anew with other parameters, where it can be."""

    scene: Scene
    rebuild: Callable[..., Scene] | None = None

    def target(self, name: str) -> Target:
        """Return what a name stands for; ValueError says what is unknown, and what there is."""
        parameters = self.scene.parameters if self.rebuild else {}
        if name in parameters:
            own = parameters[name]
            if isinstance(own, bool | str):
                raise ValueError(f"the parameter {name} = {own!r} is no number, and cannot be varied")
            return Target(name, float(own), None)
        try:
            place = place_of(self.scene, name)
        except ValueError as error:
            told = f"; parameters of {self.scene.name}: {', '.join(parameters)}" if parameters else ""
            hint = problems.suggest(name, parameters) if "." not in name else ""
            raise ValueError(f"{error}{told}{hint}") from None
        return Target(name, value_at(self.scene, place), place)


@dataclass(frozen=True)
class Variants:
    """Which scene and which start every run has."""

    source: Source
    targets: Sequence[Target]
    kept: tuple[str, ...] = ()  # velocities that stay where the others are made to fit the joints
    tolerance: float = 1e-9  # of these

    def __post_init__(self) -> None:
        moved = [target.name for target in self.targets if target.start in POSE]
        if self.kept and moved:
            raise ValueError(
                f"keep = {', '.join(self.kept)} makes velocities fit, but {', '.join(moved)} varies a pose; "
                "let the start be projected (project_initial)"
            )
        if self.kept:
            with suppress(InconsistentScene):  # of the scene as it stands; names that are unknown are told here
                keeping(self.source.scene, self.kept, self.tolerance)

    @property
    def is_one_scene(self) -> bool:
        """Whether runs differ in their start alone, as it is asked for."""
        return not self.kept and all(target.start for target in self.targets)

    @property
    def moves(self) -> bool:
        """Whether runs differ in poses at t = 0."""
        return any(target.start in POSE for target in self.targets)

    def scene(self, values: np.ndarray) -> Scene:
        """Return a run's scene, its velocities too; poses are the start's. ValueError where there is no such scene."""
        pairs = list(zip(self.targets, values.tolist(), strict=True))
        parameters = {target.name: _as_number(value) for target, value in pairs if target.place is None}
        made = self.source.rebuild(**parameters) if parameters and self.source.rebuild else self.source.scene
        if made.body_names != self.source.scene.body_names:
            raise ValueError(f"{', '.join(parameters)} changes which bodies there are; vary what leaves them")
        places = {t.place: value for t, value in pairs if t.place is not None and t.start not in POSE}
        try:
            made = with_values(made, places) if places else made
        except ValidationError as error:
            raise ValueError(problems.sentences(error, Scene, {})) from None
        return keeping(made, self.kept, self.tolerance) if self.kept else made

    def start(self, scene: Scene, values: np.ndarray) -> Poses:
        """Return the poses and velocities (one sample of each) from which a run of its scene starts."""
        start = own_start(scene)
        _set(start, self.targets, values[None], POSE)
        return start

    def starts(self, values: np.ndarray) -> Poses:
        """Return the start of every run (n of each) of the one scene."""
        starts = Poses(*(np.repeat(part, len(values), axis=0) for part in own_start(self.source.scene)))
        _set(starts, self.targets, values, (*POSE, *RATES))
        return starts


def own_start(scene: Scene) -> Poses:
    """Return the poses and velocities of a scene at t = 0, one sample of each."""
    system = compile_scene(scene)
    return system.poses(system.initial_state()[None])


def _set(starts: Poses, targets: Sequence[Target], values: np.ndarray, fields: tuple[str, ...]) -> None:
    """Write the values (n, n_targets) of those targets that are such fields into starts (n of each)."""
    turns: dict[int, np.ndarray] = {}  # rotation vectors (n, 3) of bodies in space, rad
    for target, column in zip(targets, values.T, strict=True):
        if target.start in fields and target.place is not None:
            _, body, field, *component = target.place
            if field == TURN:
                turns.setdefault(int(body), np.zeros((len(values), 3)))[:, int(component[0])] = column
            else:
                getattr(starts, FIELDS.get(str(field), str(field)))[(slice(None), body, *component)] = column
    for body, vectors in turns.items():
        starts.orientation[:, body] = product(_turned_by(vectors), starts.orientation[:, body])


def _turned_by(vectors: np.ndarray) -> np.ndarray:
    """Return the Euler parameters (n, 4) of rotation vectors (n, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vectors).as_quat(scalar_first=True)


def _as_number(value: float) -> Any:
    """Return an integer as such, for parameters that count."""
    return int(value) if value.is_integer() else value
