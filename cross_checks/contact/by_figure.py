"""Experiments that measure a contact, and scenes with contact compared by figures: where laws differ, motions do."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from cross_checks import engines
from cross_checks.contact.request import DURATION, GRAVITY, SHARE, SINK, ContactModel, Request, Translation
from cross_checks.engine import Engine
from cross_checks.judge.one_run import checked_run
from cross_checks.judge.vocabulary import OURS
from cross_checks.metrics.contact_figures import MANY, contact_figures
from mbs_ref import Settings, Trajectory, scenes
from mbs_ref.files import package_data
from mbs_ref.scene import GROUND, Force, PlanarBody, Prismatic, Scene
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, StickSlip

RADIUS = 0.1  # m
UNTURNED = 1e9  # kg m^2: a body of this inertia slides without turning
FLIGHT = 12.37  # steps of free flight before an impact, no whole number
HELD, RESTS = 1.0, 1.0  # s on the slope, and after sliding
TABLE: dict[str, dict[str, list]] = package_data(__name__, "figures.toml")  # by scene and figure


class Measured(NamedTuple):
    """One requested figure, as an engine obtains it."""

    figure: str
    requested: float
    obtained: float | None
    note: str  # what the engine's documentation excludes, or why its run has no figure


def measured(model: ContactModel, request: Request, translation: Translation) -> list[Measured]:
    """Return every requested figure as the engine obtains it at the requested step."""
    experiments = [impact_scene(request, translation)]
    if translation.friction is not None:
        angle, slides = math.atan(SHARE * request.friction), request.speed / (request.friction * GRAVITY)
        experiments.append(floor_scene(request, translation, 0.0, request.speed, slides + RESTS))
        experiments.append(floor_scene(request, translation, angle, 0.0, HELD))
    figures: dict[str, float] = {}
    failures: list[str] = []
    for scene in experiments:
        path = run(model, model.compared[0], scene, request.step)
        if isinstance(path, str):
            failures.append(path)
            continue
        shown = {name.removeprefix("pair: "): value for name, value in contact_figures(scene, path).items()}
        figures = shown | figures
    return [_row(label, request, figures, translation, failures) for label in request.figures]


def _row(label: str, request: Request, figures: dict, translation: Translation, failures: list[str]) -> Measured:
    refused = translation.refused.get(label)
    notes = [f"cannot, {refused.instead:.3g} instead: {refused.why}"] if refused else []
    notes += failures if label not in figures else []
    return Measured(label, request.figures[label], figures.get(label), "; ".join(notes))


def run(
    model: ContactModel, method: str, scene: Scene, step: float, times: np.ndarray | None = None
) -> Trajectory | str:
    """Return the motion by steps (s) at times (s), every step unless given, or the sentence why there is none."""
    settings = Settings(method=method, step=step, reactions=False, initial_tolerance=1.0)
    every = step * np.arange(round(scene.duration / step) + 1)
    return motion(model.engine, scene, settings, every if times is None else times)


def motion(engine: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> Trajectory | str:
    """Return the motion at times (s), or the sentence why there is none."""
    path = checked_run(engine, scene, settings, times)
    if not isinstance(path, Trajectory):
        return path[1]
    return path if path.ok else path.message


def impact_scene(request: Request, translation: Translation) -> Scene:
    """Return a sphere that hits another one, fixed to the ground, without gravity."""
    centre = (0.0, 2.0 * RADIUS + FLIGHT * request.step * request.speed)
    ball = PlanarBody(name="ball", mass=request.mass, inertia=UNTURNED, position=centre, velocity=(0.0, -request.speed))
    pair = CircleOnCircle(
        name="pair", body_a="ball", center_a=centre, radius_a=RADIUS, body_b=GROUND, center_b=(0.0, 0.0),
        radius_b=RADIUS, law=translation.law,
    )  # fmt: skip
    steps = 3.0 * FLIGHT + 2.0 * request.figures[DURATION] / request.step
    return Scene(name="impact", duration=math.ceil(steps) * request.step, bodies=(ball,), contacts=(pair,))


def floor_scene(request: Request, translation: Translation, angle: float, speed: float, duration: float) -> Scene:
    """Return a body that cannot turn, sunk as the engine lets it, on a slope (rad) along its axes, at a speed (m/s)."""
    gravity = (GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle))
    refused = translation.refused.get(SINK)
    sink = refused.instead if refused else request.figures[SINK]
    centre = (0.0, RADIUS - math.cos(angle) * sink)
    body = PlanarBody(name="slider", mass=request.mass, inertia=UNTURNED, position=centre, velocity=(speed, 0.0))
    pair = CircleOnLine(
        name="pair", body_a="slider", center=centre, radius=RADIUS, point_1=(0.0, 0.0), point_2=(1.0, 0.0),
        law=translation.floor or translation.law, friction=translation.friction,
    )  # fmt: skip
    steps = math.ceil(duration / request.step)
    return Scene(name="slider", duration=steps * request.step, gravity=gravity, bodies=(body,), contacts=(pair,))


RTOL, LOOSER = 1e-10, 1e-8  # of the reference, and of the run whose difference from it is the uncertainty


@dataclass(frozen=True)
class Obtained:
    """One figure of one scene by one method of an engine, or the reason why there is none."""

    scene: str
    engine: str
    method: str
    step: float  # s
    figure: str = ""
    requested: float | None = None  # of the scene's own law, by the reference solver
    uncertainty: float | None = None  # of the requested
    obtained: float | None = None
    change: float | None = None  # of the obtained figure at half the step
    reason: str = ""


def figures_of(scene: Scene, path: Trajectory) -> dict[str, float]:
    """Return the largest of every figure over the scene's contacts, and the figures declared for the scene."""
    figures: dict[str, float] = {}
    for name, value in contact_figures(scene, path).items():
        label = name.rpartition(": ")[2]
        figures[label] = max(value, figures.get(label, value))
    return figures | {label: _declared(scene, path, *row) for label, row in TABLE.get(scene.name, {}).items()}


