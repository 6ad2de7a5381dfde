"""The scene and the start of every run: other numbers, parameters or initial conditions."""

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
from mbs_ref.simulate.many.ensemble.numbers import TURN, Place, place_of, value_at, with_values
from mbs_ref.simulate.start.consistent import InconsistentScene, fitted_rates

# at t = 0: a body is moved together with the marks of joints, springs and contacts on it
POSE = ("position", "angle", TURN)
RATES = ("velocity", "angular_velocity")
FIELDS = {"angle": "orientation"}  # of a body, as Poses has them


class Target(NamedTuple):
    """A varied number: a parameter of the scene, or a place in it."""

    name: str
    own: float | None
    place: Place | None

    @property
    def start(self) -> str:
        """The field of a body's start to which it belongs, or nothing."""
        if self.place is None or self.place[0] != "bodies":
            return ""
        field = str(self.place[2])
        return field if field in (*POSE, *RATES) else ""


@dataclass(frozen=True)
class Source:
    """The scene that is varied, and its builder for other parameters if it has one."""

    scene: Scene
    rebuild: Callable[..., Scene] | None = None

    def target(self, name: str) -> Target:
        """Return the number of a name; ValueError names what is unknown, and what exists."""
        parameters = self.scene.parameters if self.rebuild else {}
        if name in parameters:
            own = parameters[name]
            if isinstance(own, bool | str):
                raise ValueError(f"the parameter {name} = {own!r} is not a number, and cannot be varied")
            return Target(name, float(own), None)
        try:
            place = place_of(self.scene, name)
        except ValueError as error:
            listed = f"; parameters of {self.scene.name}: {', '.join(parameters)}" if parameters else ""
            hint = problems.suggest(name, parameters) if "." not in name else ""
            raise ValueError(f"{error}{listed}{hint}") from None
        return Target(name, value_at(self.scene, place), place)


@dataclass(frozen=True)
class Variants:
    """The scene and the start of every run."""

    source: Source
    targets: Sequence[Target]
    fixed: tuple[str, ...] = ()  # velocities that do not change when the others are fitted to the joints
    tolerance: float = 1e-9  # m, rad, m/s, rad/s: largest violation of a joint then

    def __post_init__(self) -> None:
        moved = [target.name for target in self.targets if target.start in POSE]
        if self.fixed and moved:
            raise ValueError(
                f"keep = {', '.join(self.fixed)} fits velocities, but {', '.join(moved)} varies a pose; "
                "project the start instead (project_initial)"
            )
        if self.fixed:
            with suppress(InconsistentScene):  # of the unchanged scene; unknown names raise ValueError
                fitted_rates(self.source.scene, self.fixed, self.tolerance)

    @property
    def is_one_scene(self) -> bool:
        """Whether runs differ in their start alone."""
        return not self.fixed and all(target.start for target in self.targets)

    @property
    def moves(self) -> bool:
        """Whether runs differ in poses at t = 0."""
        return any(target.start in POSE for target in self.targets)

    def scene(self, values: np.ndarray) -> Scene:
        """Return a run's scene with its velocities, without the start's poses; ValueError if the scene is invalid."""
        pairs = list(zip(self.targets, values.tolist(), strict=True))
        given = {target.name: value for target, value in pairs if target.place is None}
        parameters: dict[str, Any] = {
            name: int(x) if x.is_integer() else x for name, x in given.items()
        }  # they may count
        scene = self.source.rebuild(**parameters) if parameters and self.source.rebuild else self.source.scene
        if scene.body_names != self.source.scene.body_names:
            raise ValueError(f"{', '.join(parameters)} changes the number or names of bodies; vary another parameter")
        places = {t.place: value for t, value in pairs if t.place is not None and t.start not in POSE}
        try:
            scene = with_values(scene, places) if places else scene
        except ValidationError as error:
            raise ValueError(problems.sentences(error, Scene, {})) from None
        return fitted_rates(scene, self.fixed, self.tolerance) if self.fixed else scene

    def start(self, scene: Scene, values: np.ndarray) -> Poses:
        """Return the poses and velocities (one sample of each) at the start of a run."""
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
    """Write the values (n, n_targets) of the targets with such a field into starts (n of each)."""
    turns: dict[int, np.ndarray] = {}  # rotation vectors (n, 3) of bodies in space, rad
    for target, column in zip(targets, values.T, strict=True):
        if target.start in fields and target.place is not None:
            _, body, field, *component = target.place
            if field == TURN:
                turns.setdefault(int(body), np.zeros((len(values), 3)))[:, int(component[0])] = column
            else:
                getattr(starts, FIELDS.get(str(field), str(field)))[(slice(None), body, *component)] = column
    for body, vectors in turns.items():
        from scipy.spatial.transform import Rotation  # takes long to import

        turned = Rotation.from_rotvec(vectors).as_quat(scalar_first=True)
        starts.orientation[:, body] = product(turned, starts.orientation[:, body])
