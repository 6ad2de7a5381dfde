"""How far an engine's motion of a scene's image is from the image of its motion."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.conformance.cases import Case
from cross_checks.conformance.symmetry import placement as place
from cross_checks.conformance.symmetry.placement import Placement, image, moved
from cross_checks.engine import Engine
from cross_checks.isolation.parent import Isolated, Lost
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.observables.distance import Motion, Partial, point_distances

NUDGE = 2.0**-46  # of the scene's size: some roundings of a step's arithmetic
SAMPLES = 5
RTOL = 1e-8  # of an adaptive method for which none is given
PLAIN = 30.0  # times the change that a nudge, or a finer setting, causes: a larger one has another cause
BACK = "there and back"
PATIENCE = 300.0  # s of one case: some twelve runs


class NotRunError(RuntimeError):
    """The engine did not finish a run; its words."""


@dataclass(frozen=True)
class Violation:
    """What one symmetry leaves of one run."""

    symmetry: str
    size: float | None  # m, largest distance of world points from where they belong; None where it does not apply
    noise: float  # m, what roundoff and the method's tolerance do by themselves
    error: float  # m, what half the step, or a tenth of the tolerance, changes: of the way back, what it grows to there
    reason: str = ""  # why there is no size

    @property
    def is_broken(self) -> bool:
        """Whether the symmetry is broken beyond roundoff; running back undoes nothing of the method's error."""
        allowed = max(self.noise, self.error) if self.symmetry == BACK else self.noise
        return self.size is not None and self.size > PLAIN * allowed

    @property
    def exceeds_error(self) -> bool:
        """Whether it is broken by more than the method errs anyway: no smaller step will mend it."""
        return self.is_broken and self.size is not None and self.size > PLAIN * self.error


def violations(engine: Engine, scene: Scene, settings: Settings) -> list[Violation]:
    """Return what every symmetry leaves, in the order of SYMMETRIES. Raises NotRunError where the plain run fails."""
    times = np.linspace(0.0, settings.t_end or scene.duration, SAMPLES)
    plain = _run(engine, scene, settings, times)
    noise = _noise(engine, scene, settings, times, plain)
    finer = {"step": 0.5 * settings.step} if settings.step else {"rtol": 0.1 * (settings.rtol or RTOL)}
    error, rate_error = _gap(scene, _run(engine, scene, settings.model_copy(update=finer), times), plain)
    # a way back starts from velocities, which may be worse than positions
    carried = error + plain.times[-1] * rate_error

    def violation(name: str) -> Violation:
        own = carried if name == BACK else error
        try:
            size = SYMMETRIES[name](engine, scene, settings, plain)
        except NotRunError as stop:
            size = str(stop)
        return Violation(name, None, noise, own, size) if isinstance(size, str) else Violation(name, size, noise, own)

    return [violation(name) for name in SYMMETRIES]


def _run(engine: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory:
    t_end = float(times[-1])
    run = engine.run(scene, settings.model_copy(update={"t_end": t_end}), times)
    if not run.ok or len(run.times) < len(times):
        raise NotRunError(f"{engine.name} does not finish: {run.message}")
    return run


def _noise(engine: Engine, scene: Scene, settings: Settings, times: np.ndarray, plain: Trajectory) -> float:
    """Return how far the motion goes from a nudged start, and from a run of another tolerance."""
    size = max(1.0, float(np.abs(plain.position).max()))
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(scene.bodies), len(scene.gravity)))
    amount = NUDGE * size
    bodies = tuple(
        body.model_copy(update={"position": tuple((np.array(body.position) + amount * sign).tolist())})
        for body, sign in zip(scene.bodies, signs, strict=True)
    )
    others = [(scene.model_copy(update={"bodies": bodies, "name": "nudged", "parameters": {}}), settings)]
    if settings.rtol is not None:
        others.append((scene, settings.model_copy(update={"rtol": 0.5 * settings.rtol})))
    gaps = [_gap(scene, _run(engine, *other, times), plain)[0] for other in others]
    return float(max(amount, *gaps))


def _gap(scene: Scene, seen: Motion, wanted: Motion) -> np.ndarray:
    """Return the largest distances (m, m/s) of centres and of points a radius of gyration away."""
    return point_distances(scene, seen, wanted).max(axis=(0, 1))


def _seen(make: Callable[[Scene], Placement], *, needs_step: bool = False) -> Callable:
    """Return what measures a placement: the image's motion against the motion's image, in the scene's metres."""

    def measure(engine: Engine, scene: Scene, settings: Settings, plain: Trajectory) -> float | str:
        placed = make(scene)
        reason = place.obstacle(scene, placed)
        if not reason and needs_step and settings.step is None:
            reason = "an absolute tolerance has no image where speeds scale unlike lengths"
        if reason:
            return reason
        changed = {"t_end": placed.time * float(plain.times[-1])}
        if settings.step is not None:
            changed["step"] = settings.step * placed.time
        elif settings.atol is not None:
            changed["atol"] = settings.atol * placed.length
        seen = image(scene, placed)
        run = _run(engine, seen, settings.model_copy(update=changed), plain.times * placed.time)
        return float(_gap(seen, run, Partial(*moved(plain, placed)))[0]) / placed.length

    return measure