def _declared(scene: Scene, path: Trajectory, what: str, body: str, quantity: str, component: int | None = None):
    values = getattr(path, quantity)
    values = values[..., None] if values.ndim == 2 else values  # (n_t, n_bodies, components)
    values = values if body == "*" else values[:, [scene.body_index(body)]]
    if what == "slope":  # of a triangle in a corner at the origin, with the same centre: what lies lower fell off
        along, up = np.mean(values[-1][values[-1][:, 1] > 0.0], axis=0)
        return float(np.arctan2(up, along))
    if component is None and values.shape[2] > 1:
        values, component = np.linalg.norm(values, axis=-1, keepdims=True), 0
    scalar = values[..., component or 0]
    if what == "crossing":
        sign = scalar[:, 0] * np.sign(scalar[0, 0])
        k = int(np.argmax(sign <= 0.0))
        return float(np.interp(0.0, -sign[k - 1 : k + 1], path.times[k - 1 : k + 1])) if k else float("nan")
    return float(np.max(scalar[-1] if what == "last" else np.abs(scalar)))


def compare(models: dict[str, ContactModel], cases: dict[str, Scene], step: float, *, every: bool = False):
    """Yield every figure of the scenes by every contact model, by all methods or those compared; a refusal is one."""
    for name, scene in cases.items():
        reference = None
        for engine, model in models.items():
            for method in [method.name for method in model.engine.methods()] if every else model.compared:
                key: dict[str, Any] = {"scene": name, "engine": engine, "method": method, "step": step}
                times = _times(scene, step)
                path = run(model, method, scene, step, times)
                if isinstance(path, str):
                    yield Obtained(**key, reason=path)
                    continue
                reference = reference or _reference(scene, step)
                yield from _rows(
                    key, reference, scene, path, run(model, method, scene, 0.5 * step, _times(scene, 0.5 * step))
                )


type Reference = dict[str, tuple[float, float | None]]  # by figure: value and uncertainty


def _times(scene: Scene, step: float) -> np.ndarray:
    """Return output times (s): every step, or start and end alone where each figure is one of the end."""
    ends = all(row[0] in ("last", "slope") for row in TABLE.get(scene.name, {}).values())
    counts = np.arange(round(scene.duration / step) + 1)
    return step * (counts[[0, -1]] if ends and len(scene.contacts) > MANY else counts)


def _rows(
    key: dict[str, Any], reference: Reference, scene: Scene, path: Trajectory, fine: Trajectory | str
) -> Iterator[Obtained]:
    here = figures_of(scene, path)
    finer = {} if isinstance(fine, str) else figures_of(scene, fine)
    for label, (value, apart) in reference.items():
        change = finer[label] - here[label] if label in here and label in finer else None
        reason = "" if label in here else "the run does not show it"
        yield Obtained(**key, figure=label, requested=value, uncertainty=apart, obtained=here.get(label),
                       change=change, reason=reason)  # fmt: skip


def _scattered(start: Callable[[int], Scene], step: float) -> Reference:
    """Return the means over STARTS starts, and 95 % of the spread of one more: impacts magnify every difference."""
    settings = Settings(method="rk4", step=0.5 * step, events="none", reactions=False, estimate="off")
    cases = [start(seed) for seed in range(STARTS)]
    found = [figures_of(case, engines.get(OURS).run(case, settings)) for case in cases]
    spread = float(scipy.stats.t.ppf(0.975, STARTS - 1)) * math.sqrt(1.0 + 1.0 / STARTS)
    table = {label: [one[label] for one in found] for label in TABLE[cases[0].name]}
    return {label: (float(np.mean(row)), spread * float(np.std(row, ddof=1))) for label, row in table.items()}


