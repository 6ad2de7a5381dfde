"""What an engine must answer: scenes short enough to be quick, each with a truth, and the settings of each run."""

from dataclasses import dataclass
from functools import cache
from itertools import islice

import numpy as np

from cross_checks.conformance.cases import STATED
from cross_checks.conformance.probes import probe_truth, probes
from cross_checks.engine import Engine
from cross_checks.engine.method import Method
from cross_checks.truths import Truth, known, truth_for
from mbs_ref import Settings, scenes
from mbs_ref.scene import GROUND, PointMass, Scene, UserForce
from mbs_ref.scene import Distance as Rod
from mbs_ref.scene.traits import is_smooth, part_types

SPANS: dict[str, float] = STATED["spans"]  # s
SAMPLES = 51
STEPS = (50, 100, 200, 400)  # over the span
RTOLS = (1e-4, 1e-6, 1e-8, 1e-10)


@dataclass(frozen=True)
class Question:
    """A scene, the times requested and its truth there."""

    scene: Scene
    times: np.ndarray  # (n_t,) s
    truth: Truth

    @property
    def is_smooth(self) -> bool:
        return is_smooth(self.scene)


@cache
def question_of(name: str) -> Question | None:
    """Return the question that a scene is; None where no truth is known at its times."""
    scene = scenes.make(name)
    times = np.linspace(0.0, SPANS.get(name, scene.duration), SAMPLES)
    truth = truth_for(scene, times)
    return None if truth is None else Question(scene, times, truth)


def questions(engine: Engine) -> list[Question]:
    """Return the scenes that some method takes, and small ones for the parts that it declares and those lack.

    It is one of the costlier scenes where it takes none of the quick ones.
    """
    quick = [name for name in SPANS if engine.able(scenes.make(name))]
    costlier = (name for name in known() if name in scenes.names() and name not in SPANS)
    others = (name for name in costlier if engine.able(scenes.make(name)))
    of_library = [question_of(name) for name in quick or [*islice(others, 1)]]
    there = [question for question in of_library if question is not None]
    met = {(kind, question.scene.dimension) for question in there for kind in part_types(question.scene)}
    lacking = [part for part in probes() if part[0] in engine.part_types and part not in met]
    return there + [probe(*part) for part in lacking if engine.able(probes()[part])]


@cache
def probe(kind: str, dimension: int) -> Question:
    """Return the question that the small scene for a type of part is."""
    scene = probes()[kind, dimension]
    times, name = np.linspace(0.0, scene.duration, SAMPLES), f"{kind}_in_{scene.world.name}"
    return Question(scene.model_copy(update={"name": name}), times, probe_truth(scene, times))


def uncovered(engine: Engine, questions: list[Question]) -> tuple[str, ...]:
    """Return the types of parts that an engine declares and no question covers."""
    return tuple(sorted(engine.part_types.difference(*(part_types(question.scene) for question in questions))))


def rungs(method: Method, times: np.ndarray, *, jumps: bool = False) -> list[Settings]:
    """Return the settings of the runs, coarse to fine.

    Where forces jump, an adaptive method that locates no events cannot meet a tight tolerance (Exudyn's DOPRI5 does
    not come back from 1e-8), and has the loose ones alone.
    """
    if method.kind == "fixed":
        steps = [float(times[-1]) / n for n in STEPS]
        return [Settings(method=method.name, step=h, estimate="off", refuse_unstable=False) for h in steps]
    rtols = RTOLS[:2] if jumps and not method.locates_events else RTOLS
    return [Settings(method=method.name, rtol=r, estimate="off") for r in rtols]


def impossible() -> Scene:
    """A scene in space under a Python force: few engines take either."""
    stone = PointMass(name="stone", mass=1.0, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    wind = UserForce(name="wind", function=lambda t, q, v: 0.0 * q)
    return Scene(name="impossible", gravity=(0.0, 0.0, -9.81), bodies=(stone,), loads=(wind,))


def open_pendulum() -> Scene:
    """A particle that starts along its rod: the velocity breaks the constraint."""
    bob = PointMass(name="bob", mass=1.0, position=(1.0, 0.0), velocity=(1.0, 0.0))
    rod = Rod(name="rod", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=(1.0, 0.0))
    return Scene(name="open", gravity=(0.0, -9.81), bodies=(bob,), joints=(rod,))