def _placed(scene: Scene, flip: bool | None = None, **changes: Any) -> Placement:
    """Return space as it is, or turned to leave no axis in place (flip False), or mirrored as well (True)."""
    d = len(scene.gravity)
    matrix = np.eye(d)
    if flip is not None:
        c, s = np.cos(0.7), np.sin(0.7)
        turn = np.array([[c, -s], [s, c]]) if d == 2 else np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3.0
        matrix = turn @ np.diag([1.0] * (d - 1) + [-1.0 if flip else 1.0])
    return replace(Placement(matrix, np.zeros(d)), **changes)


def _shifted(scene: Scene) -> Placement:
    size = max(1.0, max(abs(x) for body in scene.bodies for x in body.position))
    return _placed(scene, shift=size * np.array([0.5, -0.25, 0.125])[: len(scene.gravity)])


def _reordered(scene: Scene) -> Placement:
    """The first body's gravity may be singled out: it stays first where it is."""
    keep = int(any(getattr(load, "form", "") == "central" for load in scene.loads))
    return _placed(scene, order=(*range(keep), *reversed(range(keep, len(scene.bodies)))))


def _cut(engine: Engine, scene: Scene, settings: Settings, plain: Trajectory) -> float | str:
    """Stop half way and start anew from there."""
    if reason := place.cut_obstacle(scene, back=False):
        return reason
    half = len(plain.times) // 2
    first = _run(engine, scene, settings, plain.times[: half + 1])
    rest = place.continued(scene, first, back=False)
    second = _run(engine, rest, settings, plain.times[half:] - plain.times[half])
    return float(_gap(scene, second, Partial(plain.position[half:], plain.orientation[half:]))[0])


def _there_and_back(engine: Engine, scene: Scene, settings: Settings, plain: Trajectory) -> float | str:
    """Turn all velocities round at the end: twice the method's error is left, where nothing is lost."""
    if reason := place.cut_obstacle(scene, back=True):
        return reason
    back = _run(engine, place.continued(scene, plain, back=True), settings, plain.times)
    return float(_gap(scene, back, Partial(plain.position[::-1], plain.orientation[::-1]))[0])


SYMMETRIES: dict[str, Callable[[Engine, Scene, Settings, Trajectory], float | str]] = {
    "turned": _seen(partial(_placed, flip=False)),
    "mirrored": _seen(partial(_placed, flip=True)),
    "shifted": _seen(_shifted),
    # powers of two leave no rounding
    "other units": _seen(partial(_placed, mass=2.0**7, length=2.0**5, time=2.0**3), needs_step=True),
    "other mass and length": _seen(partial(_placed, mass=2.0**7, length=2.0**5)),
    "reordered": _seen(_reordered),
    "renamed": _seen(
        lambda scene: _placed(scene, names={name: f"z{k}" for k, name in enumerate(reversed(scene.body_names))})
    ),
    "cut in two": _cut,
    BACK: _there_and_back,
}


def facts(case: Case) -> dict[str, Any]:
    """Return how many symmetries could be judged, those broken beyond roundoff, and why there is none."""
    try:
        found = violations(engines.get(case.engine), case.built(), case.settings)
    except NotRunError as error:
        return _told(case, stopped=str(error))
    broken = [asdict(one) | {"exceeds_error": one.exceeds_error} for one in found if one.is_broken]
    return _told(case, judged=sum(one.size is not None for one in found), broken=broken)


def isolated(case: Case, call: Isolated) -> dict[str, Any]:
    """Return the facts of a case that is run in a child process, which may not come back."""
    call.timeout = PATIENCE
    try:
        return call(facts, case)
    except Lost as error:
        return _told(case, stopped=f"{error.status}: {error}")


def _told(case: Case, *, judged: int = 0, broken: list[dict[str, Any]] | None = None, stopped: str = "") -> dict:
    return {"engine": case.engine, "method": case.method, "scene": case.scene, "parameters": case.parameters,
            "setting": case.setting, "judged": judged, "broken": broken or [], "stopped": stopped}  # fmt: skip


def by_method(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each engine and method: cases run, symmetries judged, and what is broken beyond what."""
    rows = []
    for engine, method in dict.fromkeys((one["engine"], one["method"]) for one in found):
        mine = [one for one in found if (one["engine"], one["method"]) == (engine, method)]
        broken = [each for one in mine for each in one["broken"]]
        rows.append({
            "engine": engine, "method": method, "cases": len(mine),
            "stopped": sum(bool(one["stopped"]) for one in mine),
            "judged": sum(one["judged"] for one in mine), "broken": len(broken),
            "beyond_error": sum(each["exceeds_error"] for each in broken),
        })  # fmt: skip
    return rows