def _reference(scene: Scene, step: float) -> Reference:
    """Return figures by the reference solver, and their change at a looser tolerance, by steps that no output ends.

    None is the change of a figure that the looser run does not show.
    """
    if scene.name in AT_RANDOM:
        return _scattered(AT_RANDOM[scene.name], step)
    solver, times = engines.get(OURS), _times(scene, step)
    common: dict[str, Any] = {"method": "dop853", "reactions": False, "estimate": "off"}
    runs = Settings(rtol=RTOL, atol=RTOL, **common), Settings(rtol=LOOSER, atol=LOOSER, outputs="dense", **common)
    best, other = (figures_of(scene, solver.run(scene, one, times)) for one in runs)
    return {
        label: (value, max(abs(value - other[label]), np.spacing(abs(value))) if label in other else None)
        for label, value in best.items()
    }


def with_contact() -> dict[str, Scene]:
    """Return the library's scenes in which bodies touch, and those of AT_RANDOM."""
    every = {name: case(name) for name in (*scenes.names(), *AT_RANDOM)}
    return {name: scene for name, scene in every.items() if scene.contacts}


def case(name: str) -> Scene:
    """Return a scene of the library or of AT_RANDOM, at its first seed. ValueError for an unknown name."""
    return AT_RANDOM[name](0) if name in AT_RANDOM else scenes.make(name)


STARTS = 8


def heap(seed: int) -> Scene:
    """Return discs that fall on a ledge of fixed ones beside a wall, from a start that a seed shifts.

    Those of one size are a crystal, whose slope hardly depends on friction.
    """
    column = scenes.make(
        "granular_column", grains=60, across=6, ledge=9, friction=0.5, slip=1e-3, seed=seed, spread=0.4
    )
    return column.model_copy(update={"name": "granular_heap"})


AT_RANDOM = {"granular_heap": heap}  # scenes by their seed, whose figures depend on the start


FRICTION, SHARES, LOADS = 0.7, (0.1, math.tan(0.2) / 0.7, 0.5, 0.9), (1.0, 100.0)  # -, of the cone, of the block's mass
STIFFNESS, DAMPING = 1e5, 200.0  # N/m, N s/m of each corner


def holding() -> dict[str, Scene]:
    """Return blocks that Coulomb's law holds: on a slope, beneath a load, pressed to a wall and gripped by jaws."""
    cases = {f"slope at {share:.0%} of the cone": slope(share, 0.0) for share in SHARES}
    cases |= {f"slope beneath {load:g} of its mass": slope(SHARES[1], load) for load in LOADS}
    return cases | {"pressed to a wall": pressed(SHARES[1]), "gripped by two jaws": pressed(SHARES[1], 2)}


def slope(share: float, load: float) -> Scene:
    """Return a block on a slope of tan(angle) = share of mu, and on it a block `load` times as heavy, if any."""
    angle, harder = math.atan(share * FRICTION), max(load, 1.0)
    laws = {"stiffness": STIFFNESS * harder, "damping": DAMPING * harder}
    stack = scenes.make("block_stack", blocks=2 if load else 1, ratio=load or 1.0, **laws)
    grip = StickSlip(coefficient=FRICTION, stiffness=STIFFNESS * harder, damping=DAMPING * harder)
    contacts = tuple(contact.model_copy(update={"friction": grip}) for contact in stack.contacts)
    gravity = (GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle))
    return stack.model_copy(update={"gravity": gravity, "contacts": contacts})


def pressed(share: float, jaws: int = 1, ratio: float = 1.0) -> Scene:
    """Return a block that a force presses to a wall along which its weight pulls, itself or by a jaw that slides.

    The jaw is `ratio` times as heavy as the block.
    """
    scene = slope(share, ratio if jaws > 1 else 0.0)
    block, last = scene.bodies[0], scene.bodies[-1]
    force = block.mass * GRAVITY / (jaws * share * FRICTION)
    load = Force(name="press", body=last.name, point=last.position, vector=(0.0, 0.0, -force))
    guide = Prismatic(name="guide", body_a=last.name, body_b=GROUND, point=last.position, axis=(0.0, 0.0, 1.0))
    joints = (guide,) if jaws > 1 else ()
    return scene.model_copy(update={"gravity": (GRAVITY, 0.0, 0.0), "loads": (load,), "joints": joints})
